//! Contract: the human with single toes is the foot human with more joints, and its toes are of use.
//!
//! Proves: bones, contact points, mass, centre of mass and inertia of a foot are those of five segments, whatever joint carries them; the
//! four basic poses are found for eight segments, on a plane and on a ball; the body stands in them by torques alone; on a ball of 0.5 m
//! more points carry than with five segments. Equal totals alone would not do: a toe that hangs on the wrong metatarsal weighs the same.

use bevy_athlete::cli::feet::{Disturbance, Episode, StancePose, run_episode};
use bevy_athlete::control::foot::{
    BasicPose, FootAnatomy, FootPoseOptions, FootPoseRequest, GroundPlane, SegmentSet, foot_pose,
};
use bevy_athlete::model::{CharacterModel, Shape, SharedModel, foot_human, toes_human};
use glam::{DMat3, DQuat, DVec3};

/// Mass (kg), centre of mass (m) and inertia about it (kg m^2) of these links in the zero pose, character axes.
fn whole(model: &CharacterModel, links: &[usize]) -> (f64, DVec3, DMat3) {
    let rest = model.rest_positions();
    let place = |l: usize| rest[l] + model.links[l].com;
    let mass: f64 = links.iter().map(|&l| model.links[l].mass).sum();
    let com = links.iter().map(|&l| place(l) * model.links[l].mass).sum::<DVec3>() / mass;
    let about = |l: usize| {
        let (m, d) = (model.links[l].mass, place(l) - com);
        let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        model.links[l].inertia + (DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer) * m
    };
    (mass, com, links.iter().map(|&l| about(l)).sum())
}

#[test]
fn a_foot_with_single_toes_weighs_what_the_foot_of_five_segments_weighs() {
    let (five, eight) = (foot_human(), toes_human());
    for (a, b) in five.feet().iter().zip(eight.feet()) {
        let ((ma, ca, ia), (mb, cb, ib)) = (whole(&five, &a.links), whole(&eight, &b.links));
        let size = |m: DMat3| m.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt();
        let off = size(ia - ib) / size(ia);
        println!(
            "{:?}: mass off by {:.1e} kg (allowed 1e-9), centre by {:.1e} m (1e-4), inertia by {off:.1e} of it (2e-3)",
            a.side,
            mb - ma,
            ca.distance(cb)
        );
        assert!((ma - mb).abs() < 1e-9 && ca.distance(cb) < 1e-4 && off < 2e-3);
        assert_eq!(b.links.len(), 8);
    }
    // The rest of the body is the same.
    for (i, link) in five.links.iter().enumerate().filter(|(i, _)| !five.feet().iter().any(|f| f.links.contains(i))) {
        let other = &eight.links[eight.link_index(&link.name).unwrap()];
        assert_eq!(
            (link.mass, link.com, link.inertia, link.gains),
            (other.mass, other.com, other.inertia, other.gains)
        );
        assert!(i == 0 || link.offset == other.offset, "{}", link.name);
    }
}

