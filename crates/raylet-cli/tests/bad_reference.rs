//! Bad input to `raylet reference`, `check` and `schema`: one message with an address, exit code 2, nothing
//! written.

use std::fs;

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage};

/// The small scene without its lens.
fn free() -> String {
    let lens = SCENE.find("[[element]]\nkind = \"lens\"").unwrap();
    let camera = SCENE.find("[[element]]\nkind = \"sensor\"").unwrap();
    format!("{}{}", &SCENE[..lens], &SCENE[camera..])
}

#[test]
fn methods_that_do_not_apply_are_refused() {
    let tilted = SCENE.replace("name = \"L\"", "name = \"L\"\ntilt_deg = [3, 0, 0]");
    let cases: [(&str, &str, &[&str]); 6] = [
        (
            SCENE,
            "angular-spectrum",
            &["element[0]", "angular spectrum", "plates"],
        ),
        (
            SCENE,
            "rayleigh-sommerfeld",
            &["element[0]", "2 surface(s)"],
        ),
        (SCENE, "gsl", &["element[0]", "'pixels' has pixels"]),
        (&tilted, "collins", &["element[0]", "tilted"]),
        (&tilted, "auto", &["element[0]", "raylet simulate"]),
        (SCENE, "magic", &["--method", "magic", "collins"]),
    ];
    none_of(cases.map(|(scene, method, says)| {
        let stage = Stage::new(scene);
        wrong(
            &stage,
            &[
                "reference",
                "scene.toml",
                "--method",
                method,
                "--out",
                "new/out",
            ],
            says,
        )
    }));
}

#[test]
fn sums_that_take_too_long_are_refused() {
    let stage = Stage::new(&free());
    let cases: [(&str, &[&str]); 6] = [
        (
            "1e-9",
            &["scene.toml:", "pairs", "seconds", "larger --most-hours"],
        ),
        ("0", &["scene.toml:", "0.0 seconds allowed"]),
        (
            "nan",
            &["--most-hours", "nan", "expected a number of hours"],
        ),
        ("-1", &["--most-hours", "-1", "not negative"]),
        ("-inf", &["--most-hours"]),
        ("soon", &["--most-hours", "soon"]),
    ];
    none_of(cases.map(|(hours, says)| {
        let span = format!("--most-hours={hours}");
        let sum = [
            "reference",
            "scene.toml",
            "--method",
            "rayleigh-sommerfeld",
            &span,
        ];
        wrong(&stage, &sum, says)
    }));
}

#[test]
fn folders_that_cannot_be_written_are_refused_by_every_verb() {
    let stage = Stage::new(SCENE);
    fs::create_dir(stage.join("foreign")).unwrap();
    fs::write(stage.join("foreign/diary.txt"), "mine").unwrap();
    let verbs: [&[&str]; 3] = [
        &["simulate", "scene.toml"],
        &["reference", "scene.toml"],
        &["compare", "foreign", "foreign"],
    ];
    let places = [
        ("foreign", "diary.txt"),
        ("foreign/diary.txt", "not a folder"),
        ("foreign/diary.txt/x/y", "diary.txt"),
        (".", "without a name"),
        ("..", "without a name"),
        ("/", "without a name"),
        ("foreign/..", "without a name"),
        ("/proc/out", "/proc"),
        ("/proc/no/out", "/proc"),
    ];
    for verb in verbs {
        none_of(
            places.map(|(out, says)| wrong(&stage, &[verb, &["--out", out]].concat(), &[says])),
        );
    }
    assert_eq!(
        fs::read_to_string(stage.join("foreign/diary.txt")).unwrap(),
        "mine"
    );
}

#[test]
fn check_and_schema_refuse_what_they_cannot_use() {
    let stage = Stage::new(&SCENE.replace("N-BK7", "N-BK77"));
    fs::write(stage.join("empty.toml"), "").unwrap();
    fs::write(stage.join("junk.toml"), "[".repeat(100_000)).unwrap();
    fs::write(
        stage.join("deep.toml"),
        format!("a = {}", "[".repeat(100_000)),
    )
    .unwrap();
    let cases: [(&[&str], &[&str]); 7] = [
        (
            &["check", "scene.toml"],
            &["scene.toml:25:", "glass", "N-BK77"],
        ),
        (&["check", "empty.toml"], &["empty.toml:1:1", "version"]),
        (&["check", "junk.toml"], &["junk.toml:1:", "TOML"]),
        (&["check", "deep.toml"], &["deep.toml:1:", "TOML"]),
        (&["check", "."], &[".", "TOML"]),
        (&["check", "none.toml"], &["none.toml"]),
        (
            &["check", "scene.toml", "--threads", "0"],
            &["--threads", "0"],
        ),
    ];
    none_of(cases.map(|(arguments, says)| wrong(&stage, arguments, says)));

    // Long lines are not poured out.
    let output = stage.raylet(&["check", "junk.toml"]);
    assert!(output.stderr.len() < 2000);
    assert_eq!(
        stage.raylet(&["schema", "scene.toml"]).status.code(),
        Some(2)
    );
}
