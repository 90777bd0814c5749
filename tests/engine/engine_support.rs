//! What the tests of the Bevy plugins share: a headless app that is stepped by hand, and skaters in it.
#![allow(dead_code, reason = "each test file uses its part")]

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::asset::clip::{MotionClip, Pose};
use bevy_athlete::control::{Policy, ReconstructedControl};
use bevy_athlete::engine::*;
use bevy_athlete::model::{KeyPoses, ModelPose, skater};
use bevy_athlete::skill::SkillDefinition;
use std::path::Path;
use std::time::Duration;

/// Length of a fixed tick at Bevy's 64 Hz.
pub const TICK: Duration = Duration::from_micros(15_625);

/// A headless app whose frames last a tick; ambiguous orders in the schedules of the athletes are errors.
pub fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.insert_resource(AthleteWorld::ice());
    let strict = || ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..Default::default() };
    app.edit_schedule(FixedPostUpdate, |schedule| {
        schedule.set_build_settings(strict());
    });
    app.edit_schedule(RunFixedMainLoop, |schedule| {
        schedule.set_build_settings(strict());
    });
    app.finish();
    app.cleanup();
    // The first frame has no duration and runs no tick.
    app.update();
    app
}

pub fn run_ticks(app: &mut App, ticks: usize) {
    (0..ticks).for_each(|_| app.update());
}

/// A shipped skating skill, read without an asset server.
pub fn shipped_skill(name: &str) -> SkillAsset {
    skill_in(&format!("skating/{name}"))
}

/// The skill in a folder below `assets/skills/`.
pub fn skill_in(folder: &str) -> SkillAsset {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/skills").join(folder);
    let name = folder.file_name().unwrap().to_str().unwrap().to_owned();
    let definition = SkillDefinition::load(folder.join(format!("{name}.skill.ron"))).unwrap();
    let motion = folder.join(&definition.motion);
    let policy = Policy::load(folder.join("policy.onnx")).unwrap();
    if motion.to_string_lossy().ends_with(".keyposes.ron") {
        SkillAsset::from_key_poses(definition, KeyPoses::load(&motion).unwrap(), policy)
    } else {
        SkillAsset::new(definition, MotionClip::load(&motion).unwrap(), policy)
    }
}

pub fn add<A: Asset>(app: &mut App, asset: A) -> Handle<A> {
    app.world_mut().resource_mut::<Assets<A>>().add(asset)
}

/// The skater's file, once for an app: bodies that share it step together.
pub fn skater_file(app: &mut App) -> Handle<CharacterAsset> {
    add(app, CharacterAsset::preset("skater").unwrap())
}

/// A control that glides ahead in the zero pose; nothing keeps its balance.
pub fn glide(seconds: f64) -> ReconstructedControl {
    let model = skater();
    let zero = ModelPose::zero(&model);
    let poses = (0..2).map(|k| Pose {
        root_position: DVec3::new(0.0, model.rest_root_height(), -2.0 * f64::from(k) * seconds),
        root_rotation: zero.root_rotation,
        joints: zero.joints[1..].to_vec(),
    });
    ReconstructedControl {
        version: 1,
        character: "skater".into(),
        world: "ice".into(),
        rate: 1200.0,
        tick_rate: 100.0,
        ticks_per_window: 10,
        seconds,
        gains: None,
        clip: MotionClip {
            name: "glide".into(),
            frame_rate: 1.0 / seconds,
            joints: model.links[1..].iter().map(|l| l.name.clone()).collect(),
            poses: poses.collect(),
        },
        offsets: vec![vec![DVec3::ZERO; model.links.len()]],
    }
}

pub fn body(app: &App, athlete: Entity) -> &AthleteBody {
    app.world().get::<AthleteBody>(athlete).expect("a body")
}

pub fn body_mut(app: &mut App, athlete: Entity) -> Mut<'_, AthleteBody> {
    app.world_mut().get_mut::<AthleteBody>(athlete).expect("a body")
}
