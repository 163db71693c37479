//! Speed of the parts that take the time of a simulation: `cargo bench -p raylet`.
//!
//! Rates are of what each benchmark counts as an item, said in its comment. Set RAYON_NUM_THREADS to choose
//! the number of threads; rays are walked on one.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// Beamlets summed on a raster of 256 × 256 with footprints of 60 samples' radius.
mod beamlets {
    use num_complex::Complex64;
    use raylet::math::random;
    use raylet::wave::beamlet::beamlet_sum::Canvas;
    use raylet::wave::beamlet::wavelet::Arrival;
    use raylet::wave::grid::raster::Raster;

    use crate::{Bencher, ItemsCount};

    const PITCH: f64 = 0.0025;
    const RADIUS: f64 = 60.0 * PITCH;
    const WAVENUMBER: f64 = std::f64::consts::TAU / 532e-6;
    const THRESHOLD: f64 = 1e-3;
    const COUNT: u32 = 1000;

    fn canvas() -> Canvas {
        Canvas::new(Raster {
            start: [-127.5 * PITCH; 2],
            pitch: [PITCH; 2],
            size: [256, 256],
        })
    }

    /// Beamlets all over the raster whose Gaussians reach the threshold at the radius.
    fn arrivals() -> Vec<Arrival> {
        let decay = -2.0 * THRESHOLD.ln() / (WAVENUMBER * RADIUS * RADIUS);
        let curvature = Complex64::new(0.3 * decay, decay);
        let pair = |i, kind| random::pair(3, [i, kind, 0, 0]).map(|u| u - 0.5);
        (0..COUNT)
            .map(|i| Arrival {
                at: pair(i, 0).map(|u| 256.0 * PITCH * u),
                cosines: pair(i, 1).map(|u| 0.1 * u),
                amplitude: Complex64::new(1.0, 0.5),
                curvature: [curvature, Complex64::ZERO, curvature],
            })
            .collect()
    }

    fn time(bencher: Bencher, items: u64) {
        let arrivals = arrivals();
        bencher
            .counter(ItemsCount::new(items))
            .with_inputs(canvas)
            .bench_local_values(|mut canvas| {
                canvas.add(&arrivals, WAVENUMBER, THRESHOLD);
                canvas
            });
    }

    /// Item: a beamlet.
    #[divan::bench(max_time = 3)]
    fn wavelets(bencher: Bencher) {
        time(bencher, COUNT.into());
    }

    /// Item: a value of a beamlet at a sample.
    #[divan::bench(max_time = 3)]
    fn values(bencher: Bencher) {
        let evaluations = canvas().add(&arrivals(), WAVENUMBER, THRESHOLD);
        time(bencher, evaluations);
    }
}

/// Fourier sums.
mod transforms {
    use ndarray::Array2;
    use num_complex::Complex64;
    use raylet::math::chirp::{Chirp2, Comb};
    use raylet::math::nufft::Nufft;
    use raylet::math::random;

    use crate::{Bencher, ItemsCount};

    /// Points of a non-uniform sum.
    const POINTS: u32 = 1_000_000;

