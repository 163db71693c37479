//! The rule on tables: the file that heads a folder names in its table all that the folder holds, and nothing else.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::Source;

/// The files that head a folder.
const HEADS: [&str; 3] = ["mod.rs", "lib.rs", "main.rs"];

/// The last column of a table of files and folders.
const HOLDS: &str = "| what it holds |";

/// Rows that a table lacks, and rows of what is not there.
pub(crate) fn tables(sources: &[Source]) -> Vec<String> {
    let texts: BTreeMap<&str, &str> = sources.iter().map(|(p, t)| (&**p, &**t)).collect();
    let mut found = Vec::new();
    for (path, text) in &texts {
        let (folder, file) = split(path);
        // A program beside a library has the library's table.
        let library = path.replace("main.rs", "lib.rs");
        let beside = file == "main.rs" && texts.contains_key(&*library);
        if !HEADS.contains(&file) || beside {
            continue;
        }
        let (held, named) = (held(&texts, folder), named(text));
        let missing = held.difference(&named);
        found.extend(missing.map(|name| format!("{path} has no row for {name}")));
        let absent = named.difference(&held);
        found.extend(absent.map(|name| format!("{path} has a row for {name}, which is not there")));
    }
    found
}

/// The folder and the name of a file.
fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or(("", path))
}

/// The modules in a folder: its files, and its subfolders that have a head.
fn held(texts: &BTreeMap<&str, &str>, folder: &str) -> BTreeSet<String> {
    let module = |path: &&str| {
        let (within, file) = split(path);
        let stem = file.strip_suffix(".rs")?;
        if within == folder {
            return (!HEADS.contains(&file)).then(|| stem.to_owned());
        }
        let (above, name) = split(within);
        (file == "mod.rs" && above == folder).then(|| name.to_owned())
    };
    texts.keys().filter_map(module).collect()
}

/// The names in the first column of the tables of files and folders at the head of a text.
fn named(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut within = false;
    for line in text.lines().take_while(|line| line.starts_with("//!")) {
        within = line.starts_with("//! |") && (within || line.ends_with(HOLDS));
        if !within {
            continue;
        }
        // Several files may share a row.
        let names = line.split('|').nth(1).unwrap_or_default();
        let names = names.split('`').skip(1).step_by(2);
        found.extend(names.map(|name| name.trim_start_matches("mod@").to_owned()));
    }
    found
}
