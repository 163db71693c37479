//! `raylet simulate SCENE`: the field on the sensor, with pictures and numbers.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::error::run_warnings::excess;
use raylet::engine::plan::settings::Settings;
use raylet::engine::sweep::simulate_all::{FinishedRun, simulate_all};
use raylet::file::model::build;
use raylet::file::result::channel::Channel;
use raylet::file::result::hop_entry::HopEntry;
use raylet::file::result::report::{Report, above_target};
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::folder::OutputFolder;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;

use crate::failure::Failure;
use crate::overrides::Overrides;
use crate::progress::Meter;
use crate::result_folder::{Light, StandardError, gather, publish};
use crate::run_lines::run_lines;
use crate::say::say;
use crate::sweep::{Run, Sweep};

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
    sweep: Sweep,
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
        let runs = self.sweep.runs(&scene, &settings)?;
        let Carried {
            channels,
            fields,
            errors,
        } = carry_all(&runs, &settings)?;
        let systems: Vec<System> = runs.into_iter().map(|run| run.system).collect();
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

/// What came out of all runs.
#[derive(Default)]
struct Carried {
    channels: Vec<Channel>,
    fields: Vec<Field>,
    /// Where rays were drawn at random.
    errors: Vec<StandardError>,
}

/// All runs, as many side by side as threads and memory allow.
fn carry_all(runs: &[Run], settings: &Settings) -> Result<Carried, Failure> {
    let names: Vec<String> = match runs {
        [_] => vec![String::new()],
        _ => runs.iter().map(|run| run.name() + ", ").collect(),
    };
    let meter = Meter::new(runs.len());
    let note = |number: usize, progress: Progress| {
        let name = names.get(number).map_or("", String::as_str);
        meter.note(number, name, progress);
    };
    let finished =
        simulate_all(runs, settings, &note).map_err(|(run, error)| run.fault(settings, &error))?;
    let mut carried = Carried::default();
    for (run, FinishedRun { outcome, seconds }) in runs.iter().zip(finished) {
        carried.channels.push(Channel {
            place: run.place,
            ..Channel::new(&outcome, settings, seconds)
        });
        carried.fields.push(outcome.field);
        carried.errors.extend(outcome.standard_error);
    }
    Ok(carried)
}

/// A run in a few lines; several as a table.
pub(crate) fn summary(report: &Report, out: &Path) -> String {
    let mut text = match report.channels.as_slice() {
        [channel] => one_run(channel, report.settings.target_error),
        channels => run_lines(channels, report.settings.target_error) + &hop_warnings(channels),
    };
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
            let _ = writeln!(text, "warning: {}: {warning}", channel.name());
        }
    }
    text
}

/// A run with its hops.
fn one_run(channel: &Channel, target_error: f64) -> String {
    let mut text = String::new();
    let error = channel.error.map_or(String::new(), |error| {
        let mark = above_target(error, target_error);
        format!(", expected field error {error:.1e}{mark}")
    });
    let _ = writeln!(text, "{}: {}{error}", channel.name(), light(channel));
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
    text
}

/// The warnings of the hops of several runs.
fn hop_warnings(channels: &[Channel]) -> String {
    let mut text = String::new();
    for channel in channels {
        let drawn = channel
            .hops
            .iter()
            .filter_map(|hop| hop.plan.paper.as_ref());
        let rims = channel.hops.iter().flat_map(|hop| &hop.rims);
        let drawn = drawn.filter_map(|paper| paper.warning.as_ref());
        for warning in drawn.chain(rims.filter_map(|rim| rim.warning.as_ref())) {
            let _ = writeln!(text, "  warning: {}: {warning}", channel.name());
        }
    }
    text
}

/// The light on the sensor in words.
fn light(channel: &Channel) -> String {
    let landed = || {
        let last = channel.hops.last().and_then(|hop| hop.power.landed);
        last.or_else(|| channel.steps.last()?.power[2])
            .unwrap_or(0.0)
    };
    match share(channel) {
        Some(share) if share.ends_with('%') => format!("{share} of the light on the sensor"),
        Some(_) => String::from("more light on the sensor than came"),
        None => format!("{:.4e} mm² of the light on the sensor", landed()),
    }
}

/// The part of the light behind the first screen that the sensor receives. More than all of it is an error of the method,
/// and no share.
fn share(channel: &Channel) -> Option<String> {
    let share = channel.light_share?;
    Some(match excess(share, 1.0) {
        Some(_) => String::from("more than came"),
        None => format!("{:.2} %", 100.0 * share.min(1.0)),
    })
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
