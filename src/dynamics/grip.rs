//! What the grips of a character hold on to.

use crate::math::{Real, Vec3};
use glam::DVec3;

/// What a grip holds on to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripAnchor {
    /// A place that stays where it is, world frame, m.
    Fixed(DVec3),
    /// A place on a solid of the terrain, in the solid's frame, m: it goes where the solid goes.
    Solid {
        /// Number of the solid, as the terrain counts them; below [`GripAnchor::MOST_SOLIDS`].
        solid: usize,
        /// The place, frame of the solid, m.
        place: DVec3,
    },
}

impl GripAnchor {
    /// Solids that can be told apart in the lanes of every precision.
    pub const MOST_SOLIDS: usize = 1 << 24;
}

/// A grip: open, or closed about something, in each lane.
#[derive(Clone, Copy, Debug)]
pub struct GripState<R> {
    /// One where it is closed, else zero.
    closed: R,
    /// Number of the solid and one more; zero for a fixed place.
    solid: R,
    /// Where it holds on, world frame or that of the solid, m.
    place: Vec3<R>,
    /// The least distance between grip and anchor since it closed, m: what it slips is counted from here.
    nearest: R,
}

impl<R: Real> Default for GripState<R> {
    fn default() -> Self {
        Self { closed: R::zero(), solid: R::zero(), place: Vec3::zero(), nearest: R::zero() }
    }
}

impl<R: Real> GripState<R> {
    /// Farther than anything that a grip reaches, m.
    const FAR: f64 = 1e9;

    /// Closes it in lane `lane`.
    pub fn hold(&mut self, lane: usize, anchor: GripAnchor) {
        let (solid, place) = match anchor {
            GripAnchor::Fixed(place) => (0, place),
            GripAnchor::Solid { solid, place } => (solid.min(GripAnchor::MOST_SOLIDS - 1) + 1, place),
        };
        self.closed.set_lane(lane, 1.0);
        self.solid.set_lane(lane, solid as f64);
        self.place.set_lane(lane, place);
        self.nearest.set_lane(lane, Self::FAR);
    }

    /// Opens it in lane `lane`.
    pub fn release(&mut self, lane: usize) {
        self.closed.set_lane(lane, 0.0);
        self.solid.set_lane(lane, 0.0);
        self.place.set_lane(lane, DVec3::ZERO);
        self.nearest.set_lane(lane, 0.0);
    }

    /// Lanes in which it is closed.
    #[inline]
    pub fn closed(&self) -> R::Mask {
        R::zero().lt(self.closed)
    }

    /// True if it is open in every lane.
    #[inline]
    pub fn is_open(&self) -> bool {
        !R::any(self.closed())
    }

    /// What it holds on to in lane `lane`; `None` where it is open.
    pub fn anchor(&self, lane: usize) -> Option<GripAnchor> {
        let place = self.place.lane(lane);
        R::mask_lane(self.closed(), lane).then(|| match self.solid.lane(lane) as usize {
            0 => GripAnchor::Fixed(place),
            solid => GripAnchor::Solid { solid: solid - 1, place },
        })
    }

    /// Lanes in which it holds on to a solid.
    #[inline]
    pub(crate) fn on_solids(&self) -> R::Mask {
        R::zero().lt(self.solid)
    }

    /// The places, world frame where they are fixed, m.
    #[inline]
    pub(crate) fn place(&self) -> Vec3<R> {
        self.place
    }

    /// Takes note of the distance to its anchor (m); returns by how much it has slipped, m.
    #[inline]
    pub(crate) fn slip(&mut self, distance: R) -> R {
        self.nearest = self.nearest.min(distance);
        distance - self.nearest
    }

    /// Takes over lane `from` of another.
    pub fn copy_lane<S: Real>(&mut self, to: usize, other: &GripState<S>, from: usize) {
        self.closed.set_lane(to, other.closed.lane(from));
        self.solid.set_lane(to, other.solid.lane(from));
        self.place.set_lane(to, other.place.lane(from));
        self.nearest.set_lane(to, other.nearest.lane(from));
    }

    /// The numbers of lane `lane`: closed, solid, nearest distance (m); and the place (m).
    pub(crate) fn numbers(&self, lane: usize) -> (DVec3, DVec3) {
        let numbers = DVec3::new(self.closed.lane(lane), self.solid.lane(lane), self.nearest.lane(lane));
        (numbers, self.place.lane(lane))
    }

    /// The least distance so far in lane `lane`, m; of use where it is closed.
    pub fn nearest(&self, lane: usize) -> f64 {
        self.nearest.lane(lane)
    }

    /// Sets the least distance so far in lane `lane`, m: for restoring a snapshot after [`GripState::hold`].
    pub fn set_nearest(&mut self, lane: usize, nearest: f64) {
        self.nearest.set_lane(lane, nearest);
    }
}