    /// Target accuracies.
    const TOLERANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];

    /// Random points, the slowest order to sort.
    fn points() -> Vec<[f64; 2]> {
        let point = |i| random::pair(1, [i, 0, 0, 0]).map(|u| std::f64::consts::TAU * u);
        (0..POINTS).map(point).collect()
    }

    fn plan(tolerance: f64) -> Nufft {
        Nufft::new([256, 256], tolerance).expect("a tolerance that can be had")
    }

    /// Points to 256 × 256 modes. Item: a point.
    #[divan::bench(args = TOLERANCES, max_time = 3)]
    fn nufft_type1(bencher: Bencher, tolerance: f64) {
        let (plan, points) = (plan(tolerance), points());
        let strengths = vec![Complex64::new(1.0, 0.5); points.len()];
        let mut modes = Array2::zeros([256, 256]);
        bencher
            .counter(ItemsCount::new(POINTS))
            .bench_local(|| plan.type1(&points, &strengths, &mut modes));
    }

    /// 256 × 256 modes to points. Item: a point.
    #[divan::bench(args = TOLERANCES, max_time = 3)]
    fn nufft_type2(bencher: Bencher, tolerance: f64) {
        let (plan, points) = (plan(tolerance), points());
        let modes = Array2::from_elem([256, 256], Complex64::new(1.0, 0.5));
        bencher
            .counter(ItemsCount::new(POINTS))
            .bench_local(|| plan.type2(modes.view(), &points));
    }

    /// From 480 × 480 samples to 1080 × 1080. Item: a value of the result.
    #[divan::bench(max_time = 4)]
    fn chirp(bencher: Bencher) {
        let comb = |count| Comb {
            start: -0.5,
            step: 0.001,
            count,
        };
        let plan = Chirp2::new(comb(480), comb(480), comb(1080), comb(1080), 300.0);
        let input = Array2::from_elem([480, 480], Complex64::ONE);
        bencher
            .counter(ItemsCount::new(1080_u64 * 1080))
            .bench_local(|| plan.apply(input.view()));
    }
}

/// One position of the source paper's method: a patch of 100 pixels of a hologram of 200, padded twice, 10⁴
/// of its 40 000 modes drawn, behind it a lens and 200 × 200 sensor pixels.
mod paper {
    use ndarray::Array2;
    use num_complex::Complex64;
    use raylet::engine::chain::simulate::simulate;
    use raylet::engine::plan::settings::{Method, Paper, Settings};
    use raylet::math::draw::{DrawScratch, draw_into};
    use raylet::math::random::{uniform, uniforms};
    use raylet::optics::pixels::pixel_grid::PixelForm;
    use raylet::optics::system::System;
    use raylet::wave::beamlet::plane::{PlaneSum, PlaneWave};
    use raylet::wave::grid::field::{Axis, Field, Grid};
    use raylet::wave::grid::raster::Raster;
    use raylet::wave::patches::patch::Band;
    use raylet::wave::patches::tile::{CutScratch, Tile, TileCutter, TileWindow};
    use raylet_testkit::paper_systems::{PITCH, WAVELENGTH, lens_hologram};

    use crate::{Bencher, ItemsCount, black_box};

    const COUNT: usize = 200;
    const DRAWS: u32 = 10_000;
    const POSITIONS: usize = 2000;

    fn wavenumber() -> f64 {
        std::f64::consts::TAU / WAVELENGTH
    }

    fn phases() -> Array2<f64> {
        Array2::from_shape_fn((COUNT, COUNT), |(j, i)| {
            std::f64::consts::TAU * uniform(5, [j as u32, i as u32, 0, 0])
        })
    }

    fn system() -> System {
        lens_hologram(&phases(), PixelForm::Point)
    }

    fn bands() -> [Band; 2] {
        let half = 0.5 * WAVELENGTH / PITCH;
        let spacing = WAVELENGTH / (COUNT as f64 * PITCH);
        [Band::between(0.0, spacing, -half, half - 1e-9 * spacing); 2]
    }

    /// The field and the plan that cuts it.
    fn cutter() -> (Field, TileCutter) {
        let axis = Axis::uniform(COUNT, PITCH, 0.0);
        let field = Field {
            values: phases().mapv(Complex64::cis),
            grid: Grid {
                x: axis.clone(),
                y: axis,
            },
        };
        let side = 100.0 * PITCH;
        let tile = Tile {
            side,
            window: TileWindow::Rectangle,
            period: 2.0 * side,
        };
        let axes = [&field.grid.x, &field.grid.y];
        let cutter = TileCutter::new(axes, &bands(), wavenumber(), &tile);
        (field, cutter)
    }

    /// The modes of a patch. Item: a patch.
    #[divan::bench(max_time = 2)]
    fn cut(bencher: Bencher) {
        let (field, cutter) = cutter();
        let mut scratch = CutScratch::default();
        bencher
            .counter(ItemsCount::new(1u32))
            .bench_local(|| cutter.cut(&field, black_box([0.0123, -0.0456]), &mut scratch));
    }

