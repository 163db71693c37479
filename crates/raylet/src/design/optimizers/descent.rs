//! Descents whose step lengths are set beforehand: gradient descent with momentum, and Adam.
//!
//! One evaluation a step, and no step is refused: for gradients with noise, and to repeat published designs.

use serde::{Deserialize, Serialize};

use crate::design::exact;
use crate::design::optimizers::reduction;
use crate::design::optimizers::schedule::Schedule;
use crate::design::optimizers::space::Space;
use crate::design::optimizers::step::{
    OptimizerError, SavedError, Step, Stop, demand, is_moderate,
};

/// What a step is made of. g is the gradient, each part times its parameter's scale; a step x changes a
/// parameter by −rate·scale·x.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Rule {
    /// x ← momentum·x + g (Polyak, 1964; signs and damping as in PyTorch's SGD).
    Momentum {
        /// What is left of the last step; 0 for plain descent.
        #[serde(with = "exact::number")]
        momentum: f64,
    },
    /// x = m̂/(√v̂ + ε), with running means m of g and v of g², each divided by what its weights add up to
    /// (Kingma and Ba, ICLR 2015).
    Adam {
        /// Weight of the past in the mean of g.
        #[serde(with = "exact::number")]
        beta1: f64,
        /// Weight of the past in the mean of g².
        #[serde(with = "exact::number")]
        beta2: f64,
        /// ε, in units of g. It is not small where gradients are as small.
        #[serde(with = "exact::number")]
        epsilon: f64,
    },
}

impl Rule {
    /// Adam with β 0.9 and 0.999 and ε = 1e-8, the values of its paper.
    pub const ADAM: Rule = Rule::Adam {
        beta1: 0.9,
        beta2: 0.999,
        epsilon: 1e-8,
    };

    fn check(&self) -> Result<(), OptimizerError> {
        let share = |name, value: f64| {
            let good = (0.0..1.0).contains(&value);
            demand(good, name, value, "at least 0 and less than 1")
        };
        match *self {
            Rule::Momentum { momentum } => share("momentum", momentum),
            Rule::Adam {
                beta1,
                beta2,
                epsilon,
            } => {
                share("beta1", beta1)?;
                share("beta2", beta2)?;
                let positive = epsilon > 0.0 && epsilon.is_finite();
                demand(positive, "epsilon", epsilon, "a positive number")
            }
        }
    }
}

/// A descent under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descent {
    rule: Rule,
    schedule: Schedule,
    space: Space,
    #[serde(with = "exact::list")]
    point: Vec<f64>,
    /// The last step, or the mean of g; and the mean of g², empty where the rule has none.
    #[serde(with = "exact::list")]
    first: Vec<f64>,
    #[serde(with = "exact::list")]
    second: Vec<f64>,
    /// The best point so far, and its value.
    #[serde(with = "exact::list")]
    best: Vec<f64>,
    #[serde(with = "exact::number")]
    best_value: f64,
    steps: usize,
    stopped: bool,
}

impl Descent {
    /// From a starting point, which is moved into the bounds.
    ///
    /// # Errors
    /// When the point does not fit the space or a setting is outside its range.
    pub(crate) fn new(
        start: Vec<f64>,
        space: Space,
        rule: Rule,
        schedule: Schedule,
    ) -> Result<Self, OptimizerError> {
        rule.check()?;
        schedule.check()?;
        let point = space.start(start)?;
        let second = match rule {
            Rule::Momentum { .. } => 0,
            Rule::Adam { .. } => point.len(),
        };
        Ok(Self {
            rule,
            schedule,
            first: vec![0.0; point.len()],
            second: vec![0.0; second],
            best: point.clone(),
            best_value: f64::INFINITY,
            point,
            space,
            steps: 0,
            stopped: false,
        })
    }

