//! A free hop from the pixels of a curved mirror to a parallel plane, fast enough for the hundreds of evaluations
//! of a design.
//!
//! Weyl's sum over the true surface as in [`FreeHop::carry`], with one node a pixel,
//! c(p) = h²/P² sinc(hpₓ/λ) sinc(hp_y/λ) Σⱼ wⱼ vⱼ aⱼ e^{−ik(p·xⱼ + q sⱼ)},
//! v the pixels' values, a the light that arrives. A pixel's own tilt, in the sinc and in the factor N·(p, q)/q, is
//! taken for the direction from the pixel to the middle of the target: wⱼ. Phases are exact at the pixels' centres,
//! amplitudes to a few hundredths. Where the nodes are those of a lattice whose period is a whole number of pixels
//! the sums are fast Fourier transforms, and the exponential of the height is shared among a few levels.

use std::f64::consts::TAU;
use std::sync::Arc;

use fearless_simd::{Simd, SimdBase, dispatch, f64x8};
use ndarray::{Array2, ArrayView2, Axis, Zip};
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};
use rayon::prelude::*;

use crate::math::chirp::Chirp2;
use crate::math::lanes::{LANES, cis_turns};
use crate::math::lines::{quick_length, transform_rows};
use crate::math::simd_level::level;
use crate::math::sinc::sinc;
use crate::optics::screen::Screen;
use crate::wave::free::free_plan::{FreePlan, Slab};
use crate::wave::free::propagate::{CLEAR, FreeHop, band_comb};
use crate::wave::free::slab_transfer::SlabTransfer;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::{Heights, Stack};
use crate::wave::grid::raster::Raster;
use crate::wave::patches::patch::Band;

/// Period over the sum of the half widths of mirror and target. It is smaller than elsewhere, because the copies one
/// period away bring only a few thousandths of the light.
const PADDING: f64 = 3.0;

/// Directions that keep less than this of their light do not count for the levels.
const FAINT: f64 = 1e-3;

/// Error that the levels may add to a field, of the steepest light that counts.
const LEVEL_TOLERANCE: f64 = 1e-3;

/// A plane before a mirror, parallel to it.
#[derive(Clone, Copy)]
pub(crate) struct TargetPlane<'a> {
    /// Its height above the mirror's local plane, in mm.
    pub distance: f64,
    /// Its points.
    pub target: &'a Raster,
}

/// A pixelated mirror before a plane, with everything that does not depend on its pixels' values.
pub(crate) struct PixelHop {
    /// Rows and columns of pixels.
    shape: (usize, usize),
    /// Heights of the levels in wavelengths.
    levels: Vec<f64>,
    /// What each level holds of a pixel of value one, [y, x].
    held: Vec<Array2<Complex64>>,
    lines: [Line; 2],
    /// The factor of each plane wave for the way to the plane, [x, y].
    transfer: Array2<Complex64>,
    land: Chirp2,
}

/// The transform along one axis.
struct Line {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    band: Band,
}

impl PixelHop {
    /// The hop from a mirror to the points of a plane that is parallel to it, in a medium of index 1. `arrived` is the light just before the mirror, one node a pixel; light comes along
    /// the mirror's axis.
    pub(crate) fn new(
        screen: &Screen,
        arrived: &Field,
        plane: TargetPlane,
        wavelength: f64,
    ) -> Self {
        let TargetPlane { distance, target } = plane;
        let grid = &arrived.grid;
        let heights = Heights::on(screen, grid);
        let pitch = [grid.x.pitch, grid.y.pitch];
        let free = FreeHop {
            k: TAU / wavelength,
            slabs: vec![Slab {
                index: 1.0,
                thickness: distance,
                exit: None,
            }],
            offset: [0.0; 2],
            chief: [0.0; 2],
            padding: PADDING,
            clear: CLEAR,
        };
        let ([x0, x1], [y0, y1]) = (grid.x.edges(), grid.y.edges());
        let plan = lattice(&free, [x0, x1, y0, y1], target, pitch);
        let lines = [0, 1].map(|a| Line::new(plan.bands[a], wavelength / pitch[a]));
        let start = [grid.x.start, grid.y.start];
        let (transfer, least) = transfer(&free, &plan, start, pitch);

        let share = tilted(arrived, &heights, plane, wavelength);
        let (stack, held) = levelled(&share, &heights, [least, 1.0], free.k);
        Self {
            shape: (grid.y.cells, grid.x.cells),
            levels: stack.levels.at.iter().map(|z| z / wavelength).collect(),
            held,
            lines,
            transfer,
            land: Chirp2::new(
                band_comb(&plan.bands[1]),
                band_comb(&plan.bands[0]),
                target.comb(1),
                target.comb(0),
                free.k,
            ),
        }
    }

