//! Surfaces of a Zemax file: from the name of a type and its numbered parameters to a curve, a phase or a turn of the axis.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::file::prescription::face_grid::FaceGrid;
use crate::file::prescription::sequential::{Action, Curve, Turn};
use crate::file::prescription::zemax::grid_records::RawGrid;
use crate::file::scene::layer::{GratingLayer, Layer, PhaseTerm, PolynomialLayer, RadialLayer};
use crate::file::scene::surface_shape::{
    BiconicShape, OddShape, PolynomialShape, PolynomialTerm, Shape, ToroidShape,
};

/// The types that are read, as the file names them.
pub(crate) const KNOWN_TYPES: [&str; 19] = [
    "STANDARD", "EVENASPH", "ODDASPHE", "XASPHERE", "XOSPHERE", "XPOLYNOM", "BICONICX", "TOROIDAL",
    "SZERNSAG", "FZERNSAG", "COORDBRK", "PARAXIAL", "DGRATING", "BINARY_1", "BINARY_2", "SZERNPHA",
    "FZERNPHA", "GRID_SAG", "GRID_PHA",
];

/// Most terms of an extended surface; Zemax has no more.
const MOST_TERMS: usize = 500;

/// The numbers of a surface as the file writes them, in its own unit of length.
#[derive(Clone, Debug, Default)]
pub(crate) struct RawSurface {
    /// Its type.
    pub kind: String,
    /// Curvature and conic constant.
    pub curvature: f64,
    /// Conic constant.
    pub conic: f64,
    /// Parameters by their numbers.
    pub parameter: BTreeMap<usize, f64>,
    /// Extra data by their numbers.
    pub extra: BTreeMap<usize, f64>,
    /// Values on a grid.
    pub grid: RawGrid,
}

/// What a surface is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReadSurface {
    /// What it does.
    pub action: Action,
    /// Its curve.
    pub curve: Curve,
    /// Its phase.
    pub phase: Vec<Layer>,
    /// The radius in mm beyond which OpticStudio leaves out terms that the scene keeps.
    pub ends_mm: Option<f64>,
    /// Values on a grid that the curve or the phase names.
    pub grid: Option<FaceGrid>,
    /// Points of the grid without data.
    pub gaps: usize,
    /// What was assumed, in a sentence.
    pub remark: Option<&'static str>,
}

impl ReadSurface {
    /// A surface that has a curve and nothing else.
    pub(crate) fn plain(curve: Curve) -> Self {
        Self {
            action: Action::Border,
            curve,
            phase: Vec::new(),
            ends_mm: None,
            grid: None,
            gaps: 0,
            remark: None,
        }
    }
}

/// Powers of x and y, and the coefficient of their product.
type Product = ([u32; 2], f64);

/// What was found and what was expected.
pub(crate) type Refusal = (String, String);

impl RawSurface {
    /// A parameter by its number; zero where the file has none.
    pub(crate) fn parameter(&self, number: usize) -> f64 {
        self.parameter.get(&number).copied().unwrap_or(0.0)
    }

    /// Extra data by their number; zero where the file has none.
    pub(crate) fn extra(&self, number: usize) -> f64 {
        self.extra.get(&number).copied().unwrap_or(0.0)
    }

