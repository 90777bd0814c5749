//! Makes the free humanoid of this project: a skinned mesh of tapered capsules over 22 joints with the usual names of bones,
//! and the bone map that dresses the skater in it. Both lie in `assets/` already; this is how they came to be.
//!
//! The figure has the skater's measures and stands with its arms half raised, facing +Z as glTF files do. Each bone's +Y axis
//! runs along it. Toes, neck and ponytail follow no link: they are there for animations of your own.
//!
//! `cargo run --no-default-features --example make_humanoid`

use bevy_athlete::model::skater;
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// Segments around a capsule.
const AROUND: usize = 12;
/// How far the arms are raised, degrees.
const ARMS: f64 = 45.0;

/// A joint: its bone, its place at rest (skater's frame, m), the place its axis points to, and the capsule drawn along it.
struct Joint {
    name: String,
    parent: Option<usize>,
    place: DVec3,
    end: DVec3,
    /// Radii at the joint and at the end, m; `None` draws nothing.
    radii: Option<(f64, f64)>,
    /// Depth over width of the cross-section.
    depth: f64,
    link: Option<String>,
}

/// The skeleton, parents first.
fn joints() -> Vec<Joint> {
    let model = skater();
    let places = model.rest_positions();
    let up = DVec3::Y * model.rest_root_height();
    let place = |link: &str| up + places[model.link_index(link).expect("a link of the skater")];
    let mut joints: Vec<Joint> = Vec::new();
    let mut add = |name: String,
                   parent: Option<&str>,
                   place: DVec3,
                   end: DVec3,
                   shape: Option<(f64, f64, f64)>,
                   link: Option<String>| {
        let parent = parent.map(|p| joints.iter().position(|j| j.name == p).expect("parents come first"));
        let (radii, depth) = shape.map_or((None, 1.0), |(a, b, depth)| (Some((a, b)), depth));
        joints.push(Joint { name, parent, place, end, radii, depth, link });
    };
    let (hips, waist, chest, head) = (place("pelvis"), place("abdomen"), place("spine"), place("head"));
    let neck = head - DVec3::Y * 0.05;
    let link = |name: &str| Some(name.to_owned());
    add("Hips".into(), None, hips, waist, Some((0.115, 0.10, 0.75)), link("pelvis"));
    add("Spine".into(), Some("Hips"), waist, chest, Some((0.095, 0.10, 0.75)), link("abdomen"));
    add("Chest".into(), Some("Spine"), chest, neck - DVec3::Y * 0.04, Some((0.105, 0.085, 0.8)), link("spine"));
    add("Neck".into(), Some("Chest"), neck, head, Some((0.04, 0.038, 1.0)), None);
    add("Head".into(), Some("Neck"), head, head + DVec3::Y * 0.14, Some((0.055, 0.07, 1.15)), link("head"));
    let tail = head + DVec3::new(0.0, 0.12, 0.085);
    add("Ponytail".into(), Some("Head"), tail, tail + DVec3::new(0.0, -0.16, 0.05), Some((0.028, 0.012, 1.0)), None);
    for (side, end, sign) in [("Left", "left", -1.0), ("Right", "right", 1.0)] {
        let at = |link: &str| place(&format!("{link}_{end}"));
        let bone = |name: &str| format!("{side}{name}");
        let follows = |name: &str| Some(format!("{name}_{end}"));
        let shoulder = at("bicep");
        let raised = DQuat::from_rotation_z((sign * ARMS).to_radians());
        let arm = |link: &str| shoulder + raised * (at(link) - shoulder);
        let (elbow, wrist) = (arm("forearm"), arm("hand"));
        let fingers = wrist + raised * (DVec3::NEG_Y * 0.13);
        let collar = at("scapula") + DVec3::Y * 0.06;
        add(bone("Shoulder"), Some("Chest"), collar, shoulder, Some((0.05, 0.05, 0.9)), follows("scapula"));
        add(bone("Arm"), Some(&bone("Shoulder")), shoulder, elbow, Some((0.048, 0.036, 1.0)), follows("bicep"));
        add(bone("ForeArm"), Some(&bone("Arm")), elbow, wrist, Some((0.036, 0.025, 1.0)), follows("forearm"));
        add(bone("Hand"), Some(&bone("ForeArm")), wrist, fingers, Some((0.024, 0.018, 1.4)), follows("hand"));
        let (hip, knee, ankle) = (at("thigh"), at("shin"), at("foot"));
        let toes = ankle + DVec3::new(0.0, -0.05, -0.09);
        add(bone("UpLeg"), Some("Hips"), hip, knee, Some((0.078, 0.05, 1.0)), follows("thigh"));
        add(bone("Leg"), Some(&bone("UpLeg")), knee, ankle, Some((0.05, 0.035, 1.0)), follows("shin"));
        add(bone("Foot"), Some(&bone("Leg")), ankle, toes, Some((0.04, 0.034, 0.8)), follows("foot"));
        add(bone("ToeBase"), Some(&bone("Foot")), toes, toes + DVec3::NEG_Z * 0.05, Some((0.033, 0.027, 0.8)), None);
    }
    joints
}

