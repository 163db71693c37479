//! What happens when the program is told to end: nothing half-written stays behind.

use crate::failure::Failure;

/// From now on Ctrl-C and a request to terminate sweep away unfinished folders before the program ends,
/// with the exit code that shells expect, 128 and the number of the signal.
#[cfg(unix)]
pub(crate) fn watch() -> Result<(), Failure> {
    use raylet::file::hidden::abandon;
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    use crate::say::complain;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let _standstill = abandon();
            complain("\ninterrupted");
            std::process::exit(128 + signal);
        }
    });
    Ok(())
}

/// Elsewhere the system ends the program as it likes.
#[cfg(not(unix))]
pub(crate) fn watch() -> Result<(), Failure> {
    Ok(())
}
