//! A gradient beside its reference: the losses that are differentiated, and the relative error.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::math::random::uniform;

use crate::bounds::bound;

/// A real function of the field on a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Σ(I − T)² with a random image T.
    Image,
    /// Re Σ v* U with random v.
    Linear,
}

impl Loss {
    /// Formula of the loss, as the report shows it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image => "Σ(I − T)²",
            Self::Linear => "Re Σ v*U",
        }
    }

    /// Value of the loss for a field on the sensor, [y, x].
    pub fn value(self, field: &Array2<Complex64>) -> f64 {
        let term = |((j, i), u): ((usize, usize), &Complex64)| match self {
            Self::Image => (u.norm_sqr() - draw(j, i, 0)).powi(2),
            Self::Linear => (vector(j, i).conj() * u).re,
        };
        field.indexed_iter().map(term).sum()
    }

    /// Cotangent of the field U, ∂L/∂Re U + i ∂L/∂Im U, [y, x].
    pub fn bar(self, field: &Array2<Complex64>) -> Array2<Complex64> {
        Array2::from_shape_fn(field.dim(), |(j, i)| match self {
            Self::Image => {
                let u = field[[j, i]];
                4.0 * (u.norm_sqr() - draw(j, i, 0)) * u
            }
            Self::Linear => vector(j, i),
        })
    }
}

fn draw(j: usize, i: usize, part: u32) -> f64 {
    uniform(17, [j as u32, i as u32, part, 0])
}

fn vector(j: usize, i: usize) -> Complex64 {
    Complex64::new(draw(j, i, 1) - 0.5, draw(j, i, 2) - 0.5)
}

/// One gradient, and the reference to which it is compared.
pub struct Comparison {
    /// Description of the system and of the parameters, as the report shows it.
    pub name: String,
    /// Formula of the loss that is differentiated.
    pub loss: &'static str,
    /// Name of the reference.
    pub reference: &'static str,
    /// raylet's gradient and the reference's, entry by entry.
    run: Box<dyn Fn() -> Result<[Vec<f64>; 2], LinearisedSystemError>>,
}

impl Comparison {
    /// A comparison of real entries; `run` returns those of raylet and of the reference.
    pub fn new(
        name: String,
        loss: &'static str,
        reference: &'static str,
        run: Box<dyn Fn() -> Result<[Vec<f64>; 2], LinearisedSystemError>>,
    ) -> Self {
        Self {
            name,
            loss,
            reference,
            run,
        }
    }

    /// The largest error allowed; nothing where none is recorded.
    pub fn bound(&self) -> Option<f64> {
        bound(&format!("{} | {}", self.name, self.loss))
    }

    /// The relative L2 error, and the number of entries.
    ///
    /// # Errors
    /// When raylet refuses the system.
    pub fn measure(&self) -> Result<(f64, usize), LinearisedSystemError> {
        let [ours, exact] = (self.run)()?;
        let square = |list: &mut dyn Iterator<Item = f64>| list.map(|v| v * v).sum::<f64>();
        let off = square(&mut ours.iter().zip(&exact).map(|(a, b)| a - b));
        let norm = square(&mut exact.iter().copied());
        Ok(((off / norm).sqrt(), exact.len()))
    }
}
