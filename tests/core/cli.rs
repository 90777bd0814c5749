//! The `athlete` program as a user meets it: every command once, on files written here.
//!
//! Exit code 0 only on success; a bad input ends with another code, nothing on stdout that looks like a result, and a line
//! on stderr that names the place and what would be valid, never a panic. What a machine reads is JSON. Replaying a control
//! gives the same bits, in another process too. A test of the library alone would miss all of that.

use crate::bvh_writer::{conventions, write_bvh};
use crate::command_line::{Folder, athlete, done};
use bevy_athlete::asset::card::RobustnessCard;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::dense_layers::Activation;
use bevy_athlete::asset::landmark_layout::LandmarkLayout;
use bevy_athlete::asset::policy_contract::PolicyContract;
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{BodyLandmark, BodyLandmarks, KeyPoses, ModelPose, PRESET_NAMES, preset, skater};
use bevy_athlete::train::save_policy;
use glam::DQuat;
use serde_json::{Value, json};
use std::path::Path;

fn done_json(arguments: &[&str]) -> Value {
    let text = done(arguments);
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(&text).unwrap()
}

/// A run that has to fail, with all of `words` on stderr.
fn refused(arguments: &[&str], words: &[&str]) {
    let output = athlete(arguments);
    let complaint = String::from_utf8_lossy(&output.stderr);
    let code = output.status.code();
    assert!(matches!(code, Some(1 | 2)), "{arguments:?}: {code:?}\n{complaint}");
    assert!(!complaint.contains("panicked"), "{complaint}");
    for word in words {
        assert!(complaint.contains(word), "{arguments:?}: `{word}` is missing in: {complaint}");
    }
}

/// The zero pose of any character held still, as a clip that names one joint.
fn standing(joint: &str, height: f64, poses: usize) -> String {
    let pose = format!(
        "(root_position: (0.0, {height}, 0.0), root_rotation: (0.0, 0.0, 0.0, 1.0), joints: [(0.0, 0.0, 0.0, 1.0)]),"
    );
    let poses = vec![pose; poses].join("\n");
    format!("(name: \"standing\", frame_rate: 10.0, joints: [\"{joint}\"], poses: [\n{poses}\n])")
}

/// A skeleton of the file's own that no built-in map knows, and a map for it.
const BVH: &str = "HIERARCHY
ROOT hip
{
 OFFSET 0 0 0
 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
 JOINT back
 {
  OFFSET 0 10 0
  CHANNELS 3 Zrotation Xrotation Yrotation
  End Site
  {
   OFFSET 0 10 0
  }
 }
}
MOTION
Frames: 3
Frame Time: 0.05
0 90 0 0 0 0 0 0 0
0 90 0 0 0 0 0 1 0
0 90 0 0 0 0 0 2 0
";

fn root_height(character: &str) -> f64 {
    done_json(&["info", "--character", character, "--json"])["root_height"].as_f64().unwrap()
}

#[test]
fn info_shows_a_character_as_table_and_json() {
    let table = done(&["info", "--character", "skater"]);
    for word in ["57 degrees of freedom", "50.069 kg", "thigh_left", "blade_left_toe", "-155..8"] {
        assert!(table.contains(word), "{word} is missing in {table}");
    }
    let runner = done_json(&["info", "--character", "runner", "--json"]);
    assert_eq!(runner["dof"], 45);
    assert_eq!(runner["links"].as_array().unwrap().len(), 14);
    let height = runner["height"].as_f64().unwrap();
    assert!((height - 1.7).abs() < 0.01, "{height}");

    // What the file says of its feet, or what was found.
    assert!(table.contains("foot, left: blade left; foot_left; toe blade_left_toe") && table.contains("trunk: spine"));
    assert_eq!((&runner["feet"][1]["side"], &runner["trunk"]), (&json!("right"), &json!("chest")));
    let roles = runner["contact_points"].as_array().unwrap().iter().filter(|p| p["role"] == "hand").count();
    assert_eq!(roles, 2);

    refused(&["info", "--character", "skatr"], &["skatr", "skater, foot_human"]);
    let folder = Folder::new("info");
    let file = folder.write("bad.character.ron", "(name: \"x\", step_rate: fast)");
    refused(&["info", "--character", &file], &["bad.character.ron:1:"]);
}

