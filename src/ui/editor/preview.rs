//! The editor in the 3D view: the ghost of the pose, its contact marks, and the athlete that performs beside it.

use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteFell, AthleteLook, AthleteReset, AthleteSettings, CharacterAsset,
    ControlAsset, LinkId, LinkPoses, Placement, SkillAsset, shape_mesh,
};
use crate::model::{LinkTransform, SharedModel};
use crate::ui::editor::state::{Performance, PoseEditor};
use crate::ui::panel_choice::{AthletePanels, Panel};
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::prelude::*;
use std::sync::Arc;

/// Where the ghost stands against the selected athlete, and the performer against the ghost: to the right, m.
const ASIDE: f64 = 1.2;
/// Colour of the ghost.
const GHOST: Color = Color::srgba(0.95, 0.75, 0.20, 0.45);
/// How long a performance that ended stands before it begins again, s.
const AGAIN: f32 = 0.7;

/// The editor that the panel shows.
#[derive(Resource, Debug, Default, Deref, DerefMut)]
pub struct PoseEditorState(pub PoseEditor);

/// Where the ghost's motion begins, world frame. The performing athlete begins 1.2 m to its right.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct EditorStage(pub Placement);

/// The athlete that performs what the editor simulated or learnt.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct EditorAthlete;

/// The ghost of a model; its children are the shapes.
#[derive(Component)]
struct PoseGhost(SharedModel);

/// A shape of the ghost.
#[derive(Component)]
struct GhostShape {
    link: usize,
    local: Transform,
}

/// What the preview remembers between frames.
#[derive(Resource, Default)]
struct PreviewState {
    performance: u64,
    /// Time of the ghost's motion, s.
    time: f64,
    links: Vec<LinkTransform>,
}

/// Adds ghost, marks and performer.
#[derive(Debug, Default)]
pub(crate) struct EditorPreviewPlugin;

impl Plugin for EditorPreviewPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PoseEditorState>()
            .init_resource::<EditorStage>()
            .init_resource::<PreviewState>()
            .add_observer(up_again)
            .add_systems(Update, (poll, place_stage, perform, keep_time).chain())
            .add_systems(
                PostUpdate,
                (build_ghost, place_ghost)
                    .chain()
                    .before(bevy::transform::TransformSystems::Propagate)
                    .run_if(resource_exists::<Assets<Mesh>>.and_then(resource_exists::<Assets<StandardMaterial>>)),
            )
            .add_systems(PostUpdate, draw_marks.run_if(resource_exists::<bevy::gizmos::config::GizmoConfigStore>));
    }
}

fn poll(mut editor: ResMut<PoseEditorState>) {
    editor.bypass_change_detection().poll();
}

/// Puts the stage beside the selected athlete when that is asked for.
fn place_stage(
    mut commands: Commands,
    panels: Res<AthletePanels>,
    mut editor: ResMut<PoseEditorState>,
    mut stage: ResMut<EditorStage>,
    athletes: Query<&LinkPoses, Without<EditorAthlete>>,
    performers: Query<Entity, With<EditorAthlete>>,
) {
    let editor = editor.bypass_change_detection();
    if !editor.bring_here || editor.document().is_none() {
        return;
    }
    let found = panels.selected.and_then(|s| athletes.get(s).ok()).or_else(|| athletes.iter().next());
    let Some(root) = found.map(|poses| poses.link(LinkId::ROOT)) else { return };
    editor.bring_here = false;
    // The character's own heading, without its lean.
    let Ok(mut placement) = Placement::from_transform(&root) else { return };
    placement.position.y = 0.0;
    placement.position = placement.point(bevy::math::DVec3::X * ASIDE);
    stage.0 = placement;
    for performer in &performers {
        commands.trigger(AthleteReset::at(performer, performer_transform(&placement)));
    }
}

/// Where the performer begins.
fn performer_transform(stage: &Placement) -> Transform {
    Transform::from_translation(stage.point(bevy::math::DVec3::X * ASIDE).as_vec3())
        .with_rotation(stage.heading.as_quat())
}

