//! Contract: who opens a file has to know only what comes before it.
//!
//! Rooms import in one direction, as ARCHITECTURE.md says, and inside a room no files import each other in a circle. Without a
//! check the arrow turns round within weeks. Imports are read from the source (`source.rs`): nested `use` trees, `super::`, paths
//! in code and names that came by a re-export count alike, because a check of lines that begin with `use crate::` misses most of
//! them.

mod source;

use source::{Crate, Import};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Rooms in the order in which they may import: each from those of the rows before its own.
const ROOMS: [&[&str]; 11] = [
    &["math"],
    &["asset"],
    &["model"],
    &["dynamics"],
    &["contact"],
    &["sim"],
    &["control"],
    &["skill"],
    &["train", "storyboard", "engine", "scenes"],
    &["ui", "cli"],
    // The last row has `lib.rs` itself, whose prelude hands on names of all rooms.
    &["app", "guide", ""],
];

fn lib() -> Crate {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    Crate::read(&folder, "lib.rs", &["bin/", "main.rs"])
}

fn row(module: &[String]) -> Option<usize> {
    let room = module.first().map_or("", String::as_str);
    ROOMS.iter().position(|row| row.contains(&room))
}

/// Imports of a room from one of its own row or a later one.
fn against_the_arrow(source: &Crate, imports: &BTreeSet<Import>) -> Vec<String> {
    let wrong = imports.iter().filter(|i| i.from.first() != i.to.first() && row(&i.to) >= row(&i.from));
    wrong.map(|i| format!("{}:{} imports from {}", source.file(&i.from), i.line, source.file(&i.to))).collect()
}

/// A shortest circle through the files of every knot of files that all lead to each other. A file and the files of its own folder
/// are one thing seen at two distances: a parent that declares and re-exports its children, and children that use what the
/// parent defines, are no circle.
fn circles(source: &Crate, imports: &BTreeSet<Import>) -> Vec<String> {
    let mut ahead: BTreeMap<&[String], BTreeMap<&[String], usize>> = BTreeMap::new();
    for i in imports.iter().filter(|i| !i.from.starts_with(&i.to) && !i.to.starts_with(&i.from)) {
        ahead.entry(&i.from).or_default().entry(&i.to).or_insert(i.line);
    }
    let mut found: BTreeMap<BTreeSet<&[String]>, Vec<&[String]>> = BTreeMap::new();
    for start in ahead.keys() {
        // Breadth first, until the start is reached again.
        let mut before: BTreeMap<&[String], &[String]> = BTreeMap::new();
        let mut queue = std::collections::VecDeque::from([*start]);
        while let Some(at) = queue.pop_front() {
            for next in ahead.get(at).into_iter().flat_map(BTreeMap::keys) {
                if !before.contains_key(next) {
                    before.insert(next, at);
                    queue.push_back(next);
                }
            }
        }
        if before.contains_key(start) {
            let mut circle = vec![*start];
            let mut at = before[start];
            while at != *start {
                circle.push(at);
                at = before[at];
            }
            circle[1..].reverse();
            found.entry(circle.iter().copied().collect()).or_insert(circle);
        }
    }
    let told = |circle: Vec<&[String]>| {
        let first = circle.iter().copied().cycle().skip(1);
        let steps =
            circle.iter().zip(first).map(|(a, b)| format!("{}:{} -> {}", source.file(a), ahead[a][b], source.file(b)));
        steps.collect::<Vec<_>>().join(", ")
    };
    found.into_values().map(told).collect()
}

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let source = lib();
    let strangers: Vec<&str> = source
        .files()
        .filter(|f| row(&[f.split('/').next().unwrap().trim_end_matches(".rs").to_owned()]).is_none())
        .collect();
    assert!(strangers.is_empty() || strangers == ["lib.rs"], "rooms without a place in the order: {strangers:?}");
    let (imports, lost) = source.imports();
    let between = imports.iter().filter(|i| i.from.first() != i.to.first()).count();
    println!("{} files, {} imports of one by another, {between} between rooms", source.files().count(), imports.len());
    assert!(lost.is_empty(), "paths that lead nowhere, as far as this test can read:\n{}", lost.join("\n"));
    let wrong = against_the_arrow(&source, &imports);
    assert!(wrong.is_empty(), "imports against the arrow:\n{}", wrong.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bin/athlete");
    for source in [lib(), Crate::read(&folder, "main.rs", &[])] {
        let circles = circles(&source, &source.imports().0);
        assert!(circles.is_empty(), "{} circles of files:\n{}", circles.len(), circles.join("\n"));
    }
}