/// A trial of a policy leaves a trace without any force from outside, and the card of the skill's own rows stays.
#[test]
fn evaluate_tries_other_rows_and_writes_a_trial_down() {
    let folder = Folder::new("evaluate");
    let (trace, picture) = (folder.path("trial.jsonl"), folder.path("trial.png"));
    let card = bevy_athlete::cli::find_skill("two_foot_glide").unwrap().with_file_name("card.json");
    let before = std::fs::read(&card).unwrap();
    let asked = ["--trials", "8", "--speed", "1..2", "--trace", &trace, "--storyboard", &picture];
    let report = done_json(&[&["evaluate", "two_foot_glide", "--json"][..], &asked].concat());
    assert_eq!(std::fs::read(&card).unwrap(), before, "the card is that of the skill's own rows");
    assert_eq!(report["rows"][0]["trials"], 8);
    assert!(report["quality"]["time_at_torque_limits"].is_number());

    let text = std::fs::read_to_string(&trace).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0]["format"], "athlete-trace-1");
    assert!(lines.len() > 1200, "more than a second, {} lines", lines.len());
    assert!(lines.iter().skip(1).all(|line| line["external"].as_array().unwrap().is_empty()));
    assert!(lines.iter().skip(1).any(|line| line["contacts"][0]["kind"] == "blade"));
    assert_eq!(&std::fs::read(&picture).unwrap()[1..4], b"PNG");
}

/// A training leaves everything that a skill ships with, and says last how good it is.
#[test]
fn train_leaves_a_policy_with_its_card() {
    let folder = Folder::new("train");
    let out = folder.path("run");
    let asked = ["train", "two_foot_glide", "--iterations", "2", "--pods", "1", "--card-trials", "8", "--out", &out];
    let report = done(&asked);
    let last = report.lines().last().unwrap();
    let numbers: Vec<f64> = last.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(last.starts_with("survival ") && last.contains(" % reward ") && numbers.len() == 2, "{last}");
    let card = RobustnessCard::load(format!("{out}/card.json")).unwrap();
    assert_eq!((card.skill.as_str(), card.trials), ("two_foot_glide", 8));
    assert_eq!(card.command, "athlete evaluate run --trials 8 --seed 1000003");
    assert!((100.0 * card.rate() - numbers[0]).abs() < 0.06, "{last}");
    assert!(card.reward_per_step().is_some_and(|reward| (reward - numbers[1]).abs() < 6e-4), "{last}");
    for file in ["policy.onnx", "checkpoint.json", "curve.csv", "curve.png", "two_foot_glide.clip.ron"] {
        assert!(std::fs::metadata(format!("{out}/{file}")).is_ok(), "{file}");
    }
}

#[test]
fn simulate_follows_a_clip_and_writes_trace_and_storyboard() {
    let folder = Folder::new("simulate");
    let clip = folder.write("standing.clip.ron", &standing("abdomen", root_height("skater"), 2));
    let (trace, picture) = (folder.path("out.jsonl"), folder.path("out.png"));
    let run = ["simulate", "--character", "skater", "--world", "ice", "--motion", &clip, "--json"];
    let report = done_json(
        &[&run[..], &["--trace", &trace, "--storyboard", &picture, "--push", "head:0,0,5:0.01:0.02"]].concat(),
    );
    assert_eq!(report["steps"], 120);
    assert!((report["seconds"].as_f64().unwrap() - 0.1).abs() < 1e-12);
    assert!(report["fell_at"].is_null() && report["worst_root_m"].as_f64().unwrap() < 0.02, "{report}");
    assert!(report["build"]["instructions"].is_string());

    // The trace: a header, then a line a step; the push acts in its steps only.
    let text = std::fs::read_to_string(&trace).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 121);
    assert_eq!(lines[0]["format"], "athlete-trace-1");
    assert_eq!(lines[0]["bodies"].as_array().unwrap().len(), lines[1]["bodies"].as_array().unwrap().len());
    let pushed: Vec<usize> = (1..=120).filter(|&i| !lines[i]["external"].as_array().unwrap().is_empty()).collect();
    assert_eq!((pushed.len(), pushed[0]), (24, 13));
    assert!(lines.iter().skip(1).any(|line| line["contacts"][0]["kind"] == "blade"));
    assert_eq!(&std::fs::read(&picture).unwrap()[1..4], b"PNG");

    // Recorded, and performed again; 30 poses a second, or as many as asked for.
    let recorded = folder.path("out.clip.ron");
    let report = done_json(&[&run[..], &["--record", &recorded]].concat());
    assert_eq!(report["record"], recorded.as_str());
    let clip = bevy_athlete::asset::clip::MotionClip::load(&recorded).unwrap();
    assert_eq!((clip.name.as_str(), clip.frame_rate, clip.poses.len()), ("out", 30.0, 4));
    let again = ["simulate", "--character", "skater", "--motion", &recorded, "--record", &recorded];
    let text = done(&[&again[..], &["--record-rate", "60"]].concat());
    assert!(text.contains("skater on ice, plain stable PD on out") && text.contains("record  "), "{text}");
    assert_eq!(bevy_athlete::asset::clip::MotionClip::load(&recorded).unwrap().poses.len(), 7);

    // In words, without the push, at another rate and other gains.
    let text = done(&[&run[..7], &["--rate", "600", "--kp", "300", "--kd", "30", "--seconds", "0.05"]].concat());
    for word in ["built for", "0.050 s, 30 steps", "fell             no", "final state"] {
        assert!(text.contains(word), "{word} is missing in {text}");
    }
    for world in ["ground", "empty", "stairs", "sphere", "slope:10"] {
        let report = done_json(&[&run[..3], &["--world", world], &run[5..], &["--seconds", "0.01"]].concat());
        assert_eq!(report["world"], world);
    }
}

