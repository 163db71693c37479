//! A design under way: one evaluation after another, with everything that is needed to go on later.

use serde::{Deserialize, Serialize};

use crate::design::estimator::{Estimator, EstimatorKind, EvaluationMode};
use crate::design::exact;
use crate::design::optimizers::optimizer::{Optimizer, SAVED_NUMBER};
use crate::design::optimizers::step::{SavedError, Step, Stop};
use crate::design::project::{DesignEvaluation, Plans, Project, ProjectError};
use crate::engine::chain::control_variate::ControlVariate;
use crate::engine::progress::Pulse;

/// Everything of a run that its next steps depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The search.
    pub search: Optimizer,
    /// The point about which light was planned.
    #[serde(with = "exact::list")]
    planned: Vec<f64>,
    /// Iterations that were done then.
    planned_after: usize,
    /// Points of the last exact evaluations, from which estimates start; empty where there were none.
    #[serde(with = "exact::list")]
    last_exact: Vec<f64>,
    /// Share of the iterations done, as the constraints see it; it grows in stages.
    #[serde(with = "exact::number")]
    share: f64,
    /// Evaluations done.
    pub evaluations: usize,
    /// Why the search is over, if it is.
    pub stop: Option<Stop>,
}

/// Bytes of what is noted of an iteration: one line, and one more where a line search begins anew.
const NOTE: u64 = 1000;

impl State {
    /// The most bytes that the state of the design with this first search, and notes of its iterations, take as text.
    pub fn saved_bytes(fresh: &Optimizer, iterations: usize) -> u64 {
        let points = 2 * SAVED_NUMBER * fresh.space().len() as u64;
        fresh.saved_bytes() + points + NOTE * iterations as u64
    }

    /// Checks that a state which was read is one of the design that begins with the search `fresh` and does so many
    /// iterations.
    ///
    /// # Errors
    /// A search of something else, or what no run leaves.
    pub fn check(
        &self,
        project: &Project,
        fresh: &Optimizer,
        iterations: usize,
    ) -> Result<(), SavedError> {
        self.search.check(fresh)?;
        let space = fresh.space();
        let renews = |drawn: Estimator| drawn.kind == EstimatorKind::ControlVariate;
        let last_exact = project.estimator.is_some_and(renews) && self.evaluations > 0;
        let done = self.search.iteration();
        for (name, good) in [
            ("planned point", space.holds(&self.planned)),
            (
                "last exact point",
                self.last_exact.is_empty() != last_exact
                    && (!last_exact || space.holds(&self.last_exact)),
            ),
            ("share", (0.0..=1.0).contains(&self.share)),
            ("number of iterations", done <= iterations),
            ("number of evaluations", done <= self.evaluations),
            ("last plan", self.planned_after <= done),
            ("end", self.stop == self.search.stop()),
        ] {
            if !good {
                return Err(SavedError::Content(name));
            }
        }
        Ok(())
    }
}

/// A design under way.
pub struct Run<'p> {
    project: &'p Project,
    /// Number of iterations to do.
    iterations: usize,
    /// The state from which it goes on, as checkpoints hold it.
    pub state: State,
    plans: Plans,
    /// The last exact evaluations, if estimates start from them.
    control_variates: Vec<ControlVariate>,
    /// Called after each chunk of work; it may cancel a step.
    pulse: &'p Pulse<'p>,
}

/// The result of one evaluation in a run.
pub struct Evaluated {
    /// Value, gradient and light of the point.
    pub evaluation: DesignEvaluation,
    /// The verdict of the optimiser on the point.
    pub step: Step,
    /// |gradient|, without the scales of the parameters.
    pub slope: f64,
}

/// Stages in which soft levels harden; the last ones are hard.
const STAGES: usize = 32;
const HARD: f64 = 0.9;

/// Iterations after which light is planned anew when parameters of the system change.
const FRESH: usize = 10;

impl<'p> Run<'p> {
    /// A run from the start of a search. The pulse is called after each chunk of work, now and in each step.
    ///
    /// # Errors
    /// When light cannot be planned there, or the pulse cancels the work.
    pub fn new(
        project: &'p Project,
        search: Optimizer,
        iterations: usize,
        pulse: &'p Pulse<'p>,
    ) -> Result<Self, ProjectError> {
        let planned = search.point().to_vec();
        let state = State {
            search,
            planned,
            planned_after: 0,
            last_exact: Vec::new(),
            share: 0.0,
            evaluations: 0,
            stop: None,
        };
        Self::resume(project, state, iterations, pulse)
    }

