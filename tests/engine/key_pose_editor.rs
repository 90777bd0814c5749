//! The key-pose editor without a window.
//!
//! What is proven: a change of a value changes the bytes of that value and no other, in every file that ships and in one with
//! odd comments and unknown fields; undo brings the very bytes back; what the document says is what the file says; a motion is
//! simulated and a policy learnt in the background, with progress, and both can be cancelled; what was learnt is saved as files
//! that load again.

use bevy_athlete::control::Policy;
use bevy_athlete::model::{KeyPoses, preset};
use bevy_athlete::skill::{SkillDefinition, TrainedSkill};
use bevy_athlete::train::ReconstructOptions;
use bevy_athlete::train::ppo::TrainOptions;
use bevy_athlete::ui::editor::*;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Comments everywhere, fields that the crate does not know, numbers spelt in several ways, a pose without joints.
const ODD: &str = r#"// A comment with ( and "quotes
#![enable(implicit_some)]
/* a block /* inside */ ( */
(
    name: "odd", // the name
    author: (who: "somebody (else)", year: 2031), // not known to the crate
    character: "skater",
    speed: 2.50,
    seconds: [0.50, /* here */ 0.3, 0.40],
    poses: [
        // first ( pose
        (
            root: (-12.0, 0, 0), note: "kept",
            joints: {
                "thigh_left": (40.00, 4, 0), "shin_left": (-58, 0, 0), // the left leg
                /* the right one */ "thigh_right": (4.3e1, -14, 3),
            },
        ),
        (), // second
        // third
        (joints: {"head": (18, 0, 0)}, lateral: 0.0100)
    ],
    camera: [1, 2, 3],
)
// the end
"#;

fn odd() -> PoseDocument {
    PoseDocument::from_text(ODD.into(), "odd.keyposes.ron").unwrap()
}

fn joint(name: &str, axis: usize) -> PoseField {
    PoseField::Joint(name.into(), axis)
}

/// The text with one place replaced.
fn with(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn only_the_bytes_of_the_changed_value_change() {
    for (pose, field, value, from, to) in [
        (0, joint("thigh_left", 0), 41.5, "(40.00, 4, 0)", "(41.5, 4, 0)"),
        (0, joint("thigh_right", 0), -7.0, "(4.3e1, -14, 3)", "(-7, -14, 3)"),
        (0, joint("shin_left", 2), 0.25, "(-58, 0, 0)", "(-58, 0, 0.25)"),
        (0, PoseField::Root(1), 3.0, "(-12.0, 0, 0)", "(-12.0, 3, 0)"),
        (1, PoseField::Seconds, 0.35, "/* here */ 0.3,", "/* here */ 0.35,"),
        (2, PoseField::Lateral, -0.02, "lateral: 0.0100", "lateral: -0.02"),
        (2, PoseField::Speed, 2.75, "speed: 2.50", "speed: 2.75"),
        // Not there yet: a new entry after the last one, nothing else.
        (2, joint("head", 1), 5.0, "(18, 0, 0)", "(18, 5, 0)"),
        (2, joint("spine", 0), -6.0, "(18, 0, 0)}", "(18, 0, 0), \"spine\": (-6, 0, 0)}"),
        (1, PoseField::Turn, 90.0, "(), // second", "(turn: 90), // second"),
        (1, joint("head", 0), 9.0, "(), // second", "(joints: { \"head\": (9, 0, 0) }), // second"),
        (0, PoseField::Curvature, 0.1, "camera: [1, 2, 3],", "camera: [1, 2, 3],\n    curvature: 0.1,"),
    ] {
        let mut document = odd();
        document.set(pose, field.clone(), value).unwrap();
        assert_eq!(document.text(), with(ODD, from, to), "{field:?}");
        assert!((document.value(pose, &field).unwrap() - value).abs() < 1e-12);
        assert!(document.undo());
        assert_eq!(document.text(), ODD);
    }
}

#[test]
fn setting_what_is_there_already_changes_nothing() {
    for file in shipped() {
        let mut document = PoseDocument::open(&file).unwrap();
        let before = document.text().to_owned();
        let poses = document.poses().clone();
        for (k, pose) in poses.poses.iter().enumerate() {
            document.set(k, PoseField::Seconds, poses.seconds[k]).unwrap();
            document.write(k, pose).unwrap();
        }
        assert_eq!(document.text(), before, "{}", file.display());
        assert!(!document.can_undo() && !document.is_dirty());
    }
}

fn shipped() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/skills/skating");
    let skills = std::fs::read_dir(folder).unwrap().filter_map(|e| Some(e.ok()?.path()));
    let files = skills.filter_map(|p| Some(p.join(format!("{}.keyposes.ron", p.file_name()?.to_str()?))));
    let files: Vec<PathBuf> = files.filter(|f| f.is_file()).collect();
    assert!(files.len() >= 7);
    files
}

/// Every change of a long random session, and each of them undone and redone.
#[test]
fn comments_order_and_unknown_fields_survive_a_long_session() {
    let comments =
        |text: &str| text.lines().filter(|l| l.trim_start().starts_with("//")).map(str::to_owned).collect::<Vec<_>>();
    for file in shipped() {
        let mut document = PoseDocument::open(&file).unwrap();
        let original = document.text().to_owned();
        let mut texts = vec![original.clone()];
        let joints: Vec<String> = document.poses().poses[0].joints.keys().cloned().collect();
        for k in 0..60_usize {
            let pose = k * 7 % document.poses().poses.len();
            let field = match k % 5 {
                0 => PoseField::Root(k % 3),
                1 => PoseField::Lateral,
                2 => PoseField::Turn,
                _ => joint(&joints[k * 5 % joints.len()], k % 3),
            };
            document.set(pose, field.clone(), k as f64 * 0.37 - 9.0).unwrap();
            document.end_gesture();
            assert!((document.value(pose, &field).unwrap() - (k as f64 * 0.37 - 9.0)).abs() < 6e-3);
            texts.push(document.text().to_owned());
        }
        assert_eq!(comments(document.text()), comments(&original), "{}", file.display());
        // What the document says is what a reader of the file finds.
        assert_eq!(KeyPoses::from_ron(document.text(), &file).unwrap(), *document.poses());
        texts.dedup();
        for text in texts.iter().rev().skip(1) {
            assert!(document.undo());
            assert_eq!(document.text(), text);
        }
        assert!(!document.undo() && !document.is_dirty());
        while document.redo() {}
        assert_eq!(Some(document.text()), texts.last().map(String::as_str));
    }
}

#[test]
fn unknown_fields_are_named_and_kept() {
    let document = odd();
    assert_eq!(document.unknown_fields(), ["author", "note", "camera"]);
    assert_eq!(document.poses().poses.len(), 3);
}

#[test]
fn a_dragged_slider_is_one_step() {
    let mut document = odd();
    for k in 0..50 {
        document.set(0, joint("shin_left", 0), f64::from(-k)).unwrap();
    }
    document.end_gesture();
    document.set(0, joint("shin_left", 0), -3.0).unwrap();
    assert!(document.undo());
    assert_eq!(document.value(0, &joint("shin_left", 0)), Some(-49.0));
    assert!(document.undo());
    assert_eq!(document.text(), ODD);
    assert!(!document.can_undo());
}

#[test]
fn poses_are_copied_moved_and_removed_with_their_times_and_comments() {
    let mut document = odd();
    let before = document.poses().clone();
    document.duplicate(0).unwrap();
    assert_eq!(document.poses().poses[0], document.poses().poses[1]);
    assert_eq!(document.poses().seconds, [0.5, 0.5, 0.3, 0.4]);
    document.remove(0).unwrap();
    assert_eq!(*document.poses(), before);
    document.swap_with_next(1).unwrap();
    assert_eq!((&document.poses().poses[1], &document.poses().poses[2]), (&before.poses[2], &before.poses[1]));
    assert_eq!(document.poses().seconds, [0.5, 0.4, 0.3]);
    assert!(document.text().contains("// third\n        (joints"), "{}", document.text());
    document.set_airborne(1, true).unwrap();
    assert!(document.poses().poses[1].airborne);
    for _ in 0..4 {
        assert!(document.undo());
    }
    assert_eq!(document.text(), ODD);
    let refused = document.swap_with_next(2).unwrap_err();
    assert!(refused.to_string().contains("pose 3"), "{refused}");
    document.remove(2).unwrap();
    document.remove(1).unwrap();
    assert!(matches!(document.remove(0), Err(DocumentError::Edit { .. })));
}

#[test]
fn a_mirror_image_of_a_mirror_image_is_the_pose() {
    for file in shipped() {
        let mut document = PoseDocument::open(&file).unwrap();
        let model = preset("skater").unwrap();
        let before = document.poses().poses[0].clone();
        document.mirror(0).unwrap();
        let image = document.poses().poses[0].clone();
        // The name of each joint of the image is one of the character's.
        assert!(image.joints.keys().all(|n| model.link_index(n).is_some()));
        let (left, right) = (before.joints["thigh_left"], image.joints["thigh_right"]);
        assert_eq!((left.0, left.1, left.2), (right.0, -right.1, -right.2));
        document.mirror(0).unwrap();
        let again = &document.poses().poses[0];
        for (name, v) in &before.joints {
            assert_eq!(again.joints[name], *v, "{name}");
        }
        while document.undo() {}
        assert!(!document.is_dirty());
    }
}

#[test]
fn files_that_are_none_are_refused_with_their_place() {
    let open = |text: &str| PoseDocument::from_text(text.into(), "x.keyposes.ron").unwrap_err().to_string();
    assert!(open("(name: \"x\",\n  poses: [(}]").contains("line 2"), "{}", open("(name: \"x\",\n  poses: [(}]"));
    assert!(open("(name: \"x\")").contains("x.keyposes.ron"));
    assert!(PoseDocument::open("/nowhere/x.keyposes.ron").unwrap_err().to_string().contains("/nowhere"));
    let mut document = odd();
    assert!(document.set(9, PoseField::Turn, 1.0).is_err());
    assert!(document.set(0, PoseField::Turn, f64::NAN).is_err());
    assert_eq!(document.text(), ODD);
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy_athlete_{name}_{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn a_file_that_somebody_else_changed_is_not_written_over() {
    let folder = folder("document");
    let file = folder.join("odd.keyposes.ron");
    std::fs::write(&file, ODD).unwrap();
    let mut document = PoseDocument::open(&file).unwrap();
    document.set(0, PoseField::Turn, 10.0).unwrap();
    assert!(document.is_dirty());
    document.save(false).unwrap();
    assert!(!document.is_dirty());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), document.text());
    std::fs::write(&file, "else").unwrap();
    document.set(0, PoseField::Turn, 20.0).unwrap();
    assert!(matches!(document.save(false), Err(DocumentError::ChangedOnDisk { .. })));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "else");
    document.save(true).unwrap();
    assert_eq!(std::fs::read_to_string(&file).unwrap(), document.text());
    std::fs::remove_dir_all(folder).unwrap();
}

