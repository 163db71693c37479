//! The nodes, cells and plane waves of Fourier sums along one axis of a window.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::wave::grid::field::Axis;

/// What the part of a cell that a node stands for does to the spectrum of what the nodes represent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum CellFilter {
    /// Nodes hold values of a smooth function.
    #[default]
    Points,
    /// Neighbours in pairs are the two Gauss nodes of a part over which the element is constant: the product with light that is
    /// linear there is integrated exactly.
    Pairs,
}

/// The factor of a plane wave `dp` beside the carrier, at one of the two Gauss nodes of a part of this width: −1 or +1 by the
/// side.
fn of_part(dp: f64, k: f64, width: f64, side: f64) -> Complex64 {
    // ½∫(1 ± √3ξ)·exp(−ixξ) dξ over [−1, 1], beside the plane wave at the node itself.
    let half = 0.5 * k * width * dp;
    let [even, odd] = bessel(half);
    let linear = Complex64::new(even, -3f64.sqrt() * side * odd);
    linear * Complex64::cis(half * side / 3f64.sqrt())
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
pub(crate) struct Modes {
    /// Index m of the first.
    pub first: i64,
    /// Number of plane waves.
    pub count: usize,
    /// Distance λ/P of neighbours, as optical direction cosine.
    pub spacing: f64,
    /// Direction of m = 0 beside the carrier about which the nodes' values are written.
    pub shift: f64,
}

impl Modes {
    /// Those with Δp in [low, high].
    pub(crate) fn between(low: f64, high: f64, spacing: f64, shift: f64) -> Self {
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
    pub(crate) fn at(&self, index: usize) -> f64 {
        (self.first + index as i64) as f64 * self.spacing
    }
}

/// What the sums along one axis are about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FourierAxis<'a> {
    /// All nodes of the tile.
    pub axis: &'a Axis,
    /// Those under the window.
    pub range: (usize, usize),
    /// What a cell does.
    pub filter: CellFilter,
    /// The window's centre in mm.
    pub centre: f64,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// The plane waves.
    pub modes: &'a Modes,
}

impl FourierAxis<'_> {
    /// The period of the plane waves in mm.
    pub(crate) fn period(&self) -> f64 {
        TAU / (self.k * self.modes.spacing)
    }

    /// Nodes under the window.
    pub(crate) fn nodes(&self) -> usize {
        self.range.1 - self.range.0
    }

    /// How far a node is from the window's centre, in mm.
    pub(crate) fn offset(&self, node: usize) -> f64 {
        self.axis.node(node) - self.centre
    }

    /// The part of the period that a node stands for.
    pub(crate) fn weight(&self, node: usize) -> f64 {
        self.axis.weight(node) / self.period()
    }

    /// What the part about a node does to each plane wave.
    pub(crate) fn cell_factors(&self, node: usize) -> Vec<Complex64> {
        let waves = (0..self.modes.count).map(|m| self.modes.at(m));
        match self.filter {
            CellFilter::Points => vec![Complex64::ONE; self.modes.count],
            CellFilter::Pairs => {
                let width = 2.0 * self.axis.weight(node);
                let side = if node.is_multiple_of(2) { -1.0 } else { 1.0 };
                { waves }
                    .map(|dp| of_part(dp, self.k, width, side))
                    .collect()
            }
        }
    }
}
