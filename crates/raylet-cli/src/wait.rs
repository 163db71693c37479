//! What is being done, from the first second of a wait to its end: one line on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::say::complain;

/// A wait shorter than this shows no line.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between changes of the line.
const TICK: Duration = Duration::from_millis(200);

/// Time between plain lines.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// One wait, to its end when this is dropped.
pub(crate) struct Wait {
    /// Sends the text of the line to the thread that shows it; none when the wait has ended.
    shown: Option<(Sender<String>, JoinHandle<()>)>,
}

impl Wait {
    pub(crate) fn new() -> Self {
        let (sender, texts) = channel();
        let terminal = std::io::stderr().is_terminal();
        let shown = std::thread::spawn(move || match terminal {
            true => show(&texts),
            false => write_lines(&texts),
        });
        Self {
            shown: Some((sender, shown)),
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

/// Shows the texts that arrive on a terminal, from the end of `PATIENCE` until the sender is dropped.
fn show(texts: &Receiver<String>) {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}  {elapsed}") {
        bar.set_style(style);
    }
    let end = Instant::now() + PATIENCE;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        match texts.recv_timeout(left.max(TICK)) {
            Ok(doing) => bar.set_message(doing),
            Err(RecvTimeoutError::Timeout) => bar.tick(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    bar.finish_and_clear();
}

/// Writes the newest of the texts that arrive as a line, from the end of `PATIENCE` on, every `BETWEEN_LINES`.
fn write_lines(texts: &Receiver<String>) {
    let start = Instant::now();
    let (mut next, mut doing) = (start + PATIENCE, String::new());
    loop {
        match texts.recv_timeout(next.saturating_duration_since(Instant::now())) {
            Ok(text) => doing = text,
            Err(RecvTimeoutError::Timeout) => {
                complain(&format!("{:.0} s: {doing}", start.elapsed().as_secs_f64()));
                next = Instant::now() + BETWEEN_LINES;
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
}