/// Skeletons that no built-in map knows are read without one; the map that was found is written, and read back by `--map`.
#[test]
fn a_strangers_motion_goes_in() {
    let folder = Folder::new("stranger");
    let path = "assets/skills/skating/stroking/stroking.keyposes.ron";
    let skater = preset("skater").unwrap();
    let clip = KeyPoses::load(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap().to_clip(&skater).unwrap();
    let mixamo = conventions().into_iter().find(|c| c.name == "mixamo").unwrap();
    let text = write_bvh(&mixamo, &clip, &skater);
    let bvh = folder.write("walk.bvh", &text);
    let run =
        ["simulate", "--character", "runner", "--world", "ground", "--seconds", "0.05", "--motion", &bvh, "--json"];
    let output = athlete(&run);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    for word in ["mixamorig:LeftShoulder + mixamorig:LeftArm", "T-pose", "athlete map", "mixamorig:LeftHandIndex1"] {
        assert!(told.contains(word), "`{word}` is missing in:\n{told}");
    }

    let map = folder.path("my.map.ron");
    let out = ["map", &bvh, "--character", "runner", "--out", &map];
    let table = done(&out);
    assert!(table.contains("forearm_right") && table.contains("my.map.ron"), "{table}");
    refused(&out, &["my.map.ron", "--force"]);
    done(&[&out[..], &["--force"]].concat());
    refused(&["map", &bvh, "--out", "my.ron"], &["--out my.ron", ".map.ron"]);
    let picture = folder.path("map.png");
    let report = done_json(&["map", &bvh, "--character", "runner", "--storyboard", &picture, "--json"]);
    assert_eq!(report["storyboard"], picture.as_str());
    assert_eq!(&std::fs::read(&picture).unwrap()[1..4], b"PNG");
    refused(&["map", &bvh, "--storyboard", "/no/such/folder/x.png"], &["--storyboard /no/such/folder/x.png"]);
    assert_eq!((report["unit"].as_str(), report["warnings"].as_array().map(Vec::len)), (Some("cm"), Some(0)));
    let output = athlete(&[&run[..], &["--map", &map]].concat());
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));

    // Every command that reads a motion tells the same table, unless a map is given.
    let table: Vec<&str> = table.lines().filter(|line| line.contains("mixamorig:")).collect();
    assert!(table.len() > 12, "{table:?}");
    let (out, picture, joined) = (folder.path("run"), folder.path("show.png"), folder.path("joined.clip.ron"));
    let body = ["--character", "runner"];
    let train =
        ["train", "--clip", &bvh, "--world", "ground", "--iterations", "1", "--pods", "1", "--card-trials", "0"];
    let commands = [
        &["show", &bvh, "--storyboard", &picture][..],
        &["join", &bvh, &bvh, "--out", &joined],
        &["reconstruct", "--clip", &bvh, "--world", "ground", "--samples", "4", "--keep", "1", "--attempts", "1"],
        &[&train[..], &["--out", &out]].concat(),
    ];
    for command in commands {
        let told = String::from_utf8_lossy(&athlete(&[command, &body].concat()).stderr).into_owned();
        for line in &table {
            assert!(told.contains(line), "{}: `{line}` is missing in:\n{told}", command[0]);
        }
        let told = String::from_utf8_lossy(&athlete(&[command, &body, &["--map", &map]].concat()).stderr).into_owned();
        assert!(!told.contains("mixamorig:"), "{}: {told}", command[0]);
    }
    let skill = folder.write(
        "walk.skill.ron",
        "(name: \"walk\", character: \"runner\", motion: \"walk.bvh\", world: \"ground\", training_rate: 600)",
    );
    let told = athlete(&[
        "train",
        &skill,
        "--iterations",
        "1",
        "--pods",
        "1",
        "--card-trials",
        "0",
        "--out",
        &folder.path("own"),
    ]);
    let told = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(table.iter().all(|line| told.contains(line)), "{told}");

    // A wrong count is named and read; one pose is nothing to follow.
    let frames = clip.poses.len();
    let short = text.replace(&format!("Frames: {frames}"), &format!("Frames: {}", frames - 1));
    let short = folder.write("short.bvh", &short);
    let output = athlete(&["map", &short]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && told.contains(&format!("holds {frames}")), "{told}");
    let one = MotionClip { poses: clip.poses[..1].to_vec(), ..clip };
    let one = folder.write("one.bvh", &write_bvh(&mixamo, &one, &skater));
    let reconstruct = ["reconstruct", "--character", "runner", "--world", "ground", "--clip", &one];
    refused(&reconstruct, &["one.bvh", "nothing to follow"]);

    // A device without an end is refused at once.
    #[cfg(unix)]
    {
        let endless = folder.path("endless.bvh");
        std::os::unix::fs::symlink("/dev/zero", &endless).unwrap();
        refused(&["map", &endless], &["endless.bvh", "a device", "regular file"]);
    }
}

