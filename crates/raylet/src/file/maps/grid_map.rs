//! Grids of values as texts of Zemax (.dat): Grid Sag and Grid Phase.
//!
//! The first line has `nx ny delx dely unitflag xdec ydec`, every other one a point: `z dz/dx dz/dy d2z/dxdy nodata`. The first
//! point is that at the smallest x and the largest y; x grows first, then y falls. The unit is 0 for mm, 1 for cm, 2 for inches
//! and 3 for m; phases are in rad whatever it is. The text does not say whether its values are heights or phases.

use std::io::Read;
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::maps::measured_map::MeasuredMap;
use crate::file::prescription::lens_text::{LensText, Record};

/// Units by their number, and what they are in mm.
const UNITS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("m", 1000.0)];

/// Most points along an axis that are believed.
const MOST_POINTS: usize = 100_000;

/// What a file should be.
const READABLE: &str = "a readable grid of Zemax (.dat)";

/// The first line of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GridHead {
    /// Points along x and y.
    size: [usize; 2],
    /// Distance of neighbouring points along x and y in mm.
    step_mm: [f64; 2],
    /// The unit of heights.
    unit: &'static str,
    /// The middle of the grid in mm.
    middle_mm: [f64; 2],
}

/// Reads a file. Points that are marked as ones without data are missing.
///
/// # Errors
/// A file that cannot be read, the first fault of its text with its line, or one that does not fit into the limit.
pub(crate) fn read_grid(path: &Path, limit: MemoryLimit) -> Result<MeasuredMap, Fault> {
    let refuse = |found: String| Fault::of_file(path, found, READABLE);
    let file = regular_file::open(path).map_err(refuse)?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());

    // The text, and at most half as much again for the values: a point has 16 characters and more where it is complete.
    limit
        .check(format!("{length} bytes of text"), length.saturating_mul(2))
        .map_err(|(found, expected)| Fault::of_file(path, found, expected))?;
    let mut bytes = Vec::new();
    let read = file.take(length).read_to_end(&mut bytes);
    read.map_err(|error| refuse(error.to_string()))?;
    parse(&LensText::new(&bytes, path))
}

/// The grid of a text.
///
/// # Errors
/// The first fault of the text, with its line.
fn parse(text: &LensText) -> Result<MeasuredMap, Fault> {
    let mut records = text
        .records()
        .filter(|record| !record.word.starts_with('!'));
    let Some(first) = records.next() else {
        let expected = "a line `nx ny delx dely unitflag xdec ydec`, and a line for each point";
        return Err(text.fault_of_file("no lines", expected));
    };
    let head = GridHead::of(text, &first)?;
    let [nx, ny] = head.size;
    let mut listed = Vec::new();
    for record in records {
        if listed.len() == nx * ny {
            let expected = format!("{nx} × {ny} points, as line {} states", first.line);
            return Err(text.fault_of_line(record.line, "one more point", expected));
        }
        let value = text.number(record.word)?;

        // Slopes are not used, but they must be numbers.
        for place in 0..3 {
            text.value_or(&record, place, 0.0)?;
        }
        let missing = text.value_or(&record, 3, 0.0)? != 0.0;
        listed.push(if missing { f64::NAN } else { value });
    }

    // The first row has the largest y.
    let found = listed.len();
    let rows = listed.chunks_exact(nx).rev().flatten().copied().collect();
    let values = Array2::from_shape_vec((ny, nx), rows).map_err(|_| {
        let expected = format!("{nx} × {ny}, as line {} states", first.line);
        text.fault_of_file(format!("{found} points"), expected)
    })?;
    Ok(head.map_of(values))
}

