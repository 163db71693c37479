//! Stairs from one allowed level of a value to the next: hard, or softened during a design.

use serde::{Deserialize, Serialize};

/// Sharpness of the soft stairs halfway through the annealing.
const SHARPNESS: f64 = 4.0;

/// How a design reaches allowed levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Hardening {
    /// Always on a level; the gradient is that of the value before (Bengio, Léonard and Courville,
    /// arXiv:1308.3432). It is not the gradient of the loss: for descents, not for line searches.
    StraightThrough,
    /// Soft stairs ⌊u⌋ + ½ + ½tanh(b(u − ⌊u⌋ − ½))/tanh(b/2) whose sharpness b = 4·s/(1 − s) grows with
    /// the share s of the iterations done: a slope at first, the hard stairs at last. The gradient is
    /// exact while s < 1; at s = 1 it passes straight through.
    Annealed,
}

impl Hardening {
    /// The stairs at `u`, in units of the step between levels: whole numbers are levels. `share` is the share of the
    /// iterations done, 0 to 1.
    pub fn quantise(self, u: f64, share: f64) -> f64 {
        match self.sharpness(share) {
            None => (u + 0.5).floor(),
            Some(0.0) => u,
            Some(b) => {
                let past = u - u.floor() - 0.5;
                u.floor() + 0.5 + 0.5 * (b * past).tanh() / (0.5 * b).tanh()
            }
        }
    }

    /// Derivative of [`Hardening::quantise`] by `u`, for gradients.
    pub fn slope(self, u: f64, share: f64) -> f64 {
        match self.sharpness(share) {
            None | Some(0.0) => 1.0,
            Some(b) => {
                let past = u - u.floor() - 0.5;
                0.5 * b / ((b * past).cosh().powi(2) * (0.5 * b).tanh())
            }
        }
    }

    /// Of the soft stairs; none where they are hard.
    fn sharpness(self, share: f64) -> Option<f64> {
        match self {
            Self::Annealed if share < 1.0 => Some(SHARPNESS * share.max(0.0) / (1.0 - share)),
            Self::Annealed | Self::StraightThrough => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::design::constraints::staircase::Hardening;

    #[test]
    fn soft_stairs_lead_from_the_slope_to_the_hard_ones() {
        let soft = Hardening::Annealed;
        for i in -30..30 {
            let u = 0.1003 * f64::from(i);
            let near = u.round();
            assert_eq!(soft.quantise(u, 0.0), u);
            assert_eq!(soft.quantise(u, 1.0), near);
            assert_eq!(Hardening::StraightThrough.quantise(u, 0.3), near);

            // Ever nearer to the level, and never past it.
            let mut last = (u - near).abs();
            for share in [0.2, 0.5, 0.8, 0.95] {
                let off = (soft.quantise(u, share) - near).abs();
                assert!(off <= last + 1e-15, "{u} {share}");
                last = off;

                let difference =
                    (soft.quantise(u + 1e-6, share) - soft.quantise(u - 1e-6, share)) / 2e-6;
                assert!((difference - soft.slope(u, share)).abs() < 1e-6);
            }
        }
        assert_eq!(soft.slope(0.3, 1.0), 1.0);
        assert_eq!(Hardening::StraightThrough.slope(0.3, 0.5), 1.0);
    }
}
