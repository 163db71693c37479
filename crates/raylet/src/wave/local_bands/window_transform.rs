//! From the samples under one window to its plane waves, and back.
//!
//! The light under a window, divided by its carrier, is compact and has a narrow band: a sum of sinc functions brings
//! it from its few samples to the nodes at which the element is known. There it is multiplied by the transmission, and
//! Fourier sums give the plane waves exp(ikΔpₘ·u) beside the carrier that goes on, Δpₘ = m·λ/P. Both steps are products
//! of small matrices along x and y.

use std::cell::RefCell;
use std::ops::Range;

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;
use raylet_fft::Planner;
use raylet_matrix::{product, product_of_three};

use crate::math::part::{blocks, part};
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::folded_fourier::{FoldedFourier, FoldedFourier2};
use crate::wave::local_bands::fourier_axis::{CellFilter, FourierAxis, Modes};
use crate::wave::local_bands::fourier_matrix::fourier_matrix;

/// The nodes of an element along one axis, and what they represent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeLine<'a> {
    /// All nodes of the tile.
    pub axis: &'a Axis,
    /// Those under the window.
    pub range: (usize, usize),
    /// What a cell does.
    pub filter: CellFilter,
}

/// The samples under a window along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleLine<'a> {
    /// All samples of the tile.
    pub axis: &'a Axis,
    /// Those under the window.
    pub range: (usize, usize),
    /// The window's centre in mm.
    pub centre: f64,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
}

/// How much faster products of matrices run than fast transforms, for each of their operations.
const MATRIX_SPEED: f64 = 4.0;

/// From the samples of the light to nodes along one axis, and back. The map is real.
struct Interpolation {
    x: Array2<f64>,
    y: Array2<f64>,
}

/// The sum of sinc functions that continues samples to places, a row for each: sin(πt)/π(t − n) has one sine for each place.
pub(crate) fn interpolation(
    samples: &SampleLine,
    places: impl ExactSizeIterator<Item = f64>,
) -> Array2<f64> {
    let (low, high) = samples.range;
    let pitch = samples.axis.pitch;
    let first = samples.axis.node(low);
    let mut matrix = Array2::zeros((places.len(), high - low));
    for (mut row, place) in matrix.rows_mut().into_iter().zip(places) {
        let t = (place - first) / pitch;
        let sine = (std::f64::consts::PI * (t - t.round())).sin() / std::f64::consts::PI;
        for (n, value) in row.iter_mut().enumerate() {
            let away = t - n as f64;
            let odd = (t.round() as i64 - n as i64).rem_euclid(2) == 1;
            *value = match (away.abs() < 1e-9, odd) {
                (true, _) => 1.0,
                (false, true) => -sine / away,
                (false, false) => sine / away,
            };
        }
    }
    matrix
}

impl Interpolation {
    /// The light at the nodes of some rows, from that at the samples, whose real and imaginary `parts` stand side by side, times
    /// the transmission there.
    fn apply(
        &self,
        parts: &Array2<f64>,
        transmission: Option<ArrayView2<Complex64>>,
        rows: Range<usize>,
    ) -> Array2<Complex64> {
        let (samples, count) = (self.x.ncols(), rows.len());
        let along_y = product(part(self.y.view(), rows, ..), parts.view());
        let half = |first: usize| {
            let half = part(along_y.view(), 0..count, first..first + samples);
            product(half, self.x.t())
        };
        let (re, im) = (half(0), half(samples));
        match transmission {
            Some(transmission) => Zip::from(&re)
                .and(&im)
                .and(transmission)
                .map_collect(|re, im, t| Complex64::new(*re, *im) * t),
            None => combined(&re, &im),
        }
    }

    /// The transpose.
    fn apply_adjoint(&self, nodes_bar: &Array2<Complex64>) -> Array2<Complex64> {
        let along = |part: Array2<f64>| product_of_three(self.y.t(), part.view(), self.x.t());
        combined(
            &along(nodes_bar.mapv(|value| value.re)),
            &along(nodes_bar.mapv(|value| value.im)),
        )
    }
}