#[test]
fn no_file_takes_everything_of_another() {
    let source = lib();
    // The prelude is all of the engine by intention.
    let stars = source.imports().0.into_iter().filter(|i| i.star && !i.from.is_empty());
    let stars: Vec<String> = stars.map(|i| format!("{}:{}", source.file(&i.from), i.line)).collect();
    assert!(stars.is_empty(), "a star hides what is imported:\n{}", stars.join("\n"));
}

/// Files of a small crate, and what is expected of it: the wrong imports and the circles.
fn found(files: &[(&str, &str)]) -> (Vec<String>, Vec<String>) {
    let source = Crate::new(files.iter().copied(), "lib.rs");
    let (imports, lost) = source.imports();
    assert!(lost.is_empty(), "{lost:?}");
    (against_the_arrow(&source, &imports), circles(&source, &imports))
}

#[test]
fn an_import_is_found_however_it_is_written() {
    let sim = ("sim/mod.rs", "mod step;\npub use step::step;\npub struct Simulator;");
    let step =
        ("sim/step.rs", "pub fn step() {}\nmacro_rules! make { ($n:ident) => { pub struct $n; } }\nmake!(Made);");
    let writings = [
        "use crate::sim::Simulator;",
        "use crate::{math::Real, sim::{step, Simulator as S}};",
        "use crate::sim::step::Made;",
        "use super::super::sim;",
        "pub(crate) use super::super::sim::step;",
        "fn f() { let _ = crate::sim::step(); }",
        "fn f(_: &super::super::sim::Simulator) {}",
        "mod tests { use super::*; use super::super::super::sim::Simulator; }",
        "use {crate::math::Real, crate::sim::*};",
        "const A: char = '\"'; const B: &str = r#\"\"\"#; fn f<'a>(_: &'a crate::sim::Simulator) {}",
    ];
    for writing in writings {
        let files = [
            ("lib.rs", ""),
            ("math/mod.rs", "pub trait Real {}"),
            ("model/mod.rs", ""),
            ("model/a.rs", writing),
            sim,
            step,
        ];
        let (wrong, _) = found(&files);
        assert!(!wrong.is_empty() && wrong.iter().all(|w| w.starts_with("model/a.rs:1")), "{writing}: {wrong:?}");
    }
    for harmless in [
        "// use crate::sim::Simulator;",
        "/* /* */ use crate::sim::Simulator; */",
        "const A: &str = \"crate::sim::Simulator\";",
        "const A: &str = r#\"\"crate::sim::Simulator\"#;",
        "use crate::math::Real;",
        "mod tests { use super::*; }",
    ] {
        let files = [
            ("lib.rs", ""),
            ("math/mod.rs", "pub trait Real {}"),
            ("model/mod.rs", ""),
            ("model/a.rs", harmless),
            sim,
            step,
        ];
        assert_eq!(found(&files), (vec![], vec![]), "{harmless}");
    }
}

#[test]
fn a_circle_is_found_through_re_exports_and_a_family_is_none() {
    let circle = [
        ("lib.rs", ""),
        ("sim/mod.rs", "mod a;\nmod b;\nmod c;\npub use a::A;\npub use b::*;\npub struct Parent;"),
        ("sim/a.rs", "use super::B;\npub struct A(B);"),
        ("sim/b.rs", "\nuse crate::sim::c::C;\npub struct B(C);"),
        ("sim/c.rs", "use super::{A, Parent};\npub struct C;"),
    ];
    let (wrong, circles) = found(&circle);
    assert_eq!(wrong, Vec::<String>::new());
    assert_eq!(circles, ["sim/a.rs:1 -> sim/b.rs, sim/b.rs:2 -> sim/c.rs, sim/c.rs:1 -> sim/a.rs"]);
    let family = [
        ("lib.rs", "pub mod prelude { pub use crate::sim::A; }"),
        ("sim/mod.rs", "mod a;\nuse a::A;\npub struct Parent(A);"),
        ("sim/a.rs", "mod check;\nuse super::Parent;\npub struct A;\nfn f() { check::check() }"),
        ("sim/a/check.rs", "use super::A;\nuse crate::sim::Parent;\npub fn check() {}"),
    ];
    assert_eq!(found(&family), (vec![], vec![]));
}
