//! What stands on the course: pieces that the player moves, as data.

use crate::asset::{Course, CourseError};
use crate::contact::World;
use bevy::prelude::*;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PieceKind {
    /// Something to go over.
    Box,
    /// Something to go up, and down from.
    Step,
    /// A gap right across the ground.
    Gap,
}

impl PieceKind {
    pub(crate) const ALL: [Self; 3] = [Self::Box, Self::Step, Self::Gap];

    /// Its name in the menu.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Box => "Box",
            Self::Step => "Step",
            Self::Gap => "Gap",
        }
    }
}

/// Lowest and highest piece, m.
pub(crate) const HEIGHTS: (f32, f32) = (0.1, 1.4);
/// Shortest and longest, along the way, m.
pub(crate) const DEPTHS: (f32, f32) = (0.2, 6.0);
/// Narrowest and widest, m.
pub(crate) const WIDTHS: (f32, f32) = (0.6, 8.0);
/// How far to a side and along the way pieces may stand, m.
const BOUNDS: (f32, f32) = (12.0, 70.0);
/// A runner below this fell into a gap, m.
pub(super) const LOST: f32 = -1.2;
/// No piece comes nearer to the runner than this, m.
const ROOM: f32 = 0.7;
/// Height of the handle over a piece, m.
pub(super) const HANDLE: f32 = 0.35;
/// Radius within which the pointer takes the handle, m.
pub(super) const HANDLE_REACH: f32 = 0.22;
/// A gap is taken hold of as a plate of this height, m.
const PLATE: f32 = 0.04;
/// A gap is as wide as the hall to who looks, m.
const HALL: f32 = 160.0;
/// Most pieces.
pub(crate) const MOST: usize = 24;

/// One obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub kind: PieceKind,
    /// Middle over the ground: to the right, m.
    pub right: f32,
    /// Middle over the ground: along the way (-Z), m.
    pub ahead: f32,
    /// Along the way, m.
    pub depth: f32,
    /// Across it, m.
    pub width: f32,
    /// m; of a gap nothing.
    pub height: f32,
}

impl Piece {
    /// One as the menu gives it.
    pub(crate) fn new(kind: PieceKind, ahead: f32) -> Self {
        let (depth, width, height) = match kind {
            PieceKind::Box => (0.35, 1.4, 0.4),
            PieceKind::Step => (6.0, 3.0, 0.4),
            PieceKind::Gap => (1.2, HALL, 0.0),
        };
        Self { kind, right: 0.0, ahead, depth, width, height }
    }

    /// Edge lengths, m.
    pub(super) fn size(&self) -> Vec3 {
        let height = if self.kind == PieceKind::Gap { PLATE } else { self.height };
        Vec3::new(self.width, height, self.depth)
    }

    /// Its middle, m.
    pub(super) fn middle(&self) -> Vec3 {
        let up = if self.kind == PieceKind::Gap { -0.5 * PLATE + 0.004 } else { 0.5 * self.height };
        Vec3::new(self.right, up, -self.ahead)
    }

    /// Where its height is taken hold of (of a gap, its length), m.
    pub(super) fn handle(&self) -> Vec3 {
        let along = if self.kind == PieceKind::Gap { -self.ahead - 0.5 * self.depth } else { -self.ahead };
        Vec3::new(self.right, self.height + HANDLE, along)
    }

    /// How far along a ray it is hit.
    fn hit(&self, ray: Ray3d) -> Option<f32> {
        let (half, origin, way) = (self.size() * 0.5, ray.origin - self.middle(), ray.direction.as_vec3());
        let (mut near, mut far) = (0.0_f32, f32::INFINITY);
        for axis in 0..3 {
            if way[axis].abs() < 1e-9 {
                if origin[axis].abs() > half[axis] {
                    return None;
                }
                continue;
            }
            let ends = [-1.0, 1.0].map(|side: f32| (side * half[axis] - origin[axis]) / way[axis]);
            (near, far) = (near.max(ends[0].min(ends[1])), far.min(ends[0].max(ends[1])));
        }
        (near <= far).then_some(near)
    }

    /// Whether runners at these places have room beside it.
    fn leaves_room(&self, runners: &[Vec3]) -> bool {
        runners.iter().all(|runner| {
            let aside = (runner.x - self.right).abs() - 0.5 * self.width;
            let along = (runner.z + self.ahead).abs() - 0.5 * self.depth;
            aside.max(along) > ROOM
        })
    }

