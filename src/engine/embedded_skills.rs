//! The skating skills inside the program, for games that copy no folder.

/// A file of the crate's assets: its path below `assets`, and its bytes.
macro_rules! file {
    ($path:expr) => {
        ($path, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/", $path)) as &'static [u8])
    };
}

/// The files that a skill is played from.
macro_rules! skill {
    ($name:literal) => {
        [
            file!(concat!("skills/skating/", $name, "/", $name, ".skill.ron")),
            file!(concat!("skills/skating/", $name, "/", $name, ".clip.ron")),
            file!(concat!("skills/skating/", $name, "/policy.onnx")),
        ]
    };
}

const SKILLS: [[(&str, &[u8]); 3]; 6] = [
    skill!("stroking"),
    skill!("forward_crossover"),
    skill!("backward_crossover"),
    skill!("forward_three_turn"),
    skill!("backward_three_turn"),
    skill!("double_salchow"),
];

/// All of them, and the short program.
pub(super) fn files() -> impl Iterator<Item = (&'static str, &'static [u8])> {
    SKILLS.into_iter().flatten().chain([file!("skills/skating/short_program.program.ron")])
}
