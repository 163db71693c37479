//! Phases of layers in the forms that prescriptions hold: straight lines, powers of the radius, products of powers of x and y.

use std::f64::consts::TAU;

use crate::file::prescription::export::power_products::PowerProducts;
use crate::file::scene::layer::{
    FocusLayer, GratingLayer, KinoformLayer, Layer, PhaseTerm, PolynomialLayer, RadialLayer,
    ZernikeLayer,
};
use crate::optics::phase::placement::Placement;
use crate::optics::zernike::zernike_products;

/// Most terms of the series of a lens.
const MOST_TERMS: usize = 40;

/// The last term of that series at the edge, in rad.
const LAST_TERM: f64 = 1e-11;

/// Kinds of layers that are held, in words.
const HELD: &str = "layers of kind radial, xy, grating, zernike or lens, or a kinoform of these";

/// What was found and what was expected.
pub(crate) type Refusal = (String, String);

/// Where layers stand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// The scene's first wavelength in µm.
    pub first_um: f64,
    /// The index behind the element at that wavelength.
    pub index: f64,
    /// How far the element reaches from its axis in mm.
    pub reach_mm: f64,
}

/// A phase in one of the forms.
#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// Straight lines.
    Lines(GratingLayer),
    /// Coefficients of r², r⁴, … in rad and mm.
    Even(Vec<f64>),
    /// Products of powers of x and y in rad and mm.
    Products(PowerProducts),
}

/// A layer in a form, and what that changes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeldLayer {
    form: Form,
    /// What the form does not keep, in sentences.
    pub remarks: Vec<String>,
}

/// The form of a layer.
///
/// # Errors
/// A layer that no form holds, as what was found and what was expected.
pub(crate) fn held_layer(layer: &Layer, standing: Standing) -> Result<HeldLayer, Refusal> {
    let exact = |form| HeldLayer {
        form,
        remarks: Vec::new(),
    };
    Ok(match layer {
        Layer::Grating(one) => exact(Form::Lines(GratingLayer {
            direction_deg: one.direction_deg + one.rotation_deg,
            centre_mm: [0.0; 2],
            rotation_deg: 0.0,
            ..one.clone()
        })),
        Layer::Radial(one) => exact(of_radial(one)),
        Layer::Polynomial(one) => {
            exact(Form::Products(placed(&of_polynomial(one), one.placement())))
        }
        Layer::Zernike(one) => exact(Form::Products(placed(&of_zernike(one), one.placement()))),
        Layer::Lens(one) => of_lens(one, standing)?,
        Layer::Kinoform(one) => of_kinoform(one, standing)?,
        other => {
            let found = format!("a layer of kind \"{}\"", kind(other));
            return Err((found, HELD.to_owned()));
        }
    })
}

/// One layer with the phases of all; none where there is no phase.
pub(crate) fn joined(list: &[HeldLayer], reach_mm: f64) -> Option<Layer> {
    match whole(list) {
        Form::Lines(one) => (one.order != 0).then_some(Layer::Grating(one)),
        Form::Even(even) => {
            let powers = (1..).zip(&even);
            let coefficients: Vec<f64> = powers.map(|(i, a)| a * reach_mm.powi(2 * i)).collect();
            let used = coefficients.iter().any(|a| *a != 0.0);
            used.then_some(Layer::Radial(RadialLayer {
                norm_radius_mm: reach_mm,
                coefficients,
                centre_mm: [0.0; 2],
                rotation_deg: 0.0,
            }))
        }
        Form::Products(sum) => {
            // A constant phase changes nothing.
            let terms = sum.terms().filter(|(powers, _)| *powers != [0, 0]);
            let terms: Vec<PhaseTerm> = terms
                .map(|([x, y], a)| PhaseTerm {
                    x,
                    y,
                    coefficient: a * reach_mm.powi((x + y) as i32),
                })
                .collect();
            (!terms.is_empty()).then_some(Layer::Polynomial(PolynomialLayer {
                norm_radius_mm: reach_mm,
                terms,
                centre_mm: [0.0; 2],
                rotation_deg: 0.0,
            }))
        }
    }
}

/// The phases of all in the simplest form.
fn whole(list: &[HeldLayer]) -> Form {
    if let [HeldLayer { form, .. }] = list {
        return form.clone();
    }
    let mut even: Vec<f64> = Vec::new();
    for held in list {
        let Form::Even(own) = &held.form else {
            let mut sum = PowerProducts::default();
            list.iter().for_each(|held| sum.add(&products(&held.form)));
            return Form::Products(sum);
        };
        even.resize(even.len().max(own.len()), 0.0);
        even.iter_mut().zip(own).for_each(|(all, a)| *all += a);
    }
    Form::Even(even)
}

/// A form as products of powers.
fn products(form: &Form) -> PowerProducts {
    match form {
        Form::Lines(one) => {
            let rate = TAU * f64::from(one.order) / (one.period_um * 1e-3);
            let (sin, cos) = one.direction_deg.to_radians().sin_cos();
            let mut sum = PowerProducts::of([1, 0], rate * cos);
            sum.add(&PowerProducts::of([0, 1], rate * sin));
            sum
        }
        Form::Even(coefficients) => PowerProducts::of_even_powers(coefficients),
        Form::Products(sum) => sum.clone(),
    }
}

