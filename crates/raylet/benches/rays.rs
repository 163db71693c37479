//! Speed of rays and beamlets through a lens, on one thread: `cargo bench -p raylet --bench rays`.
//!
//! Rates are of what each benchmark counts as an item, said in its comment.

use std::ops::ControlFlow;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use raylet::engine::ray_block::hop_rays::{HopRays, LandingColumns};
use raylet::engine::ray_block::ray_origins::RayOrigins;
use raylet::engine::ray_block::system_rays::SystemRays;
use raylet::math::complex::{Complex, Symmetric};
use raylet::math::random;
use raylet::optics::aperture::Aperture;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;
use raylet_testkit::parts::{self, conic, face, lit, on_axis, sensor};
use rayon::ThreadPoolBuilder;

/// Rays of a round.
const RAYS: u64 = 4096;

fn screen(z: f64) -> Screen {
    parts::screen(on_axis(z), sensor(256, 0.0025))
}

/// A plano-convex lens of 50 mm focal length in N-BK7, as a catalogue's LA1131-A: R 25.8 mm, 5.3 mm thick.
fn lens() -> Vec<Surface> {
    let surface = |z: f64, shape: Shape, index: [f64; 2]| Surface {
        aperture: Aperture::disc(12.7),
        ..face(on_axis(z), shape, index)
    };
    vec![
        surface(10.0, Shape::Plane, [1.0, 1.5195]),
        surface(15.3, conic(-1.0 / 25.8, 0.0), [1.5195, 1.0]),
    ]
}

/// The same with an asphere in place of the sphere.
fn aspheric_lens() -> Vec<Surface> {
    let mut lens = lens();
    lens[1].shape = Shape::Asphere {
        base: Conic {
            curvature: -1.0 / 25.8,
            conic: -0.6,
        },
        coefficients: vec![1e-6, 2e-9, -1e-11],
    };
    lens
}

/// A double Gauss lens of 100 mm focal length (U.S. patent 2 532 751), its stop left out: radius in mm, place of the vertex in mm
/// behind the first one, and the index behind it. A radius of 0 is a plane.
const DOUBLE_GAUSS: [[f64; 3]; 10] = [
    [56.20238, 0.0, 1.62229],
    [152.2858, 8.75, 1.0],
    [37.68262, 9.25, 1.60738],
    [0.0, 21.75, 1.60342],
    [24.2313, 25.55, 1.0],
    [-28.37731, 55.6674, 1.60342],
    [0.0, 59.4674, 1.62041],
    [-37.92546, 70.4674, 1.0],
    [177.41176, 70.9674, 1.62041],
    [-79.41143, 77.9674, 1.0],
];

fn double_gauss() -> Vec<Surface> {
    let mut before = 1.0;
    let surface = |[radius, z, index]: [f64; 3]| {
        let shape = match radius {
            0.0 => Shape::Plane,
            _ => conic(1.0 / radius, 0.0),
        };
        let indices = [before, index];
        before = index;
        Surface {
            aperture: Aperture::disc(30.0),
            ..face(on_axis(5.0 + z), shape, indices)
        }
    };
    DOUBLE_GAUSS.map(surface).to_vec()
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

/// Times a hop for blocks of rays; an item is a ray at a surface or the sensor.
fn time_blocks<T>(
    bencher: Bencher,
    train: &[Surface],
    mut all: impl FnMut(&HopRays, &[[f64; 4]]) -> T,
) {
    let back = train.last().map_or(0.0, |face| face.frame.origin.z);
    let (from, to) = (screen(0.0), screen(back + 48.7));
    let hop = Hop {
        wavelength: 532e-6,
        from: &from,
        train,
        to: &to,
    };
    let rays = HopRays::new(&hop);
    let starts: Vec<[f64; 4]> = { starts().into_iter() }
        .map(|[[x, y], [p, q]]| [x, y, p, q])
        .collect();
    bencher
        .counter(ItemsCount::new(RAYS * (train.len() as u64 + 1)))
        .bench_local(|| black_box(all(&rays, &starts)));
}

/// Blocks through a sphere and a plane.
#[divan::bench(max_time = 2)]
fn block(bencher: Bencher) {
    let mut landings = LandingColumns::default();
    time_blocks(bencher, &lens(), |rays, starts| {
        rays.trace_into(starts, &mut landings);
    });
}

#[divan::bench(max_time = 2)]
fn block_rows(bencher: Bencher) {
    time_blocks(bencher, &lens(), |rays, starts| rays.trace(starts));
}

/// The same with Jacobians.
#[divan::bench(max_time = 2)]
fn block_jacobian(bencher: Bencher) {
    time_blocks(bencher, &lens(), |rays, starts| rays.jacobians(starts));
}

/// Blocks through an asphere and a plane.
#[divan::bench(max_time = 2)]
fn block_asphere(bencher: Bencher) {
    let lens = aspheric_lens();
    let mut landings = LandingColumns::default();
    time_blocks(bencher, &lens, |rays, starts| {
        rays.trace_into(starts, &mut landings);
    });
}

/// Blocks through the ten surfaces of a double Gauss lens.
#[divan::bench(max_time = 2)]
fn block_double_gauss(bencher: Bencher) {
    let mut landings = LandingColumns::default();
    time_blocks(bencher, &double_gauss(), |rays, starts| {
        rays.trace_into(starts, &mut landings);
    });
    assert!(landings.lost.iter().all(Option::is_none));
}

/// The same lens as a whole system, from the pupil to rays on the sensor in arrays.
#[divan::bench(max_time = 2)]
fn system_double_gauss(bencher: Bencher) {
    let train = double_gauss();
    let surfaces = train.len() as u64 + 1;
    let system = lit(
        vec![
            parts::screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(30.0))),
            screen(140.0),
        ],
        vec![train],
    );
    let (rays, sensor) = (SystemRays::new(&system), [surfaces as usize]);
    let columns = [0, 1].map(|axis| {
        starts()
            .iter()
            .map(|[at, _]| at[axis])
            .collect::<Vec<f64>>()
    });
    let origins = RayOrigins::Lit {
        light: &[[0.0, 0.0, 1.0]],
        at: [&columns[0], &columns[1]],
        between: RayOrigins::IN_MM,
    };
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    bencher.counter(ItemsCount::new(RAYS * surfaces)).bench(|| {
        let trace = || rays.trace(origins, &sensor, &|| ControlFlow::Continue(()));
        pool.install(trace).is_ok()
    });
}

/// Beamlets of one place through a sphere and a plane.
#[divan::bench(max_time = 2)]
fn block_beamlet(bencher: Bencher) {
    time_beamlets(bencher, &lens());
}

/// Beamlets of one place through an asphere and a plane.
#[divan::bench(max_time = 2)]
fn block_beamlet_asphere(bencher: Bencher) {
    time_beamlets(bencher, &aspheric_lens());
}

/// Times beamlets of one place; an item is a beamlet at a surface or the sensor.
fn time_beamlets(bencher: Bencher, train: &[Surface]) {
    let zero = Complex::new(0.0, 0.0);
    let q = Complex::new(-0.01, 0.05);
    let start = Symmetric {
        xx: q,
        xy: zero,
        yy: q,
    };
    time_blocks(bencher, train, |rays, starts| {
        rays.carry_beamlets(start, starts)
    });
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

fn main() {
    divan::main();
}
