//! `--record` of the commands that simulate: the simulated motion as a clip.

use bevy_athlete::control::MotionRecorder;
use bevy_athlete::model::CharacterModel;
use clap::Args;
use std::error::Error;
use std::path::{Path, PathBuf};

const ENDING: &str = ".clip.ron";

#[derive(Debug, Args)]
pub struct Record {
    /// Write the simulated motion as a clip (.clip.ron), which --motion and --clip read
    #[arg(long)]
    record: Option<PathBuf>,
    /// Poses per second of the recorded clip
    #[arg(long, requires = "record", default_value_t = MotionRecorder::DEFAULT_RATE)]
    record_rate: f64,
}

impl Record {
    /// Where the clip goes, if one was asked for.
    pub fn path(&self) -> &Option<PathBuf> {
        &self.record
    }

    /// A recorder for so many seconds, if a clip was asked for and can be written.
    pub fn recorder(&self, seconds: f64) -> Result<Option<MotionRecorder>, Box<dyn Error>> {
        let Some(path) = &self.record else { return Ok(None) };
        if !path.to_string_lossy().ends_with(ENDING) {
            return Err(format!("--record {}: valid is a name that ends in {ENDING}", path.display()).into());
        }
        check_place("--record", path)?;
        let recorder = MotionRecorder::new(0, self.record_rate, seconds);
        Ok(Some(recorder.map_err(|error| format!("--record-rate {}: {error}", self.record_rate))?))
    }

    /// Writes what was recorded, named after its file.
    pub fn save(&self, recorder: Option<MotionRecorder>, model: &CharacterModel) -> Result<(), Box<dyn Error>> {
        if let (Some(recorder), Some(path)) = (recorder, &self.record) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            recorder.into_clip(name.trim_end_matches(ENDING), model)?.save(path)?;
        }
        Ok(())
    }
}

/// A place that cannot be written is better found before a long computation than after it.
pub fn check_place(option: &str, path: &Path) -> Result<(), Box<dyn Error>> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    if folder.is_some_and(|p| !p.is_dir()) || path.is_dir() {
        return Err(format!("{option} {}: valid is a file in an existing folder", path.display()).into());
    }
    Ok(())
}
