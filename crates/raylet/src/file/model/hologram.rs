//! The hologram of a scene: what is given, what is designed, and where it is written.

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and screens are numbered by the system they are found in"
)]

use std::path::{Path, PathBuf};

use ndarray::Array2;
use num_complex::Complex64;

use crate::design::holograms::hologram::{HologramError, HologramTask};
use crate::design::losses::target::Target;
use crate::engine::chain::arriving_light::illuminate;
use crate::engine::chain::simulate::simulate;
use crate::engine::plan::settings::Settings;
use crate::file::arrays::array::BorrowedArray;
use crate::file::arrays::image::{ImageError, read_gray};
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::phase_file::PhaseFile;
use crate::file::decode::fault::Fault;
use crate::file::model::build;
use crate::file::model::error_location::simulate_fault;
use crate::file::model::fringed_pixels::refuse_fringing;
use crate::file::scene::element::{Element, WITH_PIXELS};
use crate::file::scene::layer::{Layer, PixelLayer};
use crate::file::scene::scene_file::Scene;
use crate::file::scene::settings::Hologram;
use crate::optics::paraxial::Abcd;
use crate::optics::screen::{Screen, ScreenKind, Sensor};
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::sampling::apply_screen;

/// A hologram to be computed for an element of a scene.
#[derive(Clone, Debug)]
pub struct HologramDesign {
    /// The task of the search.
    pub task: HologramTask,
    /// The file that the scene names for the phase, if it does.
    pub file: Option<PathBuf>,
    /// The field of the scene that names it, such as `element[0].layer[0].phase`.
    pub field: String,
    /// Factor on the phases of the file when the scene is read.
    pub phase_scale: f64,
    /// The element's path in the scene, such as `element[0]`.
    element: String,
}

/// The task of the `[hologram]` of a scene without its arrays, at the first wavelength; the phase file
/// need not exist. With `naive`, or `principal_planes = false`, the lenses between element and sensor are
/// one thin lens at the first vertex.
///
/// # Errors
/// No `[hologram]`, a pixel layer of unknown size, a picture or array that cannot be read, elements
/// between hologram and sensor that are neither lens nor mirror, or a train that is not centred.
pub fn commission(scene: &Scene, naive: bool) -> Result<HologramDesign, Fault> {
    let hologram = hologram_of(scene)?;
    let (blank, place) = blanked(scene, hologram)?;
    let blank = blank.load()?;
    let system = build::system(&blank, 0)?;
    let (at, hop, sensor) = last_hop(scene, hologram, &system)?;

    let element = format!("element[{}]", place.element);
    if !hop.from.is_plane() {
        let expected = "a plane element: holograms are designed on the paraxial train";
        return Err(scene.fault(&element, "a curved element", expected));
    }
    let train = match naive || !hologram.principal_planes {
        true => Abcd::between_as_thin_lens(&hop),
        false => Abcd::between(&hop),
    };
    let train = train.map_err(|error| {
        let expected = "a centred train behind the hologram's element";
        scene.fault(&element, error.to_string(), expected)
    })?;
    let pitch = place.layer.pitch_um.map(|pitch| pitch * 1e-3);
    let file = place.layer.phase.as_ref();
    Ok(HologramDesign {
        task: HologramTask {
            wavelength: system.wavelength,
            train,
            pitch,
            incident: incident(&blank, &system, at, pitch)?,
            target: target(scene, hologram)?,
            sensor: [0, 1].map(|a| sensor.pixels[a] as f64 * sensor.pitch[a]),
            iterations: hologram.iterations,
            efficiency: hologram.efficiency_goal.unwrap_or(0.0),
        },
        file: file.map(|file| scene.origin.beside(file)),
        field: format!("{element}.layer[{}].phase", place.number),
        phase_scale: place.layer.phase_scale,
        element,
    })
}

/// What the scene says about its hologram.
///
/// # Errors
/// No `[hologram]`.
pub(crate) fn hologram_of(scene: &Scene) -> Result<&Hologram, Fault> {
    scene.hologram.as_ref().ok_or_else(|| {
        let expected = "a table [hologram] with target, element and size_mm";
        scene.fault("hologram", "no hologram", expected)
    })
}

