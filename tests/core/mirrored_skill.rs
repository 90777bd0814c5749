//! A skill performed to the other side: the image of the motion, the same policy, and steering that curves both ways.

use bevy_athlete::cli::load_trained_skill;
use bevy_athlete::contact::World;
use bevy_athlete::control::tracking::{Heading, PolicyMirror, Tracker, mirror_links};
use bevy_athlete::model::{SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{Director, DirectorEvent, DirectorInput, SkillPlayer, TrainedSkill};
use glam::{DQuat, DVec3};
use std::sync::Arc;

fn skater() -> SharedModel {
    preset("skater").unwrap()
}

fn skill(name: &str) -> TrainedSkill {
    load_trained_skill(name, &skater()).unwrap()
}

/// Root places of a skill performed for some seconds from its start.
fn way(skill: TrainedSkill, seconds: f64) -> Vec<DVec3> {
    let model = skater();
    let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
    let mut player = SkillPlayer::new(Arc::new(skill), model.step_rate).unwrap();
    player.begin(&mut sim, Heading::ahead(), DVec3::ZERO, None);
    let world = World::ice();
    let steps = (seconds * model.step_rate) as usize;
    (0..steps)
        .map(|_| {
            player.drive(&mut sim, &world).unwrap();
            step(&mut sim, &world);
            player.after_step(&mut sim, &world);
            sim.state.root_position.lane(0)
        })
        .collect()
}

#[test]
fn a_policy_sees_the_image_of_the_body() {
    let model = skater();
    let (links, mirror) = (mirror_links(&model), PolicyMirror::of(&model));
    let (skill, image) = (skill("double_salchow"), skill("double_salchow").mirrored(&model));
    let mut worst = 0.0_f64;
    for tick in (0..skill.motion.last()).step_by(7) {
        let observe = |skill: &TrainedSkill, turn: DVec3, lean: f64| {
            let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
            let (motion, options) = (skill.motion.clone(), skill.definition.tracker_options());
            let mut tracker: Tracker<f64> = Tracker::new(motion, options, skill.layout.clone());
            tracker.begin(&mut sim, 0, tick, 2.0);
            // The body is not where the reference is.
            let rotation = DQuat::from_scaled_axis(turn) * sim.state.root_rotation.lane(0);
            let place = sim.state.root_position.lane(0) + DVec3::new(lean, 0.02, 0.1);
            let joints: Vec<DQuat> = sim.state.joints.iter().map(|j| j.rotation.lane(0)).collect();
            sim.state.set_pose(0, place, rotation, &joints);
            sim.state_changed();
            let mut seen = Vec::new();
            tracker.observe(&mut sim, &mut seen);
            seen
        };
        let plain = observe(&skill, DVec3::new(0.1, 0.2, -0.15), 0.05);
        let turned = observe(&image, DVec3::new(0.1, -0.2, 0.15), -0.05);
        let mut back = Vec::new();
        mirror.observation(&turned, &mut back);
        assert_eq!(plain.len(), back.len());
        for (a, b) in plain.iter().zip(&back) {
            worst = worst.max((a - f64::from(*b)).abs());
        }
    }
    println!("observations differ by {worst:.1e} at most (allowed 1e-5, single precision)");
    assert!(worst < 1e-5);
    // An action and its image's image are the same.
    let action: Vec<f32> = (0..3 * (model.links.len() - 1)).map(|k| k as f32 * 0.1 - 2.0).collect();
    let (mut twice, mut spare) = (action.clone(), Vec::new());
    mirror.action(&mut twice, &mut spare);
    assert_ne!(action, twice);
    mirror.action(&mut twice, &mut spare);
    assert_eq!(action, twice);
    assert!(links.iter().enumerate().all(|(i, &j)| links[j] == i));
}

#[test]
fn a_mirrored_crossover_curves_to_the_other_side() {
    let model = skater();
    let plain = way(skill("forward_crossover"), 4.0);
    let image = way(skill("forward_crossover").mirrored(&model), 4.0);
    let apart = plain.iter().zip(&image).map(|(a, b)| (DVec3::new(-a.x, a.y, a.z) - *b).length());
    let worst = apart.fold(0.0, f64::max);
    let (a, b) = (plain[plain.len() - 1], image[image.len() - 1]);
    println!("after 4 s at {a:.2} and {b:.2}; the image is off by {worst:.3} m at most (allowed 0.15)");
    // The solver goes through the contacts in one order, so the two are not the same to the bit.
    assert!(worst < 0.15);
    assert!(a.x < -1.0 && b.x > 1.0, "to the left, and to the right");
}

#[test]
fn mirrored_twice_it_is_the_skill_again() {
    let model = skater();
    let skill = skill("backward_crossover");
    let twice = skill.mirrored(&model).mirrored(&model);
    assert_eq!(twice.name(), "backward_crossover");
    assert!(twice.mirror.is_none());
    for k in 0..=skill.motion.last() {
        let (a, b) = (skill.motion.tick(k), twice.motion.tick(k));
        assert_eq!((a.com, a.travel, &a.pose), (b.com, b.travel, &b.pose));
    }
}

/// How a steered skater fared: what it performed, where it ended up going, and how low its pelvis came.
struct Steered {
    begun: Vec<String>,
    velocity: DVec3,
    lowest: f64,
}

/// Straight on for `wait` seconds, then across to one side.
fn steered(side: f64, wait: f64) -> Steered {
    let model = skater();
    let world = World::ice();
    let skills = ["stroking", "forward_crossover"].map(|name| Arc::new(skill(name))).to_vec();
    let mut player = Director::steering(skills, &model, model.step_rate).unwrap();
    let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
    player.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
    let wish = |direction: DVec3| DirectorInput { direction, speed: Some(2.5), ..DirectorInput::default() };
    player.set_input(wish(DVec3::NEG_Z));
    let mut found = Steered { begun: Vec::new(), velocity: DVec3::ZERO, lowest: f64::INFINITY };
    for k in 0..((wait + 12.0) * model.step_rate) as usize {
        if k as f64 > wait * model.step_rate {
            player.set_input(wish(DVec3::X * side));
        }
        player.drive(&mut sim, &world).unwrap();
        step(&mut sim, &world);
        player.after_step(&mut sim, &world);
        if let Some(DirectorEvent::Began(k)) = player.take_event() {
            found.begun.push(player.graph().skills()[k].name().to_owned());
        }
        found.lowest = found.lowest.min(sim.state.root_position.lane(0).y);
    }
    found.velocity = sim.state.root_velocity.linear.lane(0);
    found
}

/// Steered to either side at any moment, the skater crosses over to that side and ends up travelling where it was told to.
#[test]
fn steering_curves_both_ways() {
    for (side, name) in [(1.0, "forward_crossover_mirrored"), (-1.0, "forward_crossover")] {
        let (mut up, mut there, runs) = (0, 0, 16);
        for run in 0..runs {
            let found = steered(side, 2.0 + 0.11 * f64::from(run));
            let stands = found.lowest > 0.45;
            up += usize::from(stands);
            there += usize::from(stands && found.velocity.x * side > 1.0 && found.velocity.z.abs() < 1.2);
            assert!(found.begun.iter().any(|b| b == name), "{:?}", found.begun);
            println!(
                "side {side}, run {run}: {:?} {:.2} m/s, lowest {:.2} m",
                found.begun, found.velocity, found.lowest
            );
        }
        println!("side {side}: of {runs} runs {up} stay up, {there} go where they were told to");
        assert!(there >= 14, "side {side}: {there} of {runs}");
    }
}
