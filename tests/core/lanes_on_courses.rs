//! Contract: a character on a course whose solids move, with a hand that holds on to one of them, does not show its company either.
//!
//! Every lane has a course of its own at a time of its own. Lane k of a wide type has the bits of the scalar run, whoever is beside
//! it and in whatever order; and characters that go into lanes and out again, with others each time, have the bits of those that never
//! did. In [`lanes`](crate::lanes) the world is common to all lanes and at rest: a mix-up of the lanes' solids, of their times, or of the
//! anchors that go with them would show nowhere there.

use crate::common::{random_rotation, random_vector};
use crate::lanes::{place, walker};
use bevy_athlete::asset::{Course, CourseInstance};
use bevy_athlete::contact::{CourseTerrain, Terrain, World};
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::math::{F32x8, F64x4, RandomStream, Real};
use bevy_athlete::model::{JointKind, SharedModel};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// A rail that sways before the hands, a sill that comes and goes under the feet, a slab that rises and a box that is pushed past.
const COURSE: &str = r#"(
    name: "moving",
    parameters: [
        (name: "reach", range: (0.6, 1.0)),
        (name: "sway", range: (0.05, 0.3)),
        (name: "sill", range: (0.02, 0.1)),
        (name: "pace", range: (0.2, 0.7)),
    ],
    ground: (friction: 0.6),
    solids: [
        Rail(ahead: 0.1, up: "reach", length: 2, radius: 0.03, motion: Sway(along: (1, 1, 0), amplitude: "sway", frequency: 0.8)),
        Box(ahead: -0.2, depth: 0.5, width: 3, height: "sill", motion: Cross(by: (0, 0, "sway + 0.4"), speed: "pace")),
        Box(ahead: -0.9, depth: 0.6, width: 3, height: 0.1, motion: Jerk(by: (0, "sill", 0), start: 0.3, seconds: 0.9)),
        Box(ahead: 0.9, right: -1, depth: 0.5, width: 0.5, height: 1, motion: Cross(by: (2, 0, 0), speed: "pace")),
    ],
)"#;

/// The rail, as the terrain counts.
const RAIL: usize = 0;

fn course_of(index: u64) -> CourseInstance {
    let course = Course::parse("moving.course.ron", COURSE.as_bytes()).expect("a course");
    let mut values = course.defaults();
    course.draw(&mut RandomStream::new(8, index), &mut values);
    course.instance(&values, index).expect("a course")
}

/// A terrain whose lanes hold the courses of these characters, each at its own time.
fn terrain<R: Real>(indices: &[u64]) -> CourseTerrain<R> {
    let mut terrain = CourseTerrain::new(Arc::new(World::empty()), &course_of(indices[0]));
    for (lane, &index) in indices.iter().enumerate() {
        terrain.set_lane(lane, &course_of(index)).expect("one course");
        terrain.set_time(lane, 0.17 * index as f64);
    }
    terrain
}

/// Closes the hand of a lane about the rail where it is nearest, about a place in the air, or not at all.
fn hold<R: Real>(sim: &mut Simulator<R>, terrain: &CourseTerrain<R>, lane: usize, index: u64) {
    let hand = sim.grip_position(0, lane).expect("a hand");
    let rail = Terrain::<R>::anchor(terrain, lane, RAIL, DVec3::ZERO).expect("a rail").place;
    let along = DVec3::X * (hand.x - rail.x).clamp(-0.9, 0.9);
    match index % 4 {
        1 => {}
        3 => sim.hold(0, lane, GripAnchor::Fixed(hand + DVec3::Y * 0.05)),
        _ => sim.hold(0, lane, GripAnchor::Solid { solid: RAIL, place: along }),
    }
}

fn command<R: Real>(sim: &mut Simulator<R>, lane: usize, index: u64, k: usize) {
    let mut random = RandomStream::new(40 + k as u64, index);
    let model = sim.model().clone();
    for (command, link) in sim.commands.iter_mut().zip(&model.links).skip(1) {
        let target = match link.joint {
            JointKind::Hinge { axis } => DQuat::from_axis_angle(axis, random.range(-0.6, 0.6)),
            _ => random_rotation(&mut random, 0.3),
        };
        command.rotation.set_lane(lane, target);
    }
    // Somebody pulls: holding on is work.
    let push = random_vector(&mut random, 20.0);
    command_torque(sim, lane, push);
}

/// An extra torque at the first joint of a lane (outside forces are not carried into lanes).
fn command_torque<R: Real>(sim: &mut Simulator<R>, lane: usize, torque: DVec3) {
    sim.commands[1].torque.set_lane(lane, torque * 0.2);
}

/// What became of a character: fingerprints every 50 steps, steps with a hand on the rail, steps with contact.
#[derive(Clone, Debug, Default, PartialEq)]
struct Fate {
    prints: Vec<u64>,
    on_rail: usize,
    touching: usize,
    /// The step in which it went bad: what is torn at does, and its neighbours must not notice.
    bad: Option<usize>,
}

const STEPS: usize = 900;

