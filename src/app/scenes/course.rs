//! The course: the runner on a hall's floor with numbered obstacles. It is moved by its clip, not yet by torques: the menu
//! says so.

use crate::app::labels::Label;
use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::contact::{Geometry, Solid, Surface, World};
use crate::engine::{Athlete, AthleteBody, AthleteSettings, AthleteSystems, AthleteWorld, CharacterAsset};
use crate::model::{KeyPoses, ModelClip, ModelPose, SharedModel, runner};
use bevy::math::DVec3;
use bevy::prelude::*;

/// The motion, part of the program.
const MOTION: &str = include_str!("../../../assets/clips/course.keyposes.ron");
/// Where the jumps are highest, m along -Z, and the obstacles' heights, m.
const OBSTACLES: [(f32, f32); 3] = [(10.4, 0.30), (20.56, 0.35), (30.84, 0.40)];
/// Depth and width of an obstacle, m.
const SIZE: Vec2 = Vec2::new(0.35, 2.2);
/// Length of the way, m.
const WAY: f32 = 42.4;

/// The clip of the runner and where it is in it, s.
#[derive(Component)]
struct OnClip {
    clip: ModelClip,
    pose: ModelPose,
    time: f64,
}

pub(crate) struct CoursePlugin;

impl Plugin for CoursePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(OnEnter(DemoScene::Course), enter)
            .add_systems(FixedPostUpdate, follow_clip.in_set(AthleteSystems::Step).run_if(in_state(DemoScene::Course)));
    }
}

/// The clip for the model; `None` if the files do not fit each other.
fn clip(model: &SharedModel) -> Option<ModelClip> {
    let poses = KeyPoses::from_ron(MOTION, "course.keyposes.ron").ok()?;
    poses.to_clip(model).ok()?.to_model(model).ok()
}

fn enter(mut commands: Commands, stage: Res<Stage>, mut props: Props, mut characters: ResMut<Assets<CharacterAsset>>) {
    let root = scene_root(&mut commands, DemoScene::Course);
    props.hall(&mut commands, root, stage.options.low);
    let mut world = World::ground();
    for (k, (z, height)) in OBSTACLES.into_iter().enumerate() {
        let size = Vec3::new(SIZE.y, height, SIZE.x);
        let middle = Vec3::new(0.0, 0.5 * height, -z);
        let block = props.block(size, Color::hsl(18.0 + 150.0 * k as f32, 0.55, 0.55));
        commands.spawn((ChildOf(root), block, Transform::from_translation(middle)));
        let end = Transform::from_xyz(0.5 * SIZE.y - 0.15, height, -z);
        commands.spawn((ChildOf(root), end, Label { text: (k + 1).to_string(), above: 0.3 }));
        world.solids.push(Solid::fixed(
            Geometry::Box {
                center: middle.as_dvec3(),
                half_extents: size.as_dvec3() * 0.5,
                rotation: bevy::math::DQuat::IDENTITY,
            },
            Surface::GROUND,
        ));
    }
    let lane = props.block(Vec3::new(SIZE.y + 0.6, 0.01, WAY + 4.0), Color::srgb(0.72, 0.36, 0.28));
    commands.spawn((ChildOf(root), lane, Transform::from_xyz(0.0, -0.004, -0.5 * WAY)));
    commands.insert_resource(AthleteWorld(world));
    let model = runner();
    let mut athlete = commands.spawn((
        DespawnOnExit(DemoScene::Course),
        Athlete(characters.add(CharacterAsset { model: model.clone() })),
        // Its body does not step: the clip places it.
        AthleteSettings { paused: true, ..default() },
    ));
    if let Some(clip) = clip(&model) {
        athlete.insert(OnClip { pose: ModelPose::zero(&model), clip, time: 0.0 });
    }
}

fn follow_clip(time: Res<Time>, mut runners: Query<(&mut AthleteBody, &mut OnClip)>) {
    for (mut body, mut on_clip) in &mut runners {
        let OnClip { clip, pose, time: at } = &mut *on_clip;
        *at = (*at + time.delta_secs_f64()) % clip.duration().max(0.1);
        clip.sample_into(*at, pose);
        let simulator = body.simulator_mut();
        let before = simulator.state.root_position.lane(0);
        simulator.state.set_pose(0, pose.root_position, pose.root_rotation, &pose.joints);
        let velocity = (pose.root_position - before) / time.delta_secs_f64().max(1e-9);
        simulator.state.root_velocity.linear =
            crate::math::Vec3::splat(if velocity.length() < 20.0 { velocity } else { DVec3::ZERO });
        simulator.state.time = *at;
        simulator.state_changed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The knees are drawn up where the obstacles stand: nothing of the runner touches them.
    #[test]
    fn the_runner_clears_every_obstacle() {
        let model = runner();
        let clip = clip(&model).expect("the key poses fit the runner");
        let mut links = Vec::new();
        let (mut lowest, mut over) = (f64::INFINITY, 0);
        for k in 0..(clip.duration() * 240.0) as usize {
            clip.sample(k as f64 / 240.0).link_transforms(&model, &mut links);
            for point in &model.contact_points {
                let link = &links[point.link];
                let place = link.position + link.rotation * point.position;
                for (z, height) in OBSTACLES {
                    if (place.z + f64::from(z)).abs() < f64::from(SIZE.x) * 0.5 {
                        over += 1;
                        lowest = lowest.min(place.y - point.radius - f64::from(height));
                    }
                }
            }
        }
        println!("{over} points over obstacles, the lowest {lowest:.3} m above");
        assert!(over > 100 && lowest > 0.0);
    }
}
