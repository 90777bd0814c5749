//! Validation of a course file: every name known, every number in its range at the ends of the parameters' ranges.

use super::instance::nodes;
use super::{Course, CourseError, Quantity, SolidEntry};

/// Checks a whole course.
pub(super) fn check(course: &Course) -> Result<(), CourseError> {
    let file = course.shown();
    check_name(course, "name", &course.name)?;
    for (k, parameter) in course.parameters.iter().enumerate() {
        check_name(course, "parameter", &parameter.name)?;
        if course.parameters[..k].iter().any(|p| p.name == parameter.name) {
            let name = parameter.name.as_str().into();
            return Err(CourseError::Duplicate { file: file.into(), what: "parameter", name });
        }
        let (low, high) = parameter.range;
        let place = format!("parameter `{}`", parameter.name);
        let bad = |field, value: String, valid: String| {
            let (place, value, valid) = (place.as_str().into(), value.into(), valid.into());
            Err(CourseError::Value { file: file.into(), place, field, value, valid })
        };
        if !(low.abs() <= 1e6 && high.abs() <= 1e6 && low <= high) {
            return bad("range", format!("({low}, {high})"), "(low, high) with -1e6 <= low <= high <= 1e6".into());
        }
        let default = parameter.default_value();
        if !(default >= low && default <= high) {
            return bad("default", default.to_string(), format!("a number from {low} to {high}"));
        }
    }
    for (k, material) in course.materials.iter().enumerate() {
        check_name(course, "material", &material.name)?;
        let own = crate::asset::Material::named(&material.name).is_some();
        if own || course.materials[..k].iter().any(|m| m.name == material.name) {
            let name = material.name.as_str().into();
            return Err(CourseError::Duplicate { file: file.into(), what: "material", name });
        }
    }
    check_names(course)?;
    check_counts(course)?;
    check_ground(course)?;

    // The numbers, where the parameters are at their defaults, and all lowest and highest.
    let ends = |high: bool| course.parameters.iter().map(|p| if high { p.range.1 } else { p.range.0 }).collect();
    for values in [course.defaults(), ends(false), ends(true)] {
        course.instance(&values, 0)?;
    }
    Ok(())
}

fn check_name(course: &Course, field: &'static str, name: &str) -> Result<(), CourseError> {
    let letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
    if first && name.len() <= 64 && name.chars().all(letter) {
        return Ok(());
    }
    Err(CourseError::Value {
        file: course.shown().into(),
        place: "course".into(),
        field,
        value: format!("{:?}", name.chars().take(64).collect::<String>()).into(),
        valid: "a letter, then letters, digits and _, at most 64 in all".into(),
    })
}

fn check_counts(course: &Course) -> Result<(), CourseError> {
    let solids = course.solids.iter().map(|s| if let SolidEntry::Stairs { count, .. } = s { *count } else { 1 });
    let solids = solids.fold(0, usize::saturating_add);
    let nodes = course.solids.iter().map(|s| match s {
        SolidEntry::Bumps { length, width, spacing, .. } => nodes(*length, *width, *spacing).iter().product(),
        _ => 0,
    });
    for (what, count, most) in [
        ("parameters", course.parameters.len(), 64),
        ("materials", course.materials.len(), 64),
        ("solids (steps of stairs counted)", solids, Course::MAX_SOLIDS),
        ("nodes of bumps", nodes.fold(0, usize::saturating_add), Course::MAX_NODES),
    ] {
        if count > most {
            return Err(CourseError::Count { file: course.shown().into(), what, count, most });
        }
    }
    Ok(())
}

/// Every parameter and material that is named.
fn check_names(course: &Course) -> Result<(), CourseError> {
    let formula = |place: &str, field, of: &Quantity| {
        let unknown = of.formula().and_then(|f| f.names().find(|n| course.parameter(n).is_none()));
        unknown.map_or(Ok(()), |name| {
            Err(CourseError::Name {
                file: course.shown().into(),
                place: place.into(),
                field: "parameter",
                name: name.into(),
                valid: format!("{} (in field {field})", course.parameter_names()).into(),
            })
        })
    };
    let material = |place: &str, name: &str| match course.material(name) {
        Some(_) => Ok(()),
        None => {
            let own = course.materials.iter().map(|m| m.name.as_str());
            let names: Vec<&str> = crate::asset::Material::NAMES.into_iter().chain(own).collect();
            Err(CourseError::Name {
                file: course.shown().into(),
                place: place.into(),
                field: "material",
                name: name.chars().take(64).collect::<String>().into(),
                valid: format!("one of {}", names.join(", ")).into(),
            })
        }
    };
    if let Some(ground) = &course.ground {
        material("ground", &ground.material)?;
        formula("ground", "friction", &ground.friction)?;
        formula("ground", "slope", &ground.slope)?;
    }
    if let Some(width) = &course.side_walls {
        formula("course", "side_walls", width)?;
    }
    for (k, solid) in course.solids.iter().enumerate() {
        let place = format!("solid {} ({})", k + 1, solid.kind());
        if let Some(name) = solid.material() {
            material(&place, name)?;
        }
        solid.quantities().into_iter().try_for_each(|(field, of)| formula(&place, field, of))?;
        let whole = |field, value: f64, low: f64, high: f64| {
            let ok = value >= low && value <= high;
            let (file, place) = (course.shown().into(), place.as_str().into());
            let valid = format!("a number from {low} to {high} m").into();
            if ok {
                Ok(())
            } else {
                Err(CourseError::Value { file, place, field, value: value.to_string().into(), valid })
            }
        };
        match solid {
            SolidEntry::Stairs { count, .. } if !(1..=Course::MAX_SOLIDS).contains(count) => {
                return Err(CourseError::Value {
                    file: course.shown().into(),
                    place: place.into(),
                    field: "count",
                    value: count.to_string().into(),
                    valid: format!("1 to {}", Course::MAX_SOLIDS).into(),
                });
            }
            SolidEntry::Bumps { length, width, spacing, .. } => {
                whole("spacing", *spacing, 0.02, 100.0)?;
                whole("length", *length, 2.0 * spacing, 1000.0)?;
                whole("width", *width, 2.0 * spacing, 1000.0)?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Gaps and bumps are in the course's own ground, and not both.
fn check_ground(course: &Course) -> Result<(), CourseError> {
    let place = |k: usize| format!("solid {} ({})", k + 1, course.solids[k].kind()).into();
    let find = |is: fn(&SolidEntry) -> bool| course.solids.iter().position(is);
    let gap = find(|s| matches!(s, SolidEntry::Gap { .. }));
    let bumps = find(|s| matches!(s, SolidEntry::Bumps { .. }));
    let together =
        |k, reason, valid| Err(CourseError::Together { file: course.shown().into(), place: place(k), reason, valid });
    if let (Some(k), None) = (gap.or(bumps), &course.ground) {
        return together(k, "the course has no ground of its own", "`ground: (friction: 0.8)` in the course");
    }
    if let (Some(a), Some(b)) = (gap, bumps) {
        return together(a.max(b), "gaps and bumps in one course", "gaps, or one field of bumps");
    }
    let slope = course.ground.as_ref().is_some_and(|ground| ground.slope != Quantity::ZERO);
    if let (Some(k), true) = (gap, slope) {
        return together(k, "a gap in ground that has a slope", "gaps in level ground");
    }
    let mut rough = course.solids.iter().enumerate().filter(|(_, s)| matches!(s, SolidEntry::Bumps { .. }));
    if let Some((k, _)) = rough.nth(1) {
        return together(k, "a second field of bumps", "one field of bumps");
    }
    Ok(())
}
