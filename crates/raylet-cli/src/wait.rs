//! What is being done while one waits: a line on a terminal from the first second on, which goes when it is done.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// What nobody needs to be told of.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between changes of the line.
const TICK: Duration = Duration::from_millis(200);

/// One wait, to its end when this is dropped.
pub(crate) struct Wait {
    /// Where the line is shown, told what to say; nothing where there is no terminal.
    shown: Option<(Sender<String>, JoinHandle<()>)>,
}

impl Wait {
    pub(crate) fn new() -> Self {
        let begin = || {
            let (tell, told) = channel();
            (tell, std::thread::spawn(move || show(&told)))
        };
        Self {
            shown: std::io::stderr().is_terminal().then(begin),
        }
    }

    /// Notes what is being done now.
    pub(crate) fn note(&self, doing: String) {
        if let Some((tell, _)) = &self.shown {
            // A line that cannot be shown is no failure.
            let _ = tell.send(doing);
        }
    }
}

impl Drop for Wait {
    fn drop(&mut self) {
        if let Some((tell, shown)) = self.shown.take() {
            // Without a teller the line ends; what follows on the terminal must wait for that.
            drop(tell);
            let _ = shown.join();
        }
    }
}

/// Shows what is told, from when patience is over until nobody tells any more.
fn show(told: &Receiver<String>) {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}  {elapsed}") {
        bar.set_style(style);
    }
    let end = std::time::Instant::now() + PATIENCE;
    loop {
        let left = end.saturating_duration_since(std::time::Instant::now());
        match told.recv_timeout(left.max(TICK)) {
            Ok(doing) => bar.set_message(doing),
            Err(RecvTimeoutError::Timeout) => bar.tick(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    bar.finish_and_clear();
}
