//! Phases as they are made: on a number of levels, or as a height of material that is wrapped.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::design::constraints::staircase::Hardening;

/// Equally spaced levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Levels {
    /// Number of levels, at least two.
    pub count: usize,
    /// How a design reaches the levels.
    pub hardening: Hardening,
}

/// A height of material and the phase it makes, at one wavelength and square incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// Phase per height in rad/mm.
    factor: f64,
    /// The largest height in mm.
    highest: f64,
    levels: Option<Levels>,
    /// Heights that differ by this period make the same light; none where no two allowed heights differ by it.
    period: Option<f64>,
}

/// Why a relief cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ReliefError {
    /// A material that does nothing, or a wavelength of no meaning.
    #[error("a height of 1 mm makes a phase of {0} rad; expected a number that is not zero")]
    Factor(f64),
    /// A height that is not one.
    #[error("a largest height of {0} mm; expected a positive number")]
    Height(f64),
    /// Too few levels.
    #[error("{0} as number of levels")]
    Levels(usize),
}

impl Relief {
    /// A relief whose phase grows by `factor` rad per mm of height, with heights up to `highest` mm, on these levels or
    /// on any height.
    ///
    /// Phases are wrapped onto as many whole waves as the largest height holds, where the levels are the
    /// multiples of (those waves)/count from zero. Where it holds none, the levels are spread from zero to
    /// the largest height, and phases that are not among them come to the nearer end: keep the
    /// parameters within [`Relief::bounds`].
    ///
    /// # Errors
    /// When a number is outside its range.
    pub fn new(factor: f64, highest: f64, levels: Option<Levels>) -> Result<Self, ReliefError> {
        if factor == 0.0 || !factor.is_finite() {
            return Err(ReliefError::Factor(factor));
        }
        if !(highest > 0.0 && highest.is_finite()) {
            return Err(ReliefError::Height(highest));
        }
        if let Some(Levels {
            count: count @ 0..2,
            ..
        }) = levels
        {
            return Err(ReliefError::Levels(count));
        }
        let wave = TAU / factor.abs();
        // A height given as one wave in decimals is one.
        let waves = (highest / wave * (1.0 + 1e-9)).floor();
        Ok(Self {
            factor,
            highest,
            levels,
            period: (waves >= 1.0).then_some(waves * wave),
        })
    }

    /// A relief of a transparent material: φ = 2π(n − n′)h/λ, n its index and n′ that of what it stands in.
    ///
    /// # Errors
    /// When a number is outside its range.
    pub fn transmission(
        wavelength: f64,
        indices: [f64; 2],
        highest: f64,
        levels: Option<Levels>,
    ) -> Result<Self, ReliefError> {
        let [material, around] = indices;
        Self::new(TAU * (material - around) / wavelength, highest, levels)
    }

    /// A relief on a mirror: φ = −4πn′h/λ, because a height towards the light shortens its path twice.
    ///
    /// # Errors
    /// When a number is outside its range.
    pub fn reflection(
        wavelength: f64,
        around: f64,
        highest: f64,
        levels: Option<Levels>,
    ) -> Result<Self, ReliefError> {
        Self::new(-2.0 * TAU * around / wavelength, highest, levels)
    }

    /// Phases from 0 to 2π on levels, without a material: a relief whose height is its phase in rad.
    ///
    /// # Errors
    /// When there are fewer than two levels.
    pub fn phases(levels: Levels) -> Result<Self, ReliefError> {
        Self::new(1.0, TAU, Some(levels))
    }

    /// Phase per height in rad/mm. The phase at another wavelength is that at this one times the ratio of
    /// the factors, and so is its gradient.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// Whether the levels grow harder with the share of the iterations done.
    pub fn hardens(&self) -> bool {
        self.levels
            .is_some_and(|levels| levels.hardening == Hardening::Annealed)
    }

