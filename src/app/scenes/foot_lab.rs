//! The foot lab: the human with feet of sixteen bones, standing on a floor that tilts. Poses, slope and pushes by the menu;
//! nothing but joint torques and contact holds it up, so it falls when it is asked too much.

use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::contact::{Geometry, Solid, Surface, World};
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteHistory, AthleteSystems, AthleteTargets, AthleteWorld,
    CharacterAsset,
};
use crate::model::{CharacterModel, foot_human};
use bevy::math::{DQuat, DVec2, DVec3};
use bevy::prelude::*;

/// The steepest floor, degrees.
pub(crate) const STEEPEST: f32 = 12.0;
/// How fast the floor tilts, rad/s.
const TILT_RATE: f64 = 0.12;
/// How fast a pose is taken, rad/s of the joint that turns most.
const POSE_RATE: f64 = 1.6;
/// Lean from the ankles that brings the weight over the middle of the feet, degrees.
const LEAN: f64 = 1.43;
/// Half of the floor's sides, m.
const FLOOR: f32 = 1.6;

/// A pose: name, and rotation vectors of joints (degrees; without a side: both).
type LabPose = (&'static str, &'static [(&'static str, [f64; 3])]);

/// What the menu offers. Knees and hips bend together so that the weight stays over the feet.
pub(crate) const POSES: [LabPose; 6] = [
    ("Stand", &[]),
    ("Arms to the sides", &[("upper_arm_left", [0.0, 0.0, -85.0]), ("upper_arm_right", [0.0, 0.0, 85.0])]),
    ("Arms ahead", &[("upper_arm", [70.0, 0.0, 0.0]), ("medial_metatarsal", [-2.5, 0.0, 0.0])]),
    (
        "Knees bent",
        &[
            ("thigh", [30.0, 0.0, 0.0]),
            ("shin", [-55.0, 0.0, 0.0]),
            ("medial_metatarsal", [27.0, 0.0, 0.0]),
            ("upper_arm", [25.0, 0.0, 0.0]),
        ],
    ),
    ("Bow", &[("chest", [-25.0, 0.0, 0.0]), ("thigh", [12.0, 0.0, 0.0]), ("medial_metatarsal", [-7.0, 0.0, 0.0])]),
    ("Toes up", &[("medial_phalanges", [25.0, 0.0, 0.0]), ("lateral_phalanges", [25.0, 0.0, 0.0])]),
];

/// What the lab is set to.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct FootLab {
    /// Index of the pose.
    pub pose: usize,
    /// Slope to be reached, degrees: sideways (to the right is down), ahead (ahead is down).
    pub slope: Vec2,
    /// Slope at present, rad.
    now: DVec2,
    /// Part of the way from the pose before, and that pose.
    targets: Vec<DQuat>,
}

#[derive(Component)]
pub(crate) struct LabHuman;

#[derive(Component)]
struct Floor;

pub(crate) struct FootLabPlugin;

impl Plugin for FootLabPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FootLab>()
            .add_systems(OnEnter(DemoScene::FootLab), enter)
            .add_systems(FixedUpdate, take_pose.run_if(in_state(DemoScene::FootLab)))
            .add_systems(FixedPostUpdate, tilt.in_set(AthleteSystems::ReadWorld).run_if(in_state(DemoScene::FootLab)))
            .add_systems(Update, place_floor.run_if(in_state(DemoScene::FootLab)));
    }
}

fn enter(
    mut commands: Commands,
    stage: Res<Stage>,
    mut lab: ResMut<FootLab>,
    mut props: Props,
    mut characters: ResMut<Assets<CharacterAsset>>,
) {
    *lab = FootLab::default();
    let root = scene_root(&mut commands, DemoScene::FootLab);
    props.hall(&mut commands, root, stage.options.low);
    let floor = props.block(Vec3::new(2.0 * FLOOR, 0.08, 2.0 * FLOOR), Color::srgb(0.78, 0.70, 0.58));
    commands.spawn((ChildOf(root), Floor, floor, Transform::from_xyz(0.0, -0.04, 0.0)));
    commands.insert_resource(AthleteWorld(World::ground()));
    let model = foot_human();
    lab.targets = targets(&model, 0);
    commands.spawn((
        LabHuman,
        DespawnOnExit(DemoScene::FootLab),
        Athlete(characters.add(CharacterAsset { model })),
        AthleteController::External,
        AthleteTargets { rotations: lab.targets.clone(), velocities: Vec::new() },
        AthleteHistory::default(),
    ));
}

