//! Contract: the balance controller stands, by torques alone, and what it is made of is what it says.
//!
//! The programme of forces is judged by its own optimum: no other forces inside the cones come nearer to the wish. Inverse dynamics
//! under outside wrenches is judged by the transposed Jacobian. Standing is judged in the simulator with torque limits, joint limits
//! and self-collision on, from disturbed joints: a sign, a frame or a stale force shows as a fall within a second.

use crate::counting_allocator::allocations;
use bevy_athlete::asset::{StateReader, StateWriter};
use bevy_athlete::cli::feet::{Disturbance, Episode, FeetBody, StancePose, run_episode, watch_episode};
use bevy_athlete::contact::World;
use bevy_athlete::control::balance::{
    AnkleStance, Balance, BalanceError, BalanceSettings, ConeForces, ForceWeights, Hull, StanceError, SupportPoint,
};
use bevy_athlete::control::foot::{BasicPose, SegmentSet};
use bevy_athlete::dynamics::{
    InverseDynamics, LinkConstants, degrees_of_freedom, inverse_dynamics, inverse_dynamics_into, point_jacobian,
};
use bevy_athlete::math::{Force, Motion, RandomStream, Vec3};
use bevy_athlete::model::foot_human;
use bevy_athlete::sim::{ExternalForce, SimulationSettings, Simulator, step};
use glam::{DQuat, DVec2, DVec3};

/// Eight points of two soles, on ground tilted about x by `tilt`.
fn soles(tilt: f64) -> Vec<SupportPoint> {
    let turn = DQuat::from_rotation_x(tilt);
    let normal = turn * DVec3::Y;
    let mut points = Vec::new();
    for x in [-0.11, -0.04, 0.04, 0.11] {
        for z in [-0.16, 0.04] {
            points.push(SupportPoint {
                link: 0,
                index: points.len(),
                place: turn * DVec3::new(x, -0.8, z),
                normal,
                share: 1.0,
            });
        }
    }
    points
}

/// The mean place.
fn middle(points: &[SupportPoint]) -> DVec3 {
    points.iter().map(|p| p.place).sum::<DVec3>() / points.len() as f64
}

/// Random forces inside the pyramid that the programme uses, N.
fn inside(points: &[SupportPoint], friction: f64, size: f64, random: &mut RandomStream) -> Vec<DVec3> {
    let one = |p: &SupportPoint| {
        let aside = if p.normal.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
        let u = (aside - p.normal * aside.dot(p.normal)).normalize();
        let v = p.normal.cross(u);
        let edges = [u, v, -u, -v].map(|e| (p.normal + e * friction) * random.range(0.0, size));
        edges.iter().sum()
    };
    points.iter().map(one).collect()
}

#[test]
fn no_other_forces_in_the_cones_come_nearer() {
    let mut random = RandomStream::new(20, 2);
    let weights = ForceWeights { force: 1.0, upward: 1.0, moment: 0.05 };
    let mut most_steps = 0;
    for case in 0..200 {
        let points = soles(random.range(-0.3, 0.3));
        let friction = random.range(0.2, 1.0);
        let mut programme = ConeForces::new(points.len());
        points.iter().for_each(|p| programme.push(*p));
        programme.build(friction, 0.0, middle(&points));
        let force = DVec3::new(random.normal() * 150.0, random.range(-100.0, 900.0), random.normal() * 150.0);
        let moment = DVec3::new(random.normal(), random.normal(), random.normal()) * 80.0;
        let (got, turned) = programme.solve(force, moment, weights);
        most_steps = most_steps.max(programme.steps());
        let found: Vec<DVec3> = programme.forces().map(|(_, f)| f).collect();
        let middle = programme.middle();
        let score = |forces: &[DVec3]| {
            let f: DVec3 = forces.iter().sum();
            let m: DVec3 = points.iter().zip(forces).map(|(p, f)| (p.place - middle).cross(*f)).sum();
            weights.force * (f - force).length_squared() + weights.moment * (m - moment).length_squared()
        };
        let sum: DVec3 = found.iter().sum();
        assert!((sum - got).length() < 1e-9 * (1.0 + got.length()), "{case}: {sum} is not {got}");
        for (p, f) in points.iter().zip(&found) {
            let along = f.dot(p.normal);
            assert!(
                along >= 0.0 && (*f - p.normal * along).length() <= friction * along + 1e-9,
                "{case}: {f} leaves the cone"
            );
        }
        let best = score(&found);
        // The weight of the factors themselves is worth this much at most.
        let slack = 1e-5 * 4.0 * found.iter().map(|f| f.length_squared()).sum::<f64>() + 1e-6;
        for _ in 0..50 {
            let size = random.range(0.1, 60.0);
            let other = inside(&points, friction, size, &mut random);
            let part = random.range(0.0, 1.0).powi(3);
            let mixed: Vec<DVec3> = found.iter().zip(&other).map(|(a, b)| *a * (1.0 - part) + *b * part).collect();
            assert!(score(&mixed) > best - slack, "{case}: {} beats {best}", score(&mixed));
        }
        let _ = turned;
    }
    println!("most Newton steps: {most_steps}");
    assert!(most_steps < 40);
}

