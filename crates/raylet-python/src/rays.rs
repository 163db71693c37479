//! Rays of another tracer at a system's element and on its sensor.

#![expect(
    clippy::indexing_slicing,
    reason = "the columns of arrays from Python are checked before, and arrays for Python are made to size"
)]

use ndarray::{Array1, Array2, Array3, ArrayView2};
use num_complex::Complex64;
use numpy::{Ix1, Ix2, Ix3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raylet::engine::external::scatter::Scatter;
use raylet::engine::external::scatter_settings::{Coverage, Drawing, Scattering};
use raylet::engine::external::secondary_rays::SecondaryRays;
use raylet::engine::plan::settings::Sampler;
use raylet::file::decode::fault::shortened;
use raylet::math::vec3::Vec3;
use raylet::optics::bundle::Rays;
use raylet::optics::screen::Screen;
use raylet::wave::beamlet::beams::{Beams, Jacobians};
use raylet::wave::beamlet::secondary_ray_sum::{SecondaryRayError, SecondaryRaySum, Wavelet};
use raylet::wave::patches::window::Synthesis;

use crate::arrays::{check_memory, column, columns};
use crate::refusal::error;
use crate::scene::Scene;
use crate::typed::{ByPath, Given, Made, Named, Number, finite};
use crate::watch::{Watch, run};

/// Complex numbers, one for each ray.
type Column<'py> = Made<'py, Complex64, Ix1>;

/// Complex numbers on two axes.
type Grid<'py> = Made<'py, Complex64, Ix2>;

/// Rays in columns: (rays, 3) positions in mm and unit directions, (rays,) paths in mm and complex weights.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Bundle<'py> {
    position: Given<'py, f64, Ix2>,
    direction: Given<'py, f64, Ix2>,
    path: Given<'py, f64, Ix1>,
    weight: Given<'py, Complex64, Ix1>,
}

/// The same as the library takes them.
struct Columns {
    position: Vec<[f64; 3]>,
    direction: Vec<[f64; 3]>,
    path: Vec<f64>,
    weight: Vec<Complex64>,
}

impl Bundle<'_> {
    fn columns(&self) -> PyResult<Columns> {
        Ok(Columns {
            position: columns("position", &self.position)?,
            direction: columns("direction", &self.direction)?,
            path: column("path", &self.path)?,
            weight: column("weight", &self.weight)?,
        })
    }
}

impl Columns {
    fn rays(&self) -> Rays<'_> {
        Rays {
            position: &self.position,
            direction: &self.direction,
            path: &self.path,
            weight: &self.weight,
        }
    }
}

/// Bytes of a mode of a patch while it is worked on, and of a secondary ray with its copies.
const PATCH_BYTES: f64 = 64.0;
const RAY_BYTES: f64 = 400.0;

/// The most memory that arrays may take, in bytes.
fn memory(scene: &Scene) -> f64 {
    scene.file.memory_limit() as f64
}

/// How rays are scattered; lengths in mm.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Choices<'py> {
    sigma: f64,
    period: f64,
    waves: bool,
    area: Option<f64>,
    towards: Option<[f64; 4]>,
    threshold: f64,
    most: Option<usize>,
    systematic: bool,
    seed: u64,
    curvature: Option<Given<'py, f64, Ix2>>,
}

impl Choices<'_> {
    /// As the library takes it; the modes of one patch on each thread take no more than the memory in bytes.
    fn scattering(&self, memory: f64) -> Scattering {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let usual = Scattering::beamlets(self.sigma);
        let sampler = match (self.most, self.systematic) {
            (None, _) => Sampler::All,
            (Some(_), true) => Sampler::Systematic,
            (Some(_), false) => Sampler::Multinomial,
        };
        Scattering {
            period: self.period,
            synthesis: if self.waves {
                Synthesis::Plain
            } else {
                Synthesis::Window
            },
            coverage: self.area.map_or(Coverage::Divide, Coverage::Area),
            towards: self.towards,
            threshold: self.threshold,
            drawing: Drawing {
                sampler,
                most: self.most.unwrap_or(usize::MAX),
                seed: self.seed,
            },
            samples: usual
                .samples
                .min((memory / (PATCH_BYTES * threads as f64)) as usize),
            ..usual
        }
    }
}

/// An element of a scene with its arrays, at one of its wavelengths.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ElementPlace<'py> {
    scene: PyRef<'py, Scene>,
    arrays: ByPath<'py>,
    /// The name of the element.
    element: String,
    /// The index of the wavelength.
    channel: usize,
}

