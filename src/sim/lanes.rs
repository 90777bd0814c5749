//! Characters in and out of the lanes of a common simulator.
//!
//! A lane of an unfused type has the bits of a scalar simulator of its precision, so characters of one model may step
//! together or alone as it pays. Time, settings and outside forces are common to all lanes; who steps characters
//! together sees to it that they agree.

use crate::contact::BladeContact;
use crate::dynamics::ServoOutput;
use crate::math::{Real, Vec3};
use crate::sim::Simulator;

impl<R: Real> Simulator<R> {
    /// Puts lane `from` of another simulator of the same model into lane `to`: state (without time),
    /// commands and the factor on friction.
    pub fn put_lane<S: Real>(&mut self, to: usize, other: &Simulator<S>, from: usize) {
        self.state.copy_lane(to, &other.state, from);
        self.friction_scale.set_lane(to, other.friction_scale.lane(from));
        self.put_commands(to, other, from);
        self.state_changed();
    }

    /// Puts the commands of lane `from` of another simulator of the same model into lane `to`.
    pub fn put_commands<S: Real>(&mut self, to: usize, other: &Simulator<S>, from: usize) {
        for (mine, theirs) in self.commands.iter_mut().zip(&other.commands).skip(1) {
            mine.rotation.set_lane(to, theirs.rotation.lane(from));
            mine.velocity.set_lane(to, theirs.velocity.lane(from));
            // These seldom change, and to write a lane costs more than to read one.
            let torque = theirs.torque.lane(from);
            if mine.torque.lane(to) != torque {
                mine.torque.set_lane(to, torque);
            }
            for (mine, theirs) in [(&mut mine.kp, theirs.kp), (&mut mine.kd, theirs.kd)] {
                if mine.lane(to) != theirs.lane(from) {
                    mine.set_lane(to, theirs.lane(from));
                }
            }
        }
    }

    /// Takes over into every lane what a step changed in lane `from` of another simulator of the same model: the state
    /// (without time), and what is told of the last step (blades, torques, forces of contact).
    pub fn take_lane<S: Real>(&mut self, other: &Simulator<S>, from: usize) {
        for to in 0..R::LANES {
            self.state.copy_lane(to, &other.state, from);
        }
        let vector = |v: Vec3<S>| Vec3::<R>::splat(v.lane(from));
        let number = |v: S| R::splat(v.lane(from));
        for (mine, theirs) in self.servos.iter_mut().zip(&other.servos).skip(1) {
            *mine = ServoOutput {
                torque: vector(theirs.torque),
                implicit: number(theirs.implicit),
                beyond: theirs.beyond.map(vector),
            };
        }
        for (mine, theirs) in self.joint_accelerations.iter_mut().zip(&other.joint_accelerations).skip(1) {
            *mine = vector(*theirs);
        }
        let none = R::zero().lt(R::zero());
        for (mine, theirs) in self.contact.blades.iter_mut().zip(&other.contact.blades) {
            let on_ice = theirs.as_ref().filter(|b| S::mask_lane(b.on_ice, from));
            *mine = on_ice.map(|b| BladeContact {
                on_ice: !none,
                along: vector(b.along),
                across: vector(b.across),
                lean: number(b.lean),
                curvature: number(b.curvature),
            });
        }
        if S::mask_lane(other.contact.unanswered, from) {
            self.contact.unanswered = !none;
        }
        self.contact_root_position = vector(other.contact_root_position);
        self.state_changed();
    }

    /// Whether the terrain gave lane `lane` an answer that is no number since [`Simulator::forget_terrain_failures`].
    pub fn terrain_failed(&self, lane: usize) -> bool {
        R::mask_lane(self.contact.unanswered, lane)
    }

    /// From here on only new failures of the terrain count.
    pub fn forget_terrain_failures(&mut self) {
        self.contact.unanswered = R::zero().lt(R::zero());
    }

    /// Goes on at another rate, steps per second. The impulses that the next step starts from become those of a step of
    /// the new length under the same forces.
    pub fn change_rate(&mut self, rate: f64) {
        let mut settings = *self.settings();
        let scale = R::splat(settings.rate / rate);
        settings.rate = rate;
        self.set_settings(settings);
        for impulse in self.state.contact_impulses.iter_mut().chain(&mut self.state.grip_impulses) {
            *impulse = *impulse * scale;
        }
    }
}
