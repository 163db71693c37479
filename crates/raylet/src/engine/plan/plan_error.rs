//! Why a hop has no plan.

use num_complex::Complex64;

use crate::engine::plan::settings::BYTES_OF_SAMPLE;

/// Bytes of the memory limit for each plane wave of a hop without rays: they and one intermediate array must fit.
pub(crate) const BYTES_OF_DIRECTION: usize = 2 * size_of::<Complex64>();

/// Why no plan exists.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// No ray gets from one screen to the next.
    #[error("no ray from '{from}' reaches '{to}'{causes}")]
    Dark {
        /// Emitting screen.
        from: String,
        /// Receiving screen.
        to: String,
        /// How the rays of the search were lost.
        causes: String,
    },
    /// Plane wavelets start from planes.
    #[error(
        "method '{method}' does not start from curved screens such as '{screen}'; use beamlet or auto"
    )]
    Curved {
        /// The method.
        method: &'static str,
        /// Emitting screen.
        screen: String,
    },
    /// Whole fields do not cross interfaces.
    #[error(
        "element '{0}' has one medium before it and another behind it, which whole fields do not cross; the method \
         local_bands carries it"
    )]
    TwoMedia(String),
    /// Local bands have no field that is sampled as a whole.
    #[error("method 'local_bands' samples no field as a whole, as from '{from}' to '{to}'")]
    WholeField {
        /// Emitting screen.
        from: String,
        /// Receiving screen.
        to: String,
    },
    /// A screen has no edge.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
    /// The spectrum of one patch would be larger than allowed.
    #[error(
        "a patch of screen '{screen}' has {modes:?} modes, more than the {allowed} allowed; reduce \
         sigma_um, or of the paper's method patch_um or padding, or raise memory_limit_mb"
    )]
    Modes {
        /// Emitting screen.
        screen: String,
        /// Modes along x and y.
        modes: [usize; 2],
        /// Modes allowed altogether.
        allowed: usize,
    },
    /// There would be more patches than fit into memory.
    #[error(
        "screen '{screen}' takes {patches:?} patches, more than the {allowed} allowed; raise sigma_um or \
         memory_limit_mb"
    )]
    Patches {
        /// Emitting screen.
        screen: String,
        /// Patches along x and y.
        patches: [usize; 2],
        /// Patches allowed altogether.
        allowed: usize,
    },
    /// A free hop needs more plane waves than allowed.
    #[error(
        "from '{from}' to '{to}' it takes {directions:?} plane waves, more than the {allowed} allowed; \
         reduce the size of a screen, or raise memory_limit_mb"
    )]
    Directions {
        /// Emitting screen.
        from: String,
        /// Receiving screen.
        to: String,
        /// Plane waves along x and y.
        directions: [usize; 2],
        /// Plane waves allowed altogether.
        allowed: usize,
    },
    /// Sizes, distances and widths lie so far apart that the numbers of the plan are not finite.
    #[error("the plan from '{from}' to '{to}' has numbers that are not finite")]
    NotFinite {
        /// Emitting screen.
        from: String,
        /// Receiving screen.
        to: String,
    },
}

impl PlanError {
    /// The memory limit in bytes at which this plan would not be too large; nothing if it is refused for another reason.
    pub(crate) fn memory_needed(&self) -> Option<usize> {
        let (counts, bytes) = match self {
            Self::Modes { modes, .. } => (modes, BYTES_OF_SAMPLE),
            Self::Patches { patches, .. } => (patches, BYTES_OF_SAMPLE),
            Self::Directions { directions, .. } => (directions, BYTES_OF_DIRECTION),
            _ => return None,
        };
        Some(counts[0].saturating_mul(counts[1]).saturating_mul(bytes))
    }
}
