//! The elements whose pixels a scene designs: what is free, what can be made, and where it is written.

#![expect(
    clippy::indexing_slicing,
    reason = "elements, layers and channels are those that the part was found by; axes are 0 and 1"
)]

use std::path::PathBuf;

use ndarray::Array2;
use num_complex::Complex64;

use crate::design::constraints::constraint::{Constraints, Rules};
use crate::design::constraints::modulation::{Modulation, Modulator, Shaped};
use crate::design::constraints::relief::{Levels, Relief};
use crate::design::constraints::staircase::Hardening;
use crate::file::decode::fault::Fault;
use crate::file::model::fringed_pixels::refuse_fringing;
use crate::file::model::relief_side::{side_of_relief, unplaced};
use crate::file::model::scene_media::index_at;
use crate::file::scene::design::{Design, DesignElement, Free, OptimizerKind, Start};
use crate::file::scene::element::{Element, WITH_PIXELS};
use crate::file::scene::layer::{HeightLayer, Layer, PixelLayer, SumLayer};
use crate::file::scene::scene_file::Scene;
use crate::optics::pixels::active_area::Rest;
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

/// An element whose pixels are designed.
#[derive(Clone, Debug)]
pub(crate) struct PixelPart {
    /// What the scene says about it.
    pub(crate) part: DesignElement,
    /// Where it says so: `design`, or `design.element[2]`.
    pub(crate) at: String,
    /// The key of `at` that names the element.
    pub(crate) name_key: String,
    /// Number of the element in the scene, and of its layer.
    pub(crate) place: [usize; 2],
    /// The layer as the scene has it.
    layer: Layer,
    /// One blank layer of its pixels.
    blank: PixelLayer,
}

/// A file that a design leaves.
#[derive(Clone, Debug)]
pub struct Output {
    /// Path of the file.
    pub file: PathBuf,
    /// The field of the scene that names it, such as `element[0].layer[0].phase`.
    pub field: String,
    /// The element.
    element: usize,
    quantity: Quantity,
}

/// What a file holds.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    /// A plane of phases over this.
    Phase { plane: usize, scale: f64 },
    /// Amplitudes.
    Amplitude,
    /// Heights in µm.
    Height,
}

impl Output {
    /// The values of the file, [y, x], from all elements as made: phases over `phase_scale` of the layer, amplitudes
    /// from 0 to 1, or heights in µm.
    pub fn values(&self, made: &[Shaped]) -> Array2<f64> {
        let shaped = &made[self.element];
        let found = match self.quantity {
            Quantity::Phase { plane, scale } => {
                shaped.phases.get(plane).map(|made| &made.phase / scale)
            }
            Quantity::Amplitude => shaped.amplitude.clone(),
            Quantity::Height => {
                let made = shaped.phases.first();
                made.and_then(|made| made.height.as_ref().map(|height| height / UM))
            }
        };
        found.unwrap_or_default()
    }

    /// Name of the quantity in the file: "phase", "amplitude" or "height".
    pub fn what(&self) -> &'static str {
        match self.quantity {
            Quantity::Phase { .. } => "phase",
            Quantity::Amplitude => "amplitude",
            Quantity::Height => "height",
        }
    }
}

/// All elements that a design is about.
///
/// # Errors
/// Keys for the element of `[hologram]` beside a list of elements, names of none, layers that do not fit.
pub(crate) fn pixel_parts(scene: &Scene, design: &Design) -> Result<Vec<PixelPart>, Fault> {
    if design.element.is_empty() {
        let Some(hologram) = &scene.hologram else {
            return stray(scene, design, "no [hologram]").map(|()| Vec::new());
        };
        let part = DesignElement {
            name: hologram.element.clone(),
            free: Free::Phase,
            start: design.start.unwrap_or_default(),
            levels: design.levels,
            block: design.block.unwrap_or(1),
            blur: None,
            smoothness: 0.0,
            highest_um: None,
        };
        let at = String::from("design");
        return Ok(vec![PixelPart::new(
            scene,
            part,
            at,
            "hologram.element".into(),
        )?]);
    }
    stray(scene, design, "[[design.element]]")?;
    let mut parts: Vec<PixelPart> = Vec::new();
    for (i, part) in design.element.iter().enumerate() {
        let at = format!("design.element[{i}]");
        if parts.iter().any(|other| other.part.name == part.name) {
            let expected = "each element once";
            return Err(scene.fault(&format!("{at}.name"), &*part.name, expected));
        }
        let name_key = format!("{at}.name");
        parts.push(PixelPart::new(scene, part.clone(), at, name_key)?);
    }
    Ok(parts)
}