    /// The field at the target's points, [y, x], for the pixels' values, [y, x].
    ///
    /// # Panics
    /// If there are more or fewer values than pixels.
    pub(crate) fn carry(&self, values: ArrayView2<Complex64>) -> Array2<Complex64> {
        assert_eq!(values.dim(), self.shape, "a value for each pixel");
        let [x, y] = &self.lines;
        let along_x: Vec<Array2<Complex64>> = self
            .held
            .iter()
            .map(|held| {
                let part = Zip::from(held).and(values).par_map_collect(|h, v| h * v);
                let mut sums = Array2::zeros((x.band.count, self.shape.0));
                let to = sums.view_mut().reversed_axes();
                transform_rows(part.view(), to, |from, to, work| x.apply(from, to, work));
                sums
            })
            .collect();

        // Every direction along x on its own: along y, level by level.
        let mut waves: Array2<Complex64> = Array2::zeros(self.transfer.dim());
        let level = level();
        let columns = waves.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
        columns.for_each_init(Vec::new, |work, (i, mut column)| {
            let mut sums = vec![Complex64::ZERO; y.band.count];
            for (height, part) in self.levels.iter().zip(&along_x) {
                let from = part.row(i);
                let Some(from) = from.as_slice() else {
                    continue;
                };
                let mut sum = vec![Complex64::ZERO; y.band.count];
                y.apply(from, &mut sum, work);
                let lift = self.lift(i, -height);
                dispatch!(level, simd => lift.add(simd, &sum, &mut sums));
            }
            for ((wave, sum), transfer) in column.iter_mut().zip(&sums).zip(self.transfer.row(i)) {
                *wave = sum * transfer;
            }
        });
        self.land.apply(waves.reversed_axes().view())
    }

    /// The conjugate transpose of [`PixelHop::carry`].
    pub(crate) fn carry_adjoint(&self, target_bar: ArrayView2<Complex64>) -> Array2<Complex64> {
        let [x, y] = &self.lines;
        let waves_bar = self.land.apply_adjoint(target_bar).reversed_axes();

        // wave = transfer·Σ e^{−ikq·level}·(sum along y)
        let shape = (x.band.count, self.shape.0);
        let mut along_x: Vec<Array2<Complex64>> =
            self.held.iter().map(|_| Array2::zeros(shape)).collect();
        let mut rows: Vec<Vec<&mut [Complex64]>> = (0..shape.0).map(|_| Vec::new()).collect();
        for part in &mut along_x {
            let lines = part.as_slice_mut().unwrap_or_default();
            for (row, line) in rows.iter_mut().zip(lines.chunks_mut(shape.1)) {
                row.push(line);
            }
        }
        let level = level();
        let columns = rows.into_par_iter().enumerate();
        columns.for_each_init(Vec::new, |work, (i, parts)| {
            let bars = waves_bar.row(i).to_owned().into_iter();
            let bars: Vec<Complex64> = bars
                .zip(self.transfer.row(i))
                .map(|(bar, transfer)| bar * transfer.conj())
                .collect();
            for (height, part) in self.levels.iter().zip(parts) {
                let mut bar = vec![Complex64::ZERO; y.band.count];
                let lift = self.lift(i, *height);
                dispatch!(level, simd => lift.add(simd, &bars, &mut bar));
                y.apply_adjoint(&bar, part, work);
            }
        });

        // sum along x of held·value
        let mut values_bar = Array2::zeros(self.shape);
        for (held, sums_bar) in self.held.iter().zip(along_x) {
            let mut part_bar = Array2::zeros(self.shape);
            transform_rows(sums_bar.t(), part_bar.view_mut(), |from, to, work| {
                x.apply_adjoint(from, to, work);
            });
            Zip::from(&mut values_bar)
                .and(held)
                .and(&part_bar)
                .par_for_each(|bar: &mut Complex64, held, part| *bar += held.conj() * part);
        }
        values_bar
    }

