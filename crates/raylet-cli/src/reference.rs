//! `raylet reference SCENE`: the same outputs by a method that needs no rays, where one applies.

use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::Instant;

use clap::Args;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::chain::reference::{PADDING, ReferenceOptions, reference};
use raylet::engine::chain::reference_forecast::reference_forecast;
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::Settings;
use raylet::file::model::build;
use raylet::file::model::error_location::reference_fault;
use raylet::file::result::channel::Channel;
use raylet::file::result::channel::micrometres;
use raylet::file::result::report::Report;
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::folder::OutputFolder;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;

use crate::failure::Failure;
use crate::overrides::{by_name, start_threads};
use crate::progress::Meter;
use crate::result_folder::{Light, gather, publish};
use crate::say::{complain, say};
use crate::simulate::{build_all, summary};

/// Carries the light of a scene to its sensor by a method that needs no rays, to compare with.
#[derive(Args)]
pub(crate) struct Reference {
    /// The scene file.
    scene: PathBuf,
    /// Folder for the results; named after the scene by default. An earlier result there is
    /// replaced, anything else is left alone.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the light is carried: auto (the first of the others that applies, hop by hop), angular-spectrum (parallel
    /// screens with at most plane-parallel plates between), rayleigh-sommerfeld (direct sum over all nodes: nothing
    /// between the screens, at any tilt), collins (ray matrices: centred lenses, without their aberrations and rims), or
    /// gsl (one ray per pixel by the generalised law of refraction: smooth elements, no diffraction).
    #[arg(long, default_value = "auto", value_parser = by_name::<Approach>)]
    method: Approach,
    /// Longest direct sum in hours that is begun.
    #[arg(long, value_name = "HOURS", default_value_t = 3.0, value_parser = hours)]
    #[arg(allow_negative_numbers = true)]
    most_hours: f64,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Reference {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let clock = Instant::now();
        let scene = Scene::read(&self.scene)?;
        let settings = Settings {
            padding: PADDING,
            ..build::settings(&scene)
        };
        start_threads(self.threads)?;
        let out = self.out.clone().unwrap_or_else(|| default_out(&self.scene));
        let target = OutputFolder::claim(&out)?;

        // All systems are built before the first is run, so that faults show at once.
        let systems = build_all(&scene)?;
        let (channels, fields) = self.carry_all(&scene, &systems, &settings)?;
        let fields = gather(&systems, fields);
        let seconds = clock.elapsed().as_secs_f64();
        let report = Report::new("reference", &scene, &settings, channels, seconds);
        let light = Light {
            fields,
            errors: &[],
        };
        let report = publish(&target, &scene, &systems, light, report)?;
        say(&summary(&report, &out))
    }

    fn carry_all(
        &self,
        scene: &Scene,
        systems: &[System],
        settings: &Settings,
    ) -> Result<(Vec<Channel>, Vec<Field>), Failure> {
        let choice = ReferenceOptions {
            approach: self.method,
            patience: 3600.0 * self.most_hours,
        };
        let meter = Meter::new(systems.len());
        let (mut channels, mut fields) = (Vec::new(), Vec::new());
        for (number, system) in systems.iter().enumerate() {
            let clock = Instant::now();
            let run = match systems.len() {
                1 => String::new(),
                _ => format!("λ = {} µm, ", micrometres(system.wavelength)),
            };
            let refused = |error| reference_fault(scene, system, settings, choice, &error);
            let steps = reference_forecast(system, settings, choice).map_err(refused)?;

            // A reference that is refused prints no steps, so they are printed with the first progress.
            let told = Once::new();
            let tell = || {
                told.call_once(|| {
                    for step in &steps {
                        complain(&format!("{run}{}", step.line()));
                    }
                });
            };
            let note = |progress: Progress| {
                if progress.done > 0.0 {
                    tell();
                }
                meter.note(number, &run, progress)
            };
            let found = reference(system, settings, choice, &note).map_err(refused)?;
            tell();
            let seconds = clock.elapsed().as_secs_f64();
            channels.push(Channel::of_reference(system, &found, seconds));
            fields.push(found.field);
        }
        Ok((channels, fields))
    }
}

/// The scene's name with "-reference" in the current folder.
fn default_out(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from(format!("{stem}-reference"))
}

/// A span of time on the command line.
fn hours(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hours) if (0.0..=1e9).contains(&hours) => Ok(hours),
        _ => Err(String::from(
            "expected a number of hours, not negative, up to 1e9",
        )),
    }
}
