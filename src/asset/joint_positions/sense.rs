//! What positions say about themselves that their file does not: places in a picture, an axis that points another way, frames
//! in which nobody was seen.

use super::{Axes, JointPositions, LandmarkLayout, PositionError, PositionFrame, refuse};
use glam::DVec3;
use std::fmt;

/// Something that a person should know about positions as they were read. Frames are indices in the file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PositionNote {
    /// The figure stood another way than the axes of the layout say, and was turned.
    Turned {
        /// The axes of the layout.
        from: &'static str,
        /// The axes that were taken.
        to: &'static str,
    },
    /// The axes that were named leave the figure on its head or on its side.
    NotUpright {
        /// The axes that were named.
        named: &'static str,
        /// The axes in which it would stand.
        upright: &'static str,
    },
    /// Nobody was found in some frames, which were filled from those around them.
    Gap {
        /// The frames.
        frames: Vec<usize>,
    },
}

impl fmt::Display for PositionNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PositionNote::Turned { from, to } => write!(
                f,
                "the figure does not stand up in the axes `{from}` of its layout; taken as `{to}` (name the axes if it is meant to be so)"
            ),
            PositionNote::NotUpright { named, upright } => {
                write!(f, "the figure does not stand up in the axes `{named}` that were named; in `{upright}` it would")
            }
            PositionNote::Gap { frames } => {
                let list: Vec<String> = frames.iter().take(12).map(usize::to_string).collect();
                let more = if frames.len() > 12 { format!(" and {} more", frames.len() - 12) } else { String::new() };
                write!(
                    f,
                    "nobody in {} {}{more}: filled from the frames around",
                    if frames.len() == 1 { "frame" } else { "frames" },
                    list.join(", ")
                )
            }
        }
    }
}

/// Cosine from which a figure stands on its head.
const ON_ITS_HEAD: f64 = -0.7;
/// Cosine from which a figure stands along another axis.
const ALONG: f64 = 0.9;
/// How far normalised places may be beyond the edges of the picture.
const BEYOND_PICTURE: f64 = 0.35;
/// Farthest that the hips of an estimator's landmarks in space are from their origin, m.
const HIPS_AT_ORIGIN: f64 = 0.1;

/// Name of axes.
fn name(axes: Axes) -> &'static str {
    Axes::NAMES.iter().find(|(_, a)| *a == axes).map_or("", |(name, _)| name)
}

/// Mean direction from the hips to the shoulders over all frames, of unit length where it never changes. File's axes.
fn trunk_up(frames: &[PositionFrame], layout: &LandmarkLayout) -> Option<DVec3> {
    let [left_hip, right_hip, left_shoulder, right_shoulder] = layout.trunk();
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for frame in frames {
        let at = |i: usize| frame.landmarks[i].position;
        let points = (at(left_hip), at(right_hip), at(left_shoulder), at(right_shoulder));
        if let (Some(a), Some(b), Some(c), Some(d)) = points {
            sum += (c + d - a - b).normalize_or_zero();
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// The axes in which the figure stands: those given unless it stands on its head or exactly along another axis.
pub(super) fn settle_axes(
    frames: &[PositionFrame],
    layout: &LandmarkLayout,
    axes: Axes,
    named: bool,
    notes: &mut Vec<PositionNote>,
) -> Axes {
    let Some(up) = trunk_up(frames, layout) else { return axes };
    let height = |axes: Axes| axes.to_ours(up).y;
    // Along the depth of a camera's picture people do lie.
    let along_depth = axes != Axes::YDown && height(axes).abs() < 1.0 - ALONG;
    let lies = height(axes) < ON_ITS_HEAD || along_depth;
    let other = Axes::NAMES.iter().map(|(_, a)| *a).find(|a| height(*a) > ALONG);
    match other {
        Some(other) if lies && named => {
            notes.push(PositionNote::NotUpright { named: name(axes), upright: name(other) });
            axes
        }
        Some(other) if lies => {
            notes.push(PositionNote::Turned { from: name(axes), to: name(other) });
            other
        }
        _ => axes,
    }
}

/// Refuses what are places in a picture: all within it, from 0 to 1, and no hips at the origin; or without any depth.
pub(super) fn refuse_picture(frames: &[PositionFrame], layout: &LandmarkLayout) -> Result<(), PositionError> {
    let all = || frames.iter().flat_map(|f| f.landmarks.iter().filter_map(|l| l.position));
    let count = all().count();
    if count < 4 {
        return Ok(());
    }
    let valid = "positions in space, such as the result's `worldLandmarks` or `pose_world_landmarks`";
    if all().all(|p| p.z == 0.0) {
        return refuse("z", "0 throughout: these are places in a picture", valid);
    }
    let [left, right, ..] = layout.trunk();
    let hips = |f: &PositionFrame| Some((f.landmarks[left].position? + f.landmarks[right].position?) / 2.0);
    let estimator = layout.name == "mediapipe33";
    let edge = if estimator { BEYOND_PICTURE } else { 0.0 };
    let inside = all().all(|p| [p.x, p.y].iter().all(|v| (-edge..=1.0 + edge).contains(v)));
    let mean: DVec3 = all().sum::<DVec3>() / count as f64;
    let centred = (0.1..=0.9).contains(&mean.x) && (0.1..=0.9).contains(&mean.y);
    let away = frames.iter().filter_map(hips).all(|p| p.truncate().length() > HIPS_AT_ORIGIN);
    if inside && centred && away {
        let found =
            format!("all between 0 and 1, the middle at {:.2}, {:.2}: these are places in a picture", mean.x, mean.y);
        return refuse("x and y", found, format!("{valid}; name the axes if they are metres all the same"));
    }
    Ok(())
}

/// Fills frames without a landmark from those before and after them, in proportion to the time; at an end, as the next one.
pub(super) fn fill_gaps(frames: &mut [PositionFrame], notes: &mut Vec<PositionNote>) {
    let seen = |f: &PositionFrame| f.landmarks.iter().any(|l| l.position.is_some());
    let gaps: Vec<usize> = (0..frames.len()).filter(|&i| !seen(&frames[i])).collect();
    if gaps.is_empty() || gaps.len() == frames.len() {
        return;
    }
    let full: Vec<usize> = (0..frames.len()).filter(|i| gaps.binary_search(i).is_err()).collect();
    for &gap in &gaps {
        let after = full.partition_point(|&i| i < gap);
        let (a, b) = (full[after.saturating_sub(1)], full[after.min(full.len() - 1)]);
        let (from, to) = (frames[a].time, frames[b].time);
        let share = if to > from { ((frames[gap].time - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let mixed = frames[a].landmarks.iter().zip(&frames[b].landmarks).map(|(x, y)| super::Landmark {
            position: x.position.zip(y.position).map(|(p, q)| p.lerp(q, share)),
            visibility: x.visibility.min(y.visibility),
        });
        let mixed: Vec<super::Landmark> = mixed.collect();
        frames[gap].landmarks = mixed;
    }
    notes.push(PositionNote::Gap { frames: gaps });
}

impl JointPositions {
    /// What a person should know about the positions as they were read.
    pub fn notes(&self) -> &[PositionNote] {
        &self.notes
    }
}