    /// The phases of a height for all directions with this number along x.
    fn lift(&self, column: usize, height: f64) -> Lift<'_> {
        Lift {
            p: self.lines[0].band.at(column),
            band: &self.lines[1].band,
            height,
        }
    }
}

/// Plane waves of one direction along x, moved along the axis.
struct Lift<'a> {
    p: f64,
    band: &'a Band,
    /// In wavelengths.
    height: f64,
}

impl Lift<'_> {
    /// Adds from·e^{2πiq·height}; evanescent waves are left out.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, from: &[Complex64], to: &mut [Complex64]) {
        let rest = 1.0 - self.p * self.p;
        let blocks = from.chunks(LANES).zip(to.chunks_mut(LANES)).enumerate();
        for (block, (from, to)) in blocks {
            let mut turns = [0.0; LANES];
            let mut weights = [0.0; LANES];
            for (n, (turn, weight)) in turns.iter_mut().zip(&mut weights).enumerate() {
                let p = self.band.at(block * LANES + n);
                let square = rest - p * p;
                *turn = square.max(0.0).sqrt() * self.height;
                *weight = f64::from(u8::from(square > 0.0));
            }
            let (cos, sin) = cis_turns(f64x8::from_slice(simd, &turns));
            let (cos, sin) = (cos.as_array(), sin.as_array());
            for (n, (from, to)) in from.iter().zip(to).enumerate() {
                *to += from * Complex64::new(weights[n] * cos[n], weights[n] * sin[n]);
            }
        }
    }
}

impl Line {
    /// Sums from pixels to the directions of a band, whose spacing is a whole fraction of `turn` = λ/pitch.
    fn new(band: Band, turn: f64) -> Self {
        let length = (turn / band.spacing).round() as usize;
        let mut planner = Planner::new();
        Self {
            forward: planner.forward(length),
            inverse: planner.inverse(length),
            band,
        }
    }

    /// Where a direction of the band is in the transform.
    fn place(&self, index: usize) -> usize {
        (self.band.first + index as i64).rem_euclid(self.forward.len() as i64) as usize
    }

    /// Adds Σⱼ from\[j\] e^{−2πi·m·j/N} for each direction m.
    fn apply(&self, from: &[Complex64], to: &mut [Complex64], work: &mut Vec<Complex64>) {
        let (line, scratch) = self.split(&*self.forward, work);
        line[..from.len()].copy_from_slice(from);
        self.forward.process_with_scratch(line, scratch);
        for (m, to) in to.iter_mut().enumerate() {
            *to += line[self.place(m)];
        }
    }

    /// The conjugate transpose of [`Line::apply`].
    fn apply_adjoint(
        &self,
        to_bar: &[Complex64],
        from_bar: &mut [Complex64],
        work: &mut Vec<Complex64>,
    ) {
        let (line, scratch) = self.split(&*self.inverse, work);
        for (m, bar) in to_bar.iter().enumerate() {
            line[self.place(m)] += bar;
        }
        self.inverse.process_with_scratch(line, scratch);
        for (from, line) in from_bar.iter_mut().zip(line) {
            *from += *line;
        }
    }

    /// A line of zeros, and what the transform wants.
    fn split<'a>(
        &self,
        fft: &dyn Fft<f64>,
        work: &'a mut Vec<Complex64>,
    ) -> (&'a mut [Complex64], &'a mut [Complex64]) {
        work.clear();
        work.resize(fft.len() + fft.get_inplace_scratch_len(), Complex64::ZERO);
        work.split_at_mut(fft.len())
    }
}

/// The edges of a raster, `[x_min, x_max, y_min, y_max]`.
fn edges(target: &Raster) -> [f64; 4] {
    let end = |a: usize| target.start[a] + (target.size[a] as f64 - 1.0) * target.pitch[a];
    [target.start[0], end(0), target.start[1], end(1)]
}

