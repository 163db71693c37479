//! Collins' integral: a field through a centred paraxial train, without rays.
//!
//! U(x′) = e^{ikL}/(iλB) ∫ U(x) exp(ik(A x² − 2 x·x′ + D x′²)/2B) d²x with the train's ray matrix in
//! optical direction cosines and its axial path L (Collins, J. Opt. Soc. Am. 60, 1168, 1970): a chirp, an
//! exact Fourier sum between any two pitches, and another chirp.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::math::chirp::Chirp2;
use crate::math::part::{comb, part};
use crate::optics::paraxial::Abcd;
use crate::wave::grid::field::Grid;
use crate::wave::grid::raster::Raster;

/// Why Collins' integral cannot be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CollinsError {
    /// The second screen shows an image of the first.
    #[error(
        "the train images one screen onto the other (B = {b} mm): Collins' integral has no kernel \
         there; move the screen"
    )]
    Image {
        /// The reduced distance in mm.
        b: f64,
    },
}

/// The smallest |B| in mm: nearer to an image the kernel oscillates beyond any use.
const LEAST_B: f64 = 1e-9;

/// The plan of Collins' integral from the nodes of a grid to the points of a raster.
#[derive(Clone, Debug)]
pub struct Collins {
    /// One Fourier sum for each node of a cell, [node along y][node along x].
    sums: Vec<Vec<Chirp2>>,
    /// Chirp times weight at each node of the grid, along y and along x.
    before: [Vec<Complex64>; 2],
    /// Chirp at each raster point, along y and along x; the constant is in the first.
    after: [Vec<Complex64>; 2],
}

impl Collins {
    /// Plans the integral; `wavelength` in vacuum, in mm.
    ///
    /// # Errors
    /// When the raster shows an image of the grid (B = 0).
    pub fn new(
        wavelength: f64,
        train: Abcd,
        from: &Grid,
        to: &Raster,
    ) -> Result<Self, CollinsError> {
        let Abcd { a, b, d, path, .. } = train;
        if b.abs() < LEAST_B {
            return Err(CollinsError::Image { b });
        }
        let k = std::f64::consts::TAU / wavelength;

        // One comb of nodes after the other.
        let combs = [to.comb(1), to.comb(0)];
        let sums = (0..from.y.offsets.len())
            .map(|gy| {
                (0..from.x.offsets.len())
                    .map(|gx| {
                        let [y, x] = [from.y.node_comb(gy), from.x.node_comb(gx)];
                        Chirp2::new(y, x, combs[0], combs[1], -k / b)
                    })
                    .collect()
            })
            .collect();

        // The chirps, and e^{ikL}/(iλB) with whole waves of the path dropped.
        let chirp = |rate: f64, x: f64| Complex64::cis(0.5 * k * rate / b * x * x);
        let before = [&from.y, &from.x].map(|axis| {
            (0..axis.len())
                .map(|i| chirp(a, axis.node(i)) * axis.weight(i))
                .collect()
        });
        let mut after = combs.map(|comb| {
            (0..comb.count)
                .map(|i| chirp(d, comb.at(i)))
                .collect::<Vec<_>>()
        });
        let turns = path / wavelength;
        let constant = Complex64::cis(std::f64::consts::TAU * (turns - turns.round()))
            / Complex64::new(0.0, wavelength * b);
        after[0].iter_mut().for_each(|value| *value *= constant);
        Ok(Self {
            sums,
            before,
            after,
        })
    }

    /// The field [y, x] on the raster of the field [y, x] on the nodes of the grid.
    ///
    /// # Panics
    /// If `field` has not the grid's shape.
    pub fn carry(&self, field: ArrayView2<'_, Complex64>) -> Array2<Complex64> {
        let start = scaled(field, &self.before, |u, factor| u * factor);
        let mut total = Array2::zeros([self.after[0].len(), self.after[1].len()]);
        let [steps_y, steps_x] = [self.sums.len(), self.sums[0].len()];
        for (gy, row) in self.sums.iter().enumerate() {
            for (gx, sum) in row.iter().enumerate() {
                let comb = part(start.view(), comb(gy, steps_y), comb(gx, steps_x));
                total += &sum.apply(comb);
            }
        }
        scaled(total.view(), &self.after, |u, factor| u * factor)
    }

    /// The conjugate transpose of [`Collins::carry`].
    ///
    /// # Panics
    /// If `out_bar` has not the raster's shape.
    pub(crate) fn carry_adjoint(&self, out_bar: ArrayView2<'_, Complex64>) -> Array2<Complex64> {
        // U′ = after · total
        let total_bar = scaled(out_bar, &self.after, |u, factor| u * factor.conj());
        let mut start_bar = Array2::zeros([self.before[0].len(), self.before[1].len()]);
        let [steps_y, steps_x] = [self.sums.len(), self.sums[0].len()];
        // total = Σ sum(start's comb)
        for (gy, row) in self.sums.iter().enumerate() {
            for (gx, sum) in row.iter().enumerate() {
                part(start_bar.view_mut(), comb(gy, steps_y), comb(gx, steps_x))
                    .assign(&sum.apply_adjoint(total_bar.view()));
            }
        }
        // start = before · U
        scaled(start_bar.view(), &self.before, |u, factor| {
            u * factor.conj()
        })
    }
}

