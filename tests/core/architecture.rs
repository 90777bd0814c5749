//! Contract: the rooms of the crate import in one direction only, as ARCHITECTURE.md says.
//!
//! A reader who opens a room has to know only the rooms before it. Without a check the arrow turns round within weeks.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms in the order in which they may import: each from those before it.
const ROOMS: [&str; 13] = [
    "math",
    "asset",
    "model",
    "dynamics",
    "contact",
    "sim",
    "control",
    "train",
    "storyboard",
    "engine",
    "ui",
    "cli",
    "app",
];

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Names of the rooms that a line of source refers to.
fn rooms_named(line: &str) -> Vec<&str> {
    let code = line.split("//").next().unwrap_or_default();
    code.match_indices("crate::")
        .map(|(at, _)| {
            let rest = &code[at + "crate::".len()..];
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            &rest[..end]
        })
        .collect()
}

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for (place, room) in ROOMS.iter().enumerate() {
        let mut files = Vec::new();
        rust_files(&source.join(room), &mut files);
        assert!(!files.is_empty(), "room {room} is empty");
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            for (number, line) in text.lines().enumerate() {
                for named in rooms_named(line) {
                    checked += 1;
                    if ROOMS.iter().position(|r| *r == named).is_some_and(|other| other > place) {
                        let file = file.strip_prefix(&source).unwrap().display();
                        wrong.push(format!("{file}:{}: {room} imports from {named}", number + 1));
                    }
                }
            }
        }
    }
    println!("{checked} references between rooms");
    assert!(wrong.is_empty(), "imports against the arrow:\n{}", wrong.join("\n"));
}