/// Spawns, changes or takes away the athlete that performs.
fn perform(
    mut commands: Commands,
    mut preview: ResMut<PreviewState>,
    mut panels: ResMut<AthletePanels>,
    editor: Res<PoseEditorState>,
    stage: Res<EditorStage>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    mut controls: ResMut<Assets<ControlAsset>>,
    mut skills: ResMut<Assets<SkillAsset>>,
    performers: Query<(Entity, &AthleteBody), With<EditorAthlete>>,
) {
    let (number, performance) = editor.performance();
    if number == preview.performance {
        return;
    }
    preview.performance = number;
    let model = editor.model();
    // One of the same character goes on with the new control or policy; else it is replaced.
    let mut kept = None;
    for (entity, body) in &performers {
        if performance.is_some() && kept.is_none() && model.is_some_and(|m| Arc::ptr_eq(m, body.model())) {
            kept = Some(entity);
        } else {
            commands.entity(entity).despawn();
        }
    }
    let (Some(performance), Some(model)) = (performance, model) else { return };
    let entity = kept.unwrap_or_else(|| {
        let look = AthleteLook { middle: Color::srgb(0.98, 0.86, 0.55), ..default() };
        let athlete = Athlete(characters.add(CharacterAsset { model: model.clone() }));
        let settings = AthleteSettings { restart_after: Some(AGAIN), ..default() };
        let name = Name::new("key poses, simulated");
        commands.spawn((athlete, EditorAthlete, name, look, settings, performer_transform(&stage.0))).id()
    });
    panels.selected = Some(entity);
    let mut entity = commands.entity(entity);
    match performance {
        Performance::Control(found) => {
            let control = controls.add(ControlAsset { control: found.control.clone() });
            entity.insert(AthleteController::Play(control));
        }
        Performance::Skill(skill) => {
            let skill = skills.add(SkillAsset::made_for(model, skill.clone()));
            entity.insert(AthleteController::skill(skill));
        }
    }
}

/// A performer that has fallen begins again: what learns falls often.
fn up_again(fell: On<AthleteFell>, mut commands: Commands, performers: Query<(), With<EditorAthlete>>) {
    if performers.contains(fell.entity) {
        commands.trigger(AthleteReset::new(fell.entity));
    }
}

/// The ghost is at the time of the athlete that performs, or goes on by itself.
fn keep_time(
    time: Res<Time>,
    mut preview: ResMut<PreviewState>,
    editor: Res<PoseEditorState>,
    performers: Query<&AthleteBody, With<EditorAthlete>>,
) {
    preview.time = match performers.iter().next() {
        Some(body) => body.time(),
        None if editor.playing => preview.time + time.delta_secs_f64(),
        None => 0.0,
    };
}

/// Makes the ghost of the present character, and takes it away with the document or the panel.
fn build_ghost(
    mut commands: Commands,
    panels: Res<AthletePanels>,
    editor: Res<PoseEditorState>,
    ghosts: Query<(Entity, &PoseGhost)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let wanted = editor.model().filter(|_| panels.is_open(Panel::Editor));
    let mut there = false;
    for (entity, ghost) in &ghosts {
        if !there && wanted.is_some_and(|model| Arc::ptr_eq(model, &ghost.0)) {
            there = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    let Some(model) = wanted.filter(|_| !there) else { return };
    let material = materials.add(StandardMaterial {
        base_color: GHOST,
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 0.9,
        ..default()
    });
    commands.spawn((PoseGhost(model.clone()), Transform::default(), Visibility::default())).with_children(|children| {
        for (link, description) in model.links.iter().enumerate() {
            for shape in &description.shapes {
                let (mesh, center, rotation) = shape_mesh(shape);
                let local = Transform::from_translation(center.as_vec3()).with_rotation(rotation.as_quat());
                let drawn = (Mesh3d(meshes.add(mesh)), MeshMaterial3d(material.clone()), Transform::default());
                children.spawn((GhostShape { link, local }, drawn, NotShadowCaster, NotShadowReceiver));
            }
        }
    });
}

fn place_ghost(
    editor: Res<PoseEditorState>,
    stage: Res<EditorStage>,
    mut preview: ResMut<PreviewState>,
    mut ghosts: Query<(&mut Transform, &Children), With<PoseGhost>>,
    mut shapes: Query<(&GhostShape, &mut Transform), Without<PoseGhost>>,
) {
    let PreviewState { time, links, .. } = &mut *preview;
    if ghosts.is_empty() || !editor.ghost(*time, links) {
        return;
    }
    for (mut root, children) in &mut ghosts {
        root.translation = stage.0.position.as_vec3();
        root.rotation = stage.0.heading.as_quat();
        for &child in children {
            let Ok((shape, mut transform)) = shapes.get_mut(child) else { continue };
            let Some(link) = links.get(shape.link) else { continue };
            let place = Transform::from_translation(link.position.as_vec3());
            *transform = place.with_rotation(link.rotation.as_quat().normalize()) * shape.local;
        }
    }
}

/// A cross on the ground at each point that touches, while the ghost stands in the pose.
fn draw_marks(panels: Res<AthletePanels>, editor: Res<PoseEditorState>, stage: Res<EditorStage>, mut gizmos: Gizmos) {
    if !panels.is_open(Panel::Editor) || editor.playing || editor.performance().1.is_some() {
        return;
    }
    for mark in editor.marks() {
        let at = stage.0.point(mark.place).as_vec3() + Vec3::Y * 0.01;
        for arm in [Vec3::X, Vec3::Z] {
            gizmos.line(at - arm * 0.04, at + arm * 0.04, Color::srgb(0.95, 0.2, 0.2));
        }
    }
}
