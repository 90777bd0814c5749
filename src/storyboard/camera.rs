//! The view of a cell: orthographic, looking at the ground point below what it follows.
//!
//! View axes: `x` right, `y` up in the picture, `z` towards the viewer, metres, origin at the target on the ground. The
//! target is always at the same pixel of its cell, so the ground stays where it is from cell to cell.

use super::frame::{Follow, Heading, StoryboardFrame, StoryboardOptions};
use glam::{DMat3, DVec2, DVec3};

/// Room left free at the sides of a cell, as a part of its width.
const SIDE_MARGIN: f64 = 0.07;
/// Room left free below the lowest point of the figure, as a part of the cell's height.
const BOTTOM_MARGIN: f64 = 0.07;

/// A camera: world to pixels of one cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// World axes to view axes.
    pub axes: DMat3,
    /// The point on the ground that is at `anchor`, world frame, m.
    pub target: DVec3,
    /// Where the target is in the cell, pixels.
    pub anchor: DVec2,
    /// Pixels per metre.
    pub scale: f64,
}

impl Camera {
    /// A world point in the view frame, m.
    pub fn view(&self, world: DVec3) -> DVec3 {
        self.axes * (world - self.target)
    }

    /// A world point in the cell, pixels, and its height towards the viewer, m.
    pub fn project(&self, world: DVec3) -> (f32, f32, f32) {
        let v = self.view(world);
        ((self.anchor.x + v.x * self.scale) as f32, (self.anchor.y - v.y * self.scale) as f32, v.z as f32)
    }

    /// The horizontal unit vector that points right in the picture, world frame.
    pub fn right(&self) -> DVec3 {
        self.axes.row(0)
    }

    /// The horizontal unit vector away from the viewer, world frame.
    pub fn away(&self) -> DVec3 {
        let right = self.right();
        DVec3::Y.cross(right)
    }
}

/// The unit vector the motion goes along, horizontal, world frame: from the first to the last root or, where that is
/// short, the way the first root faces.
pub fn travel(frames: &[StoryboardFrame]) -> DVec3 {
    let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
    let root = |f: &StoryboardFrame| f.links.first().map_or(DVec3::ZERO, |l| l.position);
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return DVec3::NEG_Z };
    let way = flat(root(last) - root(first));
    let faces = first.links.first().map_or(DVec3::NEG_Z, |l| flat(l.rotation * DVec3::NEG_Z));
    if way.length() > 0.3 { way.normalize() } else { faces.try_normalize().unwrap_or(DVec3::NEG_Z) }
}

/// World axes to view axes.
pub(crate) fn view_axes(options: &StoryboardOptions, frames: &[StoryboardFrame]) -> DMat3 {
    let forward = match options.heading {
        Heading::Travel => travel(frames),
        Heading::World => DVec3::NEG_Z,
    };
    // Right of the heading (heading x up) is where the camera stands at azimuth zero; turning it towards the heading
    // shows the front.
    let side = forward.cross(DVec3::Y);
    let (sin, cos) = options.azimuth.sin_cos();
    let level = side * cos + forward * sin;
    let towards = level * options.elevation.cos() + DVec3::Y * options.elevation.sin();
    let right = DVec3::Y.cross(level);
    let up = towards.cross(right);
    DMat3::from_cols(right, up, towards).transpose()
}

/// The points of the ground that the cells are centred on, world frame, m.
pub(crate) fn targets(options: &StoryboardOptions, cells: &[&StoryboardFrame]) -> Vec<DVec3> {
    let ground = |v: DVec3| DVec3::new(v.x, options.ground_height, v.z);
    let roots: Vec<DVec3> = cells.iter().map(|f| f.links.first().map_or(DVec3::ZERO, |l| ground(l.position))).collect();
    match options.follow {
        Follow::Root => roots,
        Follow::Fixed => {
            let low = roots.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = roots.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            vec![(low + high) / 2.0; roots.len()]
        }
    }
}

/// Cameras for all cells with one common scale, so that everything drawn fits into every cell.
///
/// `extents` gives, for each cell, the corners of what is drawn in it, world frame, m. `size` is that of a cell and `top`
/// the room its labels need, pixels.
pub(crate) fn fit(axes: DMat3, targets: &[DVec3], extents: &[Vec<DVec3>], size: DVec2, top: f64) -> Vec<Camera> {
    let (mut half_width, mut low, mut high) = (0.15f64, 0.0f64, 0.3f64);
    for (target, points) in targets.iter().zip(extents) {
        for p in points {
            let v = axes * (*p - *target);
            half_width = half_width.max(v.x.abs());
            (low, high) = (low.min(v.y), high.max(v.y));
        }
    }
    let room = size.y * (1.0 - BOTTOM_MARGIN) - top;
    let scale = (size.x * (0.5 - SIDE_MARGIN) / half_width).min(room / (high - low));
    // What the width leaves over is shared between above and below.
    let spare = room - (high - low) * scale;
    let anchor = DVec2::new(size.x / 2.0, size.y * (1.0 - BOTTOM_MARGIN) + low * scale - spare * 0.4);
    targets.iter().map(|&target| Camera { axes, target, anchor, scale }).collect()
}
