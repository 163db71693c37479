//! Levels: from the value of a cell to the number of the step that a foundry makes.

use std::f64::consts::TAU;
use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, choice_fault};

/// Distinct values that are kept, by which levels are recognised.
const MOST_VALUES: usize = 256;

/// How far a value may be from its level, as a share of a step, to be on it: rounding of 32-bit numbers.
const ROUNDED: f64 = 1e-4;

/// The levels of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// How many there are.
    pub count: u16,
    /// The value of level 0.
    pub lowest: f64,
    /// From one level to the next, in the unit of the values.
    pub step: f64,
    /// Whether the level above the highest is level 0 again.
    pub wraps: bool,
}

impl Levels {
    /// The level of a value, and how far the value is from it. A closed cell is on level 0.
    pub(crate) fn of(&self, value: f64) -> (u16, f64) {
        if value.is_nan() {
            return (0, 0.0);
        }
        let steps = (value - self.lowest) / self.step;
        let nearest = steps.round();
        let count = f64::from(self.count);
        let level = match self.wraps {
            true => nearest.rem_euclid(count),
            false => nearest.clamp(0.0, count - 1.0),
        };
        let off = match self.wraps {
            true => steps - nearest,
            false => steps - level,
        };
        (level as u16, off * self.step)
    }

    /// The value of a level.
    pub(crate) fn value(&self, level: u16) -> f64 {
        self.lowest + f64::from(level) * self.step
    }
}

/// What the values of an element are like.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spread {
    /// The smallest and the largest.
    pub range: [f64; 2],
    /// All of them, ascending; nothing where there are many.
    pub distinct: Option<Vec<f64>>,
}

/// Looks at all values once.
///
/// # Errors
/// A row that cannot be read.
pub(crate) fn spread(cells: &mut Cells) -> Result<Spread, Fault> {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut distinct = Some(Vec::new());
    cells.each_row(|_, values| {
        let mut last = f64::NAN;
        for value in values {
            // Closed cells have no value.
            range = [range[0].min(*value), range[1].max(*value)];
            if *value != last && !value.is_nan() {
                last = *value;
                keep(&mut distinct, *value);
            }
        }
        Ok(())
    })?;
    Ok(Spread { range, distinct })
}

/// Adds a value to an ascending list, which ends where it gets too long.
fn keep(distinct: &mut Option<Vec<f64>>, value: f64) {
    let Some(list) = distinct else { return };
    if let Err(place) = list.binary_search_by(|known| known.total_cmp(&value)) {
        list.insert(place, value);
    }
    if list.len() > MOST_VALUES {
        *distinct = None;
    }
}

/// The levels on which values are put: as many as are chosen, or as the scene states, or those on which they are.
///
/// # Errors
/// Values that are on no few levels where no number is chosen, or that levels do not hold.
pub(crate) fn plan_levels(
    cells: &Cells,
    spread: &Spread,
    choices: &ExportChoices,
) -> Result<Levels, Fault> {
    let file = cells.file.as_path();
    let levels = match (cells.quantity, choices.levels) {
        (Quantity::Phase, Some(count)) => wrapped(count as u16),
        (Quantity::Phase, None) => match cells.designed {
            Some(designed) => wrapped(designed.count),
            None => found_phases(spread).ok_or_else(|| many(file))?,
        },
        (Quantity::Height, count) => heights(cells, spread, count, file)?,
        (Quantity::Amplitude, count) => straight(count.unwrap_or(2) as u16, [0.0, 1.0]),
        (Quantity::Level, count) => numbers(spread, count, file)?,
    };
    // What lies beyond half a step from every level has none.
    let half = 0.5 * levels.step * (1.0 + ROUNDED);
    let [low, high] = spread.range;
    let highest = levels.value(levels.count - 1);
    if !levels.wraps && (low < levels.lowest - half || high > highest + half) {
        let unit = cells.quantity.unit();
        let found = format!("values from {low} to {high}{unit}");
        let expected = format!(
            "{} levels from {} to {highest}{unit}",
            levels.count, levels.lowest
        );
        return Err(Fault::of_file(file, found, expected));
    }
    Ok(levels)
}

/// Phases on equal levels of a whole turn.
fn wrapped(count: u16) -> Levels {
    Levels {
        count,
        lowest: 0.0,
        step: TAU / f64::from(count),
        wraps: true,
    }
}

/// Equal levels from one value to another.
fn straight(count: u16, [lowest, highest]: [f64; 2]) -> Levels {
    let step = (highest - lowest) / f64::from(count - 1);
    Levels {
        count,
        lowest,
        step: if step > 0.0 { step } else { 1.0 },
        wraps: false,
    }
}

/// The fewest equal levels of a turn on which all phases are.
fn found_phases(spread: &Spread) -> Option<Levels> {
    let values = spread.distinct.as_ref()?;
    let fits = |count: &u16| {
        let levels = wrapped(*count);
        (values.iter()).all(|value| levels.of(*value).1.abs() <= ROUNDED * levels.step)
    };
    (2..=MOST_VALUES as u16).find(fits).map(wrapped)
}

