//! Rays of another tracer at a system's element and on its sensor.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raylet::engine::scatter::Scatter;
use raylet::engine::scattering::{Coverage, Drawing, Scattering};
use raylet::engine::secondary::Secondary;
use raylet::engine::settings::Sampler;
use raylet::optics::bundle::Rays;
use raylet::optics::screen::Screen;
use raylet::wave::beams::{Beams, Jacobians};
use raylet::wave::collect::{Collector, Wavelet};
use raylet::wave::window::Synthesis;

use crate::arrays::{column, columns, guard};
use crate::refusal::error;
use crate::scene::Scene;
use crate::watch::pool;

/// Rays in columns: (rays, 3) positions in mm and unit directions, (rays,) paths in mm and complex weights.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Bundle<'py> {
    position: PyReadonlyArray2<'py, f64>,
    direction: PyReadonlyArray2<'py, f64>,
    path: PyReadonlyArray1<'py, f64>,
    weight: PyReadonlyArray1<'py, Complex64>,
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
    curvature: Option<PyReadonlyArray2<'py, f64>>,
}

impl Choices<'_> {
    fn scattering(&self) -> Scattering {
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
            ..Scattering::beamlets(self.sigma)
        }
    }
}

/// Does something with the rays at an element of a system.
fn at_element<T: Send>(
    py: Python<'_>,
    (scene, arrays, name, channel): (&Scene, &Bound<'_, PyDict>, &str, usize),
    (bundle, choices): (&Bundle<'_>, &Choices<'_>),
    work: impl FnOnce(&Scatter) -> Result<T, String> + Send,
) -> PyResult<T> {
    let system = scene.system(py, arrays, channel)?;
    let found = system.screens.iter().find(|screen| screen.name == name);
    let screen: &Screen =
        found.ok_or_else(|| error(py, format!("no element is called '{name}'")))?;
    let held = bundle.columns()?;
    let curvature = choices
        .curvature
        .as_ref()
        .map(|array| columns::<3>("curvature", array))
        .transpose()?;
    let (settings, pool) = (choices.scattering(), pool(None)?);
    let wavelength = system.wavelength;
    let done = py.detach(|| {
        pool.install(|| {
            let scatter = Scatter::new(
                screen,
                wavelength,
                held.rays(),
                curvature.as_deref(),
                settings,
            );
            work(&scatter.map_err(|told| told.to_string())?)
        })
    });
    done.map_err(|told| error(py, told))
}

fn three<'py>(py: Python<'py>, rows: &[[f64; 3]]) -> Bound<'py, PyArray2<f64>> {
    let array = Array2::from_shape_fn((rows.len(), 3), |(i, j)| rows[i][j]);
    PyArray2::from_owned_array(py, array)
}

fn two<'py>(py: Python<'py>, rows: &[[f64; 2]]) -> Bound<'py, PyArray2<f64>> {
    let array = Array2::from_shape_fn((rows.len(), 2), |(i, j)| rows[i][j]);
    PyArray2::from_owned_array(py, array)
}

fn one<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_owned_array(py, Array1::from_vec(values))
}

/// The rays that leave an element, as a dictionary of arrays.
#[pyfunction]
pub(crate) fn scatter<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: &Bound<'py, PyDict>,
    place: (String, usize),
    bundle: Bundle<'py>,
    choices: Choices<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (name, channel) = place;
    let (made, unevenness) = at_element(
        py,
        (scene, arrays, &name, channel),
        (&bundle, &choices),
        |scatter| Ok((scatter.scatter(0..usize::MAX), scatter.unevenness())),
    )?;
    let answer = PyDict::new(py);
    let index = |i: &usize| *i as i64;
    let mode: Vec<i64> = made.mode.iter().flatten().map(index).collect();
    answer.set_item("position", three(py, &made.position))?;
    answer.set_item("direction", three(py, &made.direction))?;
    answer.set_item("window", three(py, &made.window))?;
    answer.set_item(
        "parent",
        one(py, made.parent.iter().map(index).collect::<Vec<i64>>()),
    )?;
    answer.set_item("mode", one(py, mode).reshape([made.parent.len(), 2])?)?;
    answer.set_item("dropped", made.dropped)?;
    answer.set_item("unevenness", unevenness)?;
    answer.set_item("path", one(py, made.path))?;
    answer.set_item("weight", one(py, made.weight))?;
    answer.set_item("cosine", one(py, made.cosine))?;
    answer.set_item("times", one(py, made.times))?;
    Ok(answer)
}