/// A sum over own coordinates as one over those of the element.
fn placed(sum: &PowerProducts, placement: Placement) -> PowerProducts {
    if placement == Placement::NONE {
        return sum.clone();
    }
    let (sin, cos) = placement.rotation.sin_cos();
    let [cx, cy] = placement.centre;
    let line = |a: f64, b: f64| {
        let mut line = PowerProducts::of([1, 0], a);
        line.add(&PowerProducts::of([0, 1], b));
        line.add(&PowerProducts::of([0, 0], -(a * cx + b * cy)));
        line
    };
    sum.with([&line(cos, sin), &line(-sin, cos)])
}

fn of_radial(one: &RadialLayer) -> Form {
    let radius = one.norm_radius_mm;
    let powers = (1..).zip(&one.coefficients);
    let even: Vec<f64> = powers.map(|(i, a)| a * radius.powi(-2 * i)).collect();
    match one.centre_mm == [0.0; 2] {
        true => Form::Even(even),
        false => Form::Products(placed(
            &PowerProducts::of_even_powers(&even),
            one.placement(),
        )),
    }
}

fn of_polynomial(one: &PolynomialLayer) -> PowerProducts {
    let mut sum = PowerProducts::default();
    for term in &one.terms {
        let scale = one.norm_radius_mm.powi(-((term.x + term.y) as i32));
        sum.add(&PowerProducts::of(
            [term.x, term.y],
            term.coefficient * scale,
        ));
    }
    sum
}

fn of_zernike(one: &ZernikeLayer) -> PowerProducts {
    let mut sum = PowerProducts::default();
    for (powers, a) in zernike_products(one.norm_radius_mm, &one.coefficients) {
        sum.add(&PowerProducts::of(powers, a));
    }
    sum
}

/// −k (√(r² + f²) − |f|) sign f as its series in r², up to a term that is too small to matter.
fn of_lens(one: &FocusLayer, standing: Standing) -> Result<HeldLayer, Refusal> {
    let made_for = one.wavelength_um.unwrap_or(standing.first_um) * 1e-3;
    let wavenumber = TAU * standing.index / made_for;
    series(one.focal_length_mm, wavenumber, one.placement(), standing)
}

/// The series of an ideal lens of this focal length and wavenumber in mm.
pub(crate) fn series(
    focal_length: f64,
    wavenumber: f64,
    placement: Placement,
    standing: Standing,
) -> Result<HeldLayer, Refusal> {
    let distance = placement.centre[0].hypot(placement.centre[1]);
    let edge = ((standing.reach_mm + distance) / focal_length).powi(2);
    if edge >= 1.0 {
        let found = "an ideal lens that is as wide as its focal length is long".to_owned();
        return Err((found, "a radius below the focal length".to_owned()));
    }
    let scale = -wavenumber * focal_length;
    let (mut binomial, mut even, mut last) = (0.5, Vec::new(), f64::INFINITY);
    while even.len() < MOST_TERMS && last > LAST_TERM {
        let order = even.len() as f64 + 1.0;
        even.push(scale * binomial * focal_length.powi(-2 * (order as i32)));
        last = (scale * binomial).abs() * edge.powf(order);
        binomial *= (0.5 - order) / (order + 1.0);
    }
    let remark = format!(
        "the phase of an ideal lens of f = {focal_length} mm is a series of {} even powers of the radius, whose last term has \
         {last:.1e} rad at the edge",
        even.len()
    );
    let form = match placement == Placement::NONE {
        true => Form::Even(even),
        false => Form::Products(placed(&PowerProducts::of_even_powers(&even), placement)),
    };
    Ok(HeldLayer {
        form,
        remarks: vec![remark],
    })
}

/// One order of a kinoform: the first where it is computed.
fn of_kinoform(one: &KinoformLayer, standing: Standing) -> Result<HeldLayer, Refusal> {
    let order = match one.orders.contains(&1) {
        true => 1,
        false => one.orders.first().copied().unwrap_or(1),
    };
    let (mut sum, mut remarks) = (Vec::new(), Vec::new());
    for layer in &one.layer {
        let mut held = held_layer(layer, standing)?;
        remarks.append(&mut held.remarks);
        sum.push(held);
    }
    remarks.push(format!(
        "of a kinoform order {order} is written with all its light: the light of other orders, and of this one at other \
         wavelengths, is not in the file"
    ));
    let form = match whole(&sum) {
        Form::Lines(one) => Form::Lines(GratingLayer {
            order: one.order.saturating_mul(order),
            ..one
        }),
        Form::Even(even) => Form::Even(even.iter().map(|a| f64::from(order) * a).collect()),
        Form::Products(sum) => Form::Products(sum.scaled(f64::from(order))),
    };
    Ok(HeldLayer { form, remarks })
}

/// The word of a layer's kind.
fn kind(layer: &Layer) -> &'static str {
    match layer {
        Layer::Pixels(_) => "pixels",
        Layer::Height(_) => "height",
        Layer::Grating(_) => "grating",
        Layer::Lens(_) => "lens",
        Layer::Axicon(_) => "axicon",
        Layer::Vortex(_) => "vortex",
        Layer::Radial(_) => "radial",
        Layer::RadialTable(_) => "radial_table",
        Layer::PhaseGrid(_) => "phase_grid",
        Layer::Zernike(_) => "zernike",
        Layer::Polynomial(_) => "xy",
        Layer::TwoPoint(_) => "two_point",
        Layer::Kinoform(_) => "kinoform",
        Layer::Sum(_) => "sum",
    }
}
