//! Writes the motion of a character as a BVH file of another skeleton: other names, axes, units, rest poses, rotation orders.
#![allow(dead_code)]

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::model::{CharacterModel, LinkTransform};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use std::fmt::Write;

/// In what pose the skeleton stands with every rotation at zero.
#[derive(Clone, Copy, PartialEq)]
pub enum Zero {
    /// Arms out.
    T,
    /// Arms out, legs apart by 20 degrees each.
    SplayedT,
    /// Arms half-way down.
    A,
    /// Arms down.
    Hanging,
    /// No pose: X along every bone.
    BoneX,
}

/// Names and habits of a tool.
pub struct Convention {
    pub name: &'static str,
    /// Above the hips.
    pub above: &'static [&'static str],
    pub hips: &'static str,
    pub trunk: &'static [&'static str],
    /// The last one is the head.
    pub neck: &'static [&'static str],
    /// `{}` is the side. A dummy and the hip, knee, ankle, toe.
    pub leg: [&'static str; 5],
    /// Collar, shoulder, elbow, wrist and a finger; empty where there is none.
    pub arm: [&'static str; 5],
    pub sides: [&'static str; 2],
    /// File units in a metre.
    pub units: f64,
    pub up: DVec3,
    pub facing: DVec3,
    pub zero: Zero,
    pub order: EulerRot,
    /// Position channels on every joint.
    pub six: bool,
}

struct Joint {
    name: String,
    parent: Option<usize>,
    /// Link whose turns the joint has.
    link: usize,
    /// Place in the parent's link, m.
    offset: DVec3,
    /// Link axes to joint axes.
    axes: DQuat,
    end: Option<DVec3>,
}

/// Our axes to axes with these directions.
pub fn basis(up: DVec3, facing: DVec3) -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(facing.cross(up), up, -facing)).normalize()
}

struct Writer<'a> {
    model: &'a CharacterModel,
    convention: &'a Convention,
    world: DQuat,
    joints: Vec<Joint>,
}

fn find(model: &CharacterModel, names: &[&str]) -> Option<usize> {
    names.iter().find_map(|n| model.link_index(n))
}

