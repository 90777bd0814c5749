//! Whether a motion can be right for a body: what a wrong map makes of it.
//!
//! A map with a wrong rest pose gives a motion that can be simulated, and looks like nothing a person does: arms crossed in
//! the trunk, knees that bend forwards, a figure on its head. [`check_motion`] measures such things over the whole clip, in
//! the pelvis' frame; what a person may do for a moment is no sign, what lasts for most of the clip is.

use super::find_map::{Limb, Roles, Tree, find_roles, leg_length};
use super::{CharacterModel, LinkTransform, Shape};
use crate::asset::bvh::Bvh;
use crate::asset::clip::MotionClip;
use crate::asset::joint_map::{Fit, JointMap};
use glam::DVec3;
use std::fmt;

/// Something about a motion that cannot be right, or hardly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MotionWarning {
    /// A limb is on the other side of the body for most of the clip.
    Crossed {
        /// The joint that is on the wrong side.
        joint: String,
        /// Part of the poses in which it is.
        share: f64,
    },
    /// A hand is inside the trunk for most of the clip.
    InTrunk {
        /// The joint at its end.
        joint: String,
        /// Part of the poses in which it is.
        share: f64,
    },
    /// A joint is far outside of its range for most of the clip.
    OutOfRange {
        /// The joint.
        joint: String,
        /// Middle of how far it is outside, degrees.
        degrees: f64,
        /// Part of the poses in which it is.
        share: f64,
    },
    /// The source is no size of a body, but the map fits lengths to the character's.
    Size {
        /// Length of a leg by the map's unit, m.
        leg: f64,
    },
}

/// Why a motion was refused: no body moves so.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionRefusal {
    /// Upside down for the whole clip.
    #[error(
        "`{foot}` is above `{head}` in {:.0} % of the poses: up is wrong, or the rest pose; see `up`, `facing` and `rest_degrees` in docs/book/motions.md",
        100.0 * share
    )]
    UpsideDown {
        /// A foot.
        foot: String,
        /// The head or the topmost link.
        head: String,
        /// Part of the poses.
        share: f64,
    },
    /// The source is no size of a body.
    #[error(
        "the legs of the source are {leg:.3} m long by `unit` of the map; valid: {LEAST_LEG} to {MOST_LEG} m (a unit of centimetres is 0.01)"
    )]
    Size {
        /// Length of a leg, m.
        leg: f64,
    },
}

/// Shortest leg of a source, m: a doll's are shorter.
const LEAST_LEG: f64 = 0.15;
/// Longest leg of a source, m.
const MOST_LEG: f64 = 3.0;
/// Part of the poses from which something lasts.
const MOST: f64 = 0.6;
/// Part of the poses from which a body counts as upside down.
const ALWAYS: f64 = 0.9;
/// How far a joint may be outside of its range, degrees. Captured people reach farther than characters.
const RANGE_SLACK: f64 = 30.0;

impl fmt::Display for MotionWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MotionWarning::Crossed { joint, share } => {
                write!(f, "`{joint}` is on the other side of the body in {:.0} % of the poses", 100.0 * share)
            }
            MotionWarning::InTrunk { joint, share } => {
                write!(f, "the end of `{joint}` is inside the trunk in {:.0} % of the poses", 100.0 * share)
            }
            MotionWarning::OutOfRange { joint, degrees, share } => write!(
                f,
                "`{joint}` is {degrees:.0} degrees outside of its range in {:.0} % of the poses",
                100.0 * share
            ),
            MotionWarning::Size { leg } => write!(
                f,
                "the legs of the source are {leg:.3} m long by `unit` of the map; lengths were fitted to the character's"
            ),
        }
    }
}

/// Whether the source is of a person's size by the unit of a map: a body of 30 m is a wrong unit. Where the map fits lengths by
/// the legs, the unit falls out, and a wrong one is a warning only. Skeletons that are not recognised are not judged.
pub fn check_size(bvh: &Bvh, map: &JointMap) -> Result<Option<MotionWarning>, MotionRefusal> {
    let factor = if let Fit::Factor(factor) = map.fit { factor } else { 1.0 };
    let Some(leg) = leg_length(bvh).map(|leg| leg * map.unit * factor) else { return Ok(None) };
    match map.fit {
        _ if (LEAST_LEG..=MOST_LEG).contains(&leg) => Ok(None),
        Fit::Legs { .. } => Ok(Some(MotionWarning::Size { leg })),
        Fit::None | Fit::Factor(_) => Err(MotionRefusal::Size { leg }),
    }
}

/// Whether a link frame's point is inside a shape.
fn inside(shape: &Shape, p: DVec3) -> bool {
    match *shape {
        Shape::Sphere { center, radius } => p.distance(center) < radius,
        Shape::Capsule { a, b, radius } => {
            let along = b - a;
            let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            p.distance(a + along * t) < radius
        }
        Shape::Box { center, half_extents, rotation } => {
            (rotation.conjugate() * (p - center)).abs().cmplt(half_extents).all()
        }
    }
}

struct Check<'a> {
    model: &'a CharacterModel,
    roles: Roles,
    /// Places of all links, pose by pose.
    poses: Vec<Vec<LinkTransform>>,
}

