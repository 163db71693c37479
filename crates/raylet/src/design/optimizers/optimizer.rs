//! Optimisers: they give a point, and the caller reports value and gradient there.
//!
//! The caller owns the loop: it computes value and gradient at [`Optimizer::point`] and reports them; it may
//! stop after any evaluation, save the optimiser with serde, and go on later bit for bit.

use serde::{Deserialize, Serialize};

use crate::design::optimizers::descent::{Descent, Rule};
use crate::design::optimizers::lbfgs::{Lbfgs, LbfgsSettings};
use crate::design::optimizers::schedule::Schedule;
use crate::design::optimizers::space::Space;
use crate::design::optimizers::step::{OptimizerError, SavedError, Step, Stop};

/// How to look for a minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// L-BFGS, for exact gradients.
    Lbfgs(LbfgsSettings),
    /// Steps of lengths set beforehand.
    Descent(Rule, Schedule),
}

impl Method {
    /// The search from a starting point, which is moved into the bounds.
    ///
    /// # Errors
    /// When the point does not fit the space or a setting is outside its range.
    pub fn start(self, point: Vec<f64>, space: Space) -> Result<Optimizer, OptimizerError> {
        Ok(match self {
            Self::Lbfgs(settings) => Optimizer::Lbfgs(Lbfgs::new(point, space, settings)?),
            Self::Descent(rule, schedule) => {
                Optimizer::Descent(Descent::new(point, space, rule, schedule)?)
            }
        })
    }
}

/// Bytes of a number of a saved list, a little more than its base64, and of all single numbers and names.
pub(crate) const SAVED_NUMBER: u64 = 12;
const SAVED_NAMES: u64 = 1 << 16;

/// A search under way, by any of the methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Optimizer {
    /// By L-BFGS.
    Lbfgs(Lbfgs),
    /// By steps of lengths set beforehand.
    Descent(Descent),
}

impl Optimizer {
    /// Checks that a search which was read can have begun as `fresh` did, and can go on.
    ///
    /// # Errors
    /// Another method, other settings or parameters, or what no search leaves.
    pub fn check(&self, fresh: &Self) -> Result<(), SavedError> {
        match (self, fresh) {
            (Self::Lbfgs(search), Self::Lbfgs(fresh)) => search.check(fresh),
            (Self::Descent(search), Self::Descent(fresh)) => search.check(fresh),
            _ => Err(SavedError::Method),
        }
    }

    /// The most bytes that it takes as text when it is saved.
    pub fn saved_bytes(&self) -> u64 {
        let numbers = match self {
            Self::Lbfgs(search) => search.saved_numbers(),
            Self::Descent(search) => search.saved_numbers(),
        };
        SAVED_NUMBER * numbers as u64 + SAVED_NAMES
    }

    /// The space that it searches.
    pub(crate) fn space(&self) -> &Space {
        match self {
            Self::Lbfgs(search) => search.space(),
            Self::Descent(search) => search.space(),
        }
    }

    /// Why it is over, if it is.
    pub(crate) fn stop(&self) -> Option<Stop> {
        match self {
            Self::Lbfgs(search) => search.stop(),
            Self::Descent(search) => search.stop(),
        }
    }

    /// The point at which the caller evaluates next.
    pub fn point(&self) -> &[f64] {
        match self {
            Self::Lbfgs(search) => search.point(),
            Self::Descent(search) => search.point(),
        }
    }

    /// Learns the value and the gradient there.
    ///
    /// # Panics
    /// When the gradient has another length than the point.
    pub fn report(&mut self, value: f64, gradient: &[f64]) -> Step {
        match self {
            Self::Lbfgs(search) => search.report(value, gradient),
            Self::Descent(search) => search.report(value, gradient),
        }
    }

    /// The best point that ended an iteration, and its value; none before the first value.
    pub fn best(&self) -> Option<(&[f64], f64)> {
        match self {
            Self::Lbfgs(search) => search.best(),
            Self::Descent(search) => search.best(),
        }
    }

    /// Iterations done.
    pub fn iteration(&self) -> usize {
        match self {
            Self::Lbfgs(search) => search.iteration(),
            Self::Descent(search) => search.iteration(),
        }
    }

