//! Rays that this file traces itself, scattered at an element and collected on a sensor, against direct
//! sums: nothing here walks through raylet's own systems.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::external::scatter::Scatter;
use raylet::engine::external::scatter_settings::Scattering;
use raylet::engine::external::secondary_rays::SecondaryRays;
use raylet::engine::plan::settings::Settings;
use raylet::math::random::pair;
use raylet::math::vec3::Vec3;
use raylet::optics::bundle::Rays;
use raylet::optics::screen::Screen;
use raylet::wave::beamlet::beams::{Beams, Jacobians};
use raylet::wave::beamlet::secondary_ray_sum::{SecondaryRaySum, Wavelet};
use raylet::wave::grid::metrics::field_error;
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::problems::mirror::{Coat, MirrorProblem};
use raylet_accuracy::problems::problem::{axis, doe, random_pixels, sensor};
use raylet_accuracy::references::rayleigh_sommerfeld::rayleigh_sommerfeld;

const K: f64 = std::f64::consts::TAU;

/// Rays in columns.
#[derive(Default)]
struct Columns {
    position: Vec<[f64; 3]>,
    direction: Vec<[f64; 3]>,
    path: Vec<f64>,
    weight: Vec<Complex64>,
}

impl Columns {
    fn push(&mut self, position: [f64; 3], direction: [f64; 3], path: f64, weight: Complex64) {
        self.position.push(position);
        self.direction.push(direction);
        self.path.push(path);
        self.weight.push(weight);
    }

    fn rays(&self) -> Rays<'_> {
        Rays {
            position: &self.position,
            direction: &self.direction,
            path: &self.path,
            weight: &self.weight,
        }
    }
}

/// Places `step` apart over a square of half width `half`.
fn lattice(half: f64, step: f64) -> Vec<[f64; 2]> {
    let count = (2.0 * half / step).ceil() as usize;
    let place = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * step;
    (0..count * count)
        .map(|i| [place(i % count), place(i / count)])
        .collect()
}

/// Rays of free space to the plane z = `distance`, as an array each.
fn fly(secondary: &SecondaryRays, distance: f64) -> Columns {
    let mut landed = Columns::default();
    for i in 0..secondary.len() {
        let ([x, y, z], [a, b, c]) = (secondary.position[i], secondary.direction[i]);
        let length = (distance - z) / c;
        landed.push(
            [x + length * a, y + length * b, distance],
            [a, b, c],
            secondary.path[i] + length,
            secondary.weight[i],
        );
    }
    landed
}

/// [[1, B], [0, 1]] of free flight between parallel planes, B = z(1/q)(1 + ppᵀ/q²).
fn flight([a, b, c]: [f64; 3], distance: f64) -> [[f64; 4]; 4] {
    let mut j = [[0.0; 4]; 4];
    for (i, row) in j.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    let b_of = |p: f64, q: f64, same: f64| distance / c * (same + p * q / (c * c));
    (j[0][2], j[0][3]) = (b_of(a, a, 1.0), b_of(a, b, 0.0));
    (j[1][2], j[1][3]) = (b_of(a, b, 0.0), b_of(b, b, 1.0));
    j
}

fn images(pixels: &Pixels, tilt: [f64; 2], count: usize, pitch: f64, z: f64) -> Array2<Complex64> {
    let along = axis(count, pitch);
    let points: Vec<[f64; 3]> = (0..count * count)
        .map(|i| [along[i % count], along[i / count], z])
        .collect();
    let values = rayleigh_sommerfeld(pixels, tilt, 1.0, 6, &points);
    Array2::from_shape_vec((count, count), values).unwrap()
}

/// Collimated rays at these places and with this tilt.
fn collimated(places: &[[f64; 2]], tilt: [f64; 2]) -> Columns {
    let along = (1.0 - tilt[0] * tilt[0] - tilt[1] * tilt[1]).sqrt();
    let mut arriving = Columns::default();
    for [x, y] in places {
        let path = tilt[0] * x + tilt[1] * y;
        arriving.push(
            [*x, *y, 0.0],
            [tilt[0], tilt[1], along],
            path,
            Complex64::ONE,
        );
    }
    arriving
}

