//! Beamlets summed on the samples of one tile, divided by the tile's carrier, and the transpose.

use fearless_simd::dispatch;
use ndarray::Array2;
use num_complex::Complex64;

use crate::math::simd_level::level;
use crate::wave::beamlet::beamlet_kernel::{BeamletKernel, Moments};
use crate::wave::beamlet::raster_rows::Rows;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;
use crate::wave::local_bands::carrier::Carrier;

/// The samples of one tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gather {
    /// The carrier by which the light is divided.
    pub carrier: Carrier,
    /// Places of the samples, in mm.
    pub raster: Raster,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// Each beamlet is summed where it exceeds this share of its peak.
    pub edge: f64,
}

impl Gather {
    /// The light of beamlets over the carrier at the samples, [y, x], and how many values were evaluated.
    pub(crate) fn apply(&self, arrivals: &[Arrival]) -> (Array2<Complex64>, u64) {
        let mut rows = Rows::zeros(self.raster);
        let limit = self.limit();
        let mut evaluations = 0;
        for arrival in arrivals {
            let beside = self.carrier.beside(arrival, self.k);
            if let Some(kernel) = BeamletKernel::new(&beside, &self.raster, limit, self.k) {
                evaluations += dispatch!(level(), simd => kernel.add(simd, &mut rows));
            }
        }
        let [nx, ny] = self.raster.size;
        let values = Array2::from_shape_fn((ny, nx), |(j, i)| rows.value([j, i]));
        (values, evaluations)
    }

    /// The conjugate transpose: the moments that the cotangent of the samples has under each beamlet of amplitude one,
    /// the first of which is the cotangent of the beamlet's amplitude.
    pub(crate) fn apply_adjoint(
        &self,
        arrivals: &[Arrival],
        bar: &Array2<Complex64>,
    ) -> Vec<Moments> {
        let mut rows = Rows::zeros(self.raster);
        for ((j, i), value) in bar.indexed_iter() {
            rows.set([j, i], *value);
        }
        let limit = self.limit();
        let one = |arrival: &Arrival| {
            let beside = self.carrier.beside(arrival, self.k);
            let Some(kernel) = BeamletKernel::new(&beside, &self.raster, limit, self.k) else {
                return [Complex64::ZERO; 6];
            };
            let moments = dispatch!(level(), simd => kernel.add_adjoint(simd, &rows));
            // amplitude of the beamlet beside the carrier = amplitude·removed
            let turned = self.carrier.removed(arrival.at, self.k).conj();
            moments.map(|moment| moment * turned)
        };
        arrivals.iter().map(one).collect()
    }

    /// Where a footprint ends.
    fn limit(&self) -> f64 {
        -2.0 * self.edge.ln() / self.k
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;
    use crate::wave::local_bands::carrier::Carrier;
    use crate::wave::local_bands::gather::Gather;

    #[test]
    fn gather_dot_product() {
        let gather = Gather {
            carrier: Carrier {
                at: [0.1, 0.2],
                p: [0.3, -0.1],
                q: [0.01, 0.002, -0.02],
            },
            raster: Raster {
                start: [-9.0, -11.0],
                pitch: [0.4, 0.5],
                size: [50, 45],
            },
            k: 6.0,
            edge: 1e-3,
        };
        let amplitudes = noise((1, 12), 0);
        let all: Vec<Arrival> = amplitudes
            .iter()
            .enumerate()
            .map(|(i, amplitude)| Arrival {
                at: [0.9 * i as f64 - 5.0, 3.0 - 0.7 * i as f64],
                cosines: [0.31, -0.08 - 0.002 * i as f64],
                amplitude: *amplitude,
                curvature: [
                    Complex64::new(0.02, 0.03),
                    Complex64::new(-0.01, 0.005),
                    Complex64::new(0.01, 0.02),
                ],
            })
            .collect();
        let (there, evaluations) = gather.apply(&all);
        assert!(evaluations > 1000);
        let bar = noise(there.dim(), 1);
        let back = gather.apply_adjoint(&all, &bar);
        let forward: Complex64 = there.iter().zip(&bar).map(|(a, b)| b.conj() * a).sum();
        let reverse: Complex64 = amplitudes
            .iter()
            .zip(&back)
            .map(|(a, moments)| moments[0].conj() * a)
            .sum();
        assert!((forward - reverse).norm() < 1e-11, "{forward} {reverse}");
    }
}
