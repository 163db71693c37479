//! Phase holograms for a sensor close behind them, by Gerchberg and Saxton's algorithm with the angular
//! spectrum.
//!
//! Pixels are point samples of a band-limited field, as the source paper has them: plane waves of their own
//! band alone, on a lattice of twice their width. The sensor has the same pixels. As in
//! [`crate::design::holograms::hologram`], steps have momentum.

use std::f64::consts::TAU;

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

use crate::engine::progress::{Cancelled, Reply};
use crate::math::chirp::{Chirp2, Comb};
use crate::wave::grid::metrics::ncc;

/// Width of the lattice's period over that of the pixels.
const PADDING: usize = 2;

/// Momentum: the next step starts from each phase plus this part of its last change.
const MOMENTUM: f64 = 0.9;

/// A hologram to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct NearTask {
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
    /// Distance of neighbouring pixels in mm.
    pub pitch: f64,
    /// Distance from the hologram to the sensor in mm.
    pub distance: f64,
    /// Modulus of the light behind each pixel, [y, x].
    pub amplitude: Array2<f64>,
    /// The target intensity at each pixel of the sensor, up to a factor.
    pub target: Array2<f64>,
    /// Number of iterations.
    pub iterations: usize,
}

/// Free space between two grids of the same pixels, for their band alone.
pub struct NearSpace {
    spectrum: Chirp2,
    transfer: Array2<Complex64>,
    share: f64,
}

impl NearSpace {
    /// The space of `z` mm behind `count`² pixels; `padding` is the period over their width.
    pub fn new(wavelength: f64, pitch: f64, z: f64, count: usize, padding: usize) -> Self {
        let modes = padding * count;
        let (k, spacing) = (TAU / wavelength, wavelength / (modes as f64 * pitch));
        let nodes = Comb {
            start: -0.5 * (count as f64 - 1.0) * pitch,
            step: pitch,
            count,
        };
        let directions = Comb {
            start: -((modes / 2) as f64) * spacing,
            step: spacing,
            count: modes,
        };
        let transfer = Array2::from_shape_fn((modes, modes), |(j, i)| {
            let under = 1.0 - directions.at(i).powi(2) - directions.at(j).powi(2);
            if under > 0.0 {
                Complex64::cis(k * z * under.sqrt())
            } else {
                Complex64::ZERO
            }
        });
        Self {
            spectrum: Chirp2::new(nodes, nodes, directions, directions, -k),
            transfer,
            share: 1.0 / (modes * modes) as f64,
        }
    }

    /// The field on the sensor.
    pub fn carry(&self, field: ArrayView2<Complex64>) -> Array2<Complex64> {
        let modes = self.spectrum.apply(field) * &self.transfer;
        self.spectrum.apply_adjoint(modes.view()) * Complex64::from(self.share)
    }

    /// The conjugate transpose of [`NearSpace::carry`].
    pub(crate) fn carry_adjoint(&self, seen_bar: ArrayView2<Complex64>) -> Array2<Complex64> {
        // seen = adjoint spectrum · (transfer · spectrum(field))
        let modes = self.spectrum.apply(seen_bar) * self.transfer.mapv(|t| t.conj());
        self.spectrum.apply_adjoint(modes.view()) * Complex64::from(self.share)
    }
}

/// Seeks the phases, in radians, and the normalised cross-correlation of what they show with the target;
/// `progress` is called after every iteration. The phases are zero at the start.
///
/// # Errors
/// When `progress` cancels the search.
pub fn design<R: Reply>(
    task: &NearTask,
    progress: &mut dyn FnMut(usize, f64) -> R,
) -> Result<(Array2<f64>, f64), Cancelled> {
    let space = NearSpace::new(
        task.wavelength,
        task.pitch,
        task.distance,
        task.amplitude.ncols(),
        PADDING,
    );
    let modulus = task.target.mapv(|value| value.max(0.0).sqrt());
    let mut field = task.amplitude.mapv(Complex64::from);
    let mut last: Option<Array2<Complex64>> = None;
    for iteration in 0..task.iterations {
        let seen = space.carry(field.view());
        Cancelled::check(progress(iteration, likeness(&seen, task)).flow())?;

        // The target's modulus at the field's own brightness and phase, carried back; then only the phase is kept.
        let (mut along, mut square) = (0.0, 0.0);
        Zip::from(&seen).and(&modulus).for_each(|u, m| {
            along += u.norm() * m;
            square += m * m;
        });
        let scale = along / square;
        let change = Zip::from(&seen)
            .and(&modulus)
            .map_collect(|u, m| Complex64::from_polar(scale * m, u.arg()) - u);
        let back = space.carry_adjoint(change.view());
        Zip::from(&mut field)
            .and(&back)
            .and(&task.amplitude)
            .for_each(|u, back, size| *u = Complex64::from_polar(*size, (*u + back).arg()));

        // On beyond it, the way it came from the last.
        let here = field.clone();
        if let (Some(last), true) = (&last, iteration + 1 < task.iterations) {
            Zip::from(&mut field)
                .and(last)
                .for_each(|u, old| *u *= Complex64::cis(MOMENTUM * (*u * old.conj()).arg()));
        }
        last = Some(here);
    }
    let found = likeness(&space.carry(field.view()), task);
    Cancelled::check(progress(task.iterations, found).flow())?;
    Ok((field.mapv(|u| u.arg()), found))
}

fn likeness(seen: &Array2<Complex64>, task: &NearTask) -> f64 {
    let intensity = seen.mapv(|u| u.norm_sqr());
    ncc(intensity.view(), task.target.view()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::design::holograms::near::{NearSpace, NearTask, design};
    use crate::fixtures::paper_systems::{NEAR, PITCH, WAVELENGTH, open};
    use crate::fixtures::smiley::smiley;
    use crate::math::random::pair;

    #[test]
    fn near_space_dot_product() {
        let space = NearSpace::new(WAVELENGTH, PITCH, NEAR, 12, 2);
        let any = |what: u32| {
            Array2::from_shape_fn((12, 12), |(j, i)| {
                let [re, im] = pair(1, [j as u32, i as u32, what, 0]);
                Complex64::new(re - 0.5, im - 0.5)
            })
        };
        let (a, b) = (any(0), any(1));
        let dot = |p: &Array2<Complex64>, q: &Array2<Complex64>| {
            p.iter()
                .zip(q)
                .map(|(p, q)| p.conj() * q)
                .sum::<Complex64>()
        };
        let (forth, back) = (space.carry(a.view()), space.carry_adjoint(b.view()));
        assert!((dot(&forth, &b) - dot(&a, &back)).norm() < 1e-12);
    }

    #[test]
    fn the_smiley_is_found() {
        let task = NearTask {
            wavelength: WAVELENGTH,
            pitch: PITCH,
            distance: NEAR,
            amplitude: open(100),
            target: smiley(100),
            iterations: 60,
        };
        let mut first = 0.0;
        let (phase, found) = design(&task, &mut |iteration, score| {
            if iteration == 0 {
                first = score;
            }
        })
        .unwrap();
        assert_eq!(phase.dim(), (100, 100));
        assert!(found > 0.95 && first < 0.6, "{first} {found}");
    }
}