    /// The function has changed (a sharper staircase, another choice of rays): values so far do not
    /// compare with those to come. `forget`: nor do gradients.
    pub(crate) fn refresh(&mut self, forget: bool) {
        match self {
            Self::Lbfgs(search) => search.refresh(forget),
            Self::Descent(search) => search.refresh(forget),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::descent::Rule;
    use crate::design::optimizers::lbfgs::LbfgsSettings;
    use crate::design::optimizers::optimizer::{Method, Optimizer};
    use crate::design::optimizers::schedule::Schedule;
    use crate::design::optimizers::space::Space;
    use crate::design::optimizers::step::Step;

    /// Rosenbrock's function in many dimensions, with its gradient; no number beyond a wall.
    fn rosenbrock(x: &[f64]) -> (f64, Vec<f64>) {
        let (mut value, mut gradient) = (0.0, vec![0.0; x.len()]);
        for i in 0..x.len() - 1 {
            let (bend, rest) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
            value += 100.0 * bend * bend + rest * rest;
            gradient[i] += -400.0 * bend * x[i] - 2.0 * rest;
            gradient[i + 1] += 200.0 * bend;
        }
        let wall = x.iter().any(|x| x.abs() > 50.0);
        (if wall { f64::NAN } else { value }, gradient)
    }

    fn methods() -> [Method; 3] {
        let rate = Schedule::Cosine {
            from: 1e-2,
            to: 1e-4,
            iterations: 90,
        };
        let settings = LbfgsSettings {
            memory: 5,
            first: 900.0,
            ..LbfgsSettings::default()
        };
        [
            Method::Lbfgs(settings),
            Method::Descent(Rule::ADAM, rate),
            Method::Descent(
                Rule::Momentum { momentum: 0.7 },
                Schedule::Constant { rate: 1e-4 },
            ),
        ]
    }

    fn started(method: Method) -> Optimizer {
        let space = Space::free(40).with_bounds(3..7, -0.5, 0.5).unwrap();
        let space = space.with_scale(10..20, 0.3).unwrap();
        let start = (0..40).map(|i| [-1.2, 1.0][i % 2]).collect();
        method.start(start, space).unwrap()
    }

    #[test]
    fn written_down_after_every_evaluation_and_read_again_it_goes_on_bit_for_bit() {
        for method in methods() {
            let (mut through, mut stopped) = (started(method), started(method));
            for step in 0..90 {
                if step == 60 {
                    through.refresh(true);
                    stopped.refresh(true);
                }
                let (value, gradient) = rosenbrock(through.point());
                let here = through.report(value, &gradient);
                let (value, gradient) = rosenbrock(stopped.point());
                assert_eq!(stopped.report(value, &gradient), here);
                let text = serde_json::to_string(&stopped).unwrap();
                assert!(text.len() as u64 <= stopped.saved_bytes());
                stopped = serde_json::from_str(&text).unwrap();
                assert_eq!(stopped.check(&started(method)), Ok(()));
                let bits = |search: &Optimizer| {
                    let point = search.point().iter().map(|x| x.to_bits());
                    point.collect::<Vec<_>>()
                };
                assert_eq!(bits(&through), bits(&stopped), "step {step}");
            }
            assert_eq!(through, stopped);
        }
    }

    #[test]
    fn every_method_descends_and_knows_its_best() {
        for method in methods() {
            let mut search = started(method);
            assert_eq!(search.best(), None);
            let (first, _) = rosenbrock(search.point());
            let mut least = f64::INFINITY;
            for _ in 0..200 {
                let (value, gradient) = rosenbrock(search.point());
                match search.report(value, &gradient) {
                    Step::Accepted => least = least.min(value),
                    Step::Trial | Step::Restarted => {}
                    Step::Finished(_) => break,
                }
            }
            let (point, value) = search.best().unwrap();
            assert_eq!(rosenbrock(point).0, value);
            assert!(value <= least && value < 0.5 * first, "{value} {first}");
            assert!(search.iteration() > 0);
        }
    }

    #[test]
    fn same_bits_for_any_number_of_threads() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let count = 30_000;
                let start = (0..count).map(|i| [-1.2, 1.0][i % 2]).collect();
                let method = Method::Lbfgs(LbfgsSettings::default());
                let mut search = method.start(start, Space::free(count)).unwrap();
                for _ in 0..25 {
                    let (value, gradient) = rosenbrock(search.point());
                    search.report(value, &gradient);
                }
                let bits = search.point().iter().map(|x| x.to_bits());
                bits.collect::<Vec<_>>()
            })
        };
        assert_eq!(run(1), run(3));
    }
}
