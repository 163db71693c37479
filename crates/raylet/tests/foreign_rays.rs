//! Rays of a tracer that shares nothing with raylet: planes and spheres in the meridian of a lens, Snell's
//! law in vector form, Jacobians by differences. What it collects is compared with raylet's own runs.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::external::scatter::Scatter;
use raylet::engine::external::scatter_settings::Scattering;
use raylet::engine::external::secondary_rays::SecondaryRays;
use raylet::engine::plan::settings::{Correction, Method, Settings};
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::bundle::Rays;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::{MediumBehind, Screen, ScreenKind};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::beamlet::beams::{Beams, Jacobians};
use raylet::wave::beamlet::secondary_ray_sum::{SecondaryRaySum, Wavelet};
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::noise::column;
use raylet_testkit::parts::{self, conic, face, on_axis, pixel_layer, screen};

const WAVELENGTH: f64 = 0.7e-3;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;

/// A plane (radius zero) or a sphere on the z axis, and the index behind it.
struct Face {
    z: f64,
    radius: f64,
    index: f64,
}

type Vector = [f64; 3];

fn add(a: Vector, b: Vector, scale: f64) -> Vector {
    [0, 1, 2].map(|i| a[i] + scale * b[i])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Follows a ray through faces in air and on to the plane at `end`: place, direction and optical path.
fn trace(faces: &[Face], end: f64, mut at: Vector, mut d: Vector) -> (Vector, Vector, f64) {
    let (mut path, mut n) = (0.0, 1.0);
    for face in faces {
        let (length, normal);
        if face.radius == 0.0 {
            length = (face.z - at[2]) / d[2];
            normal = [0.0, 0.0, 1.0];
        } else {
            // |at + length·d − centre| = |radius|, on the side of the vertex.
            let from = add(at, [0.0, 0.0, face.z + face.radius], -1.0);
            let half = dot(from, d);
            let root = (half * half - dot(from, from) + face.radius * face.radius).sqrt();
            length = -half - face.radius.signum() * root;
            let out = add(from, d, length);
            normal = out.map(|v| -v / face.radius);
        }
        at = add(at, d, length);
        path += n * length;
        // n′d′ = n d + (n′cos′ − n cos) normal.
        let cosine = dot(normal, d);
        let ratio = n / face.index;
        let after = (1.0 - ratio * ratio * (1.0 - cosine * cosine)).sqrt();
        d = add(d.map(|v| v * ratio), normal, after - ratio * cosine);
        n = face.index;
    }
    let length = (end - at[2]) / d[2];
    (add(at, d, length), d, path + n * length)
}

/// ∂(s, p′)/∂(x, p) of a ray from the plane z = 0, by central differences.
fn jacobian(faces: &[Face], end: f64, at: Vector, d: Vector) -> [[f64; 4]; 4] {
    let mut j = [[0.0; 4]; 4];
    for (column, h) in [1e-3, 1e-3, 1e-4, 1e-4].into_iter().enumerate() {
        let [plus, minus] = [h, -h].map(|h| {
            let mut start = [at[0], at[1], d[0], d[1]];
            start[column] += h;
            let [x, y, p, q] = start;
            let (s, d, _) = trace(
                faces,
                end,
                [x, y, 0.0],
                [p, q, (1.0 - p * p - q * q).sqrt()],
            );
            [s[0], s[1], d[0], d[1]]
        });
        for row in 0..4 {
            j[row][column] = (plus[row] - minus[row]) / (2.0 * h);
        }
    }
    j
}

/// The field that secondary rays bring through faces to a sensor, as beamlets and as plane waves.
fn collect(secondary: &SecondaryRays, faces: &[Face], sensor: &Screen) -> [Array2<Complex64>; 2] {
    let end = sensor.frame.origin.z;
    let (mut position, mut direction, mut path, mut jacobians) = (vec![], vec![], vec![], vec![]);
    for i in 0..secondary.len() {
        let (at, d) = (secondary.position[i], secondary.direction[i]);
        let (s, after, length) = trace(faces, end, at, d);
        position.push(s);
        direction.push(after);
        path.push(secondary.path[i] + length);
        jacobians.push(jacobian(faces, end, at, d));
    }
    let rays = Rays {
        position: &position,
        direction: &direction,
        path: &path,
        weight: &secondary.weight,
    };
    let ray_sum = SecondaryRaySum::new(sensor, WAVELENGTH, 1e-4).unwrap();
    let jacobians = Jacobians {
        jacobian: &jacobians,
        window: &secondary.window,
        cosine: &secondary.cosine,
        images: None,
    };
    let hits = ray_sum.hits(&rays).unwrap();
    let beams = Beams::from_jacobians(&jacobians, &hits, K).unwrap();
    [Wavelet::Beamlet(&beams), Wavelet::Prefactor(&beams)]
        .map(|wavelet| ray_sum.sum(&rays, &wavelet).unwrap())
}

fn sensor(z: f64, pixels: usize, pitch: f64) -> Screen {
    screen(on_axis(z), parts::sensor(pixels, pitch))
}

/// Random pixels, with an analytic phase before them where there is one.
fn element(count: usize, pitch: f64, before: Option<Profile>) -> Screen {
    let pixel = |(j, i): (usize, usize)| {
        Complex64::cis(std::f64::consts::TAU * uniform(5, [i as u32, j as u32, 0, 0]))
    };
    let values = Array2::from_shape_fn((count, count), pixel);
    let mut layers: Vec<Layer> = before.into_iter().map(Layer::Phase).collect();
    layers.push(pixel_layer(values, pitch, PixelForm::Box));
    let half = 0.5 * count as f64 * pitch;
    let doe = Doe {
        layers,
        aperture: Aperture {
            outline: Outline::Rectangle {
                half_x: half,
                half_y: half,
            },
            centre: [0.0; 2],
        },
        reflect: false,
    };
    screen(on_axis(0.0), ScreenKind::Doe(doe))
}

fn lit(element: Screen, train: Vec<Surface>, sensor: &Screen) -> System {
    System {
        wavelength: WAVELENGTH,
        ..parts::lit(vec![element, sensor.clone()], vec![train])
    }
}

/// Places `step` apart over a square of half width `half`.
fn lattice(half: f64, step: f64) -> Vec<Vector> {
    let count = (2.0 * half / step).ceil() as usize;
    let place = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * step;
    (0..count * count)
        .map(|i| [place(i % count), place(i / count), 0.0])
        .collect()
}

/// Radius and index of a plano-convex lens of 50 mm, and the width of beamlets behind it.
const RADIUS: f64 = 25.8;
const INDEX: f64 = 1.513_063_997_196;
const SIGMA: f64 = 0.06;

fn faces() -> [Face; 2] {
    [
        Face {
            z: 3.0,
            radius: RADIUS,
            index: INDEX,
        },
        Face {
            z: 8.3,
            radius: 0.0,
            index: 1.0,
        },
    ]
}

/// The field of raylet's own run through that lens.
fn run(element: &Screen, sensor: &Screen) -> Array2<Complex64> {
    let surface = |z: f64, curvature: f64, index: [f64; 2]| Surface {
        aperture: Aperture::disc(6.0),
        ..face(on_axis(z), conic(curvature, 0.0), index)
    };
    let train = vec![
        surface(3.0, 1.0 / RADIUS, [1.0, INDEX]),
        surface(8.3, 0.0, [INDEX, 1.0]),
    ];
    let settings = Settings {
        method: Method::Beamlet,
        correction: Correction::Off,
        sigma: Some(SIGMA),
        step: Some(1.25),
        period: Some(7.0),
        mode_threshold: Some(1e-4),
        footprint_threshold: Some(1e-4),
        ..Settings::default()
    };
    let system = lit(element.clone(), train, sensor);
    simulate(&system, &settings, &|_| {}).unwrap().field.values
}

/// A hologram of 0.4 mm before the lens, seen a little out of its focus.
#[test]
fn beamlets_of_a_foreign_tracer_match_a_run() {
    let (element, sensor) = (element(64, 6.3e-3, None), sensor(51.0, 48, 6.3e-3));
    let (own, sigma) = (run(&element, &sensor), SIGMA);
    let position = lattice(0.2016 + 3.5 * sigma, 1.25 * sigma);
    let count = position.len();
    let rays = Rays {
        position: &position,
        direction: &vec![[0.0, 0.0, 1.0]; count],
        path: &vec![0.0; count],
        weight: &vec![Complex64::ONE; count],
    };
    let scattering = Scattering {
        period: 7.0 * sigma,
        threshold: 1e-4,
        towards: Some([-0.02, 0.02, -0.02, 0.02]),
        ..Scattering::beamlets(sigma)
    };
    let plan = Scatter::new(&element, WAVELENGTH, rays, None, scattering).unwrap();
    let secondary = plan.scatter(0..count);
    let [beamlets, _] = collect(&secondary, &faces(), &sensor);
    let error = field_error(beamlets.view(), own.view()).unwrap();
    assert!(error < 1e-7, "{error:e}");
}

/// The same by plane waves with prefactor: places so close that copies, λf/step away, pass beside the sensor
/// and its margin; rays that land further out are left away, the last of them fading.
#[test]
fn plane_waves_of_a_foreign_tracer_match_a_run() {
    let (element, sensor) = (element(64, 6.3e-3, None), sensor(51.0, 48, 6.3e-3));
    let own = run(&element, &sensor);
    let position = lattice(0.2016 + 4.5 * SIGMA, 0.5 * SIGMA);
    let count = position.len();
    let rays = Rays {
        position: &position,
        direction: &vec![[0.0, 0.0, 1.0]; count],
        path: &vec![0.0; count],
        weight: &vec![Complex64::ONE; count],
    };
    let scattering = Scattering {
        towards: Some([-0.015, 0.015, -0.015, 0.015]),
        threshold: 1e-4,
        ..Scattering::waves(SIGMA, 10.0 * SIGMA)
    };
    let plan = Scatter::new(&element, WAVELENGTH, rays, None, scattering).unwrap();
    let mut secondary = plan.scatter(0..count);
    for i in 0..secondary.len() {
        let (s, _, _) = trace(
            &faces(),
            51.0,
            secondary.position[i],
            secondary.direction[i],
        );
        let beside = s[0].abs().max(s[1].abs()) - 0.15 - 0.3;
        let t = (beside / 0.12).clamp(0.0, 1.0);
        secondary.weight[i] *= 1.0 - t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
    }
    let [_, waves] = collect(&secondary, &faces(), &sensor);
    let error = field_error(waves.view(), own.view()).unwrap();
    assert!(error < 3e-4, "{error:e}");
}

/// Pixels on the back of a block of glass, lit at an angle from inside it: the secondary rays leave into air by Snell's law and the
/// pixels together, with what the bare interface transmits, as in a run by local bands.
#[test]
fn rays_leave_an_interface_into_the_medium_behind_it() {
    let (index, slant, sigma) = (1.5, 0.05f64, 0.03);
    let sensor = Screen {
        frame: on_axis(10.0).moved(Vec3::new(0.75, 0.0, 0.0)),
        ..sensor(10.0, 40, 8e-3)
    };
    for (coating, curvature) in [(Coating::Ideal, 0.0), (Coating::Fresnel, 0.1)] {
        let element = Screen {
            index,
            shape: conic(curvature, 0.0),
            behind: Some(MediumBehind {
                index: 1.0,
                coating,
            }),
            ..element(40, 0.01, None)
        };
        let cosine = (1.0 - slant * slant).sqrt();
        let system = System {
            source: Source::Plane {
                direction: Vec3::new(slant, 0.0, cosine),
                origin: Vec3::new(0.0, 0.0, 0.0),
            },
            ..lit(element.clone(), vec![], &sensor)
        };
        let own = simulate(&system, &Settings::default(), &|_| {});
        let own = own.unwrap().field.values;

        let on_surface = |[x, y, _]: Vector| [x, y, element.height([x, y]).unwrap().z];
        let places = lattice(0.2 + 3.5 * sigma, 1.25 * sigma).into_iter();
        let position: Vec<Vector> = places.map(on_surface).collect();
        let count = position.len();
        let path = |[x, _, z]: &Vector| index * (slant * x + cosine * z);
        let path: Vec<f64> = position.iter().map(path).collect();
        let rays = Rays {
            position: &position,
            direction: &vec![[slant, 0.0, cosine]; count],
            path: &path,
            weight: &vec![Complex64::ONE; count],
        };
        let scattering = Scattering {
            period: 7.0 * sigma,
            threshold: 1e-4,
            towards: Some([-0.02, 0.17, -0.1, 0.1]),
            ..Scattering::beamlets(sigma)
        };
        let plan = Scatter::new(&element, WAVELENGTH, rays, None, scattering).unwrap();
        let secondary = plan.scatter(0..count);
        let [beamlets, _] = collect(&secondary, &[], &sensor);
        let error = field_error(beamlets.view(), own.view()).unwrap();
        assert!(error < 2e-3, "{coating:?} {curvature}: {error:e}");

        // The transpose: of the amplitudes of the arriving rays, with all of the element.
        let bar = column(secondary.len(), 2);
        let back = plan.weigh_adjoint(&secondary, &bar).unwrap();
        let inner = |a: &[Complex64], b: &[Complex64]| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let forward = inner(&bar, &secondary.weight);
        let ones = vec![Complex64::ONE; count];
        let reverse = inner(&back.weight, &ones);
        assert!(
            (forward - reverse).norm() < 1e-10 * forward.norm().max(1.0),
            "{forward} {reverse}"
        );
    }
}

/// Light that an ideal lens has bent arrives at random pixels in the same plane. With the curvature of its
/// wavefront each ray carries enough; without, its patches are lit by plane waves, and wrongly.
#[test]
fn converging_light_needs_its_curvature() {
    let (focal_length, sigma) = (20.0, 0.03);
    let lens = Profile::Lens {
        focal_length,
        wavenumber: K,
    };
    let sensor = sensor(15.0, 40, 4e-3);
    let system = lit(element(20, 0.02, Some(lens)), vec![], &sensor);
    let own = simulate(&system, &Settings::default(), &|_| {});
    let own = own.unwrap().field.values;

    let element = element(20, 0.02, None);
    let position = lattice(0.2 + 3.0 * sigma, 1.5 * sigma);
    let slant = |[x, y, _]: &Vector| (x * x + y * y + focal_length * focal_length).sqrt();
    let direction: Vec<Vector> = position
        .iter()
        .map(|at| [-at[0], -at[1], focal_length].map(|v| v / slant(at)))
        .collect();
    let path: Vec<f64> = position.iter().map(|at| focal_length - slant(at)).collect();
    let curvature: Vec<[f64; 3]> = direction
        .iter()
        .zip(&position)
        .map(|([a, b, _], at)| [1.0 - a * a, -a * b, 1.0 - b * b].map(|v| -v / slant(at)))
        .collect();
    let rays = Rays {
        position: &position,
        direction: &direction,
        path: &path,
        weight: &vec![Complex64::ONE; position.len()],
    };
    let scattering = Scattering {
        towards: Some([-0.12, 0.12, -0.12, 0.12]),
        ..Scattering::beamlets(sigma)
    };
    let [with, without] = [Some(&curvature[..]), None].map(|curvature| {
        let plan = Scatter::new(&element, WAVELENGTH, rays, curvature, scattering).unwrap();
        let secondary = plan.scatter(0..position.len());
        let [beamlets, _] = collect(&secondary, &[], &sensor);
        field_error(beamlets.view(), own.view()).unwrap()
    });
    assert!(with < 2e-4 && without > 0.1, "{with:e} {without:e}");
}