    /// The phases that can be made, where they do not wrap: bounds for parameters.
    pub fn bounds(&self) -> Option<[f64; 2]> {
        let end = self.factor * self.highest;
        self.period
            .is_none()
            .then_some([end.min(0.0), end.max(0.0)])
    }

    /// The height in mm for a phase in rad, `share` of the iterations done: 0 ≤ h ≤ highest.
    pub fn height(&self, phase: f64, share: f64) -> f64 {
        let (height, _) = self.nearest(phase);
        let Some(levels) = self.levels else {
            return height;
        };
        let spacing = self.spacing(levels.count);
        let level = levels.hardening.quantise(height / spacing, share);
        match self.period {
            // The level above the last is the first of the next wave.
            Some(_) if level >= levels.count as f64 => 0.0,
            _ => level * spacing,
        }
    }

    /// The phase that is made, in rad.
    pub fn make(&self, phase: f64, share: f64) -> f64 {
        self.factor * self.height(phase, share)
    }

    /// Derivative of the phase that is made by the requested phase.
    pub fn slope(&self, phase: f64, share: f64) -> f64 {
        let (height, slope) = self.nearest(phase);
        match self.levels {
            Some(Levels { count, hardening }) => {
                slope * hardening.slope(height / self.spacing(count), share)
            }
            None => slope,
        }
    }

    /// The cotangent of the requested phase, from that of the phase made.
    pub fn make_adjoint(&self, phase: f64, share: f64, made_bar: f64) -> f64 {
        // made = factor · height(phase)
        self.slope(phase, share) * made_bar
    }

    /// The height, from zero to the largest, that makes this phase or comes nearest to it, and its derivative by the
    /// height of the phase: 1, or 0 at an end.
    fn nearest(&self, phase: f64) -> (f64, f64) {
        let height = phase / self.factor;
        if let Some(period) = self.period {
            return (height.rem_euclid(period), 1.0);
        }
        let wave = TAU / self.factor.abs();
        match height.rem_euclid(wave) {
            height if height <= self.highest => (height, 1.0),
            height if height - self.highest < wave - height => (self.highest, 0.0),
            _ => (0.0, 0.0),
        }
    }

