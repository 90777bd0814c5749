//! Contract: every objective has the value that a pose or a velocity known by hand gives it, and falls in the direction in
//! which the motion gets better. In lanes it has the bits of the scalar.
//!
//! Values alone would not do: an optimiser follows differences, and a sign that is wrong only shows in a jump that digs
//! itself into the ice.

use bevy_athlete::control::ReferenceTick;
use bevy_athlete::math::{F64x4, Quat, Real};
use bevy_athlete::model::{BodyPart, CharacterModel, ModelPose, ModelVelocity, Objective, Side, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator};
use bevy_athlete::train::objectives as measure;
use glam::{DQuat, DVec3};

fn standing<R: Real>() -> Simulator<R> {
    let model = preset("skater").unwrap();
    Simulator::new(model.clone(), SimulationSettings::of(&model))
}

/// The skater in its zero pose, moved and turned as a whole, with the root's velocity.
fn placed(shift: DVec3, turn: DQuat, linear: DVec3, angular: DVec3) -> Simulator<f64> {
    let mut sim = standing::<f64>();
    let joints = vec![DQuat::IDENTITY; sim.model().links.len()];
    let place = sim.state.root_position.lane(0) + shift;
    sim.state.set_pose(0, place, turn, &joints);
    sim.state.set_velocity(0, linear, angular, &vec![DVec3::ZERO; joints.len()]);
    sim.state_changed();
    sim
}

fn raised(height: f64) -> Simulator<f64> {
    placed(DVec3::Y * height, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO)
}

fn moving(linear: DVec3, angular: DVec3) -> Simulator<f64> {
    placed(DVec3::ZERO, DQuat::IDENTITY, linear, angular)
}

fn still(model: &CharacterModel) -> ReferenceTick {
    ReferenceTick { pose: ModelPose::zero(model), velocity: ModelVelocity::zero(model) }
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}, expected {expected}");
}

#[test]
fn blade_on_ground_is_the_sum_of_both_ends_squared() {
    for side in 0..2 {
        let blade = preset("skater").unwrap().blades[side].clone();
        let at = |height: f64| measure::blade_on_ground(&mut raised(height), &blade);
        near(at(0.0), 0.0);
        near(at(0.1), 2.0 * 0.01);
        // As bad below the ice as above it.
        near(at(-0.1), at(0.1));
        assert!(at(0.05) < at(0.06));
        // Toes up about the root: one end rises by the length of the blade times the sine, nearly.
        let mut tilted = placed(DVec3::ZERO, DQuat::from_rotation_x(0.1), DVec3::ZERO, DVec3::ZERO);
        assert!(measure::blade_on_ground(&mut tilted, &blade) > 1e-5);
    }
}

#[test]
fn com_height_is_the_squared_difference() {
    let height = standing::<f64>().center_of_mass().y;
    near(measure::com_height(&mut raised(0.0), height), 0.0);
    near(measure::com_height(&mut raised(0.2), height), 0.04);
    near(measure::com_height(&mut raised(-0.2), height), 0.04);
    assert!(measure::com_height(&mut raised(0.1), height + 0.2) < measure::com_height(&mut raised(0.0), height + 0.2));
}

#[test]
fn max_com_height_falls_as_the_mass_rises() {
    let height = standing::<f64>().center_of_mass().y;
    near(measure::max_com_height(&mut raised(1.0 - height)), 1.0);
    near(measure::max_com_height(&mut raised(2.0 - height)), 0.25);
    assert!(measure::max_com_height(&mut raised(0.01)) < measure::max_com_height(&mut raised(0.0)));
    // Lying on the ice or below it the cost is bounded.
    near(measure::max_com_height(&mut raised(-5.0)), 100.0);
}

#[test]
fn on_com_is_the_horizontal_distance_to_each_part() {
    // In the zero pose the body is symmetric: both blades lie equally far to the sides, the head above.
    let parts = [BodyPart::Head, BodyPart::BladeLeft, BodyPart::BladeRight];
    let [head, left, right] = parts.map(|part| measure::on_com(&mut raised(0.0), part));
    near(left, right);
    assert!(left > 0.09_f64.powi(2), "a blade is at least half a hip's width away: {left}");
    assert!(head < 0.05_f64.powi(2), "{head}");
    // It knows nothing of height or place, and a whole body that leans brings one blade below the mass.
    near(
        measure::on_com(&mut placed(DVec3::new(3.0, 1.0, -2.0), DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO), parts[1]),
        left,
    );
    let leaning = |angle: f64| {
        let mut sim = placed(DVec3::ZERO, DQuat::from_rotation_z(angle), DVec3::ZERO, DVec3::ZERO);
        parts.map(|part| measure::on_com(&mut sim, part))
    };
    // +z tilts to the left: the mass goes over the left blade.
    let (to_left, to_right) = (leaning(0.05), leaning(-0.05));
    assert!(to_left[1] < left && to_left[2] > right);
    assert!(to_right[1] > left && to_right[2] < right);
}

