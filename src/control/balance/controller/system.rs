//! The linear system of a decision: posture, momentum, supports.

use super::super::accelerations::Accelerations;
use super::super::momentum::Whole;
use super::{Balance, MOST_SUPPORTS, SIX};
use crate::asset::turn::rotation_vector;
use crate::dynamics::{LinkConstants, LinkKinematics, inverse_dynamics_into};
use crate::math::{Motion, Vec3};
use crate::sim::Simulator;
use glam::{DMat3, DQuat, DVec3};

/// Compliance of the rows of momentum, of a support's place and rotation; weights of tracking are 1.
const MOMENTUM_COMPLIANCE: f64 = 1e-6;
/// Compliance of a row that does not count.
const LOOSE: f64 = 1e6;
/// What a support may count as away from where it shall be, m and rad: bounds the speed at which a segment comes down.
const FURTHEST: f64 = 0.02;
const SLOWLY: f64 = 0.005;
const FURTHEST_TURN: f64 = 0.2;
/// Weight of the root's own acceleration, which nothing tracks.
const ROOT_LINEAR: f64 = 1e-2;
/// Weight of tracking of the joints of segments that stand: the ground holds them.
const STANDING_JOINT: f64 = 0.05;

impl Balance {
    /// Accelerations towards the posture, and their weights.
    pub(super) fn track(&mut self, sim: &Simulator<f64>) {
        let gain = self.settings.tracking;
        let damping = 2.0 * gain.sqrt();
        for i in 0..self.model.links.len() {
            self.targets[i] = self.posture_of(i);
        }
        let system = &mut self.system;
        system.track.fill(0.0);
        system.weights.fill(1.0);
        system.weights[..3].fill(ROOT_LINEAR);
        let now = sim.state.root_rotation.lane(0);
        let spin = now.conjugate() * sim.state.root_velocity.angular.lane(0);
        let turn = rotation_vector(now.conjugate() * self.heading) * gain - spin * damping;
        system.track[3..6].copy_from_slice(&turn.to_array());
        for i in 1..self.model.links.len() {
            let joint = &sim.state.joints[i];
            let q = joint.rotation.lane(0);
            let turn = rotation_vector(q.conjugate() * self.targets[i]) * gain - joint.velocity.lane(0) * damping;
            let at = self.dof_of[i];
            match self.constants[i].hinge {
                Some(axis) => system.track[at] = axis.lane(0).dot(turn),
                None => system.track[at..at + 3].copy_from_slice(&turn.to_array()),
            }
        }
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            for segment in stance.touch.iter().filter_map(|k| footing.anatomy.segments().get(k)) {
                let at = self.dof_of[segment.link];
                let count = if self.constants[segment.link].hinge.is_some() { 1 } else { 3 };
                system.weights[at..at + count].fill(STANDING_JOINT);
            }
        }
    }

    /// Rotation of a joint in the posture; those of a foot as foot pose control has them.
    pub(super) fn posture_of(&self, link: usize) -> DQuat {
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            if stance.touch.is_empty() {
                continue;
            }
            let Some(k) = footing.anatomy.segments().iter().position(|s| s.link == link) else { continue };
            let Some(pose) = &footing.pose else { continue };
            if k > 0 {
                return pose.joints[k];
            }
            let Some(shin) = self.model.links[link].parent else { continue };
            let Some(thigh) = self.model.links[shin].parent else { continue };
            let above = self.heading * self.stance.posture[thigh] * self.stance.posture[shin];
            return pose.ankle_joint(&footing.anatomy, above.normalize()).0;
        }
        self.stance.posture[link]
    }

    /// The rows of momentum and support.
    pub(super) fn fill_system(&mut self, root: DVec3, whole: &Whole, force: DVec3, moment: DVec3) {
        // Accelerations that links have while no generalised velocity changes: J' v of every joint.
        inverse_dynamics_into(
            &self.constants,
            &self.kinematics,
            Motion::zero(),
            &self.still,
            Vec3::zero(),
            &[],
            &mut self.inverse,
        );
        let supports: usize = self.stance.feet.iter().map(|f| f.touch.len()).sum::<usize>().min(MOST_SUPPORTS - 1);
        let swinging = usize::from(self.capture.swing.is_some());
        let system = &mut self.system;
        system.begin(SIX * (1 + supports + swinging));
        // Momentum, as accelerations of the centre of mass and of a body that turns as one.
        let inertia = whole.inertia.to_cols_array();
        let turning = (inertia[0] + inertia[4] + inertia[8]) / 3.0;
        let rate = self.map.rate();
        system.wish[..3].copy_from_slice(&((force - rate.force.lane(0)) / whole.mass).to_array());
        system.wish[3..6].copy_from_slice(&((moment - rate.moment.lane(0)) / turning).to_array());
        system.compliance[..6].fill(MOMENTUM_COMPLIANCE);
        for (dof, column) in self.map.columns().iter().enumerate() {
            let (linear, angular) = (column.force.lane(0) / whole.mass, column.moment.lane(0) / turning);
            for k in 0..3 {
                system.set(k, dof, linear[k]);
                system.set(3 + k, dof, angular[k]);
            }
        }
        // Supports: equation 7.
        let body = Body {
            kinematics: &self.kinematics,
            constants: &self.constants,
            dof_of: &self.dof_of,
            coasting: self.inverse.accelerations(),
            compliance: self.settings.support_compliance,
        };
        let mut row = SIX;
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            for k in stance.touch.iter().filter(|&k| k < footing.anatomy.segments().len()) {
                if row + SIX > SIX * (1 + supports) {
                    break;
                }
                let link = footing.anatomy.segments()[k].link;
                let flying = footing.gaps[k] > self.settings.flying;
                let coming = footing.coming.contains(k);
                let gain = if coming { self.settings.landing } else { self.settings.support };
                let furthest = if coming && self.fresh <= 0.0 { SLOWLY } else { FURTHEST };
                let damping = 2.0 * gain.sqrt();
                let at = &self.kinematics[link];
                let anchor = &footing.anchors[k];
                let place = root + at.origin.lane(0);
                let rotation = DQuat::from_mat3(&at.rotation.lane(0));
                let drift = footing.drift;
                let velocity = at.velocity;
                let turn = rotation_vector(anchor.rotation * rotation.conjugate()).clamp_length_max(FURTHEST_TURN);
                let way = (anchor.place - place).clamp_length_max(furthest);
                let linear = gain * way - damping * (velocity.linear.lane(0) - drift);
                let angular = gain * turn - damping * (velocity.angular.lane(0) - footing.spin);
                // Along the ground and out of it: a segment in the air comes down wherever it does.
                let level = if flying { LOOSE } else { self.settings.support_compliance };
                let wish = LinkWish { link, linear, angular, axes: DMat3::from_quat(anchor.rotation), level };
                body.fill(&mut self.system, row, &wish);
                row += SIX;
            }
        }
        if let Some(swing) = self.capture.swing {
            let link = self.footings[swing.foot].anatomy.ankle();
            let at = &self.kinematics[link];
            let velocity = at.velocity;
            let (linear, rotation) = self.swing_wish(&swing, root + at.origin.lane(0), velocity.linear.lane(0));
            let turn = rotation_vector(rotation * DQuat::from_mat3(&at.rotation.lane(0)).conjugate());
            let gain = self.settings.swing;
            let angular = gain * turn.clamp_length_max(FURTHEST_TURN) - 2.0 * gain.sqrt() * velocity.angular.lane(0);
            let level = self.settings.support_compliance;
            body.fill(&mut self.system, row, &LinkWish { link, linear, angular, axes: DMat3::IDENTITY, level });
        }
    }
}

