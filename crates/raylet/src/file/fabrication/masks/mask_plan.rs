//! How cells become shapes of a mask file: layers, coordinates, and the tile that repeats.

use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_choices::{ExportChoices, Masks, choice_fault};
use crate::file::fabrication::masks::database_units::in_units;
use crate::file::fabrication::masks::drawn_part::DrawnPart;
use crate::optics::pixels::active_area::ActiveArea;

/// Layers and data types are below this.
const MOST_LAYERS: u32 = 32_768;

/// Most columns or rows of an array of references.
const MOST_REPEATS: usize = 32_767;

/// Most levels whose shapes are drawn wider: each has a pattern of its own.
const MOST_PATTERNS: u16 = 255;

/// Where shapes stand, and on which layers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaskPlan {
    /// How levels become layers.
    pub masks: Masks,
    /// Number of levels.
    pub levels: u16,
    /// Number of the first layer.
    pub first_layer: u16,
    /// Database unit in nm.
    pub unit_nm: f64,
    /// Number of cells [nx, ny].
    pub size: [usize; 2],
    /// Width of a cell along x and y in database units.
    pub pitch: [i64; 2],
    /// The corner of the smallest x and y, in database units: the element is centred, to half a unit.
    pub corner: [i64; 2],
    /// The part of a cell that is drawn.
    pub part: DrawnPart,
    /// The layer of the outline of the aperture, if it is drawn.
    pub aperture_layer: Option<u16>,
}

/// A layer of a mask file, with its data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MaskLayer {
    /// Its number.
    pub layer: u16,
    /// Its data type.
    pub data_type: u16,
}

impl MaskPlan {
    /// The plan for cells of this number and pitch.
    ///
    /// # Errors
    /// A pitch that is no multiple of the database unit, coordinates beyond 32 bits, layers beyond 15 bits, or a number of
    /// levels without binary masks.
    pub(crate) fn new(
        file: &Path,
        size: [usize; 2],
        (pitch_um, active): ([f64; 2], ActiveArea),
        levels: u16,
        choices: &ExportChoices,
    ) -> Result<Self, Fault> {
        let unit_nm = choices.database_unit_nm;
        let mut pitch = [0; 2];
        for (to, um) in pitch.iter_mut().zip(pitch_um) {
            *to = in_units(file, "pitch_um", um, unit_nm)?;
        }
        let [nx, ny] = size;
        let [dx, dy] = pitch;
        let widths = [(nx, dx), (ny, dy)].map(|(count, pitch)| {
            i64::try_from(count).map_or(i64::MAX, |count| count.saturating_mul(pitch))
        });
        if let Some(width) = widths.iter().find(|width| **width > i64::from(i32::MAX)) {
            let mm = *width as f64 * unit_nm * 1e-6;
            let found = format!("an element {mm:.6} mm wide in units of {unit_nm} nm");
            let most = f64::from(i32::MAX) * unit_nm * 1e-6;
            let expected = format!("at most {most:.6} mm, or a larger unit: 32 bits hold no more");
            return Err(choice_fault(file, "database_unit_nm", found, expected));
        }
        let plan = Self {
            masks: choices.masks,
            levels,
            first_layer: choices.gds_layer,
            unit_nm,
            size,
            pitch,
            corner: widths.map(|width| -(width / 2)),
            part: DrawnPart::plan(file, pitch, active, choices)?,
            aperture_layer: choices.aperture_layer,
        };
        plan.check(file)?;
        Ok(plan)
    }

