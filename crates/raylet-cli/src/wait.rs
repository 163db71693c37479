//! A line on a terminal that shows what is being done, from the first second of a wait to its end.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A wait shorter than this shows no line.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between changes of the line.
const TICK: Duration = Duration::from_millis(200);

/// One wait, to its end when this is dropped.
pub(crate) struct Wait {
    /// Sends the text of the line to the thread that shows it; none where there is no terminal.
    shown: Option<(Sender<String>, JoinHandle<()>)>,
}

impl Wait {
    pub(crate) fn new() -> Self {
        let begin = || {
            let (sender, texts) = channel();
            (sender, std::thread::spawn(move || show(&texts)))
        };
        Self {
            shown: std::io::stderr().is_terminal().then(begin),
        }
    }

    /// Notes what is being done now.
    pub(crate) fn note(&self, doing: String) {
        if let Some((sender, _)) = &self.shown {
            // A line that cannot be shown is no failure.
            let _ = sender.send(doing);
        }
    }
}

impl Drop for Wait {
    fn drop(&mut self) {
        if let Some((sender, shown)) = self.shown.take() {
            // Without a sender the thread removes the line; what follows on the terminal must wait for that.
            drop(sender);
            let _ = shown.join();
        }
    }
}

/// Shows the texts that arrive, from the end of `PATIENCE` until the sender is dropped.
fn show(texts: &Receiver<String>) {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}  {elapsed}") {
        bar.set_style(style);
    }
    let end = std::time::Instant::now() + PATIENCE;
    loop {
        let left = end.saturating_duration_since(std::time::Instant::now());
        match texts.recv_timeout(left.max(TICK)) {
            Ok(doing) => bar.set_message(doing),
            Err(RecvTimeoutError::Timeout) => bar.tick(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    bar.finish_and_clear();
}
