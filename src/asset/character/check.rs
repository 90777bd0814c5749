//! Validation of a character: every number finite and in range, every name known, the links one tree, every inertia that of
//! a possible body.

mod parts;

use super::{Character, JointEntry, LeanLawEntry, LinkEntry, ShapeEntry};
use crate::asset::CharacterError;
use glam::{DMat3, DVec3};
use parts::{MAX_FEET, check_parts};
use std::collections::HashMap;
use std::fmt::Debug;

/// Farthest any point may lie from the character's origin, m.
const REACH: f64 = 100.0;
/// Smallest size of a solid, m.
const SMALLEST: f64 = 1e-4;

/// Validates the whole character.
pub(super) fn check(character: &Character) -> Result<(), CharacterError> {
    let file = if character.file.is_empty() { "character built in code" } else { character.file.as_str() };
    let whole = Entry { file, part: "character", name: &character.name };
    whole.name()?;
    whole.number("step_rate", character.step_rate, 30.0, 20_000.0, "/s")?;
    whole.gains(character.gains.kp, character.gains.kd)?;
    check_counts(character, file)?;

    // Names first, so that every later message can rely on them.
    let links = unique(file, "link", character.links.iter().map(|l| l.name.as_str()))?;
    check_tree(character, file, &links)?;
    for link in &character.links {
        check_link(&Entry { file, part: "link", name: &link.name }, link)?;
    }
    check_attachments(character, file, &links)?;
    check_parts(character, file, &links)
}

/// One entry of the file, for messages.
struct Entry<'a> {
    file: &'a str,
    part: &'static str,
    name: &'a str,
}

impl Entry<'_> {
    /// A refusal of this entry.
    fn refuse(&self, field: &'static str, value: impl Debug, valid: impl Into<Box<str>>) -> CharacterError {
        let value: String = format!("{value:?}").chars().take(80).collect();
        CharacterError::Value {
            file: self.file.into(),
            part: self.part,
            name: shown(self.name),
            field,
            value: value.into(),
            valid: valid.into(),
        }
    }
    fn name(&self) -> Result<(), CharacterError> {
        let letter = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(letter) {
            return Err(self.refuse("name", self.name, "1 to 64 letters, digits, `_`, `-` or `.`"));
        }
        Ok(())
    }
    /// NaN fails every comparison, so it is refused with the rest.
    fn number(&self, field: &'static str, value: f64, low: f64, high: f64, unit: &str) -> Result<(), CharacterError> {
        if value >= low && value <= high {
            return Ok(());
        }
        let space = if unit.is_empty() || unit.starts_with('/') { "" } else { " " };
        Err(self.refuse(field, value, format!("a number from {low} to {high}{space}{unit}")))
    }
    fn point(&self, field: &'static str, value: DVec3) -> Result<(), CharacterError> {
        if value.to_array().iter().all(|c| c.abs() <= REACH) {
            return Ok(());
        }
        Err(self.refuse(field, value.to_array(), format!("three numbers from -{REACH} to {REACH} m")))
    }
    fn unit(&self, field: &'static str, value: DVec3) -> Result<(), CharacterError> {
        let length = value.length();
        if (0.99..=1.01).contains(&length) {
            return Ok(());
        }
        Err(self.refuse(field, value.to_array(), "a vector of length 1 (within 0.01)"))
    }
    fn gains(&self, kp: f64, kd: f64) -> Result<(), CharacterError> {
        self.number("gains.kp", kp, 0.0, 1e6, "N m/rad")?;
        self.number("gains.kd", kd, 0.0, 1e5, "N m s/rad")
    }
}

/// A name short enough for a message.
fn shown(name: &str) -> Box<str> {
    name.chars().take(64).collect::<String>().into()
}

/// The valid choices of a link name.
fn one_of(links: &HashMap<&str, usize>) -> String {
    let mut names: Vec<&str> = links.keys().copied().collect();
    names.sort_by_key(|name| links[name]);
    let rest = names.len().saturating_sub(24);
    names.truncate(24);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    format!("one of {}{more}", names.join(", "))
}

