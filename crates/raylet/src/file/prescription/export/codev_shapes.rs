//! Curves and phases as commands of CODE V.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::file::prescription::export::held_phase::Refusal;
use crate::file::prescription::export::power_products::PowerProducts;
use crate::file::prescription::export::zemax_types::{added_powers, added_products, refused_shape};
use crate::file::prescription::export::zemax_writer::written;
use crate::file::prescription::sequential::{Curve, Turn};
use crate::file::scene::layer::Layer;
use crate::file::scene::surface_shape::{Shape, Straight, ToroidShape};
use crate::optics::zernike::zernike_products;

/// Words of the coefficients of r⁴, r⁶, … r²⁰.
const POWERS: [&str; 9] = ["A", "B", "C", "D", "E", "F", "G", "H", "J"];

/// The highest power of the radius of a special surface, and the highest degree of products of powers of x and y.
const HIGHEST_POWER: usize = 30;
const HIGHEST_DEGREE: u32 = 10;

/// Most coefficients of a phase along the radius.
const MOST_EVEN: usize = 65;

/// A surface of the format.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CodevShape {
    /// Radius of curvature along y in mm; zero for a plane.
    pub radius_mm: f64,
    /// Its commands.
    pub commands: Vec<String>,
    /// How far its vertex stands behind that of the scene's surface.
    pub offset_mm: f64,
}

/// The commands of a curve.
///
/// # Errors
/// A curve that the format cannot hold, as what was found and what was expected.
pub(crate) fn codev_curve(curve: &Curve) -> Result<CodevShape, Refusal> {
    let plain = CodevShape {
        radius_mm: curve.radius_mm().unwrap_or(0.0),
        commands: conic(curve.conic),
        offset_mm: 0.0,
    };
    if let Some(powers) = added_powers(curve) {
        return of_powers(plain, curve.conic, &powers);
    }
    match &curve.shape {
        Some(Shape::Polynomial(sum)) => {
            of_products(plain, curve.conic, &added_products(curve, sum))
        }
        Some(Shape::Zernike(sum)) => {
            let mut products =
                PowerProducts::of_even_powers(&[&[0.0], curve.aspheric.as_slice()].concat());
            for (powers, a) in zernike_products(sum.norm_radius_mm, &sum.coefficients_um) {
                products.add(&PowerProducts::of(powers, 1e-3 * a));
            }
            of_products(plain, curve.conic, &products)
        }
        Some(Shape::Biconic(one)) => {
            let across = (one.radius_x_mm, one.conic_x);
            Ok(biconic((one.radius_y_mm, one.conic_y), across))
        }
        Some(Shape::Cylinder(one)) => Ok(match one.straight_along {
            Straight::X => biconic((one.radius_mm, one.conic), (None, 0.0)),
            Straight::Y => biconic((None, 0.0), (one.radius_mm, one.conic)),
        }),
        Some(Shape::Toroid(one)) => toroid(one),
        other => Err(refused_shape(other.as_ref())),
    }
}

/// Conic sections along y and x, each with a radius and a conic constant.
fn biconic(y: (Option<f64>, f64), x: (Option<f64>, f64)) -> CodevShape {
    CodevShape {
        radius_mm: y.0.unwrap_or(0.0),
        commands: vec![
            "AAS".to_owned(),
            format!("KY {}", written(y.1)),
            format!("CUX {}", written(of_radius(x.0))),
            format!("KX {}", written(x.1)),
        ],
        offset_mm: 0.0,
    }
}

fn toroid(one: &ToroidShape) -> Result<CodevShape, Refusal> {
    let mut commands = vec![
        "YTO".to_owned(),
        format!("CUX {}", written(of_radius(one.rotation_radius_mm))),
        format!("K {}", written(one.conic)),
    ];
    let even = (2..).zip(&one.aspheric).map(|(i, a)| (2 * i, *a));
    commands.extend(asphere(&even.collect()).ok_or_else(|| {
        let found = format!("{} coefficients of a toroid", one.aspheric.len());
        (found, "up to nine, to y²⁰".to_owned())
    })?);
    Ok(CodevShape {
        radius_mm: one.radius_mm.unwrap_or(0.0),
        commands,
        offset_mm: 0.0,
    })
}

/// The curvature of a radius.
fn of_radius(radius: Option<f64>) -> f64 {
    radius.map_or(0.0, |radius| 1.0 / radius)
}

fn conic(conic: f64) -> Vec<String> {
    match conic == 0.0 {
        true => Vec::new(),
        false => vec!["CON".to_owned(), format!("K {}", written(conic))],
    }
}

/// Coefficients of r⁴ to r²⁰; none where there are other powers.
fn asphere(powers: &BTreeMap<usize, f64>) -> Option<Vec<String>> {
    let command = |(power, a): (&usize, &f64)| {
        let word = POWERS.get((power / 2).checked_sub(2)?)?;
        (power.is_multiple_of(2)).then(|| format!("{word} {}", written(*a)))
    };
    powers.iter().map(command).collect()
}