/// The real parts of numbers and, to the right of them, the imaginary ones.
fn side_by_side(values: &Array2<Complex64>) -> Array2<f64> {
    let (rows, columns) = values.dim();
    let mut parts = Array2::zeros((rows, 2 * columns));
    for ((j, i), value) in values.indexed_iter() {
        parts[[j, i]] = value.re;
        parts[[j, columns + i]] = value.im;
    }
    parts
}

/// Complex numbers of their parts.
fn combined(re: &Array2<f64>, im: &Array2<f64>) -> Array2<Complex64> {
    Zip::from(re)
        .and(im)
        .map_collect(|re, im| Complex64::new(*re, *im))
}

/// From nodes to plane waves.
enum Spectrum {
    /// By matrices along x and y.
    Matrices([Array2<Complex64>; 2]),
    /// By fast transforms.
    Folded(Box<FoldedFourier2>),
}

impl Spectrum {
    fn new(along: [&FourierAxis; 2]) -> Self {
        let folded = PLANNER.with_borrow_mut(|planner| {
            let [x, y] = along.map(|along| FoldedFourier::new(along, planner));
            x.zip(y).map(|(x, y)| FoldedFourier2 { x, y })
        });
        let [x, y] = along.map(|along| [along.nodes() as f64, along.modes.count as f64]);
        let products = 8.0 * y[1] * x[0] * (y[0] + x[1]);
        match folded {
            Some(folded) if folded.operations() * MATRIX_SPEED < products => {
                Self::Folded(Box::new(folded))
            }
            _ => Self::Matrices(along.map(fourier_matrix)),
        }
    }

    /// The plane waves [m_y, m_x] of `light`, which gives that at the nodes [y, x] of some rows.
    fn apply(&self, light: impl Fn(Range<usize>) -> Array2<Complex64>) -> Array2<Complex64> {
        match self {
            Self::Matrices([x, y]) => {
                let mut waves = Array2::zeros((y.nrows(), x.nrows()));
                for rows in blocks(y.ncols()) {
                    let here = part(y.view(), .., rows.clone());
                    waves += &product_of_three(here, light(rows).view(), x.view());
                }
                waves
            }
            Self::Folded(folded) => folded.apply(light),
        }
    }

    /// The conjugate transpose.
    fn apply_adjoint(&self, waves_bar: &Array2<Complex64>) -> Array2<Complex64> {
        match self {
            Self::Matrices([x, y]) => {
                let bar = conjugate(waves_bar);
                conjugate(&product_of_three(y.t(), bar.view(), x.t()))
            }
            Self::Folded(folded) => folded.apply_adjoint(waves_bar),
        }
    }
}

thread_local! {
    /// Fast transforms of the lengths that a thread has met.
    static PLANNER: RefCell<Planner> = RefCell::new(Planner::new());
}

/// The linear map from the samples under one window, indexed [y, x], to its plane waves, indexed [m_y, m_x].
pub(crate) struct WindowTransform {
    /// From samples to nodes; nothing where the samples are the nodes.
    to_nodes: Option<Interpolation>,
    spectrum: Spectrum,
}

impl WindowTransform {
    /// Plans it; without `nodes` the samples themselves are the nodes.
    pub(crate) fn new(
        samples: [&SampleLine; 2],
        nodes: Option<[&NodeLine; 2]>,
        modes: [&Modes; 2],
    ) -> Self {
        let along = [0, 1].map(|a| {
            let (axis, range, filter) = match nodes {
                Some(nodes) => (nodes[a].axis, nodes[a].range, nodes[a].filter),
                None => (samples[a].axis, samples[a].range, CellFilter::Points),
            };
            FourierAxis {
                axis,
                range,
                filter,
                centre: samples[a].centre,
                k: samples[a].k,
                modes: modes[a],
            }
        });
        Self {
            to_nodes: nodes.map(|nodes| {
                let along = |a: usize| {
                    let (low, high) = nodes[a].range;
                    let places = (low..high).map(|node| nodes[a].axis.node(node));
                    interpolation(samples[a], places)
                };
                let [x, y] = [0, 1].map(along);
                Interpolation { x, y }
            }),
            spectrum: Spectrum::new([&along[0], &along[1]]),
        }
    }

