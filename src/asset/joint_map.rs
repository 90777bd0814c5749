//! Joint maps: how a BVH skeleton drives the links of a character (`*.map.ron`).
//!
//! A link follows the orientation that its source joint has in the world, so a chain of source joints that ends in one
//! link composes by itself, and links that have no source joint stay straight. With
//!
//! - `G` the source joint's axes to the source world (from the file's forward kinematics),
//! - `A` the source world to ours (Y up, facing -Z), from [`JointMap::up`] and [`JointMap::facing`],
//! - `B` link axes to the source joint's axes, from [`LinkMap::up`] and [`LinkMap::facing`],
//! - `C` the rest-pose offset, [`LinkMap::rest_degrees`],
//!
//! the link's axes to our world are `A * G * B * C`. For a source that faces +X with Y up, in file units of metres,
//! `A` takes (x, y, z) to (z, y, -x).

use super::bvh::Bvh;
use super::read_file::{ReadFault, read_text};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// How one link of the character follows the source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkMap {
    /// Link of the character; also the name by which the rest of the map refers to this entry.
    pub link: String,
    /// Other names for the link, tried in order where the character has no `link`.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// Source joints summed into the link, from the trunk outwards. The last one gives the link its orientation.
    pub joints: Vec<String>,
    /// The link's up (+Y) in the axes of the source joint; without it the source world's.
    #[serde(default)]
    pub up: Option<DVec3>,
    /// The link's facing (-Z) in the axes of the source joint; without it the source world's.
    #[serde(default)]
    pub facing: Option<DVec3>,
    /// Rotation of the link in the source's rest pose: about its own x, then y, then z, degrees.
    #[serde(default)]
    pub rest_degrees: DVec3,
    /// How much of the way from the parent link's orientation to the source's the link goes: 1 is all of it. Spreads
    /// one source joint over several links.
    #[serde(default = "one")]
    pub share: f64,
    /// Whether a character without the link is welcome.
    #[serde(default)]
    pub optional: bool,
}

/// Which point of the character's root follows which point of the source.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum RootAnchor {
    /// The root link's joint follows the last source joint of the root entry.
    #[default]
    Joint,
    /// The middle between two links' joints (the hips, say) follows the middle between two source joints. For roots
    /// that lie elsewhere: on the ground, or higher up in the pelvis.
    Between {
        /// Source joints.
        joints: (String, String),
        /// Links, children of the root.
        links: (String, String),
    },
}

/// How lengths are fitted to a character of another size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Fit {
    /// Not at all.
    #[default]
    None,
    /// All lengths of the root's path times a number.
    Factor(f64),
    /// Times the ratio of leg lengths (hip to knee to ankle), character to source.
    Legs {
        /// Source joints: hip, knee, ankle.
        joints: (String, String, String),
        /// Links whose joints are hip, knee and ankle.
        links: (String, String, String),
    },
}

/// A joint map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointMap {
    /// Name for reports.
    pub name: String,
    /// Metres in one file unit.
    pub unit: f64,
    /// Unit vector that points up in the source world.
    pub up: DVec3,
    /// Unit vector along which the source faces in its rest pose, source world, at right angles to `up`.
    pub facing: DVec3,
    /// The root link.
    pub root: LinkMap,
    /// Where the root is placed.
    #[serde(default)]
    pub anchor: RootAnchor,
    /// The other links.
    pub links: Vec<LinkMap>,
    /// Source joints that drive nothing. Every joint of the file must be here or in an entry.
    #[serde(default)]
    pub ignored: Vec<String>,
    /// Size of the character against the source.
    #[serde(default)]
    pub fit: Fit,
    /// Factor on distances along the ground, beyond `fit`.
    #[serde(default = "one")]
    pub stride: f64,
    /// Added to the root's height after all scaling, m.
    #[serde(default)]
    pub lift: f64,
    /// Links (with all below them) whose lowest point over the clip is put on y = 0; none leaves the height alone.
    #[serde(default)]
    pub soles: Vec<String>,
    /// Fraction of the poses whose soles may reach below y = 0 all the same (0: none).
    #[serde(default)]
    pub sole_fraction: f64,
}

fn one() -> f64 {
    1.0
}

/// Why a joint map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The file could not be read.
    #[error("joint map {path}: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The text is no map.
    #[error("joint map text, line {line}, column {column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// Too long.
    #[error("joint map of {found} bytes; at most {MAX_MAP_BYTES} are read")]
    TooLarge {
        /// Found, bytes.
        found: usize,
    },
    /// A field is out of range.
    #[error("joint map `{map}`, {place}: {found}; valid is {expected}")]
    Value {
        /// The map.
        map: String,
        /// Field and link.
        place: String,
        /// The value.
        found: String,
        /// What would be valid.
        expected: &'static str,
    },
}

/// Largest map file, bytes.
pub const MAX_MAP_BYTES: usize = 1 << 20;

/// Maps that come with the crate, the more particular first.
const BUILT_IN: [&str; 3] = [
    include_str!("../../assets/maps/skate.map.ron"),
    include_str!("../../assets/maps/spin.map.ron"),
    include_str!("../../assets/maps/mocap.map.ron"),
];

impl JointMap {
    /// Reads a map from RON text and checks it.
    pub fn from_ron(text: &str) -> Result<Self, MapError> {
        if text.len() > MAX_MAP_BYTES {
            return Err(MapError::TooLarge { found: text.len() });
        }
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let map: JointMap = options.from_str(text).map_err(|error| MapError::Syntax {
            line: error.span.start.line,
            column: error.span.start.col,
            reason: error.code.to_string(),
        })?;
        map.validate()?;
        Ok(map)
    }

