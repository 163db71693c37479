//! The rules on imports. Each takes the sources of a crate and returns what breaks it.

use std::collections::{BTreeMap, BTreeSet};

use crate::imports::{Imports, Place, place};
use crate::source::{Source, code};

/// The layers of the library, lowest first.
pub(crate) const LAYERS: [&str; 6] = ["math", "optics", "wave", "engine", "design", "file"];

/// Layers look only down. Every file below the root belongs to a layer.
pub(crate) fn looks_up(sources: &[Source]) -> Vec<String> {
    let imports = Imports::of(sources);
    let mut found = Vec::new();
    for (place, named) in &imports.named {
        let Some(layer) = place.first() else { continue };
        let file = &imports.file[place];
        let Some(height) = height(layer) else {
            found.push(format!("{file} is in no layer"));
            continue;
        };
        for path in named {
            let other = path.first().and_then(|layer| self::height(layer));
            if other.is_some_and(|other| other > height) {
                found.push(format!("{file} looks up into {}", path.join("::")));
            }
        }
    }
    found
}

/// No import goes through the crate root: what follows `crate::` is a layer, or the fixtures, which only tests have.
pub(crate) fn through_the_root(sources: &[Source]) -> Vec<String> {
    let imports = Imports::of(sources);
    let mut found = Vec::new();
    for (place, named) in imports.named.iter().filter(|(place, _)| !place.is_empty()) {
        let inside = |word: &String| height(word).is_some() || word == "fixtures";
        let outside = |path: &&Vec<String>| !path.first().is_some_and(inside);
        for path in named.iter().filter(outside) {
            let (file, path) = (&imports.file[place], path.join("::"));
            found.push(format!("{file} goes through the crate root: {path}"));
        }
    }
    found
}

/// No file uses `super`, but for its tests.
pub(crate) fn uses_super(sources: &[Source]) -> Vec<String> {
    let below = sources.iter().filter(|(path, _)| !place(path).is_empty());
    let using = below.filter(|(_, text)| code(text).contains("super::"));
    using
        .map(|(path, _)| format!("{path} uses super"))
        .collect()
}

/// No ring of imports: files can be put in an order in which each needs only earlier ones.
pub(crate) fn ring(sources: &[Source]) -> Vec<String> {
    let imports = Imports::of(sources);
    let mut graph: BTreeMap<&Place, BTreeSet<Place>> = BTreeMap::new();
    for place in imports.file.keys() {
        graph.insert(place, imports.needs(place));
    }
    // Take away files that need nothing any more; what cannot be taken away is a ring, or leads to one.
    loop {
        let free = |needs: &BTreeSet<Place>| needs.iter().all(|need| !graph.contains_key(need));
        let bound = graph.iter().filter(|(_, needs)| !free(needs));
        let bound: BTreeSet<&Place> = bound.map(|(place, _)| *place).collect();
        if bound.len() == graph.len() {
            break;
        }
        graph.retain(|place, _| bound.contains(place));
    }
    let Some((&start, _)) = graph.first_key_value() else {
        return Vec::new();
    };
    vec![walk(start, &graph, &imports)]
}

/// A ring that a walk among files comes to, each of which needs another one of them.
fn walk(start: &Place, graph: &BTreeMap<&Place, BTreeSet<Place>>, imports: &Imports) -> String {
    let mut way = vec![start];
    loop {
        let needs = &graph[way[way.len() - 1]];
        let next = needs.iter().find(|need| graph.contains_key(need)).unwrap();
        if let Some(first) = way.iter().position(|place| *place == next) {
            let names = way[first..].iter().chain([&next]);
            let names = names.map(|place| imports.file[*place].as_str());
            return format!("import ring: {}", names.collect::<Vec<_>>().join(" -> "));
        }
        way.push(next);
    }
}

fn height(layer: &str) -> Option<usize> {
    LAYERS.iter().position(|name| *name == layer)
}
