//! Curves and phases as surfaces of OpticStudio: a type and its numbers.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::file::prescription::export::held_phase::Refusal;
use crate::file::prescription::export::power_products::PowerProducts;
use crate::file::prescription::sequential::{Action, Curve, Face, Turn};
use crate::file::scene::layer::{GratingLayer, Layer};
use crate::file::scene::surface_shape::{
    PolynomialShape, Shape, Straight, ToroidShape, ZernikeShape,
};

/// The highest degree of products of powers; the format has no more terms.
const HIGHEST_DEGREE: u32 = 20;

/// Most terms of an extended asphere, of a radial phase, and of a Zernike sum.
const MOST_POWERS: usize = 240;
const MOST_ZERNIKE: usize = 231;

/// A surface of the format, lengths in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ZemaxType {
    /// The word of its type.
    pub word: &'static str,
    /// Curvature at the vertex.
    pub curvature: f64,
    /// Conic constant.
    pub conic: f64,
    /// Numbered parameters.
    pub parameter: Vec<(usize, f64)>,
    /// Extra data from number 1.
    pub extra: Vec<f64>,
    /// How far its vertex stands behind that of the scene's surface.
    pub offset_mm: f64,
}

/// The type of a surface.
///
/// # Errors
/// A curve or phase that the format cannot hold, as what was found and what was expected.
pub(crate) fn zemax_type(face: &Face) -> Result<ZemaxType, Refusal> {
    match face.action {
        Action::Turn(turn) => Ok(coordinate_break(turn)),
        Action::IdealLens(focal_length) => Ok(ZemaxType {
            word: "PARAXIAL",
            parameter: vec![(1, focal_length), (2, 1.0)],
            ..ZemaxType::default()
        }),
        Action::Border => match face.phase.first() {
            None => of_curve(&face.curve),
            Some(layer) => of_phase(&face.curve, layer),
        },
    }
}

fn coordinate_break(turn: Turn) -> ZemaxType {
    let [dx, dy] = turn.decenter_mm;
    let [x, y, z] = turn.tilt_deg;
    let order = if turn.tilt_first { 1.0 } else { 0.0 };
    ZemaxType {
        word: "COORDBRK",
        parameter: (1..).zip([dx, dy, x, y, z, order]).collect(),
        ..ZemaxType::default()
    }
}

/// All powers of the radius that a curve adds to its conic, by their exponents; none where its shape is no such sum.
pub(crate) fn added_powers(curve: &Curve) -> Option<BTreeMap<usize, f64>> {
    let mut powers = BTreeMap::new();
    match &curve.shape {
        None => {}
        Some(Shape::Odd(sum)) => {
            let terms = (1..).zip(&sum.coefficients);
            powers.extend(terms.map(|(power, a)| (power, *a)));
        }
        Some(_) => return None,
    }
    for (i, a) in (2..).zip(&curve.aspheric) {
        *powers.entry(2 * i).or_default() += a;
    }
    powers.retain(|_, a| *a != 0.0);
    Some(powers)
}

/// The products of powers that a curve adds to its conic, in mm; none where its shape is no such sum.
pub(crate) fn added_products(curve: &Curve, sum: &PolynomialShape) -> PowerProducts {
    let mut products = PowerProducts::of_even_powers(&[&[0.0], curve.aspheric.as_slice()].concat());
    for term in &sum.terms {
        let scale = sum.norm_radius_mm.powi(-((term.x + term.y) as i32));
        products.add(&PowerProducts::of(
            [term.x, term.y],
            1e-3 * term.height_um * scale,
        ));
    }
    products
}

/// Parameters 1 to 8: even powers up to r¹⁶; none where there are others.
fn even_parameters(powers: &BTreeMap<usize, f64>) -> Option<Vec<(usize, f64)>> {
    let fits = |power: &usize| power.is_multiple_of(2) && *power <= 16;
    let all = powers.keys().all(fits);
    all.then(|| powers.iter().map(|(power, a)| (power / 2, *a)).collect())
}

