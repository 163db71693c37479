//! What may stand at a stop: phases and pixels over its whole width.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::random::uniform;
use raylet::optics::doe::Layer;
use raylet::optics::phase::placement::Placement;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::zernike::ZernikeSum;

/// 20 waves of x³ + y³ over a radius in mm, by Zernike polynomials: Z7 and Z9 hold y³, Z8 and Z10 x³.
pub fn cubic(radius: f64) -> Layer {
    let waves = 20.0 * TAU;
    let mut coefficients = vec![0.0; 10];
    // x³ = (Z10/√8 + 3·(Z8/√8 + 2Z2/2)/3)/4 and likewise y³ = (−Z9/√8 + 3·(Z7/√8 + 2Z3/2)/3)/4.
    let trefoil = waves / (4.0 * 8f64.sqrt());
    (coefficients[9], coefficients[7]) = (trefoil, trefoil);
    (coefficients[8], coefficients[6]) = (-trefoil, trefoil);
    (coefficients[1], coefficients[2]) = (waves / 4.0, waves / 4.0);
    Layer::Phase(Profile::Zernike(ZernikeSum::new(radius, coefficients)))
}

/// Pixels of random phase, as many as a width and a height in mm hold.
pub fn random_pixels([width, height]: [f64; 2], pitch: f64) -> Layer {
    let count = |size: f64| (size / pitch).round() as usize;
    let phase = |(j, i)| TAU * uniform(5, [j as u32, i as u32, 0, 0]);
    let values = Array2::from_shape_fn((count(height), count(width)), |at: (usize, usize)| {
        Complex64::cis(phase(at))
    });
    boxes([pitch; 2], values)
}

/// Bars of phase 0 and π in turn, each half a period wide in mm and as long as the height.
pub fn binary_grating([width, height]: [f64; 2], period: f64) -> Layer {
    let count = (2.0 * width / period).round() as usize;
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let values = Array2::from_shape_fn((1, count), |(_, i)| Complex64::new(sign(i), 0.0));
    boxes([0.5 * period, height], values)
}

fn boxes(pitch: [f64; 2], values: Array2<Complex64>) -> Layer {
    Layer::Pixels(Pixels {
        pitch,
        values,
        form: PixelForm::Box,
        active: ActiveArea::WHOLE,
        placement: Placement::NONE,
    })
}
