//! The design of a scene: its losses, what is free, where it starts, and what it leaves.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, fields of view and screens are numbered by the lists built here from the scene"
)]

use std::sync::Arc;

use ndarray::Array2;

use crate::design::constraints::modulation::{Modulation, Modulator};
use crate::design::estimator::{Estimator, EstimatorKind};
use crate::design::holograms::hologram;
use crate::design::holograms::start::{SpreadingPhase, random_phase};
use crate::design::optimizers::descent::Rule;
use crate::design::optimizers::lbfgs::LbfgsSettings;
use crate::design::optimizers::optimizer::{Method, Optimizer};
use crate::design::optimizers::schedule::Schedule;
use crate::design::optimizers::space::Space;
use crate::design::optimizers::step::OptimizerError;
use crate::design::project::{Channel, Element, Project, SystemBuild, SystemParameter};
use crate::engine::chain::arriving_light::sensor_of;
use crate::engine::plan::settings::Settings;
use crate::file::decode::fault::Fault;
use crate::file::model::build;
use crate::file::model::design_targets::{ChannelDescription, ChannelLosses, channel_losses, lit};
use crate::file::model::hologram::{HologramDesign, commission};
use crate::file::model::pixel_part::{Output, PixelPart, blanked, pixel_parts};
use crate::file::model::variations::DERIVATIVE_STEP;
use crate::file::scene::design::{Design, OptimizerKind, Start, Variable};
use crate::file::scene::scene_file::Scene;
use crate::file::scene::variable::{VariableAddress, VariableScene};
use crate::math::random::Purpose;
use crate::optics::system::System;
use crate::wave::grid::raster::Raster;

/// The design of a scene.
pub struct SceneDesign {
    /// The project: what changes, and the losses.
    pub project: Project,
    /// The optimiser, at the starting point.
    pub search: Optimizer,
    /// The section `[design]` of the scene.
    pub design: Design,
    /// Description of each channel of the project.
    pub described: Vec<ChannelDescription>,
    /// The files for what is found.
    pub outputs: Vec<Output>,
    /// Area of a pixel of the sensor in mm².
    pub pixel_area: f64,
    /// Half width and height of the sensor in mm.
    pub sensor_half: [f64; 2],
    /// Name, half width and half height in mm of each element that is designed.
    pub elements: Vec<(String, [f64; 2])>,
    /// The parameters of the system that are designed.
    addresses: Arc<Vec<VariableAddress>>,
}

/// Relative size of a step of a parameter of the system, where none is given.
const SCALE: f64 = 1e-3;

/// The perturbed systems of a derivative are this share of a step away.
const NEAR: f64 = DERIVATIVE_STEP / SCALE;

/// The design of a scene without its arrays, which may be still to come.
///
/// # Errors
/// No `[design]`, nothing to design, or an impossible design.
pub fn scene_design(scene: &Scene) -> Result<SceneDesign, Fault> {
    let Some(design) = scene.design.clone() else {
        return Err(scene.fault("design", "no design", "a table [design]"));
    };
    let parts = pixel_parts(scene, &design)?;
    if parts.is_empty() && design.variable.is_empty() {
        let expected = "a [hologram], a [[design.element]] or a [[design.variable]]";
        return Err(scene.fault("design", "nothing to design", expected));
    }
    check_rates(scene, &design)?;
    let blank = blanked(scene, parts.iter()).load()?;
    let lit = lit(&blank, &design)?;
    let systems = lit.iter().map(systems);
    let systems: Vec<Vec<System>> = systems.collect::<Result<_, Fault>>()?;
    let first = &systems[0];

    // The losses, and the light that they judge.
    let channel_losses = channel_losses(scene, &design, &systems)?;
    let elements = parts
        .iter()
        .map(|part| element(scene, &design, part, first));
    let elements: Vec<Element> = elements.collect::<Result<_, Fault>>()?;
    let (described, channels) = channels(scene, channel_losses, &parts, &elements, first)?;

    // What is free, and where it starts.
    let start = starts(scene, &parts, &elements)?;
    let parameters = system_parameters(scene, &blank, &design.variable)?;
    let addresses = Arc::new(parameters.addresses);
    let project = Project {
        build_system: build_system(&lit, &described, &addresses)?,
        channels,
        elements,
        estimator: estimator(scene, &design, &first[0])?,
        settings: settings(scene, !addresses.is_empty()),
        system_parameters: parameters.list,
    };
    let search = search(&design, &project, start, &parameters.ranges).map_err(|error| {
        let expected = "parameters that make sense together";
        scene.fault("design", error.to_string(), expected)
    })?;
    let outputs = parts.iter().enumerate();
    let outputs = outputs.map(|(i, part)| part.outputs(scene, i));
    let outputs = outputs.collect::<Result<Vec<_>, Fault>>()?.concat();
    let raster = raster(scene, first)?;
    Ok(SceneDesign {
        project,
        search,
        design,
        described,
        outputs,
        pixel_area: raster.pitch[0] * raster.pitch[1],
        sensor_half: [0, 1].map(|a| 0.5 * raster.size[a] as f64 * raster.pitch[a]),
        elements: parts
            .iter()
            .map(|part| (part.part.name.clone(), part.half()))
            .collect(),
        addresses,
    })
}

