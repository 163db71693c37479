//! Mask files in the format GDSII, read back into the levels of cells.
//!
//! The file is read twice: first for its structures and their bounds, then for its shapes, of which those of the whole element
//! are painted as they come. Only structures that are referred to are in memory.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use crate::file::arrays::memory::MachineMemory;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_choices::{ExportChoices, choice_fault, needed};
use crate::file::fabrication::gds::gds_elements::{
    Element, Records, Reference, Shape, real, trimmed,
};
use crate::file::fabrication::gds::gds_painting::{Meaning, Painting};
use crate::file::fabrication::gds::gds_record::kind;
use crate::file::fabrication::masks::database_units::in_units;
use crate::file::fabrication::masks::drawn_part::DrawnPart;
use crate::optics::pixels::active_area::{ActiveArea, Rest};

/// Deepest references to structures that refer to others.
const DEEPEST: usize = 32;

/// Most references of a file, and most kinds of layers.
const MOST_REFERENCES: usize = 1_000_000;

/// Smallest and largest places: x0, y0, x1, y1.
type Bounds = [i64; 4];

/// The cells of a mask file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadMasks {
    /// Number of cells [nx, ny].
    pub size: [usize; 2],
    /// The levels of all cells, row by row; rows grow with y.
    pub levels: Vec<u16>,
    /// Number of levels.
    pub count: u16,
}

/// A structure: where its elements begin, and what stands in it.
#[derive(Debug, Default)]
struct Structure {
    start: u64,
    bounds: Option<Bounds>,
    references: Vec<Reference>,
}

/// What the first pass finds.
#[derive(Debug, Default)]
struct Library {
    /// Database unit in nm.
    unit_nm: f64,
    structures: Vec<Structure>,
    numbers: BTreeMap<Vec<u8>, usize>,
    /// The largest level, or number of a binary mask.
    largest: u16,
}

/// Reads a mask file.
///
/// # Errors
/// A file that cannot be read or is no GDSII file, shapes that do not follow the grid of the cells, or choices that do not fit.
pub fn read_masks(path: &Path, choices: &ExportChoices) -> Result<ReadMasks, Fault> {
    choices.check(path)?;
    let file = regular_file::open(path)
        .map_err(|found| Fault::of_file(path, found, "a readable mask file"))?;
    let limit = MachineMemory::now().usual_limit();
    read_stream(
        BufReader::with_capacity(1 << 18, file),
        path,
        choices,
        limit,
    )
}

/// [`read_masks`] of a stream; faults name it as `path`. Cells take at most `limit` bytes.
///
/// # Errors
/// As [`read_masks`].
pub(crate) fn read_stream(
    input: impl Read + Seek,
    path: &Path,
    choices: &ExportChoices,
    limit: u64,
) -> Result<ReadMasks, Fault> {
    let broken = |found| broken(path, found);
    let pitch_um = needed(
        path,
        "pitch_um",
        choices.pitch_um,
        "the cells of a mask file (--pitch-um)",
    )?;
    let meaning = Meaning {
        masks: choices.masks,
        first_layer: choices.gds_layer,
        levels: choices.levels.map(|levels| levels as u16),
        aperture_layer: choices.aperture_layer,
    };
    let mut records = Records::new(input);
    let library = Library::read(&mut records, &meaning).map_err(broken)?;
    let top = library.top().map_err(broken)?;

    let grid = library.grid(path, top, (pitch_um, choices))?;
    let [nx, ny] = grid.size;
    let count = (nx as u64).saturating_mul(ny as u64);
    if count.saturating_mul(2) > limit {
        let expected = "cells that fit into memory: half of what is free";
        let found = format!("{nx} x {ny} cells");
        return Err(choice_fault(path, "size", found, expected));
    }
    let mut painting = Painting {
        meaning,
        levels: meaning.count(library.largest),
        pitch: grid.pitch,
        margins: grid.margins,
        corner: grid.corner,
        size: grid.size,
        cells: vec![0; count as usize],
        work: 0,
    };
    let mut sheets = BTreeMap::new();
    library
        .draw(&mut records, top, &mut sheets, &mut painting)
        .map_err(broken)?;
    Ok(ReadMasks {
        size: grid.size,
        count: painting.levels,
        levels: painting.finish(),
    })
}

/// The fault of a file that is not as expected.
fn broken(path: &Path, found: String) -> Fault {
    let expected = "a GDSII file of shapes on the grid of the cells";
    Fault::of_file(path, found, expected)
}

/// Where the cells are, in database units.
struct Grid {
    size: [usize; 2],
    pitch: [i64; 2],
    corner: [i64; 2],
    /// How far drawn edges may lie from those of cells.
    margins: [i64; 2],
}

