//! The lines that the blades leave on the ice, coloured by edge; they stay, and fade.

use crate::contact::BladeEdge;
use crate::engine::{AthleteBody, LinkPoses};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

/// Longest line, points.
const LONGEST: usize = 2400;
/// Distance between two points, m.
const SPACING: f32 = 0.04;
/// A line is gone after this time, s.
const FADE: f64 = 40.0;
/// Athletes that leave lines.
const ATHLETES: usize = 6;

/// A place on the ice.
#[derive(Clone, Copy)]
struct Mark {
    place: Vec3,
    edge: BladeEdge,
    time: f64,
}

/// For each blade of an athlete its line; `None` is a gap.
#[derive(Resource, Default)]
pub(super) struct Tracks {
    lines: HashMap<(Entity, usize), Vec<Option<Mark>>>,
}

/// Adds the present place of each blade that is on the ice. A line that has moved back in time is cut there.
pub(super) fn leave_tracks(
    time: Res<Time>,
    mut tracks: ResMut<Tracks>,
    bodies: Query<(Entity, &AthleteBody, &LinkPoses)>,
) {
    tracks.lines.retain(|(entity, _), _| bodies.contains(*entity));
    let now = time.elapsed_secs_f64();
    for (entity, body, poses) in bodies.iter().take(ATHLETES) {
        let model = body.model();
        for (index, blade) in model.blades.iter().enumerate() {
            let edge = body.blade_edge(index);
            let line = tracks.lines.entry((entity, index)).or_default();
            let Some(pose) = poses.current.get(blade.link) else { continue };
            let mark = (edge != BladeEdge::Off).then(|| {
                let ends = model.contact_points[blade.toe].position + model.contact_points[blade.heel].position;
                let place = (pose.position + pose.rotation * (ends * 0.5)).as_vec3();
                Mark { place: place.with_y(0.004), edge, time: now }
            });
            match (mark, line.last().copied().flatten()) {
                (Some(mark), Some(last)) if mark.place.distance(last.place) > 1.0 => line.extend([None, Some(mark)]),
                (Some(mark), Some(last)) if mark.place.distance(last.place) < SPACING => {}
                (Some(mark), _) => line.push(Some(mark)),
                (None, Some(_)) => line.push(None),
                (None, None) => {}
            }
            if line.len() > LONGEST {
                line.drain(..LONGEST / 4);
            }
        }
    }
}

fn color(mark: &Mark, now: f64) -> Color {
    let fresh = (1.0 - (now - mark.time) / FADE).clamp(0.0, 1.0) as f32;
    let color = match mark.edge {
        BladeEdge::Inside => Color::srgb(0.93, 0.45, 0.10),
        BladeEdge::Outside => Color::srgb(0.10, 0.42, 0.85),
        _ => Color::srgb(0.38, 0.50, 0.60),
    };
    color.with_alpha(fresh)
}

/// Draws the lines.
pub(super) fn draw_tracks(time: Res<Time>, tracks: Res<Tracks>, mut gizmos: Gizmos) {
    let now = time.elapsed_secs_f64();
    for line in tracks.lines.values() {
        for stroke in line.split(Option::is_none) {
            gizmos.linestrip_gradient(stroke.iter().flatten().map(|mark| (mark.place, color(mark, now))));
        }
    }
}
