//! Motion clips as RON text (`*.clip.ron`).

use super::clip::{ClipError, MotionClip};
use super::read_file::{ReadFault, read_text};
use super::turn::unit;
use std::path::Path;

/// Largest clip file, bytes.
pub const MAX_CLIP_BYTES: usize = 256 << 20;

impl MotionClip {
    /// Reads a clip from RON text and checks it. Quaternions a little off unit length (below 0.001) are scaled to it.
    pub fn from_ron(text: &str) -> Result<Self, ClipError> {
        if text.len() > MAX_CLIP_BYTES {
            return Err(ClipError::TooLarge { what: "bytes", found: text.len(), limit: MAX_CLIP_BYTES });
        }
        let mut clip: MotionClip = ron::from_str(text).map_err(|error| ClipError::Syntax {
            line: error.span.start.line,
            column: error.span.start.col,
            reason: error.code.to_string(),
        })?;
        clip.validate()?;
        for pose in &mut clip.poses {
            // Untouched where rounding alone is to blame, so that a saved clip comes back bit for bit.
            for q in pose.joints.iter_mut().chain(std::iter::once(&mut pose.root_rotation)) {
                if (q.length_squared() - 1.0).abs() > 1e-12 {
                    *q = unit(*q);
                }
            }
        }
        Ok(clip)
    }

    /// The clip as RON text, one pose to a line. Numbers are written so that they come back bit for bit.
    pub fn to_ron(&self) -> Result<String, ClipError> {
        self.validate()?;
        let style = ron::ser::PrettyConfig::new().depth_limit(2).struct_names(true).new_line("\n").indentor(" ");
        ron::ser::to_string_pretty(self, style).map(|text| text + "\n").map_err(|error| ClipError::Syntax {
            line: 0,
            column: 0,
            reason: error.to_string(),
        })
    }

    /// The clip with numbers of six decimals, a micrometre and a microradian: less than half the text, for clips that are
    /// followed and not replayed.
    pub fn rounded(mut self) -> Self {
        // The sum turns a negative zero into zero.
        let round = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
        for pose in &mut self.poses {
            pose.root_position = pose.root_position.map(round);
            for q in pose.joints.iter_mut().chain(std::iter::once(&mut pose.root_rotation)) {
                *q = glam::DQuat::from_array(q.to_array().map(round));
            }
        }
        self
    }

    /// Reads a `*.clip.ron` file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ClipError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_CLIP_BYTES as u64).map_err(|error| match error.fault {
            ReadFault::TooLarge { bytes, .. } => {
                let found = usize::try_from(bytes).unwrap_or(usize::MAX);
                ClipError::TooLarge { what: "bytes", found, limit: MAX_CLIP_BYTES }
            }
            fault => ClipError::File { path: path.to_path_buf(), reason: fault.to_string() },
        })?;
        Self::from_ron(&text)
    }

    /// Writes a `*.clip.ron` file.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), ClipError> {
        let path = path.as_ref();
        std::fs::write(path, self.to_ron()?)
            .map_err(|e| ClipError::File { path: path.to_path_buf(), reason: e.to_string() })
    }
}
