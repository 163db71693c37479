//! `raylet paper`: numbers, pictures, and a folder that says whose it is.

use std::fs;
use std::process::Command;

#[test]
fn figure_three_in_seconds() {
    let room = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(room.path())
            .args(arguments)
            .output()
            .unwrap()
    };
    let output = run(&["paper", "fig3", "--quick", "--out", "fig3"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{errors}");
    assert!(
        text.contains("Metalens") && text.contains("Siemens"),
        "{text}"
    );
    let document = fs::read_to_string(room.path().join("fig3/paper.json")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    for (place, name) in ["metalens", "star"].iter().enumerate() {
        assert_eq!(document[place]["name"], *name);
        let picture = fs::read(room.path().join(format!("fig3/{name}.png"))).unwrap();
        assert!(picture.starts_with(b"\x89PNG"));

        // The last of three numbers of draws: uniform is worst, systematic best.
        let error = |way: usize| {
            document[place]["ways"][way]["errors"][2][1]
                .as_f64()
                .unwrap()
        };
        assert!(error(2) < error(1) && error(1) < error(0), "{text}");
    }

    // No study is called so.
    let refused = run(&["paper", "fig9"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8(refused.stderr).unwrap().contains("fig3"));
}
