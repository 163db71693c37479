//! From the field on a plane or curved screen to the plane waves of a free hop, and back.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::math::chirp::Comb;
use crate::math::interleaved_dft::InterleavedDft2;
use crate::wave::free::free_plan::FreePlan;
use crate::wave::free::propagate::{FreeHop, Surface, band_comb};
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::heights::{Heights, Stack, normal_cosines};
use crate::wave::patches::patch::Band;

impl FreeHop {
    /// Field to plane waves.
    pub(in crate::wave) fn emission_spectrum(
        &self,
        field: &Field,
        surface: Surface,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let dft = self.dft(&field.grid, plan);
        let Some((heights, leaves)) = surface else {
            return self.spread(&dft, field.values.view(), &field.grid, plan);
        };
        let [band_x, band_y] = &plan.bands;
        let normal = |p: [f64; 2]| leaves * self.normal(p);
        let stack = self.stack(field, heights, leaves, plan);
        let mut waves: Array2<Complex64> = Array2::zeros((band_y.count, band_x.count));
        for (number, level) in stack.levels.at.iter().enumerate() {
            // What this level holds of the field, and of the field times the slopes.
            let held = level_part(&stack, number, field, heights);
            let part = |weight: Option<&Array2<f64>>| match weight {
                None => self.spread(&dft, held.view(), &field.grid, plan),
                Some(slope) => {
                    let tilted = ndarray::Zip::from(&held)
                        .and(slope)
                        .par_map_collect(|u, s| u * s);
                    self.spread(&dft, tilted.view(), &field.grid, plan)
                }
            };
            let [sx, sy] = &heights.slope;
            let (flat, along_x, along_y) = (part(None), part(Some(sx)), part(Some(sy)));
            ndarray::Zip::indexed(&mut waves)
                .and(&flat)
                .and(&along_x)
                .and(&along_y)
                .par_for_each(|(j, i), wave, flat, along_x, along_y| {
                    let p = [band_x.at(i), band_y.at(j)];
                    let q = normal(p);
                    if q != 0.0 {
                        let lifted = flat - (along_x * p[0] + along_y * p[1]) / q;
                        *wave += lifted * Complex64::cis(-self.k * q * level);
                    }
                });
        }
        waves
    }

    /// The conjugate transpose of [`FreeHop::emission_spectrum`].
    pub(in crate::wave) fn emission_spectrum_adjoint(
        &self,
        waves_bar: &Array2<Complex64>,
        field: &Field,
        surface: Surface,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let dft = self.dft(&field.grid, plan);
        let Some((heights, leaves)) = surface else {
            return self.spread_adjoint(&dft, waves_bar, &field.grid, plan);
        };
        let [band_x, band_y] = &plan.bands;
        let stack = self.stack(field, heights, leaves, plan);
        let mut values_bar: Array2<Complex64> = Array2::zeros(field.values.dim());
        for (number, level) in stack.levels.at.iter().enumerate() {
            // wave += (flat − (along_x p_x + along_y p_y)/q)·e^{−ikq·level}
            let back = |weight: &(dyn Fn([f64; 2], f64) -> f64 + Sync)| {
                let mut part_bar = waves_bar.clone();
                ndarray::Zip::indexed(&mut part_bar).par_for_each(|(j, i), wave| {
                    let p = [band_x.at(i), band_y.at(j)];
                    let q = leaves * self.normal(p);
                    let factor = if q == 0.0 { 0.0 } else { weight(p, q) };
                    *wave *= Complex64::from_polar(factor, self.k * q * level);
                });
                self.spread_adjoint(&dft, &part_bar, &field.grid, plan)
            };
            let flat = back(&|_, _| 1.0);
            let along_x = back(&|p, q| -p[0] / q);
            let along_y = back(&|p, q| -p[1] / q);

            // What the level holds is a share of the value; tilted parts are that times a slope.
            let [sx, sy] = &heights.slope;
            let mut held_bar = flat;
            ndarray::Zip::from(&mut held_bar)
                .and(&along_x)
                .and(&along_y)
                .and(sx)
                .and(sy)
                .par_for_each(|bar, x, y, sx, sy| *bar += x * sx + y * sy);
            ndarray::Zip::from(&mut values_bar)
                .and(&held_bar)
                .and(&heights.z)
                .and(&field.values)
                .par_for_each(|bar, held, z, value| {
                    if *value != Complex64::ZERO {
                        *bar += stack.part_adjoint(*held, *z, number);
                    }
                });
        }
        values_bar
    }

    /// The normal cosine in the first medium; zero when evanescent.
    fn normal(&self, p: [f64; 2]) -> f64 {
        let n = self.slabs.first().map_or(1.0, |slab| slab.index);
        (n * n - p[0] * p[0] - p[1] * p[1]).max(0.0).sqrt()
    }

