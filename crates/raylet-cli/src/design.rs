//! `raylet design SCENE`: phases and parameters of the system found by gradients through the real system.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{HumanDuration, ProgressBar};
use raylet::design::optimizers::step::{Step, is_moderate};
use raylet::design::project::DesignEvaluation;
use raylet::design::run::{Run, State};
use raylet::engine::progress::uncancelled;
use raylet::file::arrays::phase_file::PhaseFile;
use raylet::file::decode::fault::Fault;
use raylet::file::model::design_targets::ChannelDescription;
use raylet::file::model::pixel_part::Output;
use raylet::file::model::project::{SceneDesign, scene_design};
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::checkpoint::{Checkpoints, Restored};
use raylet::file::storage::own_file::OwnFile;
use raylet::file::storage::run_folder::RunFolder;
use raylet::wave::grid::metrics::ncc;
use raylet_plot::design_chart::{DesignChart, Row};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::interrupt::{end, is_requested, wait_for_step};
use crate::outputs::Outputs;
use crate::overrides::start_threads;
use crate::progress::dress;
use crate::say::{complain, say};

/// Runs the [design] of a scene: phases of pixels and parameters of the system.
#[derive(Args)]
pub(crate) struct Design {
    /// The scene file, with a table `[design]`.
    scene: PathBuf,
    /// The folder for pictures, checkpoints and the course of the design.
    #[arg(long, value_name = "DIR", default_value = "out/design")]
    out: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
    /// Go on from the last checkpoint in the folder, as if never stopped.
    #[arg(long)]
    resume: bool,
    /// Number of iterations, in place of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    iterations: Option<u32>,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// A cross-correlation may exceed 1 by rounding.
const ROUNDING: f64 = 1e-9;

/// What a checkpoint holds.
#[derive(Serialize, Deserialize)]
struct Saved {
    state: State,
    rows: Vec<Row>,
}

/// A design being run.
struct Course<'a> {
    scene: &'a Scene,
    scene_design: &'a SceneDesign,
    out: &'a Path,
    files: Files,
    checkpoints: Checkpoints,
    rows: Vec<Row>,
}

/// The files that a design leaves, each checked before the work begins.
struct Files {
    /// The arrays that the scene names, in the order of the scene_design's outputs.
    arrays: Vec<PhaseFile>,
    /// The scene with designed parameters, where there are any.
    designed: Option<OwnFile>,
    picture: OwnFile,
    course: OwnFile,
    /// The folder of the last two, which no other run may write meanwhile.
    _folder: RunFolder,
}

impl Design {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let clock = Instant::now();
        start_threads(self.threads)?;
        let mut scene = Scene::open(&self.scene)?;
        if let (Some(design), Some(iterations)) = (&mut scene.design, self.iterations) {
            design.iterations = iterations as usize;
        }
        let scene_design = scene_design(&scene)?;
        let mut course = Course {
            files: self.claim(&scene, &scene_design)?,
            checkpoints: checkpoints(&self.out, &scene, &scene_design)?,
            scene: &scene,
            scene_design: &scene_design,
            out: &self.out,
            rows: Vec::new(),
        };
        let mut run = self.start(&scene_design, &mut course)?;
        let stopped = course.follow(&mut run)?;
        course.save(&run)?;
        if stopped {
            let note = format!(
                "stopped after {} iterations; the same command with --resume goes on",
                run.iteration()
            );
            complain(&note);
            end();
        }
        let evaluation = run.finish().map_err(|error| course.refuse(&error))?;
        course.publish(&run, &evaluation)?;
        say(&format!(
            "{}\n{:.1} s\n",
            course.summary(&run, &evaluation),
            clock.elapsed().as_secs_f64()
        ))
    }

    /// The run from its start, or from the last checkpoint.
    fn start<'b>(
        &self,
        scene_design: &'b SceneDesign,
        course: &mut Course,
    ) -> Result<Run<'b>, Failure> {
        let iterations = scene_design.design.iterations;
        let run = if self.resume {
            let check = |saved: &Saved| saved.check(scene_design);
            let Restored {
                state: saved,
                warning,
            } = course.checkpoints.read(check)?;
            if let Some(warning) = warning {
                complain(&format!("warning: {warning}"));
            }
            course.rows = saved.rows;
            Run::resume(&scene_design.project, saved.state, iterations, &uncancelled)
        } else {
            course.checkpoints.claim(self.outputs.replace())?;
            Run::new(
                &scene_design.project,
                scene_design.search.clone(),
                iterations,
                &uncancelled,
            )
        };
        Ok(run.map_err(|error| course.refuse(&error))?)
    }

    /// Everything that will be written: what may not be is refused before the work begins.
    fn claim(&self, scene: &Scene, scene_design: &SceneDesign) -> Result<Files, Failure> {
        check_distinct(scene, &scene_design.outputs)?;
        let allowed = self.outputs.allowed(Some(&self.out));
        let array =
            |output: &Output| PhaseFile::of_scene(scene, &output.field, &output.file, allowed);
        let replace = self.outputs.replace();
        let held = |name: &str| OwnFile::claim_held(&self.out.join(name), replace);
        Ok(Files {
            _folder: RunFolder::open(&self.out)?,
            arrays: scene_design
                .outputs
                .iter()
                .map(array)
                .collect::<Result<_, _>>()?,
            designed: match scene_design.project.system_parameters.is_empty() {
                true => None,
                false => Some(OwnFile::claim(&designed(scene), replace)?),
            },
            picture: held("design.png")?,
            course: held("course.csv")?,
        })
    }
}

