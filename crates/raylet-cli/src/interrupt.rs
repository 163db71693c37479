//! What happens when the program is interrupted: no incomplete file stays behind.

use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use raylet::file::storage::unfinished::abandon;

use crate::failure::Failure;

/// The signal that came during a step that the program finishes before it ends; 0 for none.
static SIGNAL: AtomicI32 = AtomicI32::new(0);

/// Whether it finishes its step first.
static PATIENT: AtomicBool = AtomicBool::new(false);

/// Whether a signal to end has come during a step; called when the step is finished.
pub(crate) fn is_requested() -> bool {
    SIGNAL.load(Ordering::Relaxed) != 0
}

/// Ends the program as it would have ended without waiting for the step.
pub(crate) fn end() -> ! {
    let _standstill = abandon();
    std::process::exit(128 + SIGNAL.load(Ordering::Relaxed))
}

/// From now on the first request to end waits for a step to be done (`true`), or does not.
pub(crate) fn wait_for_step(patient: bool) {
    PATIENT.store(patient, Ordering::Relaxed);
}

/// From now on Ctrl-C and a request to terminate sweep away unfinished folders before the program ends,
/// with the exit code that shells expect, 128 and the number of the signal. A file that grows beyond what the user
/// allows (`ulimit -f`) does not end the program, but its write fails like any other.
#[cfg(unix)]
pub(crate) fn watch() -> Result<(), Failure> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;

    use crate::say::complain;

    flag::register(SIGXFSZ, std::sync::Arc::default())?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::spawn(move || {
        for signal in signals.forever() {
            if PATIENT.load(Ordering::Relaxed) && SIGNAL.swap(signal, Ordering::Relaxed) == 0 {
                complain("\nstopping after this step; once more ends at once");
                continue;
            }
            let _standstill = abandon();
            complain("\ninterrupted");
            std::process::exit(128 + signal);
        }
    });
    Ok(())
}

/// On other systems the system itself ends the program.
#[cfg(not(unix))]
pub(crate) fn watch() -> Result<(), Failure> {
    Ok(())
}
