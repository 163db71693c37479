//! Single rays through a system.

#![expect(
    clippy::indexing_slicing,
    reason = "rays are counted by the arrays of places, which were found to be equally long, and the rest is made to their size"
)]

use ndarray::{Array1, Array2, Array3, Axis};
use numpy::{Ix1, Ix2, Ix3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use raylet::engine::geometrical::system_trace::{
    SystemRay, first_meeting, sensitivity, trace_system,
};
use raylet::engine::progress::Cancelled;
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::file::model::build;
use raylet::file::model::variations::variations;
use raylet::math::vec3::Vec3;
use raylet::optics::ray::Loss;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::source::Source;
use raylet::optics::system::System;
use rayon::prelude::*;

use crate::arrays::columns;
use crate::refusal::error;
use crate::scene::Scene;
use crate::typed::{ByPath, Given, Made};
use crate::watch::{Watch, run};

type Answer<'py> = (
    Made<'py, f64, Ix3>,
    Made<'py, f64, Ix3>,
    Made<'py, f64, Ix2>,
    Made<'py, u8, Ix1>,
    Made<'py, f64, Ix3>,
);

/// Where rays start: the places (rays, 2) where they meet the first screen, in units of the half widths of its
/// aperture, and their light (rays, 3): unit directions of a collimated source, places in mm of a point source.
/// Or, `free` of the source, points (rays, 3) in mm and unit directions (rays, 3), both global.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Starts<'py> {
    pupil: Given<'py, f64, Ix2>,
    light: Given<'py, f64, Ix2>,
    free: bool,
}

/// Where the chief ray of the first wavelength meets the sensor, in mm on the sensor's axes; None where it does not.
#[pyfunction]
pub(crate) fn chief_landing(
    py: Python<'_>,
    scene: &Scene,
    arrays: ByPath<'_>,
) -> PyResult<Option<(f64, f64)>> {
    let system = scene.system(py, &arrays, 0)?;
    let landing = py.detach(|| raylet::engine::geometrical::chief_ray::chief_landing(&system));
    Ok(landing.map(|[x, y]| (x, y)))
}

/// Rays by their `starts`, a dictionary: their places "pupil" (rays, 2) on the first screen, in units of the half
/// widths of its aperture, and their "light" (rays, 3): unit directions of a collimated source, places in mm of a point
/// source. If "free" is true, "pupil" are points (rays, 3) in mm where the rays start, and "light" their unit
/// directions, both global; their paths are counted from there.
///
/// Returns points (parts, rays, 3) in mm, directions behind (parts, rays, 3), optical paths (parts, rays) in mm,
/// fates (rays; 0 arrived, else the number of the loss), and derivatives (parameters, 5, rays) of x, y, L, M, path on
/// the sensor. What a lost ray did not reach is NaN.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "its parameters are those of the Python function"
)]
pub(crate) fn trace<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    channel: usize,
    starts: Starts<'py>,
    parameters: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Answer<'py>> {
    let starts = launches(&starts)?;
    scene.check(channel)?;
    let (system, variations) = scene.with_arrays(py, &arrays, |file, arrays| {
        let system = build::system_with(file, arrays, channel)?;
        Ok((system, variations(file, arrays, channel, &parameters)?))
    })?;
    let bounds = system.screens.first().and_then(Screen::bounds);
    let bounds = bounds.ok_or_else(|| error(py, "the first screen has no edge"))?;
    refuse_turned(py, &system, &variations)?;
    let job = Job {
        system,
        variations,
        bounds,
        starts,
    };
    let found = run(py, threads, None, move |watch: &Watch| job.follow(watch))?;
    let found = found.map_err(|failure| error(py, failure))?;
    if !found.arrived_are_finite() {
        return Err(error(
            py,
            "a ray that arrives at places that are not finite",
        ));
    }
    Ok((
        Made::with_gaps(py, found.points),
        Made::with_gaps(py, found.directions),
        Made::with_gaps(py, found.paths),
        Made::with_gaps(py, found.fates),
        Made::with_gaps(py, found.slopes),
    ))
}