/// The checkpoints of a design in this folder.
fn checkpoints(out: &Path, scene: &Scene, designed: &SceneDesign) -> Result<Checkpoints, Failure> {
    let bytes = State::saved_bytes(&designed.search, designed.design.iterations);
    Ok(Checkpoints::within(out, &scene.to_toml()?, bytes))
}

/// Refuses two arrays in one file.
fn check_distinct(scene: &Scene, outputs: &[Output]) -> Result<(), Fault> {
    for (number, output) in outputs.iter().enumerate() {
        let same = |other: &&Output| other.file.components().eq(output.file.components());
        if let Some(other) = outputs.iter().take(number).find(same) {
            let file = output.file.display();
            let found = format!("{file}, where the design of `{}` goes too", other.field);
            return Err(scene.fault(&output.field, found, "a file of its own"));
        }
    }
    Ok(())
}

/// Where a scene with designed parameters goes: beside the scene, so that the files it names are found.
fn designed(scene: &Scene) -> PathBuf {
    scene.origin.file.with_extension("designed.toml")
}

impl Saved {
    /// Checks that a design can go on from this; returns what was found otherwise.
    fn check(&self, scene_design: &SceneDesign) -> Result<(), String> {
        let iterations = scene_design.design.iterations;
        let checked = self
            .state
            .check(&scene_design.project, &scene_design.search, iterations);
        checked.map_err(|error| error.to_string())?;
        match are_sound(&self.rows, &self.state) {
            true => Ok(()),
            false => Err(String::from("a course of another design")),
        }
    }
}

/// Whether rows are the course to a state: one for each accepted point, up to the last evaluation.
fn are_sound(rows: &[Row], state: &State) -> bool {
    let moderate = |row: &Row| {
        is_moderate(row.loss)
            && is_moderate(row.slope)
            && row.ncc.is_none_or(|ncc| ncc.abs() <= 1.0 + ROUNDING)
            && row.efficiency.is_none_or(is_moderate)
    };
    let mut pairs = rows.iter().zip(rows.iter().skip(1));
    let rises = pairs.all(|(a, b)| a.iteration <= b.iteration && a.evaluations < b.evaluations);
    let ends = match rows.last() {
        Some(last) => {
            last.evaluations == state.evaluations && last.iteration == state.search.iteration()
        }
        None => state.evaluations == 0,
    };
    rows.iter().all(moderate) && rises && ends
}

