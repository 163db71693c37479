//! A system as a function of pixels and parameters, with its gradient.

use std::sync::Arc;

use ndarray::Array2;
use num_complex::Complex64;
use numpy::Ix2;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use raylet::engine::chain::forward_pass::ForwardPass;
use raylet::engine::chain::linearised_system::LinearisedSystem as Plans;
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::engine::plan::settings::Settings;
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::file::arrays::array::BorrowedArray;
use raylet::file::decode::fault::{Fault, shortened};
use raylet::file::model::build;
use raylet::file::model::fringed_pixels::refuse_fringed_element;
use raylet::file::model::variations::{ParameterValues, varied_system};
use raylet::file::scene::scene_file::Scene as File;
use raylet::file::scene::variable::{VariableAddress, VariableScene};
use raylet::optics::pixels::pixel_grid::Pixels;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::field::is_amplitude;
use raylet::wave::grid::transmission::phase_bar;

use crate::arrays::{Guard, guard};
use crate::refusal::{error, fault};
use crate::scene::Scene;
use crate::typed::{ByPath, Made, Row, finite};
use crate::watch::{Watch, run};

/// Frozen plans of a scene whose pixels and parameters vary.
#[pyclass(frozen, module = "raylet._raylet")]
pub(crate) struct LinearisedSystem {
    file: VariableScene,
    /// Names of the elements and their screens.
    elements: Vec<(String, usize)>,
    addresses: Vec<VariableAddress>,
    /// For each wavelength its system as it was planned, with its plans.
    planned: Arc<Vec<(System, Plans)>>,
}

/// The record of a forward pass through a linearised system, for its gradient.
#[pyclass(frozen, module = "raylet._raylet")]
pub(crate) struct Passage {
    planned: Arc<Vec<(System, Plans)>>,
    channels: Arc<Vec<Channel>>,
    /// The screen of each element, and whether it was given by its phases.
    elements: Vec<(usize, bool)>,
}

/// One wavelength of a passage.
struct Channel {
    system: System,
    variations: Vec<Variation>,
    trace: ForwardPass,
}