#[test]
fn a_wish_that_the_cones_can_give_is_given() {
    let points = soles(0.1);
    let mut programme = ConeForces::new(points.len());
    points.iter().for_each(|p| programme.push(*p));
    programme.build(0.6, 0.0, middle(&points));
    let mut random = RandomStream::new(20, 3);
    let wished = inside(&points, 0.5, 30.0, &mut random);
    let force: DVec3 = wished.iter().sum();
    let moment: DVec3 = points.iter().zip(&wished).map(|(p, f)| (p.place - programme.middle()).cross(*f)).sum();
    let (got, turned) = programme.solve(force, moment, ForceWeights { force: 1.0, upward: 1.0, moment: 0.05 });
    assert!((got - force).length() < 0.05 && (turned - moment).length() < 0.5, "{got} {turned} of {force} {moment}");
    // Pulling is not given.
    let (got, _) =
        programme.solve(DVec3::Y * -100.0, DVec3::ZERO, ForceWeights { force: 1.0, upward: 1.0, moment: 0.05 });
    assert!(got.length() < 1e-6, "{got}");
}

#[test]
fn the_hull_has_the_middle_and_the_nearest_point_of_a_rectangle() {
    let corners = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.2), (0.0, 0.2)].map(|(x, y)| DVec2::new(x, y));
    let inner = [DVec2::new(0.1, 0.1), DVec2::new(0.2, 0.05), DVec2::new(0.15, 0.0)];
    let hull = Hull::of(inner.into_iter().chain(corners));
    assert_eq!(hull.corners().len(), 4, "{:?}", hull.corners());
    assert!((hull.middle().unwrap() - DVec2::new(0.15, 0.1)).length() < 1e-12);
    assert_eq!(hull.nearest(DVec2::new(0.1, 0.1), 0.0), Some(DVec2::new(0.1, 0.1)));
    assert!((hull.nearest(DVec2::new(0.5, 0.1), 0.0).unwrap() - DVec2::new(0.3, 0.1)).length() < 1e-12);
    assert!((hull.nearest(DVec2::new(0.5, 0.5), 0.5).unwrap() - DVec2::new(0.225, 0.15)).length() < 1e-12);
    assert!(Hull::of(std::iter::empty()).middle().is_none());
}

#[test]
fn outside_wrenches_take_their_part_of_the_torques() {
    let model = foot_human();
    let constants = LinkConstants::<f64>::of(&model);
    let mut random = RandomStream::new(20, 4);
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut three = |size: f64| DVec3::new(random.normal(), random.normal(), random.normal()) * size;
    for joint in sim.state.joints.iter_mut().skip(1) {
        joint.rotation.set_lane(0, DQuat::from_scaled_axis(three(0.3)));
        joint.velocity = Vec3::splat(three(1.0));
    }
    sim.state_changed();
    let links = sim.kinematics().to_vec();
    let root = Motion { angular: Vec3::splat(three(2.0)), linear: Vec3::splat(three(2.0)) };
    let joints: Vec<Vec3<f64>> = (0..links.len()).map(|_| Vec3::splat(three(3.0))).collect();
    let gravity = Vec3::splat(DVec3::Y * -9.81);
    let (link, place, force) = (model.link_index("heel_left").unwrap(), three(0.05), three(200.0));
    let mut external = vec![Force::zero(); links.len()];
    let arm = links[link].rotation.mul_vec(Vec3::splat(place));
    external[link] = Force::at(arm, Vec3::splat(force));
    let (wrench, free) = inverse_dynamics(&constants, &links, root, &joints, gravity);
    let mut work = InverseDynamics::new(links.len());
    inverse_dynamics_into(&constants, &links, root, &joints, gravity, &external, &mut work);
    let mut columns = vec![Vec3::zero(); degrees_of_freedom(&constants)];
    point_jacobian(&constants, &links, link, Vec3::splat(place), &mut columns);
    let part = |dof: usize| columns[dof].lane(0).dot(force);
    for k in 0..3 {
        let given = wrench.force.lane(0)[k] - work.root().force.lane(0)[k];
        assert!((given - part(k)).abs() < 1e-9 * force.length(), "root {k}: {given} is not {}", part(k));
    }
    for (i, alone) in free.iter().enumerate().skip(1) {
        for k in 0..3 {
            let given = alone.lane(0)[k] - work.torques()[i].lane(0)[k];
            assert!((given - part(3 + 3 * i + k)).abs() < 1e-9 * force.length(), "{i} {k}: {given}");
        }
    }
}

