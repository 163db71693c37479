//! Values of cells as numbers: a NumPy array, a table of comma-separated values, and the grid files of Zemax OpticStudio.

use std::io::{self, Write};

use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::Quantity;
use crate::file::fabrication::made_values::MadeValues;

/// Fewest points of a Zemax grid along an axis.
pub(crate) const FEWEST_POINTS: usize = 5;

/// A NumPy array of float64 [y, x].
///
/// # Errors
/// A row that cannot be read, or an error of the file system.
pub(crate) fn write_npy(
    out: &mut impl Write,
    cells: &mut Cells,
    made: &MadeValues,
) -> io::Result<()> {
    let [nx, ny] = cells.size();
    let mut head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({ny}, {nx}), }}");
    // Ten bytes stand before; data begin at a multiple of 64.
    let length = (head.len() + 11).next_multiple_of(64) - 10;
    while head.len() + 1 < length {
        head.push(' ');
    }
    head.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    out.write_all(head.as_bytes())?;
    let mut values = vec![0.0; nx];
    for y in 0..ny {
        made.row(cells, y, &mut values)?;
        for value in &values {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(())
}

/// The place of the centre of a cell in mm.
fn centre(i: usize, count: usize, pitch_um: f64) -> f64 {
    (i as f64 - 0.5 * (count.saturating_sub(1)) as f64) * pitch_um * 1e-3
}

/// A table: x in mm in the first line, y in mm in the first column, which grows downwards.
///
/// # Errors
/// A row that cannot be read, or an error of the file system.
pub(crate) fn write_csv(
    out: &mut impl Write,
    cells: &mut Cells,
    made: &MadeValues,
) -> io::Result<()> {
    let [nx, ny] = cells.size();
    let [dx, dy] = cells.pitch_um;
    write!(out, "{}; y_mm \\ x_mm", made.quantity.with_unit())?;
    for x in 0..nx {
        write!(out, ",{}", centre(x, nx, dx))?;
    }
    writeln!(out)?;
    let mut values = vec![0.0; nx];
    for y in 0..ny {
        made.row(cells, y, &mut values)?;
        write!(out, "{}", centre(y, ny, dy))?;
        for value in &values {
            write!(out, ",{value}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A file of Grid Phase (rad) or Grid Sag (mm): the size, the steps in mm, and a point a line from −x and +y. Derivatives are
/// zero throughout, so that OpticStudio takes differences.
///
/// # Errors
/// A row that cannot be read, or an error of the file system.
pub(crate) fn write_dat(
    out: &mut impl Write,
    cells: &mut Cells,
    made: &MadeValues,
) -> io::Result<()> {
    let [nx, ny] = cells.size();
    let [dx, dy] = cells.pitch_um.map(|um| um * 1e-3);
    let scale = match made.quantity {
        Quantity::Height => 1e-3,
        _ => 1.0,
    };
    writeln!(out, "{nx} {ny} {dx} {dy} 0 0 0")?;
    let mut values = vec![0.0; nx];
    for y in (0..ny).rev() {
        made.row(cells, y, &mut values)?;
        for value in &values {
            writeln!(out, "{} 0 0 0 0", scale * value)?;
        }
    }
    Ok(())
}
