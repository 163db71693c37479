//! Single rays through a system.

use ndarray::{Array1, Array2, Array3};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raylet::engine::follow::{Followed, follow, sensitivity};
use raylet::engine::sway::Variation;
use raylet::file::arrays::Arrays;
use raylet::file::build;
use raylet::file::fault::Fault;
use raylet::file::scene::Scene as File;
use raylet::file::variable::{Address, with_numbers};
use raylet::math::vec3::Vec3;
use raylet::optics::ray::Loss;
use raylet::optics::source::Source;
use raylet::optics::system::System;

use crate::arrays::columns;
use crate::refusal::error;
use crate::scene::Scene;
use crate::watch::{Watch, run};

type Answer<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray3<f64>>,
);

/// Rays through the places `pupil` (rays, 2) of the first screen, in units of the half widths of its opening, of
/// light that is `light` (rays, 3): unit directions of a collimated source, places in mm of a point source.
///
/// Returns points (parts, rays, 3) in mm, directions behind (parts, rays, 3), optical paths (parts, rays) in mm,
/// fates (rays; 0 arrived, else the number of the loss), and derivatives (numbers, 5, rays) of x, y, L, M, path on
/// the sensor. What a lost ray did not reach is NaN.
#[pyfunction]
pub(crate) fn trace<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: &Bound<'py, PyDict>,
    channel: usize,
    pupil: PyReadonlyArray2<'py, f64>,
    light: PyReadonlyArray2<'py, f64>,
    numbers: Vec<String>,
) -> PyResult<Answer<'py>> {
    let (pupil, light) = (
        columns::<f64, 2>("pupil", &pupil)?,
        columns::<f64, 3>("light", &light)?,
    );
    if pupil.len() != light.len() {
        let (pupil, light) = (pupil.len(), light.len());
        return Err(PyValueError::new_err(format!(
            "{pupil} places for {light} rays"
        )));
    }
    scene.check(channel)?;
    let (system, variations) = scene.with_arrays(py, arrays, |file, arrays| {
        let system = build::system_with(file, arrays, channel)?;
        Ok((system, variations(file, arrays, channel, &numbers)?))
    })?;
    let bounds = system.screens[0].bounds();
    let [x0, x1, y0, y1] = bounds.ok_or_else(|| error(py, "the first screen has no edge"))?;
    let place = |[u, v]: [f64; 2]| {
        [
            0.5 * (x0 + x1 + u * (x1 - x0)),
            0.5 * (y0 + y1 + v * (y1 - y0)),
        ]
    };
    let starts: Vec<(Source, [f64; 2])> = (light.into_iter().zip(pupil))
        .map(|(light, at)| (lit(&system.source, light), place(at)))
        .collect();
    let (points, directions, paths, followed, slopes) =
        run(py, None, None, move |watch: &Watch| {
            let one = |(source, at): &(Source, [f64; 2])| {
                watch.pulse();
                follow(&system, source, *at)
            };
            let followed: Vec<Followed> = starts.iter().map(one).collect();
            let slopes = slopes(&system, &variations, &starts, watch);
            let (points, directions, paths) = meetings(&system, &followed);
            (points, directions, paths, followed, slopes)
        })?;
    let fates = followed
        .iter()
        .map(|ray| ray.lost.map_or(0, fate))
        .collect();
    Ok((
        PyArray3::from_owned_array(py, points),
        PyArray3::from_owned_array(py, directions),
        PyArray2::from_owned_array(py, paths),
        PyArray1::from_owned_array(py, Array1::from_vec(fates)),
        PyArray3::from_owned_array(py, slopes),
    ))
}

/// The source of one ray.
fn lit(source: &Source, [x, y, z]: [f64; 3]) -> Source {
    let given = Vec3::new(x, y, z);
    match *source {
        Source::Plane { origin, .. } => Source::Plane {
            direction: given,
            origin,
        },
        Source::Point { reference, .. } => Source::Point {
            position: given,
            reference,
        },
    }
}

/// Relative distance of the neighbours that tell derivatives.
const NEAR: f64 = 1e-5;

/// The neighbours of a system in the numbers at these paths.
fn variations(
    file: &File,
    arrays: &Arrays,
    channel: usize,
    paths: &[String],
) -> Result<Vec<Variation>, Fault> {
    let one = |path: &String| {
        let address = [Address::new(file, path, "element")?];
        let value = address[0].value(file)?;
        let step = if value == 0.0 {
            NEAR
        } else {
            NEAR * value.abs()
        };
        let moved = |by: f64| {
            let scene = with_numbers(file, &address, &[value + by])?;
            build::system_with(&scene, arrays, channel)
        };
        Ok(Variation {
            below: moved(-step)?,
            above: moved(step)?,
            distance: 2.0 * step,
        })
    };
    paths.iter().map(one).collect()
}

fn slopes(
    system: &System,
    variations: &[Variation],
    starts: &[(Source, [f64; 2])],
    watch: &Watch,
) -> Array3<f64> {
    let mut all = Array3::from_elem((variations.len(), 5, starts.len()), f64::NAN);
    if variations.is_empty() {
        return all;
    }
    for (ray, (source, at)) in starts.iter().enumerate() {
        watch.pulse();
        let found = sensitivity(system, variations, source, *at).unwrap_or_default();
        for (number, slopes) in found.into_iter().enumerate() {
            for (which, slope) in slopes.into_iter().enumerate() {
                all[[number, which, ray]] = slope;
            }
        }
    }
    all
}

/// Points, directions and paths of all rays at all parts.
fn meetings(system: &System, followed: &[Followed]) -> (Array3<f64>, Array3<f64>, Array2<f64>) {
    let surfaces: usize = system.trains.iter().map(Vec::len).sum();
    let (parts, rays) = (system.screens.len() + surfaces, followed.len());
    let mut points = Array3::from_elem((parts, rays, 3), f64::NAN);
    let mut directions = points.clone();
    let mut paths = Array2::from_elem((parts, rays), f64::NAN);
    for (ray, followed) in followed.iter().enumerate() {
        for (part, meeting) in followed.meetings.iter().enumerate() {
            let (p, d) = (meeting.point, meeting.direction);
            for (axis, (p, d)) in [(p.x, d.x), (p.y, d.y), (p.z, d.z)].into_iter().enumerate() {
                points[[part, ray, axis]] = p;
                directions[[part, ray, axis]] = d;
            }
            paths[[part, ray]] = meeting.path;
        }
    }
    (points, directions, paths)
}

fn fate(loss: Loss) -> u8 {
    match loss {
        Loss::Clipped => 1,
        Loss::Missed => 2,
        Loss::TotalReflection => 3,
        Loss::Evanescent => 4,
        Loss::NotConverged => 5,
    }
}