#[test]
fn all_three_feet_stand() {
    for body in FeetBody::ALL {
        let model = body.model();
        let episode = Episode { friction: (0.6, 1.0), ..Episode::standing(Disturbance::None, 6.0) };
        let result = run_episode(&model, &episode, 1, 0.0).unwrap();
        assert!(result.held(), "{} fell at {:?}", model.name, result.fell_at);
        println!("{}: controller {:.4} s, all {:.4} s for a second", model.name, result.cost.0, result.cost.1);
    }
}

#[test]
fn disturbed_starts_stand_where_points_come_down_one_by_one() {
    // Of these starts, the first fell before 0.6 s, thrown over the one toe that touches first.
    let model = foot_human();
    let episode = Episode { friction: (0.6, 1.0), ..Episode::standing(Disturbance::None, 3.0) };
    for number in [4, 19, 22, 34] {
        let result = run_episode(&model, &episode, number, 0.0).unwrap();
        assert!(result.held(), "episode {number} fell at {:?}", result.fell_at);
    }
}

#[test]
fn poses_are_taken_and_left_again() {
    let model = foot_human();
    for stance in [StancePose::Basic(BasicPose::Tiptoe), StancePose::OneLeg(0), StancePose::OneLeg(1)] {
        let episode = Episode { stance, returns: true, ..Episode::standing(Disturbance::None, 10.0) };
        let mut in_pose = 0.0_f64;
        let result = watch_episode(&model, &episode, 2, 0.0, &mut |sim, balance| {
            // Between 4 s and 7 s no segment carries but those of the pose.
            if (4.0..7.0).contains(&sim.state.time) {
                for (f, foot) in balance.feet().enumerate() {
                    for (k, segment) in foot.segments().iter().enumerate() {
                        if !balance.touch(f).contains(k) {
                            let load: f64 = segment.points.iter().map(|p| sim.contact_force(p.2, 0).length()).sum();
                            in_pose = in_pose.max(load);
                        }
                    }
                }
            }
        });
        let result = result.unwrap();
        assert!(result.held(), "{stance:?} fell at {:?}", result.fell_at);
        assert!(in_pose < 1.0, "{stance:?}: {in_pose} N on segments that shall not touch");
    }
}

#[test]
fn a_small_push_is_held_and_a_large_one_is_not() {
    let model = foot_human();
    let push = |force: f64| Disturbance::Push { force, toward: DVec3::Z };
    let small = run_episode(&model, &Episode::standing(push(25.0), 6.0), 3, 0.0).unwrap();
    assert!(small.held(), "fell at {:?}", small.fell_at);
    // Far beyond what any centre of pressure in the sole can catch.
    let large = run_episode(&model, &Episode::standing(push(400.0), 6.0), 3, 0.0).unwrap();
    assert!(!large.held());
}

/// A controller that is written and read again goes on for so many steps as the one that it was; bytes that end early are refused.
fn goes_on_the_same(sim: &mut Simulator<f64>, balance: &mut Balance, world: &World, steps: usize) {
    let mut out = StateWriter::default();
    balance.write_state(&mut out);
    let bytes = out.finish();
    let mut other = Balance::new(sim.model(), BalanceSettings::default()).unwrap();
    let mut from = StateReader::new(&bytes);
    other.read_state(&mut from).unwrap();
    from.end().unwrap();
    let mut twin = sim.clone();
    for _ in 0..steps {
        balance.tick(sim, world);
        step(sim, world);
        other.tick(&mut twin, world);
        step(&mut twin, world);
    }
    assert_eq!(sim.state.fingerprint(0), twin.state.fingerprint(0));
    assert_eq!(balance.steps_taken(), other.steps_taken());
    assert!(other.read_state(&mut StateReader::new(&bytes[..bytes.len() - 1])).is_err());
}

#[test]
fn a_state_goes_on_with_the_same_bits() {
    let model = foot_human();
    let world = World::ground();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut balance = Balance::new(&model, BalanceSettings::default()).unwrap();
    balance.begin(&mut sim, &world);
    let stance = balance.one_leg(1).unwrap();
    for k in 0..1003 {
        if k == 400 {
            balance.assume(stance.clone()).unwrap();
        }
        balance.tick(&mut sim, &world);
        step(&mut sim, &world);
    }
    // In the middle of a decision, on the way to another stance.
    goes_on_the_same(&mut sim, &mut balance, &world, 200);
}

