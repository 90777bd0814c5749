//! The lines that the blades leave on the ice, coloured by edge.

use crate::contact::BladeEdge;
use crate::engine::AthleteBody;
use bevy::prelude::*;

/// Longest line, points.
const LONGEST: usize = 3000;

/// For each blade of the athlete its line: places on the ice (`None` is a gap) and their colours.
#[derive(Resource, Default)]
pub(super) struct Tracks {
    lines: Vec<Vec<Option<(Vec3, Color)>>>,
    time: f64,
}

/// Adds the present place of each blade that is on the ice; a new start wipes the ice.
pub(super) fn leave_tracks(mut tracks: ResMut<Tracks>, mut bodies: Query<&mut AthleteBody>) {
    let Some(mut body) = bodies.iter_mut().next() else { return };
    let model = body.model().clone();
    if body.time() < tracks.time {
        tracks.lines.clear();
    }
    tracks.time = body.time();
    tracks.lines.resize_with(model.blades.len(), Vec::new);
    for (index, blade) in model.blades.iter().enumerate() {
        let edge = body.blade_edge(index);
        let point = match edge {
            BladeEdge::Off => None,
            _ => {
                let middle =
                    (model.contact_points[blade.toe].position + model.contact_points[blade.heel].position) * 0.5;
                let simulator = body.simulator_mut();
                let root = simulator.state.root_position.lane(0);
                let link = simulator.kinematics()[blade.link];
                let place = root + link.origin.lane(0) + link.rotation.lane(0) * middle;
                Some((place.as_vec3().with_y(0.004), color(edge)))
            }
        };
        let line = &mut tracks.lines[index];
        if point.is_some() || line.last().is_some_and(Option::is_some) {
            line.push(point);
        }
        if line.len() > LONGEST {
            line.drain(..LONGEST / 4);
        }
    }
}

fn color(edge: BladeEdge) -> Color {
    match edge {
        BladeEdge::Inside => Color::srgb(0.93, 0.45, 0.10),
        BladeEdge::Outside => Color::srgb(0.10, 0.42, 0.85),
        _ => Color::srgb(0.38, 0.50, 0.60),
    }
}

/// Draws the lines.
pub(super) fn draw_tracks(tracks: Res<Tracks>, mut gizmos: Gizmos) {
    for line in &tracks.lines {
        for stroke in line.split(Option::is_none) {
            gizmos.linestrip_gradient(stroke.iter().copied().flatten());
        }
    }
}
