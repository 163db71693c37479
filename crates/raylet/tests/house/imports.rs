//! Which modules the code of a file names.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{Source, code};

/// The module path of a file below the crate root: `["engine", "walk"]`; empty for the root itself.
pub(crate) type Place = Vec<String>;

/// The file of every module of a crate, with the places that its code names.
pub(crate) struct Imports {
    /// Path of the file, by its place.
    pub(crate) file: BTreeMap<Place, String>,
    /// Paths that the code names, as they are written but from the crate root, by the place of the file.
    pub(crate) named: BTreeMap<Place, BTreeSet<Vec<String>>>,
}

/// A path of a `use` or of an expression, and the name that it goes by where that is another one.
struct Named {
    path: Vec<String>,
    alias: Option<String>,
}

/// The place of a file: `engine/mod.rs` is the module `engine`, `lib.rs` and `main.rs` are the root.
pub(crate) fn place(path: &str) -> Place {
    let stem = path.trim_end_matches(".rs");
    let mut parts: Place = stem.split('/').map(str::to_owned).collect();
    let last = parts.last().map_or("", String::as_str);
    if last == "mod" || (parts.len() == 1 && (last == "lib" || last == "main")) {
        parts.pop();
    }
    parts
}

impl Imports {
    /// Reads the imports of all files of a crate. Where it has a library and a program, the library counts.
    pub(crate) fn of(sources: &[Source]) -> Self {
        let library = sources.iter().any(|(path, _)| path == "lib.rs");
        let kept = || {
            sources
                .iter()
                .filter(move |(path, _)| !(library && path == "main.rs"))
        };
        let file = kept().map(|(path, _)| (place(path), path.clone()));
        let mut imports = Self {
            file: file.collect(),
            named: BTreeMap::new(),
        };
        for (path, text) in kept() {
            let place = place(path);
            let named = imports.read(&place, &code(text));
            imports.named.insert(place, named);
        }
        imports
    }

    /// The file whose module a path enters last: the deepest one that exists.
    pub(crate) fn resolve(&self, path: &[String]) -> Place {
        let mut place = path.to_vec();
        while !place.is_empty() && !self.file.contains_key(&place) {
            place.pop();
        }
        place
    }

    /// The places of other files that a file names.
    pub(crate) fn needs(&self, place: &Place) -> BTreeSet<Place> {
        let paths = self.named[place].iter();
        let found = paths.map(|path| self.resolve(path));
        found.filter(|other| other != place).collect()
    }

    /// Paths from the crate root that the code of a file names.
    fn read(&self, place: &Place, text: &str) -> BTreeSet<Vec<String>> {
        let parent = || place[..place.len().saturating_sub(1)].to_vec();
        let mut found = paths(text, "crate", &[]);
        found.extend(paths(text, "self", place));
        found.extend(paths(text, "super", &parent()));
        // Modules that the file can name without `crate::`: its own, and those that it has imported.
        let mut short: BTreeMap<String, Place> = BTreeMap::new();
        for module in self.file.keys() {
            if module.len() == place.len() + 1 && module.starts_with(place) {
                short.insert(module[place.len()].clone(), module.clone());
            }
        }
        for Named { path, alias } in &found {
            if let (Some(last), true) = (path.last(), self.file.contains_key(path)) {
                short.insert(alias.as_ref().unwrap_or(last).clone(), path.clone());
            }
        }
        for (name, module) in short {
            found.extend(paths(text, &name, &module));
        }
        found.into_iter().map(|named| named.path).collect()
    }
}

/// All paths in a text that begin with this word, which means the module `start`.
fn paths(text: &str, word: &str, start: &[String]) -> Vec<Named> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices(&format!("{word}::")) {
        let before = text[..at].trim_end_matches('$');
        let inside = before.ends_with(|c: char| is_letter(c) || c == ':');
        // `pub(in crate::x)` says who may see an item; it imports nothing.
        if !inside && !before.ends_with("pub(in ") {
            branches(&text[at + word.len() + 2..], start, &mut found);
        }
    }
    found
}

/// Reads what stands after `::`: a name, a group in braces, or a star. Returns what follows it.
fn branches<'a>(text: &'a str, before: &[String], found: &mut Vec<Named>) -> &'a str {
    let mut path = before.to_vec();
    let mut rest = text.trim_start();
    if let Some(group) = rest.strip_prefix('{') {
        rest = group.trim_start();
        while !rest.is_empty() && !rest.starts_with('}') {
            let after = branches(rest, &path, found).trim_start();
            let next = after.strip_prefix(',').unwrap_or(after).trim_start();
            // What is no path ends the group.
            rest = if next.len() == rest.len() { "" } else { next };
        }
        return rest.strip_prefix('}').unwrap_or(rest);
    }
    let name = word(rest);
    rest = &rest[name.len()..];
    match name {
        // A star names the module itself, and so does `self` in a group.
        "" => rest = rest.strip_prefix('*').unwrap_or(rest),
        "self" => (),
        "super" => _ = path.pop(),
        name => path.push(name.to_owned()),
    }
    let deeper = rest.strip_prefix("::");
    if let Some(deeper) = deeper.filter(|deeper| !deeper.starts_with('<')) {
        return branches(deeper, &path, found);
    }
    let alias = rest.trim_start().strip_prefix("as ").map(str::trim_start);
    if let Some(alias) = alias {
        rest = &alias[word(alias).len()..];
    }
    let alias = alias.map(|alias| word(alias).to_owned());
    found.push(Named { path, alias });
    rest
}

/// The name that a text begins with.
fn word(text: &str) -> &str {
    let end = text.find(|c: char| !is_letter(c)).unwrap_or(text.len());
    &text[..end]
}

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}
