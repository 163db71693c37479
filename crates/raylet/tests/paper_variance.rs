//! The source paper's estimate of a field: unbiased in free space, with the variance that theory gives.
//!
//! Of a patch's modes cₘ, N are drawn with probability π and weighted c/(Nπ). The estimate's mean squared
//! error at a point is (Σ|c|²/π − |V|²)/N, V the patch's field there: ((Σ|c|)² − |V|²)/N for π ∝ |c|,
//! (KΣ|c|² − |V|²)/N for π alike for K modes. Patches at random positions add the variance of V from
//! patch to patch.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::error::tally::Tally;
use raylet::engine::monte_carlo::paper::PaperRun;
use raylet::engine::monte_carlo::paper_plan::{DrawAddress, PaperPlan};
use raylet::engine::plan::settings::{Density, Positions, Sag, Sampler};
use raylet::engine::progress::uncancelled;
use raylet::optics::system::Hop;
use raylet::wave::beamlet::plane::PlaneSum;
use raylet::wave::grid::field::{Axis, Field, Grid};
use raylet::wave::grid::raster::Raster;
use raylet::wave::patches::patch::Band;
use raylet::wave::patches::tile::TileWindow;
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{on_axis, open_screen};

/// Wavelength, pitch of the field, and distance of the screens.
const WAVELENGTH: f64 = 1.0;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;
const PITCH: f64 = 2.0;
const DISTANCE: f64 = 25.0;

/// Samples of the field, of a patch and of its period along each axis.
const FIELD: usize = 16;
const PATCH: usize = 8;
const PERIOD: usize = 16;

/// Points where the estimate is judged.
const RASTER: Raster = Raster {
    start: [-9.0, -7.0],
    pitch: [3.0, 2.5],
    size: [7, 6],
};

fn field() -> Field {
    let axis = Axis::uniform(FIELD, PITCH, 0.0);
    let grid = Grid {
        x: axis.clone(),
        y: axis,
    };
    Field {
        values: phases([FIELD; 2], 3),
        ..Field::zeros(grid)
    }
}

fn band(period: usize) -> Band {
    let (spacing, half) = (
        WAVELENGTH / (period as f64 * PITCH),
        0.5 * WAVELENGTH / PITCH,
    );
    Band::between(0.0, spacing, -half, half - 1e-9 * spacing)
}

/// The library's estimate at the raster's points, and its tally.
fn run(field: &Field, plan: &PaperPlan, seed: u64) -> (Array2<Complex64>, Tally) {
    let (from, to) = (open_screen(on_axis(0.0)), open_screen(on_axis(DISTANCE)));
    let hop = Hop {
        wavelength: WAVELENGTH,
        from: &from,
        train: &[],
        to: &to,
    };
    let mut sum = PlaneSum::new(RASTER, K, 1e-9).unwrap();
    let address = DrawAddress { seed, hop: 0 };
    let run = PaperRun::new(hop, plan, address, field);
    let tally = run.carry(&mut sum, &|_| uncancelled()).unwrap();
    (sum.finish(), tally)
}

fn estimate(field: &Field, plan: &PaperPlan, seed: u64) -> Array2<Complex64> {
    run(field, plan, seed).0
}

/// `positions` patches in the middle `area` of the field, `secondary` modes of each.
fn plan(positions: usize, secondary: usize, half: f64) -> PaperPlan {
    PaperPlan {
        positions,
        rule: Positions::Dilated,
        cells: [positions, 1],
        coverage: false,
        secondary,
        density: Density::Amplitude,
        sampler: Sampler::Multinomial,
        sag: Sag::True,
        along: 1.0,
        area: [-half, half, -half, half],
        side: PATCH as f64 * PITCH,
        window: TileWindow::Rectangle,
        period: PERIOD as f64 * PITCH,
        bands: [band(PERIOD); 2],
        obliquity: false,
        arriving: [1.0; 2],
    }
}

/// What one patch is: Σ|c| and Σ|c|² over its modes, how many they are, and its field at the raster's
/// points, all by direct sums.
struct Exact {
    sizes: f64,
    squares: f64,
    modes: f64,
    values: Array2<Complex64>,
}

/// The patch whose first sample is that of the given indices, which may lie outside of the field.
fn patch(field: &Field, first: [i64; 2]) -> Exact {
    patch_of_period(field, first, PERIOD)
}

