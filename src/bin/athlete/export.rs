//! `athlete export`: from what a training left to a skill that a game loads.

use crate::output::{Outcome, complain, say, say_json};
use bevy_athlete::cli::{
    ArgumentError, CARD_FILE, POLICY_FILE, SkillExport, check_folder, keep_earlier, skill_export, write_whole,
};
use clap::Args;
use serde_json::json;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Make a folder that a game loads of what a training left: description, motion, policy and card, and where they are its own, course
/// and character. What does not belong together is refused.
#[derive(Debug, Args)]
pub struct Export {
    /// Folder that `athlete train` has filled, or the policy in it
    run: PathBuf,
    /// Folder of the skill, made where it is missing
    #[arg(long)]
    out: PathBuf,
    /// Replace the skill in --out
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Export {
    pub fn run(&self) -> Outcome {
        let file = if self.run.is_dir() { self.run.join(POLICY_FILE) } else { self.run.clone() };
        let made = !self.out.exists();
        check_folder("--out", &self.out)?;
        let written = self.write(&file);
        if made && written.is_err() {
            // Nothing was exported, so nothing is left: a folder that holds something stays.
            let _ = std::fs::remove_dir(&self.out);
        }
        let skill = written?;
        let places: Vec<PathBuf> = skill.files.iter().map(|(name, _)| self.out.join(name)).collect();
        if self.json {
            say_json(&json!({"skill": skill.name, "out": self.out, "files": places, "card": skill.has_card}))?;
        } else {
            say(&format!("{} of {}", skill.name, file.display()))?;
            for place in &places {
                say(&format!("                 {}", place.display()))?;
            }
        }
        if !skill.has_card {
            let out = self.out.display();
            complain(&format!("note: no card beside the policy; athlete evaluate {out} --card writes one"));
        }
        Ok(ExitCode::SUCCESS)
    }

    fn write(&self, file: &std::path::Path) -> Result<SkillExport, Box<dyn Error>> {
        let skill = skill_export(file)?;
        // Of two skills in one folder nobody could say whose policy it is.
        let own = format!("{}.skill.ron", skill.name);
        let entries = std::fs::read_dir(&self.out).map_err(|e| format!("{}: {e}", self.out.display()))?;
        let names = entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
        if let Some(other) = names.into_iter().find(|n| n.ends_with(".skill.ron") && *n != own) {
            let found = format!("{} (holds {other})", self.out.display());
            return Err(ArgumentError::new("--out", found, "a folder of its own for each skill").into());
        }
        let mut places: Vec<PathBuf> = skill.files.iter().map(|(name, _)| self.out.join(name)).collect();
        let card = self.out.join(CARD_FILE);
        if !skill.has_card {
            places.push(card.clone());
        }
        keep_earlier("--out", &places, self.force, "another folder")?;
        if !skill.has_card && card.exists() {
            // It is of the policy that goes.
            std::fs::remove_file(&card).map_err(|e| format!("cannot remove {}: {e}", card.display()))?;
        }
        for (name, bytes) in &skill.files {
            write_whole(&self.out.join(name), bytes)?;
        }
        Ok(skill)
    }
}
