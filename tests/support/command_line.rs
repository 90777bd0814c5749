//! The `athlete` program started as a user starts it, and a folder of its own for a test.

use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A run of the program.
pub fn athlete(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_athlete")).args(arguments).output().unwrap()
}

/// Stdout of a run that has to succeed.
pub fn done(arguments: &[&str]) -> String {
    let output = athlete(arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {:?}\n{text}\n{complaint}", output.status);
    text
}

/// A run that has to end with this code and say all of these words on stderr, and no words of the program's inside.
pub fn refused(code: i32, arguments: &[&str], words: &[&str]) {
    let output = athlete(arguments);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {complaint}");
    for word in words {
        assert!(complaint.contains(word), "{arguments:?}: `{word}` is missing in: {complaint}");
    }
    for inside in ["Some(", "None", "panicked"] {
        assert!(!complaint.contains(inside), "{arguments:?}: `{inside}` in: {complaint}");
    }
}

/// A folder of its own for a test, gone when the test ends.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        static MADE: AtomicUsize = AtomicUsize::new(0);
        let made = MADE.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("athlete-test-{}-{made}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    pub fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).unwrap();
        self.path(name)
    }

    /// A clip of the skater's zero pose, so many times.
    pub fn standing(&self, name: &str, frame_rate: f64, poses: usize) -> String {
        let pose =
            "(root_position: (0.0, 0.9, 0.0), root_rotation: (0.0, 0.0, 0.0, 1.0), joints: [(0.0, 0.0, 0.0, 1.0)]),\n";
        let poses = pose.repeat(poses);
        let text =
            format!("(name: \"standing\", frame_rate: {frame_rate:?}, joints: [\"abdomen\"], poses: [\n{poses}])");
        self.write(name, &text)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