/// The corner of cells that are centred, as they are written.
fn centred(size: [usize; 2], pitch: [i64; 2]) -> [i64; 2] {
    let mut corner = [0; 2];
    for ((to, count), pitch) in corner.iter_mut().zip(size).zip(pitch) {
        let count = i64::try_from(count).unwrap_or(i64::MAX);
        *to = -(count.saturating_mul(pitch) / 2);
    }
    corner
}

/// The shapes of structures that are referred to.
type Sheets = BTreeMap<usize, Vec<Shape>>;

impl Library {
    /// The cells of a pitch: so many about the origin, or from the first shape to the last.
    fn grid(
        &self,
        path: &Path,
        top: usize,
        (pitch_um, choices): ([f64; 2], &ExportChoices),
    ) -> Result<Grid, Fault> {
        let mut pitch = [0; 2];
        for (to, um) in pitch.iter_mut().zip(pitch_um) {
            *to = in_units(path, "pitch_um", um, self.unit_nm)?;
        }
        let active = ActiveArea::of_fill(choices.fill.unwrap_or(1.0), Rest::Flat);
        let active = active.unwrap_or(ActiveArea::WHOLE);
        let choices = ExportChoices {
            database_unit_nm: self.unit_nm,
            ..choices.clone()
        };
        let margins = DrawnPart::plan(path, pitch, active, &choices)?.margins();
        let size = choices.size;
        if let Some(size) = size {
            let corner = centred(size, pitch);
            return Ok(Grid {
                size,
                pitch,
                corner,
                margins,
            });
        }
        if margins != [0; 2] {
            let purpose = "shapes that are narrower or wider than cells (--size)";
            needed(path, "size", size, purpose)?;
        }
        let bounds = self.bounds(top, 0).map_err(|found| broken(path, found))?;
        let Some([x0, y0, x1, y1]) = bounds else {
            let found = String::from("no shape on the layers of levels");
            return Err(broken(path, found));
        };
        Ok(Grid {
            size: [(x1 - x0) / pitch[0], (y1 - y0) / pitch[1]].map(|n| n.max(1) as usize),
            pitch,
            corner: [x0, y0],
            margins,
        })
    }

    /// The first pass.
    fn read<R: Read + Seek>(records: &mut Records<R>, meaning: &Meaning) -> Result<Self, String> {
        let mut library = Self::default();
        let mut references = 0;
        let (first, _) = records.next()?;
        if first != kind::HEADER {
            return Err(String::from("a file without the header of a GDSII file"));
        }
        loop {
            let (kind, data) = records.next()?;
            match kind {
                kind::UNITS => {
                    let metres = data.get(8..).map_or(0.0, real);
                    library.unit_nm = 1e9 * metres;
                }
                kind::STRNAME => {
                    let name = trimmed(data).to_vec();
                    let mut structure = Structure {
                        start: records.at,
                        ..Structure::default()
                    };
                    library.largest = structure.read(records, meaning)?.max(library.largest);
                    references += structure.references.len();
                    if references > MOST_REFERENCES {
                        return Err(format!("more than {MOST_REFERENCES} references"));
                    }
                    let number = library.structures.len();
                    if library.numbers.insert(name, number).is_some() {
                        return Err(String::from("two structures of one name"));
                    }
                    library.structures.push(structure);
                }
                kind::ENDLIB => break,
                _ => {}
            }
        }
        match (1e-6..=1e6).contains(&library.unit_nm) {
            true => Ok(library),
            false => Err(format!("a database unit of {} nm", library.unit_nm)),
        }
    }

    /// The structure to which no other refers.
    fn top(&self) -> Result<usize, String> {
        let references = self.structures.iter().flat_map(|one| &one.references);
        let referred: Vec<usize> = references.filter_map(|one| self.number(one).ok()).collect();
        let mut is_top = vec![true; self.structures.len()];
        for number in referred {
            if let Some(top) = is_top.get_mut(number) {
                *top = false;
            }
        }
        let mut tops = (0..).zip(&is_top).filter(|(_, top)| **top);
        match (tops.next(), tops.next()) {
            (Some((top, _)), None) => Ok(top),
            (None, _) => Err(String::from("no structure that holds the others")),
            _ => Err(String::from("several structures that no other refers to")),
        }
    }

    /// The structure of a reference.
    fn number(&self, reference: &Reference) -> Result<usize, String> {
        let number = self.numbers.get(&reference.name).copied();
        number.ok_or_else(|| {
            let name = String::from_utf8_lossy(&reference.name);
            let name: String = name.chars().take(40).collect();
            format!("a reference to `{name}`, which is not there")
        })
    }

    /// The bounds of a structure with all that it refers to.
    fn bounds(&self, number: usize, depth: usize) -> Result<Option<Bounds>, String> {
        let mut known = BTreeMap::new();
        self.bounds_of(number, depth, &mut known)
    }

