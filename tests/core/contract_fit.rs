//! Contract: what a policy's contract says is what is played, and where anything differs, the field is named.
//!
//! A policy that is played with another scale, rate, order of links or order of observations moves the body by wrong numbers without
//! a word: its trials only look worse. So every field is changed in turn, and every reader has to refuse the change or to show that
//! it does not matter: a game's loader, `athlete evaluate` and `athlete info`. A body that the command line names is held against the
//! same contract.

use crate::command_line::athlete;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::policy_contract::CONTRACT_KEY;
use bevy_athlete::control::{Policy, PolicyError};
use bevy_athlete::model::{CharacterModel, preset, skater};
use bevy_athlete::skill::{SkillDefinition, TrainedSkill, TrainedSkillError};
use prost::Message;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tract_onnx::pb::ModelProto;

/// A change of a contract, and the field that has to be named; none where it does not matter.
type Row = (&'static str, fn(&mut Value), Option<&'static str>);

fn table() -> Vec<Row> {
    vec![
        ("nothing", |_| {}, None),
        ("another action scale", |c| c["action"]["scale"] = json!(0.6), Some("action.scale")),
        ("other gains", |c| c["gains"] = json!([1000.0, 50.0]), Some("gains")),
        ("another control rate", |c| c["control_rate"] = json!(60.0), Some("control_rate")),
        ("links swapped", |c| swap(&mut c["action"]["links"], 0, 3), Some("action.links[0]")),
        ("a link renamed", |c| c["action"]["links"][16] = json!("tail"), Some("action.links[16]")),
        ("blocks swapped", |c| swap(&mut c["observation"], 3, 4), Some("observation[3]")),
        ("a block renamed", |c| c["observation"][12]["name"] = json!("pose"), Some("observation[12]")),
        (
            "a block's numbers given to the next",
            |c| {
                c["observation"][1]["size"] = json!(2);
                c["observation"][2]["size"] = json!(2);
            },
            Some("observation[1]"),
        ),
        ("a motion that repeats", |c| c["reference"]["cyclic"] = json!(false), Some("reference.cyclic")),
        ("another body", |c| c["character_fingerprint"] = json!("0123456789abcdef"), Some("character_fingerprint")),
        ("another version", |c| c["version"] = json!(2), Some("version")),
        ("gains missing", |c| drop(c.as_object_mut().map(|c| c.remove("gains"))), Some("missing field `gains`")),
        (
            "rate missing",
            |c| drop(c.as_object_mut().map(|c| c.remove("control_rate"))),
            Some("missing field `control_rate`"),
        ),
        (
            "cyclic missing",
            |c| drop(c["reference"].as_object_mut().map(|r| r.remove("cyclic"))),
            Some("missing field `cyclic`"),
        ),
        // Words do not move a body.
        ("another name of the skill", |c| c["skill"] = json!("gliding"), None),
        ("another name of the character", |c| c["character"] = json!("anna"), None),
        ("another explanation", |c| c["observation"][0]["meaning"] = json!("words"), None),
        ("the right body", |c| c["character_fingerprint"] = json!(format!("{:016x}", skater().fingerprint())), None),
    ]
}

fn swap(list: &mut Value, a: usize, b: usize) {
    if let Some(list) = list.as_array_mut() {
        list.swap(a, b);
    }
}

fn folder(name: &str) -> PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/skills/skating").join(name)
}

/// The bytes of a shipped policy with its contract changed.
fn changed(skill: &str, change: fn(&mut Value)) -> Vec<u8> {
    let bytes = std::fs::read(folder(skill).join("policy.onnx")).unwrap();
    let mut model = ModelProto::decode(&*bytes).unwrap();
    let entry = model.metadata_props.iter_mut().find(|entry| entry.key == CONTRACT_KEY).unwrap();
    let mut contract: Value = serde_json::from_str(&entry.value).unwrap();
    change(&mut contract);
    entry.value = contract.to_string();
    model.encode_to_vec()
}

fn load(bytes: &[u8], model: &CharacterModel) -> Result<TrainedSkill, TrainedSkillError> {
    let definition = SkillDefinition::load(folder("stroking").join("stroking.skill.ron")).unwrap();
    let clip = MotionClip::load(&definition.motion).unwrap();
    TrainedSkill::new(definition, &clip, Policy::from_bytes(bytes, "changed.onnx")?, model)
}

#[test]
fn a_game_plays_the_contract_or_refuses() {
    for (what, change, field) in table() {
        match (load(&changed("stroking", change), &skater()), field) {
            (Ok(_), None) => {}
            (Err(error), Some(field)) => assert!(error.to_string().contains(field), "{what}: {error}"),
            (Ok(_), Some(_)) => panic!("{what}: played"),
            (Err(error), None) => panic!("{what}: {error}"),
        }
    }
}

