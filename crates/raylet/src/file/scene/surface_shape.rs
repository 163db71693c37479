//! Shapes of surfaces, as a scene file describes them.

use std::path::PathBuf;
use std::sync::Arc;

use ndarray::ArrayView2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::fault::Fault;
use crate::file::decode::number::{not_empty, one_or_pair_schema, pitch, positive, radius};
use crate::file::decode::place::Place;
use crate::file::decode::quantity::LENGTH;
use crate::file::decode::tagged::tagged;
use crate::optics::aperture::Aperture;
use crate::optics::assembly::part_check::missing_point;
use crate::optics::freeform::Term;
use crate::optics::sag_grid::SagGrid;
use crate::optics::shape::{self as optics, Conic};
use crate::optics::toric;
use crate::optics::zernike::ZernikeSum;

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

tagged! {
    /// A shape that is no conic with even powers of the radius. Heights grow towards larger z.
    pub enum Shape {
        /// One conic along x and another along y; instead of radius_mm, conic and aspheric.
        Biconic(BiconicShape) = "biconic",
        /// A curve along y, turned about an axis parallel to y; instead of radius_mm, conic and aspheric.
        Toroid(ToroidShape) = "toroid",
        /// Curved across one axis only; instead of radius_mm, conic and aspheric.
        Cylinder(CylinderShape) = "cylinder",
        /// All powers of the radius, odd ones too, on top of the conic.
        Odd(OddShape) = "odd",
        /// Products of powers of x and y on top of the conic.
        Polynomial(PolynomialShape) = "xy",
        /// Zernike polynomials on top of the conic.
        Zernike(ZernikeShape) = "zernike",
        /// Gaussian bumps on top of the conic.
        Gaussian(GaussianShape) = "gaussian",
        /// Heights from an array file on top of the conic.
        Grid(GridShape) = "grid",
    }
}

/// z = (x²/Rx + y²/Ry) / (1 + √(1 − (1+κx) x²/Rx² − (1+κy) y²/Ry²)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BiconicShape {
    /// Radius of curvature along x at the vertex in millimetres; straight when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_x_mm: Option<f64>,
    /// Radius of curvature along y at the vertex in millimetres; straight when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_y_mm: Option<f64>,
    /// Conic constant along x.
    #[serde(default)]
    pub conic_x: f64,
    /// Conic constant along y.
    #[serde(default)]
    pub conic_y: f64,
}

/// The curve z(y) = (y²/R) / (1 + √(1 − (1+κ) y²/R²)) + Σ aᵢ y^{2i+2}, turned about an axis parallel to y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToroidShape {
    /// Radius R of the curve along y at the vertex in millimetres; straight when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_mm: Option<f64>,
    /// Distance from the vertex to the axis of rotation in millimetres, positive when that lies at larger
    /// z: the radius along x; a cylinder when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub rotation_radius_mm: Option<f64>,
    /// Conic constant κ of the curve along y.
    #[serde(default)]
    pub conic: f64,
    /// Coefficients of y⁴, y⁶, y⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
    #[serde(default)]
    pub aspheric: Vec<f64>,
}

/// A cylinder, or a conic section drawn out along a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// The axis along which it is straight.
    pub straight_along: Straight,
    /// Radius of curvature across that axis in millimetres.
    #[serde(deserialize_with = "radius")]
    #[schemars(with = "f64")]
    pub radius_mm: Option<f64>,
    /// Conic constant across that axis.
    #[serde(default)]
    pub conic: f64,
}

/// An axis across a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Straight {
    /// The local x axis.
    X,
    /// The local y axis.
    Y,
}

/// Σ aᵢ rⁱ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OddShape {
    /// Coefficients of r, r², r³, … in 1, mm⁻¹, mm⁻², …
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub coefficients: Vec<f64>,
}

/// Σ a (x/ρ)ⁱ (y/ρ)ʲ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolynomialShape {
    /// Length ρ in millimetres at which every power is one.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub norm_radius_mm: f64,
    /// The terms.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub terms: Vec<PolynomialTerm>,
}

