//! A map of any of the formats, with its missing samples filled where that is requested.

use std::io::Read;
use std::path::Path;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::maps::fits_map::read_fits;
use crate::file::maps::grid_map::read_grid;
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
    /// A map of MetroPro or a grid of Zemax: the first byte decides.
    Dat,
    Tiff,
    Fits,
    Hdf5,
}

impl MapFormat {
    /// The format of a file of this name.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match end.as_str() {
            "dat" => MapFormat::Dat,
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
            (MapFormat::Fits, key) => read_fits(path, key, usual, limit),
            (MapFormat::Hdf5, key) => read_hdf5(path, key, usual, limit),
            (MapFormat::Dat, None) => read_dat(path, usual, limit),
            (MapFormat::Tiff, None) => read_tiff(path, limit),
            (MapFormat::Dat | MapFormat::Tiff, Some(key)) => Err(Fault::of_file(
                path,
                format!("the key `{key}`"),
                "no key: such a file holds one map",
            )),
        }
    }
}

/// Reads a .dat file: texts are grids of Zemax, all others maps of MetroPro. The unit of a grid is that of heights; its phases
/// are in rad.
fn read_dat(path: &Path, usual: &str, limit: MemoryLimit) -> Result<MeasuredMap, Fault> {
    let refuse = |found: String| Fault::of_file(path, found, "a map (.dat) that can be read");
    let file = regular_file::open(path).map_err(refuse)?;
    let mut start = Vec::new();
    let got = file.take(1).read_to_end(&mut start);
    got.map_err(|error| refuse(error.to_string()))?;
    if start.first().is_some_and(|byte| !is_text(*byte)) {
        return read_zygo(path, limit);
    }
    let mut map = read_grid(path, limit)?;
    if usual == "phase" {
        map.unit = Some(String::from("rad"));
    }
    Ok(map)
}

/// Whether a text may begin with this byte: a character, a space, or the mark of a Unicode text.
fn is_text(byte: u8) -> bool {
    byte.is_ascii_graphic() || byte.is_ascii_whitespace() || [0xef, 0xfe, 0xff].contains(&byte)
}

/// Reads a map from a file of MetroPro or a grid of Zemax (.dat), a TIFF picture, a FITS or HDF5 file, or a NumPy file.
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