/// The plan of a hop from an area `[x_min, x_max, y_min, y_max]`, on a lattice whose period is a whole number of
/// pixels.
fn lattice(free: &FreeHop, from: [f64; 4], target: &Raster, pitch: [f64; 2]) -> FreePlan {
    let mut plan = free.plan(from, edges(target));
    let axes = plan.bands.iter_mut().zip(plan.period).zip(pitch);
    for ((band, period), pitch) in axes {
        let limit = -band.at(0);
        let pixels = quick_length((period / pitch).ceil() as usize);
        let spacing = plan.wavelength / (pixels as f64 * pitch);
        *band = Band::between(0.0, spacing, -limit, limit);
    }
    plan
}

/// The factor of each plane wave on the way to the plane, [x, y], with the spectrum of a pixel's box and the phase of
/// the first pixel's place. Then the least normal cosine of the waves that count.
fn transfer(
    free: &FreeHop,
    plan: &FreePlan,
    start: [f64; 2],
    pitch: [f64; 2],
) -> (Array2<Complex64>, f64) {
    let [band_x, band_y] = &plan.bands;
    let area = |a: usize| pitch[a] * plan.bands[a].spacing / plan.wavelength;
    let scale = area(0) * area(1);
    let direction = |i: usize, j: usize| [band_x.at(i), band_y.at(j)];
    let mut transfer = Array2::zeros((band_x.count, band_y.count));
    let slabs = SlabTransfer::new(&free.slabs, plan);
    Zip::indexed(transfer.rows_mut()).par_for_each(|i, mut row| {
        for (j, value) in row.iter_mut().enumerate() {
            let [x, y] = direction(i, j);
            let boxes = sinc(pitch[0] * x / plan.wavelength) * sinc(pitch[1] * y / plan.wavelength);
            *value = Complex64::from_polar(scale * boxes, -free.k * (x * start[0] + y * start[1]));
        }
        slabs.apply(row, |j| direction(i, j));
    });
    let mut least = 1.0f64;
    for ((i, j), value) in transfer.indexed_iter() {
        let [px, py] = direction(i, j);
        if value.norm() > FAINT * scale {
            least = least.min((1.0 - px * px - py * py).max(0.0).sqrt());
        }
    }
    (transfer, least)
}

/// The levels for light with these normal cosines, and what each holds of the light behind the pixels.
fn levelled(
    share: &Array2<Complex64>,
    heights: &Heights,
    cosines: [f64; 2],
    k: f64,
) -> (Stack, Vec<Array2<Complex64>>) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (z, share) in heights.z.iter().zip(share) {
        if *share != Complex64::ZERO {
            (low, high) = (low.min(*z), high.max(*z));
        }
    }
    let stack = Stack::within(LEVEL_TOLERANCE, [low, high], cosines, k);
    let part = |number: usize| {
        Zip::from(share)
            .and(&heights.z)
            .par_map_collect(|share, z| stack.part(*share, *z, number))
    };
    let held = (0..stack.len()).map(part).collect();
    (stack, held)
}

