//! As many skaters as the machine holds, each performing crossovers by its policy on a circle of its own cell of the rink.

use crate::app::camera::{CameraMode, OrbitCamera, follow};
use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteDiagnosticsPlugin, AthleteLook, AthletePrecision, AthleteSettings,
    AthleteWorld, CharacterAsset, PlaybackSpeed,
};
use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use std::f32::consts::TAU;
use std::time::Duration;

/// Radius of the crossover's circle, m.
const RADIUS: f32 = 3.85;
/// Middles of the circles, m: three across the rink, six along it.
const CELLS: (usize, usize, Vec2) = (3, 6, Vec2::new(9.4, 9.4));
/// Wall time of the fixed ticks that the crowd may grow to, seconds per simulated second.
const FULL: f32 = 0.6;
/// What is judged at once, simulated s.
const WINDOW: f32 = 0.5;

/// How many there are, and what they cost.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct CrowdCount {
    /// Skaters on the ice.
    pub skaters: usize,
    /// Wall seconds per simulated second spent in stepping, over the last window.
    pub load: f32,
    /// The number is given, not found.
    pub fixed: bool,
    /// Growing has ended.
    pub full: bool,
    simulated: f32,
}

impl CrowdCount {
    /// How many could be stepped in real time, at the cost of the last window.
    pub fn capacity(&self) -> f32 {
        if self.load > 0.0 { self.skaters as f32 / self.load } else { 0.0 }
    }
}

#[derive(Component)]
struct Skater;

pub(crate) struct CrowdPlugin;

impl Plugin for CrowdPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CrowdCount>()
            .add_systems(OnEnter(DemoScene::Crowd), enter)
            .add_systems(OnExit(DemoScene::Crowd), leave)
            .add_systems(Update, (grow, look_over.before(follow)).run_if(in_state(DemoScene::Crowd)));
    }
}

fn enter(
    mut commands: Commands,
    stage: Res<Stage>,
    mut count: ResMut<CrowdCount>,
    mut props: Props,
    mut cameras: Query<&mut OrbitCamera>,
) {
    for mut camera in &mut cameras {
        camera.found = false;
    }
    let root = scene_root(&mut commands, DemoScene::Crowd);
    props.rink(&mut commands, root, Vec3::ZERO, stage.options.low);
    commands.insert_resource(AthleteWorld::ice());
    *count = CrowdCount { fixed: stage.options.crowd > 0, ..default() };
}

/// Looks over the whole rink, once.
fn look_over(mut cameras: Query<&mut OrbitCamera>) {
    for mut camera in &mut cameras {
        if !camera.found {
            let target = Vec3::new(0.0, 0.0, 3.0);
            *camera = OrbitCamera {
                target,
                azimuth: 0.5,
                elevation: 0.5,
                distance: 44.0,
                found: true,
                mode: CameraMode::Free,
            };
        }
    }
}

fn leave(mut cameras: Query<&mut OrbitCamera>) {
    for mut camera in &mut cameras {
        *camera = OrbitCamera::default();
    }
}

/// Wall seconds per simulated second that stepping took in the last `seconds` of simulated time.
fn load(diagnostics: &DiagnosticsStore, tick: Duration, seconds: f32) -> f32 {
    let ticks = (seconds / tick.as_secs_f32()).round().max(1.0) as usize;
    let Some(taken) = diagnostics.get(&AthleteDiagnosticsPlugin::STEP_TIME) else { return 0.0 };
    let last = taken.values().skip(taken.history_len().saturating_sub(ticks));
    let (sum, count) = last.fold((0.0, 0.0), |(sum, count), ms| (sum + ms, count + 1.0));
    if count > 0.0 { (sum / count * 1e-3 / tick.as_secs_f64()) as f32 } else { 0.0 }
}

/// Adds skaters as long as stepping them leaves time for everything else.
fn grow(
    mut commands: Commands,
    stage: Res<Stage>,
    assets: Res<AssetServer>,
    time: Res<Time>,
    fixed: Res<Time<Fixed>>,
    diagnostics: Res<DiagnosticsStore>,
    playback: Res<PlaybackSpeed>,
    mut count: ResMut<CrowdCount>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    mut skater: Local<Option<Handle<CharacterAsset>>>,
    spawned: Query<(), With<Skater>>,
    ready: Query<(), (With<Skater>, With<AthleteBody>)>,
) {
    let present = spawned.iter().count();
    count.skaters = ready.iter().count();
    if count.skaters < present || playback.paused {
        // Still loading: what a tick costs now says nothing.
        count.simulated = 0.0;
        return;
    }
    count.simulated += time.delta_secs();
    let mut more = 0;
    if count.fixed {
        more = (stage.options.crowd as usize).saturating_sub(present);
    } else if present == 0 {
        more = 6;
    }
    if count.simulated >= WINDOW {
        count.load = load(&diagnostics, fixed.timestep(), count.simulated);
        count.simulated = 0.0;
        if !count.fixed && !count.full {
            // A third more, or what the load of one skater says.
            let room = (FULL - count.load).max(0.0) / (count.load / present.max(1) as f32).max(1e-6);
            more = (present / 3 + 1).min(room as usize);
            count.full = more == 0;
        }
    }
    let character =
        skater.get_or_insert_with(|| characters.add(CharacterAsset { model: crate::model::skater() })).clone();
    for k in present..present + more {
        commands.spawn((
            Skater,
            DespawnOnExit(DemoScene::Crowd),
            Athlete(character.clone()),
            AthleteController::skill(assets.load("skills/skating/forward_crossover/forward_crossover.skill.ron")),
            AthleteSettings { precision: AthletePrecision::Single, ..default() },
            look(k),
            place(k),
        ));
    }
}

/// The place of skater `k`: cell by cell, in each cell around the circle, in every further round between those before.
fn place(k: usize) -> Transform {
    let cells = CELLS.0 * CELLS.1;
    let (cell, round) = (k % cells, k / cells);
    // The golden ratio spreads any number around the circle.
    let angle = TAU * (round as f32 * 0.618_034 + cell as f32 * 0.137).fract();
    let column = (cell % CELLS.0) as f32 - (CELLS.0 - 1) as f32 * 0.5;
    let row = (cell / CELLS.0) as f32 - (CELLS.1 - 1) as f32 * 0.5;
    let middle = Vec3::new(column * CELLS.2.x, 0.0, row * CELLS.2.y);
    let heading = Quat::from_rotation_y(angle);
    // It curves to its left: the middle lies there.
    Transform::from_translation(middle + heading * Vec3::X * RADIUS).with_rotation(heading)
}

/// A costume of one of twelve colours.
fn look(k: usize) -> AthleteLook {
    let hue = (k * 5 % 12) as f32 * 30.0;
    AthleteLook {
        left: Color::hsl(hue, 0.62, 0.45),
        right: Color::hsl(hue, 0.62, 0.58),
        middle: Color::hsl(hue, 0.25, 0.82),
        shadows: k < 36,
        ..default()
    }
}
