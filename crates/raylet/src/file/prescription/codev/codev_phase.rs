//! Diffractive phases and gratings of a CODE V file's surfaces.
//!
//! `DIF DOE` has the phase 2π/λ₀ Σ Cⱼ r^{2j} times the order (HCT R), or the same with products of powers of x and y (HCT XY). It
//! is added to the field, exp(+iφ): a negative C₁ converges, with the power −2 C₁ at λ₀.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::file::decode::fault::Fault;
use crate::file::prescription::codev::codev_commands::Command;
use crate::file::prescription::codev::codev_shape::Refusal;
use crate::file::prescription::lens_text::LensText;
use crate::file::scene::layer::{GratingLayer, Layer, PhaseTerm, PolynomialLayer, RadialLayer};

/// The highest number of a coefficient.
const MOST: usize = 200;

/// What diffracts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// Nothing.
    #[default]
    None,
    /// A phase.
    Phase,
    /// Straight lines.
    Grating,
}

/// What the coefficients belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Powers {
    /// r², r⁴, …
    Radius,
    /// x, y, x², xy, y², …
    Products,
}

/// The diffractive numbers of a surface, lengths in the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RawPhase {
    kind: Kind,
    order: f64,
    wavelength_nm: Option<f64>,
    powers: Option<Powers>,
    coefficient: BTreeMap<usize, f64>,
    spacing: f64,
    /// The direction across the lines.
    across: [f64; 3],
}

impl Default for RawPhase {
    fn default() -> Self {
        Self {
            kind: Kind::None,
            order: 1.0,
            wavelength_nm: None,
            powers: None,
            coefficient: BTreeMap::new(),
            spacing: 0.0,
            across: [0.0, 1.0, 0.0],
        }
    }
}

impl RawPhase {
    /// Reads a command; false where it is none of a phase.
    ///
    /// # Errors
    /// A value that is missing or no number, or a kind that is not read.
    pub(crate) fn read(&mut self, text: &LensText, command: &Command<'_>) -> Result<bool, Fault> {
        let word = command.values.first().map(|word| word.to_ascii_uppercase());
        match command.key.as_str() {
            "DIF" => {
                self.kind = match word.as_deref() {
                    Some("DOE") => Kind::Phase,
                    Some("GRT") => Kind::Grating,
                    other => {
                        let found = format!("DIF {}", other.unwrap_or_default());
                        return Err(text.fault(command.word, found, "DIF DOE or DIF GRT"));
                    }
                }
            }
            "GRT" => self.kind = Kind::Grating,
            "HOR" | "GRO" => self.order = command.number(text, 0)?,
            "HWL" => self.wavelength_nm = Some(command.number(text, 0)?),
            "HCT" => {
                self.powers = match word.as_deref() {
                    Some("R") => Some(Powers::Radius),
                    Some("XY") => Some(Powers::Products),
                    other => {
                        let found = format!("HCT {}", other.unwrap_or_default());
                        return Err(text.fault(command.word, found, "HCT R or HCT XY"));
                    }
                }
            }
            "HCO" => {
                let number = command
                    .qualifier('C')
                    .and_then(|number| number.parse().ok());
                let Some(number) = number.filter(|number| (1..=MOST).contains(number)) else {
                    let expected = format!("HCO C1 to C{MOST}, and a number");
                    return Err(text.fault(command.word, "an unknown coefficient", expected));
                };
                self.coefficient.insert(number, command.number(text, 0)?);
            }
            "GRS" => self.spacing = command.number(text, 0)?,
            "GRX" => self.across[0] = command.number(text, 0)?,
            "GRY" => self.across[1] = command.number(text, 0)?,
            "GRZ" => self.across[2] = command.number(text, 0)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Whether it is a grating, whose sign of orders the format leaves open.
    pub(crate) fn is_grating(&self) -> bool {
        self.kind == Kind::Grating
    }

    /// The layers in mm, for a unit of this many mm, and a design wavelength in µm where the file states none.
    ///
    /// # Errors
    /// Numbers without a counterpart, as what was found and what was expected.
    pub(crate) fn layers(&self, unit: f64, reference_um: f64) -> Result<Vec<Layer>, Refusal> {
        if self.kind == Kind::None {
            return Ok(Vec::new());
        }
        if self.order.fract() != 0.0 || self.order.abs() > 1e6 {
            let found = format!("a diffraction order of {}", self.order);
            return Err((found, "a whole number".to_owned()));
        }
        if self.kind == Kind::Grating {
            return self.grating(unit);
        }
        let wavelength_um = self.wavelength_nm.map_or(reference_um, |nm| nm / 1e3);
        if !(0.01..=100.0).contains(&wavelength_um) {
            let found = format!("a design wavelength of {wavelength_um} µm (HWL)");
            return Err((found, "one from 0.01 to 100 µm".to_owned()));
        }
        // Radians for a coefficient of one, in mm: every power is one at one unit of length.
        let scale = self.order * TAU * unit / (wavelength_um * 1e-3);
        let last = self.coefficient.keys().next_back().copied().unwrap_or(0);
        let at = |number: usize| {
            let value = self.coefficient.get(&number).copied();
            scale * value.unwrap_or(0.0)
        };
        let used = (1..=last).any(|number| at(number) != 0.0);
        let layer = match self.powers {
            _ if !used => return Ok(Vec::new()),
            Some(Powers::Radius) => Layer::Radial(RadialLayer {
                norm_radius_mm: unit,
                coefficients: (1..=last).map(at).collect(),
                centre_mm: [0.0; 2],
                rotation_deg: 0.0,
            }),
            Some(Powers::Products) => {
                let powers = (1u32..).flat_map(|order| (0..=order).map(move |y| [order - y, y]));
                let terms = (1..=last).zip(powers).map(|(number, [x, y])| PhaseTerm {
                    x,
                    y,
                    coefficient: at(number),
                });
                Layer::Polynomial(PolynomialLayer {
                    norm_radius_mm: unit,
                    terms: terms.filter(|term| term.coefficient != 0.0).collect(),
                    centre_mm: [0.0; 2],
                    rotation_deg: 0.0,
                })
            }
            None => {
                let found = "DIF DOE without the kind of its coefficients".to_owned();
                return Err((found, "HCT R or HCT XY".to_owned()));
            }
        };
        Ok(vec![layer])
    }

    /// Positive orders turn light towards the direction across the lines.
    fn grating(&self, unit: f64) -> Result<Vec<Layer>, Refusal> {
        let [x, y, z] = self.across;
        let period_um = self.spacing.abs() * unit * 1e3;
        if z != 0.0 || (x, y) == (0.0, 0.0) {
            let found = format!("lines of a grating across ({x}, {y}, {z})");
            return Err((
                found,
                "a direction in the plane of the surface (GRX, GRY)".to_owned(),
            ));
        }
        if !(1e-6..=1e9).contains(&period_um) {
            let found = format!("lines of a grating {} apart", self.spacing);
            return Err((found, "a spacing above zero (GRS)".to_owned()));
        }
        if self.order == 0.0 {
            return Ok(Vec::new());
        }
        Ok(vec![Layer::Grating(GratingLayer {
            period_um,
            direction_deg: y.atan2(x).to_degrees(),
            order: self.order as i32,
            centre_mm: [0.0; 2],
            rotation_deg: 0.0,
        })])
    }
}
