//! A line search that ends where the strong Wolfe conditions hold.
//!
//! Moré and Thuente, "Line search algorithms with guaranteed sufficient decrease" (ACM Trans. Math. Softw.
//! 20, 286, 1994), as in MINPACK-2's `dcsrch`: cubic and quadratic interpolation inside an interval that
//! is known to hold an acceptable step and shrinks by a third at least every other time. The search
//! calls no function: the caller reports value and slope at each trial.

use serde::{Deserialize, Serialize};

use crate::design::exact;

/// Least share of the decrease that the first slope promises: φ(α) ≤ φ(0) + DECREASE·α·φ′(0).
const DECREASE: f64 = 1e-3;

/// Largest slope left, as a share of the first: |φ′(α)| ≤ CURVATURE·|φ′(0)|.
const CURVATURE: f64 = 0.9;

/// The interval is small enough when it is this share of its larger end.
const NARROW: f64 = 0.1;

/// Before a minimum is bracketed, the next trial goes beyond the last one by between these multiples of the last
/// trial's distance from the best step before it.
const ADVANCE: [f64; 2] = [1.1, 4.0];

/// A bracket that did not shrink to this share in two trials is halved.
const SHRINK: f64 = 0.66;

/// Trials of one search.
const TRIALS: u32 = 20;

/// A step α, the value φ(α) there and the slope φ′(α).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sample {
    /// α.
    #[serde(with = "exact::number")]
    pub step: f64,
    /// φ(α).
    #[serde(with = "exact::number")]
    pub value: f64,
    /// φ′(α).
    #[serde(with = "exact::number")]
    pub slope: f64,
}

impl Sample {
    /// Of φ(α) − slope·α.
    fn tilted(self, slope: f64) -> Self {
        Self {
            value: self.value - slope * self.step,
            slope: self.slope - slope,
            ..self
        }
    }
}

/// What a search says of the sample that was reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineSearchReply {
    /// Good enough.
    Enough,
    /// Another one is to be looked at: [`Search::trial`].
    Again,
    /// No step will do.
    Hopeless,
}

/// A search under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Search {
    start: Sample,
    /// The ends of the interval: the best sample yet, and another one.
    best: Sample,
    other: Sample,
    bracketed: bool,
    /// Until a step with enough decrease and a slope that is not negative is seen.
    first_stage: bool,
    #[serde(with = "exact::number")]
    trial: f64,
    #[serde(with = "exact::number")]
    most: f64,
    /// Where the next trial may be.
    #[serde(with = "exact::number")]
    from: f64,
    #[serde(with = "exact::number")]
    to: f64,
    /// Widths of the interval one and two trials ago.
    #[serde(with = "exact::number")]
    width: f64,
    #[serde(with = "exact::number")]
    last_width: f64,
    trials: u32,
}

impl Search {
    /// From the value and the (negative) slope at step 0; the first trial and the largest step.
    pub(crate) fn new(value: f64, slope: f64, trial: f64, most: f64) -> Self {
        let start = Sample {
            step: 0.0,
            value,
            slope,
        };
        Self {
            start,
            best: start,
            other: start,
            bracketed: false,
            first_stage: true,
            trial,
            most,
            from: 0.0,
            to: (1.0 + ADVANCE[1]) * trial,
            width: most,
            last_width: 2.0 * most,
            trials: 0,
        }
    }

    /// Whether a search can have come to be so: one that was read may be anything.
    pub(crate) fn is_sound(&self) -> bool {
        let samples = [self.start, self.best, self.other];
        let finite = |sample: &Sample| {
            let numbers = [sample.step, sample.value, sample.slope];
            numbers.iter().all(|number| number.is_finite())
        };
        let ahead = [self.trial, self.from, self.to, self.width, self.last_width];
        samples.iter().all(finite)
            && ahead.iter().all(|length| length.is_finite())
            && self.start.step == 0.0
            && self.start.slope < 0.0
            && (0.0..=self.most).contains(&self.trial)
            && self.most.is_finite()
            && self.from <= self.to
            && self.trials < TRIALS
    }

    /// The step to be looked at.
    pub(crate) fn trial_step(&self) -> f64 {
        self.trial
    }

    /// Learns the value and the slope at the trial step.
    pub(crate) fn report(&mut self, value: f64, slope: f64) -> LineSearchReply {
        self.trials += 1;
        if !(value.is_finite() && slope.is_finite()) {
            return self.retreat();
        }
        let seen = Sample {
            step: self.trial,
            value,
            slope,
        };
        let promised = DECREASE * self.start.slope;
        let enough = self.start.value + seen.step * promised;
        if self.first_stage && value <= enough && slope >= 0.0 {
            self.first_stage = false;
        }
        if let Some(judgement) = self.judge(&seen, enough, promised) {
            return judgement;
        }

        // Until the decrease is enough, the search is for a minimum of what exceeds the promised decrease.
        if self.first_stage && value <= self.best.value && value > enough {
            self.best = self.best.tilted(promised);
            self.other = self.other.tilted(promised);
            self.narrow(seen.tilted(promised));
            self.best = self.best.tilted(-promised);
            self.other = self.other.tilted(-promised);
        } else {
            self.narrow(seen);
        }
        self.choose();
        LineSearchReply::Again
    }

