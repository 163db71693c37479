//! Grids of values as texts of Zemax (.dat): Grid Sag and Grid Phase.
//!
//! The first line has `nx ny delx dely unitflag xdec ydec`, every other one a point: `z dz/dx dz/dy d2z/dxdy nodata`. The first
//! point is that at the smallest x and the largest y; x grows first, then y falls. The unit is 0 for mm, 1 for cm, 2 for inches
//! and 3 for m; phases are in rad whatever it is.

use std::io::Read;
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::prescription::lens_text::{LensText, Record};

/// Units by their number, in mm.
const UNITS: [f64; 4] = [1.0, 10.0, 25.4, 1000.0];

/// Most points along an axis that are believed.
const MOST_POINTS: usize = 100_000;

/// Part of a step by which that of a scene may differ: the digits in which steps are written.
const SAME_STEP: f64 = 1e-6;

/// Bytes within which the first line stands, with remarks before it.
const LONGEST_HEAD: u64 = 100_000;

/// What a file should be.
const READABLE: &str = "a readable grid of Zemax (.dat)";

/// A grid of values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridText {
    /// What stands before the points.
    pub head: GridHead,
    /// The values [y, x] as written, with rows growing with y; zero where a point is marked as one without data.
    pub values: Array2<f64>,
    /// The first line of a point without data.
    pub gap: Option<usize>,
    /// Whether the text has slopes besides values.
    pub slopes: bool,
}

/// The first line of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GridHead {
    /// Points along x and y.
    pub size: [usize; 2],
    /// Distance of neighbouring points along x and y in mm.
    pub step_mm: [f64; 2],
    /// How many mm the unit of heights has.
    pub unit_mm: f64,
    /// The middle of the grid in mm.
    pub middle_mm: [f64; 2],
}

impl GridText {
    /// Reads a file of at most so many bytes.
    ///
    /// # Errors
    /// A file that cannot be read, or the first fault of its text with its line.
    pub(crate) fn read(path: &Path, limit: u64) -> Result<Self, Fault> {
        let refuse = |found: String| Fault::of_file(path, found, READABLE);
        let file = regular_file::open(path).map_err(refuse)?;
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        // The text, and at most half as much again for the values: a point has 16 characters and more where it is complete.
        MemoryLimit::of_settings(limit)
            .check(format!("{length} bytes of text"), length.saturating_mul(2))
            .map_err(|(found, expected)| Fault::of_file(path, found, expected))?;
        let mut bytes = Vec::new();
        let read = file.take(limit).read_to_end(&mut bytes);
        read.map_err(|error| refuse(error.to_string()))?;
        Self::parse(&LensText::new(&bytes, path))
    }

    /// The grid of a text.
    ///
    /// # Errors
    /// The first fault of the text, with its line.
    pub(crate) fn parse(text: &LensText) -> Result<Self, Fault> {
        let mut records = text
            .records()
            .filter(|record| !record.word.starts_with('!'));
        let Some(first) = records.next() else {
            let expected = "a line `nx ny delx dely unitflag xdec ydec`, and a line for each point";
            return Err(text.fault_of_file("no lines", expected));
        };
        let head = GridHead::of(text, &first)?;
        let [nx, ny] = head.size;
        let (mut listed, mut gap, mut slopes) = (Vec::new(), None, false);
        for record in records {
            if listed.len() == nx * ny {
                let expected = format!("{nx} × {ny} points, as line {} states", first.line);
                return Err(text.fault_of_line(record.line, "one more point", expected));
            }
            let number = |place: usize| match place {
                0 => text.number(record.word),
                _ => text.value_or(&record, place - 1, 0.0),
            };
            let (height, missing) = (number(0)?, number(4)? != 0.0);
            for place in 1..4 {
                slopes |= number(place)? != 0.0;
            }
            if missing && gap.is_none() {
                gap = Some(record.line);
            }
            listed.push(if missing { 0.0 } else { height });
        }
        let found = listed.len();
        // The first row has the largest y.
        let rows = listed.chunks_exact(nx).rev().flatten().copied().collect();
        let values = Array2::from_shape_vec((ny, nx), rows).map_err(|_| {
            let expected = format!("{nx} × {ny}, as line {} states", first.line);
            text.fault_of_file(format!("{found} points"), expected)
        })?;
        Ok(Self {
            head,
            values,
            gap,
            slopes,
        })
    }
}

