//! The source paper's method on a curved diffractive mirror: its patches lie on the planes that touch
//! the mirror, and their error grows with them; with the height of the mirror it does not.

use std::sync::LazyLock;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Paper, Positions, Sag, Sampler, Settings};
use raylet::wave::grid::metrics::{field_error, shape_error};
use raylet::wave::patches::tile::TileWindow;
use raylet_accuracy::problems::mirror::{Coat, MirrorProblem};

/// Random pixels of 1.6 wavelengths on a Gaussian bump, whose smallest radius of curvature is 506 λ.
fn mirror(width: f64) -> MirrorProblem {
    MirrorProblem {
        coat: Coat::Random(1.6),
        width,
        distance: 250.0,
        points: 16,
        pitch: 1.9,
    }
}

/// Every mode of patches side by side, or `overlap` times as dense, with what covers each place divided out:
/// nothing is left to chance. Periods keep the copies off the sensor; orders take in what the pixels' edges bend
/// towards it.
fn error(
    mirror: MirrorProblem,
    exact: &Array2<Complex64>,
    [patch, overlap]: [f64; 2],
    window: TileWindow,
    sag: Sag,
) -> [f64; 2] {
    let across = ((mirror.width / patch).ceil() * overlap) as usize;
    let settings = Settings {
        method: Method::Paper,
        nufft_tolerance: 1e-9,
        paper: Paper {
            rays: across * across,
            patch: Some(patch),
            window,
            padding: (290.0 + mirror.width) / patch,
            orders: 2,
            positions: Positions::Grid,
            coverage: true,
            sampler: Sampler::All,
            sag,
            ..Paper::default()
        },
        ..Settings::default()
    };
    let problem = mirror.problem("random", settings, 6);
    let outcome = simulate(&problem.system, &problem.settings, &|_| {}).unwrap();
    let ours = outcome.field.values;
    let (ours, exact) = (ours.view(), exact.view());
    [
        field_error(ours, exact).unwrap(),
        shape_error(ours, exact).unwrap().error,
    ]
}

/// The exact field of a mirror of 120 wavelengths.
static EXACT: LazyLock<Array2<Complex64>> = LazyLock::new(|| mirror(120.0).exact(6));

/// Patches of 25, 50 and 100 wavelengths.
const SIZES: [f64; 3] = [25.0, 50.0, 100.0];

#[test]
fn tangent_patches_err_with_their_size_and_true_ones_do_not_slow() {
    let square = || mirror(120.0);
    let exact = &*EXACT;
    for (patch, [low, high]) in SIZES
        .into_iter()
        .zip([[0.5, 0.65], [0.9, 1.0], [0.95, 1.0]])
    {
        let [tangent, whole] = [Sag::Tangent, Sag::True]
            .map(|sag| error(square(), exact, [patch, 1.0], TileWindow::Rectangle, sag));
        let found =
            format!("{patch} wavelengths: tangent {tangent:.3?}, with the height {whole:.4?}");
        assert!((low..high).contains(&tangent[1]), "{found}");
        assert!(whole[0] < 6e-3, "{found}");
    }
}

/// How large the error of a plane is depends on its use: half the phase where the light that
/// comes meets the true surface, and of what overlapping patches have in common only a factor is left.
#[test]
fn overlap_and_the_incident_light_decide_about_planes_slow() {
    let square = || mirror(120.0);
    let exact = &*EXACT;
    let expected = [
        (Sag::Tangent, 2.0, [0.32, 0.92, 0.97]),
        (Sag::Incident, 1.0, [0.31, 0.83, 0.95]),
        (Sag::Incident, 2.0, [0.15, 0.65, 0.97]),
    ];
    for (sag, overlap, expected) in expected {
        for (patch, expected) in SIZES.into_iter().zip(expected) {
            let [_, shape] = error(
                square(),
                exact,
                [patch, overlap],
                TileWindow::Rectangle,
                sag,
            );
            assert!(
                (shape - expected).abs() < 0.01,
                "{sag:?}, {overlap} times as dense, {patch} wavelengths: {shape:.3}"
            );
        }
    }
}

/// Windows that fade to their edges, twice as dense as patches side by side: what neighbours have in common is a
/// factor, so that the shape errs less than the field.
#[test]
fn fading_patches_err_too() {
    let square = || mirror(120.0);
    let exact = &*EXACT;
    for (patch, expected) in [(50.0, [0.669, 0.235]), (100.0, [1.027, 0.818])] {
        let found = error(
            square(),
            exact,
            [patch, 2.0],
            TileWindow::Hann,
            Sag::Incident,
        );
        assert!(
            (found[0] - expected[0]).abs() < 0.01 && (found[1] - expected[1]).abs() < 0.01,
            "{patch} wavelengths: {found:.3?}"
        );
    }
}