fn check_counts(character: &Character, file: &str) -> Result<(), CharacterError> {
    let points = character.contact_points.len() + 2 * character.blades.len();
    let shapes = character.links.iter().map(|l| l.shapes.len()).max().unwrap_or(0);
    for (what, count, least, most) in [
        ("links", character.links.len(), 1, Character::MAX_LINKS),
        ("contact points (blade ends included)", points, 0, Character::MAX_POINTS),
        ("blades", character.blades.len(), 0, 16),
        ("grips", character.grips.len(), 0, 64),
        ("feet", character.feet.len(), 0, MAX_FEET),
        ("no_collision pairs", character.no_collision.len(), 0, Character::MAX_LINKS * Character::MAX_LINKS / 2),
        ("shapes on one link", shapes, 0, 64),
    ] {
        if !(least..=most).contains(&count) {
            return Err(CharacterError::Count {
                file: file.into(),
                what,
                count,
                valid: format!("{least} to {most}").into(),
            });
        }
    }
    Ok(())
}

/// Valid, different names and their positions.
fn unique<'a>(
    file: &'a str,
    part: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<HashMap<&'a str, usize>, CharacterError> {
    let mut places = HashMap::new();
    for (index, name) in names.enumerate() {
        Entry { file, part, name }.name()?;
        if let Some(first) = places.insert(name, index) {
            let (first, second) = (first + 1, index + 1);
            return Err(CharacterError::Duplicate { file: file.into(), part, name: name.into(), first, second });
        }
    }
    Ok(places)
}

/// Known parents, no cycle, one root; the root and only the root is free.
fn check_tree(character: &Character, file: &str, links: &HashMap<&str, usize>) -> Result<(), CharacterError> {
    let all = &character.links;
    let mut parents = Vec::with_capacity(all.len());
    for link in all {
        parents.push(match &link.parent {
            None => None,
            Some(parent) => Some(*links.get(parent.as_str()).ok_or_else(|| CharacterError::UnknownParent {
                file: file.into(),
                link: shown(&link.name),
                parent: shown(parent),
                valid: one_of(links).into(),
            })?),
        });
    }
    for start in 0..all.len() {
        // A chain longer than the number of links has met a link twice.
        let (mut at, mut chain) = (start, vec![all[start].name.as_str()]);
        while let Some(parent) = parents[at] {
            at = parent;
            chain.push(&all[at].name);
            if at == start {
                let chain = chain.join(" -> ").into();
                return Err(CharacterError::Cycle { file: file.into(), link: shown(&all[start].name), chain });
            }
            if chain.len() > all.len() {
                // The cycle does not pass through `start`; it is reported from one of its own links.
                break;
            }
        }
    }
    let roots: Vec<&str> = all.iter().filter(|l| l.parent.is_none()).map(|l| l.name.as_str()).collect();
    if roots.len() != 1 {
        let (count, mut roots) = (roots.len(), roots);
        roots.truncate(8);
        let roots = if count == 0 { "none".to_owned() } else { roots.join(", ") };
        return Err(CharacterError::Roots { file: file.into(), count, roots: roots.into() });
    }
    for link in all {
        let free = link.joint == JointEntry::Free;
        if free != link.parent.is_none() {
            let valid = if free { "Ball, Hinge or Weld for a link with a parent" } else { "Free for the root" };
            return Err(Entry { file, part: "link", name: &link.name }.refuse("joint", link.joint, valid));
        }
    }
    Ok(())
}

