//! A joint map for a skeleton that nobody has described: [`find_map`] looks at names, shape and motion of a BVH file.
//!
//! 1. `joint_name.rs`, `skeleton.rs`: which joint is which part of the body, in the file and on the character;
//! 2. `rest_axes.rs`: how each link lies in its joint's axes, where the zero pose is one in which a person could stand;
//! 3. `motion_axes.rs`: the same from the motion, where it is not;
//! 4. `assemble.rs`: unit, up axis and sides, and the map that comes of it.
//!
//! What was found is an ordinary [`JointMap`]: it can be written to a file, corrected there and given instead.

mod assemble;
mod joint_name;
mod links;
mod motion_axes;
mod rest_axes;
mod skeleton;
mod source;

use crate::asset::joint_map::{JointMap, MapError};
use glam::DQuat;
use std::fmt;

pub use assemble::find_map;

/// Length of the left leg of a file's skeleton, file units; `None` where no legs were recognised.
pub(crate) fn leg_length(bvh: &crate::asset::bvh::Bvh) -> Option<f64> {
    source::Source::new(bvh).ok().map(|source| source.leg_length())
}
pub(crate) use skeleton::{Limb, Roles, Tree, find_roles};

/// How each part's link lies in its joint's axes: link axes to joint axes.
#[derive(Clone, Debug)]
struct Axes {
    pelvis: DQuat,
    trunk: Vec<DQuat>,
    neck: Vec<DQuat>,
    legs: [LimbAxes; 2],
    arms: Option<[LimbAxes; 2]>,
}

/// The same for a limb.
#[derive(Clone, Copy, Debug)]
struct LimbAxes {
    collar: DQuat,
    upper: DQuat,
    lower: DQuat,
    end: DQuat,
    toe: DQuat,
}

/// In what pose a skeleton stands when every rotation is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestPose {
    /// Arms out to the sides.
    T,
    /// Arms half-way down.
    A,
    /// Arms down.
    Hanging,
    /// No pose of a person: every joint has axes of its own.
    None,
}

/// One link and what it follows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapRow {
    /// The link.
    pub link: String,
    /// The joints, from the trunk outwards; the last one gives the orientation.
    pub joints: Vec<String>,
    /// The link's up in the last joint's axes, such as `+Y`.
    pub up: String,
    /// The link's facing in the last joint's axes.
    pub facing: String,
}

/// A map that was found, and what it was found by.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundMap {
    /// The map.
    pub map: JointMap,
    /// Name of the character it was found for.
    pub character: String,
    /// What each link follows, in the order of the map.
    pub rows: Vec<MapRow>,
    /// Joints that drive nothing, each with the reason.
    pub unmapped: Vec<(String, &'static str)>,
    /// The zero pose.
    pub rest: RestPose,
    /// Name of the unit of length, such as `cm`.
    pub unit: String,
    /// Length of the source's leg, m.
    pub leg: f64,
    /// What a person should know.
    pub warnings: Vec<MapWarning>,
}

/// Something that a person should know about a map that was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MapWarning {
    /// The names do not say left and right; toes and knees do.
    SidesByShape {
        /// The hip taken as the left one.
        left: String,
    },
    /// Names and toes disagree about left and right.
    SidesDisagree {
        /// The hip that is called left.
        left: String,
    },
    /// The figure stands along another axis in its motion than with all rotations zero.
    UpFromMotion {
        /// The axis in the motion.
        found: String,
        /// The axis of the zero pose.
        zero: String,
    },
    /// The file has no arms, or they were not found.
    NoArms,
    /// No usual unit makes a person of the skeleton.
    Unit {
        /// Length of a leg, file units.
        leg: f64,
        /// Metres in a unit that was taken.
        taken: f64,
    },
}

