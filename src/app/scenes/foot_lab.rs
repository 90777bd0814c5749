//! The foot lab: the human with feet of sixteen bones beside the one with feet of two segments, balanced on a floor that tilts or on a ball. Poses, ground and
//! slope by the menu; a pull by the pointer. Nothing but joint torques and contact holds them up: they step where standing no longer helps, and fall
//! when they are asked too much.

use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::contact::{Geometry, Solid, Surface, World};
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteHistory, AthleteSystems, AthleteWorld, BalancePose, CharacterAsset,
};
use crate::model::{SharedModel, foot_human, two_segment_human};
use bevy::math::{DQuat, DVec2, DVec3};
use bevy::prelude::*;

/// The steepest floor, degrees.
pub(crate) const STEEPEST: f32 = 12.0;
/// How fast the floor tilts, rad/s.
const TILT_RATE: f64 = 0.12;
/// Half of the floor's sides, m.
const FLOOR: f32 = 1.6;
/// How far from the middle each human stands, m.
const ASIDE: f32 = 0.7;
/// Radius of the balls, m.
const BALL: f32 = 0.6;

/// What the menu offers.
pub(crate) const POSES: [(&str, BalancePose); 6] = [
    ("Both soles", BalancePose::Rest),
    ("Tiptoe", BalancePose::Tiptoe),
    ("Inside tilt", BalancePose::InsideTilt),
    ("Outside tilt", BalancePose::OutsideTilt),
    ("Left leg", BalancePose::LeftLeg),
    ("Right leg", BalancePose::RightLeg),
];

/// What they stand on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LabGround {
    /// A floor that tilts.
    #[default]
    Floor,
    /// A ball each.
    Ball,
}

/// What the lab is set to.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct FootLab {
    /// Index of the pose.
    pub pose: usize,
    /// Ground.
    pub ground: LabGround,
    /// Slope to be reached, degrees: sideways (to the right is down), ahead (ahead is down).
    pub slope: Vec2,
    /// Slope at present, rad.
    now: DVec2,
}

/// A human of the lab, and the pose that it was told to take.
#[derive(Component)]
pub(crate) struct LabHuman(BalancePose);

#[derive(Component)]
struct Floor;

/// What lies on one ground only.
#[derive(Component)]
struct OnGround(LabGround);

pub(crate) struct FootLabPlugin;

impl Plugin for FootLabPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FootLab>()
            .add_systems(OnEnter(DemoScene::FootLab), enter)
            .add_systems(FixedUpdate, take_pose.run_if(in_state(DemoScene::FootLab)))
            .add_systems(FixedPostUpdate, tilt.in_set(AthleteSystems::ReadWorld).run_if(in_state(DemoScene::FootLab)))
            .add_systems(Update, (place_floor, change_ground).run_if(in_state(DemoScene::FootLab)));
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
    let lies = OnGround(LabGround::Floor);
    commands.spawn((ChildOf(root), Floor, lies, floor, Transform::from_xyz(0.0, -0.04, 0.0)));
    for x in [-ASIDE, ASIDE] {
        let ball = props.ball(BALL, Color::srgb(0.55, 0.62, 0.72));
        let lies = OnGround(LabGround::Ball);
        commands.spawn((ChildOf(root), lies, ball, Visibility::Hidden, Transform::from_xyz(x, BALL, 0.0)));
    }
    commands.insert_resource(AthleteWorld(World::ground()));
    spawn_humans(&mut commands, &mut characters, LabGround::Floor);
}

fn spawn_humans(commands: &mut Commands, characters: &mut Assets<CharacterAsset>, ground: LabGround) {
    let top = if ground == LabGround::Ball { 2.0 * BALL } else { 0.0 };
    for (model, x) in [(foot_human(), -ASIDE), (two_segment_human(), ASIDE)] {
        commands.spawn((
            LabHuman(BalancePose::Rest),
            DespawnOnExit(DemoScene::FootLab),
            Athlete(characters.add(CharacterAsset { model })),
            AthleteController::Balance(BalancePose::Rest),
            AthleteHistory::default(),
            Transform::from_xyz(x, top, 0.0),
        ));
    }
}

/// Whether a body has what a pose stands on.
fn can_take(pose: BalancePose, model: &SharedModel) -> bool {
    pose.stance(model).is_ok()
}

/// Tells those who can to take the chosen pose; the feet of two segments have no inside and no outside.
fn take_pose(lab: Res<FootLab>, mut humans: Query<(&mut LabHuman, &mut AthleteController, &AthleteBody)>) {
    let (_, pose) = POSES[lab.pose.min(POSES.len() - 1)];
    for (mut human, mut controller, body) in &mut humans {
        if human.0 != pose {
            human.0 = pose;
            if can_take(pose, body.model()) {
                *controller = AthleteController::Balance(pose);
            }
        }
    }
}

/// Shows the ground that was chosen, and begins anew on it.
fn change_ground(
    mut commands: Commands,
    mut lab: ResMut<FootLab>,
    mut shown: Local<LabGround>,
    humans: Query<Entity, With<LabHuman>>,
    mut props: Query<(&OnGround, &mut Visibility)>,
    mut characters: ResMut<Assets<CharacterAsset>>,
) {
    if *shown == lab.ground {
        return;
    }
    *shown = lab.ground;
    (lab.pose, lab.slope, lab.now) = (0, Vec2::ZERO, DVec2::ZERO);
    for (on, mut visibility) in &mut props {
        *visibility = if on.0 == *shown { Visibility::Inherited } else { Visibility::Hidden };
    }
    humans.iter().for_each(|human| commands.entity(human).despawn());
    spawn_humans(&mut commands, &mut characters, *shown);
}

/// Tilts the floor under whoever stands on it, or puts balls there.
fn tilt(time: Res<Time>, mut lab: ResMut<FootLab>, mut world: ResMut<AthleteWorld>) {
    let lab = lab.bypass_change_detection();
    world.solids.clear();
    if lab.ground == LabGround::Ball {
        for x in [-ASIDE, ASIDE] {
            let center = DVec3::new(f64::from(x), f64::from(BALL), 0.0);
            let ball = Geometry::Sphere { center, radius: f64::from(BALL) };
            world.solids.push(Solid::fixed(ball, Surface::GROUND));
        }
        // Whoever falls off it lies somewhere.
        let floor = Geometry::Plane { point: DVec3::ZERO, normal: DVec3::Y };
        world.solids.push(Solid::fixed(floor, Surface::GROUND));
        return;
    }
    let dt = time.delta_secs_f64();
    let wanted = DVec2::new(-f64::from(lab.slope.y), -f64::from(lab.slope.x)) * 1f64.to_radians();
    let step = (wanted - lab.now).clamp_length_max(TILT_RATE * dt);
    lab.now += step;
    let turn = DQuat::from_scaled_axis(DVec3::new(lab.now.x, 0.0, lab.now.y));
    let rate = step / dt.max(1e-9);
    let mut floor = Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal: turn * DVec3::Y }, Surface::GROUND);
    floor.angular_velocity = DVec3::new(rate.x, 0.0, rate.y);
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

    #[test]
    fn the_feet_of_five_segments_take_every_pose_and_those_of_two_the_flat_ones() {
        let can = |model: &SharedModel| POSES.map(|(_, pose)| can_take(pose, model));
        assert_eq!(can(&foot_human()), [true; 6]);
        assert_eq!(can(&two_segment_human()), [true, true, false, false, true, true]);
    }
}
