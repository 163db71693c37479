//! Shapes of a CODE V file's surfaces.

use std::collections::BTreeMap;

use crate::file::decode::fault::Fault;
use crate::file::prescription::codev::codev_commands::Command;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::Curve;
use crate::file::prescription::zernike_order::{MOST_FRINGE, noll_of_fringe};
use crate::file::scene::surface_shape::{
    BiconicShape, OddShape, PolynomialShape, PolynomialTerm, Shape, ToroidShape, ZernikeShape,
};

/// Words of coefficients: of r⁴, r⁶, … r²⁰.
const POWERS: [&str; 9] = ["A", "B", "C", "D", "E", "F", "G", "H", "J"];

/// Words that need other shapes, unless they are zero.
const ANAMORPHIC: [&str; 8] = ["AR", "BR", "CR", "DR", "AP", "BP", "CP", "DP"];

/// The highest number of a coefficient of a special surface.
const MOST_SPECIAL: usize = 200;

/// The coefficient of the first fringe polynomial.
const FIRST_FRINGE: usize = 4;

/// The kind of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// A sphere, a conic section or an even asphere.
    #[default]
    Round,
    /// Two curvatures.
    Biconic,
    /// A curve along y turned about a line along y.
    Toroid,
    /// The same along x.
    ToroidAlongX,
    /// Powers of r.
    Odd,
    /// Powers of x and y.
    Polynomial,
    /// Fringe Zernike polynomials.
    Fringe,
}

/// The numbers of a shape, in the unit of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RawShape {
    /// Curvature along y.
    pub curvature: f64,
    /// Conic constant.
    pub conic: f64,
    kind: Kind,
    curvature_x: Option<f64>,
    conic_x: f64,
    power: [f64; 9],
    special: BTreeMap<usize, f64>,
    norm_radius: Option<f64>,
    fresnel: f64,
    anamorphic: BTreeMap<&'static str, f64>,
}

/// What was found and what was expected.
pub(crate) type Refusal = (String, String);