#[test]
fn max_angular_momentum_falls_towards_its_side() {
    let spinning = |rate: f64, to: Side| measure::max_angular_momentum(&mut moving(DVec3::ZERO, DVec3::Y * rate), to);
    near(spinning(0.0, Side::Left), 1.0);
    let inertia = standing::<f64>().total_inertia().to_mat3().lane(0).y_axis.y;
    // 5 kg m^2/s counter-clockwise is a quarter for the left; against it the tangent goes on.
    let rate = 5.0 / inertia;
    near(spinning(rate, Side::Left), 0.25);
    near(spinning(-rate, Side::Right), 0.25);
    near(spinning(-rate, Side::Left), 3.0);
    let (a, b, c) = (spinning(-0.1, Side::Left), spinning(0.0, Side::Left), spinning(0.1, Side::Left));
    assert!(a > b && b > c);
    // No kink at rest.
    let h = 1e-5;
    let slope = |from: f64| (spinning(from + h, Side::Left) - spinning(from, Side::Left)) / h;
    assert!((slope(0.0) - slope(-h)).abs() < 1e-3 * slope(0.0).abs());
    // Straight motion has none.
    near(measure::max_angular_momentum(&mut moving(DVec3::X * 5.0, DVec3::ZERO), Side::Left), 1.0);
}

#[test]
fn max_velocity_falls_as_the_body_rises_faster() {
    let rising = |v: f64| measure::max_velocity(&mut moving(DVec3::Y * v, DVec3::ZERO));
    near(rising(0.0), 1.0);
    near(rising(1.0), 0.25);
    near(rising(-1.0), 3.0);
    assert!(rising(0.5) < rising(0.4));
    near(measure::max_velocity(&mut moving(DVec3::X * 3.0, DVec3::ZERO)), 1.0);
}

#[test]
fn com_velocity_is_the_squared_difference() {
    let at = |v: DVec3| measure::com_velocity(&mut moving(v, DVec3::ZERO), DVec3::new(0.0, 0.0, -2.0));
    near(at(DVec3::NEG_Z * 2.0), 0.0);
    near(at(DVec3::ZERO), 4.0);
    near(at(DVec3::new(1.0, 0.0, -2.0)), 1.0);
    assert!(at(DVec3::NEG_Z * 1.5) < at(DVec3::NEG_Z * 1.4));
}

#[test]
fn pelvis_heading_compares_the_axis_to_the_right() {
    let turned = |angle: f64, desired: DVec3| {
        measure::pelvis_heading(
            &mut placed(DVec3::ZERO, DQuat::from_rotation_y(angle), DVec3::ZERO, DVec3::ZERO),
            desired,
        )
    };
    near(turned(0.0, DVec3::X), 0.0);
    near(turned(0.0, DVec3::X * 7.0), 0.0);
    near(turned(0.0, DVec3::NEG_X), 4.0);
    near(turned(0.0, DVec3::Z), 2.0);
    // The paper's (1, 0, 1) / sqrt 2: the athlete looks 45 degrees to its right.
    near(turned(-std::f64::consts::FRAC_PI_4, DVec3::new(1.0, 0.0, 1.0)), 0.0);
    assert!(turned(-0.5, DVec3::new(1.0, 0.0, 1.0)) < turned(-0.4, DVec3::new(1.0, 0.0, 1.0)));
}

#[test]
fn track_pose_is_the_squared_angle_and_knows_no_place() {
    let mut sim = standing::<f64>();
    let links = sim.model().links.len();
    let knee = sim.model().link_index("shin_left").unwrap();
    let straight = vec![Quat::splat(DQuat::IDENTITY); links];
    let mut weights = vec![0.0; links];
    weights[knee] = 2.0;
    near(measure::track_pose(&sim, &straight, Quat::splat(DQuat::IDENTITY), &weights), 0.0);
    let bent = |angle: f64| {
        let mut joints = straight.clone();
        joints[knee] = Quat::splat(DQuat::from_rotation_x(angle));
        measure::track_pose(&sim, &joints, Quat::splat(DQuat::IDENTITY), &weights)
    };
    // (2 sin(angle / 2))^2.
    near(bent(-0.2), (2.0 * 0.1_f64.sin()).powi(2));
    assert!(bent(-0.2) < bent(-0.3));
    near(
        measure::track_pose(&sim, &straight, Quat::splat(DQuat::from_rotation_y(0.2)), &weights),
        (2.0 * 0.1_f64.sin()).powi(2),
    );
    sim.state.set_pose(0, DVec3::ONE * 9.0, DQuat::IDENTITY, &vec![DQuat::IDENTITY; links]);
    near(measure::track_pose(&sim, &straight, Quat::splat(DQuat::IDENTITY), &weights), 0.0);
}

