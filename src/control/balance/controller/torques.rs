//! Torques at every step.

use super::Balance;
use crate::dynamics::{State, inverse_dynamics_into, passive_torque};
use crate::math::{Force, Motion, Quat, Vec3};
use crate::sim::Simulator;

impl Balance {
    /// Torques for the present state, by inverse dynamics under the held accelerations and forces of the ground, into the commands.
    pub(super) fn command(&mut self, sim: &mut Simulator<f64>) {
        let h = sim.step_seconds();
        self.external.fill(Force::zero());
        let gone = sim.state.root_position.lane(0) - self.decided_at;
        for (point, force) in self.forces.forces() {
            let arm = point.place - gone - self.kinematics[point.link].origin.lane(0);
            self.external[point.link] += Force::at(Vec3::<f64>::splat(arm), Vec3::<f64>::splat(force));
        }
        let a = &self.accelerations;
        let three = |at: usize| Vec3::new(a[at], a[at + 1], a[at + 2]);
        let root = Motion { linear: three(0), angular: self.kinematics[0].rotation.mul_vec(three(3)) };
        for i in 1..self.constants.len() {
            let at = self.dof_of[i];
            self.joints[i] = self.constants[i].hinge.map_or_else(|| three(at), |axis| axis * a[at]);
        }
        let gravity = Vec3::<f64>::splat(sim.settings().gravity);
        inverse_dynamics_into(
            &self.constants,
            &self.kinematics,
            root,
            &self.joints,
            gravity,
            &self.external,
            &mut self.inverse,
        );
        let rest = self.inverse.root();
        self.probe.residual = rest.force.lane(0).length().max(rest.moment.lane(0).length());
        for (v, a) in self.planned.iter_mut().zip(&self.accelerations) {
            *v += a * h;
        }
        let State { joints, .. } = &sim.state;
        for (i, joint) in joints.iter().enumerate().skip(1) {
            let at = self.dof_of[i];
            let planned = |at: usize| Vec3::new(self.planned[at], self.planned[at + 1], self.planned[at + 2]);
            let command = &mut sim.commands[i];
            command.rotation = Quat::<f64> { v: joint.rotation.v, w: joint.rotation.w };
            command.velocity = self.constants[i].hinge.map_or_else(|| planned(at), |axis| axis * self.planned[at]);
            command.kp = 0.0;
            if self.of_foot[i] && !self.is_ankle[i] {
                command.rotation = Quat::<f64>::splat(self.targets[i]);
                command.kp = self.settings.foot_stiffness * self.model.links[i].gains.kp;
            }
            let foot = self.of_foot[i];
            let part = if foot { self.settings.foot_damping } else { self.settings.damping };
            command.kd = part * self.model.links[i].gains.kd;
            // What a passive spring does need not be done.
            command.torque = self.inverse.torques()[i] - passive_torque(&self.constants[i], joint);
        }
    }
}
