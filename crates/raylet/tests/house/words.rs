//! The rules on words. Each takes the sources of the repository and returns what breaks it.

use crate::source::Source;

/// Names that say nothing.
const EMPTY_NAMES: [&str; 4] = ["utils", "common", "helpers", "misc"];

/// Marks of what is left undone.
const MARKS: [&str; 4] = ["TODO", "FIXME", "XXX", "HACK"];

/// Files and folders whose names say nothing.
pub(crate) fn empty_names(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, _) in sources {
        let mut parts = path.split(['/', '.']);
        let empty = parts.find(|part| EMPTY_NAMES.contains(part));
        found.extend(empty.map(|name| format!("{path} is named {name}")));
    }
    found
}

/// Sources that say what is left undone.
pub(crate) fn left_undone(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    // The tests of these rules name the marks.
    for (path, text) in sources.iter().filter(|(path, _)| !path.contains("/house/")) {
        let marks = MARKS.iter().filter(|mark| text.contains(**mark));
        found.extend(marks.map(|mark| format!("{path} holds {mark}")));
    }
    found
}