    /// With its numbers in their ranges; as wide as a race wants it.
    fn within(mut self, race_width: Option<f32>) -> Self {
        self.right = self.right.clamp(-BOUNDS.0, BOUNDS.0);
        self.ahead = self.ahead.clamp(-BOUNDS.1, BOUNDS.1);
        self.depth = self.depth.clamp(DEPTHS.0, DEPTHS.1);
        match (self.kind, race_width) {
            (PieceKind::Gap, _) => (self.right, self.width, self.height) = (0.0, HALL, 0.0),
            (_, Some(width)) => (self.right, self.width) = (0.0, width),
            (_, None) => self.width = self.width.clamp(WIDTHS.0, WIDTHS.1),
        }
        if self.kind != PieceKind::Gap {
            self.height = self.height.clamp(HEIGHTS.0, HEIGHTS.1);
        }
        self
    }
}

/// What the pointer has of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grip {
    /// All of it; from the pointer to its middle over the ground, m, and the height at which the pointer holds it, m.
    Whole { offset: Vec3, level: f32 },
    /// Its height, or a gap's length.
    Size,
}

/// The course as the player has built it.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Site {
    /// What stands there.
    pub pieces: Vec<Piece>,
    /// The piece that was touched last.
    pub chosen: Option<usize>,
    /// What the pointer holds, by its piece.
    pub held: Option<(usize, Grip)>,
    /// Width of every piece while a race is on, m: right across the lanes.
    pub race_width: Option<f32>,
    /// Counts the changes.
    pub revision: u32,
}

impl Site {
    /// With these pieces.
    pub(crate) fn lay(&mut self, pieces: Vec<Piece>) {
        let (race_width, revision) = (self.race_width, self.revision + 1);
        *self = Self {
            pieces: pieces.into_iter().map(|p| p.within(race_width)).collect(),
            race_width,
            revision,
            ..Self::default()
        };
    }

    /// Puts one more there.
    pub(crate) fn add(&mut self, piece: Piece, runners: &[Vec3]) -> bool {
        let piece = piece.within(self.race_width);
        let added = self.pieces.len() < MOST && piece.leaves_room(runners);
        if added {
            self.pieces.push(piece);
            self.chosen = Some(self.pieces.len() - 1);
            self.revision += 1;
        }
        added
    }

    /// Takes the chosen one away.
    pub(crate) fn remove(&mut self) {
        if let Some(k) = self.chosen.take().filter(|k| *k < self.pieces.len()) {
            self.pieces.remove(k);
            self.held = None;
            self.revision += 1;
        }
    }

    /// Changes a piece, where the runners have room beside what it becomes. Numbers out of their ranges are brought into them.
    pub(crate) fn change(&mut self, k: usize, wanted: Piece, runners: &[Vec3]) -> bool {
        let wanted = wanted.within(self.race_width);
        let Some(piece) = self.pieces.get_mut(k) else { return false };
        // What a runner stands on does not move under it; a height may change before its nose.
        let (place, size) = ((wanted.right, wanted.ahead), (wanted.depth, wanted.width));
        let stays = (piece.right, piece.ahead) == place && (piece.depth, piece.width) == size;
        let over = !piece.leaves_room(runners);
        if wanted == *piece || (over && wanted.kind != PieceKind::Gap) || !(stays || wanted.leaves_room(runners)) {
            return false;
        }
        *piece = wanted;
        self.revision += 1;
        true
    }

    /// The piece under a ray, and what of it.
    pub(super) fn under(&self, ray: Ray3d) -> Option<(usize, Grip)> {
        let way = ray.direction.as_vec3();
        let mut nearest: Option<(f32, usize, Grip)> = None;
        let mut see = |along: f32, k: usize, grip: Grip| {
            if along > 0.1 && nearest.is_none_or(|(before, ..)| along < before) {
                nearest = Some((along, k, grip));
            }
        };
        for (k, piece) in self.pieces.iter().enumerate() {
            let along = (piece.handle() - ray.origin).dot(way);
            if (ray.origin + way * along).distance(piece.handle()) < HANDLE_REACH {
                see(along, k, Grip::Size);
            }
            if let Some(along) = piece.hit(ray) {
                let point = ray.origin + way * along;
                see(along, k, Grip::Whole { offset: piece.middle() - point, level: point.y });
            }
        }
        nearest.map(|(_, k, grip)| (k, grip))
    }