impl Course<'_> {
    /// Goes on until the iterations are done, or the user stops it; returns whether it was stopped.
    fn follow(&mut self, run: &mut Run) -> Result<bool, Failure> {
        let iterations = self.scene_design.design.iterations;
        let bar = ProgressBar::new(iterations as u64);
        if !std::io::IsTerminal::is_terminal(&std::io::stderr()) {
            bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
        }
        dress(&bar, "design [{bar:30}] {pos}/{len}  {msg}  {left}");
        let (clock, before) = (Instant::now(), run.iteration());
        let mut last_line = Instant::now();
        wait_for_step(true);
        while !run.is_done() {
            let found = run.step().map_err(|error| self.refuse(&error))?;
            if found.step == Step::Trial || !found.evaluation.is_finite() {
                continue;
            }
            let row = self.row(run, &found.evaluation, found.slope);
            self.rows.push(row);
            bar.set_position(run.iteration() as u64);
            bar.set_message(line(&row));
            if bar.is_hidden() && last_line.elapsed() > PATIENCE {
                last_line = Instant::now();
                let done = (run.iteration() - before).max(1) as f64;
                let left = clock
                    .elapsed()
                    .mul_f64((iterations - run.iteration()) as f64 / done);
                complain(&format!(
                    "iteration {}: {}, {:#} left",
                    row.iteration,
                    line(&row),
                    HumanDuration(left)
                ));
            }
            if run
                .iteration()
                .is_multiple_of(self.scene_design.design.checkpoint)
                && !run.is_done()
            {
                self.save(run)?;
                self.draw(run, &found.evaluation)?;
            }
            if is_requested() {
                bar.finish_and_clear();
                return Ok(!run.is_done());
            }
        }
        bar.finish_and_clear();
        wait_for_step(false);
        Ok(false)
    }

    fn row(&self, run: &Run, evaluation: &DesignEvaluation, slope: f64) -> Row {
        let [ncc, efficiency] = self.scores(evaluation);
        Row {
            iteration: run.iteration(),
            evaluations: run.state.evaluations,
            loss: evaluation.value,
            ncc,
            efficiency,
            slope,
        }
    }

    /// NCC and efficiency, means of all channels that have a picture; efficiency of those with a known power.
    fn scores(&self, evaluation: &DesignEvaluation) -> [Option<f64>; 2] {
        let area = self.scene_design.pixel_area;
        let (mut sums, mut counts) = ([0.0; 2], [0; 2]);
        let seen = evaluation.intensities.iter().zip(&evaluation.powers);
        for (description, (intensity, power)) in self.scene_design.described.iter().zip(seen) {
            if let Some([picture, window]) = &description.picture {
                sums[0] += ncc(intensity.view(), picture.view()).unwrap_or(0.0);
                counts[0] += 1;
                if let Some(power) = power {
                    sums[1] += (intensity * window).sum() * area / power.max(f64::MIN_POSITIVE);
                    counts[1] += 1;
                }
            }
        }
        let mean = |sum: f64, count: i32| (count > 0).then(|| sum / f64::from(count));
        [mean(sums[0], counts[0]), mean(sums[1], counts[1])]
    }

    fn save(&self, run: &Run) -> Result<(), Failure> {
        let saved = Saved {
            state: run.state.clone(),
            rows: self.rows.clone(),
        };
        Ok(self.checkpoints.write(&saved)?)
    }

    /// The picture of how far it is.
    fn draw(&self, run: &Run, evaluation: &DesignEvaluation) -> Result<(), Failure> {
        let made = self.scene_design.project.make(run.best(), 1.0);
        let title = match self.scene.title.as_str() {
            "" => "Design",
            title => title,
        };
        let pictures = self.scene_design.described.iter();
        let mut pictures = pictures.filter_map(|description| description.picture.as_ref());
        let seen = self
            .scene_design
            .described
            .iter()
            .zip(&evaluation.intensities);
        let seen = seen.map(|(description, intensity)| (self.name(description), intensity.view()));
        let chart = DesignChart {
            title,
            rows: &self.rows,
            made: &made,
            elements: &self.scene_design.elements,
            target: pictures.next().map(|[picture, _]| picture),
            intensities: seen.collect(),
            sensor: self.scene_design.sensor_half,
        };
        let file = self.files.picture.path();
        let png = chart.png().map_err(|error| {
            Fault::of_file(file, error.to_string(), "a picture that can be drawn")
        })?;
        Ok(self.files.picture.write(&png)?)
    }

    /// What a channel is called.
    fn name(&self, description: &ChannelDescription) -> String {
        let [field, wavelength] = description.place;
        let (fields, lengths) = (&self.scene_design.design.field, &self.scene.wavelength_um);
        let mut name = String::from("On the sensor");
        if lengths.len() > 1
            && let Some(length) = lengths.get(wavelength)
        {
            name = format!("{length} µm");
        }
        if let Some(field) = fields.get(field) {
            let place = match (field.angle_deg, field.position_mm) {
                (Some([x, y]), _) => format!("{x}°, {y}°"),
                (_, Some([x, y, z])) => format!("{x}, {y}, {z} mm"),
                _ => String::new(),
            };
            name += &format!(" from {place}");
        }
        name
    }

    /// Leaves what was found of the pixels, the parameters, the picture and the course.
    fn publish(&self, run: &Run, evaluation: &DesignEvaluation) -> Result<(), Failure> {
        let made = self.scene_design.project.make(run.best(), 1.0);
        for (output, file) in self.scene_design.outputs.iter().zip(&self.files.arrays) {
            file.write(&output.values(&made))?;
        }
        self.draw(run, evaluation)?;
        let mut course = String::from("iteration,evaluations,loss,ncc,efficiency,gradient\n");
        for row in &self.rows {
            course += &format!(
                "{},{},{:e},{},{},{:e}\n",
                row.iteration,
                row.evaluations,
                row.loss,
                share(row.ncc),
                share(row.efficiency),
                row.slope
            );
        }
        self.files.course.write(course.as_bytes())?;
        if let Some(file) = &self.files.designed {
            let designed = self.scene_design.scene_at(self.scene, run.best())?;
            file.write(designed.to_toml()?.as_bytes())?;
        }
        Ok(())
    }

    fn summary(&self, run: &Run, evaluation: &DesignEvaluation) -> String {
        let mut summary = format!(
            "after {} iterations, {} evaluations, through the real system: loss {:.6}",
            run.iteration(),
            run.state.evaluations,
            evaluation.value
        );
        if let [Some(ncc), Some(efficiency)] = self.scores(evaluation) {
            summary += &format!(
                ", NCC {ncc:.4} over the sensor, {:.1} % of the light in the picture's outline",
                100.0 * efficiency
            );
        }
        if !self.scene_design.design.loss.is_empty() {
            for (description, parts) in self.scene_design.described.iter().zip(&evaluation.parts) {
                summary += &format!("\n{}:", self.name(description));
                for (kind, part) in description.kinds.iter().zip(parts) {
                    summary += &format!(" {kind} {part:.5}");
                }
            }
        }
        for output in &self.scene_design.outputs {
            summary += &format!("\n{} in {}", output.what(), output.file.display());
        }
        summary += &format!("\ncourse and picture in {}", self.out.display());
        if let Some(stop) = run.state.stop {
            summary += &format!("\nthe search ended by itself: {}", reason(stop));
        }
        let parameters = run
            .best()
            .iter()
            .skip(self.scene_design.project.system_parameters_from());
        for (parameter, value) in self
            .scene_design
            .project
            .system_parameters
            .iter()
            .zip(parameters)
        {
            summary += &format!("\n{}: {} -> {value}", parameter.name, parameter.start);
        }
        if let Some(file) = &self.files.designed {
            let file = file.path().display();
            summary += &format!("\nscene with these parameters in {file}");
        }
        summary
    }

    fn refuse(&self, error: &dyn std::fmt::Display) -> Fault {
        let expected = "a system that light gets through";
        self.scene.fault("design", error.to_string(), expected)
    }
}

/// Time between lines where there is no bar.
const PATIENCE: Duration = Duration::from_secs(10);

fn line(row: &Row) -> String {
    let mut line = format!("loss {:.5}", row.loss);
    if let (Some(ncc), Some(light)) = (row.ncc, row.efficiency) {
        line += &format!("  NCC {ncc:.4}  light {:.1} %", 100.0 * light);
    }
    line + &format!("  gradient {:.1e}", row.slope)
}

/// A share as the course writes it; nothing where there is none.
fn share(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:.6}"))
}

fn reason(stop: raylet::design::optimizers::step::Stop) -> &'static str {
    use raylet::design::optimizers::step::Stop;
    match stop {
        Stop::Flat => "the gradient vanishes",
        Stop::Still => "the loss changes no more",
        Stop::Stuck => "nothing downhill is better",
        Stop::NotFinite => "the loss is not a number",
    }
}
