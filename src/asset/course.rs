//! Courses (`*.course.ron`): obstacles whose numbers follow from named parameters.
//!
//! The frame of a course: it starts at the world's origin, `ahead` counts along -Z, `right` along +X, `up` along +Y, m. What
//! stands on something is placed by the middle of its front at the bottom: that is where it begins. Angles are in degrees
//! here and in radians everywhere else.

mod check;
mod entries;
mod error;
mod formula;
mod instance;

use crate::asset::read_file::{ReadFault, read_bytes};
use crate::asset::{AssetError, Material};
use crate::math::RandomStream;
use serde::{Deserialize, Serialize};
use std::path::Path;

pub use entries::{MaterialEntry, MotionEntry, SolidEntry};
pub use error::CourseError;
pub use formula::{Formula, FormulaError, Quantity};
pub use instance::{BumpsInstance, CourseInstance, MotionInstance, SolidInstance, SolidShape};

/// A course as written in its file. [`Course::parse`] returns only validated ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Course {
    /// Where it was read from, for error messages; not part of the file.
    #[serde(skip)]
    pub file: String,
    /// Name, such as `vault_box`.
    pub name: String,
    /// What can be chosen or drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterEntry>,
    /// Materials besides `ground`, `ice`, `wall` and `rail`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialEntry>,
    /// Level ground at y = 0, with gaps and bumps in it; without it, the course stands on whatever world it is put into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<GroundEntry>,
    /// Width between the side walls, m. They are not solid: they say where an obstacle is crossed and not gone round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side_walls: Option<Quantity>,
    /// What stands on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solids: Vec<SolidEntry>,
}

/// A parameter of a course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Unique name, as formulas use it.
    pub name: String,
    /// Least and largest value.
    pub range: (f64, f64),
    /// Value where none is chosen; without it, the middle of the range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub default: Option<f64>,
}

impl ParameterEntry {
    /// Value where none is chosen.
    pub fn default_value(&self) -> f64 {
        self.default.unwrap_or(0.5 * (self.range.0 + self.range.1))
    }
}

/// The ground of a course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundEntry {
    /// Name of its material.
    #[serde(default = "ground")]
    pub material: String,
    /// Coulomb coefficient.
    pub friction: Quantity,
    /// By how much it rises along the way, degrees; it falls where this is negative. It is at height 0 where the course starts.
    #[serde(default = "entries::zero", skip_serializing_if = "entries::is_zero")]
    pub slope: Quantity,
}

fn ground() -> String {
    "ground".to_owned()
}

impl Course {
    /// Largest file, bytes.
    pub const MAX_BYTES: usize = 1 << 20;
    /// Most solids, the steps of stairs counted.
    pub const MAX_SOLIDS: usize = 1024;
    /// Most nodes of a field of bumps.
    pub const MAX_NODES: usize = 1 << 16;

    /// Parses and validates the bytes of a course file; `file` is the name used in messages.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, CourseError> {
        let name = || file.to_owned();
        if bytes.len() > Self::MAX_BYTES {
            let (bytes, limit) = (bytes.len() as u64, Self::MAX_BYTES as u64);
            return Err(AssetError::TooLarge { file: name(), bytes, limit }.into());
        }
        let text = std::str::from_utf8(bytes)
            .map_err(|error| AssetError::NotText { file: name(), at: error.valid_up_to() })?;
        let mut course: Course = options().from_str(text).map_err(|error| AssetError::Syntax {
            file: name(),
            line: error.span.start.line,
            column: error.span.start.col,
            reason: error.code.to_string().chars().take(400).collect(),
        })?;
        course.file = name();
        course.validate()?;
        Ok(course)
    }

    /// Reads, parses and validates a course file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, CourseError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let bytes = read_bytes(path, Self::MAX_BYTES as u64).map_err(|error| match error.fault {
            ReadFault::TooLarge { bytes, limit } => AssetError::TooLarge { file: file.clone(), bytes, limit },
            fault => AssetError::Read { file: file.clone(), reason: fault.to_string() },
        })?;
        Self::parse(&file, &bytes)
    }

    /// The text of a course file, which [`Course::parse`] reads back; refuses what it would refuse.
    pub fn to_ron(&self) -> Result<String, CourseError> {
        self.validate()?;
        let pretty = ron::ser::PrettyConfig::new().depth_limit(3);
        let text = options().to_string_pretty(self, pretty).map_err(|error| AssetError::Syntax {
            file: self.file.clone(),
            line: 0,
            column: 0,
            reason: error.to_string(),
        })?;
        Ok(text)
    }

    /// Checks everything that the types alone do not promise, with all parameters at their defaults, lowest and highest values.
    pub fn validate(&self) -> Result<(), CourseError> {
        check::check(self)
    }

    /// Place of a parameter in the list.
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// Default values of all parameters.
    pub fn defaults(&self) -> Vec<f64> {
        self.parameters.iter().map(ParameterEntry::default_value).collect()
    }

    /// Chooses a parameter; refuses one that there is not, and a value out of its range.
    pub fn set(&self, values: &mut [f64], name: &str, value: f64) -> Result<(), CourseError> {
        let Some(index) = self.parameter(name) else {
            return Err(CourseError::Name {
                file: self.shown().into(),
                place: "course".into(),
                field: "parameter",
                name: name.chars().take(64).collect::<String>().into(),
                valid: self.parameter_names().into(),
            });
        };
        let (low, high) = self.parameters[index].range;
        if !(value >= low && value <= high) {
            return Err(CourseError::Value {
                file: self.shown().into(),
                place: format!("parameter `{name}`").into(),
                field: "value",
                value: value.to_string().into(),
                valid: format!("a number from {low} to {high}").into(),
            });
        }
        if let Some(place) = values.get_mut(index) {
            *place = value;
        }
        Ok(())
    }

    /// Draws all parameters evenly from their ranges.
    pub fn draw(&self, random: &mut RandomStream, values: &mut [f64]) {
        for (value, parameter) in values.iter_mut().zip(&self.parameters) {
            *value = random.range(parameter.range.0, parameter.range.1);
        }
    }

    /// The material of this name: the file's own, else the crate's.
    pub fn material(&self, name: &str) -> Option<Material> {
        match self.materials.iter().position(|m| m.name == name) {
            Some(k) => {
                let MaterialEntry { carves, grippable, .. } = self.materials[k];
                Some(Material { id: Material::OWN + k as u16, carves, grippable })
            }
            None => Material::named(name),
        }
    }

    /// The course with these values of the parameters, and with bumps drawn from `seed`.
    pub fn instance(&self, values: &[f64], seed: u64) -> Result<CourseInstance, CourseError> {
        let mut instance = CourseInstance::default();
        self.evaluate(values, seed, &mut instance)?;
        Ok(instance)
    }

    /// [`Course::instance`] into one that exists: from the second time on nothing is allocated.
    pub fn evaluate(&self, values: &[f64], seed: u64, out: &mut CourseInstance) -> Result<(), CourseError> {
        instance::evaluate(self, values, seed, out)
    }

    /// The file as it is called in messages.
    fn shown(&self) -> &str {
        if self.file.is_empty() { "course built in code" } else { &self.file }
    }

    /// The valid choices of a parameter's name.
    fn parameter_names(&self) -> String {
        let names: Vec<&str> = self.parameters.iter().map(|p| p.name.as_str()).take(24).collect();
        if names.is_empty() {
            "no name, this course has no parameters".into()
        } else {
            format!("one of {}", names.join(", "))
        }
    }
}

/// RON as our files are written: no `Some(..)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
}