    /// A run that goes on where it was.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn resume(
        project: &'p Project,
        state: State,
        iterations: usize,
        pulse: &'p Pulse<'p>,
    ) -> Result<Self, ProjectError> {
        let plans = project.plan(&state.planned, state.share, pulse)?;
        let control_variates = match state.last_exact.is_empty() {
            true => Vec::new(),
            false => project.control_variates(&plans, &state.last_exact, state.share, pulse)?,
        };
        Ok(Self {
            project,
            iterations,
            state,
            plans,
            control_variates,
            pulse,
        })
    }

    /// Iterations done.
    pub fn iteration(&self) -> usize {
        self.state.search.iteration()
    }

    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.state.stop.is_some() || self.iteration() >= self.iterations
    }

    /// The best point so far. With drawn beamlets it is the last point, because the best value is then mostly chance.
    pub fn best(&self) -> &[f64] {
        let search = &self.state.search;
        if self.project.estimator.is_some() {
            return search.point();
        }
        search.best().map_or(search.point(), |(point, _)| point)
    }

    /// Evaluates the next point of the search, and goes on.
    ///
    /// # Errors
    /// When light cannot be carried there, no loss so far was a number, or the pulse cancels the step.
    pub fn step(&mut self) -> Result<Evaluated, ProjectError> {
        let evaluation = self.possible()?;
        let state = &mut self.state;
        let step = state.search.report(evaluation.value, &evaluation.gradient);
        state.evaluations += 1;
        if let Step::Finished(stop) = step {
            state.stop = Some(stop);
        }
        if step == Step::Finished(Stop::NotFinite) && state.search.best().is_none() {
            return Err(ProjectError::NotFinite);
        }
        let slope = evaluation
            .gradient
            .iter()
            .map(|g| g * g)
            .sum::<f64>()
            .sqrt();
        if step == Step::Accepted {
            self.settle()?;
        }
        Ok(Evaluated {
            evaluation,
            step,
            slope,
        })
    }

    /// Evaluates the point. If a line-search trial has no valid system, or light that spreads too far to be carried,
    /// reports an infinite loss, so that the step is shortened.
    fn possible(&mut self) -> Result<DesignEvaluation, ProjectError> {
        loop {
            let found = self.evaluate();
            let state = &mut self.state;
            let trial = matches!(state.search, Optimizer::Lbfgs(_)) && state.evaluations > 0;
            let too_far = found.as_ref().is_err_and(ProjectError::is_of_point);
            let nowhere = vec![0.0; state.search.point().len()];
            if !(too_far && trial)
                || matches!(
                    state.search.report(f64::INFINITY, &nowhere),
                    Step::Finished(_)
                )
            {
                return found;
            }
            state.evaluations += 1;
        }
    }

    /// Evaluates the point with the design's estimator.
    fn evaluate(&mut self) -> Result<DesignEvaluation, ProjectError> {
        let (project, iteration) = (self.project, self.iteration());
        let state = &mut self.state;
        let (point, share) = (state.search.point().to_vec(), state.share);
        let renews = |drawn: Estimator| drawn.renews_control_variates(iteration);
        if project.estimator.is_some_and(renews) {
            self.control_variates =
                project.control_variates(&self.plans, &point, share, self.pulse)?;
            state.last_exact = point.clone();
        }
        let seed = project.settings.seed;
        let draws = project.estimator.map(|drawn| drawn.draws(seed, iteration));
        let mode = match draws {
            None => EvaluationMode::All,
            Some(draws) if self.control_variates.is_empty() => EvaluationMode::Drawn(draws),
            Some(draws) => EvaluationMode::From(&self.control_variates, draws),
        };
        project.evaluate_by(&self.plans, &point, share, &mode, self.pulse)
    }

    /// After an iteration: harder levels, and fresh plans where the system has changed.
    fn settle(&mut self) -> Result<(), ProjectError> {
        let done = self.iteration();
        let state = &mut self.state;
        let stage = (self.iterations / STAGES).max(1);
        let share = (done / stage * stage) as f64 / (HARD * self.iterations as f64);
        let hardens = self
            .project
            .elements
            .iter()
            .any(|e| e.modulator.constraints().hardens());
        if hardens && share.min(1.0) != state.share {
            state.share = share.min(1.0);
            state.search.refresh(true);
        }
        if !self.project.system_parameters.is_empty() && done >= state.planned_after + FRESH {
            state.planned_after = done;
            state.planned = state.search.point().to_vec();
            self.plans = self.project.plan(&state.planned, state.share, self.pulse)?;
            state.search.refresh(false);
        }
        Ok(())
    }

    /// The best point as it will be made: levels hard, light planned about it.
    ///
    /// # Errors
    /// When light cannot be planned or carried there, or the pulse cancels the work.
    pub fn finish(&self) -> Result<DesignEvaluation, ProjectError> {
        let point = self.best();
        let (project, pulse) = (self.project, self.pulse);
        let plans = project.plan(point, 1.0, pulse)?;
        let evaluation = project.evaluate_by(&plans, point, 1.0, &EvaluationMode::All, pulse)?;
        match evaluation.is_finite() {
            true => Ok(evaluation),
            false => Err(ProjectError::NotFinite),
        }
    }
}
