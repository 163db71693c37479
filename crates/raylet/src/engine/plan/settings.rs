//! What a user may choose about a run. Scene files name the options by these enums, and the schema of scenes has their
//! descriptions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::wave::patches::tile::TileWindow;

/// A method that propagates the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    // Without rays where no surface has power, by beamlets elsewhere.
    /// The cheapest method whose expected error is at most the target error.
    #[default]
    Auto,
    /// Gaussian beamlets with exact second-order phase.
    Beamlet,
    // Wavelets with prefactor, summed by a non-uniform FFT.
    /// Plane-wave pieces.
    Plane,
    // Window by window of a screen; memory follows the beamlets, not the samples of a screen.
    /// Gaussian beamlets from screens that are never sampled as a whole.
    LocalBands,
    // As the source paper does: rectangular patches, plain plane waves.
    /// Random patches and drawn modes, as first published.
    Paper,
}

/// When a correction is applied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Where the target error needs it.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

/// The choices of a run; the defaults are what the accuracy report was made with.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Method that propagates fields from screen to screen.
    pub method: Method,
    /// Relative error of the complex field that the planner aims at, by the power of ten at or below it.
    pub target_error: f64,
    /// Beamlet width σ in mm, where the field is exp(−u²/2σ²); chosen by the planner when absent.
    pub sigma: Option<f64>,
    /// Distance of windows in σ; chosen by the planner when absent.
    pub step: Option<f64>,
    /// Period of a patch in σ; chosen from the target error when absent.
    pub period: Option<f64>,
    /// Modes weaker than this share of the strongest are dropped; chosen from the target error when absent.
    pub mode_threshold: Option<f64>,
    /// Footprints end where the Gaussian falls below this; chosen from the target error when absent.
    pub footprint_threshold: Option<f64>,
    /// Correction of the aberration inside a beamlet.
    pub correction: Correction,
    /// The least period of a free hop over the sum of the half widths of screen and target; at least 2. The target error asks
    /// for more.
    pub padding: f64,
    /// Relative tolerance of the non-uniform FFT.
    pub nufft_tolerance: f64,
    /// The settings of [`Method::Paper`].
    pub paper: Paper,
    /// Seed of everything drawn at random.
    pub seed: u64,
    /// Most bytes that the arrays of a run may take.
    pub memory_limit: usize,
}

// Apertures count as the boxes that hold them.
/// How positions of the method `paper` are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Positions {
    /// At random on the aperture alone, whose rim is then covered too thinly.
    Inside,
    /// At random on the aperture and half a patch around it.
    #[default]
    Dilated,
    /// One at random in each cell of a grid over the same.
    Jittered,
    // In the middle of each cell.
    /// A regular grid over the aperture.
    Grid,
}

/// Which modes the method `paper` draws more often.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Density {
    /// The stronger ones, in proportion to their amplitude.
    #[default]
    Amplitude,
    /// None.
    Uniform,
}

/// How the method `paper` draws modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    // Equal draws become one ray.
    /// Independently, with replacement.
    #[default]
    Multinomial,
    // At equal distances of summed probability along Hilbert's curve.
    /// Without replacement, evenly along a curve through all modes.
    Systematic,
    /// All of them, whatever `secondary` is.
    All,
}

/// How a patch of the method `paper` uses the height of a curved element over its tangent plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sag {
    // The patch is taken to be that plane for arriving and for leaving light.
    /// Nothing.
    Tangent,
    /// The phase that it adds to the arriving light; none for the leaving light.
    Incident,
    /// The phase that it has for each mode.
    #[default]
    True,
}

/// The settings of the source paper's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Incident rays: positions of patches. Grids take the nearest number that fills them.
    pub rays: usize,
    /// Secondary rays drawn per incident ray.
    pub secondary: usize,
    /// Side of the square patch, in mm; a quarter of the screen when absent.
    pub patch: Option<f64>,
    /// What the field in it is multiplied by.
    pub window: TileWindow,
    /// Period of a patch over its side.
    pub padding: f64,
    /// How far the lattice of modes goes, in bands of the pixels' FFT: 1 is that band itself, ±λ/2h for
    /// pixels of width h; more take in the higher orders of the pixels, as far as they propagate.
    pub orders: usize,
    /// Where patches stand.
    pub positions: Positions,
    /// Whether the field is divided by the sum of the windows that cover it, instead of by the one
    /// expected.
    pub coverage: bool,
    /// Which modes are drawn more often.
    pub density: Density,
    /// How they are drawn.
    pub sampler: Sampler,
    /// What is made of the height of a curved screen.
    pub sag: Sag,
    /// Whether each wavelet is multiplied by the cosine ⟨n, d⟩ at the sensor.
    pub obliquity: bool,
}