/// The number of the element's screen, which must be the last before the sensor, and the hop to that.
fn last_hop<'s>(
    scene: &Scene,
    hologram: &Hologram,
    system: &'s System,
) -> Result<(usize, Hop<'s>, &'s Sensor), Fault> {
    let hop = system.hops().last();
    let at = system.screens.len().saturating_sub(2);
    match hop.map(|hop| (hop, &hop.to.kind)) {
        Some((hop, ScreenKind::Sensor(sensor))) if hop.from.name == hologram.element => {
            Ok((at, hop, sensor))
        }
        _ => Err(scene.fault(
            "hologram.element",
            "an element with others than lenses and mirrors between it and the sensor",
            "the last diffractive element, with no stop behind it",
        )),
    }
}

impl HologramDesign {
    /// The fault of a scene whose hologram cannot be designed.
    pub fn fault(&self, scene: &Scene, error: &HologramError) -> Fault {
        let (path, expected) = match error {
            HologramError::Collins(_) => (&*self.element, "a sensor that is not in an image of it"),
            HologramError::NotFinite => (
                &*self.element,
                "sizes and distances that lie less far apart",
            ),
            HologramError::Cancelled(_) => ("hologram", "a search to its end"),
            HologramError::Dark => (&*self.element, "an aperture that light reaches"),
            HologramError::Black => ("hologram.target", "a picture that is not all black"),
            HologramError::Outside { .. } => ("hologram.size_mm", "at most the sensor's size"),
            HologramError::TooWide { .. } => {
                ("hologram.size_mm", "a smaller picture, or finer pixels")
            }
        };
        scene.fault(path, error.to_string(), expected)
    }

    /// Writes phases in radians as the scene will read them: divided by `phase_scale`.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn write(&self, phase: &Array2<f64>, file: &PhaseFile) -> Result<(), Fault> {
        file.write(&(phase / self.phase_scale))
    }
}

/// Where the hologram goes: the numbers of the element and of its pixel layer, and that as the scene has it.
pub(crate) struct HologramLayer {
    pub(crate) element: usize,
    pub(crate) number: usize,
    pub(crate) layer: PixelLayer,
}

/// The scene with the hologram's layer made blank, so that its phase file need not exist.
pub(crate) fn blanked(scene: &Scene, hologram: &Hologram) -> Result<(Scene, HologramLayer), Fault> {
    let mut blank = scene.clone();
    let named = scene.number_of(&hologram.element);
    let named = named.and_then(|number| Some((number, blank.element.get_mut(number)?)));
    if let Some((element, Element::Doe(doe))) = named {
        for (number, layer) in doe.layer.iter_mut().enumerate() {
            let Layer::Pixels(pixels) = layer else {
                continue;
            };
            refuse_fringing(
                scene,
                pixels,
                &format!("element[{element}].layer[{number}]"),
            )?;
            if !pixels.placement().is_none() {
                let path = format!("element[{element}].layer[{number}]");
                let found = "a hologram in pixels that are off centre, or turned, on their element";
                let expected = "centre_mm = [0, 0] and rotation_deg = 0; decenter_mm and tilt_deg move the element as a whole";
                return Err(scene.fault(&path, found, expected));
            }
            let layer = pixels.clone();
            pixels.phase = None;
            if pixels.transmission.is_some()
                || (pixels.size.is_none() && pixels.amplitude.is_none())
            {
                let path = format!("element[{element}].layer[{number}]");
                let found = "a layer for a hologram without its size";
                let expected = "size = [nx, ny] and phase = \"FILE.npy\"";
                return Err(scene.fault(&path, found, expected));
            }
            let place = HologramLayer {
                element,
                number,
                layer,
            };
            return Ok((blank, place));
        }
    }
    Err(scene.fault("hologram.element", hologram.element.as_str(), WITH_PIXELS))
}

/// The target picture, inverted and mirrored as the scene asks, with its width and height in mm.
pub(crate) fn target(scene: &Scene, hologram: &Hologram) -> Result<Target, Fault> {
    let mut image = picture_of(scene, &hologram.target, "hologram.target")?;
    if hologram.invert {
        image.mapv_inplace(|value| 1.0 - value);
    }
    if hologram.flip_x {
        image.invert_axis(ndarray::Axis(1));
    }
    if hologram.flip_y {
        image.invert_axis(ndarray::Axis(0));
    }
    Ok(Target {
        image: image.as_standard_layout().into_owned(),
        size: hologram.size_mm,
        blur: [0.0; 2],
    })
}

