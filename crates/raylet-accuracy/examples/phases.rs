//! scratch
use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::random::uniform;
use raylet::wave::field::*;
use raylet::wave::gather::*;
use raylet::wave::patch::*;
use raylet::wave::raster::*;
use raylet::wave::wavelet::Arrival;
use raylet::wave::window::*;
use std::time::Instant;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let v: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    v[11].parse::<f64>().unwrap() / 100.0
}
fn launches() {
    use raylet::engine::{beamlets::launch, budget::aberration};
    use raylet::math::vec3::Vec3;
    use raylet::optics::{
        aperture::Aperture, bend::*, frame::Frame, screen::*, shape::*, surface::Surface,
        system::Hop,
    };
    let at = |z| Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z));
    let n = 1.513;
    let train = [
        Surface {
            shape: Shape::Conic(Conic {
                curvature: 1.0 / 25.8,
                conic: 0.0,
            }),
            frame: at(3.0),
            aperture: Aperture::disc(12.7),
            interface: Interface::Refract,
            coating: Coating::Ideal,
            index: [1.0, n],
        },
        Surface {
            shape: Shape::Plane,
            frame: at(8.3),
            aperture: Aperture::disc(12.7),
            interface: Interface::Refract,
            coating: Coating::Ideal,
            index: [n, 1.0],
        },
    ];
    let screen = |z| Screen {
        name: "".into(),
        frame: at(z),
        index: 1.0,
        arrives: 1.0,
        act: Act::Sensor(Sensor {
            pixels: [256, 256],
            pitch: [6.3e-3; 2],
        }),
    };
    let (from, to) = (screen(0.0), screen(53.0));
    let hop = Hop {
        wavelength: 0.7e-3,
        from: &from,
        train: &train,
        to: &to,
    };
    let t = cpu();
    let mut sum = 0.0;
    for i in 0..1_000_000u32 {
        let u = (i as f64 * 0.618).fract() - 0.5;
        let a = launch(&hop, [u, 0.3 * u], [0.02 * u, 0.01], 0.1).unwrap();
        sum += a.at[0] + a.amplitude.re;
    }
    println!("launch {} ns ({sum})", (cpu() - t) * 1e3);
    let t = cpu();
    for i in 0..1_000_000u32 {
        let u = (i as f64 * 0.618).fract() - 0.5;
        let a = hop.trace([u, 0.3 * u], [0.02 * u, 0.01], &mut ()).unwrap();
        sum += a.at[0];
    }
    println!("trace {} ns ({sum})", (cpu() - t) * 1e3);
    let t = cpu();
    for i in 0..100_000u32 {
        let u = (i as f64 * 0.618).fract() - 0.5;
        let a = aberration(&hop, [u, 0.3 * u], [0.02 * u, 0.01], 0.1, 9e3).unwrap();
        sum += a.cubic;
    }
    println!("aberration {} ns ({sum})", (cpu() - t) * 1e4);
}
fn main() {
    launches();
    let k = std::f64::consts::TAU / 0.7e-3;
    let axis = Axis::gauss(200, 6.3e-3, 0.0, 3);
    let values = Array2::from_shape_fn((600, 600), |(j, i)| {
        Complex64::cis(6.28 * uniform(7, [j as u32 / 3, i as u32 / 3, 0, 0]))
    });
    let field = Field {
        grid: Grid {
            x: axis.clone(),
            y: axis.clone(),
        },
        values,
    };
    for sigma in [0.15, 0.075] {
        let period = 6.0 * sigma;
        let t = (Instant::now(), cpu());
        let pos = Positions::cover(axis.edges(), sigma, 1.5 * sigma, 3.0 * sigma);
        let band = Band::between(0.0, 0.7e-3 / period, -0.024, 0.024);
        let patches = Patches::new([&axis, &axis], [&pos, &pos], [&band, &band], k, period);
        println!("plan {:?} cpu {}", t.0.elapsed(), cpu() - t.1);
        let t = (Instant::now(), cpu());
        let mut n = 0;
        for i in 0..patches.count() {
            if let Some(s) = patches.cut(&field, i) {
                n += s.coefficients.len();
            }
        }
        println!(
            "sigma {sigma}: cut {} patches, {} modes {:?} cpu {}",
            patches.count(),
            n,
            t.0.elapsed(),
            cpu() - t.1
        );
    }
    let arrivals: Vec<Arrival> = (0..200000)
        .map(|i| Arrival {
            at: [
                uniform(1, [i, 0, 0, 0]) * 1.6 - 0.8,
                uniform(1, [i, 1, 0, 0]) * 1.6 - 0.8,
            ],
            cosines: [0.01, 0.02],
            amplitude: Complex64::ONE,
            curvature: [
                Complex64::new(0.001, 1.0 / k / 0.04f64.powi(2)),
                Complex64::ZERO,
                Complex64::new(0.001, 1.0 / k / 0.04f64.powi(2)),
            ],
        })
        .collect();
    let mut canvas = Canvas::new(Raster {
        start: [-0.8, -0.8],
        pitch: [6.3e-3; 2],
        size: [256, 256],
    });
    let t = (Instant::now(), cpu());
    let n = canvas.add(&arrivals, k, 1e-3);
    println!(
        "gather {} values {:?} cpu {} ns/value {}",
        n,
        t.0.elapsed(),
        cpu() - t.1,
        (cpu() - t.1) / n as f64 * 1e9
    );
}
