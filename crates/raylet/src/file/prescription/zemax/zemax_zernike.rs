//! Surfaces of a Zemax file that Zernike polynomials shape, and phases that they describe.
//!
//! | number | surfaces `SZERNSAG`, `FZERNSAG` | phases `SZERNPHA`, `FZERNPHA` |
//! | --- | --- | --- |
//! | parameter 0 | whether terms hold beyond the norm radius | diffraction order |
//! | parameter 1 | coefficient of r² | whether terms hold beyond the norm radius |
//! | parameters 2 to 8 | coefficients of r⁴, r⁶, … r¹⁶ | |
//! | parameters 9 and 10 | shift of the terms along x and y | |
//! | extra data 1, 2, 3 … | how many terms, norm radius, coefficients | the same, coefficients in waves |

use std::f64::consts::TAU;

use crate::file::prescription::sequential::Curve;
use crate::file::prescription::zemax::zemax_shape::{
    ASSUMED_ORDER, RawSurface, ReadSurface, Refusal, trimmed,
};
use crate::file::prescription::zernike_order::{MOST_FRINGE, add_square, noll_of_fringe};
use crate::file::scene::layer::{Layer, ZernikeLayer};
use crate::file::scene::surface_shape::{Shape, ZernikeShape};

/// Most standard polynomials; Zemax has no more.
const MOST_STANDARD: usize = 231;

impl RawSurface {
    /// An even asphere with Zernike terms in the unit of the file.
    ///
    /// # Errors
    /// Terms that are shifted, or too many.
    pub(crate) fn zernike_sag(&self, unit: f64) -> Result<ReadSurface, Refusal> {
        let (norm_radius_mm, noll) = self.noll_terms(unit)?;
        if noll.is_empty() {
            return Ok(ReadSurface::plain(self.even(unit)));
        }
        let shift = [9, 10].map(|number| self.parameter(number));
        if shift != [0.0; 2] {
            let found = format!("Zernike terms that are shifted by {shift:?}");
            let expected = "0 as parameters 9 and 10".to_owned();
            return Err((found, expected));
        }

        // The term of r² is in that of defocus, the others beside the polynomials.
        let mut heights: Vec<f64> = noll.iter().map(|a| 1e3 * a * unit).collect();
        add_square(&mut heights, 1e3 * self.parameter(1) / unit, norm_radius_mm);
        let aspheric = (2..=8).map(|i| self.parameter(i) * unit.powi(1 - 2 * i as i32));
        let curve = Curve {
            aspheric: trimmed(aspheric.collect()),
            shape: Some(Shape::Zernike(ZernikeShape {
                norm_radius_mm,
                coefficients_um: heights,
            })),
            ..self.conic(unit)
        };
        Ok(ReadSurface {
            ends_mm: (self.parameter(0) == 0.0).then_some(norm_radius_mm),
            ..ReadSurface::plain(curve)
        })
    }

    /// A conic section with a phase of order · 2π Σ Aᵢ Zᵢ.
    ///
    /// # Errors
    /// An order that is no whole number, parameters without a meaning, or too many terms.
    pub(crate) fn zernike_phase(&self, unit: f64) -> Result<ReadSurface, Refusal> {
        let mut others = self.parameter.iter();
        if let Some((number, value)) = others.find(|(n, value)| **n > 1 && **value != 0.0) {
            let found = format!(
                "parameter {number} = {value} on a surface of type {}",
                self.kind
            );
            return Err((found, "an order and coefficients alone".to_owned()));
        }
        let (order, stated) = self.stated_order()?;
        let (norm_radius_mm, noll) = self.noll_terms(unit)?;
        let coefficients: Vec<f64> = noll.iter().map(|a| order * TAU * a).collect();
        let present = order != 0.0 && !coefficients.is_empty();
        let layer = present.then_some(Layer::Zernike(ZernikeLayer {
            norm_radius_mm,
            coefficients,
            centre_mm: [0.0; 2],
            rotation_deg: 0.0,
        }));
        Ok(ReadSurface {
            phase: layer.into_iter().collect(),
            ends_mm: (present && self.parameter(1) == 0.0).then_some(norm_radius_mm),
            remark: (!stated).then_some(ASSUMED_ORDER),
            ..ReadSurface::plain(self.conic(unit))
        })
    }

    /// The norm radius in mm, and coefficients as written but in Noll's order and normalisation.
    fn noll_terms(&self, unit: f64) -> Result<(f64, Vec<f64>), Refusal> {
        let (radius, coefficients) = self.series(unit)?;
        let fringe = self.kind.starts_with('F');
        let most = if fringe { MOST_FRINGE } else { MOST_STANDARD };
        let coefficients = trimmed(coefficients);
        if coefficients.len() > most {
            let found = format!("{} Zernike terms", coefficients.len());
            return Err((found, format!("at most {most}")));
        }
        match fringe {
            true => Ok((radius, noll_of_fringe(&coefficients))),
            false => Ok((radius, coefficients)),
        }
    }
}
