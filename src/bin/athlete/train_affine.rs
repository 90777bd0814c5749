//! `athlete train --affine`: one matrix and an offset, found by CMA-ES.

use crate::interrupt;
use crate::output::{Outcome, bar, say};
use crate::run_folder::RunFolder;
use bevy_athlete::cli::Stopped;
use bevy_athlete::train::ppo::{SkillTask, trained_policy};
use bevy_athlete::train::{AffineOptions, AffineSearch, save_policy};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// How long to search, and for what.
pub struct Goal {
    /// At most so long.
    pub limit: Duration,
    /// At most so many generations.
    pub generations: Option<usize>,
    /// Enough as soon as the survival is this, in percent.
    pub until: Option<f64>,
}

/// Searches, and writes the policy and its motion into the folder whenever a better one is found.
pub fn run(task: SkillTask, options: AffineOptions, goal: &Goal, folder: &RunFolder) -> Outcome {
    let mut search = AffineSearch::new(task, options)?;
    interrupt::watch()?;
    let size = search.task().layout.size();
    say(&format!("{} numbers seen, {} told: {} searched", size, search.task().action_size(), search.dimension()))?;
    let began = Instant::now();
    let bar = bar(goal.limit.as_secs(), "search");
    let mut saved = None;
    loop {
        let news = search.iterate()?;
        bar.set_position(began.elapsed().as_secs().min(goal.limit.as_secs()));
        bar.set_message(format!("generation {}, survival {:.1} %", news.number, 100.0 * news.mean.0));
        if let Some(best) = search.best().filter(|b| saved != Some(b.iteration)) {
            folder.begin_results()?;
            let (layers, mut contract) = trained_policy(search.task(), best, folder.motion());
            contract.reference.fingerprint = Some(folder.motion_fingerprint());
            save_policy(folder.place("policy.onnx"), &layers, &contract)?;
            saved = Some(best.iteration);
            let text = format!(
                "{:>7.1} s {:>9} samples  generation {:>4}  survival {:>5.1} %  reward {:.3}",
                began.elapsed().as_secs_f64(),
                news.samples,
                news.number,
                100.0 * best.evaluation.0,
                best.evaluation.1
            );
            bar.suspend(|| say(&text))?;
        }
        let reached = search.best().is_some_and(|b| goal.until.is_some_and(|p| 100.0 * b.evaluation.0 >= p));
        let enough = goal.generations.is_some_and(|n| news.number >= n as u64);
        if reached || enough || interrupt::asked() || began.elapsed() >= goal.limit {
            break;
        }
    }
    bar.finish_and_clear();
    if interrupt::asked() {
        let policy = folder.place("policy.onnx");
        let Some(best) = saved else { return Err(Stopped("no policy was found yet".into()).into()) };
        say(&format!("stopped; the best policy, of generation {best}, is saved in {}", policy.display()))?;
        return Ok(interrupt::stopped());
    }
    let (survival, reward) = search.best().map_or((0.0, 0.0), |b| b.evaluation);
    say(&format!("survival {:.1} % reward {reward:.3}", 100.0 * survival))?;
    Ok(ExitCode::SUCCESS)
}