    /// The surface in mm, for a unit of this many mm; an array of its own is named `file`.
    ///
    /// # Errors
    /// A type or number that has no counterpart, as what was found and what was expected.
    pub(crate) fn read(&self, unit: f64, file: PathBuf) -> Result<ReadSurface, Refusal> {
        let plain = ReadSurface::plain;
        if !self.grid.is_empty() && !self.kind.starts_with("GRID_") {
            let found = format!("a grid (GDAT) on a surface of type {}", self.kind);
            return Err((found, "one of type GRID_SAG or GRID_PHA".to_owned()));
        }
        Ok(match self.kind.as_str() {
            "STANDARD" => plain(self.conic(unit)),
            "EVENASPH" => plain(self.even(unit)),
            "ODDASPHE" => plain(self.odd(unit)),
            "XASPHERE" => plain(self.extended(unit, 2)?),
            "XOSPHERE" => plain(self.extended(unit, 1)?),
            "XPOLYNOM" => plain(self.polynomial(unit)?),
            "BICONICX" => plain(self.biconic(unit)),
            "TOROIDAL" => plain(self.toroid(unit)?),
            "PARAXIAL" => ReadSurface {
                action: Action::IdealLens(self.focal_length(unit)?),
                ..plain(Curve::default())
            },
            "COORDBRK" => ReadSurface {
                action: Action::Turn(self.turn(unit)),
                ..plain(Curve::default())
            },
            "DGRATING" => ReadSurface {
                phase: self.grating()?,
                ..plain(self.conic(unit))
            },
            "BINARY_1" | "BINARY_2" => self.binary(unit)?,
            "SZERNSAG" | "FZERNSAG" => self.zernike_sag(unit)?,
            "SZERNPHA" | "FZERNPHA" => self.zernike_phase(unit)?,
            "GRID_SAG" => self.grid_sag(unit, file)?,
            "GRID_PHA" => self.grid_phase(unit, file)?,
            "BLACKBOX" => {
                let found = "a black box, whose file (.zbb) is encrypted".to_owned();
                return Err((found, "surfaces whose shapes the file has".to_owned()));
            }
            other => {
                let found = format!("a surface of type {other}");
                return Err((found, format!("one of {}", KNOWN_TYPES.join(", "))));
            }
        })
    }

    /// The curve of its curvature and conic constant.
    pub(crate) fn conic(&self, unit: f64) -> Curve {
        Curve {
            curvature: self.curvature / unit,
            conic: self.conic,
            ..Curve::default()
        }
    }

    /// Parameters 1 to 8 are the coefficients of r², r⁴, … r¹⁶.
    pub(crate) fn even(&self, unit: f64) -> Curve {
        let coefficients = (1..=8).map(|i| self.parameter(i) * unit.powi(1 - 2 * i as i32));
        with_even_powers(self.conic(unit), coefficients.collect())
    }

    /// Parameters 1 to 8 are the coefficients of r, r², … r⁸.
    fn odd(&self, unit: f64) -> Curve {
        let coefficients = (1..=8).map(|i| self.parameter(i) * unit.powi(1 - i as i32));
        with_all_powers(self.conic(unit), coefficients.collect())
    }

    /// Extra data from 3 on are the coefficients of (r/ρ)^step, (r/ρ)^{2 step}, …
    fn extended(&self, unit: f64, step: i32) -> Result<Curve, Refusal> {
        if let Some((number, value)) = self.parameter.iter().find(|(n, v)| **n > 0 && **v != 0.0) {
            let found = format!(
                "parameter {number} = {value} on a surface of type {}",
                self.kind
            );
            return Err((found, "coefficients in its extra data alone".to_owned()));
        }
        let (radius, coefficients) = self.series(unit)?;
        let scaled = (1..)
            .zip(coefficients)
            .map(|(i, a)| a * unit * radius.powi(-step * i));
        let scaled = scaled.collect();
        Ok(match step {
            1 => with_all_powers(self.conic(unit), scaled),
            _ => with_even_powers(self.conic(unit), scaled),
        })
    }

    /// Extra data: how many terms, the radius in mm at which every power is one, and the coefficients as written.
    ///
    /// # Errors
    /// Too many terms, or no radius.
    pub(crate) fn series(&self, unit: f64) -> Result<(f64, Vec<f64>), Refusal> {
        let (count, radius) = (self.extra(1), self.extra(2) * unit);
        if count.fract() != 0.0 || !(0.0..=MOST_TERMS as f64).contains(&count) {
            let expected = format!("a whole number of terms up to {MOST_TERMS}");
            return Err((format!("{count} terms as extra data 1"), expected));
        }
        let coefficients: Vec<f64> = (0..count as usize).map(|i| self.extra(i + 3)).collect();
        // Without terms the radius has no meaning, and some programs write zero.
        let used = coefficients.iter().any(|a| *a != 0.0);
        match radius > 1e-12 {
            true => Ok((radius, coefficients)),
            false if !used => Ok((1.0, Vec::new())),
            false => Err((
                format!("a norm radius of {radius} mm as extra data 2"),
                "a radius above zero".to_owned(),
            )),
        }
    }