    /// The held piece as the ray wants it.
    pub(super) fn dragged(&self, ray: Ray3d) -> Option<(usize, Piece)> {
        let (k, grip) = self.held?;
        let mut piece = *self.pieces.get(k)?;
        let way = ray.direction.as_vec3();
        match grip {
            Grip::Whole { offset, level } => {
                let along = (level - ray.origin.y) / way.y;
                if !(along > 0.1 && along < 200.0) {
                    return None;
                }
                let middle = ray.origin + way * along + offset;
                (piece.right, piece.ahead) = (middle.x, -middle.z);
            }
            Grip::Size if piece.kind == PieceKind::Gap => {
                // The front edge stays, the far one follows the pointer over the ground.
                let along = (HANDLE - ray.origin.y) / way.y;
                if !(along > 0.1 && along < 200.0) {
                    return None;
                }
                let front = piece.ahead - 0.5 * piece.depth;
                piece.depth = (-(ray.origin + way * along).z - front).clamp(DEPTHS.0, DEPTHS.1);
                piece.ahead = front + 0.5 * piece.depth;
            }
            Grip::Size => {
                // Where the vertical line through the handle is nearest to the ray.
                let level = way.with_y(0.0);
                let along = (piece.handle() - ray.origin).with_y(0.0).dot(level) / level.length_squared().max(1e-6);
                piece.height = ray.origin.y + way.y * along - HANDLE;
            }
        }
        Some((k, piece))
    }

    /// As a course file, to be run by `athlete course` or trained on.
    pub(crate) fn to_ron(&self) -> String {
        let gaps = self.pieces.iter().filter(|p| p.kind == PieceKind::Gap);
        let mut gaps: Vec<(f32, f32)> =
            gaps.map(|gap| (gap.ahead - 0.5 * gap.depth, gap.ahead + 0.5 * gap.depth)).collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Gaps that overlap are one.
        let mut merged: Vec<(f32, f32)> = Vec::new();
        for (front, end) in gaps {
            match merged.last_mut() {
                Some(last) if front <= last.1 + 0.01 => last.1 = last.1.max(end),
                _ => merged.push((front, end)),
            }
        }
        let mut text = String::from("(\n    name: \"built\",\n    ground: (friction: 0.8),\n    solids: [\n");
        for (front, end) in merged {
            text.push_str(&format!("        Gap(ahead: {front:.3}, length: {:.3}),\n", end - front));
        }
        for p in self.pieces.iter().filter(|p| p.kind != PieceKind::Gap) {
            let front = p.ahead - 0.5 * p.depth;
            text.push_str(&format!(
                "        Box(ahead: {front:.3}, right: {:.3}, depth: {:.3}, width: {:.3}, height: {:.3}, material: \"ground\"),\n",
                p.right, p.depth, p.width, p.height
            ));
        }
        text.push_str("    ],\n)\n");
        text
    }

