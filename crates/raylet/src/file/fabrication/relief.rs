//! The relief that makes a phase: height = φ λ / (2π (n − n₀)).
//!
//! Light that runs a height h in a medium of index n instead of one of index n₀ gets the phase +k(n − n₀)h, whichever of the
//! two it meets first. A relief of the denser medium is therefore high where the phase is large. Where n < n₀, such as grooves
//! that are filled with air, it is high where the phase is small.

use std::f64::consts::TAU;

/// What is known of a relief.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Relief {
    /// Wavelength in vacuum in µm.
    pub wavelength_um: Option<f64>,
    /// Index of the relief less that of the medium whose place it takes.
    pub step: Option<f64>,
    /// The depth of a whole wave in µm, where it is stated.
    pub stated_depth_um: Option<f64>,
}

impl Relief {
    /// The depth of a whole wave in µm: λ / |n − n₀|, if that is known.
    pub(crate) fn depth_um(&self) -> Option<f64> {
        let own = match (self.wavelength_um, self.step) {
            (Some(wavelength), Some(step)) if step != 0.0 => Some(wavelength / step.abs()),
            _ => None,
        };
        self.stated_depth_um.or(own)
    }

    /// +1 where height adds to the phase, else −1.
    pub(crate) fn sign(&self) -> f64 {
        self.step.map_or(1.0, |step| step.signum())
    }

    /// The height in µm of a phase in rad, from 0 to below the depth of a whole wave.
    pub(crate) fn height_um(&self, phase: f64) -> Option<f64> {
        let waves = (self.sign() * phase / TAU).rem_euclid(1.0);
        // The remainder of a tiny negative number rounds to one.
        let waves = if waves < 1.0 { waves } else { 0.0 };
        self.depth_um().map(|depth| waves * depth)
    }

    /// The phase in rad of a height in µm.
    pub(crate) fn phase(&self, height_um: f64) -> Option<f64> {
        (self.depth_um()).map(|depth| self.sign() * TAU * height_um / depth)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use crate::file::fabrication::relief::Relief;

    #[test]
    fn heights_make_their_phases() {
        for (index, ambient) in [(1.46, 1.0), (1.0, 1.46), (1.7, 1.33)] {
            let relief = Relief {
                wavelength_um: Some(0.532),
                step: Some(index - ambient),
                stated_depth_um: None,
            };
            for phase in [0.0, 0.3, PI, 6.0, -1.0, 20.0, -1e-300] {
                let height = relief.height_um(phase).unwrap();
                assert!(height >= 0.0 && height < relief.depth_um().unwrap());
                // By the definition: k (n − n₀) h.
                let made = TAU / 0.532 * (index - ambient) * height;
                let turns = (made - phase) / TAU;
                assert!((turns - turns.round()).abs() < 1e-12, "{phase}: {turns}");
                assert!((relief.phase(height).unwrap() - made).abs() < 1e-12);
            }
        }
        // A quarter of a wave in glass is low, and in grooves of air it is deep.
        let glass = |step| Relief {
            wavelength_um: Some(0.5),
            step: Some(step),
            stated_depth_um: None,
        };
        assert!((glass(0.5).height_um(0.5 * PI).unwrap() - 0.25).abs() < 1e-12);
        assert!((glass(-0.5).height_um(0.5 * PI).unwrap() - 0.75).abs() < 1e-12);
    }
}