/// Looks for what cannot be right in a motion of a character. Characters without legs that can be recognised are not judged.
pub fn check_motion(clip: &MotionClip, model: &CharacterModel) -> Result<Vec<MotionWarning>, MotionRefusal> {
    let Ok(fitted) = clip.to_model(model) else { return Ok(Vec::new()) };
    let tree = Tree {
        names: model.links.iter().map(|l| l.name.clone()).collect(),
        parents: model.links.iter().map(|l| l.parent).collect(),
        lengths: model.links.iter().map(|l| l.offset.length()).collect(),
        ends: model.links.iter().map(|l| 2.0 * l.com.length()).collect(),
    };
    let Ok(roles) = find_roles(&tree) else { return Ok(Vec::new()) };
    let every = (fitted.poses().len() / 500).max(1);
    let poses = fitted.poses().iter().step_by(every).map(|pose| {
        let mut places = Vec::new();
        pose.link_transforms(model, &mut places);
        places
    });
    let check = Check { model, roles, poses: poses.collect() };
    check.upside_down()?;
    let mut warnings = Vec::new();
    check.crossed(&mut warnings);
    check.in_trunk(&mut warnings);
    let joints: Vec<_> = fitted.poses().iter().step_by(every).map(|pose| &pose.joints).collect();
    for (link, own) in model.links.iter().enumerate().skip(1) {
        let Some(limits) = own.limits else { continue };
        let mut beyond: Vec<f64> = joints
            .iter()
            .map(|joints| {
                let v = crate::asset::turn::rotation_vector(joints[link]);
                (limits.low - v).max(v - limits.high).max(DVec3::ZERO).length().to_degrees()
            })
            .filter(|d| *d > RANGE_SLACK)
            .collect();
        beyond.sort_by(f64::total_cmp);
        let share = beyond.len() as f64 / joints.len() as f64;
        if share > MOST {
            let (joint, degrees) = (own.name.clone(), beyond[beyond.len() / 2]);
            warnings.push(MotionWarning::OutOfRange { joint, degrees, share });
        }
    }
    Ok(warnings)
}

impl Check<'_> {
    fn name(&self, link: usize) -> String {
        self.model.links[link].name.clone()
    }

    /// Part of the poses for which something holds.
    fn share(&self, holds: impl Fn(&[LinkTransform]) -> bool) -> f64 {
        self.poses.iter().filter(|p| holds(p)).count() as f64 / self.poses.len() as f64
    }

    fn upside_down(&self) -> Result<(), MotionRefusal> {
        let Some(&head) = self.roles.neck.last().or(self.roles.trunk.last()) else { return Ok(()) };
        for leg in &self.roles.legs {
            let foot = leg.end.unwrap_or(leg.lower);
            let share = self.share(|p| p[foot].position.y > p[head].position.y);
            if share > ALWAYS && self.poses.len() > 1 {
                return Err(MotionRefusal::UpsideDown { foot: self.name(foot), head: self.name(head), share });
            }
        }
        Ok(())
    }

    /// End of a limb's last link: its end joint, or as far beyond the centre of mass.
    fn tip(&self, limb: &Limb) -> (usize, DVec3) {
        match limb.end {
            Some(end) => (end, DVec3::ZERO),
            None => (limb.lower, 2.0 * self.model.links[limb.lower].com),
        }
    }

    fn crossed(&self, warnings: &mut Vec<MotionWarning>) {
        let arms = self.roles.arms.iter().flatten();
        let limbs: Vec<&Limb> = self.roles.legs.iter().chain(arms).collect();
        for (index, &limb) in limbs.iter().enumerate() {
            // The two of a pair stand side by side.
            let other = limbs[index ^ 1];
            let ((link, tip), (other_link, other_tip)) = (self.tip(limb), self.tip(other));
            // Across the body, by the upper joints, and beyond the other limb's end.
            let share = self.share(|p| {
                let across = (p[limb.upper].position - p[other.upper].position).normalize_or_zero();
                let middle = (p[limb.upper].position + p[other.upper].position) / 2.0;
                let place = |link: usize, tip: DVec3| p[link].position + p[link].rotation * tip;
                let (here, there) = (place(link, tip), place(other_link, other_tip));
                (here - middle).dot(across) < -0.03 && (here - there).dot(across) < -0.06
            });
            if share > MOST {
                warnings.push(MotionWarning::Crossed { joint: self.name(link), share });
            }
        }
    }

    fn in_trunk(&self, warnings: &mut Vec<MotionWarning>) {
        let trunk: Vec<usize> = std::iter::once(self.roles.pelvis).chain(self.roles.trunk.iter().copied()).collect();
        for arm in self.roles.arms.iter().flatten() {
            let (link, tip) = self.tip(arm);
            let share = self.share(|p| {
                let end = p[link].position + p[link].rotation * tip;
                trunk.iter().any(|&t| {
                    let local = p[t].rotation.conjugate() * (end - p[t].position);
                    self.model.links[t].shapes.iter().any(|shape| inside(shape, local))
                })
            });
            if share > MOST {
                warnings.push(MotionWarning::InTrunk { joint: self.name(link), share });
            }
        }
    }
}
