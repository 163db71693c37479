//! The design that a scene asks for: its losses, what is free, where it starts, and what it leaves.

use std::path::PathBuf;
use std::sync::Arc;

use ndarray::Array2;

use crate::design::constraint::{Constraints, Rules};
use crate::design::descent::Rule;
use crate::design::fill::Fill;
use crate::design::hologram;
use crate::design::lbfgs::LbfgsSettings;
use crate::design::likeness::{Brightness, Likeness};
use crate::design::loss::{Loss, Sum};
use crate::design::optimizer::{Method, Optimizer as Search};
use crate::design::project::{Channel, Element, Number, Project, Rig};
use crate::design::relief::{Levels, Relief};
use crate::design::schedule::Schedule;
use crate::design::share::Share;
use crate::design::space::Space;
use crate::design::staircase::Hardening;
use crate::design::start::{Spreading, random_phase};
use crate::engine::settings::Settings;
use crate::engine::simulate::sensor_of;
use crate::file::build;
use crate::file::design::{Design, Optimizer, Start, Variable};
use crate::file::fault::Fault;
use crate::file::hologram::{Commission, asked, blanked, commission, target};
use crate::file::scene::Scene;
use crate::file::variable::{Address, with_numbers};
use crate::optics::screen::Act;
use crate::optics::system::System;
use crate::wave::raster::Raster;

/// A design that a scene asks for.
pub struct Brief {
    /// What is looked for.
    pub project: Project,
    /// How, and from where.
    pub search: Search,
    /// What the scene says.
    pub design: Design,
    /// The picture wanted at the sensor's pixels, [y, x].
    pub picture: Array2<f64>,
    /// Where on the sensor the light is wanted.
    pub window: Array2<f64>,
    /// The file that the scene names for the phase, if it does, and the factor on its phases when it is read.
    pub file: Option<PathBuf>,
    /// See [`Brief::file`].
    pub phase_scale: f64,
    /// Area of a pixel of the sensor in mm².
    pub pixel_area: f64,
    /// Half width and height of the sensor and of the element, in mm.
    pub sensor_half: [f64; 2],
    /// See [`Brief::sensor_half`].
    pub element_half: [f64; 2],
    /// The numbers that are designed.
    addresses: Arc<Vec<Address>>,
}

/// Relative size of a step of a number, where none is given.
const SCALE: f64 = 1e-3;

/// Neighbours that tell a derivative are this share of a step away.
const NEAR: f64 = 0.01;

/// The design of a scene without its arrays, which may be still to come.
///
/// # Errors
/// No `[design]` or `[hologram]`, or what these ask for cannot be.
pub fn brief(scene: &Scene) -> Result<Brief, Fault> {
    let Some(design) = scene.design.clone() else {
        return Err(scene.fault("design", "no design", "a table [design]"));
    };
    let wanted = asked(scene)?;
    let (blank, place) = blanked(scene, wanted)?;
    if place.layer.amplitude.is_some() {
        let path = format!("element[{}].layer", place.element);
        let expected = "size = [nx, ny]: a design makes phases";
        return Err(scene.fault(&path, "an amplitude", expected));
    }
    let blank = Arc::new(blank.load()?);
    let system = build::system(&blank, 0)?;
    let (screen, shape) = pixels_of(&system, &wanted.element);
    let view = View::of(scene, &system)?;

    // What is free, and where it starts.
    let constraints = constraints(scene, &design, shape)?;
    let (addresses, numbers, scales) = numbers(scene, &blank, &design.variable)?;
    let addresses = Arc::new(addresses);
    let start = start(scene, &design, &constraints, (screen, shape))?;

    let light = transmitted(&system, screen);
    let channels = (0..scene.wavelength_um.len()).map(|index| view.channel(scene, index, light));
    let project = Project {
        rig: rig(&blank, &addresses),
        channels: channels.collect::<Result<_, Fault>>()?,
        elements: vec![Element {
            screen,
            constraints,
        }],
        settings: settings(scene, !numbers.is_empty()),
        numbers,
    };
    let search = search(&design, &project, start, &scales).map_err(|error| {
        let expected = "numbers that make sense together";
        scene.fault("design", error.to_string(), expected)
    })?;
    let file = place.layer.phase.as_ref();
    let side = |a: usize| [shape.1, shape.0][a] as f64 * place.layer.pitch_um[a] * 1e-3;
    Ok(Brief {
        project,
        search,
        design,
        file: file.map(|file| scene.origin.beside(file)),
        phase_scale: place.layer.phase_scale,
        pixel_area: view.raster.pitch[0] * view.raster.pitch[1],
        sensor_half: [0, 1].map(|a| 0.5 * view.raster.size[a] as f64 * view.raster.pitch[a]),
        element_half: [0, 1].map(|a| 0.5 * side(a)),
        picture: view.picture,
        window: view.window,
        addresses,
    })
}

/// The sensor with what is wanted on it.
struct View {
    raster: Raster,
    /// The picture at the pixels, [y, x], and where its outline is.
    picture: Array2<f64>,
    window: Array2<f64>,
}

