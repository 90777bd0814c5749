//! What a storyboard is made from: instants of a motion, and how to look at them.

use crate::model::{CharacterModel, LinkTransform, Shape};
use glam::DVec3;

/// A place where the world pushes on the character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchPoint {
    /// Where, world frame, m.
    pub position: DVec3,
    /// Force on the character, world frame, N.
    pub force: DVec3,
}

/// One instant of the motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoryboardFrame {
    /// Time, s.
    pub time: f64,
    /// Every link, in the model's order.
    pub links: Vec<LinkTransform>,
    /// Every link of the reference, drawn translucent behind the figure.
    pub ghost: Option<Vec<LinkTransform>>,
    /// What touches.
    pub contacts: Vec<TouchPoint>,
    /// Solids drawn in red: link and number of the shape on it.
    pub marked: Vec<(usize, usize)>,
    /// A word or two below the time label; empty for none.
    pub caption: String,
}

impl StoryboardFrame {
    /// An instant with nothing but the figure. Time in s.
    pub fn new(time: f64, links: Vec<LinkTransform>) -> Self {
        Self { time, links, ..Default::default() }
    }

    /// Centre of mass of the figure, world frame, m.
    pub fn center_of_mass(&self, model: &CharacterModel) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (link, place) in model.links.iter().zip(&self.links) {
            sum += link.mass * (place.position + place.rotation * link.com);
        }
        sum / model.mass().max(f64::MIN_POSITIVE)
    }
}

/// What the camera of a cell is centred on, horizontally. The ground stays at the same height in every cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follow {
    /// The root, cell by cell: the figure fills every cell.
    #[default]
    Root,
    /// The middle of the way: the figure travels through the cells, as small as that needs.
    Fixed,
}

/// What the azimuth counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heading {
    /// The direction from the first to the last frame's root; where that is shorter than 0.3 m, the way the root faces in
    /// the first frame. The motion runs from left to right.
    #[default]
    Travel,
    /// The world's -Z.
    World,
}

/// The surface the figure is drawn on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ground {
    /// Pale blue.
    #[default]
    Ice,
    /// Warm grey.
    Floor,
}

/// How a storyboard looks.
#[derive(Clone, Debug, PartialEq)]
pub struct StoryboardOptions {
    /// Width of the picture, pixels (64 to 16384).
    pub width: u32,
    /// Height of the picture, pixels (64 to 16384).
    pub height: u32,
    /// Number of cells (1 to 64); fewer where fewer frames are given or a cell would be narrower than 16 pixels.
    pub frames: usize,
    /// Most cells in a row (1 to 64); what is more goes into rows below.
    pub columns: usize,
    /// Camera azimuth, rad: 0 looks at the side with the heading to the right, positive moves the camera to the front.
    pub azimuth: f64,
    /// Camera elevation above the horizon, rad (0 to 1.5).
    pub elevation: f64,
    /// What the azimuth counts from.
    pub heading: Heading,
    /// What the camera follows.
    pub follow: Follow,
    /// What the ground looks like.
    pub ground: Ground,
    /// Height of the ground, world frame, m.
    pub ground_height: f64,
    /// Whether to draw the band with the way of the centre of mass from above.
    pub path_band: bool,
    /// Whether to write its time into each cell.
    pub times: bool,
    /// Whether to draw the world's axes beside the figure.
    pub axes: bool,
    /// Fixed solids to draw with the figure (stairs, a wall), world frame.
    pub scenery: Vec<Shape>,
    /// A line above the strip; empty for none.
    pub title: String,
}

impl Default for StoryboardOptions {
    fn default() -> Self {
        Self {
            width: 1920,
            height: 560,
            frames: 8,
            columns: 64,
            azimuth: 0.35,
            elevation: 0.17,
            heading: Heading::Travel,
            follow: Follow::Root,
            ground: Ground::Ice,
            ground_height: 0.0,
            path_band: true,
            times: true,
            axes: false,
            scenery: Vec::new(),
            title: String::new(),
        }
    }
}

/// Why a storyboard could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoryboardError {
    /// There was nothing to draw.
    #[error("a storyboard needs at least one frame")]
    NoFrames,
    /// A frame does not fit the character.
    #[error("frame {frame} has {found} links, the character {character} has {expected}")]
    LinkCount {
        /// Index of the frame.
        frame: usize,
        /// Name of the character.
        character: String,
        /// Links in the frame (or in its ghost).
        found: usize,
        /// Links of the character.
        expected: usize,
    },
    /// A number that is not finite.
    #[error("frame {frame} holds a number that is not finite in {place}")]
    NotFinite {
        /// Index of the frame.
        frame: usize,
        /// Which part of it.
        place: &'static str,
    },
    /// An option out of its range.
    #[error("storyboard option {option} is {value}, valid is {valid}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// What it was.
        value: f64,
        /// What would be valid.
        valid: &'static str,
    },
    /// The picture could not be encoded.
    #[error("the picture could not be encoded: {0}")]
    Encode(String),
    /// The file could not be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
}

impl StoryboardOptions {
    /// Refuses options that no picture can be made from.
    pub(crate) fn check(&self) -> Result<(), StoryboardError> {
        let fail = |option, value, valid| Err(StoryboardError::Option { option, value, valid });
        if !(64..=16384).contains(&self.width) {
            return fail("width", self.width.into(), "64 to 16384");
        }
        if !(64..=16384).contains(&self.height) {
            return fail("height", self.height.into(), "64 to 16384");
        }
        if !(1..=64).contains(&self.frames) {
            return fail("frames", self.frames as f64, "1 to 64");
        }
        if !(1..=64).contains(&self.columns) {
            return fail("columns", self.columns as f64, "1 to 64");
        }
        if !self.azimuth.is_finite() {
            return fail("azimuth", self.azimuth, "any finite angle in rad");
        }
        if !(0.0..=1.5).contains(&self.elevation) {
            return fail("elevation", self.elevation, "0 to 1.5 rad");
        }
        if !self.ground_height.is_finite() {
            return fail("ground_height", self.ground_height, "any finite height in m");
        }
        Ok(())
    }
}

/// Refuses frames that do not fit the character or hold numbers that are not finite.
pub(crate) fn check_frames(model: &CharacterModel, frames: &[StoryboardFrame]) -> Result<(), StoryboardError> {
    if frames.is_empty() {
        return Err(StoryboardError::NoFrames);
    }
    let finite = |links: &[LinkTransform]| links.iter().all(|l| l.position.is_finite() && l.rotation.is_finite());
    for (frame, f) in frames.iter().enumerate() {
        for links in std::iter::once(&f.links).chain(&f.ghost) {
            if links.len() != model.links.len() {
                let (found, expected) = (links.len(), model.links.len());
                return Err(StoryboardError::LinkCount { frame, character: model.name.clone(), found, expected });
            }
        }
        let fail = |place| Err(StoryboardError::NotFinite { frame, place });
        if !f.time.is_finite() {
            return fail("time");
        }
        if !finite(&f.links) {
            return fail("links");
        }
        if !f.ghost.as_ref().is_none_or(|g| finite(g)) {
            return fail("ghost");
        }
        if !f.contacts.iter().all(|c| c.position.is_finite() && c.force.is_finite()) {
            return fail("contacts");
        }
    }
    Ok(())
}