    fn check(&self, file: &Path) -> Result<(), Fault> {
        if self.masks == Masks::Binary && !self.levels.is_power_of_two() {
            let found = format!("binary masks of {} levels", self.levels);
            return Err(choice_fault(
                file,
                "masks",
                found,
                "2, 4, 8, … levels, or a mask each",
            ));
        }
        let last = u32::from(self.first_layer) + u32::from(self.layers().saturating_sub(1));
        if last >= MOST_LAYERS {
            let found = format!("layers up to {last}");
            return Err(choice_fault(file, "gds_layer", found, "at most 32767"));
        }
        let levels = u32::from(self.first_layer)..=last;
        if let Some(own) = self.aperture_layer
            && (levels.contains(&u32::from(own)) || u32::from(own) >= MOST_LAYERS)
        {
            let expected = format!(
                "a layer below 32768 other than those of levels, {} to {last}",
                self.first_layer
            );
            return Err(choice_fault(
                file,
                "aperture_layer",
                own.to_string(),
                expected,
            ));
        }
        if self.has_own_patterns() && self.levels - 1 > MOST_PATTERNS {
            let found = format!("shapes of {} levels that are drawn wider", self.levels);
            let expected = format!("at most {MOST_PATTERNS} of them");
            return Err(choice_fault(file, "etch_bias_um", found, expected));
        }
        Ok(())
    }

    /// Number of layers.
    pub(crate) fn layers(&self) -> u16 {
        match self.masks {
            Masks::Each => self.levels - 1,
            Masks::Binary => self.levels.ilog2() as u16,
            Masks::Dose => 1,
        }
    }

    /// Whether each level has a pattern of its own, because patterns that grow lie above each other.
    fn has_own_patterns(&self) -> bool {
        self.masks != Masks::Binary && matches!(self.part, DrawnPart::Grown(_))
    }

    /// Number of patterns that are merged into rectangles by themselves: binary masks lie above each other.
    pub(crate) fn patterns(&self) -> u16 {
        match self.masks {
            Masks::Each | Masks::Dose if self.has_own_patterns() => self.levels - 1,
            Masks::Each | Masks::Dose => 1,
            Masks::Binary => self.layers(),
        }
    }

    /// The level that draws nothing.
    pub(crate) fn empty(&self) -> u16 {
        match self.masks {
            Masks::Each | Masks::Dose => 0,
            Masks::Binary => self.levels - 1,
        }
    }

    /// What a cell of a level has in a pattern; 0 where nothing is drawn.
    pub(crate) fn value(&self, pattern: u16, level: u16) -> u16 {
        match self.masks {
            Masks::Each | Masks::Dose if self.has_own_patterns() => {
                level * u16::from(level == pattern + 1)
            }
            Masks::Each | Masks::Dose => level,
            // Mask k = 1, 2, … etches N/2ᵏ steps; a level is that many steps above the lowest.
            Masks::Binary => {
                let etched = self.levels - 1 - level;
                (etched >> (self.layers() - 1 - pattern)) & 1
            }
        }
    }

    /// What a part of a cell has in a pattern, by the levels of the cell and of its neighbours on the side of the part:
    /// along x, along y and across. Gaps between cells are on level 0.
    pub(crate) fn part_value(&self, levels: [u16; 4], pattern: u16, is_core: bool) -> u16 {
        match self.part {
            DrawnPart::Apart(_) => self.value(pattern, self.part.value(levels, is_core)),
            _ => {
                let values = levels.map(|level| self.value(pattern, level));
                self.part.value(values, is_core)
            }
        }
    }

    /// The layer of a value in a pattern.
    pub(crate) fn layer(&self, pattern: u16, value: u16) -> MaskLayer {
        let (layer, data_type) = match self.masks {
            Masks::Each => (self.first_layer + value - 1, 0),
            Masks::Binary => (self.first_layer + pattern, 0),
            Masks::Dose => (self.first_layer, value),
        };
        MaskLayer { layer, data_type }
    }

    /// The tile [nx, ny] that is drawn once and repeated, of the smallest that repeats. What is the same along an axis is
    /// one rectangle instead.
    pub(crate) fn tile(&self, smallest: [usize; 2]) -> [usize; 2] {
        // An etch moves edges by what lies on their other side, which a tile alone does not know.
        if matches!(self.part, DrawnPart::Shrunk(_) | DrawnPart::Grown(_)) {
            return self.size;
        }
        let [px, py] = smallest;
        let [nx, ny] = self.size;
        let tile = [if px == 1 { nx } else { px }, if py == 1 { ny } else { py }];
        let [columns, rows] = self.repeats(tile);
        match columns.max(rows) <= MOST_REPEATS {
            true => tile,
            false => self.size,
        }
    }

