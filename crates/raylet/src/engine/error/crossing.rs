//! Parts that cross inside their openings: light runs backwards from one to the next there.

use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::frame::Frame;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::System;

/// Radii and directions at which two parts are compared, and the overlap in mm from which they cross.
const RADII: usize = 32;
const DIRECTIONS: usize = 16;
const OVERLAP: f64 = 1e-9;

/// A part as others may cross it.
struct Face<'a> {
    /// The screen that it is, or behind which it stands as the surface of this number.
    screen: &'a str,
    number: Option<usize>,
    frame: &'a Frame,
    shape: &'a Shape,
    aperture: Aperture,
    /// Whether it is matter: what follows a stop is compared with the part before the stop.
    solid: bool,
}

impl<'a> Face<'a> {
    fn of_screen(screen: &'a Screen) -> Self {
        let (aperture, solid) = match &screen.kind {
            ScreenKind::Stop(aperture) => (aperture.clone(), false),
            // The light of a source on a plane is an element without edge.
            ScreenKind::Doe(doe) => (doe.aperture.clone(), doe.aperture != Aperture::OPEN),
            ScreenKind::Sensor(sensor) => {
                let [half_x, half_y] =
                    [0, 1].map(|a| 0.5 * sensor.pixels[a] as f64 * sensor.pitch[a]);
                let outline = Outline::Rectangle { half_x, half_y };
                let centre = [0.0; 2];
                (Aperture { outline, centre }, true)
            }
        };
        Self {
            screen: &screen.name,
            number: None,
            frame: &screen.frame,
            shape: &screen.shape,
            aperture,
            solid,
        }
    }

    fn of_surface(surface: &'a Surface, number: usize, screen: &'a Screen) -> Self {
        Self {
            screen: &screen.name,
            number: Some(number + 1),
            frame: &surface.frame,
            shape: &surface.shape,
            aperture: surface.aperture.clone(),
            solid: true,
        }
    }

    /// How far from its origin its aperture reaches; nothing without an edge.
    fn reach(&self) -> Option<f64> {
        let bounds = self.aperture.bounds()?;
        Some(bounds.into_iter().fold(0.0f64, |most, b| most.max(b.abs())))
    }
}

/// The parts of a system that cross the part before them, as the hop in which they stand and the words. The system is taken as
/// it was given: with screens at its rims, surfaces have no edges.
pub(crate) fn crossings(system: &System) -> Vec<(usize, String)> {
    let mut before = system.screens.first().map(Face::of_screen);
    before = before.filter(|face| face.solid);
    let mut found = Vec::new();
    for (number, hop) in system.hops().enumerate() {
        let surfaces = hop.train.iter().enumerate();
        let surfaces = surfaces.map(|(i, surface)| Face::of_surface(surface, i, hop.from));
        for face in surfaces.chain([Face::of_screen(hop.to)]) {
            let text = before.as_ref().and_then(|before| crossing(before, &face));
            found.extend(text.map(|text| (number, text)));
            if face.solid {
                before = Some(face);
            }
        }
    }
    found
}

/// That two parts cross, and where most.
fn crossing(front: &Face, back: &Face) -> Option<String> {
    let ([x, y], overlap) = overlap(front, back)?;
    Some(format!(
        "{} cross inside their apertures: {:.4} mm from the axis the second stands {overlap:.2e} mm before the first",
        names(front, back),
        x.hypot(y),
    ))
}

/// What two parts are called together.
fn names(front: &Face, back: &Face) -> String {
    let name = |face: &Face| match face.number {
        Some(number) => format!("surface {number} behind '{}'", face.screen),
        None => format!("'{}'", face.screen),
    };
    match (front.number, back.number) {
        (Some(a), Some(b)) if front.screen == back.screen => {
            format!("surfaces {a} and {b} behind '{}'", front.screen)
        }
        (None, Some(number)) if front.screen == back.screen => {
            format!("'{}' and surface {number} behind it", front.screen)
        }
        _ => format!("{} and {}", name(front), name(back)),
    }
}

