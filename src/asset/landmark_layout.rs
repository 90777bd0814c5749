//! Landmark layouts: which point of a character each landmark of a pose estimator is (`*.landmarks.ron`).

use super::clip_edit::other_side;
use super::read_file::read_text;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The axes in which positions are written. Ours have X to the right, Y up and Z towards the viewer, and a character in its
/// zero pose faces -Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axes {
    /// Y up, facing +Z, the left hand on +X, as the SMPL body model: (x, y, z) becomes (-x, y, -z).
    YUp,
    /// A camera's: x to the right of the picture, y down, z away from the camera: (x, y, z) becomes (x, -y, -z).
    YDown,
    /// Z up, x to the right, y forwards: (x, y, z) becomes (x, z, -y).
    ZUp,
}

impl Axes {
    /// How a position file calls each.
    pub const NAMES: [(&'static str, Axes); 3] = [("y_up", Axes::YUp), ("y_down", Axes::YDown), ("z_up", Axes::ZUp)];

    /// A position in our axes.
    pub fn to_ours(self, p: DVec3) -> DVec3 {
        match self {
            Axes::YUp => DVec3::new(-p.x, p.y, -p.z),
            Axes::YDown => DVec3::new(p.x, -p.y, -p.z),
            Axes::ZUp => DVec3::new(p.x, p.z, -p.y),
        }
    }

    /// A position of ours in these axes.
    pub fn from_ours(self, p: DVec3) -> DVec3 {
        match self {
            Axes::ZUp => DVec3::new(p.x, -p.z, p.y),
            // Half turns are their own inverses.
            _ => self.to_ours(p),
        }
    }
}

/// A point of a character.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LandmarkPlace {
    /// The joint that carries the link.
    Joint(String),
    /// A place in the box round the link's shapes, from (-1, -1, -1) to (1, 1, 1) along the link's axes; up to 4 is
    /// outside of it.
    Inside(String, DVec3),
    /// A place in the link's own frame, m.
    At(String, DVec3),
}

impl LandmarkPlace {
    /// The link.
    pub fn link(&self) -> &str {
        match self {
            LandmarkPlace::Joint(link) | LandmarkPlace::Inside(link, _) | LandmarkPlace::At(link, _) => link,
        }
    }
}

/// One landmark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarkEntry {
    /// Its name. `left` and `right` in names make pairs.
    pub name: String,
    /// Where it is: the first whose link the character has counts. Empty: read, but not used.
    #[serde(default)]
    pub at: Vec<LandmarkPlace>,
    /// How much it counts against others: 1 for a joint that people and characters share, less where they differ.
    #[serde(default = "one")]
    pub weight: f64,
}

fn one() -> f64 {
    1.0
}

/// The landmarks of a tool, in the order of its arrays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarkLayout {
    /// Name, as a position file gives it.
    pub name: String,
    /// Axes of files that name none.
    pub axes: Axes,
    /// The landmarks of the left and the right hip.
    pub hips: (String, String),
    /// The landmarks of the left and the right shoulder.
    pub shoulders: (String, String),
    /// All landmarks.
    pub landmarks: Vec<LandmarkEntry>,
    /// How far a joint goes from straight where no landmark tells: standard deviations of the components of its
    /// rotation vector, degrees, by link. Without an entry, three tenths of the joint's range.
    #[serde(default)]
    pub spread: BTreeMap<String, (f64, f64, f64)>,
}

/// Why a landmark layout was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LayoutError {
    /// The file could not be read.
    #[error("landmark layout {path}: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The text is no layout.
    #[error("landmark layout text, line {line}, column {column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// A field is out of range.
    #[error("landmark layout `{layout}`, {place}: {found}; valid is {expected}")]
    Value {
        /// The layout.
        layout: String,
        /// Field and landmark.
        place: String,
        /// The value.
        found: String,
        /// What would be valid.
        expected: &'static str,
    },
}

/// Largest layout file, bytes.
const MAX_BYTES: usize = 1 << 20;
/// Most landmarks of a layout.
const MAX_LANDMARKS: usize = 1024;

/// Layouts that come with the crate.
const BUILT_IN: [&str; 3] = [
    include_str!("../../assets/landmarks/smpl24.landmarks.ron"),
    include_str!("../../assets/landmarks/mediapipe33.landmarks.ron"),
    include_str!("../../assets/landmarks/smpl22.landmarks.ron"),
];

impl LandmarkLayout {
    /// Names of the layouts that come with the crate.
    pub const NAMES: [&'static str; 3] = ["smpl24", "mediapipe33", "smpl22"];

    /// Reads a layout from RON text and checks it.
    pub fn from_ron(text: &str) -> Result<Self, LayoutError> {
        let syntax = |line, column, reason| LayoutError::Syntax { line, column, reason };
        if text.len() > MAX_BYTES {
            return Err(syntax(1, 1, format!("{} bytes; at most {MAX_BYTES} are read", text.len())));
        }
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let layout: LandmarkLayout = options
            .from_str(text)
            .map_err(|error| syntax(error.span.start.line, error.span.start.col, error.code.to_string()))?;
        layout.validate()?;
        Ok(layout)
    }

    /// Reads a `*.landmarks.ron` file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LayoutError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_BYTES as u64)
            .map_err(|e| LayoutError::File { path: path.to_path_buf(), reason: e.fault.to_string() })?;
        Self::from_ron(&text)
    }

    /// The layout of this name that comes with the crate.
    pub fn built_in(name: &str) -> Option<Self> {
        let index = Self::NAMES.iter().position(|n| *n == name)?;
        Self::from_ron(BUILT_IN[index]).ok()
    }