/// A short glide that is found and learnt quickly.
const GLIDE: &str = r#"(
    name: "short_glide", character: "skater", speed: 2.0, seconds: [0.3, 0.3],
    poses: [(joints: {"thigh_left": (20, 0, 0), "shin_left": (-35, 0, 0), "foot_left": (15, 0, 0),
        "thigh_right": (20, 0, 0), "shin_right": (-35, 0, 0), "foot_right": (15, 0, 0)}), ()],
)"#;

fn editor() -> PoseEditor {
    let mut editor = PoseEditor::default();
    editor.edit(PoseDocument::from_text(GLIDE.into(), "short_glide.keyposes.ron").unwrap());
    assert!(matches!(editor.clip(), Some(Ok(_))), "{:?}", editor.message);
    editor
}

/// Polls until `done`; the longest poll, which must never wait for a job.
fn poll_until(editor: &mut PoseEditor, what: &str, done: impl Fn(&PoseEditor) -> bool) -> Duration {
    let (began, mut longest) = (Instant::now(), Duration::ZERO);
    while !done(editor) {
        let poll = Instant::now();
        editor.poll();
        longest = longest.max(poll.elapsed());
        assert!(began.elapsed() < Duration::from_secs(240), "{what}: {:?}", editor.message);
        std::thread::sleep(Duration::from_millis(5));
    }
    longest
}