    /// Drawing with replacement, the random numbers included. Item: a draw.
    #[divan::bench(max_time = 2)]
    fn drawing(bencher: Bencher) {
        let (field, cutter) = cutter();
        let mut modes = CutScratch::default();
        cutter.cut(&field, [0.0; 2], &mut modes);
        let weights: Vec<f64> = modes.modes.iter().map(|c| c.norm()).collect();
        let (mut scratch, mut drawn) = (DrawScratch::default(), Vec::new());
        let mut numbers = vec![0.0; DRAWS as usize];
        bencher.counter(ItemsCount::new(DRAWS)).bench_local(|| {
            uniforms(3, [0; 4], &mut numbers);
            draw_into(&weights, &numbers, &mut scratch, &mut drawn)
        });
    }

    /// The plane waves of every fourth mode of a patch.
    fn waves() -> Vec<PlaneWave> {
        let system = system();
        let (bands, mut waves) = (bands(), Vec::new());
        for hop in system.hops() {
            for n in 0..DRAWS as usize {
                let p = [bands[0].at(4 * n % COUNT), bands[1].at(4 * n / COUNT)];
                if let Ok(landing) = hop.trace([0.1, 0.2], p, &mut ()) {
                    waves.push(PlaneWave {
                        at: landing.at,
                        cosines: landing.cosines,
                        amplitude: Complex64::cis(wavenumber() * landing.path),
                    });
                }
            }
        }
        waves
    }

    /// Rays through the lens. Item: a ray.
    #[divan::bench(max_time = 2)]
    fn rays(bencher: Bencher) {
        bencher.counter(ItemsCount::new(DRAWS)).bench_local(waves);
    }

    /// The sum of their plane waves on the sensor, fifty positions at a time. Item: a ray.
    #[divan::bench(max_time = 2)]
    fn sum(bencher: Bencher) {
        let waves = waves();
        let waves: Vec<PlaneWave> = (0..50).flat_map(|_| waves.clone()).collect();
        let raster = Raster {
            start: [-99.5 * PITCH; 2],
            pitch: [PITCH; 2],
            size: [COUNT; 2],
        };
        bencher
            .counter(ItemsCount::new(waves.len()))
            .with_inputs(|| PlaneSum::new(raster, wavenumber(), 1e-6))
            .bench_local_values(|sum| {
                if let Ok(mut sum) = sum {
                    sum.add(&waves);
                }
            });
    }

    /// Everything, two thousand positions: what a run takes beside its draws, as its plan, hardly counts. Item: a draw.
    #[divan::bench(max_time = 12)]
    fn whole(bencher: Bencher) {
        let system = system();
        let settings = Settings {
            method: Method::Paper,
            paper: Paper {
                rays: POSITIONS,
                secondary: DRAWS as usize,
                patch: Some(100.0 * PITCH),
                ..Paper::default()
            },
            ..Settings::default()
        };
        bencher
            .counter(ItemsCount::new(POSITIONS * DRAWS as usize))
            .bench_local(|| simulate(&system, &settings, &|_| {}).is_ok());
    }
}

/// Optimisers of designs.
mod design {
    use raylet::design::optimizers::lbfgs::{Lbfgs, LbfgsSettings};
    use raylet::design::optimizers::space::Space;

    use crate::{Bencher, ItemsCount};

    /// Σ cₖ(cosh xₖ − 1) and its gradient.
    fn function(point: &[f64]) -> (f64, Vec<f64>) {
        let factor = |i: usize| 1.0 + (i % 97) as f64;
        let terms = point.iter().enumerate();
        let value = terms.clone().map(|(i, x)| factor(i) * (x.cosh() - 1.0));
        (
            value.sum(),
            terms.map(|(i, x)| factor(i) * x.sinh()).collect(),
        )
    }

