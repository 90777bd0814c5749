//! Watches soles: where each stands, and when that changes; steps, and feet that catch on something.

use crate::asset::{Material, Side, StateError, StateReader, StateWriter};
use crate::contact::Terrain;
use crate::control::foot::FootAnatomy;
use crate::engine::StumbleCause;
use crate::engine::footstep::FootPhase;
use crate::math::{Real, Vec3};
use crate::model::CharacterModel;
use crate::sim::Simulator;
use bevy::math::DVec3;

/// How long a new contact has to last, s: soles chatter for a few milliseconds when they touch down.
const SETTLE: f64 = 0.010;
/// How long a foot has to be off the ground, s: it bounces when it comes down.
const LIFTED: f64 = 0.060;
/// How long another foot has to stand while one is in the air for that to be a step, s: both feet of a jump do not come down at the same moment.
const CARRIED: f64 = 0.050;

/// Which parts of a sole touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sole {
    /// What lies behind the ankle.
    rear: bool,
    /// What lies before it.
    front: bool,
}

impl Sole {
    fn is_up(self) -> bool {
        self == Self::default()
    }
    /// What the change to another contact is called.
    fn change(self, to: Self) -> Option<FootPhase> {
        let up = Self::default();
        Some(match (self, to) {
            (a, b) if a == b => return None,
            (_, b) if b == up => FootPhase::ToeOff,
            (a, Self { rear: true, front: false }) if a == up => FootPhase::HeelStrike,
            (a, Self { rear: false, .. }) if a == up => FootPhase::ToeStrike,
            (_, Self { rear: true, front: true }) => FootPhase::FootFlat,
            (_, Self { rear: false, .. }) => FootPhase::HeelOff,
            // Rolled back onto the heel.
            _ => FootPhase::HeelStrike,
        })
    }
    fn number(self) -> u8 {
        u8::from(self.rear) | u8::from(self.front) << 1
    }
    fn numbered(from: &mut StateReader) -> Result<Self, StateError> {
        let number = from.byte("contact of a sole")?;
        if number > 3 {
            return Err(StateError::value("contact of a sole", number, "0 to 3"));
        }
        Ok(Self { rear: number & 1 != 0, front: number & 2 != 0 })
    }
}

/// A change of a sole's contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootChange {
    pub time: f64,
    pub foot: usize,
    pub side: Option<Side>,
    pub phase: FootPhase,
    pub force: DVec3,
    pub impulse: DVec3,
    pub place: DVec3,
    pub material: Material,
    pub slip: f64,
}

/// A step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootStep {
    pub time: f64,
    pub foot: usize,
    pub side: Option<Side>,
    pub from: DVec3,
    pub to: DVec3,
    pub airtime: f64,
}

/// What a foot did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FootEvent {
    Change(FootChange),
    Step(FootStep),
    Caught { time: f64, foot: usize, speed: f64 },
}

/// One foot.
#[derive(Clone, Debug)]
pub(super) struct FootWatch {
    foot: usize,
    side: Option<Side>,
    /// Contact points behind the ankle and before it.
    rear: Vec<usize>,
    front: Vec<usize>,
    /// Link of the ankle.
    ankle: usize,
    told: Sole,
    seen: Sole,
    since: f64,
    /// Impulse of the ground since the contact that is seen, N s.
    impulse: DVec3,
    /// Where the ankle was when the foot last came down, m; `None` before.
    landed: Option<DVec3>,
    /// When it left the ground, s.
    lifted: f64,
    /// How long another foot has stood since, s.
    carried: f64,
    /// It was told that it caught on something since.
    caught: bool,
}