/// One product of powers of x and y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolynomialTerm {
    /// Power of x/ρ, up to 40.
    #[serde(default)]
    pub x: u32,
    /// Power of y/ρ, up to 40.
    #[serde(default)]
    pub y: u32,
    /// Coefficient in micrometres.
    pub height_um: f64,
}

/// Σ aⱼ Zⱼ(x/ρ, y/ρ) in Noll's order and normalisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ZernikeShape {
    /// Radius ρ in millimetres of the unit circle.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub norm_radius_mm: f64,
    /// Coefficients in micrometres of Noll's Z₁ (piston), Z₂ (tilt in x), Z₃ (tilt in y), Z₄ (defocus), …
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub coefficients_um: Vec<f64>,
}

/// A sum of Gaussian bumps h exp(−d²/2σ²), d the distance from the centre of each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaussianShape {
    /// The bumps.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub bumps: Vec<Bump>,
}

/// One Gaussian bump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bump {
    /// Height h at its centre in micrometres; negative for a pit.
    pub height_um: f64,
    /// σ in millimetres: where the height has fallen to 61 %.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub sigma_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// Heights on a centred grid with a bicubic spline between them. The surface ends at the outer points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridShape {
    /// Distance of neighbouring points in micrometres: one number, or [x, y].
    #[serde(deserialize_with = "pitch")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub pitch_um: [f64; 2],
    /// Real 2-D array of heights in micrometres, indexed [y, x] with rows growing with y, at least 4 × 4,
    /// in a NumPy file or a map (.dat, .tif, .fits, .h5).
    pub height_um: PathBuf,
    /// Name of the array in a .npz file; without it `height_um`, or else its only array.
    #[serde(default)]
    pub key: Option<String>,
}

/// The keys of a surface that describe its shape.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceShape<'a> {
    /// Radius of curvature in mm.
    pub radius_mm: Option<f64>,
    /// Conic constant.
    pub conic: f64,
    /// Coefficients of r⁴, r⁶, …
    pub aspheric: &'a [f64],
    /// What replaces them or is added to them.
    pub shape: Option<&'a Shape>,
}

/// A highest power in x or y.
pub(crate) const HIGHEST_POWER: u32 = 40;

fn conic(radius_mm: Option<f64>, conic: f64) -> Conic {
    Conic {
        curvature: radius_mm.map_or(0.0, |radius| 1.0 / radius),
        conic,
    }
}

impl SurfaceShape<'_> {
    /// The shape that is described; nothing when it needs an array of heights in µm that is not there.
    pub(crate) fn optics(&self, heights_um: Option<ArrayView2<f64>>) -> Option<optics::Shape> {
        let straight = conic(None, 0.0);
        Some(match self.shape {
            None => self.of_revolution(),
            Some(Shape::Biconic(one)) => optics::Shape::Biconic(toric::Biconic {
                x: conic(one.radius_x_mm, one.conic_x),
                y: conic(one.radius_y_mm, one.conic_y),
            }),
            Some(Shape::Cylinder(one)) => {
                let across = conic(one.radius_mm, one.conic);
                let (x, y) = match one.straight_along {
                    Straight::X => (straight, across),
                    Straight::Y => (across, straight),
                };
                optics::Shape::Biconic(toric::Biconic { x, y })
            }
            Some(Shape::Toroid(one)) => optics::Shape::Toroid(toric::Toroid {
                rotation: conic(one.rotation_radius_mm, 0.0).curvature,
                curve: conic(one.radius_mm, one.conic),
                coefficients: one.aspheric.clone(),
            }),
            Some(added) => {
                let mut terms = terms(added, heights_um)?;
                if !self.aspheric.is_empty() {
                    // r⁴, r⁶, … among all powers.
                    let pairs = self.aspheric.iter().flat_map(|a| [0.0, *a]);
                    terms.push(Term::Powers([0.0, 0.0].into_iter().chain(pairs).collect()));
                }
                let base = conic(self.radius_mm, self.conic);
                optics::Shape::Freeform { base, terms }
            }
        })
    }

    /// The conic with even powers.
    fn of_revolution(&self) -> optics::Shape {
        let base = conic(self.radius_mm, self.conic);
        if self.aspheric.iter().any(|&coefficient| coefficient != 0.0) {
            let coefficients = self.aspheric.to_vec();
            optics::Shape::Asphere { base, coefficients }
        } else if base.curvature == 0.0 {
            optics::Shape::Plane
        } else {
            optics::Shape::Conic(base)
        }
    }

    /// Checks that the keys fit together.
    pub(crate) fn check(&self, place: &Place<'_>) -> Result<(), Fault> {
        let kind = match self.shape {
            Some(Shape::Biconic(_)) => "biconic",
            Some(Shape::Toroid(_)) => "toroid",
            Some(Shape::Cylinder(_)) => "cylinder",
            Some(Shape::Polynomial(sum)) => return check_powers(sum, place),
            _ => return Ok(()),
        };
        let given = [
            (".radius_mm", self.radius_mm.is_some()),
            (".conic", self.conic != 0.0),
            (".aspheric", !self.aspheric.is_empty()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((key, _)) => place.inner(key).refuse(
                format!("a key beside a shape of kind \"{kind}\", which replaces it"),
                "what belongs to it inside `shape`",
            ),
            None => Ok(()),
        }
    }
}

