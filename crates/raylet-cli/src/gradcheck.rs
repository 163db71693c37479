//! `raylet gradcheck SCENE`: whether the gradients of a design are those of its loss.

use std::fmt::Display;
use std::path::PathBuf;

use clap::Args;
use raylet::design::project::{Plans, Project, ProjectError};
use raylet::engine::progress::uncancelled;
use raylet::file::decode::fault::Fault;
use raylet::file::model::project::scene_design;
use raylet::file::scene::scene_file::Scene;
use raylet::math::random::{Purpose, uniform};

use crate::failure::Failure;
use crate::overrides::start_threads;
use crate::say::say;

/// Compares the gradient of a scene's design with differences of its loss.
#[derive(Args)]
pub(crate) struct Gradcheck {
    /// The scene file, with a table `[design]`.
    scene: PathBuf,
    /// Threads to use; all processors by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Random directions along which all pixels change.
const DIRECTIONS: u32 = 3;

/// Change of a phase in rad, for differences.
const TURN: f64 = 1e-3;

/// What is written below the table.
const TAIL: &str = "differences are of fourth order, through the same plans; their own rounding is about 1e-9, and 1e-4 by \
     local bands, which choose carriers anew\n";

impl Gradcheck {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        start_threads(self.threads)?;
        let scene = Scene::open(&self.scene)?;
        let scene_design = scene_design(&scene)?;
        let project = &scene_design.project;
        let refuse = |error: &dyn Display| -> Fault {
            let expected = "a system that light gets through";
            scene.fault("design", error.to_string(), expected)
        };
        let point = scene_design.search.point();
        let plans = project
            .plan(point, 0.0, &uncancelled)
            .map_err(|error| refuse(&error))?;
        let evaluation = project
            .evaluate(&plans, point, 0.0)
            .map_err(|error| refuse(&error))?;

        // Each line has a direction of the parameters and the two slopes along it.
        let mut table = head(evaluation.value);
        for direction in directions(project, scene.seed) {
            let slope = direction.slope(&evaluation.gradient);
            let found =
                differences(project, &plans, point, &direction).map_err(|error| refuse(&error))?;
            if !(evaluation.value.is_finite() && slope.is_finite() && found.is_finite()) {
                let name = &direction.name;
                let infinite = format!("a loss or slope along {name} that is not finite");
                return Err(refuse(&infinite).into());
            }
            table += &direction.line(slope, found);
        }
        say(&(table + TAIL))
    }
}

/// A direction in which parameters change.
struct Direction {
    /// Its name in the table.
    name: String,
    /// How far each parameter changes for a step of one.
    along: Vec<f64>,
    /// The step for differences.
    step: f64,
}

impl Direction {
    /// The slope of the loss along it, by the gradient.
    fn slope(&self, gradient: &[f64]) -> f64 {
        let along = self.along.iter();
        along.zip(gradient).map(|(a, g)| a * g).sum()
    }

    /// Its line in the table.
    fn line(&self, slope: f64, found: f64) -> String {
        let (name, apart) = (&self.name, apart(slope, found));
        format!("{name:<44} {slope:>16.9e} {found:>16.9e} {apart:>9}\n")
    }
}

/// The loss, and the names of the columns.
fn head(loss: f64) -> String {
    format!(
        "loss {loss:.9e}\n{:<44} {:>16} {:>16} {:>9}\n",
        "along", "gradient", "differences", "apart"
    )
}

/// Random directions of all pixels, and every parameter of the system.
fn directions(project: &Project, seed: u64) -> Vec<Direction> {
    let pixels = project.system_parameters_from();
    let count = if pixels > 0 { DIRECTIONS } else { 0 };
    let random = (0..count).map(|number| random_direction(project, seed, number));
    let parameters = project.system_parameters.iter().enumerate();
    let single = parameters.map(|(i, parameter)| {
        let along = |place: usize| f64::from(u8::from(place == pixels + i));
        Direction {
            name: parameter.name.clone(),
            along: (0..project.len()).map(along).collect(),
            step: parameter.step,
        }
    });
    random.chain(single).collect()
}

/// A random direction of all pixels.
fn random_direction(project: &Project, seed: u64, number: u32) -> Direction {
    let pixels = project.system_parameters_from();
    let along = |i: usize| match i < pixels {
        true => {
            let address = [i as u32, number, 0, Purpose::GradientCheck as u32];
            uniform(seed, address) - 0.5
        }
        false => 0.0,
    };
    Direction {
        name: format!("all pixels, random direction {}", number + 1),
        along: (0..project.len()).map(along).collect(),
        step: TURN,
    }
}

/// The difference of two slopes over the larger of them; nothing where both are zero.
fn apart(slope: f64, found: f64) -> String {
    match slope.abs().max(found.abs()) {
        0.0 => String::from("-"),
        larger => format!("{:.1e}", (slope - found).abs() / larger),
    }
}

/// The slope of the loss along a direction by fourth-order central differences.
fn differences(
    project: &Project,
    plans: &Plans,
    point: &[f64],
    direction: &Direction,
) -> Result<f64, ProjectError> {
    let (along, step) = (&direction.along, direction.step);
    let at = |by: f64| {
        let moved: Vec<f64> = point.iter().zip(along).map(|(p, a)| p + by * a).collect();
        project.value(plans, &moved, 0.0)
    };
    let near = at(step)? - at(-step)?;
    let far = at(2.0 * step)? - at(-2.0 * step)?;
    Ok((8.0 * near - far) / (12.0 * step))
}

#[cfg(test)]
mod tests {
    use crate::gradcheck::apart;

    /// A slope of zero was once divided by, which gave 1.4e306.
    #[test]
    fn slopes_are_compared_with_the_larger_one() {
        assert_eq!(apart(2.0, 2.0), "0.0e0");
        assert_eq!(apart(1e-2, 0.0), "1.0e0");
        assert_eq!(apart(0.0, -3e-9), "1.0e0");
        assert_eq!(apart(0.0, 0.0), "-");
    }
}
