//! The rule on output: a library prints nothing and ends no process, and tests say what they measure in assertions.

use crate::source::Source;

/// Sources of libraries and of tests that print, or end the process. Examples and benches may.
pub(crate) fn prints(sources: &[Source]) -> Vec<String> {
    // Whole words: `println!` is not in `eprintln!`.
    let calls = [
        "print!",
        "println!",
        "eprint!",
        "eprintln!",
        "dbg!",
        "process::exit",
    ];
    let held = |path: &str| ["/src/", "/tests/"].iter().any(|part| path.contains(part));
    let mut found = Vec::new();
    // The tests of these rules name the calls.
    let sources = sources
        .iter()
        .filter(|(path, _)| held(path) && !path.contains("/house/"));
    for (path, text) in sources {
        let lines = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        for line in lines {
            let called = calls.iter().find(|call| calls_it(line, call));
            found.extend(called.map(|call| format!("{path} calls {call}")));
        }
    }
    found
}

/// Whether a line holds a call, not as the end of a longer name.
fn calls_it(line: &str, call: &str) -> bool {
    let mut places = line.match_indices(call);
    places.any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
}