    /// Extra data from 3 on are the coefficients of x, y, x², xy, y², x³, … over the norm radius.
    fn products(&self, unit: f64) -> Result<(f64, Vec<Product>), Refusal> {
        let (radius, coefficients) = self.series(unit)?;
        let powers = (1u32..).flat_map(|order| (0..=order).map(move |y| [order - y, y]));
        let terms = powers.zip(coefficients).filter(|(_, a)| *a != 0.0);
        Ok((radius, terms.collect()))
    }

    fn polynomial(&self, unit: f64) -> Result<Curve, Refusal> {
        let (norm_radius_mm, terms) = self.products(unit)?;
        let terms: Vec<_> = terms
            .into_iter()
            .map(|([x, y], a)| PolynomialTerm {
                x,
                y,
                height_um: 1e3 * a * unit,
            })
            .collect();
        let shape = (!terms.is_empty()).then_some(Shape::Polynomial(PolynomialShape {
            norm_radius_mm,
            terms,
        }));
        Ok(Curve {
            shape,
            ..self.conic(unit)
        })
    }

    /// Parameter 1 is the radius along x, 2 the conic constant along x; the curvature is that along y.
    fn biconic(&self, unit: f64) -> Curve {
        let radius = self.parameter(1) * unit;
        Curve {
            shape: Some(Shape::Biconic(BiconicShape {
                radius_x_mm: (radius != 0.0).then_some(radius),
                radius_y_mm: self.conic(unit).radius_mm(),
                conic_x: self.parameter(2),
                conic_y: self.conic,
            })),
            ..Curve::default()
        }
    }

    /// Parameter 1 is the radius of rotation, from 2 on are the coefficients of y², y⁴, …
    fn toroid(&self, unit: f64) -> Result<Curve, Refusal> {
        let (_, zernike) = self.series(unit)?;
        if zernike.iter().any(|a| *a != 0.0) {
            let found = "Zernike terms on a toroid".to_owned();
            return Err((found, "a toroid without Zernike terms".to_owned()));
        }
        let (curve, conic) = self.curve_along_y(unit)?;
        let radius = self.parameter(1) * unit;
        let aspheric = (3..=8).map(|i| self.parameter(i) * unit.powi(3 - 2 * i as i32));
        Ok(Curve {
            shape: Some(Shape::Toroid(ToroidShape {
                radius_mm: curve.radius_mm(),
                rotation_radius_mm: (radius != 0.0).then_some(radius),
                conic,
                aspheric: trimmed(aspheric.collect()),
            })),
            ..Curve::default()
        })
    }

    /// The conic section of a toroid along y, with the term of y², parameter 2: one with a parabola is another parabola.
    fn curve_along_y(&self, unit: f64) -> Result<(Curve, f64), Refusal> {
        let (base, square) = (self.conic(unit), self.parameter(2) / unit);
        if square == 0.0 {
            return Ok((base, self.conic));
        }
        if self.curvature != 0.0 && self.conic != -1.0 {
            let found = format!("a coefficient of y² = {} on a toroid", self.parameter(2));
            let expected = "0, or a conic constant of -1, or no radius";
            return Err((found, expected.to_owned()));
        }
        let curvature = base.curvature + 2.0 * square;
        Ok((Curve { curvature, ..base }, -1.0))
    }

    fn focal_length(&self, unit: f64) -> Result<f64, Refusal> {
        let focal_length = self.parameter(1) * unit;
        if focal_length.abs() < 1e-12 {
            let found = format!("a focal length of {focal_length} mm");
            return Err((found, "one other than zero, as parameter 1".to_owned()));
        }
        Ok(focal_length)
    }

    /// Parameters: shifts along x and y, tilts about x, y and z, and the order of both.
    fn turn(&self, unit: f64) -> Turn {
        Turn {
            decenter_mm: [1, 2].map(|i| self.parameter(i) * unit),
            tilt_deg: [3, 4, 5].map(|i| self.parameter(i)),
            tilt_first: self.parameter(6) != 0.0,
            ..Turn::default()
        }
    }

