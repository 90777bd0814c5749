//! From positions of landmarks to key poses of a character.

use super::body_landmarks::{BodyLandmarkError, BodyLandmarks};
use super::inverse_kinematics::{BodySize, LandmarkTarget, PoseFit, PoseSolver};
use super::key_pose_text::NewKeyPoses;
use super::key_poses::{KeyPose, KeyPoseError, KeyPoses};
use super::side_check::{SidedPart, exchange, exchanged_part};
use super::{CharacterModel, JointKind};
use crate::asset::joint_positions::{JointPositions, PositionError, PositionFrame};
use crate::asset::turn::twist;
use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt;

/// How positions become key poses.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionImportOptions {
    /// Name of the motion.
    pub name: String,
    /// Visibility below which a landmark counts as not seen, 0 to 1.
    pub min_visibility: f64,
    /// Frames to make poses of, in order; all if `None`.
    pub frames: Option<Vec<usize>>,
    /// Exchanges left and right of a part before anything else.
    pub exchange: Option<SidedPart>,
    /// Whether speed, lateral places and heights are taken from the positions. Else the poses stand on the ground, one after
    /// the other at one place, as a camera that follows shows them.
    pub travel: bool,
}

impl Default for PositionImportOptions {
    fn default() -> Self {
        Self { name: "imported".into(), min_visibility: 0.5, frames: None, exchange: None, travel: false }
    }
}

/// Something that a person should know about imported poses. Frames are indices in the file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PositionWarning {
    /// Landmarks were not seen.
    Unseen {
        /// The frames.
        frames: Vec<usize>,
        /// The landmarks.
        landmarks: Vec<String>,
        /// Joints, with components of the rotation vector, that these would have determined; they stay near straight.
        undetermined: Vec<String>,
    },
    /// The body fits much better with left and right of a part exchanged.
    Sides {
        /// The frames.
        frames: Vec<usize>,
        /// What to exchange.
        part: SidedPart,
        /// Distance of the landmarks from the body as they are, root of the mean square, m.
        rms: f64,
        /// The same when exchanged, m.
        exchanged_rms: f64,
    },
    /// A landmark is far from the body.
    Stray {
        /// The frames.
        frames: Vec<usize>,
        /// The landmark.
        landmark: String,
        /// Largest distance, m.
        distance: f64,
    },
}

/// Why positions could not become key poses.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PositionImportError {
    /// The positions are wrong.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The layout does not fit the character.
    #[error(transparent)]
    Layout(#[from] BodyLandmarkError),
    /// Too few landmarks are seen to know how the body stands.
    #[error(
        "frame {frame}: {seen} landmarks are seen, but not {unseen}; valid: at least three of {trunk}, and {least} in all"
    )]
    TooFew {
        /// Index of the frame.
        frame: usize,
        /// Landmarks seen.
        seen: usize,
        /// Hips and shoulders that are not.
        unseen: String,
        /// All hips and shoulders.
        trunk: String,
        /// Landmarks needed.
        least: usize,
    },
    /// Hips and shoulders are at one place.
    #[error("frame {frame}: hips and shoulders are at one place; valid: positions of a body")]
    OnePlace {
        /// Index of the frame.
        frame: usize,
    },
    /// An option is out of range.
    #[error("{option} is {found}; valid: {valid}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it is.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// The key poses cannot be used, such as for two poses ten seconds apart.
    #[error(transparent)]
    KeyPoses(#[from] KeyPoseError),
}

/// Imported key poses.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedPoses {
    /// The text of their file.
    pub text: String,
    /// The same, read.
    pub key_poses: KeyPoses,
    /// How each pose was found.
    pub fits: Vec<PoseFit>,
    /// What a person should know.
    pub warnings: Vec<PositionWarning>,
    /// Joints, with components of the rotation vector, that the layout does not show even if all is seen.
    pub unshown: Vec<String>,
}

/// Fewest landmarks of a pose.
const LEAST: usize = 6;
/// Distance from which a landmark is reported, m.
const STRAY: f64 = 0.12;
/// Deviation, as a part of the prior's, from which a joint counts as not determined.
const UNDETERMINED: f64 = 0.5;
/// Most key poses of a file.
const MOST_POSES: usize = 1000;

