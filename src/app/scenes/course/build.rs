//! Building while it runs: the pointer moves pieces and pulls at their handles, the menu adds and removes them.

use super::race::Racer;
use super::site::{HANDLE, LOST, Piece, PieceKind, Site};
use super::{PieceOf, Runner};
use crate::app::labels::Label;
use crate::app::props::Props;
use crate::app::pull::{Pointer, on_panel};
use crate::app::scenes::DemoScene;
use crate::engine::{AthleteReset, AthleteWorld};
use bevy::prelude::*;
use bevy_egui::EguiContexts;

/// Whether the pointer holds no piece: then a drag turns the camera.
pub(crate) fn holds_no_piece(site: Res<Site>) -> bool {
    site.held.is_none()
}

/// Takes hold of the piece under the pointer.
pub(crate) fn take_piece(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: Pointer,
    mut contexts: EguiContexts,
    scene: Res<State<DemoScene>>,
    mut site: ResMut<Site>,
) -> Result {
    if *scene.get() != DemoScene::Course || !buttons.just_pressed(MouseButton::Left) {
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    if pointer.place().is_none_or(|at| on_panel(context, at)) {
        return Ok(());
    }
    let Some((ray, _)) = pointer.ray() else { return Ok(()) };
    let found = site.under(ray);
    if found.is_some() {
        site.chosen = found.map(|(k, _)| k);
        site.held = found;
    }
    Ok(())
}

/// Moves the held piece.
pub(super) fn drag_piece(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: Pointer,
    runners: Query<&Transform, With<Runner>>,
    mut site: ResMut<Site>,
) {
    if site.held.is_none() {
        return;
    }
    if !buttons.pressed(MouseButton::Left) {
        site.held = None;
        return;
    }
    let Some((ray, _)) = pointer.ray() else { return };
    if let Some((k, wanted)) = site.dragged(ray) {
        let runners: Vec<Vec3> = runners.iter().map(|place| place.translation).collect();
        site.change(k, wanted, &runners);
    }
}

/// Del takes the chosen piece away.
pub(crate) fn build_keys(keys: Res<ButtonInput<KeyCode>>, scene: Res<State<DemoScene>>, mut site: ResMut<Site>) {
    if *scene.get() == DemoScene::Course && keys.just_pressed(KeyCode::Delete) {
        site.remove();
    }
}

/// The world is the site's as soon as that has changed.
pub(super) fn lay_world(site: Res<Site>, mut world: ResMut<AthleteWorld>, mut laid: Local<Option<u32>>) -> Result {
    if laid.replace(site.revision) != Some(site.revision) {
        world.0 = site.world()?;
    }
    Ok(())
}

/// What is seen, while time stands still too.
pub(super) fn lay_seen(
    mut commands: Commands,
    mut props: Props,
    site: Res<Site>,
    roots: Query<Entity, With<CourseRoot>>,
    mut seen: Query<(Entity, &PieceOf, &mut Transform, Option<&mut Label>)>,
    mut laid: Local<Option<u32>>,
) {
    let all_there = seen.iter().count() == site.pieces.len();
    if laid.replace(site.revision) == Some(site.revision) && all_there {
        return;
    }
    let is_there = |of: &PieceOf| site.pieces.get(of.index).is_some_and(|piece| piece.kind == of.kind);
    if all_there && seen.iter().all(|(_, of, ..)| is_there(of)) {
        for (_, of, mut transform, label) in &mut seen {
            let Some(piece) = site.pieces.get(of.index) else { continue };
            *transform = stands(piece);
            if let Some(mut label) = label {
                label.above = above(piece);
            }
        }
        return;
    }
    for (entity, ..) in &seen {
        commands.entity(entity).despawn();
    }
    let Some(root) = roots.iter().next() else { return };
    for (index, piece) in site.pieces.iter().enumerate() {
        let color = match piece.kind {
            PieceKind::Gap => Color::srgb(0.10, 0.11, 0.13),
            _ => Color::hsl((18.0 + 137.5 * index as f32) % 360.0, 0.55, 0.55),
        };
        let label = Label { text: (index + 1).to_string(), above: above(piece) };
        let of = PieceOf { index, kind: piece.kind };
        let mut seen = commands.spawn((ChildOf(root), of, props.block(Vec3::ONE, color), stands(piece)));
        if piece.kind != PieceKind::Gap {
            seen.insert(label);
        }
    }
}

/// Where its number is, from its middle, m: over the knob.
fn above(piece: &Piece) -> f32 {
    0.5 * piece.height + HANDLE + 0.25
}

/// A unit block as the piece.
fn stands(piece: &Piece) -> Transform {
    Transform::from_translation(piece.middle()).with_scale(piece.size())
}

/// What the pieces hang on.
#[derive(Component)]
pub(super) struct CourseRoot;

/// Handles of all pieces; those of the chosen one stand out.
pub(super) fn draw_handles(site: Res<Site>, mut gizmos: Gizmos) {
    for (k, piece) in site.pieces.iter().enumerate() {
        let chosen = site.chosen == Some(k);
        let color = if chosen { Color::srgb(1.0, 0.78, 0.20) } else { Color::srgba(1.0, 1.0, 1.0, 0.55) };
        let handle = piece.handle();
        gizmos.line(handle.with_y(piece.height), handle, color);
        gizmos.sphere(handle, 0.06, color);
        if chosen {
            let outline = Transform::from_translation(piece.middle()).with_scale(piece.size() + Vec3::splat(0.02));
            gizmos.cube(outline, color);
        }
    }
}

/// Who fell into a gap starts again; a racer is out.
pub(super) fn bring_back(mut commands: Commands, runners: Query<(Entity, &Transform), (With<Runner>, Without<Racer>)>) {
    for (entity, place) in &runners {
        if place.translation.y < LOST {
            commands.trigger(AthleteReset::new(entity));
        }
    }
}
