//! What a system looks like: its parts, its section, its elements.

use std::sync::Arc;

use ndarray::Array2;
use num_complex::Complex64;
use numpy::Ix2;
use pyo3::prelude::*;
use raylet::engine::chain::forecast::{RunForecast, forecast_run};
use raylet::engine::error::advice::advice;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::file::decode::fault::{Fault, shortened};
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::model::phase_units::phase_units;
use raylet::file::model::prescription::parts as list;
use raylet::file::model::scene_sweep::{named_fields, scene_at_place};
use raylet::file::result::channel::Place;
use raylet::optics::media::catalog;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet_plot::layout_picture::{self, FieldView};
use raylet_plot::pictures::doe_map;
use raylet_plot::section_panel::CurveKind;
use raylet_plot::sensor_panels::{DECADES, PHASE_FLOOR, Quantity, SensorPanels, SensorRow};
use serde_json::{Value, json};

use crate::refusal::{error, fault};
use crate::scene::Scene;
use crate::typed::{ByPath, Made, finite};
use crate::watch::{Watch, run};

/// The panels of a sensor's picture as JSON: what `raylet simulate` shows of runs with these names on pixels with these
/// centres in x and y.
#[pyfunction]
pub(crate) fn sensor_panels(x_mm: Vec<f64>, y_mm: Vec<f64>, names: Vec<String>) -> String {
    let plan = SensorPanels::new([&x_mm, &y_mm], &names, false);
    let panel = |quantity: &Quantity| json!([quantity.word(), quantity.title()]);
    let row = |row: &SensorRow| {
        let panels: Vec<Value> = row.quantities.iter().map(panel).collect();
        json!({"channel": row.channel, "note": row.note, "panels": panels})
    };
    json!({
        "rows": plan.rows.iter().map(row).collect::<Vec<Value>>(),
        "ranges_mm": plan.ranges_mm,
        "unit": plan.unit.0,
        "per_mm": plan.unit.1,
        "stretch": plan.stretch,
        "line": plan.line,
        "phase_floor": PHASE_FLOOR,
        "decades": DECADES,
    })
    .to_string()
}

/// The system in each of some fields of light, angles in degrees or places in mm; without any, in those that its scene
/// names.
fn in_fields(
    py: Python<'_>,
    scene: &Scene,
    arrays: &ByPath<'_>,
    channel: usize,
    fields: &[Vec<f64>],
) -> PyResult<Vec<(String, System)>> {
    scene.check(channel)?;
    let named = || named_fields(&scene.file);
    let given = fields.iter().map(|field| Place {
        angle_deg: <[f64; 2]>::try_from(field.as_slice()).ok(),
        position_mm: <[f64; 3]>::try_from(field.as_slice()).ok(),
        ..Place::default()
    });
    let places: Vec<Place> = match fields.is_empty() {
        true => named(),
        false => given.collect(),
    };
    let own = named().first().copied();
    scene.with_arrays(py, arrays, |file, arrays| {
        let there = |place: &Place| {
            let name = place.light().unwrap_or_default();
            let system = match own.as_ref() == Some(place) {
                true => build::system_with(file, arrays, channel),
                false => {
                    let moved = scene_at_place(file, place, false)?;
                    build::system_with(&moved, arrays, channel)
                }
            };
            Ok((name, system?))
        };
        places.iter().map(there).collect()
    })
}

/// The section through a system as JSON, with the light of some fields, or of those that the scene names: rays,
/// surfaces, glass and labels as points (z, transverse) in mm.
#[pyfunction]
pub(crate) fn layout(
    py: Python<'_>,
    scene: &Scene,
    arrays: ByPath<'_>,
    channel: usize,
    fields: Vec<Vec<f64>>,
) -> PyResult<String> {
    let systems = in_fields(py, scene, &arrays, channel, &fields)?;
    let views: Vec<FieldView> = (systems.iter())
        .map(|(name, system)| FieldView {
            name: name.clone(),
            system,
        })
        .collect();
    let (drawn, transverse) = layout_picture::layout(&scene.file, &views);
    let kind = |kind: CurveKind| match kind {
        CurveKind::Surface => "surface",
        CurveKind::Mirror => "mirror",
        CurveKind::Doe => "doe",
        CurveKind::Stop => "stop",
        CurveKind::Sensor => "sensor",
        CurveKind::Screen => "screen",
    };
    let rays = drawn
        .rays
        .iter()
        .map(|ray| json!({"points": ray.points, "group": ray.group}));
    let surfaces = drawn.surfaces.iter();
    let surfaces = surfaces.map(|curve| json!({"points": curve.points, "kind": kind(curve.kind)}));
    let labels = drawn
        .labels
        .iter()
        .map(|label| json!({"at": label.at, "text": label.text}));
    let points = (drawn.rays.iter().flat_map(|ray| &ray.points))
        .chain(drawn.surfaces.iter().flat_map(|curve| &curve.points))
        .chain(drawn.glass.iter().flat_map(|region| &region.points))
        .chain(drawn.labels.iter().map(|label| &label.at));
    finite(py, points.flatten())?;
    let all = json!({
        "transverse": transverse,
        "rays": rays.collect::<Vec<Value>>(),
        "ray_groups": drawn.ray_groups,
        "surfaces": surfaces.collect::<Vec<Value>>(),
        "glass": drawn.glass.iter().map(|glass| json!(glass.points)).collect::<Vec<Value>>(),
        "labels": labels.collect::<Vec<Value>>(),
    });
    Ok(all.to_string())
}