/// Solves a pose for each chosen frame and writes them as key poses.
///
/// Scale and proportions are those of one body: found frame by frame, then set to what most frames say, and the poses solved
/// again. The first pose faces -Z (with `travel`, the way does).
pub fn import_positions(
    model: &CharacterModel,
    positions: &JointPositions,
    options: &PositionImportOptions,
) -> Result<ImportedPoses, PositionImportError> {
    positions.validate()?;
    let layout = &positions.layout;
    let body = BodyLandmarks::new(layout, model)?;
    let trunk = layout.trunk();
    let chosen = chosen_frames(positions, options)?;
    if !(0.0..=1.0).contains(&options.min_visibility) {
        let (found, valid) = (options.min_visibility.to_string(), "0 to 1".to_owned());
        return Err(PositionImportError::Option { option: "minimum visibility", found, valid });
    }
    let order = options.exchange.map(|part| exchange(layout, &body, model, part));
    let frames: Vec<Vec<Option<LandmarkTarget>>> = chosen
        .iter()
        .map(|&frame| {
            let targets = targets(&positions.frames[frame], order.as_deref(), options.min_visibility);
            check_seen(positions, &body, frame, &targets).map(|()| targets)
        })
        .collect::<Result<_, _>>()?;

    // Each frame for itself, and its sides.
    let solver = PoseSolver::new(model, &body);
    let exchanges: Vec<(SidedPart, Vec<usize>)> =
        SidedPart::ALL.iter().map(|&part| (part, exchange(layout, &body, model, part))).collect();
    let mut fits: Vec<PoseFit> = Vec::with_capacity(frames.len());
    let mut warnings = Vec::new();
    for (targets, &frame) in frames.iter().zip(&chosen) {
        let size = solver.guess_size(trunk, targets).ok_or(PositionImportError::OnePlace { frame })?;
        let fit = solver.solve(trunk, targets, &size, fits.last());
        if let Some((part, other)) = exchanged_part(&solver, &exchanges, trunk, targets, &size, &fit) {
            let (rms, exchanged_rms) = (fit.rms(), other.rms());
            warnings.push(PositionWarning::Sides { frames: vec![frame], part, rms, exchanged_rms });
        }
        fits.push(fit);
    }
    // One body for all.
    if fits.len() > 1 {
        let size = common_size(&fits);
        for i in 0..fits.len() {
            fits[i] = solver.solve(trunk, &frames[i], &size, Some(&fits[i]));
        }
    }

    let names = |index: usize| layout.landmarks[index].name.clone();
    for ((fit, targets), &frame) in fits.iter().zip(&frames).zip(&chosen) {
        let usable = |i: usize| body.points[i].is_some();
        let unseen: Vec<usize> = (0..targets.len()).filter(|&i| usable(i) && targets[i].is_none()).collect();
        if !unseen.is_empty() {
            let all = solver.uncertainty(fit, usable);
            let seen = solver.uncertainty(fit, |i| targets[i].is_some());
            let lost = |link: usize, k: usize| seen[link][k] > UNDETERMINED && seen[link][k] > 1.5 * all[link][k];
            let (frames, landmarks) = (vec![frame], unseen.iter().map(|&i| names(i)).collect());
            warnings.push(PositionWarning::Unseen { frames, landmarks, undetermined: components(model, lost) });
        }
        for (index, distance) in fit.distances.iter().enumerate() {
            if let Some(distance) = distance.filter(|d| *d > STRAY) {
                warnings.push(PositionWarning::Stray { frames: vec![frame], landmark: names(index), distance });
            }
        }
    }
    let all = solver.uncertainty(&fits[0], |i| body.points[i].is_some());
    let unshown = components(model, |link, k| all[link][k] > UNDETERMINED);
    let text = write(model, positions, &chosen, &fits, options);
    let key_poses = KeyPoses::from_ron(&text, format!("{}.keyposes.ron", options.name))?;
    // Times, places and angles are those of a file that can be played.
    key_poses.to_clip(model)?;
    Ok(ImportedPoses { text, key_poses, fits, warnings: merged(warnings), unshown })
}

fn chosen_frames(
    positions: &JointPositions,
    options: &PositionImportOptions,
) -> Result<Vec<usize>, PositionImportError> {
    let count = positions.frames.len();
    let chosen = options.frames.clone().unwrap_or_else(|| (0..count).collect());
    let fail = |found: String, valid: String| Err(PositionImportError::Option { option: "frames", found, valid });
    if chosen.is_empty() || chosen.len() > MOST_POSES {
        return fail(format!("{} frames", chosen.len()), format!("1 to {MOST_POSES} chosen ones"));
    }
    if let Some(frame) = chosen.iter().find(|f| **f >= count) {
        return fail(frame.to_string(), format!("0 to {}", count - 1));
    }
    if let Some(pair) = chosen.windows(2).find(|p| p[0] >= p[1]) {
        return fail(format!("{}, {}", pair[0], pair[1]), "ascending indices".into());
    }
    Ok(chosen)
}

