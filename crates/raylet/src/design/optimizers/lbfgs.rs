//! L-BFGS: Newton's method with a curvature learnt from the last few steps, for many parameters.
//!
//! Two-loop recursion (Nocedal, Math. Comp. 35, 773, 1980), Moré–Thuente line search, initial curvature
//! from the last pair (Liu and Nocedal, Math. Program. 45, 503, 1989), all in the metric of the
//! parameters' scales. Bounds: parameters at a bound stay there if downhill leads out, and the
//! recursion runs in the others alone; the full step is cut off by the box and searched along a straight
//! line (Kim, Sra and Dhillon, SIAM J. Sci. Comput. 32, 3548, 2010, with the segment of L-BFGS-B: Zhu,
//! Byrd, Lu and Nocedal, ACM Trans. Math. Softw. 23, 550, 1997).
//!
//! The caller evaluates: one evaluation of a design takes seconds to minutes, the caller stops after any one of
//! them and goes on from what serde wrote, bit for bit. So no crate can be used: ganesh 0.29.1 and
//! argmin 0.11.0 call the function from within a step, a whole line search at a time, and what they can
//! save is the state between iterations only (argmin has no bounds besides).

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::design::exact;
use crate::design::optimizers::reduction;
use crate::design::optimizers::space::Space;
use crate::design::optimizers::step::{
    OptimizerError, SavedError, Step, Stop, demand, is_moderate,
};
use crate::design::optimizers::wolfe::{LineSearchReply, Search};

/// Steps are never longer than this many times the direction.
const LONGEST: f64 = 1e10;

/// A pair is kept when step·change is more than this share of −step·(the gradient before the step).
const CURVED: f64 = 1e-15;

/// Where bounds hold some parameters, a pair is used when step·change of the free ones is more than this share of that
/// of all.
const CURVED_PART: f64 = 1e-6;

/// A step cut off by the box must keep this share of its descent; else it goes straight downhill.
const DESCENT_LEFT: f64 = 1e-6;

/// When to stop and how much to remember.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LbfgsSettings {
    /// Steps remembered.
    pub memory: usize,
    /// Stops when no scale's worth of a parameter changes the value by more than this.
    #[serde(with = "exact::number")]
    pub slope: f64,
    /// Stops when an iteration lowers the value by less than this share of it (of 1 below 1).
    #[serde(with = "exact::number")]
    pub change: f64,
    /// Length of the very first step, in scales (root of the sum of squares over all parameters).
    #[serde(with = "exact::number")]
    pub first: f64,
}

impl Default for LbfgsSettings {
    /// Tight: holograms go on improving long after usual tolerances are met.
    fn default() -> Self {
        Self {
            memory: 20,
            slope: 1e-10,
            change: 1e-13,
            first: 1.0,
        }
    }
}

/// A step taken and how it changed the gradient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Pair {
    #[serde(with = "exact::list")]
    step: Vec<f64>,
    #[serde(with = "exact::list")]
    change: Vec<f64>,
    /// step · change.
    #[serde(with = "exact::number")]
    curvature: f64,
    /// |scale · change|².
    #[serde(with = "exact::number")]
    square: f64,
}

/// A search under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lbfgs {
    settings: LbfgsSettings,
    space: Space,
    /// The point at which the caller evaluates next; after the end the best point.
    #[serde(with = "exact::list")]
    point: Vec<f64>,
    /// The last accepted point, value and gradient.
    #[serde(with = "exact::list")]
    base: Vec<f64>,
    #[serde(with = "exact::number")]
    value: f64,
    #[serde(with = "exact::list")]
    gradient: Vec<f64>,
    #[serde(with = "exact::list")]
    direction: Vec<f64>,
    pairs: VecDeque<Pair>,
    /// The line search; none before the first value.
    search: Option<Search>,
    iteration: usize,
    stop: Option<Stop>,
}

impl Lbfgs {
    /// A search from a starting point, which is moved into the bounds.
    ///
    /// # Errors
    /// When the point does not fit the space or a setting is outside its range.
    pub fn new(
        start: Vec<f64>,
        space: Space,
        settings: LbfgsSettings,
    ) -> Result<Self, OptimizerError> {
        let LbfgsSettings {
            memory,
            slope,
            change,
            first,
        } = settings;
        demand(memory > 0, "memory", memory as f64, "at least 1")?;
        demand(slope >= 0.0, "slope", slope, "none below zero")?;
        demand(change >= 0.0, "change", change, "none below zero")?;
        let positive = first > 0.0 && first.is_finite();
        demand(positive, "first", first, "a positive number")?;
        let point = space.start(start)?;
        Ok(Self {
            settings,
            base: point.clone(),
            value: f64::NAN,
            gradient: vec![0.0; point.len()],
            direction: vec![0.0; point.len()],
            point,
            space,
            pairs: VecDeque::new(),
            search: None,
            iteration: 0,
            stop: None,
        })
    }

