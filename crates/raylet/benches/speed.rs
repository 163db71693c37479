//! Speed of the parts that take the time of a simulation: `cargo bench -p raylet`.
//!
//! Rates are of what each benchmark counts as an item, said in its comment. Set RAYON_NUM_THREADS to choose
//! the number of threads; rays are walked on one.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// Rays through a lens.
mod rays {
    use raylet::math::complex::{Complex, Symmetric};
    use raylet::math::random;
    use raylet::math::vec3::Vec3;
    use raylet::optics::aperture::Aperture;
    use raylet::optics::bend::{Coating, Interface};
    use raylet::optics::frame::Frame;
    use raylet::optics::screen::{Act, Screen, Sensor};
    use raylet::optics::shape::{Conic, Shape};
    use raylet::optics::surface::Surface;
    use raylet::optics::system::Hop;

    use crate::{Bencher, ItemsCount, black_box};

    /// Rays of a round.
    const RAYS: u64 = 4096;

    fn screen(z: f64) -> Screen {
        let sensor = Sensor {
            pixels: [256, 256],
            pitch: [0.0025, 0.0025],
        };
        Screen {
            name: String::from("screen"),
            frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
            act: Act::Sensor(sensor),
            index: 1.0,
            shape: Shape::Plane,
            arrives: 1.0,
        }
    }

    /// A plano-convex lens of 50 mm focal length in N-BK7, as a catalogue's LA1131-A: R 25.8 mm, 5.3 mm thick.
    fn lens() -> Vec<Surface> {
        let surface = |z: f64, shape: Shape, index: [f64; 2]| Surface {
            shape,
            frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
            aperture: Aperture::disc(12.7),
            interface: Interface::Refract,
            coating: Coating::Ideal,
            index,
        };
        let sphere = Shape::Conic(Conic {
            curvature: -1.0 / 25.8,
            conic: 0.0,
        });
        vec![
            surface(10.0, Shape::Plane, [1.0, 1.5195]),
            surface(15.3, sphere, [1.5195, 1.0]),
        ]
    }

    /// Starts (x, y) within 5 mm and directions within ±0.02.
    fn starts() -> Vec<[[f64; 2]; 2]> {
        let pair = |i, kind| random::pair(7, [i, kind, 0, 0]);
        (0..RAYS as u32)
            .map(|i| {
                let at = pair(i, 0).map(|u| 10.0 * u - 5.0);
                [at, pair(i, 1).map(|u| 0.04 * u - 0.02)]
            })
            .collect()
    }

    /// Times a hop for all rays; an item is a ray at a surface.
    fn time<T>(bencher: Bencher, one: impl Fn(&Hop, [[f64; 2]; 2]) -> T + Sync) {
        let (from, train, to) = (screen(0.0), lens(), screen(64.0));
        let hop = Hop {
            wavelength: 532e-6,
            from: &from,
            train: &train,
            to: &to,
        };
        let starts = starts();
        bencher
            .counter(ItemsCount::new(RAYS * train.len() as u64))
            .bench_local(|| {
                for start in &starts {
                    black_box(one(&hop, *start));
                }
            });
    }

    /// Position, direction and optical path. Item: a ray at a surface.
    #[divan::bench(max_time = 2)]
    fn plain(bencher: Bencher) {
        time(bencher, |hop, [at, p]| hop.trace(at, p, &mut ()));
    }

    /// The same with a beamlet's amplitude and curvature. Item: a ray at a surface.
    #[divan::bench(max_time = 2)]
    fn beamlet(bencher: Bencher) {
        let (q, zero) = (Complex::new(0.0, 0.05), Complex::new(0.0, 0.0));
        let start = Symmetric {
            xx: q,
            xy: zero,
            yy: q,
        };
        time(bencher, |hop, [at, p]| hop.carry_beamlet(at, p, start));
    }

    /// Position, direction and path with all their derivatives. Item: a ray at a surface.
    #[divan::bench(max_time = 2)]
    fn jacobian(bencher: Bencher) {
        time(bencher, |hop, [at, p]| hop.jacobian(at, p));
    }
}

/// Beamlets summed on a raster of 256 × 256 with footprints of 60 samples' radius.
mod beamlets {
    use num_complex::Complex64;
    use raylet::math::random;
    use raylet::wave::gather::Canvas;
    use raylet::wave::raster::Raster;
    use raylet::wave::wavelet::Arrival;

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

    /// Asked accuracies.
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
