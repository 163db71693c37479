//! What may be wrong with one part, and the error that says so.

use crate::optics::aperture::{Aperture, Outline};
use crate::optics::doe::{Doe, Layer};
use crate::optics::pixels::pixel_axes::is_same_from_pixels;
use crate::optics::pixels::pixel_grid::Pixels;
use crate::optics::screen::Sensor;
use crate::optics::shape::Shape;

/// Why a system cannot be built: the first part that is wrong, what was found, and what is expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{part}: found {found}, expected {expected}")]
pub struct BuildError {
    /// The part, such as `surface 2` or `element 'hologram'`.
    pub part: String,
    /// What was found.
    pub found: String,
    /// What is expected there.
    pub expected: String,
}

/// What was found and what is expected, of a part that is known elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mismatch {
    /// What was found.
    pub found: String,
    /// What is expected there.
    pub expected: &'static str,
}

impl Mismatch {
    /// Of what was found, and what is expected in its place.
    pub(crate) fn new(found: impl Into<String>, expected: &'static str) -> Self {
        Self {
            found: found.into(),
            expected,
        }
    }
}

/// A length or wavelength above zero.
pub(crate) fn check_above_zero(what: &str, value: f64) -> Result<(), Mismatch> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(Mismatch::new(
            format!("{what} of {value} mm"),
            "one above zero",
        )),
    }
}

/// A place aside of the axis in mm and angles in rad must be numbers.
pub(crate) fn check_finite(decentre: &[f64; 2], tilt: &[f64; 3]) -> Result<(), Mismatch> {
    match decentre.iter().chain(tilt).all(|number| number.is_finite()) {
        true => Ok(()),
        false => Err(Mismatch::new(
            format!("an offset of {decentre:?} mm and angles of {tilt:?} rad"),
            "finite numbers",
        )),
    }
}

/// A surface must be curved by finite numbers, and exist all over its aperture.
pub(crate) fn check_face(shape: &Shape, aperture: &Aperture) -> Result<(), Mismatch> {
    if let Shape::Conic(conic) = shape
        && !conic.curvature.is_finite()
    {
        let found = format!("a curvature of {} per mm", conic.curvature);
        let expected = "a radius that is not zero; infinite for a plane";
        return Err(Mismatch::new(found, expected));
    }
    check_aperture(aperture)?;
    match missing_point(shape, aperture, f64::MAX) {
        None => Ok(()),
        Some([x, y]) => {
            let found =
                format!("an aperture at ({x:.6}, {y:.6}) mm, where the surface does not exist");
            Err(Mismatch::new(found, "an aperture all over which it exists"))
        }
    }
}

/// A point of the aperture, in mm, where the surface does not exist or is further than `highest` mm from its local
/// plane.
pub(crate) fn missing_point(shape: &Shape, aperture: &Aperture, highest: f64) -> Option<[f64; 2]> {
    let exists = |[x, y]: &[f64; 2]| {
        let height = shape.height(*x, *y);
        height.is_some_and(|here| here.z.abs() <= highest)
    };
    // Away from its axis the height of a conic only grows: the farthest point of the aperture decides for all.
    let circle = aperture.circumcircle();
    let farthest = circle.map(|([x, y], radius)| [x.hypot(y) + radius, 0.0]);
    if matches!(shape, Shape::Plane | Shape::Conic(_)) && farthest.is_some_and(|at| exists(&at)) {
        return None;
    }
    let mut points = aperture.rim().into_iter().chain(aperture.inside());
    points.find(|point| !exists(point))
}

/// An aperture must have a width above zero.
pub(crate) fn check_aperture(aperture: &Aperture) -> Result<(), Mismatch> {
    if let Outline::Disc { radius } = aperture.outline {
        return check_above_zero("a radius of the aperture", radius);
    }
    let Some([x0, x1, y0, y1]) = aperture.bounds() else {
        return Ok(());
    };
    check_above_zero("a width of the aperture", x1 - x0)?;
    check_above_zero("a height of the aperture", y1 - y0)
}

/// An element must have an edge, and pixels that are numbers on one lattice.
pub(crate) fn check_element(doe: &Doe) -> Result<(), Mismatch> {
    check_aperture(&doe.aperture)?;
    for layer in &doe.layers {
        if let Layer::Pixels(pixels) = layer {
            check_pixels(pixels)?;
        }
    }
    if doe.bounds().is_none() {
        let expected = "an aperture, or a layer of pixels";
        return Err(Mismatch::new("no edge", expected));
    }
    match doe.shares_lattice() {
        true => Ok(()),
        false => Err(Mismatch::new(
            "pixel grids of different pitch, size, pixel form, fill or place in one element",
            "grids that share their lattice; or two elements at a distance",
        )),
    }
}

/// Pixels on a curved surface stand at its vertex.
pub(crate) fn check_places(shape: &Shape, doe: &Doe) -> Result<(), Mismatch> {
    match is_same_from_pixels(shape, doe) {
        true => Ok(()),
        false => Err(Mismatch::new(
            "pixels that are off centre, or turned, on a curved surface",
            "centred pixels on an element that is moved and turned as a whole, or a plane element",
        )),
    }
}

/// An element with a medium behind it must let light through.
pub(crate) fn check_transmits(doe: &Doe) -> Result<(), Mismatch> {
    match doe.reflect {
        false => Ok(()),
        true => Err(Mismatch::new(
            "light that goes on by reflection, and a medium behind the element",
            "exactly one of the two",
        )),
    }
}

fn check_pixels(pixels: &Pixels) -> Result<(), Mismatch> {
    for pitch in pixels.pitch {
        check_above_zero("a pitch", pitch)?;
    }
    if pixels.values.is_empty() {
        return Err(Mismatch::new("no pixels", "at least one"));
    }
    match pixels.values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => {
            let found = format!("a pixel of {value}");
            Err(Mismatch::new(found, "finite transmissions"))
        }
    }
}

/// A sensor must have pixels of a size.
pub(crate) fn check_sensor(sensor: &Sensor) -> Result<(), Mismatch> {
    for pitch in sensor.pitch {
        check_above_zero("a pitch", pitch)?;
    }
    match sensor.pixels.contains(&0) {
        true => Err(Mismatch::new(
            format!("{:?} pixels", sensor.pixels),
            "at least one each way",
        )),
        false => Ok(()),
    }
}

/// A distance must have the sign of the way that light runs.
pub(crate) fn check_heading(distance: f64, towards: f64) -> Result<(), Mismatch> {
    match expected_heading(distance, towards) {
        None => Ok(()),
        Some(expected) => {
            let found = format!("a distance of {distance} mm");
            Err(Mismatch::new(found, expected))
        }
    }
}

/// What is expected in place of a distance that is not the way light runs; nothing where it is.
pub(crate) fn expected_heading(distance: f64, towards: f64) -> Option<&'static str> {
    if distance * towards >= 0.0 && distance.is_finite() {
        return None;
    }
    Some(match towards > 0.0 {
        true => "zero or more: no mirror has turned the light back",
        false => "zero or less: after an odd number of mirrors light runs towards -z",
    })
}