impl Default for Paper {
    fn default() -> Self {
        Self {
            rays: 1000,
            secondary: 1000,
            patch: None,
            window: TileWindow::default(),
            padding: 2.0,
            orders: 1,
            positions: Positions::default(),
            coverage: false,
            density: Density::default(),
            sampler: Sampler::default(),
            sag: Sag::default(),
            obliquity: false,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            target_error: 1e-3,
            sigma: None,
            step: None,
            period: None,
            mode_threshold: None,
            footprint_threshold: None,
            correction: Correction::Auto,
            padding: 2.0,
            nufft_tolerance: 1e-6,
            paper: Paper::default(),
            seed: 1,
            memory_limit: 4 << 30,
        }
    }
}

/// Largest share of the target error that the period of a patch may cost.
const PERIOD_SHARE: f64 = 0.25;

/// Where footprints end in a system that changes, as a share of their peak.
const SMOOTH: f64 = 1e-7;

/// A target error counts as a power of ten if its logarithm is this near to one.
const ROUNDING: f64 = 1e-9;

/// The thresholds are the target error, but never more than this.
const COARSEST: f64 = 1e-3;

/// Bytes of the memory limit for each complex sample of an array: an array may have an eighth of the memory.
pub(crate) const BYTES_OF_SAMPLE: usize = 8 * size_of::<num_complex::Complex64>();

impl Settings {
    /// The period of a patch in σ: as given, or the one whose error 2e^{−P²/4σ²} is a quarter of the
    /// target.
    pub(crate) fn patch_period(&self) -> f64 {
        let chosen = || 2.0 * (2.0 / (PERIOD_SHARE * self.target_error)).ln().sqrt();
        self.period.unwrap_or_else(chosen)
    }

    /// The settings of each of so many hops, whose errors add in squares to the target.
    pub(crate) fn shared(&self, hops: usize) -> Self {
        self.aiming_at(self.target_error / (hops.max(1) as f64).sqrt())
    }

    /// The settings by which a run is planned: with the power of ten at or below the target error. The errors of plans for
    /// nearby targets differ by chance, so that the one for the smaller target may expect the larger error.
    pub(crate) fn for_planning(&self) -> Self {
        let power = (self.target_error.log10() + ROUNDING).floor() as i32;
        self.aiming_at(10f64.powi(-power).recip())
    }

    /// The same settings with another target error.
    pub(crate) fn aiming_at(&self, target_error: f64) -> Self {
        Self {
            target_error,
            ..self.clone()
        }
    }

    /// The share of the strongest mode below which modes are dropped.
    pub(crate) fn weakest_mode(&self) -> f64 {
        self.mode_threshold.unwrap_or(self.coarsest_threshold())
    }

    /// The threshold of modes and footprints where none is given.
    pub(crate) fn coarsest_threshold(&self) -> f64 {
        self.target_error.min(COARSEST)
    }

    /// The share of its peak at which a footprint ends.
    pub(crate) fn footprint_edge(&self) -> f64 {
        self.footprint_threshold
            .unwrap_or(self.coarsest_threshold())
    }

    /// The settings for a system that changes: footprints end so far out that no value jumps.
    pub fn without_jumps(mut self) -> Self {
        self.footprint_threshold = Some(self.footprint_edge().min(SMOOTH));
        self
    }

    /// Complex samples that one array may have: an eighth of the memory limit.
    pub(crate) fn samples_allowed(&self) -> usize {
        self.memory_limit / BYTES_OF_SAMPLE
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::plan::settings::Settings;

    #[test]
    fn runs_are_planned_for_powers_of_ten() {
        let given = [0.5, 1e-1, 3e-2, 1e-3, 0.99e-3, 2e-6, 1e-12];
        let planned = given.map(|target_error| {
            let settings = Settings {
                target_error,
                ..Settings::default()
            };
            settings.for_planning().target_error
        });
        assert_eq!(planned, [1e-1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-12]);
    }
}
