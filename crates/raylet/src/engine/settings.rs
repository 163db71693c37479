//! What a user may choose about a run.

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
    /// Distance of windows in σ.
    pub step: f64,
    /// Period of a patch in σ.
    pub period: f64,
    /// Modes weaker than this share of the strongest are dropped.
    pub mode_threshold: f64,
    /// Footprints end where the Gaussian falls below this.
    pub footprint_threshold: f64,
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

/// The knobs of the source paper's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Incident rays: random positions on the aperture dilated by half a patch.
    pub rays: usize,
    /// Secondary rays drawn per incident ray, with probability ∝ |c|.
    pub secondary: usize,
    /// Side of the square patch, in mm; a quarter of the screen when absent.
    pub patch: Option<f64>,
    /// Period of a patch over its side.
    pub padding: f64,
    /// How far the lattice of modes goes, in bands of the pixels' FFT: 1 is that band itself, ±λ/2h for
    /// pixels of width h; more take in the higher orders of the pixels, as far as they propagate.
    pub orders: usize,
    /// Whether positions are drawn on the aperture itself instead: its rim is then covered too thinly.
    pub inside: bool,
    /// Whether each wavelet is multiplied by the cosine ⟨n, d⟩ at the sensor.
    pub obliquity: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            target_error: 1e-3,
            sigma: None,
            step: 1.5,
            period: 6.0,
            mode_threshold: 1e-3,
            footprint_threshold: 1e-3,
            correction: Correction::Auto,
            padding: 4.0,
            nufft_tolerance: 1e-6,
            paper: Paper {
                rays: 1000,
                secondary: 1000,
                patch: None,
                padding: 2.0,
                orders: 1,
                inside: false,
                obliquity: false,
            },
            seed: 1,
            memory_limit: 4 << 30,
        }
    }
}

impl Settings {
    /// Complex samples that one array may have: an eighth of the memory limit.
    pub fn samples_allowed(&self) -> usize {
        self.memory_limit / (8 * size_of::<num_complex::Complex64>())
    }
}
