//! The problems on which raylet is measured: each a system for raylet and an independent reference.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::plan::settings::Settings;
use raylet::math::random::uniform;
use raylet::optics::aperture::Aperture;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::Screen;
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

use crate::bounds::bound;
use crate::numerics::pixels::Pixels;
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{self, box_pixels, on_axis, screen};

/// A system, how raylet is to run it, and the field that a reference finds on its sensor.
pub struct Problem {
    /// Description of the system, as the report shows it.
    pub name: String,
    /// Name of the reference.
    pub reference: &'static str,
    /// The system.
    pub system: System,
    /// Settings of raylet's run.
    pub settings: Settings,
    /// The reference's field on the sensor, [y, x]; may take a while.
    pub exact: Box<dyn Fn() -> Array2<Complex64>>,
}

/// The errors of a field against the reference.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Relative L2 error of the complex field, nothing fitted.
    pub absolute: f64,
    /// Relative L2 error after the best complex factor.
    pub shape: f64,
    /// Normalised cross-correlation of the intensities.
    pub ncc: f64,
    /// The error that raylet estimates.
    pub estimate: f64,
    /// Rays followed.
    pub rays: u64,
}

impl Problem {
    /// The largest error allowed; nothing where none is recorded.
    pub fn bound(&self) -> Option<f64> {
        bound(&self.name)
    }

    /// Runs raylet and the reference.
    ///
    /// # Errors
    /// When raylet refuses the system.
    pub fn measure(&self) -> Result<Measured, SimulateError> {
        let outcome = simulate(&self.system, &self.settings, &|_| {})?;
        Ok(measured(&outcome, &(self.exact)()))
    }
}

fn measured(outcome: &Outcome, exact: &Array2<Complex64>) -> Measured {
    let ours = &outcome.field.values;
    let power = |a: &Array2<Complex64>| a.iter().map(|u| u.norm_sqr()).sum::<f64>();
    let overlap: Complex64 = ours.iter().zip(exact).map(|(a, b)| a.conj() * b).sum();
    let off: f64 = ours
        .iter()
        .zip(exact)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    let intensity = |a: &Array2<Complex64>| a.mapv(|u| u.norm_sqr());
    let (ia, ib) = (intensity(ours), intensity(exact));
    let sum = |a: &Array2<f64>, b: &Array2<f64>| (a * b).sum();
    let rays = outcome.hops.iter().map(|hop| hop.tally.total_rays());
    Measured {
        absolute: (off / power(exact)).sqrt(),
        shape: (1.0 - overlap.norm_sqr() / power(ours) / power(exact))
            .max(0.0)
            .sqrt(),
        ncc: sum(&ia, &ib) / (sum(&ia, &ia) * sum(&ib, &ib)).sqrt(),
        estimate: outcome.expected_error().unwrap_or(0.0),
        rays: rays.sum(),
    }
}

/// A screen of box pixels on the axis.
pub fn doe(z: f64, pixels: &Pixels) -> Screen {
    screen(
        on_axis(z),
        box_pixels(pixels.transmission.clone(), pixels.pitch),
    )
}

/// A sensor of `count`² points on the axis.
pub fn sensor(z: f64, count: usize, pitch: f64) -> Screen {
    screen(on_axis(z), parts::sensor(count, pitch))
}

/// The positions of such a sensor's points along one axis.
pub fn axis(count: usize, pitch: f64) -> Array1<f64> {
    Array1::from_iter((0..count).map(|i| (i as f64 - 0.5 * (count as f64 - 1.0)) * pitch))
}

/// A refracting surface on the axis; `radius` infinite for a plane.
pub fn face(z: f64, radius: f64, semi_aperture: f64, coating: Coating, index: [f64; 2]) -> Surface {
    Surface {
        aperture: Aperture::disc(semi_aperture),
        coating,
        ..parts::face(on_axis(z), Shape::sphere(radius), index)
    }
}

/// `count`² pixels of random phase.
pub fn random_pixels(count: usize, pitch: f64) -> Pixels {
    Pixels {
        pitch,
        transmission: phases([count, count], 7),
    }
}

/// `count`² pixels of random amplitude, 0 to 1, and random phase.
pub fn random_amplitude(count: usize, pitch: f64) -> Pixels {
    let mut pixels = random_pixels(count, pitch);
    for ((j, i), value) in pixels.transmission.indexed_iter_mut() {
        *value *= uniform(11, [j as u32, i as u32, 0, 0]);
    }
    pixels
}

/// Pixels of pitch one, `count`² of them, with random light whose sines stay below about 0.15: narrow
/// Gaussian beams about the middle, added.
pub fn smooth_random(count: usize) -> Pixels {
    let (width, beams) = (6.0, 40);
    let draw = |beam: u32, part: u32| uniform(13, [beam, part, 0, 0]) - 0.5;
    let at = axis(count, 1.0);
    let beam = |beam: u32, y: f64, x: f64| {
        let [x0, y0] = [0, 1].map(|part| 0.5 * count as f64 * draw(beam, part));
        let [px, py] = [2, 3].map(|part| 0.14 * draw(beam, part));
        let (dx, dy) = (x - x0, y - y0);
        let size = (-(dx * dx + dy * dy) / (2.0 * width * width)).exp();
        Complex64::from_polar(
            size,
            std::f64::consts::TAU * (px * dx + py * dy + draw(beam, 4)),
        )
    };
    Pixels {
        pitch: 1.0,
        transmission: Array2::from_shape_fn((count, count), |(j, i)| {
            (0..beams).map(|number| beam(number, at[j], at[i])).sum()
        }),
    }
}

/// `count`² pixels of phase 0 and π in turn.
pub fn checkerboard(count: usize, pitch: f64) -> Pixels {
    Pixels {
        pitch,
        transmission: Array2::from_shape_fn((count, count), |(j, i)| {
            Complex64::new(if (i + j) % 2 == 0 { 1.0 } else { -1.0 }, 0.0)
        }),
    }
}

/// `count`² pixels of a linear phase: a grating of this sine, at wavelength one.
pub fn grating_pixels(count: usize, pitch: f64, sine: f64) -> Pixels {
    Pixels {
        pitch,
        transmission: Array2::from_shape_fn((count, count), |(_, i)| {
            Complex64::cis(std::f64::consts::TAU * sine * pitch * i as f64)
        }),
    }
}
