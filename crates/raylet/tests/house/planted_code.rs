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

/// What the rule says of a file with this code and a test of it.
fn lone(code: &str, test: &str) -> Vec<String> {
    let text = format!("{code}#[cfg(test)]\nmod tests {{\n    fn {test}\n}}\n");
    planted(lone_adjoints, &[("math/real.rs", &text)])
}

const SCALE: &str = "fn scale() {}\nfn scale_adjoint() {}\n";

#[test]
fn an_adjoint_without_a_forward_above_it_is_found() {
    let test = "scale_dot_product() { scale_adjoint() }";
    for kept in [SCALE, "fn scale_at() {}\nfn scale_adjoint() {}\n"] {
        assert_eq!(lone(kept, test), Vec::<String>::new(), "{kept}");
    }
    for bad in [
        "fn scale_adjoint() {}\nfn scale() {}\n",
        "fn scaled() {}\nfn scale_adjoint() {}\n",
        "// fn scale\nfn scale_adjoint() {}\n",
    ] {
        let expected = ["math/real.rs: scale_adjoint has no forward above it"];
        assert_eq!(lone(bad, test), expected, "{bad}");
    }
}

#[test]
fn an_adjoint_that_no_dot_product_test_calls_is_found() {
    let by_way = format!("{SCALE}fn run_back() {{ scale_adjoint() }}\n");
    for (code, test) in [
        (SCALE, "scale_inner_product() { scale_adjoint() }"),
        (by_way.as_str(), "run_dot_product() { run_back() }"),
    ] {
        assert_eq!(lone(code, test), Vec::<String>::new(), "{test}");
    }
    let named = format!("// `scale_dot_product` holds it.\n{SCALE}");
    let expected = ["math/real.rs: scale_adjoint has no dot-product test"];
    for (code, test) in [
        (SCALE, "scale_works() { scale_adjoint() }"),
        (SCALE, "scale_dot_product() { scale() }"),
        (by_way.as_str(), "scale_dot_product() { scale() }"),
        (named.as_str(), "scale_dot_product() { scale() }"),
        (named.as_str(), "scale_works() {}"),
    ] {
        assert_eq!(lone(code, test), expected, "{code} {test}");
    }

    // A test of another file counts where a comment names it.
    let elsewhere = ("tests/real.rs", "fn scale_dot_product() {}\n");
    let file = ("math/real.rs", named.as_str());
    let found = planted(lone_adjoints, &[file, elsewhere]);
    assert_eq!(found, Vec::<String>::new());
    let silent = planted(lone_adjoints, &[("math/real.rs", SCALE), elsewhere]);
    assert_eq!(silent, expected);
}
