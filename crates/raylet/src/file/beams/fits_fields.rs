//! Fields as FITS files.
//!
//! The first image is a cube of real and imaginary parts, as POPPY writes complex wavefronts: [part, y, x] of one
//! wavelength, [wavelength, part, y, x] of several, the first row at the smallest y. Extensions X_MM, Y_MM and
//! WAVELENGTH_UM hold positions and wavelengths. Without them these come from CDELT, CRPIX and CRVAL with a unit of
//! length, or from PIXELSCL in metres about the middle, and from WAVELEN in metres.

use std::io::{self, Write};
use std::path::Path;

use ndarray::{Array1, Array3, Axis};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::decode::fault::Fault;
use crate::file::fits::fits_header::Header;
use crate::file::fits::fits_reader::{Fits, Part};
use crate::file::fits::fits_writer::{Cards, write_doubles};
use crate::file::maps::fits_map::{REAL_PART, complex};
use crate::file::maps::map_unit::Unit;

/// Extensions with positions in mm and wavelengths in µm.
const AXES: [&str; 3] = ["X_MM", "Y_MM", "WAVELENGTH_UM"];

/// Writes fields.
///
/// # Errors
/// An error of the file system.
pub(crate) fn write_fits(fields: &Fields, out: &mut impl Write) -> io::Result<()> {
    let (count, ny, nx) = fields.field.dim();
    let axes: &[usize] = match count {
        1 => &[nx, ny, 2],
        _ => &[nx, ny, 2, count],
    };
    let mut cards = Cards::of_doubles(None, axes);
    cards.text("PLANE1", "Real part of complex wavefront", "");
    cards.text("PLANE2", "Imaginary part of complex wavefront", "");
    for (axis, name, positions) in [(1, "X", &fields.x_mm), (2, "Y", &fields.y_mm)] {
        let first = positions.first().copied().unwrap_or(0.0);
        let last = positions.last().copied().unwrap_or(0.0);
        let step = (last - first) / (positions.len().max(2) - 1) as f64;
        cards.text(&format!("CTYPE{axis}"), name, "");
        cards.text(&format!("CUNIT{axis}"), "mm", "");
        cards.number(&format!("CRPIX{axis}"), 1.0, "");
        cards.number(&format!("CRVAL{axis}"), first, "");
        cards.number(&format!("CDELT{axis}"), step, "");
        if axis == 1 {
            cards.number("PIXELSCL", step * 1e-3, "metres per sample along x");
            cards.text("PIXUNIT", "meter", "");
        }
    }
    if let Some(wavelength_um) = fields.wavelength_um.first() {
        cards.number(
            "WAVELEN",
            wavelength_um * 1e-6,
            "first wavelength in metres",
        );
    }
    cards.text("PHASE", "exp(+ikz)", "sign of the phase along +z");
    cards.write(out)?;

    // The real parts of a wavelength come first, its imaginary parts behind them.
    let parts = fields.field.outer_iter().flat_map(|channel| {
        let real = channel.into_iter().map(|u| u.re);
        real.chain(channel.into_iter().map(|u| u.im))
    });
    write_doubles(out, parts)?;
    let values = [&fields.x_mm, &fields.y_mm, &fields.wavelength_um];
    for (name, values) in AXES.into_iter().zip(values) {
        Cards::of_doubles(Some(name), &[values.len()]).write(out)?;
        write_doubles(out, values.iter().copied())?;
    }
    Ok(())
}

