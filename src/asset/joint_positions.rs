//! 3D positions of landmarks over time, as pose and human-mesh estimators give them (JSON).
//!
//! A landmark is `[x, y, z]`, `[x, y, z, visibility]`, `{"x": .., "y": .., "z": .., "visibility": ..}`, or `null` where it was
//! not found. A frame is the list of all landmarks in the order of the layout, or an object from names to landmarks, in
//! which names may be left out; or `{"time": seconds, "joints": LANDMARKS}`. A file is a frame, a list of frames, or
//!
//! ```json
//! {"layout": "smpl24", "axes": "y_up", "fps": 30, "frames": [FRAME, FRAME]}
//! ```
//!
//! with `"joints": LANDMARKS` in place of `frames` where there is only one. All but the positions may be left out. Result objects
//! of the common estimators are frames too (`results.rs`); a frame may be `null` where nobody was found. What a file does not say of
//! itself is looked for: an axis that points another way, places in a picture (`sense.rs`).

mod results;
mod sense;

use super::landmark_layout::{Axes, LandmarkLayout};
use super::read_file::read_text;
use glam::DVec3;
use serde_json::Value;
use std::path::{Path, PathBuf};

pub use sense::PositionNote;

/// One landmark in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Landmark {
    /// Where, in our axes and the file's unit of length; `None` where it was not found.
    pub position: Option<DVec3>,
    /// How surely it was seen, 0 to 1; 1 where the file does not say.
    pub visibility: f64,
}

impl Landmark {
    /// A landmark that was surely seen.
    pub fn at(position: DVec3) -> Self {
        Self { position: Some(position), visibility: 1.0 }
    }
}

/// All landmarks at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionFrame {
    /// Time, s.
    pub time: f64,
    /// In the order of the layout.
    pub landmarks: Vec<Landmark>,
}

/// A file of positions.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPositions {
    /// What the landmarks are.
    pub layout: LandmarkLayout,
    /// The frames, at least one, in order of time.
    pub frames: Vec<PositionFrame>,
    notes: Vec<PositionNote>,
}

/// What the reader is told from outside; it comes before what the file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PositionOptions {
    /// What the landmarks are; else the file's `layout`, else the built-in one with as many landmarks.
    pub layout: Option<LandmarkLayout>,
    /// The axes; else the file's `axes`, else those of the layout.
    pub axes: Option<Axes>,
    /// Frames per second where frames have no `time`; else the file's `fps`, else 30.
    pub fps: Option<f64>,
}

/// Why positions were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PositionError {
    /// The file could not be read.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The text is no JSON.
    #[error("line {line}, column {column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// A part of the file is not what it should be.
    #[error("{place}: {found}; valid: {valid}")]
    Value {
        /// Where.
        place: String,
        /// What was found.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// A frame has too few or too many landmarks.
    #[error("frame {frame} has {found} landmarks; valid: {expected}, as layout `{layout}` has")]
    Count {
        /// Index of the frame.
        frame: usize,
        /// Landmarks found.
        found: usize,
        /// The layout.
        layout: String,
        /// Landmarks of the layout.
        expected: usize,
    },
    /// A coordinate is not finite, or so large that it can be no position.
    #[error("frame {frame}, landmark `{landmark}`: {found}; valid: finite coordinates within 1e7, or null")]
    NotFinite {
        /// Index of the frame.
        frame: usize,
        /// The landmark.
        landmark: String,
        /// The position.
        found: String,
    },
}

/// Largest file, bytes.
pub const MAX_POSITION_BYTES: usize = 256 << 20;
/// Most frames.
pub const MAX_FRAMES: usize = 100_000;
/// Largest coordinate: millimetres over ten kilometres.
const MAX_COORDINATE: f64 = 1e7;

fn refuse<T>(place: impl Into<String>, found: impl Into<String>, valid: impl Into<String>) -> Result<T, PositionError> {
    Err(PositionError::Value { place: place.into(), found: found.into(), valid: valid.into() })
}

/// What a value is, in a few words.
fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => n.to_string(),
        Value::String(s) => format!("\"{}\"", s.chars().take(40).collect::<String>()),
        Value::Array(a) => format!("a list of {}", a.len()),
        Value::Object(o) => format!("an object of {}", o.len()),
    }
}

/// Whether a value can be a landmark, rather than a list of some.
fn is_landmark(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(a) => !a.is_empty() && a.iter().all(|v| v.is_number() || v.is_null()),
        Value::Object(o) => o.contains_key("x"),
        _ => false,
    }
}

/// Whether a value is the landmarks of one frame, rather than a list of frames.
fn is_frame(value: &Value) -> bool {
    match value {
        Value::Array(a) => a.iter().any(|v| is_landmark(v) && !v.is_null()) || a.is_empty(),
        Value::Object(_) => true,
        _ => false,
    }
}

