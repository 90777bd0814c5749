//! Contract: bodies are compared by their numbers.
//!
//! A name says nothing: users call their own body `skater`. The fingerprint is equal for equal bodies whatever they are called,
//! and changes with any one number, so that a policy, a recording or a snapshot is never played on a body that it was not made for.

use bevy_athlete::asset::Character;
use bevy_athlete::model::{
    CharacterModel, ContactKind, JointKind, LeanLaw, PRESET_NAMES, PointRole, Shape, preset, preset_source,
};
use std::collections::BTreeMap;

fn model(name: &str) -> CharacterModel {
    (*preset(name).expect("a preset")).clone()
}

#[test]
fn the_name_does_not_count_and_building_again_changes_nothing() {
    for name in PRESET_NAMES {
        let (file, text) = preset_source(name).expect("a preset");
        let mut again =
            CharacterModel::build(&Character::parse(file, text.as_bytes()).expect("a character")).expect("a model");
        assert_eq!(again.fingerprint(), model(name).fingerprint(), "{name}");
        again.name = "somebody".into();
        assert_eq!(again.fingerprint(), model(name).fingerprint(), "{name}");
    }
}

#[test]
fn presets_differ() {
    let all: BTreeMap<u64, &str> = PRESET_NAMES.into_iter().map(|n| (model(n).fingerprint(), n)).collect();
    assert_eq!(all.len(), PRESET_NAMES.len(), "{all:?}");
}

/// Changes of one number or name each, every kind that a model has.
#[test]
fn every_number_counts() {
    type Change = (&'static str, fn(&mut CharacterModel));
    let changes: [Change; 41] = [
        ("step rate", |m| m.step_rate += 1.0),
        ("link's name", |m| m.links[3].name.push('x')),
        ("links swapped by name", |m| {
            let (a, b) = (m.links[1].name.clone(), m.links[2].name.clone());
            (m.links[1].name, m.links[2].name) = (b, a);
        }),
        ("parent", |m| m.links[3].parent = Some(0)),
        ("joint", |m| {
            let axis = glam::DVec3::X;
            m.links[1].joint = JointKind::Hinge { axis };
        }),
        ("hinge's axis", |m| m.links[1].joint = JointKind::Hinge { axis: glam::DVec3::new(0.6, 0.0, 0.8) }),
        ("offset", |m| m.links[1].offset.y += 1e-9),
        ("mass", |m| m.links[1].mass += 1e-9),
        ("centre of mass", |m| m.links[1].com.z -= 1e-9),
        ("inertia", |m| m.links[1].inertia.x_axis.x += 1e-10),
        ("product of inertia", |m| m.links[1].inertia.y_axis.z += 1e-10),
        ("stiffness", |m| m.links[1].gains.kp += 1e-8),
        ("damping", |m| m.links[1].gains.kd += 1e-8),
        ("torque limit", |m| m.links[1].max_torque = 77.0),
        ("armature", |m| m.links[1].armature = 1e-9),
        ("spring", |m| {
            m.links[1].spring =
                Some(bevy_athlete::model::JointSpring { stiffness: 1.0, damping: 0.0, rest: glam::DVec3::ZERO });
        }),
        ("no joint range", |m| m.links.iter_mut().for_each(|l| l.limits = None)),
        ("joint range", |m| {
            let link = m.links.iter_mut().find(|l| l.limits.is_some()).expect("a limit");
            if let Some(limits) = &mut link.limits {
                limits.high.y += 1e-9;
            }
        }),
        ("shape left out", |m| m.links[1].shapes.clear()),
        ("shape", |m| m.links[1].shapes.push(Shape::Sphere { center: glam::DVec3::ZERO, radius: 0.01 })),
        ("another shape", |m| {
            let (a, b) = (glam::DVec3::ZERO, glam::DVec3::Y);
            m.links[1].shapes[0] = Shape::Capsule { a, b, radius: 0.01 };
        }),
        ("contact point left out", |m| m.contact_points.truncate(m.contact_points.len() - 1)),
        ("contact point's link", |m| m.contact_points[0].link += 1),
        ("contact point's name", |m| m.contact_points[0].name.push('x')),
        ("contact point's place", |m| m.contact_points[0].position.x += 1e-9),
        ("contact point's radius", |m| m.contact_points[0].radius += 1e-9),
        ("contact point's friction", |m| m.contact_points[0].friction += 1e-9),
        ("contact point's kind", |m| m.contact_points[0].kind = ContactKind::BladeToe(7)),
        ("blade left out", |m| m.blades.truncate(m.blades.len() - 1)),
        ("blade's name", |m| m.blades[0].name.push('x')),
        ("blade's end", |m| m.blades[0].toe += 1),
        ("blade's inside", |m| m.blades[0].inside = -m.blades[0].inside),
        ("blade's law", |m| m.blades[0].lean_law = LeanLaw::Rocker { radius: 1.5 }),
        ("blade's hold", |m| m.blades[0].bite = Some(0.123)),
        ("grip", |m| {
            let position = glam::DVec3::ZERO;
            m.grips.push(bevy_athlete::model::Grip { name: "nose".into(), link: 1, position, max_force: 300.0 });
        }),
        ("grip's force", |m| m.grips[0].max_force += 1.0),
        ("contact point's role", |m| m.contact_points[0].role = PointRole::Hand),
        ("foot left out", |m| m.feet.truncate(1)),
        ("foot's side", |m| m.feet[0].side = None),
        ("trunk", |m| m.trunk = 0),
        ("pairs that collide", |m| m.collision_pairs.truncate(m.collision_pairs.len() - 1)),
    ];
    let mut seen = BTreeMap::from([(model("skater").fingerprint(), "nothing")]);
    for (what, change) in changes {
        let mut changed = model("skater");
        change(&mut changed);
        if let Some(same) = seen.insert(changed.fingerprint(), what) {
            panic!("{what}: the fingerprint is that of {same} changed");
        }
    }
}

/// The last bits of what a sine gives differ between machines, and both zeros are the same place.
#[test]
fn rounding_does_not_count() {
    let plain = model("foot_human");
    let mut rounded = plain.clone();
    let next = |v: &mut f64| *v = f64::from_bits(v.to_bits() + 1);
    for link in &mut rounded.links {
        next(&mut link.mass);
        next(&mut link.inertia.x_axis.x);
        if link.offset.x == 0.0 {
            link.offset.x = -0.0;
        }
    }
    assert_ne!(plain.links[1].mass.to_bits(), rounded.links[1].mass.to_bits());
    assert_eq!(plain.fingerprint(), rounded.fingerprint());
}
