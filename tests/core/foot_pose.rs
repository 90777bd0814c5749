//! Contract: the foot pose controller puts the soles that it is asked for on any plane, by the least that the foot's joints need,
//! and says so where it cannot.
//!
//! The pose is judged by forward kinematics of the model's own links and contact points, not by the controller's view of the foot:
//! a wrong radius, a wrong joint or a wrong frame shows as a sole off the plane. Reachable poses are drawn without the controller,
//! from angles; it then gets the ankle up to 5 mm from where it was.

use bevy_athlete::contact::{Geometry, Solid, Surface, World};
use bevy_athlete::control::foot::{
    BasicPose, FootAnatomy, FootError, FootFault, FootPose, FootPoseOptions, FootPoseRequest, GroundPlane, SegmentSet,
    foot_pose,
};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{CharacterModel, foot_human, skater, two_segment_human};
use glam::{DMat3, DQuat, DVec3};

/// Lowest point (m over the plane) and tilt of the sole (rad) of every segment, by the model's links.
fn measured(model: &CharacterModel, foot: &FootAnatomy, pose: &FootPose, ground: &GroundPlane) -> Vec<(f64, f64)> {
    let mut place: Vec<(usize, DVec3, DQuat)> = Vec::new();
    for (k, segment) in foot.segments().iter().enumerate() {
        let at = if k == 0 {
            (segment.link, pose.ankle, pose.rotation)
        } else {
            let link = &model.links[segment.link];
            let (_, origin, rotation) = *place.iter().find(|p| Some(p.0) == link.parent).unwrap();
            (segment.link, origin + rotation * link.offset, rotation * pose.joints[k])
        };
        place.push(at);
    }
    let gap = |&(link, origin, rotation): &(usize, DVec3, DQuat)| {
        let own = model.contact_points.iter().filter(|p| p.link == link);
        let lowest =
            own.map(|p| ground.height(origin + rotation * p.position) - p.radius).fold(f64::INFINITY, f64::min);
        (lowest, (rotation * DVec3::Y).angle_between(ground.normal))
    };
    place.iter().map(gap).collect()
}

/// A rotation from foot axes (Y up, -Z ahead) to a plane's, turned in it by `yaw`, then rolled and pitched about the foot's own axes.
fn turned(ground: &GroundPlane, yaw: f64, pitch: f64, roll: f64) -> DQuat {
    let n = ground.normal;
    let x = n.cross(DVec3::new(0.3, 0.1, 1.0)).normalize();
    let flat = DQuat::from_mat3(&DMat3::from_cols(x, n, x.cross(n)));
    flat * DQuat::from_rotation_y(yaw) * DQuat::from_rotation_z(roll) * DQuat::from_rotation_x(pitch)
}

fn random_plane(random: &mut RandomStream) -> GroundPlane {
    let tilt = random.range(0.0, 0.6);
    let around = random.range(0.0, std::f64::consts::TAU);
    let normal = DVec3::new(tilt.sin() * around.cos(), tilt.cos(), tilt.sin() * around.sin());
    let point = DVec3::new(random.range(-5.0, 5.0), random.range(-5.0, 5.0), random.range(-5.0, 5.0));
    GroundPlane { point, normal }
}

/// What the ankle's link is turned by, and how high the ankle is, in a reachable pose that touches with `touch`.
fn drawn(
    foot: &FootAnatomy,
    pose: usize,
    touch: SegmentSet,
    g: &GroundPlane,
    random: &mut RandomStream,
) -> (DQuat, f64) {
    let inward = if foot.side == Some(bevy_athlete::asset::Side::Left) { 1.0 } else { -1.0 };
    let yaw = random.range(-3.0, 3.0);
    let (pitch, roll) = match pose {
        0 => (0.0, 0.0),
        1 => (random.range(-0.7, -0.1), random.range(-0.05, 0.05)),
        2 => (0.0, inward * random.range(-0.35, -0.08)),
        3 => (0.0, inward * random.range(0.08, 0.35)),
        _ => (random.range(0.2, 0.35), random.range(-0.045, 0.045)),
    };
    // Height of the ankle that a joint on its link asks for.
    let asks = |rotation: DQuat, k: usize| {
        let segment = &foot.segments()[k];
        segment.drop - g.normal.dot(rotation * segment.offset)
    };
    let fixed: Vec<usize> = touch.iter().filter(|&k| foot.segments()[k].parent == 0).collect();
    let rotation = if let ([a, b, ..], 2..=3) = (&fixed[..], pose) {
        // Two joints: the pitch at which both ask for the same height.
        let (mut low, mut high) = (-0.4, 0.4);
        let off = |pitch: f64| {
            let r = turned(g, yaw, pitch, roll);
            asks(r, *a) - asks(r, *b)
        };
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if off(middle) * off(low) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        turned(g, yaw, low, roll)
    } else {
        turned(g, yaw, pitch, roll)
    };
    (rotation, asks(rotation, fixed[0]))
}

