//! Lengths in the whole database units of a mask file.

use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_choices::choice_fault;

/// How far a pitch may be from a whole number of database units, in these.
const ROUNDED: f64 = 1e-6;

/// A length in database units, which the choice of a name states.
///
/// # Errors
/// One that is no whole number of them.
pub(crate) fn in_units(file: &Path, name: &str, um: f64, unit_nm: f64) -> Result<i64, Fault> {
    let units = 1e3 * um / unit_nm;
    let whole = units.round();
    if whole >= 1.0 && (units - whole).abs() <= ROUNDED && whole < 1e15 {
        return Ok(whole as i64);
    }
    // Units that would do, and the nearest length that does.
    let fits = |unit: &f64| {
        let units = 1e3 * um / unit;
        units.round() >= 1.0 && (units - units.round()).abs() <= ROUNDED
    };
    let finer = [0.5, 0.25, 0.2, 0.1, 0.05, 0.025, 0.02, 0.01, 0.001];
    let mut expected = format!("a multiple of the database unit of {unit_nm} nm");
    match finer.iter().find(|unit| **unit < unit_nm && fits(unit)) {
        Some(unit) => expected += &format!(", or a unit of {unit} nm (--database-unit-nm {unit})"),
        None => {
            let near = whole.max(1.0) * unit_nm * 1e-3;
            expected += &format!(", such as {near} µm");
        }
    }
    Err(choice_fault(file, name, format!("{um} µm"), expected))
}
