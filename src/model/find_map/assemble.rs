//! From the parts of two bodies and their axes to a joint map.

use super::links::Links;
use super::skeleton::{Limb, Missing};
use super::source::{Source, nearest_axis};
use super::{Axes, FindMapError, FoundMap, LimbAxes, MapRow, MapWarning, RestPose, direction, motion_axes, rest_axes};
use crate::asset::bvh::{Bvh, Channel};
use crate::asset::joint_map::{Fit, JointMap, LinkMap, RootAnchor, basis};
use crate::model::CharacterModel;
use crate::model::find_map::joint_name::{Part, read_name};
use glam::{DQuat, DVec3};

/// A leg of a grown person, m.
const USUAL_LEG: f64 = 0.82;
/// Units of length, metres, and how unusual each is.
const UNITS: [(&str, f64, f64); 7] = [
    ("m", 1.0, 0.0),
    ("cm", 0.01, 0.0),
    ("mm", 0.001, 0.05),
    ("inches", 0.0254, 0.1),
    // The unit of the ASF skeletons of the CMU database: 1 / 0.45 inches.
    ("inches / 0.45", 0.0254 / 0.45, 0.15),
    ("dm", 0.1, 0.25),
    ("feet", 0.3048, 0.25),
];
/// How far a leg may be from the usual one, natural logarithm of the ratio.
const LEG_RANGE: f64 = 0.7;
/// Other names of links in the characters that come with the crate.
const ALIASES: [&[&str]; 5] = [
    &["foot", "medial_metatarsal"],
    &["toes", "medial_phalanges", "toe3"],
    &["upper_arm", "bicep"],
    &["abdomen", "waist"],
    &["chest", "spine", "torso"],
];

/// Finds how the skeleton of a file drives a character, by names, shape and motion.
///
/// The motion counts where the pose with all rotations zero is none in which a person could stand; a clip of a few frames
/// may then tell too little.
pub fn find_map(bvh: &Bvh, model: &CharacterModel) -> Result<FoundMap, FindMapError> {
    let named = |missing| match missing {
        Missing::Legs => "two legs of thigh and shin",
        Missing::Trunk => "joints between legs and arms",
    };
    let mut source = Source::new(bvh).map_err(|missing| FindMapError::NotInFile {
        missing: named(missing),
        joints: bvh.joints().iter().map(|j| j.name.clone()).collect(),
    })?;
    let links = Links::new(model).map_err(|missing| FindMapError::NotInCharacter {
        character: model.name.clone(),
        missing: named(missing),
        links: model.links.iter().map(|l| l.name.clone()).collect(),
    })?;
    let mut warnings = Vec::new();
    settle_sides(&mut source, &mut warnings);
    if source.roles.arms.is_none() && links.roles.arms.is_some() {
        warnings.push(MapWarning::NoArms);
    }

    // Up and facing of the world, and the axes of all parts.
    let name = |joint: usize| bvh.joints()[joint].name.clone();
    let upright = rest_axes::upright(&source);
    let up = world_up(&source, upright.map(|u| u.up));
    let (axes, rest, facing) = match upright {
        Some(zero) => {
            if zero.up.dot(up) < 0.9 {
                let (found, zero) = (direction(up), direction(zero.up));
                warnings.push(MapWarning::UpFromMotion { found, zero });
            }
            // As the zero pose faces, laid down where that stands along another axis.
            let facing = DQuat::from_rotation_arc(zero.up, up) * zero.facing;
            (rest_axes::axes(&source, &links.bones, zero), rest_axes::kind(&source, zero), facing)
        }
        None => {
            let axes = motion_axes::axes(&source, &links.bones).ok_or_else(|| FindMapError::OnePlace {
                from: name(source.roles.legs[0].upper),
                to: name(source.roles.legs[1].upper),
            })?;
            // No pose faces anywhere: the way that most files have it.
            let facing = if up.z.abs() > 0.5 { DVec3::NEG_Y * up.z.signum() } else { DVec3::Z };
            (axes, RestPose::None, facing)
        }
    };
    let facing = facing.reject_from_normalized(up).normalize();

    let leg = source.leg_length();
    if !(leg > 1e-6 && links.leg_length > 1e-6) {
        let legs = &source.roles.legs[0];
        return Err(FindMapError::OnePlace { from: name(legs.upper), to: name(legs.end.unwrap_or(legs.lower)) });
    }
    let (unit, metres) = unit(leg);
    if unit == "unknown" {
        warnings.push(MapWarning::Unit { leg, taken: metres });
    }
    let mut writer =
        Writer { source: &source, links: &links, model, axes: &axes, entries: Vec::new(), used: Vec::new() };
    writer.entries();
    let entries = std::mem::take(&mut writer.entries);
    let unmapped = writer.unmapped();
    let map = writer.map(entries, metres, up, facing, unmapped.iter().map(|(n, _)| n.clone()).collect());
    map.validate()?;
    let rows = map
        .entries()
        .map(|entry| MapRow {
            link: entry.link.clone(),
            joints: entry.joints.clone(),
            up: direction(entry.up.unwrap_or(up)),
            facing: direction(entry.facing.unwrap_or(facing)),
        })
        .collect();
    let unit = unit.to_owned();
    Ok(FoundMap { map, character: model.name.clone(), rows, unmapped, rest, unit, leg: leg * metres, warnings })
}

