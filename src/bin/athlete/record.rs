//! `--record` of the commands that simulate: the simulated motion as a clip.

use bevy_athlete::cli::{ArgumentError, check_output};
use bevy_athlete::control::MotionRecorder;
use bevy_athlete::model::CharacterModel;
use clap::Args;
use std::error::Error;
use std::path::PathBuf;

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
            return Err(ArgumentError::new("--record", path.display(), format!("a name that ends in {ENDING}")).into());
        }
        check_output("--record", path)?;
        let recorder = MotionRecorder::new(0, self.record_rate, seconds);
        Ok(Some(recorder.map_err(|error| ArgumentError::new("--record-rate", self.record_rate, error))?))
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