/// The starts of all rays.
fn launches(starts: &Starts<'_>) -> PyResult<Vec<Start>> {
    let light = columns::<f64, 3>("light", &starts.light)?;
    let far = |number: &f64, most: f64| number.is_nan() || number.abs() > most;
    let (list, is_far): (Vec<Start>, bool) = if starts.free {
        let points = columns::<f64, 3>("start_mm", &starts.pupil)?;
        let is_far = points.as_flattened().iter().any(|x| far(x, FARTHEST));
        let pairs = points.iter().zip(&light);
        let list = pairs.map(|(&point, &direction)| Start::Point { point, direction });
        (list.collect(), is_far)
    } else {
        let pupil = columns::<f64, 2>("pupil", &starts.pupil)?;
        let is_far = pupil.as_flattened().iter().any(|p| far(p, WIDEST));
        let pairs = pupil.iter().zip(&light);
        let list = pairs.map(|(&at, &light)| Start::Pupil { at, light });
        (list.collect(), is_far)
    };
    if list.len() != light.len() {
        let (places, light) = (list.len(), light.len());
        return Err(PyValueError::new_err(format!(
            "{places} places for {light} rays"
        )));
    }
    if is_far || light.as_flattened().iter().any(|x| far(x, FARTHEST)) {
        let message = format!(
            "places in the pupil beyond {WIDEST:e} half widths, or of the source beyond {FARTHEST:e} mm"
        );
        return Err(PyValueError::new_err(message));
    }
    Ok(list)
}

/// The farthest place of a ray in the pupil, in half widths of the aperture.
const WIDEST: f64 = 1e6;

/// The farthest place of a luminous point in mm.
const FARTHEST: f64 = 1e12;

/// Refuses derivatives where an element turns rays.
fn refuse_turned(py: Python<'_>, system: &System, variations: &[Variation]) -> PyResult<()> {
    let mut screens = system.screens.iter();
    let turned = screens.find(|screen| matches!(screen.kind, ScreenKind::Doe(_)));
    match turned {
        Some(screen) if !variations.is_empty() => Err(error(
            py,
            format!(
                "derivatives of rays that element '{}' turns: they exist through surfaces, mirrors and stops; \
                 System.linearised has those of the field",
                screen.name
            ),
        )),
        _ => Ok(()),
    }
}

/// Rays that are followed side by side before their meetings are written down.
const ROUND: usize = 1 << 14;

/// Rays to follow.
struct Job {
    system: System,
    variations: Vec<Variation>,
    /// Edges of the first screen's aperture.
    bounds: [f64; 4],
    starts: Vec<Start>,
}

/// How a ray starts.
enum Start {
    /// With the light of the source, at a place on the first screen in half widths of its aperture.
    Pupil { at: [f64; 2], light: [f64; 3] },
    /// At a point in mm with a unit direction, both global.
    Point {
        point: [f64; 3],
        direction: [f64; 3],
    },
}

/// Their points, directions and paths at all parts, what became of them, and their derivatives.
struct TracedRays {
    points: Array3<f64>,
    directions: Array3<f64>,
    paths: Array2<f64>,
    fates: Array1<u8>,
    slopes: Array3<f64>,
}

/// A ray, and its derivatives if it has any.
struct Course {
    ray: SystemRay,
    slopes: Vec<[f64; 5]>,
}

impl Course {
    /// A ray that meets nothing.
    fn lost(loss: Loss) -> Self {
        Self {
            ray: SystemRay {
                hits: Vec::new(),
                lost: Some(loss),
            },
            slopes: Vec::new(),
        }
    }
}

