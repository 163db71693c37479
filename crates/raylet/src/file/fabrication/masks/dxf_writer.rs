//! Mask files in the format DXF of AutoCAD release 12: a filled quadrangle (SOLID) for each rectangle, a closed POLYLINE for
//! each polygon, an INSERT with columns and rows for an array.
//!
//! raylet writes the text itself, because the crate `dxf` holds a whole drawing.

use std::io::{self, Write};

use crate::file::fabrication::export_choices::Masks;
use crate::file::fabrication::masks::mask_file::{MaskFile, TILE, TileArray};
use crate::file::fabrication::masks::mask_plan::{MaskLayer, MaskPlan};

/// A file that is written.
pub(crate) struct DxfFile<W> {
    out: W,
    unit_nm: f64,
    masks: Masks,
    first_layer: u16,
    aperture_layer: Option<u16>,
    /// What ends the section that is open.
    closing: &'static str,
}

impl<W: Write> DxfFile<W> {
    /// Writes the head of a file: the release, and that lengths are in µm.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn new(mut out: W, plan: &MaskPlan) -> io::Result<Self> {
        out.write_all(b"999\nraylet\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n")?;
        out.write_all(b"9\n$INSUNITS\n70\n13\n0\nENDSEC\n")?;
        Ok(Self {
            out,
            unit_nm: plan.unit_nm,
            masks: plan.masks,
            first_layer: plan.first_layer,
            aperture_layer: plan.aperture_layer,
            closing: "",
        })
    }

    /// A place in µm, without the noise of its last digits.
    fn um(&self, units: i64) -> f64 {
        let um = units as f64 * self.unit_nm * 1e-3;
        (um * 1e9).round() / 1e9
    }

    /// The name of a layer: the level, the number of a binary mask, or that of the aperture with its depth.
    fn name(&self, layer: MaskLayer) -> String {
        let number = layer.layer;
        match (self.aperture_layer == Some(number), self.masks) {
            (true, _) if layer.data_type == 0 => String::from("APERTURE"),
            (true, _) => format!("APERTURE_{}", layer.data_type),
            (_, Masks::Each | Masks::Binary) => (number - self.first_layer + 1).to_string(),
            (_, Masks::Dose) => layer.data_type.to_string(),
        }
    }
}

impl<W: Write> MaskFile for DxfFile<W> {
    fn structure(&mut self, name: &str) -> io::Result<()> {
        self.out.write_all(self.closing.as_bytes())?;
        if name == TILE {
            self.closing = "0\nENDBLK\n8\n0\n0\nENDSEC\n";
            self.out.write_all(b"0\nSECTION\n2\nBLOCKS\n")?;
            return self
                .out
                .write_all(b"0\nBLOCK\n8\n0\n2\nTILE\n70\n0\n10\n0\n20\n0\n3\nTILE\n");
        }
        self.closing = "0\nENDSEC\n";
        self.out.write_all(b"0\nSECTION\n2\nENTITIES\n")
    }

    fn rectangle(&mut self, layer: MaskLayer, [low, high]: [[i64; 2]; 2]) -> io::Result<()> {
        let name = self.name(layer);
        let [x0, y0] = low.map(|at| self.um(at));
        let [x1, y1] = high.map(|at| self.um(at));
        // The third and fourth corner of a SOLID stand in the order of a Z.
        write!(
            self.out,
            "0\nSOLID\n8\n{name}\n10\n{x0}\n20\n{y0}\n11\n{x1}\n21\n{y0}\n12\n{x0}\n22\n{y1}\n13\n{x1}\n23\n{y1}\n"
        )
    }

    fn polygon(&mut self, layer: MaskLayer, corners: &[[i64; 2]]) -> io::Result<()> {
        let name = self.name(layer);
        let head = "66\n1\n70\n1\n10\n0\n20\n0\n30\n0";
        writeln!(self.out, "0\nPOLYLINE\n8\n{name}\n{head}")?;
        for corner in corners {
            let [x, y] = corner.map(|at| self.um(at));
            writeln!(self.out, "0\nVERTEX\n8\n{name}\n10\n{x}\n20\n{y}")?;
        }
        writeln!(self.out, "0\nSEQEND\n8\n{name}")
    }

    fn array(&mut self, array: TileArray) -> io::Result<()> {
        let [x, y] = array.corner.map(|at| self.um(at));
        let [dx, dy] = array.steps.map(|at| self.um(at));
        let [columns, rows] = array.counts;
        writeln!(
            self.out,
            "0\nINSERT\n8\n0\n2\nTILE\n10\n{x}\n20\n{y}\n70\n{columns}\n71\n{rows}\n44\n{dx}\n45\n{dy}"
        )
    }

    fn end(&mut self) -> io::Result<()> {
        self.out.write_all(self.closing.as_bytes())?;
        self.out.write_all(b"0\nEOF\n")
    }
}
