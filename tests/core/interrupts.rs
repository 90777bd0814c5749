//! Contract: Ctrl-C keeps what was found, as `--help` promises.
//!
//! Every long command is started as a person starts it, sent SIGINT once it is at work, and looked at for what it leaves and how it ends: 130,
//! with the result of what was done. Where it takes long to come to a stop, a second one ends it at once. Times are bounds for a loaded
//! machine, nothing is measured.
#![cfg(unix)]

use crate::command_line::Folder;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// No command may take longer to come to its end, s.
const LIMIT: u64 = 240;

/// A command at work, and the line of its output that said so.
struct Running {
    child: Child,
    out: BufReader<std::process::ChildStdout>,
    /// The program has been given its end; a test that fails leaves none behind.
    over: bool,
}

/// How a command ended, with its output from when it was at work.
struct Ended {
    code: Option<i32>,
    out: String,
    complaint: String,
}

impl Running {
    /// Starts a command and waits for a line with this word, which it prints when it listens to Ctrl-C.
    fn start(arguments: &[&str], word: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_athlete"));
        let mut child = command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        while !line.contains(word) {
            line.clear();
            let read = out.read_line(&mut line).unwrap();
            assert!(read > 0, "{arguments:?} ended before it said `{word}`");
        }
        Self { child, out, over: false }
    }

