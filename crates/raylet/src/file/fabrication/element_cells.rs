//! The cells of an element of a scene: those of a layer of pixels or heights, or an analytic phase at the centres of cells.
//! What lies outside of the aperture of the element is marked.

use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::{
    BorrowedRows, CellRows, Cells, FunctionRows, Part, part_of,
};
use crate::file::fabrication::designed_levels::designed_levels;
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, choice_fault, needed};
use crate::file::fabrication::npy_rows::npy_rows;
use crate::file::fabrication::open_part::OpenPart;
use crate::file::fabrication::relief::Relief;
use crate::file::model::build::system_with;
use crate::file::model::relief_side::side_of_relief;
use crate::file::model::scene_arrays::Arrays;
use crate::file::model::scene_media::index_at;
use crate::file::scene::element::{Coordinates, DoeElement, Element};
use crate::file::scene::layer::{HeightLayer, Layer, PixelLayer};
use crate::file::scene::scene_file::Scene;
use crate::optics::doe;
use crate::optics::phase::placement::Placement;
use crate::optics::phase::profile::Profile;
use crate::optics::pixels::active_area::ActiveArea;
use crate::optics::screen::ScreenKind;
use crate::optics::shape::Shape;
use crate::optics::surface_coordinates::SurfaceCoordinates;

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

/// Most cells along an axis of an analytic phase.
const MOST_CELLS: f64 = 1e7;

/// Most cells of an analytic phase in all: a thousand seconds of work.
const MOST_IN_ALL: f64 = 1e10;

/// An element of a scene, with its number.
#[derive(Clone, Copy)]
struct Chosen<'a> {
    scene: &'a Scene,
    number: usize,
    doe: &'a DoeElement,
    /// Number of the layer.
    layer: usize,
}

/// The cells of the element that is chosen, from arrays that are loaded, or else from their files.
///
/// # Errors
/// No such element or layer, a layer that has no cells, or an array that cannot be read.
pub(crate) fn element_cells<'a>(
    scene: &'a Scene,
    arrays: &'a Arrays<'_>,
    choices: &ExportChoices,
) -> Result<Cells<'a>, Fault> {
    let chosen = chosen(scene, choices)?;
    let layer = chosen.doe.layer.get(chosen.layer);
    let mut cells = match layer {
        Some(Layer::Pixels(pixels)) => chosen.pixels(pixels, arrays, choices)?,
        Some(Layer::Height(heights)) => chosen.heights(heights, arrays)?,
        _ => chosen.phase(arrays, choices)?,
    };
    let flat = cells.open.as_ref().filter(|open| open.along.is_none());
    cells.aperture = flat.map(|open| open.aperture.seen_from(open.placement));
    if choices.whole_grid
        && let Some(open) = cells.open.take()
        && open.closed(cells.size()) > 0
    {
        cells.losses.push(String::from(
            "the aperture of the element: the whole grid is drawn",
        ));
    }
    cells.designed = designed_levels(scene, chosen.number, chosen.layer);
    if chosen.doe.layer.len() > 1 {
        let others = chosen.doe.layer.len() - 1;
        let plural = if others == 1 { "layer" } else { "layers" };
        cells
            .losses
            .push(format!("{others} other {plural} of the element"));
    }
    Ok(cells)
}

/// The element and the layer that are chosen.
fn chosen<'a>(scene: &'a Scene, choices: &ExportChoices) -> Result<Chosen<'a>, Fault> {
    let file = scene.origin.file.as_path();
    let doe = |number: usize| match scene.element.get(number) {
        Some(Element::Doe(doe)) => Some((number, doe)),
        _ => None,
    };
    let all: Vec<_> = (0..scene.element.len()).filter_map(doe).collect();
    let names: Vec<String> = all.iter().map(|(i, _)| scene.element_name(*i)).collect();
    let known = match names.is_empty() {
        true => String::from("a scene with a diffractive element"),
        false => format!("the name of a diffractive element: {}", names.join(", ")),
    };
    let (number, doe) = match (&choices.element, all.as_slice()) {
        (Some(name), _) => {
            let found = scene.number_of(name).and_then(doe);
            found.ok_or_else(|| choice_fault(file, "element", format!("\"{name}\""), known))?
        }
        (None, [only]) => *only,
        (None, _) => {
            let found = format!("{} diffractive elements and no choice", all.len());
            return Err(choice_fault(file, "element", found, known));
        }
    };
    let count = doe.layer.len();
    let layer = match choices.layer {
        Some(layer) if layer < count => layer,
        None if count == 1 => 0,
        other => {
            let found = match other {
                Some(layer) => layer.to_string(),
                None => format!("{count} layers of the element and no choice"),
            };
            let expected = format!("a number from 0 to {}", count - 1);
            return Err(choice_fault(file, "layer", found, expected));
        }
    };
    Ok(Chosen {
        scene,
        number,
        doe,
        layer,
    })
}

impl<'a> Chosen<'a> {
    /// The path of the layer in the scene.
    fn path(&self) -> String {
        format!("element[{}].layer[{}]", self.number, self.layer)
    }

