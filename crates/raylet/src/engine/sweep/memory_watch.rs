//! The memory that runs take, measured while they work.
//!
//! What a run will take is known in parts only before it is done. So the memory that the program holds is measured again
//! and again, and what it has grown by is divided among the runs that are under way.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System, get_current_pid};

/// Time between measurements. Arrays that are large enough to matter live longer.
const BETWEEN: Duration = Duration::from_millis(20);

/// How many runs are under way, and what they were found to take.
#[derive(Debug)]
pub(crate) struct MemoryUse {
    /// Runs under way.
    pub runs: usize,
    /// The number of the next run that starts.
    pub next: usize,
    /// Bytes of the results of those that are done.
    pub results: u64,
    /// The most bytes that one run was found to take.
    pub of_one: u64,
}

impl MemoryUse {
    /// Notes that the program holds so many bytes more than before the first run.
    fn note(&mut self, more: u64) {
        if let Some(of_one) = more
            .saturating_sub(self.results)
            .checked_div(self.runs as u64)
        {
            self.of_one = self.of_one.max(of_one);
        }
    }

    /// Whether one more run fits into so many bytes beside those that are under way. One alone always may: its plan keeps to
    /// the limit.
    pub(crate) fn has_room(&self, limit: u64) -> bool {
        self.runs == 0 || (self.runs as u64 + 1).saturating_mul(self.of_one) <= limit
    }
}

/// The use of memory, which threads share, and what ends its measurement.
pub(crate) struct MemoryWatch {
    used: Mutex<MemoryUse>,
    ended: Mutex<bool>,
    end: Condvar,
}

impl MemoryWatch {
    pub(crate) fn new() -> Self {
        Self {
            used: Mutex::new(MemoryUse {
                runs: 0,
                next: 0,
                results: 0,
                of_one: 0,
            }),
            ended: Mutex::new(false),
            end: Condvar::new(),
        }
    }

    /// The use of memory, for this thread alone as long as the answer lives.
    pub(crate) fn used(&self) -> MutexGuard<'_, MemoryUse> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does work while another thread measures what the program holds. Where the system does not report that, a run
    /// counts as `unknown` bytes.
    pub(crate) fn during<T>(&self, unknown: u64, work: impl FnOnce() -> T) -> T {
        let Some(mut meter) = ResidentMemory::new() else {
            self.used().of_one = unknown;
            return work();
        };
        std::thread::scope(|scope| {
            scope.spawn(move || self.measure(&mut meter));
            // The measurement ends whether the work does or panics.
            let _ending = Ending(self);
            work()
        })
    }

    fn measure(&self, meter: &mut ResidentMemory) {
        let before = meter.bytes().unwrap_or(0);
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        while !*ended {
            let waited = self.end.wait_timeout(ended, BETWEEN);
            ended = waited.unwrap_or_else(PoisonError::into_inner).0;
            if let Some(now) = meter.bytes() {
                self.used().note(now.saturating_sub(before));
            }
        }
    }
}

/// Ends a measurement when it is dropped.
struct Ending<'a>(&'a MemoryWatch);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        *(self.0.ended.lock()).unwrap_or_else(PoisonError::into_inner) = true;
        self.0.end.notify_all();
    }
}

/// The memory that this program holds.
struct ResidentMemory {
    system: System,
    here: Pid,
}

impl ResidentMemory {
    /// Nothing where the system does not report it.
    fn new() -> Option<Self> {
        let (system, here) = (System::new(), get_current_pid().ok()?);
        let mut meter = Self { system, here };
        meter.bytes().is_some().then_some(meter)
    }

    /// The bytes that it holds now.
    fn bytes(&mut self) -> Option<u64> {
        let (here, kind) = (
            [self.here],
            ProcessRefreshKind::nothing().with_memory().without_tasks(),
        );
        let these = ProcessesToUpdate::Some(&here);
        self.system.refresh_processes_specifics(these, false, kind);
        self.system.process(self.here).map(|here| here.memory())
    }
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;
    use std::time::Duration;

    use crate::engine::sweep::memory_watch::{MemoryUse, MemoryWatch};

    const MEGABYTE: u64 = 1_000_000;

    fn used(runs: usize) -> MemoryUse {
        MemoryUse {
            runs,
            next: runs,
            results: 0,
            of_one: 0,
        }
    }

    #[test]
    fn what_the_program_grows_by_is_divided_among_the_runs() {
        let mut found = used(2);
        found.results = 10;
        found.note(110);
        assert_eq!(found.of_one, 50);
        // What was found once stands, and nothing is said while no run is under way.
        found.note(30);
        found.runs = 0;
        found.note(1000);
        assert_eq!(found.of_one, 50);
    }

    #[test]
    fn there_is_room_for_one_more_as_long_as_all_fit() {
        for (runs, of_one, limit, room) in [
            (0, 200, 100, true),
            (1, 50, 100, true),
            (1, 51, 100, false),
            (3, 25, 100, true),
            (4, 25, 100, false),
        ] {
            let found = MemoryUse {
                of_one,
                ..used(runs)
            };
            assert_eq!(found.has_room(limit), room, "{found:?}");
        }
    }

    /// An array of 400 MB that one of two runs holds for a while counts as 200 MB of each. Other tests take and free memory of
    /// this program meanwhile: half of that at most.
    #[test]
    fn arrays_are_seen_while_they_are_held() {
        for (runs, expected) in [(1, 400), (2, 200)] {
            let watch = MemoryWatch::new();
            watch.during(0, || {
                watch.used().runs = runs;
                let held = black_box(vec![1_u8; 400 * MEGABYTE as usize]);
                std::thread::sleep(Duration::from_millis(300));
                drop(held);
                watch.used().runs = 0;
            });
            let found = watch.used().of_one / MEGABYTE;
            assert!(found >= expected / 2, "{runs}: {found}");
        }
    }
}