/// What the channels are, and they themselves: the losses of each run, and how its light sees each element.
fn channels(
    scene: &Scene,
    channel_losses: Vec<ChannelLosses>,
    parts: &[PixelPart],
    elements: &[Element],
    systems: &[System],
) -> Result<(Vec<ChannelDescription>, Vec<Channel>), Fault> {
    let mut list = (Vec::new(), Vec::new());
    for (description, losses) in channel_losses {
        let ratio = |(part, element): (&PixelPart, &Element)| {
            part.ratio(
                scene,
                &around(systems, element.screen),
                description.place[1],
            )
        };
        let ratios = parts.iter().zip(elements).map(ratio);
        let ratios = ratios.collect::<Result<_, Fault>>()?;
        list.1.push(Channel { losses, ratios });
        list.0.push(description);
    }
    Ok(list)
}

impl SceneDesign {
    /// The scene with the parameters of a point of the design.
    ///
    /// # Errors
    /// A scene that is none with these parameters.
    pub fn scene_at(&self, scene: &Scene, point: &[f64]) -> Result<Scene, Fault> {
        let values = &point[self.project.system_parameters_from()..];
        VariableScene::new(scene)?.with_parameters(&self.addresses, values)
    }
}

/// The system of each wavelength.
fn systems(scene: &Scene) -> Result<Vec<System>, Fault> {
    let channels = 0..scene.wavelength_um.len();
    channels
        .map(|channel| build::system(scene, channel))
        .collect()
}

fn raster(scene: &Scene, systems: &[System]) -> Result<Raster, Fault> {
    let sensor = sensor_of(&systems[0]);
    let sensor =
        sensor.map_err(|error| scene.fault("element", error.to_string(), "a sensor at the end"))?;
    Ok(Raster::of(sensor))
}

/// An element with what can be made of it.
fn element(
    scene: &Scene,
    design: &Design,
    part: &PixelPart,
    systems: &[System],
) -> Result<Element, Fault> {
    let screen = part.screen(scene, &systems[0])?;
    let around = around(systems, screen);
    Ok(Element {
        screen,
        modulator: part.modulator(scene, design.optimizer, &around)?,
    })
}

/// The indices before and behind a screen at each wavelength.
fn around(systems: &[System], screen: usize) -> Vec<[f64; 2]> {
    let both = |system: &System| {
        let screen = &system.screens[screen];
        [screen.index, screen.index_behind()]
    };
    systems.iter().map(both).collect()
}

/// What makes the systems: the scene as it is lit in each run, with the parameters of a point.
fn build_system(
    lit: &[Scene],
    described: &[ChannelDescription],
    addresses: &Arc<Vec<VariableAddress>>,
) -> Result<SystemBuild, Fault> {
    let places: Vec<[usize; 2]> = described
        .iter()
        .map(|description| description.place)
        .collect();
    let addresses = Arc::clone(addresses);
    let lit: Vec<VariableScene> = lit
        .iter()
        .map(VariableScene::new)
        .collect::<Result<_, _>>()?;
    Ok(Box::new(move |channel: usize, values: &[f64]| {
        let [field, wavelength] = places[channel];
        let made = match values.is_empty() {
            true => build::system(lit[field].scene(), wavelength),
            false => lit[field]
                .with_parameters(&addresses, values)
                .and_then(|scene| build::system(&scene, wavelength)),
        };
        made.map_err(|fault| fault.to_string())
    }))
}

/// Settings of the design's runs. No mode is dropped unless the scene sets a threshold. Where the system changes,
/// footprints are wider, so that no value jumps.
fn settings(scene: &Scene, changing: bool) -> Settings {
    let mut settings = build::settings(scene);
    if scene.settings.mode_threshold.is_none() {
        settings.mode_threshold = Some(0.0);
    }
    match changing {
        true => settings.without_jumps(),
        false => settings,
    }
}