    /// Checks that a search which was read can have begun as `fresh` did.
    ///
    /// # Errors
    /// Other settings or parameters, or what no search leaves.
    pub(crate) fn check(&self, fresh: &Self) -> Result<(), SavedError> {
        if self.settings != fresh.settings || self.space != fresh.space {
            return Err(SavedError::Settings);
        }
        let count = self.space.len();
        let list = |list: &[f64]| list.len() == count && list.iter().all(|x| is_moderate(*x));
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let value = self.value.is_nan() || is_moderate(self.value);
        let pair = |pair: &Pair| {
            list(&pair.step)
                && list(&pair.change)
                && positive(pair.curvature)
                && positive(pair.square)
        };
        // Without a value there is no line search, and with one there is, until the end.
        let searching = match &self.search {
            Some(search) => self.value.is_finite() && self.stop.is_none() && search.is_sound(),
            None => self.stop.is_some() || self.value.is_nan(),
        };
        for (name, good) in [
            ("point", self.space.holds(&self.point)),
            ("last point", self.space.holds(&self.base)),
            ("gradient", list(&self.gradient)),
            ("direction", list(&self.direction)),
            ("steps so far", self.pairs.iter().all(pair)),
            ("memory", self.pairs.len() <= self.settings.memory),
            ("value", value),
            ("line search", searching),
        ] {
            if !good {
                return Err(SavedError::Content(name));
            }
        }
        Ok(())
    }

    /// How many numbers are saved at most.
    pub(crate) fn saved_numbers(&self) -> usize {
        // Bounds, scales, points, gradient and direction; two for each remembered step.
        self.space.len() * (7 + 2 * self.settings.memory)
    }

    /// Why it is over, if it is.
    pub(crate) fn stop(&self) -> Option<Stop> {
        self.stop
    }

    /// The space that it searches.
    pub(crate) fn space(&self) -> &Space {
        &self.space
    }

    /// The point at which the caller evaluates next; once finished, the best point.
    pub fn point(&self) -> &[f64] {
        &self.point
    }

    /// The last accepted point and its value: no accepted point was better. None before the first value.
    pub(crate) fn best(&self) -> Option<(&[f64], f64)> {
        self.value.is_finite().then_some((&self.base, self.value))
    }

    /// Iterations done: accepted points but the first.
    pub(crate) fn iteration(&self) -> usize {
        self.iteration
    }

    /// The function has changed: goes on from the last accepted point, which is evaluated again.
    /// `forget`: its curvature is not to be relied on any more.
    pub(crate) fn refresh(&mut self, forget: bool) {
        self.point.copy_from_slice(&self.base);
        self.value = f64::NAN;
        self.search = None;
        self.stop = None;
        if forget {
            self.pairs.clear();
        }
    }

    /// Learns the value and the gradient at [`Lbfgs::point`].
    ///
    /// # Panics
    /// When the gradient has another length than the point.
    pub fn report(&mut self, value: f64, gradient: &[f64]) -> Step {
        assert_eq!(gradient.len(), self.point.len(), "length of the gradient");
        if let Some(stop) = self.stop {
            return Step::Finished(stop);
        }
        let slope = reduction::dot(&self.direction, gradient);
        match self
            .search
            .as_mut()
            .map(|search| search.report(value, slope))
        {
            None => self.begin(value, gradient),
            Some(LineSearchReply::Again) => {
                self.place();
                Step::Trial
            }
            Some(LineSearchReply::Enough) => self.accept(value, gradient),
            Some(LineSearchReply::Hopeless) if self.pairs.is_empty() => self.finish(Stop::Stuck),
            Some(LineSearchReply::Hopeless) => {
                self.pairs.clear();
                self.start_search(Step::Restarted)
            }
        }
    }

    /// The first point, or the last one of a function that has changed since.
    fn begin(&mut self, value: f64, gradient: &[f64]) -> Step {
        if !(value.is_finite() && gradient.iter().all(|g| g.is_finite())) {
            return self.finish(Stop::NotFinite);
        }
        self.value = value;
        self.gradient.copy_from_slice(gradient);
        if self.space.slope(&self.base, &self.gradient) <= self.settings.slope {
            return self.finish(Stop::Flat);
        }
        self.start_search(Step::Accepted)
    }

