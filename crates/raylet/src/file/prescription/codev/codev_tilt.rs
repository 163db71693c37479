//! Shifts and tilts of a CODE V file's surfaces, as turns of the axis before and behind them.
//!
//! CODE V turns about x and y left-handed, about z right-handed: a positive ADE turns +z towards +y. The shift comes first, then
//! the turns about x, the new y and the new z.

use crate::file::decode::fault::Fault;
use crate::file::prescription::codev::codev_commands::Command;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::Turn;

/// What becomes of the axis behind a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum After {
    /// It stays that of the surface.
    #[default]
    Kept,
    /// It returns to that before the surface.
    Returned,
    /// It turns once more, as light that a mirror reflects.
    Bent,
    /// The surface is not turned, and the axis behind it goes back by the turn.
    Reversed,
}

/// The shift and tilt of a surface, lengths in the unit of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tilt {
    shift: [f64; 3],
    /// ADE, BDE and CDE in degrees.
    angles: [f64; 3],
    after: After,
    line: usize,
}

impl Tilt {
    /// Reads a command; false where it is none of a tilt.
    ///
    /// # Errors
    /// A value that is missing or no number, or a return to the axis of another surface.
    pub(crate) fn read(&mut self, text: &LensText, command: &Command<'_>) -> Result<bool, Fault> {
        let places = [
            ("XDE", 0),
            ("YDE", 1),
            ("ZDE", 2),
            ("ADE", 3),
            ("BDE", 4),
            ("CDE", 5),
        ];
        let place = places.iter().find(|(word, _)| *word == command.key);
        if let Some((_, place)) = place {
            let value = command.number(text, 0)?;
            let mut numbers = self.shift.iter_mut().chain(self.angles.iter_mut());
            if let Some(number) = numbers.nth(*place) {
                *number = value;
            }
            return Ok(true);
        }
        self.after = match command.key.as_str() {
            "DEC" => After::Kept,
            "DAR" => After::Returned,
            "BEN" => After::Bent,
            "REV" => After::Reversed,
            "RET" | "GLB" => {
                let found = format!("{}, the axis of another surface", command.word);
                let expected = "shifts and tilts with DAR, BEN, REV or none of them";
                return Err(text.fault(command.word, found, expected));
            }
            _ => return Ok(false),
        };
        self.line = command.line;
        Ok(true)
    }

    /// The turns before and behind the surface in mm.
    ///
    /// # Errors
    /// A bend about two axes.
    pub(crate) fn turns(&self, text: &LensText, unit: f64) -> Result<[Option<Turn>; 2], Fault> {
        let [a, b, c] = self.angles;
        // Zero is taken from, so that no zero has a sign.
        let tilt_deg = [0.0 - a, 0.0 - b, c];
        let [x, y, z] = self.shift.map(|shift| shift * unit);
        let there = Turn {
            decenter_mm: [x, y],
            along_mm: z,
            tilt_deg,
            tilt_first: false,
        };
        let back = Turn {
            decenter_mm: [0.0 - x, 0.0 - y],
            along_mm: 0.0 - z,
            tilt_deg: tilt_deg.map(|angle| 0.0 - angle),
            tilt_first: true,
        };
        let again = Turn {
            tilt_deg,
            ..Turn::default()
        };
        let moved = self.shift != [0.0; 3] || self.angles != [0.0; 3];
        let used = |turn: Turn| moved.then_some(turn);
        Ok(match self.after {
            After::Kept => [used(there), None],
            After::Returned => [used(there), used(back)],
            After::Reversed => [None, used(back)],
            After::Bent => {
                if self.angles.iter().filter(|angle| **angle != 0.0).count() > 1 {
                    let found = "BEN with more than one of ADE, BDE and CDE";
                    let expected = "a bend about one axis";
                    return Err(text.fault_of_line(self.line, found, expected));
                }
                [used(there), used(again)]
            }
        })
    }
}