    /// The world that it is.
    pub(super) fn world(&self) -> Result<World, CourseError> {
        let course = Course::parse("built.course.ron", self.to_ron().as_bytes())?;
        let instance = course.instance(&course.defaults(), 0)?;
        Ok(World::with_course(&World::empty(), &instance).unwrap_or_else(|_| World::ground()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Terrain;

    const NOBODY: &[Vec3] = &[];

    fn site() -> Site {
        let mut site = Site::default();
        site.lay(vec![Piece::new(PieceKind::Box, 10.0), Piece::new(PieceKind::Gap, 20.0)]);
        site
    }

    fn ray(from: Vec3, to: Vec3) -> Ray3d {
        Ray3d::new(from, Dir3::new(to - from).unwrap())
    }

    /// Height of what can be stood on under a point of the way, m.
    fn height(site: &Site, ahead: f64) -> Option<f64> {
        let column = site.world().unwrap().height(crate::math::Vec3::new(0.0, 2.0, -ahead));
        column.found.then_some(column.height)
    }

    #[test]
    fn the_world_is_what_the_pieces_say() {
        let mut site = site();
        assert_eq!(
            [9.0, 10.0, 11.0, 20.0, 21.0].map(|at| height(&site, at)),
            [Some(0.0), Some(0.4), Some(0.0), None, Some(0.0)]
        );
        // Gaps that overlap are one, in whatever order they were laid.
        site.add(Piece::new(PieceKind::Gap, 19.5), NOBODY);
        assert_eq!(
            [18.85, 19.0, 20.12, 20.5, 20.7].map(|at| height(&site, at)),
            [Some(0.0), None, None, None, Some(0.0)]
        );
    }

    #[test]
    fn the_pointer_takes_the_nearest_piece_and_moves_it_over_the_ground() {
        let mut site = site();
        let eye = Vec3::new(2.0, 3.0, -4.0);
        let at = Vec3::new(0.1, 0.3, -9.825);
        let (k, grip) = site.under(ray(eye, at)).unwrap();
        assert!(k == 0 && matches!(grip, Grip::Whole { .. }), "{k}, {grip:?}");
        assert!(site.under(ray(eye, Vec3::new(0.0, 8.0, -10.0))).is_none(), "over everything");
        site.held = Some((k, grip));
        let (k, moved) = site.dragged(ray(eye, at + Vec3::new(1.0, 0.0, -2.0))).unwrap();
        assert!(site.change(k, moved, NOBODY));
        let piece = site.pieces[0];
        assert!((piece.right - 1.0).abs() < 1e-3 && (piece.ahead - 12.0).abs() < 1e-3, "{piece:?}");
        assert_eq!((piece.height, piece.depth), (0.4, 0.35));
    }

    #[test]
    fn the_handle_sets_the_height_and_a_gaps_length() {
        let mut site = site();
        let eye = Vec3::new(3.0, 2.0, -6.0);
        let handle = site.pieces[0].handle();
        let (k, grip) = site.under(ray(eye, handle)).unwrap();
        assert_eq!((k, grip), (0, Grip::Size));
        site.held = Some((k, grip));
        let (_, piece) = site.dragged(ray(eye, handle + Vec3::Y * 0.3)).unwrap();
        assert!((piece.height - 0.7).abs() < 1e-3, "{piece:?}");
        site.held = Some((1, Grip::Size));
        let before = site.pieces[1];
        let (_, piece) = site.dragged(ray(eye, before.handle() + Vec3::NEG_Z * 0.5)).unwrap();
        assert!((piece.depth - before.depth - 0.5).abs() < 1e-3, "{piece:?}");
        let front = |p: &Piece| p.ahead - 0.5 * p.depth;
        assert!((front(&piece) - front(&before)).abs() < 1e-4);
    }

    #[test]
    fn nothing_is_put_into_the_runner_and_numbers_stay_in_their_ranges() {
        let mut site = site();
        let runner = &[Vec3::new(0.0, 0.9, -8.0)];
        assert!(!site.change(0, Piece { ahead: 8.2, ..site.pieces[0] }, runner));
        assert!(!site.add(Piece::new(PieceKind::Box, 8.0), runner));
        // A height may change under its nose, but not under its feet.
        assert!(site.change(0, Piece { height: 0.6, ..site.pieces[0] }, &[Vec3::new(0.0, 0.9, -9.0)]));
        assert!(!site.change(0, Piece { height: 0.3, ..site.pieces[0] }, &[Vec3::new(0.0, 1.5, -10.0)]));
        assert!(site.change(0, Piece { height: 9.0, ahead: 1e9, ..site.pieces[0] }, NOBODY));
        assert_eq!((site.pieces[0].height, site.pieces[0].ahead), (HEIGHTS.1, BOUNDS.1));
        site.chosen = Some(1);
        site.remove();
        assert!(site.pieces.len() == 1 && site.chosen.is_none());
        // In a race all pieces lie right across the lanes, whatever is done to them.
        site.race_width = Some(13.8);
        site.lay(vec![Piece::new(PieceKind::Box, 10.0)]);
        site.change(0, Piece { right: 2.0, width: 1.0, height: 0.5, ..site.pieces[0] }, NOBODY);
        assert_eq!((site.pieces[0].right, site.pieces[0].width, site.pieces[0].height), (0.0, 13.8, 0.5));
    }
}
