//! How bad input must be refused.

use crate::stage::{Stage, complaint};

/// What is wrong with a refusal, if anything: it is one error with exit code 2 that says what was found and
/// what was expected, names these pieces, and comes before anything is written.
pub(crate) fn wrong(stage: &Stage, arguments: &[&str], says: &[&str]) -> Option<String> {
    let before = stage.names();
    let output = stage.raylet(arguments);
    let message = complaint(&output);
    let fine = output.status.code() == Some(2)
        && message.starts_with("error: ")
        && message.matches("error:").count() == 1
        && (message.contains("expected") || message.contains("invalid value"))
        && !message.contains("panicked")
        && says.iter().all(|piece| message.contains(piece))
        && output.stdout.is_empty()
        && stage.names() == before;
    let code = output.status.code();
    (!fine).then(|| format!("{arguments:?} should say {says:?}: {code:?} in\n{message}"))
}

/// Fails with all that is wrong.
pub(crate) fn none_of(wrong: impl IntoIterator<Item = Option<String>>) {
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
