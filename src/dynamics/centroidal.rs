//! The centroidal momentum map: what each degree of freedom adds to the momentum of the whole body.
//!
//! Orin, Goswami, Lee 2013, "Centroidal dynamics of a humanoid robot". With v the generalised velocity,
//!
//! ```text
//! h = A v               momentum about the centre of mass (equation 1)
//! h' = A v' + A' v      and its change by outside forces
//! ```
//!
//! Column j of A is the momentum of the subtree that degree of freedom j moves, at unit rate, seen from the centre of mass: the
//! composite inertia of the subtree times the motion (their Section 4.1). `A' v` is the change of momentum while no generalised
//! velocity changes; it is summed over the links from the accelerations that they have then.

use crate::dynamics::generalized::joint_axes;
use crate::dynamics::{LinkConstants, LinkKinematics, degrees_of_freedom};
use crate::math::{Force, Inertia, Mat3, Motion, Real, Sym3, Vec3};
use glam::DVec3;

/// A and A' v of one character (or one in each lane), with the room to work them out in. [`CentroidalMap::update`] allocates
/// nothing.
#[derive(Clone, Debug)]
pub struct CentroidalMap<R> {
    columns: Vec<Force<R>>,
    rate: Force<R>,
    /// Inertia of each link with all that hangs on it, about the link's origin.
    composite: Vec<Inertia<R>>,
    /// Acceleration of each link's origin while no generalised velocity changes.
    coasting: Vec<Motion<R>>,
}

impl<R: Real> CentroidalMap<R> {
    /// Room for a character with these links; all zero until the first update.
    pub fn new(constants: &[LinkConstants<R>]) -> Self {
        Self {
            columns: vec![Force::zero(); degrees_of_freedom(constants)],
            rate: Force::zero(),
            composite: vec![Inertia::default(); constants.len()],
            coasting: vec![Motion::zero(); constants.len()],
        }
    }

    /// A, column by column, in the order of the module's conventions: angular momentum about the centre of mass (kg m^2/s, world
    /// axes; field `moment`) and linear momentum (kg m/s; field `force`) for each unit of the generalised velocity.
    pub fn columns(&self) -> &[Force<R>] {
        &self.columns
    }

    /// A' v: change of the momentum about the centre of mass (N m; field `moment`) and of the linear momentum (N; field `force`)
    /// while no generalised velocity changes, world axes.
    pub fn rate(&self) -> Force<R> {
        self.rate
    }

    /// A times a generalised velocity: the momentum, as in [`CentroidalMap::columns`].
    pub fn momentum(&self, velocity: &[R]) -> Force<R> {
        let mut h = Force::zero();
        for (column, v) in self.columns.iter().zip(velocity) {
            h.moment = column.moment.mul_add(*v, h.moment);
            h.force = column.force.mul_add(*v, h.force);
        }
        h
    }

    /// Works both out for links that are where `kinematics` says and move so; `com` is the centre of mass relative to the root's
    /// origin, m (see [`totals`](crate::dynamics::totals)).
    pub fn update(&mut self, constants: &[LinkConstants<R>], kinematics: &[LinkKinematics<R>], com: Vec3<R>) {
        self.gather_inertias(constants, kinematics);
        let mut columns = self.columns.iter_mut();
        let mut write = |link: usize, motion: Motion<R>, composite: &Inertia<R>| {
            if let Some(place) = columns.next() {
                *place = composite.mul_motion(&motion).shifted(kinematics[link].origin - com);
            }
        };
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            write(0, Motion { angular: Vec3::zero(), linear: Vec3::splat(axis) }, &self.composite[0]);
        }
        for (i, c) in constants.iter().enumerate() {
            let (axes, count) = joint_axes(c);
            for axis in &axes[..count] {
                let angular = kinematics[i].rotation.mul_vec(*axis);
                write(i, Motion { angular, linear: Vec3::zero() }, &self.composite[i]);
            }
        }
        self.rate = self.coasting_rate(constants, kinematics, com);
    }

    /// Composite inertias, leaves to root.
    fn gather_inertias(&mut self, constants: &[LinkConstants<R>], kinematics: &[LinkKinematics<R>]) {
        for ((composite, c), k) in self.composite.iter_mut().zip(constants).zip(kinematics) {
            *composite = Inertia {
                angular: k.inertia_com + Sym3::parallel_axis(c.mass, k.com),
                coupling: Mat3::skew(k.com * c.mass),
                linear: Sym3::diagonal(c.mass),
            };
        }
        for i in (1..constants.len()).rev() {
            let d = kinematics[i].from_parent;
            let Inertia { angular, coupling, linear } = self.composite[i];
            let shifted = coupling.add_cross_columns(d, &linear);
            let seen =
                Inertia { angular: angular.add_skew_products(d, &coupling, &shifted), coupling: shifted, linear };
            let parent = &mut self.composite[constants[i].parent];
            *parent = *parent + seen;
        }
    }

    /// Sum of `(c - com) x m a + I alpha + w x I w` and of `m a`, root to leaves.
    fn coasting_rate(
        &mut self,
        constants: &[LinkConstants<R>],
        kinematics: &[LinkKinematics<R>],
        com: Vec3<R>,
    ) -> Force<R> {
        let mut rate = Force::zero();
        for (i, (c, k)) in constants.iter().zip(kinematics).enumerate() {
            let coasting = if i == 0 {
                Motion::zero()
            } else {
                let (parent, omega) = (self.coasting[c.parent], kinematics[c.parent].velocity.angular);
                Motion {
                    angular: omega.cross_add(k.joint_velocity, parent.angular),
                    linear: omega.cross_add(omega.cross(k.from_parent), parent.at(k.from_parent)),
                }
            };
            self.coasting[i] = coasting;
            let omega = k.velocity.angular;
            let force = omega.cross_add(omega.cross(k.com), coasting.at(k.com)) * c.mass;
            let spin = omega.cross_add(k.inertia_com.mul_vec(omega), k.inertia_com.mul_vec(coasting.angular));
            rate += Force { moment: (k.origin + k.com - com).cross_add(force, spin), force };
        }
        rate
    }
}