#[test]
fn a_course_is_chosen_by_its_file_and_its_parameters() {
    let folder = Folder::new("course");
    let height = root_height("runner") - 0.001;
    let clip = folder.write("standing.clip.ron", &standing("abdomen", height, 2));
    let course = |name: &str| format!("{}/assets/courses/{name}.course.ron", env!("CARGO_MANIFEST_DIR"));
    let (vault, bumps) = (course("vault_box"), course("bumps"));
    let run = ["simulate", "--character", "runner", "--motion", &clip, "--json"];
    let plain = done_json(&[&run[..], &["--world", "ground"]].concat());
    // Far from its box, the course's ground is the ground; on top of its box, nothing is.
    let far = ["--course", &vault, "--set", "distance=20", "--set", "height=0.45"];
    let picture = folder.path("out.png");
    let report = done_json(&[&run[..], &far, &["--storyboard", &picture]].concat());
    assert_eq!(report["world"], "course:vault_box,seed=0,height=0.45,distance=20,aside=0");
    assert_eq!(report["fingerprint"], plain["fingerprint"]);
    let near = done_json(&[&run[..], &["--course", &vault, "--set", "distance=0"]].concat());
    assert_ne!(near["fingerprint"], plain["fingerprint"]);
    let rough = done_json(&[&run[..], &["--course", &bumps, "--course-seed", "3"]].concat());
    assert_eq!(rough["world"], "course:bumps,seed=3,amplitude=0.02");
    let shown = folder.path("show.png");
    done(&["show", &clip, "--character", "runner", "--storyboard", &shown, "--course", &vault]);
    assert_ne!(std::fs::read(&picture).unwrap(), std::fs::read(&shown).unwrap());

    let with = |more: &[&'static str]| [&run[..5], &["--course", &vault], more].concat();
    refused(&with(&["--set", "height=0.9"]), &["parameter `height`", "0.9", "from 0.4 to 0.6"]);
    refused(&with(&["--set", "depth=0.9"]), &["`depth` is unknown", "one of height, distance, aside"]);
    refused(&with(&["--set", "height"]), &["`height`", "NAME=NUMBER"]);
    refused(&[&run[..5], &["--set", "height=0.5"]].concat(), &["--course"]);
    refused(&[&run[..5], &["--course", "no/such.course.ron"]].concat(), &["no/such.course.ron", "cannot be read"]);
    let moving = folder.write(
        "moving.course.ron",
        "(name: \"moving\", solids: [Box(ahead: 3, depth: 1, width: 1, height: 1, motion: Cross(by: (1, 0, 0), speed: 1))])",
    );
    done(&[&run[..], &["--course", &moving]].concat());
    refused(&["reconstruct", "--character", "runner", "--clip", &clip, "--course", &moving], &["solids that move"]);
}

#[test]
fn simulate_reads_bvh_by_a_map_of_the_users_own() {
    let folder = Folder::new("bvh");
    let bvh = folder.write("own.bvh", BVH);
    let run = ["simulate", "--character", "runner", "--motion", &bvh, "--json"];
    refused(&run, &["own.bvh", "--map", "hip, back"]);
    let trunk = done_json(&["info", "--character", "runner", "--json"])["links"][1]["name"].clone();
    let link = format!("(link: \"{}\", joints: [\"back\"])", trunk.as_str().unwrap());
    let map = format!(
        "(name: \"own\", unit: 0.01, up: (0, 1, 0), facing: (0, 0, -1), root: (link: \"pelvis\", joints: [\"hip\"]), links: [{link}])"
    );
    let map = folder.write("own.map.ron", &map);
    let report = done_json(&[&run[..], &["--map", &map]].concat());
    assert_eq!((report["steps"].as_u64(), report["clip"].as_str()), (Some(200), Some("own")));

    let cut = folder.write("cut.bvh", &BVH[..BVH.len() / 2]);
    refused(&["simulate", "--character", "runner", "--motion", &cut], &["cut.bvh"]);
    refused(&[&run[..], &["--map", &cut]].concat(), &["cut.bvh", "joint map"]);
}

#[test]
fn reconstruct_finds_a_control_that_replays_to_the_same_bits() {
    let folder = Folder::new("reconstruct");
    let clip = folder.write("standing.clip.ron", &standing("abdomen", root_height("skater"), 3));
    let (control, picture) = (folder.path("out.control.ron"), folder.path("out.png"));
    let run = [
        "reconstruct",
        "--character",
        "skater",
        "--clip",
        &clip,
        "--samples",
        "16",
        "--keep",
        "4",
        "--deviation",
        "0.02",
        "--json",
    ];
    let found = done_json(&[&run[..], &["--out", &control, "--storyboard", &picture, "--threads", "2"]].concat());
    assert_eq!(found["meets"], true, "{found}");
    assert_eq!(&std::fs::read(&picture).unwrap()[1..4], b"PNG");
    // One thread finds the same.
    let recorded = folder.path("out.clip.ron");
    let again = done_json(&[&run[..], &["--threads", "1", "--record", &recorded]].concat());
    assert_eq!(found["fingerprint"], again["fingerprint"]);

    // Replayed twice, and after being read and written again.
    let replayed = folder.path("replayed.clip.ron");
    let replay = done_json(&["simulate", "--control", &control, "--json", "--record", &replayed]);
    assert_eq!(replay["fingerprint"], found["fingerprint"]);
    let clips = [&recorded, &replayed].map(|path| bevy_athlete::asset::clip::MotionClip::load(path).unwrap());
    assert!(clips[0].poses.len() == 7 && clips[0].poses == clips[1].poses);
    assert_eq!(replay["world"], "ice");
    assert_eq!(done_json(&["simulate", "--control", &control, "--json"])["fingerprint"], found["fingerprint"]);
    let copy = folder.path("copy.control.ron");
    bevy_athlete::control::ReconstructedControl::load(&control).unwrap().save(&copy).unwrap();
    let copied = done_json(&["simulate", "--character", "skater", "--control", &copy, "--json"]);
    assert_eq!(copied["fingerprint"], found["fingerprint"]);

    refused(&["simulate", "--control", &control, "--character", "runner"], &["out.control.ron", "runner"]);
    refused(&["simulate", "--control", &control, "--rate", "600"], &["--rate 600", "1200"]);
    refused(&["simulate", "--control", &control, "--kp", "600"], &["--kp"]);
    let text = std::fs::read_to_string(&control).unwrap();
    let broken = folder.write("broken.control.ron", &text.replace("rate: 1200.0", "rate: -1.0"));
    refused(&["simulate", "--control", &broken], &["broken.control.ron", "rate is -1", "30 to 20000"]);
    let strange = folder.write("strange.control.ron", &text.replace("world: \"ice\"", "world: \"lava\""));
    refused(&["simulate", "--control", &strange], &["strange.control.ron", "lava", "ground"]);
}

#[test]
fn reconstruct_says_what_is_wrong() {
    let folder = Folder::new("refusals");
    let clip = folder.write("standing.clip.ron", &standing("abdomen", 0.9, 2));
    let run = ["reconstruct", "--character", "skater", "--clip", &clip];
    refused(&[&run[..], &["--samples", "1"]].concat(), &["--samples 1", "4 to"]);
    refused(&[&run[..], &["--keep", "0"]].concat(), &["--keep 0"]);
    refused(&[&run[..], &["--deviation", "9"]].concat(), &["--deviation 9"]);
    refused(&[&run[..], &["--threads", "0"]].concat(), &["--threads 0"]);
    refused(&[&run[..], &["--cycles", "0"]].concat(), &["--cycles 0", "1 to"]);
    refused(&[&run[..], &["--kp", "600"]].concat(), &["--kd"]);
    refused(&[&run[..], &["--kp", "nan", "--kd", "1"]].concat(), &["--kp NaN"]);
    refused(&[&run[..], &["--out", "/no/such/folder/out.ron"]].concat(), &["--out", "/no/such/folder"]);
    refused(&[&run[..], &["--record", "/no/such/folder/x.clip.ron"]].concat(), &["--record", "/no/such/folder"]);
    // Nothing can follow a character that hangs 5 m above the ice.
    let high = folder.write("high.clip.ron", &standing("abdomen", 5.0, 9));
    let hang = ["reconstruct", "--character", "skater", "--clip", &high, "--samples", "4", "--keep", "1"];
    refused(&hang, &["high.clip.ron", "no sample passes window"]);
}

#[test]
fn simulate_says_what_is_wrong() {
    let folder = Folder::new("simulate-refusals");
    let clip = folder.write("standing.clip.ron", &standing("abdomen", 0.9, 2));
    let run = ["simulate", "--character", "skater", "--motion", &clip];
    refused(&["simulate", "--character", "skater"], &["--motion", "--control"]);
    refused(&["simulate", "--motion", &clip], &["--character"]);
    refused(&[&run[..], &["--world", "moon"]].concat(), &["moon", "ice, ground", "slope:DEGREES"]);
    refused(&[&run[..], &["--world", "slope:80"]].concat(), &["slope:80", "-60 to 60"]);
    refused(&[&run[..], &["--seconds=-1"]].concat(), &["--seconds -1", "0 to 3600"]);
    refused(&[&run[..], &["--rate", "1"]].concat(), &["--rate 1", "30 to 20000"]);
    refused(&[&run[..], &["--kd", "inf"]].concat(), &["--kd inf"]);
    refused(&[&run[..], &["--push", "nose:0,0,1:0:1"]].concat(), &["nose", "no such link", "pelvis"]);
    refused(&[&run[..], &["--push", "head:0,0:0:1"]].concat(), &["three components"]);
    refused(&[&run[..], &["--trace", "/no/such/folder/x"]].concat(), &["/no/such/folder/x"]);
    refused(&[&run[..], &["--storyboard", "/no/such/folder/x.png"]].concat(), &["/no/such/folder/x.png"]);
    refused(&[&run[..], &["--record", "x.ron"]].concat(), &["--record x.ron", ".clip.ron"]);
    refused(&[&run[..], &["--record", "x.clip.ron", "--record-rate", "0"]].concat(), &["--record-rate 0", "1 to 1000"]);
    refused(&[&run[..], &["--record-rate", "60"]].concat(), &["--record"]);
    refused(&["simulate", "--character", "skater", "--motion", "none.bvh"], &["none.bvh"]);
    refused(&["simulate", "--character", "skater", "--motion", "x.png"], &["x.png", ".bvh"]);
    refused(&["simulate", "--control", "none.control.ron"], &["none.control.ron"]);
    let wrong = folder.write("wrong.clip.ron", &standing("tail", 0.9, 2));
    refused(&["simulate", "--character", "skater", "--motion", &wrong], &["wrong.clip.ron", "tail", "abdomen"]);
    // Too stiff a push for the step: reported, not written on.
    refused(&[&run[..], &["--push", "head:99999,0,0:0:1"]].concat(), &["left its range"]);
}

/// The 24 SMPL joints of the skater in a step, metres, Y up, facing +Z.
fn smpl_step() -> Vec<[f64; 3]> {
    let (model, layout) = (skater(), LandmarkLayout::built_in("smpl24").unwrap());
    let mut pose = ModelPose::zero(&model);
    let bends = [("thigh_left", 50.0), ("shin_left", -60.0), ("shin_right", -35.0), ("forearm_right", 40.0)];
    for (link, degrees) in bends {
        pose.joints[model.link_index(link).unwrap()] = DQuat::from_rotation_x(f64::to_radians(degrees));
    }
    let mut links = Vec::new();
    pose.link_transforms(&model, &mut links);
    let body = BodyLandmarks::new(&layout, &model).unwrap();
    let place = |p: &BodyLandmark| links[p.link].position + links[p.link].rotation * p.position;
    body.points.iter().map(|p| layout.axes.from_ours(place(p.as_ref().unwrap())).to_array()).collect()
}

#[test]
fn joints_are_imported_and_shown() {
    let folder = Folder::new("import");
    let joints = smpl_step();
    let file = folder.write("step.json", &json!({ "fps": 10, "frames": [joints, joints, joints] }).to_string());
    let keys = folder.path("step.keyposes.ron");
    let text = done(&["import-joints", &file]);
    for word in
        ["3 frames of 24 landmarks (smpl24)", "units of the file in a metre of the skater", "step.keyposes.ron (3)"]
    {
        assert!(text.contains(word), "`{word}` is missing in:\n{text}");
    }
    let read = KeyPoses::load(&keys).unwrap();
    let knee = read.poses[0].joints["shin_left"];
    assert!((knee.0 + 60.0).abs() < 2.0, "{knee:?}");
    // What is there is not overwritten unless asked for.
    refused(&["import-joints", &file], &["step.keyposes.ron exists", "--out"]);
    let report = done_json(&["import-joints", &file, "--out", &keys, "--every", "2", "--json"]);
    assert_eq!((report["poses"].as_u64(), report["layout"].as_str()), (Some(2), Some("smpl24")));
    assert!(report["worst_rms_m"].as_f64().unwrap() < 0.01 && report["warnings"].as_array().unwrap().is_empty());
    assert_eq!(KeyPoses::load(&keys).unwrap().seconds, [0.2, 0.2]);

    // Left called right, and a landmark that is missing: warnings, in words and as JSON; put right by --exchange.
    let layout = LandmarkLayout::built_in("smpl24").unwrap();
    let mut wrong: Vec<Value> = (0..24).map(|i| json!(joints[layout.partner(i)])).collect();
    wrong[layout.index("left_wrist").unwrap()] = Value::Null;
    let file = folder.write("wrong.json", &json!(wrong).to_string());
    let output = athlete(&["import-joints", &file, "--out", &keys]);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{complaint}");
    for word in ["warning: frame 0: left and right of the body", "left_wrist not seen"] {
        assert!(complaint.contains(word), "`{word}` is missing in: {complaint}");
    }
    let report = done_json(&["import-joints", &file, "--out", &keys, "--exchange", "body", "--json"]);
    assert_eq!(report["warnings"].as_array().unwrap().len(), 1, "{report}");

    // Pictures: one figure for each key pose; of clips at even times.
    let picture = folder.path("out.png");
    let shown = done_json(&["show", &keys, "--storyboard", &picture, "--json"]);
    assert_eq!((shown["figures"].as_u64(), shown["character"].as_str()), (Some(1), Some("skater")));
    assert_eq!(&std::fs::read(&picture).unwrap()[1..4], b"PNG");
    let clip = folder.write("standing.clip.ron", &standing("abdomen", root_height("runner"), 30));
    let words = done(&["show", &clip, "--character", "skater", "--storyboard", &picture, "--figures", "5"]);
    assert!(words.contains("30 poses, 2.90 s, character skater") && words.contains("(5 figures)"), "{words}");

    refused(&["show", &keys, "--storyboard", &picture, "--figures", "0"], &["--figures 0", "1 to 64"]);
    refused(&["show", &keys, "--storyboard", "/no/such/folder/x.png"], &["/no/such/folder/x.png"]);
    refused(&["show", &file, "--storyboard", &picture], &["wrong.json", ".keyposes.ron"]);
    refused(
        &["show", &keys, "--storyboard", &picture, "--character", "runner"],
        &["step.keyposes.ron", "no such joint"],
    );
}

#[test]
fn import_joints_says_what_is_wrong() {
    let folder = Folder::new("import-refusals");
    let file = folder.write("good.json", &json!(smpl_step()).to_string());
    let run = ["import-joints", &file];
    refused(&[&run[..], &["--out", "x.json"]].concat(), &["--out x.json", ".keyposes.ron"]);
    refused(&[&run[..], &["--out", "/no/such/folder/x.keyposes.ron"]].concat(), &["--out", "/no/such/folder"]);
    refused(&[&run[..], &["--layout", "coco"]].concat(), &["coco", "smpl24, mediapipe33"]);
    refused(&[&run[..], &["--axes", "x_up"]].concat(), &["x_up", "y_down"]);
    refused(&[&run[..], &["--exchange", "head"]].concat(), &["head", "legs"]);
    refused(&[&run[..], &["--frames", "0,7"]].concat(), &["good.json", "frames is 7", "0 to 0"]);
    refused(&[&run[..], &["--every", "0"]].concat(), &["--every 0"]);
    refused(&[&run[..], &["--min-visibility", "2"]].concat(), &["minimum visibility is 2"]);
    refused(&[&run[..], &["--fps", "0"]].concat(), &["fps", "0.1 to 1000"]);
    refused(&["import-joints", "none.json"], &["none.json"]);
    for (text, words) in [
        ("[[NaN, 0, 0]]", &["line 1", "null"][..]),
        ("[[1, 2, 3]]", &["1 landmarks", "smpl24"]),
        (
            "{\"layout\": \"smpl24\", \"joints\": {\"left_hip\": [0, 1, 0]}}",
            &["frame 0", "right_hip", "at least three"],
        ),
    ] {
        let bad = folder.write("bad.json", text);
        refused(&["import-joints", &bad], &[&["bad.json"], words].concat());
    }
    let names: Vec<String> =
        std::fs::read_dir(&folder.0).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().all(|n| n.ends_with(".json")), "nothing is written: {names:?}");
}

