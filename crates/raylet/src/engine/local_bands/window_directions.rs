//! Which directions lead from a window to the target.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::target::TargetRegion;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;

/// Steps of the search for the ray that lands on the target.
const STEPS: usize = 4;

/// The linear map of directions to places is trusted to this factor.
const SAFETY: f64 = 1.15;

/// A way from windows of a screen to a target: one hop, or several with smooth elements between them.
pub(crate) trait RayWay {
    /// Where a ray lands, and ∂s/∂p, rows by s; nothing when it is lost.
    fn land(&self, at: [f64; 2], p: [f64; 2]) -> Option<([f64; 2], [[f64; 2]; 2])>;

    /// The beamlet of a window in the direction Δp beside its carrier, where it lands; nothing when its ray is lost.
    fn carry(&self, start: &ChirpedStart, dp: [f64; 2]) -> Option<Arrival>;

    /// Vacuum wavenumber, and the index of the medium behind the first screen.
    fn medium(&self) -> (f64, f64);
}

impl RayWay for Hop<'_> {
    fn land(&self, at: [f64; 2], p: [f64; 2]) -> Option<([f64; 2], [[f64; 2]; 2])> {
        let (landing, j) = self.jacobian_along(at, p).ok()?;
        Some((landing.at, [[j[0][2], j[0][3]], [j[1][2], j[1][3]]]))
    }

    fn carry(&self, start: &ChirpedStart, dp: [f64; 2]) -> Option<Arrival> {
        start.launch(self, dp).ok()
    }

    fn medium(&self) -> (f64, f64) {
        (self.wavenumber(), self.from.index_behind())
    }
}

/// A ray from a window with what a change of its direction does to where it lands.
struct LandedDirection {
    p: [f64; 2],
    landing: [f64; 2],
    /// ∂s/∂p, rows by s.
    slope: [[f64; 2]; 2],
}

impl LandedDirection {
    fn new(way: &impl RayWay, at: [f64; 2], p: [f64; 2]) -> Option<Self> {
        let (landing, slope) = way.land(at, p)?;
        Some(Self { p, landing, slope })
    }

    /// The change of direction that moves the landing by `gap`; nothing at an image of the window.
    fn change(&self, gap: [f64; 2]) -> Option<[f64; 2]> {
        let [[a, b], [c, d]] = self.slope;
        let determinant = a * d - b * c;
        let change = [
            (d * gap[0] - b * gap[1]) / determinant,
            (a * gap[1] - c * gap[0]) / determinant,
        ];
        change.iter().all(|p| p.is_finite()).then_some(change)
    }
}

/// Directions from a window whose beamlets may meet the target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WindowDirections {
    /// Their box beside the window's carrier, `[x_low, x_high, y_low, y_high]`.
    pub bounds: [f64; 4],
    /// The part of its sides, about their middle, that leads to the target itself; the rest falls beside it.
    pub landing: [f64; 2],
}

/// The directions from a window whose beamlets may meet the target; nothing when no ray gets through.
pub(crate) fn window_directions(
    way: &impl RayWay,
    start: &ChirpedStart,
    target: &TargetRegion,
) -> Option<WindowDirections> {
    let at = start.carrier.at;
    let bounds = &target.bounds;
    let mut nearest = LandedDirection::new(way, at, start.carrier.p)?;
    for _ in 0..STEPS {
        let gap = [0, 1].map(|a| {
            let here = nearest.landing[a];
            here.clamp(bounds[2 * a], bounds[2 * a + 1]) - here
        });
        if gap == [0.0; 2] {
            break;
        }
        let closer = nearest.change(gap).and_then(|dp| {
            LandedDirection::new(way, at, [nearest.p[0] + dp[0], nearest.p[1] + dp[1]])
        });
        let Some(closer) = closer else { break };
        nearest = closer;
    }

    // The target and a footprint around it, seen from where the ray lands.
    let aside = [0, 1].map(|a| nearest.p[a] - start.carrier.p[a]);
    let (k, index) = way.medium();
    let footprint = way.carry(start, aside)?.footprint(k, target.edge);
    let side = |a: usize| {
        let [low, high] = [bounds[2 * a], bounds[2 * a + 1]];
        let half = SAFETY * (0.5 * (high - low) + footprint[a]);
        [-half, half].map(|half| 0.5 * (low + high) + half - nearest.landing[a])
    };
    let (x, y) = (side(0), side(1));
    let part = |a: usize, [low, high]: [f64; 2]| (bounds[2 * a + 1] - bounds[2 * a]) / (high - low);
    let landing = [part(0, x), part(1, y)];
    let mut found = [f64::INFINITY, f64::NEG_INFINITY].repeat(2);
    for corner in [[x[0], y[0]], [x[0], y[1]], [x[1], y[0]], [x[1], y[1]]] {
        let Some(dp) = nearest.change(corner) else {
            let all = 2.0 * index;
            let bounds = [-all, all, -all, all];
            return Some(WindowDirections { bounds, landing });
        };
        for a in 0..2 {
            found[2 * a] = found[2 * a].min(aside[a] + dp[a]);
            found[2 * a + 1] = found[2 * a + 1].max(aside[a] + dp[a]);
        }
    }
    let bounds = [found[0], found[1], found[2], found[3]];
    Some(WindowDirections { bounds, landing })
}