    /// Parameters: lines per µm, and the order. Positive orders turn light towards +y.
    fn grating(&self) -> Result<Vec<Layer>, Refusal> {
        let (lines, order) = (self.parameter(1), self.order(2)?);
        if lines == 0.0 || order == 0 {
            return Ok(Vec::new());
        }
        Ok(vec![Layer::Grating(GratingLayer {
            period_um: (1.0 / lines).abs(),
            direction_deg: 90.0 * lines.signum(),
            order,
            centre_mm: [0.0; 2],
            rotation_deg: 0.0,
        })])
    }

    fn order(&self, number: usize) -> Result<i32, Refusal> {
        let order = self.parameter(number);
        if order.fract() != 0.0 || order.abs() > 1e6 {
            let found = format!("a diffraction order of {order} as parameter {number}");
            return Err((found, "a whole number".to_owned()));
        }
        Ok(order as i32)
    }

    /// The diffraction order of parameter 0, and whether the file states it; 1 otherwise.
    ///
    /// # Errors
    /// An order that is no whole number.
    pub(crate) fn stated_order(&self) -> Result<(f64, bool), Refusal> {
        match self.parameter.contains_key(&0) {
            true => Ok((f64::from(self.order(0)?), true)),
            false => Ok((1.0, false)),
        }
    }

    /// An even asphere with a phase: order · Σ Aᵢ (r/ρ)^{2i}, or order · Σ Aᵢ times products of powers of x/ρ and y/ρ.
    fn binary(&self, unit: f64) -> Result<ReadSurface, Refusal> {
        let (order, stated) = self.stated_order()?;
        let phase = match self.kind.as_str() {
            "BINARY_2" => {
                let (norm_radius_mm, coefficients) = self.series(unit)?;
                let coefficients = trimmed(coefficients.iter().map(|a| order * a).collect());
                (!coefficients.is_empty()).then_some(Layer::Radial(RadialLayer {
                    norm_radius_mm,
                    coefficients,
                    centre_mm: [0.0; 2],
                    rotation_deg: 0.0,
                }))
            }
            _ => {
                let (norm_radius_mm, terms) = self.products(unit)?;
                let term = |([x, y], a): Product| PhaseTerm {
                    x,
                    y,
                    coefficient: order * a,
                };
                let terms: Vec<_> = terms.into_iter().map(term).collect();
                (order != 0.0 && !terms.is_empty()).then_some(Layer::Polynomial(PolynomialLayer {
                    norm_radius_mm,
                    terms,
                    centre_mm: [0.0; 2],
                    rotation_deg: 0.0,
                }))
            }
        };
        Ok(ReadSurface {
            phase: phase.into_iter().collect(),
            remark: (!stated).then_some(ASSUMED_ORDER),
            ..ReadSurface::plain(self.even(unit))
        })
    }
}

/// What is assumed where a file does not state the order.
pub(crate) const ASSUMED_ORDER: &str = "its diffraction order is not stated, and taken as 1";

/// A curve with coefficients of r², r⁴, … added.
fn with_even_powers(base: Curve, mut coefficients: Vec<f64>) -> Curve {
    let square = match coefficients.is_empty() {
        true => 0.0,
        false => coefficients.remove(0),
    };
    let shape = (square != 0.0).then(|| {
        Shape::Odd(OddShape {
            coefficients: vec![0.0, square],
        })
    });
    Curve {
        aspheric: trimmed(coefficients),
        shape,
        ..base
    }
}

/// A curve with coefficients of r, r², … added.
fn with_all_powers(base: Curve, coefficients: Vec<f64>) -> Curve {
    let coefficients = trimmed(coefficients);
    let shape = (!coefficients.is_empty()).then_some(Shape::Odd(OddShape { coefficients }));
    Curve { shape, ..base }
}

/// Without the zeros at the end.
pub(crate) fn trimmed(mut coefficients: Vec<f64>) -> Vec<f64> {
    while coefficients.last() == Some(&0.0) {
        coefficients.pop();
    }
    coefficients
}