/// A body with the right links may have any name; one with a joint less, or other links, is refused by what differs.
#[test]
fn bodies_are_compared_by_what_they_are() {
    let own = |change: fn(&mut CharacterModel)| {
        let mut model = (*skater()).clone();
        model.name = "anna".into();
        change(&mut model);
        load(
            &changed("stroking", |c| c["character_fingerprint"] = json!(format!("{:016x}", skater().fingerprint()))),
            &model,
        )
    };
    assert!(own(|_| {}).is_ok());
    let error = own(|model| model.links[4].mass += 0.5).unwrap_err();
    assert!(
        matches!(&error, TrainedSkillError::Policy(PolicyError::Misfit { misfit, .. }) if misfit.field == "character_fingerprint"),
        "{error}"
    );
    for name in ["foot_human", "two_segment_human", "toes_human", "runner"] {
        let model = preset(name).unwrap();
        let policy = Policy::from_bytes(&changed("stroking", |_| {}), "stroking.onnx").unwrap();
        let error = policy.check_for(&model).unwrap_err();
        assert!(
            matches!(&error, PolicyError::Misfit { misfit, .. } if misfit.field.starts_with("action.links[")),
            "{error}"
        );
    }
}

#[test]
fn the_command_line_plays_the_contract_or_refuses() {
    let beside = std::env::temp_dir().join(format!("athlete-contract-{}", std::process::id()));
    std::fs::create_dir_all(&beside).unwrap();
    let file = beside.join("policy.onnx").display().to_string();
    std::fs::copy(folder("stroking").join("stroking.clip.ron"), beside.join("stroking.clip.ron")).unwrap();
    let mut wrong = Vec::new();
    for (what, change, field) in table() {
        std::fs::write(&file, changed("stroking", change)).unwrap();
        let mut commands = vec![vec!["info", "--policy", &file, "--character", "skater"]];
        // What is refused is so before the first trial.
        if field.is_some() {
            commands.push(vec!["evaluate", &file, "--trials", "8"]);
        }
        for command in commands {
            let output = athlete(&command);
            let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
            let good = match field {
                None => output.status.success(),
                Some(field) => {
                    output.status.code() == Some(1) && complaint.contains(field) && complaint.contains("policy.onnx")
                }
            };
            if !good {
                wrong.push(format!("{what}: {} gave {:?}: {complaint}", command[0], output.status.code()));
            }
        }
    }
    // Where there are no settings, the contract alone says what is played: another scale is another policy, and refused by none.
    let bare = |c: &mut Value| {
        c["skill_settings"] = json!("");
        c["action"]["scale"] = json!(0.25);
    };
    std::fs::write(&file, changed("two_foot_glide", bare)).unwrap();
    let (key_poses, skater) = (folder("two_foot_glide").join("two_foot_glide.keyposes.ron"), skater());
    let clip = bevy_athlete::model::KeyPoses::load(key_poses).unwrap().to_clip(&skater).unwrap();
    clip.save(beside.join("two_foot_glide.clip.ron")).unwrap();
    let output = athlete(&["evaluate", &file, "--trials", "8", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = athlete(&["info", "--policy", &file, "--character", "skater"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let _ = std::fs::remove_dir_all(&beside);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A body of one's own is tried where the policy fits it, whatever its name; where it does not, the field is named before any trial.
#[test]
fn a_body_that_the_command_line_names_fits_or_is_refused() {
    let beside = std::env::temp_dir().join(format!("athlete-bodies-{}", std::process::id()));
    std::fs::create_dir_all(&beside).unwrap();
    let place = |name: &str| beside.join(name).display().to_string();
    let preset = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/characters/skater.character.ron");
    let text = std::fs::read_to_string(preset).unwrap();
    let (anna, heavy) = (place("anna.character.ron"), place("heavy.character.ron"));
    std::fs::write(&anna, text.replacen("name: \"skater\"", "name: \"anna\"", 1)).unwrap();
    std::fs::write(&heavy, text.replacen("mass: 5.6154", "mass: 6.6154", 1)).unwrap();
    // A policy that says which body it was learnt with.
    let file = place("policy.onnx");
    let own = |c: &mut Value| c["character_fingerprint"] = json!(format!("{:016x}", skater().fingerprint()));
    std::fs::write(&file, changed("stroking", own)).unwrap();
    std::fs::copy(folder("stroking").join("stroking.clip.ron"), place("stroking.clip.ron")).unwrap();

    let evaluate = |more: &[&str]| athlete(&[&["evaluate", &file, "--trials", "8"], more].concat());
    let (plain, named) = (evaluate(&["--json"]), evaluate(&["--json", "--character", &anna]));
    assert!(plain.status.success() && named.status.success(), "{}", String::from_utf8_lossy(&named.stderr));
    assert_eq!(plain.stdout, named.stdout, "the same body by another name does the same");
    let text = evaluate(&["--character", &anna]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("stroking of anna"));

    for (body, field) in [(heavy.as_str(), "character_fingerprint"), ("runner", "observation[")] {
        let output = evaluate(&["--character", body]);
        let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{body}: {complaint}");
        assert!(complaint.contains("does not fit") && complaint.contains(field), "{body}: {complaint}");
        assert!(output.stdout.is_empty(), "{body}: refused before the first trial");
    }
    for wrong in [&["--character", "anna"][..], &["--character", "skater", "--card"]] {
        assert_eq!(evaluate(wrong).status.code(), Some(2), "{wrong:?}");
    }
    // Without that fingerprint, links and observation alone decide: a heavier body of the same links is tried.
    std::fs::write(&file, changed("stroking", |_| {})).unwrap();
    assert!(evaluate(&["--character", &heavy]).status.success());
    let _ = std::fs::remove_dir_all(&beside);
}