    /// The light at the nodes of rows times the transmission there, which is one where there is none.
    fn light<'a>(
        &'a self,
        samples: &'a Array2<Complex64>,
        transmission: Option<ArrayView2<'a, Complex64>>,
    ) -> impl Fn(Range<usize>) -> Array2<Complex64> + 'a {
        let parts = (self.to_nodes.as_ref()).map(|to_nodes| (to_nodes, side_by_side(samples)));
        move |rows| {
            let here = transmission.map(|all| part(all, rows.clone(), ..));
            match (&parts, here) {
                (Some((to_nodes, parts)), here) => to_nodes.apply(parts, here, rows),
                (None, Some(here)) => &part(samples.view(), rows, ..) * &here,
                (None, None) => part(samples.view(), rows, ..).to_owned(),
            }
        }
    }

    /// The plane waves of the light times the transmission at the nodes, which is one where there is none.
    pub(crate) fn apply(
        &self,
        samples: &Array2<Complex64>,
        transmission: Option<ArrayView2<Complex64>>,
    ) -> Array2<Complex64> {
        self.spectrum.apply(self.light(samples, transmission))
    }

    /// The conjugate transpose: the cotangents of the samples, and of the transmission.
    pub(crate) fn apply_adjoint(
        &self,
        samples: &Array2<Complex64>,
        transmission: Option<ArrayView2<Complex64>>,
        waves_bar: &Array2<Complex64>,
    ) -> (Array2<Complex64>, Array2<Complex64>) {
        // waves = spectrum of light·t
        let after_bar = self.spectrum.apply_adjoint(waves_bar);
        let light = self.light(samples, None)(0..after_bar.nrows());
        let transmission_bar = conjugate(&light) * &after_bar;
        let mut light_bar = after_bar;
        if let Some(transmission) = transmission {
            light_bar *= &transmission.mapv(|value| value.conj());
        }
        let samples_bar = match &self.to_nodes {
            Some(to_nodes) => to_nodes.apply_adjoint(&light_bar),
            None => light_bar,
        };
        (samples_bar, transmission_bar)
    }
}

fn conjugate(array: &Array2<Complex64>) -> Array2<Complex64> {
    array.mapv(|value| value.conj())
}

