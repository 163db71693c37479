//! Grids of values inside a Zemax file: surfaces `GRID_SAG` and `GRID_PHA`.
//!
//! A record `GDAT` has how many points there are along x and y, their steps and the middle of the grid; a record `GARR` each point:
//! its number from 0, its value, three slopes, and whether it is without data. The first point is that at the smallest x and the
//! largest y; x grows first, then y falls. Lengths are in the unit of the file, phases in rad.

use std::path::PathBuf;
use std::sync::Arc;

use ndarray::Array2;

use crate::file::decode::fault::Fault;
use crate::file::prescription::face_grid::{FaceGrid, GridKind};
use crate::file::prescription::lens_text::{LensText, Record};
use crate::file::prescription::sequential::Curve;
use crate::file::prescription::zemax::zemax_shape::{
    ASSUMED_ORDER, RawSurface, ReadSurface, Refusal, trimmed,
};
use crate::file::scene::layer::{Layer, PhaseGridLayer};
use crate::file::scene::surface_shape::{GridShape, Shape};

/// Most points along an axis.
const MOST_POINTS: usize = 100_000;

/// The grid of a surface as the file writes it.
#[derive(Clone, Debug, Default)]
pub(crate) struct RawGrid {
    size: [usize; 2],
    /// Steps along x and y, then the middle.
    places: [f64; 4],
    values: Vec<f64>,
    /// Points without data.
    missing: usize,
}

/// What an import says of a grid.
const SPLINE: &str = "its grid is a bicubic spline through the points; slopes in the file are not used, and between points \
     OpticStudio's surface is another one";

impl RawGrid {
    /// Reads a record; false where it is none of a grid.
    ///
    /// # Errors
    /// A value that is missing or no number, or a point in another place than its number says.
    pub(crate) fn read(&mut self, text: &LensText, record: &Record<'_>) -> Result<bool, Fault> {
        match record.word {
            "GDAT" => {
                let count = |place: usize| text.count(record, place, MOST_POINTS);
                self.size = [count(0)?, count(1)?];
                for (place, number) in self.places.iter_mut().enumerate() {
                    *number = text.value_or(record, place + 2, 0.0)?;
                }
            }
            "GARR" => {
                let number = text.value(record, 0)?;
                if number != self.values.len() as f64 {
                    let expected = format!("point {}", self.values.len());
                    return Err(text.fault(record.word, format!("point {number}"), expected));
                }
                let (value, missing) = (text.value(record, 1)?, text.value_or(record, 5, 0.0)?);
                self.missing += usize::from(missing != 0.0);
                self.values.push(if missing == 0.0 { value } else { 0.0 });
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Whether the file has no grid.
    pub(crate) fn is_empty(&self) -> bool {
        self.values.is_empty() && self.size == [0; 2]
    }

    /// The values [y, x] times a factor, with rows growing with y.
    fn array(&self, factor: f64) -> Result<Array2<f64>, Refusal> {
        let [nx, ny] = self.size;
        let found = format!(
            "a grid of {nx} × {ny} points with {} values",
            self.values.len()
        );
        let refuse = || (found, "records GDAT, and GARR for each point".to_owned());
        if nx == 0 || ny == 0 {
            return Err(refuse());
        }
        let rows = self.values.chunks_exact(nx).rev().flatten();
        let scaled = rows.map(|value| value * factor).collect();
        Array2::from_shape_vec((ny, nx), scaled).map_err(|_| refuse())
    }

    fn steps(&self, unit: f64) -> Result<[f64; 2], Refusal> {
        let [x, y, ..] = self.places.map(|step| (step * unit).abs());
        match x > 0.0 && y > 0.0 {
            true => Ok([x, y]),
            false => Err((
                format!("steps of {x} and {y} mm"),
                "steps above zero".to_owned(),
            )),
        }
    }

    fn middle(&self, unit: f64) -> [f64; 2] {
        let [.., x, y] = self.places;
        [x, y].map(|at| at * unit)
    }
}

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