/// The place on a part where the next stands farthest before it, within both apertures, and by how many mm.
fn overlap(front: &Face, back: &Face) -> Option<([f64; 2], f64)> {
    let reach = front.reach().or(back.reach())?;
    // The way from one to the next runs towards the local +z or −z.
    let way = back.frame.to_local(front.frame.origin).z;
    if way == 0.0 {
        return None;
    }
    let places = (0..=RADII).flat_map(|i| (0..DIRECTIONS).map(move |j| (i, j)));
    let deep = places.filter_map(|(i, j)| {
        let (sin, cos) = (std::f64::consts::TAU * j as f64 / DIRECTIONS as f64).sin_cos();
        let r = reach * i as f64 / RADII as f64;
        let (x, y) = (r * cos, r * sin);
        if !front.aperture.contains(x, y) {
            return None;
        }
        let z = front.shape.height(x, y)?.z;
        let there = back
            .frame
            .to_local(front.frame.to_global(Vec3::new(x, y, z)));
        if !back.aperture.contains(there.x, there.y) {
            return None;
        }
        let gap = (back.shape.height(there.x, there.y)?.z - there.z) * -way.signum();
        (gap < -OVERLAP).then_some(([x, y], -gap))
    });
    deep.max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use crate::engine::error::crossing::crossings;
    use crate::fixtures::parts::{conic, element, face, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::surface::Surface;

    /// A surface of this curvature, 2 mm in radius, at z.
    fn surface(z: f64, curvature: f64, index: [f64; 2]) -> Surface {
        Surface {
            aperture: Aperture::disc(2.0),
            ..face(on_axis(z), conic(curvature, 0.0), index)
        }
    }

    fn system(screens: Vec<Screen>, trains: Vec<Vec<Surface>>) -> Vec<(usize, String)> {
        crossings(&lit(screens, trains))
    }

    fn stop(z: f64) -> Screen {
        screen(on_axis(z), ScreenKind::Stop(Aperture::disc(2.0)))
    }

    fn camera(z: f64) -> Screen {
        screen(on_axis(z), sensor(400, 0.01))
    }

    /// Two spheres of 5 mm with sags of 0.4174 mm at 2 mm overlap there by twice that, less the thickness; an entrance in the
    /// plane of the first vertex is no part.
    #[test]
    fn a_lens_that_is_too_thin_crosses_itself_at_its_edge() {
        let lens = |thickness: f64| {
            let train = vec![
                surface(0.0, 0.2, [1.0, 1.5]),
                surface(thickness, -0.2, [1.5, 1.0]),
            ];
            system(vec![stop(0.0), camera(9.0)], vec![train])
        };
        assert_eq!(lens(0.9), []);
        let found = lens(0.01);
        let [(0, text)] = found.as_slice() else {
            panic!("{found:?}")
        };
        assert!(
            text.contains("2.0000 mm") && text.contains("8.25e-1"),
            "{text}"
        );
    }

    /// The same lens with an element as one of its surfaces, and with a stop between them.
    #[test]
    fn an_element_on_a_surface_crosses_the_other_one() {
        let curved = |z: f64, curvature: f64| Screen {
            shape: conic(curvature, 0.0),
            ..screen(
                on_axis(z),
                ScreenKind::Doe(element(
                    Layer::Phase(Profile::Vortex { charge: 0 }),
                    Aperture::disc(2.0),
                )),
            )
        };
        let back = surface(0.01, -0.2, [1.5, 1.0]);
        let first = system(
            vec![curved(0.0, 0.2), camera(9.0)],
            vec![vec![back.clone()]],
        );
        assert!(
            first[0].1.starts_with("'element' and surface 1 behind it"),
            "{first:?}"
        );
        let front = surface(0.0, 0.2, [1.0, 1.5]);
        let screens = vec![stop(0.0), curved(0.01, -0.2), camera(9.0)];
        let last = system(screens, vec![vec![front.clone()], vec![]]);
        assert!(last[0].1.contains(" and 'element' cross"), "{last:?}");
        let iris = Screen {
            name: String::from("iris"),
            ..stop(0.005)
        };
        let screens = vec![stop(-1.0), iris, camera(9.0)];
        let between = system(screens, vec![vec![front], vec![back]]);
        assert!(
            between.iter().any(|(hop, text)| *hop == 1
                && text.starts_with("surface 1 behind 'stop' and surface 1 behind 'iris'")),
            "{between:?}"
        );
    }

    /// The rim of a meniscus stands 0.4174 mm behind its vertex.
    #[test]
    fn a_sensor_and_a_stop_may_stand_in_a_surface() {
        let behind = |last: fn(f64) -> Screen, z: f64| {
            let train = vec![surface(1.0, 0.2, [1.0, 1.5])];
            system(
                vec![
                    screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(2.0))),
                    last(z),
                ],
                vec![train],
            )
        };
        for last in [stop, camera] {
            assert_eq!(behind(last, 1.5), []);
            assert_eq!(behind(last, 1.3).len(), 1);
        }
    }
}
