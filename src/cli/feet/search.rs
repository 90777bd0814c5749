//! The largest disturbance that is held.

use super::episode::{Episode, EpisodeError, run_episode};
use crate::model::SharedModel;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How hard is looked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOptions {
    /// Episodes a point.
    pub trials: usize,
    /// Part of the episodes that has to be held.
    pub part: f64,
    /// Number of the first episode.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// Whether the wanted part of the episodes is held. Stops as soon as it cannot be; the answer does not depend on the threads.
pub fn is_held(model: &SharedModel, episode: &Episode, options: &SearchOptions) -> Result<bool, EpisodeError> {
    let allowed = options.trials - (options.trials as f64 * options.part).ceil() as usize;
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || -> Result<(), EpisodeError> {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= options.trials || failed.load(Ordering::Relaxed) > allowed {
                return Ok(());
            }
            if !run_episode(model, episode, options.seed + number as u64, 0.0)?.held() {
                failed.fetch_add(1, Ordering::Relaxed);
            }
        }
    };
    std::thread::scope(|scope| -> Result<(), EpisodeError> {
        let workers: Vec<_> = (0..options.threads.max(1)).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            // A worker does not panic: it only steps and counts.
            if let Ok(done) = worker.join() {
                done?;
            }
        }
        Ok(())
    })?;
    Ok(failed.into_inner() <= allowed)
}

/// The level farthest from `easy` towards `hard` that is still held, found by halving down to `close`; `None` where not even the easy
/// one is.
pub fn largest_held(
    model: &SharedModel,
    options: &SearchOptions,
    (easy, hard, close): (f64, f64, f64),
    episode: impl Fn(f64) -> Episode,
) -> Result<Option<f64>, EpisodeError> {
    if !is_held(model, &episode(easy), options)? {
        return Ok(None);
    }
    if is_held(model, &episode(hard), options)? {
        return Ok(Some(hard));
    }
    let (mut held, mut lost) = (easy, hard);
    while (held - lost).abs() > close * 1.001 {
        let middle = 0.5 * (held + lost);
        if is_held(model, &episode(middle), options)? {
            held = middle;
        } else {
            lost = middle;
        }
    }
    Ok(Some(held))
}
