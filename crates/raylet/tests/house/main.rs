//! The rules of the house, held by reading the code.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `source` | The sources that the rules read |
//! | `imports` | Which modules the code of a file names |
//! | `rules` | The rules on imports |
//! | `sizes` | The rules on sizes |
//! | `words` | The rules on names and on marks of what is left undone |
//! | `adjoints` | The rule on adjoints |
//! | `orphans` | The rule that no file is forgotten |
//! | `tables` | The rule that the table of a folder names what the folder holds |
//! | `prints` | The rule on output |
//! | `planted` | Sources that break the rules on imports, folders and output, and what is found in them |
//! | `planted_code` | The same for functions, words and adjoints |

mod adjoints;
mod imports;
mod orphans;
mod planted;
mod planted_code;
mod prints;
mod rules;
mod sizes;
mod source;
mod tables;
mod words;

use crate::adjoints::lone_adjoints;
use crate::orphans::orphans;
use crate::prints::prints;
use crate::rules::{looks_up, ring, through_the_root, uses_super};
use crate::sizes::{full_folders, long_files, long_functions};
use crate::source::{Source, all_sources, crate_names, sources};
use crate::tables::tables;
use crate::words::{empty_names, left_undone};

/// The libraries whose adjoints stand beside their forward steps; bindings and references have theirs elsewhere.
const LIBRARIES: [&str; 3] = ["raylet", "raylet-plot", "raylet-paper"];

/// The crates with a program that prints.
const PROGRAMS: [&str; 2] = ["raylet-accuracy", "raylet-cli"];

/// The Rust sources in the `src` folders of these crates, with their paths from the root of the repository.
fn code_of<T: AsRef<str>>(names: &[T]) -> Vec<Source> {
    let folders: Vec<String> = names.iter().map(|name| folder(name.as_ref())).collect();
    let mut sources = all_sources();
    sources.retain(|(path, _)| path.ends_with(".rs") && starts(path, &folders));
    sources
}

/// The `src` folder of a crate.
fn folder(name: &str) -> String {
    format!("crates/{name}/src/")
}

/// Whether a file is in one of these folders.
fn starts(path: &str, folders: &[String]) -> bool {
    folders.iter().any(|folder| path.starts_with(folder))
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
    assert_eq!(empty_names(&all_sources()), Vec::<String>::new());
}

#[test]
fn functions_are_short() {
    let names = crate_names();
    let sources = code_of(&names);
    for name in names {
        let folder = [folder(&name)];
        let found = sources.iter().any(|(path, _)| starts(path, &folder));
        assert!(found, "{name}");
    }
    assert_eq!(long_functions(&sources), Vec::<String>::new());
}

#[test]
fn nothing_is_left_undone() {
    assert_eq!(left_undone(&all_sources()), Vec::<String>::new());
}

#[test]
fn libraries_and_tests_print_nothing() {
    let programs = PROGRAMS.map(folder);
    let mut sources = all_sources();
    sources.retain(|(path, _)| path.starts_with("crates/") && !starts(path, &programs));
    assert!(sources.len() > 300, "{}", sources.len());
    assert_eq!(prints(&sources), Vec::<String>::new());
}

#[test]
fn every_adjoint_stands_below_its_forward_and_has_a_dot_product_test() {
    let parts = ["src", "tests"].map(|part| LIBRARIES.map(|name| format!("crates/{name}/{part}/")));
    let folders = parts.as_flattened();
    let mut sources = all_sources();
    // The tests of these rules hold sources that break them.
    sources.retain(|(path, _)| {
        path.ends_with(".rs") && starts(path, folders) && !path.contains("/house/")
    });
    assert!(sources.len() > 250, "{}", sources.len());
    assert_eq!(lone_adjoints(&sources), Vec::<String>::new());
}