fn of_curve(curve: &Curve) -> Result<ZemaxType, Refusal> {
    let plain = ZemaxType {
        word: "STANDARD",
        curvature: curve.curvature,
        conic: curve.conic,
        ..ZemaxType::default()
    };
    if let Some(powers) = added_powers(curve) {
        return of_powers(plain, &powers);
    }
    match &curve.shape {
        Some(Shape::Polynomial(sum)) => {
            let products = added_products(curve, sum);
            let list = listed(&products)?;
            Ok(ZemaxType {
                word: "XPOLYNOM",
                extra: [vec![list.len() as f64, 1.0], list].concat(),
                offset_mm: products.at([0, 0]),
                ..plain
            })
        }
        Some(Shape::Zernike(sum)) => of_zernike(curve, sum, plain),
        Some(Shape::Biconic(one)) => {
            let across = [one.radius_x_mm.unwrap_or(0.0), one.conic_x];
            Ok(biconic(one.radius_y_mm, one.conic_y, across))
        }
        Some(Shape::Cylinder(one)) => Ok(match one.straight_along {
            Straight::X => biconic(one.radius_mm, one.conic, [0.0; 2]),
            Straight::Y => biconic(None, 0.0, [one.radius_mm.unwrap_or(0.0), one.conic]),
        }),
        Some(Shape::Toroid(one)) => toroid(one),
        other => Err(refused_shape(other.as_ref())),
    }
}

/// A Zernike Standard Sag, with even powers of the radius beside its terms.
fn of_zernike(curve: &Curve, sum: &ZernikeShape, plain: ZemaxType) -> Result<ZemaxType, Refusal> {
    let count = sum.coefficients_um.len();
    let even = (2..).zip(&curve.aspheric).filter(|(_, a)| **a != 0.0);
    let parameter: Vec<(usize, f64)> = even.map(|(i, a)| (i, *a)).collect();
    if count > MOST_ZERNIKE || parameter.iter().any(|(i, _)| *i > 8) {
        let found = format!("{count} Zernike terms, and powers of the radius beside them");
        let expected = format!("up to {MOST_ZERNIKE} terms, and powers up to r¹⁶");
        return Err((found, expected));
    }
    let heights = sum.coefficients_um.iter().map(|a| 1e-3 * a);
    let head = [count as f64, sum.norm_radius_mm];
    Ok(ZemaxType {
        word: "SZERNSAG",
        parameter,
        extra: head.into_iter().chain(heights).collect(),
        ..plain
    })
}

/// Conic sections along y, and along x with a radius and a conic constant.
fn biconic(along_y: Option<f64>, conic: f64, [radius_x, conic_x]: [f64; 2]) -> ZemaxType {
    ZemaxType {
        word: "BICONICX",
        curvature: along_y.map_or(0.0, |radius| 1.0 / radius),
        conic,
        parameter: vec![(1, radius_x), (2, conic_x)],
        ..ZemaxType::default()
    }
}

fn toroid(one: &ToroidShape) -> Result<ZemaxType, Refusal> {
    if one.aspheric.len() > 6 {
        let found = format!("{} coefficients of a toroid", one.aspheric.len());
        return Err((found, "up to six, to y¹⁴".to_owned()));
    }
    let mut parameter = vec![(1, one.rotation_radius_mm.unwrap_or(0.0))];
    parameter.extend((3..).zip(one.aspheric.iter().copied()));
    Ok(ZemaxType {
        word: "TOROIDAL",
        curvature: one.radius_mm.map_or(0.0, |radius| 1.0 / radius),
        conic: one.conic,
        parameter,
        ..ZemaxType::default()
    })
}

/// Why no format holds a shape.
pub(crate) fn refused_shape(shape: Option<&Shape>) -> Refusal {
    let kind = match shape {
        Some(Shape::Gaussian(_)) => "gaussian",
        Some(Shape::Grid(_)) => "grid",
        _ => "another kind",
    };
    let expected = "a conic, an asphere, odd, xy, zernike, biconic, cylinder or toroid";
    (format!("a shape of kind \"{kind}\""), expected.to_owned())
}