impl Writer<'_> {
    fn add(&mut self, name: String, parent: usize, link: usize, offset: DVec3, axes: DQuat) -> usize {
        self.joints.push(Joint { name, parent: Some(parent), link, offset, axes, end: None });
        self.joints.len() - 1
    }

    /// A row of names that ends in a link; those before it turn with what carries the row, and lie on the way.
    fn row(&mut self, names: &[String], mut parent: usize, link: usize, offset: DVec3, axes: DQuat) -> usize {
        for (i, name) in names.iter().enumerate() {
            let part = offset / names.len() as f64;
            let last = i + 1 == names.len();
            let (turns, own) = if last { (link, axes) } else { (self.joints[parent].link, self.joints[parent].axes) };
            parent = self.add(name.clone(), parent, turns, part, own);
        }
        parent
    }

    /// Axes of a joint whose link is turned by `rest` in the zero pose, or has `bone_x` where there is none.
    fn axes(&self, rest: DQuat, bone_x: DQuat, own: Option<DVec3>) -> DQuat {
        if self.convention.zero != Zero::BoneX {
            return self.world * rest;
        }
        own.map_or(bone_x, |own| DQuat::from_rotation_arc(bone_x * own, DVec3::X) * bone_x)
    }

    fn build(&mut self) {
        let (m, c) = (self.model, self.convention);
        let rest = m.rest_positions();
        let body = self.axes(DQuat::IDENTITY, basis(DVec3::X, DVec3::Y), None);
        for (i, name) in c.above.iter().enumerate() {
            let parent = i.checked_sub(1);
            self.joints.push(Joint {
                name: (*name).into(),
                parent,
                link: usize::MAX,
                offset: DVec3::ZERO,
                axes: DQuat::IDENTITY,
                end: None,
            });
        }
        let parent = self.joints.len().checked_sub(1);
        self.joints.push(Joint { name: c.hips.into(), parent, link: 0, offset: DVec3::ZERO, axes: body, end: None });
        let hips = self.joints.len() - 1;
        for side in [0, 1] {
            self.leg(side, hips, &rest);
        }
        // Names of the trunk in as many parts as there are links.
        let links: Vec<usize> = [&["abdomen"][..], &["chest", "spine"]].iter().filter_map(|n| find(m, n)).collect();
        let last = |i: usize| ((i + 1) * c.trunk.len()).div_ceil(links.len());
        let (mut parent, mut from) = (hips, 0);
        for (i, &link) in links.iter().enumerate() {
            let names: Vec<String> = c.trunk[from..last(i)].iter().map(|n| (*n).to_owned()).collect();
            parent = self.row(&names, parent, link, m.links[link].offset, body);
            from = last(i);
        }
        let chest = parent;
        if let Some(head) = find(m, &["head"]) {
            let names: Vec<String> = c.neck.iter().map(|n| (*n).to_owned()).collect();
            let joint = self.row(&names, chest, head, m.links[head].offset, body);
            self.joints[joint].end = Some(DVec3::Y * 0.15);
        }
        for side in [0, 1] {
            self.arm(side, chest, &rest);
        }
    }

    fn leg(&mut self, side: usize, hips: usize, rest: &[DVec3]) {
        let (m, c) = (self.model, self.convention);
        let (s, sign) = ([" left", " right"][side].trim(), [-1.0, 1.0][side]);
        let name = |i: usize| c.leg[i].replace("{}", c.sides[side]);
        let link = |base: &str| m.link_index(&format!("{base}_{s}"));
        let (thigh, shin) = (link("thigh").unwrap(), link("shin").unwrap());
        let foot = link("foot").or(link("medial_metatarsal")).unwrap();
        let apart =
            if c.zero == Zero::SplayedT { DQuat::from_rotation_z(sign * 20f64.to_radians()) } else { DQuat::IDENTITY };
        let axes = self.axes(apart, basis(DVec3::NEG_X, DVec3::Y), Some((rest[shin] - rest[thigh]).normalize()));
        let mut parent = hips;
        let mut offset = m.links[thigh].offset;
        if !c.leg[0].is_empty() {
            parent = self.add(name(0), hips, 0, DVec3::ZERO, self.joints[hips].axes);
        }
        parent = self.add(name(1), parent, thigh, offset, axes);
        offset = m.links[shin].offset;
        let axes = self.axes(apart, basis(DVec3::NEG_X, DVec3::Y), Some((rest[foot] - rest[shin]).normalize()));
        parent = self.add(name(2), parent, shin, offset, axes);
        // The ball of the foot: the toes' joint, or a place on the foot.
        let toes = link("toes").or(link("medial_phalanges")).or(link("toe3"));
        let ball = toes.map_or(DVec3::new(0.0, -0.05, -0.12), |t| rest[t] - rest[foot]);
        let axes = self.axes(DQuat::IDENTITY, basis(DVec3::NEG_Y, DVec3::X), Some(ball.normalize()));
        parent = self.add(name(3), parent, foot, m.links[foot].offset, axes);
        let axes = self.axes(DQuat::IDENTITY, basis(DVec3::NEG_Y, DVec3::X), None);
        let toe = self.add(name(4), parent, toes.unwrap_or(foot), ball, axes);
        self.joints[toe].end = Some(DVec3::NEG_Z * 0.05);
    }

    fn arm(&mut self, side: usize, chest: usize, rest: &[DVec3]) {
        let (m, c) = (self.model, self.convention);
        let (s, sign) = (["left", "right"][side], [-1.0, 1.0][side]);
        let name = |i: usize| c.arm[i].replace("{}", c.sides[side]);
        let link = |base: &str| m.link_index(&format!("{base}_{s}"));
        let (upper, lower) = (link("upper_arm").or(link("bicep")).unwrap(), link("forearm").unwrap());
        let degrees: f64 = match c.zero {
            Zero::T | Zero::SplayedT => 90.0,
            Zero::A => 45.0,
            _ => 0.0,
        };
        let out = DQuat::from_rotation_z(sign * degrees.to_radians());
        let own = |a: usize, b: Option<usize>| Some(b.map_or(DVec3::NEG_Y, |b| (rest[b] - rest[a]).normalize()));
        let (mut parent, mut offset) = (chest, m.links[upper].offset);
        if let Some(scapula) = link("scapula") {
            let outwards = basis(DVec3::Z, DVec3::Y * sign);
            let axes = self.axes(DQuat::IDENTITY, outwards, own(scapula, Some(upper)));
            parent = self.add(name(0), parent, scapula, m.links[scapula].offset, axes);
        } else {
            let (turns, axes) = (self.joints[chest].link, self.joints[chest].axes);
            parent = self.add(name(0), parent, turns, offset * 0.4, axes);
            offset *= 0.6;
        }
        let turned = basis(DVec3::NEG_X, DVec3::Z * sign);
        let axes = self.axes(out, turned, own(upper, Some(lower)));
        parent = self.add(name(1), parent, upper, offset, axes);
        let hand = link("hand");
        let axes = self.axes(out, turned, own(lower, hand));
        parent = self.add(name(2), parent, lower, m.links[lower].offset, axes);
        let wrist = hand.map_or(DVec3::NEG_Y * 0.24, |h| m.links[h].offset);
        let axes = self.axes(out, turned, None);
        parent = self.add(name(3), parent, hand.unwrap_or(lower), wrist, axes);
        self.joints[parent].end = Some(DVec3::NEG_Y * 0.1);
        if !c.arm[4].is_empty() {
            let turns = self.joints[parent].link;
            let axes = self.joints[parent].axes;
            let finger = self.add(name(4), parent, turns, DVec3::NEG_Y * 0.1, axes);
            self.joints[finger].end = Some(DVec3::NEG_Y * 0.03);
            self.joints[parent].end = None;
        }
    }

    /// Offset of a joint in its parent's axes, file units.
    fn offset(&self, joint: usize) -> DVec3 {
        let j = &self.joints[joint];
        match j.parent {
            Some(p) if self.joints[p].link != usize::MAX => self.joints[p].axes * j.offset * self.convention.units,
            _ => DVec3::ZERO,
        }
    }

    fn hierarchy(&self, joint: usize, depth: usize, text: &mut String, order: &mut Vec<usize>) {
        order.push(joint);
        let j = &self.joints[joint];
        let tab = "\t".repeat(depth);
        let kind = if j.parent.is_none() { "ROOT" } else { "JOINT" };
        let o = self.offset(joint);
        let axes = match self.convention.order {
            EulerRot::ZYX => "Zrotation Yrotation Xrotation",
            EulerRot::ZXY => "Zrotation Xrotation Yrotation",
            EulerRot::YXZ => "Yrotation Xrotation Zrotation",
            EulerRot::XYZ => "Xrotation Yrotation Zrotation",
            _ => panic!("an order that no file has"),
        };
        let positions = if self.positioned(joint) { "6 Xposition Yposition Zposition" } else { "3" };
        let _ = write!(text, "{tab}{kind} {}\n{tab}{{\n{tab}\tOFFSET {:.6} {:.6} {:.6}\n", j.name, o.x, o.y, o.z);
        let _ = writeln!(text, "{tab}\tCHANNELS {positions} {axes}");
        for child in 0..self.joints.len() {
            if self.joints[child].parent == Some(joint) {
                self.hierarchy(child, depth + 1, text, order);
            }
        }
        if let Some(end) = j.end {
            let e = j.axes * end * self.convention.units;
            let _ = write!(
                text,
                "{tab}\tEnd Site\n{tab}\t{{\n{tab}\t\tOFFSET {:.6} {:.6} {:.6}\n{tab}\t}}\n",
                e.x, e.y, e.z
            );
        }
        let _ = writeln!(text, "{tab}}}");
    }

    /// The root has positions, the hips below a root that stays where it is, and every joint where the tool says so.
    fn positioned(&self, joint: usize) -> bool {
        self.convention.six
            || self.joints[joint].parent.is_none()
            || self.joints[joint].link == 0 && self.hips() == joint
    }

    fn hips(&self) -> usize {
        self.convention.above.len()
    }

    fn row_of_frame(&self, places: &[LinkTransform], order: &[usize]) -> String {
        let c = self.convention;
        let turn = |j: usize| match self.joints[j].link {
            usize::MAX => DQuat::IDENTITY,
            link => self.world * places[link].rotation * self.joints[j].axes.conjugate(),
        };
        let mut row = String::new();
        for &joint in order {
            let parent = self.joints[joint].parent;
            let local = parent.map_or(DQuat::IDENTITY, turn).conjugate() * turn(joint);
            if self.positioned(joint) {
                let p =
                    if joint == self.hips() { self.world * places[0].position * c.units } else { self.offset(joint) };
                let _ = write!(row, "{:.6} {:.6} {:.6} ", p.x, p.y, p.z);
            }
            let (a, b, d) = local.normalize().to_euler(c.order);
            let _ = write!(row, "{:.6} {:.6} {:.6} ", a.to_degrees(), b.to_degrees(), d.to_degrees());
        }
        row
    }
}