#[test]
fn export_writes_presets_and_scenes() {
    let folder = Folder::new("export");
    let (plain, scene) = (folder.path("skater.xml"), folder.path("scene.xml"));
    done(&["export-mjcf", "--character", "skater", &plain]);
    done(&["export-mjcf", "--character", "skater_stand", &scene]);
    let sites = |path: &str| std::fs::read_to_string(path).unwrap().matches("<site ").count();
    assert_eq!(sites(&scene), sites(&plain) + 4);
    refused(&["export-mjcf", "--character", "sled", &plain], &["sled", "runner", "foot_stand"]);
    refused(&["export-mjcf", "--character", "skater", "/no/such/folder/x.xml"], &["/no/such/folder/x.xml"]);
    assert!(Path::new(&plain).exists());
}

#[test]
fn bench_prints_the_rows_a_machine_reads() {
    let report =
        done_json(&["bench", "--json", "--quick", "--scene", "skater_air", "--lanes", "f64", "--lanes", "8 x f32"]);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        assert_eq!(row["engine"], "bevy_athlete");
        assert!(row["us_min"].as_f64().unwrap() > 0.0 && row["us_median"].as_f64() >= row["us_min"].as_f64(), "{row}");
        assert_eq!(row["points"], 0.0);
    }
    assert!(report["build"]["profile"].is_string());
    refused(&["bench", "--scene", "moon"], &["moon", "skater_stand"]);
    refused(&["bench", "--lanes", "3 x f16"], &["3 x f16", "8 x f32"]);
}

