//! What a character can touch: a signed distance with a normal, a velocity and what the surface is made of; and the heights
//! of what it can step on.

use crate::asset::Material;
use crate::contact::ContactCandidate;
use crate::math::{Real, Sym3, Vec3};
use glam::DVec3;

/// The answer of a [`Terrain`] for one point.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit<R: Real> {
    /// Signed distance, m; negative inside.
    pub distance: R,
    /// Outward unit normal.
    pub normal: Vec3<R>,
    /// Velocity of the surface there, world axes, m/s.
    pub velocity: Vec3<R>,
    /// Coulomb coefficient.
    pub friction: R,
    /// True where blades act as knife edges, as on ice.
    pub carves: R::Mask,
    /// True where hands can hold on.
    pub grippable: R::Mask,
}

impl<R: Real> SurfaceHit<R> {
    /// Nothing anywhere near: 1e9 m away.
    #[inline]
    pub fn nothing() -> Self {
        let zero = R::zero();
        let none = zero.lt(zero);
        Self {
            distance: R::splat(1e9),
            normal: Vec3::splat(DVec3::Y),
            velocity: Vec3::zero(),
            friction: zero,
            carves: none,
            grippable: none,
        }
    }

    /// `other` where the mask holds, else `self`.
    #[inline]
    pub fn replaced(&self, mask: R::Mask, other: &Self) -> Self {
        Self {
            distance: R::select(mask, other.distance, self.distance),
            normal: Vec3::select(mask, other.normal, self.normal),
            velocity: Vec3::select(mask, other.velocity, self.velocity),
            friction: R::select(mask, other.friction, self.friction),
            carves: (self.carves & !mask) | (other.carves & mask),
            grippable: (self.grippable & !mask) | (other.grippable & mask),
        }
    }
}

/// What could be stood on at a place: the top of a vertical line's topmost solid.
#[derive(Clone, Copy, Debug)]
pub struct SupportHit<R: Real> {
    /// Height of the surface, world frame, m; [`SupportHit::BOTTOMLESS`] where there is none.
    pub height: R,
    /// Outward unit normal there.
    pub normal: Vec3<R>,
    /// Velocity of the surface there, world axes, m/s.
    pub velocity: Vec3<R>,
    /// True where there is one.
    pub found: R::Mask,
}

impl<R: Real> SupportHit<R> {
    /// The height told where there is nothing below, m.
    pub const BOTTOMLESS: f64 = -1e9;

    /// No surface.
    #[inline]
    pub fn nothing() -> Self {
        let zero = R::zero();
        Self {
            height: R::splat(Self::BOTTOMLESS),
            normal: Vec3::splat(DVec3::Y),
            velocity: Vec3::zero(),
            found: zero.lt(zero),
        }
    }

    /// The higher of two.
    #[inline]
    pub fn higher(&self, other: &Self) -> Self {
        let mask = other.found & self.height.lt(other.height);
        Self {
            height: R::select(mask, other.height, self.height),
            normal: Vec3::select(mask, other.normal, self.normal),
            velocity: Vec3::select(mask, other.velocity, self.velocity),
            found: self.found | mask,
        }
    }
}

/// A place that a grip holds on to, as it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnchorMotion {
    /// Where it is, world frame, m.
    pub place: DVec3,
    /// How it moves, world axes, m/s.
    pub velocity: DVec3,
}

/// A solid that begins so little above a point still counts as a support of it, m: a sole that has sunk in a little, a low
/// sill under the toes.
pub const STEP_UP: f64 = 0.05;

/// Anything that a character can touch.
pub trait Terrain<R: Real> {
    /// The surface nearest to `point` (world frame, m).
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R>;

