//! Elements on the axes of their pixels, so that these are centred and along x and y.
//!
//! Fields are sampled along the pixels of an element. Where those are off centre or turned, the whole screen is described on
//! their axes before light is carried: the frame moves, the pixels stand at its centre, and the aperture and the other layers
//! move the other way. On a curved surface only a turn about the axis of a surface of revolution leaves the shape as it is.

use crate::optics::doe::{Doe, Layer};
use crate::optics::phase::placement::Placement;
use crate::optics::pixels::pixel_grid::Pixels;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::system::System;

/// Whether a surface looks the same from the axes of the pixels over its x and y.
pub(crate) fn is_same_from_pixels(shape: &Shape, doe: &Doe) -> bool {
    let placement = placement_of(doe);
    let turned = placement.centre == [0.0; 2] && shape.is_round();
    placement.is_none() || *shape == Shape::Plane || turned
}

/// Where the pixels of an element over x and y stand on it.
fn placement_of(doe: &Doe) -> Placement {
    doe.pixels()
        .map_or(Placement::NONE, |pixels| pixels.placement)
}

/// A screen on the axes of its pixels.
pub(crate) fn on_pixel_axes(screen: &Screen) -> Screen {
    let ScreenKind::Doe(doe) = &screen.kind else {
        return screen.clone();
    };
    let placement = placement_of(doe);
    if placement.is_none() {
        return screen.clone();
    }
    Screen {
        frame: screen.frame.placed(placement.centre, placement.rotation),
        kind: ScreenKind::Doe(Doe {
            layers: seen_from(&doe.layers, placement),
            aperture: doe.aperture.seen_from(placement),
            reflect: doe.reflect,
        }),
        ..screen.clone()
    }
}

/// A system whose screens all stand on the axes of their pixels.
pub(crate) fn system_on_pixel_axes(system: &System) -> System {
    System {
        screens: system.screens.iter().map(on_pixel_axes).collect(),
        ..system.clone()
    }
}

/// Layers on the axes of a placement. Pixels over x and y share it.
fn seen_from(layers: &[Layer], placement: Placement) -> Vec<Layer> {
    let one = |layer: &Layer| match layer {
        Layer::Pixels(pixels) => Layer::Pixels(Pixels {
            placement: Placement::NONE,
            ..pixels.clone()
        }),
        Layer::Phase(profile) => Layer::Phase(profile.clone().placed(placement.inverse())),
        Layer::Sum(terms) => {
            let terms = terms.iter();
            Layer::Sum(
                terms
                    .map(|(weight, layers)| (*weight, seen_from(layers, placement)))
                    .collect(),
            )
        }
        // Of a surface that looks the same from there.
        Layer::OnSurface(own, layers) => {
            Layer::OnSurface(own.clone(), seen_from(layers, placement))
        }
    };
    layers.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{on_axis, pixel_layer, screen};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::pixel_axes::{is_same_from_pixels, on_pixel_axes};
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
    use crate::optics::screen::ScreenKind;
    use crate::optics::shape::{Conic, Shape};

    const PLACED: Placement = Placement {
        centre: [0.3, -0.2],
        rotation: 0.7,
    };

    fn element(placement: Placement) -> Doe {
        let Layer::Pixels(pixels) = pixel_layer(noise((9, 12), 0), 0.1, PixelForm::Box) else {
            panic!("pixels")
        };
        let pixels = Layer::Pixels(Pixels {
            placement,
            ..pixels
        });
        let lens = Profile::Lens {
            focal_length: 20.0,
            wavenumber: 9000.0,
        };
        let vortex = Profile::Vortex { charge: 2 }.placed(Placement {
            centre: [0.1, 0.05],
            rotation: -0.4,
        });
        let half = Complex64::new(0.5, 0.25);
        let sum = Layer::Sum(vec![
            (half, vec![pixels.clone()]),
            (half, vec![Layer::Phase(vortex)]),
        ]);
        Doe {
            layers: vec![pixels, Layer::Phase(lens), sum],
            aperture: Aperture::turned_rectangle(0.5, 0.4, 0.2, [0.25, -0.1])
                .blocked(Aperture::disc(0.1)),
            reflect: false,
        }
    }

    /// The same light passes every point, wherever the axes stand.
    #[test]
    fn a_screen_on_other_axes_is_the_same_screen() {
        let given = screen(on_axis(3.0), ScreenKind::Doe(element(PLACED)));
        let moved = on_pixel_axes(&given);
        let (ScreenKind::Doe(a), ScreenKind::Doe(b)) = (&given.kind, &moved.kind) else {
            panic!("{moved:?}")
        };
        assert!(b.pixels().unwrap().placement.is_none());
        let mut open = 0;
        for j in -20..=20 {
            for i in -20..=20 {
                let (x, y) = (f64::from(i) * 0.0437, f64::from(j) * 0.0391);
                let there = moved
                    .frame
                    .to_local(given.frame.to_global(Vec3::new(x, y, 0.0)));
                let difference = a.transmission(x, y) - b.transmission(there.x, there.y);
                assert!(there.z.abs() < 1e-14 && difference.norm() < 1e-9, "{x} {y}");
                assert_eq!(
                    a.aperture.contains(x, y),
                    b.aperture.contains(there.x, there.y)
                );
                open += usize::from(a.aperture.contains(x, y));
            }
        }
        assert!(open > 300, "{open}");
    }

    #[test]
    fn curved_surfaces_allow_turns_about_their_axis_alone() {
        let sphere = Shape::Conic(Conic {
            curvature: 0.1,
            conic: 0.0,
        });
        let turned = Placement {
            centre: [0.0; 2],
            ..PLACED
        };
        assert!(is_same_from_pixels(&Shape::Plane, &element(PLACED)));
        assert!(is_same_from_pixels(&sphere, &element(turned)));
        assert!(is_same_from_pixels(&sphere, &element(Placement::NONE)));
        assert!(!is_same_from_pixels(&sphere, &element(PLACED)));
    }
}
