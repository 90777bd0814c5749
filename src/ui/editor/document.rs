//! A key-pose file that is being edited: the text is what counts, and only the values that change are replaced in it.

use crate::asset::read_file::read_text;
use crate::model::{KeyPose, KeyPoseError, KeyPoses};
use crate::ui::editor::patch::{Patcher, number};
use crate::ui::editor::spans::{Node, Sequence, SpanFault};
use std::path::{Path, PathBuf};

/// Fields that the crate reads of a file and of a pose; others are kept and named in [`PoseDocument::unknown_fields`].
const FILE_FIELDS: &[&str] = &[
    "name",
    "character",
    "speed",
    "curvature",
    "acceleration",
    "mass_on_path",
    "seconds",
    "contacts",
    "poses",
    "mirrored",
    "repeat",
    "frame_rate",
    "windows",
    "optimize",
];
const POSE_FIELDS: &[&str] = &["lateral", "height", "support", "turn", "airborne", "root", "joints"];

/// Decimals of degrees, of metres, and of seconds.
const DEGREES: i32 = 2;
const METRES: i32 = 4;
const SECONDS: i32 = 4;
/// Most steps that can be undone.
const UNDO: usize = 1000;
/// Largest file, bytes.
const MOST_BYTES: usize = 4 << 20;