/// The nodes of an axis within [low, high].
pub(crate) fn nodes_within(axis: &Axis, low: f64, high: f64) -> (usize, usize) {
    let Range { start, end } = axis.below(low)..axis.below(high);
    (start, end.max(start))
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::fourier_axis::{CellFilter, Modes};
    use crate::wave::local_bands::window_transform::{
        NodeLine, SampleLine, WindowTransform, nodes_within,
    };

    const K: f64 = 6.0;

    fn samples(axis: &Axis) -> SampleLine<'_> {
        SampleLine {
            axis,
            range: (2, 31),
            centre: 0.4,
            k: K,
        }
    }

    #[test]
    fn window_transform_dot_product() {
        let (coarse, fine) = (Axis::uniform(33, 0.5, 0.0), Axis::gauss(80, 0.17, 0.1, 2));
        let lines = NodeLine {
            axis: &fine,
            range: nodes_within(&fine, -5.0, 6.0),
            filter: CellFilter::Pairs,
        };
        let modes = Modes::between(-0.9, 1.3, 0.11, 0.05);
        let line = samples(&coarse);
        let values = noise((29, 29), 0);
        for nodes in [None, Some([&lines, &lines])] {
            let transform = WindowTransform::new([&line; 2], nodes, [&modes; 2]);
            let count = nodes.map_or(29, |_| lines.range.1 - lines.range.0);
            let through = noise((count, count), 1);
            let there = transform.apply(&values, Some(through.view()));
            let bar = noise(there.dim(), 2);
            let (back, through_bar) = transform.apply_adjoint(&values, Some(through.view()), &bar);
            assert_transposed(&[(&bar, &there)], &[(&back, &values)]);
            assert_transposed(&[(&bar, &there)], &[(&through_bar, &through)]);
        }
    }

    /// Two nodes a pixel agree with a fine sum over pixels of random transmission, a third of a window wide, in directions
    /// in which a pixel has 1.5 rad to each side; without their pixel's own spectrum they do not.
    #[test]
    fn box_pixels_are_integrated_with_the_light_in_them() {
        let (sigma, width): (f64, f64) = (1.2, 0.2);
        let coarse = Axis::uniform(33, 0.5, 0.4);
        let line = SampleLine {
            axis: &coarse,
            range: (0, 33),
            centre: 0.4,
            k: K,
        };
        let modes = Modes::between(-2.5, 2.5, 0.11, 0.0);
        let pixels = noise((1, 70), 4);
        let light = |u: f64| (-0.5 * (u - 0.4f64).powi(2) / (sigma * sigma)).exp();
        let values = Array2::from_shape_fn((33, 33), |(j, i)| {
            Complex64::from(light(coarse.node(i)) * light(coarse.node(j)))
        });
        let spectrum = |nodes: usize, cells: usize, filter: CellFilter| {
            let axis = Axis::gauss(70 * cells, width / cells as f64, 0.4, nodes);
            let lines = NodeLine {
                axis: &axis,
                range: (0, axis.len()),
                filter,
            };
            let each = nodes * cells;
            let through = Array2::from_shape_fn((axis.len(), axis.len()), |(j, i)| {
                pixels[[0, i / each]] * pixels[[0, j / each]]
            });
            let transform = WindowTransform::new([&line; 2], Some([&lines; 2]), [&modes; 2]);
            transform.apply(&values, Some(through.view()))
        };
        let exact = spectrum(6, 1, CellFilter::Points);
        let norm = |a: &Array2<Complex64>| a.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let error = |filter| {
            let found = spectrum(2, 1, filter);
            norm(&(found - &exact)) / norm(&exact)
        };
        let (pairs, points) = (error(CellFilter::Pairs), error(CellFilter::Points));
        assert!(pairs < 1e-3 && points > 5e-3, "{pairs:e} {points:e}");
    }

    /// A Gaussian that is brought to other nodes has its own spectrum.
    #[test]
    fn interpolated_light_keeps_its_spectrum() {
        let sigma: f64 = 1.2;
        let (coarse, fine) = (Axis::uniform(33, 0.5, 0.4), Axis::uniform(400, 0.07, 0.1));
        let line = SampleLine {
            axis: &coarse,
            range: (0, 33),
            centre: 0.4,
            k: K,
        };
        let nodes = NodeLine {
            axis: &fine,
            range: (0, 400),
            filter: CellFilter::Points,
        };
        let modes = Modes::between(-0.5, 0.5, 0.11, 0.02);
        let window = |i: usize| {
            let u = coarse.node(i) - 0.4;
            (-0.5 * u * u / (sigma * sigma)).exp()
        };
        let values =
            Array2::from_shape_fn((33, 33), |(j, i)| Complex64::from(window(i) * window(j)));
        let transform = WindowTransform::new([&line; 2], Some([&nodes; 2]), [&modes; 2]);
        let waves = transform.apply(&values, None);
        let period = std::f64::consts::TAU / (K * modes.spacing);
        let exact = |m: usize| {
            let p = modes.shift + modes.at(m);
            (-0.5 * (K * sigma * p).powi(2)).exp() * sigma * std::f64::consts::TAU.sqrt() / period
        };
        for ((my, mx), value) in waves.indexed_iter() {
            assert!((value - exact(mx) * exact(my)).norm() < 1e-6, "{mx} {my}");
        }
    }
}
