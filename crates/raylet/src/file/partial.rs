//! A random run that is not finished: its parts so far in a file, from which it goes on later.

use std::fs;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use ndarray::{Array1, Ix1, Ix2, OwnedRepr, array};
use ndarray_npy::{NpzReader, NpzWriter, WriteNpzError};
use num_complex::Complex64;

use crate::engine::repeat::Repeats;
use crate::file::fault::Fault;
use crate::file::hidden::unwritable;

/// The file of a run, which belongs to the run of one description only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartialFile {
    path: PathBuf,
    description: String,
}

impl PartialFile {
    /// The file at this path for the run that is so described: everything that its numbers depend on.
    pub fn new(path: &Path, description: &str) -> Self {
        Self {
            path: path.to_path_buf(),
            description: description.to_owned(),
        }
    }

    /// What an earlier run of this description left; nothing where there is no such file, or one that another
    /// run left.
    pub fn read(&self) -> Option<Repeats> {
        let file = fs::File::open(&self.path).ok()?;
        let mut archive = NpzReader::new(BufReader::new(file)).ok()?;
        let description = archive.by_name::<OwnedRepr<u8>, Ix1>("description").ok()?;
        if description.to_vec() != self.description.as_bytes() {
            return None;
        }
        let sum = archive.by_name::<OwnedRepr<Complex64>, Ix2>("sum").ok()?;
        let numbers = archive.by_name::<OwnedRepr<f64>, Ix1>("numbers").ok()?;
        match numbers.to_vec()[..] {
            [squares, parts, draws, rays, seconds] => Some(Repeats {
                sum,
                squares,
                parts: parts as usize,
                draws,
                rays: rays as u64,
                seconds,
            }),
            _ => None,
        }
    }

    /// Writes what there is; the file changes as a whole or not at all.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, run: &Repeats) -> Result<(), Fault> {
        let bytes = self
            .pack(run)
            .map_err(|error| unwritable(&self.path, &std::io::Error::other(error)))?;
        let write = || {
            if let Some(folder) = self.path.parent() {
                fs::create_dir_all(folder)?;
            }
            let fresh = self.path.with_extension("fresh");
            fs::write(&fresh, &bytes)?;
            fs::rename(&fresh, &self.path)
        };
        write().map_err(|error| unwritable(&self.path, &error))
    }

    fn pack(&self, run: &Repeats) -> Result<Vec<u8>, WriteNpzError> {
        let mut writer = NpzWriter::new(Cursor::new(Vec::new()));
        let description = Array1::from(self.description.as_bytes().to_vec());
        writer.add_array("description", &description)?;
        writer.add_array("sum", &run.sum)?;
        let numbers = array![
            run.squares,
            run.parts as f64,
            run.draws,
            run.rays as f64,
            run.seconds
        ];
        writer.add_array("numbers", &numbers)?;
        Ok(writer.finish()?.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::repeat::Repeats;
    use crate::file::partial::PartialFile;

    #[test]
    fn a_run_goes_on_where_it_was_and_no_other_does() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("new/run.npz");
        let file = PartialFile::new(&path, "these settings");
        assert_eq!(file.read(), None);
        let run = Repeats {
            sum: Array2::from_shape_fn((3, 4), |(j, i)| Complex64::new(j as f64, i as f64)),
            squares: 0.1,
            parts: 7,
            draws: 4e9,
            rays: 123,
            seconds: 5.5,
        };
        file.write(&run).unwrap();
        assert_eq!(file.read(), Some(run));
        assert_eq!(PartialFile::new(&path, "other settings").read(), None);
        std::fs::write(&path, b"no archive").unwrap();
        assert_eq!(file.read(), None);
    }
}