fn patch_of_period(field: &Field, [first_x, first_y]: [i64; 2], period: usize) -> Exact {
    let inside = |i: i64| (0..FIELD as i64).contains(&i);
    let band = band(period);
    let along = |first: i64, m: usize| -> Vec<(usize, Complex64)> {
        (first..first + PATCH as i64)
            .filter(|i| inside(*i))
            .map(|i| {
                let x = field.grid.x.node(i as usize);
                (i as usize, Complex64::cis(-K * band.at(m) * x))
            })
            .collect()
    };
    let [nx, ny] = RASTER.size;
    let mut exact = Exact {
        sizes: 0.0,
        squares: 0.0,
        modes: (band.count * band.count) as f64,
        values: Array2::zeros((ny, nx)),
    };
    for my in 0..band.count {
        let down = along(first_y, my);
        for mx in 0..band.count {
            let across = along(first_x, mx);
            let mut c = Complex64::ZERO;
            for (j, b) in &down {
                for (i, a) in &across {
                    c += field.values[[*j, *i]] * a * b;
                }
            }
            c /= (period * period) as f64;
            exact.sizes += c.norm();
            exact.squares += c.norm_sqr();
            let [px, py] = [band.at(mx), band.at(my)];
            let q = (1.0 - px * px - py * py).sqrt();
            for ((j, i), value) in exact.values.indexed_iter_mut() {
                let x = RASTER.start[0] + i as f64 * RASTER.pitch[0];
                let y = RASTER.start[1] + j as f64 * RASTER.pitch[1];
                *value += c * Complex64::cis(K * (px * x + py * y + q * DISTANCE));
            }
        }
    }
    exact
}

fn square(a: &Array2<Complex64>) -> f64 {
    a.iter().map(|v| v.norm_sqr()).sum()
}

/// Mean squared error over the points and many seeds, and what is left of it in the mean of the seeds.
fn measured(
    field: &Field,
    plan: &PaperPlan,
    scale: f64,
    exact: &Array2<Complex64>,
    seeds: u64,
) -> [f64; 2] {
    let (mut mse, mut mean) = (0.0, Array2::zeros(exact.raw_dim()));
    for seed in 0..seeds {
        let error = estimate(field, plan, seed).mapv(|v| v * scale) - exact;
        mse += square(&error);
        mean += &error;
    }
    let count = seeds as f64;
    [mse / count, square(&mean) / (count * count)]
}

/// Half width of an area for positions too small to matter, and the share by which one patch counts.
const FIXED: f64 = 1e-9;

fn fixed_share() -> f64 {
    (2.0 * FIXED).powi(2) / (PATCH as f64 * PITCH).powi(2)
}

/// One patch at a fixed place, for both densities.
#[test]
fn drawn_modes_of_a_patch_have_the_variance_of_their_law() {
    let field = field();
    let first = (FIELD - PATCH) as i64 / 2;
    let exact = patch(&field, [first; 2]);
    let points = exact.values.len() as f64;
    for (density, sum, draws) in [
        (
            Density::Amplitude,
            exact.sizes.powi(2),
            [(4, 4000), (64, 2000)],
        ),
        (
            Density::Uniform,
            exact.modes * exact.squares,
            [(4, 4000), (64, 2000)],
        ),
    ] {
        let law = sum * points - square(&exact.values);
        for (secondary, seeds) in draws {
            let plan = PaperPlan {
                density,
                ..plan(1, secondary, FIXED)
            };
            let scale = 1.0 / fixed_share();
            let [mse, bias] = measured(&field, &plan, scale, &exact.values, seeds);
            let ratio = mse * secondary as f64 / law;
            assert!((ratio - 1.0).abs() < 0.05, "{secondary}: {ratio}");
            // The mean of the seeds is off by what chance leaves, one part in `seeds`, and no more.
            assert!(
                bias / mse < 2.0 / seeds as f64,
                "{secondary}: {bias:e} of {mse:e}"
            );
        }
    }
}

/// Half and a quarter of a patch's modes without replacement: unbiased, and better than with it.
#[test]
fn modes_drawn_without_replacement_err_less() {
    let field = field();
    let first = (FIELD - PATCH) as i64 / 2;
    let exact = patch(&field, [first; 2]);
    for (secondary, gain) in [(64, 1.7), (128, 3.5)] {
        let [with, without] = [Sampler::Multinomial, Sampler::Systematic].map(|sampler| {
            let plan = PaperPlan {
                sampler,
                ..plan(1, secondary, FIXED)
            };
            measured(&field, &plan, 1.0 / fixed_share(), &exact.values, 2000)
        });
        let (times, bias) = (with[0] / without[0], without[1] / without[0]);
        assert!(times > gain && bias < 1e-3, "{secondary}: {times} {bias:e}");
    }
}

