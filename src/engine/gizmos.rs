//! What the blades do, drawn: lean, edge, carve radius and force.

use crate::contact::BladeEdge;
use crate::engine::AthleteBody;
use bevy::prelude::*;

/// Longest arc that is drawn of the curve a blade follows, m.
const ARC: f32 = 1.2;
/// Curves flatter than this are drawn straight, m.
const STRAIGHT: f32 = 200.0;

/// Draws at each blade of an athlete: the edge in its colour, how far it leans, the curve that it follows, and the force of
/// the ice.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteGizmos {
    /// Length of the arrow of 1000 N, m.
    pub force_scale: f32,
    /// Colours of a flat, an inside and an outside edge.
    pub colors: [Color; 3],
}

impl Default for AthleteGizmos {
    fn default() -> Self {
        let colors = [Color::srgb(0.25, 0.30, 0.38), Color::srgb(0.92, 0.35, 0.18), Color::srgb(0.10, 0.45, 0.92)];
        Self { force_scale: 1.0, colors }
    }
}

/// Draws the gizmos of all athletes that have them.
pub(super) fn draw_blades(
    mut gizmos: Gizmos,
    athletes: Query<(&AthleteBody, &crate::engine::LinkPoses, &AthleteGizmos)>,
) {
    for (body, poses, style) in &athletes {
        let (sim, model) = (body.simulator(), body.model());
        for (k, blade) in model.blades.iter().enumerate() {
            let Some(link) = poses.interpolated.get(blade.link) else { continue };
            let place = |point: usize| (link.position + link.rotation * model.contact_points[point].position).as_vec3();
            let (toe, heel) = (place(blade.toe), place(blade.heel));
            for (point, at) in [(blade.toe, toe), (blade.heel, heel)] {
                let force = sim.contact_force(point, 0).as_vec3() * (style.force_scale / 1000.0);
                if force.length() > 1e-3 {
                    gizmos.arrow(at, at + force, Color::srgb(0.90, 0.10, 0.35));
                }
            }
            let (Some((lean, curvature)), edge) = (sim.blade_lean(k, 0), sim.blade_edge(k, 0)) else { continue };
            let color = match edge {
                BladeEdge::Inside => style.colors[1],
                BladeEdge::Outside => style.colors[2],
                BladeEdge::Flat | BladeEdge::Off => style.colors[0],
            };
            let middle = (toe + heel) * 0.5;
            let along = ((toe - heel) * Vec3::new(1.0, 0.0, 1.0)).normalize_or_zero();
            // Towards the inside edge, over the ice.
            let inside = (link.rotation * blade.inside).as_vec3() * Vec3::new(1.0, 0.0, 1.0);
            let inside = (inside - along * inside.dot(along)).normalize_or_zero();
            gizmos.line(heel, toe, color);
            let (sin, cos) = (lean as f32).sin_cos();
            gizmos.line(middle, middle + (Vec3::Y * cos + inside * sin) * 0.3, color);
            let curvature = curvature as f32;
            let point = |s: f32| {
                if curvature.abs() < 1.0 / STRAIGHT {
                    return middle + along * s;
                }
                let angle = s * curvature;
                middle + (along * angle.sin() + inside * (1.0 - angle.cos())) / curvature
            };
            // As far as half a circle, for the tightest curves.
            let reach = ARC.min(std::f32::consts::PI / curvature.abs().max(1e-3));
            gizmos.linestrip((0..=24).map(|n| point(reach * n as f32 / 24.0) + Vec3::Y * 0.005), color);
        }
    }
}
