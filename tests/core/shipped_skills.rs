//! The skills that come with the crate: every file fits the others, cards are of the policies beside them, and what a card
//! claims is found again on other trials. In the air nothing but gravity acts, and no force from outside helps.

use crate::seen_momentum::Picture;
use bevy_athlete::asset::card::RobustnessCard;
use bevy_athlete::cli::{PerformOptions, Script, find_skill, load_task, load_trained_skill, perform};
use bevy_athlete::contact::World;
use bevy_athlete::control::tracking::Heading;
use bevy_athlete::control::{Policy, ReconstructedControl};
use bevy_athlete::math::F32x8;
use bevy_athlete::model::{KeyPoses, Objective, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{SKATING_SKILLS, SkillDefinition, SkillPlayer};
use bevy_athlete::train::optimize::{Plan, PlannedWindow};
use bevy_athlete::train::ppo::evaluate;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The names of all skills that ship.
fn shipped() -> Vec<String> {
    let folders = |path: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(path).unwrap().map(|e| e.unwrap().path());
        entries.filter(|p| p.is_dir()).collect()
    };
    let skills = folders(Path::new("assets/skills")).into_iter().flat_map(|family| folders(&family));
    let mut names: Vec<String> = skills.map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn every_file_fits_the_others() {
    let all = shipped();
    assert!(SKATING_SKILLS.iter().all(|name| all.iter().any(|n| n == name)), "{all:?}");
    for name in &all {
        let file = find_skill(name).unwrap();
        let character = SkillDefinition::load(&file).unwrap().character;
        let model = preset(&character).unwrap();
        let skill = load_trained_skill(name, &model).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(skill.name(), name);
        let card = RobustnessCard::load(file.with_file_name("card.json")).unwrap();
        let policy = Policy::load(file.with_file_name("policy.onnx")).unwrap();
        assert_eq!(card.policy, policy.fingerprint(), "{name}: the card is of another policy");
        assert_eq!(card.skill, *name);
        let rows: Vec<&str> = skill.definition.trial.rows.iter().map(|r| r.name.as_str()).collect();
        let rows = if rows.is_empty() { vec!["unpushed"] } else { rows };
        assert_eq!(card.rows.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), rows, "{name}: rows of the card");
    }
}

/// Each of the paper's skills can be optimised: two windows or more from end to end, a blade on the ice in at least half of them.
#[test]
fn every_skill_has_windows_to_optimise() {
    let model = preset("skater").unwrap();
    for name in SKATING_SKILLS {
        let file = find_skill(name).unwrap().with_file_name(format!("{name}.keyposes.ron"));
        let poses = KeyPoses::load(&file).unwrap();
        assert!(poses.windows.len() >= 2, "{name}: {} windows", poses.windows.len());
        let plan = Plan::new(&poses, &model).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!((plan.seconds() - plan.clip.duration()).abs() < 0.02, "{name}: {} s of windows", plan.seconds());
        let on_ice = |w: &PlannedWindow| w.objectives.iter().any(|o| matches!(o, Objective::BladeOnGround { .. }));
        let down = plan.windows.iter().filter(|w| on_ice(w)).count();
        assert!(down >= plan.windows.len() / 2 && down > 0, "{name}: {down} of {} windows", plan.windows.len());
    }
}

