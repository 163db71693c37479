//! What a user may choose about a run.

use crate::wave::patches::tile::TileWindow;

/// How a field is carried across a hop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Without rays where no surface has power, by beamlets elsewhere.
    #[default]
    Auto,
    /// By beamlets everywhere.
    Beamlet,
    /// By plane wavelets with prefactor, summed by a non-uniform FFT.
    Plane,
    /// As the source paper does: random positions, rectangular patches, drawn modes, plain plane waves.
    Paper,
}

/// Whether the aberration inside each beamlet is made good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Correction {
    /// When the estimate says that it matters.
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
    /// How fields are carried.
    pub method: Method,
    /// Relative error of the complex field that the planner aims at.
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
    /// Period of a free hop over the sum of the half widths of screen and target; at least 4.
    pub padding: f64,
    /// Relative tolerance of the non-uniform FFT.
    pub nufft_tolerance: f64,
    /// The knobs of [`Method::Paper`].
    pub paper: Paper,
    /// Seed of everything drawn at random.
    pub seed: u64,
    /// Most bytes that the arrays of a run may take.
    pub memory_limit: usize,
}

/// Where the patches of [`Method::Paper`] stand. Apertures count as the boxes that hold them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Positions {
    /// Uniformly random on the aperture itself: its rim is covered too thinly.
    Inside,
    /// Uniformly random on the aperture dilated by half a patch, which covers all of it alike.
    #[default]
    Dilated,
    /// One at random in each cell of a grid over the dilated aperture.
    Jittered,
    /// In the middle of each cell of a grid over the aperture itself.
    Grid,
}

/// With which probability a mode of [`Method::Paper`] is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Density {
    /// In proportion to |c|.
    #[default]
    Amplitude,
    /// Alike for all modes that propagate.
    Uniform,
}

/// How modes of [`Method::Paper`] are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sampler {
    /// Independently, with replacement; equal draws become one ray.
    #[default]
    Multinomial,
    /// Without replacement, at equal distances of summed probability along Hilbert's curve.
    Systematic,
    /// Not at all: every mode is followed.
    All,
}

/// What [`Method::Paper`] makes of the height of a curved screen over the plane that touches a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sag {
    /// Nothing: the patch is taken to be that plane, for the light that comes and for the light that goes.
    Tangent,
    /// The light that comes meets the screen where it is; the light that goes leaves the plane.
    Incident,
    /// Each mode's coefficient has its phase.
    #[default]
    True,
}

/// The knobs of the source paper's method.
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
            padding: 4.0,
            nufft_tolerance: 1e-6,
            paper: Paper::default(),
            seed: 1,
            memory_limit: 4 << 30,
        }
    }
}

/// Largest share of the target error that the period of a patch may cost.
const PERIOD_SHARE: f64 = 0.25;

/// The thresholds are the target error, but never more than this.
const COARSEST: f64 = 1e-3;

impl Settings {
    /// The period of a patch in σ: as given, or the one whose error 2e^{−P²/4σ²} is a quarter of the
    /// target.
    pub fn patch_period(&self) -> f64 {
        let chosen = || 2.0 * (2.0 / (PERIOD_SHARE * self.target_error)).ln().sqrt();
        self.period.unwrap_or_else(chosen)
    }

    /// The settings of each of so many hops, whose errors add in squares to the target.
    pub fn shared(&self, hops: usize) -> Self {
        self.aiming_at(self.target_error / (hops.max(1) as f64).sqrt())
    }

    /// The same settings with another target error.
    pub fn aiming_at(&self, target_error: f64) -> Self {
        Self {
            target_error,
            ..self.clone()
        }
    }

    /// The share of the strongest mode below which modes are dropped.
    pub fn weakest_mode(&self) -> f64 {
        self.mode_threshold
            .unwrap_or(self.target_error.min(COARSEST))
    }

    /// The share of its peak at which a footprint ends.
    pub fn footprint_edge(&self) -> f64 {
        self.footprint_threshold
            .unwrap_or(self.target_error.min(COARSEST))
    }

    /// Complex samples that one array may have: an eighth of the memory limit.
    pub fn samples_allowed(&self) -> usize {
        self.memory_limit / (8 * size_of::<num_complex::Complex64>())
    }
}
