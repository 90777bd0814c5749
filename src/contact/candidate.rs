//! What takes part in the contact stages of a step: points, the links that they are on, clusters of links.

use crate::math::{Force, Motion, Real, Vec3};

/// A contact point or a closed grip that takes part in this step.
#[derive(Clone, Copy, Debug)]
pub struct ContactCandidate<R: Real> {
    /// Index of the contact point in the model; for a grip, of the grip.
    pub source: usize,
    /// True for a grip.
    pub is_grip: bool,
    /// True where the knife edge holds.
    pub blade: R::Mask,
    /// True where a grip pulls as well as it pushes.
    pub pulls: R::Mask,
    /// True where the point is within the margin, or the grip holds.
    pub active: R::Mask,
    /// The place of contact relative to the link's origin, world axes, m.
    pub arm: Vec3<R>,
    /// The place of contact relative to the root's origin at the start of the step, world axes, m.
    pub place: Vec3<R>,
    /// Row directions: normal and two tangents (along and across, for a blade), world axes.
    pub directions: [Vec3<R>; 3],
    /// Moment arms of the rows: `arm x direction`.
    pub moments: [Vec3<R>; 3],
    /// Velocity along each row that the solver aims at, m/s.
    pub bias_velocities: [R; 3],
    /// Motion of the link from a unit impulse along each row.
    pub responses: [Motion<R>; 3],
    /// Inverse effective masses `J_r . response_s`: 00, 11, 22, 01, 02, 12.
    pub coupling: [R; 6],
    /// `1 / coupling[r][r]`, zero in inactive lanes.
    pub effective_mass: [R; 3],
    /// Impulses along the rows, N s.
    pub impulses: [R; 3],
    /// Coulomb coefficient.
    pub friction: R,
    /// Index of the other end of the same blade among the candidates.
    pub partner: usize,
    /// Bite: largest lateral impulse over the blade's normal impulse.
    pub bite: R,
    /// Largest impulse of a grip that pulls, N s.
    pub grip_limit: R,
}

impl<R: Real> ContactCandidate<R> {
    /// No contact.
    pub(super) fn blank() -> Self {
        let none = R::zero().lt(R::zero());
        Self {
            source: 0,
            is_grip: false,
            blade: none,
            pulls: none,
            active: none,
            arm: Vec3::zero(),
            place: Vec3::zero(),
            directions: [Vec3::zero(); 3],
            moments: [Vec3::zero(); 3],
            bias_velocities: [R::zero(); 3],
            responses: [Motion::zero(); 3],
            coupling: [R::zero(); 6],
            effective_mass: [R::zero(); 3],
            impulses: [R::zero(); 3],
            friction: R::zero(),
            partner: 0,
            bite: R::zero(),
            grip_limit: R::zero(),
        }
    }

    /// The surface takes the opposite of impulses along the rows and gives way: what is aimed at goes with it.
    #[inline(always)]
    pub(crate) fn push_surface(&mut self, give: &[R; 6], d: &[R; 3]) {
        let [nn, tt, ss, nt, ns, ts] = *give;
        self.bias_velocities[0] -= nn * d[0] + nt * d[1] + ns * d[2];
        self.bias_velocities[1] -= nt * d[0] + tt * d[1] + ts * d[2];
        self.bias_velocities[2] -= ns * d[0] + ts * d[1] + ss * d[2];
    }

    /// Impulses along the rows of a grip that pulls, brought back to what it can hold by.
    #[inline(always)]
    pub(crate) fn within_grip(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        let squared = z.mul_add(z, y.mul_add(y, x * x)).max(R::splat(1e-30));
        let scale = (self.grip_limit / squared.sqrt()).min(R::one());
        [x * scale, y * scale, z * scale]
    }
    /// The impulse on the link, world axes, N s.
    #[inline(always)]
    pub fn impulse(&self) -> Vec3<R> {
        let [n, t, s] = self.directions;
        s.mul_add(self.impulses[2], t.mul_add(self.impulses[1], n * self.impulses[0]))
    }
}

/// The candidates of one link.
#[derive(Clone, Copy, Debug)]
pub struct ContactGroup<R> {
    /// Link index.
    pub link: usize,
    /// First candidate.
    pub start: usize,
    /// One past the last candidate.
    pub end: usize,
    /// Velocity of the link origin as the solver goes on.
    pub velocity: Motion<R>,
    /// Impulse wrench on the link about its origin, in all.
    pub wrench: Force<R>,
}

impl<R: Real> ContactGroup<R> {
    /// A group without candidates yet.
    pub fn on_link(link: usize) -> Self {
        Self { link, start: 0, end: 0, velocity: Motion::zero(), wrench: Force::zero() }
    }
}

/// The links in contact of one cluster (see [`ContactMobility`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactCluster<R> {
    /// Topmost link of the cluster.
    pub(super) hub: usize,
    /// First group.
    pub(super) start: usize,
    /// One past the last group.
    pub(super) end: usize,
    /// Motion of the hub, brought by other clusters, that the cluster's links have not yet heard of.
    pub(super) pending: Motion<R>,
}
