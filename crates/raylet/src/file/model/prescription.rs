//! The parts of a system in the order light meets them, with the names the scene gives them.

use crate::file::model::build::SOURCE;
use crate::file::scene::element::{Element, LensElement};
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::optics::aperture::Aperture;
use crate::optics::frame::Frame;
use crate::optics::refraction::Interface;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::System;

/// A part of a system: a screen, or a surface between two screens.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    /// A place where the field is known.
    Screen(&'a Screen),
    /// A refracting or reflecting surface.
    Surface(&'a Surface),
}

/// One part of a system.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// The name of its element, or its path in the scene file.
    pub name: String,
    /// Whether the scene gives it that name.
    pub named: bool,
    /// Number of its element in the scene; none for the plane of a source, or an entrance that the scene does not state.
    pub element: Option<usize>,
    /// Number of the surface within its element, and how many there are.
    pub surface: [usize; 2],
    /// The part itself.
    pub kind: Kind<'a>,
    /// Name of the medium behind it.
    pub medium: String,
}

impl Part<'_> {
    /// Origin (in mm) and axes of the part, global.
    pub fn frame(&self) -> &Frame {
        match self.kind {
            Kind::Screen(screen) => &screen.frame,
            Kind::Surface(surface) => &surface.frame,
        }
    }

    /// Refractive index of the medium before it.
    pub fn index_before(&self) -> f64 {
        match self.kind {
            Kind::Screen(screen) => screen.index,
            Kind::Surface(surface) => surface.index[0],
        }
    }

    /// Refractive index of the medium behind it.
    pub fn index(&self) -> f64 {
        match self.kind {
            Kind::Screen(screen) => screen.index_behind(),
            Kind::Surface(surface) => surface.index[1],
        }
    }

    /// Kind of the part in one word, such as "stop", "mirror" or "sphere".
    pub fn word(&self) -> &'static str {
        match self.kind {
            Kind::Screen(screen) => match &screen.kind {
                ScreenKind::Stop(_) => "stop",
                ScreenKind::Doe(_) if self.element.is_none() => "source",
                ScreenKind::Doe(_) => "doe",
                ScreenKind::Sensor(_) => "sensor",
            },
            Kind::Surface(surface) => match (surface.interface, &surface.shape) {
                (Interface::Reflect, _) => "mirror",
                (Interface::Refract, Shape::Plane) => "plane",
                (Interface::Refract, Shape::Conic(conic)) if conic.conic == 0.0 => "sphere",
                (Interface::Refract, Shape::Conic(_)) => "conic",
                (Interface::Refract, Shape::Asphere { .. }) => "asphere",
                (Interface::Refract, Shape::Biconic(two)) => {
                    let flat = two.x.curvature == 0.0 || two.y.curvature == 0.0;
                    if flat { "cylinder" } else { "biconic" }
                }
                (Interface::Refract, Shape::Toroid(_)) => "toroid",
                (Interface::Refract, Shape::Freeform { .. }) => "freeform",
            },
        }
    }

    /// Height of the part over its local plane, as a function of x and y.
    pub fn shape(&self) -> &Shape {
        match self.kind {
            Kind::Screen(screen) => &screen.shape,
            Kind::Surface(surface) => &surface.shape,
        }
    }

    /// The part of it that is open; none for a sensor.
    pub fn aperture(&self) -> Option<&Aperture> {
        match self.kind {
            Kind::Surface(surface) => Some(&surface.aperture),
            Kind::Screen(screen) => match &screen.kind {
                ScreenKind::Stop(aperture) => Some(aperture),
                ScreenKind::Doe(doe) => Some(&doe.aperture),
                ScreenKind::Sensor(_) => None,
            },
        }
    }

    /// Its radii of curvature at the vertex along x and y in mm; none where it is straight.
    pub fn radii(&self) -> [Option<f64>; 2] {
        let height = self.shape().height(0.0, 0.0);
        let [x, _, y] = height.map_or([0.0; 3], |height| height.hessian);
        let radius = |curvature: f64| (curvature != 0.0).then(|| 1.0 / curvature);
        [x, y].map(|curvature| radius(curvature).filter(|radius| radius.is_finite()))
    }

    /// The part that is used, `[x_min, x_max, y_min, y_max]` in mm in its own frame; none without an edge.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        match self.kind {
            Kind::Screen(screen) => screen.bounds(),
            Kind::Surface(surface) => surface.aperture.bounds(),
        }
    }

    /// The tilt of its axis against the global z axis, in degrees: about x, then about the new y.
    pub fn tilt_deg(&self) -> [f64; 2] {
        let z = self.frame().z;
        let about_x = if z.y == 0.0 && z.z == 0.0 {
            0.0
        } else {
            (-z.y).atan2(z.z)
        };
        [about_x, z.x.clamp(-1.0, 1.0).asin()].map(f64::to_degrees)
    }
}