/// From the skater's frame, facing -Z, to the file's, facing +Z.
fn turned(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, v.y, -v.z)
}

/// Bone axes to the file's frame: +Y along the bone.
fn axes(joint: &Joint) -> DQuat {
    DQuat::from_rotation_arc(DVec3::Y, turned(joint.end - joint.place).normalize())
}

/// The mesh: one vertex buffer for all capsules.
#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    joints: Vec<[u8; 4]>,
    weights: Vec<[u8; 4]>,
    indices: Vec<u16>,
}

impl Mesh {
    /// A tapered capsule along a joint's bone. Near its ends it goes half with the neighbour.
    fn add(&mut self, all: &[Joint], index: usize) {
        let joint = &all[index];
        let Some((radius_a, radius_b)) = joint.radii else { return };
        let (a, b, rotation) = (turned(joint.place), turned(joint.end), axes(joint));
        let length = (b - a).length();
        // The next bone along the limb, if it goes on where this one ends.
        let next = all.iter().position(|j| j.parent == Some(index) && (j.place - joint.end).length() < 0.05);
        // Rings from pole to pole: (along the bone, radius, slope of the normal along the bone).
        let mut rings = Vec::new();
        for k in 0..=3 {
            let angle = PI * 0.5 * (1.0 - f64::from(k) / 3.0);
            rings.push((-radius_a * angle.sin(), radius_a * angle.cos(), -angle.sin()));
        }
        for k in 1..4 {
            let s = f64::from(k) / 4.0;
            rings.push((length * s, radius_a + (radius_b - radius_a) * s, (radius_a - radius_b) / length));
        }
        for k in 0..=3 {
            let angle = PI * 0.5 * f64::from(k) / 3.0;
            rings.push((length + radius_b * angle.sin(), radius_b * angle.cos(), angle.sin()));
        }
        let first = self.positions.len();
        for &(along, radius, slope) in &rings {
            // The share of the neighbour: a half at the joint, none a radius away.
            let share = |distance: f64, reach: f64| 0.5 * (1.0 - distance.max(0.0) / (1.5 * reach)).clamp(0.0, 1.0);
            let (other, part) = match (joint.parent, next) {
                (Some(parent), _) if along < length * 0.5 => (parent, share(along, radius_a)),
                (_, Some(next)) if along >= length * 0.5 => (next, share(length - along, radius_b)),
                _ => (index, 0.0),
            };
            let weight = (part * 255.0).round() as u8;
            for k in 0..AROUND {
                let (sine, cosine) = (TAU * k as f64 / AROUND as f64).sin_cos();
                let side = (1.0 - slope * slope).max(0.0).sqrt();
                let local = DVec3::new(radius * cosine, along, radius * joint.depth * sine);
                let normal = DVec3::new(side * cosine * joint.depth, slope * joint.depth, side * sine);
                self.positions.push((a + rotation * local).as_vec3().to_array());
                self.normals.push((rotation * normal).normalize_or(DVec3::Y).as_vec3().to_array());
                self.joints.push([index as u8, other as u8, 0, 0]);
                self.weights.push([255 - weight, weight, 0, 0]);
            }
        }
        for ring in 0..rings.len() - 1 {
            for k in 0..AROUND {
                let at = |ring: usize, k: usize| (first + ring * AROUND + k % AROUND) as u16;
                let (p, q, r, s) = (at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
                self.indices.extend([p, r, q, q, r, s]);
            }
        }
    }
}

/// The binary part of the file and the views into it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    /// Adds an accessor over its own view; returns its index.
    fn add(
        &mut self,
        bytes: &[u8],
        count: usize,
        component: u32,
        kind: &str,
        target: Option<u32>,
        extra: Value,
    ) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        let mut accessor =
            json!({"bufferView": self.views.len(), "componentType": component, "count": count, "type": kind});
        for (key, value) in extra.as_object().into_iter().flatten() {
            accessor[key] = value.clone();
        }
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn floats<const N: usize>(rows: &[[f32; N]]) -> Vec<u8> {
    rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

/// The glTF binary: a scene `Humanoid` with the mesh and the skeleton.
fn glb(joints: &[Joint]) -> Vec<u8> {
    const FLOAT: u32 = 5126;
    const BYTE: u32 = 5121;
    const SHORT: u32 = 5123;
    let mut mesh = Mesh::default();
    (0..joints.len()).for_each(|k| mesh.add(joints, k));
    let count = mesh.positions.len();
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        mesh.positions.iter().fold([start; 3], |m, p| [0, 1, 2].map(|k| pick(m[k], p[k])))
    };
    let bounds = json!({"min": bound(f32::min, f32::MAX), "max": bound(f32::max, f32::MIN)});
    let mut binary = Binary::default();
    let positions = binary.add(&floats(&mesh.positions), count, FLOAT, "VEC3", Some(34962), bounds);
    let normals = binary.add(&floats(&mesh.normals), count, FLOAT, "VEC3", Some(34962), json!({}));
    let bones = binary.add(mesh.joints.as_flattened(), count, BYTE, "VEC4", Some(34962), json!({}));
    let normalized = json!({"normalized": true});
    let weights = binary.add(mesh.weights.as_flattened(), count, BYTE, "VEC4", Some(34962), normalized);
    let indices: Vec<u8> = mesh.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = binary.add(&indices, mesh.indices.len(), SHORT, "SCALAR", Some(34963), json!({}));
    let place = |joint: &Joint| glam::DMat4::from_rotation_translation(axes(joint), turned(joint.place));
    let inverse: Vec<[f32; 16]> = joints.iter().map(|j| place(j).inverse().to_cols_array().map(|x| x as f32)).collect();
    let inverse = binary.add(&floats(&inverse), joints.len(), FLOAT, "MAT4", None, json!({}));

    // Nodes: the joints first, then the mesh, then the root of the scene.
    let mut nodes: Vec<Value> = joints
        .iter()
        .enumerate()
        .map(|(index, joint)| {
            let above = joint.parent.map_or(glam::DMat4::IDENTITY, |p| place(&joints[p]));
            let (_, rotation, translation) = (above.inverse() * place(joint)).to_scale_rotation_translation();
            let children: Vec<usize> = (0..joints.len()).filter(|&k| joints[k].parent == Some(index)).collect();
            let mut node = json!({
                "name": joint.name,
                "translation": translation.as_vec3().to_array(),
                "rotation": rotation.normalize().as_quat().to_array(),
            });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        })
        .collect();
    let body = nodes.len();
    nodes.push(json!({"name": "Body", "mesh": 0, "skin": 0}));
    nodes.push(json!({"name": "Humanoid", "children": [0, body]}));
    let text = json!({
        "asset": {"version": "2.0", "generator": "bevy_athlete, examples/make_humanoid.rs", "copyright": "MIT OR Apache-2.0"},
        "scene": 0,
        "scenes": [{"name": "Humanoid", "nodes": [body + 1]}],
        "nodes": nodes,
        "meshes": [{"name": "Body", "primitives": [{
            "attributes": {"POSITION": positions, "NORMAL": normals, "JOINTS_0": bones, "WEIGHTS_0": weights},
            "indices": indices,
            "material": 0,
        }]}],
        "materials": [{"name": "Suit", "pbrMetallicRoughness": {
            "baseColorFactor": [0.16, 0.30, 0.55, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6,
        }}],
        "skins": [{"name": "Skeleton", "joints": (0..joints.len()).collect::<Vec<_>>(), "inverseBindMatrices": inverse, "skeleton": 0}],
        "buffers": [{"byteLength": binary.bytes.len()}],
        "bufferViews": binary.views,
        "accessors": binary.accessors,
    });
    let mut text = text.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + binary.bytes.len();
    let mut file = b"glTF".to_vec();
    for word in [2, total as u32, text.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(text);
    file.extend((binary.bytes.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary.bytes);
    file
}

/// The bone map. The offsets are left to the rest poses, which agree with the arms raised.
fn bone_map(joints: &[Joint]) -> String {
    let mut text = String::from(
        "// The humanoid of assets/models/humanoid.glb on the skater. Made by examples/make_humanoid.rs.\n(\n    character: \"skater\",\n",
    );
    text += "    // At rest the mesh has its arms half raised.\n";
    text +=
        &format!("    pose: {{\"bicep_left\": (0.0, 0.0, {:.1}), \"bicep_right\": (0.0, 0.0, {ARMS:.1})}},\n", -ARMS);
    text += "    bones: {\n";
    for joint in joints {
        if let Some(link) = &joint.link {
            text += &format!("        \"{}\": (link: \"{link}\"),\n", joint.name);
        }
    }
    text += "    },\n)\n";
    text
}

fn main() -> std::io::Result<()> {
    let joints = joints();
    let file = glb(&joints);
    std::fs::create_dir_all("assets/models")?;
    std::fs::write("assets/models/humanoid.glb", &file)?;
    std::fs::write("assets/maps/humanoid.bones.ron", bone_map(&joints))?;
    println!("{} joints, {} bytes", joints.len(), file.len());
    Ok(())
}
