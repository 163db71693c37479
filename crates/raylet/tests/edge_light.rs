//! The light of edges and of singular points by local bands, against Rayleigh and Sommerfeld's integral: far beside the light's own
//! way, and behind wide axicons.

use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::optics::aperture::Aperture;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet::optics::shape::Shape;
use raylet::wave::grid::field::Field;
use raylet_testkit::parts::element;

const WAVELENGTH: f64 = 0.5e-3;
const RADIUS: f64 = 0.3;
const DISTANCE: f64 = 2.0;
const ASIDE: f64 = 0.9;
/// Slope of the phase of the prism on the disc, as an optical direction cosine.
const TURN: f64 = -0.05;

/// The field behind a prism on a disc at a place of the sensor: Gauss points along chords, whose heights are R·sin t.
fn behind_prism([x, y]: [f64; 2]) -> Complex64 {
    let k = std::f64::consts::TAU / WAVELENGTH;
    let [chords, panels] = [6000, 2000];
    let gauss = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    ];
    let chord = |n: usize| {
        let t = std::f64::consts::PI * ((n as f64 + 0.5) / chords as f64 - 0.5);
        let (height, half) = (RADIUS * t.sin(), RADIUS * t.cos());
        let panel = half / panels as f64;
        let point = |m: usize| {
            let middle = -half + (2 * m + 1) as f64 * panel;
            let at = |(node, weight): (f64, f64)| {
                let u = middle + node * panel;
                let way = ((x - u).powi(2) + (y - height).powi(2) + DISTANCE * DISTANCE).sqrt();
                // (1 − ikr)·z·exp(ikr)/(2πr³)
                let factor = Complex64::new(1.0, -k * way) * DISTANCE
                    / (std::f64::consts::TAU * way.powi(3));
                factor * Complex64::from_polar(weight * panel, k * (way + TURN * u))
            };
            gauss.into_iter().map(at).sum::<Complex64>()
        };
        let line: Complex64 = (0..panels).map(point).sum();
        line * half * std::f64::consts::PI / chords as f64
    };
    (0..chords).map(chord).sum()
}

/// The relative error of a row of a field beside what is exact there, at every so many values; `exact` takes places about the middle
/// of the sensor.
fn relative_error(field: &Field, step: usize, exact: impl Fn([f64; 2]) -> Complex64) -> f64 {
    let (mut off, mut all) = (0.0, 0.0);
    for ((j, i), value) in field.values.indexed_iter().step_by(step) {
        let expected = exact([field.grid.x.node(i), field.grid.y.node(j)]);
        off += (value - expected).norm_sqr();
        all += expected.norm_sqr();
    }
    (off / all).sqrt()
}

/// A sensor at 24° to the light has no light but that of the edge. Nodes under windows of the usual width resolve 17°.
#[test]
fn a_dark_sensor_sees_the_edge() {
    let gradient = [TURN * std::f64::consts::TAU / WAVELENGTH, 0.0];
    let prism = element(
        Layer::Phase(Profile::Linear { gradient }),
        Aperture::disc(RADIUS),
    );
    let system = SystemBuilder::new(WAVELENGTH)
        .element("prism", Shape::Plane, prism)
        .gap(DISTANCE)
        .offset([ASIDE, 0.0], [0.0; 3])
        .sensor([3, 1], [4e-3; 2])
        .build()
        .unwrap();
    let settings = Settings {
        method: Method::LocalBands,
        ..Settings::default()
    };
    let found = simulate(&system, &settings, &|_| {}).unwrap();
    let error = relative_error(&found.field, 1, |[x, y]| behind_prism([ASIDE + x, y]));
    assert!(error < 1e-2, "{error:e}");
}

const RED: f64 = 0.6328e-3;
const FAR: f64 = 100.0;

/// J₀.
fn bessel(v: f64) -> f64 {
    let at = |n: usize| std::f64::consts::PI * (n as f64 + 0.5) / 200.0;
    (0..200).map(|n| (v * at(n).sin()).cos()).sum::<f64>() / 200.0
}

/// Rayleigh and Sommerfeld's integral at a distance from the axis, ring by ring; for light near the axis the rings' obliquity is
/// that of their own point on the axis.
fn behind_axicon(radius: f64, slope: f64, place: f64) -> Complex64 {
    let k = std::f64::consts::TAU / RED;
    let steps = (radius * radius / (RED * FAR) * 400.0).ceil() as usize + 20_000;
    let step = radius / steps as f64;
    let ring = |n: usize| {
        let r = (n as f64 + 0.5) * step;
        let way = (r * r + FAR * FAR).sqrt();
        let weight = r * step * FAR / (way * way) * k;
        let path = way + 0.5 * place * place / way;
        Complex64::from_polar(weight, slope * r + k * path) * bessel(k * r * place / way)
    };
    Complex64::new(0.0, -1.0) * (0..steps).map(ring).sum::<Complex64>()
}

/// An axicon that turns light by half a degree. Tiles about its axis once were sampled for light that does not turn at all, so
/// that the middle of wide ones was dark; and nodes at the rim were too coarse for its light, a twelfth of that on the axis. At the
/// widest one it is summed along the edge: without it the error was 3e-2.
#[test]
fn wide_axicons_have_their_bright_axis() {
    let slope = -std::f64::consts::TAU / RED * 0.5f64.to_radians().sin();
    for radius in [2.0, 3.0, 5.0] {
        let axicon = element(
            Layer::Phase(Profile::Axicon { slope }),
            Aperture::disc(radius),
        );
        let system = SystemBuilder::new(RED)
            .element("axicon", Shape::Plane, axicon)
            .gap(FAR)
            .sensor([41, 1], [2e-3; 2])
            .build()
            .unwrap();
        let settings = Settings {
            method: Method::LocalBands,
            ..Settings::default()
        };
        let found = simulate(&system, &settings, &|_| {}).unwrap();
        let exact = |[x, _]: [f64; 2]| behind_axicon(radius, slope, x.abs());
        let error = relative_error(&found.field, 5, exact);
        let expected = found.expected_error().unwrap();
        // Nodes at the rim of the wider one just resolve its light, and the estimate counts a part of it as missing.
        assert!(
            error < 3e-4 && expected > 0.5 * error && expected < 1e-2,
            "radius {radius}: {error:e}, expected {expected:e}"
        );
    }
}