#[test]
fn info_shows_a_policys_contract() {
    let folder = Folder::new("policy");
    let mut random = RandomStream::new(81, 0);
    let layers = crate::policy_support::network(&[20, 8, 51], Activation::Tanh, &mut random);
    let contract = crate::policy_support::contract_for(&layers, &mut random);
    let file = folder.path("test.onnx");
    save_policy(&file, &layers, &contract).unwrap();

    let text = done(&["info", "--policy", &file]);
    for word in ["stroking", "30 actions/s", "600 simulation steps/s", "stroking.clip.ron", "phase", "hand_right"] {
        assert!(text.contains(word), "`{word}` is missing in:\n{text}");
    }
    let json = done_json(&["info", "--policy", &file, "--json"]);
    assert_eq!(PolicyContract::from_json(&json["contract"].to_string()).unwrap(), contract);
    refused(
        &["info", "--policy", &file, "--character", "skater"],
        &["observation[0]", "`phase` of 1 numbers", "`phase` of 10"],
    );
    refused(&["info", "--policy", &folder.write("text.onnx", "a text")], &["not an ONNX model"]);
    refused(&["info", "--policy", &folder.path("none.onnx")], &["cannot be read"]);
    refused(&["info"], &["--character"]);
}

#[test]
fn help_names_every_preset() {
    for command in ["show", "evaluate", "simulate", "reconstruct"] {
        let help = done(&[command, "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
        let listed = format!("preset ({})", PRESET_NAMES.join(", "));
        assert!(help.contains(&listed), "{command}: {help}");
    }
}