/// Refuses keys for the element of `[hologram]` where there is another list of elements, or none.
fn stray(scene: &Scene, design: &Design, beside: &str) -> Result<(), Fault> {
    let keys = [
        ("start", design.start.is_some()),
        ("levels", design.levels.is_some()),
        ("block", design.block.is_some()),
    ];
    match keys.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((key, _)) => Err(scene.fault(
            &format!("design.{key}"),
            format!("a key for the element of [hologram] beside {beside}"),
            "it inside a [[design.element]]",
        )),
    }
}

impl PixelPart {
    fn new(
        scene: &Scene,
        part: DesignElement,
        at: String,
        name_key: String,
    ) -> Result<Self, Fault> {
        let Some(number) = scene.number_of(&part.name) else {
            return Err(scene.nameless(&name_key, &part.name));
        };
        let Element::Doe(doe) = &scene.element[number] else {
            return Err(scene.fault(&name_key, &*part.name, WITH_PIXELS));
        };
        let gridded =
            |layer: &Layer| matches!(layer, Layer::Pixels(_) | Layer::Height(_) | Layer::Sum(_));
        let Some(place) = doe.layer.iter().position(gridded) else {
            return Err(scene.fault(&name_key, &*part.name, WITH_PIXELS));
        };
        let path = format!("element[{number}].layer[{place}]");
        let blank = blank(scene, &doe.layer[place], part.free, &path)?;
        if part.highest_um.is_some() && part.free != Free::Height {
            let expected = "it with free = \"height\" only";
            return Err(scene.fault(&format!("{at}.highest_um"), "a largest height", expected));
        }
        Ok(Self {
            layer: doe.layer[place].clone(),
            place: [number, place],
            part,
            at,
            name_key,
            blank,
        })
    }

    /// Rows and columns of its pixels.
    pub(crate) fn shape(&self) -> (usize, usize) {
        self.blank.size.map_or((1, 1), |[nx, ny]| (ny, nx))
    }

    /// Half width and height in mm.
    pub(crate) fn half(&self) -> [f64; 2] {
        let (ny, nx) = self.shape();
        [0, 1].map(|a| 0.5 * [nx, ny][a] as f64 * self.blank.pitch_um[a] * UM)
    }

    /// Its screen in a system.
    ///
    /// # Errors
    /// An element without pixels there.
    pub(crate) fn screen(&self, scene: &Scene, system: &System) -> Result<usize, Fault> {
        let named = |name: &str| name == self.part.name;
        let at = system.screens.iter().position(|screen| named(&screen.name));
        let pixels = at.filter(|at| match &system.screens[*at].kind {
            ScreenKind::Doe(doe) => doe.free_pixels().is_some(),
            ScreenKind::Stop(_) | ScreenKind::Sensor(_) => false,
        });
        pixels.ok_or_else(|| {
            let expected = "an element with pixels";
            scene.fault(&self.name_key, &*self.part.name, expected)
        })
    }

