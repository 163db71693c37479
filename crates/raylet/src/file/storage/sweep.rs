//! What killed runs left behind: hidden drafts and locks that nobody holds any more.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::file::arrays::regular_file;
use crate::file::storage::hidden::PREFIX;
use crate::file::storage::lock::Lock;
use crate::file::storage::parent_folders::{named, standing};
use crate::file::storage::unfinished::{OLD, OWNER, PLACE, clear, unfinished};

/// Letters and digits behind the prefix of a draft's name.
const LETTERS: usize = 6;

/// The end of a lock's name.
pub(crate) const LOCK: &str = ".lock";

/// Longest note of a place that is read, in bytes.
const LONGEST_PLACE: u64 = 1 << 16;

/// So many folders around a path are looked through: a run that makes folders has its draft outside of them.
const LEVELS: usize = 3;

/// Removes the drafts and locks that killed runs left around a path; a result that stood aside when such a run ended is
/// put back. Those that a live process holds stay, and so does whatever cannot be removed.
pub(crate) fn sweep_around(path: &Path) {
    let there = standing(path);
    let around = there.ancestors().take(LEVELS);
    for folder in around {
        sweep(named(folder));
    }
}

/// Removes the drafts and locks that killed runs left directly inside a folder.
pub(crate) fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(rest) = name.strip_prefix(PREFIX) else {
            continue;
        };
        let (path, kind) = (entry.path(), entry.file_type());
        let is_draft = rest.len() == LETTERS && rest.chars().all(|c| c.is_ascii_alphanumeric());
        if is_draft && kind.is_ok_and(|kind| kind.is_dir()) {
            sweep_draft(folder, &path);
        } else if rest.ends_with(LOCK) {
            // Dropped at once, a lock that nobody held is gone.
            let _ = Lock::take_stale(&path);
        }
    }
}

fn sweep_draft(around: &Path, draft: &Path) {
    let owner = draft.join(OWNER);
    if let Ok(note) = fs::symlink_metadata(&owner) {
        // A run that was killed before it wrote its name has written nothing else.
        let is_named = note.len() > 0;
        let count = fs::read_dir(draft).map_or(0, Iterator::count);
        if !is_named && count != 1 {
            return;
        }
        let Ok(Some(lock)) = Lock::take_stale(&owner) else {
            return;
        };
        let list = unfinished();
        put_back(around, draft);
        clear(draft);
        drop(list);
        drop(lock);
    }
    // Without an owner it is empty, or not raylet's.
    let _ = fs::remove_dir(draft);
}

/// Puts back a folder that was to be replaced by a new one which was never completed.
fn put_back(around: &Path, draft: &Path) {
    let Some(place) = place(draft) else {
        return;
    };
    let target = around.join(place);
    let is_free =
        fs::symlink_metadata(&target).is_err_and(|error| error.kind() == io::ErrorKind::NotFound);
    if is_free {
        let _ = fs::rename(draft.join(OLD), target);
    }
}