impl GridHead {
    /// What the first line says.
    fn of(text: &LensText, record: &Record<'_>) -> Result<Self, Fault> {
        let count = record.values.len() + 1;
        if count < 5 {
            let found = format!("a first line of {count} numbers");
            let expected = "nx ny delx dely unitflag, and maybe xdec ydec";
            return Err(text.fault_of_line(record.line, found, expected));
        }
        let number = |place: usize| match place {
            0 => text.number(record.word),
            5.. => text.value_or(record, place - 1, 0.0),
            _ => text.value(record, place - 1),
        };
        let whole = |place: usize, most: usize, what: &str| {
            let value = number(place)?;
            let good = value.fract() == 0.0 && value >= 0.0 && value <= most as f64;
            good.then_some(value as usize).ok_or_else(|| {
                let expected = format!("a whole number up to {most}");
                text.fault_of_line(record.line, format!("{what} {value}"), expected)
            })
        };
        let size = [whole(0, MOST_POINTS, "nx")?, whole(1, MOST_POINTS, "ny")?];
        let unit = whole(4, UNITS.len() - 1, "a unit of number")?;
        let (unit, unit_mm) = UNITS.get(unit).copied().unwrap_or(("mm", 1.0));
        let step = [number(2)?.abs(), number(3)?.abs()];
        if size.contains(&0) || step.contains(&0.0) {
            let found = format!("{} × {} points {step:?} apart", size[0], size[1]);
            return Err(text.fault_of_line(record.line, found, "numbers above zero"));
        }
        Ok(Self {
            size,
            step_mm: step.map(|step| step * unit_mm),
            unit,
            middle_mm: [number(5)? * unit_mm, number(6)? * unit_mm],
        })
    }

    /// The map of these values. A middle of its own is left to the user: scenes have grids about their axis.
    fn map_of(&self, values: Array2<f64>) -> MeasuredMap {
        let mut map = MeasuredMap::of(Array::Real(values));
        map.pitch_um = Some(self.step_mm.map(|mm| mm * 1e3));
        map.unit = Some(self.unit.to_owned());
        if self.middle_mm != [0.0; 2] {
            let doubt = format!("a grid with its middle at {:?} mm", self.middle_mm);
            map.doubts.push(doubt);
        }
        map
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ndarray::array;

    use crate::file::arrays::array::Array;
    use crate::file::maps::grid_map::parse;
    use crate::file::maps::measured_map::MeasuredMap;
    use crate::file::prescription::lens_text::LensText;

    fn parsed(text: &str) -> Result<MeasuredMap, String> {
        let text = LensText::new(text.as_bytes(), Path::new("a.dat"));
        parse(&text).map_err(|fault| fault.to_string())
    }

    #[test]
    fn rows_come_from_the_top() {
        let grid = parsed(
            "! nx ny …\n3 2 0.1 -0.2 1 0.5 0\n1 0 0 0\n2 0 0 0 0\n3\n\n4 1 0 0\n5\n6 0 0 0 1\n",
        );
        let map = grid.unwrap();
        let Array::Real(values) = map.values else {
            panic!("a complex grid");
        };
        assert!(values[[0, 2]].is_nan());
        let known = values.mapv(|value| if value.is_nan() { 0.0 } else { value });
        assert_eq!(known, array![[4.0, 5.0, 0.0], [1.0, 2.0, 3.0]]);
        assert_eq!(map.pitch_um, Some([1000.0, 2000.0]));
        assert_eq!(map.unit.as_deref(), Some("cm"));
        assert_eq!(map.doubts, ["a grid with its middle at [5.0, 0.0] mm"]);
    }

    #[test]
    fn faults_name_the_line() {
        for (text, start) in [
            ("", "a.dat: found no lines"),
            (
                "2 2 1",
                "a.dat:1:1: found a first line of 3 numbers, expected nx ny",
            ),
            (
                "2.5 2 1 1 0",
                "a.dat:1:1: found nx 2.5, expected a whole number",
            ),
            (
                "1e9 2 1 1 0",
                "a.dat:1:1: found nx 1000000000, expected a whole number",
            ),
            (
                "2 0 1 1 0",
                "a.dat:1:1: found 2 × 0 points [1.0, 1.0] apart",
            ),
            (
                "2 2 0 1 0",
                "a.dat:1:1: found 2 × 2 points [0.0, 1.0] apart",
            ),
            ("2 2 1 1 4", "a.dat:1:1: found a unit of number 4"),
            ("2 2 1 1 0\n1\nx\n", "a.dat:3:1: found x, expected a number"),
            (
                "2 2 1 1 0\n1\n2\n3\n",
                "a.dat: found 3 points, expected 2 × 2, as line 1",
            ),
            (
                "1 1 1 1 0\n1\n2\n",
                "a.dat:3:1: found one more point, expected 1 × 1",
            ),
        ] {
            let fault = parsed(text).unwrap_err();
            assert!(fault.starts_with(start), "{fault}");
        }
    }
}
