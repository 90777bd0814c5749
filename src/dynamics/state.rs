//! The state of a character: everything a snapshot needs, nothing that can be recomputed.

use crate::dynamics::{GripAnchor, GripState};
use crate::math::{Motion, Quat, Real, Vec3};
use crate::model::CharacterModel;
use glam::{DQuat, DVec3};

/// Configuration and velocity of one joint.
#[derive(Clone, Copy, Debug)]
pub struct JointState<R> {
    /// Child axes to parent axes.
    pub rotation: Quat<R>,
    /// Angular velocity of the child against the parent, child axes, rad/s.
    pub velocity: Vec3<R>,
}

impl<R: Real> Default for JointState<R> {
    fn default() -> Self {
        Self { rotation: Quat::identity(), velocity: Vec3::zero() }
    }
}

/// Configuration, velocity and warm starts of a character (one per lane).
#[derive(Clone, Debug)]
pub struct State<R> {
    /// Simulated time, s.
    pub time: f64,
    /// Root joint position, world frame, m.
    pub root_position: Vec3<R>,
    /// Root axes to world axes.
    pub root_rotation: Quat<R>,
    /// Root twist: angular velocity (rad/s) and velocity of the root's origin (m/s), world axes.
    pub root_velocity: Motion<R>,
    /// One per link; entry 0 belongs to the root and is unused.
    pub joints: Vec<JointState<R>>,
    /// Contact impulse of the last step at each contact point, world axes, N s: the warm start of the next.
    pub contact_impulses: Vec<Vec3<R>>,
    /// Impulse of the last step at each grip, world axes, N s.
    pub grip_impulses: Vec<Vec3<R>>,
    /// What each grip holds on to.
    pub grips: Vec<GripState<R>>,
}

impl<R: Real> State<R> {
    /// The zero pose at rest, standing on y = 0.
    pub fn at_rest(model: &CharacterModel) -> Self {
        Self {
            time: 0.0,
            root_position: Vec3::splat(DVec3::new(0.0, model.rest_root_height(), 0.0)),
            root_rotation: Quat::identity(),
            root_velocity: Motion::zero(),
            joints: vec![JointState::default(); model.links.len()],
            contact_impulses: vec![Vec3::zero(); model.contact_points.len()],
            grip_impulses: vec![Vec3::zero(); model.grips.len()],
            grips: vec![GripState::default(); model.grips.len()],
        }
    }

    /// Copies lane `from` of `other` into lane `to`: configuration, velocity, warm starts and grips. Time stays: it is common to
    /// all lanes.
    pub fn copy_lane<S: Real>(&mut self, to: usize, other: &State<S>, from: usize) {
        self.root_position.set_lane(to, other.root_position.lane(from));
        self.root_rotation.set_lane(to, other.root_rotation.lane(from));
        self.root_velocity.angular.set_lane(to, other.root_velocity.angular.lane(from));
        self.root_velocity.linear.set_lane(to, other.root_velocity.linear.lane(from));
        for (mine, theirs) in self.joints.iter_mut().zip(&other.joints) {
            mine.rotation.set_lane(to, theirs.rotation.lane(from));
            mine.velocity.set_lane(to, theirs.velocity.lane(from));
        }
        for (mine, theirs) in self.contact_impulses.iter_mut().zip(&other.contact_impulses) {
            mine.set_lane(to, theirs.lane(from));
        }
        for (mine, theirs) in self.grip_impulses.iter_mut().zip(&other.grip_impulses) {
            mine.set_lane(to, theirs.lane(from));
        }
        for (mine, theirs) in self.grips.iter_mut().zip(&other.grips) {
            mine.copy_lane(to, theirs, from);
        }
    }

    /// One lane as a state of its own.
    pub fn lane<S: Real>(&self, model: &CharacterModel, index: usize) -> State<S> {
        let mut state = State::at_rest(model);
        state.time = self.time;
        for to in 0..S::LANES {
            state.copy_lane(to, self, index);
        }
        state
    }