    /// The levels of a curved screen that all directions of a plan need.
    pub(crate) fn stack(
        &self,
        field: &Field,
        heights: &Heights,
        leaves: f64,
        plan: &FreePlan,
    ) -> Stack {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for (z, value) in heights.z.iter().zip(&field.values) {
            if value.norm_sqr() > 0.0 {
                range = [range[0].min(*z), range[1].max(*z)];
            }
        }
        let [x, y] = &plan.bands;
        let ends = |band: &Band| [band.at(0), band.at(band.count.max(1) - 1)];
        let ([x0, x1], [y0, y1]) = (ends(x), ends(y));
        let n = self.slabs.first().map_or(1.0, |slab| slab.index);
        let mut cosines = normal_cosines([x0, x1, y0, y1], n).map(|q| leaves * q);
        cosines.sort_by(f64::total_cmp);
        Stack::new(range, cosines, self.k)
    }

    /// Field to plane waves, c(p) = 1/P² Σ U e^{−ik p·x} dA.
    fn spread(
        &self,
        dft: &InterleavedDft2,
        values: ArrayView2<Complex64>,
        grid: &Grid,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let area = plan.period[0] * plan.period[1];
        let mut weighted = values.to_owned();
        ndarray::Zip::indexed(weighted.rows_mut()).par_for_each(|j, mut row| {
            let along_y = grid.y.weight(j) / area;
            for (i, value) in row.iter_mut().enumerate() {
                *value *= grid.x.weight(i) * along_y;
            }
        });
        dft.apply(weighted.view())
    }

    /// The conjugate transpose of [`FreeHop::spread`].
    fn spread_adjoint(
        &self,
        dft: &InterleavedDft2,
        waves_bar: &Array2<Complex64>,
        grid: &Grid,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let area = plan.period[0] * plan.period[1];
        let mut values_bar = dft.apply_adjoint(waves_bar.view(), grid.shape());
        ndarray::Zip::indexed(values_bar.rows_mut()).par_for_each(|j, mut row| {
            let along_y = grid.y.weight(j) / area;
            for (i, bar) in row.iter_mut().enumerate() {
                *bar *= grid.x.weight(i) * along_y;
            }
        });
        values_bar
    }

    /// The transforms from the nodes of a grid to a plan's directions.
    fn dft(&self, grid: &Grid, plan: &FreePlan) -> InterleavedDft2 {
        let [band_x, band_y] = &plan.bands;
        let combs = |axis: &Axis| -> Vec<Comb> {
            (0..axis.offsets.len()).map(|g| axis.node_comb(g)).collect()
        };
        let (y, x) = (combs(&grid.y), combs(&grid.x));
        InterleavedDft2::new(&y, &x, band_comb(band_y), band_comb(band_x), -self.k)
    }
}

/// What one level holds of a field on a curved screen.
fn level_part(stack: &Stack, number: usize, field: &Field, heights: &Heights) -> Array2<Complex64> {
    ndarray::Zip::from(&field.values)
        .and(&heights.z)
        .par_map_collect(|value, z| stack.part(*value, *z, number))
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::wave::free::free_plan::Slab;
    use crate::wave::free::propagate::{CLEAR, FreeHop};
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;

    /// From a plane and, with dark nodes, from a curved screen.
    #[test]
    fn emission_spectrum_dot_product() {
        let axis = Axis::gauss(20, 0.5, 0.0, 2);
        let grid = Grid {
            x: axis.clone(),
            y: axis.clone(),
        };
        let shape = grid.shape();
        let bump = |(j, i): (usize, usize)| {
            let (x, y) = (axis.node(i), axis.node(j));
            2.0 * (-(x * x + y * y) / 30.0).exp()
        };
        let z = Array2::from_shape_fn(shape, bump);
        let slope = |(j, i): (usize, usize)| -axis.node(i) / 15.0 * z[[j, i]];
        let along_x = Array2::from_shape_fn(shape, slope);
        let along_y = along_x.t().to_owned();
        let heights = Heights {
            z,
            slope: [along_x, along_y],
        };
        let slab = Slab {
            index: 1.2,
            thickness: 7.0,
            exit: None,
        };
        let hop = FreeHop {
            k: std::f64::consts::TAU,
            slabs: vec![slab],
            offset: [0.3, 0.0],
            chief: [0.1, 0.0],
            padding: 4.0,
            clear: CLEAR,
        };
        let bounds = [-5.0, 5.0, -5.0, 5.0];
        let plan = hop.plan(bounds, bounds);
        let mut values = noise(shape, 0);
        values.row_mut(3).fill(0.0.into());
        let field = Field { grid, values };
        for surface in [None, Some((&heights, 1.0)), Some((&heights, -1.0))] {
            let there = hop.emission_spectrum(&field, surface, &plan);
            let bar = noise(there.dim(), 1);
            let back = hop.emission_spectrum_adjoint(&bar, &field, surface, &plan);
            assert_transposed(&[(&bar, &there)], &[(&back, &field.values)]);
        }
    }
}
