//! How the step length of a descent changes from iteration to iteration.

use serde::{Deserialize, Serialize};

use crate::design::exact;
use crate::design::optimizers::step::{OptimizerError, demand};

/// Step lengths (learning rates), in scales of the parameters: radians for phases of scale 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// Always the same.
    Constant {
        /// The length.
        #[serde(with = "exact::number")]
        rate: f64,
    },
    /// Half a cosine from one length down to another (Loshchilov and Hutter, ICLR 2017, without
    /// restarts): `to` + (`from` − `to`)·(1 + cos(πt/`iterations`))/2, and `to` ever after.
    Cosine {
        /// Length of the first step.
        #[serde(with = "exact::number")]
        from: f64,
        /// Length after the last.
        #[serde(with = "exact::number")]
        to: f64,
        /// How many steps lie between.
        iterations: usize,
    },
    /// `rate`·`factor`^⌊t/`every`⌋.
    Steps {
        /// Length of the first step.
        #[serde(with = "exact::number")]
        rate: f64,
        /// By what it is multiplied.
        #[serde(with = "exact::number")]
        factor: f64,
        /// After how many steps.
        every: usize,
    },
}

impl Schedule {
    /// Length of step `t`, counted from 0.
    pub(crate) fn rate(&self, t: usize) -> f64 {
        match *self {
            Self::Constant { rate } => rate,
            Self::Cosine { to, iterations, .. } if t >= iterations => to,
            Self::Cosine {
                from,
                to,
                iterations,
            } => {
                let turn = std::f64::consts::PI * t as f64 / iterations as f64;
                to + 0.5 * (from - to) * (1.0 + turn.cos())
            }
            Self::Steps {
                rate,
                factor,
                every,
            } => rate * factor.powf((t / every) as f64),
        }
    }

    /// Whether every length makes sense.
    ///
    /// # Errors
    /// When one is not a positive number or a schedule takes no steps.
    pub(crate) fn check(&self) -> Result<(), OptimizerError> {
        let positive = |name, value: f64| {
            let good = value > 0.0 && value.is_finite();
            demand(good, name, value, "a positive number")
        };
        match *self {
            Self::Constant { rate } => positive("rate", rate),
            Self::Cosine {
                from,
                to,
                iterations,
            } => {
                positive("from", from)?;
                demand(to >= 0.0 && to.is_finite(), "to", to, "none below zero")?;
                positive("iterations", iterations as f64)
            }
            Self::Steps {
                rate,
                factor,
                every,
            } => {
                positive("rate", rate)?;
                positive("factor", factor)?;
                positive("every", every as f64)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::schedule::Schedule;

    #[test]
    fn schedules_start_and_end_where_they_say() {
        let cosine = Schedule::Cosine {
            from: 25.0,
            to: 5.0,
            iterations: 50,
        };
        let rates = [0, 25, 50, 99].map(|t| cosine.rate(t));
        assert!((rates[1] - 15.0).abs() < 1e-14);
        assert_eq!([rates[0], rates[2], rates[3]], [25.0, 5.0, 5.0]);
        let steps = Schedule::Steps {
            rate: 1.0,
            factor: 0.5,
            every: 10,
        };
        assert_eq!([0, 9, 10, 20].map(|t| steps.rate(t)), [1.0, 1.0, 0.5, 0.25]);
        assert_eq!(Schedule::Constant { rate: 10.0 }.rate(77), 10.0);

        let none = Schedule::Steps {
            rate: 1.0,
            factor: 0.5,
            every: 0,
        };
        assert!(none.check().is_err() && steps.check().is_ok() && cosine.check().is_ok());
        assert!(Schedule::Constant { rate: f64::NAN }.check().is_err());
    }
}
