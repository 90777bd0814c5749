//! Contract: what a training left becomes a skill that a game loads, whole or not at all.
//!
//! The exported folder is read as a game reads it, by its skill file, and its trials come out as those of the run to the last digit: a
//! field that got lost on the way (a world, a gain, the course, the body) would show there. What does not belong together is refused
//! before anything is written, and nothing is replaced unasked.

use crate::command_line::{Folder, athlete, done, refused};
use bevy_athlete::asset::card::RobustnessCard;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::{Character, Course};
use bevy_athlete::cli::{load_character, load_trained_skill};
use bevy_athlete::control::Policy;
use bevy_athlete::skill::{SkillDefinition, TrainedSkill};
use std::path::{Path, PathBuf};

fn names(folder: &str) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Loads a skill folder as a game does: all by the skill file.
fn load(folder: &str, name: &str) -> TrainedSkill {
    let skill = SkillDefinition::load(Path::new(folder).join(format!("{name}.skill.ron"))).unwrap();
    let model = load_character(&skill.character).unwrap();
    let clip = MotionClip::load(&skill.motion).unwrap();
    let policy = Policy::load(Path::new(folder).join("policy.onnx")).unwrap();
    let course = skill.course.as_ref().map(|file| Course::read(file).unwrap());
    let trained = TrainedSkill::new(skill, &clip, policy, &model).unwrap();
    match course {
        Some(course) => trained.on_course(&course, &model).unwrap(),
        None => trained,
    }
}

#[test]
fn a_training_becomes_a_skill_that_does_the_same() {
    let folder = Folder::new("glide");
    let (run, out) = (folder.path("run"), folder.path("skills/two_foot_glide"));
    done(&["train", "two_foot_glide", "--iterations", "1", "--pods", "1", "--card-trials", "8", "--out", &run]);
    let export = ["export", &run, "--out", &out];
    let told = done(&export);
    let files = ["card.json", "policy.onnx", "two_foot_glide.clip.ron", "two_foot_glide.skill.ron"];
    assert_eq!(names(&out), files);
    assert!(files.iter().all(|file| told.contains(file)), "{told}");

    let skill = load(&out, "two_foot_glide");
    let card = RobustnessCard::load(Path::new(&out).join("card.json")).unwrap();
    assert_eq!((skill.name(), card.policy.as_str()), ("two_foot_glide", skill.policy.fingerprint()));
    let shipped = bevy_athlete::cli::find_skill("two_foot_glide").unwrap();
    let shipped = SkillDefinition::load(shipped).unwrap();
    let plain =
        |skill: &SkillDefinition| SkillDefinition { motion: PathBuf::new(), after: Vec::new(), ..skill.clone() };
    assert_eq!(plain(&skill.definition), plain(&shipped), "every field of the skill that was learnt");
    let trials = |policy: &str| done(&["evaluate", policy, "--trials", "8", "--json"]);
    assert_eq!(trials(&run), trials(&out));

    // Nothing is replaced unasked; asked for, it is, and a card of the policy that goes does not stay.
    refused(2, &export, &["--out would replace", "policy.onnx", "--force"]);
    std::fs::remove_file(Path::new(&run).join("card.json")).unwrap();
    let output = athlete(&[&export[..], &["--force"]].concat());
    assert!(output.status.success() && String::from_utf8_lossy(&output.stderr).contains("no card"));
    assert_eq!(names(&out), &files[1..]);

    // Another motion under its feet is found out, whoever plays it.
    let motion = Path::new(&out).join("two_foot_glide.clip.ron");
    let text = std::fs::read_to_string(&motion).unwrap();
    std::fs::write(&motion, text.replacen("name: \"", "name: \"another_", 1)).unwrap();
    let learnt_from = ["two_foot_glide.clip.ron: fingerprint fnv1a64-", "valid: fnv1a64-"];
    refused(1, &["evaluate", &out, "--trials", "8"], &learnt_from);
    let file = Path::new(&out).join("two_foot_glide.skill.ron").display().to_string();
    let skater = load_character("skater").unwrap();
    let refusal = load_trained_skill(&file, &skater).unwrap_err().to_string();
    assert!(learnt_from.iter().all(|word| refusal.contains(word)), "{refusal}");
    // Lines that end as on Windows are the same motion.
    std::fs::write(&motion, text.replace('\n', "\r\n")).unwrap();
    load_trained_skill(&file, &skater).unwrap();

    // A folder has one skill.
    std::fs::write(Path::new(&out).join("other.skill.ron"), "").unwrap();
    refused(2, &[&export[..], &["--force"]].concat(), &["--out", "other.skill.ron"]);
}

#[test]
fn what_does_not_belong_together_is_not_exported() {
    let folder = Folder::new("mixed");
    let (run, out) = (folder.path("run"), folder.path("out"));
    done(&["train", "two_foot_glide", "--iterations", "1", "--pods", "1", "--card-trials", "8", "--out", &run]);
    let export = ["export", &run, "--out", &out];
    let change = |name: &str, from: &str, to: &str| {
        let file = Path::new(&run).join(name);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{name}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        text
    };
    for (name, from, to) in
        [("two_foot_glide.clip.ron", "name: \"", "name: \"another_"), ("card.json", "fnv1a64-", "fnv1a64-1")]
    {
        let text = change(name, from, to);
        refused(1, &export, &[name, "policy.onnx", "fnv1a64-"]);
        std::fs::write(Path::new(&run).join(name), text).unwrap();
    }
    assert!(!Path::new(&out).exists(), "what was refused leaves nothing behind");
    refused(1, &["export", &folder.path("none"), "--out", &out], &["none"]);
    std::fs::write(folder.path("file"), "").unwrap();
    refused(2, &["export", &run, "--out", &folder.path("file/x")], &["--out", "file"]);
}

/// A body of one's own and a course go with the skill: the folder needs nothing from where it was made.
#[test]
fn body_and_course_go_with_the_skill() {
    let folder = Folder::new("hopper");
    let (run, out) = (folder.path("run"), folder.path("out"));
    let skill = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/families/hopper/hop_up/hop_up.skill.ron");
    let skill = skill.display().to_string();
    done(&["train", &skill, "--iterations", "1", "--pods", "1", "--card-trials", "8", "--out", &run]);
    let before = done(&["evaluate", &run, "--trials", "8", "--json"]);
    done(&["export", &run, "--out", &out]);
    let files = ["card.json", "hop_up.clip.ron", "hop_up.course.ron", "hop_up.skill.ron", "hopper.character.ron"];
    assert_eq!(names(&out), [&files[..], &["policy.onnx"]].concat());
    let trained = load(&out, "hop_up");
    assert!(Path::new(&trained.definition.character).starts_with(&out), "{}", trained.definition.character);
    Character::read(&trained.definition.character).unwrap();
    assert_eq!(done(&["evaluate", &out, "--trials", "8", "--json"]), before);
}
