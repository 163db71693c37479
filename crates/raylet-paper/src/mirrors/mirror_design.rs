//! The design of the pixels of a conformal mirror: the target on the sensor, and where the search begins.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;

use raylet::design::losses::likeness::{Brightness, Likeness};
use raylet::design::losses::loss::{Loss, LossError, Sum};
use raylet::design::losses::share::Share;
use raylet::design::mirrors::mirror::{FreePixelValue, MirrorDesign, MirrorError};

use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show, Window};

/// Distance of the sensor's samples in mm, half a wavelength.
const PITCH: f64 = 5e-4;
const WAVELENGTH: f64 = 1e-3;

/// The weight β of the loss −β·log(share of the light in the letter) beside likeness.
const EFFICIENCY: f64 = 0.01;

/// Radius at full size of the disc on the sensor from which the letter's search begins, in mm: it holds the letter.
const SPREAD: f64 = 0.08;

/// A search for the pixels of a mirror.
pub struct MirrorSearch {
    /// The mirror with its sensor and loss.
    pub design: MirrorDesign,
    /// The phases that it begins with.
    pub start: Vec<f64>,
    /// The target at the sensor's samples, [y, x].
    pub target: Array2<f64>,
    /// The sensor.
    pub sensor: Window,
}

/// Why there is no search for the pixels of a mirror.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MirrorSearchError {
    /// Its loss is refused.
    #[error(transparent)]
    Loss(#[from] LossError),
    /// Its system is refused.
    #[error(transparent)]
    Mirror(#[from] MirrorError),
}

impl MirrorSearch {
    /// The mirror that shows its foci or its letter on a sensor as wide as itself.
    ///
    /// Foci: two free phases a pixel, from those of a flat mirror, so that the height is not known at the start; the
    /// loss is Σ(s − T)² with the shares s of the light at the samples and T a half at each focus. The letter: one
    /// phase a pixel, from a wave that lights a disc; the loss is 1 − NCC² and a little for light in the letter.
    ///
    /// # Errors
    /// A mirror so small that the sensor misses the target.
    pub fn new(mirror: &Conformal, aperture: LitArea) -> Result<Self, MirrorSearchError> {
        let half = (0.5 * mirror.width() / PITCH).floor() as usize;
        let sensor = Window {
            x: 0.0,
            pixels: [2 * half + 1; 2],
            pitch: PITCH,
        };
        let place = |i: usize| (i as f64 - half as f64) * PITCH;
        let lit = |(j, i): (usize, usize)| match mirror.show {
            Show::Letter => mirror.letter(place(i), place(j)),
            Show::Foci => {
                let near = |f: f64| (place(i) - f).abs() < 0.5 * PITCH;
                j == half && mirror.foci().into_iter().any(near)
            }
        };
        let shape = (2 * half + 1, 2 * half + 1);
        let mut target = Array2::from_shape_fn(shape, |at| f64::from(u8::from(lit(at))));
        if mirror.show == Show::Foci {
            target *= 0.5;
        }
        let pixels = (mirror.count(), mirror.count());
        let blank = mirror.made(Array2::from_elem(pixels, Complex64::ONE), aperture, sensor);
        let freedom = match mirror.show {
            Show::Foci => FreePixelValue::TwoPhases,
            Show::Letter => FreePixelValue::Phase,
        };
        let design = MirrorDesign::new(&blank, freedom, loss(mirror.show, &target)?)?;
        let start = match mirror.show {
            Show::Foci => mirror.flat_phases(),
            Show::Letter => spread(mirror, &design, shape, &place),
        };
        Ok(Self {
            design,
            start,
            target,
            sensor,
        })
    }
}

/// What is made small.
fn loss(show: Show, target: &Array2<f64>) -> Result<Box<dyn Loss>, LossError> {
    let parts: Vec<(f64, Box<dyn Loss>)> = match show {
        Show::Foci => {
            let given = Brightness::Given { scale: 1.0 };
            let alike = Likeness::new(target.clone(), None, given)?;
            // The likeness is a mean over the samples, the paper's loss a sum.
            vec![(target.len() as f64, Box::new(alike))]
        }
        Show::Letter => {
            let alike = Likeness::new(target.clone(), None, Brightness::Free)?;
            let light = Share::efficiency(target.clone(), 1.0, 1.0, EFFICIENCY)?;
            vec![(1.0, Box::new(alike)), (1.0, Box::new(light))]
        }
    };
    Ok(Box::new(Sum::new(parts)?))
}

/// The phases that send the mirror's light, made smaller, onto a disc of the sensor. They conjugate the light that
/// comes back from the disc, whose own phase spreads it over the mirror.
fn spread(
    mirror: &Conformal,
    design: &MirrorDesign,
    shape: (usize, usize),
    place: &dyn Fn(usize) -> f64,
) -> Vec<f64> {
    let radius = SPREAD * mirror.scale;
    let larger = 0.5 * mirror.width() / radius;
    let bend = 0.5 * TAU / WAVELENGTH * (1.0 - larger) / mirror.distance();
    let disc = Array2::from_shape_fn(shape, |(j, i)| {
        let square = place(i).powi(2) + place(j).powi(2);
        let lit = f64::from(u8::from(square < radius * radius));
        Complex64::from_polar(lit, bend * square)
    });
    design.conjugate(disc.view()).into_iter().collect()
}

impl Conformal {
    /// Two phases for each pixel of a flat mirror, one to each focus: first those of all pixels to the first.
    fn flat_phases(&self) -> Vec<f64> {
        let (count, k) = (self.count(), TAU / WAVELENGTH);
        let to = |focus: f64| {
            (0..count * count).map(move |n| {
                let (x, y) = (self.place(n % count), self.place(n / count));
                -k * ((focus - x).powi(2) + y * y + self.distance().powi(2)).sqrt()
            })
        };
        self.foci().into_iter().flat_map(to).collect()
    }
}

#[cfg(test)]
mod tests {
    use raylet::design::optimizers::lbfgs::LbfgsSettings;
    use raylet::design::optimizers::optimizer::Method;
    use raylet::design::optimizers::space::Space;

    use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show, Substrate};
    use crate::mirrors::mirror_design::MirrorSearch;

    /// A mirror at a tenth of its size. Its height turns the phase by fifteen radians, and the start does not know the
    /// height. The design finds both foci all the same.
    #[test]
    fn foci_are_found_from_a_start_that_ignores_the_height() {
        let mirror = Conformal {
            substrate: Substrate::Bump,
            show: Show::Foci,
            scale: 0.1,
        };
        let search = MirrorSearch::new(&mirror, LitArea::Disc).unwrap();
        let in_foci = |phases: &[f64]| {
            let shares = search.design.evaluate(phases).shares;
            (&shares * &search.target).sum()
        };
        let before = in_foci(&search.start);
        let settings = LbfgsSettings {
            memory: 10,
            first: 0.1 * (search.start.len() as f64).sqrt(),
            ..LbfgsSettings::default()
        };
        let space = Space::free(search.start.len());
        let mut optimizer = Method::Lbfgs(settings)
            .start(search.start.clone(), space)
            .unwrap();
        for _ in 0..30 {
            let evaluation = search.design.evaluate(optimizer.point());
            optimizer.report(evaluation.value, &evaluation.gradient);
        }
        let after = in_foci(optimizer.best().unwrap().0);
        // A perfect focus of this aperture has π NA²/λ² of its light on each mm²: 0.039 on half a sample's area.
        assert!(before < 0.015 && after > 0.032, "{before} {after}");
    }
}
