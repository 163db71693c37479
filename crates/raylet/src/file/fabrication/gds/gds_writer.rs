//! Mask files in the format GDSII.

use std::io::{self, Write};

use crate::file::fabrication::gds::gds_record::{kind, longs, real, shorts, text, write_record};
use crate::file::fabrication::masks::mask_file::{MaskFile, TILE, TileArray};
use crate::file::fabrication::masks::mask_plan::MaskLayer;

/// The version of the format.
const VERSION: u16 = 600;

/// The times that a file states twice: always the same, so that files of equal elements are equal.
const TIMES: [u16; 12] = [2000, 1, 1, 0, 0, 0, 2000, 1, 1, 0, 0, 0];

/// A file that is written.
pub(crate) struct GdsFile<W> {
    out: W,
    is_open: bool,
}

impl<W: Write> GdsFile<W> {
    /// Writes the head of a file: version, times, the name of the library, the database unit in µm and in metres.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn new(mut out: W, unit_nm: f64) -> io::Result<Self> {
        write_record(&mut out, kind::HEADER, &shorts(&[VERSION]))?;
        write_record(&mut out, kind::BGNLIB, &shorts(&TIMES))?;
        write_record(&mut out, kind::LIBNAME, &text("RAYLET"))?;
        let units = [real(1e-3 * unit_nm), real(1e-9 * unit_nm)];
        write_record(&mut out, kind::UNITS, &units.concat())?;
        let is_open = false;
        Ok(Self { out, is_open })
    }

    fn close(&mut self) -> io::Result<()> {
        match std::mem::take(&mut self.is_open) {
            true => write_record(&mut self.out, kind::ENDSTR, &[]),
            false => Ok(()),
        }
    }

    /// A polygon, whose first corner stands in the file again after the last.
    fn boundary(&mut self, layer: MaskLayer, corners: &[u8]) -> io::Result<()> {
        write_record(&mut self.out, kind::BOUNDARY, &[])?;
        write_record(&mut self.out, kind::LAYER, &layer.layer.to_be_bytes())?;
        write_record(
            &mut self.out,
            kind::DATATYPE,
            &layer.data_type.to_be_bytes(),
        )?;
        write_record(&mut self.out, kind::XY, corners)?;
        write_record(&mut self.out, kind::ENDEL, &[])
    }
}

impl<W: Write> MaskFile for GdsFile<W> {
    fn structure(&mut self, name: &str) -> io::Result<()> {
        self.close()?;
        self.is_open = true;
        write_record(&mut self.out, kind::BGNSTR, &shorts(&TIMES))?;
        write_record(&mut self.out, kind::STRNAME, &text(name))
    }

    /// 64 bytes.
    fn rectangle(&mut self, layer: MaskLayer, [low, high]: [[i64; 2]; 2]) -> io::Result<()> {
        // The plan holds all coordinates within 32 bits.
        let ([x0, y0], [x1, y1]) = (low.map(|at| at as i32), high.map(|at| at as i32));
        let mut corners = [0_u8; 40];
        let numbers = [x0, y0, x1, y0, x1, y1, x0, y1, x0, y0];
        for (to, number) in corners.chunks_exact_mut(4).zip(numbers) {
            to.copy_from_slice(&number.to_be_bytes());
        }
        self.boundary(layer, &corners)
    }

    fn polygon(&mut self, layer: MaskLayer, corners: &[[i64; 2]]) -> io::Result<()> {
        let all = corners.iter().chain(corners.first()).flatten();
        let numbers: Vec<i32> = all.map(|at| *at as i32).collect();
        self.boundary(layer, &longs(&numbers))
    }

    fn array(&mut self, array: TileArray) -> io::Result<()> {
        let [columns, rows] = array.counts;
        let out = &mut self.out;
        write_record(out, kind::AREF, &[])?;
        write_record(out, kind::SNAME, &text(TILE))?;
        write_record(out, kind::COLROW, &shorts(&[columns as u16, rows as u16]))?;
        let [x, y] = array.corner.map(|at| at as i32);
        let [dx, dy] = array.steps;
        let [width, height] = [columns as i64 * dx, rows as i64 * dy].map(|at| at as i32);
        let corners = [x, y, x + width, y, x, y + height];
        write_record(out, kind::XY, &longs(&corners))?;
        write_record(out, kind::ENDEL, &[])
    }

    fn end(&mut self) -> io::Result<()> {
        self.close()?;
        write_record(&mut self.out, kind::ENDLIB, &[])
    }
}
