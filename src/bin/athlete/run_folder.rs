//! The folder of a training: what lies in it belongs together.

use bevy_athlete::asset::Course;
use bevy_athlete::asset::card::fingerprint;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::read_file::read_bytes;
use bevy_athlete::cli::{ArgumentError, check_folder, keep_earlier, write_whole};
use bevy_athlete::train::ppo::course_file;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Policy, checkpoint, curve, card and the motion that all of them are of.
pub struct RunFolder {
    path: PathBuf,
    /// Name of the file of the motion, and what it holds.
    motion: String,
    text: String,
    /// The same of the course, where there is one.
    course: Option<(String, String)>,
}

impl RunFolder {
    /// Makes the folder and tries it. Refuses one that holds an earlier training unless that is resumed or replaced (`force`),
    /// and to resume a training of another motion.
    pub fn open(
        path: &Path,
        skill: &str,
        clip: &MotionClip,
        resume: bool,
        force: bool,
    ) -> Result<Self, Box<dyn Error>> {
        check_folder("--out", path)?;
        let text = clip.clone().rounded().to_ron()?;
        let folder = Self { path: path.to_path_buf(), motion: format!("{skill}.clip.ron"), text, course: None };
        let earlier: Vec<PathBuf> = ["policy.onnx", "checkpoint.json", "card.json", "curve.csv", &folder.motion]
            .map(|name| path.join(name))
            .into();
        if !resume {
            keep_earlier("--out", &earlier, force, "--resume to go on with it, another folder")?;
        } else if !force && folder.motion_file().exists() && !folder.has_motion() {
            let found = format!("({} is another motion than the one to be learnt)", folder.motion_file().display());
            let valid = "the motion that the checkpoint is of, another --out for another motion";
            return Err(ArgumentError::new("--resume", found, valid).into());
        }
        Ok(folder)
    }

    /// The same folder for a skill over a course, which will lie beside the policy too.
    pub fn with_course(self, skill: &str, course: Option<&Course>) -> Result<Self, Box<dyn Error>> {
        let text = course.map(Course::to_ron).transpose()?;
        Ok(Self { course: text.map(|text| (course_file(skill), text)), ..self })
    }

    /// Where a file of this name goes.
    pub fn place(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Name of the file of the motion.
    pub fn motion(&self) -> &str {
        &self.motion
    }

    /// Fingerprint of the file of the motion, for the policy's contract.
    pub fn motion_fingerprint(&self) -> String {
        fingerprint(self.text.as_bytes())
    }

    /// Writes the motion where it is not there, and removes a card that is of another policy.
    pub fn begin_results(&self) -> Result<(), Box<dyn Error>> {
        if let Some((file, text)) = &self.course {
            write_whole(&self.place(file), text.as_bytes())?;
        }
        if !self.has_motion() {
            write_whole(&self.motion_file(), self.text.as_bytes())?;
        }
        match std::fs::remove_file(self.place("card.json")) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(format!("cannot remove {}: {error}", self.place("card.json").display()).into())
            }
            _ => Ok(()),
        }
    }

    fn motion_file(&self) -> PathBuf {
        self.place(&self.motion)
    }

    fn has_motion(&self) -> bool {
        read_bytes(self.motion_file(), self.text.len() as u64).is_ok_and(|bytes| bytes == self.text.as_bytes())
    }
}
