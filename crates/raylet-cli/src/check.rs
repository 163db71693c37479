//! `raylet check SCENE`: what a scene says, what a run would do, and warnings.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use raylet::engine::chain::forecast::{Forecast, RunForecast, expected_error, forecast_run};
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::error::advice::advice;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::settings::Settings;
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::model::phase_units::phase_units;
use raylet::file::model::prescription::{Part, parts};
use raylet::file::result::channel::micrometres;
use raylet::file::result::document;
use raylet::file::result::hop_entry::{BeamletEntry, LocalBandEntry, PlanEntry};
use raylet::file::result::report::above_target;
use raylet::file::result::rim::RimEntry;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::paraxial::{Cardinal, ParaxialError};
use raylet::optics::phase::vertex_power::vertex_power;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::system::{Hop, System};
use raylet_plot::text_table::table;

use crate::failure::Failure;
use crate::overrides::Overrides;
use crate::say::say;
use crate::simulate::build_all;
use crate::wait::Wait;

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
        text += &memory_limit_line(&scene, &settings);
        let wait = Wait::new();
        for system in &build_all(&scene)? {
            let _ = writeln!(text, "λ = {} µm", micrometres(system.wavelength));
            text += &prescription(&scene, system);
            text += &paraxial(system);
            text += &plan(&scene, system, &settings, &wait)?;
        }
        drop(wait);
        for (path, finding) in phase_units(&scene, &scene.arrays) {
            let _ = writeln!(text, "warning: {path}: {finding}");
        }
        say(&text)
    }
}

/// The most memory that arrays may take, and what sets it.
fn memory_limit_line(scene: &Scene, settings: &Settings) -> String {
    let megabytes = settings.memory_limit as f64 * 1e-6;
    let set_by = match scene.settings.memory_limit_mb {
        Some(_) => "settings.memory_limit_mb",
        None => "half of what is free; settings.memory_limit_mb sets another",
    };
    format!("memory limit {megabytes} MB ({set_by})\n")
}

/// The parts of the system as a table.
fn prescription(scene: &Scene, system: &System) -> String {
    let head = [
        "element",
        "what",
        "x mm",
        "y mm",
        "z mm",
        "radius mm",
        "semi-aperture mm",
        "behind",
        "index",
        "tilt °",
    ];
    let list = parts(scene, system);
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    format!("\n{}\n", table(&head, &rows, &[2, 3, 4, 5, 6, 8]))
}

