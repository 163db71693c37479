//! The sources that the rules read: where they are, and the text that the rules look at.

use std::fs;
use std::path::{Path, PathBuf};

/// Path of a source below its `src` folder with `/` between the parts, and its text.
pub(crate) type Source = (String, String);

/// The folder that holds the crates of the workspace.
fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Rust files in a folder and its subfolders, but for what was built.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The Rust files of a crate's `src` folder.
pub(crate) fn of_crate(name: &str) -> Vec<PathBuf> {
    files(&crates().join(name).join("src"))
}

/// All Rust files of the workspace.
pub(crate) fn workspace() -> Vec<PathBuf> {
    files(&crates())
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
    let source = |path: PathBuf| {
        let below = path.strip_prefix(&root).unwrap();
        let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
        (parts.join("/"), fs::read_to_string(&path).unwrap())
    };
    of_crate(name).into_iter().map(source).collect()
}

/// The part of a text before its tests, without comments.
pub(crate) fn code(text: &str) -> String {
    let before = text.split("#[cfg(test)]\nmod tests").next();
    let lines = before.unwrap_or_default().lines();
    let kept = lines.filter(|line| !line.trim_start().starts_with("//"));
    kept.collect::<Vec<_>>().join("\n")
}
