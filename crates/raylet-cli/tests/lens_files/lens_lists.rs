//! `raylet lenses`.

use crate::lens_files::{run, scenes, text};

#[test]
fn lists_have_the_lenses_that_fit() {
    let room = tempfile::tempdir().unwrap();
    let folder = scenes().join("prescriptions");
    let folder = folder.to_str().unwrap();
    let done = run(
        room.path(),
        &[
            "lenses",
            folder,
            "--focal-mm",
            "99,101",
            "--text",
            "achromatic",
        ],
    );
    assert!(done.status.success(), "{}", text(&done.stderr));
    let rows = text(&done.stdout);
    assert_eq!(rows.lines().count(), 2, "{rows}");
    assert!(
        rows.contains("CODV_32327.seq") && rows.contains("100.0"),
        "{rows}"
    );
    assert!(text(&done.stderr).contains("not read: "));
    let done = run(room.path(), &["lenses", "--maker", "thorlabs"]);
    assert_eq!(text(&done.stdout).lines().count(), 3);
    let done = run(room.path(), &["lenses", "--focal-mm", "5,1"]);
    assert_eq!(done.status.code(), Some(2));
}