/// The parameters of the system that are designed.
#[derive(Default)]
struct Parameters {
    addresses: Vec<VariableAddress>,
    list: Vec<SystemParameter>,
    /// The scale of the steps of each, and its bounds.
    ranges: Vec<(f64, [f64; 2])>,
}

fn system_parameters(
    scene: &Scene,
    blank: &Scene,
    variables: &[Variable],
) -> Result<Parameters, Fault> {
    let mut parameters = Parameters::default();
    let blank = VariableScene::new(blank)?;
    for (i, variable) in variables.iter().enumerate() {
        let at = format!("design.variable[{i}].path");
        let address = VariableAddress::new(&blank, &variable.path, &at)?;
        let start = address.value(&blank);
        if !start.is_finite() {
            return Err(scene.fault(&at, "infinity", "a finite number to start from"));
        }
        let usual = if start == 0.0 {
            SCALE
        } else {
            SCALE * start.abs()
        };
        let scale = variable.scale.unwrap_or(usual);
        let bounds = address.bounds([variable.lowest, variable.highest]);
        let Some(bounds) = bounds.filter(|[low, high]| low <= &start && &start <= high) else {
            let text = |bound: Option<f64>| bound.map_or(String::from("none"), |b| b.to_string());
            let found = format!(
                "lowest {} and highest {}",
                text(variable.lowest),
                text(variable.highest)
            );
            let expected =
                "lowest and highest about the scene's own value; both of one sign for a radius";
            return Err(scene.fault(&at, found, expected));
        };
        parameters.list.push(SystemParameter {
            name: address.name(),
            start,
            step: NEAR * scale,
        });
        parameters.addresses.push(address);
        parameters.ranges.push((scale, bounds));
    }
    Ok(parameters)
}

/// The parameters of all pixels at the start.
fn starts(scene: &Scene, parts: &[PixelPart], elements: &[Element]) -> Result<Vec<f64>, Fault> {
    let mut point = Vec::new();
    for (part, element) in parts.iter().zip(elements) {
        // The files of the others may not exist.
        let others = parts.iter().filter(|other| other.place != part.place);
        let scene = blanked(scene, others);
        point.extend(start(&scene, part, element)?);
    }
    Ok(point)
}

/// The parameters of one element at the start.
fn start(scene: &Scene, part: &PixelPart, element: &Element) -> Result<Vec<f64>, Fault> {
    let (modulator, shape) = (&element.modulator, part.shape());
    let [phases, amplitudes] = modulator.planes();
    let planes = match part.is_read() {
        true => part.stored(scene, modulator)?,
        false => {
            let found = phase(scene, part, element.screen, shape)?;
            let mut planes = vec![found; phases];
            if matches!(modulator.modulation(), Modulation::TwoPhase(_)) {
                // Two phases that are alike would stay so.
                let screen = element.screen as u32;
                let turn = random_phase(scene.seed, screen, Purpose::SecondStartPhase, shape);
                planes[1] = &planes[1] + &turn.mapv(|turn| 0.5 * turn);
            }
            planes.extend(vec![Array2::ones(shape); amplitudes]);
            planes
        }
    };
    Ok(packed(modulator, &planes, phases))
}

/// Planes of pixels as parameters: a block starts at the mean of its pixels' phasors or amplitudes.
fn packed(modulator: &Modulator, planes: &[Array2<f64>], phases: usize) -> Vec<f64> {
    let constraints = modulator.constraints();
    let mut point = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let blocks = match (number < phases, constraints.free() == plane.dim()) {
            (_, true) => plane.clone(),
            (true, false) => constraints.block_phases(plane.view()),
            (false, false) => constraints.block_means(plane.view()),
        };
        point.extend(blocks);
    }
    point
}

/// The phases of an element at the start, where they are not read.
fn phase(
    scene: &Scene,
    part: &PixelPart,
    screen: usize,
    shape: (usize, usize),
) -> Result<Array2<f64>, Fault> {
    let task = || {
        let named = scene.hologram.as_ref().map(|hologram| &hologram.element);
        if named != Some(&part.part.name) {
            let expected =
                "a [hologram] of this element, or start = \"flat\", \"random\" or \"file\"";
            let path = format!("{}.start", part.at);
            return Err(scene.fault(&path, "a start that needs a picture", expected));
        }
        commission(scene, false)
    };
    Ok(match part.part.start {
        Start::Flat | Start::File => Array2::zeros(shape),
        Start::Random => random_phase(scene.seed, screen as u32, Purpose::StartPhase, shape),
        Start::Spread => spread(&task()?, shape),
        Start::Paraxial => {
            let commission = task()?;
            let found = hologram::design(&commission.task, &mut |_| ());
            found
                .map_err(|error| commission.fault(scene, &error))?
                .phase
        }
    })
}