/// Does something with the rays at an element of a system.
fn at_element<T: Send + 'static>(
    py: Python<'_>,
    place: &ElementPlace<'_>,
    bundle: &Bundle<'_>,
    choices: &Choices<'_>,
    work: impl FnOnce(&Scatter, &Screen, &Watch) -> Result<T, String> + Send + 'static,
) -> PyResult<T> {
    let (scene, name) = (&place.scene, &place.element);
    let system = scene.system(py, &place.arrays, place.channel)?;
    let wavelength = system.wavelength;
    let mut screens = system.screens.into_iter();
    let found = screens.find(|screen| screen.name == *name);
    let screen =
        found.ok_or_else(|| error(py, format!("no element is called '{}'", shortened(name))))?;
    let held = bundle.columns()?;
    let curvature = choices
        .curvature
        .as_ref()
        .map(|array| columns::<f64, 3>("curvature", array))
        .transpose()?;
    let settings = choices.scattering(memory(scene));
    let done = run(py, None, None, move |watch: &Watch| {
        let (rays, bent) = (held.rays(), curvature.as_deref());
        let scatter = Scatter::new(&screen, wavelength, rays, bent, settings);
        let scatter = scatter.map_err(|failure| failure.to_string())?;
        work(&scatter, &screen, watch)
    })?;
    done.map_err(|failure| error(py, failure))
}

/// Rows of `N` numbers as an array (rows, N).
fn rows<'py, T: Number + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Made<'py, T, Ix2>> {
    let array = Array2::from_shape_fn((rows.len(), N), |(i, j)| rows[i][j]);
    Made::new(py, array)
}

fn one<T: Number>(py: Python<'_>, values: Vec<T>) -> PyResult<Made<'_, T, Ix1>> {
    Made::new(py, Array1::from_vec(values))
}

/// The x, y and z axes of the plane that touches a screen at a global point on it.
fn touching(screen: &Screen, [x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    let local = screen.frame.to_local(Vec3::new(x, y, z));
    let plane = screen.tangent([local.x, local.y]);
    let frame = plane.map_or(screen.frame, |plane| plane.frame);
    [frame.x, frame.y, frame.z].map(|axis| [axis.x, axis.y, axis.z])
}

/// The rays that leave an element, as a dictionary of arrays.
#[pyfunction]
pub(crate) fn scatter<'py>(
    py: Python<'py>,
    place: ElementPlace<'py>,
    bundle: Bundle<'py>,
    choices: Choices<'py>,
) -> PyResult<Named<'py>> {
    let most = (memory(&place.scene) / RAY_BYTES) as usize;
    let (made, axes, unevenness) = at_element(
        py,
        &place,
        &bundle,
        &choices,
        move |scatter, screen, watch| {
            let made = scatter
                .scatter_within(most, &|| watch.pulse())
                .map_err(|failure| failure.to_string())?;
            let axes: Vec<[[f64; 3]; 3]> = made
                .position
                .iter()
                .map(|at| touching(screen, *at))
                .collect();
            Ok((made, axes, scatter.unevenness()))
        },
    )?;
    let answer = PyDict::new(py);
    let index = |i: &usize| *i as i64;
    let mode: Vec<[i64; 2]> = made
        .mode
        .iter()
        .map(|mode| mode.map(|i| index(&i)))
        .collect();
    let turns = Array3::from_shape_fn((axes.len(), 3, 3), |(ray, axis, i)| axes[ray][axis][i]);
    answer.set_item("position", rows(py, &made.position)?)?;
    answer.set_item("direction", rows(py, &made.direction)?)?;
    answer.set_item("window", rows(py, &made.window)?)?;
    answer.set_item("axes", Made::new(py, turns)?)?;
    answer.set_item(
        "parent",
        one(py, made.parent.iter().map(index).collect::<Vec<i64>>())?,
    )?;
    finite(py, [&made.dropped, &unevenness])?;
    answer.set_item("mode", rows(py, &mode)?)?;
    answer.set_item("dropped", made.dropped)?;
    answer.set_item("unevenness", unevenness)?;
    answer.set_item("path", one(py, made.path)?)?;
    answer.set_item("weight", one(py, made.weight)?)?;
    answer.set_item("cosine", one(py, made.cosine)?)?;
    answer.set_item("times", one(py, made.times)?)?;
    Ok(Named(answer))
}

/// Which secondary rays were chosen.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Drawn<'py> {
    parent: Given<'py, i64, Ix1>,
    mode: Given<'py, i64, Ix2>,
    times: Given<'py, f64, Ix1>,
}