    /// What is made of its parameters; at each wavelength of the scene it stands in a medium of these indices.
    ///
    /// # Errors
    /// Numbers that make no sense.
    pub(crate) fn modulator(
        &self,
        scene: &Scene,
        optimizer: OptimizerKind,
        around: &[[f64; 2]],
    ) -> Result<Modulator, Fault> {
        let hardening = match optimizer {
            OptimizerKind::Lbfgs => Hardening::Annealed,
            OptimizerKind::Adam | OptimizerKind::Momentum => Hardening::StraightThrough,
        };
        let levels = self.part.levels.map(|count| Levels { count, hardening });
        let rules = Rules {
            block: self.part.block,
            blur: self.part.blur,
            relief: self.relief(scene, levels, around)?,
        };
        let constraints = Constraints::new(rules, self.shape()).map_err(|error| {
            let expected = "blocks that fit the element";
            scene.fault(&format!("{}.block", self.at), error.to_string(), expected)
        })?;
        let modulation = match (self.part.free, &self.layer) {
            (Free::Amplitude, _) => Modulation::Amplitude,
            (Free::Both, _) => Modulation::Both,
            (Free::TwoPhase, Layer::Sum(sum)) => Modulation::TwoPhase(weights(sum)),
            _ => Modulation::Phase,
        };
        Ok(Modulator::new(modulation, constraints).smooth(self.part.smoothness))
    }

    /// Levels of phase, or the heights that can be made.
    fn relief(
        &self,
        scene: &Scene,
        levels: Option<Levels>,
        around: &[[f64; 2]],
    ) -> Result<Option<Relief>, Fault> {
        let at = |key: &str| format!("{}.{key}", self.at);
        let Layer::Height(height) = &self.layer else {
            let relief = levels.map(Relief::phases).transpose();
            return relief
                .map_err(|error| scene.fault(&at("levels"), error.to_string(), "two or more"));
        };
        let index = self.index(scene, height, 0)?;
        let displaced = self.displaced(scene, height, around, 0)?;
        let wavelength = scene.wavelength_um[0] * UM;
        let wave = wavelength / (index - displaced).abs();
        let highest = self.part.highest_um.map_or(wave, |highest| highest * UM);
        let relief = Relief::transmission(wavelength, [index, displaced], highest, levels);
        let relief = relief.map_err(|error| {
            let expected = "a material unlike what is around it, at least two levels";
            scene.fault(&self.name_key, error.to_string(), expected)
        })?;
        Ok(Some(relief))
    }

    fn index(&self, scene: &Scene, height: &HeightLayer, channel: usize) -> Result<f64, Fault> {
        let [element, layer] = self.place;
        let path = format!("element[{element}].layer[{layer}].glass");
        index_at(scene, &height.glass, channel, &path)
    }

    /// The index of the medium whose place a relief takes, at a wavelength.
    fn displaced(
        &self,
        scene: &Scene,
        height: &HeightLayer,
        around: &[[f64; 2]],
        channel: usize,
    ) -> Result<f64, Fault> {
        let own = self.index(scene, height, 0)?;
        let [element, layer] = self.place;
        let path = format!("element[{element}].layer[{layer}]");
        let side = side_of_relief(own, around[0], height.stands_in);
        let side = side.ok_or_else(|| unplaced(scene, &path))?;
        Ok(side.of(around[channel]))
    }

    /// What its phases are at a wavelength over those at the first one.
    ///
    /// # Errors
    /// A material that is not known there.
    pub(crate) fn ratio(
        &self,
        scene: &Scene,
        around: &[[f64; 2]],
        channel: usize,
    ) -> Result<f64, Fault> {
        let Layer::Height(height) = &self.layer else {
            return Ok(1.0);
        };
        let per_height = |channel: usize| -> Result<f64, Fault> {
            let own = self.index(scene, height, channel)?;
            let step = own - self.displaced(scene, height, around, channel)?;
            Ok(step / scene.wavelength_um[channel])
        };
        Ok(per_height(channel)? / per_height(0)?)
    }