    /// Height from level to level.
    fn spacing(&self, count: usize) -> f64 {
        match self.period {
            Some(period) => period / count as f64,
            None => self.highest / (count as f64 - 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use crate::design::constraints::relief::{Levels, Relief, ReliefError};
    use crate::design::constraints::staircase::Hardening;
    use crate::fixtures::noise::column;

    fn levels(count: usize) -> Levels {
        Levels {
            count,
            hardening: Hardening::Annealed,
        }
    }

    /// Distance of two phases on the circle.
    fn apart(a: f64, b: f64) -> f64 {
        let turn = (a - b).rem_euclid(TAU);
        turn.min(TAU - turn)
    }

    #[test]
    fn heights_make_the_phase_and_are_wrapped() {
        // At 0.6 µm a wave is 1.2 µm of an index half above or below what is around, or 0.3 µm of a mirror.
        let air = Relief::transmission(0.6e-3, [1.5, 1.0], 1.2e-3, None).unwrap();
        let twice = Relief::transmission(0.6e-3, [1.5, 1.0], 2.5e-3, None).unwrap();
        let bubble = Relief::transmission(0.6e-3, [1.0, 1.5], 2.0e-3, None).unwrap();
        let mirror = Relief::reflection(0.6e-3, 1.0, 0.3e-3, None).unwrap();
        assert!((air.height(PI, 0.0) - 0.6e-3).abs() < 1e-18);
        assert!((twice.height(3.0 * PI, 0.0) - 1.8e-3).abs() < 1e-17);
        assert!((bubble.height(-PI, 0.0) - 0.6e-3).abs() < 1e-18);
        assert!((mirror.height(-PI, 0.0) - 0.15e-3).abs() < 1e-18);
        for relief in [air, twice, bubble, mirror] {
            for i in -40..40 {
                let phase = 0.37 * f64::from(i);
                let height = relief.height(phase, 0.5);
                assert!((0.0..=relief.highest).contains(&height));
                assert!(apart(relief.make(phase, 0.5), phase) < 1e-12);
            }
            assert_eq!(relief.bounds(), None);
        }
    }

    #[test]
    fn levels_have_the_given_number_and_are_the_nearest() {
        let relief = Relief::transmission(0.6e-3, [1.5, 1.0], 1.2e-3, Some(levels(5))).unwrap();
        let phases = (0..1000).map(|i| 0.031 * f64::from(i) - 11.0);
        let mut seen = Vec::new();
        for phase in phases {
            let made = relief.make(phase, 1.0);
            assert!(apart(made, phase) <= PI / 5.0 + 1e-12, "{phase} {made}");
            if !seen.contains(&made) {
                seen.push(made);
            }
        }
        assert_eq!(seen.len(), 5);

        // Too low for a wave: from zero to the top, and what cannot be made comes to the nearer end.
        let low = Relief::transmission(0.6e-3, [1.5, 1.0], 0.6e-3, Some(levels(3))).unwrap();
        let made = [0.1, 1.0, 3.0, 4.0, 6.0].map(|phase| low.make(phase, 1.0));
        let exact = [0.0, 0.5 * PI, PI, PI, 0.0];
        assert!(
            made.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12),
            "{made:?}"
        );
        let bounds = low.bounds().unwrap();
        assert!(bounds[0] == 0.0 && (bounds[1] - PI).abs() < 1e-12);
        assert_eq!([low.slope(1.0, 1.0), low.slope(4.0, 1.0)], [1.0, 0.0]);
    }

    #[test]
    fn make_central_differences_and_inner_product() {
        let reliefs = [
            Relief::phases(levels(4)).unwrap(),
            Relief::transmission(0.6e-3, [1.5, 1.0], 2.5e-3, None).unwrap(),
            Relief::reflection(0.6e-3, 1.3, 0.2e-3, Some(levels(3))).unwrap(),
        ];
        for relief in reliefs {
            for i in 0..60 {
                let (phase, step) = (0.2113 * f64::from(i) - 6.0, 1e-5);
                for share in [0.0, 0.3, 0.7] {
                    // By way of the wrap, differences are of a turn more.
                    let up = relief.make(phase + step, share) - relief.make(phase - step, share);
                    let turns = TAU * (up / TAU).round();
                    let bar = relief.make_adjoint(phase, share, 1.7);
                    let off = bar - 1.7 * (up - turns) / (2.0 * step);
                    assert!(off.abs() < 1e-7, "{phase} {share} {off:e}");
                }
            }

            // All phases at once: ⟨J dx, ȳ⟩ = ⟨dx, Jᵀȳ⟩ with J dx by central differences along dx.
            for share in [0.0, 0.3, 0.7] {
                let [mut there, mut back] = [0.0f64; 2];
                for (i, drawn) in (0..).zip(column(60, 5)) {
                    let (phase, step) = (0.2113 * f64::from(i) - 6.0, 1e-5);
                    let [dx, bar] = [drawn.re, drawn.im];
                    let ends = [phase + step * dx, phase - step * dx];
                    let [up, down] = ends.map(|phase| relief.make(phase, share));
                    let turns = TAU * ((up - down) / TAU).round();
                    there += (up - down - turns) / (2.0 * step) * bar;
                    back += dx * relief.make_adjoint(phase, share, bar);
                }
                assert!(back.abs() > 0.1, "{back}");
                assert!((there - back).abs() < 1e-9, "{share}: {there} {back}");
            }
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let same = Relief::transmission(0.6e-3, [1.5, 1.5], 1e-3, None);
        assert_eq!(same.unwrap_err(), ReliefError::Factor(0.0));
        for highest in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = Relief::transmission(0.6e-3, [1.5, 1.0], highest, None);
            assert!(matches!(found, Err(ReliefError::Height(_))));
        }
        assert_eq!(Relief::phases(levels(1)), Err(ReliefError::Levels(1)));
    }
}