/// Sets by number: the four basic poses and the heel alone.
fn sets(foot: &FootAnatomy) -> [SegmentSet; 5] {
    let basic = BasicPose::ALL.map(|p| foot.set(p).unwrap());
    let tilt = [foot.set(BasicPose::InsideTilt).unwrap(), foot.set(BasicPose::OutsideTilt).unwrap()];
    let heel: Vec<usize> = tilt[0].iter().filter(|&k| tilt[1].contains(k)).collect();
    [basic[0], basic[1], basic[2], basic[3], SegmentSet::of(&heel)]
}

#[test]
fn soles_lie_on_any_plane_though_the_ankle_is_off() {
    let model = foot_human();
    let feet = [0, 1].map(|f| FootAnatomy::of(&model, f).unwrap());
    let mut random = RandomStream::new(20, 1);
    let options = FootPoseOptions::default();
    let (mut gap, mut tilt, mut deep, mut roll, mut moved): (f64, f64, f64, f64, f64) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for draw in 0..10_000 {
        let foot = &feet[draw % 2];
        let kind = (draw / 2) % 5;
        let touch = sets(foot)[kind];
        let ground = random_plane(&mut random);
        let (rotation, height) = drawn(foot, kind, touch, &ground, &mut random);
        let ankle = ground.point + ground.normal * height;
        let off = DVec3::new(random.normal(), random.normal(), random.normal()).normalize() * random.range(0.0, 0.005);
        let direction = rotation * DVec3::NEG_Z;
        let request =
            FootPoseRequest { ankle: ankle + off, rotation, direction, touch, ground, under: Default::default() };
        let pose = foot_pose(foot, &request, &options);
        let seen = measured(&model, foot, &pose, &ground);
        let told = format!("draw {draw}, pose {kind}: {:?}\n{seen:?}", pose.report);
        for (k, &(lowest, angle)) in seen.iter().enumerate() {
            if touch.contains(k) {
                assert!(lowest.abs() < 1e-3 && angle < 0.21f64.to_radians(), "{told}");
                (gap, tilt) = (gap.max(lowest.abs()), tilt.max(angle));
            }
            assert!(lowest > -2e-4, "segment {k} digs in: {told}");
            deep = deep.max(-lowest);
            let report = &pose.report.segments[k];
            assert!((report.gap - lowest).abs() < 1e-7 && (report.tilt - angle).abs() < 1e-6, "{told}");
        }
        assert!(pose.report.roll.abs() <= 3.001f64.to_radians(), "{told}");
        assert!(pose.report.is_met(), "{told}");
        assert!((pose.ankle - request.ankle - ground.normal * pose.report.displacement).length() < 1e-12);
        (roll, moved) = (roll.max(pose.report.roll.abs()), moved.max(pose.report.displacement.abs()));
    }
    println!(
        "largest gap {:.4} mm (allowed 1), tilt {:.4} degrees (0.2), depth {:.4} mm, roll added {:.2} degrees (3), ankle moved {:.2} mm",
        gap * 1e3,
        tilt.to_degrees(),
        deep * 1e3,
        roll.to_degrees(),
        moved * 1e3
    );
}

/// A request over level ground, the foot straight ahead.
fn level(foot: &FootAnatomy, height: f64, rotation: DQuat, touch: SegmentSet) -> FootPoseRequest {
    let direction = rotation * foot.forward();
    let (ground, under) = (GroundPlane::LEVEL, Default::default());
    FootPoseRequest { ankle: DVec3::Y * height, rotation, direction, touch, ground, under }
}

#[test]
fn one_joint_turns_by_the_papers_angle() {
    // Equation 2 with the radius of the segment, about the axis of equation 1.
    let model = foot_human();
    let foot = FootAnatomy::of(&model, 0).unwrap();
    let touch = foot.set(BasicPose::Tiptoe).unwrap();
    let k = touch.iter().find(|&k| foot.segments()[k].parent == 0).unwrap();
    for height in [0.08, 0.1, 0.12] {
        let request = level(&foot, height, DQuat::IDENTITY, touch);
        let pose = foot_pose(&foot, &request, &FootPoseOptions::default());
        let v = foot.segments()[k].offset;
        let before = v.x.hypot(v.z).atan2(-v.y);
        let after = ((height - foot.segments()[k].drop) / v.length()).acos();
        let axis = DVec3::Y.cross(v).normalize();
        let paper = DQuat::from_axis_angle(axis, before - after);
        // The paper turns v about n x v by phi_b - phi_a; its sign is that of the turn towards -n.
        let turned = paper * v;
        assert!((turned.y + height - foot.segments()[k].drop).abs() < 1e-12, "{turned}");
        assert!(pose.rotation.angle_between(paper) < 1e-7, "{height}: {} against {paper}", pose.rotation);
        assert_eq!(pose.report.displacement, 0.0);
    }
}