/// Reads fields.
///
/// # Errors
/// A file that cannot be read, that holds no complex field, without positions or wavelengths, or beyond the limit.
pub(crate) fn read_fits_fields(path: &Path, limit: MemoryLimit) -> Result<Fields, Fault> {
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let mut fits = Fits::open(path)?;
    let is_field = |part: &&Part| {
        let plane = part.header.text("PLANE1");
        part.is_image() && plane.is_some_and(|plane| plane.starts_with(REAL_PART))
    };
    let part = fits.parts.iter().find(is_field).cloned().ok_or_else(|| {
        let found = String::from("no image of a complex field");
        refuse((
            found,
            format!("a cube whose PLANE1 begins with `{REAL_PART}`"),
        ))
    })?;
    let axes = part.header.axes().map_err(refuse)?;
    let (nx, ny, count) = match *axes.as_slice() {
        [nx, ny, 2] if nx.min(ny) > 0 => (nx, ny, 1),
        [nx, ny, 2, count] if nx.min(ny).min(count) > 0 => (nx, ny, count),
        _ => {
            let expected = "[x, y, part] or [x, y, part, wavelength], none of them empty";
            return Err(refuse((format!("axes {axes:?}"), expected.to_owned())));
        }
    };
    let [nx, ny, count] = [nx, ny, count].map(|length| length as usize);
    let bytes = part.header.data_bytes().map_err(refuse)?;
    limit
        .check("a field", bytes.saturating_mul(3))
        .map_err(refuse)?;

    // One wavelength after the other.
    let numbers = fits.numbers(&part, limit)?;
    let mut field = Array3::zeros((count, ny, nx));
    let each = numbers.chunks_exact((2 * ny * nx).max(1));
    for (mut channel, numbers) in field.axis_iter_mut(Axis(0)).zip(each) {
        channel.assign(&complex(numbers.to_vec(), [nx, ny]).map_err(refuse)?);
    }
    let [x_name, y_name, waves_name] = AXES;
    let x = extension(&mut fits, x_name, limit)?;
    let y = extension(&mut fits, y_name, limit)?;
    let waves = extension(&mut fits, waves_name, limit)?;
    let header = &part.header;
    let fields = Fields {
        x_mm: x
            .map_or_else(|| positions(header, 1, nx), Ok)
            .map_err(refuse)?,
        y_mm: y
            .map_or_else(|| positions(header, 2, ny), Ok)
            .map_err(refuse)?,
        wavelength_um: waves
            .map_or_else(|| wavelength(header), Ok)
            .map_err(refuse)?,
        field,
    };
    fields.check_for(path)?;
    Ok(fields)
}

/// The numbers of an extension of one axis, if there is one.
fn extension(
    fits: &mut Fits,
    name: &str,
    limit: MemoryLimit,
) -> Result<Option<Array1<f64>>, Fault> {
    let found = fits
        .parts
        .iter()
        .find(|part| part.is_image() && part.name() == name);
    match found.cloned() {
        Some(part) => Ok(Some(fits.numbers(&part, limit)?.into())),
        None => Ok(None),
    }
}

/// Positions in mm as the header says.
fn positions(header: &Header, axis: u32, count: usize) -> Result<Array1<f64>, (String, String)> {
    let number = |word: &str| header.number(&format!("{word}{axis}"));
    let unit = header.text(&format!("CUNIT{axis}")).and_then(Unit::named);
    let at = |first: f64, step: f64| -> Array1<f64> {
        (0..count).map(|i| first + i as f64 * step).collect()
    };
    if let (Some(step), Some(Unit::Length(um))) = (number("CDELT")?, unit) {
        let (pixel, value) = (
            number("CRPIX")?.unwrap_or(1.0),
            number("CRVAL")?.unwrap_or(0.0),
        );
        let mm = um * 1e-3;
        return Ok(at(mm * (value + (1.0 - pixel) * step), mm * step));
    }

    // A scale alone: the samples lie symmetrically about the axis.
    let is_metres = header.text("PIXUNIT").and_then(Unit::named) == Some(Unit::Length(1e6));
    match header.number("PIXELSCL")? {
        Some(scale) if is_metres => {
            let step = 1e3 * scale;
            Ok(at(-0.5 * step * (count.max(1) - 1) as f64, step))
        }
        _ => Err((
            format!("no positions along axis {axis}"),
            format!(
                "an extension {}, CDELT with CUNIT, or PIXELSCL in metres",
                { if axis == 1 { AXES[0] } else { AXES[1] } }
            ),
        )),
    }
}

/// The wavelength in µm as the header says.
fn wavelength(header: &Header) -> Result<Array1<f64>, (String, String)> {
    match header.number("WAVELEN")? {
        Some(metres) => Ok(Array1::from_elem(1, 1e6 * metres)),
        None => Err((
            String::from("no wavelength"),
            format!("an extension {}, or WAVELEN in metres", AXES[2]),
        )),
    }
}