    /// Checks that a descent which was read can have begun as `fresh` did.
    ///
    /// # Errors
    /// Other settings or parameters, or what no descent leaves.
    pub(crate) fn check(&self, fresh: &Self) -> Result<(), SavedError> {
        let same =
            self.rule == fresh.rule && self.schedule == fresh.schedule && self.space == fresh.space;
        if !same {
            return Err(SavedError::Settings);
        }
        let first = self.first.len() == fresh.first.len();
        let second = self.second.len() == fresh.second.len();
        let known = is_moderate(self.best_value) || self.best_value == f64::INFINITY;
        for (name, good) in [
            ("point", self.space.holds(&self.point)),
            ("best point", self.space.holds(&self.best)),
            ("mean", first && self.first.iter().all(|x| is_moderate(*x))),
            (
                "mean square",
                second && self.second.iter().all(|x| is_moderate(*x) && *x >= 0.0),
            ),
            ("best value", known),
        ] {
            if !good {
                return Err(SavedError::Content(name));
            }
        }
        Ok(())
    }

    /// How many numbers are saved at most.
    pub(crate) fn saved_numbers(&self) -> usize {
        // Bounds, scales, two points and two means.
        7 * self.space.len()
    }

    /// Why it is over, if it is.
    pub(crate) fn stop(&self) -> Option<Stop> {
        self.stopped.then_some(Stop::NotFinite)
    }

    /// The space that it searches.
    pub(crate) fn space(&self) -> &Space {
        &self.space
    }

    /// The point at which the caller evaluates next.
    pub(crate) fn point(&self) -> &[f64] {
        &self.point
    }

    /// The best point so far, and its value. None before the first value.
    pub(crate) fn best(&self) -> Option<(&[f64], f64)> {
        let known = self.best_value.is_finite();
        known.then_some((&self.best, self.best_value))
    }

    /// Steps taken.
    pub(crate) fn iteration(&self) -> usize {
        self.steps
    }

    /// The function has changed, so the best value so far does not count. With `forget` the means do not count either.
    pub(crate) fn refresh(&mut self, forget: bool) {
        self.best_value = f64::INFINITY;
        self.stopped = false;
        if forget {
            self.first.fill(0.0);
            self.second.fill(0.0);
        }
    }

    /// Learns the value and the gradient at [`Descent::point`] and takes a step.
    ///
    /// # Panics
    /// When the gradient has another length than the point.
    pub(crate) fn report(&mut self, value: f64, gradient: &[f64]) -> Step {
        assert_eq!(gradient.len(), self.point.len(), "length of the gradient");
        self.stopped |= !(value.is_finite() && gradient.iter().all(|g| g.is_finite()));
        if self.stopped {
            return Step::Finished(Stop::NotFinite);
        }
        if value < self.best_value {
            self.best_value = value;
            self.best.copy_from_slice(&self.point);
        }
        let rate = self.schedule.rate(self.steps);
        self.steps += 1;
        match self.rule {
            Rule::Momentum { momentum } => self.roll(rate, momentum, gradient),
            Rule::Adam {
                beta1,
                beta2,
                epsilon,
            } => self.adapt(rate, [beta1, beta2], epsilon, gradient),
        }
        Step::Accepted
    }

    fn roll(&mut self, rate: f64, momentum: f64, gradient: &[f64]) {
        let (space, scales) = (&self.space, self.space.scales());
        reduction::change(&mut self.first, |i, x| {
            momentum * x + scales[i] * gradient[i]
        });
        let steps = &self.first;
        reduction::change(&mut self.point, |i, at| {
            space.moved(i, at, -rate * scales[i] * steps[i])
        });
    }