#[test]
fn bones_and_contact_points_are_the_same_and_toes_share_what_their_segment_can() {
    let (five, eight) = (foot_human(), toes_human());
    let places = |m: &CharacterModel| {
        let rest = m.rest_positions();
        let points = m.contact_points.iter().map(|p| (p.name.clone(), rest[p.link] + p.position, p.radius));
        let capsules = m.links.iter().enumerate().flat_map(|(l, link)| {
            let at = rest[l];
            link.shapes.iter().filter_map(move |s| match *s {
                Shape::Capsule { a, b, radius } => Some((at + a, at + b, radius)),
                _ => None,
            })
        });
        (points.collect::<Vec<_>>(), capsules.collect::<Vec<_>>())
    };
    let ((points, bones), (other_points, other_bones)) = (places(&five), places(&eight));
    assert_eq!((points.len(), bones.len()), (other_points.len(), other_bones.len()));
    for (name, at, radius) in &points {
        let (_, other, r) = other_points.iter().find(|p| p.0 == *name).unwrap_or_else(|| panic!("no point {name}"));
        assert!(at.distance(*other) < 1e-9 && radius == r, "{name} is at {other}, not at {at}");
    }
    for (a, b, radius) in &bones {
        let same = |o: &&(DVec3, DVec3, f64)| o.0.distance(*a) < 1e-9 && o.1.distance(*b) < 1e-9 && o.2 == *radius;
        assert_eq!(other_bones.iter().filter(same).count(), 1, "bone from {a} to {b}");
    }
    for side in ["left", "right"] {
        let link = |m: &SharedModel, name: &str| m.links[m.link_index(&format!("{name}_{side}")).unwrap()].clone();
        for (segment, toes) in
            [("medial_phalanges", ["toe1", "toe2", "toe3"].as_slice()), ("lateral_phalanges", &["toe4", "toe5"])]
        {
            let whole = link(&five, segment);
            let parts: Vec<_> = toes.iter().map(|t| link(&eight, t)).collect();
            let sum = |f: fn(&bevy_athlete::model::Link) -> f64| parts.iter().map(f).sum::<f64>();
            assert!((sum(|l| l.mass) - whole.mass).abs() < 1e-9, "{segment}");
            assert_eq!(sum(|l| l.max_torque), whole.max_torque, "{segment}");
            assert_eq!((sum(|l| l.gains.kp), sum(|l| l.gains.kd)), (whole.gains.kp, whole.gains.kd), "{segment}");
            for part in &parts {
                assert_eq!(part.limits, whole.limits);
                let parent = &eight.links[part.parent.unwrap()].name;
                assert_eq!(*parent, five.links[whole.parent.unwrap()].name, "{}", part.name);
            }
        }
    }
}

/// A request for a foot whose ankle is at `height` over the highest point of a ball under it (a plane for `None`), turned by `rotation`.
fn request(foot: &FootAnatomy, height: f64, rotation: DQuat, touch: SegmentSet, ball: Option<f64>) -> FootPoseRequest {
    let mut under = [None; bevy_athlete::control::foot::MOST_SEGMENTS];
    if let Some(radius) = ball {
        let center = DVec3::NEG_Y * radius;
        let mut joints = vec![DVec3::Y * height];
        for segment in &foot.segments()[1..] {
            joints.push(joints[segment.parent] + segment.offset);
        }
        for (under, joint) in under.iter_mut().zip(&joints).skip(1) {
            let normal = (*joint - center).normalize();
            *under = Some(GroundPlane { point: center + normal * radius, normal });
        }
    }
    let direction = rotation * DVec3::NEG_Z;
    FootPoseRequest { ankle: DVec3::Y * height, rotation, direction, touch, ground: GroundPlane::LEVEL, under }
}

/// The centres of the contact points of a pose, by segment.
fn points(foot: &FootAnatomy, request: &FootPoseRequest) -> Vec<Vec<(DVec3, f64)>> {
    let pose = foot_pose(foot, request, &FootPoseOptions::default());
    let mut place: Vec<(DVec3, DQuat)> = vec![(pose.ankle, pose.rotation)];
    for (k, segment) in foot.segments().iter().enumerate().skip(1) {
        let (origin, parent) = place[segment.parent];
        place.push((origin + parent * segment.offset, parent * pose.joints[k]));
    }
    let segments = foot.segments().iter().zip(&place);
    segments.map(|(s, (at, turn))| s.points.iter().map(|p| (*at + *turn * p.0, p.1)).collect()).collect()
}

