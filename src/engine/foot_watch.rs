//! Watches soles: where each stands, and when that changes.

use crate::asset::{Side, StateError, StateReader, StateWriter};
use crate::control::foot::FootAnatomy;
use crate::engine::footstep::FootPhase;
use crate::math::Real;
use crate::model::CharacterModel;
use crate::sim::Simulator;
use bevy::math::DVec3;

/// How long a new contact has to last, s: soles chatter for a few milliseconds when they touch down.
const SETTLE: f64 = 0.010;
/// How long a foot has to be off the ground, s: it bounces when it comes down.
const LIFTED: f64 = 0.060;

/// Which parts of a sole touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sole {
    /// What lies behind the ankle.
    rear: bool,
    /// What lies before it.
    front: bool,
}

impl Sole {
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
    pub place: DVec3,
    pub slip: f64,
}

/// One foot.
#[derive(Clone, Debug)]
pub(super) struct FootWatch {
    foot: usize,
    side: Option<Side>,
    /// Contact points behind the ankle and before it.
    rear: Vec<usize>,
    front: Vec<usize>,
    told: Sole,
    seen: Sole,
    since: f64,
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
                told: Sole::default(),
                seen: Sole::default(),
                since: 0.0,
            })
        };
        (0..model.feet().len()).filter_map(watch).collect()
    }

    pub fn restart(&mut self) {
        (self.told, self.seen, self.since) = (Sole::default(), Sole::default(), 0.0);
    }

    /// Looks at lane `lane` after a step.
    pub fn observe<R: Real>(&mut self, sim: &mut Simulator<R>, lane: usize, time: f64) -> Option<FootChange> {
        let touches = |points: &[usize]| points.iter().any(|p| sim.contact_force(*p, lane) != DVec3::ZERO);
        let now = Sole { rear: touches(&self.rear), front: touches(&self.front) };
        if now != self.seen {
            (self.seen, self.since) = (now, time);
        }
        let settle = if self.seen == Sole::default() { LIFTED } else { SETTLE };
        if self.seen == self.told || time - self.since < settle {
            return None;
        }
        let phase = self.told.change(self.seen)?;
        self.told = self.seen;
        let (force, place, slip) = self.contact(sim, lane);
        Some(FootChange { time: self.since, foot: self.foot, side: self.side, phase, force, place, slip })
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
    }

    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        self.told = Sole::numbered(from)?;
        self.seen = Sole::numbered(from)?;
        self.since = from.number("time of a sole's contact")?;
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
