//! Trials that begin where the skills before are left.

use crate::motion;
use bevy_athlete::cli::{POLICY_FILE, load_task_with};
use bevy_athlete::skill::SkillDefinition;
use bevy_athlete::train::load_layers;
use bevy_athlete::train::ppo::{SkillTask, follow_policy};

/// Lets trials begin as the policies of the skills that are followed leave their motions, half of them begun themselves as what they follow is left.
/// The name of each, that of what it is left for, and in how many ways.
pub fn follow_policies(task: &mut SkillTask) -> Result<Vec<(String, String, usize)>, Box<dyn std::error::Error>> {
    follow(task, 1)
}

/// `generations`: how many skills before the one before.
fn follow(
    task: &mut SkillTask,
    generations: usize,
) -> Result<Vec<(String, String, usize)>, Box<dyn std::error::Error>> {
    let mut found = Vec::new();
    for (k, file) in task.skill.after.clone().iter().enumerate() {
        let policy = file.with_file_name(POLICY_FILE);
        if generations == 0 && !policy.is_file() {
            // What comes before a skill before may have learnt nothing yet: then it is left in the poses of its motion.
            continue;
        }
        let mut other = SkillDefinition::load(file)?;
        if generations == 0 || !other.episode.after_policy {
            other.after.clear();
        }
        // The body that is asked about performs both.
        other.character.clone_from(&task.skill.character);
        let mut other = load_task_with(&other, None, &mut motion::tell)?;
        if generations > 0 {
            found.extend(follow(&mut other, generations - 1)?);
        }
        let (layers, contract) = load_layers(policy)?;
        let ways = follow_policy(task, k, &other, &layers, &contract)?;
        found.push((other.skill.name, task.skill.name.clone(), ways));
    }
    Ok(found)
}
