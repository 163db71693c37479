//! Gaps between pixels make the orders of their lattice what they are.

use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::phase::placement::Placement;
use raylet::optics::pixels::active_area::{ActiveArea, Rest};
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::screen::ScreenKind;
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::parts::{element, lit, on_axis, screen, sensor};

/// Pixels along each side, and of how many parts of a pixel the gap is one, on each side.
const PIXELS: usize = 12;
const PARTS: usize = 20;

/// The light of pixels 6 wavelengths wide on a sensor so far beside the axis; their first order is at 65 wavelengths.
fn light(pixels: Pixels, aperture: Aperture, method: Method, aside: f64) -> Array2<Complex64> {
    run(pixels, aperture, method, aside).field.values
}

fn run(pixels: Pixels, aperture: Aperture, method: Method, aside: f64) -> Outcome {
    let beside = on_axis(400.0).moved(Vec3::new(aside, 0.0, 0.0));
    let doe = element(Layer::Pixels(pixels), aperture);
    let screens = vec![
        screen(on_axis(0.0), ScreenKind::Doe(doe)),
        screen(beside, sensor(24, 2.0)),
    ];
    let settings = Settings {
        method,
        ..Settings::default()
    };
    let system = lit(screens, vec![Vec::new()]);
    simulate(&system, &settings, &|_| {}).unwrap()
}

/// A pixel with a gap of a twentieth of the pitch on each side is 20² finer pixels, of which the outer ones are those of the gap:
/// by whole fields and by local bands, through the pixels' own rectangle, a disc that is wider, and one that
/// cuts some of them.
#[test]
fn pixels_with_gaps_are_those_of_finer_pixels() {
    let phase = |j: usize, i: usize| Complex64::cis((7 * i * i + 3 * j * j + 5 * i * j) as f64);
    let pitch = [6.0; 2];
    let form = PixelForm::Box;
    for rest in [Rest::Dark, Rest::Flat] {
        let gap = match rest {
            Rest::Dark => Complex64::ZERO,
            Rest::Flat => Complex64::ONE,
        };
        let part = |n: usize| (1..PARTS - 1).contains(&(n % PARTS));
        let count = PIXELS * PARTS;
        let fine = Pixels {
            pitch: pitch.map(|pitch| pitch / PARTS as f64),
            values: Array2::from_shape_fn((count, count), |(j, i)| match part(j) && part(i) {
                true => phase(j / PARTS, i / PARTS),
                false => gap,
            }),
            form,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        };
        let gapped = Pixels {
            pitch,
            values: Array2::from_shape_fn((PIXELS, PIXELS), |(j, i)| phase(j, i)),
            form,
            active: ActiveArea::of_fill(0.81, rest).unwrap(),
            placement: Placement::NONE,
        };
        let mean = Pixels {
            values: gapped.values.mapv(|value| 0.81 * value + 0.19 * gap),
            active: ActiveArea::WHOLE,
            ..gapped.clone()
        };
        for (aperture, aside, method, most) in [
            (Aperture::OPEN, 65.0, Method::Auto, 1e-6),
            (Aperture::disc(31.0), 65.0, Method::Auto, 1e-3),
            (Aperture::OPEN, 0.0, Method::LocalBands, 1e-3),
            (Aperture::disc(60.0), 0.0, Method::LocalBands, 1e-3),
            (Aperture::disc(31.0), 0.0, Method::LocalBands, 5e-4),
        ] {
            let of =
                |pixels: &Pixels, method| light(pixels.clone(), aperture.clone(), method, aside);
            let exact = of(&fine, Method::Auto);
            let error = field_error(of(&gapped, method).view(), exact.view()).unwrap();
            let by_means = field_error(of(&mean, Method::Auto).view(), exact.view()).unwrap();
            let all = format!("{rest:?} {aperture:?} {method:?}: {error:e} {by_means:e}");
            assert!(error < most && by_means > 10.0 * most, "{all}");
        }
    }
}

/// Pixels that are all alike have no first order: there the sensor has a thousandth of the light that falls beside it, whose
/// footprints end before it. What they lack there is in the expected error of local bands.
#[test]
fn dark_places_beside_bright_ones_are_less_exact_and_the_estimate_knows() {
    let alike = Pixels {
        pitch: [6.0; 2],
        values: Array2::ones((PIXELS, PIXELS)),
        form: PixelForm::Box,
        active: ActiveArea::WHOLE,
        placement: Placement::NONE,
    };
    for (aperture, aside) in [
        (Aperture::OPEN, 30.0),
        (Aperture::OPEN, 65.0),
        (Aperture::OPEN, 100.0),
        (Aperture::disc(31.0), 65.0),
    ] {
        let exact = light(alike.clone(), aperture.clone(), Method::Auto, aside);
        let found = run(alike.clone(), aperture, Method::LocalBands, aside);
        let error = field_error(found.field.values.view(), exact.view()).unwrap();
        let expected = found.expected_error().unwrap();
        assert!(
            (0.4..2.5).contains(&(expected / error)) && error < 6e-3,
            "{aside}: {error:e} {expected:e}"
        );
    }
}

/// The first order of a light modulator of 8 µm pixels filled to 0.93, all at phase zero, behind a lens: sinc²(√0.93) of the zero
/// order where the gaps are dark, nothing where they are flat.
#[test]
fn the_first_order_of_a_lattice_has_its_closed_form() {
    let (focal, wavelength, pitch) = (50.0f64, 0.532e-3, 8e-3f64);
    let peak = |method: &str, rest: &str, order: f64| {
        let x = focal * (order * wavelength / pitch).asin().tan();
        let text = format!(
            "version = 1\nwavelength_um = 0.532\nsource = {{ kind = \"plane\" }}\nsettings = {{ method = \"{method}\" }}\n\
             [[element]]\nkind = \"doe\"\nthickness_mm = {focal}\naperture = {{ rectangle = {{ width_mm = 0.8, height_mm = 0.8 }} }}\n\
             [[element.layer]]\nkind = \"lens\"\nfocal_length_mm = {focal}\n\
             [[element.layer]]\nkind = \"pixels\"\npitch_um = 8\nsize = [100, 100]\nfill = 0.93\nrest = \"{rest}\"\n\
             [[element]]\nkind = \"sensor\"\npixels = [5, 5]\npitch_um = 4.0\ndecenter_mm = [{x}, 0.0]\n"
        );
        let scene = Scene::parse(&text, Path::new("modulator.toml")).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let found = simulate(&system, &Settings::default(), &|_| {}).unwrap();
        found
            .field
            .intensity()
            .fold(0.0, |most: f64, i| most.max(*i))
    };
    let side = std::f64::consts::PI * 0.93f64.sqrt();
    let expected = (side.sin() / side).powi(2);
    for method in ["auto", "local_bands"] {
        let ratio = |rest: &str| peak(method, rest, 1.0) / peak(method, rest, 0.0);
        let (dark, flat) = (ratio("dark"), ratio("flat"));
        let all = format!("{method}: {dark:e} {flat:e} {expected:e}");
        assert!(
            (dark / expected - 1.0).abs() < 0.02 && flat < 1e-2 * expected,
            "{all}"
        );
    }
}
