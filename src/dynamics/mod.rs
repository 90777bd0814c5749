//! Articulated rigid-body dynamics over lanes: kinematics, forward and inverse dynamics, momentum and energy.
//!
//! Conventions of this room: axes are those of the world; the reference point of every link quantity is the link's
//! joint; link origins are relative to the root's origin, so that single precision does not suffer far from the world's
//! origin. Generalised velocity, and everything dual to it, is ordered as MuJoCo and the papers have it: root linear
//! (world axes), root angular (root axes), then each joint in the axes of its child link.

mod articulated;
mod centroidal;
mod constants;
mod forward;
mod generalized;
mod grip;
mod inverse;
mod jacobian;
mod kinematics;
mod mass_matrix;
mod momentum;
mod servo;
mod state;

pub use articulated::{ArticulatedLink, articulated_inertias};
pub use centroidal::CentroidalMap;
pub use constants::{LinkConstants, PassiveSpring};
pub use forward::{contact_free_accelerations, forward_accelerations, integrate};
pub use generalized::{degrees_of_freedom, generalized_velocity};
pub use grip::{GripAnchor, GripState};
pub use inverse::{InverseDynamics, inverse_dynamics, inverse_dynamics_into};
pub use jacobian::{point_jacobian, point_jacobian_rate, point_velocity};
pub use kinematics::{LinkKinematics, update_positions, update_twists, update_velocities};
pub use mass_matrix::mass_matrix;
pub use momentum::{Momentum, Totals, correct_root, energy, momentum, totals};
pub use servo::{JointCommand, LimitSpring, ServoOutput, passive_torque, servo};
pub use state::{JointState, State};
