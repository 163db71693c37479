//! From the samples under one window to its plane waves, and back.
//!
//! The light under a window, divided by its carrier, is compact and has a narrow band: a sum of sinc functions brings
//! it from its few samples to the nodes at which the element is known. There it is multiplied by the transmission, and
//! Fourier sums give the plane waves exp(ikΔpₘ·u) beside the carrier that goes on, Δpₘ = m·λ/P. Both steps are products
//! of small matrices along x and y.

use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::wave::grid::field::Axis;

/// What a cell about each node does to the spectrum of what the nodes represent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CellFilter {
    /// Nodes hold values of a smooth function.
    #[default]
    Points,
    /// The element is constant over each cell of this width in mm, which has one node in its middle or two Gauss nodes:
    /// the product with light that is constant or linear in the cell is integrated exactly.
    Boxes(f64),
    /// Nodes hold means over cells of this width in mm: the sinc that this brings is divided out.
    Means(f64),
}

impl CellFilter {
    /// The factor of a plane wave `dp` beside the carrier, at a node this far from the middle of its cell.
    fn factor(self, dp: f64, k: f64, aside: f64) -> Complex64 {
        let half = |width: f64| 0.5 * k * width * dp;
        match self {
            Self::Points => Complex64::ONE,
            Self::Boxes(width) if aside == 0.0 => Complex64::from(bessel(half(width))[0]),
            Self::Boxes(width) => {
                // ½∫(1 ± √3ξ)·exp(−ixξ) dξ over [−1, 1], beside the plane wave at the node itself.
                let [even, odd] = bessel(half(width));
                let linear = Complex64::new(even, -3f64.sqrt() * aside.signum() * odd);
                linear * Complex64::cis(k * dp * aside)
            }
            Self::Means(width) => Complex64::from(1.0 / bessel(half(width))[0]),
        }
    }
}

/// The spherical Bessel functions j₀ and j₁.
fn bessel(x: f64) -> [f64; 2] {
    if x.abs() < 1e-3 {
        let square = x * x;
        return [1.0 - square / 6.0, x / 3.0 * (1.0 - 0.1 * square)];
    }
    let (sine, cosine) = x.sin_cos();
    [sine / x, (sine / x - cosine) / x]
}

/// The plane waves of a window to be computed, along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// Index m of the first.
    pub first: i64,
    /// How many.
    pub count: usize,
    /// Distance λ/P of neighbours, as optical direction cosine.
    pub spacing: f64,
    /// Direction of m = 0 beside the carrier about which the nodes' values are written.
    pub shift: f64,
}

impl Modes {
    /// Those with Δp in [low, high].
    pub fn between(low: f64, high: f64, spacing: f64, shift: f64) -> Self {
        let first = (low / spacing).ceil() as i64;
        let last = (high / spacing).floor() as i64;
        Self {
            first,
            count: (last - first + 1).max(0) as usize,
            spacing,
            shift,
        }
    }

    /// Δp of one of them.
    pub fn at(&self, index: usize) -> f64 {
        (self.first + index as i64) as f64 * self.spacing
    }
}

/// The nodes of an element along one axis, and what they represent.
#[derive(Clone, Copy, Debug)]
pub struct NodeLine<'a> {
    /// All nodes of the tile.
    pub axis: &'a Axis,
    /// Those under the window.
    pub range: (usize, usize),
    /// What a cell does.
    pub filter: CellFilter,
}

/// The samples under a window along one axis.
#[derive(Clone, Copy, Debug)]
pub struct SampleLine<'a> {
    /// All samples of the tile.
    pub axis: &'a Axis,
    /// Those under the window.
    pub range: (usize, usize),
    /// The window's centre in mm.
    pub centre: f64,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
}

/// The factors of nodes are computed anew after so many modes, before rounding adds up.
const RESTART: usize = 64;

/// The matrices along one axis.
struct Line {
    /// A row per node, a column per sample; nothing where the samples are the nodes.
    to_nodes: Option<Array2<Complex64>>,
    /// A row per mode, a column per node.
    to_modes: Array2<Complex64>,
}

impl Line {
    fn new(samples: &SampleLine, nodes: Option<&NodeLine>, modes: &Modes) -> Self {
        let (axis, range, filter) = nodes
            .map_or((samples.axis, samples.range, CellFilter::Points), |nodes| {
                (nodes.axis, nodes.range, nodes.filter)
            });
        Self {
            to_nodes: nodes.map(|nodes| interpolation(samples, nodes)),
            to_modes: fourier(samples, (axis, range), filter, modes),
        }
    }
}

/// The Fourier sum over the nodes of a range: a row per mode, a column per node. From mode to mode a node's factor turns by the
/// same phase; what a cell does to a mode is the same in each cell.
fn fourier(
    samples: &SampleLine,
    (axis, range): (&Axis, (usize, usize)),
    filter: CellFilter,
    modes: &Modes,
) -> Array2<Complex64> {
    let k = samples.k;
    let period = std::f64::consts::TAU / (k * modes.spacing);
    let factor = |node: usize| {
        let all = (0..modes.count).map(|m| filter.factor(modes.at(m), k, axis.aside(node)));
        all.collect::<Vec<Complex64>>()
    };
    let cells: Vec<Vec<Complex64>> = (0..axis.nodes_of_cell()).map(factor).collect();
    let mut matrix = Array2::zeros((modes.count, range.1 - range.0));
    for (i, mut column) in matrix.columns_mut().into_iter().enumerate() {
        let node = range.0 + i;
        let u = axis.node(node) - samples.centre;
        let step = Complex64::cis(-k * modes.spacing * u);
        let mut wave = Complex64::ZERO;
        for (m, value) in column.iter_mut().enumerate() {
            wave = match m % RESTART {
                0 => {
                    Complex64::cis(-k * (modes.shift + modes.at(m)) * u)
                        * (axis.weight(node) / period)
                }
                _ => wave * step,
            };
            *value = wave * cells[node % cells.len()][m];
        }
    }
    matrix
}