/// The unit in which a leg of this length is nearest to a person's; of unknown units, the one that makes it so.
fn unit(leg: f64) -> (&'static str, f64) {
    let off = |metres: f64| (leg * metres / USUAL_LEG).ln().abs();
    let best = UNITS.iter().min_by(|a, b| (off(a.1) + a.2).total_cmp(&(off(b.1) + b.2)));
    match best {
        Some(&(name, metres, _)) if off(metres) < LEG_RANGE => (name, metres),
        _ => ("unknown", USUAL_LEG / leg),
    }
}

/// Up in the file's world: along which axis the figure stands over the clip; where it lies about, that of the zero pose.
fn world_up(source: &Source, zero: Option<DVec3>) -> DVec3 {
    let [left, right] = [&source.roles.legs[0], &source.roles.legs[1]].map(|l| l.end.unwrap_or(l.lower));
    let top = source.top();
    let sum: DVec3 = source
        .frames
        .iter()
        .map(|f| (f[top].position - (f[left].position + f[right].position) / 2.0).normalize_or_zero())
        .sum();
    let mean = sum / source.frames.len() as f64;
    let (axis, cosine) = nearest_axis(mean);
    match zero {
        // A handstand is upside down, and so would be the floor.
        Some(zero) if mean.length() < 0.5 || cosine < 0.8 || zero.dot(axis).abs() > 0.9 => zero,
        None if mean.length() < 0.3 => DVec3::Y,
        _ => axis,
    }
}

/// Names say which side is left; where they do not, or toes and knees say otherwise, the body does.
fn settle_sides(source: &mut Source, warnings: &mut Vec<MapWarning>) {
    let told = sides_by_body(source);
    let left = source.bvh.joints()[source.roles.legs[0].upper].name.clone();
    let by_name = source.roles.sides_by_name;
    if told < if by_name { -0.3 } else { 0.0 } {
        source.roles.legs.swap(0, 1);
    }
    let left_now = source.bvh.joints()[source.roles.legs[0].upper].name.clone();
    match (by_name, left == left_now) {
        (true, true) => {}
        (true, false) => warnings.push(MapWarning::SidesDisagree { left }),
        (false, _) => warnings.push(MapWarning::SidesByShape { left: left_now }),
    }
    // Arms of the sides on which the legs are.
    let [left, right] = [&source.roles.legs[0], &source.roles.legs[1]].map(|l| l.upper);
    if let Some([l, r]) = &source.roles.arms {
        let same: f64 = source
            .frames
            .iter()
            .map(|f| (f[left].position - f[right].position).dot(f[l.upper].position - f[r.upper].position))
            .sum();
        if same < 0.0
            && let Some(arms) = &mut source.roles.arms
        {
            arms.swap(0, 1);
        }
    }
}

/// Whether the first leg is on the left of where toes and knees point: 1 is always, -1 never.
fn sides_by_body(source: &Source) -> f64 {
    let roles = &source.roles;
    let (first, second) = (&roles.legs[0], &roles.legs[1]);
    let mut sum = 0.0;
    for f in &source.frames {
        let across = f[first.upper].position - f[second.upper].position;
        let hips = (f[first.upper].position + f[second.upper].position) / 2.0;
        let up = (f[source.top()].position - hips).normalize_or_zero();
        let ahead: DVec3 = roles.legs.iter().map(|leg| ahead(source, leg, f)).sum();
        sum += up.cross(ahead).normalize_or_zero().dot(across.normalize_or_zero());
    }
    sum / source.frames.len() as f64
}