impl FootWatch {
    /// The soles of a model; feet on blades have edges instead.
    pub fn of(model: &CharacterModel) -> Vec<Self> {
        let watch = |foot: usize| {
            let anatomy = FootAnatomy::of(model, foot).ok()?;
            let (rear, front) = anatomy.rear_and_front();
            Some(Self {
                foot,
                side: anatomy.side,
                rear,
                front,
                ankle: anatomy.ankle(),
                told: Sole::default(),
                seen: Sole::default(),
                since: 0.0,
                impulse: DVec3::ZERO,
                landed: None,
                lifted: 0.0,
                carried: 0.0,
                caught: false,
            })
        };
        (0..model.feet().len()).filter_map(watch).collect()
    }

    pub fn restart(&mut self) {
        (self.told, self.seen, self.since) = (Sole::default(), Sole::default(), 0.0);
        (self.impulse, self.landed) = (DVec3::ZERO, None);
        (self.lifted, self.carried, self.caught) = (0.0, 0.0, false);
    }

    /// Whether it stands for certain.
    pub fn stands(&self) -> bool {
        !self.told.is_up() && !self.seen.is_up()
    }

    /// Looks at lane `lane` after a step; `carried` says whether another foot stands.
    pub fn observe<R: Real>(
        &mut self,
        sim: &mut Simulator<R>,
        lane: usize,
        time: f64,
        carried: bool,
        ground: &impl Terrain<f64>,
        mut tell: impl FnMut(FootEvent),
    ) {
        let touches = |points: &[usize]| points.iter().any(|p| sim.contact_force(*p, lane) != DVec3::ZERO);
        let now = Sole { rear: touches(&self.rear), front: touches(&self.front) };
        let h = sim.step_seconds();
        if self.told.is_up() && now.is_up() && carried {
            self.carried += h;
        }
        if now != self.seen {
            let swings = self.told.is_up() && self.seen.is_up() && self.landed.is_some();
            (self.seen, self.since, self.impulse) = (now, time, DVec3::ZERO);
            if swings && !self.caught {
                let speed = self.speed_along(sim, lane, ground);
                if speed > StumbleCause::CAUGHT {
                    self.caught = true;
                    tell(FootEvent::Caught { time, foot: self.foot, speed });
                }
            }
        }
        if self.seen == self.told {
            return;
        }
        let points = self.rear.iter().chain(&self.front);
        self.impulse += points.map(|p| sim.contact_force(*p, lane)).sum::<DVec3>() * h;
        let settle = if self.seen.is_up() { LIFTED } else { SETTLE };
        if time - self.since >= settle {
            self.settle(sim, lane, ground, tell);
        }
    }

    /// The contact that is seen is certain.
    fn settle<R: Real>(
        &mut self,
        sim: &mut Simulator<R>,
        lane: usize,
        ground: &impl Terrain<f64>,
        mut tell: impl FnMut(FootEvent),
    ) {
        let (time, foot, side) = (self.since, self.foot, self.side);
        let Some(phase) = self.told.change(self.seen) else { return };
        let was_up = std::mem::replace(&mut self.told, self.seen).is_up();
        let (force, place, slip) = self.contact(sim, lane);
        let material = if force == DVec3::ZERO { Material::GROUND } else { ground.material(0, place) };
        let impulse = self.impulse;
        tell(FootEvent::Change(FootChange { time, foot, side, phase, force, impulse, place, material, slip }));
        if self.told.is_up() {
            (self.lifted, self.carried, self.caught) = (time, 0.0, false);
        } else if was_up {
            let to = sim.state.root_position.lane(lane) + sim.kinematics()[self.ankle].origin.lane(lane);
            let before = self.landed.replace(to);
            if let Some(from) = before.filter(|_| self.carried >= CARRIED) {
                tell(FootEvent::Step(FootStep { time, foot, side, from, to, airtime: time - self.lifted }));
            }
        }
    }

