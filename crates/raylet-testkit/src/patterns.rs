//! Two elements in free space on which ways to sample are compared: a metalens and a hologram of a
//! Siemens star. Both have pixels of half a wavelength, one sample each, and a sensor like themselves.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, Zip};
use num_complex::Complex64;
use raylet::math::random::uniform;
use raylet::optics::aperture::Aperture;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::free::free_plan::Slab;
use raylet::wave::free::propagate::{CLEAR, FreeHop};
use raylet::wave::grid::field::{Axis, Field, Grid};
use raylet::wave::grid::raster::Raster;

use super::parts::{self, lit, on_axis, pixel_layer, screen};

/// Spokes of the star.
const SPOKES: f64 = 18.0;

/// Seed of the hologram's random phase.
const SEED: u64 = 11;

/// A square metalens of `width` wavelengths with this numerical aperture, and a sensor at its focus.
pub fn metalens(width: usize, aperture: f64, wavelength: f64) -> System {
    let count = 2 * width;
    let pitch = 0.5 * wavelength;
    let focus = distance(width, aperture, wavelength);
    let at = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * pitch;
    let values = Array2::from_shape_fn((count, count), |(j, i)| {
        let path = focus - (at(i).powi(2) + at(j).powi(2) + focus * focus).sqrt();
        Complex64::cis(TAU / wavelength * path)
    });
    system(values, focus, wavelength)
}

/// A phase hologram of `width` wavelengths that shows a Siemens star at the distance of this numerical
/// aperture: the phase of the star, with random phases of its own, carried back to the element.
pub fn star_hologram(width: usize, aperture: f64, wavelength: f64) -> System {
    let count = 2 * width;
    let pitch = 0.5 * wavelength;
    let z = distance(width, aperture, wavelength);
    let axis = Axis::uniform(count, pitch, 0.0);
    let mut image = Field::zeros(Grid {
        x: axis.clone(),
        y: axis.clone(),
    });
    let star = star(count);
    Zip::indexed(&mut image.values)
        .and(&star)
        .for_each(|(j, i), value, &intensity| {
            let turn = uniform(SEED, [j as u32, i as u32, 0, 0]);
            *value = Complex64::from_polar(intensity.sqrt(), TAU * turn);
        });

    // Back is forward with the conjugate field.
    let half = 0.5 * count as f64 * pitch;
    let hop = FreeHop {
        k: TAU / wavelength,
        slabs: vec![Slab {
            index: 1.0,
            thickness: z,
            exit: None,
        }],
        offset: [0.0; 2],
        chief: [0.0; 2],
        padding: 4.0,
        clear: CLEAR,
    };
    let bounds = [-half, half, -half, half];
    let raster = Raster {
        start: [axis.start; 2],
        pitch: [pitch; 2],
        size: [count; 2],
    };
    let plan = hop.plan(bounds, bounds);
    let arrived = hop.carry(&image, None, &raster, &plan);
    system(arrived.mapv(|u| Complex64::cis(-u.arg())), z, wavelength)
}

/// A Siemens star of `count`² pixels, one and zero, within 0.9 of the square.
pub fn star(count: usize) -> Array2<f64> {
    let middle = 0.5 * (count as f64 - 1.0);
    Array2::from_shape_fn((count, count), |(j, i)| {
        let (x, y) = (i as f64 - middle, j as f64 - middle);
        let lit = x.hypot(y) < 0.45 * count as f64 && (SPOKES * y.atan2(x) + 0.5 * PI).sin() > 0.0;
        if lit { 1.0 } else { 0.0 }
    })
}

/// Where the edge of an element of `width` wavelengths is seen under this numerical aperture.
fn distance(width: usize, aperture: f64, wavelength: f64) -> f64 {
    0.5 * width as f64 * wavelength / aperture.asin().tan()
}

/// These pixels, collimated light, and a sensor like them `z` mm behind.
fn system(values: Array2<Complex64>, z: f64, wavelength: f64) -> System {
    let (count, pitch) = (values.nrows(), 0.5 * wavelength);
    let layer = pixel_layer(values, pitch, PixelForm::Point);
    let element = ScreenKind::Doe(parts::element(layer, Aperture::OPEN));
    let sensor = parts::sensor(count, pitch);
    let screens = vec![screen(on_axis(0.0), element), screen(on_axis(z), sensor)];
    System {
        wavelength,
        ..lit(screens, vec![vec![]])
    }
}

#[cfg(test)]
mod tests {
    use raylet::engine::chain::simulate::simulate;
    use raylet::engine::plan::settings::Settings;
    use raylet::wave::grid::metrics::ncc;

    use super::{metalens, star, star_hologram};

    /// The middle of the focus is the sum of all pixels in phase, by the first Rayleigh–Sommerfeld
    /// integral with one node each: Σ h² (z/r)(1/r − ik) e^{ik·focus}/(2πr).
    #[test]
    fn metalens_focuses() {
        let system = metalens(50, 0.1, 1e-3);
        let k = system.wavenumber();
        let z = system.screens[1].frame.origin.z;
        let field = simulate(&system, &Settings::default(), &|_| {})
            .unwrap()
            .field
            .values;
        let mut sum = 0.0;
        for j in 0..100 {
            for i in 0..100 {
                let [x, y] = [i, j].map(|i| (f64::from(i) - 49.5) * 5e-4);
                let r = (x * x + y * y + z * z).sqrt();
                sum += 2.5e-7 * z / (r * r) * k / std::f64::consts::TAU;
            }
        }
        // The four middle samples stand half a pixel from the axis.
        let middle = field[[50, 50]].norm();
        assert!((middle / sum - 1.0).abs() < 0.01, "{middle} {sum}");
    }

    #[test]
    fn hologram_shows_the_star() {
        let system = star_hologram(64, 0.7, 1e-3);
        let field = simulate(&system, &Settings::default(), &|_| {})
            .unwrap()
            .field
            .values;
        let like = ncc(field.mapv(|u| u.norm_sqr()).view(), star(128).view()).unwrap();
        // Developed speckle alone would score 0.7 of a perfect star, a flat square about 0.56.
        assert!((0.62..0.9).contains(&like), "{like}");
    }
}
