//! The rules on sizes. Each takes the sources of the repository and returns what breaks it.

use std::collections::BTreeMap;

use crate::source::Source;

/// Longest file, in lines.
const LONGEST_FILE: usize = 600;

/// Most source files that stand directly in one folder.
const FULLEST_FOLDER: usize = 25;

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