    /// The trial ends an iteration.
    fn accept(&mut self, value: f64, gradient: &[f64]) -> Step {
        // What the step teaches about the curvature, unless there is none along it.
        let (base, before) = (&self.base, &self.gradient);
        let (mut step, mut change) = (self.point.clone(), gradient.to_vec());
        reduction::change(&mut step, |i, x| x - base[i]);
        reduction::change(&mut change, |i, g| g - before[i]);
        let curvature = reduction::dot(&step, &change);
        if curvature > CURVED * -reduction::dot(&step, before) {
            if self.pairs.len() == self.settings.memory {
                self.pairs.pop_front();
            }
            let square = reduction::square(self.space.scales(), &change);
            self.pairs.push_back(Pair {
                step,
                change,
                curvature,
                square,
            });
        }

        // On from here, if there is any use.
        let size = self.value.abs().max(value.abs()).max(1.0);
        let still = self.value - value <= self.settings.change * size;
        self.base.copy_from_slice(&self.point);
        self.gradient.copy_from_slice(gradient);
        self.value = value;
        self.iteration += 1;
        if self.space.slope(&self.base, &self.gradient) <= self.settings.slope {
            return self.finish(Stop::Flat);
        }
        if still {
            return self.finish(Stop::Still);
        }
        self.start_search(Step::Accepted)
    }

    fn finish(&mut self, stop: Stop) -> Step {
        self.point.copy_from_slice(&self.base);
        self.search = None;
        self.stop = Some(stop);
        Step::Finished(stop)
    }

    /// Chooses the direction from the last accepted point and proposes the first trial along it.
    fn start_search(&mut self, step: Step) -> Step {
        let free = self.free();
        self.direction = self.newton(free.as_deref());
        let mut slope = reduction::dot(&self.direction, &self.gradient);
        if free.is_some() {
            let whole = slope;
            slope = self.cut();

            // What the box leaves of Newton's step may lead uphill; of the gradient it never does.
            if slope.is_nan() || slope > DESCENT_LEFT * whole {
                self.direction = self.downhill(free.as_deref(), self.pairs.back());
                slope = self.cut();
            }
        }
        if slope.is_nan() || slope >= 0.0 {
            return self.finish(Stop::Stuck);
        }
        self.search = Some(Search::new(self.value, slope, 1.0, self.longest()));
        self.place();
        step
    }

    /// Which parameters are not held by a bound; none where nothing is bounded.
    fn free(&self) -> Option<Vec<bool>> {
        let one = |(i, (x, g)): (usize, (&f64, &f64))| !self.space.binds(i, *x, *g);
        let all = self.base.iter().zip(&self.gradient).enumerate();
        self.space.is_bounded().then(|| all.map(one).collect())
    }

    /// −H·gradient by the two-loop recursion, in the free parameters.
    fn newton(&self, free: Option<&[bool]>) -> Vec<f64> {
        // Pairs as the free parameters see them: [curvature, square].
        let part = |pair: &Pair| match free {
            None => [pair.curvature, pair.square],
            Some(free) => [
                reduction::dot_where(free, &pair.step, &pair.change),
                self.square_where(free, &pair.change),
            ],
        };
        let useful = self.pairs.iter().map(|pair| (pair, part(pair)));
        let useful: Vec<(&Pair, [f64; 2])> = useful
            .filter(|(pair, [curvature, _])| *curvature > CURVED_PART * pair.curvature)
            .collect();
        let Some((_, [curvature, square])) = useful.last() else {
            return self.downhill(free, None);
        };

        // Down through the pairs, latest first; the curvature of the latest; up again.
        let mut along = self.gradient.clone();
        keep(&mut along, free);
        let mut shares = Vec::with_capacity(useful.len());
        for (pair, [curvature, _]) in useful.iter().rev() {
            let share = reduction::dot(&pair.step, &along) / curvature;
            reduction::add(&mut along, -share, &pair.change);
            keep(&mut along, free);
            shares.push(share);
        }
        let (scales, gamma) = (self.space.scales(), curvature / square);
        reduction::change(&mut along, |i, g| gamma * scales[i] * scales[i] * g);
        for ((pair, [curvature, _]), share) in useful.iter().zip(shares.iter().rev()) {
            let back = reduction::dot(&pair.change, &along) / curvature;
            reduction::add(&mut along, share - back, &pair.step);
            keep(&mut along, free);
        }
        reduction::change(&mut along, |_, value| -value);
        along
    }