/// The light behind each pixel of value one, times what its tilt does to it towards the middle of the target.
fn tilted(
    arrived: &Field,
    heights: &Heights,
    plane: TargetPlane,
    wavelength: f64,
) -> Array2<Complex64> {
    let TargetPlane { distance, target } = plane;
    let grid = &arrived.grid;
    let [x0, x1, y0, y1] = edges(target);
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    let mut share = arrived.values.clone();
    Zip::indexed(&mut share).par_for_each(|(j, i), value| {
        let slope = [0, 1].map(|a| heights.slope[a][[j, i]]);
        let way = [
            middle[0] - grid.x.node(i),
            middle[1] - grid.y.node(j),
            distance - heights.z[[j, i]],
        ];
        let length = way.iter().map(|w| w * w).sum::<f64>().sqrt();
        let [px, py, q] = way.map(|w| w / length);
        *value *= (q - slope[0] * px - slope[1] * py) / q;
        // Light that arrives along the axis turns its phase by the slope too.
        for (p, slope, pitch) in [(px, slope[0], grid.x.pitch), (py, slope[1], grid.y.pitch)] {
            let cells = pitch / wavelength;
            *value *= sinc(cells * (p + (1.0 + q) * slope)) / sinc(cells * p);
        }
    });
    share
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::open_screen;
    use crate::optics::conic::Conic;
    use crate::optics::frame::Frame;
    use crate::optics::freeform::Term;
    use crate::optics::screen::Screen;
    use crate::optics::shape::Shape;
    use crate::wave::free::pixel_hop::{PixelHop, TargetPlane};
    use crate::wave::free::rayleigh::Emitters;
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;
    use crate::wave::grid::metrics::shape_error;
    use crate::wave::grid::raster::Raster;

    const PIXELS: usize = 41;

    /// A bump of two wavelengths, as steep as one of a tenth.
    fn mirror() -> Screen {
        let base = Conic {
            curvature: 0.0,
            conic: 0.0,
        };
        let bump = Term::Gaussian {
            height: 2.0,
            centre: [1.0, -0.5],
            sigma: 13.0,
        };
        Screen {
            shape: Shape::Freeform {
                base,
                terms: vec![bump],
            },
            arrives: -1.0,
            ..open_screen(Frame::GLOBAL)
        }
    }

    /// Light that came along −z, on so many nodes of each pixel of half a wavelength.
    fn arrived(screen: &Screen, nodes: usize) -> Field {
        let axis = Axis::gauss(PIXELS, 0.5, 0.0, nodes);
        let grid = Grid {
            x: axis.clone(),
            y: axis,
        };
        let z = Heights::on(screen, &grid).z;
        Field {
            values: z.mapv(|z| Complex64::cis(-std::f64::consts::TAU * z)),
            grid,
        }
    }

    const TARGET: Raster = Raster {
        start: [-7.0, -6.0],
        pitch: [1.0, 1.5],
        size: [15, 9],
    };

    #[test]
    fn carry_dot_product() {
        let screen = mirror();
        let mut light = arrived(&screen, 1);
        light.values.row_mut(4).fill(0.0.into());
        let plane = TargetPlane {
            distance: 25.0,
            target: &TARGET,
        };
        let hop = PixelHop::new(&screen, &light, plane, 1.0);
        let (values, bar) = (noise((PIXELS, PIXELS), 1), noise((9, 15), 2));
        let there = hop.carry(values.view());
        let back = hop.carry_adjoint(bar.view());
        assert_transposed(&[(&bar, &there)], &[(&back, &values)]);
    }

    /// Pixels that send light to the target, and to one point of it, against the direct integral with many nodes a
    /// pixel: no factor is fitted to the field.
    #[test]
    fn as_the_direct_integral_but_for_the_tilt_of_pixels() {
        let (screen, distance) = (mirror(), 25.0);
        let light = arrived(&screen, 1);
        let plane = TargetPlane {
            distance,
            target: &TARGET,
        };
        let hop = PixelHop::new(&screen, &light, plane, 1.0);
        let fine = arrived(&screen, 4);
        let heights = Heights::on(&screen, &fine.grid);
        let points: Vec<[f64; 3]> = (0..9 * 15)
            .map(|n| {
                let [i, j] = [n % 15, n / 15];
                [i as f64 - 7.0, 1.5 * j as f64 - 6.0, distance]
            })
            .collect();
        let smooth = Array2::from_shape_fn((9, 15), |(j, i)| {
            Complex64::cis(0.1 * (i as f64 - 7.0).powi(2) + 0.2 * (j as f64 - 4.0).powi(2))
        });
        let mut point = Array2::zeros((9, 15));
        point[[5, 3]] = Complex64::ONE;
        for target in [smooth, point] {
            let values = hop
                .carry_adjoint(target.view())
                .mapv(|u| Complex64::cis(u.arg()));
            let mut behind = fine.clone();
            for ((j, i), value) in behind.values.indexed_iter_mut() {
                *value *= values[[j / 4, i / 4]];
            }
            let exact = Emitters::new(&behind, &heights).field_at(&points, 1.0);
            let exact = Array2::from_shape_vec((9, 15), exact).unwrap();
            let found = hop.carry(values.view());
            let size: f64 = exact.iter().map(|u| u.norm_sqr()).sum();
            let off: f64 = (&found - &exact).iter().map(|u| u.norm_sqr()).sum();
            let error = (off / size).sqrt();
            let shape = shape_error(found.view(), exact.view()).unwrap().error;
            assert!(error < 0.08 && shape < 0.05, "{error:e} {shape:e}");
        }
    }
}