    /// Starts a command that says nothing until its end, and leaves it alone for a while.
    fn start_silent(arguments: &[&str], wait: Duration) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_athlete"));
        let mut child = command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::sleep(wait);
        Self { child, out, over: false }
    }

    fn interrupt(&self) {
        let sent = Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Waits for its end.
    fn end(mut self) -> Ended {
        let began = Instant::now();
        while !self.has_ended() {
            assert!(began.elapsed() < Duration::from_secs(LIMIT), "it goes on");
            std::thread::sleep(Duration::from_millis(20));
        }
        self.over = true;
        let (mut out, mut complaint) = (String::new(), String::new());
        self.out.read_to_string(&mut out).unwrap();
        self.child.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        Ended { code: self.child.wait().unwrap().code(), out, complaint }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if !self.over {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

fn run(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_athlete")).args(arguments).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn help_promises_the_code() {
    let (_, help) = run(&["--help"]);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("130 stopped by Ctrl-C") && help.contains("second Ctrl-C"), "{help}");
}

/// A training that is stopped before its first save has a policy and a checkpoint, and goes on from there.
#[test]
fn a_training_saves_what_was_learnt() {
    let folder = Folder::new("train");
    let out = folder.path("run");
    let train = ["train", "two_foot_glide", "--pods", "1", "--card-trials", "0", "--out", &out];
    let training = Running::start(&train, "results in");
    training.interrupt();
    let ended = training.end();
    assert_eq!(ended.code, Some(130), "{}", ended.complaint);
    assert!(ended.out.contains("saved in") && ended.out.contains("--resume"), "{}", ended.out);
    for file in ["policy.onnx", "checkpoint.json", "two_foot_glide.clip.ron"] {
        assert!(Path::new(&out).join(file).is_file(), "{file}");
    }
    let (code, _) = run(&[&train[..], &["--resume", "--iterations", "2"]].concat());
    assert_eq!(code, Some(0));
}

/// A search keeps the windows that it has passed. How many that are depends on the machine, so it is given longer until there are some.
#[test]
fn a_reconstruction_saves_the_windows_that_were_passed() {
    let folder = Folder::new("reconstruct");
    let (clip, control) = (folder.standing("standing.clip.ron", 1.0, 901), folder.path("out.control.ron"));
    let search = ["reconstruct", "--character", "skater", "--world", "ice", "--clip", &clip, "--out", &control];
    let search = [&search[..], &["--samples", "32", "--keep", "8", "--deviation", "0.02", "--threads", "1"]].concat();
    let mut wait = Duration::from_millis(200);
    loop {
        let searching = Running::start(&search, "follows standing");
        std::thread::sleep(wait);
        searching.interrupt();
        let ended = searching.end();
        assert_eq!(ended.code, Some(130), "{}", ended.complaint);
        if ended.complaint.contains("nothing was found") && wait < Duration::from_secs(20) {
            assert!(!Path::new(&control).exists());
            wait *= 4;
            continue;
        }
        assert!(ended.complaint.contains("saved in"), "{}", ended.complaint);
        break;
    }
    let found = bevy_athlete::control::ReconstructedControl::load(&control).unwrap();
    assert!(found.seconds > 0.0 && found.seconds < 900.0, "{}", found.seconds);
    found.check_for(&bevy_athlete::model::skater()).unwrap();
}

/// Windows that are done lie in the checkpoint; before the first one there is nothing, and that is said. Either way it is 130.
#[test]
fn an_optimisation_that_is_stopped_says_what_there_is() {
    let folder = Folder::new("optimize");
    let optimize =
        ["optimize", "stroking", "--no-samcon", "--iterations", "100000", "--threads", "1", "--out", &folder.path("")];
    let running = Running::start(&optimize, "windows");
    running.interrupt();
    let ended = running.end();
    assert_eq!(ended.code, Some(130), "{}", ended.complaint);
    let saved = Path::new(&folder.path("stroking.optimize.ron")).exists();
    let words = if saved { "--resume" } else { "no window was done" };
    assert!(ended.complaint.contains(words), "{}", ended.complaint);
    assert!(!Path::new(&folder.path("stroking.clip.ron")).exists());
}

/// Trials that were begun are counted, in a table and for a machine; a card with fewer trials than it says is not written.
#[test]
fn an_evaluation_shows_the_trials_that_were_begun() {
    let folder = Folder::new("evaluate");
    for file in ["two_foot_glide.skill.ron", "two_foot_glide.keyposes.ron", "policy.onnx"] {
        let shipped = bevy_athlete::cli::find_skill("two_foot_glide").unwrap().with_file_name(file);
        std::fs::copy(shipped, folder.0.join(file)).unwrap();
    }
    let evaluate = ["evaluate", &folder.path(""), "--trials", "1000000", "--card"];
    let evaluating = Running::start(&evaluate, "two_foot_glide of skater");
    evaluating.interrupt();
    let ended = evaluating.end();
    assert_eq!(ended.code, Some(130), "{}", ended.complaint);
    assert!(ended.complaint.contains("stopped after") && ended.complaint.contains("card"), "{}", ended.complaint);
    // The first row of the table: its name may have spaces, the numbers follow.
    let row = ended.out.lines().nth(1).unwrap();
    let trials = row.split_whitespace().find_map(|word| word.parse::<u64>().ok()).unwrap();
    assert!((8..1_000_000).contains(&trials) && trials.is_multiple_of(8), "{row}");
    assert!(!Path::new(&folder.path("card.json")).exists());

    // Nothing was stopped: so it says.
    let (code, out) = run(&["evaluate", &folder.path(""), "--trials", "1", "--json"]);
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (code, &report["stopped"], &report["rows"][0]["trials"]),
        (Some(0), &Value::Bool(false), &Value::from(1))
    );
}

/// Episodes that were begun are shown. Before the command listens, the signal ends it: then it is given longer.
#[test]
fn episodes_that_were_begun_are_shown() {
    let command = ["balance", "rest", "--seconds", "1", "--trials", "10000", "--json"];
    let mut wait = Duration::from_millis(500);
    let ended = loop {
        let running = Running::start_silent(&command, wait);
        running.interrupt();
        let ended = running.end();
        if ended.code.is_some() || wait > Duration::from_secs(30) {
            break ended;
        }
        wait *= 3;
    };
    assert_eq!(ended.code, Some(130), "{}", ended.complaint);
    let report: Value = serde_json::from_str(&ended.out).unwrap();
    let count = report["trials"].as_u64().unwrap();
    assert!((1..10_000).contains(&count) && report["stopped"] == true, "{report}");
    assert!(ended.complaint.contains(&format!("stopped after {count} of ")), "{}", ended.complaint);
}

/// A search for an affine policy saves the best one whenever it finds one.
#[test]
fn an_affine_search_says_what_there_is() {
    let folder = Folder::new("affine");
    let skill =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/families/hopper/hop_up_affine/hop_up_affine.skill.ron");
    let out = folder.path("run");
    let searching = Running::start(&["train", &skill.display().to_string(), "--affine", "--out", &out], "searched");
    searching.interrupt();
    let ended = searching.end();
    assert_eq!(ended.code, Some(130), "{}", ended.complaint);
    let saved = Path::new(&out).join("policy.onnx").is_file();
    assert!(if saved { ended.out.contains("is saved in") } else { ended.complaint.contains("no policy was found") });
}

/// A window of so many samples takes a while. The first Ctrl-C waits for its end, the second does not.
#[test]
fn the_second_one_ends_it_at_once() {
    let folder = Folder::new("second");
    let (clip, control) = (folder.standing("standing.clip.ron", 1.0, 61), folder.path("out.control.ron"));
    let search = ["reconstruct", "--character", "skater", "--world", "ice", "--clip", &clip, "--out", &control];
    let mut searching =
        Running::start(&[&search[..], &["--samples", "65536", "--threads", "1"]].concat(), "follows standing");
    let began = Instant::now();
    // Two that come before the first is heard count as one: so until it ends.
    let mut sent = 0;
    while !searching.has_ended() {
        assert!(began.elapsed() < Duration::from_secs(60), "{sent} were sent");
        searching.interrupt();
        sent += 1;
        std::thread::sleep(Duration::from_millis(100));
    }
    let ended = searching.end();
    assert_eq!(ended.code, Some(130));
    assert!(sent >= 2, "it ended by the first");
    assert!(ended.complaint.is_empty() && !Path::new(&control).exists(), "{}", ended.complaint);
}