/// As many draws without replacement as there are modes are all modes; the lattice has no copies of the
/// raster within its period but the patch itself, so that the sum is the patch's field.
#[test]
fn all_modes_are_the_patch() {
    let field = field();
    let first = (FIELD - PATCH) as i64 / 2;
    let exact = patch(&field, [first; 2]);
    let modes = exact.modes as usize;
    for (sampler, density, secondary) in [
        (Sampler::All, Density::Amplitude, 1),
        (Sampler::Systematic, Density::Amplitude, modes),
        (Sampler::Systematic, Density::Uniform, modes + 5),
    ] {
        let plan = PaperPlan {
            sampler,
            density,
            ..plan(1, secondary, FIXED)
        };
        let whole = PaperPlan {
            sampler: Sampler::All,
            ..plan.clone()
        };
        let (ours, all) = (estimate(&field, &plan, 5), estimate(&field, &whole, 6));
        let apart = (square(&(&ours - &all)) / square(&all)).sqrt();
        let scaled = ours.mapv(|v| v / fixed_share());
        let error = (square(&(scaled - &exact.values)) / square(&exact.values)).sqrt();
        assert!(apart < 1e-12, "{sampler:?} {density:?}: {apart:e}");
        assert!(error < 1e-8, "{sampler:?} {density:?}: {error:e}");
    }
}

/// Tiles side by side, jittered patches and random ones with what covers each node divided out: all give
/// the field of the whole aperture, which each node enters once.
#[test]
fn divided_coverage_leaves_the_field_itself() {
    let field = field();
    let period = 8 * PERIOD;
    let mut whole = Array2::zeros((6, 7));
    for first in [[0, 0], [0, 8], [8, 0], [8, 8]] {
        whole += &patch_of_period(&field, first, period).values;
    }
    let at = |rule, window, cells: [usize; 2], half| PaperPlan {
        rule,
        window,
        cells,
        sampler: Sampler::All,
        period: period as f64 * PITCH,
        bands: [band(period); 2],
        ..plan(cells[0] * cells[1], 1, half)
    };
    let half = 0.5 * FIELD as f64 * PITCH;
    let dilated = half + 0.5 * PATCH as f64 * PITCH;
    // On one lattice copies add up like the patches; coverage that differs from place to place shows.
    let (sharp, hann) = (TileWindow::Rectangle, TileWindow::Hann);
    for (rule, window, cells, half, coverage, low, high) in [
        (Positions::Grid, sharp, [2, 2], half, false, 0.0, 1e-10),
        (Positions::Grid, sharp, [3, 3], half, true, 0.0, 1e-10),
        (Positions::Grid, hann, [4, 4], half, true, 0.0, 1e-10),
        (
            Positions::Jittered,
            sharp,
            [6, 6],
            dilated,
            true,
            0.0,
            1e-10,
        ),
        (Positions::Jittered, hann, [6, 6], dilated, true, 0.0, 1e-10),
        (
            Positions::Dilated,
            sharp,
            [150, 1],
            dilated,
            true,
            0.0,
            1e-10,
        ),
        (Positions::Grid, sharp, [3, 3], half, false, 0.3, 0.6),
    ] {
        let plan = PaperPlan {
            coverage,
            ..at(rule, window, cells, half)
        };
        let error = (square(&(estimate(&field, &plan, 2) - &whole)) / square(&whole)).sqrt();
        assert!(
            (low..high).contains(&error),
            "{rule:?} {window:?} {cells:?}: {error}"
        );
    }
}

/// What a run says of its standard error, against the spread of its repetitions.
#[test]
fn standard_error_is_the_spread_of_repeated_runs_slow() {
    let field = field();
    let half = 0.5 * (FIELD + PATCH) as f64 * PITCH;
    for (positions, secondary, sampler) in [
        (400, 50, Sampler::Multinomial),
        (1003, 20, Sampler::Systematic),
        (2000, 1, Sampler::All),
    ] {
        let plan = PaperPlan {
            sampler,
            ..plan(positions, secondary, half)
        };
        let runs: Vec<_> = (0..40).map(|seed| run(&field, &plan, seed)).collect();
        let mean = runs
            .iter()
            .fold(Array2::<Complex64>::zeros((6, 7)), |sum, run| sum + &run.0);
        let mean = mean.mapv(|v| v / 40.0);
        let spread: f64 = runs
            .iter()
            .map(|run| square(&(&run.0 - &mean)))
            .sum::<f64>()
            / 39.0;
        let ratios: Vec<f64> = runs
            .iter()
            .filter_map(|(values, tally)| {
                Some(tally.standard_error()? * square(values).sqrt() / spread.sqrt())
            })
            .collect();
        let [least, most] = [f64::min, f64::max].map(|f| ratios.iter().copied().reduce(f).unwrap());
        assert_eq!(ratios.len(), 40);
        assert!(
            least > 1.0 / 1.5 && most < 1.5,
            "{positions} {secondary}: {least} {most}"
        );
    }
}