fn check_link(entry: &Entry, link: &LinkEntry) -> Result<(), CharacterError> {
    entry.point("position", link.position)?;
    entry.number("mass", link.mass, 1e-4, 1e3, "kg")?;
    if let Some(com) = link.com {
        entry.point("com", com)?;
    }
    for shape in &link.shapes {
        check_shape(entry, shape)?;
    }
    match link.inertia {
        Some(inertia) => check_inertia(entry, inertia)?,
        None if link.shapes.is_empty() => {
            return Err(entry.refuse("inertia", "missing", "six numbers, or shapes to compute it from"));
        }
        None => {}
    }
    if let JointEntry::Hinge { axis } = link.joint {
        entry.unit("joint axis", axis)?;
    }

    // A joint that does not move, or moves freely, has no servo and no range.
    let driven = matches!(link.joint, JointEntry::Ball | JointEntry::Hinge { .. });
    if !driven {
        let none = "nothing on a Free or Weld joint";
        if let Some(gains) = link.gains {
            return Err(entry.refuse("gains", (gains.kp, gains.kd), none));
        }
        if let Some(torque) = link.max_torque {
            return Err(entry.refuse("max_torque", torque, none));
        }
        if let Some(limits) = link.limits {
            return Err(entry.refuse("limits", (limits.x, limits.y, limits.z), none));
        }
        if let Some(armature) = link.armature {
            return Err(entry.refuse("armature", armature, none));
        }
        if let Some(spring) = link.spring {
            return Err(entry.refuse("spring", (spring.stiffness, spring.damping), none));
        }
    }
    if let Some(gains) = link.gains {
        entry.gains(gains.kp, gains.kd)?;
    }
    if let Some(torque) = link.max_torque {
        entry.number("max_torque", torque, 1e-3, 1e6, "N m")?;
    }
    if let Some(armature) = link.armature {
        entry.number("armature", armature, 0.0, 1e3, "kg m^2")?;
    }
    if let Some(spring) = link.spring {
        entry.number("spring stiffness", spring.stiffness, 0.0, 1e6, "N m/rad")?;
        entry.number("spring damping", spring.damping, 0.0, 1e5, "N m s/rad")?;
        if !spring.rest.to_array().iter().all(|a| a.abs() <= 180.0) {
            let valid = "three numbers from -180 to 180 degrees";
            return Err(entry.refuse("spring rest", spring.rest.to_array(), valid));
        }
    }
    if let Some(limits) = link.limits {
        for (field, (low, high)) in [("limits.x", limits.x), ("limits.y", limits.y), ("limits.z", limits.z)] {
            let valid = "(low, high) with -180 <= low <= high <= 180 degrees";
            if !(low >= -180.0 && low <= high && high <= 180.0) {
                return Err(entry.refuse(field, (low, high), valid));
            }
        }
    }
    Ok(())
}

fn check_shape(entry: &Entry, shape: &ShapeEntry) -> Result<(), CharacterError> {
    match *shape {
        ShapeEntry::Box { center, size, rotation } => {
            entry.point("box center", center)?;
            if !size.to_array().iter().all(|s| (SMALLEST..=REACH).contains(s)) {
                let valid = format!("three numbers from {SMALLEST} to {REACH} m");
                return Err(entry.refuse("box size", size.to_array(), valid));
            }
            if !rotation.to_array().iter().all(|a| a.abs() <= 360.0) {
                let valid = "three numbers from -360 to 360 degrees";
                return Err(entry.refuse("box rotation", rotation.to_array(), valid));
            }
        }
        ShapeEntry::Capsule { a, b, radius } => {
            entry.point("capsule a", a)?;
            entry.point("capsule b", b)?;
            entry.number("capsule radius", radius, SMALLEST, REACH, "m")?;
        }
        ShapeEntry::Sphere { center, radius } => {
            entry.point("sphere center", center)?;
            entry.number("sphere radius", radius, SMALLEST, REACH, "m")?;
        }
    }
    Ok(())
}

/// Positive definite, and no principal moment above the sum of the other two (the triangle inequality of mass in space).
fn check_inertia(entry: &Entry, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Result<(), CharacterError> {
    let values = [xx, yy, zz, xy, xz, yz];
    if !values.iter().all(|v| v.abs() <= 1e7) {
        return Err(entry.refuse("inertia", values, "six numbers from -1e7 to 1e7 kg m^2"));
    }
    let columns = [DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz)];
    let principal = eigenvalues(DMat3::from_cols(columns[0], columns[1], columns[2]));
    let [low, middle, high] = principal;
    if low > 1e-9 * high && low > 1e-15 && high <= (low + middle) * (1.0 + 1e-6) {
        return Ok(());
    }
    Err(CharacterError::Inertia { file: entry.file.into(), link: entry.name.into(), principal })
}