    /// The files that it leaves.
    ///
    /// # Errors
    /// A layer that names no file for the result.
    pub(crate) fn outputs(&self, scene: &Scene, element: usize) -> Result<Vec<Output>, Fault> {
        let mut list = Vec::new();
        let [number, layer] = self.place;
        let path = format!("element[{number}].layer[{layer}]");
        let mut claim = |name: Option<&PathBuf>, key: &str, quantity: Quantity| match name {
            Some(name) => {
                list.push(Output {
                    file: scene.origin.beside(name),
                    field: format!("{path}.{key}"),
                    element,
                    quantity,
                });
                Ok(())
            }
            None => {
                let expected = format!("`{key}` in the layer that is designed");
                Err(scene.fault(&path, format!("no file for the {key}"), expected))
            }
        };
        let phase = |pixels: &PixelLayer, plane: usize| Quantity::Phase {
            plane,
            scale: pixels.phase_scale,
        };
        match &self.layer {
            Layer::Pixels(pixels) => {
                if self.part.free != Free::Amplitude {
                    claim(pixels.phase.as_ref(), "phase", phase(pixels, 0))?;
                }
                if self.part.free != Free::Phase {
                    claim(pixels.amplitude.as_ref(), "amplitude", Quantity::Amplitude)?;
                }
            }
            Layer::Height(height) => {
                claim(Some(&height.height_um), "height_um", Quantity::Height)?;
            }
            Layer::Sum(sum) => {
                for (plane, term) in sum.terms.iter().enumerate() {
                    if let [Layer::Pixels(pixels)] = term.as_slice() {
                        let key = format!("terms[{plane}][0].phase");
                        claim(pixels.phase.as_ref(), &key, phase(pixels, plane))?;
                    }
                }
            }
            _ => {}
        }
        Ok(list)
    }

    /// What its files hold: planes of phases in rad, then of amplitudes.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn stored(
        &self,
        scene: &Scene,
        modulator: &Modulator,
    ) -> Result<Vec<Array2<f64>>, Fault> {
        let full = scene.clone().load()?;
        let [element, layer] = self.place;
        let path = format!("element[{element}].layer[{layer}]");
        let read = |pixels: &PixelLayer, path: &str| {
            let whole = PixelLayer {
                fill: 1.0,
                ..pixels.clone()
            };
            let values = full.arrays.transmission(&whole, path);
            values.unwrap_or_default()
        };
        Ok(match &self.layer {
            Layer::Pixels(pixels) => {
                let values = read(pixels, &path);
                let [phases, amplitudes] = modulator.planes();
                let mut planes = vec![values.mapv(|t| t.arg()); phases];
                planes.extend(vec![values.mapv(|t| t.norm()); amplitudes]);
                planes
            }
            Layer::Height(_) => {
                let factor = modulator.constraints().per_height().unwrap_or(1.0);
                let heights = full.arrays.heights_um(&path);
                vec![heights.map(|h| &h * (factor * UM)).unwrap_or_default()]
            }
            Layer::Sum(sum) => {
                let terms = sum.terms.iter().enumerate();
                let term = |(i, term): (usize, &Vec<Layer>)| match term.as_slice() {
                    [Layer::Pixels(pixels)] => {
                        read(pixels, &format!("{path}.terms[{i}][0]")).mapv(|t| t.arg())
                    }
                    _ => Array2::default((0, 0)),
                };
                terms.map(term).collect()
            }
            _ => Vec::new(),
        })
    }

    /// Whether it starts with what its files hold.
    pub(crate) fn is_read(&self) -> bool {
        self.part.start == Start::File
    }
}

/// The scene with the layers of these parts made blank, so that their files need not exist.
pub(crate) fn blanked<'p>(scene: &Scene, parts: impl Iterator<Item = &'p PixelPart>) -> Scene {
    let mut blank = scene.clone();
    for part in parts {
        let [element, layer] = part.place;
        if let Element::Doe(doe) = &mut blank.element[element] {
            doe.layer[layer] = Layer::Pixels(part.blank.clone());
        }
    }
    blank
}

