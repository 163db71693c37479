//! The directions into which pixels send light, and how much goes into each.
//!
//! A pixel alone spreads light by its sinc². What many of them send is that times the power spectrum of their
//! transmissions about the place: smooth phases keep the light together, dark pixels send none. Where pixels are
//! going to change, as in a design, the spectrum is taken to be even.

use std::borrow::Cow;
use std::sync::Arc;

use num_complex::Complex64;
use raylet_fft::{Fft, Planner};

use crate::engine::rims::source_ray::{SourceRay, obliquity};
use crate::math::sinc::sinc;
use crate::optics::doe::Doe;
use crate::optics::system::Hop;

/// Directions along each axis, closer together about the middle, over all sines up to this one and over this
/// many orders of the pixels' lattice at least to each side.
const DIRECTIONS: usize = 21;
const STEEPEST: f64 = 1.2;
const ORDERS: f64 = 1.5;

/// Pixels along each axis of the patch whose spectrum is taken, and its points in each order.
const PATCH: usize = 32;

/// Orders up to which the spectrum is resolved. Beyond them pixels send a hundredth of the light, by the mean of the
/// spectrum over an order.
const RESOLVED: f64 = 8.0;

/// Where the mean of the spectrum stands along an axis, behind its points.
const MEAN: usize = PATCH;

/// Whether the pixels of an element are known or will change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelValues {
    /// They keep their values, and the spectrum of these counts.
    Fixed,
    /// They will have other values: all directions that a single pixel lights count.
    Varying,
}

/// What pixels of an element do to light, for rays that arrive anywhere on it.
pub(crate) struct PixelLight<'a> {
    /// With the mean of each pixel and its gap.
    doe: Cow<'a, Doe>,
    values: PixelValues,
    pitch: [f64; 2],
    /// The orders up to which directions reach.
    widest: [f64; 2],
    /// For each axis the points of the spectrum.
    axes: [Vec<Point>; 2],
    /// The transform of a row of the patch.
    fourier: Arc<dyn Fft<f64>>,
}

/// A point of the spectrum along an axis.
struct Point {
    /// Its direction from the ray's own, in orders of the lattice.
    order: f64,
    /// The share of a pixel's light about it: sinc² times the width that it represents.
    share: f64,
    /// Which direction it belongs to, and which point of an order it is, or [`MEAN`].
    direction: usize,
    within: usize,
}

/// What goes into a direction: its share of the light, and that times the order along x and y.
type Sent = [f64; 3];

impl<'a> PixelLight<'a> {
    /// Of the pixels of this element, at this wavelength; nothing if it has none.
    pub(crate) fn new(doe: &'a Doe, wavelength: f64, values: PixelValues) -> Option<Self> {
        let pitch = doe.pixels()?.pitch;
        let widest = pitch.map(|pitch| ORDERS.max(STEEPEST * pitch / wavelength));
        Some(Self {
            doe: doe.without_gaps(),
            values,
            pitch,
            widest,
            axes: widest.map(points),
            fourier: Planner::new().forward(PATCH),
        })
    }

    /// The rays that leave for one that arrives, by directions; those without energy are left out.
    pub(crate) fn rays(&self, hop: &Hop, arriving: &SourceRay) -> Vec<SourceRay> {
        let ray = |(direction, [share, x, y]): (usize, Sent)| {
            let orders = [x / share, y / share];
            let places = [direction % DIRECTIONS, direction / DIRECTIONS];
            let p = [0, 1].map(|a| arriving.p[a] + orders[a] * hop.wavelength / self.pitch[a]);
            SourceRay {
                at: arriving.at,
                p,
                energy: arriving.energy * share * obliquity(hop, p),
                spread: [0, 1]
                    .map(|a| self.half_width(a, places[a]) * hop.wavelength / self.pitch[a]),
            }
        };
        let sent = self.sent(arriving.at).into_iter().enumerate();
        let rays = sent.filter(|(_, [share, ..])| *share > 0.0).map(ray);
        rays.filter(|ray| ray.energy > 0.0).collect()
    }

    /// Half of what a direction spans along an axis, in orders.
    fn half_width(&self, axis: usize, direction: usize) -> f64 {
        let [low, high] = ends(direction, self.widest[axis]);
        0.5 * (high - low)
    }

