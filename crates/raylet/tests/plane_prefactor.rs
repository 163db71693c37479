//! The prefactor √det(D + ikσ²C) of a plane wavelet, against the ray's Jacobian.
//!
//! Its modulus follows from the Jacobian at once. Its sign is that of the root that starts at one in an
//! empty space and is continued while the surfaces are brought to life: the determinant never vanishes,
//! because the Jacobian stays symplectic.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;
use raylet::engine::beamlet::beamlet_launch::launch_beamlet;
use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use raylet::optics::screen::Screen;
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;
use raylet::wave::beamlet::plane::PlaneWave;
use raylet_testkit::parts::{conic, face, mirror, open_screen};

const WAVELENGTH: f64 = 0.7e-3;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;
const SIGMA: f64 = 0.05;

/// Rays: a point on the first screen and two global direction cosines.
const RAYS: [[f64; 4]; 3] = [
    [0.3, -0.2, 0.05, -0.03],
    [-0.5, 0.4, 0.0, 0.04],
    [0.0, 0.0, -0.04, -0.02],
];

/// Steps in which a system is brought to life.
const STEPS: usize = 200;

fn screen(frame: Frame, arrives: f64) -> Screen {
    Screen {
        arrives,
        ..open_screen(frame)
    }
}

fn place(z: f64, tilt: [f64; 3]) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.1, -0.2, z)).tilted(tilt)
}

/// Two tilted lenses of index `n`, each behind the image that the one before makes.
fn lenses(n: f64) -> Vec<Surface> {
    let lens = |z: f64, tilt: [f64; 3]| {
        [(z, 20.0, [1.0, n]), (z + 3.0, -20.0, [n, 1.0])]
            .map(|(z, radius, index)| face(place(z, tilt), conic(1.0 / radius, -0.4), index))
    };
    let (first, second) = (lens(42.0, [0.25, -0.1, 0.0]), lens(130.0, [-0.1, 0.3, 0.0]));
    first.into_iter().chain(second).collect()
}

/// A tilted mirror whose curvature is `share` of 1/60 per mm.
fn grown_mirror(share: f64) -> Vec<Surface> {
    let frame = Frame::GLOBAL
        .moved(Vec3::new(0.0, 0.0, 60.0))
        .tilted([0.0, 0.5, 0.0]);
    let radius = -60.0 / share.max(1e-12);
    vec![mirror(frame, conic(1.0 / radius, -0.4))]
}

/// √(cos₁/cos₂·|det(D + ikσ²C)|), and the phase of the root, continued from `alive(0)` to `alive(1)`.
fn continued(
    alive: impl Fn(f64) -> Vec<Surface>,
    [from, to]: [&Screen; 2],
    ray: [f64; 4],
) -> [f64; 2] {
    let [x, y, px, py] = ray;
    let (mut phase, mut last, mut size) = (0.0, Complex64::ZERO, 0.0);
    for step in 0..=STEPS {
        let train = alive(step as f64 / STEPS as f64);
        let hop = Hop {
            wavelength: WAVELENGTH,
            from,
            train: &train,
            to,
        };
        let (landing, j) = hop.jacobian([x, y], [px, py]).unwrap();
        let entry =
            |a: usize, b: usize| Complex64::new(j[2 + a][2 + b], K * SIGMA * SIGMA * j[2 + a][b]);
        let d = entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0);
        if step > 0 {
            let turn = (d / last).arg();
            assert!(
                turn.abs() < 0.5,
                "the steps are too long to follow the root: {turn}"
            );
            phase += turn;
        }
        let cosine = |[px, py]: [f64; 2]| (1.0 - px * px - py * py).sqrt();
        size = (d.norm() * cosine([px, py]) / cosine(landing.cosines)).sqrt();
        last = d;
    }
    [size, 0.5 * phase]
}

/// The prefactor of the library, without the phase of the optical path.
fn prefactor(train: &[Surface], [from, to]: [&Screen; 2], ray: [f64; 4]) -> Complex64 {
    let hop = Hop {
        wavelength: WAVELENGTH,
        from,
        train,
        to,
    };
    let [x, y, px, py] = ray;
    let beamlet = launch_beamlet(&hop, [x, y], [px, py], SIGMA).unwrap();
    let landing = hop.trace([x, y], [px, py], &mut ()).unwrap();
    PlaneWave::from_beamlet(&beamlet).amplitude * Complex64::cis(-K * landing.path)
}

/// Compares the two on all rays; returns the largest continued phase.
fn compare(alive: impl Fn(f64) -> Vec<Surface>, screens: [&Screen; 2]) -> f64 {
    let mut farthest: f64 = 0.0;
    for [x, y, dx, dy] in RAYS {
        let direction = Vec3::new(dx, dy, (1.0 - dx * dx - dy * dy).sqrt());
        let p = screens[0].frame.direction_to_local(direction);
        let ray = [x, y, p.x, p.y];
        let [size, phase] = continued(&alive, screens, ray);
        let found = prefactor(&alive(1.0), screens, ray);
        let expected = Complex64::from_polar(size, phase);
        assert!(
            (found.norm() / size - 1.0).abs() < 1e-8,
            "{found} {expected}"
        );
        assert!(
            (found - expected).norm() < 1e-8 * size,
            "{found} {expected}"
        );
        farthest = farthest.max(phase.abs());
    }
    farthest
}

/// Between the lenses and behind both; there the determinant has turned by more than a whole cycle, so
/// that its principal root has the wrong sign.
#[test]
fn prefactor_of_tilted_lenses_follows_from_the_jacobian() {
    let from = screen(Frame::GLOBAL.tilted([0.1, -0.15, 0.2]), 1.0);
    let grown = |share: f64| lenses(1.0 + 0.5 * share);
    let to = screen(place(200.0, [0.2, 0.1, -0.3]), 1.0);
    let first = |share: f64| grown(share)[..2].to_vec();
    let one = compare(first, [&from, &to]);
    let two = compare(grown, [&from, &to]);
    assert!(one > FRAC_PI_2 && two > PI, "{one} {two}");
}

/// A mirror changes the handedness of the axes; the prefactor does not depend on it.
#[test]
fn prefactor_of_a_tilted_mirror_follows_from_the_jacobian() {
    let from = screen(Frame::GLOBAL.tilted([0.1, 0.0, 0.0]), 1.0);
    let turned = Frame::GLOBAL
        .moved(Vec3::new(0.0, 0.0, 60.0))
        .tilted([0.0, 1.0, 0.0]);
    let to = screen(
        turned
            .moved(Vec3::new(0.0, 0.0, -70.0))
            .tilted([0.1, 0.2, 0.0]),
        -1.0,
    );
    let phase = compare(grown_mirror, [&from, &to]);
    assert!(phase > FRAC_PI_2, "{phase}");
}