/// Why a file could not be opened, changed or saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DocumentError {
    /// The file could not be read or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The text is not RON.
    #[error("{}, line {line}: {reason}; valid: a .keyposes.ron file", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The text is RON, but not key poses.
    #[error(transparent)]
    Poses(#[from] KeyPoseError),
    /// The file was changed by somebody else since it was opened.
    #[error("{}: changed on disk since it was opened; valid: save it under another name, or anyway", path.display())]
    ChangedOnDisk {
        /// The file.
        path: PathBuf,
    },
    /// What was asked for is not there or cannot be.
    #[error("{place}: {found}; valid: {valid}")]
    Edit {
        /// Pose and field.
        place: String,
        /// What was asked for.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

/// A number of a pose, or of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseField {
    /// Component (0 to 2) of a joint's rotation vector, degrees.
    Joint(String, usize),
    /// Component of the root's rotation vector, degrees.
    Root(usize),
    /// Place beside the path, m.
    Lateral,
    /// Height of the root, m.
    Height,
    /// Turn about the vertical, degrees.
    Turn,
    /// Time to the next pose, s.
    Seconds,
    /// Speed of the file, m/s.
    Speed,
    /// Curvature of the file, 1/m.
    Curvature,
    /// Acceleration of the file, m/s^2.
    Acceleration,
}

/// One step of the history.
#[derive(Clone, Debug)]
struct Edit {
    at: usize,
    removed: String,
    inserted: String,
}

impl Edit {
    /// What turns `old` into `new`.
    fn between(old: &str, new: &str) -> Self {
        let mut at = old.bytes().zip(new.bytes()).take_while(|(a, b)| a == b).count();
        while !old.is_char_boundary(at) || !new.is_char_boundary(at) {
            at -= 1;
        }
        let most = old.len().min(new.len()) - at;
        let mut tail = old.bytes().rev().zip(new.bytes().rev()).take(most).take_while(|(a, b)| a == b).count();
        while !old.is_char_boundary(old.len() - tail) || !new.is_char_boundary(new.len() - tail) {
            tail -= 1;
        }
        Self { at, removed: old[at..old.len() - tail].to_owned(), inserted: new[at..new.len() - tail].to_owned() }
    }

    fn reversed(&self) -> Self {
        Self { at: self.at, removed: self.inserted.clone(), inserted: self.removed.clone() }
    }
}

/// A key-pose file under edit.
#[derive(Clone, Debug)]
pub struct PoseDocument {
    path: PathBuf,
    text: String,
    /// The text on disk, as far as is known.
    on_disk: String,
    poses: KeyPoses,
    unknown: Vec<String>,
    undo: Vec<Edit>,
    redo: Vec<Edit>,
    /// Changes of this number join the last step of the history.
    gesture: Option<(usize, PoseField)>,
    revision: u64,
}

impl PoseDocument {
    /// Opens a file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, DocumentError> {
        let path = path.as_ref();
        let text = read_text(path, MOST_BYTES as u64)
            .map_err(|e| DocumentError::File { path: path.to_path_buf(), reason: e.fault.to_string() })?;
        Self::from_text(text, path)
    }

    /// A document of this text; `path` is where it is saved to.
    pub fn from_text(text: String, path: impl AsRef<Path>) -> Result<Self, DocumentError> {
        let path = path.as_ref().to_path_buf();
        if text.len() > MOST_BYTES {
            let reason = format!("{} bytes; valid: at most {MOST_BYTES}", text.len());
            return Err(DocumentError::File { path, reason });
        }
        let (poses, unknown) = read(&text, &path)?;
        Ok(Self {
            on_disk: text.clone(),
            path,
            text,
            poses,
            unknown,
            undo: Vec::new(),
            redo: Vec::new(),
            gesture: None,
            revision: 0,
        })
    }

    /// Where it is saved to.
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// The text as it would be saved.
    pub fn text(&self) -> &str {
        &self.text
    }
    /// What the text says.
    pub fn poses(&self) -> &KeyPoses {
        &self.poses
    }
    /// Fields of the file that the crate does not know; they are kept.
    pub fn unknown_fields(&self) -> &[String] {
        &self.unknown
    }
    /// Whether it differs from the file.
    pub fn is_dirty(&self) -> bool {
        self.text != self.on_disk
    }
    /// Grows with every change, undone ones included.
    pub fn revision(&self) -> u64 {
        self.revision
    }
    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }
    /// Whether there is something to redo.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Writes the file, whole or not at all. Unless `anyway`, a file that somebody else changed is left alone.
    pub fn save(&mut self, anyway: bool) -> Result<(), DocumentError> {
        let failed = |e: std::io::Error| DocumentError::File { path: self.path.clone(), reason: e.to_string() };
        let changed = std::fs::read_to_string(&self.path).is_ok_and(|now| now != self.on_disk);
        if changed && !anyway {
            return Err(DocumentError::ChangedOnDisk { path: self.path.clone() });
        }
        let mut part = self.path.as_os_str().to_owned();
        part.push(".part");
        std::fs::write(&part, &self.text).and_then(|()| std::fs::rename(&part, &self.path)).map_err(failed)?;
        self.on_disk.clone_from(&self.text);
        Ok(())
    }

    /// Writes it to another file, which is its own from then on.
    pub fn save_as(&mut self, path: impl AsRef<Path>) -> Result<(), DocumentError> {
        let before = std::mem::replace(&mut self.path, path.as_ref().to_path_buf());
        let saved = self.save(true);
        if saved.is_err() {
            self.path = before;
        }
        saved
    }

    /// The number in a field of a pose; zero where the file leaves it out.
    pub fn value(&self, pose: usize, field: &PoseField) -> Option<f64> {
        let p = self.poses.poses.get(pose)?;
        let part = |v: (f64, f64, f64), k: usize| [v.0, v.1, v.2].get(k).copied();
        match field {
            PoseField::Joint(name, k) => part(p.joints.get(name).copied().unwrap_or_default(), *k),
            PoseField::Root(k) => part(p.root, *k),
            PoseField::Lateral => Some(p.lateral),
            PoseField::Height => p.height,
            PoseField::Turn => Some(p.turn),
            PoseField::Seconds => self.poses.seconds.get(pose).copied(),
            PoseField::Speed => Some(self.poses.speed),
            PoseField::Curvature => Some(self.poses.curvature),
            PoseField::Acceleration => Some(self.poses.acceleration),
        }
    }

    /// Sets a number. Changes of the same one, without anything between, are one step of the history until
    /// [`PoseDocument::end_gesture`]: a slider that is dragged.
    pub fn set(&mut self, pose: usize, field: PoseField, value: f64) -> Result<(), DocumentError> {
        if !value.is_finite() {
            let found = value.to_string();
            return Err(DocumentError::Edit { place: format!("{field:?}"), found, valid: "a finite number".into() });
        }
        let gesture = Some((pose, field.clone()));
        let joined = self.gesture == gesture;
        self.change(joined, |patch| set_field(patch, pose, &field, value))?;
        self.gesture = gesture;
        Ok(())
    }

    /// The next change is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Says whether a pose is in the air.
    pub fn set_airborne(&mut self, pose: usize, airborne: bool) -> Result<(), DocumentError> {
        self.change(false, |patch| {
            let node = pose_node(patch, pose)?;
            match patch.get(&node, "airborne").cloned() {
                Some(at) => Ok(patch.set_word(&at, if airborne { "true" } else { "false" })?),
                None if airborne => Ok(patch.add_entry(&node, "airborne: true")?),
                None => Ok(()),
            }
        })
    }

    /// Puts a copy of a pose after it.
    pub fn duplicate(&mut self, pose: usize) -> Result<(), DocumentError> {
        self.in_both_lists(pose, Patcher::duplicate)
    }

    /// Takes a pose out, with the comments above it. The last one stays.
    pub fn remove(&mut self, pose: usize) -> Result<(), DocumentError> {
        if self.poses.poses.len() < 2 {
            let place = format!("pose {pose}");
            return Err(DocumentError::Edit { place, found: "the only one".into(), valid: "one of several".into() });
        }
        self.in_both_lists(pose, Patcher::remove)
    }

    /// Swaps a pose and its duration with the next one.
    pub fn swap_with_next(&mut self, pose: usize) -> Result<(), DocumentError> {
        self.pose(pose + 1)?;
        self.in_both_lists(pose, Patcher::swap_with_next)
    }

    /// Turns a pose into its mirror image: left and right swapped.
    pub fn mirror(&mut self, pose: usize) -> Result<(), DocumentError> {
        let image = self.pose(pose)?.mirrored();
        self.write(pose, &image)
    }

    /// Writes the angles and places of `source` over those of a pose.
    pub fn write(&mut self, pose: usize, source: &KeyPose) -> Result<(), DocumentError> {
        let before = self.pose(pose)?.clone();
        let mut wanted = vec![
            (PoseField::Lateral, source.lateral),
            (PoseField::Turn, source.turn),
            (PoseField::Root(0), source.root.0),
            (PoseField::Root(1), source.root.1),
            (PoseField::Root(2), source.root.2),
        ];
        wanted.extend(source.height.map(|height| (PoseField::Height, height)));
        for name in source.joints.keys().chain(before.joints.keys().filter(|n| !source.joints.contains_key(*n))) {
            let v = source.joints.get(name).copied().unwrap_or_default();
            let parts = [v.0, v.1, v.2].into_iter().enumerate();
            wanted.extend(parts.map(|(k, v)| (PoseField::Joint(name.clone(), k), v)));
        }
        self.change(false, |patch| wanted.iter().try_for_each(|(field, value)| set_field(patch, pose, field, *value)))
    }

    /// Takes the last change back; false where there is none.
    pub fn undo(&mut self) -> bool {
        let Some(edit) = self.undo.pop() else { return false };
        self.apply(&edit.reversed());
        self.redo.push(edit);
        true
    }

    /// Makes the change that was taken back again; false where there is none.
    pub fn redo(&mut self) -> bool {
        let Some(edit) = self.redo.pop() else { return false };
        self.apply(&edit);
        self.undo.push(edit);
        true
    }

    fn pose(&self, pose: usize) -> Result<&KeyPose, DocumentError> {
        self.poses.poses.get(pose).ok_or_else(|| no_pose(pose, self.poses.poses.len()))
    }

    fn apply(&mut self, edit: &Edit) {
        let mut text = self.text.clone();
        text.replace_range(edit.at..edit.at + edit.removed.len(), &edit.inserted);
        // Every text of the history has been read before.
        if let Ok((poses, unknown)) = read(&text, &self.path) {
            (self.text, self.poses, self.unknown) = (text, poses, unknown);
            self.revision += 1;
        }
        self.gesture = None;
    }

    /// Changes the text, reads it, and keeps the step; nothing changes where any of it fails.
    fn change(
        &mut self,
        joined: bool,
        by: impl FnOnce(&mut Patcher) -> Result<(), DocumentError>,
    ) -> Result<(), DocumentError> {
        let mut patch = Patcher::new(self.text.clone()).map_err(|fault| syntax(&self.text, &self.path, &fault))?;
        by(&mut patch)?;
        if patch.text() == self.text {
            return Ok(());
        }
        let text = patch.into_text();
        let (poses, unknown) = read(&text, &self.path)?;
        let last = if joined { self.undo.pop() } else { None };
        let before = match last {
            Some(edit) => {
                let mut before = self.text.clone();
                before.replace_range(edit.at..edit.at + edit.inserted.len(), &edit.removed);
                before
            }
            None => std::mem::take(&mut self.text),
        };
        // A slider that came back to where it was leaves no step.
        if before != text {
            self.undo.push(Edit::between(&before, &text));
        }
        if self.undo.len() > UNDO {
            self.undo.remove(0);
        }
        self.redo.clear();
        self.gesture = None;
        (self.text, self.poses, self.unknown) = (text, poses, unknown);
        self.revision += 1;
        Ok(())
    }

    /// The same change of the poses and of their durations.
    fn in_both_lists(
        &mut self,
        pose: usize,
        by: fn(&mut Patcher, &Sequence, usize) -> Result<(), SpanFault>,
    ) -> Result<(), DocumentError> {
        self.pose(pose)?;
        self.change(false, |patch| {
            for field in ["poses", "seconds"] {
                let list = patch.get(patch.root(), field).and_then(Node::list).cloned();
                let list = list.filter(|l| l.entries.len() > pose).ok_or_else(|| no_pose(pose, 0))?;
                by(patch, &list, pose)?;
            }
            Ok(())
        })
    }
}

