//! Arrays of HDF5 files as maps, and their axes. Rows are as axes say; without them the first row is at the smallest y.

use std::path::Path;

use ndarray::{Array2, Axis};

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::hdf5::hdf5_reader::{Hdf5, Numbers};
use crate::file::maps::map_unit::Unit;
use crate::file::maps::measured_map::MeasuredMap;

/// How far a position may lie from equal steps, as a part of the step.
const UNEVEN: f64 = 1e-3;

/// Reads an array: the one named `key`, or else `usual`, or else the only one with two axes.
///
/// # Errors
/// A file that cannot be read, no such array, one of other than two axes longer than one, one that does not fit into
/// the limit, or axes with unequal steps.
pub(crate) fn read_hdf5(
    path: &Path,
    key: Option<&str>,
    usual: &str,
    limit: MemoryLimit,
) -> Result<MeasuredMap, Fault> {
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let file = Hdf5::open(path, limit)?;
    let name = chosen(path, &file, key, usual)?;
    let stored = file.read(&name)?;
    let size = size_of(&stored.shape).ok_or_else(|| {
        let found = format!("`{name}` of shape {:?}", stored.shape);
        refuse((found, String::from("two axes [y, x] longer than one")))
    })?;
    let shaped = |_| {
        let found = format!("`{name}` of shape {:?}", stored.shape);
        refuse((found, String::from("two axes [y, x]")))
    };
    let values = match stored.numbers {
        Numbers::Real(numbers) => {
            Array::Real(Array2::from_shape_vec(size, numbers).map_err(shaped)?)
        }
        Numbers::Complex(numbers) => {
            Array::Complex(Array2::from_shape_vec(size, numbers).map_err(shaped)?)
        }
    };
    let mut map = MeasuredMap::of(values);
    map.unit = stored.unit;
    map.quantity = name.rsplit('/').next().unwrap_or_default().to_owned();

    // Axes beside the array say the pitch, and which way they run.
    let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut pitch = [None; 2];
    let (ny, nx) = size;
    let axes = [("x", Axis(1), nx), ("y", Axis(0), ny)];
    for ((letter, axis, length), pitch) in axes.into_iter().zip(&mut pitch) {
        let Some(ends) = axis_ends(path, &file, [folder, letter], length)? else {
            continue;
        };
        let step = (ends[1] - ends[0]) / (length - 1) as f64;
        if step < 0.0 {
            invert(&mut map.values, axis);
        }
        map.place(letter, ends, usual);
        *pitch = Some(step.abs());
    }
    if let [Some(x), Some(y)] = pitch {
        map.pitch_um = Some([x, y]);
    }
    Ok(map)
}

/// The name of the array that is meant.
fn chosen(path: &Path, file: &Hdf5, key: Option<&str>, usual: &str) -> Result<String, Fault> {
    if let Some(key) = key {
        return Ok(key.to_owned());
    }
    let names = file.names()?;
    if names.iter().any(|name| name == usual) {
        return Ok(usual.to_owned());
    }
    let mut maps = Vec::new();
    for name in &names {
        if size_of(&file.shape(name)?).is_some() {
            maps.push(name);
        }
    }
    match maps.as_slice() {
        [only] => Ok((*only).clone()),
        _ => Err(Fault::of_file(
            path,
            format!("{} arrays of two axes", maps.len()),
            format!(
                "a `key` that names one; outside of groups there are: {}",
                names.join(", ")
            ),
        )),
    }
}

/// Rows and columns; leading axes of length one are left out.
fn size_of(shape: &[usize]) -> Option<(usize, usize)> {
    match shape {
        [leading @ .., ny, nx]
            if leading.iter().all(|length| *length == 1) && *ny > 0 && *nx > 0 =>
        {
            Some((*ny, *nx))
        }
        _ => None,
    }
}

/// The first and the last position of an axis in µm; none where there is no axis of this length with a unit of length.
fn axis_ends(
    path: &Path,
    file: &Hdf5,
    [folder, letter]: [&str; 2],
    length: usize,
) -> Result<Option<[f64; 2]>, Fault> {
    let names = [
        (format!("{letter}_mm"), Some(1e3)),
        (format!("{letter}_um"), Some(1.0)),
        (letter.to_owned(), None),
    ];
    for (name, known) in names {
        let name = match folder {
            "" => name,
            folder => format!("{folder}/{name}"),
        };
        if file.shape(&name).ok().as_deref() != Some(&[length]) || length < 2 {
            continue;
        }
        let axis = file.read(&name)?;
        let um = known.or_else(|| match axis.unit.as_deref().and_then(Unit::named) {
            Some(Unit::Length(um)) => Some(um),
            _ => None,
        });
        let (Numbers::Real(numbers), Some(um)) = (axis.numbers, um) else {
            continue;
        };
        let (first, last) = (numbers.first().copied(), numbers.last().copied());
        let (first, last) = (first.unwrap_or(0.0), last.unwrap_or(0.0));
        let step = (last - first) / (length - 1) as f64;
        let off = |(i, p): (usize, &f64)| (p - first - i as f64 * step).abs();
        let even = |place: (usize, &f64)| off(place) <= UNEVEN * step.abs();
        if step == 0.0 || !step.is_finite() || !numbers.iter().enumerate().all(even) {
            let found = format!("`{name}` with unequal steps");
            return Err(Fault::of_file(path, found, "equally spaced positions"));
        }
        return Ok(Some([first * um, last * um]));
    }
    Ok(None)
}

/// Turns an axis around.
fn invert(values: &mut Array, axis: Axis) {
    match values {
        Array::Real(values) => {
            values.invert_axis(axis);
            *values = values.as_standard_layout().into_owned();
        }
        Array::Complex(values) => {
            values.invert_axis(axis);
            *values = values.as_standard_layout().into_owned();
        }
    }
}
