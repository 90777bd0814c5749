//! The robustness card of a policy, measured.

use crate::asset::card::{CARD_VERSION, CardRow, RobustnessCard, reward_name};
use crate::control::Policy;
use crate::math::F32x8;
use crate::train::ppo::evaluate::{evaluate_until, row_seed};
use crate::train::ppo::quality::{JointLoad, motion_quality};
use crate::train::ppo::task::{SkillTask, TaskError};
use std::collections::BTreeMap;

/// Trials of the first row by which the quality of the motion is measured.
const QUALITY_TRIALS: usize = 16;

/// A card, and what was found beside it.
#[derive(Clone, Debug)]
pub struct CardReport {
    /// The card.
    pub card: RobustnessCard,
    /// For each row what the trials that did not count lacked and where in the motion they ended.
    pub shortfalls: Vec<String>,
    /// What the joints had to bear in the trials by which the quality of the motion is measured.
    pub joints: Vec<JointLoad>,
    /// It was stopped: there are fewer trials than were asked for, or rows, or no quality of the motion.
    pub stopped: bool,
}

/// Tries a policy on fresh random trials of each row of its skill, all of them counted, at the task's simulation rate.
/// `command` is what the card says it was made by.
pub fn robustness_card(
    task: &SkillTask,
    policy: &Policy,
    trials: usize,
    seed: u64,
    threads: usize,
    command: String,
) -> Result<CardReport, TaskError> {
    robustness_card_until(task, policy, trials, seed, threads, command, &|| false)
}

/// [`robustness_card`] that begins no more trials once `stop` says so, and is then one of those that were begun.
pub fn robustness_card_until(
    task: &SkillTask,
    policy: &Policy,
    trials: usize,
    seed: u64,
    threads: usize,
    command: String,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<CardReport, TaskError> {
    let tables = task.trials()?;
    let (mut rows, mut shortfalls, mut quality) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut joints = Vec::new();
    for (k, (name, row)) in tables.iter().enumerate() {
        if k > 0 && stop() {
            break;
        }
        let found = evaluate_until::<F32x8, _>(row, policy, trials, row_seed(seed, k), threads, stop);
        rows.push(CardRow::new(name, found.trials as u64, found.survived as u64));
        quality.insert(reward_name(name), found.reward);
        quality.insert(format!("residual_rad, {name}"), found.residual);
        let words: Vec<_> = found.shortfalls.iter().map(|(what, n)| format!("{n} {what}")).collect();
        let mut lacked = words.join(", ");
        let mut at = found.failed_at;
        at.sort_unstable();
        if let (Some(first), Some(last)) = (at.first(), at.last()) {
            let time = |tick: usize| tick as f64 / task.skill.control_rate;
            let middle = time(at[at.len() / 2]);
            lacked.push_str(&format!("; at {:.1} to {:.1} s, half of them by {middle:.1}", time(*first), time(*last)));
        }
        shortfalls.push(lacked);
    }
    let stopped = stop();
    if let Some((_, row)) = tables.first().filter(|_| !stopped) {
        let q = motion_quality(row, policy, QUALITY_TRIALS.min(trials), seed);
        for (name, value) in [
            ("joint_jerk_rad_per_s3", q.jerk),
            ("reference_joint_jerk_rad_per_s3", q.reference_jerk),
            ("self_penetration_m", q.overlap),
            ("blade_slip_m_per_s", q.slip),
            ("time_at_joint_limits", q.at_limits),
            ("work_j_per_m", q.work_per_metre),
            ("largest_torque_n_m", q.torque),
            ("time_at_torque_limits", q.at_torque_limits),
        ] {
            quality.insert(name.to_owned(), value);
        }
        joints = q.joints;
    }
    let card = RobustnessCard {
        version: CARD_VERSION,
        skill: task.skill.name.clone(),
        character: task.model.name.clone(),
        policy: policy.fingerprint().into(),
        crate_version: env!("CARGO_PKG_VERSION").into(),
        seed,
        trials: rows.iter().map(|r| r.trials).sum(),
        rows,
        quality,
        command,
    };
    Ok(CardReport { card, shortfalls, joints, stopped })
}