/// Each row within what chance allows for its few trials, and all rows together within what chance allows for their sum: a row
/// alone would let a policy that fails a tenth more often pass.
#[test]
fn what_a_card_claims_is_found_again() {
    let model = preset("skater").unwrap();
    // Trials that went well, those that the cards promise, and the variance of that promise.
    let (mut well, mut promised, mut variance) = (0.0, 0.0, 0.0);
    for name in SKATING_SKILLS {
        let file = find_skill(name).unwrap();
        let mut skill = SkillDefinition::load(&file).unwrap();
        skill.after.clear();
        let task = load_task(&skill, None).unwrap().at_rate(model.step_rate).unwrap();
        let policy = Policy::load(file.with_file_name("policy.onnx")).unwrap();
        let card = RobustnessCard::load(file.with_file_name("card.json")).unwrap();
        // The first row and the last.
        let rows = task.trials().unwrap();
        for ((label, row), claim) in rows.iter().zip(&card.rows) {
            if label != &rows[0].0 && label != &rows[rows.len() - 1].0 {
                continue;
            }
            let found = evaluate::<F32x8, _>(row, &policy, 48, 20_260_729, 2);
            let sigma = (claim.rate() * (1.0 - claim.rate()) / found.trials as f64).sqrt().max(0.02);
            println!("{name}, {label}: {:.1} %, the card says {:.1} %", 100.0 * found.survival(), 100.0 * claim.rate());
            let away = (found.survival() - claim.rate()).abs();
            assert!(away < 4.0 * sigma, "{name}, {label}: {} against {}", found.survival(), claim.rate());
            let trials = found.trials as f64;
            well += found.survival() * trials;
            promised += claim.rate() * trials;
            // A claim is itself an estimate, of so many trials.
            variance += trials * claim.rate() * (1.0 - claim.rate()) * (1.0 + trials / claim.trials as f64);
        }
    }
    let allowed = 3.0 * f64::max(variance, 1.0).sqrt();
    println!("all rows: {well} trials went well, the cards say {promised:.1}, {allowed:.1} more or fewer are allowed");
    assert!((well - promised).abs() < allowed, "{well} against {promised:.1}");
}

#[test]
fn nothing_helps_the_jump() {
    let model = preset("skater").unwrap();
    let skill = Arc::new(load_trained_skill("double_salchow", &model).unwrap());
    let mut player = SkillPlayer::new(skill, model.step_rate).unwrap();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    player.begin(&mut sim, Heading::ahead(), DVec3::ZERO, None);
    let (world, mass) = (World::ice(), model.mass());
    let gravity = SimulationSettings::of(&model).gravity;
    let (mut flight, mut off_path, mut off_spin) = (0, 0.0_f64, 0.0_f64);
    let seconds = 1.0 / model.step_rate;
    let (mut seen, mut before) = (Picture::of(&mut sim), None);
    while !player.is_finished() {
        player.drive(&mut sim, &world).unwrap();
        step(&mut sim, &world);
        player.after_step(&mut sim, &world);
        assert!(sim.external.is_empty(), "a force from outside");
        let touching = (0..model.contact_points.len()).any(|p| sim.contact_force(p, 0) != DVec3::ZERO);
        let picture = Picture::of(&mut sim);
        let now = seen.momentum(&picture, &model, seconds);
        if let (false, Some((linear, angular))) = (touching, before) {
            let (linear, angular): (DVec3, DVec3) = (linear, angular);
            flight += 1;
            off_path = off_path.max((now.linear - linear - gravity * (mass * seconds)).length() / (mass * 9.81));
            off_spin = off_spin.max((now.angular - angular).length() / angular.length());
        }
        // Linear momentum of the step before, angular momentum of the first in the air.
        before = (!touching).then_some((now.linear, before.map_or(now.angular, |(_, angular)| angular)));
        seen = picture;
    }
    println!(
        "{flight} steps in the air, weight off by {off_path:.1e} of it and a step, angular momentum by {off_spin:.1e} of it"
    );
    assert!(flight > 400, "{flight} steps in the air at {} steps per second", model.step_rate);
    assert!(off_path < 1e-9 && off_spin < 0.04, "{off_path}, {off_spin}");
}

/// What the demo begins with is open loop: it follows the physics that it was searched on and no other.
#[test]
fn the_control_of_the_demo_replays_without_a_fall() {
    let control = ReconstructedControl::load("assets/skills/skating/stroking/stroking.control.ron").unwrap();
    let model = preset("skater").unwrap();
    let settings = SimulationSettings { rate: control.rate, ..SimulationSettings::of(&model) };
    let options = PerformOptions { settings, seconds: None, kp: None, kd: None, pushes: Vec::new() };
    let script = Script::Control(Box::new(control));
    let report = perform(&model, &World::ice(), &script, &options, |_, _| Ok(())).unwrap();
    println!("root {:.3} m, joints {:.1} degrees", report.worst_root_m, report.mean_joint_deg);
    assert!(report.fell_at.is_none() && report.worst_root_m < 0.3 && report.mean_joint_deg < 15.0, "{report:?}");
}