/// High powers are slips of the pen.
fn check_powers(sum: &PolynomialShape, place: &Place<'_>) -> Result<(), Fault> {
    for (i, term) in sum.terms.iter().enumerate() {
        for (key, power) in [("x", term.x), ("y", term.y)] {
            if power > HIGHEST_POWER {
                return place
                    .inner(&format!(".shape.terms[{i}].{key}"))
                    .refuse(power.to_string(), format!("a power up to {HIGHEST_POWER}"));
            }
        }
    }
    Ok(())
}

/// The terms that a shape adds to a conic; nothing without the heights it needs.
fn terms(shape: &Shape, heights_um: Option<ArrayView2<f64>>) -> Option<Vec<Term>> {
    let term = match shape {
        Shape::Biconic(_) | Shape::Toroid(_) | Shape::Cylinder(_) => return Some(Vec::new()),
        Shape::Gaussian(sum) => {
            let bump = |bump: &Bump| Term::Gaussian {
                height: bump.height_um * UM,
                centre: bump.centre_mm,
                sigma: bump.sigma_mm,
            };
            return Some(sum.bumps.iter().map(bump).collect());
        }
        Shape::Odd(sum) => Term::Powers(sum.coefficients.clone()),
        Shape::Polynomial(sum) => Term::Polynomial {
            radius: sum.norm_radius_mm,
            terms: sum
                .terms
                .iter()
                .map(|term| ([term.x, term.y], term.height_um * UM))
                .collect(),
        },
        Shape::Zernike(sum) => Term::Zernike(ZernikeSum::new(
            sum.norm_radius_mm,
            sum.coefficients_um.iter().map(|a| a * UM).collect(),
        )),
        Shape::Grid(grid) => {
            let heights = heights_um?.mapv(|height| height * UM);
            let grid = SagGrid::new(&heights, grid.pitch_um.map(|p| p * UM))?;
            Term::Grid(Arc::new(grid))
        }
    };
    Some(vec![term])
}

/// Checks that a surface exists all over its aperture, whose key is a step from `place`.
pub(crate) fn check_extent(
    shape: &optics::Shape,
    aperture: &Aperture,
    key: &str,
    place: &Place<'_>,
) -> Result<(), Fault> {
    let gap = missing_point(shape, aperture, LENGTH);
    let Some([x, y]) = gap else {
        return Ok(());
    };
    let round = matches!(
        shape,
        optics::Shape::Conic(_) | optics::Shape::Asphere { .. }
    );
    match aperture.bounds() {
        Some([_, radius, ..]) if round && key == ".semi_aperture_mm" => place.inner(key).refuse(
            radius.to_string(),
            "a radius up to which the surface exists: its conic ends before",
        ),
        _ => place.inner(key).refuse(
            format!("an aperture at ({x:.6}, {y:.6}) mm, where the surface does not exist"),
            "an aperture all over which it exists",
        ),
    }
}
