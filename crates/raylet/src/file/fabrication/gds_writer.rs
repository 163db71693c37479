//! Mask files in the format GDSII, written while rows are read.

use std::collections::BTreeMap;
use std::io::{self, Write};

use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::gds_record::{kind, longs, real, shorts, text, write_record};
use crate::file::fabrication::level_survey::row_levels;
use crate::file::fabrication::levels::Levels;
use crate::file::fabrication::mask_plan::{MaskLayer, MaskPlan};
use crate::file::fabrication::rectangles::{Merging, Rectangle};

/// The version of the format.
const VERSION: u16 = 600;

/// The times that a file states twice: always the same, so that files of equal elements are equal.
const TIMES: [u16; 12] = [2000, 1, 1, 0, 0, 0, 2000, 1, 1, 0, 0, 0];

/// The structure that is repeated.
const TILE: &str = "TILE";

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

/// Writes the mask file of an element; `smallest` is the tile that repeats.
///
/// # Errors
/// A row that cannot be read, or an error of the file system.
pub(crate) fn write_gds(
    out: &mut impl Write,
    cells: &mut Cells,
    levels: &Levels,
    plan: &MaskPlan,
    smallest: [usize; 2],
) -> io::Result<Shapes> {
    let tile = plan.tile(smallest);
    let repeats = plan.repeats(tile);
    let is_tiled = repeats != [1, 1];
    let name = structure_name(&cells.name);

    // The head: version, times, the name of the library, the database unit in µm and in metres.
    write_record(out, kind::HEADER, &shorts(&[VERSION]))?;
    write_record(out, kind::BGNLIB, &shorts(&TIMES))?;
    write_record(out, kind::LIBNAME, &text("RAYLET"))?;
    let units = [real(1e-3 * plan.unit_nm), real(1e-9 * plan.unit_nm)];
    write_record(out, kind::UNITS, &units.concat())?;

    // The shapes: of the whole element, or of one tile.
    let drawn = if is_tiled { TILE } else { name.as_str() };
    let corner = if is_tiled { [0; 2] } else { plan.corner };
    begin(out, drawn)?;
    let mut shapes = Shapes {
        repeats,
        name: name.clone(),
        ..Shapes::default()
    };
    draw(out, cells, levels, (plan, tile, corner), &mut shapes)?;
    write_record(out, kind::ENDSTR, &[])?;

    // The element as an array of tiles.
    if is_tiled {
        begin(out, &name)?;
        repeat(out, plan, tile)?;
        write_record(out, kind::ENDSTR, &[])?;
    }
    write_record(out, kind::ENDLIB, &[])?;
    Ok(shapes)
}

/// The head of a structure.
fn begin(out: &mut impl Write, name: &str) -> io::Result<()> {
    write_record(out, kind::BGNSTR, &shorts(&TIMES))?;
    write_record(out, kind::STRNAME, &text(name))
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
    out: &mut impl Write,
    cells: &mut Cells,
    levels: &Levels,
    (plan, [px, py], corner): (&MaskPlan, [usize; 2], [i64; 2]),
    shapes: &mut Shapes,
) -> io::Result<()> {
    let [nx, _] = cells.size();
    let mut merging: Vec<Merging> = Vec::new();
    merging.resize_with(usize::from(plan.patterns()), Merging::default);
    let (mut values, mut row, mut masked) = (vec![0.0; nx], vec![0; nx], vec![0; px]);
    let mut close = |pattern: u16, rectangle: Rectangle| {
        let layer = plan.layer(pattern, rectangle.value);
        *shapes.rectangles.entry(layer).or_default() += 1;
        let [x0, x1] = rectangle.x;
        let [y0, y1] = rectangle.y;
        boundary(
            out,
            layer,
            corner,
            [plan.place([x0, y0]), plan.place([x1, y1])],
        )
    };
    for y in 0..py {
        cells.read_row(y, &mut values).map_err(io::Error::other)?;
        row_levels(levels, &values, &mut row);
        for (pattern, merging) in (0..).zip(&mut merging) {
            for (to, level) in masked.iter_mut().zip(&row) {
                *to = plan.value(pattern, *level);
            }
            merging.add(&masked, |rectangle| close(pattern, rectangle))?;
        }
    }
    for (pattern, merging) in (0..).zip(merging) {
        merging.finish(|rectangle| close(pattern, rectangle))?;
    }
    Ok(())
}

/// One rectangle: 64 bytes.
fn boundary(
    out: &mut impl Write,
    layer: MaskLayer,
    [x, y]: [i64; 2],
    [[x0, y0], [x1, y1]]: [[i64; 2]; 2],
) -> io::Result<()> {
    // The plan holds all coordinates within 32 bits.
    let [x0, y0, x1, y1] = [x + x0, y + y0, x + x1, y + y1].map(|at| at as i32);
    write_record(out, kind::BOUNDARY, &[])?;
    write_record(out, kind::LAYER, &layer.layer.to_be_bytes())?;
    write_record(out, kind::DATATYPE, &layer.data_type.to_be_bytes())?;
    let mut corners = [0_u8; 40];
    let numbers = [x0, y0, x1, y0, x1, y1, x0, y1, x0, y0];
    for (to, number) in corners.chunks_exact_mut(4).zip(numbers) {
        to.copy_from_slice(&number.to_be_bytes());
    }
    write_record(out, kind::XY, &corners)?;
    write_record(out, kind::ENDEL, &[])
}

/// The array of references to the tile.
fn repeat(out: &mut impl Write, plan: &MaskPlan, tile: [usize; 2]) -> io::Result<()> {
    let [columns, rows] = plan.repeats(tile);
    write_record(out, kind::AREF, &[])?;
    write_record(out, kind::SNAME, &text(TILE))?;
    write_record(out, kind::COLROW, &shorts(&[columns as u16, rows as u16]))?;
    let [x, y] = plan.corner.map(|at| at as i32);
    let [width, height] = plan.place(plan.size).map(|at| at as i32);
    let corners = [x, y, x + width, y, x, y + height];
    write_record(out, kind::XY, &longs(&corners))?;
    write_record(out, kind::ENDEL, &[])
}