/// Heights on levels of a whole wave, or else from the lowest to the highest.
fn heights(
    cells: &Cells,
    spread: &Spread,
    chosen: Option<u32>,
    file: &Path,
) -> Result<Levels, Fault> {
    let [low, high] = spread.range;
    let designed = cells.designed.filter(|_| chosen.is_none());
    // Levels that a scene states are shares of a whole wave.
    let depth = cells.relief.depth_um();
    let stated = designed.filter(|_| depth.is_some());
    let count = chosen.or(stated.map(|designed| u32::from(designed.count)));
    match (count, depth) {
        (Some(count), Some(depth)) => Ok(Levels {
            count: count as u16,
            lowest: 0.0,
            step: match designed {
                Some(designed) => designed.step_um(depth),
                None => depth / f64::from(count),
            },
            wraps: false,
        }),
        (Some(count), None) => Ok(straight(count as u16, spread.range)),
        (None, _) => {
            let values = spread.distinct.as_deref().ok_or_else(|| many(file))?;
            let gaps = values.iter().zip(values.iter().skip(1));
            let smallest = gaps
                .map(|(a, b)| b - a)
                .filter(|gap| *gap > ROUNDED * (high - low))
                .fold(f64::INFINITY, f64::min);
            if smallest.is_infinite() {
                return Ok(straight(2, [low, low + 1.0]));
            }
            let count = ((high - low) / smallest).round() + 1.0;
            let levels = straight(count.min(f64::from(u16::MAX)) as u16, spread.range);
            let on = |value: &f64| levels.of(*value).1.abs() <= ROUNDED * levels.step;
            match count <= MOST_VALUES as f64 && values.iter().all(on) {
                true => Ok(levels),
                false => Err(many(file)),
            }
        }
    }
}

/// Values that are numbers of levels.
fn numbers(spread: &Spread, count: Option<u32>, file: &Path) -> Result<Levels, Fault> {
    let [low, high] = spread.range;
    let is_whole = |value: &f64| value.fract() == 0.0;
    let whole = (spread.distinct.as_ref()).is_none_or(|values| values.iter().all(is_whole));
    if !whole || low < 0.0 || high > 32_766.0 {
        let found = format!("values from {low} to {high}");
        return Err(Fault::of_file(file, found, "whole numbers from 0 to 32766"));
    }
    let count = count.unwrap_or((high as u32 + 1).max(2));
    Ok(straight(count as u16, [0.0, f64::from(count - 1)]))
}

/// The fault of values that are on no levels.
fn many(file: &Path) -> Fault {
    let found = "values that are not on a few equal levels";
    choice_fault(file, "levels", found, "a number of levels (--levels N)")
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};
    use std::path::Path;

    use ndarray::{Array2, array};

    use crate::file::arrays::array::BorrowedArray;
    use crate::file::fabrication::cell_rows::{BorrowedRows, Cells, Part};
    use crate::file::fabrication::export_choices::{ExportChoices, Quantity};
    use crate::file::fabrication::levels::{Levels, plan_levels, spread};

    fn cells(values: &Array2<f64>, quantity: Quantity) -> Cells<'_> {
        let rows = BorrowedRows {
            array: BorrowedArray::Real(values.view()),
            part: Part::Phase,
            scale: 1.0,
        };
        Cells {
            quantity,
            ..Cells::new(Box::new(rows), [1.0; 2], Path::new("a.npy"))
        }
    }

    fn planned(
        values: Array2<f64>,
        quantity: Quantity,
        levels: Option<u32>,
    ) -> Result<Levels, String> {
        let mut cells = cells(&values, quantity);
        let choices = ExportChoices {
            levels,
            ..ExportChoices::default()
        };
        let spread = spread(&mut cells).map_err(|fault| fault.to_string())?;
        plan_levels(&cells, &spread, &choices).map_err(|fault| fault.to_string())
    }

    #[test]
    fn levels_are_recognised() {
        // Phases of 32 bits, and beyond a turn.
        let third = f64::from((TAU / 3.0) as f32);
        let phases = array![[0.0, third, 2.0 * third, TAU - third, 3.0 * TAU, -third]];
        let levels = planned(phases, Quantity::Phase, None).unwrap();
        assert_eq!((levels.count, levels.wraps), (3, true));
        assert_eq!(levels.of(-third).0, 2);
        let fault = planned(array![[0.0, 0.1, 1.0]], Quantity::Phase, None).unwrap_err();
        assert!(
            fault.contains("a.npy: levels") && fault.contains("--levels"),
            "{fault}"
        );

        // Heights, numbers of levels, amplitudes.
        let heights = planned(array![[0.2, 0.8, 0.4]], Quantity::Height, None).unwrap();
        assert_eq!((heights.count, heights.of(0.8).0), (4, 3));
        let numbers = planned(array![[0.0, 5.0]], Quantity::Level, None).unwrap();
        assert_eq!((numbers.count, numbers.of(5.0)), (6, (5, 0.0)));
        assert!(planned(array![[0.5, 5.0]], Quantity::Level, None).is_err());
        assert!(planned(array![[0.0, 5.0]], Quantity::Level, Some(4)).is_err());
        assert!(planned(array![[0.0, 1.8]], Quantity::Amplitude, None).is_err());
        let flat = planned(array![[3.0, 3.0]], Quantity::Height, None).unwrap();
        assert_eq!(flat.of(3.0), (0, 0.0));
    }

    #[test]
    fn phases_are_rounded_and_wrapped() {
        let levels = planned(array![[0.0, 1.0]], Quantity::Phase, Some(4)).unwrap();
        for (phase, level) in [
            (0.0, 0),
            (0.7, 0),
            (0.9, 1),
            (PI, 2),
            (-PI, 2),
            (5.6, 0),
            (-0.9, 3),
            (7.0, 0),
        ] {
            let (found, off) = levels.of(phase);
            assert_eq!(found, level, "{phase}");
            assert!(off.abs() <= PI / 4.0 + 1e-12);
            let turns = (phase - off - levels.value(level)) / TAU;
            assert!((turns - turns.round()).abs() < 1e-12);
        }
    }
}