#[pymethods]
impl LinearisedSystem {
    /// Plans a scene about the values of its parameters; `elements` are the names of those whose pixels vary,
    /// `parameters` the paths of the parameters that do.
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        arrays: ByPath<'_>,
        elements: Vec<String>,
        parameters: Vec<String>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let found = found(&scene.file, &parameters);
        let (file, addresses) = found.map_err(|failure| fault(py, &failure))?;
        let values = values(&file, &addresses);
        let at = ParameterValues {
            scene: &file,
            addresses: &addresses,
            values: &values,
        };
        let made = made(py, scene, &arrays, at)?;
        let elements = elements.into_iter().map(|name| {
            refuse_fringed_element(&scene.file, &name).map_err(|failure| fault(py, &failure))?;
            let at = made
                .first()
                .and_then(|(system, _)| screen_of(system, &name));
            let at = at.ok_or_else(|| {
                error(
                    py,
                    format!(
                        "element '{}' has no pixels that could vary; {}",
                        shortened(&name),
                        with_pixels(made.first().map(|(system, _)| system))
                    ),
                )
            })?;
            Ok((name, at))
        });
        let elements = elements.collect::<PyResult<_>>()?;
        let settings = settings(&scene.file, !addresses.is_empty());
        let planned = run(py, threads, None, move |watch: &Watch| {
            let pulse = || watch.pulse();
            let plan = |(system, variations): (System, Vec<Variation>)| {
                let plans = Plans::new_with(&system, &variations, &settings, &pulse)?;
                Ok((system, plans))
            };
            made.into_iter()
                .map(plan)
                .collect::<Result<Vec<_>, LinearisedSystemError>>()
        })?;
        let planned = Arc::new(planned.map_err(|failure| error(py, failure))?);
        Ok(Self {
            file,
            elements,
            addresses,
            planned,
        })
    }

    /// The parameters as the scene has them: of a radius the curvature, 1/radius.
    fn parameters(&self) -> Vec<f64> {
        values(&self.file, &self.addresses)
    }

    /// Light through the system with these pixels (phases float64 or transmissions complex128, [y, x], for each
    /// element) and parameters: the fields [y, x] of all wavelengths, and the passage.
    #[expect(
        clippy::too_many_arguments,
        reason = "its parameters are those of the Python method"
    )]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        scene: &Scene,
        arrays: ByPath<'py>,
        pixels: Row<'py>,
        parameters: Vec<f64>,
        threads: Option<usize>,
    ) -> PyResult<(Vec<Made<'py, Complex64, Ix2>>, Passage)> {
        let mut made = match self.addresses.is_empty() {
            true => self
                .planned
                .iter()
                .map(|(system, _)| (system.clone(), Vec::new()))
                .collect(),
            false => made(py, scene, &arrays, self.at(&parameters))?,
        };
        let elements = self.place(py, &pixels, &mut made)?;
        let planned = Arc::clone(&self.planned);
        let channels = run(py, threads, None, move |watch: &Watch| {
            let pulse = || watch.pulse();
            let each = made.into_iter().zip(planned.iter());
            let one = |((system, variations), (_, plans)): (
                (System, Vec<Variation>),
                &(System, Plans),
            )| {
                let trace = plans.forward_with(&system, &pulse)?;
                Ok(Channel {
                    system,
                    variations,
                    trace,
                })
            };
            each.map(one)
                .collect::<Result<Vec<_>, LinearisedSystemError>>()
        })?;
        let mut channels = channels.map_err(|failure| error(py, failure))?;
        // The adjoint does not need the field itself: its memory becomes NumPy's.
        let take = |channel: &mut Channel| std::mem::take(&mut channel.trace.field.values);
        let fields = channels.iter_mut().map(take);
        let fields = fields.map(|field| Made::new(py, field));
        let fields = fields.collect::<PyResult<_>>()?;
        let passage = Passage {
            planned: Arc::clone(&self.planned),
            channels: Arc::new(channels),
            elements,
        };
        Ok((fields, passage))
    }
}

impl LinearisedSystem {
    /// These values of the parameters.
    fn at<'a>(&'a self, values: &'a [f64]) -> ParameterValues<'a> {
        ParameterValues {
            scene: &self.file,
            addresses: &self.addresses,
            values,
        }
    }

    /// Puts pixels into the systems; returns the screen of each element and whether it was given by its phases.
    fn place(
        &self,
        py: Python<'_>,
        pixels: &Row<'_>,
        made: &mut [(System, Vec<Variation>)],
    ) -> PyResult<Vec<(usize, bool)>> {
        if pixels.len() != self.elements.len() {
            let (found, expected) = (pixels.len(), self.elements.len());
            return Err(error(
                py,
                format!("{found} arrays of pixels, expected {expected}"),
            ));
        }
        let mut kinds = Vec::new();
        for ((name, screen), array) in self.elements.iter().zip(pixels.iter()) {
            let guard = guard(name, &array)?;
            let array = guard.borrowed();
            for (system, variations) in made.iter_mut() {
                let near = variations
                    .iter_mut()
                    .flat_map(|v| [&mut v.below, &mut v.above]);
                for system in std::iter::once(system).chain(near) {
                    let own = pixels_of(system, *screen)
                        .ok_or_else(|| error(py, format!("element '{name}' has no pixels")))?;
                    put(own, array).map_err(|failure| {
                        error(py, format!("pixels of element '{name}': {failure}"))
                    })?;
                }
            }
            kinds.push((*screen, matches!(guard, Guard::Real(_))));
        }
        Ok(kinds)
    }
}

