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
fn main() {
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
