//! The record of a forward pass, which the adjoint reads, and the gradient that the adjoint returns.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::chain::screen_sensitivity::ScreenFields;
use crate::engine::local_bands::carry::KeptHop;
use crate::wave::grid::field::Field;

/// The record of a forward pass, for the adjoint: the field on the sensor and the light on the screens before it.
#[derive(Clone, Debug)]
pub struct ForwardPass {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// The light on every screen before it.
    pub light: PassedLight,
}

/// The light of a run on all screens but the sensor.
#[derive(Clone, Debug)]
pub enum PassedLight {
    /// As whole fields.
    Fields(Vec<ScreenFields>),
    /// As beamlets, of a run by local bands.
    Beamlets(Vec<KeptHop>),
}

impl ForwardPass {
    /// The whole fields on all screens but the sensor; none of a run by local bands.
    pub fn screens(&self) -> &[ScreenFields] {
        match &self.light {
            PassedLight::Fields(screens) => screens,
            PassedLight::Beamlets(_) => &[],
        }
    }

    /// ∫|U|² just behind the first screen, in mm² for unit amplitude; nothing of a run by local bands, which has no
    /// field there.
    pub(crate) fn power_behind(&self) -> Option<f64> {
        self.screens().first().map(|first| first.behind.power())
    }
}

/// The gradient of a loss L by the pixels and parameters of a system.
#[derive(Clone, Debug, Default)]
pub struct Gradient {
    /// For each screen the cotangent of the transmission t of its pixels, [y, x]: ∂L/∂Re t + i ∂L/∂Im t; `None` on a
    /// screen without pixels.
    pub pixels: Vec<Option<Array2<Complex64>>>,
    /// ∂L/∂q for each parameter q, in one over the unit of q.
    pub parameters: Vec<f64>,
}
