//! A program that is interrupted removes unfinished files. Alone in its process, because all threads stop.

use std::fs;

use raylet::file::storage::hidden::Hidden;
use raylet::file::storage::unfinished::abandon;

#[test]
fn everything_unfinished_goes_and_the_rest_stays() {
    let room = tempfile::tempdir().unwrap();
    let count = || fs::read_dir(room.path()).unwrap().count();
    let finished = room.path().join("new/finished");
    let hidden = Hidden::beside(&finished).unwrap();
    hidden.write(None, b"whole").unwrap();
    hidden.reveal(&finished, &|_| Ok(())).unwrap();

    // A file that is written and a folder that is being filled.
    let file = Hidden::beside(&room.path().join("other/file")).unwrap();
    file.write(None, b"whole").unwrap();
    let folder = Hidden::beside(&room.path().join("folder")).unwrap();
    folder.make_folder().unwrap();
    folder.write(Some("part"), b"half").unwrap();
    assert_eq!(count(), 3);
    drop(abandon());
    assert_eq!(count(), 1);
    assert_eq!(fs::read(&finished).unwrap(), b"whole");

    // Nothing can be finished any more.
    let place = room.path().join("folder");
    assert!(folder.reveal(&place, &|_| Ok(())).is_err() && !place.exists());
}
