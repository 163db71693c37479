//! The values that a file gets: as they are, or on levels, or as heights instead of phases.

use std::io;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, choice_fault};
use crate::file::fabrication::levels::{Levels, plan_levels, spread};
use crate::file::fabrication::open_part::CLOSED;
use crate::file::fabrication::relief::Relief;

/// How a value of a cell becomes that of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MadeValues {
    /// The levels on which values are put, where their number is chosen.
    pub levels: Option<Levels>,
    /// The relief in whose heights values are given.
    relief: Option<Relief>,
    /// What a file holds.
    pub quantity: Quantity,
    /// What the cells hold.
    from: Quantity,
}

/// The smallest and the largest value of a file, and the root mean square of what levels changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MadeRange {
    /// In the unit of the file.
    pub range: [f64; 2],
    /// In the unit of the cells.
    pub rounding: f64,
    /// Whether neighbours along x or y differ by more than half a turn of the phase.
    pub jumps: bool,
}

impl MadeValues {
    /// The values for the cells; heights where `heights` asks for them.
    ///
    /// # Errors
    /// Heights of a relief whose depth is not known, or values that are on no levels.
    pub(crate) fn plan(
        cells: &mut Cells,
        choices: &ExportChoices,
        heights: bool,
    ) -> Result<Self, Fault> {
        let levels = match choices.levels {
            Some(_) => {
                let found = spread(cells)?;
                Some(plan_levels(cells, &found, choices)?)
            }
            None => None,
        };
        if !cells.active.is_whole() {
            let lost = "the gaps between pixels: cells touch";
            cells.losses.push(String::from(lost));
        }
        let from = cells.quantity;
        let relief = (heights && from != Quantity::Height).then_some(cells.relief);
        if let Some(relief) = relief {
            let known = relief.depth_um().is_some();
            let refuse = |name: &str, found: &str, expected: &str| {
                Err(choice_fault(&cells.file, name, found, expected))
            };
            match from {
                Quantity::Phase if !known => {
                    let expected = "the index of the relief and the wavelength (--index, --wavelength-um), or the depth of a \
                         whole wave (--depth-um)";
                    return refuse("index", "phases without a relief", expected);
                }
                Quantity::Level if !known || levels.is_none() => {
                    let expected =
                        "a number of levels, and the depth of them all (--levels, --depth-um)";
                    return refuse("depth_um", "levels without a depth", expected);
                }
                Quantity::Amplitude => {
                    return refuse("quantity", "amplitudes", "phases, heights or levels");
                }
                _ => {}
            }
        }
        Ok(Self {
            levels,
            relief,
            quantity: if relief.is_some() {
                Quantity::Height
            } else {
                from
            },
            from,
        })
    }

    /// The value of a file for that of a cell; of a closed one that of level 0, or 0.
    pub(crate) fn of(&self, value: f64) -> f64 {
        let on_level = match self.levels {
            Some(levels) => levels.value(levels.of(value).0),
            None if value.is_nan() => 0.0,
            None => value,
        };
        match (self.relief, self.from, self.levels) {
            (None, ..) => on_level,
            (Some(relief), Quantity::Level, Some(levels)) => {
                on_level * relief.depth_um().unwrap_or(0.0) / f64::from(levels.count)
            }
            (Some(relief), ..) => relief.height_um(on_level).unwrap_or(0.0),
        }
    }

    /// Puts the values of a row of a file in place of those of the cells.
    ///
    /// # Errors
    /// A row that cannot be read; the fault is within the error.
    pub(crate) fn row(&self, cells: &mut Cells, y: usize, values: &mut [f64]) -> io::Result<()> {
        cells.read_row(y, values).map_err(io::Error::other)?;
        values.iter_mut().for_each(|value| *value = self.of(*value));
        Ok(())
    }

    /// Looks at all values once.
    ///
    /// # Errors
    /// A row that cannot be read.
    pub(crate) fn range(&self, cells: &mut Cells) -> Result<MadeRange, Fault> {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut squares, mut count) = (0.0, 0.0);
        let is_phase = self.quantity == Quantity::Phase;
        let (mut before, mut made) = (Vec::new(), Vec::new());
        let mut jumps = false;
        cells.each_row(|_, values| {
            made.clear();
            for value in values {
                let own = self.of(*value);
                range = [range[0].min(own), range[1].max(own)];
                // Jumps to closed cells do not count, nor are these rounded.
                made.push(if value.is_nan() { CLOSED } else { own });
                count += f64::from(u8::from(!value.is_nan()));
            }
            if let Some(levels) = self.levels {
                squares += values
                    .iter()
                    .map(|value| levels.of(*value).1.powi(2))
                    .sum::<f64>();
            }
            if is_phase && !jumps {
                let far = |(a, b): (&f64, &f64)| (a - b).abs() > std::f64::consts::PI;
                jumps = made.iter().zip(made.iter().skip(1)).any(far)
                    || made.iter().zip(&before).any(far);
            }
            std::mem::swap(&mut before, &mut made);
            Ok(())
        })?;
        Ok(MadeRange {
            range,
            rounding: (squares / count).sqrt(),
            jumps,
        })
    }
}