/// Target rotations of a pose, leaning from the ankles.
fn targets(model: &CharacterModel, pose: usize) -> Vec<DQuat> {
    let (_, joints) = POSES[pose.min(POSES.len() - 1)];
    let rotation = |name: &str| {
        let own = joints.iter().filter(|(joint, _)| {
            name == *joint || name.strip_prefix(joint).is_some_and(|side| side == "_left" || side == "_right")
        });
        let mut vector = own.map(|(_, degrees)| DVec3::from_array(*degrees)).sum::<DVec3>();
        if name.starts_with("medial_metatarsal") {
            vector.x += LEAN;
        }
        DQuat::from_scaled_axis(vector * 1f64.to_radians())
    };
    model.links.iter().map(|link| rotation(&link.name)).collect()
}

/// Moves the targets towards the chosen pose.
fn take_pose(
    time: Res<Time>,
    mut lab: ResMut<FootLab>,
    mut humans: Query<(&mut AthleteTargets, Option<&AthleteBody>), With<LabHuman>>,
) {
    for (mut given, body) in &mut humans {
        let Some(body) = body else { continue };
        if body.time() <= 0.0 {
            lab.targets = targets(body.model(), 0);
            lab.pose = 0;
        }
        let wanted = targets(body.model(), lab.pose);
        let furthest = lab.targets.iter().zip(&wanted).map(|(a, b)| a.angle_between(*b)).fold(0.0, f64::max);
        if furthest > 1e-4 {
            let part = (POSE_RATE * time.delta_secs_f64() / furthest).min(1.0);
            for (now, wanted) in lab.bypass_change_detection().targets.iter_mut().zip(&wanted) {
                *now = now.slerp(*wanted, part);
            }
        }
        given.rotations.clone_from(&lab.targets);
    }
}

/// Tilts the floor under whoever stands on it.
fn tilt(time: Res<Time>, mut lab: ResMut<FootLab>, mut world: ResMut<AthleteWorld>) {
    let lab = lab.bypass_change_detection();
    let dt = time.delta_secs_f64();
    let wanted = DVec2::new(-f64::from(lab.slope.y), -f64::from(lab.slope.x)) * 1f64.to_radians();
    let step = (wanted - lab.now).clamp_length_max(TILT_RATE * dt);
    lab.now += step;
    let turn = DQuat::from_scaled_axis(DVec3::new(lab.now.x, 0.0, lab.now.y));
    let rate = step / dt.max(1e-9);
    let mut floor = Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal: turn * DVec3::Y }, Surface::GROUND);
    floor.angular_velocity = DVec3::new(rate.x, 0.0, rate.y);
    world.solids.clear();
    world.solids.push(floor);
}

fn place_floor(lab: Res<FootLab>, mut floors: Query<&mut Transform, With<Floor>>) {
    for mut floor in &mut floors {
        let turn = DQuat::from_scaled_axis(DVec3::new(lab.now.x, 0.0, lab.now.y)).as_quat();
        *floor = Transform::from_translation(turn * Vec3::new(0.0, -0.04, 0.0)).with_rotation(turn);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Quat, Vec3 as LaneVec3};
    use crate::sim::{SimulationSettings, Simulator, step};

    /// Height of the pelvis after taking a pose and holding it, against that before.
    fn hold(pose: usize) -> f64 {
        let model = foot_human();
        let settings = SimulationSettings::of(&model);
        let mut sim: Simulator<f64> = Simulator::new(model.clone(), settings);
        let joints = vec![DQuat::IDENTITY; model.links.len()];
        sim.state.set_pose(0, DVec3::Y * model.rest_root_height(), DQuat::IDENTITY, &joints);
        sim.state_changed();
        let (mut now, wanted) = (targets(&model, 0), targets(&model, pose));
        let world = World::ground();
        let mut before = 0.0;
        for k in 0..(8.0 * settings.rate) as usize {
            if k == (2.0 * settings.rate) as usize {
                before = sim.state.root_position.lane(0).y;
            }
            if k as f64 > 2.0 * settings.rate {
                let furthest = now.iter().zip(&wanted).map(|(a, b)| a.angle_between(*b)).fold(0.0, f64::max);
                let part = if furthest > 1e-4 { (POSE_RATE / settings.rate / furthest).min(1.0) } else { 1.0 };
                for (now, wanted) in now.iter_mut().zip(&wanted) {
                    *now = now.slerp(*wanted, part);
                }
            }
            for (command, target) in sim.commands.iter_mut().zip(&now).skip(1) {
                (command.rotation, command.velocity) = (Quat::splat(*target), LaneVec3::zero());
            }
            step(&mut sim, &world);
        }
        sim.state.root_position.lane(0).y / before
    }

    #[test]
    fn every_pose_can_be_held() {
        for (k, (name, _)) in POSES.iter().enumerate() {
            let left = hold(k);
            println!("{name}: pelvis at {:.0} % of its height after 6 s", 100.0 * left);
            assert!(left > 0.75, "{name}: it fell");
        }
    }
}
