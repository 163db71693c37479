//! A control variate: beamlets that are drawn estimate only how far the light has changed since a run in
//! which all were followed.
//!
//! A hop is linear, U = A·u. With an exact evaluation at u₀ and an estimate Â of the operator, U ≈ A·u₀ + Â·(u − u₀), and the
//! cotangent ū = Aᴴ·Ū₀ + Âᴴ·(Ū − Ū₀): the noise vanishes with the distance from u₀ (Johnson and Zhang, NIPS
//! 2013, applied to the field instead of the gradient, so that a loss of |U|² is hardly biased either).

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::chain::forward_pass::{ForwardPass, Gradient, PassedLight};
use crate::engine::chain::linearised_system::LinearisedSystem;
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::chain::screen_sensitivity::ScreenFields;
use crate::engine::progress::Pulse;
use crate::optics::system::System;
use crate::wave::grid::field::Field;
use crate::wave::grid::sampling::apply_screen_adjoint;

/// An exact evaluation from which estimates start.
#[derive(Clone, Debug)]
pub struct ControlVariate {
    field: Field,
    behind: Field,
    field_bar: Array2<Complex64>,
    behind_bar: Field,
}

impl ControlVariate {
    /// Looks at a system with one element and its sensor; `field_bar` gives the cotangent of the field there.
    ///
    /// # Errors
    /// [`LinearisedSystemError::ControlVariate`] when there are more screens; as [`LinearisedSystem::forward`] and
    /// `field_bar`; when the pulse cancels the work.
    pub fn new<E: From<LinearisedSystemError>>(
        linearised: &LinearisedSystem,
        system: &System,
        pulse: &Pulse,
        field_bar: impl FnOnce(&Field) -> Result<Array2<Complex64>, E>,
    ) -> Result<Self, E> {
        let passed = linearised.pass(system)?;
        let field = linearised.propagate(system, &passed.behind, pulse)?;
        let field_bar = field_bar(&field)?;
        let behind_bar = linearised.propagate_adjoint(system, &passed.behind, &field_bar, pulse)?;
        Ok(Self {
            field,
            behind: passed.behind,
            field_bar,
            behind_bar,
        })
    }

    /// What has changed behind the element.
    fn change(&self, behind: &Field) -> Field {
        Field {
            grid: behind.grid.clone(),
            values: &behind.values - &self.behind.values,
        }
    }

    /// The field on the sensor, by a linearised system whose beamlets are drawn.
    ///
    /// # Errors
    /// As [`ControlVariate::new`].
    pub fn forward(
        &self,
        drawn: &LinearisedSystem,
        system: &System,
        pulse: &Pulse,
    ) -> Result<ForwardPass, LinearisedSystemError> {
        let passed = drawn.pass(system)?;
        let mut field = drawn.propagate(system, &self.change(&passed.behind), pulse)?;
        field.values += &self.field.values;
        Ok(ForwardPass {
            field,
            light: PassedLight::Fields(vec![passed]),
        })
    }

    /// The gradient of the element's pixels, from the same draws: the conjugate transpose of [`ControlVariate::forward`]
    /// but for what the exact run gives; `control_variate_dot_product` in the crate's tests holds it.
    ///
    /// # Errors
    /// As [`ControlVariate::new`].
    pub fn forward_adjoint(
        &self,
        drawn: &LinearisedSystem,
        system: &System,
        trace: &ForwardPass,
        field_bar: &Array2<Complex64>,
        pulse: &Pulse,
    ) -> Result<Gradient, LinearisedSystemError> {
        let [ScreenFields { arrived, behind }] = trace.screens() else {
            return Err(LinearisedSystemError::ControlVariate(trace.screens().len()));
        };
        let turned = field_bar - &self.field_bar;
        let mut bar = drawn.propagate_adjoint(system, &self.change(behind), &turned, pulse)?;
        bar.values += &self.behind_bar.values;
        let pixels = apply_screen_adjoint(&system.screens[0], arrived, &mut bar);
        Ok(Gradient {
            pixels: vec![pixels],
            parameters: Vec::new(),
        })
    }
}
