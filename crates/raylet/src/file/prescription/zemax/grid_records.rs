//! Grids of values as a Zemax file writes them.
//!
//! A record `GDAT` has how many points there are along x and y, their steps and the middle of the grid; a record `GARR` each point:
//! its number from 0, its value, three slopes, and whether it is without data. The first point is that at the smallest x and the
//! largest y; x grows first, then y falls. Lengths are in the unit of the file, phases in rad.

use ndarray::Array2;

use crate::file::decode::fault::Fault;
use crate::file::prescription::lens_text::{LensText, Record};

/// Most points along an axis.
const MOST_POINTS: usize = 100_000;

/// The grid of a surface as the file writes it.
#[derive(Clone, Debug, Default)]
pub(crate) struct RawGrid {
    size: [usize; 2],
    /// Steps along x and y, then the middle.
    places: [f64; 4],
    values: Vec<f64>,
    /// Points without data.
    pub missing: usize,
}

impl RawGrid {
    /// Reads a record; false where it is none of a grid.
    ///
    /// # Errors
    /// A value that is missing or no number, or a point in another place than its number says.
    pub(crate) fn read(&mut self, text: &LensText, record: &Record<'_>) -> Result<bool, Fault> {
        match record.word {
            "GDAT" => {
                let count = |place: usize| text.count(record, place, MOST_POINTS);
                self.size = [count(0)?, count(1)?];
                for (place, number) in self.places.iter_mut().enumerate() {
                    *number = text.value_or(record, place + 2, 0.0)?;
                }
            }
            "GARR" => {
                let number = text.value(record, 0)?;
                if number != self.values.len() as f64 {
                    let expected = format!("point {}", self.values.len());
                    return Err(text.fault(record.word, format!("point {number}"), expected));
                }
                let (value, missing) = (text.value(record, 1)?, text.value_or(record, 5, 0.0)?);
                self.missing += usize::from(missing != 0.0);
                self.values.push(if missing == 0.0 { value } else { 0.0 });
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Whether the file has no grid.
    pub(crate) fn is_empty(&self) -> bool {
        self.values.is_empty() && self.size == [0; 2]
    }

    /// The values [y, x] times a factor, with rows growing with y.
    ///
    /// # Errors
    /// What was found in place of what was expected: other counts.
    pub(crate) fn array(&self, factor: f64) -> Result<Array2<f64>, (String, String)> {
        let [nx, ny] = self.size;
        let found = format!(
            "a grid of {nx} × {ny} points with {} values",
            self.values.len()
        );
        let refuse = || (found, "records GDAT, and GARR for each point".to_owned());
        if nx == 0 || ny == 0 {
            return Err(refuse());
        }
        let rows = self.values.chunks_exact(nx).rev().flatten();
        let scaled = rows.map(|value| value * factor).collect();
        Array2::from_shape_vec((ny, nx), scaled).map_err(|_| refuse())
    }

    /// The steps along x and y in mm.
    ///
    /// # Errors
    /// What was found in place of what was expected: steps that are zero.
    pub(crate) fn steps(&self, unit: f64) -> Result<[f64; 2], (String, String)> {
        let [x, y, ..] = self.places.map(|step| (step * unit).abs());
        match x > 0.0 && y > 0.0 {
            true => Ok([x, y]),
            false => Err((
                format!("steps of {x} and {y} mm"),
                "steps above zero".to_owned(),
            )),
        }
    }

    /// The middle of the grid in mm.
    pub(crate) fn middle(&self, unit: f64) -> [f64; 2] {
        let [.., x, y] = self.places;
        [x, y].map(|at| at * unit)
    }
}