impl Drawn<'_> {
    fn secondary(&self) -> PyResult<SecondaryRays> {
        let refuse =
            || PyValueError::new_err("indices of secondary rays, expected those that scatter gave");
        let index = |i: i64| usize::try_from(i).map_err(|_| refuse());
        let mode = self.mode.as_array();
        if mode.ncols() != 2 {
            return Err(refuse());
        }
        let modes = mode
            .rows()
            .into_iter()
            .map(|row| Ok([index(row[0])?, index(row[1])?]));
        let mode: Vec<[usize; 2]> = modes.collect::<PyResult<_>>()?;
        let parents = column("parent", &self.parent)?.into_iter().map(index);
        let parent: Vec<usize> = parents.collect::<PyResult<_>>()?;
        let times = column("times", &self.times)?;
        if parent.len() != mode.len() || times.len() != mode.len() {
            return Err(refuse());
        }
        Ok(SecondaryRays {
            parent,
            mode,
            times,
            ..SecondaryRays::default()
        })
    }
}

/// The conjugate transpose of [`scatter`] by weights: cotangents of the element's pixels (complex [y, x], or None
/// where it is not one grid of box or point pixels, alone or times analytic phases) and of the arriving weights.
#[pyfunction]
pub(crate) fn scatter_adjoint<'py>(
    py: Python<'py>,
    place: ElementPlace<'py>,
    bundle: Bundle<'py>,
    choices: Choices<'py>,
    drawn: Drawn<'py>,
    weight_bar: Given<'py, Complex64, Ix1>,
) -> PyResult<(Option<Grid<'py>>, Column<'py>)> {
    let (secondary, bar) = (drawn.secondary()?, column("weight_bar", &weight_bar)?);
    let (pixels, weight) = at_element(py, &place, &bundle, &choices, move |scatter, _, _| {
        let back = scatter
            .weigh_adjoint(&secondary, &bar)
            .map_err(|failure| failure.to_string())?;
        Ok((scatter.pixels_bar(&back).ok(), back.weight))
    })?;
    let pixels = pixels.map(|pixels| Made::new(py, pixels)).transpose()?;
    Ok((pixels, one(py, weight)?))
}

/// What a tracer reports of the path of each ray: (rays, 4, 4) Jacobians, (rays, 3) windows, (rays,) cosines where they
/// started and numbers of images they passed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Ways<'py> {
    jacobian: Given<'py, f64, Ix3>,
    window: Given<'py, f64, Ix2>,
    cosine: Given<'py, f64, Ix1>,
    images: Option<Given<'py, i64, Ix1>>,
}

/// The same as the library takes them.
struct Legs {
    jacobian: Vec<[[f64; 4]; 4]>,
    window: Vec<[f64; 3]>,
    cosine: Vec<f64>,
    images: Option<Vec<u32>>,
}

impl Ways<'_> {
    fn legs(&self) -> PyResult<Legs> {
        check_memory("jacobian", &self.jacobian)?;
        let view = self.jacobian.as_array();
        let (_, rows, across) = view.dim();
        if (rows, across) != (4, 4) {
            let message = format!(
                "jacobian: an array of shape {:?}, expected (rays, 4, 4)",
                view.shape()
            );
            return Err(PyValueError::new_err(message));
        }
        let images = self
            .images
            .as_ref()
            .map(|array| column("images", array))
            .transpose()?;
        let refuse = |_| PyValueError::new_err("images: a negative or huge number");
        let count = |i: i64| u32::try_from(i).map_err(refuse);
        let counted = |all: Vec<i64>| all.into_iter().map(count).collect::<PyResult<_>>();
        let matrix =
            |m: ArrayView2<f64>| std::array::from_fn(|i| std::array::from_fn(|j| m[[i, j]]));
        Ok(Legs {
            jacobian: view.outer_iter().map(matrix).collect(),
            window: columns("window", &self.window)?,
            cosine: column("cosine", &self.cosine)?,
            images: images.map(counted).transpose()?,
        })
    }
}

/// The sensor of a scene with its arrays, at one of its wavelengths.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SensorPlace<'py> {
    scene: PyRef<'py, Scene>,
    arrays: ByPath<'py>,
    /// The index of the wavelength.
    channel: usize,
}

/// Does something with rays on the sensor of a system.
fn on_sensor<T: Send + 'static>(
    py: Python<'_>,
    place: &SensorPlace<'_>,
    bundle: &Bundle<'_>,
    tolerance: f64,
    work: impl FnOnce(&SecondaryRaySum, &Rays, f64) -> Result<T, SecondaryRayError> + Send + 'static,
) -> PyResult<T> {
    let mut system = place.scene.system(py, &place.arrays, place.channel)?;
    let screen = system.screens.pop();
    let screen = screen.ok_or_else(|| error(py, "no sensor"))?;
    let (held, wavelength) = (bundle.columns()?, system.wavelength);
    let done = run(py, None, None, move |_: &Watch| {
        let ray_sum = SecondaryRaySum::new(&screen, wavelength, tolerance)?;
        work(&ray_sum, &held.rays(), std::f64::consts::TAU / wavelength)
    })?;
    done.map_err(|failure| error(py, failure))
}

