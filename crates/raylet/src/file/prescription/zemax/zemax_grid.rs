//! Surfaces of a Zemax file by values on a grid: `GRID_SAG` and `GRID_PHA`.

use std::path::PathBuf;
use std::sync::Arc;

use ndarray::Array2;

use crate::file::prescription::face_grid::{FaceGrid, GridKind};
use crate::file::prescription::sequential::Curve;
use crate::file::prescription::zemax::zemax_shape::{
    ASSUMED_ORDER, RawSurface, ReadSurface, Refusal, trimmed,
};
use crate::file::scene::layer::{Layer, PhaseGridLayer};
use crate::file::scene::surface_shape::{GridShape, Shape};

/// What an import says of a grid.
const SPLINE: &str = "its grid is a bicubic spline through the points; slopes in the file are not used, and between points \
     OpticStudio's surface is another one";

impl RawSurface {
    /// An even asphere with heights on a grid, which the scene finds in `file`.
    ///
    /// # Errors
    /// Numbers without a counterpart, as what was found and what was expected.
    pub(crate) fn grid_sag(&self, unit: f64, file: PathBuf) -> Result<ReadSurface, Refusal> {
        let beside = |what: &str| {
            let found = format!("{what} beside a grid");
            Err((
                found,
                "a conic section, powers from r⁴, and a grid".to_owned(),
            ))
        };
        let (_, terms) = self.series(unit)?;
        if terms.iter().any(|a| *a != 0.0) {
            return beside("Zernike terms");
        }
        if self.parameter(1) != 0.0 {
            return beside("a coefficient of r²");
        }
        let middle = self.grid.middle(unit);
        if middle != [0.0; 2] {
            let found = format!("a grid with its middle at {middle:?} mm");
            return Err((found, "one about the vertex".to_owned()));
        }
        let (values, pitch_mm) = (self.grid.array(1e3 * unit)?, self.grid.steps(unit)?);
        let aspheric = (2..=8).map(|i| self.parameter(i) * unit.powi(1 - 2 * i as i32));
        let curve = Curve {
            aspheric: trimmed(aspheric.collect()),
            shape: Some(Shape::Grid(GridShape {
                pitch_um: pitch_mm.map(|mm| mm * 1e3),
                height_um: file.clone(),
                key: None,
            })),
            ..self.conic(unit)
        };
        Ok(ReadSurface {
            grid: Some(face_grid(GridKind::Sag, file, values, pitch_mm)),
            gaps: self.grid.missing,
            remark: Some(SPLINE),
            ..ReadSurface::plain(curve)
        })
    }

    /// A plane with phases on a grid, times the order of parameter 0, which the scene finds in `file`.
    ///
    /// # Errors
    /// Numbers without a counterpart, as what was found and what was expected.
    pub(crate) fn grid_phase(&self, unit: f64, file: PathBuf) -> Result<ReadSurface, Refusal> {
        let mut others = self.parameter.iter();
        if let Some((number, value)) = others.find(|(n, value)| **n > 0 && **value != 0.0) {
            let found = format!(
                "parameter {number} = {value} on a surface of type {}",
                self.kind
            );
            return Err((found, "an order alone, as parameter 0".to_owned()));
        }
        let (order, stated) = self.stated_order()?;
        // No public file shows that the order is parameter 0: one that leaves nothing of the phase is not believed.
        if order == 0.0 {
            let found = "a diffraction order of 0 as parameter 0".to_owned();
            return Err((found, "another order".to_owned()));
        }
        let (values, pitch_mm) = (self.grid.array(order)?, self.grid.steps(unit)?);
        let layer = Layer::PhaseGrid(PhaseGridLayer {
            pitch_um: pitch_mm.map(|mm| mm * 1e3),
            size: None,
            phase: file.clone(),
            key: None,
            centre_mm: self.grid.middle(unit),
            rotation_deg: 0.0,
        });
        Ok(ReadSurface {
            phase: vec![layer],
            grid: Some(face_grid(GridKind::Phase, file, values, pitch_mm)),
            gaps: self.grid.missing,
            remark: Some(if stated { SPLINE } else { ASSUMED_ORDER }),
            ..ReadSurface::plain(Curve::default())
        })
    }
}

fn face_grid(kind: GridKind, file: PathBuf, values: Array2<f64>, pitch_mm: [f64; 2]) -> FaceGrid {
    FaceGrid {
        kind,
        file,
        values: Arc::new(values),
        pitch_mm,
    }
}
