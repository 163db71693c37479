//! Runs that share the threads and keep to one memory limit.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::engine::chain::outcome::{Outcome, Progress};
use crate::engine::chain::simulate::simulate;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::Reply;
use crate::engine::sweep::memory_watch::MemoryWatch;
use crate::optics::system::System;

/// A run that is done.
#[derive(Clone, Debug)]
pub struct FinishedRun {
    /// What came out.
    pub outcome: Outcome,
    /// Seconds it took, beside the others.
    pub seconds: f64,
}

/// Carries the light of several systems, as many side by side as there are threads and as fit into the memory limit.
///
/// Every run is planned with the whole limit and has the bits that it has alone. The first one has all threads to itself,
/// and shows what a run takes: so many are side by side then as together keep to the limit, if they take no more than any
/// before them was found to take. Where the system does not report what the program holds, they follow one another.
/// `progress` is called with the number of a run after each chunk of its work, from any thread.
///
/// # Errors
/// The first run that fails, and its error. Runs before it are finished, those behind it are not.
pub fn simulate_all<'a, T: AsRef<System> + Sync, R: Reply>(
    runs: &'a [T],
    settings: &Settings,
    progress: &(dyn Fn(usize, Progress) -> R + Sync),
) -> Result<Vec<FinishedRun>, (&'a T, SimulateError)> {
    let systems: Vec<&System> = runs.iter().map(AsRef::as_ref).collect();
    let progress: &RunListener = &|run, here| progress(run, here).flow();
    let sweep = Sweep::new(&systems, settings, progress);
    if let [system] = systems[..] {
        sweep.run(0, system);
    } else {
        let unknown = settings.memory_limit as u64;
        sweep.memory.during(unknown, || sweep.run_all());
    }
    let done = (sweep.done.into_inner()).unwrap_or_else(PoisonError::into_inner);
    let done = runs.iter().zip(done.into_iter().flatten());
    done.map(|(run, result)| result.map_err(|error| (run, error)))
        .collect()
}

/// A listener to which each run reports, with its number, how far it has come.
type RunListener<'a> = dyn Fn(usize, Progress) -> ControlFlow<()> + Sync + 'a;

/// Several runs.
struct Sweep<'a> {
    systems: &'a [&'a System],
    settings: &'a Settings,
    progress: &'a RunListener<'a>,
    memory: MemoryWatch,
    /// The smallest number of a run that failed; no run has the number `usize::MAX`.
    failed: AtomicUsize,
    /// What came of each; nothing for those that have not begun.
    done: Mutex<Vec<Option<Result<FinishedRun, SimulateError>>>>,
}

impl<'a> Sweep<'a> {
    fn new(
        systems: &'a [&'a System],
        settings: &'a Settings,
        progress: &'a RunListener<'a>,
    ) -> Self {
        Self {
            systems,
            settings,
            progress,
            memory: MemoryWatch::new(),
            failed: AtomicUsize::new(usize::MAX),
            done: Mutex::new(systems.iter().map(|_| None).collect()),
        }
    }

    /// The first run, then the others.
    fn run_all(&self) {
        if !self.run_next() {
            return;
        }
        let others = self.systems.len().saturating_sub(1);
        // One task for each thread, which takes one run after the other: a thread that waits for parts of its run never
        // begins with another one meanwhile.
        rayon::scope(|scope| {
            for _ in 0..others.min(rayon::current_num_threads()) {
                scope.spawn(|_| while self.run_next() {});
            }
        });
    }

    /// Does the next run, if there is one and there is memory for it.
    fn run_next(&self) -> bool {
        let mut used = self.memory.used();
        let number = used.next;
        let wanted = number < self.failed.load(Ordering::Relaxed);
        let room = used.has_room(self.settings.memory_limit as u64);
        let Some(system) = self.systems.get(number).filter(|_| wanted && room) else {
            return false;
        };
        (used.next, used.runs) = (number + 1, used.runs + 1);
        drop(used);

        let results = self.run(number, system);
        let mut used = self.memory.used();
        used.runs -= 1;
        used.results += results;
        true
    }

    /// One run; the bytes of its results.
    fn run(&self, number: usize, system: &System) -> u64 {
        let clock = Instant::now();
        let here = |progress: Progress| match self.failed.load(Ordering::Relaxed) < number {
            true => ControlFlow::Break(()),
            false => (self.progress)(number, progress),
        };
        let result = simulate(system, self.settings, &here);
        if result.is_err() {
            self.failed.fetch_min(number, Ordering::Relaxed);
        }
        let bytes = result.as_ref().map_or(0, result_bytes);
        let seconds = clock.elapsed().as_secs_f64();
        let finished = result.map(|outcome| FinishedRun { outcome, seconds });
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = done.get_mut(number) {
            *place = Some(finished);
        }
        bytes
    }
}

