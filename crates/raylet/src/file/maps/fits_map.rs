//! Images of FITS files as maps. The first row is the one at the smallest y, as FITS viewers show it.

use std::path::Path;

use ndarray::{Array2, Axis};
use num_complex::Complex64;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::fits::fits_header::Header;
use crate::file::fits::fits_reader::{Fits, Part};
use crate::file::maps::map_unit::Unit;
use crate::file::maps::measured_map::MeasuredMap;

/// What stands at the start of PLANE1 of a cube of real and imaginary parts.
pub(crate) const REAL_PART: &str = "Real part";

/// Reads an image: the extension named `key`, or else the first image with data. `usual` is the key of a scene that it is for.
///
/// # Errors
/// A file that cannot be read, no such image, an image of other than two axes that is no complex field, or one that
/// does not fit into the limit.
pub(crate) fn read_fits(
    path: &Path,
    key: Option<&str>,
    usual: &str,
    limit: MemoryLimit,
) -> Result<MeasuredMap, Fault> {
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let mut fits = Fits::open(path)?;
    let part = chosen(&fits, key).map_err(refuse)?;
    let header = &part.header;
    let axes = header.axes().map_err(refuse)?;
    let lengths: Vec<usize> = axes.iter().map(|axis| *axis as usize).collect();

    // Axes of length one beyond the second are left out.
    let used = lengths.iter().rposition(|length| *length != 1).unwrap_or(0);
    let shown: Vec<usize> = lengths.iter().copied().take((used + 1).max(2)).collect();
    let is_complex = header
        .text("PLANE1")
        .is_some_and(|plane| plane.starts_with(REAL_PART));
    let values = match *shown.as_slice() {
        [nx, ny] if nx > 0 && ny > 0 => {
            let numbers = fits.numbers(&part, limit)?;
            grid(numbers, [nx, ny]).map(Array::Real)
        }
        [nx, ny, 2] if is_complex && nx > 0 && ny > 0 => {
            let numbers = fits.numbers(&part, limit)?;
            complex(numbers, [nx, ny]).map(Array::Complex)
        }
        _ => Err((
            format!("an image of axes {lengths:?}"),
            String::from("two axes, or a third one of real and imaginary part, as PLANE1 says"),
        )),
    };
    let mut map = MeasuredMap::of(values.map_err(refuse)?);
    map.unit = header.text("BUNIT").map(str::to_owned);
    map.pitch_um = pitch(header).map_err(refuse)?;
    for (number, axis, count) in [(1, "x", shown.first()), (2, "y", shown.get(1))] {
        let count = count.copied().unwrap_or(1);
        if let Some(ends) = ends(header, number, count).map_err(refuse)? {
            map.place(axis, ends, usual);
        }
    }
    Ok(map)
}

/// The image that is named, or the first one with data.
fn chosen(fits: &Fits, key: Option<&str>) -> Result<Part, (String, String)> {
    let has_data = |part: &&Part| part.is_image() && part.header.data_bytes().unwrap_or(0) > 0;
    let mut images = fits.parts.iter().filter(has_data);
    let found = match key {
        Some(key) => images.find(|part| part.name() == key),
        None => images.next(),
    };
    if let Some(part) = found {
        return Ok(part.clone());
    }
    let names: Vec<&str> = fits.parts.iter().map(Part::name).collect();
    let is_packed = fits.parts.iter().any(|part| part.header.is_true("ZIMAGE"));
    let found = match (key, is_packed) {
        (_, true) => String::from("a compressed image in a table"),
        (Some(key), _) => format!("no image `{key}`"),
        (None, _) => String::from("no image with data"),
    };
    let expected = format!(
        "an image that is not compressed; extensions: {}",
        names.join(", ")
    );
    Err((found, expected))
}

/// Rows of real numbers.
fn grid(numbers: Vec<f64>, [nx, ny]: [usize; 2]) -> Result<Array2<f64>, (String, String)> {
    let found = format!("{} numbers", numbers.len());
    Array2::from_shape_vec((ny, nx), numbers).map_err(|_| (found, format!("{ny} x {nx}")))
}

/// Real parts, and behind them imaginary parts.
pub(crate) fn complex(
    numbers: Vec<f64>,
    [nx, ny]: [usize; 2],
) -> Result<Array2<Complex64>, (String, String)> {
    let both = grid(numbers, [nx, 2 * ny])?;
    let (real, imaginary) = both.view().split_at(Axis(0), ny);
    let mut field = real.mapv(Complex64::from);
    field.zip_mut_with(&imaginary, |u, part| u.im = *part);
    Ok(field)
}

/// The first and the last position of an axis in µm, where the header places a sample of it: CRVAL at CRPIX, with CDELT and a
/// unit of length.
fn ends(header: &Header, axis: usize, count: usize) -> Result<Option<[f64; 2]>, (String, String)> {
    let number = |name: &str| header.number(&format!("{name}{axis}"));
    let unit = header.text(&format!("CUNIT{axis}")).and_then(Unit::named);
    let (Some(value), Some(pixel), Some(step), Some(Unit::Length(um))) =
        (number("CRVAL")?, number("CRPIX")?, number("CDELT")?, unit)
    else {
        return Ok(None);
    };
    let at = |place: f64| (value + (place - pixel) * step) * um;
    Ok(Some([at(1.0), at(count as f64)]))
}

/// The distance of neighbouring samples in µm: CDELT with its unit of length, or PIXELSCL in metres.
fn pitch(header: &Header) -> Result<Option<[f64; 2]>, (String, String)> {
    let mut pitch = [0.0; 2];
    for (axis, pitch) in (1..).zip(&mut pitch) {
        let step = header.number(&format!("CDELT{axis}"))?;
        let unit = header.text(&format!("CUNIT{axis}")).and_then(Unit::named);
        *pitch = match (step, unit) {
            (Some(step), Some(Unit::Length(um))) if step > 0.0 => step * um,
            _ => 0.0,
        };
    }
    if pitch.iter().all(|pitch| *pitch > 0.0) {
        return Ok(Some(pitch));
    }

    // What POPPY and similar programs write.
    let in_metres = header
        .text("PIXUNIT")
        .is_none_or(|unit| Unit::named(unit) == Some(Unit::Length(1e6)));
    let pupil = header.number("PUPLSCAL")?;
    let scale = match in_metres {
        true => header.number("PIXELSCL")?,
        false => None,
    };
    let metres = pupil.or(scale.filter(|_| header.text("PIXUNIT").is_some()));
    Ok(metres
        .filter(|metres| *metres > 0.0)
        .map(|metres| [metres * 1e6; 2]))
}
