//! What may be chosen about a run with local bands.

use crate::wave::local_bands::tiling::WindowShape;

/// How light is carried by local bands.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalBandSettings {
    /// Width σ of the windows of each screen but the last, in mm.
    pub sigmas: Vec<f64>,
    /// Distance of neighbouring windows in σ.
    pub step: f64,
    /// Period of the plane waves of a window in σ.
    pub period: f64,
    /// Plane waves weaker than this share of the light's are left out; beamlets end at this share of their peak.
    pub threshold: f64,
    /// Windows along each side of a tile.
    pub tile: usize,
    /// Nodes per σ where an edge cuts a window.
    pub edge_nodes: f64,
    /// Whether the aberration inside beamlets is made good.
    pub corrected: bool,
    /// What the opening of the first screen does where that is a stop.
    pub opening: SourceOpening,
}

/// What the opening of the first screen does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SourceOpening {
    /// It only says where windows stand: the light falls off by itself. For openings wider than what comes next.
    #[default]
    Soft,
    /// It cuts the light, which is diffracted.
    Hard,
}

/// Distance of the windows of a smooth source in σ: their sum is even to 1e-5.
pub const SOURCE_STEP: f64 = 1.25;

/// The usual distance of windows in σ.
pub const STEP: f64 = 1.25;

impl LocalBandSettings {
    /// The usual settings with these widths of windows.
    pub fn new(sigmas: Vec<f64>) -> Self {
        Self {
            sigmas,
            step: STEP,
            period: 6.5,
            threshold: 1e-3,
            tile: 4,
            edge_nodes: 16.0,
            corrected: true,
            opening: SourceOpening::Soft,
        }
    }

    /// The windows of a screen; nothing where no width is given.
    pub fn windows(&self, screen: usize) -> Option<WindowShape> {
        let sigma = *self.sigmas.get(screen)?;
        (sigma > 0.0).then_some(WindowShape {
            sigma,
            step: self.step,
            period: self.period,
        })
    }
}
