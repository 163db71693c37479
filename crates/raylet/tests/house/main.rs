//! The rules of the house, held by reading the code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The layers of the library, lowest first.
const LAYERS: [&str; 6] = ["math", "optics", "wave", "engine", "design", "file"];

/// Longest file and longest function, in lines.
const LONGEST_FILE: usize = 600;
const LONGEST_FUNCTION: usize = 60;

/// Names that say nothing.
const EMPTY_NAMES: [&str; 4] = ["utils", "common", "helpers", "misc"];

/// Layer and file of a source.
type Place = (String, String);

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn library() -> Vec<PathBuf> {
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"))
}

fn workspace() -> Vec<PathBuf> {
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .into_iter()
        .filter(|path| !path.components().any(|part| part.as_os_str() == "target"))
        .collect()
}

/// The part of a file before its tests, without comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let before = text
        .split("#[cfg(test)]\nmod tests")
        .next()
        .unwrap_or_default();
    let lines = before
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// (layer, file) of a library source, and those that it names.
fn imports(path: &Path) -> Option<(Place, BTreeSet<Place>)> {
    let mut parts: Vec<String> = path
        .iter()
        .rev()
        .take(2)
        .map(|p| p.to_string_lossy().into_owned())
        .collect();
    let layer = parts.pop()?;
    let file = parts.pop()?.trim_end_matches(".rs").to_owned();
    if !LAYERS.contains(&layer.as_str()) || file == "mod" {
        return None;
    }
    let mut named = BTreeSet::new();
    for piece in code(path).split("crate::").skip(1) {
        let word = |text: &str| -> String {
            text.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        };
        let above = word(piece);
        let below = piece
            .strip_prefix(&format!("{above}::"))
            .map(word)
            .unwrap_or_default();
        named.insert((above, below));
    }
    Some(((layer, file), named))
}

#[test]
fn layers_look_only_down() {
    let place = |layer: &str| LAYERS.iter().position(|l| *l == layer);
    for path in library() {
        let Some(((layer, file), named)) = imports(&path) else {
            continue;
        };
        for (other, _) in named {
            let other_place = place(&other)
                .unwrap_or_else(|| panic!("{layer}/{file} goes through the crate root: {other}"));
            assert!(
                Some(other_place) <= place(&layer),
                "{layer}/{file} looks up into {other}"
            );
        }
        let text = code(&path);
        assert!(!text.contains("super::"), "{layer}/{file} uses super");
    }
}

#[test]
fn no_ring_inside_a_layer() {
    let mut graph: BTreeMap<Place, BTreeSet<Place>> = BTreeMap::new();
    for path in library() {
        if let Some((node, named)) = imports(&path) {
            let same = named
                .into_iter()
                .filter(|other| other.0 == node.0 && *other != node);
            graph.insert(node.clone(), same.collect());
        }
    }
    // Take away files that need nothing any more; what cannot be taken away is a ring.
    while !graph.is_empty() {
        let free: Vec<_> = graph
            .iter()
            .filter(|(_, needs)| needs.iter().all(|n| !graph.contains_key(n)))
            .map(|(node, _)| node.clone())
            .collect();
        assert!(!free.is_empty(), "import ring among {:?}", graph.keys());
        for node in free {
            graph.remove(&node);
        }
    }
}

#[test]
fn files_are_short_and_named_for_something() {
    for path in workspace() {
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().count();
        assert!(
            lines <= LONGEST_FILE,
            "{} has {lines} lines",
            path.display()
        );
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(!EMPTY_NAMES.contains(&name.as_str()), "{}", path.display());
    }
}

#[test]
fn functions_are_short() {
    for path in library() {
        let text = code(&path);
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
fn nothing_is_left_undone_or_printed() {
    let marks = ["TODO", "FIXME", "XXX", "HACK"];
    let is_test = |path: &PathBuf| path.to_string_lossy().ends_with("_test.rs");
    for path in library().into_iter().filter(|path| !is_test(path)) {
        let text = code(&path);
        for mark in marks {
            assert!(!text.contains(mark), "{} holds {mark}", path.display());
        }
        for call in ["println!", "eprintln!", "dbg!", "process::exit"] {
            assert!(!text.contains(call), "{} calls {call}", path.display());
        }
    }
}

#[test]
fn every_adjoint_stands_below_its_forward_and_is_tested() {
    for path in library() {
        let text = fs::read_to_string(&path).unwrap();
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
