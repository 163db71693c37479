//! A map of any of the formats, with its missing samples filled where that is requested.

use std::path::Path;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::maps::fits_map::read_fits;
use crate::file::maps::hdf5_map::read_hdf5;
use crate::file::maps::measured_map::MeasuredMap;
use crate::file::maps::missing_samples::fill;
use crate::file::maps::tiff_map::read_tiff;
use crate::file::maps::zygo_map::read_zygo;

pub use crate::file::maps::missing_samples::Fill;

/// What a user chooses of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapChoices<'a> {
    /// Name of the array in a .npz or HDF5 file, or of the extension of a FITS file.
    pub key: Option<&'a str>,
    /// What stands in the place of missing samples; they stay NaN without it.
    pub fill: Option<Fill>,
    /// The most memory that the map may take.
    pub limit: MemoryLimit,
}

/// Formats of maps besides NumPy's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MapFormat {
    Zygo,
    Tiff,
    Fits,
    Hdf5,
}

impl MapFormat {
    /// The format of a file of this name.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match end.as_str() {
            "dat" => MapFormat::Zygo,
            "tif" | "tiff" => MapFormat::Tiff,
            "fits" | "fit" | "fts" => MapFormat::Fits,
            "h5" | "hdf5" => MapFormat::Hdf5,
            _ => return None,
        })
    }

    /// Reads a file of this format; `usual` names the array of an HDF5 file where no key does.
    pub(crate) fn read(
        self,
        path: &Path,
        key: Option<&str>,
        usual: &str,
        limit: MemoryLimit,
    ) -> Result<MeasuredMap, Fault> {
        match (self, key) {
            (MapFormat::Fits, key) => read_fits(path, key, limit),
            (MapFormat::Hdf5, key) => read_hdf5(path, key, usual, limit),
            (MapFormat::Zygo, None) => read_zygo(path, limit),
            (MapFormat::Tiff, None) => read_tiff(path, limit),
            (MapFormat::Zygo | MapFormat::Tiff, Some(key)) => Err(Fault::of_file(
                path,
                format!("the key `{key}`"),
                "no key: such a file holds one map",
            )),
        }
    }
}

/// Reads a map from a file of MetroPro (.dat), a TIFF picture, a FITS or HDF5 file, or a NumPy file.
///
/// # Errors
/// A file that cannot be read, of another kind, or beyond the limit.
pub fn read_map(path: &Path, choices: &MapChoices) -> Result<MeasuredMap, Fault> {
    let mut map = match MapFormat::of(path) {
        Some(format) => format.read(path, choices.key, "height", choices.limit)?,
        None => MeasuredMap::of(read_numpy(
            path,
            choices.key,
            "height_um",
            choices.limit.bytes,
        )?),
    };
    if let (Some(with), Array::Real(values)) = (choices.fill, &mut map.values) {
        fill(values, with);
    }
    Ok(map)
}

/// Reads the array of a NumPy file, where the name says no other format.
///
/// # Errors
/// As [`Array::read`].
pub(crate) fn read_numpy(
    path: &Path,
    key: Option<&str>,
    usual: &str,
    limit: u64,
) -> Result<Array, Fault> {
    let end = path.extension().and_then(|end| end.to_str());
    let end = end.unwrap_or_default().to_ascii_lowercase();
    if path.file_name().is_some() && end != "npy" && end != "npz" {
        let found = format!("a file of type `{end}`");
        let expected = "a .npy, .npz, .dat, .tif, .fits or .h5 file";
        return Err(Fault::of_file(path, found, expected));
    }
    Array::read(path, key, usual, limit)
}
