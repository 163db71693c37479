//! The sources that the rules read: where they are, and the text that the rules look at.

use std::fs;
use std::path::{Path, PathBuf};

/// Path of a source below a folder (its `src`, or the repository) with `/` between the parts, and its text.
pub(crate) type Source = (String, String);

/// The folder that holds the crates of the workspace.
fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Rust files in a folder and its subfolders, but for what was built.
fn files(folder: &Path) -> Vec<PathBuf> {
    files_of(folder, &["rs"])
}

/// The files with one of these endings in a folder and its subfolders, but for what was built.
fn files_of(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let ends = |path: &Path| endings.iter().any(|e| path.extension() == Some(e.as_ref()));
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(files_of(&path, endings));
        } else if ends(&path) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The Rust files of a crate's `src` folder.
fn of_crate(name: &str) -> Vec<PathBuf> {
    files(&crates().join(name).join("src"))
}

/// The Rust and Python sources of the repository, with their paths from its root.
pub(crate) fn all_sources() -> Vec<Source> {
    let root = crates().join("..");
    let folders = ["crates", "python", "fuzz", "docs"].map(|name| root.join(name));
    let paths = folders.iter().flat_map(|f| files_of(f, &["rs", "py"]));
    paths.map(|path| source(&root, &path)).collect()
}

/// A source with its path below a folder.
fn source(folder: &Path, path: &Path) -> Source {
    let below = path.strip_prefix(folder).unwrap();
    let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
    (parts.join("/"), fs::read_to_string(path).unwrap())
}

/// The names of all crates of the workspace.
pub(crate) fn crate_names() -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(crates()).unwrap() {
        let path = entry.unwrap().path();
        if path.join("Cargo.toml").is_file() {
            names.push(path.file_name().unwrap().to_string_lossy().into_owned());
        }
    }
    names.sort();
    names
}

/// The sources of a crate, as the rules on imports take them.
pub(crate) fn sources(name: &str) -> Vec<Source> {
    let root = crates().join(name).join("src");
    of_crate(name)
        .iter()
        .map(|path| source(&root, path))
        .collect()
}

/// The part of a text before its tests, without comments.
pub(crate) fn code(text: &str) -> String {
    let before = text.split("#[cfg(test)]\nmod tests").next();
    let lines = before.unwrap_or_default().lines();
    let kept = lines.filter(|line| !line.trim_start().starts_with("//"));
    kept.collect::<Vec<_>>().join("\n")
}