/// The amplitudes (rays,) and curvatures (rays, 3) in 1/mm of the beamlets of rays on the sensor.
#[pyfunction]
pub(crate) fn beams<'py>(
    py: Python<'py>,
    place: SensorPlace<'py>,
    bundle: Bundle<'py>,
    ways: Ways<'py>,
) -> PyResult<(Column<'py>, Grid<'py>)> {
    let legs = ways.legs()?;
    let made = on_sensor(py, &place, &bundle, 1e-3, move |ray_sum, rays, k| {
        let jacobians = Jacobians {
            jacobian: &legs.jacobian,
            window: &legs.window,
            cosine: &legs.cosine,
            images: legs.images.as_deref(),
        };
        Ok(Beams::from_jacobians(&jacobians, &ray_sum.hits(rays)?, k)?)
    })?;
    Ok((one(py, made.amplitude)?, rows(py, &made.curvature)?))
}

/// How rays are summed: the shape of what each adds, "beamlet", "prefactor" or "plain"; with beamlets for the first
/// two, amplitudes (rays,) and curvatures (rays, 3); and to which tolerance.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Sum<'py> {
    wavelet: String,
    amplitude: Option<Given<'py, Complex64, Ix1>>,
    curvature: Option<Given<'py, Complex64, Ix2>>,
    tolerance: f64,
}

/// A wavelet that holds its beamlets.
enum Held {
    Plain,
    Prefactor(Beams),
    Beamlet(Beams),
}

impl Held {
    fn wavelet(&self) -> Wavelet<'_> {
        match self {
            Held::Plain => Wavelet::Plain,
            Held::Prefactor(beams) => Wavelet::Prefactor(beams),
            Held::Beamlet(beams) => Wavelet::Beamlet(beams),
        }
    }
}

impl Sum<'_> {
    fn held(&self) -> PyResult<Held> {
        let beams = || {
            let (Some(amplitude), Some(curvature)) = (&self.amplitude, &self.curvature) else {
                let wavelet = shortened(&self.wavelet);
                let message = format!("no beams, expected them for wavelet '{wavelet}'");
                return Err(PyValueError::new_err(message));
            };
            Ok(Beams {
                amplitude: column("amplitude", amplitude)?,
                curvature: columns("curvature", curvature)?,
            })
        };
        match self.wavelet.as_str() {
            "plain" => Ok(Held::Plain),
            "prefactor" => Ok(Held::Prefactor(beams()?)),
            "beamlet" => Ok(Held::Beamlet(beams()?)),
            other => {
                let message = format!(
                    "wavelet is '{}', expected 'beamlet', 'prefactor' or 'plain'",
                    shortened(other)
                );
                Err(PyValueError::new_err(message))
            }
        }
    }
}

/// The field that rays bring to the pixel centres of the sensor, [y, x].
#[pyfunction]
pub(crate) fn gather<'py>(
    py: Python<'py>,
    place: SensorPlace<'py>,
    bundle: Bundle<'py>,
    sum: Sum<'py>,
) -> PyResult<Grid<'py>> {
    let held = sum.held()?;
    let field = on_sensor(
        py,
        &place,
        &bundle,
        sum.tolerance,
        move |ray_sum, rays, _| ray_sum.sum(rays, &held.wavelet()),
    )?;
    Made::new(py, field)
}

/// The conjugate transpose of [`gather`], as a dictionary of arrays: cotangents of weight, path (1/mm), place and
/// optical cosines on the sensor's axes; of beamlets their amplitudes and curvatures too.
#[pyfunction]
pub(crate) fn gather_adjoint<'py>(
    py: Python<'py>,
    place: SensorPlace<'py>,
    bundle: Bundle<'py>,
    sum: Sum<'py>,
    field_bar: Given<'py, Complex64, Ix2>,
) -> PyResult<Named<'py>> {
    let held = sum.held()?;
    check_memory("field_bar", &field_bar)?;
    let bar = field_bar.as_array().to_owned();
    let back = on_sensor(
        py,
        &place,
        &bundle,
        sum.tolerance,
        move |ray_sum, rays, _| ray_sum.sum_adjoint(rays, &held.wavelet(), &bar),
    )?;
    let answer = PyDict::new(py);
    answer.set_item("weight", one(py, back.weight)?)?;
    answer.set_item("path", one(py, back.path)?)?;
    answer.set_item("at", rows(py, &back.at)?)?;
    answer.set_item("cosines", rows(py, &back.cosines)?)?;
    answer.set_item("amplitude", one(py, back.amplitude)?)?;
    answer.set_item("curvature", rows(py, &back.curvature)?)?;
    Ok(Named(answer))
}