#[pymethods]
impl Passage {
    /// The gradient of a real loss, from the cotangents ∂L/∂Re U + i ∂L/∂Im U of the fields [y, x] of all
    /// wavelengths: for each element by its phases (float64) or transmissions (complex128, ∂L/∂Re t + i ∂L/∂Im t),
    /// and by the parameters.
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        fields_bar: Row<'py>,
        threads: Option<usize>,
    ) -> PyResult<(Vec<Bound<'py, PyAny>>, Vec<f64>)> {
        let mut bars = Vec::new();
        for (channel, bar) in self.channels.iter().zip(fields_bar.iter()) {
            let held = guard("field_bar", &bar)?;
            let bar = match held.borrowed() {
                BorrowedArray::Real(bar) => bar.mapv(|re| Complex64::new(re, 0.0)),
                BorrowedArray::Complex(bar) => bar.to_owned(),
            };
            let expected = channel.trace.field.grid.shape();
            if bar.dim() != (expected[0], expected[1]) {
                let found = bar.dim();
                return Err(error(
                    py,
                    format!("field_bar has shape {found:?}, expected {expected:?}"),
                ));
            }
            bars.push(bar);
        }
        if bars.len() != self.channels.len() {
            return Err(error(
                py,
                format!("{} fields, expected {}", bars.len(), self.channels.len()),
            ));
        }
        let (planned, channels) = (Arc::clone(&self.planned), Arc::clone(&self.channels));
        let elements = self.elements.clone();
        let gradient = run(py, threads, None, move |watch: &Watch| {
            go_back(&planned, &channels, &elements, &bars, watch)
        })?;
        let (pixels, parameters) = gradient.map_err(|failure| error(py, failure))?;
        let each = pixels.into_iter().map(|pixels| match pixels {
            Bar::Phase(bar) => Made::new(py, bar)?.into_bound_py_any(py),
            Bar::Transmission(bar) => Made::new(py, bar)?.into_bound_py_any(py),
        });
        finite(py, &parameters)?;
        Ok((each.collect::<PyResult<_>>()?, parameters))
    }
}

/// The gradient by the pixels of one element.
enum Bar {
    Phase(Array2<f64>),
    Transmission(Array2<Complex64>),
}

/// The gradient by all elements and parameters, summed over wavelengths.
fn go_back(
    planned: &[(System, Plans)],
    channels: &[Channel],
    elements: &[(usize, bool)],
    bars: &[Array2<Complex64>],
    watch: &Watch,
) -> Result<(Vec<Bar>, Vec<f64>), LinearisedSystemError> {
    let mut pixels: Vec<Option<Bar>> = elements.iter().map(|_| None).collect();
    let mut parameters = Vec::new();
    for ((channel, (_, plans)), bar) in channels.iter().zip(planned).zip(bars) {
        let Channel {
            system,
            variations,
            trace,
        } = channel;
        let pulse = || watch.pulse();
        let gradient = plans.adjoint_with(system, variations, trace, bar, &pulse)?;
        parameters.resize(gradient.parameters.len(), 0.0);
        for (total, part) in parameters.iter_mut().zip(&gradient.parameters) {
            *total += part;
        }
        for (total, (screen, by_phase)) in pixels.iter_mut().zip(elements) {
            if let Some(Some(part)) = gradient.pixels.get(*screen) {
                add(total, part.clone(), own_pixels(system, *screen), *by_phase);
            }
        }
    }
    let empty = || Bar::Phase(Array2::default((0, 0)));
    Ok((
        pixels
            .into_iter()
            .map(|bar| bar.unwrap_or_else(empty))
            .collect(),
        parameters,
    ))
}

/// Adds what one wavelength gives.
fn add(total: &mut Option<Bar>, part: Array2<Complex64>, own: Option<&Pixels>, by_phase: bool) {
    let part = match (by_phase, own) {
        (true, Some(own)) => Bar::Phase(phase_bar(&part, &own.values)),
        _ => Bar::Transmission(part),
    };
    match (total.as_mut(), part) {
        (Some(Bar::Phase(sum)), Bar::Phase(part)) => *sum += &part,
        (Some(Bar::Transmission(sum)), Bar::Transmission(part)) => *sum += &part,
        (_, part) => *total = Some(part),
    }
}

