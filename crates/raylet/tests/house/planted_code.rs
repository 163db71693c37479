//! Every rule on functions, words and adjoints finds what is planted to break it.

use crate::adjoints::lone_adjoints;
use crate::planted::planted;
use crate::sizes::long_functions;
use crate::words::{empty_names, left_undone};

/// A function with these words before `fn`, their indentation and as many lines.
fn function(before: &str, lines: usize) -> String {
    let indent = &before[..before.len() - before.trim_start().len()];
    let body = "        go();\n".repeat(lines - 2);
    format!("{before}fn f() {{\n{body}{indent}}}\n")
}

#[test]
fn a_long_function_is_found_after_any_qualifier() {
    for head in [
        "",
        "pub ",
        "pub(crate) ",
        "pub(in crate::engine) ",
        "const ",
        "pub(crate) const ",
        "async ",
        "pub const unsafe ",
        "pub(super) unsafe extern \"C\" ",
    ] {
        let kept = function(head, 60);
        assert_eq!(
            planted(long_functions, &[("math/real.rs", &kept)]),
            Vec::<String>::new()
        );
        let long = function(head, 61);
        assert_eq!(
            planted(long_functions, &[("math/real.rs", &long)]),
            ["math/real.rs: f has 61 lines"],
            "{head}"
        );
    }
}

/// Comments and tests do not count, and no function goes on beyond its own end.
#[test]
fn the_length_of_a_function_is_that_of_its_code() {
    let long = function("", 61);
    let commented = function("", 60).replacen("go();\n", "go();\n    // So.\n", 1);
    let tested = format!("#[cfg(test)]\nmod tests {{\n{long}}}\n");
    let listed = format!(
        "trait Real {{\n    fn a();\n    fn b(\n        x: f64,\n    ) -> f64;\n    fn c() {{}}\n{}{}}}\n",
        "    type A;\n".repeat(60),
        function("    ", 60)
    );
    for kept in [commented, tested, listed] {
        let found = planted(long_functions, &[("math/real.rs", &kept)]);
        assert_eq!(found, Vec::<String>::new(), "{kept}");
    }
    let inside = format!("impl Real {{\n{}}}\n", function("    pub ", 61));
    assert_eq!(
        planted(long_functions, &[("math/real.rs", &inside)]),
        ["math/real.rs: f has 61 lines"]
    );
}

#[test]
fn an_empty_name_is_found() {
    let bad = [
        ("math/utils.rs", ""),
        ("engine/common/mod.rs", ""),
        ("python/helpers.py", ""),
        ("math/commons.rs", ""),
    ];
    let expected = [
        "math/utils.rs is named utils",
        "engine/common/mod.rs is named common",
        "python/helpers.py is named helpers",
    ];
    assert_eq!(planted(empty_names, &bad), expected);
}

#[test]
fn a_mark_of_what_is_left_undone_is_found() {
    let bad = [
        ("math/real.rs", "// TODO: faster\n"),
        ("engine/plan.rs", "fn go() {} // FIXME\n"),
    ];
    let expected = ["math/real.rs holds TODO", "engine/plan.rs holds FIXME"];
    assert_eq!(planted(left_undone, &bad), expected);
}

#[test]
fn a_lone_adjoint_is_found() {
    let kept = "fn scale() {}\nfn scale_adjoint() {}\nfn dot_product() {}\n";
    assert_eq!(
        planted(lone_adjoints, &[("math/real.rs", kept)]),
        Vec::<String>::new()
    );
    let above = "fn scale_adjoint() {}\nfn scale() {}\nfn dot_product() {}\n";
    assert_eq!(
        planted(lone_adjoints, &[("math/real.rs", above)]),
        ["math/real.rs: scale_adjoint has no forward"]
    );
    let untested = "fn scale() {}\nfn scale_adjoint() {}\n";
    assert_eq!(
        planted(lone_adjoints, &[("math/real.rs", untested)]),
        ["math/real.rs: scale_adjoint has no dot-product test"]
    );
}