#[test]
fn heel_and_toes_flat_move_the_ankle_and_do_not_roll_it() {
    let model = foot_human();
    let foot = FootAnatomy::of(&model, 1).unwrap();
    let rest = foot.set(BasicPose::Rest).unwrap();
    let inside = foot.set(BasicPose::InsideTilt).unwrap();
    for touch in [rest, inside] {
        for height in [0.05, 0.06, 0.066, 0.075] {
            let request = level(&foot, height, DQuat::IDENTITY, touch);
            let pose = foot_pose(&foot, &request, &FootPoseOptions::default());
            assert!((pose.report.displacement - (0.066 - height)).abs() < 1e-9, "{height}: {:?}", pose.report);
            assert!(pose.report.rotation < 1e-9 && pose.report.is_met(), "{:?}", pose.report);
        }
        // Farther than the ankle may move: out of reach, by name.
        let request = level(&foot, 0.1, DQuat::IDENTITY, touch);
        let pose = foot_pose(&foot, &request, &FootPoseOptions::default());
        let first = touch.iter().next().unwrap();
        match pose.report.segments[first].fault {
            Some(FootFault::OutOfReach { gap }) => assert!((gap - 0.014).abs() < 1e-9, "{gap}"),
            other => panic!("{other:?}"),
        }
        assert!((pose.report.displacement + 0.02).abs() < 1e-12 && pose.report.touching.is_empty());
    }
}

#[test]
fn faults_are_told_by_segment() {
    let model = foot_human();
    let foot = FootAnatomy::of(&model, 0).unwrap();
    let [rest, tiptoe, _, _, heel] = sets(&foot);
    let heel_index = heel.iter().next().unwrap();
    let options = FootPoseOptions::default();

    // The heel hangs on a joint 26 mm from the ankle: at 20 cm nothing reaches, the argument of the arccosine is clamped.
    let pose = foot_pose(&foot, &level(&foot, 0.2, DQuat::IDENTITY, heel), &options);
    assert!(
        matches!(pose.report.segments[heel_index].fault, Some(FootFault::OutOfReach { gap }) if gap > 0.1),
        "{:?}",
        pose.report
    );
    // The same far below the ground.
    let pose = foot_pose(&foot, &level(&foot, -0.2, DQuat::IDENTITY, heel), &options);
    assert!(!pose.report.is_met() && pose.ankle.is_finite() && pose.rotation.is_finite());

    // Normal parallel to the vector from the ankle to the joint.
    let toes = tiptoe.iter().find(|&k| foot.segments()[k].parent == 0).unwrap();
    let v = foot.segments()[toes].offset;
    let upright = DQuat::from_rotation_arc(v.normalize(), DVec3::NEG_Y);
    let pose = foot_pose(&foot, &level(&foot, 0.135, upright, SegmentSet::of(&[toes])), &options);
    assert!(pose.report.parallel && pose.report.segments[toes].gap.abs() < 1e-6, "{:?}", pose.report);

    // The reference points along the normal: the link's own direction counts.
    let mut request = level(&foot, 0.066, DQuat::IDENTITY, rest);
    request.direction = DVec3::NEG_Y;
    let pose = foot_pose(&foot, &request, &options);
    assert!(pose.report.no_direction && pose.report.is_met());
    assert!(pose.rotation.angle_between(DQuat::IDENTITY) < 1e-9);

    // A direction that the toe joints cannot turn to: 60 degrees to the side against limits of 20 to 25.
    let mut request = level(&foot, 0.1, DQuat::IDENTITY, tiptoe);
    request.direction = DQuat::from_rotation_y(1.05) * foot.forward();
    let pose = foot_pose(&foot, &request, &options);
    let limited = tiptoe.iter().filter(
        |&k| matches!(pose.report.segments[k].fault, Some(FootFault::JointLimit { missing }) if missing > 0.25),
    );
    assert_eq!(limited.count(), tiptoe.len(), "{:?}", pose.report);
    let joints = tiptoe.iter().map(|k| (k, pose.joints[k]));
    for (k, q) in joints {
        let limits = foot.segments()[k].limits.unwrap();
        let r = q.to_scaled_axis();
        assert!(r.cmpge(limits.low - 1e-6).all() && r.cmple(limits.high + 1e-6).all(), "{k}: {r}");
    }

    // What was not asked for and would dig in is stood on instead.
    let pose = foot_pose(&foot, &level(&foot, 0.055, DQuat::IDENTITY, tiptoe), &options);
    let report = &pose.report;
    let added = report.added.iter().next().expect("one that would dig in");
    assert!(!tiptoe.contains(added) && report.segments[added].gap.abs() < 1e-6, "{report:?}");
    assert!((report.displacement - 0.011).abs() < 1e-6, "the ankle goes up for it, and that is told: {report:?}");

    // The ankle's own joint, under a shin that leans farther than it can bend.
    let pose = foot_pose(&foot, &level(&foot, 0.066, DQuat::IDENTITY, rest), &options);
    let (_, missing) = pose.ankle_joint(&foot, DQuat::IDENTITY);
    assert!(missing < 1e-9);
    let (_, missing) = pose.ankle_joint(&foot, DQuat::from_rotation_x(80f64.to_radians()));
    assert!((missing - 25f64.to_radians()).abs() < 0.01, "{missing}");

    // In the air nothing moves.
    let still = DQuat::from_rotation_x(0.3);
    let pose = foot_pose(&foot, &level(&foot, 0.5, still, SegmentSet::NONE), &options);
    assert!(pose.rotation.angle_between(still) < 1e-9 && pose.report.displacement == 0.0 && pose.report.is_met());
}