fn quick_search() -> ReconstructOptions {
    ReconstructOptions { samples: 64, keep: 16, threads: 1, attempts: 1, ..ReconstructOptions::default() }
}

#[test]
fn poses_are_simulated_in_the_background() {
    let mut editor = editor();
    editor.simulate(quick_search());
    assert!(editor.simulating().is_some());
    let longest = poll_until(&mut editor, "simulate", |e| e.simulating().is_none());
    let found = editor.simulated().expect("it finds something").clone();
    assert!((found.control.seconds - 0.6).abs() < 0.05, "{}", found.control.seconds);
    assert!((found.motion.duration() - found.control.seconds).abs() < 0.02);
    assert!(matches!(editor.performance().1, Some(Performance::Control(_))));
    println!("longest poll while simulating: {longest:?}");
    // Other poses: what was simulated is no longer theirs.
    editor.change(|d| d.set(0, PoseField::Turn, 5.0));
    assert!(editor.simulated().is_none());
}

#[test]
fn a_search_can_be_cancelled() {
    let mut editor = editor();
    editor.simulate(ReconstructOptions { samples: 1 << 16, threads: 1, ..ReconstructOptions::default() });
    let (job, _) = editor.simulating().unwrap();
    job.cancel();
    let began = Instant::now();
    // The frame goes on at once; the thread ends at its next window.
    editor.poll();
    assert!(began.elapsed() < Duration::from_millis(200));
    let mut editor = self::editor();
    editor.simulate(ReconstructOptions { samples: 512, threads: 1, ..ReconstructOptions::default() });
    editor.simulating().unwrap().0.cancel();
    poll_until(&mut editor, "cancel", |e| e.simulating().is_none());
    assert!(editor.simulated().is_none() && editor.performance().1.is_none());
    assert!(editor.message.as_ref().unwrap().text.contains("cancelled"));
}

