//! Steering: a wish for a direction and a speed becomes a choice of skills.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::model::CharacterModel;
use crate::sim::Simulator;
use crate::skill::transition::{Transition, best_transition};
use crate::skill::{SkillPlayer, TrainedSkill, Way};
use glam::DVec3;
use std::sync::Arc;

/// Deviation from the wished direction at which a curving skill is chosen, rad.
const CURVE: f64 = 0.6;
/// How fast a skill that goes straight is turned, rad/s for each radian of deviation, and at most.
const STEER: (f64, f64) = (0.6, 0.35);

/// What is wished for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// Direction of travel over the ground, world frame; its length does not matter, zero is as it comes.
    pub direction: DVec3,
    /// Mean speed, m/s.
    pub speed: f64,
    /// Name of a skill to perform once, as soon as it can begin.
    pub perform: Option<String>,
}

/// What the player knows of a skill.
#[derive(Clone, Debug)]
struct Known {
    skill: Arc<TrainedSkill>,
    /// Which way the pelvis faces while travelling.
    way: Way,
    /// How fast it turns, rad/s, positive to the left.
    curve: f64,
}

/// Skates where it is told to: straight skills on straight ways, curving skills on curves, others by name. Clones share
/// what they know.
#[derive(Clone, Debug)]
pub struct SteeringPlayer {
    known: Arc<[Known]>,
    /// `passages[a][b]`: from skill a to skill b.
    passages: Arc<[Vec<Transition>]>,
    player: SkillPlayer,
    rate: f64,
    now: usize,
    next: Option<usize>,
    begun: Option<usize>,
}

impl SteeringPlayer {
    /// A player at the start of the first skill. `rate`: steps per second of the simulation. `None` without skills, or if
    /// the rate does not fit one of them.
    pub fn new(skills: Vec<Arc<TrainedSkill>>, model: &CharacterModel, rate: f64) -> Option<Self> {
        for skill in &skills {
            SkillPlayer::new(skill.clone(), rate)?;
        }
        let player = SkillPlayer::new(skills.first()?.clone(), rate)?;
        let mut known: Vec<Known> = skills.into_iter().map(Known::of).collect();
        // What repeats on a curve can be performed on the other hand too, unless that is among the skills itself; the
        // straight skills too, so that a passage between images is the image of one that was learnt.
        let curves = |k: &Known| k.repeats() && k.curve.abs() > 0.1;
        let one_handed = |k: &Known| {
            !known.iter().any(|other| curves(other) && other.way == k.way && other.curve.signum() != k.curve.signum())
        };
        if known.iter().any(|k| curves(k) && one_handed(k)) {
            let missing = |k: &&Known| k.repeats() && (!curves(k) || one_handed(k));
            let images: Vec<Known> = known.iter().filter(missing).map(|k| k.image(model)).collect();
            known.extend(images);
        }
        let passage = |a: &Known, b: &Known| best_transition(&a.skill.motion, &b.skill.motion, b.skill.entry_ticks());
        let passages = known.iter().map(|a| known.iter().map(|b| passage(a, b)).collect()).collect();
        Some(Self { known: known.into(), passages, player, rate, now: 0, next: None, begun: Some(0) })
    }

    /// The player of the present skill.
    pub fn player(&self) -> &SkillPlayer {
        &self.player
    }
    #[cfg(feature = "engine")]
    pub(crate) fn player_mut(&mut self) -> &mut SkillPlayer {
        &mut self.player
    }
    /// Name of the skill that has begun since this was last asked.
    pub fn take_begun(&mut self) -> Option<&str> {
        let k = self.begun.take()?;
        Some(self.known[k].skill.name())
    }
    /// The skills it may use.
    pub fn skills(&self) -> impl Iterator<Item = &Arc<TrainedSkill>> {
        self.known.iter().map(|k| &k.skill)
    }
    /// Goes on at another rate, see [`SkillPlayer::set_rate`].
    pub fn set_rate(&mut self, rate: f64) -> bool {
        let fits = self.known.iter().all(|k| SkillPlayer::new(k.skill.clone(), rate).is_some());
        let changed = fits && self.player.set_rate(rate);
        if changed {
            self.rate = rate;
        }
        changed
    }