/// Which secondary rays were chosen.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Drawn<'py> {
    parent: PyReadonlyArray1<'py, i64>,
    mode: PyReadonlyArray2<'py, i64>,
    times: PyReadonlyArray1<'py, f64>,
}

impl Drawn<'_> {
    fn secondary(&self) -> PyResult<Secondary> {
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
        Ok(Secondary {
            parent,
            mode,
            times,
            ..Secondary::default()
        })
    }
}

/// The conjugate transpose of [`scatter`] by weights: cotangents of the element's pixels (complex [y, x], or None
/// where it has none of its own) and of the arriving weights.
#[pyfunction]
pub(crate) fn scatter_adjoint<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: &Bound<'py, PyDict>,
    place: (String, usize),
    rays: (Bundle<'py>, Choices<'py>),
    drawn: (Drawn<'py>, PyReadonlyArray1<'py, Complex64>),
) -> PyResult<(
    Option<Bound<'py, PyArray2<Complex64>>>,
    Bound<'py, PyArray1<Complex64>>,
)> {
    let ((name, channel), (bundle, choices)) = (place, rays);
    let (secondary, bar) = (drawn.0.secondary()?, column("weight_bar", &drawn.1)?);
    let at = (scene, arrays, name.as_str(), channel);
    let (pixels, weight) = at_element(py, at, (&bundle, &choices), move |scatter| {
        let back = scatter
            .weigh_adjoint(&secondary, &bar)
            .map_err(|told| told.to_string())?;
        Ok((scatter.pixels_bar(&back).ok(), back.weight))
    })?;
    let pixels = pixels.map(|pixels| PyArray2::from_owned_array(py, pixels));
    Ok((pixels, one(py, weight)))
}

/// What a tracer tells of the way of each ray: (rays, 4, 4) Jacobians, (rays, 3) windows, (rays,) cosines where they
/// started and numbers of images they passed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Ways<'py> {
    jacobian: PyReadonlyArray3<'py, f64>,
    window: PyReadonlyArray2<'py, f64>,
    cosine: PyReadonlyArray1<'py, f64>,
    images: Option<PyReadonlyArray1<'py, i64>>,
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
        let view = self.jacobian.as_array();
        let (_, rows, columns_) = view.dim();
        if (rows, columns_) != (4, 4) {
            let shape = view.shape();
            return Err(PyValueError::new_err(format!(
                "jacobian: an array of shape {shape:?}, expected (rays, 4, 4)"
            )));
        }
        let images = self
            .images
            .as_ref()
            .map(|array| column("images", array))
            .transpose()?;
        let count = |i: i64| {
            u32::try_from(i).map_err(|_| PyValueError::new_err("images: a negative or huge number"))
        };
        let images = images
            .map(|all| all.into_iter().map(count).collect::<PyResult<_>>())
            .transpose()?;
        let matrices = view.outer_iter();
        Ok(Legs {
            jacobian: matrices
                .map(|m| std::array::from_fn(|i| std::array::from_fn(|j| m[[i, j]])))
                .collect(),
            window: columns("window", &self.window)?,
            cosine: column("cosine", &self.cosine)?,
            images,
        })
    }
}

/// How rays are summed: "beamlet", "prefactor" or "plain", and to which tolerance.
type Sum = (String, f64);