impl From<SpanFault> for DocumentError {
    fn from(fault: SpanFault) -> Self {
        Self::Edit { place: format!("byte {}", fault.at), found: fault.reason.into(), valid: "RON".into() }
    }
}

fn no_pose(pose: usize, poses: usize) -> DocumentError {
    DocumentError::Edit {
        place: format!("pose {pose}"),
        found: "not there".into(),
        valid: format!("0 to {}", poses.max(1) - 1),
    }
}

fn syntax(text: &str, path: &Path, fault: &SpanFault) -> DocumentError {
    let line = 1 + text.bytes().take(fault.at).filter(|c| *c == b'\n').count();
    DocumentError::Syntax { path: path.to_path_buf(), line, reason: fault.reason.into() }
}

/// What a text says, and the fields that are not known.
fn read(text: &str, path: &Path) -> Result<(KeyPoses, Vec<String>), DocumentError> {
    let patch = Patcher::new(text.to_owned()).map_err(|fault| syntax(text, path, &fault))?;
    let root = patch.root();
    let file = root.sequence().map(|s| (s, FILE_FIELDS));
    let poses = patch.get(root, "poses").and_then(Node::list);
    let poses = poses.iter().flat_map(|l| &l.entries).filter_map(|e| e.value.sequence()).map(|s| (s, POSE_FIELDS));
    let (known, unknown) = patch.without(&file.into_iter().chain(poses).collect::<Vec<_>>());
    Ok((KeyPoses::from_ron(&known, path)?, unknown))
}

