//! A family that nobody planned for, made of what there is: a one-legged hopper that comes hopping and goes up a step of any height
//! from 0.05 to 0.2 m. Everything that it needs lies in this folder; see `tests/families/README.md`.
//!
//! Proves: the files fit each other through the public API; both policies that lie here, a network and one matrix with an offset, do what
//! was measured of them on trials that nobody has tried before, and more than the motion does alone; both kinds of training run from
//! the files. No source file of the crate knows the family.

use bevy_athlete::asset::card::RobustnessCard;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::{Character, Course};
use bevy_athlete::cli::{load_task, load_trained_skill};
use bevy_athlete::contact::{CourseTerrain, World};
use bevy_athlete::control::Policy;
use bevy_athlete::control::tracking::Heading;
use bevy_athlete::math::F32x8;
use bevy_athlete::model::{CharacterModel, FootKind, KeyPoses, SharedModel};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{SkillDefinition, SkillPlayer};
use bevy_athlete::train::ppo::{Actor, SkillTask, TrainOptions, Trainer, evaluate, trained_policy};
use bevy_athlete::train::{AffineOptions, AffineSearch, policy_bytes};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The two skills, and the least part of fresh trials that has to count: the card's figure less what chance allows.
const SKILLS: [(&str, f64); 2] = [("hop_up", 0.9), ("hop_up_affine", 0.75)];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/families/hopper").join(name)
}

fn skill_file(skill: &str) -> PathBuf {
    file(skill).join(format!("{skill}.skill.ron"))
}

fn hopper() -> SharedModel {
    Arc::new(CharacterModel::build(&Character::read(file("hopper.character.ron")).unwrap()).unwrap())
}

fn task(skill: &str) -> SkillTask {
    load_task(&SkillDefinition::load(skill_file(skill)).unwrap(), None).unwrap()
}

/// A policy that never says anything.
struct Nothing;

impl Actor for Nothing {
    type Scratch = Vec<f32>;
    fn act<'a>(&'a self, scratch: &'a mut Vec<f32>, _: &'a mut [f32], rows: usize) -> &'a [f32] {
        scratch.resize(rows * 9, 0.0);
        scratch
    }
}

#[test]
fn every_file_fits_the_others() {
    let model = hopper();
    let [foot] = model.feet() else { panic!("{} feet", model.feet().len()) };
    assert!(foot.side.is_none() && foot.kind == FootKind::Sole, "one foot, in the middle of the body");
    let clip = KeyPoses::load(file("hop_up.keyposes.ron")).unwrap().to_clip(&model).unwrap();
    assert_eq!(clip.joints, ["thigh", "shank", "foot"]);
    assert_eq!(MotionClip::load(file("hop_up.clip.ron")).unwrap().joints, clip.joints);
    let course = Course::read(file("step.course.ron")).unwrap();
    for (name, _) in SKILLS {
        let skill = load_trained_skill(&skill_file(name).to_string_lossy(), &model).unwrap();
        let parameter = &skill.definition.parameters[0];
        let (low, high) = course.parameters[0].range;
        assert!(parameter.name == "height" && low <= parameter.range.0 && parameter.range.1 <= high);
        // The motion knows that it ends on the step it was written for.
        let (first, last) = (skill.motion.tick(0), skill.motion.tick(skill.motion.last()));
        assert_eq!((first.support, last.support), (0.0, skill.definition.warps[0].neutral), "{name}");
        let card = RobustnessCard::load(file(name).join("card.json")).unwrap();
        assert_eq!(card.policy, skill.policy.fingerprint(), "{name}: the card is of another policy");
        let size = std::fs::metadata(file(name).join("policy.onnx")).unwrap().len();
        assert!(size < 60_000, "{name}: {size} bytes");
    }
}

#[test]
fn no_source_file_knows_the_family() {
    fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                sources(&entry, found);
            } else if entry.extension().is_some_and(|e| e == "rs") {
                found.push(entry);
            }
        }
    }
    let mut files = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 100);
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap().to_lowercase();
        assert!(!text.contains("hopper") && !text.contains("hop_up"), "{}", file.display());
    }
}