/// Random pixels of two wavelengths, 48 across, and a sensor of 24 points 150 wavelengths behind.
struct Free {
    pixels: Pixels,
    element: Screen,
    sensor: Screen,
}

const DISTANCE: f64 = 150.0;

impl Free {
    fn new() -> Self {
        let pixels = random_pixels(24, 2.0);
        let mut element = doe(0.0, &pixels);
        let mut sensor = sensor(DISTANCE, 24, 1.3);
        (element.index, sensor.index) = (1.0, 1.0);
        Self {
            pixels,
            element,
            sensor,
        }
    }

    /// Compares the field with these rays, by beamlets or plain plane waves, with the exact one.
    fn check(
        &self,
        arriving: &Columns,
        tilt: [f64; 2],
        settings: Scattering,
        beams: bool,
        bound: f64,
    ) {
        let plan = Scatter::new(&self.element, 1.0, arriving.rays(), None, settings).unwrap();
        let secondary = plan.scatter(0..arriving.path.len());
        let landed = fly(&secondary, DISTANCE);
        let ray_sum = SecondaryRaySum::new(&self.sensor, 1.0, 1e-3).unwrap();
        let ours = if beams {
            let jacobian: Vec<_> = landed
                .direction
                .iter()
                .map(|d| flight(*d, DISTANCE))
                .collect();
            let jacobians = Jacobians {
                jacobian: &jacobian,
                window: &secondary.window,
                cosine: &secondary.cosine,
                images: None,
            };
            let hits = ray_sum.hits(&landed.rays()).unwrap();
            let beams = Beams::from_jacobians(&jacobians, &hits, K).unwrap();
            ray_sum.sum(&landed.rays(), &Wavelet::Beamlet(&beams))
        } else {
            let ray_sum = SecondaryRaySum::new(&self.sensor, 1.0, 1e-9).unwrap();
            ray_sum.sum(&landed.rays(), &Wavelet::Plain)
        };
        let exact = images(&self.pixels, tilt, 24, 1.3, DISTANCE);
        let error = field_error(ours.unwrap().view(), exact.view()).unwrap();
        assert!(
            error < bound,
            "{} arriving, {} secondary rays, unevenness {:.2}, dropped {:.1e}: error {error:.1e}",
            arriving.path.len(),
            secondary.len(),
            plan.unevenness(),
            secondary.dropped
        );
    }
}

/// On a lattice of 1.5σ, straight and at 10°, and on one whose places are moved at random by up to a
/// quarter of a step: the division by the actual coverage takes care of it.
#[test]
fn beamlets_of_a_lattice_match_rayleigh_and_sommerfeld() {
    let free = Free::new();
    let sigma = 5.0;
    let half = 24.0 + 3.0 * sigma;
    let towards = [-0.75, 0.75, -0.75, 0.75];
    let settings = Scattering {
        towards: Some(towards),
        ..Scattering::beamlets(sigma)
    };
    for tilt in [[0.0, 0.0], [10f64.to_radians().sin(), 0.0]] {
        let arriving = collimated(&lattice(half, 1.5 * sigma), tilt);
        free.check(&arriving, tilt, settings, true, 2e-3);
    }
    let step = 1.25 * sigma;
    let jitter = |(i, [x, y]): (usize, [f64; 2])| {
        let [u, v] = pair(2, [i as u32, 0, 0, 0]).map(|t| 0.5 * step * (t - 0.5));
        [x + u, y + v]
    };
    let places: Vec<_> = lattice(half, step)
        .into_iter()
        .enumerate()
        .map(jitter)
        .collect();
    let arriving = collimated(&places, [0.0; 2]);
    free.check(&arriving, [0.0; 2], settings, true, 2e-3);
}

/// Plain plane waves are right in free space, with Gaussian windows that add up to one and with squares
/// side by side.
#[test]
fn plane_waves_of_a_lattice_match_rayleigh_and_sommerfeld() {
    let free = Free::new();
    let towards = Some([-0.5, 0.5, -0.5, 0.5]);
    let settings = Scattering {
        towards,
        threshold: 0.0,
        ..Scattering::waves(5.0, 180.0)
    };
    let arriving = collimated(&lattice(24.0 + 17.5, 8.3), [0.0; 2]);
    free.check(&arriving, [0.0; 2], settings, false, 1e-3);
    let squares = Scattering {
        towards: Some([-0.85, 0.85, -0.85, 0.85]),
        threshold: 0.0,
        ..Scattering::squares(12.0, 300.0)
    };
    let arriving = collimated(&lattice(24.0, 12.0), [0.0; 2]);
    free.check(&arriving, [0.0; 2], squares, false, 2e-2);
}