/// The text of a BVH file in which a skeleton of the convention moves as the character does.
pub fn write_bvh(convention: &Convention, clip: &MotionClip, model: &CharacterModel) -> String {
    let world = basis(convention.up, convention.facing);
    let mut writer = Writer { model, convention, world, joints: Vec::new() };
    writer.build();
    let (mut text, mut order) = (String::from("HIERARCHY\n"), Vec::new());
    writer.hierarchy(0, 0, &mut text, &mut order);
    let fitted = clip.to_model(model).unwrap();
    let _ = write!(text, "MOTION\nFrames: {}\nFrame Time: {:.7}\n", clip.poses.len(), 1.0 / clip.frame_rate);
    let mut places = Vec::new();
    for pose in fitted.poses() {
        pose.link_transforms(model, &mut places);
        text += writer.row_of_frame(&places, &order).trim_end();
        text.push('\n');
    }
    text
}

/// The conventions of seven tools and databases, and of one that nobody knows.
pub fn conventions() -> Vec<Convention> {
    let (y, z) = (DVec3::Y, DVec3::Z);
    let words = ["Left", "Right"];
    vec![
        Convention {
            name: "lafan1",
            above: &[],
            hips: "Hips",
            trunk: &["Spine", "Spine1", "Spine2"],
            neck: &["Neck", "Head"],
            leg: ["", "{}UpLeg", "{}Leg", "{}Foot", "{}Toe"],
            arm: ["{}Shoulder", "{}Arm", "{}ForeArm", "{}Hand", ""],
            sides: words,
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::BoneX,
            order: EulerRot::ZYX,
            six: false,
        },
        Convention {
            name: "cmu",
            above: &[],
            hips: "Hips",
            trunk: &["LowerBack", "Spine", "Spine1"],
            neck: &["Neck", "Neck1", "Head"],
            leg: ["{}HipJoint", "{}UpLeg", "{}Leg", "{}Foot", "{}ToeBase"],
            arm: ["{}Shoulder", "{}Arm", "{}ForeArm", "{}Hand", "{}FingerBase"],
            sides: words,
            units: 0.45 / 0.0254,
            up: y,
            facing: z,
            zero: Zero::SplayedT,
            order: EulerRot::ZYX,
            six: false,
        },
        Convention {
            name: "mixamo",
            above: &[],
            hips: "mixamorig:Hips",
            trunk: &["mixamorig:Spine", "mixamorig:Spine1", "mixamorig:Spine2"],
            neck: &["mixamorig:Neck", "mixamorig:Head"],
            leg: ["", "mixamorig:{}UpLeg", "mixamorig:{}Leg", "mixamorig:{}Foot", "mixamorig:{}ToeBase"],
            arm: [
                "mixamorig:{}Shoulder",
                "mixamorig:{}Arm",
                "mixamorig:{}ForeArm",
                "mixamorig:{}Hand",
                "mixamorig:{}HandIndex1",
            ],
            sides: words,
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::T,
            order: EulerRot::ZXY,
            six: true,
        },
        Convention {
            name: "rokoko",
            above: &["Root"],
            hips: "Hips",
            trunk: &["Spine1", "Spine2", "Spine3", "Spine4"],
            neck: &["Neck", "Head"],
            leg: ["", "{}Thigh", "{}Shin", "{}Foot", "{}Toe"],
            arm: ["{}Shoulder", "{}Arm", "{}ForeArm", "{}Hand", "{}FingerMiddle1"],
            sides: words,
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::T,
            order: EulerRot::YXZ,
            six: true,
        },
        Convention {
            name: "xsens",
            above: &[],
            hips: "Hips",
            trunk: &["Chest", "Chest2", "Chest3", "Chest4"],
            neck: &["Neck", "Head"],
            leg: ["", "{}Hip", "{}Knee", "{}Ankle", "{}Toe"],
            arm: ["{}Collar", "{}Shoulder", "{}Elbow", "{}Wrist", ""],
            sides: words,
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::Hanging,
            order: EulerRot::YXZ,
            six: false,
        },
        Convention {
            name: "bandai_namco",
            above: &["joint_Root"],
            hips: "Hips",
            trunk: &["Spine", "Chest"],
            neck: &["Neck", "Head"],
            leg: ["", "UpperLeg_{}", "LowerLeg_{}", "Foot_{}", "Toes_{}"],
            arm: ["Shoulder_{}", "UpperArm_{}", "LowerArm_{}", "Hand_{}", ""],
            sides: ["L", "R"],
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::BoneX,
            order: EulerRot::ZXY,
            six: true,
        },
        Convention {
            name: "100style",
            above: &[],
            hips: "Hips",
            trunk: &["Chest", "Chest2", "Chest3", "Chest4"],
            neck: &["Neck", "Head"],
            leg: ["", "{}Hip", "{}Knee", "{}Ankle", "{}Toe"],
            arm: ["{}Collar", "{}Shoulder", "{}Elbow", "{}Wrist", ""],
            sides: words,
            units: 100.0,
            up: y,
            facing: z,
            zero: Zero::T,
            order: EulerRot::YXZ,
            six: false,
        },
        Convention {
            name: "z_up",
            above: &["Reference", "Dummy"],
            hips: "pelvis",
            trunk: &["spine_01", "spine_02", "spine_03"],
            neck: &["neck_01", "head"],
            leg: ["", "thigh.{}", "calf.{}", "foot.{}", "ball.{}"],
            arm: ["clavicle.{}", "upperarm.{}", "lowerarm.{}", "hand.{}", "index_01.{}"],
            sides: ["l", "r"],
            units: 1.0,
            up: z,
            facing: -y,
            zero: Zero::A,
            order: EulerRot::XYZ,
            six: false,
        },
        Convention {
            name: "nameless",
            above: &["b0"],
            hips: "b1",
            trunk: &["b2", "b3"],
            neck: &["b4", "b5"],
            leg: ["", "b6{}", "b7{}", "b8{}", "b9{}"],
            arm: ["c6{}", "c7{}", "c8{}", "c9{}", "c10{}"],
            sides: ["x", "y"],
            units: 1.0 / 0.0254,
            up: y,
            facing: DVec3::X,
            zero: Zero::T,
            order: EulerRot::ZXY,
            six: false,
        },
    ]
}
