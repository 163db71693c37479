//! A sphere about the part of a surface inside its aperture, and the directions in which a point sees it: rays along
//! others miss the surface or are clipped.

use crate::math::vec3::Vec3;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;

/// Samples of the height along each axis, from which its bounds come.
const SAMPLES: usize = 17;

/// Rounding of the sphere and of the rays, over the distances.
const ROUNDING: f64 = 1e-9;

/// A sphere in global coordinates, in mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundingSphere {
    centre: Vec3,
    radius: f64,
}

/// Optical direction cosines, as discs in their plane: `[p_x, p_y, radius]`.
#[derive(Clone, Debug)]
pub(crate) struct SeenDirections(Vec<[f64; 3]>);

impl BoundingSphere {
    /// About what a surface has inside its aperture; nothing without an edge, or where it has no finite height.
    pub(crate) fn of(surface: &Surface) -> Option<Self> {
        let ([x, y], radius) = surface.aperture.circumcircle()?;
        let [low, high] = heights(&surface.shape, surface.aperture.bounds()?)?;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        Some(Self {
            centre: surface.frame.to_global(Vec3::new(x, y, middle)),
            radius: radius.hypot(half),
        })
    }

    /// The directions in which it is seen from above (x, y) on a screen, which rays leave; nothing from inside, from
    /// where all are. Surfaces are met backwards too, so that the opposite directions belong to them.
    pub(crate) fn seen_from(&self, screen: &Screen, [x, y]: [f64; 2]) -> Option<SeenDirections> {
        let start = screen.shape.height(x, y)?.z;
        let way = self.centre - screen.frame.to_global(Vec3::new(x, y, start));
        let distance = way.norm();
        let rounding = ROUNDING * (distance + self.centre.norm());
        let sine = (self.radius + rounding) / distance;
        if sine.is_nan() || sine >= 1.0 {
            return None;
        }

        // Unit vectors within the angle asin(sine) are no farther apart than this chord, and so are their projections.
        let chord = 2.0 * (0.5 * sine.asin()).sin() + ROUNDING;
        let towards = screen.frame.direction_to_local(way * (1.0 / distance));
        let n = screen.index_behind();
        let leaves = |sign: &f64| sign * towards.z * screen.leaves() >= -chord;
        let disc = |sign: f64| [sign * n * towards.x, sign * n * towards.y, n * chord];
        let signs = [1.0, -1.0].into_iter().filter(leaves);
        Some(SeenDirections(signs.map(disc).collect()))
    }
}

impl SeenDirections {
    /// Whether none of a square of direction cosines is among them.
    pub(crate) fn misses(&self, centre: [f64; 2], half: f64) -> bool {
        self.0.iter().all(|[x, y, radius]| {
            let beside = |a: f64, b: f64| ((a - b).abs() - half).max(0.0);
            beside(centre[0], *x).hypot(beside(centre[1], *y)) > *radius
        })
    }
}

