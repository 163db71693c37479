//! A hard disc: quadrature weights on a square grid, and its Fourier transform.

use ndarray::Array2;

use crate::numerics::quadrature::gauss_legendre;

/// Gauss nodes per row of cells for the chords of a disc.
const CHORDS_PER_ROW: usize = 16;

/// Weights w_j (in units of a cell's area) on the grid x_j = h·j, |j| ≤ `half`, such that
/// Σ_j w_j g(x_j) is the integral over the disc of radius `radius` (in units of h) of the local
/// polynomial interpolant of g through `stencil` points per axis.
///
/// `stencil` = 1 gives the area of each cell that the disc covers; 6 (quintic) takes the hard
/// edge to high order. The grid must reach `stencil`/2 points beyond the disc.
pub fn disc_weights(radius: f64, half: usize, stencil: usize) -> Array2<f64> {
    let axis = Interpolation::new(half, stencil);
    let mut weights = Array2::zeros((2 * half + 1, 2 * half + 1));
    for cell in axis.cells() {
        // The part of this row of cells inside the disc, in the angle of y = a sin θ.
        let (low, high) = axis.edges(cell);
        let (low, high) = (
            (low / radius).clamp(-1.0, 1.0).asin(),
            (high / radius).clamp(-1.0, 1.0).asin(),
        );
        if high <= low {
            continue;
        }
        for (node, weight) in gauss_legendre(CHORDS_PER_ROW) {
            // The chord at this height, spread to the columns and to the rows of the stencil.
            let theta = 0.5 * (low + high) + 0.5 * (high - low) * node;
            let chord = axis.integral(radius * theta.cos());
            let area = 0.5 * (high - low) * weight * radius * theta.cos();
            for (row, share) in axis.spread(cell, radius * theta.sin()) {
                for (column, length) in chord.iter().enumerate() {
                    weights[[row, column]] += area * share * length;
                }
            }
        }
    }
    weights
}

/// Piecewise polynomial interpolation along one axis of the grid.
struct Interpolation {
    half: usize,
    stencil: usize,
    /// Integral of the weights over a whole cell.
    whole: Vec<f64>,
}

impl Interpolation {
    fn new(half: usize, stencil: usize) -> Self {
        let mut axis = Self {
            half,
            stencil,
            whole: Vec::new(),
        };
        let (low, high) = axis.edges(half);
        axis.whole = axis.part(half, low, high);
        axis
    }

    /// Cells whose whole stencil lies on the grid, by the index of their lower (or middle) point.
    fn cells(&self) -> std::ops::Range<usize> {
        (self.stencil - 1) / 2..2 * self.half + 1 - self.stencil / 2
    }

    /// Bounds of a cell: between two points for even stencils, about one for odd.
    fn edges(&self, cell: usize) -> (f64, f64) {
        let low = cell as f64 - self.half as f64 - 0.5 * (self.stencil % 2) as f64;
        (low, low + 1.0)
    }

    /// Grid indices and Lagrange weights for a position in `cell`.
    fn spread(&self, cell: usize, position: f64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let first = cell - (self.stencil - 1) / 2;
        let at = position + self.half as f64 - first as f64;
        (0..self.stencil).map(move |i| {
            let others = (0..self.stencil).filter(|&j| j != i);
            let weight = others
                .map(|j| (at - j as f64) / (i as f64 - j as f64))
                .product();
            (first + i, weight)
        })
    }

    /// Integral of the weights from `low` to `high` within `cell`, on its stencil.
    fn part(&self, cell: usize, low: f64, high: f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.stencil];
        for (node, weight) in gauss_legendre(self.stencil / 2 + 1) {
            let position = 0.5 * (low + high) + 0.5 * (high - low) * node;
            for (sum, (_, share)) in sums.iter_mut().zip(self.spread(cell, position)) {
                *sum += 0.5 * (high - low) * weight * share;
            }
        }
        sums
    }

    /// Weights on the whole axis that integrate the interpolant over [−`reach`, `reach`].
    fn integral(&self, reach: f64) -> Vec<f64> {
        let mut sums = vec![0.0; 2 * self.half + 1];
        for cell in self.cells() {
            let (low, high) = self.edges(cell);
            if high <= -reach || low >= reach {
                continue;
            }
            let inside = -reach <= low && high <= reach;
            let cut = (!inside).then(|| self.part(cell, low.max(-reach), high.min(reach)));
            let first = cell - (self.stencil - 1) / 2;
            for (i, share) in cut.as_ref().unwrap_or(&self.whole).iter().enumerate() {
                sums[first + i] += share;
            }
        }
        sums
    }
}

/// Integral of exp(i u·x) over the disc of radius `radius`, for |u| = `frequency` (radians per
/// length): 2πa²·J₁(ua)/(ua).
pub fn disc_transform(radius: f64, frequency: f64) -> f64 {
    let argument = radius * frequency;
    let jinc = if argument < 1e-4 {
        0.5 - argument * argument / 16.0
    } else {
        libm::j1(argument) / argument
    };
    std::f64::consts::TAU * radius * radius * jinc
}

#[cfg(test)]
mod tests {
    use crate::numerics::disc::{disc_transform, disc_weights};

    /// Largest error of the disc's transform by its weights, relative to the area.
    fn error(stencil: usize, radius: f64, frequency: f64) -> f64 {
        let half = radius.ceil() as usize + 5;
        let weights = disc_weights(radius, half, stencil);
        let mut sum = 0.0;
        for ((row, column), weight) in weights.indexed_iter() {
            let (y, x) = (row as f64 - half as f64, column as f64 - half as f64);
            sum += weight * (frequency * (0.6 * x + 0.8 * y)).cos();
        }
        let area = std::f64::consts::PI * radius * radius;
        ((sum - disc_transform(radius, frequency)) / area).abs()
    }

    #[test]
    fn weights_integrate_the_disc_to_high_order() {
        // Frequency 1 radian per sample is p = 0.5 at a pitch of a third of a wavelength.
        for (stencil, bound) in [(1, 3.3e-4), (4, 6e-5), (6, 7e-6), (8, 9e-7)] {
            let worst = [0.0, 0.3, 0.62, 1.0]
                .map(|u| error(stencil, 31.3, u))
                .into_iter()
                .fold(0.0, f64::max);
            assert!(worst < bound, "{stencil}: {worst:e}");
        }
    }
}
