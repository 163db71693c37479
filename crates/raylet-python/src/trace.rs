//! Single rays through a system.

use std::borrow::Cow;

use ndarray::{Array1, Array3, Axis};
use numpy::{Ix1, Ix2, Ix3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use raylet::engine::geometrical::system_trace::RaySensitivity;
use raylet::engine::progress::Cancelled;
use raylet::engine::ray_block::ray_origins::RayOrigins;
use raylet::engine::ray_block::system_derivatives::{ByLandings, SystemDerivatives};
use raylet::engine::ray_block::system_rays::{SystemRays, TracksMut};
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::file::model::build;
use raylet::file::model::variations::variations;
use raylet::optics::ray::Loss;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::system::System;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::arrays::{columns, in_order};
use crate::refusal::error;
use crate::scene::Scene;
use crate::typed::{ByPath, Filled, Given, Made};
use crate::watch::{Watch, pool, run_borrowing};

/// Fates of rays, and their derivatives.
type Answer<'py> = (Made<'py, u8, Ix1>, Made<'py, f64, Ix3>);

/// Where rays start: their places "x" and "y" (rays) on the first screen, in units of the half widths of its aperture, and
/// their "light" (rays, 3), or (1, 3) for all: unit directions of a collimated source, places in mm of a point source.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PupilStarts<'py> {
    x: Given<'py, f64, Ix1>,
    y: Given<'py, f64, Ix1>,
    light: Given<'py, f64, Ix2>,
}

/// Or, free of the source, points "start_mm" (rays, 3) and unit directions "cosines" (rays, 3), both global; one serves
/// all.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FreeStarts<'py> {
    start_mm: Given<'py, f64, Ix2>,
    cosines: Given<'py, f64, Ix2>,
}

/// One of both.
#[derive(FromPyObject)]
pub(crate) enum Starts<'py> {
    /// With light of the source.
    Pupil(PupilStarts<'py>),
    /// Free of it.
    Free(FreeStarts<'py>),
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
    Ok(landing.map(|chief| (chief.at[0], chief.at[1])))
}

/// Rays by their `starts`, a dictionary: either places "x" and "y" (rays) on the first screen, in units of the half
/// widths of its aperture, and "light" (rays, 3), unit directions of a collimated source or places in mm of a point
/// source; or points "start_mm" (rays, 3) and their unit "cosines" (rays, 3), both global, from where paths count. One
/// entry of "light", "start_mm" or "cosines" serves all.
///
/// Fills `tracks` (7, parts, rays) with the points in mm, the directions behind and the optical paths in mm at the
/// `recorded` parts. Returns fates (rays; 0 arrived, else the number of the loss) and derivatives (parameters, 5, rays)
/// of x, y, L, M, path on the sensor. What a lost ray did not reach is NaN.
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
    recorded: Vec<usize>,
    mut tracks: Filled<'py, f64, Ix3>,
    parameters: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Answer<'py>> {
    let job = Job::new(py, (scene, &arrays, channel), &starts, &parameters, threads)?;
    let (parts, rays) = (recorded.len(), job.starts.origins().len());
    let mut lost = vec![None; rays];
    let tracks = tracks.as_shape(Ix3(7, parts, rays))?;
    let (points, rest) = tracks.split_at(Axis(0), 3);
    let (directions, paths) = rest.split_at(Axis(0), 3);
    let mut to = TracksMut {
        points,
        directions,
        paths: paths.index_axis_move(Axis(0), 0),
        lost: &mut lost,
    };
    let follow = |watch: &Watch| job.follow(&recorded, &mut to, watch);
    let found = run_borrowing(py, threads, follow)?;
    let (fates, slopes) = found.map_err(|failure| error(py, failure))?;
    let fates =
        fates.ok_or_else(|| error(py, "a ray that arrives at places that are not finite"))?;
    Ok((
        Made::with_gaps(py, Array1::from_vec(fates)),
        Made::with_gaps(py, slopes),
    ))
}