/// The phase that spreads the light over the picture.
fn spread(commission: &HologramDesign, shape: (usize, usize)) -> Array2<f64> {
    let task = &commission.task;
    let spreading = SpreadingPhase {
        wavelength: task.wavelength,
        train: task.train,
        pitch: task.pitch,
        lit: [0, 1].map(|a| 0.5 * [shape.1, shape.0][a] as f64 * task.pitch[a]),
        spread: task
            .target
            .size
            .map(|size| 0.5 * size * std::f64::consts::SQRT_2),
    };
    spreading.phase(shape)
}

/// The search from the start.
fn search(
    design: &Design,
    project: &Project,
    mut start: Vec<f64>,
    ranges: &[(f64, [f64; 2])],
) -> Result<Optimizer, OptimizerError> {
    let pixels = start.len();
    start.extend(
        project
            .system_parameters
            .iter()
            .map(|parameter| parameter.start),
    );
    let mut space = Space::free(start.len());
    let mut from = 0;
    for element in &project.elements {
        let bounds = element.modulator.bounds();
        let size = element.modulator.count() / bounds.len().max(1);
        for bounds in bounds {
            if let Some([low, high]) = bounds {
                space = space.with_bounds(from..from + size, low, high)?;
            }
            from += size;
        }
    }
    for (i, (scale, [low, high])) in ranges.iter().enumerate() {
        let one = pixels + i..pixels + i + 1;
        space = space
            .with_scale(one.clone(), *scale)?
            .with_bounds(one, *low, *high)?;
    }
    let rate = design.rate.unwrap_or(RATE);
    let schedule = match design.last_rate {
        None => Schedule::Constant { rate },
        Some(to) => Schedule::Cosine {
            from: rate,
            to,
            iterations: design.iterations,
        },
    };
    let method = match design.optimizer {
        OptimizerKind::Lbfgs => Method::Lbfgs(LbfgsSettings {
            first: 0.1 * (start.len() as f64).sqrt(),
            ..LbfgsSettings::default()
        }),
        OptimizerKind::Adam => Method::Descent(Rule::ADAM, schedule),
        OptimizerKind::Momentum => Method::Descent(Rule::Momentum { momentum: 0.9 }, schedule),
    };
    method.start(start, space)
}

/// Length of a step of adam or momentum, where the scene gives none, in rad.
const RATE: f64 = 0.2;

/// L-BFGS finds the lengths of its steps itself: a scene that gives them is refused.
fn check_rates(scene: &Scene, design: &Design) -> Result<(), Fault> {
    let rates = [("rate", design.rate), ("last_rate", design.last_rate)];
    match rates.iter().find(|(_, given)| given.is_some()) {
        Some((key, _)) if design.optimizer == OptimizerKind::Lbfgs => Err(scene.fault(
            &format!("design.{key}"),
            "the length of a step with the optimizer lbfgs, which finds its own",
            "it with optimizer = \"adam\" or \"momentum\"",
        )),
        _ => Ok(()),
    }
}

/// Which beamlets are followed.
///
/// # Errors
/// An optimiser or a loss that drawn beamlets cannot serve.
fn estimator(scene: &Scene, design: &Design, system: &System) -> Result<Option<Estimator>, Fault> {
    let Some(given) = &design.estimator else {
        return Ok(None);
    };
    let fault = |found: &str, expected: &str| Err(scene.fault("design.estimator", found, expected));
    if design.optimizer == OptimizerKind::Lbfgs {
        return fault(
            "drawn beamlets with the optimizer lbfgs",
            "adam or momentum, which bear noise",
        );
    }
    if !design.variable.is_empty() {
        return fault(
            "drawn beamlets and parameters of the system that are designed",
            "one of the two",
        );
    }
    if given.kind == EstimatorKind::ControlVariate && system.trains.len() != 1 {
        return fault(
            "a control variate with several screens before the sensor",
            "one element and the sensor",
        );
    }
    Ok(Some(Estimator {
        kind: given.kind,
        each: given.each,
        refresh: given.refresh,
        temperature: given.temperature,
    }))
}
