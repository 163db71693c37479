//! The estimators of a design's gradient side by side: how near the exact gradient each comes, and what it reaches on one
//! hologram in equal time. Prints the table of `docs/estimators.md` and draws its picture, scores and cosines against
//! time, as `out/estimators.png`.
//!
//! `cargo run --release -p raylet-accuracy --example estimators -- [SECONDS]`

use std::path::Path;
use std::sync::LazyLock;
use std::time::Instant;

use raylet::design::estimator::{Estimator, EstimatorKind, EvaluationMode};
use raylet::design::optimizers::descent::Rule;
use raylet::design::optimizers::optimizer::{Method, Optimizer};
use raylet::design::optimizers::schedule::Schedule;
use raylet::design::optimizers::space::Space;
use raylet::design::optimizers::step::Step;
use raylet::design::project::{Plans, Project};
use raylet::engine::progress::uncancelled;
use raylet::file::model::project::scene_design;
use raylet::file::scene::scene_file::Scene;
use raylet::math::random::uniform;
use raylet::wave::grid::metrics::ncc;
use raylet_plot::chart_panel::Series;
use raylet_plot::figure::{Figure, Panel};

type Failure = Box<dyn std::error::Error>;

/// The NCC by all beamlets and the exact gradient at a point.
type Truth<'a> = &'a dyn Fn(&[f64]) -> Result<(f64, Vec<f64>), Failure>;

/// Where the study is posed: the hologram through a lens of the source paper's figure 5.
const SCENE: &str = "scenes/paper/fig5.toml";

/// Radians of the first steps.
const RATE: f64 = 0.2;

/// When the program began.
static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);

/// Seconds of the processor so far, which other programs do not change; of the clock where the system reports none.
fn processor() -> f64 {
    let reported = || {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
        let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
        Some((ticks(11)? + ticks(12)?) / 100.0)
    };
    reported().unwrap_or_else(|| BEGAN.elapsed().as_secs_f64())
}

/// One estimator's run.
struct Course {
    name: String,
    evaluations: usize,
    /// Cosine of the angle to the exact gradient at the start and where the exact search ended.
    cosines: [f64; 2],
    /// (seconds, exact NCC).
    scores: Vec<[f64; 2]>,
    /// (seconds, cosine to the exact gradient there).
    nearness: Vec<[f64; 2]>,
    end: Vec<f64>,
}

fn main() -> Result<(), Failure> {
    let seconds = std::env::args().nth(1).map_or(Ok(60.0), |s| s.parse())?;
    let scene_design = scene_design(&Scene::open(Path::new(SCENE))?)?;
    let (project, start) = (&scene_design.project, scene_design.search.point().to_vec());
    let plans = project.plan(&start, 0.0, &uncancelled)?;
    let Some([picture, _]) = &scene_design.described[0].picture else {
        return Err(format!("{SCENE} has no picture").into());
    };
    let exact = |point: &[f64]| -> Result<(f64, Vec<f64>), Failure> {
        let evaluation = project.evaluate(&plans, point, 1.0)?;
        let like = ncc(evaluation.intensities[0].view(), picture.view());
        Ok((like.unwrap_or(f64::NAN), evaluation.gradient))
    };

    let study = Study {
        project,
        plans: &plans,
        start: &start,
        seconds,
    };
    let mut courses: Vec<Course> = Vec::new();
    for (name, estimator) in estimators() {
        let mut course = study.descend(estimator, &exact)?;
        name.clone_into(&mut course.name);
        let end = courses.first().unwrap_or(&course).end.clone();
        course.cosines = [
            study.mean_cosine(estimator, &start)?,
            study.mean_cosine(estimator, &end)?,
        ];
        println!("{}", row(&course));
        courses.push(course);
    }
    draw(&courses, seconds)
}

