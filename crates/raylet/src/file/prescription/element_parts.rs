//! Parts of a scene's elements that an import makes and alters: rims, names, distances.

use crate::file::scene::aperture::{Aperture, Disc};
use crate::file::scene::element::Element;
use crate::file::scene::surface_shape::SurfaceShape;

/// A disc about the axis.
pub(crate) fn disc(radius_mm: f64) -> Aperture {
    Aperture {
        disc: Some(Disc {
            radius_mm,
            centre_mm: [0.0; 2],
        }),
        ..Aperture::default()
    }
}

/// A centred disc as the radius of a rim, or another aperture.
pub(crate) fn rim(aperture: Aperture) -> (Option<f64>, Option<Aperture>) {
    let radius = aperture.disc.as_ref().map(|disc| disc.radius_mm);
    match radius {
        Some(radius) if aperture == disc(radius) => (Some(radius), None),
        _ => (None, Some(aperture)),
    }
}

/// How far a first surface comes towards the light at a radius in mm.
pub(crate) fn hollow(element: &Element, radius: f64) -> f64 {
    height(element, radius).map_or(0.0, |height| (-height).max(0.0))
}

/// The height of a surface over its vertex in mm at a radius, the lower one of those along x and y; none where there is none.
pub(crate) fn height(element: &Element, radius: f64) -> Option<f64> {
    let curve: SurfaceShape<'_> = match element {
        Element::Surface(one) => one.surface_shape(),
        Element::Mirror(one) => one.surface_shape(),
        Element::Doe(one) => one.surface_shape(),
        _ => return None,
    };
    let shape = curve.optics(None)?;
    let [x, y] = [shape.sag(radius, 0.0)?, shape.sag(0.0, radius)?];
    Some(x.min(y))
}

/// Gives a surface a centred rim of this radius in mm.
pub(crate) fn widen(element: &mut Element, radius: f64) {
    let rim = match element {
        Element::Surface(one) => &mut one.semi_aperture_mm,
        Element::Mirror(one) => &mut one.semi_aperture_mm,
        _ => return,
    };
    *rim = Some(radius);
}

/// Gives an element the distance to the next one in mm; a sensor has none.
pub(crate) fn set_thickness(element: &mut Element, thickness: f64) {
    match element {
        Element::Doe(any) => any.thickness_mm = Some(thickness),
        Element::Lens(any) => any.thickness_mm = Some(thickness),
        Element::Surface(any) => any.thickness_mm = Some(thickness),
        Element::Mirror(any) => any.thickness_mm = Some(thickness),
        Element::ParaxialLens(any) => any.thickness_mm = Some(thickness),
        Element::Stop(any) => any.thickness_mm = Some(thickness),
        Element::CoordinateBreak(any) => any.thickness_mm = thickness,
        Element::Sensor(_) => {}
    }
}

/// Gives an element of an import its name.
pub(crate) fn name(element: &mut Element, word: String) {
    match element {
        Element::Doe(any) => any.name = Some(word),
        Element::Surface(any) => any.name = Some(word),
        Element::Mirror(any) => any.name = Some(word),
        Element::ParaxialLens(any) => any.name = Some(word),
        Element::Stop(any) => any.name = Some(word),
        _ => {}
    }
}