/// The picture that the scene names at a place, grey, [y, x] with y upwards.
pub(crate) fn picture_of(scene: &Scene, file: &Path, at: &str) -> Result<Array2<f64>, Fault> {
    if let Some(look) = scene.arrays.get(at) {
        return match look {
            BorrowedArray::Real(values) if values.iter().all(|value| *value >= 0.0) => {
                Ok(values.to_owned())
            }
            _ => Err(scene.fault(at, "negative or complex values", "a picture: values from 0")),
        };
    }
    let file = scene.origin.beside(file);
    let refuse = |found: String| scene.fault(at, found, "a PNG picture beside the scene");
    let limit = MemoryLimit::of_settings(scene.memory_limit());
    read_gray(&file, limit).map_err(|error| match error {
        ImageError::Memory {
            found, expected, ..
        } => scene.fault(at, found, expected),
        other => refuse(other.to_string()),
    })
}

/// The field at the pixel centres of the blank element, behind it.
fn incident(
    scene: &Scene,
    system: &System,
    at: usize,
    pitch: [f64; 2],
) -> Result<Array2<Complex64>, Fault> {
    let screen = &system.screens[at];
    let pixels = match &screen.kind {
        ScreenKind::Doe(doe) => doe.pixels().map(|pixels| pixels.values.dim()),
        _ => None,
    };
    let (ny, nx) = pixels.unwrap_or((1, 1));
    let grid = Grid {
        x: Axis::uniform(nx, pitch[0], 0.0),
        y: Axis::uniform(ny, pitch[1], 0.0),
    };
    let mut field = match at {
        0 => illuminate(system, grid),
        _ => arriving(scene, system, at, grid)?,
    };
    apply_screen(screen, &mut field);
    Ok(field.values)
}