    /// The built-in layout with so many landmarks.
    pub fn of_count(count: usize) -> Option<Self> {
        Self::NAMES.iter().filter_map(|name| Self::built_in(name)).find(|l| l.landmarks.len() == count)
    }

    /// Index of a landmark.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.landmarks.iter().position(|l| l.name == name)
    }

    /// Index of the landmark on the other side; its own where it has no partner.
    pub fn partner(&self, index: usize) -> usize {
        self.index(&other_side(&self.landmarks[index].name)).unwrap_or(index)
    }

    /// Indices of left hip, right hip, left shoulder, right shoulder.
    pub fn trunk(&self) -> [usize; 4] {
        let names = [&self.hips.0, &self.hips.1, &self.shoulders.0, &self.shoulders.1];
        // Validation has found them all.
        names.map(|name| self.index(name).unwrap_or(0))
    }

    /// Whether every name and number can be used.
    pub fn validate(&self) -> Result<(), LayoutError> {
        let refuse = |place: String, found: String, expected: &'static str| {
            Err(LayoutError::Value { layout: self.name.clone(), place, found, expected })
        };
        if self.name.is_empty() {
            return refuse("name".into(), "empty".into(), "a name");
        }
        if !(4..=MAX_LANDMARKS).contains(&self.landmarks.len()) {
            return refuse("landmarks".into(), self.landmarks.len().to_string(), "4 to 1024 landmarks");
        }
        for (i, landmark) in self.landmarks.iter().enumerate() {
            if landmark.name.is_empty() || self.landmarks[..i].iter().any(|l| l.name == landmark.name) {
                let found = format!("`{}`", landmark.name);
                return refuse(format!("landmark {i}"), found, "a name of its own");
            }
            let place = |field: &str| format!("landmark `{}`, {field}", landmark.name);
            if !(1e-3..=1e3).contains(&landmark.weight) {
                return refuse(place("weight"), landmark.weight.to_string(), "0.001 to 1000");
            }
            for at in &landmark.at {
                if let LandmarkPlace::Inside(_, p) | LandmarkPlace::At(_, p) = at
                    && !(p.is_finite() && p.abs().max_element() <= 4.0)
                {
                    return refuse(place("at"), p.to_string(), "coordinates from -4 to 4");
                }
            }
        }
        for (field, (left, right)) in [("hips", &self.hips), ("shoulders", &self.shoulders)] {
            for name in [left, right] {
                if self.index(name).is_none_or(|i| self.landmarks[i].at.is_empty()) {
                    return refuse(field.into(), format!("`{name}`"), "a landmark with a place on the character");
                }
            }
            if left == right {
                return refuse(field.into(), format!("`{left}` twice"), "two landmarks");
            }
        }
        for (link, (x, y, z)) in &self.spread {
            if ![x, y, z].into_iter().all(|s| (0.1..=360.0).contains(s)) {
                return refuse(format!("spread of `{link}`"), format!("{x}, {y}, {z}"), "0.1 to 360 degrees");
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_layouts_are_valid_and_pair_left_with_right() {
        for (name, text) in LandmarkLayout::NAMES.iter().zip(BUILT_IN) {
            let layout = LandmarkLayout::from_ron(text).unwrap();
            assert_eq!(&layout.name, name);
            for i in 0..layout.landmarks.len() {
                assert_eq!(layout.partner(layout.partner(i)), i);
                let name = &layout.landmarks[i].name;
                assert_eq!(layout.partner(i) != i, name.contains("left") || name.contains("right"), "{name}");
            }
        }
        assert_eq!(LandmarkLayout::of_count(24).unwrap().name, "smpl24");
        assert_eq!(LandmarkLayout::of_count(22).unwrap().name, "smpl22");
        assert_eq!(LandmarkLayout::of_count(33).unwrap().name, "mediapipe33");
        assert!(LandmarkLayout::of_count(23).is_none());
    }

    #[test]
    fn axes_are_rotations_and_come_back() {
        for (name, axes) in Axes::NAMES {
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| axes.to_ours(v));
            assert_eq!(x.cross(y), z, "{name} is right-handed");
            let p = DVec3::new(1.0, 2.0, 3.0);
            assert_eq!(axes.from_ours(axes.to_ours(p)), p, "{name}");
        }
        assert_eq!(Axes::YDown.to_ours(DVec3::NEG_Y), DVec3::Y);
        assert_eq!(Axes::ZUp.to_ours(DVec3::Z), DVec3::Y);
        assert_eq!(Axes::YUp.to_ours(DVec3::Z), DVec3::NEG_Z);
    }

    #[test]
    fn wrong_layouts_are_refused_by_place() {
        let good = BUILT_IN[0];
        for (from, to, words) in [
            ("weight: 0.5", "weight: -1", &["pelvis", "weight", "-1"][..]),
            ("hips: (\"left_hip\"", "hips: (\"left_hipp\"", &["hips", "left_hipp"]),
            ("hips: (\"left_hip\"", "hips: (\"right_hip\"", &["hips", "twice"]),
            ("name: \"neck\"", "name: \"spine1\"", &["landmark 12", "spine1"]),
            ("(0, 0.5, 0)", "(0, 50, 0)", &["spine2", "-4 to 4"]),
            ("(50, 8, 6)", "(50, 8, 0)", &["spread of `shin_left`"]),
            ("axes: YUp", "axes: Up", &["line 5"]),
        ] {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good);
            let message = LandmarkLayout::from_ron(&text).unwrap_err().to_string();
            assert!(words.iter().all(|w| message.contains(w)), "{words:?}: {message}");
        }
        let message = LandmarkLayout::load("no/such.landmarks.ron").unwrap_err().to_string();
        assert!(message.contains("no/such.landmarks.ron"), "{message}");
    }
}
