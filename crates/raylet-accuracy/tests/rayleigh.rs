//! The library's direct Rayleigh–Sommerfeld sum against the one that shares no code with it.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::wave::free::rayleigh::Emitters;
use raylet::wave::grid::field::{Axis, Field, Grid};
use raylet::wave::grid::heights::Heights;
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::references::rayleigh_sommerfeld::rayleigh_sommerfeld;

/// Random-phase box pixels of half a wavelength, lit at 10°, onto a tilted line of points.
#[test]
fn both_direct_sums_agree_to_rounding() {
    let (pitch, wavelength, tilt) = (0.35e-3, 0.7e-3, [10f64.to_radians().sin(), 0.0]);
    let transmission = Array2::from_shape_fn((40, 40), |(j, i)| {
        Complex64::cis((7 * j * j + 3 * i) as f64)
    });
    let axis = Axis::gauss(40, pitch, 0.0, 4);
    let mut field = Field::zeros(Grid {
        x: axis.clone(),
        y: axis.clone(),
    });
    let k = std::f64::consts::TAU / wavelength;
    for ((j, i), value) in field.values.indexed_iter_mut() {
        let incident = Complex64::cis(k * (tilt[0] * axis.node(i) + tilt[1] * axis.node(j)));
        *value = transmission[[j / 4, i / 4]] * incident;
    }
    let points: Vec<[f64; 3]> = (0..400)
        .map(|i| {
            let t = f64::from(i) / 400.0 - 0.5;
            [0.03 * t, 0.01 * t, 0.02 + 0.01 * t]
        })
        .collect();
    let pixels = Pixels {
        pitch,
        transmission,
    };
    let theirs = rayleigh_sommerfeld(&pixels, tilt, wavelength, 4, &points);
    let ours = Emitters::new(&field, &Heights::flat(&field.grid)).field_at(&points, wavelength);
    let norm: f64 = theirs.iter().map(|u| u.norm_sqr()).sum();
    let off: f64 = ours
        .iter()
        .zip(&theirs)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    let error = (off / norm).sqrt();
    assert!(error < 1e-12, "{error:e}");
}
