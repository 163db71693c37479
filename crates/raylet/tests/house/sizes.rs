//! The rules on sizes. Each takes the sources of the repository and returns what breaks it.

use std::collections::BTreeMap;

use crate::source::{Source, code};

/// Longest file, in lines.
const LONGEST_FILE: usize = 600;

/// Longest function, in lines without comments.
const LONGEST_FUNCTION: usize = 60;

/// Most source files that stand directly in one folder.
const FULLEST_FOLDER: usize = 25;

/// What may stand before `fn`, beside the name of a foreign interface and the module that a visibility names.
const QUALIFIERS: [&str; 6] = ["pub", "default", "const", "async", "unsafe", "extern"];

/// Files that are too long.
pub(crate) fn long_files(sources: &[Source]) -> Vec<String> {
    let lengths = sources
        .iter()
        .map(|(path, text)| (path, text.lines().count()));
    let long = lengths.filter(|(_, lines)| *lines > LONGEST_FILE);
    long.map(|(path, lines)| format!("{path} has {lines} lines"))
        .collect()
}

/// Folders that hold too many files.
pub(crate) fn full_folders(sources: &[Source]) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (path, _) in sources {
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        *counts.entry(folder).or_default() += 1;
    }
    let full = counts
        .into_iter()
        .filter(|(_, files)| *files > FULLEST_FOLDER);
    full.map(|(folder, files)| format!("{folder} has {files} source files"))
        .collect()
}

/// Functions outside of tests that are too long.
pub(crate) fn long_functions(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in sources {
        let text = code(text);
        let lines: Vec<&str> = text.lines().collect();
        for (start, line) in lines.iter().enumerate() {
            let Some(name) = function(line) else { continue };
            let length = length(&lines[start..]);
            if length > LONGEST_FUNCTION {
                found.push(format!("{path}: {name} has {length} lines"));
            }
        }
    }
    found
}

/// The name of the function that a line begins.
fn function(line: &str) -> Option<&str> {
    let (before, after) = line.split_once("fn ")?;
    // `pub(in crate::engine)`: who sees a function is no matter here.
    let words = match before.split_once('(') {
        Some((visibility, inside)) => [visibility, inside.split_once(')')?.1],
        None => [before, ""],
    };
    let mut words = words.iter().flat_map(|part| part.split_whitespace());
    let qualified = words.all(|word| QUALIFIERS.contains(&word) || word.starts_with('"'));
    let end = after.find(|c: char| !c.is_alphanumeric() && c != '_')?;
    qualified.then_some(&after[..end])
}

/// How many lines the function has that begins with the first one.
fn length(lines: &[&str]) -> usize {
    let head = lines[0];
    if head.ends_with(['}', ';']) {
        return 1;
    }
    // A formatted body ends at the first closing brace with the indentation of its head, a declaration in a trait with
    // its last bracket.
    let indent = &head[..head.len() - head.trim_start().len()];
    let (body, list) = (format!("{indent}}}"), format!("{indent})"));
    let ends = |line: &&str| **line == body || (line.starts_with(&list) && line.ends_with(';'));
    let end = lines.iter().position(ends);
    end.map_or(lines.len(), |end| end + 1)
}
