//! What a mask file holds, whatever its format: structures of rectangles and polygons, and arrays of a structure. They are
//! handed on while rows are read.

use std::collections::BTreeMap;
use std::io;

use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::level_survey::row_levels;
use crate::file::fabrication::levels::Levels;
use crate::file::fabrication::masks::mask_plan::{MaskLayer, MaskPlan};
use crate::file::fabrication::masks::outline::Outlines;
use crate::file::fabrication::masks::rectangles::{Merging, Rectangle};

/// The structure that is repeated.
pub(crate) const TILE: &str = "TILE";

/// Most characters of the name of a structure.
const LONGEST_NAME: usize = 32;

/// Shapes of a file, by their layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shapes {
    /// Rectangles in the file.
    pub rectangles: BTreeMap<MaskLayer, u64>,
    /// How often each of them stands.
    pub repeats: [usize; 2],
    /// The structure of the whole element.
    pub name: String,
}

impl Shapes {
    /// All rectangles in the file.
    pub(crate) fn count(&self) -> u64 {
        self.rectangles.values().sum()
    }
}

/// An array of the structure [`TILE`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileArray {
    /// Where the first stands, in database units.
    pub corner: [i64; 2],
    /// How many stand along x and y.
    pub counts: [usize; 2],
    /// From one to the next along x and y.
    pub steps: [i64; 2],
}

/// A file of one format. All places are in database units within 32 bits.
pub(crate) trait MaskFile {
    /// Begins a structure, which ends where the next one begins.
    ///
    /// # Errors
    /// An error of the file system, as everywhere here.
    fn structure(&mut self, name: &str) -> io::Result<()>;

    /// A rectangle from a corner to the one across.
    ///
    /// # Errors
    /// An error of the file system.
    fn rectangle(&mut self, layer: MaskLayer, corners: [[i64; 2]; 2]) -> io::Result<()>;

    /// A polygon of at least three corners.
    ///
    /// # Errors
    /// An error of the file system.
    fn polygon(&mut self, layer: MaskLayer, corners: &[[i64; 2]]) -> io::Result<()>;

    /// An array of the structure [`TILE`], which stands before.
    ///
    /// # Errors
    /// An error of the file system.
    fn array(&mut self, array: TileArray) -> io::Result<()>;

    /// Ends the file.
    ///
    /// # Errors
    /// An error of the file system.
    fn end(&mut self) -> io::Result<()>;
}

/// Writes the masks of an element; `smallest` is the tile that repeats.
///
/// # Errors
/// A row that cannot be read, or an error of the file system.
pub(crate) fn write_masks(
    file: &mut impl MaskFile,
    cells: &mut Cells,
    levels: &Levels,
    plan: &MaskPlan,
    (smallest, outlines): ([usize; 2], &Outlines),
) -> io::Result<Shapes> {
    let tile = plan.tile(smallest);
    let counts = plan.repeats(tile);
    let is_tiled = counts != [1, 1];
    let name = structure_name(&cells.name);
    let mut shapes = Shapes {
        repeats: counts,
        name: name.clone(),
        ..Shapes::default()
    };

    // The shapes: of the whole element, or of one tile with the element as an array of it.
    let drawn = if is_tiled { TILE } else { name.as_str() };
    let corner = if is_tiled { [0; 2] } else { plan.corner };
    file.structure(drawn)?;
    draw(file, cells, levels, (plan, tile, corner), &mut shapes)?;
    if is_tiled {
        file.structure(&name)?;
        let (corner, steps) = (plan.corner, plan.place(tile));
        file.array(TileArray {
            corner,
            counts,
            steps,
        })?;
    }

    // The outline of the aperture, as the element is seen.
    if let Some(layer) = plan.aperture_layer {
        for outline in &outlines.polygons {
            let data_type = outline.depth;
            let turn = if cells.mirror { -1 } else { 1 };
            let corners = outline.corners.iter().map(|[x, y]| [turn * x, *y]);
            let corners: Vec<[i64; 2]> = corners.collect();
            file.polygon(MaskLayer { layer, data_type }, &corners)?;
        }
    }
    file.end()?;
    Ok(shapes)
}

/// A name with the characters that every reader takes, and other than that of the tile.
fn structure_name(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '_' {
            c
        } else {
            '_'
        }
    };
    let name: String = name.chars().map(plain).take(LONGEST_NAME).collect();
    match name.as_str() {
        "" | TILE => String::from("ELEMENT"),
        _ => name,
    }
}

