//! `raylet hologram SCENE`: the phase with which the sensor shows a picture.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use raylet::design::holograms::hologram::{Score, design};
use raylet::file::arrays::phase_file::PhaseFile;
use raylet::file::decode::fault::Fault;
use raylet::file::model::hologram::{HologramDesign, commission};
use raylet::file::scene::scene_file::Scene;

use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::overrides::start_threads;
use crate::progress::dress;
use crate::say::say;

/// Computes the phase hologram of a scene, on its paraxial train.
#[derive(Args)]
pub(crate) struct Hologram {
    /// The scene file, with a table `[hologram]`.
    scene: PathBuf,
    /// The .npy file for the phase in radians, float64 [y, x]; by default the one that the scene
    /// names. An earlier one that raylet wrote is replaced.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
    /// Number of iterations, in place of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    iterations: Option<u32>,
    /// Replace the lenses by one thin lens at the first vertex, for comparison.
    #[arg(long)]
    naive: bool,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Hologram {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let clock = Instant::now();
        start_threads(self.threads)?;
        let scene = Scene::open(&self.scene)?;
        let mut job = commission(&scene, self.naive)?;
        if let Some(iterations) = self.iterations {
            job.task.iterations = iterations as usize;
        }
        // A place that cannot be written is refused before the work begins.
        let file = self.claim(&scene, &job)?;

        let bar = bar(job.task.iterations as u64);
        let found = design(&job.task, &mut |score| {
            bar.set_position(score.iteration as u64);
            bar.set_message(format!("NCC {:.4}", score.ncc));
        });
        bar.finish_and_clear();
        let found = found.map_err(|error| job.fault(&scene, &error))?;
        job.write(&found.phase, &file)?;
        let seconds = clock.elapsed().as_secs_f64();
        let written = file.path().display();
        let mut summary = summary(&found.score);
        if let [first, _, ..] = scene.wavelength_um.as_slice() {
            summary += &format!("\nfor λ = {first} µm, the first of the scene's wavelengths");
        }
        say(&format!("{summary}\n{seconds:.2} s; phase in {written}\n"))
    }

    /// The file for the phase: the user's choice, or what the scene names.
    fn claim(&self, scene: &Scene, job: &HologramDesign) -> Result<PhaseFile, Fault> {
        match (&self.out, &job.file) {
            (Some(file), _) => PhaseFile::claim(file, self.outputs.replace()),
            (None, Some(file)) => {
                PhaseFile::of_scene(scene, &job.field, file, self.outputs.allowed(None))
            }
            (None, None) => {
                let expected = "--out FILE, or `phase` in the scene's layer of pixels";
                Err(Fault::of_file(
                    &self.scene,
                    "no file for the phase",
                    expected,
                ))
            }
        }
    }
}

fn summary(score: &Score) -> String {
    format!(
        "after {} iterations, on the paraxial train: NCC {:.4} with the softened picture ({:.4} over \
         the whole sensor), {:.1} % of the light in it",
        score.iteration,
        score.ncc,
        score.ncc_sensor,
        100.0 * score.efficiency
    )
}

/// A bar on a terminal, nothing elsewhere.
fn bar(iterations: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(iterations);
    dress(&bar, "hologram [{bar:30}] {percent:>3} %  {msg}  {left}");
    bar
}