const VALID_LANDMARK: &str =
    "[x, y, z], [x, y, z, visibility], {\"x\": .., \"y\": .., \"z\": .., \"visibility\": ..} or null";

fn landmark(value: &Value, place: &dyn Fn() -> String) -> Result<Landmark, PositionError> {
    let number = |v: &Value| match v {
        Value::Null => Ok(None),
        Value::Number(n) => Ok(n.as_f64()),
        other => refuse(place(), kind(other), VALID_LANDMARK),
    };
    let (coordinates, visibility) = match value {
        Value::Null => return Ok(Landmark::default()),
        Value::Array(a) if a.len() == 3 || a.len() == 4 => {
            ([number(&a[0])?, number(&a[1])?, number(&a[2])?], a.get(3).map(number).transpose()?.flatten())
        }
        Value::Object(o) if ["x", "y", "z"].iter().all(|k| o.contains_key(*k)) => (
            [number(&o["x"])?, number(&o["y"])?, number(&o["z"])?],
            o.get("visibility").or_else(|| o.get("score")).map(number).transpose()?.flatten(),
        ),
        other => return refuse(place(), kind(other), VALID_LANDMARK),
    };
    let [Some(x), Some(y), Some(z)] = coordinates else { return Ok(Landmark::default()) };
    Ok(Landmark { position: Some(DVec3::new(x, y, z)), visibility: visibility.unwrap_or(1.0).clamp(0.0, 1.0) })
}

/// The landmarks of one frame, in the file's axes.
fn landmarks(value: &Value, frame: usize, layout: &LandmarkLayout) -> Result<Vec<Landmark>, PositionError> {
    let expected = layout.landmarks.len();
    match value {
        Value::Null => Ok(vec![Landmark::default(); expected]),
        Value::Array(list) if list.is_empty() => Ok(vec![Landmark::default(); expected]),
        Value::Array(list) => {
            if list.len() != expected {
                let (found, layout) = (list.len(), layout.name.clone());
                return Err(PositionError::Count { frame, found, layout, expected });
            }
            let named = |(v, l): (&Value, &super::landmark_layout::LandmarkEntry)| {
                landmark(v, &|| format!("frame {frame}, landmark `{}`", l.name))
            };
            list.iter().zip(&layout.landmarks).map(named).collect()
        }
        Value::Object(named) => {
            let mut out = vec![Landmark::default(); expected];
            for (name, value) in named {
                let Some(index) = layout.index(name) else {
                    let names: Vec<&str> = layout.landmarks.iter().map(|l| l.name.as_str()).collect();
                    let place = format!("frame {frame}, landmark `{name}`");
                    return refuse(place, "unknown", format!("one of {}", names.join(", ")));
                };
                out[index] = landmark(value, &|| format!("frame {frame}, landmark `{name}`"))?;
            }
            Ok(out)
        }
        other => refuse(format!("frame {frame}"), kind(other), "a list of landmarks, or an object from names to them"),
    }
}

impl JointPositions {
    /// Positions that were made in the program.
    pub fn new(layout: LandmarkLayout, frames: Vec<PositionFrame>) -> Self {
        Self { layout, frames, notes: Vec::new() }
    }