    /// Whether the search is over.
    fn judge(&self, seen: &Sample, enough: f64, promised: f64) -> Option<LineSearchReply> {
        let decreased = seen.value <= enough;
        if decreased && seen.slope.abs() <= CURVATURE * -self.start.slope {
            return Some(LineSearchReply::Enough);
        }
        // At the largest step and still going down; or rounding leaves no room between the ends.
        let end = seen.step == self.most && decreased && seen.slope <= promised;
        let outside = seen.step <= self.from || seen.step >= self.to;
        let narrow = self.to - self.from <= NARROW * self.to;
        let over = self.bracketed && (outside || narrow) || self.trials >= TRIALS;
        match (end || over, decreased && seen.value < self.start.value) {
            (true, true) => Some(LineSearchReply::Enough),
            (true, false) => Some(LineSearchReply::Hopeless),
            (false, _) => None,
        }
    }

    /// The function has no value at the trial. The next trial is halfway back to the best step, and no later one goes
    /// beyond it.
    fn retreat(&mut self) -> LineSearchReply {
        if self.trials >= TRIALS {
            return LineSearchReply::Hopeless;
        }
        self.trial = self.best.step + 0.5 * (self.trial - self.best.step);
        self.most = self.most.min(self.trial);
        LineSearchReply::Again
    }

    /// Takes a sample into the interval; the next trial by interpolation.
    fn narrow(&mut self, seen: Sample) {
        let (next, brackets) = self.interpolate(&seen);
        if seen.value > self.best.value {
            self.other = seen;
        } else {
            if seen.slope * self.best.slope.signum() < 0.0 {
                self.other = self.best;
            }
            self.best = seen;
        }
        self.bracketed |= brackets;
        self.trial = next;
    }

    /// The next trial, and whether the sample brackets a minimum with the best one: the four cases of the
    /// paper's section 4.
    fn interpolate(&self, seen: &Sample) -> (f64, bool) {
        let best = &self.best;
        let secant = seen.step + seen.slope / (seen.slope - best.slope) * (best.step - seen.step);

        // 1. A higher value: the cubic's minimum if it is nearer to the best step than the parabola's,
        //    else halfway between them.
        if seen.value > best.value {
            let cubic = minimum(best, seen, best);
            let fall = (best.value - seen.value) / (seen.step - best.step) + best.slope;
            let parabola = best.step + 0.5 * (best.slope / fall) * (seen.step - best.step);
            let nearer = (cubic - best.step).abs() < (parabola - best.step).abs();
            let next = if nearer {
                cubic
            } else {
                cubic + 0.5 * (parabola - cubic)
            };
            return (next, true);
        }

        // 2. Lower, with slopes of opposite signs: the farther of the cubic's and the secant's minimum.
        if seen.slope * best.slope.signum() < 0.0 {
            let cubic = minimum(seen, best, seen);
            let farther = (cubic - seen.step).abs() > (secant - seen.step).abs();
            return (if farther { cubic } else { secant }, true);
        }

        // 3. Lower, and less steep. 4. Lower, and no less steep.
        if seen.slope.abs() < best.slope.abs() {
            return (self.extrapolated(seen, secant), false);
        }
        let next = match (self.bracketed, seen.step > best.step) {
            (true, _) => minimum(seen, &self.other, seen),
            (false, true) => self.to.min(self.most),
            (false, false) => self.from,
        };
        (next, false)
    }

    /// Case 3: the cubic may have no minimum behind the sample.
    fn extrapolated(&self, seen: &Sample, secant: f64) -> f64 {
        let best = &self.best;
        let forward = seen.step > best.step;
        let (reach, gamma) = cubic_reach(seen, best);
        let cubic = if reach < 0.0 && gamma != 0.0 {
            seen.step + reach * (best.step - seen.step)
        } else if forward {
            self.to
        } else {
            self.from
        };
        let nearer = (cubic - seen.step).abs() < (secant - seen.step).abs();
        if !self.bracketed {
            let farther = if nearer { secant } else { cubic };
            return farther.clamp(self.from, self.to);
        }

        // Inside a bracket the nearer one, and not too close to the other end.
        let next = if nearer { cubic } else { secant };
        let limit = seen.step + SHRINK * (self.other.step - seen.step);
        if forward {
            next.min(limit)
        } else {
            next.max(limit)
        }
    }

