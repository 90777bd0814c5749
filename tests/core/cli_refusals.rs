//! Contract: nothing is lost and nothing is silent on the command line.
//!
//! What cannot be done is refused before the work, by the option as it was typed, what was given and what would be valid, with exit
//! code 2; what fails later ends with 1. No earlier result is replaced unasked, what lies in a folder belongs together, and a command
//! that only looks writes nothing. Each kind was found by somebody who lost an hour of work, or believed a wrong number.

use crate::command_line::{Folder, done, refused};
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::contact::World;
use bevy_athlete::model::skater;
use bevy_athlete::train::{ReconstructError, ReconstructOptions, reconstruct};
use serde_json::Value;
use std::path::Path;

#[test]
fn wrong_arguments_are_named_and_end_with_2() {
    let folder = Folder::new("arguments");
    let clip = folder.standing("standing.clip.ron", 10.0, 3);
    let bvh = folder.path("wave.bvh");
    std::fs::write(&bvh, "HIERARCHY").unwrap();
    let out = folder.path("out");
    let train = ["train", "two_foot_glide", "--out", &out];
    let imitate = ["train", "--clip", &clip, "--character", "skater", "--out", &out];
    let simulate = ["simulate", "--character", "skater", "--motion", &clip];
    let reconstruct = ["reconstruct", "--character", "skater", "--clip", &clip];
    let evaluate = ["evaluate", "two_foot_glide"];
    let table: &[(&[&str], &[&str], &[&str])] = &[
        (&train, &["--until", "nan"], &["--until NaN", "0 to 100 percent"]),
        (&train, &["--until", "101"], &["--until 101", "0 to 100 percent"]),
        (&train, &["--iterations", "0"], &["--iterations 0", "1 to"]),
        (&train, &["--minutes", "0"], &["--minutes 0", "more than 0"]),
        (&train, &["--threads", "0"], &["--threads 0", "1 to 256"]),
        (&train, &["--epochs", "0"], &["--epochs 0", "1 to 1000"]),
        (&train, &["--card-trials", "9999999"], &["--card-trials 9999999", "1000000"]),
        (&train, &["--discount", "1.5"], &["--discount 1.5"]),
        (&train, &["--hidden", "0"], &["--hidden 0", "1 to 4096"]),
        (&train, &["--hidden", "wide"], &["--hidden wide", "128,128"]),
        (&train, &["--rate", "100"], &["--rate 100", "120"]),
        (&imitate, &["--gains=-1,2"], &["--gains -1,2", "0 to 1e6"]),
        (&imitate, &["--gains", "600"], &["--gains 600", "600,49"]),
        (&["train", &bvh], &[], &["that is a motion", "--clip"]),
        (&["train", "glide"], &[], &["glide", "two_foot_glide", ".skill.ron"]),
        (&evaluate, &["--threads", "0"], &["--threads 0"]),
        (&evaluate, &["--trials", "0"], &["--trials 0", "1 to 1000000"]),
        (&evaluate, &["--push=-1"], &["--push -1", "0 to 100000 N"]),
        (&evaluate, &["--speed", "3..1"], &["--speed 3..1", "0..2.5"]),
        (&evaluate, &["--card", "--push", "100"], &["--card", "--push"]),
        (&evaluate, &["--trace", "/no/such/folder/x"], &["--trace /no/such/folder/x"]),
        (&reconstruct, &["--attempts", "0"], &["--attempts 0", "1 to 100"]),
        (&reconstruct, &["--samples", "1"], &["--samples 1", "4 to"]),
        (&reconstruct, &["--storyboard", "/no/such/folder/x.png"], &["--storyboard /no/such/folder/x.png"]),
        (&simulate, &["--seconds=-1"], &["--seconds -1", "0 to 3600 s"]),
        (&simulate, &["--rate", "1"], &["--rate 1", "30 to 20000"]),
        (&simulate, &["--push", "head:0,0,5:9:0.1"], &["--push head:0,0,5:9:0.1", "before the end, at 0.2 s"]),
        (&simulate, &["--push", "head:0,0:0:1"], &["three components"]),
        (&simulate, &["--world", "moon"], &["moon", "slope:DEGREES"]),
        (&simulate, &["--storyboard", &folder.path("")], &["--storyboard", "a folder"]),
        (&["simulate", "--motion", &clip], &[], &["--character", "runner"]),
        (&["optimize", "stroking", "--out", &out], &["--iterations", "0"], &["--iterations 0"]),
        (&["program", "short"], &[], &["program short", ".program.ron"]),
        (&["show", &clip, "--storyboard", &folder.path("x.png")], &["--figures", "0"], &["--figures 0", "1 to 64"]),
        (&["info"], &["--character", "skatr"], &["skatr", "skater"]),
        (&["bench"], &["--lanes", "3 x f16"], &["--lanes 3 x f16", "8 x f32"]),
    ];
    for (command, options, words) in table {
        refused(2, &[*command, *options].concat(), words);
    }
}