    fn adapt(&mut self, rate: f64, beta: [f64; 2], epsilon: f64, gradient: &[f64]) {
        let (space, scales) = (&self.space, self.space.scales());
        let g = |i: usize| scales[i] * gradient[i];
        let mix = |beta: f64, mean: f64, new: f64| beta * mean + (1.0 - beta) * new;
        reduction::change(&mut self.first, |i, mean| mix(beta[0], mean, g(i)));
        reduction::change(&mut self.second, |i, mean| mix(beta[1], mean, g(i) * g(i)));

        // Early means lack the weight of a past that was not; their divisors make up for it.
        let whole = beta.map(|beta| 1.0 - beta.powf(self.steps as f64));
        let (first, second) = (&self.first, &self.second);
        reduction::change(&mut self.point, |i, at| {
            let step = first[i] / whole[0] / ((second[i] / whole[1]).sqrt() + epsilon);
            space.moved(i, at, -rate * scales[i] * step)
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::descent::{Descent, Rule};
    use crate::design::optimizers::schedule::Schedule;
    use crate::design::optimizers::space::Space;
    use crate::design::optimizers::step::{Step, Stop};

    const RATE: Schedule = Schedule::Constant { rate: 0.1 };

    #[test]
    fn momentum_is_a_damped_oscillator() {
        // On λx²/2: z² − (1 + μ − rate·λ)z + μ = 0 for the decay z of a step; here |z|² = μ.
        let rule = Rule::Momentum { momentum: 0.81 };
        let mut descent = Descent::new(vec![1.0], Space::free(1), rule, RATE).unwrap();
        let (trace, product) = (1.81 - 0.1 * 4.0, 0.81);
        let mut seen = Vec::new();
        for _ in 0..40 {
            let x = descent.point()[0];
            seen.push(x);
            descent.report(2.0 * x * x, &[4.0 * x]);
        }
        for x in seen.windows(3) {
            assert!((x[2] - trace * x[1] + product * x[0]).abs() < 1e-14);
        }
    }

    #[test]
    fn adam_takes_the_steps_of_its_paper() {
        // By hand for gradients 1, then 3: m̂ and v̂ are means with weights (0.1, 0.09), (1e-3, 9.99e-4).
        let mut descent = Descent::new(vec![0.0], Space::free(1), Rule::ADAM, RATE).unwrap();
        descent.report(0.0, &[1.0]);
        assert!((descent.point()[0] + 0.1 / (1.0 + 1e-8)).abs() < 1e-15);
        let before = descent.point()[0];
        descent.report(0.0, &[3.0]);
        let mean = (0.09 * 1.0 + 0.1 * 3.0) / 0.19;
        let square: f64 = (9.99e-4 * 1.0 + 1e-3 * 9.0) / 1.999e-3;
        let step = 0.1 * mean / (square.sqrt() + 1e-8);
        assert!((before - descent.point()[0] - step).abs() < 1e-15);
    }

    #[test]
    fn scales_are_units_and_bounds_hold() {
        // A parameter in thousandths takes the same steps as one in wholes.
        for rule in [Rule::Momentum { momentum: 0.9 }, Rule::ADAM] {
            let space = Space::free(2).with_scale(1..2, 1e-3).unwrap();
            let space = space.with_bounds(0..1, -10.0, 10.0).unwrap();
            let space = space.with_bounds(1..2, -1e-2, 1e-2).unwrap();
            let mut descent = Descent::new(vec![1.0, 1e-3], space, rule, RATE).unwrap();
            for _ in 0..30 {
                let [x, y] = [descent.point()[0], 1e3 * descent.point()[1]];
                assert!((x - y).abs() < 1e-12);
                descent.report(x * x + y * y, &[2.0 * x, 2e3 * y]);
            }
            let best = descent.best().unwrap();
            assert!(best.1 < 1.0 && best.0[0].abs() < 0.7);
            for _ in 0..500 {
                descent.report(0.0, &[-9.0, 9e9]);
            }
            assert_eq!(descent.point(), [10.0, -1e-2].as_slice());
        }
    }

    #[test]
    fn what_is_no_number_ends_the_descent() {
        let mut descent = Descent::new(vec![1.0], Space::free(1), Rule::ADAM, RATE).unwrap();
        let end = Step::Finished(Stop::NotFinite);
        assert_eq!(descent.report(1.0, &[f64::NAN]), end);
        assert_eq!(descent.report(1.0, &[1.0]), end);
        assert_eq!(descent.point(), [1.0].as_slice());
        let rule = Rule::Momentum { momentum: 1.0 };
        assert!(Descent::new(vec![1.0], Space::free(1), rule, RATE).is_err());
    }
}