/// The gradient of a number by `parameters`, from its derivatives `by_landings` by x, y, L, M, path of rays on the
/// sensor: five arrays (rays), or None for zero. The rays have these `starts`, as `trace` takes them. Derivatives by
/// lost rays do not count.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "its parameters are those of the Python function"
)]
pub(crate) fn trace_adjoint<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    channel: usize,
    starts: Starts<'py>,
    by_landings: [Option<Given<'py, f64, Ix1>>; 5],
    parameters: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Vec<f64>> {
    let job = Job::new(py, (scene, &arrays, channel), &starts, &parameters, threads)?;
    let rays = job.starts.origins().len();
    for given in by_landings.iter().flatten() {
        if given.as_array().len() != rays {
            let found = given.as_array().len();
            let message = format!("derivatives by {found} rays, expected by {rays}");
            return Err(PyValueError::new_err(message));
        }
    }
    let columns =
        { by_landings.each_ref() }.map(|given| Some(in_order(given.as_ref()?.as_array())));
    let columns = columns.each_ref().map(Option::as_deref);
    let follow_back = |watch: &Watch| job.follow_back(&columns, watch);
    let gradient = run_borrowing(py, threads, follow_back)?;
    let gradient = gradient.map_err(|failure| error(py, failure))?;
    match gradient.iter().all(|slope| slope.is_finite()) {
        true => Ok(gradient),
        false => Err(error(py, "a gradient that is not finite")),
    }
}

/// The starts of all rays, on a first screen within these bounds; threads of a pool read them.
fn launches<'a>(
    py: Python<'_>,
    starts: &'a Starts<'_>,
    [x0, x1, y0, y1]: [f64; 4],
    pool: &ThreadPool,
) -> PyResult<Launches<'a>> {
    let far = |number: &f64, most: f64| number.is_nan() || number.abs() > most;
    let (launches, is_far) = match starts {
        Starts::Pupil(PupilStarts { x, y, light }) => {
            let light = columns::<f64, 3>("light", light)?;
            let places = [in_order(x.as_array()), in_order(y.as_array())];
            let is_near = py.detach(|| pool.install(|| places.iter().all(|u| are_near(u))));
            let between = [[x0, x1], [y0, y1]];
            (Launches::Lit(places, between, light), !is_near)
        }
        Starts::Free(FreeStarts { start_mm, cosines }) => {
            let points = columns::<f64, 3>("start_mm", start_mm)?;
            let is_far = points.as_flattened().iter().any(|x| far(x, FARTHEST));
            (
                Launches::Free(points, columns::<f64, 3>("cosines", cosines)?),
                is_far,
            )
        }
    };
    if is_far
        || launches
            .light()
            .as_flattened()
            .iter()
            .any(|x| far(x, FARTHEST))
    {
        let message = format!(
            "places in the pupil beyond {WIDEST:e} half widths, or of the source beyond {FARTHEST:e} mm"
        );
        return Err(PyValueError::new_err(message));
    }
    launches.checked()
}

/// Whether all places in the pupil are numbers that are not too far out.
fn are_near(places: &[f64]) -> bool {
    // Without a way out of the loop many are looked at together.
    let near = |places: &[f64]| { places.iter() }.fold(true, |near, u| near & (u.abs() <= WIDEST));
    places.par_chunks(PLACES).all(near)
}

/// Places that one thread takes in a row.
const PLACES: usize = 1 << 16;

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

/// Single rays whose derivatives are summed by one thread.
const SINGLE_RAYS: usize = 256;

/// Rays to follow.
struct Job<'a> {
    system: System,
    variations: Vec<Variation>,
    starts: Launches<'a>,
}

/// How rays start; one entry may serve all.
enum Launches<'a> {
    /// At x and y of the first screen, in half widths between these bounds in mm, with light of the source.
    Lit([Cow<'a, [f64]>; 2], [[f64; 2]; 2], Vec<[f64; 3]>),
    /// At points in mm with unit directions, both global.
    Free(Vec<[f64; 3]>, Vec<[f64; 3]>),
}

impl Launches<'_> {
    fn light(&self) -> &[[f64; 3]] {
        let (Launches::Lit(_, _, light) | Launches::Free(_, light)) = self;
        light
    }

    /// The same, if it has as many entries of each kind as there are rays, or one.
    fn checked(self) -> PyResult<Self> {
        let light = self.light().len();
        let (places, fits) = match &self {
            Launches::Lit([x, y], ..) => (
                x.len(),
                x.len() == y.len() && (light == x.len() || light == 1),
            ),
            Launches::Free(points, _) => {
                let points = points.len();
                (points, points == light || points == 1 || light == 1)
            }
        };
        match fits {
            true => Ok(self),
            false => Err(PyValueError::new_err(format!(
                "{places} places for {light} rays"
            ))),
        }
    }

    fn origins(&self) -> RayOrigins<'_> {
        match self {
            Launches::Lit([x, y], between, light) => RayOrigins::Lit {
                light,
                at: [x, y],
                between: *between,
            },
            Launches::Free(points, directions) => RayOrigins::Free { points, directions },
        }
    }
}

impl<'a> Job<'a> {
    /// Rays of a channel of a scene, which change with parameters.
    fn new<'py>(
        py: Python<'py>,
        (scene, arrays, channel): (&Scene, &ByPath<'py>, usize),
        starts: &'a Starts<'py>,
        parameters: &[String],
        threads: Option<usize>,
    ) -> PyResult<Self> {
        scene.check(channel)?;
        let (system, variations) = scene.with_arrays(py, arrays, |file, arrays| {
            let system = build::system_with(file, arrays, channel)?;
            Ok((system, variations(file, arrays, channel, parameters)?))
        })?;
        let bounds = system.screens.first().and_then(Screen::bounds);
        let bounds = bounds.ok_or_else(|| error(py, "the first screen has no edge"))?;
        refuse_turned(py, &system, &variations)?;
        Ok(Self {
            system,
            variations,
            starts: launches(py, starts, bounds, &*pool(threads)?)?,
        })
    }