/// The parts of the system that [`system`](crate::file::model::build::system) made of a scene.
pub fn parts<'a>(scene: &Scene, system: &'a System) -> Vec<Part<'a>> {
    let mut kinds = in_order(system).into_iter().peekable();
    let ambient = medium_name(&scene.ambient);
    let mut medium = ambient.clone();
    let mut list = Vec::new();

    // The builder puts the plane on which the light is given first, or an entrance before a first surface.
    let first_bends = matches!(
        scene.element.iter().find(|e| !is_break(e)),
        Some(Element::Lens(_) | Element::Surface(_) | Element::Mirror(_))
    );
    let before = match (scene.source.plane(), first_bends) {
        (Some(_), _) => Some(SOURCE),
        (None, true) => Some("entrance"),
        (None, false) => None,
    };
    if let Some(name) = before
        && let Some(kind) = kinds.next()
    {
        list.push(Part {
            name: String::from(name),
            named: true,
            element: None,
            surface: [0, 1],
            kind,
            medium: medium.clone(),
        });
    }
    for (number, element) in scene.element.iter().enumerate() {
        let media = match element {
            Element::CoordinateBreak(_) => continue,
            Element::Lens(lens) => lens_media(lens, &ambient),
            Element::Surface(surface) => {
                vec![surface.glass.as_ref().map_or(ambient.clone(), medium_name)]
            }
            Element::Doe(doe) => {
                vec![doe.glass.as_ref().map_or(medium.clone(), medium_name)]
            }
            _ => vec![medium.clone()],
        };
        let count = media.len();
        for (index, after) in media.into_iter().enumerate() {
            let Some(kind) = kinds.next() else {
                return list;
            };
            medium = after;
            list.push(Part {
                name: scene.element_name(number),
                named: element.name().is_some(),
                element: Some(number),
                surface: [index, count],
                kind,
                medium: medium.clone(),
            });
        }
    }
    list
}

/// The screens and surfaces of a system as light meets them.
fn in_order(system: &System) -> Vec<Kind<'_>> {
    let mut list = Vec::new();
    for (number, screen) in system.screens.iter().enumerate() {
        list.push(Kind::Screen(screen));
        let train = system.trains.get(number).into_iter().flatten();
        list.extend(train.map(Kind::Surface));
    }
    list
}

fn is_break(element: &Element) -> bool {
    matches!(element, Element::CoordinateBreak(_))
}

fn lens_media(lens: &LensElement, ambient: &str) -> Vec<String> {
    let last = lens.surface.len() - 1;
    let media = lens.surface.iter().enumerate().map(|(number, surface)| {
        let glass = surface.glass.as_ref().filter(|_| number < last);
        glass.map_or(ambient.to_owned(), medium_name)
    });
    media.collect()
}

fn medium_name(material: &Material) -> String {
    match material {
        Material::Named(name) => name.clone(),
        Material::Own(own) => own.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::model::build::system;
    use crate::file::model::prescription::parts;
    use crate::file::scene::scene_file::Scene;

    #[test]
    fn every_part_is_named_and_placed() {
        let text = r#"version = 1
wavelength_um = 0.7
source = { kind = "plane", beam_radius_mm = 2 }
[[element]]
kind = "lens"
name = "L"
tilt_deg = [10, 5, 0]
thickness_mm = 5
surface = [
  { radius_mm = 25.8, thickness_mm = 5.3, glass = "N-BK7", semi_aperture_mm = 12.7 },
  { semi_aperture_mm = 12.7 },
]
[[element]]
kind = "coordinate_break"
[[element]]
kind = "stop"
thickness_mm = 3
aperture = { disc = { radius_mm = 1 } }
[[element]]
kind = "sensor"
pixels = [8, 8]
pitch_um = 10
"#;
        let scene = Scene::parse(text, Path::new("a.toml")).unwrap();
        let system = system(&scene, 0).unwrap();
        let parts = parts(&scene, &system);
        let columns: Vec<_> = parts
            .iter()
            .map(|p| (p.name.as_str(), p.word(), p.medium.as_str(), p.radii()[1]))
            .collect();
        assert_eq!(
            columns,
            [
                ("entrance", "stop", "air", None),
                ("L", "sphere", "N-BK7", Some(25.8)),
                ("L", "plane", "air", None),
                ("element[2]", "stop", "air", None),
                ("element[3]", "sensor", "air", None),
            ]
        );
        let [about_x, about_y] = parts[1].tilt_deg();
        assert!((about_x - 10.0).abs() < 1e-12 && (about_y - 5.0).abs() < 1e-12);
        assert!((parts[4].frame().origin.z - 13.3).abs() < 1e-12);
    }
}