fn targets(frame: &PositionFrame, order: Option<&[usize]>, min_visibility: f64) -> Vec<Option<LandmarkTarget>> {
    let count = frame.landmarks.len();
    (0..count)
        .map(|i| {
            let landmark = &frame.landmarks[order.map_or(i, |order| order[i])];
            let position = landmark.position.filter(|_| landmark.visibility >= min_visibility)?;
            Some(LandmarkTarget { position, weight: landmark.visibility.max(0.05) })
        })
        .collect()
}

fn check_seen(
    positions: &JointPositions,
    body: &BodyLandmarks,
    frame: usize,
    targets: &[Option<LandmarkTarget>],
) -> Result<(), PositionImportError> {
    let seen = targets.iter().zip(&body.points).filter(|(t, p)| t.is_some() && p.is_some()).count();
    let names = |all: Vec<usize>| -> Vec<&str> {
        all.into_iter().map(|i| positions.layout.landmarks[i].name.as_str()).collect()
    };
    let trunk = positions.layout.trunk();
    let unseen: Vec<usize> = trunk.into_iter().filter(|&i| targets[i].is_none()).collect();
    if unseen.len() > 1 || seen < LEAST {
        let unseen = if unseen.is_empty() { "enough".into() } else { names(unseen).join(", ") };
        let trunk = names(trunk.to_vec()).join(", ");
        return Err(PositionImportError::TooFew { frame, seen, unseen, trunk, least: LEAST });
    }
    Ok(())
}

/// The middle of what the frames say about the size of the body.
fn common_size(fits: &[PoseFit]) -> BodySize {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let links = fits[0].lengths.len();
    BodySize {
        scale: middle(fits.iter().map(|f| f.scale).collect()),
        // Estimators breathe a little.
        scale_spread: 0.03,
        lengths: (0..links).map(|link| middle(fits.iter().map(|f| f.lengths[link]).collect())).collect(),
        length_spread: 0.005,
    }
}

/// Links and the components for which `wanted` holds: `shin_left`, or `thigh_left (y)` where it is not all of them.
fn components(model: &CharacterModel, wanted: impl Fn(usize, usize) -> bool) -> Vec<String> {
    let mut out = Vec::new();
    for (i, link) in model.links.iter().enumerate().skip(1) {
        let axes: Vec<&str> = (0..3).filter(|&k| wanted(i, k)).map(|k| ["x", "y", "z"][k]).collect();
        let hinge = matches!(link.joint, JointKind::Hinge { .. });
        match axes.len() {
            0 => {}
            3 => out.push(link.name.clone()),
            _ if hinge => out.push(link.name.clone()),
            _ => out.push(format!("{} ({})", link.name, axes.join(", "))),
        }
    }
    out
}

/// One warning for all frames that have the same.
fn merged(warnings: Vec<PositionWarning>) -> Vec<PositionWarning> {
    let mut out: Vec<PositionWarning> = Vec::new();
    for warning in warnings {
        let same = out.iter_mut().any(|before| match (before, &warning) {
            (
                PositionWarning::Unseen { frames, landmarks, undetermined },
                PositionWarning::Unseen { frames: more, landmarks: l, undetermined: u },
            ) if landmarks == l => {
                frames.extend(more);
                undetermined.extend(u.clone());
                undetermined.sort();
                undetermined.dedup();
                true
            }
            (
                PositionWarning::Sides { frames, part, rms, exchanged_rms },
                PositionWarning::Sides { frames: more, part: p, rms: r, exchanged_rms: e },
            ) if part == p => {
                frames.extend(more);
                (*rms, *exchanged_rms) = (rms.max(*r), exchanged_rms.max(*e));
                true
            }
            (
                PositionWarning::Stray { frames, landmark, distance },
                PositionWarning::Stray { frames: more, landmark: l, distance: d },
            ) if landmark == l => {
                frames.extend(more);
                *distance = distance.max(*d);
                true
            }
            _ => false,
        });
        if !same {
            out.push(warning);
        }
    }
    out
}