impl fmt::Display for MapWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MapWarning::SidesByShape { left } => {
                write!(f, "the names say no left and right; by toes and knees `{left}` is the left hip")
            }
            MapWarning::SidesDisagree { left } => write!(
                f,
                "`{left}` lies on the right of where the toes point; left and right were taken from the toes (a mirrored file?)"
            ),
            MapWarning::UpFromMotion { found, zero } => {
                write!(
                    f,
                    "the figure stands along {found} in its motion but along {zero} at zero; {found} was taken as up"
                )
            }
            MapWarning::NoArms => write!(f, "no arms were found; the character's hang"),
            MapWarning::Unit { leg, taken } => {
                write!(
                    f,
                    "a leg is {leg:.3} units long, which no usual unit makes a person's; 1 unit was taken as {taken:.4} m"
                )
            }
        }
    }
}

/// Why no map was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FindMapError {
    /// The file has no body that could be recognised.
    #[error(
        "no {missing} were recognised among {} (a map of your own: docs/book/motions.md, \"BVH and joint maps\")",
        some_names(joints)
    )]
    NotInFile {
        /// What was looked for.
        missing: &'static str,
        /// All joints of the file.
        joints: Vec<String>,
    },
    /// The character has none.
    #[error("character `{character}` has no {missing} that could be recognised among its links {}", links.join(", "))]
    NotInCharacter {
        /// The character.
        character: String,
        /// What was looked for.
        missing: &'static str,
        /// Its links.
        links: Vec<String>,
    },
    /// The joints are there, but they do not lie as those of a body.
    #[error(
        "`{from}` and `{to}` lie in one place: no direction of the body can be told (docs/book/motions.md, \"BVH and joint maps\")"
    )]
    OnePlace {
        /// A joint.
        from: String,
        /// Another one.
        to: String,
    },
    /// What was found is no valid map.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// The first names of a list, and how many more there are.
pub fn some_names<S: AsRef<str>>(names: &[S]) -> String {
    const SHOWN: usize = 40;
    let mut text = names.iter().take(SHOWN).map(S::as_ref).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text += &format!(" and {} more", names.len() - SHOWN);
    }
    text
}

impl fmt::Display for RestPose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RestPose::T => "T-pose",
            RestPose::A => "A-pose",
            RestPose::Hanging => "hanging arms",
            RestPose::None => "none (each joint has axes of its own; read from the motion)",
        })
    }
}

impl FoundMap {
    /// What was taken for what, as a table for a person.
    pub fn table(&self) -> String {
        let map = &self.map;
        let mut lines = vec![
            format!("unit             {} ({} m), a leg of {:.2} m", self.unit, map.unit, self.leg),
            format!("world            {} up, {} ahead", direction(map.up), direction(map.facing)),
            format!("pose at zero     {}", self.rest),
        ];
        let width = |of: &dyn Fn(&MapRow) -> usize| self.rows.iter().map(of).max().unwrap_or(0);
        let (first, second) = (width(&|r| r.link.len()).max(15), width(&|r| r.joints.join(" + ").len()));
        for row in &self.rows {
            let joints = row.joints.join(" + ");
            lines.push(format!("{:first$}  {joints:second$}  up {}, ahead {}", row.link, row.up, row.facing));
        }
        let mut reasons: Vec<&'static str> = self.unmapped.iter().map(|(_, reason)| *reason).collect();
        reasons.dedup();
        reasons.sort_unstable();
        reasons.dedup();
        for reason in reasons {
            let names: Vec<&str> =
                self.unmapped.iter().filter(|(_, r)| *r == reason).map(|(name, _)| name.as_str()).collect();
            lines.push(format!("not mapped       {}: {}", reason, names.join(", ")));
        }
        lines.join("\n")
    }
}

/// `+Y`, or the three components.
fn direction(v: glam::DVec3) -> String {
    let (axis, cosine) = source::nearest_axis(v);
    if cosine < 0.999_99 {
        return format!("({:.3}, {:.3}, {:.3})", v.x, v.y, v.z);
    }
    let sign = if axis.element_sum() > 0.0 { '+' } else { '-' };
    let name = ["X", "Y", "Z"][axis.abs().max_position()];
    format!("{sign}{name}")
}