/// An array times a factor for its row and a factor for its column.
fn scaled(
    values: ArrayView2<'_, Complex64>,
    [rows, columns]: &[Vec<Complex64>; 2],
    times: impl Fn(Complex64, Complex64) -> Complex64 + Sync,
) -> Array2<Complex64> {
    let mut out = values.to_owned();
    ndarray::Zip::indexed(out.rows_mut()).par_for_each(|j, mut row| {
        for (value, column) in row.iter_mut().zip(columns) {
            *value = times(*value, rows[j] * column);
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::complex_noise;
    use crate::optics::paraxial::Abcd;
    use crate::wave::free::collins::{Collins, CollinsError};
    use crate::wave::grid::field::{Axis, Grid};
    use crate::wave::grid::raster::Raster;

    const WAVELENGTH: f64 = 0.7e-3;

    fn train(sensor: f64) -> Abcd {
        Abcd::IDENTITY
            .drift(10.0, 1.0)
            .thin_lens(1.0 / 50.0)
            .drift(4.0, 1.5)
            .drift(sensor, 1.0)
    }

    fn raster(size: [usize; 2], pitch: f64) -> Raster {
        Raster {
            start: size.map(|n| -0.5 * (n as f64 - 1.0) * pitch),
            pitch: [pitch; 2],
            size,
        }
    }

    #[test]
    fn gaussian_beam_follows_its_q_parameter() {
        // U = e^{ik path} e^{ik x²/2q′}/(A + B/q): absolute phase, Gouy phase in the complex divisor,
        // before, in and behind the focus.
        let (waist, k) = (0.4, std::f64::consts::TAU / WAVELENGTH);
        let grid = Grid {
            x: Axis::uniform(400, 0.01, 0.0),
            y: Axis::gauss(260, 0.015, 0.05, 4),
        };
        let beam = Array2::from_shape_fn(grid.shape(), |(j, i)| {
            let square = grid.x.node(i).powi(2) + grid.y.node(j).powi(2);
            Complex64::from((-square / (waist * waist)).exp())
        });
        for sensor in [30.0, 50.0, 80.0, 400.0] {
            let (train, to) = (train(sensor), raster([21, 17], 0.05));
            let q = Complex64::new(0.0, -0.5 * k * waist * waist);
            let divisor = train.a + train.b / q;
            let curvature = (train.c + train.d / q) / divisor;
            let field = Collins::new(WAVELENGTH, train, &grid, &to)
                .unwrap()
                .carry(beam.view());
            let mut worst: f64 = 0.0;
            for ((j, i), value) in field.indexed_iter() {
                let [x, y] = [0, 1].map(|a| to.start[a] + [i, j][a] as f64 * to.pitch[a]);
                let exponent = 0.5 * (x * x + y * y) * curvature + train.path;
                let exact = (Complex64::i() * k * exponent).exp() / divisor;
                worst = worst.max((value - exact).norm() * divisor.norm());
            }
            assert!(worst < 2e-9, "{sensor}: {worst:e}");
        }
    }

    #[test]
    fn carry_dot_product() {
        let grid = Grid {
            x: Axis::gauss(31, 0.013, 0.01, 2),
            y: Axis::gauss(23, 0.017, -0.02, 3),
        };
        let to = raster([47, 39], 0.011);
        let plan = Collins::new(WAVELENGTH, train(40.0), &grid, &to).unwrap();
        let (field, out_bar) = (
            complex_noise(grid.shape(), 3, [0, 1]),
            complex_noise([39, 47], 3, [0, 2]),
        );
        let (out, field_bar) = (plan.carry(field.view()), plan.carry_adjoint(out_bar.view()));
        let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| {
            a.iter()
                .zip(b)
                .map(|(a, b)| a.conj() * b)
                .sum::<Complex64>()
        };
        let size = (inner(&out, &out) * inner(&out_bar, &out_bar))
            .norm()
            .sqrt();
        let off = (inner(&out_bar, &out) - inner(&field_bar, &field)).norm() / size;
        assert!(off < 1e-15, "{off:e}");
    }

    #[test]
    fn images_are_refused() {
        let relay = Abcd::IDENTITY
            .drift(100.0, 1.0)
            .thin_lens(1.0 / 50.0)
            .drift(100.0, 1.0);
        let grid = Grid {
            x: Axis::uniform(4, 0.1, 0.0),
            y: Axis::uniform(4, 0.1, 0.0),
        };
        let result = Collins::new(WAVELENGTH, relay, &grid, &raster([4, 4], 0.1));
        assert!(matches!(result, Err(CollinsError::Image { .. })));
    }
}