    /// Steepest descent in scales. Its length comes from the curvature of `pair`; without a pair it is that of the
    /// first step.
    fn downhill(&self, free: Option<&[bool]>, pair: Option<&Pair>) -> Vec<f64> {
        let mut along = self.gradient.clone();
        keep(&mut along, free);
        let scales = self.space.scales();
        let length = match pair {
            Some(pair) => pair.curvature / pair.square,
            None => self.settings.first / reduction::square(scales, &along).sqrt(),
        };
        reduction::change(&mut along, |i, g| -length * scales[i] * scales[i] * g);
        along
    }

    fn square_where(&self, free: &[bool], change: &[f64]) -> f64 {
        let mut scaled = change.to_vec();
        let scales = self.space.scales();
        reduction::change(&mut scaled, |i, g| scales[i] * g);
        reduction::dot_where(free, &scaled, &scaled)
    }

    /// Ends the direction where it leaves the box; its slope.
    fn cut(&mut self) -> f64 {
        let (space, base) = (&self.space, &self.base);
        reduction::change(&mut self.direction, |i, step| {
            space.moved(i, base[i], step) - base[i]
        });
        reduction::dot(&self.direction, &self.gradient)
    }

    /// The largest multiple of the direction inside the box.
    fn longest(&self) -> f64 {
        if !self.space.is_bounded() {
            return LONGEST;
        }
        let room = |i: usize| self.space.room(i, self.base[i], self.direction[i]);
        let least = reduction::extreme(self.base.len(), LONGEST, room, f64::min);
        least.max(1.0)
    }

    /// Puts the point to the line search's trial.
    fn place(&mut self) {
        let step = self.search.as_ref().map_or(0.0, Search::trial_step);
        let (space, base, direction) = (&self.space, &self.base, &self.direction);
        reduction::change(&mut self.point, |i, _| {
            space.moved(i, base[i], step * direction[i])
        });
    }
}

