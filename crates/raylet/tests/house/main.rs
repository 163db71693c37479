//! The rules of the house, held by reading the code.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `source` | The sources that the rules read |
//! | `imports` | Which modules the code of a file names |
//! | `rules` | The rules on imports |
//! | `sizes` | The rules on sizes |
//! | `orphans` | The rule that no file is forgotten |
//! | `tables` | The rule that the table of a folder names what the folder holds |
//! | `prints` | The rule on output |
//! | `planted` | Sources that break these rules, and what is found in them |

mod imports;
mod orphans;
mod planted;
mod prints;
mod rules;
mod sizes;
mod source;
mod tables;

use std::fs;
use std::path::PathBuf;

use crate::orphans::orphans;
use crate::prints::prints;
use crate::rules::{looks_up, ring, through_the_root, uses_super};
use crate::sizes::{full_folders, long_files};
use crate::source::{all_sources, code, crate_names, of_crate, sources, workspace};
use crate::tables::tables;

/// Longest function, in lines.
const LONGEST_FUNCTION: usize = 60;

/// Names that say nothing.
const EMPTY_NAMES: [&str; 4] = ["utils", "common", "helpers", "misc"];

/// The crates whose code the rules on functions hold.
const LIBRARIES: [&str; 3] = ["raylet", "raylet-plot", "raylet-paper"];

fn libraries() -> Vec<PathBuf> {
    LIBRARIES.iter().flat_map(|name| of_crate(name)).collect()
}

fn text(path: &PathBuf) -> String {
    fs::read_to_string(path).unwrap()
}

#[test]
fn layers_look_only_down() {
    let library = sources("raylet");
    for rule in [looks_up, through_the_root, uses_super] {
        assert_eq!(rule(&library), Vec::<String>::new());
    }
}

#[test]
fn no_crate_has_a_ring() {
    let names = crate_names();
    assert!(names.len() >= 4, "{names:?}");
    for name in names {
        assert_eq!(ring(&sources(&name)), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn files_are_short_and_folders_small() {
    let sources = all_sources();
    assert!(sources.len() > 400, "{}", sources.len());
    assert_eq!(long_files(&sources), Vec::<String>::new());
    assert_eq!(full_folders(&sources), Vec::<String>::new());
}

#[test]
fn every_file_is_compiled() {
    let sources = all_sources();
    assert_eq!(orphans(&sources), Vec::<String>::new());
}

#[test]
fn tables_name_what_folders_hold() {
    let sources = all_sources();
    assert_eq!(tables(&sources), Vec::<String>::new());
}

#[test]
fn files_are_named_for_something() {
    for path in workspace() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(!EMPTY_NAMES.contains(&name.as_str()), "{}", path.display());
    }
}

#[test]
fn functions_are_short() {
    for path in libraries() {
        let text = code(&text(&path));
        let lines: Vec<&str> = text.lines().collect();
        for (start, line) in lines.iter().enumerate() {
            let head = line.trim_start();
            let starts = ["fn ", "pub fn ", "pub(crate) fn ", "pub const fn "];
            if !starts.iter().any(|s| head.starts_with(s)) || head.ends_with(';') {
                continue;
            }
            // A formatted function ends at the first closing brace with its own indentation.
            let close = format!("{}}}", &line[..line.len() - head.len()]);
            let length = lines[start..].iter().position(|l| *l == close).unwrap_or(0) + 1;
            let place = format!("{}:{}", path.display(), start + 1);
            assert!(length <= LONGEST_FUNCTION, "{place} has {length} lines");
        }
    }
}

#[test]
fn nothing_is_left_undone() {
    let is_test = |path: &PathBuf| path.to_string_lossy().ends_with("_test.rs");
    for path in libraries().into_iter().filter(|path| !is_test(path)) {
        let text = code(&text(&path));
        for mark in ["TODO", "FIXME", "XXX", "HACK"] {
            assert!(!text.contains(mark), "{} holds {mark}", path.display());
        }
    }
}

#[test]
fn libraries_and_their_tests_print_nothing() {
    let folders = LIBRARIES.map(|name| format!("crates/{name}/"));
    let mut sources = all_sources();
    sources.retain(|(path, _)| folders.iter().any(|folder| path.starts_with(folder)));
    assert!(sources.len() > 250, "{}", sources.len());
    assert_eq!(prints(&sources), Vec::<String>::new());
}

#[test]
fn every_adjoint_stands_below_its_forward_and_is_tested() {
    for path in libraries() {
        let text = text(&path);
        for piece in text.split("fn ").skip(1) {
            let name: String = piece
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            let Some(forward) = name.strip_suffix("_adjoint") else {
                continue;
            };
            let up = text.find(&format!("fn {forward}"));
            let down = text.find(&format!("fn {name}"));
            assert!(
                up.is_some() && up < down,
                "{}: {name} has no forward",
                path.display()
            );
            assert!(
                text.contains("dot_product") || text.contains("inner_product"),
                "{}: {name} has no dot-product test",
                path.display()
            );
        }
    }
}