/// The key poses as text.
fn write(
    model: &CharacterModel,
    positions: &JointPositions,
    chosen: &[usize],
    fits: &[PoseFit],
    options: &PositionImportOptions,
) -> String {
    let times: Vec<f64> = chosen.iter().map(|&f| positions.frames[f].time).collect();
    let mut seconds: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    seconds.push(seconds.last().copied().unwrap_or(0.3));

    // The way, if it counts.
    let (first, last) = (fits[0].root_position, fits[fits.len() - 1].root_position);
    let way = DVec3::new(last.x - first.x, 0.0, last.z - first.z);
    let travels = options.travel && way.length() > 0.1;
    let speed = if travels { way.length() / (times[times.len() - 1] - times[0]) } else { 0.0 };
    let ground = fits.iter().map(|fit| lowest(model, fit)).fold(f64::INFINITY, f64::min);
    let right = way.normalize_or(DVec3::NEG_Z).cross(DVec3::Y);

    let degrees = |r: DVec3| (r.x.to_degrees(), r.y.to_degrees(), r.z.to_degrees());
    let facing = |fit: &PoseFit| {
        let about = twist(fit.root_rotation, DVec3::Y);
        (2.0 * about.y.atan2(about.w)).to_degrees()
    };
    let start = if travels { (-way.x).atan2(-way.z).to_degrees() } else { facing(&fits[0]) };
    let mut turn = 0.0;
    let poses: Vec<(String, KeyPose)> = fits
        .iter()
        .zip(chosen)
        .map(|(fit, &frame)| {
            // The turn goes on the shorter way from pose to pose, also beyond half a turn in all.
            let wanted = facing(fit) - start;
            turn = wanted + 360.0 * ((turn - wanted) / 360.0).round();
            let upright = twist(fit.root_rotation, DVec3::Y).conjugate() * fit.root_rotation;
            let root = upright.to_scaled_axis();
            let joints: BTreeMap<String, (f64, f64, f64)> =
                model.links.iter().zip(&fit.joints).skip(1).map(|(link, r)| (link.name.clone(), degrees(*r))).collect();
            let pose = KeyPose {
                lateral: if travels { (fit.root_position - first).dot(right) } else { 0.0 },
                height: options.travel.then_some(fit.root_position.y - ground),
                turn,
                root: degrees(root),
                joints,
                ..Default::default()
            };
            let time = positions.frames[frame].time;
            let remark = format!("Frame {frame}, {time:.3} s: landmarks {:.1} cm off (RMS).", 100.0 * fit.rms());
            (remark, pose)
        })
        .collect();
    let remarks = [
        format!("From {} landmarks in the layout {}.", positions.layout.landmarks.len(), positions.layout.name),
        "Degrees: +x bends hip, shoulder and elbow forwards and lifts the toes; -x bends knee and trunk forwards;"
            .into(),
        "+y turns to the left; +z takes a hanging arm or leg to the right.".into(),
    ];
    let (name, character) = (&options.name, &model.name);
    NewKeyPoses {
        name,
        character,
        remarks: &remarks,
        speed: (speed * 1e3).round() / 1e3,
        seconds: &seconds,
        poses: &poses,
    }
    .text()
}

/// Height of the lowest contact point, m.
fn lowest(model: &CharacterModel, fit: &PoseFit) -> f64 {
    let mut places = Vec::new();
    fit.pose().link_transforms(model, &mut places);
    let heights = model.contact_points.iter().map(|point| {
        let link = &places[point.link];
        (link.position + link.rotation * point.position).y - point.radius
    });
    heights.fold(f64::INFINITY, f64::min)
}

/// `3`, `3-5`, `0, 3-5, 9`.
fn ranges(frames: &[usize]) -> String {
    let mut out: Vec<(usize, usize)> = Vec::new();
    for &frame in frames {
        match out.last_mut() {
            Some((_, last)) if *last + 1 == frame => *last = frame,
            _ => out.push((frame, frame)),
        }
    }
    let word = |&(a, b): &(usize, usize)| if a == b { a.to_string() } else { format!("{a}-{b}") };
    out.iter().map(word).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for PositionWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frames =
            |frames: &[usize]| format!("{} {}", if frames.len() == 1 { "frame" } else { "frames" }, ranges(frames));
        match self {
            PositionWarning::Unseen { frames: at, landmarks, undetermined } => {
                write!(f, "{}: {} not seen; ", frames(at), landmarks.join(", "))?;
                if undetermined.is_empty() {
                    write!(f, "the other landmarks determine the pose all the same")
                } else {
                    write!(f, "not determined, so near straight: {}", undetermined.join(", "))
                }
            }
            PositionWarning::Sides { frames: at, part, rms, exchanged_rms } => write!(
                f,
                "{}: left and right of the {} seem to be exchanged: landmarks are {:.1} cm off the body, {:.1} cm the other \
                 way round, where knees bend and toes point as they should",
                frames(at),
                part.name(),
                100.0 * rms,
                100.0 * exchanged_rms
            ),
            PositionWarning::Stray { frames: at, landmark, distance } => {
                write!(f, "{}: {landmark} is up to {:.0} cm off the body", frames(at), 100.0 * distance)
            }
        }
    }
}