fn pose_node(patch: &Patcher, pose: usize) -> Result<Node, DocumentError> {
    let list = patch.get(patch.root(), "poses").and_then(Node::list);
    let found = list.and_then(|l| l.entries.get(pose)).map(|e| e.value.clone());
    found.ok_or_else(|| no_pose(pose, list.map_or(0, |l| l.entries.len())))
}

fn set_field(patch: &mut Patcher, pose: usize, field: &PoseField, value: f64) -> Result<(), DocumentError> {
    match field {
        PoseField::Speed => set_top(patch, "speed", value),
        PoseField::Curvature => set_top(patch, "curvature", value),
        PoseField::Acceleration => set_top(patch, "acceleration", value),
        PoseField::Seconds => {
            let list = patch.get(patch.root(), "seconds").and_then(Node::list);
            let at = list.and_then(|l| l.entries.get(pose)).map(|e| e.value.clone());
            Ok(patch.set_number(&at.ok_or_else(|| no_pose(pose, 0))?, value, SECONDS)?)
        }
        PoseField::Lateral => set_plain(patch, pose, "lateral", value, METRES),
        PoseField::Height => set_plain(patch, pose, "height", value, METRES),
        PoseField::Turn => set_plain(patch, pose, "turn", value, DEGREES),
        PoseField::Root(k) => set_part(patch, pose, None, "root", *k, value),
        PoseField::Joint(name, k) => set_part(patch, pose, Some("joints"), &format!("{name:?}"), *k, value),
    }
}

