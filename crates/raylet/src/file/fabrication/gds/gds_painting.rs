//! Polygons of a mask file as levels of cells: each must follow the grid.

use crate::file::fabrication::export_choices::Masks;
use crate::file::fabrication::gds::gds_elements::Shape;

/// Cells may be painted so many times on each mask before a file is refused.
const MOST_PAINTS: u64 = 4;

/// The same where cells are drawn in parts.
const MOST_PARTS: u64 = 16;

/// What is small enough to be done in any case.
const FREE: u64 = 10_000_000;

/// How levels lie on layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meaning {
    /// How levels became layers.
    pub masks: Masks,
    /// Number of the first layer.
    pub first_layer: u16,
    /// Number of levels, if it is known.
    pub levels: Option<u16>,
    /// The layer of the outline of an aperture, which stands for no level.
    pub aperture_layer: Option<u16>,
}

impl Meaning {
    /// What a layer and data type stand for: a level, or the number of a binary mask from 1; nothing where no level is.
    pub(crate) fn of(&self, shape: &Shape) -> Option<u16> {
        if self.aperture_layer == Some(shape.layer) {
            return None;
        }
        let above = || shape.layer.checked_sub(self.first_layer)?.checked_add(1);
        let found = match self.masks {
            Masks::Each => above()?,
            Masks::Binary => above()?,
            Masks::Dose if shape.layer == self.first_layer => shape.data_type,
            Masks::Dose => return None,
        };
        let most = match (self.masks, self.levels) {
            (Masks::Binary, Some(levels)) => levels.ilog2() as u16,
            (Masks::Binary, None) => 14,
            (_, Some(levels)) => levels - 1,
            (_, None) => 32_766,
        };
        (1..=most).contains(&found).then_some(found)
    }

    /// Number of levels where this is the largest that shapes stand for.
    pub(crate) fn count(&self, largest: u16) -> u16 {
        self.levels.unwrap_or(match self.masks {
            Masks::Binary => 1 << largest.clamp(1, 14),
            Masks::Each | Masks::Dose => largest.max(1) + 1,
        })
    }
}

/// The cells that are painted.
pub(crate) struct Painting {
    /// How levels lie on layers.
    pub meaning: Meaning,
    /// Number of levels.
    pub levels: u16,
    /// Width of a cell in database units.
    pub pitch: [i64; 2],
    /// How far a corner may lie from that of a cell along x and y.
    pub margins: [i64; 2],
    /// The corner of the smallest x and y.
    pub corner: [i64; 2],
    /// Number of cells [nx, ny].
    pub size: [usize; 2],
    /// Levels, or steps that are etched, row by row.
    pub cells: Vec<u16>,
    /// What has been done.
    pub work: u64,
}

impl Painting {
    /// Counts work, and refuses a file that makes too much of it.
    ///
    /// # Errors
    /// More work than cells explain, in words.
    pub(crate) fn spend(&mut self, work: u64) -> Result<(), String> {
        self.work = self.work.saturating_add(work);
        let masks = match self.meaning.masks {
            Masks::Binary => u64::from(self.levels.ilog2()),
            Masks::Each | Masks::Dose => 1,
        };
        let each = if self.margins == [0; 2] {
            MOST_PAINTS
        } else {
            MOST_PARTS
        };
        let paints = (self.cells.len() as u64).saturating_mul(masks * each);
        let most = paints.saturating_add(FREE);
        match self.work <= most {
            true => Ok(()),
            false => Err(String::from("shapes that lie above each other many times")),
        }
    }

    /// Paints a polygon that is shifted by an offset. Parts of cells between their nearest corners vanish.
    ///
    /// # Errors
    /// A corner off the grid or outside of it, a slanted side, or two levels in one cell, in words.
    pub(crate) fn paint(&mut self, shape: &Shape, offset: [i64; 2]) -> Result<(), String> {
        let Some(value) = self.meaning.of(shape) else {
            return Ok(());
        };
        let mut corners = Vec::with_capacity(shape.corners.len());
        for corner in &shape.corners {
            corners.push(self.cell(*corner, offset)?);
        }
        let next = corners.iter().cycle().skip(1);
        let mut sides = Vec::new();
        for ([x0, y0], [x1, y1]) in corners.iter().zip(next) {
            match (x0 == x1, y0 == y1) {
                (true, false) => sides.push((*y0.min(y1), *y0.max(y1), *x0)),
                (false, false) => return Err(String::from("a slanted side of a shape")),
                _ => {}
            }
        }
        let low = sides.iter().map(|side| side.0).min().unwrap_or(0);
        let high = sides.iter().map(|side| side.1).max().unwrap_or(0);
        self.spend(1 + ((high - low) as u64).saturating_mul(sides.len() as u64))?;

        // Between the sides that a row crosses, in pairs, lies the inside.
        let mut crossed = Vec::new();
        for y in low..high {
            crossed.clear();
            let cross = sides.iter().filter(|side| (side.0..side.1).contains(&y));
            crossed.extend(cross.map(|side| side.2));
            crossed.sort_unstable();
            for [from, to] in crossed.as_chunks().0 {
                self.fill(y, *from, *to, value)?;
            }
        }
        Ok(())
    }

    /// The corner of cells at which a corner of a shape lies.
    fn cell(&self, corner: [i32; 2], offset: [i64; 2]) -> Result<[usize; 2], String> {
        let [nx, ny] = self.size;
        let [x, y] = corner.map(i64::from);
        let [x, y] = [x + offset[0], y + offset[1]];
        let mut at = [0; 2];
        let axes = self.pitch.into_iter().zip(self.margins);
        let ways = [x, y].into_iter().zip(self.corner).zip(axes);
        for ((to, count), ((place, first), (pitch, margin))) in
            at.iter_mut().zip([nx, ny]).zip(ways)
        {
            // The nearest corner of a cell, which is the same where shapes are narrower or wider than cells.
            let way = place - first + pitch / 2;
            let (nearest, off) = (way.div_euclid(pitch), way.rem_euclid(pitch) - pitch / 2);
            let cell = usize::try_from(nearest).ok();
            let inside = cell.filter(|cell| off.abs() <= margin && *cell <= count);
            *to = inside.ok_or_else(|| {
                format!("a corner at ({x}, {y}) database units, off the grid of the cells")
            })?;
        }
        Ok(at)
    }

    /// Fills cells of a row.
    fn fill(&mut self, y: usize, from: usize, to: usize, value: u16) -> Result<(), String> {
        self.spend((to - from) as u64)?;
        let is_binary = self.meaning.masks == Masks::Binary;
        let masks = self.levels.ilog2() as u16;
        let etched = 1_u16 << masks.saturating_sub(value).min(15);
        let start = y * self.size[0];
        let cells = self.cells.get_mut(start + from..start + to);
        for (x, cell) in (from..).zip(cells.into_iter().flatten()) {
            if is_binary {
                *cell |= etched;
            } else if *cell == 0 || *cell == value {
                *cell = value;
            } else {
                return Err(format!("levels {cell} and {value} in the cell [{y}, {x}]"));
            }
        }
        Ok(())
    }

    /// The levels of all cells, row by row.
    pub(crate) fn finish(mut self) -> Vec<u16> {
        if self.meaning.masks == Masks::Binary {
            let highest = self.levels - 1;
            let cells = self.cells.iter_mut();
            cells.for_each(|etched| *etched = highest.saturating_sub(*etched));
        }
        self.cells
    }
}
