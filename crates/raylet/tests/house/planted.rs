//! Every rule on imports, folders and output finds what is planted to break it, and nothing in sources that keep it.

use crate::orphans::orphans;
use crate::prints::prints;
use crate::rules::{looks_up, ring, through_the_root, uses_super};
use crate::sizes::{full_folders, long_files};
use crate::source::Source;
use crate::tables::tables;

fn sources(pairs: &[(&str, &str)]) -> Vec<Source> {
    let source = |(path, text): &(&str, &str)| ((*path).to_owned(), (*text).to_owned());
    pairs.iter().map(source).collect()
}

/// Sources that keep every rule: files, a subfolder, groups, a module by its short name, and tests.
const GOOD: [(&str, &str); 7] = [
    (
        "lib.rs",
        "//! | folder | what it holds |\n//! | --- | --- |\n//! | [`math`] | a |\n//! | [`engine`] | b |\n\
         pub mod math;\npub mod engine;\n",
    ),
    (
        "math/mod.rs",
        "//! | word | meaning |\n//! | --- | --- |\n//! | `cut` | c |\n//!\n\
         //! | file | what it holds |\n//! | --- | --- |\n//! | `real` | A `f64`, or another |\npub mod real;\n",
    ),
    ("math/real.rs", "pub struct Real;\n"),
    (
        "engine/mod.rs",
        "//! | file or folder | what it holds |\n//! | --- | --- |\n//! | [`mod@plan`], `trace` | d |\n\
         pub mod plan;\npub mod trace;\n",
    ),
    (
        "engine/plan.rs",
        "use crate::engine::trace::{self, walk::Walk};\nuse crate::math::real::Real;\nfn go() { trace::go() }\n\
         #[cfg(test)]\nmod tests {\n    use super::go;\n    use crate::file::scene::scene_file::Scene;\n}\n",
    ),
    (
        "engine/trace/mod.rs",
        "//! | file | what it holds |\n//! | --- | --- |\n//! | `walk` | e |\npub mod walk;\npub fn go() {}\n",
    ),
    (
        "engine/trace/walk.rs",
        "/// As [`crate::engine::plan`] says.\nuse crate::math::real::Real;\npub(in crate::engine) struct Walk;\n",
    ),
];

/// What a rule says once these files take the place of the good ones of the same name, or stand beside them.
pub(crate) fn planted(rule: fn(&[Source]) -> Vec<String>, bad: &[(&str, &str)]) -> Vec<String> {
    let mut all = sources(&GOOD);
    assert_eq!(rule(&all), Vec::<String>::new());
    all.retain(|(path, _)| !bad.iter().any(|(name, _)| name == path));
    all.extend(sources(bad));
    rule(&all)
}

#[test]
fn a_look_up_is_found() {
    let bad = [("math/real.rs", "use crate::engine::plan::Plan;\n")];
    let expected = ["math/real.rs looks up into engine::plan::Plan"];
    assert_eq!(planted(looks_up, &bad), expected);
    let deep = [(
        "engine/trace/walk.rs",
        "use crate::file::scene::scene_file::Scene;\n",
    )];
    let expected = ["engine/trace/walk.rs looks up into file::scene::scene_file::Scene"];
    assert_eq!(planted(looks_up, &deep), expected);
    let grouped = "use crate::{\n    math::real::Real,\n    design::{loss, run::Run},\n};\n";
    let expected = [
        "engine/plan.rs looks up into design::loss",
        "engine/plan.rs looks up into design::run::Run",
    ];
    assert_eq!(planted(looks_up, &[("engine/plan.rs", grouped)]), expected);
    let expected = ["loose.rs is in no layer"];
    assert_eq!(planted(looks_up, &[("loose.rs", "")]), expected);
}

#[test]
fn a_way_through_the_root_is_found() {
    let bad = [("engine/trace/walk.rs", "use crate::Scene;\n")];
    let expected = ["engine/trace/walk.rs goes through the crate root: Scene"];
    assert_eq!(planted(through_the_root, &bad), expected);
    let grouped = [("engine/plan.rs", "use crate::{math::real::Real, Scene};\n")];
    let expected = ["engine/plan.rs goes through the crate root: Scene"];
    assert_eq!(planted(through_the_root, &grouped), expected);
    let star = [("engine/plan.rs", "use crate::*;\n")];
    let expected = ["engine/plan.rs goes through the crate root: "];
    assert_eq!(planted(through_the_root, &star), expected);
    let fixture = [("engine/trace/walk.rs", "use crate::fixtures::parts;\n")];
    assert_eq!(planted(through_the_root, &fixture), Vec::<String>::new());
}

#[test]
fn a_super_is_found() {
    let bad = [
        ("math/real.rs", "use super::lanes::Lanes;\n"),
        ("engine/trace/walk.rs", "fn go() { super::go() }\n"),
    ];
    let expected = ["math/real.rs uses super", "engine/trace/walk.rs uses super"];
    assert_eq!(planted(uses_super, &bad), expected);
}

#[test]
fn a_ring_of_two_is_found() {
    let bad = [
        ("math/real.rs", "use crate::math::{lanes::Lanes};\n"),
        ("math/lanes.rs", "fn f() -> crate::math::real::Real {}\n"),
    ];
    let expected = ["import ring: math/real.rs -> math/lanes.rs -> math/real.rs"];
    assert_eq!(planted(ring, &bad), expected);
}