    /// What it remembers; the skills are not part of it.
    pub fn write_state(&self, out: &mut StateWriter) {
        out.count(self.now);
        out.option(self.next, StateWriter::count);
        out.option(self.begun, StateWriter::count);
        out.number(self.rate);
        self.player.write_state(out);
    }
    /// Goes to where a player of the same skills was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let count = self.known.len();
        let now = from.below("skill that is performed", count)?;
        self.next = from.option("next skill", |from| from.below("next skill", count))?;
        self.begun = from.option("skill that has begun", |from| from.below("skill that has begun", count))?;
        let rate = from.number("rate of the skills")?;
        self.player = SkillPlayer::new(self.known[now].skill.clone(), rate)
            .ok_or_else(|| StateError::value("rate of the skills", rate, "a rate that fits the skill"))?;
        (self.now, self.rate) = (now, rate);
        self.player.read_state(from)
    }

    /// Puts the body at the start of the first skill.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, heading: Heading<f64>, place: DVec3) {
        let first = self.known[0].skill.clone();
        if let Some(player) = SkillPlayer::new(first, self.rate) {
            self.player = player;
        }
        (self.now, self.next, self.begun) = (0, None, Some(0));
        self.player.begin(sim, heading, place, None);
    }

    /// Sets the servo targets of the coming step. Call it before each step. A wish that was begun is taken out.
    pub fn drive(&mut self, sim: &mut Simulator<f64>, wish: &mut Wish) -> Result<(), PolicyError> {
        if self.player.at_decision() {
            self.prepare(sim, wish);
        }
        self.player.drive(sim)
    }

    /// Call it after each step.
    pub fn after_step(&mut self, sim: &Simulator<f64>) {
        self.player.after_step(sim);
    }

    pub(crate) fn prepare(&mut self, sim: &mut Simulator<f64>, wish: &mut Wish) {
        let velocity = sim.total_momentum().linear.lane(0) / sim.model().mass();
        let off = deviation(velocity, wish.direction);
        let here = &self.known[self.now];
        let repeats = here.skill.motion.cycle().is_some();
        let finished = self.player.is_finished();
        if let Some(name) = &wish.perform {
            match self.known.iter().position(|k| k.skill.name() == name) {
                Some(k) if k != self.now && (repeats || finished) => self.next = Some(self.by_hand(k)),
                Some(_) => {}
                None => wish.perform = None,
            }
        }
        if self.next.is_none_or(|k| self.known[k].skill.motion.cycle().is_some()) {
            self.next = if repeats { self.for_direction(off) } else { finished.then(|| self.after_end()) };
        }
        if let Some(next) = self.next {
            let passage = self.passages[self.now][next];
            let there = !repeats || self.player.tick() % self.player.skill().motion.last() == passage.leave;
            if there && let Some(mut player) = SkillPlayer::new(self.known[next].skill.clone(), self.rate) {
                player.join(sim, passage.enter);
                if wish.perform.as_deref() == Some(self.known[next].skill.name()) {
                    wish.perform = None;
                }
                (self.player, self.now, self.next, self.begun) = (player, next, None, Some(next));
            }
        }
        let here = &self.known[self.now];
        if here.skill.motion.cycle().is_some() {
            self.player.set_speed(wish.speed);
            // Straight on into a passage, too: that is how the next skill learnt to begin.
            let straight = here.curve.abs() > 0.1 || self.next.is_some();
            let rate = if straight { 0.0 } else { (off * STEER.0).clamp(-STEER.1, STEER.1) };
            self.player.set_steering(rate);
        }
    }

    /// The skill that repeats and suits the deviation (rad, positive: to the left), if it is another one.
    fn for_direction(&self, off: f64) -> Option<usize> {
        let here = &self.known[self.now];
        let suits = |k: &Known| k.skill.motion.cycle().is_some() && k.way == here.way;
        let side = |k: &Known| k.curve.abs() > 0.1 && k.curve.signum() == off.signum();
        if here.curve.abs() > 0.1 {
            // It is left once in a cycle: when going straight on now is nearer to the wish than after another cycle.
            let in_a_cycle = here.curve.abs() * here.skill.motion.duration();
            let leave = off * here.curve.signum() < 0.5 * in_a_cycle;
            return self.nearest(|k| suits(k) && k.curve.abs() <= 0.1).filter(|_| leave);
        }
        let curve = self.known.iter().position(|k| suits(k) && side(k)).filter(|_| off.abs() > CURVE)?;
        Some(self.by_hand(curve))
    }

    /// The skill that repeats and begins most like the present one ends.
    fn after_end(&self) -> usize {
        self.nearest(Known::repeats).unwrap_or(0)
    }

    /// The next skill on the way to skill `k`: images follow images, as the skills themselves were learnt one after the
    /// other, so the hand is changed first, from a straight skill to its image.
    fn by_hand(&self, k: usize) -> usize {
        let (here, there) = (&self.known[self.now], &self.known[k]);
        if here.is_image() == there.is_image() || !here.repeats() {
            return k;
        }
        let straight = |a: &Known| a.repeats() && a.way == here.way && a.curve.abs() <= 0.1;
        let next = if here.curve.abs() > 0.1 {
            self.nearest(straight)
        } else {
            self.known.iter().position(|a| straight(a) && a.is_image() == there.is_image())
        };
        next.unwrap_or(k)
    }

    /// The skill of a kind, other than the present one and of the same hand where there is one, that begins most like the
    /// present one is left.
    fn nearest(&self, is_wanted: impl Fn(&Known) -> bool) -> Option<usize> {
        let near = |k: &usize| self.passages[self.now][*k].distance;
        let wanted = (0..self.known.len()).filter(|&k| k != self.now && is_wanted(&self.known[k]));
        let hand = self.known[self.now].is_image();
        wanted.min_by(|a, b| {
            let other = |k: &usize| self.known[*k].is_image() != hand;
            other(a).cmp(&other(b)).then(near(a).total_cmp(&near(b)))
        })
    }
}