    /// What the pixels about a place send into each direction [y, x].
    fn sent(&self, at: [f64; 2]) -> Vec<Sent> {
        let spectrum = match self.values {
            PixelValues::Fixed => self.spectrum(at),
            PixelValues::Varying => vec![1.0; (PATCH + 1) * (PATCH + 1)],
        };
        let [along_x, along_y] = &self.axes;

        // Along x first, for each row of the spectrum: the share of each direction, and that times the order.
        let row = |row: &[f64]| {
            let mut sums = [[0.0; 2]; DIRECTIONS];
            for x in along_x {
                let share = x.share * row[x.within];
                let [shares, moments] = &mut sums[x.direction];
                *shares += share;
                *moments += share * x.order;
            }
            sums
        };
        let rows: Vec<[[f64; 2]; DIRECTIONS]> = spectrum.chunks(PATCH + 1).map(row).collect();

        // Then along y.
        let mut sent = vec![[0.0; 3]; DIRECTIONS * DIRECTIONS];
        for y in along_y {
            let into = sent[y.direction * DIRECTIONS..][..DIRECTIONS].iter_mut();
            for (sum, [shares, moments]) in into.zip(&rows[y.within]) {
                let parts = [*shares, *moments, shares * y.order];
                for (sum, part) in sum.iter_mut().zip(parts) {
                    *sum += y.share * part;
                }
            }
        }
        sent
    }

    /// The power spectrum of the patch about a place, [y, x], and behind each row and column its mean; the mean of
    /// all is that of |transmission|².
    fn spectrum(&self, at: [f64; 2]) -> Vec<f64> {
        let window = window();
        let energy: f64 = window.iter().map(|w| w * w).sum();
        let mut values = self.patch(at);
        for (n, value) in values.iter_mut().enumerate() {
            *value *= window[n / PATCH] * window[n % PATCH] / energy;
        }

        // Along rows, then along columns.
        let power = self.transform(self.transform(values));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / PATCH as f64;
        let mut found = Vec::with_capacity((PATCH + 1) * (PATCH + 1));
        for row in power.chunks(PATCH) {
            let row: Vec<f64> = row.iter().map(|value| value.norm_sqr()).collect();
            found.extend_from_slice(&row);
            found.push(mean(&row));
        }
        for x in 0..=PATCH {
            let column: Vec<f64> = found.iter().skip(x).step_by(PATCH + 1).copied().collect();
            found.push(mean(&column[..PATCH]));
        }
        found
    }

    /// The Fourier sums along the rows, as columns.
    fn transform(&self, mut values: Vec<Complex64>) -> Vec<Complex64> {
        self.fourier.process(&mut values);
        let turned = |n: usize| values[n % PATCH * PATCH + n / PATCH];
        (0..PATCH * PATCH).map(turned).collect()
    }

    /// Transmissions of the pixels about a place, [y, x]; zero outside the aperture.
    fn patch(&self, at: [f64; 2]) -> Vec<Complex64> {
        let place = |n: usize, a: usize| {
            let steps = n as f64 - 0.5 * (PATCH as f64 - 1.0);
            at[a] + steps * self.pitch[a]
        };
        let value = |n: usize| {
            let (x, y) = (place(n % PATCH, 0), place(n / PATCH, 1));
            let open = self.doe.aperture.contains(x, y);
            let here = open.then(|| self.doe.transmission(x, y));
            here.unwrap_or(Complex64::ZERO)
        };
        (0..PATCH * PATCH).map(value).collect()
    }
}

/// The window of a patch along an axis: Hann's, which lets no light leak into other directions.
fn window() -> [f64; PATCH] {
    let place = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / PATCH as f64;
    std::array::from_fn(|i| place(i).sin().powi(2))
}

/// The points of the spectrum up to so many orders to each side.
fn points(widest: f64) -> Vec<Point> {
    let most = (widest.min(RESOLVED) * PATCH as f64).floor() as i64;
    let point = |n: i64| {
        let order = n as f64 / PATCH as f64;
        // From −1 to 1 over all directions, the square root of the order.
        let place = (order.abs() / widest).sqrt().copysign(order);
        let direction = (0.5 * (place + 1.0) * DIRECTIONS as f64) as usize;
        Point {
            order,
            share: sinc(order).powi(2) / PATCH as f64,
            direction: direction.min(DIRECTIONS - 1),
            within: n.rem_euclid(PATCH as i64) as usize,
        }
    };
    let mut points: Vec<Point> = (-most..=most).map(point).collect();
    points.extend((0..DIRECTIONS).filter_map(|direction| unresolved(direction, widest)));
    points
}

/// The orders between which a direction lies, of directions that reach up to the widest.
fn ends(direction: usize, widest: f64) -> [f64; 2] {
    [direction, direction + 1].map(|i| {
        let t = 2.0 * i as f64 / DIRECTIONS as f64 - 1.0;
        widest * t * t.abs()
    })
}

