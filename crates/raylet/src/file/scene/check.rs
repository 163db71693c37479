//! Faults of a scene that no single value shows: parts that do not fit together.

use crate::file::decode::fault::Fault;
use crate::file::decode::origin::Origin;
use crate::file::decode::place::Place;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::aperture::Rim;
use crate::file::scene::element::{DoeElement, Element, LensElement, LensSurface};
use crate::file::scene::layer_check::check_element_layers;
use crate::file::scene::surface_shape::{SurfaceShape, check_extent};
use crate::optics::assembly::part_check::expected_heading;

/// How many radii, in how many directions, are looked at where two surfaces of a lens might cross.
const RADII: usize = 256;
const DIRECTIONS: usize = 16;

/// The most elements of a scene: each is compared with all others.
const MOST_ELEMENTS: usize = 10_000;

/// Checks the elements of a scene against each other. Surfaces whose array is not loaded yet are passed
/// over.
///
/// # Errors
/// The first fault along the axis, with its address.
pub(crate) fn check_elements(
    elements: &[Element],
    arrays: &Arrays,
    origin: &Origin,
) -> Result<(), Fault> {
    if elements.len() > MOST_ELEMENTS {
        let found = format!("{} elements", elements.len());
        return Err(origin.fault("element", found, format!("at most {MOST_ELEMENTS}")));
    }
    check_sensor(elements, origin)?;
    check_names(elements, origin)?;
    // +1 while light runs towards +z.
    let mut heading = 1.0;
    for (i, element) in elements.iter().enumerate() {
        let place = Place {
            origin,
            path: format!("element[{i}]"),
        };
        check_element(element, arrays, &place, heading)?;
        if element.reflects() {
            heading = -heading;
        }
        check_thickness(element, &place, heading)?;
    }
    Ok(())
}

/// There must be one sensor, at the end.
fn check_sensor(elements: &[Element], origin: &Origin) -> Result<(), Fault> {
    let mut sensors = (0..)
        .zip(elements)
        .filter_map(|(i, element)| matches!(element, Element::Sensor(_)).then_some(i));
    let last = elements.len().saturating_sub(1);
    let refuse = |i: usize, found: &str, expected: &str| {
        Err(origin.fault(&format!("element[{i}].kind"), found, expected))
    };
    match (sensors.next(), sensors.next()) {
        _ if elements.is_empty() => {
            Err(origin.fault("element", "no elements", "at least one, and a sensor"))
        }
        (None, _) => refuse(
            last,
            "no sensor",
            "an element of kind \"sensor\" at the end",
        ),
        (_, Some(second)) => refuse(second, "a second sensor", "one sensor"),
        (Some(i), None) if i < last => {
            refuse(i, "a sensor before other elements", "the sensor at the end")
        }
        _ => Ok(()),
    }
}

/// No two elements may share a name: reports and holograms find them by it.
fn check_names(elements: &[Element], origin: &Origin) -> Result<(), Fault> {
    for (i, element) in elements.iter().enumerate() {
        let Some(name) = element.name() else { continue };
        if elements
            .iter()
            .take(i)
            .any(|other| other.name() == Some(name))
        {
            return Err(origin.fault(
                &format!("element[{i}].name"),
                format!("the name \"{name}\" again"),
                "a name of its own",
            ));
        }
    }
    Ok(())
}

/// Checks the inside of one element.
fn check_element(
    element: &Element,
    arrays: &Arrays,
    place: &Place<'_>,
    heading: f64,
) -> Result<(), Fault> {
    match element {
        Element::Doe(doe) => {
            doe.aperture.check(&place.inner(".aperture"))?;
            check_coating(doe, &place.inner(".coating"))?;
            let aperture = Rim {
                semi_aperture_mm: None,
                aperture: Some(&doe.aperture),
            };
            check_surface(&doe.surface_shape(), &aperture, arrays, place)?;
            check_element_layers(doe, arrays, place)
        }
        Element::Stop(stop) => stop.aperture.check(&place.inner(".aperture")),
        Element::ParaxialLens(lens) => lens.aperture.check(&place.inner(".aperture")),
        Element::Lens(lens) => check_lens(lens, arrays, place, heading),
        Element::Surface(one) => check_surface(&one.surface_shape(), &one.rim(), arrays, place),
        Element::Mirror(one) => check_surface(&one.surface_shape(), &one.rim(), arrays, place),
        Element::CoordinateBreak(_) | Element::Sensor(_) => Ok(()),
    }
}

/// Only an element on an interface has a coating: one that reflects has no medium behind it, from which Fresnel's coefficients
/// would follow.
fn check_coating(doe: &DoeElement, place: &Place<'_>) -> Result<(), Fault> {
    match (&doe.coating, &doe.glass) {
        (Some(_), _) if doe.reflect => place.refuse(
            "a coating on an element that reflects light",
            "none: its layers alone say what it reflects",
        ),
        (Some(_), None) => place.refuse(
            "a coating on an element that is no interface",
            "none here, or the medium behind the element as its glass",
        ),
        _ => Ok(()),
    }
}