#[test]
fn what_fails_ends_with_1() {
    let folder = Folder::new("failures");
    let one = folder.standing("one.clip.ron", 10.0, 1);
    refused(1, &["simulate", "--character", "skater", "--motion", &folder.path("none.bvh")], &["none.bvh"]);
    refused(1, &["evaluate", &folder.path("none.onnx")], &["none.onnx"]);
    refused(1, &["reconstruct", "--character", "skater", "--clip", &one], &["one.clip.ron", "nothing to follow"]);
}

/// Trains for one iteration.
fn train<'a>(out: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    let run = ["train", "two_foot_glide", "--iterations", "1", "--pods", "1", "--card-trials", "0", "--out", out];
    [&run[..], rest].concat()
}

#[test]
fn a_folder_of_a_training_belongs_together() {
    let folder = Folder::new("train");
    let out = folder.path("run");
    done(&train(&out, &[]));
    let read = |name: &str| std::fs::read(Path::new(&out).join(name)).unwrap();
    let (policy, motion) = (read("policy.onnx"), read("two_foot_glide.clip.ron"));
    // Again: refused, and nothing is touched.
    refused(2, &train(&out, &["--seed", "7"]), &["policy.onnx", "--resume", "--force"]);
    assert!(read("policy.onnx") == policy && read("two_foot_glide.clip.ron") == motion);
    std::fs::write(Path::new(&out).join("card.json"), "of an earlier policy").unwrap();
    done(&train(&out, &["--seed", "7", "--force"]));
    assert!(read("policy.onnx") != policy && !Path::new(&out).join("card.json").exists());

    // The motion of another run beside the policy: neither tried nor gone on from.
    let other = String::from_utf8(motion.clone()).unwrap().replacen("name: \"", "name: \"another_", 1);
    assert_ne!(other.as_bytes(), motion);
    std::fs::write(Path::new(&out).join("two_foot_glide.clip.ron"), other).unwrap();
    refused(1, &["evaluate", &out, "--trials", "8"], &["two_foot_glide.clip.ron", "fingerprint", "policy.onnx"]);
    refused(2, &train(&out, &["--resume"]), &["--resume", "another motion"]);
    std::fs::write(Path::new(&out).join("two_foot_glide.clip.ron"), &motion).unwrap();

    // So many trials as were asked for, and nothing written unless asked.
    let report: Value = serde_json::from_str(&done(&["evaluate", &out, "--trials", "3", "--json"])).unwrap();
    assert_eq!(report["rows"][0]["trials"], 3);
    assert!(!Path::new(&out).join("card.json").exists());
    done(&["evaluate", &out, "--trials", "3", "--card"]);
    assert!(Path::new(&out).join("card.json").exists());
}

#[test]
fn a_control_is_not_replaced_unasked() {
    let folder = Folder::new("reconstruct");
    let clip = folder.standing("standing.clip.ron", 10.0, 2);
    let control = folder.path("out.control.ron");
    std::fs::write(&control, "hours of work").unwrap();
    let run =
        ["reconstruct", "--character", "skater", "--clip", &clip, "--samples", "4", "--keep", "1", "--attempts", "1"];
    refused(2, &[&run[..], &["--out", &control]].concat(), &["--out would replace", "out.control.ron", "--force"]);
    assert_eq!(std::fs::read_to_string(&control).unwrap(), "hours of work");
    let optimize = ["optimize", "stroking", "--iterations", "1"];
    refused(2, &optimize, &["stroking.control.ron", "--force"]);
}

/// A trace that fills a disk is told before it does; the estimate is near.
#[test]
fn the_size_of_a_large_trace_is_told() {
    let folder = Folder::new("trace");
    let (clip, trace) = (folder.standing("standing.clip.ron", 10.0, 2), folder.path("out.jsonl"));
    let simulate = ["simulate", "--character", "skater", "--motion", &clip, "--trace", &trace];
    done(&simulate);
    let (bytes, lines) = (std::fs::metadata(&trace).unwrap().len() as f64, 120.0);
    let estimate = bevy_athlete::cli::trace_bytes(skater().links.len(), lines);
    assert!((estimate / bytes - 1.0).abs() < 0.3, "{estimate} for {bytes}");
}

/// A search that is stopped gives the control of the windows that it has passed, and one that has not passed any says so.
#[test]
fn a_search_that_is_stopped_keeps_what_it_found() {
    let folder = Folder::new("stopped");
    let model = skater();
    let clip = MotionClip::load(folder.standing("standing.clip.ron", 10.0, 11)).unwrap();
    let (clip, _) = clip.lifted_clear(&model).unwrap();
    let options = ReconstructOptions { samples: 8, keep: 2, deviation: 0.02, threads: 1, ..Default::default() };
    let search = |last: usize| reconstruct(&model, &World::ice(), "ice", &clip, &options, |news| news.window < last);
    let found = search(4).unwrap();
    assert!(found.stopped && found.control.offsets.len() == 4);
    assert!((found.control.seconds - 4.0 * 0.06).abs() < 1e-12, "{}", found.control.seconds);
    found.control.check_for(&model).unwrap();
    assert_eq!(found.report.fell_at, None);
    assert!(matches!(search(0), Err(ReconstructError::Cancelled)));
}
