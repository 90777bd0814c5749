//! The Bevy app: plugins, quality, the camera.

use crate::app::buttons::show_buttons;
use crate::app::camera::{OrbitCamera, drive, follow, orbit};
use crate::app::keys::{keys, rewind, scene_keys, single_step};
use crate::app::labels::paint_labels;
use crate::app::menu::show_menu;
use crate::app::news::NewsPlugin;
use crate::app::panel::{ShowPanel, show_panel};
use crate::app::panels::add_panels;
use crate::app::pull::{PullPlugin, holds_nothing, take_hold};
#[cfg(not(target_arch = "wasm32"))]
use crate::app::recorder::{RATE, Recording, film};
use crate::app::reflection::{make_images, place_images};
use crate::app::scenery::HAZE;
use crate::app::scenes::course::{CoursePlugin, build_keys, holds_no_piece, take_piece};
use crate::app::scenes::crowd::CrowdPlugin;
use crate::app::scenes::field::FieldPlugin;
use crate::app::scenes::foot_lab::FootLabPlugin;
use crate::app::scenes::skating::SkatingPlugin;
use crate::app::screenshot::{PictureSource, Shot, image_target, take};
use crate::app::spray::SprayPlugin;
use crate::app::stage::Stage;
use crate::app::stick::show_stick;
use crate::app::touch::TouchPlugin;
use crate::app::tracks::{Tracks, draw_tracks, leave_tracks};
use crate::app::{ControlScene, DemoOptions, DemoScene, has_display};
use crate::engine::{AthletePlugins, AthleteWorld};
use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::AssetMetaCheck;
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

/// Opens the window, or renders to a picture; returns when it is closed.
pub fn run_window(control: ControlScene, options: &DemoOptions) -> ExitCode {
    let offscreen = !has_display();
    let mut app = App::new();
    let window = Window {
        title: "Athletes, simulated".into(),
        resolution: WindowResolution::new(options.width, options.height),
        present_mode: PresentMode::AutoVsync,
        // A page has the canvas ready and gives it its size.
        canvas: Some("#demo".into()),
        fit_canvas_to_parent: true,
        prevent_default_event_handling: false,
        ..default()
    };
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: (!offscreen).then_some(window),
            exit_condition: if offscreen { ExitCondition::DontExit } else { ExitCondition::OnPrimaryClosed },
            ..default()
        })
        // No file of the crate has a `.meta` beside it; asking for one is an error in a browser's console.
        .set(AssetPlugin { meta_check: AssetMetaCheck::Never, file_path: asset_folder(), ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: options.picture().is_some(), ..default() })
        .set(LogPlugin { filter: "warn,wgpu=error,naga=error,bevy_athlete=info".into(), ..default() });
    if offscreen {
        app.add_plugins((plugins.disable::<WinitPlugin>(), ScheduleRunnerPlugin::run_loop(Duration::ZERO)));
    } else {
        app.add_plugins((plugins, EguiPlugin::default(), TouchPlugin))
            .add_systems(
                EguiPrimaryContextPass,
                (paint_labels, show_panel, show_menu, show_buttons, show_stick.run_if(steers)).chain(),
            )
            .add_systems(
                Update,
                (
                    (keys, scene_keys, build_keys).run_if(not(egui_wants_any_keyboard_input)),
                    drive.run_if(not(egui_wants_any_keyboard_input)).before(follow),
                    (
                        take_hold,
                        take_piece.run_if(holds_nothing),
                        orbit.run_if(holds_nothing.and_then(holds_no_piece)).before(follow),
                    )
                        .chain()
                        .run_if(not(egui_wants_any_pointer_input)),
                ),
            )
            .add_systems(PreUpdate, (single_step, rewind).chain().run_if(not(egui_wants_any_keyboard_input)));
        #[cfg(not(feature = "fonts"))]
        app.add_systems(
            PreUpdate,
            crate::app::fonts::give_fonts
                .after(bevy_egui::EguiPreUpdateSet::InitContexts)
                .before(bevy_egui::EguiPreUpdateSet::BeginPass),
        );
        add_panels(&mut app, options);
    }
    #[cfg(target_arch = "wasm32")]
    app.add_plugins(crate::app::web::PagePlugin);
    app.add_plugins((AthletePlugins, NewsPlugin, PullPlugin, SprayPlugin))
        .insert_state(if options.crowd > 0 { DemoScene::Crowd } else { options.scene })
        .add_plugins((SkatingPlugin, FootLabPlugin, CoursePlugin, CrowdPlugin, FieldPlugin))
        .insert_resource(options.play)
        .insert_resource(AthleteWorld(control.world.clone()))
        .insert_resource(ClearColor(HAZE))
        .insert_resource(ShowPanel(true))
        .init_resource::<Tracks>()
        .init_resource::<PictureSource>()
        .insert_resource(Stage { control, options: options.clone(), offscreen })
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
    let at = if options.at.is_finite() { options.at.clamp(0.0, 3600.0) } else { 0.0 };
    if let Some(file) = &options.screenshot {
        // Frames are cut so that the picture shows the wanted time, however slow the renderer is.
        let frames = options.frames.max((at / 0.2).ceil() as u32);
        let shot = Shot { file: file.clone(), frames, seen: 0 };
        let frame = Duration::from_secs_f64(at / f64::from(frames));
        app.insert_resource(shot).insert_resource(TimeUpdateStrategy::ManualDuration(frame)).add_systems(Update, take);
    }
    #[cfg(not(target_arch = "wasm32"))]
    if let Some(file) = &options.record {
        let frame = Duration::from_secs(1) / u32::from(RATE);
        app.insert_resource(Recording::new(file.clone(), at, options.seconds))
            .insert_resource(TimeUpdateStrategy::ManualDuration(frame))
            .add_systems(Update, film);
    }
    let exit = app.run();
    match options.picture() {
        Some(file) if !exit.is_success() || !file.exists() => {
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

/// Whether the scene has somebody to steer.
fn steers(scene: Res<State<DemoScene>>) -> bool {
    matches!(scene.get(), DemoScene::Rink | DemoScene::Course | DemoScene::Field)
}

/// Where the files of the crate are: in the page's `assets`; else beside the program or in a folder above it, so that the
/// built program can be started from anywhere.
fn asset_folder() -> String {
    let usual = || AssetPlugin::default().file_path;
    if cfg!(target_arch = "wasm32") || std::env::var_os("BEVY_ASSET_ROOT").is_some() {
        return usual();
    }
    let program = std::env::current_exe().ok();
    let above = program.iter().flat_map(|program| program.ancestors().skip(1));
    let mut folders = above.map(|folder| folder.join("assets")).filter(|folder| folder.join("characters").is_dir());
    folders.next().map_or_else(usual, |folder| folder.to_string_lossy().into_owned())
}

/// The camera, and how lines are drawn.
fn setup(
    mut commands: Commands,
    stage: Res<Stage>,
    mut source: ResMut<PictureSource>,
    mut images: ResMut<Assets<Image>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    let Stage { options, offscreen, .. } = &*stage;
    gizmos.config_mut::<DefaultGizmoConfigGroup>().0.line.width = 2.0;
    let orbit =
        OrbitCamera { azimuth: options.azimuth.to_radians(), distance: options.distance.clamp(1.5, 60.0), ..default() };
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
    if options.picture().is_some() {
        // Dithering doubles the size of the file.
        camera.insert(DebandDither::Disabled);
    }
    if *offscreen {
        let (image, target) = image_target(&mut images, options.width, options.height);
        camera.insert(target);
        source.0 = Some(image);
    }
}
