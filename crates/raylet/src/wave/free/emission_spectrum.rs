//! From the field on a plane or curved screen to the plane waves of a free hop, and back.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::math::chirp::Comb;
use crate::math::interleaved_dft::InterleavedDft2;
use crate::math::part::part;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::wave::free::free_plan::FreePlan;
use crate::wave::free::propagate::{FreeHop, Surface, band_comb};
use crate::wave::free::surface_tilt::{NEIGHBOURS, SurfaceTilt};
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::heights::{Heights, SplitField, Stack, normal_cosines};
use crate::wave::patches::patch::Band;

impl FreeHop {
    /// Field to plane waves.
    pub(in crate::wave) fn emission_spectrum(
        &self,
        field: &Field,
        surface: Surface,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let Some((heights, leaves)) = surface else {
            let dft = self.dft(&field.grid, &plan.bands);
            return self.spread(&dft, field.values.view(), &field.grid, plan);
        };
        let [band_x, band_y] = &plan.bands;
        let stack = self.stack(field, heights, leaves, plan);
        let tilt = SurfaceTilt::of(heights, &stack, &field.grid, plan, self.k);
        let dft = self.dft(&field.grid, &leaving_bands(&tilt, plan));
        let weighted = self.weighted(field.values.view(), &field.grid, plan);
        let split = SplitField::new(&weighted, heights, &stack);
        let mut waves: Array2<Complex64> = Array2::zeros((band_y.count, band_x.count));
        for (number, level) in stack.levels.at.iter().enumerate() {
            // What this level holds of the field, and of the field times the slopes along the direction.
            let held = split.level(number);
            let all = dft.apply(held.view());
            let (flat, tilted) = match &tilt {
                Some(tilt) => (inner(&all), tilt.apply(&all, &plan.bands, *level)),
                None => {
                    let tilted = Self::tilted(&dft, &held, heights, &plan.bands);
                    (all.view(), tilted)
                }
            };
            ndarray::Zip::indexed(&mut waves)
                .and(&flat)
                .and(&tilted)
                .par_for_each(|(j, i), wave, flat, tilted| {
                    let q = leaves * self.normal([band_x.at(i), band_y.at(j)]);
                    if q != 0.0 {
                        *wave += (flat - tilted / q) * Complex64::cis(-self.k * q * level);
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
        let Some((heights, leaves)) = surface else {
            let dft = self.dft(&field.grid, &plan.bands);
            return self.spread_adjoint(&dft, waves_bar, &field.grid, plan);
        };
        let [band_x, band_y] = &plan.bands;
        let stack = self.stack(field, heights, leaves, plan);
        let tilt = SurfaceTilt::of(heights, &stack, &field.grid, plan, self.k);
        let dft = self.dft(&field.grid, &leaving_bands(&tilt, plan));
        let mut values_bar: Array2<Complex64> = Array2::zeros(field.values.dim());
        for (number, level) in stack.levels.at.iter().enumerate() {
            // wave += (flat − tilted/q)·e^{−ikq·level}
            let back = |weight: &(dyn Fn(f64) -> f64 + Sync)| {
                let mut part_bar = waves_bar.clone();
                ndarray::Zip::indexed(&mut part_bar).par_for_each(|(j, i), wave| {
                    let q = leaves * self.normal([band_x.at(i), band_y.at(j)]);
                    let factor = if q == 0.0 { 0.0 } else { weight(q) };
                    *wave *= Complex64::from_polar(factor, self.k * q * level);
                });
                part_bar
            };
            let (flat, tilted) = (back(&|_| 1.0), back(&|q| -1.0 / q));
            let held_bar = match &tilt {
                Some(tilt) => {
                    let mut all = widened(&flat);
                    tilt.apply_adjoint(&tilted, &plan.bands, *level, &mut all);
                    self.spread_adjoint(&dft, &all, &field.grid, plan)
                }
                None => {
                    let mut held = self.spread_adjoint(&dft, &flat, &field.grid, plan);
                    held += &self.tilted_adjoint(&dft, &tilted, heights, &field.grid, plan);
                    held
                }
            };
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

    /// Σ U·s·p of what a level holds, for slopes of any surface: one transform for each axis.
    fn tilted(
        dft: &InterleavedDft2,
        held: &Array2<Complex64>,
        heights: &Heights,
        [band_x, band_y]: &[Band; 2],
    ) -> Array2<Complex64> {
        let along = |slope: &Array2<f64>| {
            let tilted = ndarray::Zip::from(held)
                .and(slope)
                .par_map_collect(|u, s| u * s);
            dft.apply(tilted.view())
        };
        let [mut sum, along_y] = heights.slope.each_ref().map(along);
        ndarray::Zip::indexed(&mut sum)
            .and(&along_y)
            .par_for_each(|(j, i), sum, y| *sum = *sum * band_x.at(i) + y * band_y.at(j));
        sum
    }

    /// The conjugate transpose of [`FreeHop::tilted`].
    fn tilted_adjoint(
        &self,
        dft: &InterleavedDft2,
        tilted_bar: &Array2<Complex64>,
        heights: &Heights,
        grid: &Grid,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let [band_x, band_y] = &plan.bands;
        let back = |slope: &Array2<f64>, cosine: &(dyn Fn((usize, usize)) -> f64 + Sync)| {
            let mut part_bar = tilted_bar.clone();
            ndarray::Zip::indexed(&mut part_bar).par_for_each(|at, bar| *bar *= cosine(at));
            let mut held_bar = self.spread_adjoint(dft, &part_bar, grid, plan);
            ndarray::Zip::from(&mut held_bar)
                .and(slope)
                .par_for_each(|bar, s| *bar *= s);
            held_bar
        };
        let [along_x, along_y] = &heights.slope;
        back(along_x, &|(_, i)| band_x.at(i)) + back(along_y, &|(j, _)| band_y.at(j))
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
        self.levels(range, leaves, plan)
    }

    /// The levels of a curved screen between two heights that all directions of a plan need.
    fn levels(&self, range: [f64; 2], leaves: f64, plan: &FreePlan) -> Stack {
        let [x, y] = &plan.bands;
        let ends = |band: &Band| [band.at(0), band.at(band.count.max(1) - 1)];
        let ([x0, x1], [y0, y1]) = (ends(x), ends(y));
        let n = self.slabs.first().map_or(1.0, |slab| slab.index);
        let mut cosines = normal_cosines([x0, x1, y0, y1], n).map(|q| leaves * q);
        cosines.sort_by(f64::total_cmp);
        Stack::new(range, cosines, self.k)
    }

    /// How many transforms take the field of a screen to the plane waves of a plan.
    pub(crate) fn transforms(&self, screen: &Screen, plan: &FreePlan) -> usize {
        let Some(relief) = screen.relief().filter(|_| !screen.is_plane()) else {
            return 1;
        };
        let stack = self.levels([relief.low, relief.high], screen.leaves(), plan);
        match &screen.shape {
            Shape::Conic(_) => stack.len(),
            _ => 3 * stack.len(),
        }
    }

    /// Field to plane waves, c(p) = 1/P² Σ U e^{−ik p·x} dA.
    fn spread(
        &self,
        dft: &InterleavedDft2,
        values: ArrayView2<Complex64>,
        grid: &Grid,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        dft.apply(self.weighted(values, grid, plan).view())
    }

    /// A field times what its nodes represent, over the area of a period.
    fn weighted(
        &self,
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
        weighted
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

    /// The transforms from the nodes of a grid to directions.
    fn dft(&self, grid: &Grid, [band_x, band_y]: &[Band; 2]) -> InterleavedDft2 {
        let combs = |axis: &Axis| -> Vec<Comb> {
            (0..axis.offsets.len()).map(|g| axis.node_comb(g)).collect()
        };
        let (y, x) = (combs(&grid.y), combs(&grid.x));
        InterleavedDft2::new(&y, &x, band_comb(band_y), band_comb(band_x), -self.k)
    }
}

/// The directions of the transform of a level: those of the plan, and the neighbours that a tilt takes.
fn leaving_bands(tilt: &Option<SurfaceTilt>, plan: &FreePlan) -> [Band; 2] {
    let beside = tilt.as_ref().map_or(0, |_| NEIGHBOURS);
    plan.bands.map(|band| Band {
        first: band.first - beside as i64,
        count: band.count + 2 * beside,
        ..band
    })
}

/// The directions of the plan among those and their neighbours.
fn inner(wide: &Array2<Complex64>) -> ArrayView2<'_, Complex64> {
    let [ny, nx] = [0, 1].map(|a| NEIGHBOURS..wide.shape()[a] - NEIGHBOURS);
    part(wide.view(), ny, nx)
}

/// The conjugate transpose of [`inner`].
fn widened(inner_bar: &Array2<Complex64>) -> Array2<Complex64> {
    let [ny, nx] = [0, 1].map(|a| inner_bar.shape()[a]);
    let mut wide = Array2::zeros((ny + 2 * NEIGHBOURS, nx + 2 * NEIGHBOURS));
    let [rows, columns] = [ny, nx].map(|count| NEIGHBOURS..NEIGHBOURS + count);
    part(wide.view_mut(), rows, columns).assign(inner_bar);
    wide
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{conic, open_screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::conic::Conic;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;
    use crate::optics::shape::Shape;
    use crate::wave::free::free_plan::{FreePlan, Slab};
    use crate::wave::free::propagate::{CLEAR, FreeHop};
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;

    /// A hop to a plane beside the axis.
    fn hop() -> FreeHop {
        let slab = Slab {
            index: 1.2,
            thickness: 7.0,
            exit: None,
        };
        FreeHop {
            k: std::f64::consts::TAU,
            slabs: vec![slab],
            offset: [0.3, 0.0],
            chief: [0.1, 0.0],
            padding: 4.0,
            clear: CLEAR,
        }
    }

    /// A field with dark nodes, on a grid beside the axis.
    fn field() -> Field {
        let grid = Grid {
            x: Axis::gauss(20, 0.5, 1.0, 2),
            y: Axis::gauss(20, 0.5, 0.0, 2),
        };
        let mut values = noise(grid.shape(), 0);
        values.row_mut(3).fill(0.0.into());
        Field { grid, values }
    }

    fn plan() -> FreePlan {
        hop().plan([-4.0, 6.0, -5.0, 5.0], [-5.0, 5.0, -5.0, 5.0])
    }

    /// A surface that is no conic.
    fn bump(grid: &Grid) -> Heights {
        let place = |(j, i): (usize, usize)| [grid.x.node(i), grid.y.node(j)];
        let height = |at| {
            let [x, y]: [f64; 2] = place(at);
            2.0 * (-(x * x + y * y) / 30.0).exp()
        };
        let slope = |axis: usize| {
            Array2::from_shape_fn(grid.shape(), |at| -place(at)[axis] / 15.0 * height(at))
        };
        Heights {
            z: Array2::from_shape_fn(grid.shape(), height),
            slope: [slope(0), slope(1)],
            conic: None,
        }
    }

    fn bowl(grid: &Grid) -> Heights {
        let mut bowl = open_screen(Frame::GLOBAL);
        bowl.shape = conic(1.0 / 14.0, 0.4);
        Heights::on(&bowl, grid)
    }

    /// From a plane and from curved screens.
    #[test]
    fn emission_spectrum_dot_product() {
        let (hop, field, plan) = (hop(), field(), plan());
        let (bump, bowl) = (bump(&field.grid), bowl(&field.grid));
        let curved =
            [&bump, &bowl].map(|heights| [1.0, -1.0].map(|leaves| Some((heights, leaves))));
        for surface in curved.into_iter().flatten().chain([None]) {
            let there = hop.emission_spectrum(&field, surface, &plan);
            let bar = noise(there.dim(), 1);
            let back = hop.emission_spectrum_adjoint(&bar, &field, surface, &plan);
            assert_transposed(&[(&bar, &there)], &[(&back, &field.values)]);
        }
    }

    /// Of a plane, of a bowl by its levels, and of a shape whose slopes are no multiples of the place.
    #[test]
    fn transforms_are_as_many_as_a_forecast_counts() {
        let (hop, field, plan) = (hop(), field(), plan());
        let bowl = bowl(&field.grid);
        let levels = hop.stack(&field, &bowl, 1.0, &plan).len();
        let mut screen = open_screen(Frame::GLOBAL);
        screen.kind = ScreenKind::Stop(Aperture::turned_rectangle(5.0, 5.0, 0.0, [1.0, 0.0]));
        assert_eq!(hop.transforms(&screen, &plan), 1);

        screen.shape = conic(1.0 / 14.0, 0.4);
        let counted = hop.transforms(&screen, &plan);
        assert!(
            levels > 5 && counted.abs_diff(levels) <= 2,
            "{counted} of {levels}"
        );

        screen.shape = Shape::Asphere {
            base: Conic {
                curvature: 1.0 / 14.0,
                conic: 0.4,
            },
            coefficients: vec![0.0],
        };
        assert_eq!(hop.transforms(&screen, &plan), 3 * counted);
    }

    #[test]
    fn tilts_from_neighbouring_directions_are_those_of_the_slopes() {
        let (hop, field, plan) = (hop(), field(), plan());
        let bowl = bowl(&field.grid);
        let slopes = Heights {
            conic: None,
            ..bowl.clone()
        };
        let waves = |heights| hop.emission_spectrum(&field, Some((heights, 1.0)), &plan);
        let (found, expected) = (waves(&bowl), waves(&slopes));
        let off = (&found - &expected).mapv(|c| c.norm_sqr()).sum();
        let all = expected.mapv(|c| c.norm_sqr()).sum();
        assert!(off > 0.0, "both ways are one");
        assert!((off / all).sqrt() < 1e-5, "{:e}", (off / all).sqrt());
    }
}
