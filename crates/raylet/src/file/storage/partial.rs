//! A random run that is not finished: its parts so far in a file, from which it goes on later.

use std::fs;
use std::io::{self, BufReader, Cursor};
use std::path::{Path, PathBuf};

use ndarray::{Array1, Ix1, Ix2, OwnedRepr, array};
use ndarray_npy::{NpzReader, NpzWriter, WriteNpzError};
use num_complex::Complex64;

use crate::engine::monte_carlo::repeated_runs::RepeatedRuns;
use crate::file::decode::fault::Fault;
use crate::file::storage::hidden::{Hidden, unwritable};

/// Numbers are whole up to here.
const WHOLE: f64 = 9e15;

/// The file of a run, which belongs to the run of one description only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartialFile {
    path: PathBuf,
    description: String,
}

/// A file that was opened, and what its run is called.
type Opened = (NpzReader<BufReader<fs::File>>, Vec<u8>);

impl PartialFile {
    /// The file at this path for the run that is so described: everything that its numbers depend on.
    pub fn new(path: &Path, description: &str) -> Self {
        Self {
            path: path.to_path_buf(),
            description: description.to_owned(),
        }
    }

    /// What an earlier run of this description left for a sensor of [ny, nx] samples; nothing where there is no such
    /// file, or one that another run left.
    ///
    /// # Errors
    /// A file that is no run's, or whose numbers are none of this run's.
    pub fn read(&self, shape: [usize; 2]) -> Result<Option<RepeatedRuns>, Fault> {
        if fs::symlink_metadata(&self.path).is_err() {
            return Ok(None);
        }
        let refuse = |found: &str| Fault::of_file(&self.path, found, "parts of a run, or no file");
        let (mut archive, description) =
            open(&self.path).ok_or_else(|| refuse("a file that raylet did not write"))?;
        if description != self.description.as_bytes() {
            return Ok(None);
        }
        let repeats = unpack(&mut archive).filter(|found| is_sound(found, shape));
        repeats
            .map(Some)
            .ok_or_else(|| refuse("numbers that no run leaves"))
    }

    /// Writes what there is; the file changes as a whole or not at all.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn write(&self, run: &RepeatedRuns) -> Result<(), Fault> {
        let refuse = |error: io::Error| unwritable(&self.path, &error);
        let bytes = self.pack(run);
        let bytes = bytes.map_err(|error| refuse(io::Error::other(error)))?;
        let fresh = Hidden::beside(&self.path)?;
        fresh.write(None, &bytes).map_err(refuse)?;
        fresh.reveal(&self.path, &|_| Ok(()))
    }

    /// Removes a file, if it holds the parts of a run.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn remove(path: &Path) -> Result<(), Fault> {
        match open(path) {
            Some(_) => fs::remove_file(path).map_err(|error| unwritable(path, &error)),
            None => Ok(()),
        }
    }

    fn pack(&self, run: &RepeatedRuns) -> Result<Vec<u8>, WriteNpzError> {
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

/// Opens a file that holds the parts of a run.
fn open(path: &Path) -> Option<Opened> {
    let is_file = fs::symlink_metadata(path).ok()?.is_file();
    let file = is_file.then(|| fs::File::open(path).ok())??;
    let mut archive = NpzReader::new(BufReader::new(file)).ok()?;
    let description = archive.by_name::<OwnedRepr<u8>, Ix1>("description").ok()?;
    Some((archive, description.to_vec()))
}

/// The run in a file.
fn unpack(archive: &mut NpzReader<BufReader<fs::File>>) -> Option<RepeatedRuns> {
    let sum = archive.by_name::<OwnedRepr<Complex64>, Ix2>("sum").ok()?;
    let numbers = archive.by_name::<OwnedRepr<f64>, Ix1>("numbers").ok()?;
    let [squares, parts, draws, rays, seconds] = numbers.to_vec()[..] else {
        return None;
    };
    let counts = [parts, rays];
    let is_count = |count: &f64| (0.0..WHOLE).contains(count) && count.fract() == 0.0;
    counts.iter().all(is_count).then_some(RepeatedRuns {
        sum,
        squares,
        parts: parts as usize,
        draws,
        rays: rays as u64,
        seconds,
    })
}

/// Whether a run on a sensor of [ny, nx] samples can have left this.
fn is_sound(run: &RepeatedRuns, [ny, nx]: [usize; 2]) -> bool {
    let finite = |value: &f64| value.is_finite() && *value >= 0.0;
    run.sum.dim() == (ny, nx)
        && run.sum.iter().all(|u| u.is_finite())
        && [run.squares, run.draws, run.seconds].iter().all(finite)
        && run.parts > 0
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::monte_carlo::repeated_runs::RepeatedRuns;
    use crate::file::storage::partial::PartialFile;

    #[test]
    fn a_run_goes_on_where_it_was_and_no_other_does() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("new/run.npz");
        let file = PartialFile::new(&path, "these settings");
        assert_eq!(file.read([3, 4]), Ok(None));
        let run = RepeatedRuns {
            sum: Array2::from_shape_fn((3, 4), |(j, i)| Complex64::new(j as f64, i as f64)),
            squares: 0.1,
            parts: 7,
            draws: 4e9,
            rays: 123,
            seconds: 5.5,
        };
        file.write(&run).unwrap();
        assert_eq!(file.read([3, 4]), Ok(Some(run.clone())));
        let other = PartialFile::new(&path, "other settings");
        assert_eq!(other.read([3, 4]), Ok(None));

        // Numbers that no run leaves are refused.
        assert!(file.read([4, 3]).is_err());
        for squares in [f64::NAN, -1.0, f64::INFINITY] {
            let forged = RepeatedRuns {
                squares,
                ..run.clone()
            };
            file.write(&forged).unwrap();
            assert!(file.read([3, 4]).is_err());
        }
        let mut forged = run.clone();
        forged.sum[[1, 1]].im = f64::NAN;
        file.write(&forged).unwrap();
        assert!(file.read([3, 4]).is_err());

        // What is no run's stays.
        PartialFile::remove(&path).unwrap();
        std::fs::write(&path, b"no archive").unwrap();
        assert!(file.read([3, 4]).is_err());
        PartialFile::remove(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"no archive");
    }
}