#[test]
fn a_ring_through_a_subfolder_is_found() {
    let bad = [(
        "engine/trace/walk.rs",
        "use crate::{math::real::Real, engine::{plan::Plan as P}};\n",
    )];
    let expected = ["import ring: engine/plan.rs -> engine/trace/walk.rs -> engine/plan.rs"];
    assert_eq!(planted(ring, &bad), expected);
}

#[test]
fn a_ring_through_the_file_of_a_folder_is_found() {
    // `go` is declared in the folder's own file, which uses the walk again.
    let bad = [
        (
            "engine/trace/mod.rs",
            "pub use walk::Walk;\npub fn go() {}\n",
        ),
        ("engine/trace/walk.rs", "use crate::engine::trace::go;\n"),
    ];
    let expected =
        ["import ring: engine/trace/mod.rs -> engine/trace/walk.rs -> engine/trace/mod.rs"];
    assert_eq!(planted(ring, &bad), expected);
}

#[test]
fn a_ring_through_an_imported_module_is_found() {
    let bad = [
        (
            "engine/plan.rs",
            "use crate::engine::trace as way;\nfn f(w: way::walk::Walk) {}\n",
        ),
        ("engine/trace/walk.rs", "use crate::engine::plan;\n"),
    ];
    let expected = ["import ring: engine/plan.rs -> engine/trace/walk.rs -> engine/plan.rs"];
    assert_eq!(planted(ring, &bad), expected);
}

#[test]
fn a_long_file_is_found() {
    let lines = |count: usize| "x\n".repeat(count);
    assert_eq!(
        planted(long_files, &[("math/real.rs", &lines(600))]),
        Vec::<String>::new()
    );
    assert_eq!(
        planted(long_files, &[("math/real.rs", &lines(601))]),
        ["math/real.rs has 601 lines"]
    );
}

#[test]
fn a_full_folder_is_found() {
    let names: Vec<String> = (0..26).map(|n| format!("wave/grid/part{n}.rs")).collect();
    let files: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "")).collect();
    assert_eq!(planted(full_folders, &files[..25]), Vec::<String>::new());
    // Files of subfolders count in these.
    let mut beside = files[..25].to_vec();
    beside.push(("wave/grid/deeper/part.rs", ""));
    assert_eq!(planted(full_folders, &beside), Vec::<String>::new());
    assert_eq!(
        planted(full_folders, &files),
        ["wave/grid has 26 source files"]
    );
}

#[test]
fn a_wrong_table_is_found() {
    let none = [("engine/trace/mod.rs", "//! Rays.\npub mod walk;\n")];
    let expected = ["engine/trace/mod.rs has no row for walk"];
    assert_eq!(planted(tables, &none), expected);
    let beside = [
        ("engine/run.rs", ""),
        ("engine/chain/mod.rs", ""),
        // Without a head of its own it is no module.
        ("engine/data/list.rs", ""),
    ];
    let expected = [
        "engine/mod.rs has no row for chain",
        "engine/mod.rs has no row for run",
    ];
    assert_eq!(planted(tables, &beside), expected);
    let gone = [(
        "math/mod.rs",
        "//! | file | what it holds |\n//! | --- | --- |\n//! | `real` | a |\n//! | `lanes` | b |\n",
    )];
    let expected = ["math/mod.rs has a row for lanes, which is not there"];
    assert_eq!(planted(tables, &gone), expected);
    // A program beside a library needs no table.
    assert_eq!(planted(tables, &[("main.rs", "")]), Vec::<String>::new());
}

#[test]
fn a_print_is_found() {
    let bad = [
        (
            "crates/raylet/src/math/real.rs",
            "fn f() {}\n#[cfg(test)]\nmod tests {\n    println!(\"a\");\n}\n",
        ),
        (
            "crates/raylet/tests/rays.rs",
            "eprintln!(\"b\");\n// dbg!(c);\n",
        ),
        ("crates/raylet/examples/tour.rs", "println!(\"d\");\n"),
    ];
    let expected = [
        "crates/raylet/src/math/real.rs calls println!",
        "crates/raylet/tests/rays.rs calls eprintln!",
    ];
    assert_eq!(planted(prints, &bad), expected);
}

#[test]
fn a_forgotten_file_is_found() {
    let bad = [
        (
            "crates/a/src/lib.rs",
            "//! mod d;\npub mod b;\npub(crate) mod e;\n",
        ),
        ("crates/a/src/b.rs", ""),
        ("crates/a/src/d.rs", ""),
        ("crates/a/src/e/mod.rs", "    mod f;\n"),
        ("crates/a/src/e/f.rs", ""),
        ("crates/a/src/g/mod.rs", ""),
        ("crates/a/tests/integration.rs", "mod rays;\n"),
        ("crates/a/tests/rays.rs", ""),
        ("crates/a/tests/waves.rs", ""),
        ("crates/a/examples/tour.rs", ""),
    ];
    let expected = [
        "crates/a/src/d.rs is in no module",
        "crates/a/src/g/mod.rs is in no module",
        "crates/a/tests/waves.rs is in no module",
    ];
    assert_eq!(planted(orphans, &bad), expected);
}