    /// Reads a `*.map.ron` file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MapError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_MAP_BYTES as u64).map_err(|error| match error.fault {
            ReadFault::TooLarge { bytes, .. } => {
                MapError::TooLarge { found: usize::try_from(bytes).unwrap_or(usize::MAX) }
            }
            fault => MapError::File { path: path.to_path_buf(), reason: fault.to_string() },
        })?;
        Self::from_ron(&text)
    }

    /// The maps that come with the crate.
    pub fn built_in() -> impl Iterator<Item = JointMap> {
        BUILT_IN.iter().filter_map(|text| JointMap::from_ron(text).ok())
    }

    /// The built-in map for the skeleton of a file: the first that knows all its joints and misses none.
    pub fn detect(bvh: &Bvh) -> Option<JointMap> {
        Self::built_in().find(|map| map.fits(bvh))
    }

    /// Whether the file has exactly the joints that the map names.
    pub fn fits(&self, bvh: &Bvh) -> bool {
        bvh.joints().iter().all(|j| self.knows(&j.name)) && self.joints().all(|j| bvh.joint_index(j).is_some())
    }

    /// The root's entry and those of the other links.
    pub fn entries(&self) -> impl Iterator<Item = &LinkMap> {
        std::iter::once(&self.root).chain(&self.links)
    }
    /// The entry for a link, by its name in the map.
    pub fn entry(&self, link: &str) -> Option<&LinkMap> {
        self.entries().find(|e| e.link == link)
    }
    /// Source joints that drive a link.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.entries().flat_map(|e| e.joints.iter().map(String::as_str))
    }
    /// Whether a source joint drives a link or is ignored.
    pub fn knows(&self, joint: &str) -> bool {
        self.ignored.iter().any(|j| j == joint) || self.joints().any(|j| j == joint)
    }

    /// Source world to ours: the rotation `A`.
    pub fn world_rotation(&self) -> DQuat {
        basis(self.up, self.facing).conjugate()
    }
    /// Link axes to the source joint's axes with the rest-pose offset: `B * C`.
    pub fn link_rotation(&self, entry: &LinkMap) -> DQuat {
        let rest = entry.rest_degrees;
        let rest = DQuat::from_euler(EulerRot::XYZ, rest.x.to_radians(), rest.y.to_radians(), rest.z.to_radians());
        (basis(entry.up.unwrap_or(self.up), entry.facing.unwrap_or(self.facing)) * rest).normalize()
    }

    /// Whether every number is in range and every name refers to something.
    pub fn validate(&self) -> Result<(), MapError> {
        let refuse = |place: String, found: String, expected: &'static str| {
            Err(MapError::Value { map: self.name.clone(), place, found, expected })
        };
        for (field, value, low, high, expected) in [
            ("unit", self.unit, 1e-6, 1e3, "0.000001 to 1000 m"),
            ("stride", self.stride, 0.0, 100.0, "0 to 100"),
            ("sole_fraction", self.sole_fraction, 0.0, 1.0, "0 to 1"),
            ("lift", self.lift, -100.0, 100.0, "-100 to 100 m"),
        ] {
            if !(low..=high).contains(&value) {
                return refuse(field.into(), value.to_string(), expected);
            }
        }
        for (index, entry) in self.entries().enumerate() {
            let place = |field: &str| format!("link `{}`, {field}", entry.link);
            let (up, facing) = (entry.up.unwrap_or(self.up), entry.facing.unwrap_or(self.facing));
            let unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-3;
            if !(unit(up) && unit(facing) && up.dot(facing).abs() < 1e-3) {
                let found = format!("{up} and {facing}");
                return refuse(place("up and facing"), found, "unit vectors at right angles");
            }
            if !(entry.rest_degrees.is_finite() && entry.rest_degrees.abs().max_element() <= 360.0) {
                return refuse(place("rest_degrees"), entry.rest_degrees.to_string(), "angles from -360 to 360");
            }
            if !(0.0..=1.0).contains(&entry.share) {
                return refuse(place("share"), entry.share.to_string(), "0 to 1");
            }
            if entry.joints.is_empty() {
                return refuse(place("joints"), "none".into(), "at least one source joint");
            }
            if entry.link.is_empty() || self.entries().take(index).any(|e| e.link == entry.link) {
                return refuse(place("name"), "empty or used before".into(), "a name of its own");
            }
        }
        if let Some(joint) = self.ignored.iter().find(|i| self.joints().any(|j| j == *i)) {
            return refuse("ignored".into(), joint.clone(), "a joint that drives no link");
        }
        if let Fit::Factor(factor) = self.fit
            && !(1e-3..=1e3).contains(&factor)
        {
            return refuse("fit".into(), factor.to_string(), "0.001 to 1000");
        }
        for (field, link) in self.link_references() {
            if self.entry(link).is_none() {
                return refuse(field.into(), link.into(), "the name of an entry of this map");
            }
        }
        Ok(())
    }

    /// Links that other fields refer to, with the field.
    fn link_references(&self) -> Vec<(&'static str, &str)> {
        let mut links: Vec<(&'static str, &str)> = self.soles.iter().map(|l| ("soles", l.as_str())).collect();
        if let RootAnchor::Between { links: (a, b), .. } = &self.anchor {
            links.extend([("anchor", a.as_str()), ("anchor", b.as_str())]);
        }
        if let Fit::Legs { links: (a, b, c), .. } = &self.fit {
            links.extend([("fit", a.as_str()), ("fit", b.as_str()), ("fit", c.as_str())]);
        }
        links
    }
}

/// The rotation that takes our axes (x right, y up, -z facing) to axes with these directions.
pub(crate) fn basis(up: DVec3, facing: DVec3) -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(facing.cross(up), up, -facing)).normalize()
}