/// The field that all draws have in the mean, with patches anywhere on the field dilated by half a patch.
fn mean_field(field: &Field) -> Array2<Complex64> {
    let steps = FIELD + PATCH;
    let mut mean = Array2::zeros((6, 7));
    for n in 0..steps * steps {
        let first = [n % steps, n / steps].map(|i| i as i64 - PATCH as i64);
        mean += &patch(field, first).values;
    }
    mean / Complex64::from((PATCH * PATCH) as f64)
}

/// What a run says of its standard error point by point: real and imaginary parts are off by once or twice
/// their share of it as often as they should. With 16 batches Student's t of 30 degrees of freedom takes the
/// place of the normal law: 67.5 % and 94.5 %.
#[test]
fn standard_error_of_each_point_covers_its_error() {
    let field = field();
    let half = 0.5 * (FIELD + PATCH) as f64 * PITCH;
    let mean = mean_field(&field);
    for (positions, secondary, sampler) in [
        (400, 50, Sampler::Multinomial),
        (1600, 20, Sampler::Systematic),
    ] {
        let plan = PaperPlan {
            sampler,
            ..plan(positions, secondary, half)
        };
        let (mut error, mut estimated, mut once, mut twice, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for seed in 0..100 {
            let (values, tally) = run(&field, &plan, seed);
            let noise = tally.noise.unwrap();
            for ((value, mean), noise) in values.iter().zip(&mean).zip(&noise) {
                let off = value - mean;
                error += off.norm_sqr();
                estimated += noise * noise;
                for part in [off.re, off.im] {
                    let spreads = part.abs() / (noise / 2f64.sqrt());
                    once += f64::from(u8::from(spreads < 1.0));
                    twice += f64::from(u8::from(spreads < 2.0));
                    count += 1.0;
                }
            }
        }
        let (ratio, once, twice) = (estimated / error, once / count, twice / count);
        assert!((ratio - 1.0).abs() < 0.1, "{sampler:?}: {ratio}");
        assert!((once - 0.675).abs() < 0.03, "{sampler:?}: {once}");
        assert!((twice - 0.945).abs() < 0.02, "{sampler:?}: {twice}");
    }
}

/// The whole method: patches anywhere on the field dilated by half a patch. A patch changes only where a
/// sample enters or leaves it, so the mean over positions is a mean over whole steps.
#[test]
fn random_patches_have_the_variance_of_their_law() {
    let field = field();
    let steps = FIELD + PATCH;
    let share = (steps * steps) as f64 / (PATCH * PATCH) as f64;
    let (mut mean, mut spread, mut drawn) = (Array2::zeros((6, 7)), 0.0, 0.0);
    for n in 0..steps * steps {
        let first = [n % steps, n / steps].map(|i| i as i64 - PATCH as i64);
        let exact = patch(&field, first);
        spread += square(&exact.values);
        drawn += exact.sizes.powi(2) * exact.values.len() as f64 - square(&exact.values);
        mean += &exact.values;
    }
    let count = (steps * steps) as f64;
    let mean = mean.mapv(|v: Complex64| v * (share / count));
    let between = spread * share * share / count - square(&mean);
    let within = drawn * share * share / count;

    let half = 0.5 * steps as f64 * PITCH;
    for (positions, secondary, seeds) in [(20, 4, 2000), (5, 200, 2000)] {
        let plan = plan(positions, secondary, half);
        let law = (between + within / secondary as f64) / positions as f64;
        let [mse, bias] = measured(&field, &plan, 1.0, &mean, seeds);
        let ratio = mse / law;
        assert!(
            (ratio - 1.0).abs() < 0.05,
            "{positions} {secondary}: {ratio}"
        );
        assert!(bias / mse < 2.0 / seeds as f64);
    }
}
