//! The folders around a path, which may not be there yet.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// The innermost folder around a path that is there already.
pub(crate) fn standing(path: &Path) -> PathBuf {
    let there = |folder: &&Path| fs::symlink_metadata(named(folder)).is_ok();
    let found = path.ancestors().skip(1).find(there);
    found.map_or(PathBuf::from("."), |folder| named(folder).to_path_buf())
}

/// A path as the folder that stands around it sees it.
pub(crate) fn below<'p>(around: &Path, path: &'p Path) -> &'p Path {
    path.strip_prefix(around).unwrap_or(path)
}

/// The current folder has no name among the ancestors of a relative path.
pub(crate) fn named(folder: &Path) -> &Path {
    match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    }
}

/// Makes the missing folders around a path, and notes which.
///
/// # Errors
/// An error of the file system.
pub(crate) fn make(path: &Path, made: &mut Vec<PathBuf>) -> io::Result<()> {
    let missing: Vec<&Path> = path
        .ancestors()
        .skip(1)
        .take_while(|folder| fs::symlink_metadata(named(folder)).is_err())
        .collect();
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => made.push(folder.to_path_buf()),
            // Another program may be as fast.
            Err(_) if folder.is_dir() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Removes folders that were made for nothing, the innermost first; one that others use by now stays.
pub(crate) fn unmake(made: &[PathBuf]) {
    for folder in made.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}

/// Waits until the names in a folder are on the disk, where the system can say so.
///
/// # Errors
/// An error of the file system.
pub(crate) fn sync(folder: &Path) -> io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    match File::open(named(folder)).and_then(|folder| folder.sync_all()) {
        // Some file systems have no such request for folders, and a folder may be writable but not readable.
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::InvalidInput | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// Lets two paths change places at one stroke; `false` where the system or its file system cannot.
///
/// # Errors
/// An error of the file system.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
pub(crate) fn exchange(one: &Path, other: &Path) -> io::Result<bool> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(true),
        Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Elsewhere there is no such call.
#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
pub(crate) fn exchange(_: &Path, _: &Path) -> io::Result<bool> {
    Ok(false)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::storage::parent_folders::{exchange, sync};

    /// Where the file system cannot, it says so, and each stays in its place.
    #[test]
    fn folders_change_places() {
        let room = tempfile::tempdir().unwrap();
        let [one, other] = ["one", "other"].map(|name| room.path().join(name));
        fs::create_dir(&one).unwrap();
        fs::create_dir(&other).unwrap();
        fs::write(one.join("file"), "").unwrap();
        assert!(exchange(&one, &room.path().join("none")).is_err());
        let [full, empty] = match exchange(&one, &other).unwrap() {
            true => [&other, &one],
            false => [&one, &other],
        };
        assert!(full.join("file").exists() && !empty.join("file").exists());
        sync(room.path()).unwrap();
    }
}
