//! A foot of five segments to try out: which segments shall touch, where the ankle shall be, what comes up under it.
//!
//! 1 to 5 are the segments of the left foot, 6 to 0 those of the right: each asks its segment to touch, or no longer. Up and down raise the ankles, left and
//! right roll them, B brings a bump up under the left foot and down again, P pushes from behind. T is tiptoe, L stands on the left leg, C circles with the left
//! foot, space is slow motion, R starts again. The log says what the soles do; the red marks are the forces of the ground.
//!
//! `cargo run --release --example foot_lab`

mod common;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Solid, Surface, World as Surroundings};
use bevy_athlete::control::balance::AnkleStance;
use bevy_athlete::engine::*;

/// Digits in the order of the keys.
const DIGITS: [KeyCode; 10] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
    KeyCode::Digit0,
];

/// How high the bump is and is to be, m, and since when the foot circles, s.
#[derive(Resource, Default)]
struct Lab {
    height: f64,
    wanted: f64,
    circling: Option<f32>,
}

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(-1.2, 0.1, -1.6) }))
        .insert_resource(AthleteWorld(Surroundings::ground()))
        .init_resource::<Lab>()
        .add_systems(Startup, setup)
        .add_systems(Update, (feet, motions))
        .add_systems(FixedPostUpdate, bump.in_set(AthleteSystems::ReadWorld))
        .add_observer(|step: On<Footstep>| info!("{:?}: {:?}, {:.1} N s", step.side, step.phase, step.impulse.y))
        .add_observer(|step: On<StepTaken>| info!("a step of {:.2} m", step.from.distance(step.to)))
        .add_observer(|stumble: On<Stumbled>| info!("{:?}", stumble.cause))
        .add_observer(|refused: On<AthleteRefused>| info!("{}", refused.reason))
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        Athlete(assets.load("characters/foot_human.character.ron")),
        AthleteController::Balance(BalancePose::Rest),
        AthleteGizmos::default(),
        Transform::default(),
    ));
}

/// What is asked of the feet.
fn feet(keys: Res<ButtonInput<KeyCode>>, human: Single<(&AthleteBody, &mut AthleteController)>) {
    let (body, mut controller) = human.into_inner();
    let Some(Ok(before)) = body.feet_asked().map(<[AnkleStance; 2]>::try_from) else { return };
    let mut feet = before;
    for (k, _) in DIGITS.iter().enumerate().filter(|(_, key)| keys.just_pressed(**key)) {
        let touch = &mut feet[k / 5].touch;
        *touch = if touch.contains(k % 5) { touch.without(k % 5) } else { touch.with(k % 5) };
    }
    let axis = |more, less| f64::from(i8::from(keys.just_pressed(more)) - i8::from(keys.just_pressed(less)));
    let (rise, roll) = (axis(KeyCode::ArrowUp, KeyCode::ArrowDown), axis(KeyCode::ArrowRight, KeyCode::ArrowLeft));
    feet = feet.map(|foot| foot.moved(0.01 * rise, 0.05 * roll));
    let pose = BalancePose::Feet(feet);
    if feet != before && pose.stance(body.model()).is_ok() {
        *controller = AthleteController::Balance(pose);
    }
}

/// Poses that have names, the circle, the push.
fn motions(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut lab: ResMut<Lab>,
    human: Single<(&AthleteBody, &mut AthleteController, &mut AthleteForces)>,
) {
    let (body, mut controller, mut forces) = human.into_inner();
    for (key, pose) in [(KeyCode::KeyT, BalancePose::Tiptoe), (KeyCode::KeyL, BalancePose::LeftLeg)] {
        if keys.just_pressed(key) {
            (*controller, lab.circling) = (AthleteController::Balance(pose), None);
        }
    }
    if keys.just_pressed(KeyCode::KeyC) {
        lab.circling = Some(time.elapsed_secs());
    }
    if let Some(since) = lab.circling {
        let quarter = ((time.elapsed_secs() - since) / 0.75) as usize;
        controller.set_if_neq(AthleteController::Balance(BalancePose::Circling { foot: 0, quarter }));
    }
    if let (true, Some(link)) = (keys.just_pressed(KeyCode::KeyP), body.link("chest")) {
        let position = body.model().links[link.index()].com;
        forces.push(AthleteForce { link, position, force: DVec3::NEG_Z * 60.0, seconds: Some(0.4) });
    }
    if keys.just_pressed(KeyCode::KeyB) {
        lab.wanted = if lab.wanted > 0.0 { 0.0 } else { 0.03 };
    }
}

/// The bump comes up at 2 cm/s where the left foot stands at the start: the top of a ball of 12 cm.
fn bump(time: Res<Time>, mut lab: ResMut<Lab>, mut world: ResMut<AthleteWorld>, mut gizmos: Gizmos) {
    let step = (lab.wanted - lab.height).clamp(-0.02 * time.delta_secs_f64(), 0.02 * time.delta_secs_f64());
    lab.height += step;
    world.0 = Surroundings::ground();
    if lab.height > 0.0 {
        let center = DVec3::new(-0.075, lab.height - 0.12, -0.04);
        let mut ball = Solid::fixed(Geometry::Sphere { center, radius: 0.12 }, Surface::GROUND);
        ball.linear_velocity = DVec3::Y * step / time.delta_secs_f64().max(1e-9);
        world.solids.push(ball);
        gizmos.sphere(center.as_vec3(), 0.12, Color::srgb(0.8, 0.4, 0.3));
    }
}
