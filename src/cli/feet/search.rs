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

/// Whether the wanted part of the trials goes well. Stops as soon as it cannot; the answer does not depend on the threads.
pub(super) fn mostly<E: Send>(
    options: &SearchOptions,
    trial: impl Fn(u64) -> Result<bool, E> + Sync,
) -> Result<bool, E> {
    let allowed = options.trials - (options.trials as f64 * options.part).ceil() as usize;
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || -> Result<(), E> {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= options.trials || failed.load(Ordering::Relaxed) > allowed {
                return Ok(());
            }
            if !trial(number as u64)? {
                failed.fetch_add(1, Ordering::Relaxed);
            }
        }
    };
    std::thread::scope(|scope| -> Result<(), E> {
        let workers: Vec<_> = (0..options.threads.max(1)).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            // A panic in a thread is passed on.
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        }
        Ok(())
    })?;
    Ok(failed.into_inner() <= allowed)
}

/// The level farthest from `easy` towards `hard` that still holds, found by halving down to `close`; `None` where not even the easy one does.
pub(super) fn largest<E>(
    (easy, hard, close): (f64, f64, f64),
    holds: impl Fn(f64) -> Result<bool, E>,
) -> Result<Option<f64>, E> {
    if !holds(easy)? {
        return Ok(None);
    }
    if holds(hard)? {
        return Ok(Some(hard));
    }
    let (mut held, mut lost) = (easy, hard);
    while (held - lost).abs() > close * 1.001 {
        let middle = 0.5 * (held + lost);
        if holds(middle)? {
            held = middle;
        } else {
            lost = middle;
        }
    }
    Ok(Some(held))
}

/// The farthest level at which a body still holds the wanted part of its episodes.
pub fn largest_held(
    model: &SharedModel,
    options: &SearchOptions,
    range: (f64, f64, f64),
    episode: impl Fn(f64) -> Episode,
) -> Result<Option<f64>, EpisodeError> {
    largest(range, |level| {
        let episode = episode(level);
        mostly(options, |number| Ok(run_episode(model, &episode, options.seed + number, 0.0)?.held()))
    })
}
