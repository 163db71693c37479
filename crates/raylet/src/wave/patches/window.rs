//! Gaussian windows on a regular lattice of positions, divided by their actual coverage.
//!
//! Analysis window ĝⱼ = gⱼ / Σₗ gₗ², synthesis window gⱼ, so that Σⱼ ĝⱼ gⱼ = 1 at every node: no density
//! constant is needed and its ripple is gone. Wavelets without a window of their own are put together
//! from wⱼ = gⱼ / Σₗ gₗ instead, Σⱼ wⱼ = 1. All factors are separable, so one axis at a time.

use crate::wave::grid::field::Axis;

/// How patches are added to the field again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Synthesis {
    /// Each with its own window gⱼ: beamlets.
    Window,
    /// Each as it is: plane waves.
    Plain,
}

/// The positions of the windows along one axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Positions {
    /// First position, in mm.
    pub start: f64,
    /// Distance of neighbouring positions, in mm.
    pub step: f64,
    /// Number of positions.
    pub count: usize,
    /// Standard deviation σ of the window exp(−u²/2σ²), in mm.
    pub sigma: f64,
    /// Half the length beyond which a window is cut, in mm.
    pub reach: f64,
    /// How the coverage is divided out.
    pub synthesis: Synthesis,
}

impl Positions {
    /// Positions that cover `edges` dilated by the windows' reach, centred on it.
    pub(crate) fn covering(edges: [f64; 2], sigma: f64, step: f64, reach: f64) -> Self {
        let length = edges[1] - edges[0] + 2.0 * reach;
        // A window whose reach only touches the edge carries nothing, hence the floor.
        let count = ((length / step).floor() as usize).saturating_add(1);
        let centre = 0.5 * (edges[0] + edges[1]);
        Self {
            start: centre - 0.5 * (count as f64 - 1.0) * step,
            step,
            count,
            sigma,
            reach,
            synthesis: Synthesis::Window,
        }
    }

    /// The same positions for patches that are put together without windows.
    pub(crate) fn plain(self) -> Self {
        Self {
            synthesis: Synthesis::Plain,
            ..self
        }
    }

    /// The `index`-th position, in mm.
    pub(crate) fn at(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }

    /// The window gⱼ at x.
    fn window(&self, index: usize, x: f64) -> f64 {
        self.window_about(self.at(index), x)
    }

    fn window_about(&self, centre: f64, x: f64) -> f64 {
        let u = x - centre;
        if u.abs() > self.reach {
            return 0.0;
        }
        (-0.5 * u * u / (self.sigma * self.sigma)).exp()
    }

    /// Σₗ gₗ(x)², or Σₗ gₗ(x) for patches put together without windows; over all windows of a lattice that goes on for ever,
    /// so that ĝ falls outwards under the last ones as well.
    fn coverage(&self, x: f64) -> f64 {
        let first = ((x - self.reach - self.start) / self.step).ceil() as i64;
        let last = ((x + self.reach - self.start) / self.step).floor() as i64;
        let power = match self.synthesis {
            Synthesis::Window => 2,
            Synthesis::Plain => 1,
        };
        let at = |l: i64| self.start + l as f64 * self.step;
        (first..=last)
            .map(|l| self.window_about(at(l), x).powi(power))
            .sum()
    }

    /// The nodes inside the `index`-th window as a range, and ĝⱼ (or wⱼ) times the node's length at each.
    pub(crate) fn analysis(&self, axis: &Axis, index: usize) -> (std::ops::Range<usize>, Vec<f64>) {
        let centre = self.at(index);
        let q = axis.offsets.len();
        let cell = |x: f64| ((x - axis.start) / axis.pitch + 0.5).floor();
        let first = cell(centre - self.reach).max(0.0) as usize * q;
        let last = (cell(centre + self.reach) + 1.0).clamp(0.0, axis.cells as f64) as usize * q;
        let range = first.min(last)..last;
        let weights = range
            .clone()
            .map(|i| {
                let x = axis.node(i);
                let window = self.window(index, x);
                if window == 0.0 {
                    return 0.0;
                }
                window * axis.weight(i) / self.coverage(x)
            })
            .collect();
        (range, weights)
    }
}

#[cfg(test)]
mod tests {
    use crate::wave::grid::field::Axis;
    use crate::wave::patches::window::Positions;

    #[test]
    fn analysis_times_synthesis_sums_to_one() {
        let axis = Axis::uniform(101, 0.1, 0.7);
        let positions = Positions::covering(axis.edges(), 0.5, 0.75, 1.5);
        let mut sum = vec![0.0; axis.len()];
        for j in 0..positions.count {
            let (range, weights) = positions.analysis(&axis, j);
            for (i, w) in range.zip(weights) {
                let u = (axis.node(i) - positions.at(j)) / 0.5;
                sum[i] += w / 0.1 * (-0.5 * u * u).exp();
            }
        }
        for total in sum {
            assert!((total - 1.0).abs() < 1e-14);
        }
    }

    /// Under the last window, beyond the edge, no other one adds to the coverage; divided by what it has there alone, it would grow
    /// outwards as the inverse of a Gaussian.
    #[test]
    fn the_last_window_falls_outwards() {
        let axis = Axis::uniform(400, 0.05, 0.0);
        let positions = Positions::covering([-4.0, 4.0], 0.5, 0.625, 2.15);
        let last = positions.count - 1;
        let (range, weights) = positions.analysis(&axis, last);
        let of = |sigmas: f64| {
            let near = |i: usize| (axis.node(i) - positions.at(last) - 0.5 * sigmas).abs();
            let all = range.clone().zip(&weights);
            let nearest = all.min_by(|a, b| near(a.0).total_cmp(&near(b.0)));
            *nearest.unwrap().1
        };
        assert!(of(4.0) < 1e-2 * of(0.0), "{} {}", of(4.0), of(0.0));
    }

    #[test]
    fn plain_windows_sum_to_one() {
        let axis = Axis::gauss(40, 0.25, -0.2, 2);
        let positions = Positions::covering(axis.edges(), 0.5, 0.45, 2.2).plain();
        let mut sum = vec![0.0; axis.len()];
        for j in 0..positions.count {
            let (range, weights) = positions.analysis(&axis, j);
            for (i, w) in range.zip(weights) {
                sum[i] += w / axis.weight(i);
            }
        }
        for total in sum {
            assert!((total - 1.0).abs() < 1e-14);
        }
    }
}