#[test]
fn a_step_catches_what_standing_does_not() {
    let model = foot_human();
    for toward in [DVec3::Z, DVec3::NEG_Z] {
        let standing = Episode::standing(Disturbance::Push { force: 90.0, toward }, 6.0);
        let settings = BalanceSettings { steps: 3, ..standing.settings };
        let held = |episode: &Episode| {
            (0..4).filter(|number| run_episode(&model, episode, *number, 0.0).unwrap().held()).count()
        };
        assert_eq!(held(&standing), 0, "{toward}");
        assert!(held(&Episode { settings, ..standing }) >= 3, "{toward}");
    }
}

#[test]
fn a_state_in_the_middle_of_a_step_goes_on_with_the_same_bits() {
    let model = foot_human();
    let world = World::ground();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut balance = Balance::new(&model, BalanceSettings::default()).unwrap();
    balance.begin(&mut sim, &world);
    let link = model.trunk();
    let push = ExternalForce {
        link,
        position: Vec3::<f64>::splat(model.links[link].com),
        force: Vec3::<f64>::splat(DVec3::Z * 90.0),
    };
    let mut since = 0;
    for k in 0.. {
        assert!(k < 8000, "no step was taken");
        sim.external.clear();
        if (1800..2500).contains(&k) {
            sim.external.push(push);
        }
        balance.tick(&mut sim, &world);
        step(&mut sim, &world);
        since += usize::from(balance.steps_taken() > 0);
        if since == 40 {
            break;
        }
    }
    goes_on_the_same(&mut sim, &mut balance, &world, 600);
}

#[test]
fn a_tick_does_not_allocate_and_says_what_does_not_fit() {
    let model = foot_human();
    let world = World::ground();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut balance = Balance::new(&model, BalanceSettings::default()).unwrap();
    balance.begin(&mut sim, &world);
    for _ in 0..100 {
        balance.tick(&mut sim, &world);
        step(&mut sim, &world);
    }
    let before = allocations();
    for _ in 0..100 {
        balance.tick(&mut sim, &world);
        step(&mut sim, &world);
    }
    assert_eq!(allocations(), before);
    assert!(balance.probe().residual < 5.0, "forces and accelerations disagree by {}", balance.probe().residual);

    let mut stance = balance.one_leg(0).unwrap();
    stance.feet.pop();
    let error = balance.assume(stance).unwrap_err();
    assert!(matches!(error, BalanceError::Stance { found: 1, expected: 2, .. }), "{error}");
}

/// What can be asked of each foot alone gives the stances that have names, and what nobody can stand on is refused by name.
#[test]
fn stances_are_what_their_feet_are_asked() {
    let balance = Balance::new(&foot_human(), BalanceSettings::default()).unwrap();
    let named = BasicPose::ALL.map(|pose| balance.basic(pose).unwrap());
    for stance in named.into_iter().chain([0, 1].map(|foot| balance.one_leg(foot).unwrap())) {
        assert_eq!(balance.asked(&stance.feet).unwrap(), stance);
    }
    let whole = balance.basic(BasicPose::Rest).unwrap().feet[0];
    let with = |touch, rise, roll| balance.asked(&[whole, AnkleStance { touch, rise, roll }]);
    let found = |result: Result<_, BalanceError>| match result {
        Err(BalanceError::Asked(error)) => error,
        other => panic!("{other:?}"),
    };
    assert!(with(SegmentSet::NONE, 0.0, 0.0).is_ok(), "a foot in the air");
    let beyond = found(with(SegmentSet::of(&[7]), 0.0, 0.0));
    assert!(matches!(beyond, StanceError::Segment { foot: 1, segment: 7, .. }), "{beyond}");
    assert!(beyond.to_string().contains("heel_right"), "{beyond}");
    for (rise, roll) in [(f64::NAN, 0.0), (0.2, 0.0), (-0.01, 0.0), (0.0, 0.5)] {
        let error = found(with(whole.touch, rise, roll));
        assert!(matches!(error, StanceError::Ankle { foot: 1, .. }), "{error}");
    }
    let air = AnkleStance::default();
    assert_eq!(found(balance.asked(&[air, air])), StanceError::NothingTouches);
    assert_eq!(found(balance.asked(&[whole])), StanceError::Feet { found: 1, expected: 2 });
}