/// The sum of sinc functions that continues samples to nodes: sin(πt)/π(t − n) has one sine for each node.
fn interpolation(samples: &SampleLine, nodes: &NodeLine) -> Array2<Complex64> {
    let count = [nodes.range, samples.range].map(|(low, high)| high - low);
    let pitch = samples.axis.pitch;
    let first = samples.axis.node(samples.range.0);
    let mut matrix = Array2::zeros((count[0], count[1]));
    for (i, mut row) in matrix.rows_mut().into_iter().enumerate() {
        let t = (nodes.axis.node(nodes.range.0 + i) - first) / pitch;
        let sine = (std::f64::consts::PI * (t - t.round())).sin() / std::f64::consts::PI;
        for (n, value) in row.iter_mut().enumerate() {
            let away = t - n as f64;
            let odd = (t.round() as i64 - n as i64).rem_euclid(2) == 1;
            let size = if away.abs() < 1e-9 { 1.0 } else { sine / away };
            *value = Complex64::new(
                if odd && away.abs() >= 1e-9 {
                    -size
                } else {
                    size
                },
                0.0,
            );
        }
    }
    matrix
}

/// The linear map from the samples under one window, indexed [y, x], to its plane waves, indexed [m_y, m_x].
pub struct WindowTransform {
    x: Line,
    y: Line,
}

impl WindowTransform {
    /// Plans it; without `nodes` the samples themselves are the nodes.
    pub fn new(
        samples: [&SampleLine; 2],
        nodes: Option<[&NodeLine; 2]>,
        modes: [&Modes; 2],
    ) -> Self {
        let line = |a: usize| Line::new(samples[a], nodes.map(|nodes| nodes[a]), modes[a]);
        Self {
            x: line(0),
            y: line(1),
        }
    }

    /// The light at the nodes.
    fn at_nodes(&self, samples: &Array2<Complex64>) -> Array2<Complex64> {
        match (&self.x.to_nodes, &self.y.to_nodes) {
            (Some(x), Some(y)) => y.dot(&samples.dot(&x.t())),
            _ => samples.clone(),
        }
    }

    /// The plane waves of the light times the transmission at the nodes, which is one where there is none.
    pub fn apply(
        &self,
        samples: &Array2<Complex64>,
        transmission: Option<ArrayView2<Complex64>>,
    ) -> Array2<Complex64> {
        let mut light = self.at_nodes(samples);
        if let Some(transmission) = transmission {
            light *= &transmission;
        }
        self.y.to_modes.dot(&light).dot(&self.x.to_modes.t())
    }

    /// The conjugate transpose: the cotangents of the samples, and of the transmission.
    pub fn apply_adjoint(
        &self,
        samples: &Array2<Complex64>,
        transmission: Option<ArrayView2<Complex64>>,
        waves_bar: &Array2<Complex64>,
    ) -> (Array2<Complex64>, Array2<Complex64>) {
        // waves = Ey·(light·t)·Exᵀ
        let conjugate = |matrix: &Array2<Complex64>| matrix.mapv(|value| value.conj());
        let after_bar =
            (conjugate(&self.y.to_modes).t().dot(waves_bar)).dot(&conjugate(&self.x.to_modes));
        let transmission_bar = conjugate(&self.at_nodes(samples)) * &after_bar;
        let mut light_bar = after_bar;
        if let Some(transmission) = transmission {
            light_bar *= &transmission.mapv(|value| value.conj());
        }
        // light = Sy·samples·Sxᵀ
        let samples_bar = match (&self.x.to_nodes, &self.y.to_nodes) {
            (Some(x), Some(y)) => y.t().dot(&light_bar).dot(x),
            _ => light_bar,
        };
        (samples_bar, transmission_bar)
    }
}

/// The nodes of an axis within [low, high].
pub fn nodes_within(axis: &Axis, low: f64, high: f64) -> (usize, usize) {
    let Range { start, end } = axis.below(low)..axis.below(high);
    (start, end.max(start))
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::math::noise::{assert_transposed, noise};
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::window_transform::{
        CellFilter, Modes, NodeLine, SampleLine, WindowTransform, nodes_within,
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
        let (coarse, fine) = (Axis::uniform(33, 0.5, 0.0), Axis::uniform(80, 0.17, 0.1));
        let lines = NodeLine {
            axis: &fine,
            range: nodes_within(&fine, -5.0, 6.0),
            filter: CellFilter::Boxes(0.17),
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
    /// in which a pixel has 1.5 rad to each side; one node does not.
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
        let error = |nodes| {
            let found = spectrum(nodes, 1, CellFilter::Boxes(width));
            norm(&(found - &exact)) / norm(&exact)
        };
        assert!(error(2) < 1e-3, "{:e}", error(2));
        assert!(error(1) > 1e-2, "{:e}", error(1));
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