impl View {
    fn of(scene: &Scene, system: &System) -> Result<Self, Fault> {
        let sensor = sensor_of(system)
            .map_err(|error| scene.fault("element", error.to_string(), "a sensor at the end"))?;
        let (raster, target) = (Raster::of(sensor), target(scene, asked(scene)?)?);
        let inside = target.inside(&raster);
        Ok(Self {
            picture: target.on(&raster),
            window: inside.mapv(|inside| f64::from(u8::from(inside))),
            raster,
        })
    }

    /// The channel of a wavelength, for an element that lets this power of light through (mm²).
    fn channel(&self, scene: &Scene, index: usize, power: f64) -> Result<Channel, Fault> {
        let efficiency = scene
            .design
            .as_ref()
            .map_or(0.0, |design| design.efficiency);
        let area = self.raster.pitch[0] * self.raster.pitch[1];
        let loss = loss(&self.picture, &self.window, (power, area), efficiency);
        let lengths = &scene.wavelength_um;
        Ok(Channel {
            loss: loss.map_err(|error| {
                let expected = "a picture on the sensor";
                scene.fault("hologram.target", error.to_string(), expected)
            })?,
            weight: 1.0 / lengths.len() as f64,
            ratio: lengths[0] / lengths[index],
        })
    }
}

/// What makes the systems: the scene with the numbers of a point.
fn rig(blank: &Arc<Scene>, addresses: &Arc<Vec<Address>>) -> Rig {
    let (scene, addresses) = (Arc::clone(blank), Arc::clone(addresses));
    Box::new(move |channel: usize, values: &[f64]| {
        let made = match values.is_empty() {
            true => build::system(&scene, channel),
            false => with_numbers(&scene, &addresses, values)
                .and_then(|scene| build::system(&scene, channel)),
        };
        made.map_err(|fault| fault.to_string())
    })
}

/// What can be made of an element of that many rows and columns.
fn constraints(
    scene: &Scene,
    design: &Design,
    shape: (usize, usize),
) -> Result<Constraints, Fault> {
    let relief = relief(design)
        .map_err(|error| scene.fault("design.levels", error.to_string(), "at least two levels"))?;
    let rules = Rules {
        block: design.block,
        relief,
        fill: Fill::WHOLE,
        blur: None,
    };
    Constraints::new(rules, shape).map_err(|error| {
        let expected = "blocks that fit the element";
        scene.fault("design.block", error.to_string(), expected)
    })
}

impl Brief {
    /// The scene with the numbers of a point of the design.
    ///
    /// # Errors
    /// A scene that is none with these numbers.
    pub fn scene_at(&self, scene: &Scene, point: &[f64]) -> Result<Scene, Fault> {
        let values = &point[self.project.numbers_from()..];
        with_numbers(scene, &self.addresses, values)
    }
}

/// How light is carried: what is kept may not depend on the phases that are sought, and where the system
/// changes, footprints end so far out that no value jumps.
fn settings(scene: &Scene, changing: bool) -> Settings {
    let mut settings = build::settings(scene);
    settings.mode_threshold = Some(0.0);
    if changing {
        let edge = settings.footprint_edge().min(SMOOTH);
        settings.footprint_threshold = Some(edge);
    }
    settings
}

/// Where footprints end when the system changes.
const SMOOTH: f64 = 1e-7;

/// The screen of an element by its name, and the rows and columns of its pixels.
fn pixels_of(system: &System, name: &str) -> (usize, (usize, usize)) {
    let named = system.screens.iter().position(|screen| screen.name == name);
    let at = named.unwrap_or(0);
    let shape = match &system.screens[at].act {
        Act::Doe(doe) => doe.free_pixels().map(|pixels| pixels.values.dim()),
        Act::Stop(_) | Act::Sensor(_) => None,
    };
    (at, shape.unwrap_or((1, 1)))
}

/// ∫ of the opening of an element, in mm²: the power behind it of light of unit amplitude.
fn transmitted(system: &System, screen: usize) -> f64 {
    let Act::Doe(doe) = &system.screens[screen].act else {
        return 1.0;
    };
    let Some(pixels) = doe.free_pixels() else {
        return 1.0;
    };
    let ([x0, _, y0, _], (ny, nx)) = (pixels.bounds(), pixels.values.dim());
    let [dx, dy] = pixels.pitch;
    let mut total = 0.0;
    for j in 0..ny {
        for i in 0..nx {
            let (x, y) = (x0 + i as f64 * dx, y0 + j as f64 * dy);
            total += doe.aperture.coverage(x, x + dx, y, y + dy) * dx * dy;
        }
    }
    total
}

/// 1 − NCC², and −β·log of the share of the light in the picture's outline.
fn loss(
    picture: &Array2<f64>,
    window: &Array2<f64>,
    (power, area): (f64, f64),
    efficiency: f64,
) -> Result<Box<dyn Loss>, crate::design::loss::LossError> {
    let alike = Likeness::new(picture.clone(), None, Brightness::Free)?;
    if efficiency == 0.0 {
        return Ok(Box::new(alike));
    }
    let lit = lit(picture, window);
    let share = Share::efficiency(lit, power, area, efficiency)?;
    Ok(Box::new(Sum::new(vec![
        (1.0, Box::new(alike) as Box<dyn Loss>),
        (1.0, Box::new(share)),
    ])?))
}