/// Does something with rays on the sensor of a system.
fn on_sensor<T: Send>(
    py: Python<'_>,
    (scene, channel): (&Scene, usize),
    (bundle, ways): (&Bundle<'_>, Option<&Ways<'_>>),
    (kind, tolerance): Sum,
    work: impl FnOnce(&Collector, &Rays, &Wavelet) -> Result<T, String> + Send,
) -> PyResult<T> {
    let system = scene.system(py, &PyDict::new(py), channel)?;
    let screen = system
        .screens
        .last()
        .ok_or_else(|| error(py, "no sensor"))?;
    let (held, legs) = (bundle.columns()?, ways.map(Ways::legs).transpose()?);
    let pool = pool(None)?;
    let wavelength = system.wavelength;
    let done = py.detach(|| {
        pool.install(|| {
            let collector =
                Collector::new(screen, wavelength, tolerance).map_err(|told| told.to_string())?;
            let rays = held.rays();
            let beams = match (kind.as_str(), &legs) {
                ("plain", _) => None,
                ("beamlet" | "prefactor", Some(legs)) => {
                    let jacobians = Jacobians {
                        jacobian: &legs.jacobian,
                        window: &legs.window,
                        cosine: &legs.cosine,
                        images: legs.images.as_deref(),
                    };
                    let hits = collector.hits(&rays).map_err(|told| told.to_string())?;
                    let k = std::f64::consts::TAU / wavelength;
                    Some(
                        Beams::from_jacobians(&jacobians, &hits, k)
                            .map_err(|told| told.to_string())?,
                    )
                }
                ("beamlet" | "prefactor", None) => {
                    return Err(format!("no Jacobians, expected them for wavelet '{kind}'"));
                }
                _ => {
                    return Err(format!(
                        "wavelet '{kind}', expected 'beamlet', 'prefactor' or 'plain'"
                    ));
                }
            };
            let wavelet = match (&beams, kind.as_str()) {
                (Some(beams), "beamlet") => Wavelet::Beamlet(beams),
                (Some(beams), _) => Wavelet::Prefactor(beams),
                (None, _) => Wavelet::Plain,
            };
            work(&collector, &rays, &wavelet)
        })
    });
    done.map_err(|told| error(py, told))
}

/// The field that rays bring to the pixel centres of the sensor, [y, x].
#[pyfunction]
pub(crate) fn gather<'py>(
    py: Python<'py>,
    scene: &Scene,
    channel: usize,
    bundle: Bundle<'py>,
    ways: Option<Ways<'py>>,
    sum: Sum,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let field = on_sensor(
        py,
        (scene, channel),
        (&bundle, ways.as_ref()),
        sum,
        |collector, rays, wavelet| {
            collector
                .collect(rays, wavelet)
                .map_err(|told| told.to_string())
        },
    )?;
    Ok(PyArray2::from_owned_array(py, field))
}

/// The conjugate transpose of [`gather`], as a dictionary of arrays: cotangents of weight, path (1/mm), place and
/// optical cosines on the sensor's axes.
#[pyfunction]
pub(crate) fn gather_adjoint<'py>(
    py: Python<'py>,
    scene: &Scene,
    channel: usize,
    rays: (Bundle<'py>, Option<Ways<'py>>),
    sum: Sum,
    field_bar: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let (bundle, ways) = rays;
    let held = guard("field_bar", field_bar)?;
    let bar = match held.look() {
        raylet::file::array::ArrayLook::Real(bar) => bar.mapv(|re| Complex64::new(re, 0.0)),
        raylet::file::array::ArrayLook::Complex(bar) => bar.to_owned(),
    };
    let back = on_sensor(
        py,
        (scene, channel),
        (&bundle, ways.as_ref()),
        sum,
        |collector, rays, wavelet| {
            collector
                .collect_adjoint(rays, wavelet, &bar)
                .map_err(|told| told.to_string())
        },
    )?;
    let answer = PyDict::new(py);
    answer.set_item("weight", one(py, back.weight))?;
    answer.set_item("path", one(py, back.path))?;
    answer.set_item("at", two(py, &back.at))?;
    answer.set_item("cosines", two(py, &back.cosines))?;
    Ok(answer)
}
