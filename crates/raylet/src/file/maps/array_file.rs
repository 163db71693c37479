//! The array that a key of a scene names, from a NumPy file or a map.

use std::path::Path;
use std::sync::Arc;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::maps::map_file::{MapFormat, read_numpy};
use crate::file::maps::map_unit::factor_for;
use crate::file::maps::measured_map::MeasuredMap;
use crate::file::maps::missing_samples::missing;

/// Part of a pitch by which that of a scene may differ: the digits of single precision, in which files have it.
const SAME_PITCH: f64 = 1e-6;

/// An array, and what its file says of its grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SampledArray {
    /// The values, in the unit of the key.
    pub(crate) values: Arc<Array>,
    /// Distance of neighbouring samples along x and y in µm, where the file says it.
    pub(crate) pitch_um: Option<[f64; 2]>,
}

impl SampledArray {
    /// Refuses a file that says another pitch than the scene, as (found, expected).
    pub(crate) fn require_pitch(&self, pitch_um: [f64; 2]) -> Result<(), (String, String)> {
        let Some(steps) = self.pitch_um else {
            return Ok(());
        };
        let differs = |(step, pitch): (f64, f64)| (step - pitch).abs() > SAME_PITCH * pitch;
        match steps.into_iter().zip(pitch_um).any(differs) {
            true => Err((
                format!("samples {} and {} µm apart", steps[0], steps[1]),
                format!("{} and {} µm, as in pitch_um", pitch_um[0], pitch_um[1]),
            )),
            false => Ok(()),
        }
    }
}

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
) -> Result<SampledArray, Fault> {
    let Some(format) = MapFormat::of(path) else {
        let values = read_numpy(path, key, field, limit)?;
        return Ok(SampledArray {
            values: Arc::new(values),
            pitch_um: None,
        });
    };
    let map = format.read(path, key, field, MemoryLimit::of_settings(limit))?;
    certain(map, field).map_err(|(found, expected)| Fault::of_file(path, found, expected))
}

/// The values of a map in the unit of a key, where nothing is missing or open. Refusals are (found, expected).
fn certain(map: MeasuredMap, field: &str) -> Result<SampledArray, (String, String)> {
    if let Some(doubt) = map.doubts.first() {
        let expected = "a map that leaves nothing open; raylet.read_map reads it all the same";
        return Err((doubt.clone(), String::from(expected)));
    }
    let factor = factor_for(map.unit.as_deref(), field)?;
    let (mut values, pitch_um) = (map.values, map.pitch_um);
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
    Ok(SampledArray {
        values: Arc::new(values),
        pitch_um,
    })
}