impl RawShape {
    /// Reads a command; false where it is none of a shape. Curvatures along y are read elsewhere.
    ///
    /// # Errors
    /// A value that is missing or no number, or a kind of surface that is not read.
    pub(crate) fn read(&mut self, text: &LensText, command: &Command<'_>) -> Result<bool, Fault> {
        let key = command.key.as_str();
        if let Some(place) = POWERS.iter().position(|word| *word == key) {
            if let Some(power) = self.power.get_mut(place) {
                *power = command.number(text, 0)?;
            }
            return Ok(true);
        }
        if let Some(word) = ANAMORPHIC.iter().find(|word| **word == key) {
            self.anamorphic.insert(word, command.number(text, 0)?);
            return Ok(true);
        }
        match key {
            "SPH" => {
                (self.kind, self.conic) = (Kind::Round, 0.0);
                self.power = [0.0; 9];
            }
            "CON" | "ASP" => self.kind = Kind::Round,
            "CYL" | "AAS" => self.kind = Kind::Biconic,
            "YTO" => self.kind = Kind::Toroid,
            "XTO" => self.kind = Kind::ToroidAlongX,
            "SPS" => self.kind = special_kind(text, command)?,
            "SCO" => self.read_special(text, command)?,
            "K" | "KY" => self.conic = command.number(text, 0)?,
            "KX" => self.conic_x = command.number(text, 0)?,
            "CUX" => self.curvature_x = Some(command.number(text, 0)?),
            "RDX" => self.curvature_x = Some(curvature(command.number(text, 0)?)),
            "CUF" => self.fresnel = command.number(text, 0)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn read_special(&mut self, text: &LensText, command: &Command<'_>) -> Result<(), Fault> {
        let radius = command.values.first().is_some_and(|word| {
            let word = word.to_ascii_uppercase();
            word == "NRADIUS" || word == "NRA"
        });
        if radius {
            self.norm_radius = Some(command.number(text, 1)?);
            return Ok(());
        }
        let place = match (command.qualifier('C'), command.values.first()) {
            (Some(number), _) => number.parse::<usize>().ok(),
            (None, Some(word)) if word.eq_ignore_ascii_case("K") => Some(1),
            _ => None,
        };
        let Some(place) = place.filter(|place| (1..=MOST_SPECIAL).contains(place)) else {
            let expected = format!("SCO K or SCO C1 to C{MOST_SPECIAL}, and a number");
            return Err(text.fault(command.word, "an unknown coefficient", expected));
        };
        let at = command.values.len().saturating_sub(1);
        self.special.insert(place, command.number(text, at)?);
        Ok(())
    }

    /// The curve in mm, for a unit of this many mm.
    ///
    /// # Errors
    /// Numbers without a counterpart, as what was found and what was expected.
    pub(crate) fn curve(&self, unit: f64) -> Result<Curve, Refusal> {
        if self.fresnel != 0.0 {
            let found = format!("a Fresnel surface (CUF {})", self.fresnel);
            return Err((found, "CUF 0".to_owned()));
        }
        if let Some((word, value)) = self.anamorphic.iter().find(|(_, value)| **value != 0.0) {
            let found = format!("an anamorphic asphere ({word} {value})");
            return Err((found, "one of conic sections alone".to_owned()));
        }
        let aspheric = self.power.iter().zip(2i32..);
        let aspheric = aspheric.map(|(a, i)| a * unit.powi(1 - 2 * i)).collect();
        let round = Curve {
            curvature: self.curvature / unit,
            conic: self.conic,
            aspheric: trimmed(aspheric),
            shape: None,
        };
        match self.kind {
            Kind::Round => Ok(round),
            Kind::Biconic => self.biconic(round, unit),
            Kind::Toroid => Ok(self.toroid(round, unit)),
            // Of a straight line nothing is lost by taking the other axis.
            Kind::ToroidAlongX if round.aspheric.is_empty() && self.curvature == 0.0 => {
                let along_x = Self {
                    conic: 0.0,
                    conic_x: self.conic,
                    ..self.clone()
                };
                along_x.biconic(round, unit)
            }
            Kind::ToroidAlongX => Err((
                "a toroid along x (XTO) with a curvature along y".to_owned(),
                "a cylinder, or a toroid along y (YTO)".to_owned(),
            )),
            Kind::Odd => Ok(self.odd(round, unit)),
            Kind::Polynomial => self.polynomial(round, unit),
            Kind::Fringe => self.fringe(round, unit),
        }
    }

    /// Two conic sections; `round` has that along y.
    fn biconic(&self, round: Curve, unit: f64) -> Result<Curve, Refusal> {
        if !round.aspheric.is_empty() {
            let found = "coefficients from A on a surface with two curvatures".to_owned();
            return Err((found, "conic sections alone".to_owned()));
        }
        let across = self.curvature_x.unwrap_or(0.0) / unit;
        Ok(Curve {
            shape: Some(Shape::Biconic(BiconicShape {
                radius_x_mm: (across != 0.0).then(|| 1.0 / across),
                radius_y_mm: round.radius_mm(),
                conic_x: self.conic_x,
                conic_y: self.conic,
            })),
            ..Curve::default()
        })
    }

    fn toroid(&self, round: Curve, unit: f64) -> Curve {
        let across = self.curvature_x.unwrap_or(0.0) / unit;
        Curve {
            shape: Some(Shape::Toroid(ToroidShape {
                radius_mm: round.radius_mm(),
                rotation_radius_mm: (across != 0.0).then(|| 1.0 / across),
                conic: self.conic,
                aspheric: round.aspheric,
            })),
            ..Curve::default()
        }
    }

    /// Coefficient 1 is the conic constant, from 2 on are those of r, r², …
    fn odd(&self, round: Curve, unit: f64) -> Curve {
        let last = self.special.keys().next_back().copied().unwrap_or(1);
        let coefficients = (2..=last).map(|place| {
            let power = place as i32 - 1;
            self.special(place) * unit.powi(1 - power)
        });
        let coefficients = trimmed(coefficients.collect());
        Curve {
            conic: self.special(1),
            shape: (!coefficients.is_empty()).then_some(Shape::Odd(OddShape { coefficients })),
            ..round
        }
    }

    /// Coefficient 1 is the conic constant, from 2 on are those of x, y, x², xy, y², x³, … over the norm radius, or 1.
    fn polynomial(&self, round: Curve, unit: f64) -> Result<Curve, Refusal> {
        let norm_radius_mm = norm_radius(self.norm_radius.unwrap_or(1.0), unit)?;
        let powers = (1u32..).flat_map(|order| (0..=order).map(move |y| [order - y, y]));
        let terms = (2..=MOST_SPECIAL)
            .zip(powers)
            .map(|(place, [x, y])| PolynomialTerm {
                x,
                y,
                height_um: 1e3 * self.special(place) * unit,
            });
        let terms: Vec<_> = terms.filter(|term| term.height_um != 0.0).collect();
        let shape = (!terms.is_empty()).then_some(Shape::Polynomial(PolynomialShape {
            norm_radius_mm,
            terms,
        }));
        Ok(Curve {
            conic: self.special(1),
            shape,
            ..round
        })
    }

    /// Coefficient 1 is the conic constant, 3 the norm radius; from 4 on are those of fringe polynomials 1 to 37.
    fn fringe(&self, round: Curve, unit: f64) -> Result<Curve, Refusal> {
        let conic = self.special(1);
        let unknown = |place: usize| place == 2 || place > FIRST_FRINGE + MOST_FRINGE - 1;
        let mut others = self.special.iter();
        if let Some((place, value)) = others.find(|(at, value)| unknown(**at) && **value != 0.0) {
            let found = format!("SCO C{place} {value} on a surface of Zernike polynomials");
            return Err((found, "C1, C3 and C4 to C40".to_owned()));
        }
        let places = FIRST_FRINGE..FIRST_FRINGE + MOST_FRINGE;
        let coefficients: Vec<f64> = places
            .map(|place| 1e3 * self.special(place) * unit)
            .collect();
        let coefficients_um = noll_of_fringe(&coefficients);
        if coefficients_um.is_empty() {
            return Ok(Curve { conic, ..round });
        }
        let radius = self.norm_radius.unwrap_or(self.special(3));
        let shape = Shape::Zernike(ZernikeShape {
            norm_radius_mm: norm_radius(radius, unit)?,
            coefficients_um,
        });
        Ok(Curve {
            conic,
            shape: Some(shape),
            ..round
        })
    }

    fn special(&self, place: usize) -> f64 {
        self.special.get(&place).copied().unwrap_or(0.0)
    }
}

/// Curvature of a radius, of which zero stands for a plane.
pub(crate) fn curvature(radius: f64) -> f64 {
    match radius == 0.0 {
        true => 0.0,
        false => 1.0 / radius,
    }
}

/// A norm radius in mm.
fn norm_radius(radius: f64, unit: f64) -> Result<f64, Refusal> {
    match radius * unit > 1e-12 {
        true => Ok(radius * unit),
        false => Err((
            format!("a norm radius of {radius}"),
            "one above zero (SCO NRADIUS)".to_owned(),
        )),
    }
}

fn special_kind(text: &LensText, command: &Command<'_>) -> Result<Kind, Fault> {
    let word = command.values.first().copied().unwrap_or(command.word);
    match word.to_ascii_uppercase().as_str() {
        "ODD" => Ok(Kind::Odd),
        "XYP" => Ok(Kind::Polynomial),
        "ZFR" => Ok(Kind::Fringe),
        _ => {
            let found = format!("a special surface of kind {word}");
            Err(text.fault(word, found, "SPS ODD, SPS XYP or SPS ZFR"))
        }
    }
}

/// Without the zeros at the end.
fn trimmed(mut coefficients: Vec<f64>) -> Vec<f64> {
    while coefficients.last() == Some(&0.0) {
        coefficients.pop();
    }
    coefficients
}
