//! The rink: a skater that performs what the menu says, or goes where the arrow keys point.

use crate::app::act::Act;
use crate::app::props::Props;
use crate::app::rink::HALF;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::app::thumb::{ThumbStick, over_ground, player_stick};
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteGhost, AthleteGizmos, AthleteHistory, AthleteInput,
    AthleteSettings, AthleteWorld, CharacterAsset, ControlAsset, PerformSkill,
};
use crate::skill::SKATING_SKILLS;
use bevy::prelude::*;
use bevy_egui::input::{EguiWantsInput, egui_wants_any_keyboard_input};

/// So near to the boards a steered skater is turned back, m.
const NEAR_BOARDS: f32 = 5.0;
/// Speed at which a steered skater begins, m/s.
const SPEED: f32 = 2.5;

/// What is drawn beside and over the skater.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overlays {
    pub ghost: bool,
    pub edges: bool,
}

impl Default for Overlays {
    fn default() -> Self {
        Self { ghost: true, edges: false }
    }
}

/// The skater of the rink, and what it was spawned for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RinkSkater {
    act: Act,
    overlays: Overlays,
}

pub(crate) struct SkatingPlugin;

impl Plugin for SkatingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Overlays>()
            .init_resource::<ThumbStick>()
            .add_systems(OnEnter(DemoScene::Rink), (enter, spawn_skater).chain())
            .add_systems(
                Update,
                (steer.run_if(resource_exists::<EguiWantsInput>.and_then(not(egui_wants_any_keyboard_input))), respawn)
                    .chain()
                    .run_if(in_state(DemoScene::Rink)),
            );
    }
}

fn enter(mut commands: Commands, stage: Res<Stage>, mut props: Props) {
    let root = scene_root(&mut commands, DemoScene::Rink);
    let middle = stage.control.middle().as_vec3();
    props.rink(&mut commands, root, middle, stage.options.low);
    commands.insert_resource(AthleteWorld(stage.control.world.clone()));
}

fn spawn_skater(
    mut commands: Commands,
    stage: Res<Stage>,
    act: Res<Act>,
    overlays: Res<Overlays>,
    assets: Res<AssetServer>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    mut controls: ResMut<Assets<ControlAsset>>,
) {
    let middle = stage.control.middle().as_vec3();
    let mut skater = commands.spawn((
        RinkSkater { act: *act, overlays: *overlays },
        DespawnOnExit(DemoScene::Rink),
        Athlete(characters.add(CharacterAsset { model: stage.control.model.clone() })),
        AthleteSettings { restart_after: Some(1.5), ..default() },
        AthleteHistory::default(),
    ));
    if overlays.ghost {
        let offset = if *act == Act::Clip { AthleteGhost::default().offset } else { Vec3::ZERO };
        skater.insert(AthleteGhost { offset, ..default() });
    }
    if overlays.edges {
        skater.insert(AthleteGizmos::default());
    }
    let skill = |name: &str| assets.load(format!("skills/skating/{name}/{name}.skill.ron"));
    match *act {
        Act::Clip => {
            let control = controls.add(ControlAsset { control: stage.control.control.clone() });
            skater.insert(AthleteController::Play(control));
        }
        Act::Program => {
            let program = AthleteController::Program(assets.load("skills/skating/short_program.program.ron"));
            skater.insert((program, Transform::from_translation(middle + Vec3::new(0.0, 0.0, 8.0))));
        }
        Act::Steer => {
            let controller = AthleteController::steer(SKATING_SKILLS.map(skill));
            let input = AthleteInput::default().at(SPEED);
            skater.insert((controller, input, Transform::from_translation(middle + Vec3::new(0.0, 0.0, 6.0))));
        }
        Act::Skill(k) => {
            let place = Transform::from_translation(middle + Vec3::new(0.0, 0.0, if k == 0 { 20.0 } else { 4.0 }));
            let skill = skill(SKATING_SKILLS[k.min(SKATING_SKILLS.len() - 1)]);
            skater.insert((AthleteController::skill(skill), place));
        }
    }
}

/// Another act or other overlays: another skater.
fn respawn(mut commands: Commands, act: Res<Act>, overlays: Res<Overlays>, skaters: Query<(Entity, &RinkSkater)>) {
    let wanted = RinkSkater { act: *act, overlays: *overlays };
    let mut old = skaters.iter().filter(|(_, skater)| **skater != wanted).peekable();
    if old.peek().is_some() {
        old.for_each(|(entity, _)| commands.entity(entity).despawn());
        commands.run_system_cached(spawn_skater);
    }
}

/// Arrow keys, the left stick or the one for thumbs; T, B and J turn and jump. The first touch of an arrow takes the skater over.
fn steer(
    keys: Res<ButtonInput<KeyCode>>,
    gamepads: Query<&Gamepad>,
    thumb: Res<ThumbStick>,
    stage: Res<Stage>,
    mut act: ResMut<Act>,
    cameras: Query<&GlobalTransform, With<Camera3d>>,
    mut commands: Commands,
    mut skaters: Query<(Entity, &Transform, Option<&AthleteBody>, &mut AthleteInput), With<RinkSkater>>,
) {
    let stick = player_stick(&keys, &gamepads, &thumb);
    let pressed = |key, button| keys.just_pressed(key) || gamepads.iter().any(|g| g.just_pressed(button));
    let perform = if pressed(KeyCode::KeyT, GamepadButton::West) {
        Some("forward_three_turn")
    } else if pressed(KeyCode::KeyB, GamepadButton::East) {
        Some("backward_three_turn")
    } else if pressed(KeyCode::KeyJ, GamepadButton::South) {
        Some("double_salchow")
    } else {
        None
    };
    if *act != Act::Steer {
        if stick != Vec2::ZERO {
            *act = Act::Steer;
        }
        return;
    }
    let Some(camera) = cameras.iter().next() else { return };
    for (skater, transform, body, mut input) in &mut skaters {
        if let Some(name) = perform {
            commands.trigger(PerformSkill::new(skater, name));
        }
        let velocity = body.map_or(Vec3::ZERO, |body| body.root_velocity().as_vec3().with_y(0.0));
        let from_middle = transform.translation - stage.control.middle().as_vec3();
        let mut wanted = over_ground(camera, stick);
        if outward(from_middle, velocity) {
            // Back to the middle before the boards.
            wanted = -from_middle.with_y(0.0);
        } else if wanted == Vec3::ZERO && !outward(from_middle, input.direction) {
            // Without a wish the last one goes on.
            wanted = input.direction;
        }
        if input.direction != wanted {
            input.direction = wanted;
        }
    }
}

/// Whether a place near the boards is being left in their direction.
fn outward(from_middle: Vec3, direction: Vec3) -> bool {
    let beyond = |x: f32, half: f32, v: f32| x.abs() > half - NEAR_BOARDS && x * v > 0.0;
    beyond(from_middle.x, HALF.x, direction.x) || beyond(from_middle.z, HALF.y, direction.z)
}