/// How light is carried: what is kept may not depend on what varies.
fn settings(file: &File, changing: bool) -> Settings {
    let mut settings = build::settings(file);
    settings.mode_threshold = Some(0.0);
    match changing {
        true => settings.without_jumps(),
        false => settings,
    }
}

/// The parameters at these paths of a scene.
fn found(file: &File, paths: &[String]) -> Result<(VariableScene, Vec<VariableAddress>), Fault> {
    let file = VariableScene::new(file)?;
    let addresses = paths
        .iter()
        .map(|path| VariableAddress::new(&file, path, "element"));
    let addresses = addresses.collect::<Result<_, Fault>>()?;
    Ok((file, addresses))
}

fn values(file: &VariableScene, addresses: &[VariableAddress]) -> Vec<f64> {
    addresses
        .iter()
        .map(|address| address.value(file))
        .collect()
}

/// The systems of all wavelengths with these parameters, and the perturbed systems of each.
fn made(
    py: Python<'_>,
    scene: &Scene,
    arrays: &ByPath<'_>,
    parameters: ParameterValues<'_>,
) -> PyResult<Vec<(System, Vec<Variation>)>> {
    let (found, expected) = (parameters.values.len(), parameters.addresses.len());
    if found != expected {
        return Err(error(
            py,
            format!("{found} parameters, expected {expected}"),
        ));
    }
    scene.with_arrays(py, arrays, |file, arrays| {
        let channels = 0..file.wavelength_um.len();
        channels
            .map(|channel| varied_system(parameters, arrays, channel))
            .collect()
    })
}

/// The screen of an element whose pixels can vary.
fn screen_of(system: &System, name: &str) -> Option<usize> {
    let at = system
        .screens
        .iter()
        .position(|screen| screen.name == name)?;
    own_pixels(system, at).map(|_| at)
}

/// The names of the elements whose pixels may vary, in words.
fn with_pixels(system: Option<&System>) -> String {
    let names = system.into_iter().flat_map(|system| {
        let screens = system.screens.iter().enumerate();
        screens.filter(|(at, _)| own_pixels(system, *at).is_some())
    });
    let names: Vec<String> = names
        .map(|(_, screen)| format!("'{}'", screen.name))
        .collect();
    match names.is_empty() {
        true => String::from("no element has"),
        false => format!("those that have: {}", names.join(", ")),
    }
}

fn own_pixels(system: &System, screen: usize) -> Option<&Pixels> {
    match &system.screens.get(screen)?.kind {
        ScreenKind::Doe(doe) => doe.free_pixels(),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    }
}

fn pixels_of(system: &mut System, screen: usize) -> Option<&mut Pixels> {
    match &mut system.screens.get_mut(screen)?.kind {
        ScreenKind::Doe(doe) => doe.free_pixels_mut(),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    }
}

/// Gives pixels phases, of the modulus they have, or whole transmissions.
fn put(pixels: &mut Pixels, array: BorrowedArray) -> Result<(), String> {
    let (found, own) = (array.shape(), pixels.values.dim());
    if found != [own.0, own.1] {
        return Err(format!(
            "an array of shape {found:?}, expected {:?}",
            [own.0, own.1]
        ));
    }
    match array {
        BorrowedArray::Real(phase) => pixels.values.zip_mut_with(&phase, |t, phase| {
            *t = Complex64::from_polar(t.norm(), *phase);
        }),
        BorrowedArray::Complex(values) => pixels.values.assign(&values),
    }
    match pixels.values.iter().all(|t| is_amplitude(*t)) {
        true => Ok(()),
        false => Err(String::from(
            "values that are not finite, expected finite ones below 1e60",
        )),
    }
}
