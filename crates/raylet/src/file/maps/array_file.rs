//! The array that a key of a scene names, from a NumPy file or a map.

use std::path::Path;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::maps::map_file::{MapFormat, read_numpy};
use crate::file::maps::map_unit::factor_for;
use crate::file::maps::measured_map::MeasuredMap;
use crate::file::maps::missing_samples::missing;

/// Reads the array of the key `field` of a scene, in the unit of the key. `key` names an array of a file that holds
/// several.
///
/// # Errors
/// A file that cannot be read, of another kind, or beyond the limit; a unit that does not fit; missing samples; or a map
/// that leaves open what it means.
pub(crate) fn read_array(
    path: &Path,
    key: Option<&str>,
    field: &str,
    limit: u64,
) -> Result<Array, Fault> {
    let Some(format) = MapFormat::of(path) else {
        return read_numpy(path, key, field, limit);
    };
    let map = format.read(path, key, field, MemoryLimit::of_settings(limit))?;
    certain(map, field).map_err(|(found, expected)| Fault::of_file(path, found, expected))
}

/// The values of a map in the unit of a key, where nothing is missing or open. Refusals are (found, expected).
fn certain(map: MeasuredMap, field: &str) -> Result<Array, (String, String)> {
    if let Some(doubt) = map.doubts.first() {
        let expected = "a map that leaves nothing open; raylet.read_map reads it all the same";
        return Err((doubt.clone(), String::from(expected)));
    }
    let factor = factor_for(map.unit.as_deref(), field)?;
    let mut values = map.values;
    match &mut values {
        Array::Real(values) => {
            if let Some(lost) = missing(values) {
                let expected =
                    "a value everywhere; raylet.read_map(path, fill=\"nearest\") fills them";
                return Err((lost, String::from(expected)));
            }
            if factor != 1.0 {
                values.mapv_inplace(|value| factor * value);
            }
        }
        Array::Complex(values) if factor != 1.0 => values.mapv_inplace(|value| value * factor),
        Array::Complex(_) => {}
    }
    values.borrowed().check(field)?;
    Ok(values)
}