/// The fates of these characters, side by side.
fn run<R: Real>(model: &SharedModel, indices: &[u64]) -> Vec<Fate> {
    assert_eq!(indices.len(), R::LANES);
    let mut terrain = terrain::<R>(indices);
    let mut sim = Simulator::<R>::new(model.clone(), SimulationSettings::of(model));
    for (lane, &index) in indices.iter().enumerate() {
        place(&mut sim, lane, index % 5);
    }
    for (lane, &index) in indices.iter().enumerate() {
        hold(&mut sim, &terrain, lane, index);
    }
    let mut fates = vec![Fate::default(); R::LANES];
    for k in 0..STEPS {
        for (lane, &index) in indices.iter().enumerate() {
            if k % 50 == 0 {
                command(&mut sim, lane, index, k);
                if fates[lane].bad.is_none() {
                    fates[lane].prints.push(sim.state.fingerprint(lane));
                }
            }
            if k == 2 * STEPS / 3 {
                // Let go, and hold on again at once, elsewhere.
                sim.release(0, lane);
                hold(&mut sim, &terrain, lane, index + 1);
            }
        }
        step(&mut sim, &terrain);
        terrain.advance(sim.step_seconds());
        for (lane, fate) in fates.iter_mut().enumerate() {
            if fate.bad.is_some() || !sim.is_sane(lane) {
                fate.bad = fate.bad.or(Some(k));
                continue;
            }
            fate.touching += usize::from(sim.loaded_points(lane) > 0);
            fate.on_rail += usize::from(matches!(sim.state.anchor(0, lane), Some(GripAnchor::Solid { .. })));
        }
    }
    for (lane, fate) in fates.iter_mut().enumerate() {
        if fate.bad.is_none() {
            fate.prints.push(sim.state.fingerprint(lane));
        }
    }
    fates
}

fn company_does_not_show<W: Real, S: Real>(groups: &[&[u64]]) {
    let model: SharedModel = Arc::new(walker());
    let alone: Vec<Fate> = (0..9).map(|index| run::<S>(&model, &[index]).remove(0)).collect();
    for (index, fate) in alone.iter().enumerate() {
        println!("{index} in {}: {} steps on the rail, {} with contact", S::NAME, fate.on_rail, fate.touching);
    }
    assert!(alone.iter().filter(|f| f.on_rail > STEPS / 4).count() >= 3, "hardly anybody holds on");
    assert!(alone.iter().filter(|f| f.on_rail > 0 && f.on_rail < STEPS).count() >= 3, "hands open and close");
    assert!(alone.iter().filter(|f| f.touching > STEPS / 4).count() >= 5, "hardly any contact");
    for group in groups {
        for (fate, &index) in run::<W>(&model, group).iter().zip(*group) {
            let own = &alone[index as usize];
            let differing = fate.prints.iter().zip(&own.prints).filter(|(a, b)| a != b).count();
            assert!(fate == own, "{index} among {group:?}: {differing} of {} fingerprints", own.prints.len());
        }
    }
}

#[test]
fn four_lanes_have_the_bits_of_scalar_runs_in_any_company() {
    company_does_not_show::<F64x4, f64>(&[&[0, 1, 2, 3], &[3, 1, 0, 2], &[4, 4, 0, 8], &[7, 6, 5, 2]]);
}

#[test]
fn eight_lanes_have_the_bits_of_scalar_runs_in_any_company() {
    company_does_not_show::<F32x8, f32>(&[&[0, 1, 2, 3, 4, 5, 6, 7], &[8, 6, 4, 2, 0, 7, 7, 1]]);
}

/// Six characters of whom four at a time are in lanes, others each time, and the other two alone: nobody's bits show it.
#[test]
fn groups_that_change_all_the_time_do_not_show() {
    let model: SharedModel = Arc::new(walker());
    let new = |index: u64| {
        let own = terrain::<f64>(&[index]);
        let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
        place(&mut sim, 0, index);
        sim.friction_scale = 0.6 + 0.1 * index as f64;
        hold(&mut sim, &own, 0, index);
        (sim, own)
    };
    let mut alone: Vec<_> = (0..6).map(new).collect();
    let mut guests: Vec<_> = (0..6).map(new).collect();
    let mut lanes = Simulator::<F64x4>::new(model.clone(), SimulationSettings::of(&model));
    let mut random = RandomStream::new(77, 0);
    let mut held = 0;
    for visit in 0..30 {
        for (k, (sim, _)) in alone.iter_mut().chain(&mut guests).enumerate() {
            command(sim, 0, k as u64 % 6, visit);
        }
        let mut order: Vec<usize> = (0..6).collect();
        (1..6).for_each(|k| order.swap(k, random.below(k + 1)));
        let (together, rest) = order.split_at(4);
        let indices: Vec<u64> = together.iter().map(|k| *k as u64).collect();
        let mut common = terrain::<F64x4>(&indices);
        for (lane, &k) in together.iter().enumerate() {
            common.set_time(lane, guests[k].1.time(0));
            lanes.put_lane(lane, &guests[k].0, 0);
        }
        let h = lanes.step_seconds();
        for _ in 0..19 {
            step(&mut lanes, &common);
            common.advance(h);
            for (sim, own) in &mut alone {
                step(sim, &*own);
                own.advance(h);
            }
            for &k in rest {
                let (sim, own) = &mut guests[k];
                step(sim, &*own);
                own.advance(h);
            }
        }
        for (lane, &k) in together.iter().enumerate() {
            guests[k].0.take_lane(&lanes, lane);
            guests[k].1.set_time(0, common.time(lane));
        }
        for (k, ((guest, at), (own, there))) in guests.iter().zip(&alone).enumerate() {
            assert_eq!(at.time(0).to_bits(), there.time(0).to_bits());
            assert_eq!(guest.state.fingerprint(0), own.state.fingerprint(0), "{k}, visit {visit}");
            assert_eq!(guest.state.anchor(0, 0), own.state.anchor(0, 0));
            held += usize::from(own.state.anchor(0, 0).is_some());
        }
    }
    println!("{held} of 180 times a hand held on to something");
    assert!(held > 60);
}
