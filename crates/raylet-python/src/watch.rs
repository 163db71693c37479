//! Long work: without Python's lock, on the chosen number of threads, and cancelled when the user requests it.

use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Time between checks for signals and reports of progress.
pub(crate) const BREATH: Duration = Duration::from_millis(50);

/// Largest number of threads.
const MOST_THREADS: usize = 1024;

/// How far work has come: hops done and all hops, as floating numbers, and where the current one leads.
type Stage = (f64, f64, String);

/// The state that work shares with the thread that watches it: progress one way, cancellation the other.
#[derive(Clone, Default)]
pub(crate) struct Watch(Arc<Inner>);

#[derive(Default)]
struct Inner {
    cancelled: AtomicBool,
    stage: Mutex<Option<Stage>>,
}

impl Watch {
    /// Whether the work goes on: `Break` once it is cancelled.
    pub(crate) fn pulse(&self) -> ControlFlow<()> {
        match self.0.cancelled.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// The same, after it notes how far the work has come.
    pub(crate) fn report(&self, done: f64, all: f64, to: &str) -> ControlFlow<()> {
        let mut stage = self.0.stage.lock().unwrap_or_else(PoisonError::into_inner);
        *stage = Some((done, all, to.to_owned()));
        self.pulse()
    }

    fn take_stage(&self) -> Option<Stage> {
        self.0
            .stage
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
    }
}

/// Threads that are kept from call to call: of this process, and so many.
static POOL: Mutex<Option<(u32, usize, Arc<ThreadPool>)>> = Mutex::new(None);

/// Threads to work on; all processors by default.
///
/// # Errors
/// ValueError for a number that cannot be; RuntimeError when they cannot be started.
pub(crate) fn pool(threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let count = match threads {
        Some(count) if (1..=MOST_THREADS).contains(&count) => count,
        Some(count) => {
            return Err(PyValueError::new_err(format!(
                "threads is {count}, expected from 1 to {MOST_THREADS}"
            )));
        }
        None => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let process = std::process::id();
    let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match kept.take() {
        Some((owner, size, pool)) if owner == process && size == count => {
            *kept = Some((owner, size, Arc::clone(&pool)));
            return Ok(pool);
        }
        // Threads do not survive a fork: nothing of a parent's may be touched.
        Some((owner, _, pool)) if owner != process => std::mem::forget(pool),
        _ => {}
    }
    let pool = ThreadPoolBuilder::new().num_threads(count).build();
    let pool = pool.map_err(|error| {
        PyRuntimeError::new_err(format!("cannot start {count} threads: {error}"))
    })?;
    let pool = Arc::new(pool);
    *kept = Some((process, count, Arc::clone(&pool)));
    Ok(pool)
}

/// Does work on a thread of its own, while this one checks for signals and calls `progress(done, all, to)`.
///
/// When a signal handler or `progress` raises, that is raised here at once; the work is cancelled at its next call of
/// the watch, and releases then what it holds. A panic within the work becomes an error.
///
/// # Errors
/// What the handler or `progress` raised; RuntimeError for work that failed within.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let (pool, watch) = (pool(threads)?, Watch::default());
    let (sender, receiver) = channel();
    let there = watch.clone();
    std::thread::Builder::new().spawn(move || {
        // A cancelled call has dropped the receiver.
        let _ = sender.send(caught(&pool, &there, work));
    })?;
    wait(py, receiver, progress, &watch)
}

/// The same for work that looks at its watch every few milliseconds: it may borrow, and has ended when this returns.
///
/// # Errors
/// As of [`run`].
pub(crate) fn run_borrowing<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<T> {
    let (pool, watch) = (pool(threads)?, Watch::default());
    let (sender, receiver) = channel();
    let there = watch.clone();
    std::thread::scope(|scope| {
        std::thread::Builder::new().spawn_scoped(scope, move || {
            let _ = sender.send(caught(&pool, &there, work));
        })?;
        wait(py, receiver, None, &watch)
    })
}

/// What work returned, or its panic.
type Outcome<T> = std::thread::Result<T>;

/// Does work on the threads of a pool.
fn caught<T: Send>(
    pool: &ThreadPool,
    watch: &Watch,
    work: impl FnOnce(&Watch) -> T + Send,
) -> Outcome<T> {
    catch_unwind(AssertUnwindSafe(|| pool.install(|| work(watch))))
}

/// Waits for the outcome of work, while it checks for signals and calls `progress(done, all, to)`.
fn wait<T: Send>(
    py: Python<'_>,
    mut receiver: Receiver<Outcome<T>>,
    progress: Option<&Bound<'_, PyAny>>,
    watch: &Watch,
) -> PyResult<T> {
    loop {
        let (back, outcome) = py.detach(move || {
            let outcome = receiver.recv_timeout(BREATH);
            (receiver, outcome)
        });
        receiver = back;
        let outcome = match outcome {
            Ok(outcome) => {
                outcome.map_err(|payload| PyRuntimeError::new_err(panic_message(&*payload)))?
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
            Err(RecvTimeoutError::Timeout) => {
                let kept = py.check_signals().and_then(|()| report(progress, watch));
                if let Err(error) = kept {
                    watch.0.cancelled.store(true, Ordering::Relaxed);
                    return Err(error);
                }
                continue;
            }
        };
        report(progress, watch)?;
        return Ok(outcome);
    }
}

fn report(progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    if let (Some(progress), Some(stage)) = (progress, watch.take_stage()) {
        progress.call1(stage)?;
    }
    Ok(())
}

/// The error message of a panic.
fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| String::from("no reason given"));
    format!("internal error of raylet, please report it: {text}")
}
