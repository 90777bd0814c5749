//! Joint maps as text that a person edits: one line a link, remarks above.

use super::joint_map::{Fit, JointMap, LinkMap, MapError, RootAnchor};
use glam::DVec3;
use std::fmt::Write as _;
use std::path::Path;

/// A number with at most nine digits after the point, and with a point.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let short = text.trim_end_matches('0');
    let short = if short.ends_with('.') { format!("{short}0") } else { short.to_owned() };
    if short == "-0.0" { "0.0".into() } else { short }
}

fn vector(v: DVec3) -> String {
    format!("({}, {}, {})", number(v.x), number(v.y), number(v.z))
}

fn list(names: &[String]) -> String {
    format!("[{}]", names.iter().map(|n| format!("{n:?}")).collect::<Vec<_>>().join(", "))
}

fn entry(e: &LinkMap) -> String {
    let mut text = format!("(link: {:?}, ", e.link);
    if !e.aliases.is_empty() {
        let _ = write!(text, "aliases: {}, ", list(&e.aliases));
    }
    let _ = write!(text, "joints: {}", list(&e.joints));
    for (field, axis) in [("up", e.up), ("facing", e.facing)] {
        if let Some(axis) = axis {
            let _ = write!(text, ", {field}: {}", vector(axis));
        }
    }
    if e.rest_degrees != DVec3::ZERO {
        let _ = write!(text, ", rest_degrees: {}", vector(e.rest_degrees));
    }
    if e.share != 1.0 {
        let _ = write!(text, ", share: {}", number(e.share));
    }
    if e.optional {
        text += ", optional: true";
    }
    text + ")"
}

impl JointMap {
    /// The text of a map file, with remarks at its start; [`JointMap::from_ron`] reads it back to nine digits.
    pub fn to_ron(&self, remarks: &[String]) -> Result<String, MapError> {
        self.validate()?;
        let mut text = String::new();
        for remark in remarks.iter().flat_map(|r| r.lines()) {
            let _ = writeln!(text, "{}", format!("// {remark}").trim_end());
        }
        let _ = writeln!(text, "JointMap(\n    name: {:?},\n    // Metres in one unit of the file.", self.name);
        // Units may be small: all digits.
        let _ = writeln!(text, "    unit: {:?},", self.unit);
        let _ = writeln!(text, "    up: {},\n    facing: {},", vector(self.up), vector(self.facing));
        let _ = writeln!(text, "    root: {},", entry(&self.root));
        if let RootAnchor::Between { joints: (a, b), links: (c, d) } = &self.anchor {
            let _ = writeln!(text, "    anchor: Between(joints: ({a:?}, {b:?}), links: ({c:?}, {d:?})),");
        }
        text += "    links: [\n";
        for e in &self.links {
            let _ = writeln!(text, "        {},", entry(e));
        }
        text += "    ],\n";
        if !self.ignored.is_empty() {
            let _ = writeln!(text, "    // Joints that drive nothing.\n    ignored: {},", list(&self.ignored));
        }
        match &self.fit {
            Fit::None => {}
            Fit::Factor(factor) => {
                let _ = writeln!(text, "    fit: Factor({}),", number(*factor));
            }
            Fit::Legs { joints: (a, b, c), links: (d, e, f) } => {
                let _ = writeln!(text, "    fit: Legs(joints: ({a:?}, {b:?}, {c:?}), links: ({d:?}, {e:?}, {f:?})),");
            }
        }
        if self.stride != 1.0 {
            let _ = writeln!(text, "    stride: {},", number(self.stride));
        }
        if self.lift != 0.0 {
            let _ = writeln!(text, "    lift: {},", number(self.lift));
        }
        if !self.soles.is_empty() {
            let _ = writeln!(
                text,
                "    // The lowest point of these over the clip is put on the ground; so large a part of the poses may dip below.\n    \
                 soles: {},\n    sole_fraction: {},",
                list(&self.soles),
                number(self.sole_fraction)
            );
        }
        text += ")\n";
        Ok(text)
    }

    /// Writes a `*.map.ron` file.
    pub fn save(&self, path: impl AsRef<Path>, remarks: &[String]) -> Result<(), MapError> {
        let path = path.as_ref();
        std::fs::write(path, self.to_ron(remarks)?)
            .map_err(|e| MapError::File { path: path.to_path_buf(), reason: e.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_come_back_from_their_text() {
        for map in JointMap::built_in() {
            let text = map.to_ron(&["A remark\nof two lines".into()]).unwrap();
            assert_eq!(JointMap::from_ron(&text).unwrap(), map, "{text}");
        }
        let mut map = JointMap::built_in().next().unwrap();
        map.unit = 0.0254 / 0.45;
        map.root.up = Some(DVec3::new(0.6, 0.8, 0.0));
        map.root.facing = Some(DVec3::NEG_Z);
        map.root.rest_degrees = DVec3::new(1.0, -2.5, 0.0);
        map.links[0].link = "a \"quoted\" name".into();
        (map.fit, map.anchor) = (Fit::Factor(1.25), RootAnchor::Joint);
        (map.stride, map.lift) = (0.5, -0.02);
        map.soles.clear();
        let text = map.to_ron(&[]).unwrap();
        assert_eq!(JointMap::from_ron(&text).unwrap(), map, "{text}");
    }
}
