//! Skill files as text.

use super::{SkillDefinition, SkillError};

impl SkillDefinition {
    /// The text of a skill file, which [`SkillDefinition::from_ron`] reads back to the same skill; every field is written. Paths are
    /// written as they are.
    pub fn to_ron(&self) -> Result<String, SkillError> {
        self.validate()?;
        let style = ron::ser::PrettyConfig::new().depth_limit(2);
        let text = ron::ser::to_string_pretty(self, style);
        let text = text.map_err(|e| SkillError::Syntax { path: self.name.clone().into(), message: e.to_string() })?;
        Ok(text + "\n")
    }
}
