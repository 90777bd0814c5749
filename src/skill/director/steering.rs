//! Steering: a wish for a direction and a speed becomes a choice of skills. Straight skills on straight ways, curving skills on
//! curves, others on request.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::tracking::Heading;
use crate::skill::director::{BodyView, Choice, DirectorInput};
use crate::skill::{Entry, GraphSkill, NoEntry, SkillGraph};
use glam::DVec3;

/// Deviation from the wished direction at which a curving skill is chosen, rad.
const CURVE: f64 = 0.6;
/// How fast a skill that goes straight is turned, rad/s for each radian of deviation, and at most.
const STEER: (f64, f64) = (0.6, 0.35);
/// So many skills are passed at most on the way to one that was asked for.
const HOPS: usize = 4;

/// Goes where it is told to, and performs what it is asked for as soon as that can begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steering {
    /// The skill that follows.
    next: Option<usize>,
    /// The skill that was asked for.
    request: Option<usize>,
}

impl Steering {
    /// The skill that was asked for and has not begun yet, by its index in the graph.
    pub fn request(&self) -> Option<usize> {
        self.request
    }

    /// Forgets what was planned; the request that was open.
    pub(super) fn restart(&mut self) -> Option<usize> {
        self.next = None;
        self.drop_request()
    }

    pub(super) fn drop_request(&mut self) -> Option<usize> {
        self.request.take()
    }

    /// Asks for a skill, in place of another one; when it begins.
    pub(super) fn ask(&mut self, k: usize, body: &BodyView, graph: &SkillGraph) -> Entry {
        let entry = self.entry(k, body, graph);
        if !matches!(entry, Entry::Never(_)) {
            self.request = Some(k);
        }
        entry
    }

    /// When skill `k` would begin, were it asked for now.
    pub(super) fn entry(&self, k: usize, body: &BodyView, graph: &SkillGraph) -> Entry {
        if k == body.skill && graph.skills()[k].repeats() {
            return Entry::Never(NoEntry::Playing);
        }
        let (mut from, mut tick, mut seconds) = (body.skill, body.tick, 0.0);
        for _ in 0..HOPS {
            let to = by_hand(graph, from, k);
            match graph.entry(from, tick, to) {
                Entry::Never(reason) => return Entry::Never(reason),
                Entry::Now { tick: enter } if to == k && seconds == 0.0 => return Entry::Now { tick: enter },
                Entry::Now { .. } => {}
                Entry::After { seconds: more } => seconds += more,
            }
            if to == k {
                return Entry::After { seconds };
            }
            // The decision at which it is entered is its own; it can be left at the next.
            tick = graph.transition(from, to).map_or(0, |t| t.enter) + 1;
            seconds += 1.0 / graph.skills()[to].skill.definition.control_rate;
            from = to;
        }
        Entry::Never(NoEntry::NoTransition { from: graph.skills()[body.skill].name().to_owned() })
    }

    pub(super) fn next(&mut self, body: &mut BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        let off = deviation(body.velocity(), input.direction);
        let known = graph.skills();
        let repeats = known[body.skill].repeats();
        let asked = self.request.filter(|k| *k != body.skill && (repeats || body.finished));
        if let Some(k) = asked {
            // What was asked for goes before the direction, on the way to it too.
            self.next = Some(by_hand(graph, body.skill, k));
        } else if self.next.is_none_or(|k| known[k].repeats()) {
            self.next = if repeats {
                for_direction(graph, body.skill, off)
            } else {
                body.finished.then(|| nearest(graph, body.skill, GraphSkill::repeats).unwrap_or(0))
            };
        }
        let mut choice = Choice::default();
        if let Some(next) = self.next
            && let Entry::Now { tick } = graph.entry(body.skill, body.tick, next)
        {
            choice.enter = Some((next, tick));
            self.next = None;
            self.request = self.request.filter(|k| *k != next);
        }
        let then = &known[choice.enter.map_or(body.skill, |(k, _)| k)];
        if then.repeats() {
            choice.speed = Some(input.speed.unwrap_or(then.skill.motion.mean_speed()));
            // Straight on into a transition, too: that is how the next skill learnt to begin.
            if !then.is_curve() && self.next.is_none() {
                choice.turn = (off * STEER.0).clamp(-STEER.1, STEER.1);
            }
        }
        choice
    }

    pub(super) fn write_state(&self, out: &mut StateWriter) {
        out.option(self.next, StateWriter::count);
        out.option(self.request, StateWriter::count);
    }

    pub(super) fn read_state(&mut self, from: &mut StateReader, graph: &SkillGraph) -> Result<(), StateError> {
        let count = graph.skills().len();
        self.next = from.option("next skill", |from| from.below("next skill", count))?;
        self.request = from.option("skill that was asked for", |from| from.below("skill that was asked for", count))?;
        Ok(())
    }
}

/// The skill that repeats and suits the deviation (rad, positive: to the left), if it is another one.
fn for_direction(graph: &SkillGraph, now: usize, off: f64) -> Option<usize> {
    let known = graph.skills();
    let here = &known[now];
    let suits = |k: &GraphSkill| k.repeats() && k.way == here.way;
    let side = |k: &GraphSkill| k.is_curve() && k.curve.signum() == off.signum();
    if here.is_curve() {
        // It is left once in a cycle: when going straight on now is nearer to the wish than after another cycle.
        let in_a_cycle = here.curve.abs() * here.skill.motion.duration();
        let leave = off * here.curve.signum() < 0.5 * in_a_cycle;
        return nearest(graph, now, |k| suits(k) && !k.is_curve()).filter(|_| leave);
    }
    let curve = known.iter().position(|k| suits(k) && side(k)).filter(|_| off.abs() > CURVE)?;
    Some(by_hand(graph, now, curve))
}

/// The next skill on the way to skill `k`: images follow images, as the skills themselves were learnt one after the
/// other, so the hand is changed first, from a straight skill to its image.
fn by_hand(graph: &SkillGraph, now: usize, k: usize) -> usize {
    let known = graph.skills();
    let (here, there) = (&known[now], &known[k]);
    if here.is_image() == there.is_image() || !here.repeats() {
        return k;
    }
    let straight = |a: &GraphSkill| a.repeats() && a.way == here.way && !a.is_curve();
    let next = if here.is_curve() {
        nearest(graph, now, straight)
    } else {
        known.iter().position(|a| straight(a) && a.is_image() == there.is_image())
    };
    next.unwrap_or(k)
}

/// The skill of a kind, other than the present one and of the same hand where there is one, that begins most like the
/// present one is left.
fn nearest(graph: &SkillGraph, now: usize, is_wanted: impl Fn(&GraphSkill) -> bool) -> Option<usize> {
    let known = graph.skills();
    let near = |k: &usize| graph.transition(now, *k).map_or(f64::INFINITY, |t| t.distance);
    let can = |k: usize| k != now && graph.transition(now, k).is_some();
    let wanted = (0..known.len()).filter(|&k| can(k) && is_wanted(&known[k]));
    let hand = known[now].is_image();
    wanted.min_by(|a, b| {
        let other = |k: &usize| known[*k].is_image() != hand;
        other(a).cmp(&other(b)).then(near(a).total_cmp(&near(b)))
    })
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