/// The rectangles of a tile whose corner stands at a place.
fn draw(
    file: &mut impl MaskFile,
    cells: &mut Cells,
    levels: &Levels,
    (plan, tile, corner): (&MaskPlan, [usize; 2], [i64; 2]),
    shapes: &mut Shapes,
) -> io::Result<()> {
    let mut merging: Vec<Merging> = Vec::new();
    merging.resize_with(usize::from(plan.patterns()), Merging::default);
    let mut close = |pattern: u16, rectangle: Rectangle| {
        let layer = plan.layer(pattern, rectangle.value);
        *shapes.rectangles.entry(layer).or_default() += 1;
        let [x0, x1] = rectangle.x;
        let [y0, y1] = rectangle.y;
        let placed = |[x, y]: [i64; 2]| [corner[0] + x, corner[1] + y];
        let corners = [[x0, y0], [x1, y1]].map(|at| placed(plan.meeting(at)));
        file.rectangle(layer, corners)
    };
    let mut strip = Vec::new();
    let mut rows = FramedRows::new(plan, cells.size(), tile);
    while rows.advance(cells, levels)? {
        for (pattern, merging) in (0..).zip(&mut merging) {
            for part in 0..plan.part.divisions() {
                rows.strip((plan, pattern), part, &mut strip);
                merging.add(&strip, |rectangle| close(pattern, rectangle))?;
            }
        }
    }
    for (pattern, merging) in (0..).zip(merging) {
        merging.finish(|rectangle| close(pattern, rectangle))?;
    }
    Ok(())
}

/// The levels of three rows of a tile, with empty cells around it.
struct FramedRows {
    /// Below, in the middle, above.
    rows: [Vec<u16>; 3],
    /// Cells of the tile, and empty cells on each side that are drawn as well.
    tile: [usize; 2],
    frame: usize,
    /// The level of empty cells.
    empty: u16,
    /// The next row that comes into the middle, counted from the first of the frame.
    next: usize,
    values: Vec<f64>,
    levels: Vec<u16>,
}

impl FramedRows {
    fn new(plan: &MaskPlan, [nx, _]: [usize; 2], tile: [usize; 2]) -> Self {
        let frame = plan.part.frame();
        // One more cell on each side, which only decides on its neighbours.
        let blank = vec![plan.empty(); tile[0] + 2 * frame + 2];
        Self {
            rows: [blank.clone(), blank.clone(), blank],
            tile,
            frame,
            empty: plan.empty(),
            next: 0,
            values: vec![0.0; nx],
            levels: vec![0; nx],
        }
    }

    /// Brings the next row into the middle; false where there is none.
    fn advance(&mut self, cells: &mut Cells, levels: &Levels) -> io::Result<bool> {
        if self.next == 0 {
            self.fetch(0, cells, levels)?;
        }
        if self.next == self.tile[1] + 2 * self.frame {
            return Ok(false);
        }
        self.next += 1;
        self.fetch(self.next, cells, levels)?;
        Ok(true)
    }

    /// Moves rows down by one, and reads the one above: row `y` from the first of the frame.
    fn fetch(&mut self, y: usize, cells: &mut Cells, levels: &Levels) -> io::Result<()> {
        self.rows.rotate_left(1);
        let [_, _, above] = &mut self.rows;
        let own = y.checked_sub(self.frame).filter(|y| *y < self.tile[1]);
        let Some(y) = own else {
            above.fill(self.empty);
            return Ok(());
        };
        cells
            .read_row(y, &mut self.values)
            .map_err(io::Error::other)?;
        row_levels(levels, &self.values, &mut self.levels);
        let inner = above.iter_mut().skip(self.frame + 1).take(self.tile[0]);
        inner.zip(&self.levels).for_each(|(to, from)| *to = *from);
        Ok(())
    }

    /// What a pattern has in a strip of the middle row: its only one, or its lower, middle or upper part.
    fn strip(&self, (plan, pattern): (&MaskPlan, u16), part: usize, strip: &mut Vec<u16>) {
        let [below, row, above] = &self.rows;
        let value = |level: u16| plan.value(pattern, level);
        strip.clear();
        if plan.part.divisions() == 1 {
            let inner = row.iter().skip(1).take(row.len().saturating_sub(2));
            strip.extend(inner.map(|level| value(*level)));
            return;
        }
        let beside = match part {
            0 => below,
            1 => row,
            _ => above,
        };
        for (own, up) in row.windows(3).zip(beside.windows(3)) {
            let ([l, c, r], [ul, uc, ur]) = (own, up) else {
                continue;
            };
            for (i, (along, across)) in [(l, ul), (c, uc), (r, ur)].into_iter().enumerate() {
                let is_core = part == 1 && i == 1;
                strip.push(plan.part_value([*c, *along, *uc, *across], pattern, is_core));
            }
        }
    }
}