/// Where the picture is not black.
fn lit(picture: &Array2<f64>, window: &Array2<f64>) -> Array2<f64> {
    let most = picture.iter().fold(0.0f64, |most, value| most.max(*value));
    let mut lit = window.clone();
    lit.zip_mut_with(picture, |lit, value| {
        if *value < BLACK * most {
            *lit = 0.0;
        }
    });
    lit
}

/// What counts as black, over the brightest.
const BLACK: f64 = 0.05;

fn relief(design: &Design) -> Result<Option<Relief>, crate::design::relief::ReliefError> {
    let levels = design.levels.map(|count| Levels {
        count,
        hardening: match design.optimizer {
            Optimizer::Lbfgs => Hardening::Annealed,
            Optimizer::Adam | Optimizer::Momentum => Hardening::StraightThrough,
        },
    });
    levels.map(Relief::phases).transpose()
}

/// The numbers that are designed, and the scales of their steps.
type Numbers = (Vec<Address>, Vec<Number>, Vec<f64>);

fn numbers(scene: &Scene, blank: &Scene, variables: &[Variable]) -> Result<Numbers, Fault> {
    let mut list: Numbers = Default::default();
    for (i, variable) in variables.iter().enumerate() {
        let at = format!("design.variable[{i}].path");
        let address = Address::new(blank, &variable.path, &at)?;
        let start = address.value(blank)?;
        if !start.is_finite() {
            return Err(scene.fault(&at, "infinity", "a finite number to start from"));
        }
        let usual = if start == 0.0 {
            SCALE
        } else {
            SCALE * start.abs()
        };
        let scale = variable.scale.unwrap_or(usual);
        list.1.push(Number {
            name: address.name(),
            start,
            step: NEAR * scale,
        });
        list.0.push(address);
        list.2.push(scale);
    }
    Ok(list)
}

/// The parameters of the pixels at the start.
fn start(
    scene: &Scene,
    design: &Design,
    constraints: &Constraints,
    (screen, shape): (usize, (usize, usize)),
) -> Result<Vec<f64>, Fault> {
    let phase = match design.start {
        Start::Flat => Array2::zeros(shape),
        Start::Random => random_phase(scene.seed, screen as u32, shape),
        Start::Spread => spread(&commission(scene, false)?, shape),
        Start::Paraxial => {
            let wanted = commission(scene, false)?;
            let found = hologram::design(&wanted.task, &mut |_| ());
            found.map_err(|error| wanted.blame(scene, &error))?.phase
        }
        Start::File => file_phase(scene)?,
    };
    if constraints.free() == shape {
        return Ok(phase.into_iter().collect());
    }
    // A block starts at the mean of its pixels' phasors.
    let mean = constraints.block_phases(phase.view());
    Ok(mean.into_iter().collect())
}

/// The phase that spreads the light over the picture.
fn spread(wanted: &Commission, shape: (usize, usize)) -> Array2<f64> {
    let task = &wanted.task;
    let spreading = Spreading {
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

/// The phases of the file that the layer names.
fn file_phase(scene: &Scene) -> Result<Array2<f64>, Fault> {
    let full = scene.clone().load()?;
    let system = build::system(&full, 0)?;
    let (screen, shape) = pixels_of(&system, &asked(scene)?.element);
    let phase = match &system.screens[screen].act {
        Act::Doe(doe) => doe
            .free_pixels()
            .map(|pixels| pixels.values.mapv(|t| t.arg())),
        Act::Stop(_) | Act::Sensor(_) => None,
    };
    Ok(phase.unwrap_or_else(|| Array2::zeros(shape)))
}

/// The search from the start.
fn search(
    design: &Design,
    project: &Project,
    mut start: Vec<f64>,
    scales: &[f64],
) -> Result<Search, crate::design::step::OptimizerError> {
    let pixels = start.len();
    start.extend(project.numbers.iter().map(|number| number.start));
    let mut space = Space::free(start.len());
    for (i, scale) in scales.iter().enumerate() {
        space = space.with_scale(pixels + i..pixels + i + 1, *scale)?;
    }
    let schedule = match design.last_rate {
        None => Schedule::Constant { rate: design.rate },
        Some(to) => Schedule::Cosine {
            from: design.rate,
            to,
            iterations: design.iterations,
        },
    };
    let method = match design.optimizer {
        Optimizer::Lbfgs => Method::Lbfgs(LbfgsSettings {
            first: 0.1 * (start.len() as f64).sqrt(),
            ..LbfgsSettings::default()
        }),
        Optimizer::Adam => Method::Descent(Rule::ADAM, schedule),
        Optimizer::Momentum => Method::Descent(Rule::Momentum { momentum: 0.9 }, schedule),
    };
    method.start(start, space)
}