    /// Cells with these rows.
    fn cells(
        &self,
        rows: Box<dyn CellRows + 'a>,
        pitch_um: [f64; 2],
        quantity: Quantity,
    ) -> Cells<'a> {
        let relief = Relief {
            wavelength_um: self.scene.wavelength_um.first().copied(),
            ..Relief::default()
        };
        Cells {
            quantity,
            relief,
            name: self.scene.element_name(self.number),
            ..Cells::new(rows, pitch_um, &self.scene.origin.file)
        }
    }

    /// The aperture over the cells of a layer.
    fn open(
        &self,
        arrays: &Arrays<'_>,
        placement: Placement,
        pitch_um: [f64; 2],
    ) -> Result<OpenPart, Fault> {
        let path = format!("element[{}]", self.number);
        let along = match self.doe.coordinates {
            Coordinates::Projected => None,
            Coordinates::Surface => {
                let shape = arrays.shape(&self.doe.surface_shape(), &path);
                let shape = shape.ok_or_else(|| {
                    let expected = "a surface whose array can be read";
                    self.scene
                        .fault(&path, "a surface without heights", expected)
                })?;
                (shape != Shape::Plane)
                    .then(|| SurfaceCoordinates::of(&shape))
                    .flatten()
            }
        };
        Ok(OpenPart {
            aperture: self.doe.aperture.optics(),
            placement,
            along,
            pitch_mm: pitch_um.map(|um| um * UM),
        })
    }

    /// Rows of the array that a key of the layer names.
    fn rows(
        &self,
        arrays: &'a Arrays<'_>,
        (key, file, member): (&str, &Path, Option<&str>),
        (part, scale): (Part, f64),
    ) -> Result<Box<dyn CellRows + 'a>, Fault> {
        let field = format!("{}.{key}", self.path());
        if let Some(array) = arrays.get(&field) {
            return Ok(Box::new(BorrowedRows { array, part, scale }));
        }
        let place = self.scene.origin.beside(file);
        let read = npy_rows(&place, Some((key, member)), part, scale)
            .map_err(|inner| self.scene.origin.fault_of_file(&field, inner))?;
        if read.is_complex && key != "transmission" {
            return Err(self.scene.fault(&field, "a complex array", "a real array"));
        }
        Ok(read.rows)
    }

    /// A layer of pixels: its phase, or the amplitude where that is chosen.
    fn pixels(
        &self,
        layer: &'a PixelLayer,
        arrays: &'a Arrays<'_>,
        choices: &ExportChoices,
    ) -> Result<Cells<'a>, Fault> {
        let quantity = choices.quantity;
        let part = part_of(&self.scene.origin.file, quantity)?;
        let member = layer.key.as_deref();
        let (key, file, scale) = match (&layer.transmission, quantity) {
            (Some(file), _) => ("transmission", Some(file), 1.0),
            (None, Quantity::Amplitude) => ("amplitude", layer.amplitude.as_ref(), 1.0),
            (None, _) => ("phase", layer.phase.as_ref(), layer.phase_scale),
        };
        let Some(file) = file else {
            let found = format!("a layer of pixels without {key}");
            return Err(self.scene.fault(&self.path(), found, "an array of it"));
        };
        let rows = self.rows(arrays, (key, file, member), (part, scale))?;
        let mut cells = self.cells(rows, layer.pitch_um, quantity);
        cells.open = Some(self.open(arrays, layer.placement(), layer.pitch_um)?);
        cells.active = layer.active().unwrap_or(ActiveArea::WHOLE);
        let has_both = layer.transmission.is_some() || layer.amplitude.is_some();
        let lost = &mut cells.losses;
        match quantity {
            Quantity::Amplitude if layer.transmission.is_some() || layer.phase.is_some() => {
                lost.push(String::from("the phase of the pixels"));
            }
            Quantity::Phase if has_both => {
                lost.push(String::from("the amplitude of the pixels"));
            }
            _ => {}
        }
        if layer.fringing().is_some() {
            lost.push(String::from("fly-back and crosstalk"));
        }
        if !layer.placement().is_none() {
            lost.push(String::from("the place of the layer on its element"));
        }
        Ok(cells)
    }

    /// A layer of heights.
    fn heights(&self, layer: &'a HeightLayer, arrays: &'a Arrays<'_>) -> Result<Cells<'a>, Fault> {
        let named = ("height_um", layer.height_um.as_path(), layer.key.as_deref());
        let rows = self.rows(arrays, named, (Part::Phase, 1.0))?;
        let mut cells = self.cells(rows, layer.pitch_um, Quantity::Height);
        cells.open = Some(self.open(arrays, layer.placement(), layer.pitch_um)?);
        cells.relief.step = self.step(layer)?;
        if !layer.placement().is_none() {
            let lost = "the place of the layer on its element";
            cells.losses.push(String::from(lost));
        }
        Ok(cells)
    }

    /// The index of a relief less that of the medium whose place it takes, where no element before has left the ambient one.
    fn step(&self, layer: &HeightLayer) -> Result<Option<f64>, Fault> {
        let before = self.scene.element.iter().take(self.number);
        let stays = |element: &Element| match element {
            Element::Surface(surface) => surface.glass.is_none(),
            Element::Doe(doe) => doe.glass.is_none(),
            _ => true,
        };
        if !before.into_iter().all(stays) {
            return Ok(None);
        }
        let path = self.path();
        let around = index_at(self.scene, &self.scene.ambient, 0, "ambient")?;
        let behind = match &self.doe.glass {
            Some(glass) => index_at(self.scene, glass, 0, &path)?,
            None => around,
        };
        let own = index_at(self.scene, &layer.glass, 0, &format!("{path}.glass"))?;
        let side = side_of_relief(own, [around, behind], layer.stands_in);
        Ok(side.map(|side| own - side.of([around, behind])))
    }

    /// An analytic phase at the centres of cells over the aperture.
    fn phase(&self, arrays: &Arrays<'_>, choices: &ExportChoices) -> Result<Cells<'a>, Fault> {
        let file = self.scene.origin.file.as_path();
        let pitch_um = needed(
            file,
            "pitch_um",
            choices.pitch_um,
            "the cells of an analytic phase (--pitch-um)",
        )?;
        let system = system_with(self.scene, arrays, 0)?;
        let name = self.scene.element_name(self.number);
        let screen = system
            .screens
            .into_iter()
            .find(|screen| screen.name == name);
        let Some(ScreenKind::Doe(element)) = screen.map(|screen| screen.kind) else {
            return Err(choice_fault(
                file,
                "element",
                format!("\"{name}\""),
                "a diffractive element",
            ));
        };
        let made = element.layers.get(self.layer);
        let profiles = made.and_then(|made| self.profiles(made)).ok_or_else(|| {
            let found = "a layer without a phase of its own";
            let expected = "pixels, heights, an analytic phase, or a kinoform with the order 1";
            self.scene.fault(&self.path(), found, expected)
        })?;
        let Some([x0, x1, y0, y1]) = element.aperture.bounds() else {
            let path = format!("element[{}].aperture", self.number);
            let found = "an aperture without an edge";
            return Err(self.scene.fault(&path, found, "an aperture that ends"));
        };
        let pitch = pitch_um.map(|um| um * UM);
        let size = cells_within(file, [x0, x1, y0, y1], pitch)?;
        let function =
            move |x: f64, y: f64| profiles.iter().map(|profile| profile.phase(x, y)).sum();
        let rows = FunctionRows {
            size,
            pitch,
            function,
        };
        let mut cells = self.cells(Box::new(rows), pitch_um, Quantity::Phase);
        cells.open = Some(OpenPart {
            aperture: element.aperture,
            placement: Placement::NONE,
            along: None,
            pitch_mm: pitch,
        });
        cells.losses = vec![String::from("the phase between the centres of cells")];
        Ok(cells)
    }

    /// The phases of a layer, which add: of a kinoform those of its first order.
    fn profiles(&self, made: &doe::Layer) -> Option<Vec<Profile>> {
        let phase = |layer: &doe::Layer| match layer {
            doe::Layer::Phase(profile) => Some(profile.clone()),
            _ => None,
        };
        match (made, self.doe.layer.get(self.layer)) {
            (doe::Layer::Sum(terms), Some(Layer::Kinoform(kinoform))) => {
                let first = kinoform.orders.iter().position(|order| *order == 1)?;
                let (_, layers) = terms.get(first)?;
                layers.iter().map(phase).collect()
            }
            _ => phase(made).map(|profile| vec![profile]),
        }
    }
}

/// Whether the layer that is chosen is a formula, for which the whole system is needed.
///
/// # Errors
/// No such element or layer.
pub(crate) fn is_analytic(scene: &Scene, choices: &ExportChoices) -> Result<bool, Fault> {
    let chosen = chosen(scene, choices)?;
    let layer = chosen.doe.layer.get(chosen.layer);
    Ok(!matches!(layer, Some(Layer::Pixels(_) | Layer::Height(_))))
}

/// How many cells of a pitch cover a box, about the middle of the element.
///
/// # Errors
/// When they are too many.
fn cells_within(file: &Path, bounds: [f64; 4], pitch: [f64; 2]) -> Result<[usize; 2], Fault> {
    let [x0, x1, y0, y1] = bounds;
    let count = |low: f64, high: f64, pitch: f64| {
        let cells = 2.0 * high.max(-low) / pitch;
        (cells * (1.0 - 1e-12)).ceil().max(1.0)
    };
    let counts = [count(x0, x1, pitch[0]), count(y0, y1, pitch[1])];
    if let Some(many) = counts.iter().find(|count| **count > MOST_CELLS) {
        let found = format!("a pitch that makes {many} cells along an axis");
        return Err(choice_fault(file, "pitch_um", found, "at most 1e7 cells"));
    }
    let all = counts[0] * counts[1];
    if all > MOST_IN_ALL {
        let found = format!("a pitch that makes {all:.1e} cells");
        return Err(choice_fault(file, "pitch_um", found, "at most 1e10 cells"));
    }
    Ok(counts.map(|count| count as usize))
}