impl Job {
    /// All rays, round by round, so that only the answer takes memory.
    fn follow(&self, watch: &Watch) -> Result<TracedRays, Cancelled> {
        let surfaces: usize = self.system.trains.iter().map(Vec::len).sum();
        let (parts, rays) = (self.system.screens.len() + surfaces, self.starts.len());
        let mut found = TracedRays::nowhere(parts, rays, self.variations.len());
        for first in (0..rays).step_by(ROUND) {
            let round = first..rays.min(first + ROUND);
            let courses: Vec<Course> = (round.clone().into_par_iter())
                .map(|ray| {
                    Cancelled::check(watch.pulse())?;
                    Ok(self.one(ray))
                })
                .collect::<Result<_, Cancelled>>()?;
            for (ray, course) in round.zip(&courses) {
                found.write(ray, course);
            }
        }
        Ok(found)
    }

    fn one(&self, ray: usize) -> Course {
        let (source, at) = match self.starts[ray] {
            Start::Pupil { at: [u, v], light } => {
                let [x0, x1, y0, y1] = self.bounds;
                let at = [
                    0.5 * (x0 + x1 + u * (x1 - x0)),
                    0.5 * (y0 + y1 + v * (y1 - y0)),
                ];
                (lit(&self.system.source, light), at)
            }
            Start::Point { point, direction } => {
                let [origin, direction] = [point, direction].map(|[x, y, z]| Vec3::new(x, y, z));
                let at = match first_meeting(&self.system, origin, direction) {
                    Ok(at) => at,
                    Err(lost) => return Course::lost(lost),
                };
                (Source::Plane { direction, origin }, at)
            }
        };
        let slopes = sensitivity(&self.system, &self.variations, &source, at);
        Course {
            ray: trace_system(&self.system, &source, at),
            slopes: slopes.unwrap_or_default(),
        }
    }
}

impl TracedRays {
    /// What is found of rays that reach nothing.
    fn nowhere(parts: usize, rays: usize, parameters: usize) -> Self {
        Self {
            points: Array3::from_elem((parts, rays, 3), f64::NAN),
            directions: Array3::from_elem((parts, rays, 3), f64::NAN),
            paths: Array2::from_elem((parts, rays), f64::NAN),
            fates: Array1::zeros(rays),
            slopes: Array3::from_elem((parameters, 5, rays), f64::NAN),
        }
    }

    /// Whether all numbers of the rays that arrived are finite.
    fn arrived_are_finite(&self) -> bool {
        let arrived = self
            .fates
            .iter()
            .enumerate()
            .filter(|(_, fate)| **fate == 0);
        { arrived }.all(|(ray, _)| {
            let paths = self.paths.column(ray);
            let all = [&self.points, &self.directions].map(|all| all.index_axis(Axis(1), ray));
            let vectors = all.iter().flatten();
            paths.iter().chain(vectors).all(|value| value.is_finite())
        })
    }

    fn write(&mut self, ray: usize, course: &Course) {
        for (part, hit) in course.ray.hits.iter().enumerate() {
            let (p, d) = (hit.point, hit.direction);
            for (axis, (p, d)) in [(p.x, d.x), (p.y, d.y), (p.z, d.z)].into_iter().enumerate() {
                self.points[[part, ray, axis]] = p;
                self.directions[[part, ray, axis]] = d;
            }
            self.paths[[part, ray]] = hit.path;
        }
        for (number, slopes) in course.slopes.iter().enumerate() {
            for (which, &slope) in slopes.iter().enumerate() {
                self.slopes[[number, which, ray]] = slope;
            }
        }
        self.fates[ray] = course.ray.lost.map_or(0, fate);
    }
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
        Source::TaperedPlane {
            origin,
            centre,
            taper,
            ..
        } => Source::TaperedPlane {
            direction: given,
            origin,
            centre,
            taper,
        },
        Source::TaperedPoint {
            reference, taper, ..
        } => Source::TaperedPoint {
            position: given,
            reference,
            taper,
        },
        Source::Gaussian(_) => *source,
    }
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
