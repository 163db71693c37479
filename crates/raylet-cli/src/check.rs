//! `raylet check SCENE`: what a scene says, what a run would do, and what may surprise.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use raylet::engine::advice::advice;
use raylet::engine::settings::Settings;
use raylet::engine::simulate::plan_all;
use raylet::file::blame::blame;
use raylet::file::build;
use raylet::file::prescription::{Part, parts};
use raylet::file::report::{BeamletEntry, PlanEntry};
use raylet::file::scene::Scene;
use raylet::optics::system::System;

use crate::failure::Failure;
use crate::overrides::Overrides;
use crate::say::say;
use crate::simulate::{build_all, trimmed};
use crate::table::table;

/// Validates a scene and shows the system, the plan and warnings, without running it.
#[derive(Args)]
pub(crate) struct Check {
    /// The scene file.
    scene: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
}

impl Check {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let scene = Scene::read(&self.scene)?;
        let mut settings = build::settings(&scene);
        self.overrides.apply(&mut settings)?;
        let mut text = String::new();
        if !scene.title.is_empty() {
            let _ = writeln!(text, "{}", scene.title);
        }
        for system in &build_all(&scene)? {
            let _ = writeln!(text, "λ = {} µm", trimmed(system.wavelength * 1e3));
            text += &prescription(&scene, system);
            text += &plan(&scene, system, &settings)?;
        }
        say(&text)
    }
}

/// The parts of the system as a table.
fn prescription(scene: &Scene, system: &System) -> String {
    let head = [
        "element", "what", "x mm", "y mm", "z mm", "radius mm", "semi-aperture mm", "behind",
        "index", "tilt °",
    ];
    let list = parts(scene, system);
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    format!("\n{}", table(&head, &rows, &[2, 3, 4, 5, 6, 8]))
}

fn row(part: &Part) -> Vec<String> {
    let at = part.frame().origin;
    let [tilt_x, tilt_y] = part.tilt_deg().map(|t| trimmed((t * 1e6).round() * 1e-6));
    vec![
        part.name.clone(),
        part.word().to_owned(),
        fixed(at.x),
        fixed(at.y),
        fixed(at.z),
        part.radius().map_or(String::from("∞"), fixed),
        part.bounds().map_or(String::from("∞"), semi_aperture),
        part.medium.clone(),
        format!("{:.6}", part.index()),
        match (tilt_x == 0.0, tilt_y == 0.0) {
            (true, true) => String::new(),
            _ => format!("x {tilt_x}, y {tilt_y}"),
        },
    ]
}

/// A length to a nanometre and never a negative zero.
fn fixed(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Half the size of an opening.
fn semi_aperture([x0, x1, y0, y1]: [f64; 4]) -> String {
    let (x, y) = (fixed(0.5 * (x1 - x0)), fixed(0.5 * (y1 - y0)));
    if x == y { x } else { format!("{x} × {y}") }
}

/// The plan of every hop, and what there is to say about it.
fn plan(scene: &Scene, system: &System, settings: &Settings) -> Result<String, Failure> {
    let plans = plan_all(system, settings).map_err(|error| blame(scene, &error))?;
    let findings = advice(system, &plans, settings);
    let mut text = String::from("\n");
    for (number, (hop, plan)) in system.hops().zip(&plans).enumerate() {
        let entry = PlanEntry::new(&hop, plan, settings);
        let _ = writeln!(
            text,
            "  {} to {}: {} ({})",
            entry.from, entry.to, entry.method, entry.why
        );
        let [x, y] = entry.directions;
        let _ = writeln!(
            text,
            "    {} × {} directions, p_x {:.4} to {:.4}, p_y {:.4} to {:.4}",
            x.count, y.count, x.lowest, x.highest, y.lowest, y.highest
        );
        if let Some(beamlets) = &entry.beamlets {
            text += &lattice(beamlets);
        }
        for finding in findings.iter().filter(|finding| finding.hop == number) {
            let mark = if finding.warning { "warning" } else { "note" };
            let _ = writeln!(text, "    {mark}: {}", finding.text);
        }
    }
    text.push('\n');
    Ok(text)
}

fn lattice(plan: &BeamletEntry) -> String {
    let correction = if plan.corrected { "with" } else { "without" };
    format!(
        "    σ = {:.2} µm, step {:.2} µm, period {:.2} µm, footprint {:.1} µm, {correction} correction\n    \
         {:.3e} rays, about {:.1} s on one core, aberration error {:.1e}\n",
        plan.sigma_um,
        plan.step_um,
        plan.period_um,
        plan.footprint_um,
        plan.expected_rays,
        plan.expected_seconds,
        plan.expected_error
    )
}