/// Bounds of the height over a box `[x_min, x_max, y_min, y_max]`, from samples and their slopes over a whole step, twice
/// the way to the nearest sample.
fn heights(shape: &Shape, [x0, x1, y0, y1]: [f64; 4]) -> Option<[f64; 2]> {
    let parts = (SAMPLES - 1) as f64;
    let (dx, dy) = ((x1 - x0) / parts, (y1 - y0) / parts);
    let all = (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| (i as f64, j as f64)));
    let sampled = all.filter_map(|(i, j)| shape.height(x0 + i * dx, y0 + j * dy));
    let nothing = [f64::INFINITY, f64::NEG_INFINITY];
    let bounds = sampled.fold(nothing, |[low, high], height| {
        let change = height.slope[0].abs() * dx + height.slope[1].abs() * dy;
        [low.min(height.z - change), high.max(height.z + change)]
    });
    let [low, high] = bounds;
    (low <= high && (high - low).is_finite()).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use crate::engine::trace::bounding_sphere::BoundingSphere;
    use crate::fixtures::parts::{on_axis, open_screen};
    use crate::math::random::pair;
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::conic::Conic;
    use crate::optics::frame::Frame;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::shape::Shape;
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;

    fn surface(frame: Frame, aperture: Aperture) -> Surface {
        Surface {
            frame,
            shape: Shape::Asphere {
                base: Conic {
                    curvature: -0.3,
                    conic: 0.4,
                },
                coefficients: vec![2e-3],
            },
            aperture,
            interface: Interface::Reflect,
            coating: Coating::Unit,
            index: [1.0, 1.0],
        }
    }

    /// Rays of all directions, from places in front of, beside and behind a tilted bowl with an aperture off its axis: none
    /// that gets through misses its sphere, nor do squares of directions about it, and most squares that miss are found.
    #[test]
    fn rays_that_get_through_are_among_the_directions_that_are_seen() {
        let (from, to) = (open_screen(on_axis(0.0)), open_screen(on_axis(-50.0)));
        let (mut through, mut out, mut lost) = (0, 0, 0);
        for depth in [-9.0, 3.0, 12.0] {
            let frame = on_axis(depth).tilted([20.0, -10.0, 5.0]);
            let aperture = Aperture {
                outline: Outline::Rectangle {
                    half_x: 1.0,
                    half_y: 2.0,
                },
                centre: [0.4, -0.2],
            };
            let train = [surface(frame, aperture.blocked(Aperture::disc(0.3)))];
            let hop = Hop {
                wavelength: 0.5e-3,
                from: &from,
                train: &train,
                to: &to,
            };
            let sphere = BoundingSphere::of(&train[0]).unwrap();
            for i in 0..20_000 {
                let at = pair(3, [i, 0, 0, 0]).map(|u| 16.0 * (u - 0.5));
                let p = pair(4, [i, 0, 0, 0]).map(|u| 2.0 * (u - 0.5));
                let met = hop.trace(at, p, &mut ()).is_ok();
                let Some(seen) = sphere.seen_from(&from, at) else {
                    continue;
                };
                let half = 0.01 * f64::from(i % 7);
                let misses = seen.misses([p[0] + half, p[1] - half], half);
                assert!(!(met && misses), "{at:?} {p:?} {depth}");
                through += u32::from(met);
                out += u32::from(misses);
                lost += u32::from(!met);
            }
        }
        assert!(
            through > 200 && 10 * out > 6 * lost,
            "{through} {out} {lost}"
        );
    }

    /// A flat disc of 1.5 mm radius, 10 mm straight ahead: a ray to 1.499 mm from its middle is seen, one to 1.6 mm is not.
    #[test]
    fn a_flat_disc_is_seen_as_large_as_it_is() {
        let screen = open_screen(on_axis(0.0));
        let disc = Surface {
            shape: Shape::Plane,
            ..surface(on_axis(10.0), Aperture::disc(1.5))
        };
        let seen = BoundingSphere::of(&disc).unwrap();
        let seen = seen.seen_from(&screen, [0.0, 0.0]).unwrap();
        let cosine = |x: f64| x / x.hypot(10.0);
        assert!(!seen.misses([cosine(1.499), 0.0], 0.0));
        assert!(seen.misses([0.0, cosine(1.6)], 0.0));
    }

    /// From inside the sphere all directions are seen, and a surface without an edge has none.
    #[test]
    fn nothing_is_excluded_from_inside_or_without_an_edge() {
        let screen = open_screen(Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, -0.1)));
        let edged = surface(Frame::GLOBAL, Aperture::disc(1.5));
        let sphere = BoundingSphere::of(&edged).unwrap();
        assert!(sphere.seen_from(&screen, [0.3, 0.0]).is_none());
        assert!(sphere.seen_from(&screen, [9.0, 0.0]).is_some());
        assert!(BoundingSphere::of(&surface(Frame::GLOBAL, Aperture::OPEN)).is_none());
    }
}
