//! An exported character is well-formed XML that holds the whole body: every link with its mass, every contact point.
//!
//! The scan below knows nothing of the exporter: it reads tags and attributes and checks the nesting. Whether MuJoCo
//! computes the same dynamics is another test's business (the reference numbers of `benches/mujoco/reference.py`). Set
//! `MJCF_DIR` to keep the files of the characters.

use crate::puppet::puppet;
use bevy_athlete::model::{JointKind, PRESET_NAMES, export_mjcf, preset};
use std::collections::HashMap;

struct Tag {
    name: String,
    /// Names of the open elements, the outermost first.
    inside: Vec<(String, String)>,
    attributes: HashMap<String, String>,
}

impl Tag {
    fn numbers(&self, attribute: &str) -> Vec<f64> {
        self.attributes[attribute].split(' ').map(|n| n.parse().unwrap()).collect()
    }
}

fn unescape(text: &str) -> String {
    let plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'");
    plain.replace("&amp;", "&")
}

/// Reads all tags; panics where they are not nested, an attribute is not quoted or repeated, or a reference is open.
fn scan(xml: &str) -> Vec<Tag> {
    let mut tags = Vec::new();
    let mut open: Vec<(String, String)> = Vec::new();
    for piece in xml.split('<').skip(1) {
        let (inner, after) = piece.split_once('>').expect("an unclosed tag");
        assert!(after.trim().is_empty() && !after.contains('&'), "text between tags: {after:?}");
        if let Some(name) = inner.strip_prefix('/') {
            assert_eq!(open.pop().expect("nothing is open").0, name);
            continue;
        }
        let (inner, empty) = inner.strip_suffix('/').map_or((inner, false), |i| (i, true));
        let (name, mut rest) = inner.split_once(' ').unwrap_or((inner, ""));
        let mut attributes = HashMap::new();
        while let Some((key, value)) = rest.trim_start().split_once("=\"") {
            let (value, tail) = value.split_once('"').expect("an unclosed attribute");
            for reference in value.split('&').skip(1) {
                assert!(["lt;", "gt;", "amp;", "quot;", "apos;"].iter().any(|r| reference.starts_with(r)), "{value}");
            }
            assert!(attributes.insert(key.to_string(), unescape(value)).is_none(), "{key} twice");
            rest = tail;
        }
        assert!(rest.trim().is_empty(), "left over: {rest}");
        let id = attributes.get("name").cloned().unwrap_or_default();
        tags.push(Tag { name: name.into(), inside: open.clone(), attributes });
        if !empty {
            open.push((name.into(), id));
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
    tags
}

#[test]
fn the_tree_is_kept() {
    let model = puppet();
    let tags = scan(&export_mjcf(&model));
    let bodies: Vec<&Tag> = tags.iter().filter(|t| t.name == "body").collect();
    assert_eq!(bodies.len(), model.links.len());
    for (body, link) in bodies.iter().zip(&model.links) {
        assert_eq!(body.attributes["name"], link.name);
        let (kind, parent) = body.inside.last().unwrap();
        match link.parent {
            None => assert_eq!(kind, "worldbody"),
            Some(p) => {
                assert_eq!(parent, &model.links[p].name);
                assert_eq!(body.numbers("pos"), link.offset.to_array());
            }
        }
        let joint = tags
            .iter()
            .find(|t| t.name.ends_with("joint") && t.inside.last().is_some_and(|i| i.1 == link.name))
            .unwrap();
        match link.joint {
            JointKind::Free => assert_eq!(joint.name, "freejoint"),
            JointKind::Ball => assert_eq!(joint.attributes["type"], "ball"),
            JointKind::Hinge { axis } => assert_eq!(joint.numbers("axis"), axis.to_array()),
        }
    }
}

#[test]
fn masses_and_inertias_are_kept_to_the_bit() {
    let model = puppet();
    let tags = scan(&export_mjcf(&model));
    let inertials: Vec<&Tag> = tags.iter().filter(|t| t.name == "inertial").collect();
    assert_eq!(inertials.len(), model.links.len());
    for (inertial, link) in inertials.iter().zip(&model.links) {
        assert_eq!(inertial.numbers("mass"), [link.mass]);
        assert_eq!(inertial.numbers("pos"), link.com.to_array());
        let m = link.inertia.to_cols_array_2d();
        assert_eq!(inertial.numbers("fullinertia"), [m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]]);
    }
    let total: f64 = inertials.iter().map(|i| i.numbers("mass")[0]).sum();
    assert_eq!(total, model.mass());
}

#[test]
fn every_contact_point_has_a_site_and_a_sphere_on_its_link() {
    let model = puppet();
    let tags = scan(&export_mjcf(&model));
    assert_eq!(tags.iter().filter(|t| t.name == "site").count(), model.contact_points.len());
    for point in &model.contact_points {
        for kind in ["site", "geom"] {
            let tag =
                tags.iter().find(|t| t.name == kind && t.attributes.get("name") == Some(&point.name)).expect("missing");
            assert_eq!(tag.inside.last().unwrap().1, model.links[point.link].name);
            assert!(tag.numbers("size")[0] > 0.0);
        }
    }
    // Nothing but the spheres and the floor collides.
    let colliding = tags.iter().filter(|t| t.name == "geom" && t.attributes["contype"] != "0").count();
    assert_eq!(colliding, model.contact_points.len() + 1);
}

#[test]
fn the_world_is_ours() {
    let model = puppet();
    let xml = export_mjcf(&model);
    let tags = scan(&xml);
    let tag = |name: &str| tags.iter().find(|t| t.name == name).unwrap();
    assert_eq!(tag("option").numbers("gravity"), [0.0, -9.81, 0.0]);
    assert_eq!(tag("option").numbers("timestep"), [1.0 / 1200.0]);
    assert_eq!(tag("compiler").attributes["inertiafromgeom"], "false");
    assert_eq!(tag("compiler").attributes["balanceinertia"], "false");
    assert_eq!(tag("numeric").numbers("data"), model.links.iter().map(|l| l.gains.kp).collect::<Vec<_>>());
    assert!(!xml.contains("NaN") && !xml.contains("inf"));
}

#[test]
fn all_characters_are_exported_whole() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let xml = export_mjcf(&model);
        let tags = scan(&xml);
        let count = |kind: &str| tags.iter().filter(|t| t.name == kind).count();
        assert_eq!((count("body"), count("inertial")), (model.links.len(), model.links.len()), "{name}");
        assert_eq!(count("site"), model.contact_points.len(), "{name}");
        let mass: f64 = tags.iter().filter(|t| t.name == "inertial").map(|t| t.numbers("mass")[0]).sum();
        assert!((mass - model.mass()).abs() < 1e-12 * mass, "{name}: {mass} kg");
        if let Ok(dir) = std::env::var("MJCF_DIR") {
            std::fs::write(std::path::Path::new(&dir).join(name).with_extension("xml"), &xml).unwrap();
        }
    }
}
