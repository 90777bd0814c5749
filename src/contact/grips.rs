//! Grips before they are solved: where their anchors are, whether they may pull, and which of them have slipped open.
//!
//! A closed grip whose anchor lies on a surface that a hand can close about (`SurfaceHit::grippable`), or away from any
//! surface, pulls and pushes with a force of up to its `max_force` in any direction. On any other surface it pushes and rubs
//! only: it is an ordinary contact point.

use crate::contact::{SurfaceHit, Terrain};
use crate::dynamics::{GripAnchor, GripState, LinkKinematics};
use crate::math::{Real, Vec3};
use crate::model::CharacterModel;
use glam::DVec3;

/// An anchor nearer to a surface than this lies on it, m: about the breadth of a palm.
const ON_SURFACE: f64 = 0.05;
/// Part of the largest force from which on a grip counts as giving all it has.
const AT_LIMIT: f64 = 0.999;

/// A grip and its anchor before it is known whether it takes part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GripProbe<R: Real> {
    /// Lanes in which it takes part.
    pub active: R::Mask,
    /// Lanes in which it pulls as well.
    pub pulls: R::Mask,
    /// From the grip to its anchor, world axes, m.
    pub to_anchor: Vec3<R>,
    /// Velocity of the anchor, world axes, m/s.
    pub velocity: Vec3<R>,
    /// The surface at the grip; of use where it only pushes.
    pub hit: SurfaceHit<R>,
    /// The grip relative to its link's origin, world axes, m.
    pub arm: Vec3<R>,
    /// Lanes in which it slipped open at the start of this step.
    pub slipped: R::Mask,
}

impl<R: Real> GripProbe<R> {
    /// Open.
    pub fn open() -> Self {
        let none = R::zero().lt(R::zero());
        Self {
            active: none,
            pulls: none,
            to_anchor: Vec3::zero(),
            velocity: Vec3::zero(),
            hit: SurfaceHit::nothing(),
            arm: Vec3::zero(),
            slipped: none,
        }
    }
}

/// The grips of a character, which may open while contacts are looked for.
#[derive(Debug)]
pub struct GripInputs<'a, R> {
    /// What they hold on to.
    pub states: &'a mut [GripState<R>],
    /// Their impulses of the last step, world axes, N s.
    pub impulses: &'a mut [Vec3<R>],
}

/// Looks at every closed grip; returns true if any takes part. Those that have slid along by more than `most_slip` (m) while they
/// gave all they have, and those whose solid is gone, are opened. One that only pushes takes part within `margin` (m) of the
/// surface. `h` is the length of a step, s.
pub(crate) fn probe_grips<R: Real>(
    model: &CharacterModel,
    kinematics: &[LinkKinematics<R>],
    root_position: Vec3<R>,
    terrain: &impl Terrain<R>,
    (margin, most_slip, h): (f64, f64, f64),
    grips: GripInputs<R>,
    probes: &mut [GripProbe<R>],
) -> bool {
    let GripInputs { states, impulses } = grips;
    let none = R::zero().lt(R::zero());
    let mut any = false;
    for (g, grip) in model.grips.iter().enumerate() {
        let (state, probe) = (&mut states[g], &mut probes[g]);
        let closed = state.closed();
        if !R::any(closed) {
            (probe.active, probe.slipped) = (none, none);
            continue;
        }
        let k = &kinematics[grip.link];
        let arm = k.rotation.mul_vec(Vec3::splat(grip.position));
        let point = root_position + k.origin + arm;
        let (anchor, velocity, lost) = anchors(state, terrain);

        // Slipped: it gave all it has, and yet went farther from its anchor than it was.
        let to_anchor = anchor - point;
        let slip = state.slip(to_anchor.length());
        let most = R::splat(AT_LIMIT * grip.max_force * h);
        let torn = !impulses[g].length_squared().lt(most * most) & R::splat(most_slip).lt(slip);

        // What the anchor lies on says whether a hand can pull there.
        let surface = terrain.query(anchor);
        let pulls = surface.grippable | !surface.distance.lt(R::splat(ON_SURFACE));
        let slipped = closed & (lost | (torn & pulls));
        if R::any(slipped) {
            for lane in (0..R::LANES).filter(|&lane| R::mask_lane(slipped, lane)) {
                state.release(lane);
                impulses[g].set_lane(lane, DVec3::ZERO);
            }
        }
        let held = closed & !slipped;
        let mut active = held & pulls;
        if R::any(held & !pulls) {
            probe.hit = terrain.query(point);
            active = active | (held & probe.hit.distance.lt(R::splat(margin)));
        }
        (probe.active, probe.pulls, probe.slipped) = (active, pulls, slipped);
        (probe.to_anchor, probe.velocity, probe.arm) = (to_anchor, velocity, arm);
        any = any || R::any(active);
    }
    any
}

/// Where the anchors of a grip are (world frame, m) and how they move (m/s), and the lanes whose solid is gone.
fn anchors<R: Real>(state: &GripState<R>, terrain: &impl Terrain<R>) -> (Vec3<R>, Vec3<R>, R::Mask) {
    let none = R::zero().lt(R::zero());
    let (mut place, mut velocity, mut lost) = (state.place(), Vec3::zero(), R::zero());
    if !R::any(state.on_solids()) {
        return (place, velocity, none);
    }
    for lane in 0..R::LANES {
        if let Some(GripAnchor::Solid { solid, place: at }) = state.anchor(lane) {
            match terrain.anchor(lane, solid, at) {
                Some(motion) => {
                    place.set_lane(lane, motion.place);
                    velocity.set_lane(lane, motion.velocity);
                }
                None => lost.set_lane(lane, 1.0),
            }
        }
    }
    (place, velocity, R::zero().lt(lost))
}
