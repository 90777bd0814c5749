//! Contract: what people have lost work by on a command line, a kind at a time, for every command that has the kind.
//!
//! One command that was mended says nothing of the next one that reads a file or writes a picture. So here every option that names an output
//! is given a place that cannot be, and every one that names an input a file without an end; all are refused at once, by name. Besides:
//! a motion of one pose, one that is too long, and a trace that would fill a disk.

use crate::command_line::{Folder, athlete};
use std::path::Path;

fn asset(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name).display().to_string()
}

#[test]
fn every_output_is_tried_before_the_work() {
    let folder = Folder::new("outputs");
    std::fs::write(folder.path("file"), "a file where a folder is needed").unwrap();
    let (nowhere, joints) = (folder.path("file/x"), folder.path("joints.json"));
    // Never read: the place is tried first.
    std::fs::write(&joints, "[]").unwrap();
    let clip = folder.standing("standing3.clip.ron", 10.0, 3);
    let poses = asset("skills/skating/stroking/stroking.keyposes.ron");
    let body = ["--character", "skater"];
    let simulate = [&["simulate", "--motion", &clip], &body[..]].concat();
    let reconstruct = [&["reconstruct", "--clip", &clip], &body[..]].concat();
    let table: &[(&[&str], &str, &str)] = &[
        (&simulate, "--trace", ""),
        (&simulate, "--storyboard", ".png"),
        (&simulate, "--record", ".clip.ron"),
        (&reconstruct, "--out", ".control.ron"),
        (&reconstruct, "--storyboard", ".png"),
        (&reconstruct, "--record", ".clip.ron"),
        (&["optimize", "stroking"], "--out", ""),
        (&["import-joints", &joints], "--out", ".keyposes.ron"),
        (&["map", "walk.bvh"], "--out", ".map.ron"),
        (&["map", "walk.bvh"], "--storyboard", ".png"),
        (&["join", &clip, &clip, "--character", "skater"], "--out", ".clip.ron"),
        (&["show", &poses], "--storyboard", ".png"),
        (&["foot-pose"], "--storyboard", ".png"),
        (&["balance", "rest", "--trials", "10000"], "--storyboard", ".png"),
        (&["train", "two_foot_glide"], "--out", ""),
        (&["evaluate", "two_foot_glide"], "--storyboard", ".png"),
        (&["evaluate", "two_foot_glide"], "--trace", ""),
        (&["program", "short_program"], "--storyboard", ".png"),
        (&["program", "short_program"], "--trace", ""),
        (&["course", &asset("courses/stairs.course.ron")], "--storyboard", ".png"),
        (&["gait"], "--plot", ".png"),
        (&["gait"], "--csv", ".csv"),
        (&["gait"], "--sto", ".sto"),
        (&["gait"], "--mot", ".mot"),
        (&["export", &folder.path("run")], "--out", ""),
    ];
    for (command, option, ending) in table {
        let output = athlete(&[*command, &[option, &format!("{nowhere}{ending}")]].concat());
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{command:?} {option}: {complaint}");
        assert!(complaint.contains(&format!("{option} {nowhere}")), "{command:?}: {complaint}");
    }
}

