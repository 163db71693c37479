//! The choices of a scattering of rays at a diffractive element, and why one is impossible.

use crate::engine::plan::settings::Sampler;
use crate::engine::progress::Cancelled;
use crate::optics::bundle::{RayError, check_finite, check_positive};
use crate::wave::grid::sampling::SamplingError;
use crate::wave::grid::transmission::NoPixels;
use crate::wave::patches::local_spectrum::Window;
use crate::wave::patches::window::Synthesis;

/// The area of the element that each ray represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coverage {
    /// The element is divided by what the windows of all rays add up to at each of its points, so any
    /// positions do that leave no gaps.
    Divide,
    /// Every ray represents this area in mm² of the element's local plane: for evenly spread rays.
    Area(f64),
}

/// Which modes of a patch become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// How modes are drawn: all, without or with replacement, in proportion to |c|.
    pub sampler: Sampler,
    /// Most modes drawn at each ray.
    pub most: usize,
    /// Seed; each random number follows from it, the number of the ray and the number of the draw.
    pub seed: u64,
}

/// The choices of a scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattering {
    /// Window by which the light of a patch is multiplied.
    pub window: Window,
    /// Period of a patch in mm: directions are λ/period apart, and copies of what a patch sends, a period
    /// apart, must miss the target or be damped by the window.
    pub period: f64,
    /// How the arriving rays are summed again: as beamlets, each with its window, or as plane waves.
    pub synthesis: Synthesis,
    /// The area that each ray represents.
    pub coverage: Coverage,
    /// Directions to follow, as optical cosines on the element's x and y axes `[x_low, x_high, y_low,
    /// y_high]`; all when absent.
    pub towards: Option<[f64; 4]>,
    /// Modes weaker than this share of the strongest of all rays are dropped.
    pub threshold: f64,
    /// Which of the other modes become rays.
    pub drawing: Drawing,
    /// Most sample points of the element.
    pub samples: usize,
}

impl Scattering {
    /// Settings for beamlets of width σ in mm: period 6σ, coverage divided out, modes above 10⁻³ of the strongest.
    /// With arriving rays 1.5σ apart, the error is 10⁻³ of the field.
    pub fn beamlets(sigma: f64) -> Self {
        Self {
            window: Window::Gaussian { sigma },
            period: 6.0 * sigma,
            synthesis: Synthesis::Window,
            coverage: Coverage::Divide,
            towards: None,
            threshold: 1e-3,
            drawing: Drawing {
                sampler: Sampler::All,
                most: usize::MAX,
                seed: 1,
            },
            samples: 1 << 26,
        }
    }

    /// Settings for plane waves, with a Gaussian window of width σ in mm and this period in mm.
    pub fn waves(sigma: f64, period: f64) -> Self {
        Self {
            period,
            synthesis: Synthesis::Plain,
            ..Self::beamlets(sigma)
        }
    }

    /// Settings for plane waves, with square patches of this side and period in mm.
    pub fn squares(side: f64, period: f64) -> Self {
        Self {
            window: Window::Square { side },
            ..Self::waves(side, period)
        }
    }

    /// Whether they make sense.
    ///
    /// # Errors
    /// When one is out of range.
    pub(crate) fn check(&self) -> Result<(), RayError> {
        let (name, width) = match self.window {
            Window::Gaussian { sigma } => ("window sigma", sigma),
            Window::Square { side } => ("window side", side),
        };
        check_positive(name, width)?;
        check_positive("period", self.period)?;
        if self.period < width {
            return Err(RayError::Setting {
                field: "period",
                found: self.period.to_string(),
                expected: "at least the width of the window",
            });
        }
        if let Coverage::Area(area) = self.coverage {
            check_positive("area of a ray", area)?;
        }
        if !(0.0..1.0).contains(&self.threshold) {
            return Err(RayError::Setting {
                field: "threshold",
                found: self.threshold.to_string(),
                expected: "a share from 0 up to 1",
            });
        }
        if let Some(towards) = &self.towards {
            check_finite("towards", towards.iter().map(|v| [*v]))?;
            let [x0, x1, y0, y1] = *towards;
            if x0 > x1 || y0 > y1 {
                return Err(RayError::Setting {
                    field: "towards",
                    found: format!("{towards:?}"),
                    expected: "cosines [x_low, x_high, y_low, y_high] in order",
                });
            }
        }
        Ok(())
    }

    /// The directions to follow in a medium of index `n`: those that propagate there.
    pub(crate) fn followed(&self, n: f64) -> [f64; 4] {
        let all = [-n, n, -n, n];
        self.towards
            .map_or(all, |followed| followed.map(|p| p.clamp(-n, n)))
    }

    /// Refuses patches of more modes than samples are allowed; `wavelength` is that of the vacuum, in mm.
    ///
    /// # Errors
    /// When a patch would have too many.
    pub(crate) fn check_modes(&self, n: f64, wavelength: f64) -> Result<(), RayError> {
        let [x0, x1, y0, y1] = self.followed(n);
        let along = |low: f64, high: f64| (high - low) * self.period / wavelength + 1.0;
        let modes = along(x0, x1) * along(y0, y1);
        if modes <= self.samples as f64 {
            return Ok(());
        }
        Err(RayError::Setting {
            field: "period",
            found: format!(
                "{} mm, which makes {modes:.1e} modes of a patch",
                self.period
            ),
            expected: "a shorter one, or fewer directions to follow",
        })
    }
}

/// Why rays cannot be scattered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScatterError {
    /// The arrays or settings are wrong.
    #[error(transparent)]
    Rays(#[from] RayError),
    /// The element cannot be sampled.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// The element has no pixels of its own.
    #[error(transparent)]
    NoPixels(#[from] NoPixels),
    /// The screen holds no element.
    #[error("screen '{0}' is no diffractive element, expected one")]
    NoElement(String),
    /// The element has pixels on axes of their own, and rays arrive on those of the element.
    #[error(
        "screen '{0}' has pixels that are off centre or turned on their element, expected an element that stands so itself"
    )]
    PlacedPixels(String),
    /// The progress callback cancelled the scattering.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests {
    use crate::engine::external::scatter_settings::Scattering;

    /// A patch of 60 µm has (2·60/0.6 + 1)² modes; one of a metre more than any memory.
    #[test]
    fn too_many_modes_are_refused() {
        let few = Scattering {
            samples: 201 * 201,
            ..Scattering::beamlets(0.01)
        };
        assert_eq!(few.check_modes(1.0, 0.6e-3), Ok(()));
        assert!(
            Scattering {
                samples: 40_000,
                ..few
            }
            .check_modes(1.0, 0.6e-3)
            .is_err()
        );
        assert!(
            Scattering { period: 1e3, ..few }
                .check_modes(1.0, 0.6e-3)
                .is_err()
        );
    }

    /// Directions that do not propagate are not followed.
    #[test]
    fn followed_directions_propagate() {
        let choice = Scattering {
            towards: Some([-9.0, 0.2, -0.1, 1e300]),
            ..Scattering::beamlets(0.1)
        };
        assert_eq!(choice.followed(1.5), [-1.5, 0.2, -0.1, 1.5]);
        let reversed = Scattering {
            towards: Some([0.2, -0.2, 0.0, 0.0]),
            ..choice
        };
        assert!(reversed.check().is_err());
    }
}