    /// Keeps the next trial inside, and halves a bracket that shrinks too slowly.
    fn choose(&mut self) {
        let (best, other) = (self.best.step, self.other.step);
        if self.bracketed {
            let width = (other - best).abs();
            if width >= SHRINK * self.last_width {
                self.trial = best + 0.5 * (other - best);
            }
            self.last_width = self.width;
            self.width = width;
            self.from = best.min(other);
            self.to = best.max(other);
        } else {
            self.from = self.trial + ADVANCE[0] * (self.trial - best);
            self.to = self.trial + ADVANCE[1] * (self.trial - best);
        }
        self.trial = self.trial.clamp(0.0, self.most);

        // Where no progress is possible any more, the best step is looked at once more.
        let outside = self.trial <= self.from || self.trial >= self.to;
        let narrow = self.to - self.from <= NARROW * self.to;
        if self.bracketed && (outside || narrow) {
            self.trial = best;
        }
    }
}

/// How far from `a` towards `b`, as a share, the minimum of the cubic through both is; and the root in it.
fn cubic_reach(a: &Sample, b: &Sample) -> (f64, f64) {
    let theta = 3.0 * (b.value - a.value) / (a.step - b.step) + a.slope + b.slope;
    let size = theta.abs().max(a.slope.abs()).max(b.slope.abs());
    let inside = (theta / size).powi(2) - (a.slope / size) * (b.slope / size);
    let root = size * inside.max(0.0).sqrt();
    let gamma = if a.step > b.step { -root } else { root };
    let p = (gamma - a.slope) + theta;
    let q = ((gamma - a.slope) + gamma) + b.slope;
    (p / q, gamma)
}

/// The minimum of the cubic through `a` and `b`, reckoned from `base`, which is one of them.
fn minimum(a: &Sample, b: &Sample, base: &Sample) -> f64 {
    base.step + cubic_reach(a, b).0 * (b.step - a.step)
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::wolfe::{CURVATURE, DECREASE, LineSearchReply, NARROW, Search};

    /// Functions 1 and 2 of Moré and Thuente with their slopes, and one with an edge of no number.
    fn first(a: f64) -> [f64; 2] {
        let below = a * a + 2.0;
        [-a / below, (a * a - 2.0) / (below * below)]
    }

    fn second(a: f64) -> [f64; 2] {
        let b = a + 0.004;
        [
            b.powi(5) - 2.0 * b.powi(4),
            5.0 * b.powi(4) - 8.0 * b.powi(3),
        ]
    }

    fn edge(a: f64) -> [f64; 2] {
        [-(3.0 - a).ln() - 2.0 * a, 1.0 / (3.0 - a) - 2.0]
    }

    /// Function 4 of the paper (Yanai, Ozawa and Kaneko).
    fn fourth(a: f64, b1: f64, b2: f64) -> [f64; 2] {
        let gamma = |b: f64| (1.0 + b * b).sqrt() - b;
        let one = ((1.0 - a).powi(2) + b2 * b2).sqrt();
        let two = (a * a + b1 * b1).sqrt();
        [
            gamma(b1) * one + gamma(b2) * two,
            gamma(b1) * (a - 1.0) / one + gamma(b2) * a / two,
        ]
    }

    #[test]
    fn strong_wolfe_conditions_hold_at_the_end_unless_the_interval_is_narrow() {
        type Function = fn(f64) -> [f64; 2];
        let functions: [Function; 6] = [
            first,
            second,
            |a| fourth(a, 0.001, 0.001),
            |a| fourth(a, 0.01, 0.001),
            |a| fourth(a, 0.001, 0.01),
            edge,
        ];
        for (which, function) in functions.iter().enumerate() {
            for trial in [1e-3, 0.1, 10.0, 1e3] {
                let [value, slope] = function(0.0);
                let mut search = Search::new(value, slope, trial, 1e10);
                let mut count = 0;
                let at = loop {
                    let at = function(search.trial_step());
                    count += 1;
                    match search.report(at[0], at[1]) {
                        LineSearchReply::Again => {}
                        LineSearchReply::Enough => break at,
                        LineSearchReply::Hopeless => panic!("function {which} from {trial}"),
                    }
                };
                assert!(at[0] <= value + DECREASE * slope * search.trial_step());
                let flat = at[1].abs() <= CURVATURE * slope.abs();
                assert!(flat || search.to - search.from <= NARROW * search.to);
                assert!(count <= 12, "function {which} from {trial}: {count}");
            }
        }
    }

    #[test]
    fn the_largest_step_is_taken_when_it_is_still_downhill_and_uphill_is_hopeless() {
        let mut search = Search::new(0.0, -1.0, 0.5, 2.0);
        while search.report(-search.trial_step(), -1.0) == LineSearchReply::Again {}
        assert_eq!(search.trial_step(), 2.0);

        let mut search = Search::new(0.0, -1.0, 1.0, 2.0);
        let end = loop {
            match search.report(search.trial_step(), 1.0) {
                LineSearchReply::Again => {}
                end => break end,
            }
        };
        assert_eq!(end, LineSearchReply::Hopeless);
    }
}