fn of_powers(
    plain: CodevShape,
    conic: f64,
    powers: &BTreeMap<usize, f64>,
) -> Result<CodevShape, Refusal> {
    if powers.is_empty() {
        return Ok(plain);
    }
    let mut commands = vec!["ASP".to_owned(), format!("K {}", written(conic))];
    if let Some(even) = asphere(powers) {
        commands.extend(even);
        return Ok(CodevShape { commands, ..plain });
    }
    let highest = powers.keys().next_back().copied().unwrap_or(0);
    if highest > HIGHEST_POWER {
        let found = format!("powers of the radius up to {highest}");
        let expected = format!("even powers from 4 to 20, or any up to {HIGHEST_POWER}");
        return Err((found, expected));
    }
    let coefficients = powers.iter().map(|(power, a)| (power + 1, *a));
    Ok(CodevShape {
        commands: special("SPS ODD", conic, coefficients),
        ..plain
    })
}

fn of_products(
    plain: CodevShape,
    conic: f64,
    products: &PowerProducts,
) -> Result<CodevShape, Refusal> {
    let list = listed(products)?;
    let coefficients = (2..).zip(list).filter(|(_, a)| *a != 0.0);
    Ok(CodevShape {
        commands: special("SPS XYP", conic, coefficients),
        offset_mm: products.at([0, 0]),
        ..plain
    })
}

/// A special surface with a conic constant and numbered coefficients.
fn special(
    word: &str,
    conic: f64,
    coefficients: impl Iterator<Item = (usize, f64)>,
) -> Vec<String> {
    let mut commands = vec![word.to_owned(), format!("SCO K {}", written(conic))];
    commands.extend(coefficients.map(|(number, a)| format!("SCO C{number} {}", written(a))));
    commands
}

/// Coefficients of x, y, x², …
fn listed(products: &PowerProducts) -> Result<Vec<f64>, Refusal> {
    let degree = products.degree();
    match degree <= HIGHEST_DEGREE {
        true => Ok(products.listed(1.0)),
        false => Err((
            format!("products of powers of x and y up to degree {degree}"),
            format!("up to degree {HIGHEST_DEGREE}"),
        )),
    }
}

/// The commands of a phase, at a wavelength in µm.
///
/// # Errors
/// A phase that the format cannot hold, as what was found and what was expected.
pub(crate) fn codev_phase(layer: &Layer, wavelength_um: f64) -> Result<Vec<String>, Refusal> {
    // The format has path lengths in mm in place of radians.
    let scale = wavelength_um * 1e-3 / TAU;
    let (kind, list) = match layer {
        Layer::Grating(one) => {
            let (sin, cos) = one.direction_deg.to_radians().sin_cos();
            // Lines along an axis have no rest of rounding.
            let [x, y] = [cos, sin].map(|part| if part.abs() < 1e-15 { 0.0 } else { part });
            return Ok(vec![
                "DIF GRT".to_owned(),
                format!("GRO {}", one.order),
                format!("GRS {}", written(one.period_um * 1e-3)),
                format!("GRX {}; GRY {}; GRZ 0", written(x), written(y)),
            ]);
        }
        Layer::Radial(one) => {
            let powers = (1..).zip(&one.coefficients);
            let list = powers.map(|(i, a)| a * one.norm_radius_mm.powi(-2 * i));
            ("HCT R", list.collect::<Vec<f64>>())
        }
        Layer::Polynomial(one) => {
            let mut sum = PowerProducts::default();
            for term in &one.terms {
                let size = one.norm_radius_mm.powi(-((term.x + term.y) as i32));
                sum.add(&PowerProducts::of(
                    [term.x, term.y],
                    term.coefficient * size,
                ));
            }
            ("HCT XY", listed(&sum)?)
        }
        _ => {
            return Err((
                "an unknown phase".to_owned(),
                "radial, xy or grating".to_owned(),
            ));
        }
    };
    if list.len() > MOST_EVEN {
        let found = format!("{} coefficients of a phase", list.len());
        return Err((found, format!("up to {MOST_EVEN}")));
    }
    let mut commands = vec![
        "DIF DOE".to_owned(),
        "HOR 1".to_owned(),
        format!("HWL {}", written(nanometres(wavelength_um))),
        kind.to_owned(),
    ];
    let used = (1..).zip(list).filter(|(_, a)| *a != 0.0);
    commands.extend(
        used.map(|(number, a): (usize, f64)| format!("HCO C{number} {}", written(scale * a))),
    );
    Ok(commands)
}

/// A wavelength in nm that gives the same number of µm when it is divided by 1000, where there is one.
pub(crate) fn nanometres(um: f64) -> f64 {
    let near = um * 1e3;
    let candidates = [near, near.next_up(), near.next_down()];
    let same = candidates.into_iter().find(|nm| nm / 1e3 == um);
    same.unwrap_or(near)
}

/// The commands of a turn of the axis: CODE V turns about x and y left-handed.
pub(crate) fn codev_turn(turn: Turn) -> Vec<String> {
    let [x, y] = turn.decenter_mm;
    let [a, b, c] = turn.tilt_deg;
    // REV takes back what its numbers say.
    let (shift, angles, last) = match turn.tilt_first {
        true => ([0.0 - x, 0.0 - y], [a, b, 0.0 - c], Some("REV")),
        false => ([x, y], [0.0 - a, 0.0 - b, c], None),
    };
    let words = ["XDE", "YDE", "ADE", "BDE", "CDE"];
    let values = shift.into_iter().chain(angles);
    let used = words.iter().zip(values).filter(|(_, value)| *value != 0.0);
    let mut commands: Vec<String> = used
        .map(|(word, value)| format!("{word} {}", written(value)))
        .collect();
    if !commands.is_empty() {
        commands.extend(last.map(str::to_owned));
    }
    commands
}