    /// Reads a file.
    pub fn load(path: impl AsRef<Path>, options: &PositionOptions) -> Result<Self, PositionError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_POSITION_BYTES as u64)
            .map_err(|e| PositionError::File { path: path.to_path_buf(), reason: e.fault.to_string() })?;
        Self::from_json(&text, options)
    }

    /// Reads text.
    pub fn from_json(text: &str, options: &PositionOptions) -> Result<Self, PositionError> {
        // A byte order mark is no JSON.
        let text = text.trim_start_matches('\u{feff}');
        let file: Value = serde_json::from_str(text).map_err(|error| {
            let mut reason = error.to_string();
            if text.contains("NaN") || text.contains("Infinity") {
                reason += "; JSON has no NaN and no Infinity: write null for a landmark that was not found";
            }
            PositionError::Syntax { line: error.line(), column: error.column(), reason }
        })?;
        // What the file says about itself, and its frames.
        let none = serde_json::Map::new();
        let (head, frames): (_, Vec<&Value>) = match &file {
            Value::Object(head) if head.contains_key("frames") => match &head["frames"] {
                Value::Array(frames) => (head, frames.iter().collect()),
                other => return refuse("frames", kind(other), "a list of frames"),
            },
            Value::Object(head) if results::is_result(head) => (head, vec![&file]),
            frame if is_frame(frame) => (&none, vec![frame]),
            Value::Array(frames) => (&none, frames.iter().collect()),
            other => return refuse("file", kind(other), "a frame, a list of frames, or an object with `frames`"),
        };
        if frames.is_empty() || frames.len() > MAX_FRAMES {
            return refuse("frames", format!("{} frames", frames.len()), format!("1 to {MAX_FRAMES}"));
        }
        // What is in each frame, and what the first one with somebody in it tells.
        let inner = frames.iter().enumerate().map(|(i, frame)| results::landmarks_of(frame, &format!("frame {i}")));
        let inner = inner.collect::<Result<Vec<&Value>, PositionError>>()?;
        let nobody = |value: &Value| value.is_null() || value.as_array().is_some_and(Vec::is_empty);
        let first = inner.iter().copied().find(|v| !nobody(v));
        if first.is_none() && inner.len() > 1 {
            return refuse("frames", "nobody in any of them", "at least one frame with landmarks");
        }
        let layout = layout_of(options, head, first.unwrap_or(inner[0]))?;
        let named = options.axes.is_some() || head.contains_key("axes");
        let axes = axes_of(options, head, layout.axes)?;
        let fps = match (options.fps, head.get("fps")) {
            (Some(fps), _) => fps,
            (None, Some(value)) => value.as_f64().unwrap_or(f64::NAN),
            (None, None) => 30.0,
        };
        if !(0.1..=1000.0).contains(&fps) {
            return refuse("fps", head.get("fps").map_or(fps.to_string(), kind), "0.1 to 1000 frames per second");
        }

        let mut out = Vec::with_capacity(frames.len());
        for (index, frame) in frames.into_iter().enumerate() {
            let time = match frame.get("time") {
                None => index as f64 / fps,
                Some(value) => match value.as_f64() {
                    Some(time) => time,
                    None => return refuse(format!("frame {index}, time"), kind(value), "seconds"),
                },
            };
            out.push(PositionFrame { time, landmarks: landmarks(inner[index], index, &layout)? });
        }
        let mut positions = Self { layout, frames: out, notes: Vec::new() };
        positions.validate()?;
        if !named {
            sense::refuse_picture(&positions.frames, &positions.layout)?;
        }
        let axes = sense::settle_axes(&positions.frames, &positions.layout, axes, named, &mut positions.notes);
        for landmark in positions.frames.iter_mut().flat_map(|f| &mut f.landmarks) {
            landmark.position = landmark.position.map(|p| axes.to_ours(p));
        }
        sense::fill_gaps(&mut positions.frames, &mut positions.notes);
        Ok(positions)
    }

    /// Whether counts, times and coordinates can be used.
    pub fn validate(&self) -> Result<(), PositionError> {
        if self.frames.is_empty() || self.frames.len() > MAX_FRAMES {
            return refuse("frames", format!("{} frames", self.frames.len()), format!("1 to {MAX_FRAMES}"));
        }
        let expected = self.layout.landmarks.len();
        for (frame, f) in self.frames.iter().enumerate() {
            if f.landmarks.len() != expected {
                let (found, layout) = (f.landmarks.len(), self.layout.name.clone());
                return Err(PositionError::Count { frame, found, layout, expected });
            }
            let after = frame.checked_sub(1).map_or(-1e6, |i| self.frames[i].time);
            if !(f.time > after && f.time < 1e6) {
                let place = format!("frame {frame}, time");
                return refuse(place, f.time.to_string(), "seconds, later than the frame before");
            }
            for (landmark, l) in f.landmarks.iter().zip(&self.layout.landmarks) {
                if let Some(p) = landmark.position
                    && !(p.is_finite() && p.abs().max_element() <= MAX_COORDINATE)
                {
                    let (landmark, found) = (l.name.clone(), p.to_string());
                    return Err(PositionError::NotFinite { frame, landmark, found });
                }
            }
        }
        Ok(())
    }
}

fn layout_of(
    options: &PositionOptions,
    head: &serde_json::Map<String, Value>,
    first: &Value,
) -> Result<LandmarkLayout, PositionError> {
    if let Some(layout) = &options.layout {
        return Ok(layout.clone());
    }
    let valid = || format!("{}, or a layout of your own", LandmarkLayout::NAMES.join(", "));
    if let Some(value) = head.get("layout") {
        return match value.as_str().and_then(LandmarkLayout::built_in) {
            Some(layout) => Ok(layout),
            None => refuse("layout", kind(value), valid()),
        };
    }
    match first {
        Value::Array(list) => match LandmarkLayout::of_count(list.len()) {
            Some(layout) => Ok(layout),
            None => refuse("frame 0", format!("{} landmarks and no layout named", list.len()), valid()),
        },
        _ => refuse("layout", "none named", valid()),
    }
}

fn axes_of(
    options: &PositionOptions,
    head: &serde_json::Map<String, Value>,
    default: Axes,
) -> Result<Axes, PositionError> {
    if let Some(axes) = options.axes {
        return Ok(axes);
    }
    let Some(value) = head.get("axes") else { return Ok(default) };
    match Axes::NAMES.iter().find(|(name, _)| value.as_str() == Some(name)) {
        Some((_, axes)) => Ok(*axes),
        None => refuse("axes", kind(value), Axes::NAMES.map(|(name, _)| name).join(", ")),
    }
}