/// How a link shall accelerate, world axes: m/s^2 along `axes`, of which the first and the third have the compliance `level`, and rad/s^2.
struct LinkWish {
    link: usize,
    linear: DVec3,
    angular: DVec3,
    axes: DMat3,
    level: f64,
}

/// What rows are made of.
struct Body<'a> {
    kinematics: &'a [LinkKinematics<f64>],
    constants: &'a [LinkConstants<f64>],
    dof_of: &'a [usize],
    /// Accelerations that links have while no generalised velocity changes.
    coasting: &'a [Motion<f64>],
    compliance: f64,
}

impl Body<'_> {
    /// The six rows by which a link accelerates as is wished.
    fn fill(&self, system: &mut Accelerations, row: usize, wish: &LinkWish) {
        let LinkWish { link, linear, angular, axes, level } = *wish;
        let at = &self.kinematics[link];
        let coasting = self.coasting[link];
        let wishes = [linear - coasting.linear.lane(0), angular - coasting.angular.lane(0)];
        for k in 0..3 {
            system.wish[row + k] = axes.col(k).dot(wishes[0]);
            system.wish[row + 3 + k] = wishes[1][k];
            for j in 0..3 {
                system.set(row + k, j, axes.col(k)[j]);
            }
        }
        system.compliance[row..][..6].fill(self.compliance);
        (system.compliance[row], system.compliance[row + 2]) = (level, level);
        let mut above = link;
        loop {
            let own = &self.kinematics[above];
            let joint = match self.constants[above].hinge {
                Some(axis) => ([axis.lane(0), DVec3::ZERO, DVec3::ZERO], 1),
                None => ([DVec3::X, DVec3::Y, DVec3::Z], 3),
            };
            for (j, axis) in joint.0[..joint.1].iter().enumerate() {
                let axis = own.rotation.lane(0) * *axis;
                let moved = axis.cross(at.origin.lane(0) - own.origin.lane(0));
                let dof = self.dof_of[above] + j;
                for k in 0..3 {
                    system.set(row + k, dof, axes.col(k).dot(moved));
                    system.set(row + 3 + k, dof, axis[k]);
                }
            }
            if above == 0 {
                break;
            }
            above = self.constants[above].parent;
        }
    }
}