/// What is compared.
fn estimators() -> Vec<(&'static str, Option<Estimator>)> {
    let drawn = |kind, each| {
        Some(Estimator {
            kind,
            each,
            refresh: 10,
            temperature: 1.0,
        })
    };
    use EstimatorKind::{ControlVariate, Gumbel, Multinomial, WithoutReplacement};
    vec![
        ("exact", None),
        ("control variate, 16", drawn(ControlVariate, 16)),
        ("control variate, 64", drawn(ControlVariate, 64)),
        ("without replacement, 64", drawn(WithoutReplacement, 64)),
        ("multinomial, 64", drawn(Multinomial, 64)),
        ("multinomial, 256", drawn(Multinomial, 256)),
        ("Gumbel, 8, T = 1", drawn(Gumbel, 8)),
        ("Gumbel, 64, T = 1", drawn(Gumbel, 64)),
    ]
}

/// What all estimators are asked.
struct Study<'a> {
    /// The design.
    project: &'a Project,
    /// How its light is carried.
    plans: &'a Plans,
    /// Where each descent starts.
    start: &'a [f64],
    /// Seconds of the processor that each descent has.
    seconds: f64,
}

/// Evaluations by an estimator; exact ones are renewed where it needs them.
struct Evaluator<'a> {
    /// What is evaluated.
    project: &'a Project,
    /// How its light is carried.
    plans: &'a Plans,
    /// What is drawn; nothing where all beamlets are taken.
    estimator: Option<Estimator>,
    /// The exact evaluations that draws correct.
    control_variates: Vec<raylet::engine::chain::control_variate::ControlVariate>,
}

impl Evaluator<'_> {
    fn evaluate(&mut self, point: &[f64], iteration: usize) -> Result<(f64, Vec<f64>), Failure> {
        if self
            .estimator
            .is_some_and(|drawn| drawn.renews_control_variates(iteration))
        {
            self.control_variates =
                self.project
                    .control_variates(self.plans, point, 1.0, &uncancelled)?;
        }
        let mode = match (
            self.estimator.map(|drawn| drawn.draws(7, iteration)),
            self.control_variates.is_empty(),
        ) {
            (None, _) => EvaluationMode::All,
            (Some(draws), true) => EvaluationMode::Drawn(draws),
            (Some(draws), false) => EvaluationMode::From(&self.control_variates, draws),
        };
        let evaluation = self
            .project
            .evaluate_by(self.plans, point, 1.0, &mode, &uncancelled)?;
        Ok((evaluation.value, evaluation.gradient))
    }
}

