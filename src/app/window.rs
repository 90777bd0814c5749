//! The Bevy app: plugins, quality, the skater, keys.

use crate::app::camera::{OrbitCamera, follow, orbit};
use crate::app::panel::{ShowPanel, show_panel};
use crate::app::panels::add_panels;
use crate::app::reflection::{make_images, place_images};
use crate::app::rink::{RinkPlan, spawn_rink};
use crate::app::scenery::{HAZE, spawn_scenery};
use crate::app::screenshot::{Shot, image_target, take};
use crate::app::tracks::{Tracks, draw_tracks, leave_tracks};
use crate::app::{DemoOptions, DemoScene, has_display};
use crate::engine::{
    Athlete, AthleteController, AthleteGhost, AthletePlugins, AthleteReset, AthleteSettings, AthleteWorld,
    CharacterAsset, ControlAsset, PlaybackSpeed,
};
use bevy::app::ScheduleRunnerPlugin;
use bevy::camera::visibility::VisibilitySystems;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::log::LogPlugin;
use bevy::pbr::{DistanceFog, FogFalloff};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::time::TimeUpdateStrategy;
use bevy::transform::TransformSystems;
use bevy::window::{ExitCondition, PresentMode, WindowResolution};
use bevy::winit::WinitPlugin;
use bevy_egui::input::{egui_wants_any_keyboard_input, egui_wants_any_pointer_input};
use bevy_egui::{EguiPlugin, EguiPrimaryContextPass};
use std::process::ExitCode;
use std::time::Duration;

/// Simulated seconds per real second in slow motion.
const SLOW: f32 = 0.2;

/// What the set-up needs of the command line and the scene.
#[derive(Resource)]
struct Stage {
    scene: DemoScene,
    options: DemoOptions,
    offscreen: bool,
}

/// Opens the window, or renders to a picture; returns when it is closed.
pub fn run_window(scene: DemoScene, options: &DemoOptions) -> ExitCode {
    let offscreen = !has_display();
    let mut app = App::new();
    let window = Window {
        title: "Skater, simulated".into(),
        resolution: WindowResolution::new(options.width, options.height),
        present_mode: PresentMode::AutoVsync,
        ..default()
    };
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: (!offscreen).then_some(window),
            exit_condition: if offscreen { ExitCondition::DontExit } else { ExitCondition::OnPrimaryClosed },
            ..default()
        })
        .set(RenderPlugin { synchronous_pipeline_compilation: options.screenshot.is_some(), ..default() })
        .set(LogPlugin { filter: "warn,wgpu=error,naga=error,bevy_athlete=info".into(), ..default() });
    if offscreen {
        app.add_plugins((plugins.disable::<WinitPlugin>(), ScheduleRunnerPlugin::run_loop(Duration::ZERO)));
    } else {
        app.add_plugins((plugins, EguiPlugin::default())).add_systems(EguiPrimaryContextPass, show_panel).add_systems(
            Update,
            (
                keys.run_if(not(egui_wants_any_keyboard_input)),
                orbit.run_if(not(egui_wants_any_pointer_input)).before(follow),
            ),
        );
        add_panels(&mut app, options);
    }
    app.add_plugins(AthletePlugins)
        .insert_resource(AthleteWorld(scene.world.clone()))
        .insert_resource(ClearColor(HAZE))
        .insert_resource(ShowPanel(true))
        .init_resource::<Tracks>()
        .insert_resource(Stage { scene, options: options.clone(), offscreen })
        .add_systems(Startup, setup)
        .add_systems(FixedLast, leave_tracks)
        .add_systems(Update, (follow, draw_tracks))
        .add_systems(
            PostUpdate,
            (make_images, place_images)
                .chain()
                .after(TransformSystems::Propagate)
                .before(VisibilitySystems::CheckVisibility),
        );
    if let Some(file) = &options.screenshot {
        // Frames are cut so that the picture shows the wanted time, however slow the renderer is.
        let at = if options.at.is_finite() { options.at.clamp(0.0, 3600.0) } else { 0.0 };
        let frames = options.frames.max((at / 0.2).ceil() as u32);
        let shot = Shot { file: file.clone(), frames, image: None, seen: 0 };
        let frame = Duration::from_secs_f64(at / f64::from(frames));
        app.insert_resource(shot).insert_resource(TimeUpdateStrategy::ManualDuration(frame)).add_systems(Update, take);
    }
    let exit = app.run();
    match &options.screenshot {
        Some(file) if !file.exists() => {
            eprintln!("error: the picture {} was not written", file.display());
            ExitCode::FAILURE
        }
        Some(file) => {
            println!("picture written to {}", file.display());
            ExitCode::SUCCESS
        }
        None if exit.is_success() => ExitCode::SUCCESS,
        None => ExitCode::FAILURE,
    }
}

/// The skater, the rink around it, the camera.
#[allow(clippy::too_many_arguments)] // a system takes what it needs
fn setup(
    mut commands: Commands,
    stage: Res<Stage>,
    mut shot: Option<ResMut<Shot>>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    mut controls: ResMut<Assets<ControlAsset>>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    let Stage { scene, options, offscreen } = &*stage;
    commands.spawn((
        Athlete(characters.add(CharacterAsset { model: scene.model.clone() })),
        AthleteController::Play(controls.add(ControlAsset { control: scene.control.clone() })),
        AthleteSettings { restart_after: Some(1.0), ..default() },
        AthleteGhost::default(),
    ));

    let middle = scene.middle().as_vec3();
    spawn_rink(&mut commands, &mut meshes, &mut materials, RinkPlan { middle, low: options.low });
    spawn_scenery(&mut commands, &mut meshes, &mut materials, middle);
    gizmos.config_mut::<DefaultGizmoConfigGroup>().0.line.width = 2.0;

    let orbit =
        OrbitCamera { azimuth: options.azimuth.to_radians(), distance: options.distance.clamp(1.5, 30.0), ..default() };
    let mut camera = commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection { fov: 36.0_f32.to_radians(), ..default() }),
        orbit.transform(),
        orbit,
        DistanceFog { color: HAZE, falloff: FogFalloff::Linear { start: 35.0, end: 210.0 }, ..default() },
    ));
    if options.low {
        camera.insert((Msaa::Off, Tonemapping::None));
    } else {
        camera.insert((Msaa::Sample4, Tonemapping::AcesFitted));
    }
    if options.screenshot.is_some() {
        // Dithering doubles the size of the file.
        camera.insert(DebandDither::Disabled);
    }
    if *offscreen {
        let (image, target) = image_target(&mut images, options.width, options.height);
        camera.insert(target);
        if let Some(shot) = &mut shot {
            shot.image = Some(image);
        }
    }
}

/// Space, S, R and H.
fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut playback: ResMut<PlaybackSpeed>,
    mut show: ResMut<ShowPanel>,
    athletes: Query<Entity, With<Athlete>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.paused = !playback.paused;
    }
    if keys.just_pressed(KeyCode::KeyS) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { SLOW };
    }
    if keys.just_pressed(KeyCode::KeyH) {
        show.0 = !show.0;
    }
    if keys.just_pressed(KeyCode::KeyR) {
        for athlete in &athletes {
            commands.trigger(AthleteReset::new(athlete));
        }
    }
}
