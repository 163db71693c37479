//! Systems at their real size whose field is known in closed form.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use num_complex::Complex64;
use raylet::engine::chain::forecast::{forecast, forecast_run};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::settings::Settings;
use raylet::engine::rims::rim_screens::{Rim, RimTreatment};
use raylet::file::model::build;
use raylet::file::model::scene_sweep::scene_at_place;
use raylet::file::result::channel::Place;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet_accuracy::numerics::quadrature::gauss_legendre;
use raylet_accuracy::objective::ray_integral::chief_landing;
use raylet_accuracy::objective::triplet::Triplet;
use raylet_accuracy::real_size::cases::{Case, Mask, cases};
use raylet_accuracy::real_size::on_axis::compare;
use raylet_testkit::scenes::{scene_path, scene_system};

/// Focal length of the telescope, radii of its aperture and obstruction, and half the width of a vane, in mm.
const FOCAL: f64 = 500.0;
const APERTURE: f64 = 25.0;
const OBSTRUCTION: f64 = 8.0;
const VANE: f64 = 0.5;

/// Points of the aperture between the vanes, with their areas in mm²: Gauss nodes along the radius and along each arc.
fn open_points() -> Vec<([f64; 2], f64)> {
    let mut points = Vec::new();
    for (t, w) in gauss_legendre(60) {
        let half = 0.5 * (APERTURE - OBSTRUCTION);
        let r = OBSTRUCTION + half * (t + 1.0);
        let vane = (VANE / r).asin();
        let arc = 0.5 * (FRAC_PI_2 - 2.0 * vane);
        for quarter in 0..4 {
            let middle = FRAC_PI_4 + FRAC_PI_2 * (f64::from(quarter) + 0.5);
            for (u, v) in gauss_legendre(40) {
                let (s, c) = (middle + arc * u).sin_cos();
                points.push(([r * c, r * s], half * w * r * arc * v));
            }
        }
    }
    points
}

/// A classical Cassegrain telescope has no aberration on its axis, and light at the height r goes to the focus as from a
/// paraboloid of its focal length: r = 2f tan(θ/2). With the power of its ray tubes, the field at the focus is the transform
/// −(i/λf) e^{ikL} ∫ e^{−ikx·p}/(1 + r²/4f²) d²r over the aperture, with sines p = (r/f)/(1 + r²/4f²). Beside the
/// focus it is curved about the exit pupil, by x²D/2f; D is 3.175 from the stop, 100 mm before the primary.
#[test]
fn a_telescope_with_a_spider_has_the_transform_of_its_aperture() {
    let (system, settings) = scene_system("real_size/cassegrain").unwrap();
    let ours = simulate(&system, &settings, &|_| {}).unwrap().field.values;
    let k = TAU / system.wavelength;
    let points = open_points();
    let (length, curved) = (100.0 + 95.0 + 120.0, 3.175 / (2.0 * FOCAL));
    let (mut off, mut all) = (0.0, 0.0);

    // Every third pixel of the middle 32 × 32.
    let places = || (32..64).step_by(3);
    for (row, column) in places().flat_map(|j| places().map(move |i| (j, i))) {
        let place = |index: usize| (index as f64 - 47.5) * 1e-3;
        let (x, y) = (place(column), place(row));
        let waves = points.iter().map(|([u, v], area)| {
            let share = 1.0 / (1.0 + (u * u + v * v) / (4.0 * FOCAL * FOCAL));
            Complex64::cis(-k * (x * u + y * v) * share / FOCAL) * (area * share)
        });
        let path = Complex64::cis(k * (length + (x * x + y * y) * curved));
        let exact = waves.sum::<Complex64>() * path * Complex64::new(0.0, -k / (TAU * FOCAL));
        off += (ours[[row, column]] - exact).norm_sqr();
        all += exact.norm_sqr();
    }
    let error = (off / all).sqrt();
    assert!(error < 3e-4, "{error:e}");
}