/// The weights of a sum of two.
fn weights(sum: &SumLayer) -> [Complex64; 2] {
    match sum.weights.as_deref() {
        Some([a, b]) => [a.0, b.0],
        _ => [Complex64::ONE; 2],
    }
}

/// A blank layer of the pixels of one that is to be designed.
fn blank(scene: &Scene, layer: &Layer, free: Free, path: &str) -> Result<PixelLayer, Fault> {
    let sized = "size = [nx, ny] and the names of files for what is found";
    let unsized_layer = |path: &str| scene.fault(path, "a layer to design without its size", sized);
    match (layer, free) {
        (Layer::Pixels(pixels), Free::Phase | Free::Amplitude | Free::Both) => {
            let other = match free {
                Free::Phase => ("amplitude", &pixels.amplitude),
                Free::Amplitude => ("phase", &pixels.phase),
                _ => ("transmission", &pixels.transmission),
            };
            for (key, file) in [other, ("transmission", &pixels.transmission)] {
                if file.is_some() {
                    let expected = match free {
                        Free::Phase => "`phase` alone: the amplitude is one (or free = \"both\")",
                        Free::Amplitude => {
                            "`amplitude` alone: the phase is zero (or free = \"both\")"
                        }
                        _ => "`phase` and `amplitude`",
                    };
                    let found = format!("a file of {key} in a layer that is designed");
                    return Err(scene.fault(&format!("{path}.{key}"), found, expected));
                }
            }
            refuse_fringing(scene, pixels, path)?;
            bare(pixels).ok_or_else(|| unsized_layer(path))
        }
        (Layer::Height(height), Free::Height) => {
            let size = height.size.ok_or_else(|| unsized_layer(path))?;
            Ok(PixelLayer {
                centre_mm: height.centre_mm,
                rotation_deg: height.rotation_deg,
                pitch_um: height.pitch_um,
                size: Some(size),
                phase: None,
                phase_scale: 1.0,
                amplitude: None,
                transmission: None,
                key: None,
                pixel: height.pixel,
                fill: 1.0,
                rest: Rest::Dark,
                fly_back_um: 0.0,
                crosstalk_um: 0.0,
                sub_pixels: 2,
            })
        }
        (Layer::Sum(sum), Free::TwoPhase) => blank_sum(scene, sum, path),
        _ => {
            let expected = match free {
                Free::Height => "a layer of kind \"height\" for free = \"height\"",
                Free::TwoPhase => "a layer of kind \"sum\" for free = \"two_phase\"",
                _ => "a layer of kind \"pixels\", or another `free`",
            };
            Err(scene.fault(path, "a layer of another kind", expected))
        }
    }
}

/// Pixels of known size without their arrays.
fn bare(pixels: &PixelLayer) -> Option<PixelLayer> {
    pixels.size.map(|_| PixelLayer {
        phase: None,
        amplitude: None,
        transmission: None,
        phase_scale: 1.0,
        ..pixels.clone()
    })
}

/// A sum of two layers of pixels.
fn blank_sum(scene: &Scene, sum: &SumLayer, path: &str) -> Result<PixelLayer, Fault> {
    let expected = "two terms, each one layer of pixels of one size with a file for its phase";
    let refuse = || scene.fault(path, "another sum", expected);
    let [first, second] = sum.terms.as_slice() else {
        return Err(refuse());
    };
    match (first.as_slice(), second.as_slice()) {
        ([Layer::Pixels(a)], [Layer::Pixels(b)]) => {
            for (i, pixels) in [a, b].into_iter().enumerate() {
                refuse_fringing(scene, pixels, &format!("{path}.terms[{i}][0]"))?;
            }
            let phases = [a, b].map(|p| p.amplitude.is_none() && p.transmission.is_none());
            match (bare(a), bare(b)) {
                (Some(a), Some(b)) if a == b && phases == [true; 2] => Ok(a),
                _ => Err(refuse()),
            }
        }
        _ => Err(refuse()),
    }
}