#[test]
fn other_feet_are_posed_or_refused_by_name() {
    let model = two_segment_human();
    let foot = FootAnatomy::of(&model, 0).unwrap();
    let rest = foot.set(BasicPose::Rest).unwrap();
    let tilted = DQuat::from_rotation_x(0.2) * DQuat::from_rotation_z(0.1);
    let pose = foot_pose(&foot, &level(&foot, 0.07, tilted, rest), &FootPoseOptions::default());
    for (lowest, angle) in measured(&model, &foot, &pose, &GroundPlane::LEVEL) {
        assert!(lowest.abs() < 1e-6 && angle < 1e-6, "{lowest} {angle}");
    }
    // On its toes: the hinge bends, the box comes up.
    let toes = foot.set(BasicPose::Tiptoe).unwrap();
    let pose = foot_pose(&foot, &level(&foot, 0.1, DQuat::IDENTITY, toes), &FootPoseOptions::default());
    let seen = measured(&model, &foot, &pose, &GroundPlane::LEVEL);
    assert!(seen[1].0.abs() < 3e-4 && seen[1].1 < 0.01 && seen[0].0 > 0.0, "{seen:?}");
    match foot.set(BasicPose::OutsideTilt) {
        Err(error @ FootError::LacksSegments { .. }) => {
            assert!(
                error.to_string().contains("two_segment_human") && error.to_string().contains("outside_tilt"),
                "{error}"
            );
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(FootAnatomy::of(&skater(), 0), Err(FootError::Blade { .. })));
    assert!(matches!(FootAnatomy::of(&model, 7), Err(FootError::NoFoot { index: 7, count: 2, .. })));
}

#[test]
fn the_ground_under_a_foot_is_a_plane_of_what_is_there() {
    let ball = Geometry::Sphere { center: DVec3::new(0.0, -1.0, 0.0), radius: 1.0 };
    let world = World { solids: vec![Solid::fixed(ball, Surface::GROUND)] };
    let at = DVec3::new(0.1, 0.05, -0.05);
    let plane = GroundPlane::under(&world, at, 1.0).unwrap();
    let out = (at - DVec3::new(0.0, -1.0, 0.0)).normalize();
    assert!((plane.normal - out).length() < 1e-12 && ((plane.point - DVec3::NEG_Y).length() - 1.0).abs() < 1e-12);
    assert!(GroundPlane::under(&world, DVec3::Y * 5.0, 1.0).is_none());
    assert!(GroundPlane::under(&World::empty(), DVec3::ZERO, 1.0).is_none());
}

#[test]
#[ignore = "a measurement, for a build in release on a quiet machine"]
fn both_feet_take_less_than_ten_microseconds() {
    let model = foot_human();
    let feet = [0, 1].map(|f| FootAnatomy::of(&model, f).unwrap());
    let options = FootPoseOptions::default();
    let request = |f: &FootAnatomy, h: f64| level(f, h, DQuat::from_rotation_x(0.1), f.set(BasicPose::Rest).unwrap());
    let requests = feet.each_ref().map(|f| request(f, 0.07));
    let mut sum = 0.0;
    let before = crate::counting_allocator::allocations();
    // The best of ten rounds: other work on the machine does not count.
    let mut best = f64::INFINITY;
    for _ in 0..10 {
        let start = std::time::Instant::now();
        for _ in 0..1000 {
            for (foot, request) in feet.iter().zip(&requests) {
                sum += foot_pose(foot, std::hint::black_box(request), &options).ankle.y;
            }
        }
        best = best.min(start.elapsed().as_secs_f64() / 1000.0);
    }
    assert_eq!(crate::counting_allocator::allocations(), before, "allocates");
    println!("{:.2} us for both feet ({sum:.3})", best * 1e6);
    assert!(best < 10e-6, "{:.1} us", best * 1e6);
}