fn row(part: &Part) -> Vec<String> {
    let at = part.frame().origin;
    let [tilt_x, tilt_y] = part.tilt_deg().map(fixed);
    vec![
        part.name.clone(),
        part.word().to_owned(),
        fixed(at.x),
        fixed(at.y),
        fixed(at.z),
        radii(part.radii()),
        part.bounds().map_or(String::from("∞"), semi_aperture),
        part.medium.clone(),
        format!("{:.6}", part.index()),
        match (tilt_x.as_str(), tilt_y.as_str()) {
            ("0", "0") => String::new(),
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

/// One radius, or that along x × that along y; ∞ where a part is straight.
fn radii(radii: [Option<f64>; 2]) -> String {
    let [x, y] = radii.map(|radius| radius.map_or(String::from("∞"), fixed));
    if x == y { x } else { format!("{x} × {y}") }
}

/// Half the size of an aperture.
fn semi_aperture([x0, x1, y0, y1]: [f64; 4]) -> String {
    let (x, y) = (fixed(0.5 * (x1 - x0)), fixed(0.5 * (y1 - y0)));
    if x == y { x } else { format!("{x} × {y}") }
}

/// Focal length, back focal distance, principal planes and numerical aperture of every train with power, and of all parts
/// together where elements bend light, too.
fn paraxial(system: &System) -> String {
    let k = system.wavenumber();
    let elements = || {
        let screens = system.screens.iter();
        screens.filter(|screen| matches!(screen.kind, ScreenKind::Doe(_)))
    };
    let bends = |screen: &Screen| {
        screen.behind.is_some() || vertex_power(screen, k).is_some_and(|power| power != 0.0)
    };
    let with_elements = elements().any(bends);
    let mut text = String::new();
    for hop in system.hops().filter(|hop| !hop.train.is_empty()) {
        let line = cardinal_line(Cardinal::of_hop(&hop), hop.from);
        let alone = match with_elements {
            true => ", surfaces alone",
            false => "",
        };
        let (from, to) = (&hop.from.name, &hop.to.name);
        let _ = writeln!(text, "  {from} to {to}{alone}: {line}");
    }
    if let Some(first) = system.screens.first().filter(|_| with_elements) {
        let left_out = elements().filter(|screen| vertex_power(screen, k).is_none());
        let names: Vec<&str> = left_out.map(|screen| screen.name.as_str()).collect();
        let without = match names.is_empty() {
            true => String::new(),
            false => format!(" but the phase of '{}'", names.join("', '")),
        };
        let line = cardinal_line(Cardinal::of_system(system), first);
        let _ = writeln!(text, "  all parts{without}: {line}");
    }
    text
}

/// First-order properties in words, for a beam as wide as the first screen.
fn cardinal_line(found: Result<Option<Cardinal>, ParaxialError>, first: &Screen) -> String {
    let cardinal = match found {
        Ok(Some(cardinal)) => cardinal,
        Ok(None) => return String::from("no power"),
        Err(error) => return format!("no paraxial data: {error}"),
    };
    let aperture = first.bounds().map_or(String::new(), |[x0, x1, y0, y1]| {
        let radius = 0.5 * (x1 - x0).max(y1 - y0);
        let na = cardinal.numerical_aperture(radius);
        format!(
            ", image-space NA {na:.4} at a beam radius of {} mm",
            fixed(radius)
        )
    });
    format!(
        "focal length {} mm, back focal distance {} mm, principal planes {} mm from the first and {} mm from the last \
         vertex{aperture}",
        fixed(cardinal.focal_length()),
        fixed(cardinal.back_focus()),
        fixed(cardinal.front_principal_plane()),
        fixed(cardinal.rear_principal_plane()),
    )
}

/// What a run would do hop by hop, and what there is to say about it.
fn plan(
    scene: &Scene,
    system: &System,
    settings: &Settings,
    wait: &Wait,
) -> Result<String, Failure> {
    let wavelength = micrometres(system.wavelength);
    wait.note(format!(
        "looking for rims that cut light, λ = {wavelength} µm"
    ));
    // As it will be run: rims that become screens have hops of their own.
    let given = system;
    let RunForecast { rimmed, hops } = planned(given, settings, wait)
        .map_err(|error| simulate_fault(scene, given, settings, &error))?;
    let system = &rimmed.system;
    let methods: Vec<HopMethod> = hops.iter().map(|hop| hop.method.clone()).collect();
    wait.note(format!("following rays for warnings, λ = {wavelength} µm"));
    let findings = advice(given, &rimmed, &methods, settings);
    let mut text = String::from("\n");
    for names in rimmed.joined(given) {
        let names = names.join("' and '");
        let _ = writeln!(
            text,
            "  '{names}' stand in one place and act as one element"
        );
    }
    for (number, (hop, forecast)) in system.hops().zip(&hops).enumerate() {
        let entry = PlanEntry::new(&hop, &forecast.method, settings);
        document::text(
            &entry,
            &format!("the plan of {} to {}", entry.from, entry.to),
        )?;
        text += &hop_lines(&entry, forecast);
        for rim in rimmed.rims.iter().filter(|rim| rim.hop == number) {
            let entry = RimEntry::new(rim);
            document::text(&entry, &format!("the rim of {}", entry.name))?;
            let _ = writeln!(text, "    {}", entry.line());
        }
        for finding in findings.iter().filter(|finding| finding.hop == number) {
            let mark = if finding.warning { "warning" } else { "note" };
            let _ = writeln!(text, "    {mark}: {}", finding.text);
        }
    }
    text += &run_line(expected_error(&rimmed, &hops), &hops, settings);
    text.push('\n');
    Ok(text)
}

/// What the whole run is expected to take and to miss.
fn run_line(error: Option<f64>, hops: &[Forecast], settings: &Settings) -> String {
    let seconds: f64 = hops.iter().map(|hop| hop.work.seconds).sum();
    let error = error.map_or(String::new(), |error| {
        let target = settings.target_error;
        let mark = above_target(error, target);
        format!("; expected field error {error:.1e}{mark}")
    });
    format!("  the run: about {seconds:.1} s on one core{error}\n")
}

/// Plans all hops. Where that takes long, `wait` says which hop is being planned.
fn planned(
    system: &System,
    settings: &Settings,
    wait: &Wait,
) -> Result<RunForecast, SimulateError> {
    let wavelength = micrometres(system.wavelength);
    forecast_run(system, settings, |[number, count], hop: &Hop| {
        wait.note(format!(
            "planning hop {} of {count} to '{}', λ = {wavelength} µm",
            number + 1,
            hop.to.name
        ));
    })
}

/// How a hop is carried, and what that takes.
fn hop_lines(entry: &PlanEntry, forecast: &Forecast) -> String {
    let mut text = format!(
        "  {} to {}: {} ({})\n",
        entry.from, entry.to, entry.method, entry.why
    );
    if let Some([x, y]) = entry.directions {
        let _ = writeln!(
            text,
            "    {} × {} directions, p_x {:.4} to {:.4}, p_y {:.4} to {:.4}",
            x.count, y.count, x.lowest, x.highest, y.lowest, y.highest
        );
    }
    if let Some(plan) = &entry.local_bands {
        text += &local_band_line(plan);
    }
    if let Some(plan) = &entry.beamlets {
        text += &beamlet_lines(plan, entry.expected_rays);
    }
    if let Some(plan) = &entry.planes {
        let _ = writeln!(
            text,
            "    {:.2e} rays; windows of σ = {:.2} µm, {:.2} × {:.2} µm apart, period {:.2} µm",
            entry.expected_rays, plan.sigma_um, plan.steps_um[0], plan.steps_um[1], plan.period_um
        );
    }
    if let Some(plan) = &entry.paper {
        let _ = writeln!(
            text,
            "    {} positions with {} modes each, patches of {:.2} µm, period {:.2} µm",
            plan.positions, plan.secondary, plan.side_um, plan.period_um
        );
    }
    text + &memory_line(forecast)
}

/// The windows of local bands.
fn local_band_line(plan: &LocalBandEntry) -> String {
    let correction = if plan.corrected { "with" } else { "without" };
    let [nx, ny] = plan.windows;
    format!(
        "    {nx} × {ny} windows of σ = {:.2} µm, {:.2} µm apart, period {:.2} µm; {correction} correction\n",
        plan.sigma_um, plan.step_um, plan.period_um
    )
}

/// The lattice of beamlets, and what its rays take.
fn beamlet_lines(plan: &BeamletEntry, rays: f64) -> String {
    let correction = if plan.corrected { "with" } else { "without" };
    let lattice = format!(
        "    windows of σ = {:.2} µm, {:.2} µm apart, period {:.2} µm; footprint {:.1} µm; \
         {correction} correction\n",
        plan.sigma_um, plan.step_um, plan.period_um, plan.footprint_um
    );
    let work = format!(
        "    {rays:.2e} rays, about {:.1} s on one core; aberration and windows {:.1e}\n",
        plan.expected_seconds, plan.expected_error
    );
    lattice + &work
}

/// The samples of whole fields, and the memory that a hop needs.
fn memory_line(forecast: &Forecast) -> String {
    let megabytes = forecast.bytes() as f64 * 1e-6;
    match &forecast.grids {
        Some(grids) => {
            let [[ny, nx], [my, mx]] = [grids.samples, grids.sums];
            format!("    {nx} × {ny} samples to {mx} × {my}, about {megabytes:.0} MB\n")
        }
        None => format!(
            "    no whole field; {:.2e} rays, about {megabytes:.0} MB of beamlets and {:.1} s on one core\n",
            forecast.work.rays, forecast.work.seconds
        ),
    }
}