/// A sensor follows the ray through the middle of the stop inside an objective, which is not its first element.
#[test]
fn sensors_follow_the_ray_through_an_inner_stop() {
    let scene = Scene::read(&scene_path("real_size/cooke_triplet")).unwrap();
    for angle in [-20.0, 0.0, 14.0, 20.0] {
        let place = Place {
            angle_deg: Some([angle, 3.0]),
            ..Place::default()
        };
        let [system, followed] = [false, true]
            .map(|follow| build::system(&scene_at_place(&scene, &place, follow).unwrap(), 0));
        let (system, followed) = (system.unwrap(), followed.unwrap());
        let expected = chief_landing(&system, [0.0; 2]).unwrap();
        let [before, after] =
            [&system, &followed].map(|of| of.screens.last().unwrap().frame.origin);
        let off = [
            after.x - before.x - expected[0],
            after.y - before.y - expected[1],
        ];
        assert!(off[0].hypot(off[1]) < 1e-6, "{angle}: {off:?}");
    }
}

/// The field of a triplet f/4 of 1.25 mm is the exact one, within the error that raylet tells. So is that of a triplet of 2.5 mm
/// with a vortex at its stop.
#[test]
fn small_triplets_have_their_exact_fields() {
    for (scale, vortex, bound) in [(0.025, false, 1.5e-3), (0.05, true, 1e-3)] {
        let mut triplet = Triplet::bare(4.0 * scale, 0.0);
        triplet.scale = scale;
        if vortex {
            let layer = Layer::Phase(Profile::Vortex { charge: 1 });
            triplet.element.layers.push(layer);
        }
        let found = compare(&triplet.system().unwrap(), &Settings::default(), 0.5).unwrap();
        let ratio = found.expected / found.error;
        assert!(
            found.error < bound && (0.4..2.5).contains(&ratio),
            "{scale}: {found:?}"
        );
    }
}

/// The last rim of a triplet f/4 of 5 mm cuts more than half of the light and diffracts it, as in the exact field: 8e-2 of the field
/// would be wrong if it cut single beamlets.
#[test]
fn a_rim_of_any_size_diffracts() {
    let scale = 0.1;
    let mut triplet = Triplet::bare(4.0 * scale, 0.0);
    triplet.scale = scale;
    let mut system = triplet.system().unwrap();
    system.trains[1][1].aperture = Aperture::disc(3.2 * scale);
    let settings = Settings::default();
    let outcome = simulate(&system, &settings, &|_| {}).unwrap();
    let rims: Vec<&Rim> = outcome
        .rimmed
        .rims
        .iter()
        .filter(|rim| rim.cut > 0.1)
        .collect();
    let [rim] = rims[..] else { panic!("{rims:?}") };
    assert_eq!(rim.treatment, RimTreatment::Screen);
    let found = compare(&system, &settings, 0.4).unwrap();
    assert!(found.error < 3e-4 && found.expected < 6e-4, "{found:?}");
    assert!(found.error < 2.0 * found.expected, "{found:?}");
}

/// A rim of the double Gauss lens at 10° is a screen: the forecast knows that light passes it as it came, and takes less than two
/// minutes. Rims of the triplet with a grating at 20° would take longer, and cut single rays.
#[test]
fn rims_diffract_where_that_takes_little_time() {
    for (name, angle_deg, diffracts) in [
        ("double_gauss_f2", 10.0, true),
        ("cooke_triplet", 20.0, false),
    ] {
        let asked = |case: &Case| {
            let mask = name != "cooke_triplet" || case.mask == Mask::Grating;
            case.scene == name && case.angle_deg == angle_deg && mask
        };
        let case = cases().into_iter().find(asked);
        let whole = Case {
            stop: None,
            ..case.unwrap()
        };
        let (system, settings) = whole.system().unwrap();
        let run = forecast_run(&system, &settings, |_, _| ()).unwrap();
        let screens = run
            .rimmed
            .rims
            .iter()
            .filter(|rim| rim.treatment == RimTreatment::Screen);
        assert_eq!(screens.count() > 0, diffracts, "{name}");
        let seconds: f64 = run.hops.iter().map(|hop| hop.work.seconds).sum();
        assert!(seconds < 120.0, "{name}: {seconds}");
    }
}

/// The pixels of the modulator have few directions: local bands take a third of the time of whole fields there.
#[test]
fn the_modulator_goes_by_local_bands() {
    let (system, settings) = scene_system("real_size/slm_camera").unwrap();
    let hops = forecast(&system, &settings).unwrap();
    assert!(matches!(hops[0].method, HopMethod::LocalBands(_)));
}
