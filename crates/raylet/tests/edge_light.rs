//! The light that the edge of an aperture sends far beside its own way, by local bands, against Rayleigh and Sommerfeld's integral.

use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::optics::aperture::Aperture;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet::optics::shape::Shape;
use raylet_testkit::parts::element;

const WAVELENGTH: f64 = 0.5e-3;
const RADIUS: f64 = 0.3;
const DISTANCE: f64 = 2.0;
const ASIDE: f64 = 0.9;
/// Slope of the phase of the prism on the disc, as an optical direction cosine.
const TURN: f64 = -0.05;

/// The field behind a prism on a disc at a place of the sensor: Gauss points along chords, whose heights are R·sin t.
fn exact([x, y]: [f64; 2]) -> Complex64 {
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

/// A sensor at 24° to the light has no light but that of the edge. Nodes of windows resolve 4° here.
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
    let field = &found.field;
    let (mut off, mut all) = (0.0, 0.0);
    for ((j, i), value) in field.values.indexed_iter() {
        let expected = exact([ASIDE + field.grid.x.node(i), field.grid.y.node(j)]);
        off += (value - expected).norm_sqr();
        all += expected.norm_sqr();
    }
    let error = (off / all).sqrt();
    assert!(error < 1e-2, "{error:e}");
}