    fn bounds_of(
        &self,
        number: usize,
        depth: usize,
        known: &mut BTreeMap<usize, Option<Bounds>>,
    ) -> Result<Option<Bounds>, String> {
        if let Some(bounds) = known.get(&number) {
            return Ok(*bounds);
        }
        check_depth(depth)?;
        let Some(structure) = self.structures.get(number) else {
            return Ok(None);
        };
        let mut all = structure.bounds;
        for reference in &structure.references {
            let inner = self.bounds_of(self.number(reference)?, depth + 1, known)?;
            let Some([x0, y0, x1, y1]) = inner else {
                continue;
            };
            let [x, y] = reference.origin;
            let spread = |count: i64, step: i64| {
                let last = (count - 1).saturating_mul(step);
                [last.min(0), last.max(0)]
            };
            let [left, right] = spread(reference.counts[0], reference.steps[0]);
            let [down, up] = spread(reference.counts[1], reference.steps[1]);
            let placed = [x0 + x + left, y0 + y + down, x1 + x + right, y1 + y + up];
            all = joined(all, placed);
        }
        known.insert(number, all);
        Ok(all)
    }

    /// Paints a structure; those that it refers to are read once and kept.
    fn draw<R: Read + Seek>(
        &self,
        records: &mut Records<R>,
        top: usize,
        sheets: &mut Sheets,
        painting: &mut Painting,
    ) -> Result<(), String> {
        let Some(structure) = self.structures.get(top) else {
            return Ok(());
        };
        records.seek(structure.start)?;
        loop {
            match records.element()? {
                Element::Shape(shape) => painting.paint(&shape, [0; 2])?,
                Element::End => break,
                _ => {}
            }
        }
        for reference in &structure.references {
            self.place(records, reference, ([0; 2], 1), sheets, painting)?;
        }
        Ok(())
    }

    /// Paints what a reference refers to, wherever it stands.
    fn place<R: Read + Seek>(
        &self,
        records: &mut Records<R>,
        reference: &Reference,
        (offset, depth): ([i64; 2], usize),
        sheets: &mut Sheets,
        painting: &mut Painting,
    ) -> Result<(), String> {
        check_depth(depth)?;
        let number = self.number(reference)?;
        let Some(structure) = self.structures.get(number) else {
            return Ok(());
        };
        if let Entry::Vacant(sheet) = sheets.entry(number) {
            sheet.insert(structure.shapes(records, &painting.meaning)?);
        }
        let ([columns, rows], [dx, dy]) = (reference.counts, reference.steps);
        for row in 0..rows {
            for column in 0..columns {
                painting.spend(1)?;
                let [x, y] = reference.origin;
                let at = [offset[0] + x + column * dx, offset[1] + y + row * dy];
                for shape in sheets.get(&number).into_iter().flatten() {
                    painting.paint(shape, at)?;
                }
                for inner in &structure.references {
                    self.place(records, inner, (at, depth + 1), sheets, painting)?;
                }
            }
        }
        Ok(())
    }
}

impl Structure {
    /// Reads the elements for their bounds; returns the largest level.
    fn read<R: Read + Seek>(
        &mut self,
        records: &mut Records<R>,
        meaning: &Meaning,
    ) -> Result<u16, String> {
        let mut largest = 0;
        loop {
            match records.element()? {
                Element::Shape(shape) => {
                    let Some(value) = meaning.of(&shape) else {
                        continue;
                    };
                    largest = value.max(largest);
                    for [x, y] in shape.corners {
                        let [x, y] = [x, y].map(i64::from);
                        self.bounds = joined(self.bounds, [x, y, x, y]);
                    }
                }
                Element::Reference(reference) => {
                    self.references.push(reference);
                    if self.references.len() > MOST_REFERENCES {
                        return Err(format!("more than {MOST_REFERENCES} references"));
                    }
                }
                Element::Other => {}
                Element::End => return Ok(largest),
            }
        }
    }

    /// The shapes on layers of levels.
    fn shapes<R: Read + Seek>(
        &self,
        records: &mut Records<R>,
        meaning: &Meaning,
    ) -> Result<Vec<Shape>, String> {
        records.seek(self.start)?;
        let mut shapes = Vec::new();
        loop {
            match records.element()? {
                Element::Shape(shape) if meaning.of(&shape).is_some() => shapes.push(shape),
                Element::End => return Ok(shapes),
                _ => {}
            }
        }
    }
}

/// Bounds of what was there and of something new.
fn joined(all: Option<Bounds>, [x0, y0, x1, y1]: Bounds) -> Option<Bounds> {
    let [a0, b0, a1, b1] = all.unwrap_or([x0, y0, x1, y1]);
    Some([a0.min(x0), b0.min(y0), a1.max(x1), b1.max(y1)])
}

/// Refuses structures that refer to themselves, or nearly without end.
fn check_depth(depth: usize) -> Result<(), String> {
    match depth <= DEEPEST {
        true => Ok(()),
        false => Err(format!("references more than {DEEPEST} deep")),
    }
}