#[test]
fn track_velocity_is_the_squared_difference_of_joint_velocities() {
    let mut sim = standing::<f64>();
    let links = sim.model().links.len();
    let mut weights = vec![0.0; links];
    (weights[2], weights[3]) = (1.0, 3.0);
    let mut turning = vec![DVec3::ZERO; links];
    turning[3] = DVec3::new(1.0, 2.0, 2.0);
    near(measure::track_velocity(&sim, &vec![DVec3::ZERO; links], &weights), 0.0);
    near(measure::track_velocity(&sim, &turning, &weights), 0.75 * 9.0);
    sim.state.set_velocity(0, DVec3::X * 5.0, DVec3::Y, &turning);
    near(measure::track_velocity(&sim, &turning, &weights), 0.0);
    assert!(measure::track_velocity(&sim, &vec![DVec3::ZERO; links], &weights) > 6.0);
}

#[test]
fn track_path_is_the_squared_distance_of_the_root() {
    let sim = raised(0.0);
    let place = sim.state.root_position.lane(0);
    near(measure::track_path(&sim, place), 0.0);
    near(measure::track_path(&sim, place + DVec3::new(0.3, 0.0, 0.4)), 0.25);
    assert!(measure::track_path(&sim, place + DVec3::X * 0.1) < measure::track_path(&sim, place + DVec3::X * 0.2));
}

fn all() -> Vec<Objective> {
    let text = "[BladeOnGround(side: Left), COMHeight(height: 0.8), MaxCOMHeight(), OnCOM(part: BladeRight), OnCOM(part: Head), \
        MaxAngularMomentum(to: Right), MaxVelocity(), COMVelocity(velocity: (0.2, 0.1, -2)), \
        PelvisHeading(direction: (1, 0, 1)), TrackPose(), TrackVelocity(), TrackPath(weight: 2, at_end: true)]";
    ron::from_str(text).unwrap()
}

#[test]
fn lanes_have_the_bits_of_the_scalar() {
    let mut wide = standing::<F64x4>();
    let mut singles = Vec::new();
    for lane in 0..4 {
        let x = lane as f64;
        let single = placed(
            DVec3::new(0.1 * x, 0.02 * x, -x),
            DQuat::from_rotation_y(0.3 * x) * DQuat::from_rotation_z(0.1),
            DVec3::new(0.1, 0.5 - 0.4 * x, -2.0),
            DVec3::new(0.3, 2.0 * x - 1.0, 0.1),
        );
        wide.state.copy_lane(lane, &single.state, 0);
        singles.push(single);
    }
    wide.state_changed();
    let model = wide.model().clone();
    let meter = measure::Meter::new(&model);
    let mut tick = still(&model);
    tick.pose.joints[3] = DQuat::from_rotation_x(0.4);
    tick.velocity.joints[5] = DVec3::new(0.1, 2.0, -1.0);
    for objective in all() {
        let together = meter.measure(&mut wide, &objective, &measure::Target::new(&tick));
        for (lane, single) in singles.iter_mut().enumerate() {
            let alone = meter.measure(single, &objective, &measure::Target::new(&tick));
            assert_eq!(together.lane(lane).to_bits(), alone.to_bits(), "{}", objective.label());
        }
    }
}

#[test]
fn a_mirrored_objective_costs_the_mirrored_motion_the_same() {
    let model = preset("skater").unwrap();
    let meter = measure::Meter::new(&model);
    let tick = still(&model);
    let mirror = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.1, 0.4, -0.2));
    // Rotations and angular velocities keep their part about x and change the sign of the others.
    let (linear, angular) = (DVec3::new(0.4, 0.3, -2.0), DVec3::new(0.2, 1.5, -0.3));
    let mut sim = placed(DVec3::X * 0.2, turn, linear, angular);
    let turned_back = DQuat::from_xyzw(turn.x, -turn.y, -turn.z, turn.w);
    let mut image = placed(DVec3::X * -0.2, turned_back, mirror(linear), -mirror(angular));
    for objective in all() {
        // TrackPose and TrackPath compare with the key poses, which are mirrored themselves; the zero pose stays.
        let target = measure::Target::new(&tick);
        let (a, b) =
            (meter.measure(&mut sim, &objective, &target), meter.measure(&mut image, &objective.mirrored(), &target));
        assert!((a - b).abs() < 1e-9 * a.max(1.0), "{}: {a} and {b}", objective.label());
        assert_eq!(objective.mirrored().mirrored(), objective);
    }
}

#[test]
fn a_character_that_lacks_a_part_is_told_apart() {
    let runner = preset("runner").unwrap();
    let blade = Objective::BladeOnGround { side: Side::Left, weight: 1.0, at_end: false };
    assert_eq!(measure::Meter::lacks(&runner, &blade).as_deref(), Some("no left blade"));
    assert!(all().iter().all(|o| measure::Meter::lacks(&preset("skater").unwrap(), o).is_none()));
}
