//! The light of an edge that the nodes of its tile do not resolve.
//!
//! A straight edge in a unit plane wave spreads the power ds/(2πks²) a unit of its length over directions s beside the wave's
//! own, at right angles to itself (the square of the spectrum 1/(iks) of a step). Nodes resolve directions up to a limit. What
//! lies between it and the directions that lead to the target is missing there.

use std::f64::consts::PI;

use crate::engine::local_bands::window_directions::WindowDirections;
use crate::optics::aperture::Aperture;

/// A window that an edge cuts.
pub(crate) struct CutWindow {
    /// Its centre in mm.
    pub at: [f64; 2],
    /// Its width in mm.
    pub sigma: f64,
    /// The intensity of the light that arrives.
    pub intensity: f64,
    /// The directions beside its carrier that lead to the target, `[x_low, x_high, y_low, y_high]`.
    pub directions: [f64; 4],
    /// The part of their sides, about their middle, that leads to the target itself.
    pub landing: [f64; 2],
    /// The largest direction along x and y that the nodes resolve.
    pub limit: [f64; 2],
}

impl CutWindow {
    /// The power that is missing at the target, as the energy of so many windows of a unit plane wave.
    pub(crate) fn missing(&self, aperture: &Aperture, k: f64) -> f64 {
        let [x, y] = self.at;
        let slope = aperture.depth_slope(self.at, self.sigma);
        let length = slope[0].hypot(slope[1]);
        let depth = aperture.depth(x, y) / self.sigma;
        if length == 0.0 || !depth.is_finite() {
            return 0.0;
        }
        // The windows along the edge share its length.
        let share = (-depth * depth).exp() / (PI.sqrt() * self.sigma);
        let normal = slope.map(|s| s / length);
        let beyond = |side: f64| self.beyond(normal.map(|n| side * n));
        self.intensity * share * (beyond(1.0) + beyond(-1.0)) / (2.0 * PI * k)
    }

    /// ∫ds/s² along a normal, over what leads to the target and is not resolved.
    fn beyond(&self, normal: [f64; 2]) -> f64 {
        let limit = [0, 1].map(|a| self.limit[a] / normal[a].abs());
        let directions = WindowDirections {
            bounds: self.directions,
            landing: self.landing,
        };
        across_edge(&directions, normal, limit[0].min(limit[1]))
    }
}

/// The power that a straight edge of this length and way, `along` in mm, sends to the target by diffraction, for light of
/// |U|² = 1, in mm², in directions from `least` on. Directions that lead from it to the target are given beside the light's own.
pub(crate) fn edge_power(
    directions: &WindowDirections,
    along: [f64; 2],
    k: f64,
    least: f64,
) -> f64 {
    let length = along[0].hypot(along[1]);
    let sides = normals(along).map(|normal| across_edge(directions, normal, least));
    length * (sides[0] + sides[1]) / (2.0 * PI * k)
}

/// Both normals of an edge.
pub(crate) fn normals(along: [f64; 2]) -> [[f64; 2]; 2] {
    let length = along[0].hypot(along[1]);
    let normal = [along[1] / length, -along[0] / length];
    [normal, normal.map(|n| -n)]
}

/// ∫ds/s² along the normal of an edge, over directions from `least` on that lead to the target itself; nothing where the normal
/// leads past all beamlets that reach the target, infinite where the light itself leads there.
fn across_edge(directions: &WindowDirections, normal: [f64; 2], least: f64) -> f64 {
    match span_across_edge(directions, normal, least) {
        Some([near, far]) => 1.0 / near - 1.0 / far,
        None => 0.0,
    }
}

/// The directions along the normal of an edge, from `least` on, that lead to the target itself; nothing where none does.
pub(crate) fn span_across_edge(
    directions: &WindowDirections,
    normal: [f64; 2],
    least: f64,
) -> Option<[f64; 2]> {
    let bounds = &directions.bounds;
    let sides = [0, 1].map(|a| [bounds[2 * a], bounds[2 * a + 1]]);
    let middle = sides.map(|[low, high]| 0.5 * (low + high));
    let half = sides.map(|[low, high]| 0.5 * (high - low));
    let along = |n: [f64; 2], h: [f64; 2]| n[0].abs() * h[0] + n[1].abs() * h[1];
    let across = [-normal[1], normal[0]];
    let aside = middle[0] * across[0] + middle[1] * across[1];
    if aside.abs() > along(across, half) {
        return None;
    }
    let place = middle[0] * normal[0] + middle[1] * normal[1];
    let reach = along(normal, [0, 1].map(|a| directions.landing[a] * half[a]));
    let near = (place - reach).max(least);
    let far = place + reach;
    (far > near).then_some([near, far])
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::edge_band::CutWindow;
    use crate::optics::aperture::Aperture;

    /// Windows all around a disc share its edge. A target that half of the light of the edge reaches misses what lies between the
    /// resolved directions and its own end.
    #[test]
    fn windows_share_an_edge() {
        let (sigma, step, k) = (0.02, 0.025, 1e4);
        let aperture = Aperture::disc(1.0);
        let mut sum = 0.0;
        for j in -60..=60 {
            for i in -60..=60 {
                let at = [f64::from(i) * step, f64::from(j) * step];
                let window = CutWindow {
                    at,
                    sigma,
                    intensity: 1.0,
                    directions: [-1.0, 1.0, -1.0, 1.0],
                    landing: [0.5; 2],
                    limit: [2.0; 2],
                };
                assert_eq!(window.missing(&aperture, k), 0.0);
                let coarse = CutWindow {
                    limit: [0.02; 2],
                    ..window
                };
                sum += coarse.missing(&aperture, k) * step * step;
            }
        }
        // Both sides of the edge; boxes have a part of the normal in them that depends on its turn.
        let missing = |turn: f64| {
            let (s, c) = (turn.sin().abs(), turn.cos().abs());
            s.max(c) / 0.02 - 1.0 / (0.5 * (s + c))
        };
        let mean = (0..360)
            .map(|n| missing(f64::from(n).to_radians()))
            .sum::<f64>()
            / 360.0;
        let expected = 2.0 * mean / k;
        assert!((sum / expected - 1.0).abs() < 0.02, "{sum:e} {expected:e}");
    }
}