/// Bytes of the arrays of a result.
fn result_bytes(outcome: &Outcome) -> u64 {
    let errors = outcome.standard_error.as_ref();
    let errors = errors.map_or(0, |errors| size_of_val(errors.as_slice().unwrap_or(&[])));
    let field = &outcome.field.values;
    (size_of_val(field.as_slice().unwrap_or(&[])) + errors) as u64
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    use crate::engine::chain::outcome::Progress;
    use crate::engine::chain::simulate::simulate;
    use crate::engine::chain::simulate_error::SimulateError;
    use crate::engine::plan::settings::Settings;
    use crate::engine::progress::Cancelled;
    use crate::engine::sweep::simulate_all::{RunListener, Sweep, simulate_all};
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{box_pixels, lit, on_axis, screen, sensor};
    use crate::optics::system::System;

    impl AsRef<System> for System {
        fn as_ref(&self) -> &System {
            self
        }
    }

    /// Light behind pixels on a sensor of so many pixels, at some distances in mm.
    fn systems(distances: &[f64], pixels: usize) -> Vec<System> {
        let one = |distance: &f64| {
            let values = noise((8, 8), 0).mapv(|value| value / value.norm());
            let hologram = screen(on_axis(0.0), box_pixels(values, 6.0));
            let end = screen(on_axis(*distance), sensor(pixels, 2.0));
            lit(vec![hologram, end], vec![vec![]])
        };
        distances.iter().map(one).collect()
    }

    fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(work)
    }

    #[test]
    fn runs_have_the_bits_that_they_have_alone() {
        let runs = systems(&[400.0, 500.0, 600.0], 8);
        let settings = Settings::default();
        for threads in [1, 3] {
            let found = on_threads(threads, || simulate_all(&runs, &settings, &|_, _| ()));
            let found = found.unwrap();
            assert_eq!(found.len(), runs.len());
            for (one, system) in found.iter().zip(&runs) {
                let alone = simulate(system, &settings, &|_| ()).unwrap();
                assert_eq!(one.outcome.field.values, alone.field.values);
            }
        }
    }

    /// Whether the third run begins while the second one is under way, where a run is found to take `of_one` bytes.
    /// The second one waits so long for it.
    fn is_side_by_side(of_one: u64, memory_limit: usize, patience: Duration) -> bool {
        let runs = systems(&[400.0, 500.0, 600.0], 16);
        let runs: Vec<&System> = runs.iter().collect();
        let settings = Settings {
            memory_limit,
            ..Settings::default()
        };
        let [begun, together] = [AtomicBool::new(false), AtomicBool::new(false)];
        let progress: &RunListener = &|run, _| {
            let start = Instant::now();
            while run == 1 && !begun.load(Ordering::SeqCst) && start.elapsed() < patience {
                std::thread::sleep(Duration::from_millis(1));
            }
            match run {
                1 => together.store(begun.load(Ordering::SeqCst), Ordering::SeqCst),
                2 => begun.store(true, Ordering::SeqCst),
                _ => (),
            }
            ControlFlow::Continue(())
        };
        let sweep = Sweep::new(&runs, &settings, progress);
        sweep.memory.used().of_one = of_one;
        on_threads(3, || sweep.run_all());
        let done = sweep.done.into_inner().unwrap();
        assert!(done.iter().all(|one| matches!(one, Some(Ok(_)))));
        together.into_inner()
    }

    #[test]
    fn as_many_are_under_way_as_fit_into_memory() {
        let [short, long] = [0.3, 30.0].map(Duration::from_secs_f64);
        assert!(!is_side_by_side(100_000_000, 150_000_000, short));
        assert!(is_side_by_side(100_000_000, 250_000_000, long));
    }

    /// The error is that of the first run that fails, whichever fails first; runs behind it are cancelled.
    #[test]
    fn the_first_run_that_fails_is_told() {
        let mut runs = systems(&[400.0, 500.0, 600.0, 700.0], 16);
        for failing in [2, 3] {
            runs[failing].screens.pop();
            runs[failing].trains.pop();
        }
        let settings = Settings::default();
        let found = on_threads(3, || simulate_all(&runs, &settings, &|_, _| ()));
        let (run, error) = found.unwrap_err();
        assert!(std::ptr::eq(run, &raw const runs[2]));
        assert!(matches!(error, SimulateError::NoSensor(_)), "{error}");
    }

    #[test]
    fn a_break_cancels_all_runs() {
        let runs = systems(&[400.0, 500.0, 600.0], 16);
        let stop = |run: usize, _: Progress| match run {
            1 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let found = simulate_all(&runs, &Settings::default(), &stop);
        let (run, error) = found.unwrap_err();
        assert!(std::ptr::eq(run, &raw const runs[1]));
        assert_eq!(error, SimulateError::Cancelled(Cancelled));
    }
}