/// A conic with powers of the radius, in the simplest type.
fn of_powers(plain: ZemaxType, powers: &BTreeMap<usize, f64>) -> Result<ZemaxType, Refusal> {
    let highest = powers.keys().next_back().copied().unwrap_or(0);
    if highest == 0 {
        return Ok(plain);
    }
    if let Some(parameter) = even_parameters(powers) {
        return Ok(ZemaxType {
            word: "EVENASPH",
            parameter,
            ..plain
        });
    }
    if highest <= 8 {
        return Ok(ZemaxType {
            word: "ODDASPHE",
            parameter: powers.iter().map(|(power, a)| (*power, *a)).collect(),
            ..plain
        });
    }
    let even = powers.keys().all(|power| power.is_multiple_of(2));
    let (word, step) = if even {
        ("XASPHERE", 2)
    } else {
        ("XOSPHERE", 1)
    };
    let count = highest / step;
    if count > MOST_POWERS {
        let found = format!("powers of the radius up to {highest}");
        return Err((found, format!("up to {}", step * MOST_POWERS)));
    }
    let at = |i: usize| powers.get(&(i * step)).copied().unwrap_or(0.0);
    Ok(ZemaxType {
        word,
        extra: [count as f64, 1.0]
            .into_iter()
            .chain((1..=count).map(at))
            .collect(),
        ..plain
    })
}

/// Coefficients of x, y, x², … at a norm radius of 1 mm.
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

fn of_phase(curve: &Curve, layer: &Layer) -> Result<ZemaxType, Refusal> {
    let plain = ZemaxType {
        curvature: curve.curvature,
        conic: curve.conic,
        ..ZemaxType::default()
    };
    let refused = || {
        let found = "a phase on a surface of another shape".to_owned();
        let expected = "a conic with even powers of the radius up to r¹⁶".to_owned();
        (found, expected)
    };
    let powers = added_powers(curve).ok_or_else(refused)?;
    if let (Layer::Grating(one), true) = (layer, powers.is_empty())
        && let Some(sign) = along_y(one)
    {
        return Ok(ZemaxType {
            word: "DGRATING",
            parameter: vec![(1, sign / one.period_um), (2, f64::from(one.order))],
            ..plain
        });
    }
    let mut parameter = even_parameters(&powers).ok_or_else(refused)?;
    parameter.insert(0, (0, 1.0));
    let (word, norm_radius, list) = coefficients(layer)?;
    if list.len() > MOST_POWERS {
        let found = format!("{} coefficients of a phase", list.len());
        return Err((found, format!("up to {MOST_POWERS}")));
    }
    Ok(ZemaxType {
        word,
        parameter,
        extra: [vec![list.len() as f64, norm_radius], list].concat(),
        ..plain
    })
}

/// The type that holds a phase, its norm radius and its coefficients.
fn coefficients(layer: &Layer) -> Result<(&'static str, f64, Vec<f64>), Refusal> {
    match layer {
        Layer::Radial(one) => Ok(("BINARY_2", one.norm_radius_mm, one.coefficients.clone())),
        Layer::Grating(one) => {
            let rate = TAU * f64::from(one.order) / (one.period_um * 1e-3);
            let (sin, cos) = one.direction_deg.to_radians().sin_cos();
            Ok(("BINARY_1", 1.0, vec![rate * cos, rate * sin]))
        }
        Layer::Polynomial(one) => {
            let mut sum = PowerProducts::default();
            for term in &one.terms {
                sum.add(&PowerProducts::of([term.x, term.y], term.coefficient));
            }
            Ok(("BINARY_1", one.norm_radius_mm, listed(&sum)?))
        }
        _ => Err((
            "an unknown phase".to_owned(),
            "radial, xy or grating".to_owned(),
        )),
    }
}

/// The sign of a grating whose lines run along x; none for others.
fn along_y(grating: &GratingLayer) -> Option<f64> {
    match grating.direction_deg.rem_euclid(360.0) {
        90.0 => Some(1.0),
        270.0 => Some(-1.0),
        _ => None,
    }
}
