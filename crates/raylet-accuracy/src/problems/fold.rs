//! Trains that direct sums alone can follow: tilted planes in free space, and a toroidal fold mirror seen
//! between its two astigmatic images. Lengths are in wavelengths.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::Settings;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::frame::Frame;
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::Screen;
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::optics::toric::Toroid;
use raylet_testkit::parts::{on_axis, plane_wave};

use crate::numerics::pixels::Pixels;
use crate::problems::problem::{Problem, doe, sensor};
use crate::problems::tilted::{sensor_points, soft, standing};
use crate::references::direct::SampledSurface;

/// Direction of the light in every problem here.
const ALONG: Vec3 = Vec3::new(0.0, 0.0, 1.0);

/// Points of the sensors along each axis, and their distance.
const SENSOR: (usize, f64) = (40, 1.1);

/// A problem of these screens and trains; `exact` gives the field at the sensor's points.
fn problem(
    name: &str,
    screens: Vec<Screen>,
    trains: Vec<Vec<Surface>>,
    exact: impl Fn(&[Vec3]) -> Vec<Complex64> + 'static,
) -> Problem {
    let (count, _) = SENSOR;
    let points = screens
        .last()
        .map(|screen| sensor_points(&screen.frame, SENSOR.0, SENSOR.1))
        .unwrap_or_default();
    Problem {
        name: name.to_owned(),
        reference: "direct sums",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens,
            trains,
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let field = exact(&points);
            Array2::from_shape_fn((count, count), |(j, i)| field[j * count + i])
        }),
    }
}

/// Pixels in free space, the sensor tilted.
pub fn tilted_sensor(pixels: Pixels, frame: Frame, nodes: usize) -> Problem {
    let screens = vec![
        doe(0.0, &pixels),
        standing(sensor(0.0, SENSOR.0, SENSOR.1), frame),
    ];
    let name = "random 2λ pixels, 120λ of free space, sensor tilted 30°";
    problem(name, screens, vec![vec![]], move |points| {
        SampledSurface::pixels(&pixels, &on_axis(0.0), nodes)
            .lit(ALONG, 1.0)
            .radiate(1.0, points)
    })
}

/// Pixels, other pixels on a tilted plane, the sensor.
pub fn tilted_element(first: Pixels, second: Pixels, frame: Frame, nodes: usize) -> Problem {
    let screens = vec![
        doe(0.0, &first),
        standing(doe(0.0, &second), frame),
        sensor(260.0, SENSOR.0, SENSOR.1),
    ];
    let name = "random pixels, random pixels tilted 25° 120λ on, sensor 140λ on";
    problem(name, screens, vec![vec![], vec![]], move |points| {
        let before = SampledSurface::pixels(&first, &on_axis(0.0), nodes).lit(ALONG, 1.0);
        let behind = SampledSurface::pixels(&second, &frame, nodes);
        let arriving = before.radiate(1.0, &behind.points);
        behind.times(&arriving).radiate(1.0, points)
    })
}

/// Radii of the toroidal mirror in the plane of incidence and across it: at 45° its focal lengths are 200
/// and 260.
const RADII: [f64; 2] = [565.7, 367.7];

/// Distances from the pixels to the mirror and from there to the sensor. The images of the pixels in the
/// two planes lie 400 and 743 behind the mirror.
const PATH: [f64; 2] = [400.0, 540.0];

/// Half widths of the part of the mirror that the reference sums over, and the distance of its samples.
const MIRROR: ([f64; 2], f64) = ([180.0, 125.0], 0.6);

/// Light going +z is folded towards +x: the mirror's normal stands half way.
fn mirror_frame() -> Frame {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Frame {
        origin: Vec3::new(0.0, 0.0, PATH[0]),
        x: Vec3::new(-half, 0.0, -half),
        y: Vec3::new(0.0, 1.0, 0.0),
        z: Vec3::new(half, 0.0, -half),
    }
}

/// The sensor's frame, its z axis along the folded light.
fn folded() -> Frame {
    Frame {
        origin: Vec3::new(PATH[1], 0.0, PATH[0]),
        x: Vec3::new(0.0, 0.0, -1.0),
        y: Vec3::new(0.0, 1.0, 0.0),
        z: Vec3::new(1.0, 0.0, 0.0),
    }
}

