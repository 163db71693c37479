//! The rule on adjoints: each stands below its forward step, and a dot-product test holds it.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{Source, code};

/// The name of a function, and what stands between it and the next function.
type Function<'a> = (&'a str, &'a str);

/// Adjoints, which are the functions outside of tests whose names end with `_adjoint`, that break the rule:
///
/// - Above `step_adjoint` its file has `step`, or a function whose name goes on, such as `step_at`.
/// - A test of the same file with `dot_product` or `inner_product` in its name calls the adjoint, or functions of the
///   file that do. Where none does, comments of the file name such a test of another file, in backticks, and it is
///   there; what that one calls is not looked at.
///
/// A function counts as called where its name is among the words of a body, whatever type it belongs to.
pub(crate) fn lone_adjoints(sources: &[Source]) -> Vec<String> {
    let parts: Vec<[String; 2]> = sources.iter().map(|(_, text)| parts(text)).collect();
    let mut homes: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for ((path, _), parts) in sources.iter().zip(&parts) {
        let names = parts.iter().flat_map(|part| functions(part));
        for (name, _) in names.filter(|(name, _)| is_dot_product(name)) {
            homes.entry(name).or_default().insert(path);
        }
    }
    let mut found = Vec::new();
    for ((path, text), [code, tests]) in sources.iter().zip(&parts) {
        let (own, tests) = (functions(code), functions(tests));
        let called = called(&own, &tests);
        let mut places = named(text).filter_map(|test| homes.get(test)).flatten();
        let tested_elsewhere = places.any(|home| home != path);
        for (place, (name, _)) in own.iter().enumerate() {
            let Some(step) = name.strip_suffix("_adjoint") else {
                continue;
            };
            let mut above = own[..place].iter();
            if !above.any(|(name, _)| is_forward(name, step)) {
                found.push(format!("{path}: {name} has no forward above it"));
            }
            if !called.contains(name) && !tested_elsewhere {
                found.push(format!("{path}: {name} has no dot-product test"));
            }
        }
    }
    found
}

/// What a text holds before its tests, and its tests, both without comments.
fn parts(text: &str) -> [String; 2] {
    let tests = text.split_once("#[cfg(test)]\nmod tests");
    [code(text), code(tests.map_or("", |(_, tests)| tests))]
}

/// The functions of a text.
fn functions(text: &str) -> Vec<Function<'_>> {
    let heads = text.split("fn ").skip(1);
    let functions = heads.map(|head| {
        let end = head.find(|c: char| !is_letter(c));
        head.split_at(end.unwrap_or(head.len()))
    });
    functions.collect()
}

/// The names of the functions that the dot-product tests of a file call, themselves or by way of others of the file.
fn called<'a>(own: &[Function<'a>], tests: &[Function<'a>]) -> BTreeSet<&'a str> {
    let all = || own.iter().chain(tests);
    let first = tests.iter().filter(|(name, _)| is_dot_product(name));
    let mut bodies: Vec<&str> = first.map(|(_, body)| *body).collect();
    let mut called = BTreeSet::new();
    while let Some(body) = bodies.pop() {
        let words: BTreeSet<&str> = body.split(|c: char| !is_letter(c)).collect();
        for (name, _) in all().filter(|(name, _)| words.contains(name)) {
            if called.insert(*name) {
                let same = all().filter(|(other, _)| other == name);
                bodies.extend(same.map(|(_, body)| *body));
            }
        }
    }
    called
}

/// The dot-product tests that the comments of a text name in backticks.
fn named(text: &str) -> impl Iterator<Item = &str> {
    let comments = text
        .lines()
        .filter(|line| line.trim_start().starts_with("//"));
    let quoted = comments.flat_map(|line| line.split('`').skip(1).step_by(2));
    quoted.filter(|name| is_dot_product(name))
}

fn is_dot_product(name: &str) -> bool {
    name.contains("dot_product") || name.contains("inner_product")
}

/// Whether a function of this name is the forward of `step_adjoint`.
fn is_forward(name: &str, step: &str) -> bool {
    let more = name.strip_prefix(step);
    let is_step = more.is_some_and(|more| more.is_empty() || more.starts_with('_'));
    is_step && !name.ends_with("_adjoint")
}

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}
