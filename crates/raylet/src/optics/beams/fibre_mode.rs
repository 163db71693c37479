//! Modes of a weakly guiding step-index fibre: LP modes, of one polarisation.

use std::f64::consts::PI;

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::bessel::{bessel_j, scaled_bessel_k};

/// The mode LP_lm: J_l(ur/a) in the core and K_l(wr/a) outside, times cos l(φ − φ₀), with u² + w² = V² (Gloge, Appl. Opt. 10,
/// 2252, 1971). Its largest amplitude is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreMode {
    radius: f64,
    order: u32,
    /// What varies in the core.
    u: f64,
    /// What falls outside.
    w: f64,
    rotation: f64,
    /// The largest amplitude of the mode that is one at the edge of the core.
    peak: f64,
}

/// A mode that a fibre does not guide: its normalised frequency V, and that from which it guides the mode.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a fibre of V = {v:.4}, which guides the mode from V = {cutoff:.4}")]
pub struct NotGuided {
    /// V of the fibre.
    pub v: f64,
    /// V from which the mode is guided.
    pub cutoff: f64,
}

/// Bisections of an interval: down to rounding.
const HALVINGS: usize = 60;

/// The least w at which a mode is looked for.
const WEAKEST: f64 = 1e-9;

/// Steps in which zeros of Bessel functions are looked for.
const STEP: f64 = 0.2;

/// Places in the core at which the largest amplitude is looked for.
const PLACES: u32 = 4000;

/// Of its largest amplitude, where the samples of a mode end, and how many there are in a radius of the core.
const END: f64 = 1e-6;
const IN_RADIUS: f64 = 12.0;

/// The most samples of a mode along an axis.
const MOST_SAMPLES: usize = 4096;

impl FibreMode {
    /// The mode [l, m] of a core of this radius in mm and normalised frequency V = ka·NA; its maxima lie at `rotation` rad from
    /// x towards y.
    ///
    /// # Errors
    /// When the fibre does not guide it.
    pub fn new(radius: f64, v: f64, [l, m]: [u32; 2], rotation: f64) -> Result<Self, NotGuided> {
        // Between zeros of J_{l−1}, where the mode is cut off, and of J_l, at which it is in a strong fibre.
        let cutoff = match (l, m) {
            (0, 0 | 1) => 0.0,
            (0, m) => zero_of_j(1, m - 1),
            (l, m) => zero_of_j(l - 1, m),
        };
        if v <= cutoff {
            return Err(NotGuided { v, cutoff });
        }
        let far = zero_of_j(l, m).min(v);
        let mismatch = |u: f64| {
            let w = (v * v - u * u).max(0.0).sqrt().max(WEAKEST);
            let outside = w * scaled_bessel_k(l + 1, w) / scaled_bessel_k(l, w);
            u * bessel_j(l + 1, u) - outside * bessel_j(l, u)
        };
        let u = root(cutoff, far, mismatch);
        let mode = Self {
            radius,
            order: l,
            u,
            w: (v * v - u * u).sqrt(),
            rotation,
            peak: 1.0,
        };
        let within = (0..=PLACES).map(|i| mode.across(f64::from(i) / f64::from(PLACES)).abs());
        let peak = within.fold(0.0, f64::max);
        Ok(Self { peak, ..mode })
    }

    /// The normalised propagation constant b = w²/V².
    pub fn propagation_constant(&self) -> f64 {
        let square = self.w * self.w;
        square / (square + self.u * self.u)
    }

    /// The amplitude at a distance from the middle in radii of the core.
    fn across(&self, r: f64) -> f64 {
        let here = if r < 1.0 {
            bessel_j(self.order, self.u * r) / bessel_j(self.order, self.u)
        } else {
            let [here, edge] = [r, 1.0].map(|r| scaled_bessel_k(self.order, self.w * r));
            here / edge * (self.w * (1.0 - r)).exp()
        };
        here / self.peak
    }

    /// The amplitude at a place in mm from the middle.
    pub fn field(&self, x: f64, y: f64) -> f64 {
        let turn = f64::from(self.order) * (y.atan2(x) - self.rotation);
        self.across(x.hypot(y) / self.radius) * turn.cos()
    }

    /// Half the width in mm over which it is sampled: up to 1e-6 of its peak.
    fn reach(&self) -> f64 {
        let mut r = 1.0;
        while self.across(r).abs() > END {
            r += 0.05 * r.max(1.0 / self.w);
        }
        r * self.radius
    }

    /// Its samples [y, x], and their distance in mm: an even number along each axis; nothing where the mode
    /// reaches too far outside.
    pub(crate) fn samples(&self) -> Option<(Array2<Complex64>, f64)> {
        let pitch = self.radius / IN_RADIUS;
        let half = (self.reach() / pitch).ceil() as usize;
        if 2 * half > MOST_SAMPLES {
            return None;
        }
        let place = |i: usize| (i as f64 - half as f64 + 0.5) * pitch;
        let value = |(j, i): (usize, usize)| Complex64::from(self.field(place(i), place(j)));
        Some((Array2::from_shape_fn((2 * half, 2 * half), value), pitch))
    }
}