/// A ray from a point of a plane with axes x, y, z, moved by u and with cosines p along them, to the plane
/// at this height: place and cosines there.
fn land(origin: Vec3, axes: [Vec3; 3], z: f64, [u, v, p, q]: [f64; 4]) -> [f64; 4] {
    let [ex, ey, ez] = axes;
    let from = origin + ex * u + ey * v;
    let d = ex * p + ey * q + ez * (1.0 - p * p - q * q).sqrt();
    let length = (z - from.z) / d.z;
    [from.x + length * d.x, from.y + length * d.y, d.x, d.y]
}

/// A diffractive mirror on a Gaussian bump, lit from above: the rays leave from the true surface.
#[test]
fn curved_mirror_matches_the_sum_over_its_surface() {
    let (width, distance, points) = (120.0, 250.0, 16);
    for coat in [Coat::Focus(250.0), Coat::Random(1.6)] {
        let mirror = MirrorProblem {
            coat,
            width,
            distance,
            points,
            pitch: 1.9,
        };
        let exact = mirror.exact(6);
        let system = mirror.problem("mirror", Settings::default(), 6).system;
        let (mirror, sensor) = (&system.screens[0], &system.screens[1]);
        let sigma = 5.0;
        let mut arriving = Columns::default();
        for [x, y] in lattice(0.5 * width + 3.0 * sigma, 1.5 * sigma) {
            let z = mirror.height([x, y]).unwrap().z;
            arriving.push([x, y, z], [0.0, 0.0, -1.0], -z, Complex64::ONE);
        }
        let settings = Scattering {
            towards: Some([-0.5, 0.5, -0.5, 0.5]),
            ..Scattering::beamlets(sigma)
        };
        let plan = Scatter::new(mirror, 1.0, arriving.rays(), None, settings).unwrap();
        let secondary = plan.scatter(0..arriving.path.len());
        let landed = fly(&secondary, distance);

        // Jacobians by central differences from the touching planes.
        let jacobian: Vec<[[f64; 4]; 4]> = (0..secondary.len())
            .map(|i| {
                let [x, y, z] = secondary.position[i];
                let [sx, sy] = mirror.height([x, y]).unwrap().slope;
                let ex = Vec3::new(1.0, 0.0, sx).unit();
                let ez = Vec3::new(-sx, -sy, 1.0).unit();
                let axes = [ex, ez.cross(ex), ez];
                let [a, b, c] = secondary.direction[i];
                let d = Vec3::new(a, b, c);
                let start = [0.0, 0.0, d.dot(axes[0]), d.dot(axes[1])];
                let h = 1e-4;
                let mut j = [[0.0; 4]; 4];
                for column in 0..4 {
                    let [plus, minus] = [h, -h].map(|h| {
                        let mut moved = start;
                        moved[column] += h;
                        land(Vec3::new(x, y, z), axes, distance, moved)
                    });
                    for row in 0..4 {
                        j[row][column] = (plus[row] - minus[row]) / (2.0 * h);
                    }
                }
                j
            })
            .collect();
        let ray_sum = SecondaryRaySum::new(sensor, 1.0, 1e-3).unwrap();
        let jacobians = Jacobians {
            jacobian: &jacobian,
            window: &secondary.window,
            cosine: &secondary.cosine,
            images: None,
        };
        let hits = ray_sum.hits(&landed.rays()).unwrap();
        let beams = Beams::from_jacobians(&jacobians, &hits, K).unwrap();
        let ours = ray_sum
            .sum(&landed.rays(), &Wavelet::Beamlet(&beams))
            .unwrap();
        let error = field_error(ours.view(), exact.view()).unwrap();
        let rays = secondary.len();
        assert!(error < 3e-3, "{coat:?}: {rays} rays, error {error:.1e}");
    }
}