/// The original place of that folder, relative to the folder around the draft.
fn place(draft: &Path) -> Option<PathBuf> {
    let place = regular_file::read_text(&draft.join(PLACE), LONGEST_PLACE);
    let place = PathBuf::from(place.ok()?);
    let inside = |part: Component| matches!(part, Component::Normal(_));
    place.components().all(inside).then_some(place)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::process::Command;
    use std::sync::mpsc::channel;
    use std::thread::spawn;
    use std::time::Duration;

    use crate::file::storage::hidden::Hidden;
    use crate::file::storage::lock::Lock;
    use crate::file::storage::seal::sealed;
    use crate::file::storage::sweep::sweep_around;

    #[test]
    fn what_is_left_goes_and_what_is_held_stays() {
        let room = tempfile::tempdir().unwrap();
        let join = |name: &str| room.path().join(name);
        let left = "raylet process 1 on moon since 12\n";
        fs::create_dir_all(join(".raylet-aB3d5f/new")).unwrap();
        fs::write(join(".raylet-aB3d5f/owner"), left).unwrap();
        fs::write(join(".raylet-aB3d5f/new/field.npz"), "half").unwrap();
        fs::create_dir(join(".raylet-empty0")).unwrap();
        fs::create_dir(join(".raylet-empty1")).unwrap();
        fs::write(join(".raylet-empty1/owner"), "").unwrap();
        fs::write(join(".raylet-out.lock"), left).unwrap();

        // Nobody's, or another's.
        let strange = [
            ".raylet-notes1/new/a.txt",
            ".raylet-notes/owner",
            ".raylet-notes2/owner",
            ".raylet-x/new/b",
            ".raylet-notes3/new/c",
        ];
        for path in strange {
            fs::create_dir_all(join(path).parent().unwrap()).unwrap();
            fs::write(join(path), "raylet is mine").unwrap();
        }
        fs::write(join(".raylet-notes3/owner"), "").unwrap();
        fs::write(join(".raylet-diary.lock"), "raylet is mine").unwrap();
        let held = Hidden::beside(&join("out")).unwrap();
        let lock = Lock::take(&join(".raylet-held.lock")).unwrap();
        sweep_around(&join("a/b/out"));
        let gone = [
            ".raylet-aB3d5f",
            ".raylet-empty0",
            ".raylet-empty1",
            ".raylet-out.lock",
        ];
        for path in gone {
            assert!(!join(path).exists(), "{path}");
        }
        for path in strange.iter().chain(&[".raylet-diary.lock"]) {
            assert_eq!(fs::read_to_string(join(path)).unwrap(), "raylet is mine");
        }
        assert!(join(".raylet-held.lock").exists());
        held.write(None, b"still there").unwrap();
        held.reveal(&join("out"), &|_| Ok(())).unwrap();
        drop(lock);
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 7);
    }

    /// A result that stood aside when its run was killed comes back, unless the new one has come.
    #[test]
    fn what_stood_aside_comes_back() {
        for has_come in [false, true] {
            let room = tempfile::tempdir().unwrap();
            let (out, draft) = (room.path().join("out"), room.path().join(".raylet-aB3d5f"));
            fs::create_dir_all(draft.join("old")).unwrap();
            let document = sealed("{}", &[]).unwrap();
            fs::write(draft.join("old/result.json"), &document).unwrap();
            fs::write(draft.join("place"), "out").unwrap();
            fs::write(draft.join("owner"), "raylet process 1 on moon since 12\n").unwrap();
            if has_come {
                fs::create_dir(&out).unwrap();
            }
            sweep_around(&out);
            assert_eq!(out.join("result.json").exists(), !has_come);
            assert_eq!(fs::read_dir(room.path()).unwrap().count(), 1);
        }
    }

    /// To read a pipe would wait until somebody writes into it.
    #[cfg(unix)]
    #[test]
    fn a_pipe_in_the_place_of_a_note_is_not_read() {
        let room = tempfile::tempdir().unwrap();
        let draft = room.path().join(".raylet-aB3d5f");
        fs::create_dir_all(draft.join("new")).unwrap();
        fs::write(draft.join("owner"), "raylet process 1 on moon since 12\n").unwrap();
        let made = Command::new("mkfifo").arg(draft.join("place")).status();
        assert!(made.unwrap().success());

        let (out, (done, ended)) = (room.path().join("out"), channel());
        spawn(move || {
            sweep_around(&out);
            done.send(()).unwrap();
        });
        ended.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(!draft.exists());
    }

    /// A file of the user's in what stood aside is never removed, and notes lead nowhere else.
    #[test]
    fn what_is_not_raylets_stays_in_hiding() {
        let room = tempfile::tempdir().unwrap();
        let (out, draft) = (
            room.path().join("in/out"),
            room.path().join("in/.raylet-aB3d5f"),
        );
        fs::create_dir_all(draft.join("old")).unwrap();
        fs::write(draft.join("old/late.txt"), "mine").unwrap();
        fs::write(draft.join("place"), "../out").unwrap();
        fs::write(draft.join("owner"), "raylet process 1 on moon since 12\n").unwrap();
        sweep_around(&out);
        assert_eq!(
            fs::read_to_string(draft.join("old/late.txt")).unwrap(),
            "mine"
        );
        assert!(!room.path().join("out").exists());
    }
}
