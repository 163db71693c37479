//! The part of a cell that is drawn: all of it, less where an etch widens shapes, more where it narrows them, or a
//! rectangle about its centre where there are gaps between cells.
//!
//! An etch moves the edges of a whole pattern, not those of the rectangles that it is drawn by. So a cell is divided by
//! two lines along each axis, at the distance of this move from its sides, into nine parts. Each part is drawn by what the
//! cell and the neighbours on its side hold.

use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_choices::{ExportChoices, Masks, choice_fault};
use crate::file::fabrication::masks::database_units::in_units;
use crate::optics::pixels::active_area::ActiveArea;

/// How the edges of drawn shapes lie to those of the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DrawnPart {
    /// On them.
    Whole,
    /// Each cell is drawn by itself, with this margin along x and y in database units.
    Apart([i64; 2]),
    /// Patterns are this much narrower at every edge.
    Shrunk(i64),
    /// Patterns are this much wider at every edge.
    Grown(i64),
}

impl DrawnPart {
    /// The part for cells of a pitch in database units, of which `active` is drawn.
    ///
    /// # Errors
    /// An etch bias that is no multiple of the database unit or as wide as half a cell, or one for binary masks with gaps.
    pub(crate) fn plan(
        file: &Path,
        pitch: [i64; 2],
        active: ActiveArea,
        choices: &ExportChoices,
    ) -> Result<Self, Fault> {
        let bias_um = choices.etch_bias_um;
        let bias = match bias_um == 0.0 {
            true => 0,
            false => {
                let units = in_units(
                    file,
                    "etch_bias_um",
                    bias_um.abs(),
                    choices.database_unit_nm,
                )?;
                if bias_um > 0.0 { units } else { -units }
            }
        };
        let margins = [(pitch[0], active.sides[0]), (pitch[1], active.sides[1])];
        let margins =
            margins.map(|(pitch, side)| (0.5 * (1.0 - side) * pitch as f64).round() as i64);
        let narrow = pitch[0].min(pitch[1]);
        let most = margins[0].max(margins[1]) + bias.abs();
        let refuse = |found: String, expected: &str| {
            Err(choice_fault(file, "etch_bias_um", found, expected))
        };
        if 2 * most >= narrow && bias != 0 {
            let found = format!("{bias_um} µm at each side of a cell");
            return refuse(found, "less than half of what is drawn of a cell");
        }
        let apart = margins.map(|margin| margin + bias);
        match (margins, bias) {
            ([0, 0], 0) => Ok(Self::Whole),
            ([0, 0], 1..) => Ok(Self::Shrunk(bias)),
            ([0, 0], _) => Ok(Self::Grown(-bias)),
            _ if bias != 0 && choices.masks == Masks::Binary => refuse(
                format!("{bias_um} µm for binary masks of cells with gaps"),
                "none, or masks of another kind",
            ),
            _ if apart[0].min(apart[1]) <= 0 => refuse(
                format!("{bias_um} µm for cells with narrower gaps"),
                "gaps that stay open",
            ),
            _ if 2 * apart[0].max(apart[1]) >= narrow => Ok(Self::Whole),
            _ => Ok(Self::Apart(apart)),
        }
    }

    /// How far an edge may be from that of its cell along x and y, in database units.
    pub(crate) fn margins(self) -> [i64; 2] {
        match self {
            Self::Whole => [0; 2],
            Self::Apart(margins) => margins,
            Self::Shrunk(margin) | Self::Grown(margin) => [margin; 2],
        }
    }

    /// Parts of a cell along each axis.
    pub(crate) fn divisions(self) -> usize {
        match self {
            Self::Whole => 1,
            _ => 3,
        }
    }

    /// Cells around the element into which its patterns reach.
    pub(crate) fn frame(self) -> usize {
        usize::from(matches!(self, Self::Grown(_)))
    }

    /// The place of a line between parts along an axis, in database units from the corner of the first cell.
    pub(crate) fn place(self, line: usize, axis: usize, pitch: i64) -> i64 {
        let margin = match axis {
            0 => self.margins()[0],
            _ => self.margins()[1],
        };
        let divisions = self.divisions();
        let within = match line % divisions {
            0 => 0,
            1 => margin,
            _ => pitch - margin,
        };
        ((line / divisions) as i64 - self.frame() as i64) * pitch + within
    }

    /// What a part of a cell is drawn as: of the cell, of its neighbours along x and along y on the side of the part (the
    /// cell itself in the middle), and of the one across the corner. `is_core` is the part in the middle of the cell.
    pub(crate) fn value(self, [own, along, up, across]: [u16; 4], is_core: bool) -> u16 {
        let neighbours = [along, up, across];
        match self {
            Self::Whole => own,
            Self::Apart(_) => own * u16::from(is_core),
            Self::Shrunk(_) => own * u16::from(neighbours.iter().all(|value| *value == own)),
            Self::Grown(_) => neighbours.iter().fold(own, |most, value| most.max(*value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::fabrication::export_choices::{ExportChoices, Masks};
    use crate::file::fabrication::masks::drawn_part::DrawnPart;
    use crate::optics::pixels::active_area::{ActiveArea, Rest};

    fn planned(bias_um: f64, fill: f64, masks: Masks) -> Result<DrawnPart, String> {
        let choices = ExportChoices {
            etch_bias_um: bias_um,
            masks,
            ..ExportChoices::default()
        };
        let active = ActiveArea::of_fill(fill, Rest::Flat).unwrap();
        let part = DrawnPart::plan(Path::new("a.gds"), [1000, 2000], active, &choices);
        part.map_err(|fault| fault.to_string())
    }

    #[test]
    fn gaps_and_biases_move_edges() {
        assert_eq!(planned(0.0, 1.0, Masks::Each), Ok(DrawnPart::Whole));
        assert_eq!(planned(0.05, 1.0, Masks::Binary), Ok(DrawnPart::Shrunk(50)));
        assert_eq!(planned(-0.05, 1.0, Masks::Each), Ok(DrawnPart::Grown(50)));
        // 0.81 of the area is 0.9 of each side.
        let gaps = planned(0.0, 0.81, Masks::Binary);
        assert_eq!(gaps, Ok(DrawnPart::Apart([50, 100])));
        let both = planned(0.02, 0.81, Masks::Each);
        assert_eq!(both, Ok(DrawnPart::Apart([70, 120])));
        for (bias, fill, masks, part) in [
            (0.5, 1.0, Masks::Each, "half"),
            (0.0005, 1.0, Masks::Each, "database unit"),
            (0.02, 0.81, Masks::Binary, "binary"),
            (-0.06, 0.81, Masks::Each, "narrower"),
        ] {
            let message = planned(bias, fill, masks).unwrap_err();
            assert!(
                message.contains("etch_bias_um") && message.contains(part),
                "{message}"
            );
        }
    }

    #[test]
    fn lines_divide_cells() {
        let part = DrawnPart::Grown(50);
        let lines: Vec<i64> = (0..7).map(|line| part.place(line, 0, 1000)).collect();
        assert_eq!(lines, [-1000, -950, -50, 0, 50, 950, 1000]);
        assert_eq!(DrawnPart::Whole.place(3, 1, 1000), 3000);
        assert_eq!(DrawnPart::Apart([1, 2]).place(4, 1, 1000), 1002);
    }
}
