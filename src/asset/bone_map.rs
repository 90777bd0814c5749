//! Bone maps: which bone of a skinned mesh goes with which link of a character (`*.bones.ron`).
//!
//! ```ron
//! (
//!     character: "skater",
//!     // How the character has to stand to look like the mesh at rest: about each link's own x, then y, then z, degrees.
//!     pose: {"bicep_left": (0.0, 0.0, -45.0), "bicep_right": (0.0, 0.0, 45.0)},
//!     bones: {
//!         "Hips": (link: "pelvis"),
//!         // Instead of what the rest poses say: the bone in the link's frame.
//!         "Hat": (link: "head", offset: (translation: (0.0, 0.2, 0.0), degrees: (0.0, 90.0, 0.0))),
//!     },
//! )
//! ```

use glam::{DQuat, DVec3, EulerRot};
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::marker::PhantomData;

/// Files longer than this are no bone maps, bytes.
const LARGEST_FILE: usize = 1 << 20;

/// Why a bone map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoneMapError {
    /// The file is larger than any sensible one.
    #[error("{file}: {bytes} bytes; valid: at most {LARGEST_FILE}")]
    TooLarge {
        /// File name as given.
        file: String,
        /// Size found, bytes.
        bytes: usize,
    },
    /// The text is not a bone map.
    #[error("{file}:{line}:{column}: {reason}")]
    Syntax {
        /// File name as given.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// There is no bone in it.
    #[error("{file}: no bones; valid: at least one entry in `bones`")]
    Empty {
        /// File name as given.
        file: String,
    },
    /// A bone, or a link in `pose`, has two entries.
    #[error("{file}: {part} `{name}` has entries {first} and {second}; valid: one")]
    Duplicate {
        /// File name as given.
        file: String,
        /// `bone` or `pose`.
        part: &'static str,
        /// The bone or link.
        name: String,
        /// Position of the first entry, from 1.
        first: usize,
        /// Position of the second entry, from 1.
        second: usize,
    },
    /// An offset or a rotation is no number.
    #[error("{file}: {part} `{name}`: {field} is {value}; valid: finite numbers")]
    Value {
        /// File name as given.
        file: String,
        /// `bone` or `pose`.
        part: &'static str,
        /// The bone or link.
        name: String,
        /// The field.
        field: &'static str,
        /// Value found.
        value: DVec3,
    },
    /// The map is for another character.
    #[error("{file}: made for the character `{wanted}`; the athlete is a `{found}`")]
    Character {
        /// File name as given.
        file: String,
        /// Name in the file.
        wanted: String,
        /// Name of the athlete's character.
        found: String,
    },
    /// The character has no such link.
    #[error("{file}: {part} `{name}`: link is `{link}`; valid: {valid}")]
    UnknownLink {
        /// File name as given.
        file: String,
        /// `bone` or `pose`.
        part: &'static str,
        /// The bone, or the link again.
        name: String,
        /// The link it names.
        link: String,
        /// The links of the character.
        valid: String,
    },
    /// The mesh has no such bone.
    #[error("{file}: the mesh has no bone `{bone}`; valid: {valid}")]
    UnknownBone {
        /// File name as given.
        file: String,
        /// The bone.
        bone: String,
        /// The bones that there are.
        valid: String,
    },
    /// The mesh has several bones of this name.
    #[error("{file}: the mesh has {count} bones `{bone}`; valid: one of each name that is mapped")]
    AmbiguousBone {
        /// File name as given.
        file: String,
        /// The bone.
        bone: String,
        /// How many there are.
        count: usize,
    },
    /// A bone is squeezed flat in the mesh's rest pose, or not a number.
    #[error(
        "{file}: bone `{bone}` has a rest pose that cannot be turned back; valid: finite, with a scale other than zero"
    )]
    RestPose {
        /// File name as given.
        file: String,
        /// The bone.
        bone: String,
    },
}

/// Where a bone lies in its link's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BoneOffset {
    /// The bone's joint in the link's frame, m.
    pub translation: DVec3,
    /// Rotation of the bone's axes against the link's: about x, then y, then z, degrees.
    pub degrees: DVec3,
}

/// What a bone follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoneEntry {
    /// The link.
    pub link: String,
    /// Its place on the link; without it, that of the two rest poses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<BoneOffset>,
}

/// A bone map.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoneMap {
    /// File name for messages.
    #[serde(skip)]
    pub file: String,
    /// Name of the character that it is for.
    pub character: String,
    /// Rotations of the character's joints, by link, in which it stands as the mesh does at rest: about x, then y, then z,
    /// degrees. The other joints are as in the character file.
    #[serde(default, deserialize_with = "in_order")]
    pub pose: Vec<(String, DVec3)>,
    /// Bones in the order of the file.
    #[serde(deserialize_with = "in_order")]
    pub bones: Vec<(String, BoneEntry)>,
}

impl BoneMap {
    /// Reads a bone map. `file` is its name for messages.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, BoneMapError> {
        if bytes.len() > LARGEST_FILE {
            return Err(BoneMapError::TooLarge { file: file.into(), bytes: bytes.len() });
        }
        let ron = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let mut map: Self = ron.from_bytes(bytes).map_err(|e| BoneMapError::Syntax {
            file: file.into(),
            line: e.span.start.line,
            column: e.span.start.col,
            reason: e.code.to_string(),
        })?;
        map.file = file.into();
        map.check()?;
        Ok(map)
    }

    fn check(&self) -> Result<(), BoneMapError> {
        let file = || self.file.clone();
        if self.bones.is_empty() {
            return Err(BoneMapError::Empty { file: file() });
        }
        let unique = |part: &'static str, names: Vec<&String>| {
            for (second, name) in names.iter().enumerate() {
                if let Some(first) = names[..second].iter().position(|n| n == name) {
                    let (first, second) = (first + 1, second + 1);
                    return Err(BoneMapError::Duplicate { file: file(), part, name: (*name).clone(), first, second });
                }
            }
            Ok(())
        };
        unique("bone", self.bones.iter().map(|(name, _)| name).collect())?;
        unique("pose", self.pose.iter().map(|(name, _)| name).collect())?;
        let finite = |part, name: &str, field, value: DVec3| {
            let bad = || BoneMapError::Value { file: file(), part, name: name.into(), field, value };
            if value.is_finite() { Ok(()) } else { Err(bad()) }
        };
        for (link, degrees) in &self.pose {
            finite("pose", link, "rotation", *degrees)?;
        }
        for (bone, entry) in &self.bones {
            if let Some(offset) = entry.offset {
                finite("bone", bone, "translation", offset.translation)?;
                finite("bone", bone, "degrees", offset.degrees)?;
            }
        }
        Ok(())
    }
}

/// The rotation about x, then y, then z by degrees.
pub(crate) fn rotation_of_degrees(degrees: DVec3) -> DQuat {
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    DQuat::from_euler(EulerRot::XYZ, x, y, z)
}

/// The entries of a map in the order of the file, each as often as it is there.
fn in_order<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<(String, T)>, D::Error> {
    struct Entries<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
        type Value = Vec<(String, T)>;
        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a map of names")
        }
        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = Vec::new();
            while let Some(entry) = map.next_entry()? {
                entries.push(entry);
            }
            Ok(entries)
        }
    }
    from.deserialize_map(Entries(PhantomData))
}