    /// How often a tile stands along x and y.
    pub(crate) fn repeats(&self, [px, py]: [usize; 2]) -> [usize; 2] {
        let [nx, ny] = self.size;
        [nx / px.max(1), ny / py.max(1)]
    }

    /// The position in database units of the corner of a cell, from the corner of the first.
    pub(crate) fn place(&self, [x, y]: [usize; 2]) -> [i64; 2] {
        let [dx, dy] = self.pitch;
        [x as i64 * dx, y as i64 * dy]
    }

    /// The position in database units where lines between parts of cells meet, from the corner of the first cell.
    pub(crate) fn meeting(&self, [x, y]: [usize; 2]) -> [i64; 2] {
        let [dx, dy] = self.pitch;
        [self.part.place(x, 0, dx), self.part.place(y, 1, dy)]
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::fabrication::export_choices::{ExportChoices, Masks};
    use crate::file::fabrication::masks::mask_plan::{MaskLayer, MaskPlan};
    use crate::optics::pixels::active_area::ActiveArea;

    fn plan(
        size: [usize; 2],
        pitch_um: [f64; 2],
        levels: u16,
        choices: &ExportChoices,
    ) -> Result<MaskPlan, String> {
        let cells = (pitch_um, ActiveArea::WHOLE);
        let plan = MaskPlan::new(Path::new("a.gds"), size, cells, levels, choices);
        plan.map_err(|fault| fault.to_string())
    }

    #[test]
    fn pitches_are_whole_units() {
        let usual = ExportChoices::default();
        let found = plan([4, 5], [0.3, 1.001], 4, &usual).unwrap();
        assert_eq!((found.pitch, found.corner), ([300, 1001], [-600, -2502]));
        let fault = plan([4, 4], [0.3335, 0.3335], 4, &usual).unwrap_err();
        assert!(fault.contains("--database-unit-nm 0.5"), "{fault}");
        let fault = plan([4, 4], [1.0 / 3.0, 1.0], 4, &usual).unwrap_err();
        assert!(
            fault.contains("pitch_um") && fault.contains("such as 0.333 µm"),
            "{fault}"
        );
        let fine = ExportChoices {
            database_unit_nm: 0.5,
            ..usual
        };
        assert_eq!(plan([4, 4], [0.3335; 2], 4, &fine).unwrap().pitch, [667; 2]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let usual = ExportChoices::default();
        assert!(plan([2_147_483, 1], [1.0; 2], 4, &usual).is_ok());
        let fault = plan([2_147_484, 1], [1.0; 2], 4, &usual).unwrap_err();
        assert!(
            fault.contains("database_unit_nm") && fault.contains("32 bits"),
            "{fault}"
        );
        let binary = ExportChoices {
            masks: Masks::Binary,
            ..usual
        };
        assert!(
            plan([4, 4], [1.0; 2], 6, &binary)
                .unwrap_err()
                .contains("6 levels")
        );
        let high = ExportChoices {
            gds_layer: 32_766,
            ..ExportChoices::default()
        };
        assert!(plan([4, 4], [1.0; 2], 3, &high).is_ok());
        assert!(
            plan([4, 4], [1.0; 2], 4, &high)
                .unwrap_err()
                .contains("32768")
        );
    }

    #[test]
    fn binary_masks_etch_halves_of_the_depth() {
        let binary = ExportChoices {
            masks: Masks::Binary,
            ..ExportChoices::default()
        };
        let plan = plan([4, 4], [1.0; 2], 8, &binary).unwrap();
        for level in 0..8 {
            // Steps that all masks etch: 4, 2 and 1 of the full 8.
            let etched: u16 = (0..3).map(|k| plan.value(k, level) * (4 >> k)).sum();
            assert_eq!(etched, 7 - level);
        }
        let third = MaskLayer {
            layer: 3,
            data_type: 0,
        };
        assert_eq!(plan.layer(2, 1), third);
    }
}