/// Sets to zero what is not free.
fn keep(values: &mut [f64], free: Option<&[bool]>) {
    if let Some(free) = free {
        reduction::change(values, |i, value| if free[i] { value } else { 0.0 });
    }
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::lbfgs::{Lbfgs, LbfgsSettings};
    use crate::design::optimizers::space::Space;
    use crate::design::optimizers::step::{Step, Stop};

    type Function<'a> = &'a dyn Fn(&[f64]) -> (f64, Vec<f64>);

    /// Runs to the end: why it ended, and the number of evaluations.
    fn run(search: &mut Lbfgs, function: Function<'_>) -> (Stop, usize) {
        for count in 1..100_000 {
            let (value, gradient) = function(search.point());
            if let Step::Finished(stop) = search.report(value, &gradient) {
                return (stop, count);
            }
        }
        panic!("no end");
    }

    /// Σ 100(x₂ᵢ₊₁ − x₂ᵢ²)² + (1 − x₂ᵢ)², chained or in pairs.
    fn rosenbrock(x: &[f64], stride: usize) -> (f64, Vec<f64>) {
        let (mut value, mut gradient) = (0.0, vec![0.0; x.len()]);
        for i in (0..x.len() - 1).step_by(stride) {
            let (bend, rest) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
            value += 100.0 * bend * bend + rest * rest;
            gradient[i] += -400.0 * bend * x[i] - 2.0 * rest;
            gradient[i + 1] += 200.0 * bend;
        }
        (value, gradient)
    }

    fn standard_start(count: usize) -> Vec<f64> {
        (0..count).map(|i| [-1.2, 1.0][i % 2]).collect()
    }

    fn memory(memory: usize) -> LbfgsSettings {
        LbfgsSettings {
            memory,
            ..LbfgsSettings::default()
        }
    }

    #[test]
    fn rosenbrock_takes_as_many_evaluations_as_scipy() {
        // Iterations and evaluations of scipy 1.17's L-BFGS-B with the same settings (ftol 1e-13, gtol
        // 1e-10, maxcor 10). The long chain, of hundreds of iterations, differs by rounding.
        let cases = [(2, 1, 38, 46), (100, 2, 38, 50), (100, 1, 527, 627)];
        for (count, stride, iterations, most) in cases {
            let function = |x: &[f64]| rosenbrock(x, stride);
            let start = standard_start(count);
            let mut search = Lbfgs::new(start, Space::free(count), memory(10)).unwrap();
            let (stop, evaluations) = run(&mut search, &function);
            let (best, value) = search.best().unwrap();
            let off = best.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max);
            assert!(value < 1e-12 && off < 1e-6, "{stop:?} {value:e} {off:e}");
            let short = iterations < 100;
            assert!(!short || search.iteration() == iterations && evaluations == most);
            assert!(evaluations <= most, "{evaluations} {}", search.iteration());
        }
    }

    #[test]
    fn active_bounds_of_a_quadratic() {
        // ½xᵀAx − bᵀx with A = tridiag(−1, 2.5, −1) in a box: the minimum is where x = P(x − gradient), to
        // which projected Gauss–Seidel converges.
        let count = 60;
        let b = |i: usize| 3.0 * (0.4 * i as f64).sin();
        let apply = |x: &[f64], i: usize| {
            let left = if i > 0 { x[i - 1] } else { 0.0 };
            let right = if i + 1 < count { x[i + 1] } else { 0.0 };
            2.5 * x[i] - left - right
        };
        let mut exact = vec![0.0; count];
        for _ in 0..2000 {
            for i in 0..count {
                let rest = b(i) - apply(&exact, i) + 2.5 * exact[i];
                exact[i] = (rest / 2.5).clamp(-0.5, 1.0);
            }
        }
        let function = |x: &[f64]| {
            let gradient: Vec<f64> = (0..count).map(|i| apply(x, i) - b(i)).collect();
            let value = (0..count).map(|i| x[i] * (0.5 * apply(x, i) - b(i))).sum();
            (value, gradient)
        };
        let space = Space::free(count).with_bounds(0..count, -0.5, 1.0).unwrap();
        let mut search = Lbfgs::new(vec![0.3; count], space, memory(20)).unwrap();
        let (_, evaluations) = run(&mut search, &function);
        let (best, value) = search.best().unwrap();
        let held = exact.iter().filter(|x| **x == -0.5 || **x == 1.0).count();
        assert!((20..55).contains(&held), "{held}");
        for (found, exact) in best.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-6, "{found} {exact}");
            assert_eq!(
                *exact == -0.5 || *exact == 1.0,
                *found == -0.5 || *found == 1.0
            );
        }
        // scipy 1.17 needs 11 evaluations.
        assert!((value + 73.14817939184697).abs() < 1e-12 && evaluations <= 13);
    }

    #[test]
    fn scales_undo_a_bad_choice_of_units() {
        // A thousand radians' worth of phases and a curvature in 1/mm: with the right scales the search
        // takes the same steps as in good units, without them it is lost.
        let units = |i: usize| if i < 30 { 1.0 } else { 1e-5 };
        let good = |x: &[f64]| rosenbrock(x, 1);
        let bad = |x: &[f64]| {
            let inside: Vec<f64> = x.iter().enumerate().map(|(i, x)| x / units(i)).collect();
            let (value, mut gradient) = rosenbrock(&inside, 1);
            gradient
                .iter_mut()
                .enumerate()
                .for_each(|(i, g)| *g /= units(i));
            (value, gradient)
        };
        let start = standard_start(40);
        let scaled: Vec<f64> = start
            .iter()
            .enumerate()
            .map(|(i, x)| x * units(i))
            .collect();
        let mut plain = Lbfgs::new(start, Space::free(40), memory(20)).unwrap();
        let (_, needed) = run(&mut plain, &good);

        let space = Space::free(40).with_scale(30..40, 1e-5).unwrap();
        let mut search = Lbfgs::new(scaled.clone(), space, memory(20)).unwrap();
        let (_, evaluations) = run(&mut search, &bad);
        assert!(search.best().unwrap().1 < 1e-12);
        assert!(
            evaluations.abs_diff(needed) <= needed / 5,
            "{evaluations} {needed}"
        );

        let mut lost = Lbfgs::new(scaled, Space::free(40), memory(20)).unwrap();
        for _ in 0..3 * needed {
            let (value, gradient) = bad(lost.point());
            lost.report(value, &gradient);
        }
        assert!(lost.best().unwrap().1 > 1e-3);
    }

    #[test]
    fn ends_say_why() {
        let search = |start| Lbfgs::new(vec![start], Space::free(1), memory(3)).unwrap();
        let flat = run(&mut search(0.0), &|x| (x[0] * x[0], vec![2.0 * x[0]]));
        assert_eq!(flat, (Stop::Flat, 1));
        let none = run(&mut search(1.0), &|_| (f64::NAN, vec![1.0]));
        assert_eq!(none, (Stop::NotFinite, 1));
        let lie = run(&mut search(1.0), &|x| (x[0] * x[0], vec![-1.0]));
        assert_eq!(lie.0, Stop::Stuck);
        let still = run(&mut search(1.0), &|x| {
            (1e9 + 1e-6 * x[0].cos(), vec![-1e-6 * x[0].sin()])
        });
        assert_eq!(still.0, Stop::Still);
        assert!(Lbfgs::new(vec![0.0], Space::free(1), memory(0)).is_err());
    }
}
