//! The source paper's estimate of a field: unbiased in free space, with the variance that theory gives.
//!
//! Of a patch's modes cₘ, N are drawn with probability π ∝ |c| and weighted c/(Nπ). The estimate's mean
//! squared error at a point is (Σ|c|²/π − |Σ c e|²)/N = ((Σ|c|)² − |V|²)/N, V the patch's field there.
//! K patches at random positions add the variance of V from patch to patch.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::paper::carry;
use raylet::engine::paper_plan::{Address, PaperPlan};
use raylet::engine::settings::{Density, Positions, Sag, Sampler};
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::frame::Frame;
use raylet::optics::screen::{Act, Screen};
use raylet::optics::system::Hop;
use raylet::wave::field::{Axis, Field, Grid};
use raylet::wave::patch::Band;
use raylet::wave::plane::PlaneSum;
use raylet::wave::raster::Raster;

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

fn screen(z: f64) -> Screen {
    Screen {
        name: String::from("screen"),
        frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
        act: Act::Stop(Aperture::OPEN),
        index: 1.0,
        arrives: 1.0,
    }
}

fn field() -> Field {
    let axis = Axis::uniform(FIELD, PITCH, 0.0);
    let mut field = Field::zeros(Grid {
        x: axis.clone(),
        y: axis,
    });
    for ((j, i), value) in field.values.indexed_iter_mut() {
        let turn = uniform(3, [j as u32, i as u32, 0, 0]);
        *value = Complex64::cis(std::f64::consts::TAU * turn);
    }
    field
}

fn band() -> Band {
    let (spacing, half) = (
        WAVELENGTH / (PERIOD as f64 * PITCH),
        0.5 * WAVELENGTH / PITCH,
    );
    Band::between(0.0, spacing, -half, half - 1e-9 * spacing)
}

/// The library's estimate at the raster's points.
fn estimate(field: &Field, plan: &PaperPlan, seed: u64) -> Array2<Complex64> {
    let (from, to) = (screen(0.0), screen(DISTANCE));
    let hop = Hop {
        wavelength: WAVELENGTH,
        from: &from,
        train: &[],
        to: &to,
    };
    let mut sum = PlaneSum::new(RASTER, K, 1e-9).unwrap();
    carry(
        hop,
        plan,
        Address { seed, hop: 0 },
        field,
        &mut sum,
        &|_| {},
    );
    sum.finish()
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
        period: PERIOD as f64 * PITCH,
        bands: [band(); 2],
        obliquity: false,
        arriving: [1.0; 2],
    }
}

/// What one patch is: Σ|c| over its modes, and its field at the raster's points, all by direct sums.
struct Exact {
    sizes: f64,
    values: Array2<Complex64>,
}

/// The patch whose first sample is that of the given indices, which may lie outside of the field.
fn patch(field: &Field, [first_x, first_y]: [i64; 2]) -> Exact {
    let inside = |i: i64| (0..FIELD as i64).contains(&i);
    let band = band();
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
            c /= (PERIOD * PERIOD) as f64;
            exact.sizes += c.norm();
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

/// One patch at a fixed place: positions are drawn from an area too small to matter.
#[test]
fn drawn_modes_of_a_patch_have_the_variance_of_their_law() {
    let field = field();
    let first = (FIELD - PATCH) as i64 / 2;
    let exact = patch(&field, [first; 2]);
    let half = 1e-9f64;
    let share = (2.0 * half).powi(2) / (PATCH as f64 * PITCH).powi(2);
    let law = exact.sizes.powi(2) * exact.values.len() as f64 - square(&exact.values);
    for (secondary, seeds) in [(4, 4000), (64, 2000)] {
        let plan = plan(1, secondary, half);
        let [mse, bias] = measured(&field, &plan, 1.0 / share, &exact.values, seeds);
        let ratio = mse * secondary as f64 / law;
        println!(
            "{secondary} modes: N·MSE over its law {ratio:.4}, bias² over MSE {:.2e}",
            bias / mse
        );
        assert!((ratio - 1.0).abs() < 0.05, "{secondary}: {ratio}");
        // The mean of the seeds is off by what chance leaves, one part in `seeds`, and no more.
        assert!(
            bias / mse < 2.0 / seeds as f64,
            "{secondary}: {bias:e} of {mse:e}"
        );
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
        println!(
            "{positions} × {secondary}: MSE over its law {:.4}, bias² over MSE {:.2e}",
            mse / law,
            bias / mse
        );
        assert!((mse / law - 1.0).abs() < 0.05, "{positions} {secondary}");
        assert!(bias / mse < 2.0 / seeds as f64);
    }
}
