//! The cells of an array, or those of a mask file that is read.

use std::f64::consts::TAU;
use std::path::Path;

use crate::file::arrays::array::BorrowedArray;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::{
    BorrowedRows, CellRows, Cells, LevelRows, Part, part_of,
};
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, needed};
use crate::file::fabrication::gds::gds_reader::read_masks;
use crate::file::fabrication::npy_rows::npy_rows;

/// The cells of an array file or of an array in memory.
///
/// # Errors
/// No pitch, or an array that cannot be read.
pub(crate) fn array_cells<'a>(
    file: &Path,
    array: Option<BorrowedArray<'a>>,
    choices: &ExportChoices,
) -> Result<Cells<'a>, Fault> {
    let quantity = choices.quantity;
    let pitch_um = needed(
        file,
        "pitch_um",
        choices.pitch_um,
        "the cells of an array (--pitch-um)",
    )?;
    // Complex numbers are taken apart; real ones need no part.
    let part = match quantity {
        Quantity::Amplitude => Part::Amplitude,
        _ => Part::Phase,
    };
    let (rows, is_complex): (Box<dyn CellRows + 'a>, bool) = match array {
        Some(array) => {
            if array.shape().contains(&0) {
                return Err(Fault::of_file(file, "an empty array", "at least one cell"));
            }
            let is_complex = matches!(array, BorrowedArray::Complex(_));
            let scale = 1.0;
            (Box::new(BorrowedRows { array, part, scale }), is_complex)
        }
        None => {
            let read = npy_rows(file, Some(("phase", None)), part, 1.0)?;
            (read.rows, read.is_complex)
        }
    };
    let mut losses = Vec::new();
    if is_complex {
        part_of(file, quantity)?;
        let lost = match quantity {
            Quantity::Amplitude => "the phase of the array",
            _ => "the amplitude of the array",
        };
        losses.push(String::from(lost));
    }
    Ok(Cells {
        quantity,
        losses,
        ..Cells::new(rows, pitch_um, file)
    })
}

/// The cells of a mask file: phases, heights or amplitudes of its levels, or their numbers.
///
/// # Errors
/// A file that cannot be read, or heights without a depth.
pub(crate) fn mask_cells(file: &Path, choices: &ExportChoices) -> Result<Cells<'static>, Fault> {
    let read = read_masks(file, choices)?;
    let count = f64::from(read.count);
    let step = match choices.quantity {
        Quantity::Level => 1.0,
        Quantity::Phase => TAU / count,
        Quantity::Amplitude => 1.0 / (count - 1.0),
        Quantity::Height => {
            let purpose = "the heights of levels (--depth-um)";
            needed(file, "depth_um", choices.depth_um, purpose)? / count
        }
    };
    let rows = LevelRows {
        size: read.size,
        levels: read.levels,
        step,
    };
    let pitch_um = choices.pitch_um.unwrap_or([1.0; 2]);
    Ok(Cells {
        quantity: choices.quantity,
        ..Cells::new(Box::new(rows), pitch_um, file)
    })
}