    /// A lower bound of the distance from `point` to anything, m: nothing within this distance of the point is inside a
    /// surface. The links that it clears are not asked further. To be overridden where `query` may overstate.
    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        self.query(point).distance
    }

    /// `query` on behalf of contact point `index` of the character. A terrain of several things overrides it to remember
    /// which of them the point is on.
    #[inline]
    fn query_contact(&self, index: usize, point: Vec3<R>) -> SurfaceHit<R> {
        let _ = index;
        self.query(point)
    }

    /// What could be stood on in the vertical line through `point` (world frame, m): the highest top among the solids that
    /// begin at most [`STEP_UP`] above the point. What hangs higher is overhead and does not count; a solid that the point lies
    /// in does, by its top, so a wall ahead is as high as it is. Level ground at y = 0 gives exactly 0.
    ///
    /// A terrain that knows no better finds it by sphere tracing with `query`: to 1 mm, within 100 m, and of solids that overlap
    /// only as well as their distances tell them apart.
    #[inline]
    fn height(&self, point: Vec3<R>) -> SupportHit<R> {
        traced_height(self, point)
    }

    /// Heights ahead: `out[k]` is that of `height` at `origin` moved by `distances[k]` (m) along `heading` (horizontal, unit).
    /// As long as the shorter of the two slices.
    fn scan(&self, origin: Vec3<R>, heading: Vec3<R>, distances: &[f64], out: &mut [R]) {
        for (distance, height) in distances.iter().zip(out) {
            *height = self.height(origin + heading * R::splat(*distance)).height;
        }
    }

    /// Where the place `place` (frame of the solid, m) of solid number `solid` is, for a character in lane `lane`; `None` if there is
    /// no such solid: then a grip that held on to it opens.
    fn anchor(&self, lane: usize, solid: usize, place: DVec3) -> Option<AnchorMotion> {
        let _ = (lane, solid, place);
        None
    }

    /// What the surface nearest to `point` (world frame, m) is made of in lane `lane`, for sounds and tracks: asked now and then, never in a step. A terrain
    /// that knows no better tells ice, what can be held on to, and ground apart.
    fn material(&self, lane: usize, point: DVec3) -> Material {
        let hit = self.query(Vec3::splat(point));
        match (R::mask_lane(hit.carves, lane), R::mask_lane(hit.grippable, lane)) {
            (true, _) => Material::ICE,
            (false, true) => Material::RAIL,
            (false, false) => Material::GROUND,
        }
    }

    /// True if something in it may give way; then `surface_inverse_mass` is asked in every step with contact.
    #[inline]
    fn is_compliant(&self) -> bool {
        false
    }

    /// How the surface under each candidate gives way: `out[k]` is the velocity there per impulse on it, world axes, 1/kg;
    /// zero where it does not move. `root` is what the candidates' places are relative to (world frame, m). Of a candidate
    /// only the source, the place and the normal (`directions[0]`) are known yet; grips are among them, and theirs is not used.
    #[inline]
    fn surface_inverse_mass(&self, root: Vec3<R>, candidates: &[ContactCandidate<R>], out: &mut [Sym3<R>]) {
        let _ = (root, candidates);
        out.fill(Sym3::zero());
    }
}

impl<R: Real, T: Terrain<R>> Terrain<R> for &T {
    #[inline]
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        T::query(self, point)
    }
    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        T::clearance(self, point)
    }
    #[inline]
    fn query_contact(&self, index: usize, point: Vec3<R>) -> SurfaceHit<R> {
        T::query_contact(self, index, point)
    }
    #[inline]
    fn height(&self, point: Vec3<R>) -> SupportHit<R> {
        T::height(self, point)
    }
    fn anchor(&self, lane: usize, solid: usize, place: DVec3) -> Option<AnchorMotion> {
        T::anchor(self, lane, solid, place)
    }
    fn material(&self, lane: usize, point: DVec3) -> Material {
        T::material(self, lane, point)
    }
    #[inline]
    fn is_compliant(&self) -> bool {
        T::is_compliant(self)
    }
    #[inline]
    fn surface_inverse_mass(&self, root: Vec3<R>, candidates: &[ContactCandidate<R>], out: &mut [Sym3<R>]) {
        T::surface_inverse_mass(self, root, candidates, out);
    }
}

/// Sphere tracing (Hart 1996, "Sphere tracing: a geometric method for the antialiased ray tracing of implicit surfaces") along
/// the vertical: down from [`STEP_UP`] above the point, or up to where the solid that the start lies in ends.
fn traced_height<R: Real, T: Terrain<R> + ?Sized>(terrain: &T, point: Vec3<R>) -> SupportHit<R> {
    /// Distance at which a surface is reached, m.
    const REACHED: f64 = 5e-4;
    /// Longest way, m.
    const FAR: f64 = 100.0;
    /// Most steps.
    const STEPS: usize = 256;
    let zero = R::zero();
    let start = point.y + R::splat(STEP_UP);
    let mut at = Vec3::new(point.x, start, point.z);
    let mut hit = terrain.query(at);
    let inside = hit.distance.lt(zero);
    let mut found = zero.lt(zero);
    let far = R::splat(FAR);
    for _ in 0..STEPS {
        let distance = hit.distance;
        // From inside, the first place that is not; from outside, the first that is as good as on the surface.
        let reached =
            (inside & !distance.lt(zero)) | (!inside & distance.lt(R::splat(REACHED))) & (at.y - start).abs().lt(far);
        found = found | reached;
        let going = !found & (at.y - start).abs().lt(far);
        if !R::any(going) {
            break;
        }
        // Down by the distance; up by the depth, and a little to get out.
        let step = R::select(inside, distance.abs() + R::splat(REACHED), -distance);
        at.y = R::select(going, at.y + step, at.y);
        hit = terrain.query(at);
    }
    // Onto the surface along its own slope.
    let steep = hit.normal.y.max(R::splat(0.1));
    let height = at.y - hit.distance / steep;
    let nothing = SupportHit::nothing();
    SupportHit {
        height: R::select(found, height, nothing.height),
        normal: Vec3::select(found, hit.normal, nothing.normal),
        velocity: Vec3::select(found, hit.velocity, nothing.velocity),
        found,
    }
}