    /// Fastest of the touching points along the surface that it touches, m/s.
    fn speed_along<R: Real>(&self, sim: &mut Simulator<R>, lane: usize, ground: &impl Terrain<f64>) -> f64 {
        let model = sim.model().clone();
        let root = sim.state.root_position.lane(lane);
        let mut fastest: f64 = 0.0;
        for point in self.rear.iter().chain(&self.front) {
            if sim.contact_force(*point, lane) == DVec3::ZERO {
                continue;
            }
            let p = &model.contact_points[*point];
            let link = sim.kinematics()[p.link];
            let arm = link.rotation.lane(lane) * p.position;
            let velocity = link.velocity.linear.lane(lane) + link.velocity.angular.lane(lane).cross(arm);
            let hit = ground.query(Vec3::<f64>::splat(root + link.origin.lane(lane) + arm));
            let (normal, velocity) = (hit.normal.lane(0), velocity - hit.velocity.lane(0));
            fastest = fastest.max((velocity - normal * velocity.dot(normal)).length());
        }
        fastest
    }

    /// Force of the ground (N), where it acts (m), and the speed of the touching points along it (m/s), weighted by their loads.
    fn contact<R: Real>(&self, sim: &mut Simulator<R>, lane: usize) -> (DVec3, DVec3, f64) {
        let model = sim.model().clone();
        let root = sim.state.root_position.lane(lane);
        let (mut force, mut place, mut slip, mut load) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
        for point in self.rear.iter().chain(&self.front) {
            let own = sim.contact_force(*point, lane);
            let size = own.length();
            if size == 0.0 {
                continue;
            }
            let p = &model.contact_points[*point];
            let link = sim.kinematics()[p.link];
            let arm = link.rotation.lane(lane) * p.position;
            let velocity = link.velocity.linear.lane(lane) + link.velocity.angular.lane(lane).cross(arm);
            let normal = own / size;
            force += own;
            place += (root + link.origin.lane(lane) + arm - DVec3::Y * p.radius) * size;
            slip += (velocity - normal * velocity.dot(normal)).length() * size;
            load += size;
        }
        if load == 0.0 { (force, place, 0.0) } else { (force, place / load, slip / load) }
    }

    pub fn write_state(&self, out: &mut StateWriter) {
        out.byte(self.told.number());
        out.byte(self.seen.number());
        out.number(self.since);
        out.vector(self.impulse);
        out.option(self.landed, StateWriter::vector);
        out.number(self.lifted);
        out.number(self.carried);
        out.switch(self.caught);
    }

    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        self.told = Sole::numbered(from)?;
        self.seen = Sole::numbered(from)?;
        self.since = from.number("time of a sole's contact")?;
        self.impulse = from.vector("impulse of a sole")?;
        self.landed = from.option("place of a step", |from| from.vector("place of a step"))?;
        self.lifted = from.number("time at which a foot left the ground")?;
        self.carried = from.number("time on the other foot")?;
        self.caught = from.switch("whether a foot was caught")?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{foot_human, preset};

    #[test]
    fn a_step_has_four_phases_by_their_names() {
        let [up, heel, flat, toes] =
            [(false, false), (true, false), (true, true), (false, true)].map(|(rear, front)| Sole { rear, front });
        let names = [
            (up, heel, FootPhase::HeelStrike),
            (heel, flat, FootPhase::FootFlat),
            (flat, toes, FootPhase::HeelOff),
            (toes, up, FootPhase::ToeOff),
            (up, toes, FootPhase::ToeStrike),
            (toes, flat, FootPhase::FootFlat),
            (flat, up, FootPhase::ToeOff),
            (flat, heel, FootPhase::HeelStrike),
            (up, flat, FootPhase::FootFlat),
        ];
        for (from, to, phase) in names {
            assert_eq!(from.change(to), Some(phase), "{from:?} to {to:?}");
        }
        assert_eq!(flat.change(flat), None);
    }

    #[test]
    fn soles_have_a_heel_and_toes_and_blades_have_none() {
        let watches = FootWatch::of(&foot_human());
        assert_eq!(watches.len(), 2);
        assert!(watches.iter().all(|w| !w.rear.is_empty() && !w.front.is_empty()));
        assert!(FootWatch::of(&preset("skater").unwrap()).is_empty());
    }
}