    /// Closes grip number `grip` of lane `lane` about `anchor`. A number that the character does not have is ignored.
    pub fn hold(&mut self, grip: usize, lane: usize, anchor: GripAnchor) {
        if let Some(grip) = self.grips.get_mut(grip) {
            grip.hold(lane, anchor);
        }
    }

    /// Opens grip number `grip` of lane `lane`.
    pub fn release(&mut self, grip: usize, lane: usize) {
        if let (Some(state), Some(impulse)) = (self.grips.get_mut(grip), self.grip_impulses.get_mut(grip)) {
            state.release(lane);
            impulse.set_lane(lane, DVec3::ZERO);
        }
    }

    /// Opens every grip in every lane.
    pub fn release_all(&mut self) {
        self.grips.fill(GripState::default());
        self.grip_impulses.fill(Vec3::zero());
    }

    /// What grip number `grip` of lane `lane` holds on to; `None` where it is open.
    pub fn anchor(&self, grip: usize, lane: usize) -> Option<GripAnchor> {
        self.grips.get(grip)?.anchor(lane)
    }

    /// Sets the pose of lane `index`: root position (world, m), root rotation, child-to-parent rotation of each link
    /// (entry 0 unused). Velocities stay.
    pub fn set_pose(&mut self, index: usize, root_position: DVec3, root_rotation: DQuat, joints: &[DQuat]) {
        self.root_position.set_lane(index, root_position);
        self.root_rotation.set_lane(index, root_rotation.normalize());
        for (mine, q) in self.joints.iter_mut().zip(joints).skip(1) {
            mine.rotation.set_lane(index, q.normalize());
        }
    }

    /// Sets the velocity of lane `index`: root linear and angular (world axes), and the angular velocity of each joint
    /// (child axes; entry 0 unused).
    pub fn set_velocity(&mut self, index: usize, linear: DVec3, angular: DVec3, joints: &[DVec3]) {
        self.root_velocity.linear.set_lane(index, linear);
        self.root_velocity.angular.set_lane(index, angular);
        for (mine, w) in self.joints.iter_mut().zip(joints).skip(1) {
            mine.velocity.set_lane(index, *w);
        }
    }

    /// True if every number of lane `index` is finite.
    pub fn is_finite(&self, index: usize) -> bool {
        self.root_position.lane(index).is_finite()
            && self.root_rotation.lane(index).is_finite()
            && self.root_velocity.angular.lane(index).is_finite()
            && self.root_velocity.linear.lane(index).is_finite()
            && self.joints.iter().all(|j| j.rotation.lane(index).is_finite() && j.velocity.lane(index).is_finite())
    }

    /// A hash over every bit of lane `index`: equal states have equal fingerprints.
    pub fn fingerprint(&self, index: usize) -> u64 {
        // FNV-1a, 64 bit.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut eat = |v: DVec3| {
            for x in v.to_array() {
                // Adding zero turns -0 into 0: the two are the same number.
                for byte in (x + 0.0).to_bits().to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
                }
            }
        };
        let eat_rotation = |eat: &mut dyn FnMut(DVec3), q: DQuat| {
            eat(q.xyz());
            eat(DVec3::new(q.w, 0.0, 0.0));
        };
        eat(self.root_position.lane(index));
        eat_rotation(&mut eat, self.root_rotation.lane(index));
        eat(self.root_velocity.angular.lane(index));
        eat(self.root_velocity.linear.lane(index));
        for joint in &self.joints {
            eat_rotation(&mut eat, joint.rotation.lane(index));
            eat(joint.velocity.lane(index));
        }
        for impulse in self.contact_impulses.iter().chain(&self.grip_impulses) {
            eat(impulse.lane(index));
        }
        for (number, grip) in self.grips.iter().enumerate().filter(|(_, g)| g.anchor(index).is_some()) {
            let (numbers, place) = grip.numbers(index);
            eat(DVec3::X * number as f64);
            eat(numbers);
            eat(place);
        }
        hash
    }
}