/// The parts of a system in the order light meets them, as JSON.
#[pyfunction]
pub(crate) fn parts(
    py: Python<'_>,
    scene: &Scene,
    arrays: ByPath<'_>,
    channel: usize,
) -> PyResult<String> {
    let system = scene.system(py, &arrays, channel)?;
    let part = |part: raylet::file::model::prescription::Part| {
        let frame = part.frame();
        let axes = [frame.x, frame.y, frame.z].map(|axis| [axis.x, axis.y, axis.z]);
        let origin = frame.origin;
        json!({
            "name": part.name,
            "kind": part.word(),
            "position_mm": [origin.x, origin.y, origin.z],
            "axes": axes,
            "radii_mm": part.radii(),
            "tilt_deg": part.tilt_deg(),
            "bounds_mm": part.bounds(),
            "index": part.index(),
            "medium": part.medium,
        })
    };
    let parts: Vec<Value> = list(&scene.file, &system).into_iter().map(part).collect();
    Ok(json!(parts).to_string())
}

/// The transmission of a diffractive element over its aperture: complex [y, x] at the centres of equal cells, and
/// the box [x_min, x_max, y_min, y_max] in mm.
#[pyfunction]
pub(crate) fn element<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    name: &str,
    channel: usize,
) -> PyResult<(Made<'py, Complex64, Ix2>, [f64; 4])> {
    let system = scene.system(py, &arrays, channel)?;
    let screen = system.screens.iter().find(|screen| screen.name == name);
    let Some(ScreenKind::Doe(doe)) = screen.map(|screen| &screen.kind) else {
        let screens = system.screens.iter();
        let names = screens.filter(|screen| matches!(screen.kind, ScreenKind::Doe(_)));
        let names: Vec<&str> = names.map(|screen| screen.name.as_str()).collect();
        let known = match names.is_empty() {
            true => String::from("there is none"),
            false => format!("there are: '{}'", names.join("', '")),
        };
        let message = format!(
            "no diffractive element is called '{}'; {known}",
            shortened(name)
        );
        return Err(error(py, message));
    };
    let bounds = doe
        .bounds()
        .ok_or_else(|| error(py, format!("element '{name}' has no edge")))?;
    let map: Array2<Complex64> = py.detach(|| doe_map(doe, bounds));
    Ok((Made::new(py, map)?, bounds))
}

/// What there is to say about a system before it is run: of each finding the hop, whether it is a warning, the words.
#[pyfunction]
pub(crate) fn check(
    py: Python<'_>,
    scene: &Scene,
    arrays: ByPath<'_>,
    channel: usize,
) -> PyResult<Vec<(String, bool, String)>> {
    let system = scene.system(py, &arrays, channel)?;
    let units = scene.with_arrays(py, &arrays, |file, arrays| Ok(phase_units(file, arrays)))?;
    let units = units.into_iter().map(|(path, text)| (path, true, text));
    let file = Arc::clone(&scene.file);
    let work = move |watch: &Watch| {
        let settings = build::settings(&file);
        // As it will be run: rims that become screens have hops of their own.
        let given = system;
        let planned = forecast_run(&given, &settings, |_, _| watch.pulse());
        let RunForecast { rimmed, hops } =
            planned.map_err(|failure| simulate_fault(&file, &given, &settings, &failure))?;
        let system = &rimmed.system;
        let methods: Vec<HopMethod> = hops.into_iter().map(|hop| hop.method).collect();
        let findings = advice(&given, &rimmed, &methods, &settings).into_iter();
        let between = |hop: usize| {
            let ends = system.screens.iter().skip(hop).take(2);
            let names: Vec<&str> = ends.map(|screen| screen.name.as_str()).collect();
            names.join(" to ")
        };
        let findings = findings.map(|one| (between(one.hop), one.warning, one.text));
        Ok(findings.chain(units).collect())
    };
    run(py, None, None, work)?.map_err(|failure: Fault| fault(py, &failure))
}

/// The JSON Schema of scenes, in which every key is explained.
#[pyfunction]
pub(crate) fn schema() -> String {
    raylet::file::scene::scene_file::schema().to_string()
}

/// The names of all glasses.
#[pyfunction]
pub(crate) fn glasses() -> Vec<String> {
    catalog::glasses()
        .iter()
        .map(catalog::Glass::name)
        .collect()
}
