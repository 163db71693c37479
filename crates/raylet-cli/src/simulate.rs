//! `raylet simulate SCENE`: the field on the sensor, with pictures and numbers.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::error::run_warnings::excess;
use raylet::engine::plan::settings::Settings;
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::result::report::{Channel, HopEntry, Report, above_target, micrometres};
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::folder::OutputFolder;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;

use crate::failure::Failure;
use crate::overrides::Overrides;
use crate::progress::Meter;
use crate::result_folder::{Light, StandardError, gather, publish};
use crate::say::say;

/// Carries the light of a scene to its sensor.
#[derive(Args)]
pub(crate) struct Simulate {
    /// The scene file.
    scene: PathBuf,
    /// Folder for the results; named after the scene by default. An earlier result there is
    /// replaced, anything else is left alone.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

impl Simulate {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let clock = Instant::now();
        let scene = Scene::read(&self.scene)?;
        let mut settings = build::settings(&scene);
        self.overrides.apply(&mut settings)?;
        let out = self.out.clone().unwrap_or_else(|| default_out(&self.scene));
        let target = OutputFolder::claim(&out)?;

        // All systems are built before the first is run, so that faults show at once.
        let systems = build_all(&scene)?;
        let Carried {
            channels,
            fields,
            errors,
        } = carry_all(&scene, &systems, &settings)?;
        let fields = gather(&systems, fields);
        let seconds = clock.elapsed().as_secs_f64();
        let report = Report::new("simulate", &scene, &settings, channels, seconds);
        let light = Light {
            fields,
            errors: &errors,
        };
        let report = publish(&target, &scene, &systems, light, report)?;
        say(&summary(&report, &out))
    }
}

/// The scene's name with "-out" in the current folder.
pub(crate) fn default_out(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from(format!("{stem}-out"))
}

/// The system of every wavelength.
pub(crate) fn build_all(scene: &Scene) -> Result<Vec<System>, Failure> {
    (0..scene.wavelength_um.len())
        .map(|channel| Ok(build::system(scene, channel)?))
        .collect()
}

/// What came out of all wavelengths.
#[derive(Default)]
struct Carried {
    channels: Vec<Channel>,
    fields: Vec<Field>,
    /// Where rays were drawn at random.
    errors: Vec<StandardError>,
}

fn carry_all(scene: &Scene, systems: &[System], settings: &Settings) -> Result<Carried, Failure> {
    let meter = Meter::new();
    let mut carried = Carried::default();
    for system in systems {
        let run = match systems.len() {
            1 => String::new(),
            _ => format!("λ = {} µm, ", micrometres(system.wavelength)),
        };
        let outcome = simulate(system, settings, &|progress| meter.note(&run, progress))
            .map_err(|error| simulate_fault(scene, system, settings, &error))?;
        let channel = Channel::new(&outcome, settings);
        carried.channels.push(channel);
        carried.fields.push(outcome.field);
        carried.errors.extend(outcome.standard_error);
    }
    Ok(carried)
}

/// A run in a few lines.
pub(crate) fn summary(report: &Report, out: &Path) -> String {
    let mut text = String::new();
    for channel in &report.channels {
        let wavelength = channel.wavelength_um;
        let error = channel.error.map_or(String::new(), |error| {
            let mark = above_target(error, report.settings.target_error);
            format!(", expected field error {error:.1e}{mark}")
        });
        let _ = writeln!(text, "λ = {wavelength} µm: {}{error}", light(channel),);
        for hop in &channel.hops {
            let _ = writeln!(text, "  {}", hop_line(hop));
            let drawn = hop.plan.paper.as_ref();
            if let Some(warning) = drawn.and_then(|paper| paper.warning.as_ref()) {
                let _ = writeln!(text, "    warning: {warning}");
            }
            for warning in hop.rims.iter().filter_map(|rim| rim.warning.as_ref()) {
                let _ = writeln!(text, "    warning: {warning}");
            }
        }
        for step in &channel.steps {
            let _ = writeln!(text, "  {}", step.line());
        }
    }
    let memory = report.machine.peak_memory_mb;
    let memory = memory.map_or(String::new(), |mb| format!(", {mb:.0} MB"));
    let _ = writeln!(
        text,
        "{:.2} s on {} threads{memory}; results in {}:",
        report.seconds,
        report.machine.threads,
        out.display()
    );
    let _ = writeln!(text, "  result.json, {}", report.files.join(", "));
    for channel in &report.channels {
        for warning in &channel.warnings {
            let wave = channel.wavelength_um;
            let _ = writeln!(text, "warning: λ = {wave} µm: {warning}");
        }
    }
    text
}

/// The part of the light behind the first screen that the sensor receives. More than all of it is an error of the method,
/// and no share.
fn light(channel: &Channel) -> String {
    let hops = (channel.hops.iter()).map(|hop| [hop.power.behind, hop.power.landed]);
    // A reference has steps in place of hops.
    let steps = (channel.steps.iter()).map(|step| [step.power[1], step.power[2]]);
    let all: Vec<[Option<f64>; 2]> = hops.chain(steps).collect();
    let landed = all.last().and_then(|last| last[1]).unwrap_or(0.0);
    match all.first().and_then(|first| first[0]) {
        Some(behind) => match excess(landed, behind) {
            Some(_) => String::from("more light on the sensor than came"),
            None => {
                let percent = (100.0 * landed / behind).min(100.0);
                format!("{percent:.2} % of the light on the sensor")
            }
        },
        None => format!("{landed:.4e} mm² of the light on the sensor"),
    }
}

fn hop_line(hop: &HopEntry) -> String {
    let plan = &hop.plan;
    let rays = match hop.rays.arrived {
        0 => String::new(),
        rays => format!(", {rays} rays"),
    };
    format!(
        "{} to {}: {} ({}){rays}, {:.2} s",
        plan.from, plan.to, plan.method, plan.why, hop.seconds
    )
}