    /// What L-BFGS itself takes for an iteration with twenty steps remembered. Item: a parameter.
    #[divan::bench(args = [40_000, 500_000], max_time = 3)]
    fn lbfgs(bencher: Bencher, count: usize) {
        let start = (0..count).map(|i| [-1.2, 1.0][i % 2] + 1e-3 * (i as f64).sin());
        let (space, settings) = (Space::free(count), LbfgsSettings::default());
        let Ok(mut search) = Lbfgs::new(start.collect(), space, settings) else {
            return;
        };
        for _ in 0..30 {
            let (value, gradient) = function(search.point());
            search.report(value, &gradient);
        }
        let (value, gradient) = function(search.point());
        bencher
            .counter(ItemsCount::new(count))
            .with_inputs(|| search.clone())
            .bench_local_values(|mut search| {
                search.report(value, &gradient);
                search
            });
    }
}

/// A hologram of 200² pixels, a catalogue lens and 256² sensor pixels, once planned: light through it, and
/// gradients back. What is kept depends on geometry alone.
mod gradients {
    use ndarray::Array2;
    use num_complex::Complex64;
    use raylet::engine::chain::forward_pass::ForwardPass;
    use raylet::engine::chain::linearised_system::LinearisedSystem;
    use raylet::engine::plan::settings::Settings;
    use raylet::engine::trace::ray_sensitivity::Variation;
    use raylet::math::random::uniform;
    use raylet::optics::pixels::pixel_grid::PixelForm;
    use raylet::optics::screen::{ScreenKind, Sensor};
    use raylet::optics::shape::Shape;
    use raylet::optics::system::System;
    use raylet_testkit::paper_systems::lens_hologram;

    use crate::{Bencher, black_box};

    fn system() -> System {
        let phases = Array2::from_shape_fn((200, 200), |(j, i)| {
            std::f64::consts::TAU * uniform(5, [j as u32, i as u32, 0, 0])
        });
        let mut system = lens_hologram(&phases, PixelForm::Box);
        system.screens[1].kind = ScreenKind::Sensor(Sensor {
            pixels: [256; 2],
            pitch: [11e-3; 2],
        });
        system
    }

    /// Curvature, conic and index of the lens, and the place of the sensor.
    fn variations(system: &System) -> Vec<Variation> {
        let changed = |parameter: usize, by: f64| {
            let mut changed = system.clone();
            let faces = &mut changed.trains[0];
            match (parameter, &mut faces[0].shape) {
                (0, Shape::Conic(conic)) => conic.curvature += by,
                (1, Shape::Conic(conic)) => conic.conic += by,
                (2, _) => {
                    faces[0].index[1] += by;
                    faces[1].index[0] += by;
                }
                _ => changed.screens[1].frame.origin.z += by,
            }
            changed
        };
        let variation = |parameter: usize| Variation {
            below: changed(parameter, -1e-6),
            above: changed(parameter, 1e-6),
            distance: 2e-6,
        };
        (0..4).map(variation).collect()
    }

    /// A benched system with the light that has gone through it, and its variations.
    fn run(parameters: usize) -> Option<(System, Vec<Variation>, LinearisedSystem, ForwardPass)> {
        let system = system();
        let mut variations = variations(&system);
        variations.truncate(parameters);
        let settings = Settings {
            mode_threshold: Some(0.0),
            ..Settings::default()
        };
        let linearised = LinearisedSystem::new(&system, &variations, &settings).ok()?;
        let trace = linearised.forward(&system).ok()?;
        Some((system, variations, linearised, trace))
    }

    /// The way there.
    #[divan::bench(max_time = 4)]
    fn forward(bencher: Bencher) {
        if let Some((system, _, linearised, _)) = run(0) {
            bencher.bench_local(|| black_box(linearised.forward(&system).is_ok()));
        }
    }

    /// The way there and back, to all pixels and to so many parameters.
    #[divan::bench(args = [0, 4], max_time = 4)]
    fn forward_and_adjoint(bencher: Bencher, parameters: usize) {
        if let Some((system, variations, linearised, _)) = run(parameters) {
            bencher.bench_local(|| {
                let Ok(trace) = linearised.forward(&system) else {
                    return;
                };
                let bar: Array2<Complex64> = trace.field.values.mapv(|u| u * (u.norm_sqr() - 0.1));
                black_box(
                    linearised
                        .adjoint(&system, &variations, &trace, &bar)
                        .is_ok(),
                );
            });
        }
    }
}
