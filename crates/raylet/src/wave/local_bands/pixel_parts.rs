//! The parts of a pixel over which arriving light is linear.
//!
//! Two Gauss nodes along each axis of a part integrate a constant transmission times linear light exactly. The light of a
//! smooth wave is nearly linear over a part that is narrow against its window. Light of many directions, as from pixels of
//! an earlier element, asks for parts that are narrow against its own changes.

use crate::wave::grid::field::CellPart;

/// Gauss nodes along each axis of a part.
pub(crate) const NODES_OF_PART: usize = 2;

/// What arriving light asks of the parts along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightOverParts {
    /// Root mean square direction of the light beside its carrier.
    pub spread: f64,
    /// Largest direction beside the carrier in which plane waves are computed.
    pub reach: f64,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// The relative error that parts may cost along the axis.
    pub allowed: f64,
}

impl LightOverParts {
    /// The same for light times a transmission that has an even band up to a direction of its own.
    pub(crate) fn times_band(self, direction: f64) -> Self {
        Self {
            spread: self.spread.hypot(direction / 3f64.sqrt()),
            ..self
        }
    }

    /// The number of equal parts of a width in mm that keep the error of the plane waves to what is allowed.
    ///
    /// The light exp(iaξ), −1 ≤ ξ ≤ 1, between its values at ±1/√3 differs from linear light by −a²/3 times the second
    /// Legendre polynomial at first. The direction b has −j₂(b) of that, about b²/15. Over even spreads of a up to A and of b up
    /// to B the root mean square is nearly A²(B² + 0.35 A²)/225 of the light for small A and B, and A²/15 at most. With n parts
    /// the first falls as 1/n⁴, the second as 1/n².
    pub(crate) fn parts(&self, width: f64) -> f64 {
        // An even spread up to A has the root mean square A/√3.
        let half = 0.5 * self.k * width;
        let (a, b) = (half * 3f64.sqrt() * self.spread, half * self.reach);
        let small = a * a * (b * b + 0.35 * a * a) / 225.0;
        let most = a * a / 15.0;
        let fourth = (small / self.allowed).powf(0.25);
        let square = (most / self.allowed).sqrt();
        fourth.min(square).ceil().max(1.0)
    }
}

/// The parts of a box pixel of this pitch with a gap around its active area, none wider than `part`.
pub(crate) fn gapped_cell(pitch: f64, side: f64, part: f64) -> Vec<CellPart> {
    let parts = |width: f64| {
        let count = (width / part).ceil();
        let width = width / count;
        let nodes = NODES_OF_PART;
        vec![CellPart { width, nodes }; count as usize]
    };
    let gap = parts(0.5 * (1.0 - side) * pitch);
    [gap.clone(), parts(side * pitch), gap].concat()
}

#[cfg(test)]
mod tests {
    use crate::wave::local_bands::pixel_parts::LightOverParts;

    /// The spectrum j₀(b − a) of a part under the light exp(iaξ), and that of two nodes in place of it, over even spreads of a
    /// and b by the midpoint rule: the relative error.
    fn summed(largest: [f64; 2]) -> f64 {
        let sinc = |x: f64| if x.abs() < 1e-6 { 1.0 } else { x.sin() / x };
        let odd = |x: f64| {
            if x.abs() < 1e-3 {
                x / 3.0
            } else {
                (x.sin() / x - x.cos()) / x
            }
        };
        let count = 60;
        let place =
            |side: f64, i: usize| side * ((2 * i + 1) as f64 / f64::from(count as u32) - 1.0);
        let (mut wrong, mut all) = (0.0, 0.0);
        for n in 0..count * count {
            let (a, b) = (place(largest[0], n % count), place(largest[1], n / count));
            let root = 3f64.sqrt();
            let pairs = (a / root).cos() * sinc(b) + root * (a / root).sin() * odd(b);
            wrong += (pairs - sinc(b - a)).powi(2);
            all += sinc(b - a).powi(2);
        }
        (wrong / all).sqrt()
    }

    /// The error is at most what is allowed, by these sums, and would be more with half as many parts.
    #[test]
    fn parts_keep_to_the_allowed_error() {
        let allowed = 2e-4;
        for a in [0.1, 0.3, 0.5, 1.0, 1.5, 4.0] {
            for b in [0.3, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0] {
                let light = LightOverParts {
                    spread: a / 3f64.sqrt(),
                    reach: b,
                    k: 2.0,
                    allowed,
                };
                let parts = light.parts(1.0);
                let error = summed([a / parts, b / parts]);
                assert!(error < 1.25 * allowed, "{a} {b}: {error:e}");
                let few = (0.5 * parts).ceil();
                let coarse = summed([a / few, b / few]);
                assert!(
                    parts == 1.0 || coarse > 1.25 * allowed,
                    "{a} {b}: {coarse:e}"
                );
            }
        }
    }
}