#[test]
fn the_policies_that_lie_here_hop_onto_steps() {
    for (name, least) in SKILLS {
        let task = task(name).at_play_rate().unwrap();
        let policy = Policy::load(file(name).join("policy.onnx")).unwrap();
        let (_, trials) = task.trials().unwrap().remove(0);
        let found = evaluate::<F32x8, _>(&trials, &policy, 40, 20_261_130, 2);
        let without = evaluate::<F32x8, _>(&trials, &Nothing, 24, 20_261_130, 2);
        println!(
            "{name}: {:.1} %, {:?}; without a policy {:.1} %",
            100.0 * found.survival(),
            found.shortfalls,
            100.0 * without.survival()
        );
        assert!(found.survival() >= least, "{name}: {} of {}", found.survived, found.trials);
        let helps = found.survival() - without.survival();
        assert!(helps > 0.15, "{name}: {} of {} without a policy", without.survived, without.trials);
    }
}

/// Played as a game plays it, on a step as high as the game says, and a little beyond the end of the motion.
#[test]
fn a_player_is_told_how_high_the_step_is() {
    let model = hopper();
    let course = Course::read(file("step.course.ron")).unwrap();
    for (name, heights) in [("hop_up", [0.06, 0.125, 0.19]), ("hop_up_affine", [0.06, 0.11, 0.16])] {
        let skill = Arc::new(load_trained_skill(&skill_file(name).to_string_lossy(), &model).unwrap());
        for height in heights {
            let mut values = course.defaults();
            course.set(&mut values, "height", height).unwrap();
            let terrain = CourseTerrain::<f64>::new(Arc::new(World::empty()), &course.instance(&values, 0).unwrap());
            let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
            let mut player = SkillPlayer::new(skill.clone(), model.step_rate).unwrap();
            let neutral = skill.definition.warps[0].neutral;
            assert_eq!(player.parameters(), [neutral], "nothing was chosen: what the motion was made for");
            player.set_parameters(&[height]);
            let place = skill.motion.tick(0).pose.root_position * DVec3::new(1.0, 0.0, 1.0);
            player.begin(&mut sim, Heading::ahead(), place, None);
            for _ in 0..((skill.motion.duration() + 0.3) * model.step_rate) as usize {
                player.drive(&mut sim, &terrain).unwrap();
                step(&mut sim, &terrain);
                player.after_step(&mut sim, &terrain);
            }
            assert!(player.is_finished());
            let (root, stands) = (sim.state.root_position.lane(0), player.support().height);
            let reference = player.reference_pose().root_position;
            println!("{name} on {height}: root at {root}, its reference at {reference}, stands at {stands}");
            assert!((stands - height).abs() < 1e-9, "{name} stands at {stands} on a step of {height}");
            assert!((root - reference).length() < 0.2, "{name}: {root}, {reference}");
        }
    }
}

#[test]
fn both_kinds_of_training_run_from_the_files() {
    let dense = task("hop_up");
    let options = TrainOptions {
        threads: 2,
        env_batches: 1,
        ticks: 8,
        minibatch: 256,
        hidden: vec![16],
        evaluation_trials: 8,
        evaluate_every: 2,
        ..TrainOptions::default()
    };
    let mut trainer = Trainer::new(dense, options).unwrap();
    let before = trainer.present().actor.parameters().to_vec();
    for _ in 0..3 {
        let news = trainer.iterate();
        assert!(news.reward.is_finite() && news.reward > 0.1, "{}", news.reward);
    }
    assert!(trainer.present().actor.parameters() != before, "something was learnt");
    let (layers, contract) = trained_policy(trainer.task(), &trainer.present(), "hop_up.clip.ron");
    let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "dense").unwrap();
    trainer.task().skill.check_policy(&policy, &hopper()).unwrap();

    let options = AffineOptions { population: Some(6), episodes: 8, threads: 2, ..AffineOptions::default() };
    let mut search = AffineSearch::new(task("hop_up_affine"), options).unwrap();
    let (seen, told) = (search.task().layout.size(), search.task().action_size());
    assert_eq!((told, search.dimension()), (9, (seen + 1) * 9));
    for _ in 0..2 {
        let news = search.iterate().unwrap();
        assert!(news.best.1 > 0.0 && news.best.1 >= 0.5 * news.mean.1, "{news:?}");
    }
    let (layers, contract) = trained_policy(search.task(), search.best().unwrap(), "hop_up.clip.ron");
    assert_eq!(layers.layers.len(), 1, "one matrix and an offset");
    let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "affine").unwrap();
    search.task().skill.check_policy(&policy, &hopper()).unwrap();
}