impl GridHead {
    /// Reads the first line of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or a fault of that line.
    pub(crate) fn read(path: &Path) -> Result<Self, Fault> {
        let refuse = |found: String| Fault::of_file(path, found, READABLE);
        let file = regular_file::open(path).map_err(refuse)?;
        let mut bytes = Vec::new();
        let read = file.take(LONGEST_HEAD).read_to_end(&mut bytes);
        read.map_err(|error| refuse(error.to_string()))?;
        let text = LensText::new(&bytes, path);
        let mut records = text.records();
        match records.find(|record| !record.word.starts_with('!')) {
            Some(first) => Self::of(&text, &first),
            None => Err(text.fault_of_file("no lines", READABLE)),
        }
    }

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
        let unit_mm = UNITS.get(unit).copied().unwrap_or(1.0);
        let step = [number(2)?.abs(), number(3)?.abs()];
        if size.contains(&0) || step.contains(&0.0) {
            let found = format!("{} × {} points {step:?} apart", size[0], size[1]);
            return Err(text.fault_of_line(record.line, found, "numbers above zero"));
        }
        Ok(Self {
            size,
            step_mm: step.map(|step| step * unit_mm),
            unit_mm,
            middle_mm: [number(5)? * unit_mm, number(6)? * unit_mm],
        })
    }

    /// Refuses a grid that a scene places otherwise, as (found, expected): with another pitch, or a middle of its own.
    pub(crate) fn require_pitch(&self, pitch_um: [f64; 2]) -> Result<(), (String, String)> {
        let steps = self.step_mm.map(|mm| mm * 1e3);
        let differs = |(step, pitch): (f64, f64)| (step - pitch).abs() > SAME_STEP * pitch;
        if steps.into_iter().zip(pitch_um).any(differs) {
            let found = format!("points {} and {} µm apart", steps[0], steps[1]);
            let expected = format!("{} and {} µm, as in pitch_um", pitch_um[0], pitch_um[1]);
            return Err((found, expected));
        }
        if self.middle_mm != [0.0; 2] {
            let found = format!("a grid with its middle at {:?} mm", self.middle_mm);
            return Err((found, "0 0 as xdec and ydec".to_owned()));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ndarray::array;

    use crate::file::arrays::grid_text::GridText;
    use crate::file::prescription::lens_text::LensText;

    fn parsed(text: &str) -> Result<GridText, String> {
        let text = LensText::new(text.as_bytes(), Path::new("a.dat"));
        GridText::parse(&text).map_err(|fault| fault.to_string())
    }

    #[test]
    fn rows_come_from_the_top() {
        let grid = parsed(
            "! nx ny …\n3 2 0.1 -0.2 1 0.5 0\n1 0 0 0\n2 0 0 0 0\n3\n\n4 1 0 0\n5\n6 0 0 0 1\n",
        );
        let grid = grid.unwrap();
        assert_eq!(grid.values, array![[4.0, 5.0, 0.0], [1.0, 2.0, 3.0]]);
        assert_eq!(grid.head.size, [3, 2]);
        assert_eq!(grid.head.step_mm, [1.0, 2.0]);
        assert_eq!((grid.head.unit_mm, grid.head.middle_mm), (10.0, [5.0, 0.0]));
        assert_eq!((grid.gap, grid.slopes), (Some(9), true));
        assert!(grid.head.require_pitch([1000.0, 2000.0]).is_err());
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