/// A surface must be described in one way, and exist up to its edge.
fn check_surface(
    shape: &SurfaceShape<'_>,
    rim: &Rim<'_>,
    arrays: &Arrays,
    place: &Place<'_>,
) -> Result<(), Fault> {
    shape.check(place)?;
    rim.check(place)?;
    match arrays.shape(shape, &place.path) {
        Some(shape) => check_extent(&shape, &rim.optics(), rim.key(), place),
        None => Ok(()),
    }
}

/// The distance to the next element must be there and lead the way light runs.
fn check_thickness(element: &Element, place: &Place<'_>, heading: f64) -> Result<(), Fault> {
    let free = matches!(element, Element::CoordinateBreak(_) | Element::Sensor(_));
    if free {
        return Ok(());
    }
    match element.thickness_mm() {
        None => place.refuse(
            "no `thickness_mm`",
            "the distance to the next element's vertex",
        ),
        Some(thickness) => check_heading(thickness, &place.inner(".thickness_mm"), heading),
    }
}

/// A distance must have the sign of the way light runs.
fn check_heading(thickness: f64, place: &Place<'_>, heading: f64) -> Result<(), Fault> {
    match expected_heading(thickness, heading) {
        None => Ok(()),
        Some(expected) => place.refuse(thickness.to_string(), expected),
    }
}

/// The surfaces of a lens must be complete, exist, and not cross.
fn check_lens(
    lens: &LensElement,
    arrays: &Arrays,
    place: &Place<'_>,
    heading: f64,
) -> Result<(), Fault> {
    if lens.surface.len() == 1 {
        return place.inner(".surface").refuse(
            "one surface",
            "at least two; a single one is kind \"surface\"",
        );
    }
    let part = |i: usize| place.inner(&format!(".surface[{i}]"));
    for (i, surface) in lens.surface.iter().enumerate() {
        check_surface(&surface.surface_shape(), &surface.rim(), arrays, &part(i))?;
        match lens.surface.get(i + 1) {
            Some(_) => check_gap(surface, &part(i), heading)?,
            None => check_last(surface, &part(i))?,
        }
    }
    let pairs = lens.surface.iter().zip(lens.surface.iter().skip(1));
    for (i, (front, back)) in pairs.enumerate() {
        check_order([front, back], arrays, [&part(i), &part(i + 1)], heading)?;
    }
    Ok(())
}

/// The last surface of a lens leads back into the ambient medium.
fn check_last(surface: &LensSurface, place: &Place<'_>) -> Result<(), Fault> {
    if surface.thickness_mm.is_some() {
        return place.inner(".thickness_mm").refuse(
            "a thickness on the last surface",
            "none here: the way to the next element is the lens's own thickness_mm",
        );
    }
    if surface.glass.is_some() {
        return place.inner(".glass").refuse(
            "a glass after the last surface",
            "none here: the ambient medium follows",
        );
    }
    Ok(())
}

/// Between two surfaces of a lens there must be a distance and a glass.
fn check_gap(surface: &LensSurface, place: &Place<'_>, heading: f64) -> Result<(), Fault> {
    let Some(thickness) = surface.thickness_mm else {
        return place.refuse("no `thickness_mm`", "the distance to the next surface");
    };
    if surface.glass.is_none() {
        return place.refuse("no `glass`", "the medium between this surface and the next");
    }
    check_heading(thickness, &place.inner(".thickness_mm"), heading)
}

/// Two neighbouring surfaces of a lens must keep their order within both apertures.
fn check_order(
    surfaces: [&LensSurface; 2],
    arrays: &Arrays,
    places: [&Place<'_>; 2],
    heading: f64,
) -> Result<(), Fault> {
    let shape = |surface: &LensSurface, place: &Place<'_>| {
        arrays.shape(&surface.surface_shape(), &place.path)
    };
    let (Some(front), Some(back)) = (shape(surfaces[0], places[0]), shape(surfaces[1], places[1]))
    else {
        return Ok(());
    };
    let reach = |surface: &LensSurface| {
        let bounds = surface.rim().optics().bounds().unwrap_or_default();
        bounds.into_iter().fold(0.0f64, |a, b| a.max(b.abs()))
    };
    let (reach, thickness) = (
        reach(surfaces[0]).min(reach(surfaces[1])),
        surfaces[0].thickness_mm.unwrap_or(0.0),
    );
    for (i, j) in (0..=RADII).flat_map(|i| (0..DIRECTIONS).map(move |j| (i, j))) {
        let r = reach * i as f64 / RADII as f64;
        let (sin, cos) = (std::f64::consts::TAU * j as f64 / DIRECTIONS as f64).sin_cos();
        let (x, y) = (r * cos, r * sin);
        let (Some(a), Some(b)) = (front.height(x, y), back.height(x, y)) else {
            continue;
        };
        if (thickness + b.z - a.z) * heading < 0.0 {
            return places[0].inner(".thickness_mm").refuse(
                format!(
                    "{thickness}, with which the next surface crosses this one at r = {r:.4} mm"
                ),
                "a thickness that keeps them apart within their apertures",
            );
        }
    }
    Ok(())
}