/// What of a direction lies beyond the orders that are resolved: one point, with the mean 1/(2π²u²) of sinc².
fn unresolved(direction: usize, widest: f64) -> Option<Point> {
    let ends = ends(direction, widest);
    let [near, far] = [
        ends[0].abs().min(ends[1].abs()),
        ends[0].abs().max(ends[1].abs()),
    ];
    let near = near.max(RESOLVED);
    let pi = std::f64::consts::PI;
    (near < far).then(|| Point {
        order: (0.5 * (near + far)).copysign(ends[0] + ends[1]),
        share: 0.5 * (1.0 / near - 1.0 / far) / (pi * pi),
        direction,
        within: MEAN,
    })
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::rims::pixel_light::{PixelLight, PixelValues};
    use crate::engine::rims::source_ray::SourceRay;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{element, on_axis, pixel_layer, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::ScreenKind;
    use crate::optics::system::Hop;

    /// Rays of unit energy behind pixels of pitch 4 at wavelength 1.
    fn rays(values: Array2<Complex64>, fixed: PixelValues) -> Vec<SourceRay> {
        let doe = element(pixel_layer(values, 4.0, PixelForm::Box), Aperture::OPEN);
        let light = PixelLight::new(&doe, 1.0, fixed).unwrap();
        let from = screen(on_axis(0.0), ScreenKind::Doe(doe.clone()));
        let to = screen(on_axis(100.0), sensor(1, 1.0));
        let hop = Hop {
            from: &from,
            to: &to,
            train: &[],
            wavelength: 1.0,
        };
        let arriving = SourceRay {
            at: [0.7, -0.3],
            p: [0.0; 2],
            energy: 1.0,
            spread: [0.0; 2],
        };
        light.rays(&hop, &arriving)
    }

    /// The share of the energy within this distance of a direction.
    fn near(rays: &[SourceRay], [x, y]: [f64; 2], far: f64) -> f64 {
        let close = |ray: &&SourceRay| (ray.p[0] - x).hypot(ray.p[1] - y) < far;
        rays.iter().filter(close).map(|ray| ray.energy).sum()
    }

    /// Phases that rise by a quarter turn from pixel to pixel send sinc²(1/4) = 81 % into one direction; the sinc²
    /// alone sends next to none there.
    #[test]
    fn a_grating_of_pixels_keeps_its_order_together() {
        let turn = |(_, i): (usize, usize)| Complex64::cis(0.25 * std::f64::consts::TAU * i as f64);
        let found = rays(Array2::from_shape_fn((60, 60), turn), PixelValues::Fixed);
        let order = near(&found, [1.0 / 16.0, 0.0], 0.03);
        assert!((order - 0.81).abs() < 0.01, "{order}");
        let even = rays(Array2::from_shape_fn((60, 60), turn), PixelValues::Varying);
        let there = near(&even, [1.0 / 16.0, 0.0], 0.03);
        assert!(there < 0.1, "{there}");
    }

    /// The mean direction of what a grating of pixels keeps together is that of its order, along either axis: phases
    /// that rise by a quarter turn a pixel send the light to a quarter of λ over the pitch.
    #[test]
    fn the_mean_direction_is_that_of_the_order() {
        for axis in [0, 1] {
            let turn = |(y, x): (usize, usize)| {
                Complex64::cis(0.25 * std::f64::consts::TAU * [x, y][axis] as f64)
            };
            let found = rays(Array2::from_shape_fn((60, 60), turn), PixelValues::Fixed);
            let close = |ray: &&SourceRay| ray.p[0].hypot(ray.p[1]) < 0.1;
            let together = found.iter().filter(close);
            let [energy, x, y] = together.fold([0.0; 3], |sum, ray| {
                let part = [1.0, ray.p[0], ray.p[1]];
                std::array::from_fn(|i| sum[i] + ray.energy * part[i])
            });
            let mut expected = [0.0; 2];
            expected[axis] = 1.0 / 16.0;
            for (mean, expected) in [x / energy, y / energy].into_iter().zip(expected) {
                assert!(
                    (mean - expected).abs() < 5e-4,
                    "axis {axis}: {mean} {expected}"
                );
            }
        }
    }

    /// Pixels of 200 wavelengths are followed as far as small ones, at no greater cost, and send all their light.
    #[test]
    fn large_pixels_have_few_points() {
        let points = super::points(240.0);
        let share: f64 = points.iter().map(|point| point.share).sum();
        assert!(points.len() < 600 && (share - 1.0).abs() < 2e-3, "{share}");
    }

    /// All the light goes somewhere: random phases lose a tenth to directions beyond the orders that are followed,
    /// as the sinc² does, and pixels of half the amplitude send a quarter of that.
    #[test]
    fn random_pixels_send_what_the_sinc_sends() {
        let random = noise((60, 60), 3).mapv(|value| value / value.norm());
        let sum = |rays: Vec<SourceRay>| rays.iter().map(|ray| ray.energy).sum::<f64>();
        let found = sum(rays(random.clone(), PixelValues::Fixed));
        let even = sum(rays(random.clone(), PixelValues::Varying));
        assert!((found / even - 1.0).abs() < 0.1, "{found} {even}");
        let dim = sum(rays(random.mapv(|value| 0.5 * value), PixelValues::Fixed));
        assert!((dim / found - 0.25).abs() < 1e-12, "{dim} {found}");
    }
}