    /// Follows all rays, with what they meet at the `recorded` parts. Returns their fates, or nothing where some that arrive
    /// have places that are not finite, and their derivatives.
    fn follow(
        &self,
        recorded: &[usize],
        tracks: &mut TracksMut,
        watch: &Watch,
    ) -> Result<(Option<Vec<u8>>, Array3<f64>), Cancelled> {
        let (rays, origins) = (SystemRays::new(&self.system), self.starts.origins());
        rays.trace_to(origins, recorded, tracks, &|| watch.pulse())?;
        let slopes = self.slopes(watch)?;
        let fates = { tracks.lost.par_iter() }.map(|lost| lost.map_or(0, fate));
        let fates = arrived_are_finite(tracks).then(|| fates.collect());
        Ok((fates, slopes))
    }

    /// The gradient of a number by the parameters, from its derivatives by the landings.
    fn follow_back(&self, by_landings: &ByLandings, watch: &Watch) -> Result<Vec<f64>, Cancelled> {
        let origins = self.starts.origins();
        if let Some(many) = SystemDerivatives::new(&self.system, &self.variations) {
            return many.gradient(origins, by_landings, &|| watch.pulse());
        }
        // Single rays, some at a time in the same order for any number of threads.
        let sensitivity = RaySensitivity::new(&self.system, &self.variations);
        let firsts: Vec<usize> = (0..origins.len()).step_by(SINGLE_RAYS).collect();
        let sums = firsts.into_par_iter().map(|first| {
            Cancelled::check(watch.pulse())?;
            let mut sums = vec![0.0; self.variations.len()];
            for ray in first..origins.len().min(first + SINGLE_RAYS) {
                let slopes = self.ray_slopes(&sensitivity, ray).into_iter().flatten();
                for (sum, slopes) in sums.iter_mut().zip(slopes) {
                    let columns = by_landings.iter().zip(slopes);
                    let products = columns.filter_map(|(by, slope)| Some((*by)?.get(ray)? * slope));
                    *sum += products.sum::<f64>();
                }
            }
            Ok(sums)
        });
        let mut gradient = vec![0.0; self.variations.len()];
        for sums in sums.collect::<Result<Vec<_>, _>>()? {
            { gradient.iter_mut().zip(sums) }.for_each(|(total, sum)| *total += sum);
        }
        Ok(gradient)
    }

    /// Derivatives of all rays by the parameters.
    fn slopes(&self, watch: &Watch) -> Result<Array3<f64>, Cancelled> {
        let (origins, parameters) = (self.starts.origins(), self.variations.len());
        // Without parameters no ray is followed.
        if parameters == 0 {
            return Ok(Array3::zeros((0, 5, origins.len())));
        }
        match SystemDerivatives::new(&self.system, &self.variations) {
            Some(many) => many.derivatives(origins, &|| watch.pulse()),
            None => self.single_slopes(watch),
        }
    }

    /// Derivatives of the rays one by one.
    fn single_slopes(&self, watch: &Watch) -> Result<Array3<f64>, Cancelled> {
        let rays = self.starts.origins().len();
        let mut slopes = Array3::from_elem((self.variations.len(), 5, rays), f64::NAN);
        let sensitivity = RaySensitivity::new(&self.system, &self.variations);
        let columns: Vec<_> = slopes.axis_iter_mut(Axis(2)).collect();
        (columns.into_par_iter().enumerate()).try_for_each(|(ray, mut column)| {
            Cancelled::check(watch.pulse())?;
            let found = self.ray_slopes(&sensitivity, ray).into_iter().flatten();
            for (mut row, slopes) in column.rows_mut().into_iter().zip(found) {
                row.iter_mut()
                    .zip(slopes)
                    .for_each(|(to, slope)| *to = slope);
            }
            Ok(())
        })?;
        Ok(slopes)
    }

    /// Derivatives of one ray; nothing where it is lost.
    fn ray_slopes(&self, sensitivity: &RaySensitivity, ray: usize) -> Option<Vec<[f64; 5]>> {
        let (source, at) = self.starts.origins().of(&self.system, ray).ok()?;
        sensitivity.of(&source, at)
    }
}

/// Whether all numbers of the rays that arrived are finite.
fn arrived_are_finite(tracks: &TracksMut) -> bool {
    let numbers = [&tracks.points, &tracks.directions];
    let rows = { numbers.iter() }.flat_map(|all| all.rows());
    let rows: Vec<_> = rows.chain(tracks.paths.rows()).collect();
    rows.into_par_iter().all(|row| {
        let pieces = row.axis_chunks_iter(Axis(0), PIECE);
        pieces.zip(tracks.lost.chunks(PIECE)).all(|(row, lost)| {
            // Without a way out of the loop many are looked at together.
            let gaps = row.iter().fold(false, |gaps, x| gaps | !x.is_finite());
            let mut numbers = row.iter().zip(lost);
            !gaps || numbers.all(|(number, lost)| number.is_finite() || lost.is_some())
        })
    })
}

/// Rays whose numbers are looked at together.
const PIECE: usize = 4096;

fn fate(loss: Loss) -> u8 {
    match loss {
        Loss::Clipped => 1,
        Loss::Missed => 2,
        Loss::TotalReflection => 3,
        Loss::Evanescent => 4,
        Loss::NotConverged => 5,
    }
}