/// Where a leg says that ahead is: from the ankle to the toes, or where the knee points.
fn ahead(source: &Source, leg: &Limb, f: &[crate::asset::bvh::BvhTransform]) -> DVec3 {
    let Some(end) = leg.end else { return DVec3::ZERO };
    let shin = (f[leg.lower].position - f[end].position).normalize_or_zero();
    let toe = leg.toe.or_else(|| source.child(end)).map(|toe| f[toe].position - f[end].position);
    let toe = toe.or_else(|| source.bone(end, None).map(|b| f[end].rotation * b)).unwrap_or_default();
    let toe = toe.normalize_or_zero().reject_from(shin.normalize_or(DVec3::Y));
    if toe.length() > 0.3 {
        return toe;
    }
    let middle = (f[leg.upper].position + f[end].position) / 2.0;
    (f[leg.lower].position - middle).normalize_or_zero() * 0.5
}

struct Writer<'a> {
    source: &'a Source<'a>,
    links: &'a Links,
    model: &'a CharacterModel,
    axes: &'a Axes,
    entries: Vec<LinkMap>,
    used: Vec<usize>,
}

impl Writer<'_> {
    fn joint_name(&self, joint: usize) -> String {
        self.source.bvh.joints()[joint].name.clone()
    }
    fn link_name(&self, link: usize) -> String {
        self.model.links[link].name.clone()
    }

    fn add(&mut self, link: usize, joints: &[usize], axes: DQuat, share: f64, optional: bool) {
        let link = self.link_name(link);
        let tidy = |v: DVec3| v.map(|x| if (x - x.round()).abs() < 1e-9 { x.round() + 0.0 } else { x });
        self.used.extend(joints);
        self.entries.push(LinkMap {
            aliases: aliases(&link, self.model),
            joints: joints.iter().map(|&j| self.joint_name(j)).collect(),
            up: Some(tidy(axes * DVec3::Y)),
            facing: Some(tidy(axes * DVec3::NEG_Z)),
            rest_degrees: DVec3::ZERO,
            share,
            optional,
            link,
        });
    }

    fn entries(&mut self) {
        let (own, theirs, axes) = (&self.links.roles, &self.source.roles, self.axes);
        self.add(0, &[theirs.pelvis], axes.pelvis, 1.0, false);
        for side in 0..2 {
            let (leg, link, a) = (&theirs.legs[side], &own.legs[side], &axes.legs[side]);
            self.limb(leg, link, a, false);
            if let (Some(foot), Some(joint)) = (link.end, leg.end) {
                self.add(foot, &[joint], a.end, 1.0, false);
            }
            let turns =
                |j: usize| self.source.bvh.joints()[j].channels.iter().any(|c| matches!(c, Channel::Rotation(_)));
            if let Some(toe) = leg.toe.filter(|&j| turns(j)) {
                for &link in &self.links.toes[side] {
                    self.add(link, &[toe], a.toe, 1.0, true);
                }
            }
        }
        self.spread(&own.trunk, &theirs.trunk, &axes.trunk, false);
        self.spread(&own.neck, &theirs.neck, &axes.neck, true);
        if let (Some(own), Some(theirs), Some(axes)) = (&own.arms, &theirs.arms, &axes.arms) {
            for side in 0..2 {
                let (arm, link, a) = (&theirs[side], &own[side], &axes[side]);
                self.limb(arm, link, a, true);
                if let (Some(hand), Some(joint)) = (link.end, arm.end) {
                    self.add(hand, &[joint], a.end, 1.0, true);
                }
            }
        }
    }

    /// Upper and lower link, and the collar's where there is one; else its joint belongs to the upper one.
    fn limb(&mut self, joints: &Limb, links: &Limb, axes: &LimbAxes, arm: bool) {
        match (joints.collar, links.collar) {
            (Some(joint), Some(link)) => {
                self.add(link, &[joint], axes.collar, 1.0, true);
                self.add(links.upper, &[joints.upper], axes.upper, 1.0, arm);
            }
            (Some(joint), None) => self.add(links.upper, &[joint, joints.upper], axes.upper, 1.0, arm),
            (None, _) => self.add(links.upper, &[joints.upper], axes.upper, 1.0, arm),
        }
        self.add(links.lower, &[joints.lower], axes.lower, 1.0, arm);
    }

    /// A row of joints over a row of links: each link takes the last joint of its part of the row; links that share one go
    /// there step by step.
    fn spread(&mut self, links: &[usize], joints: &[usize], axes: &[DQuat], all_optional: bool) {
        if joints.is_empty() {
            return;
        }
        let last = |i: usize| ((i + 1) * joints.len()).div_ceil(links.len()) - 1;
        for (i, &link) in links.iter().enumerate() {
            let to = last(i);
            let from = if i == 0 { 0 } else { last(i - 1) + 1 }.min(to);
            let sharing = (i..links.len()).filter(|&k| last(k) == to).count();
            let optional = all_optional || i + 1 < links.len();
            self.add(link, &joints[from..=to], axes[to], 1.0 / sharing as f64, optional);
        }
    }

    /// Joints that drive nothing, with the reason.
    fn unmapped(&self) -> Vec<(String, &'static str)> {
        let joints = self.source.bvh.joints();
        let above: Vec<usize> =
            std::iter::successors(Some(self.source.roles.pelvis), |&j| joints[j].parent).skip(1).collect();
        let reason = |j: usize| match read_name(&joints[j].name).part {
            _ if above.contains(&j) => "above the hips",
            Some(Part::Finger) => "fingers",
            Some(Part::Helper) => "ends and helpers",
            _ => "no link of the character follows",
        };
        let all = (0..joints.len()).filter(|j| !self.used.contains(j));
        all.map(|j| (joints[j].name.clone(), reason(j))).collect()
    }

    fn map(&self, mut entries: Vec<LinkMap>, unit: f64, up: DVec3, facing: DVec3, ignored: Vec<String>) -> JointMap {
        // Axes that are the world's need no word.
        let world = basis(up, facing);
        for entry in &mut entries {
            if let (Some(up), Some(facing)) = (entry.up, entry.facing)
                && world.angle_between(basis(up, facing)) < 1e-6
            {
                (entry.up, entry.facing) = (None, None);
            }
        }
        let root = entries.remove(0);
        let (own, theirs) = (&self.links.roles.legs, &self.source.roles.legs);
        let pair = |a: usize, b: usize| (self.joint_name(a), self.joint_name(b));
        let fit = match (own[0].end, theirs[0].end) {
            (Some(foot), Some(ankle)) => Fit::Legs {
                joints: (self.joint_name(theirs[0].upper), self.joint_name(theirs[0].lower), self.joint_name(ankle)),
                links: (self.link_name(own[0].upper), self.link_name(own[0].lower), self.link_name(foot)),
            },
            // Without an ankle on one of them, by the thighs.
            _ => {
                let rest = self.model.rest_positions();
                let thigh = rest[own[0].upper].distance(rest[own[0].lower]);
                let frame = &self.source.frames[0];
                let source = frame[theirs[0].upper].position.distance(frame[theirs[0].lower].position);
                Fit::Factor((thigh / (source * unit)).clamp(1e-3, 1e3))
            }
        };
        let soles = own.iter().filter_map(|leg| leg.end).map(|l| self.link_name(l));
        let soles = soles.filter(|name| entries.iter().any(|e| e.link == *name)).collect();
        JointMap {
            name: "found".into(),
            unit,
            up,
            facing,
            root,
            anchor: RootAnchor::Between {
                joints: pair(theirs[0].upper, theirs[1].upper),
                links: (self.link_name(own[0].upper), self.link_name(own[1].upper)),
            },
            links: entries,
            ignored,
            fit,
            stride: 1.0,
            lift: 0.0,
            soles,
            // Single poses dip below the rest by centimetres: one in ten may.
            sole_fraction: 0.1,
        }
    }
}

/// Names that the characters of the crate have for a link, so that a map that was found for one is of use for others.
fn aliases(link: &str, model: &CharacterModel) -> Vec<String> {
    let (base, side) = match link.rsplit_once('_') {
        Some((base, side @ ("left" | "right"))) => (base, Some(side)),
        _ => (link, None),
    };
    let group = ALIASES.iter().find(|group| group.contains(&base));
    let others = group.into_iter().flat_map(|group| group.iter()).filter(|name| **name != base);
    let named = others.map(|name| side.map_or((*name).to_owned(), |side| format!("{name}_{side}")));
    named.filter(|name| model.link_index(name).is_none()).collect()
}