/// The root between two places where a function has unlike signs.
fn root(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let above = function(high) > 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match (function(middle) > 0.0) == above {
            true => high = middle,
            false => low = middle,
        }
    }
    0.5 * (low + high)
}

/// The m-th positive zero of J_l: there is none before l, and they lie about π apart.
fn zero_of_j(order: u32, m: u32) -> f64 {
    let mut x = f64::from(order) + STEP;
    for found in 0.. {
        while bessel_j(order, x).signum() == bessel_j(order, x + STEP).signum() {
            x += STEP;
        }
        if found + 1 >= m {
            break;
        }
        x += 0.5 * PI;
    }
    root(x, x + STEP, |x| bessel_j(order, x))
}

#[cfg(test)]
mod tests {
    use crate::optics::beams::fibre_mode::{FibreMode, NotGuided};

    fn mode(v: f64, mode: [u32; 2]) -> Result<FibreMode, NotGuided> {
        FibreMode::new(4e-3, v, mode, 0.0)
    }

    /// Gloge's table: zeros of J₀ for LP11 and LP12, of J₁ for LP21, LP02 and LP22, of J₂ for LP31.
    #[test]
    fn modes_are_cut_off_where_they_should() {
        for ([l, m], cutoff) in [
            ([1, 1], 2.404_826),
            ([2, 1], 3.831_706),
            ([0, 2], 3.831_706),
            ([3, 1], 5.135_622),
            ([1, 2], 5.520_078),
            ([2, 2], 7.015_587),
        ] {
            assert!((mode(1.0, [l, m]).unwrap_err().cutoff - cutoff).abs() < 1e-6);
            assert!(mode(cutoff - 1e-5, [l, m]).is_err());
            let weak = mode(1.02 * cutoff, [l, m]).unwrap().propagation_constant();
            assert!(weak > 0.0 && weak < 0.05, "LP{l}{m}: {weak}");
        }
    }

    /// Rudolph and Neumann's w = 1.1428 V − 0.996, right to 0.1 % of V for V from 1.5 to 2.5 (Nachrichtentech. Z. 29, 328,
    /// 1976); for strong fibres u = 2.4048 exp(−1/V)... of Snyder, right to 1/V³.
    #[test]
    fn the_fundamental_mode_has_the_published_constants() {
        for v in [1.5, 1.8, 2.0, 2.2, 2.405, 2.5] {
            let w = mode(v, [0, 1]).unwrap().w;
            let off = (w - (1.1428 * v - 0.996)).abs();
            assert!(off < 2e-3 * v, "{v}: {off}");
        }
        let strong = mode(60.0, [0, 1]).unwrap().u;
        assert!(
            (strong - 2.404_826 * (1.0 - 1.0 / 60.0)).abs() < 1e-3,
            "{strong}"
        );
    }

    /// The radius of the Gaussian that takes most of LP01, by its overlap, against Marcuse's formula (J. Opt. Soc. Am. 68,
    /// 103, 1978), which is right to 1 % from V = 1.2 to 2.4.
    #[test]
    fn the_fundamental_mode_is_as_wide_as_marcuse_has_it() {
        for v in [1.4f64, 1.8, 2.2, 2.4] {
            let mode = mode(v, [0, 1]).unwrap();
            let ring = |i: i32| 0.005 * (f64::from(i) + 0.5);
            let rings: Vec<(f64, f64)> =
                (0..6000).map(|i| (ring(i), mode.across(ring(i)))).collect();
            let overlap = |w: f64| {
                let gauss = |r: f64| (-r * r / (w * w)).exp();
                rings.iter().map(|(r, f)| f * gauss(*r) * r).sum::<f64>() / w
            };
            let widths = (0..4000).map(|i| 0.8 + 1e-3 * f64::from(i));
            let best = widths
                .max_by(|a, b| overlap(*a).total_cmp(&overlap(*b)))
                .unwrap();
            let marcuse = 0.65 + 1.619 / v.powf(1.5) + 2.879 / v.powi(6);
            assert!((best / marcuse - 1.0).abs() < 0.01, "{v}: {best} {marcuse}");
        }
    }

    /// The field and its slope are continuous at the edge of the core, and LP11 has its maxima where it is turned to.
    #[test]
    fn modes_are_smooth_at_the_core() {
        for (v, order) in [
            (2.2, [0, 1]),
            (4.5, [1, 1]),
            (4.5, [2, 1]),
            (6.0, [0, 2]),
            (6.0, [1, 2]),
        ] {
            let mode = mode(v, order).unwrap();
            let h = 1e-4;
            let [inner, edge, outer] = [1.0 - h, 1.0, 1.0 + h].map(|r| mode.across(r));
            let kink = ((outer - edge) - (edge - inner)) / h;
            assert!(kink.abs() < 20.0 * h, "{order:?}: {kink}");
        }
        let turned = FibreMode::new(4e-3, 3.0, [1, 1], 0.5).unwrap();
        let around = |angle: f64| turned.field(2e-3 * angle.cos(), 2e-3 * angle.sin());
        assert!(around(0.5) > around(0.6) && around(0.5) > around(0.4));
        assert!(around(0.5 + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