/// A link to a device that never ends stands for every file that is not what its name says.
#[cfg(unix)]
#[test]
fn every_input_is_a_regular_file() {
    let folder = Folder::new("inputs");
    let clip = folder.standing("standing3.clip.ron", 10.0, 3);
    let run = folder.path("run");
    std::fs::create_dir_all(&run).unwrap();
    let endless = |name: &str| {
        let path = folder.path(name);
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        path
    };
    let (out, picture) = (folder.path("out"), folder.path("out.png"));
    let body = ["--character", "skater"];
    let simulate = |option: &'static str, file: String| {
        let given = [option, &file].map(str::to_owned);
        let start = ["simulate", "--character", "skater", "--motion", &clip].map(str::to_owned);
        let start = if option == "--motion" { &start[..3] } else { &start[..] };
        [start, &given].concat()
    };
    let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
    let train = ["train", "two_foot_glide", "--iterations", "1", "--pods", "1"];
    endless("run/checkpoint.json");
    endless("run/stroking.optimize.ron");
    let mut commands = vec![
        simulate("--motion", endless("x.bvh")),
        simulate("--motion", endless("x.clip.ron")),
        simulate("--motion", endless("x.keyposes.ron")),
        simulate("--course", endless("x.course.ron")),
        words(&["simulate", "--control", &endless("x.control.ron")]),
        words(&["info", "--character", &endless("x.character.ron")]),
        words(&["info", "--policy", &endless("x.onnx")]),
        words(&["evaluate", &folder.path("x.onnx")]),
        words(&["export", &folder.path("x.onnx"), "--out", &out]),
        words(&["import-joints", &endless("x.json"), "--out", &folder.path("new.keyposes.ron")]),
        words(&["map", &folder.path("x.bvh")]),
        words(&["gait", "--people", &endless("x.csv")]),
        words(&["course", &folder.path("x.course.ron")]),
        words(&["show", &folder.path("x.keyposes.ron"), "--storyboard", &picture]),
        words(&["program", &endless("x.program.ron")]),
        words(&["train", &endless("x.skill.ron"), "--out", &out]),
        words(&["optimize", &folder.path("x.keyposes.ron"), "--out", &out]),
        words(&["optimize", "stroking", "--resume", "--out", &run]),
    ];
    commands.push(words(&[&train[..], &["--out", &out, "--from", &folder.path("x.onnx")]].concat()));
    commands.push(words(&[&train[..], &["--out", &run, "--resume"]].concat()));
    commands.push(words(&[&["reconstruct", "--clip", &folder.path("x.clip.ron")], &body[..]].concat()));
    for command in commands {
        let arguments: Vec<&str> = command.iter().map(String::as_str).collect();
        let output = athlete(&arguments);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {complaint}");
        assert!(complaint.contains("a device; valid: a regular file"), "{command:?}: {complaint}");
    }
}

/// One pose says nothing of how to move.
#[test]
fn a_single_pose_is_nothing_to_follow() {
    let folder = Folder::new("one");
    let (one, out) = (folder.standing("standing1.clip.ron", 10.0, 1), folder.path("run"));
    let body = ["--character", "skater"];
    for command in [&["reconstruct", "--clip", &one][..], &["train", "--clip", &one, "--out", &out]] {
        let output = athlete(&[command, &body].concat());
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {complaint}");
        assert!(complaint.contains("standing1.clip.ron: 1 pose, so nothing to follow"), "{command:?}: {complaint}");
    }
    assert!(!Path::new(&out).exists(), "nothing was begun");
}

/// A clip that is too long is refused as itself, not by an option that there is not.
#[test]
fn a_clip_that_is_too_long_to_search_is_named() {
    let folder = Folder::new("long");
    let long = folder.standing("standing10100.clip.ron", 10.0, 10_100);
    let output = athlete(&["reconstruct", "--clip", &long, "--character", "skater"]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{complaint}");
    assert!(complaint.contains("standing10100.clip.ron: ") && complaint.contains("at most 100000"), "{complaint}");
    assert!(!complaint.contains("--tick-rate"), "{complaint}");
}

/// How large a trace gets is told before it is written; here onto a disk that is full.
#[cfg(target_os = "linux")]
#[test]
fn a_trace_that_fills_a_disk_is_told_before() {
    let folder = Folder::new("trace");
    let clip = folder.standing("standing3.clip.ron", 10.0, 3);
    let simulate = ["simulate", "--character", "skater", "--motion", &clip, "--seconds", "600"];
    let output = athlete(&[&simulate[..], &["--trace", "/dev/full"]].concat());
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{complaint}");
    assert!(complaint.contains("note: the trace of 720000 steps will take about 5."), "{complaint}");
    assert!(complaint.contains("cannot write /dev/full"), "{complaint}");
}
