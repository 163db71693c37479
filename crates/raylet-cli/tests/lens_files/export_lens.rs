//! `raylet export` of lens files.

use std::fs;

use crate::lens_files::{run, scenes, text};

#[test]
fn scenes_and_lens_files_become_lens_files() {
    let room = tempfile::tempdir().unwrap();
    let triplet = scenes().join("real_size/cooke_triplet.toml");
    let achromat = scenes().join("prescriptions/CODV_65564.seq");
    for (source, target) in [
        (&triplet, "a.zmx"),
        (&triplet, "a.seq"),
        (&achromat, "b.zmx"),
    ] {
        let source = source.to_str().unwrap();
        let done = run(room.path(), &["export", source, "-o", target]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let report = text(&done.stdout);
        for words in ["entrance pupil diameter", "Left out:", "Written to"] {
            assert!(report.contains(words), "{report}");
        }
        let done = run(room.path(), &["import", target]);
        assert!(done.status.success(), "{}", text(&done.stderr));
    }
}

#[test]
fn a_file_that_cannot_be_written_is_one_clear_error() {
    let room = tempfile::tempdir().unwrap();
    let hologram = scenes().join("hologram_through_lens.toml");
    let source = hologram.to_str().unwrap();
    let given: [(&[&str], &str); 4] = [
        (&["export", source, "-o", "a.zmx"], "pixels"),
        (
            &["export", source, "-o", "a.zmx", "--levels", "4"],
            "option of elements",
        ),
        (
            &["export", source, "-o", "a.gds", "--skip-unknown"],
            "lens files",
        ),
        (&["export", "nowhere.toml", "-o", "a.zmx"], "nowhere.toml"),
    ];
    for (arguments, words) in given {
        let done = run(room.path(), arguments);
        let error = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{error}");
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(fs::read_dir(room.path()).unwrap().count(), 0);
}