impl Study<'_> {
    /// An estimator without exact evaluations so far.
    fn evaluator(&self, estimator: Option<Estimator>) -> Evaluator<'_> {
        Evaluator {
            project: self.project,
            plans: self.plans,
            estimator,
            control_variates: Vec::new(),
        }
    }

    /// Seconds of one evaluation, with its share of the exact ones. Drawn evaluations are a little away from the exact
    /// ones, because nothing is drawn at the same point.
    fn cost(&self, evaluator: &mut Evaluator) -> Result<f64, Failure> {
        let (start, moved) = (self.start, moved(self.start));
        evaluator.evaluate(start, 0)?;
        let before = processor();
        let estimator = evaluator.estimator;
        let trial = match estimator {
            Some(drawn) if drawn.kind == EstimatorKind::ControlVariate => drawn.refresh,
            _ => 3,
        };
        for iteration in 0..trial {
            let exact = estimator.is_some_and(|drawn| drawn.renews_control_variates(iteration));
            evaluator.evaluate(if exact { start } else { &moved }, iteration)?;
        }
        Ok((processor() - before) / trial as f64)
    }

    /// A descent with as many evaluations as fit into the time; what scores them does not count.
    fn descend(&self, estimator: Option<Estimator>, exact: Truth) -> Result<Course, Failure> {
        let mut evaluator = self.evaluator(estimator);
        let cost = self.cost(&mut evaluator)?;
        let evaluations = (self.seconds / cost).ceil().max(1.0) as usize;

        let schedule = Schedule::Cosine {
            from: RATE,
            to: 0.0,
            iterations: evaluations,
        };
        let method = Method::Descent(Rule::ADAM, schedule);
        let space = Space::free(self.start.len());
        let mut search: Optimizer = method.start(self.start.to_vec(), space)?;
        let (mut scores, mut nearness) = (Vec::new(), Vec::new());
        let mut spent = 0.0;
        for iteration in 0..evaluations {
            let before = processor();
            let (value, gradient) = evaluator.evaluate(search.point(), iteration)?;
            let looked = processor() - before;
            if iteration % evaluations.div_ceil(8) == 0 {
                let (like, truth) = exact(search.point())?;
                scores.push([spent, like]);
                nearness.push([spent, cosine(&gradient, &truth)]);
            }
            let before = processor();
            let step = search.report(value, &gradient);
            spent += looked + processor() - before;
            if let Step::Finished(_) = step {
                break;
            }
        }
        scores.push([spent, exact(search.point())?.0]);
        Ok(Course {
            name: String::new(),
            evaluations,
            cosines: [f64::NAN; 2],
            scores,
            nearness,
            end: search.point().to_vec(),
        })
    }

    /// Mean cosine to the exact gradient at a point; for a control variate a little noise away from its exact
    /// evaluation.
    fn mean_cosine(&self, estimator: Option<Estimator>, point: &[f64]) -> Result<f64, Failure> {
        let moved = moved(point);
        let exact = self.project.evaluate(self.plans, &moved, 1.0)?.gradient;
        let mut evaluator = self.evaluator(estimator);
        if estimator.is_some_and(|drawn| drawn.renews_control_variates(0)) {
            evaluator.control_variates =
                self.project
                    .control_variates(self.plans, point, 1.0, &uncancelled)?;
        }
        let mut sum = 0.0;
        for trial in 1..=3 {
            let (_, gradient) = evaluator.evaluate(&moved, 10 * trial + 1)?;
            sum += cosine(&gradient, &exact);
        }
        Ok(sum / 3.0)
    }
}

/// Of the angle between two gradients.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

/// A point with a little noise.
fn moved(point: &[f64]) -> Vec<f64> {
    let noise = |i: usize| 0.1 * (uniform(3, [i as u32, 0, 0, 0]) - 0.5);
    let phases = point.iter().enumerate();
    phases.map(|(i, phase)| phase + noise(i)).collect()
}

/// One row of the table.
fn row(course: &Course) -> String {
    let [spent, score] = course.scores.last().copied().unwrap_or([f64::NAN; 2]);
    let (evaluations, [start, end]) = (course.evaluations, course.cosines);
    let cost = spent / evaluations as f64;
    format!(
        "| {} | {evaluations} | {cost:.2} | {spent:.1} | {start:.3} | {end:.3} | {score:.4} |",
        course.name
    )
}

/// Score and cosine against time.
fn draw(courses: &[Course], seconds: f64) -> Result<(), Failure> {
    let panel = |part: fn(&Course) -> &Vec<[f64; 2]>, named: bool| {
        let line = |course: &Course| {
            let name = if named { &*course.name } else { "" };
            Series::line(name, part(course).iter().copied())
        };
        Panel::lines(courses.iter().map(line).collect())
            .x_axis("processor time of evaluations", "s")
            .x_range([0.0, seconds])
    };
    let scores = panel(|course| &course.scores, true)
        .title("What each makes of a hologram, by Adam")
        .y_axis("NCC, by all beamlets", "");
    let nearness = panel(|course| &course.nearness, false)
        .title("How near the exact gradient it is meanwhile")
        .y_axis("cosine", "")
        .y_range([0.0, 1.05]);
    let rows = vec![vec![scores.into(), nearness.into()]];
    let figure = Figure::new(rows, "Estimators of the gradient");
    std::fs::create_dir_all("out")?;
    std::fs::write("out/estimators.png", figure.width(1400.0).to_png(1.5)?)?;
    Ok(())
}