/// Eigenvalues of a symmetric matrix, ascending, by the trigonometric solution of its characteristic cubic (Smith 1961,
/// "Eigenvalues of a symmetric 3 x 3 matrix"). Exact zeros and multiples come out to rounding.
fn eigenvalues(m: DMat3) -> [f64; 3] {
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let deviator = m - DMat3::from_diagonal(DVec3::splat(mean));
    let square = |v: DVec3| v.length_squared();
    let p = ((square(deviator.x_axis) + square(deviator.y_axis) + square(deviator.z_axis)) / 6.0).sqrt();
    if p == 0.0 {
        return [mean; 3];
    }
    let r = ((deviator * (1.0 / p)).determinant() / 2.0).clamp(-1.0, 1.0);
    let angle = r.acos() / 3.0;
    let high = mean + 2.0 * p * angle.cos();
    let low = mean + 2.0 * p * (angle + core::f64::consts::TAU / 3.0).cos();
    [low, 3.0 * mean - high - low, high]
}

/// Contact points, blades, grips and exclusions.
fn check_attachments(character: &Character, file: &str, links: &HashMap<&str, usize>) -> Result<(), CharacterError> {
    let known = |part: &'static str, name: &str, link: &str| match links.contains_key(link) {
        true => Ok(()),
        false => Err(CharacterError::UnknownLink {
            file: file.into(),
            part,
            name: shown(name),
            link: shown(link),
            valid: one_of(links).into(),
        }),
    };
    unique(file, "blade", character.blades.iter().map(|b| b.name.as_str()))?;
    unique(file, "grip", character.grips.iter().map(|g| g.name.as_str()))?;
    let ends: Vec<String> = character.blades.iter().flat_map(|b| b.end_names()).collect();
    let own = character.contact_points.iter().map(|c| c.name.as_str());
    unique(file, "contact point", own.chain(ends.iter().map(String::as_str)))?;

    for point in &character.contact_points {
        let entry = Entry { file, part: "contact point", name: &point.name };
        known(entry.part, &point.name, &point.link)?;
        entry.point("position", point.position)?;
        entry.number("radius", point.radius, 0.0, 1.0, "m")?;
        entry.number("friction", point.friction, 0.0, 10.0, "")?;
    }
    for blade in &character.blades {
        let entry = Entry { file, part: "blade", name: &blade.name };
        known(entry.part, &blade.name, &blade.link)?;
        entry.point("toe", blade.toe)?;
        entry.point("heel", blade.heel)?;
        entry.unit("inside", blade.inside)?;
        let along = blade.toe - blade.heel;
        if along.length() < 1e-3 {
            let valid = format!("a point at least 1 mm from the heel at {:?}", blade.heel.to_array());
            return Err(entry.refuse("toe", blade.toe.to_array(), valid));
        }
        if blade.inside.dot(along.normalize()).abs() > 0.1 {
            return Err(entry.refuse("inside", blade.inside.to_array(), "a vector across the line from heel to toe"));
        }
        match blade.lean_law {
            LeanLawEntry::DeadZone { dead_zone, gain } => {
                entry.number("lean_law dead_zone", dead_zone, 0.0, 90.0, "degrees")?;
                entry.number("lean_law gain", gain, 0.0, 100.0, "1/(m rad)")?;
            }
            LeanLawEntry::Rocker { radius } => entry.number("lean_law radius", radius, 0.1, 1e3, "m")?,
        }
        if let Some(bite) = blade.bite {
            entry.number("bite", bite, 0.0, 1e3, "")?;
        }
    }
    for grip in &character.grips {
        known("grip", &grip.name, &grip.link)?;
        let entry = Entry { file, part: "grip", name: &grip.name };
        entry.point("position", grip.position)?;
        if let Some(force) = grip.max_force {
            entry.number("max_force", force, 1.0, 1e5, "N")?;
        }
    }
    for (a, b) in &character.no_collision {
        known("no_collision pair", a, a)?;
        known("no_collision pair", b, b)?;
    }
    Ok(())
}