fn quick_plan() -> TrainPlan {
    let options = TrainOptions {
        threads: 1,
        env_batches: 1,
        ticks: 8,
        minibatch: 256,
        hidden: vec![16],
        evaluation_trials: 8,
        evaluate_every: 2,
        ..TrainOptions::default()
    };
    TrainPlan { seconds: 600.0, until: 2.0, every: 0.1, trials: 8, rate: Some(240.0), options, ..TrainPlan::default() }
}

#[test]
fn a_policy_is_learnt_shown_while_it_learns_and_saved_with_its_card() {
    let folder = folder("learnt");
    let mut editor = editor();
    editor.plan = quick_plan();
    editor.folder = folder.join("skill").display().to_string();
    editor.train();
    let longest = poll_until(&mut editor, "first policy", |e| e.performance().1.is_some());
    assert!(matches!(editor.performance().1, Some(Performance::Skill(_))));
    assert!(!editor.curve().is_empty(), "the curve grows before the policy is shown");
    let (first, _) = editor.performance();
    poll_until(&mut editor, "second policy", |e| e.performance().0 > first);
    editor.training().unwrap().0.finish();
    poll_until(&mut editor, "finish", |e| e.training().is_none());
    println!("longest poll while learning: {longest:?}");
    let learnt = editor.learnt().expect("it is done").clone();
    learnt.card.check().unwrap();
    assert_eq!(learnt.card.rows[0].trials, 8);
    // The files load as a skill of a game.
    let saved = PathBuf::from(&editor.folder);
    let skill = SkillDefinition::load(saved.join("short_glide.skill.ron")).unwrap();
    let clip = bevy_athlete::asset::clip::MotionClip::load(&skill.motion).unwrap();
    let policy = Policy::load(saved.join("policy.onnx")).unwrap();
    assert_eq!(policy.fingerprint(), learnt.card.policy);
    TrainedSkill::new(skill, &clip, policy, &preset("skater").unwrap()).unwrap();
    // The training monitor reads the curve.
    let table = bevy_athlete::ui::CurveTable::load(&saved).unwrap();
    assert_eq!(table.rows(), editor.curve().len());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_training_can_be_cancelled() {
    let mut editor = editor();
    editor.plan = quick_plan();
    editor.train();
    poll_until(&mut editor, "begin", |e| !e.curve().is_empty());
    editor.training().unwrap().0.cancel();
    poll_until(&mut editor, "cancel", |e| e.training().is_none());
    assert!(editor.learnt().is_none());
}

#[test]
fn changes_that_are_not_saved_are_not_let_go_at_once() {
    let folder = folder("let_go");
    let file = folder.join("odd.keyposes.ron");
    std::fs::write(&file, ODD).unwrap();
    let mut editor = PoseEditor::default();
    editor.open(&file);
    editor.change(|d| d.set(0, PoseField::Turn, 5.0));
    editor.open(&file);
    assert!(editor.message.as_ref().unwrap().fault && editor.document().unwrap().is_dirty());
    editor.open(&file);
    assert!(!editor.document().unwrap().is_dirty());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_selected_pose_stands_on_the_ground_and_its_points_are_marked() {
    for file in shipped() {
        let mut editor = PoseEditor::default();
        editor.open(&file);
        for k in 0..editor.document().unwrap().poses().poses.len() {
            editor.selected = k;
            editor.refresh();
            let mut links = Vec::new();
            assert!(editor.ghost(0.0, &mut links));
            assert_eq!(links.len(), editor.model().unwrap().links.len());
            assert!(!editor.marks().is_empty(), "{} pose {k}", file.display());
            assert!(editor.marks().iter().all(|m| m.place.y.abs() < 0.011));
        }
    }
}

/// Minutes long: prints how long the two buttons take on this machine with what they do by default.
#[test]
#[ignore = "minutes long; run it with --ignored --nocapture"]
fn the_buttons_by_default() {
    let mut editor = PoseEditor::default();
    editor.open(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/skills/skating/stroking/stroking.keyposes.ron"));
    editor.folder = folder("by_default").display().to_string();
    let began = Instant::now();
    editor.simulate_by_default();
    let longest = poll_until(&mut editor, "simulate", |e| e.simulating().is_none());
    println!("simulate: {:.1} s, {:?}, longest poll {longest:?}", began.elapsed().as_secs_f64(), editor.message);
    let began = Instant::now();
    editor.train();
    let longest = poll_until(&mut editor, "train", |e| e.training().is_none());
    println!("train: {:.1} s, {:?}, longest poll {longest:?}", began.elapsed().as_secs_f64(), editor.message);
    for i in editor.curve().iter().filter(|i| i.evaluation.is_some()) {
        println!("{:6.1} s: trials of {:.2} s, {:?}", i.seconds, i.length, i.evaluation);
    }
    println!("{:?}", editor.learnt().map(|l| l.card.rows.clone()));
}