#[test]
fn the_basic_poses_are_found_for_single_toes() {
    let model = toes_human();
    for (f, inward) in [(0, 1.0), (1, -1.0)] {
        let foot = FootAnatomy::of(&model, f).unwrap();
        let side = if f == 0 { "left" } else { "right" };
        let names = |pose: BasicPose| -> Vec<String> {
            let set = foot.set(pose).unwrap();
            set.iter().map(|k| foot.segments()[k].name.replace(&format!("_{side}"), "")).collect()
        };
        assert_eq!(names(BasicPose::Rest), ["toe1", "toe2", "toe3", "lateral_metatarsal", "toe4", "toe5", "heel"]);
        assert_eq!(names(BasicPose::Tiptoe), ["toe1", "toe2", "toe3", "toe4", "toe5"]);
        assert_eq!(names(BasicPose::InsideTilt), ["toe1", "heel"]);
        assert_eq!(names(BasicPose::OutsideTilt), ["lateral_metatarsal", "toe4", "toe5", "heel"]);

        for (pose, height, roll) in [
            (BasicPose::Rest, 0.066, 0.0),
            (BasicPose::Tiptoe, 0.106, 0.0),
            (BasicPose::InsideTilt, 0.066, -0.21),
            (BasicPose::OutsideTilt, 0.066, 0.21),
        ] {
            let touch = foot.set(pose).unwrap();
            let turned = DQuat::from_rotation_z(roll * inward);
            let pose_points = points(&foot, &request(&foot, height, turned, touch, None));
            for (k, own) in pose_points.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
                let lowest = own.iter().map(|(at, r)| at.y - r).fold(f64::INFINITY, f64::min);
                let highest = own.iter().map(|(at, r)| at.y - r).fold(f64::NEG_INFINITY, f64::max);
                let name = &foot.segments()[k].name;
                if touch.contains(k) {
                    let flat = name.contains("lateral") || highest - lowest < 1e-3;
                    assert!(lowest.abs() < 5e-4 && flat, "{pose:?}, {name}: {lowest} to {highest}");
                } else {
                    assert!(lowest > -2e-4, "{pose:?}, {name} lies {lowest} m deep");
                }
            }
        }
    }
}

#[test]
fn toes_bend_round_a_ball() {
    let radius = 0.5;
    let far = |model: &SharedModel| {
        let foot = FootAnatomy::of(model, 1).unwrap();
        let request = request(&foot, 0.066, DQuat::IDENTITY, foot.standing(), Some(radius));
        let flat = FootPoseRequest { under: Default::default(), ..request };
        let gaps = |request: &FootPoseRequest| -> Vec<f64> {
            let stands = points(&foot, request).into_iter().zip(foot.segments()).filter(|(_, s)| s.stands);
            let all = stands.flat_map(|(points, _)| points);
            all.map(|(at, r)| at.distance(DVec3::NEG_Y * radius) - radius - r).collect()
        };
        let worst = |gaps: &[f64]| gaps.iter().fold(0.0_f64, |a, g| a.max(g.abs()));
        (worst(&gaps(&request)), worst(&gaps(&flat)))
    };
    for model in [foot_human(), toes_human()] {
        let (bent, flat) = far(&model);
        println!(
            "{}: farthest sole point from a ball of {radius} m {:.2} mm, posed for a plane {:.2} mm",
            model.name,
            bent * 1e3,
            flat * 1e3
        );
        assert!(bent < 0.5 * flat, "{}: {bent} {flat}", model.name);
    }
}

#[test]
fn single_toes_stand_in_every_pose() {
    let model = toes_human();
    for pose in [BasicPose::Rest, BasicPose::Tiptoe, BasicPose::InsideTilt, BasicPose::OutsideTilt] {
        let stance = StancePose::Basic(pose);
        let returns = pose != BasicPose::Rest;
        let episode = Episode { stance, returns, ..Episode::standing(Disturbance::None, 9.0) };
        let result = run_episode(&model, &episode, 2, 0.0).unwrap();
        assert!(result.held(), "{pose:?} fell at {:?}", result.fell_at);
    }
}

#[test]
fn more_points_carry_on_a_ball_than_with_five_segments() {
    let carrying = |model: &SharedModel| {
        let episode = Episode::standing(Disturbance::Ball { radius: 0.5 }, 5.0);
        let mean = |number: u64| {
            let result = run_episode(model, &episode, number, 0.0).unwrap();
            assert!(result.held(), "{}, episode {number} fell at {:?}", model.name, result.fell_at);
            result.carrying
        };
        (mean(0) + mean(1)) / 2.0
    };
    let (five, eight) = (carrying(&foot_human()), carrying(&toes_human()));
    println!("contact points that carry on a ball of 0.5 m: {five:.1} with five segments, {eight:.1} with single toes");
    assert!(eight > five, "{eight} is not more than {five}");
}
