//! The rule that no file is forgotten: the compiler is silent about a file that no `mod` names.

use std::collections::BTreeMap;

use crate::source::Source;

/// What the file is called that names the modules of its folder.
const ROOTS: [&str; 4] = ["mod.rs", "lib.rs", "main.rs", "integration.rs"];

/// The folders of a crate in which every file is a program of its own.
const PROGRAMS: [&str; 3] = ["examples", "benches", "bin"];

/// Rust files that no file of their folder names as a module.
pub(crate) fn orphans(sources: &[Source]) -> Vec<String> {
    let texts: BTreeMap<&str, &str> = sources.iter().map(|(p, t)| (&**p, &**t)).collect();
    let mut found = Vec::new();
    for path in texts.keys().filter(|path| path.ends_with(".rs")) {
        let (folder, file) = path.rsplit_once('/').unwrap_or(("", path));
        if PROGRAMS.iter().any(|name| folder.ends_with(name)) || file == "build.rs" {
            continue;
        }
        // A folder is the module that the folder above names.
        let (folder, name) = match file {
            "mod.rs" => folder.rsplit_once('/').unwrap_or(("", folder)),
            _ if ROOTS.contains(&file) => continue,
            _ => (folder, file.trim_end_matches(".rs")),
        };
        let declares = |root: &str| {
            let root = format!("{folder}/{root}");
            let text = texts.get(root.trim_start_matches('/'));
            text.is_some_and(|text| text.lines().any(|line| declared(line) == Some(name)))
        };
        if !ROOTS.iter().any(|root| declares(root)) {
            found.push(format!("{path} is in no module"));
        }
    }
    found
}

/// The module that a line such as `pub(crate) mod name;` declares.
fn declared(line: &str) -> Option<&str> {
    let (before, after) = line.split_once("mod ")?;
    let visibility = before.trim();
    (visibility.is_empty() || visibility.starts_with("pub")).then_some(())?;
    after.trim_end().strip_suffix(';')
}