impl Known {
    fn repeats(&self) -> bool {
        self.skill.motion.cycle().is_some()
    }

    fn is_image(&self) -> bool {
        self.skill.mirror.is_some()
    }

    fn image(&self, model: &CharacterModel) -> Self {
        Self { skill: Arc::new(self.skill.mirrored(model)), way: self.way, curve: -self.curve }
    }

    fn of(skill: Arc<TrainedSkill>) -> Self {
        let motion = &skill.motion;
        let last = motion.last();
        let along: f64 = (0..=last)
            .map(|k| {
                let t = motion.tick(k);
                (t.pose.root_rotation * DVec3::NEG_Z).dot(t.travel)
            })
            .sum();
        let turned = motion.cycle().map_or(0.0, |c| Heading::<f64> { c: c.turn.0, s: c.turn.1 }.angle());
        let curve = turned / motion.duration().max(1e-3);
        Self { way: if along >= 0.0 { Way::Forward } else { Way::Backward }, curve, skill }
    }
}

/// Angle from the way that is travelled to the one that is wished for, rad, positive to the left; zero where either is
/// not known.
fn deviation(velocity: DVec3, wish: DVec3) -> f64 {
    let (v, w) = (velocity * DVec3::new(1.0, 0.0, 1.0), wish * DVec3::new(1.0, 0.0, 1.0));
    if v.length() < 0.2 || w.length() < 1e-6 || !w.is_finite() {
        return 0.0;
    }
    Heading::<f64>::towards(w).relative_to(Heading::towards(v)).angle()
}