/// The field that arrives at a later screen: that of the system which ends in a sensor there.
fn arriving(scene: &Scene, system: &System, at: usize, grid: Grid) -> Result<Field, Fault> {
    let mut cut = system.clone();
    cut.screens.truncate(at + 1);
    cut.trains.truncate(at);
    cut.screens[at] = Screen {
        kind: ScreenKind::Sensor(Sensor {
            pixels: [grid.x.cells, grid.y.cells],
            pitch: [grid.x.pitch, grid.y.pitch],
        }),
        ..system.screens[at].clone()
    };
    let settings: Settings = build::settings(scene);
    let outcome = simulate(&cut, &settings, &|_| {})
        .map_err(|error| simulate_fault(scene, &cut, &settings, &error))?;
    Ok(outcome.field)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use ndarray::{Array2, array};

    use crate::file::arrays::array::Array;
    use crate::file::arrays::image::write_gray16;
    use crate::file::arrays::phase_file::PhaseFile;
    use crate::file::decode::fault::Fault;
    use crate::file::model::hologram::{HologramDesign, commission};
    use crate::file::scene::scene_file::Scene;
    use crate::file::storage::own_file::Replace;

    const SCENE: &str = r#"version = 1
wavelength_um = 0.7
source = { kind = "plane" }
[[element]]
kind = "doe"
name = "slm"
thickness_mm = 3.0
aperture = { disc = { radius_mm = 0.05 } }
[[element.layer]]
kind = "pixels"
pitch_um = 10
size = [12, 8]
phase = "phase.npy"
phase_scale = 2
[[element]]
kind = "lens"
thickness_mm = 40
[[element.surface]]
radius_mm = 25.8
thickness_mm = 5.3
glass = "N-BK7"
semi_aperture_mm = 12.7
[[element.surface]]
semi_aperture_mm = 12.7
[[element]]
kind = "sensor"
pixels = [40, 30]
pitch_um = 20
[hologram]
target = "picture.png"
element = "slm"
size_mm = [0.4, 0.2]
"#;

    /// The commission of a scene, altered in one passage; the picture has a bright lower left corner.
    fn altered(from: &str, to: &str) -> Result<HologramDesign, Fault> {
        assert!(SCENE.contains(from), "{from}");
        let room = tempfile::tempdir().unwrap();
        let picture = array![[1.0, 0.0], [0.2, 0.0]];
        let file = room.path().join("picture.png");
        write_gray16(file, picture.view(), [0.0, 1.0]).unwrap();
        let path = room.path().join("scene.toml");
        fs::write(&path, SCENE.replacen(from, to, 1)).unwrap();
        commission(&Scene::open(&path).unwrap(), false)
    }

    fn picture(extra: &str) -> Array2<f64> {
        let line = format!("element = \"slm\"\n{extra}");
        let image = altered("element = \"slm\"", &line)
            .unwrap()
            .task
            .target
            .image;
        image.mapv(|value| (value * 10.0).round() / 10.0)
    }

    #[test]
    fn pictures_stand_upright_unless_turned() {
        assert_eq!(picture(""), array![[1.0, 0.0], [0.2, 0.0]]);
        assert_eq!(picture("flip_x = true"), array![[0.0, 1.0], [0.0, 0.2]]);
        assert_eq!(picture("flip_y = true"), array![[0.2, 0.0], [1.0, 0.0]]);
        assert_eq!(picture("invert = true"), array![[0.0, 1.0], [0.8, 1.0]]);
    }

    #[test]
    fn light_and_train_are_the_scenes() {
        let commission = altered("", "").unwrap();
        let task = &commission.task;
        assert_eq!(task.incident.dim(), (8, 12));
        assert!(
            task.sensor
                .iter()
                .zip([0.8, 0.6])
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        // The disc of 0.05 mm reaches the fourth pixel from the middle and not the sixth.
        let amplitude = |i: usize| task.incident[[4, i]].norm();
        assert!(amplitude(6 + 3) == 1.0 && amplitude(6 + 5) == 0.0);
        // 3 mm, a face of this power, 5.3 mm of glass of index n, 40 mm: their ray matrices multiplied.
        let (plain, n) = (task.train, 1.513_063_997_196);
        let (power, behind) = ((n - 1.0) / 25.8, 5.3 / n + 40.0);
        assert!((plain.a - (1.0 - power * behind)).abs() < 1e-9);
        assert!((plain.b - (3.0 + (1.0 - 3.0 * power) * behind)).abs() < 1e-9);
        let thin = altered(
            "element = \"slm\"",
            "element = \"slm\"\nprincipal_planes = false",
        );
        assert!((thin.unwrap().task.train.a - plain.a).abs() > 0.02);
    }

    #[test]
    fn later_elements_take_the_light_that_arrives_slow() {
        // The same element behind a stop: half the disc is dark, the rest is lit as diffraction has it.
        let before = "[[element]]\nkind = \"stop\"\nthickness_mm = 0.1\n\
            aperture = { disc = { radius_mm = 0.03 } }\n[[element]]\nkind = \"doe\"";
        let task = altered("[[element]]\nkind = \"doe\"", before).unwrap().task;
        assert_eq!(task.incident.dim(), (8, 12));
        let amplitude = |i: usize| task.incident[[4, i]].norm();
        assert!(amplitude(6) > 0.5 && amplitude(6 + 4) < 0.3 * amplitude(6));
    }

    #[test]
    fn what_is_missing_is_reported_at_its_place() {
        let lens = "[[element]]\nkind = \"lens\"";
        let stop = "[[element]]\nkind = \"stop\"\nthickness_mm = 1\n\
            aperture = { disc = { radius_mm = 1 } }\n[[element]]\nkind = \"lens\"";
        for (from, to, parts) in [
            (
                "size = [12, 8]\n",
                "",
                ["element[0].layer[0]", "size = [nx, ny]"],
            ),
            ("picture.png", "none.png", ["hologram.target", "none.png"]),
            (lens, stop, ["hologram.element", "no stop behind it"]),
            (
                "thickness_mm = 40",
                "thickness_mm = 40\ntilt_deg = [1, 0, 0]",
                ["element[0]", "surface 1 is tilted"],
            ),
        ] {
            let fault = altered(from, to).unwrap_err().to_string();
            assert!(parts.iter().all(|part| fault.contains(part)), "{fault}");
        }
        let bare = SCENE.split("[hologram]").next().unwrap();
        let scene = Scene::parse(bare, Path::new("scene.toml")).unwrap();
        let fault = commission(&scene, false).unwrap_err().to_string();
        assert!(fault.contains("no hologram"), "{fault}");
    }

    #[test]
    fn phases_are_written_as_they_will_be_read() {
        let commission = altered("", "").unwrap();
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("phase.npy");
        for phase in [array![[1.0, -2.0]], array![[0.5], [3.0]]] {
            let claimed = PhaseFile::claim(&file, Replace::Own).unwrap();
            commission.write(&phase, &claimed).unwrap();
            let read = Array::read(&file, None, "phase", 1000).unwrap();
            assert_eq!(read, Array::Real(phase / 2.0));
        }
        // The array and its record.
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 2);
    }
}