fn set_top(patch: &mut Patcher, name: &str, value: f64) -> Result<(), DocumentError> {
    let root = patch.root().clone();
    match patch.get(&root, name).cloned() {
        Some(at) => Ok(patch.set_number(&at, value, METRES)?),
        None if number(value, METRES) == "0" => Ok(()),
        None => Ok(patch.add_entry(&root, &format!("{name}: {}", number(value, METRES)))?),
    }
}

/// A number of a pose; zero is not written where the file leaves it out.
fn set_plain(patch: &mut Patcher, pose: usize, name: &str, value: f64, decimals: i32) -> Result<(), DocumentError> {
    let node = pose_node(patch, pose)?;
    match patch.get(&node, name).cloned() {
        Some(at) => Ok(patch.set_number(&at, value, decimals)?),
        None if number(value, decimals) == "0" => Ok(()),
        None => Ok(patch.add_entry(&node, &format!("{name}: {}", number(value, decimals)))?),
    }
}

/// A component of a rotation vector, in the pose itself or in its joints.
fn set_part(
    patch: &mut Patcher,
    pose: usize,
    inside: Option<&str>,
    name: &str,
    part: usize,
    value: f64,
) -> Result<(), DocumentError> {
    let node = pose_node(patch, pose)?;
    let mut fresh = ["0".to_owned(), "0".to_owned(), "0".to_owned()];
    let Some(slot) = fresh.get_mut(part) else {
        return Err(DocumentError::Edit { place: name.into(), found: part.to_string(), valid: "0, 1 or 2".into() });
    };
    *slot = number(value, DEGREES);
    let is_zero = slot == "0";
    let entry = format!("{name}: ({})", fresh.join(", "));
    let holder = match inside {
        None => Some(node.clone()),
        Some(inside) => patch.get(&node, inside).cloned(),
    };
    let vector = holder.as_ref().and_then(|holder| patch.get(holder, name)).cloned();
    match (vector, holder) {
        (Some(vector), _) => {
            let at = vector.at(part).cloned();
            let place = format!("pose {pose}, {name}");
            let found = patch.str(&vector).to_owned();
            let at = at.ok_or(DocumentError::Edit { place, found, valid: "three numbers".into() })?;
            Ok(patch.set_number(&at, value, DEGREES)?)
        }
        (None, _) if is_zero => Ok(()),
        (None, Some(holder)) => Ok(patch.add_entry(&holder, &entry)?),
        (None, None) => Ok(patch.add_entry(&node, &format!("{}: {{ {entry} }}", inside.unwrap_or_default()))?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_that_count_as_known_are_those_that_are_read() {
        let poses =
            KeyPoses::from_ron("(name: \"a\", character: \"b\", speed: 0, seconds: [], poses: [()])", "a").unwrap();
        for (text, known) in [
            (ron::to_string(&poses).unwrap(), FILE_FIELDS),
            (ron::to_string(&KeyPose::default()).unwrap(), POSE_FIELDS),
        ] {
            let patch = Patcher::new(text).unwrap();
            let entries = &patch.root().sequence().unwrap().entries;
            let mut names: Vec<&str> = entries.iter().map(|e| &patch.text()[e.name.clone()]).collect();
            let mut known = known.to_vec();
            names.sort_unstable();
            known.sort_unstable();
            assert_eq!(names, known);
        }
    }

    #[test]
    fn a_step_of_the_history_is_the_difference_of_two_texts() {
        for (old, new) in [("abc", "abc"), ("aab", "aaab"), ("", "x"), ("x\u{e9}y", "x\u{e8}y"), ("abab", "ab")] {
            let edit = Edit::between(old, new);
            let apply = |text: &str, edit: &Edit| {
                let mut text = text.to_owned();
                assert_eq!(&text[edit.at..edit.at + edit.removed.len()], edit.removed);
                text.replace_range(edit.at..edit.at + edit.removed.len(), &edit.inserted);
                text
            };
            assert_eq!(apply(old, &edit), new);
            assert_eq!(apply(new, &edit.reversed()), old);
        }
    }
}