/// Height, slopes and mean curvature of the toroid: the circle of radius R_y along y turned about an axis
/// parallel to y at the distance R_x.
fn toroid(x: f64, y: f64) -> ([f64; 3], f64) {
    let [rx, ry] = RADII;
    // The circle along y, and its distance from the axis of rotation.
    let circle = (ry * ry - y * y).sqrt();
    let reach = rx - (ry - circle);
    let depth = (reach * reach - x * x).sqrt();
    let slopes = [x / depth, reach / depth * (y / circle)];

    // Normal curvatures of a surface of revolution: of its meridian, and of the circle around whose centre
    // lies on the axis along the normal.
    let around = circle / (ry * reach);
    (
        [rx - depth, slopes[0], slopes[1]],
        0.5 * (1.0 / ry + around),
    )
}

/// The mirror's samples, their field the soft edge and the curvature's correction of the surface integral.
fn mirror_sheet() -> SampledSurface {
    let (half, pitch) = MIRROR;
    let frame = mirror_frame();
    let mut sheet = SampledSurface::default();
    let [nx, ny] = half.map(|half| (half / pitch) as i32);
    for j in -ny..=ny {
        for i in -nx..=nx {
            let (x, y) = (f64::from(i) * pitch, f64::from(j) * pitch);
            let ([z, zx, zy], curvature) = toroid(x, y);
            sheet.points.push(frame.to_global(Vec3::new(x, y, z)));
            let area = Vec3::new(-zx, -zy, 1.0) * (pitch * pitch);
            sheet.areas.push(frame.direction_to_global(area));
            let correction = Complex64::new(1.0, -curvature / std::f64::consts::TAU);
            sheet
                .field
                .push(correction * soft(x, half[0]) * soft(y, half[1]));
        }
    }
    sheet
}

/// Pixels, the toroidal fold mirror, the sensor between its astigmatic images.
pub fn toroidal_mirror(pixels: Pixels, nodes: usize) -> Problem {
    let shape = Shape::Toroid(Toroid {
        rotation: 1.0 / RADII[0],
        curve: Conic {
            curvature: 1.0 / RADII[1],
            conic: 0.0,
        },
        coefficients: vec![],
    });
    let mirror = Surface {
        shape,
        frame: mirror_frame(),
        aperture: Aperture::disc(300.0),
        interface: Interface::Reflect,
        coating: Coating::Unit,
        index: [1.0; 2],
    };
    let screens = vec![
        doe(0.0, &pixels),
        standing(sensor(0.0, SENSOR.0, SENSOR.1), folded()),
    ];
    let name = "smooth random light of sines below 0.15, toroidal mirror at 45°, sensor between its images";
    problem(name, screens, vec![vec![mirror]], move |points| {
        let before = SampledSurface::pixels(&pixels, &on_axis(0.0), nodes).lit(ALONG, 1.0);
        let mirror = mirror_sheet();
        let arriving = before.radiate(1.0, &mirror.points);
        mirror.times(&arriving).radiate(1.0, points)
    })
}

#[cfg(test)]
mod tests {
    use crate::problems::fold::toroid;

    /// The slopes against differences; the mean curvature against the formula from second differences.
    #[test]
    fn toroid_slopes_and_curvature() {
        let (x, y, h) = (60.0, -80.0, 1e-3);
        let ([_, p, q], mean) = toroid(x, y);
        let z = |dx: f64, dy: f64| toroid(x + dx * h, y + dy * h).0;
        let along = |a: f64, b: f64| (z(a, b)[0] - z(-a, -b)[0]) / (2.0 * h);
        assert!((along(1.0, 0.0) - p).abs() < 1e-8 && (along(0.0, 1.0) - q).abs() < 1e-8);
        let bend = |a: f64, b: f64, part: usize| (z(a, b)[part] - z(-a, -b)[part]) / (2.0 * h);
        let (r, s, t) = (bend(1.0, 0.0, 1), bend(0.0, 1.0, 1), bend(0.0, 1.0, 2));
        let stretch = 1.0 + p * p + q * q;
        let exact =
            ((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * stretch.powf(1.5));
        assert!((mean / exact - 1.0).abs() < 1e-7, "{mean} {exact}");
    }
}
