//! Work in a thread of its own: news as it goes, a result at the end, and a way to stop it.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Why a job has no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The system gives no thread.
    #[error("no thread to work in: {reason}; valid: a system with threads (not a browser)")]
    NoThread {
        /// What the system said.
        reason: String,
    },
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The work failed.
    #[error("{reason}")]
    Failed {
        /// Why.
        reason: String,
    },
}

impl JobError {
    /// Of any error.
    pub fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed { reason: error.to_string() }
    }
}

/// Whether jobs can run at all: not in a browser.
pub const JOBS_CAN_RUN: bool = !cfg!(target_arch = "wasm32");

#[derive(Debug)]
struct Shared<N> {
    cancel: AtomicBool,
    finish: AtomicBool,
    news: Mutex<VecDeque<N>>,
}

impl<N> Shared<N> {
    fn news(&self) -> MutexGuard<'_, VecDeque<N>> {
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the work sees of its job.
#[derive(Debug)]
pub struct JobControl<N>(Arc<Shared<N>>);

impl<N> JobControl<N> {
    /// Whether to stop as soon as possible, without a result.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancel.load(Relaxed)
    }
    /// Whether to come to an end with what there is.
    pub fn should_finish(&self) -> bool {
        self.0.finish.load(Relaxed)
    }
    /// Tells news.
    pub fn tell(&self, news: N) {
        self.0.news().push_back(news);
    }
}

/// Work in a thread. Dropping it cancels it; the thread ends by itself.
#[derive(Debug)]
pub struct Job<N, T> {
    shared: Arc<Shared<N>>,
    thread: Option<JoinHandle<Result<T, JobError>>>,
}

impl<N: Send + 'static, T: Send + 'static> Job<N, T> {
    /// Starts the work. It should look at its control often: a fraction of a second is how long a cancel takes.
    pub fn start(
        name: &str,
        work: impl FnOnce(&JobControl<N>) -> Result<T, JobError> + Send + 'static,
    ) -> Result<Self, JobError> {
        let shared = Arc::new(Shared {
            cancel: AtomicBool::new(false),
            finish: AtomicBool::new(false),
            news: Mutex::new(VecDeque::new()),
        });
        let control = JobControl(shared.clone());
        let thread = std::thread::Builder::new().name(name.into()).spawn(move || work(&control));
        let thread = thread.map_err(|e| JobError::NoThread { reason: e.to_string() })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// News since this was last asked, oldest first. Does not wait.
    pub fn news(&self) -> VecDeque<N> {
        std::mem::take(&mut *self.shared.news())
    }

    /// Stops it without a result.
    pub fn cancel(&self) {
        self.shared.cancel.store(true, Relaxed);
    }

    /// Whether it has been asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancel.load(Relaxed)
    }

    /// Lets it come to an end with what it has.
    pub fn finish(&self) {
        self.shared.finish.store(true, Relaxed);
    }

    /// The result, once; `None` while it works. Does not wait.
    pub fn result(&mut self) -> Option<Result<T, JobError>> {
        let thread = self.thread.take_if(|t| t.is_finished())?;
        let result = thread.join().unwrap_or_else(|_| Err(JobError::failed("the work stopped unexpectedly")));
        Some(if self.is_cancelled() { Err(JobError::Cancelled) } else { result })
    }
}

impl<N, T> Drop for Job<N, T> {
    fn drop(&mut self) {
        self.shared.cancel.store(true, Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    fn result<N: Send + 'static, T: Send + 'static>(job: &mut Job<N, T>) -> Result<T, JobError> {
        let began = Instant::now();
        loop {
            if let Some(result) = job.result() {
                return result;
            }
            assert!(began.elapsed() < Duration::from_secs(30), "the job does not end");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn news_and_result_arrive_in_order() {
        let mut job = Job::start("count", |control| {
            (0..5).for_each(|k| control.tell(k));
            Ok(7)
        })
        .unwrap();
        assert_eq!(result(&mut job), Ok(7));
        assert_eq!(job.news(), [0, 1, 2, 3, 4]);
        assert!(job.result().is_none(), "once");
    }

    fn endless(control: &JobControl<()>) -> Result<u32, JobError> {
        while !control.is_cancelled() && !control.should_finish() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(1)
    }

    #[test]
    fn it_can_be_cancelled_or_brought_to_an_end() {
        let mut job = Job::start("cancelled", endless).unwrap();
        assert!(job.result().is_none());
        job.cancel();
        assert_eq!(result(&mut job), Err(JobError::Cancelled));
        let mut job = Job::start("finished", endless).unwrap();
        job.finish();
        assert_eq!(result(&mut job), Ok(1));
    }

    #[test]
    fn a_panic_in_the_work_is_a_failure() {
        let mut job: Job<(), ()> = Job::start("panics", |_| std::panic::resume_unwind(Box::new(1))).unwrap();
        assert!(matches!(result(&mut job), Err(JobError::Failed { .. })));
    }
}
