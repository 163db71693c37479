//! From the file of a program for lens design to a scene, with a report of what was changed and left out.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ndarray::Array2;

use crate::engine::geometrical::chief_ray::{chief_entry, chief_landing};
use crate::file::arrays::regular_file;
use crate::file::decode::fault::{Fault, shortened};
use crate::file::model::build::system;
use crate::file::prescription::archive::zar_archive::READABLE;
use crate::file::prescription::archive::zar_lens::archived_lens;
use crate::file::prescription::codev::codev_reader::read_codev;
use crate::file::prescription::first_order::FirstOrder;
use crate::file::prescription::glasses::glass_choice::{GlassSources, MediumBehind, media};
use crate::file::prescription::glasses::glass_file::GlassFiles;
use crate::file::prescription::import_report::{ImportReport, Losses, ReportedNumber};
use crate::file::prescription::imported_grids::{
    ImportedArray, grids_of, named_arrays, with_arrays,
};
use crate::file::prescription::lens_file::bytes_of;
use crate::file::prescription::lens_table::read_table;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::rim_sizes::{ATTEMPTS, Fields};
use crate::file::prescription::scene_elements::{Elements, Laying};
use crate::file::prescription::scene_light::{Light, assembled, centre_aperture, shift_sensor};
use crate::file::prescription::sequential::{ApertureRule, Behind, FieldKind, Sequential};
use crate::file::prescription::zemax::zemax_reader::read_zemax;
use crate::file::scene::element::Element;
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::optics::paraxial::Cardinal;

/// What the user chooses of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportChoices {
    /// The number of the field whose light the scene has, from 1.
    pub field: usize,
    /// The number of the wavelength, from 1; the primary one by default.
    pub wavelength: Option<usize>,
    /// The number of the configuration or zoom position, from 1; the one whose values the file has by default.
    pub configuration: Option<usize>,
    /// Whether what is not known is left out, and surfaces of unknown types become planes.
    pub skip_unknown: bool,
    /// Glasses of the catalogue in place of those that the file names.
    pub glasses: BTreeMap<String, String>,
    /// Catalogues of glasses (.agf) in which names are sought first.
    pub glass_files: Vec<PathBuf>,
}

impl Default for ImportChoices {
    fn default() -> Self {
        Self {
            field: 1,
            wavelength: None,
            configuration: None,
            skip_unknown: false,
            glasses: BTreeMap::new(),
            glass_files: Vec::new(),
        }
    }
}

/// A scene from the file of another program.
#[derive(Clone, Debug)]
pub struct ImportedLens {
    /// The scene.
    pub scene: Scene,
    /// What was read, changed and left out.
    pub report: ImportReport,
    /// Position of the scene's first element behind the first surface of the file in mm.
    pub first_element_mm: f64,
    /// Arrays that the scene names, which belong beside it.
    pub arrays: Vec<ImportedArray>,
}

/// A kind of lens file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// A file of Zemax or OpticStudio.
    Zemax,
    /// A file of CODE V.
    CodeV,
    /// A table of surfaces.
    Table,
    /// An archive of OpticStudio with a file of Zemax.
    Archive,
}

impl Format {
    /// The kind of a file by the end of its name.
    fn of(path: &Path) -> Result<Self, Fault> {
        let end = path.extension().unwrap_or_default().to_string_lossy();
        match end.to_ascii_lowercase().as_str() {
            "zmx" => Ok(Self::Zemax),
            "seq" => Ok(Self::CodeV),
            "csv" => Ok(Self::Table),
            "zar" => Ok(Self::Archive),
            _ => {
                let found = format!("a file that ends with .{}", shortened(&end));
                Err(Fault::of_file(path, found, KINDS))
            }
        }
    }
}

/// How the names of lens files of other programs end.
pub(crate) const LENS_ENDS: [&str; 3] = ["zmx", "zar", "seq"];

/// The lens files that are read, in words.
const KINDS: &str =
    "a lens file of OpticStudio (.zmx, .zar) or CODE V (.seq), or a table of surfaces (.csv)";

/// Reads a lens file of Zemax (.zmx, or .zar with its glasses) or CODE V (.seq), or a table of surfaces (.csv).
///
/// # Errors
/// A file that cannot be read, or the first fault of its text with its line.
pub fn import_lens(path: &Path, choices: &ImportChoices) -> Result<ImportedLens, Fault> {
    if Format::of(path)? == Format::Archive {
        let file = regular_file::open(path);
        let file = file.map_err(|found| Fault::of_file(path, found, READABLE))?;
        return import_archive(file, path, choices);
    }
    let bytes = bytes_of(path, "a readable lens file")?;
    import_bytes(&bytes, path, choices)
}

/// [`import_lens`] of bytes that are in memory; faults name them as `path`.
///
/// # Errors
/// The first fault of the text, with its line.
pub fn import_bytes(
    bytes: &[u8],
    path: &Path,
    choices: &ImportChoices,
) -> Result<ImportedLens, Fault> {
    match Format::of(path)? {
        Format::Archive => import_archive(Cursor::new(bytes), path, choices),
        format => import_text(&LensText::new(bytes, path), format, &[], choices),
    }
}

/// The lens of an archive, with glasses of the archive's own catalogues.
fn import_archive(
    source: impl Read + Seek,
    path: &Path,
    choices: &ImportChoices,
) -> Result<ImportedLens, Fault> {
    let archived = archived_lens(source, path)?;
    let (name, bytes) = &archived.lens;
    let text = LensText::new(bytes, name);
    let mut lens = import_text(&text, Format::Zemax, &archived.catalogues, choices)?;
    let report = &mut lens.report;
    report.read.insert(0, archived.read_sentence(path));
    report.left_out.extend(archived.unused_sentence());
    Ok(lens)
}

/// The lens of a text, with glasses sought in archived catalogues after those of the user.
fn import_text(
    text: &LensText,
    format: Format,
    archived: &[(PathBuf, Vec<u8>)],
    choices: &ImportChoices,
) -> Result<ImportedLens, Fault> {
    let mut losses = Losses::default();
    let opened = OpenedLens::of(text, format, archived, choices, &mut losses)?;
    let import = Import {
        lens: &opened.lens,
        text,
        media: &opened.media,
        first: &opened.first,
        chosen: opened.chosen,
        grids: grids_of(&opened.lens.surface),
    };
    let (scene, first_element_mm) = import.scene(&mut losses)?;
    let report = import.report(&scene, losses);
    let arrays = named_arrays(&scene, &import.grids);
    Ok(ImportedLens {
        scene,
        report,
        first_element_mm,
        arrays,
    })
}

/// A lens file as it is read, before it becomes a scene.
pub(crate) struct OpenedLens {
    /// Its prescription.
    pub lens: Sequential,
    /// The media behind its surfaces.
    pub media: Vec<MediumBehind>,
    /// Its first-order data at the chosen wavelength.
    pub first: FirstOrder,
    chosen: Chosen,
}

impl OpenedLens {
    /// The lens of a text in a format, with glasses sought in archived catalogues after those of the user.
    ///
    /// # Errors
    /// The first fault of the text, with its line.
    fn of(
        text: &LensText,
        format: Format,
        archived: &[(PathBuf, Vec<u8>)],
        choices: &ImportChoices,
        losses: &mut Losses,
    ) -> Result<Self, Fault> {
        let read = match format {
            Format::Zemax | Format::Archive => read_zemax,
            Format::CodeV => read_codev,
            Format::Table => read_table,
        };
        let lens = read(text, choices.skip_unknown, choices.configuration, losses)?;
        let files = GlassFiles::read(&choices.glass_files)?;
        let files = files.followed_by(archived, &lens.catalogues)?;
        let sources = GlassSources {
            replaced: &choices.glasses,
            files: &files,
        };
        let lens = focused(lens, text, sources)?;
        let chosen = Chosen::of(&lens, text, choices)?;
        let wavelength = chosen.wavelength_um * 1e-3;
        let media = media(&lens, text, wavelength, sources, losses)?;
        let first = first_order(&lens, text, &media, wavelength)?;
        Ok(Self {
            lens,
            media,
            first,
            chosen,
        })
    }

    /// What `see` finds in the lens of a file and its text.
    ///
    /// # Errors
    /// The first fault of the file.
    pub(crate) fn seen<T>(
        bytes: &[u8],
        path: &Path,
        see: impl FnOnce(&LensText, &Self) -> T,
    ) -> Result<T, Fault> {
        let (choices, losses) = (ImportChoices::default(), &mut Losses::default());
        let format = Format::of(path)?;
        if format != Format::Archive {
            let text = LensText::new(bytes, path);
            return Ok(see(&text, &Self::of(&text, format, &[], &choices, losses)?));
        }
        let archived = archived_lens(Cursor::new(bytes), path)?;
        let (name, bytes) = &archived.lens;
        let text = LensText::new(bytes, name);
        let opened = Self::of(&text, Format::Zemax, &archived.catalogues, &choices, losses)?;
        Ok(see(&text, &opened))
    }

    /// The chosen wavelength in µm.
    pub(crate) fn wavelength_um(&self) -> f64 {
        self.chosen.wavelength_um
    }
}

/// First-order data at a wavelength in mm.
fn first_order(
    lens: &Sequential,
    text: &LensText,
    media: &[MediumBehind],
    wavelength: f64,
) -> Result<FirstOrder, Fault> {
    FirstOrder::of(lens, media, wavelength).map_err(|error| {
        let expected = "a lens whose stop light from its object can fill";
        text.fault_of_file(error.0, expected)
    })
}

/// The lens with the image at its paraxial place at the primary wavelength, where the file wants that.
fn focused(
    mut lens: Sequential,
    text: &LensText,
    sources: GlassSources<'_>,
) -> Result<Sequential, Fault> {
    let (Some(last), Some(um)) = (lens.focused, lens.wavelength_um.get(lens.primary)) else {
        return Ok(lens);
    };
    let wavelength = um * 1e-3;
    let media = media(&lens, text, wavelength, sources, &mut Losses::default())?;
    let first = first_order(&lens, text, &media, wavelength)?;
    let through = lens.surface.get(..=last).unwrap_or_default();
    let mirrors = through
        .iter()
        .filter(|face| face.behind == Behind::Reflected);
    let index = media.get(last).map_or(1.0, |medium| medium.index);
    let distance = first.crossing(last, index, mirrors.count());
    match (distance, lens.surface.get_mut(last)) {
        (Some(distance), Some(face)) => face.thickness_mm += distance,
        _ => return Err(text.fault_of_file("a paraxial image infinitely far", "a finite one")),
    }
    Ok(lens)
}

/// How many there are of something, in words.
fn counted(count: usize, what: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{count} {what}{end}")
}

/// The field and wavelength that the scene has.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    number: usize,
    field: [f64; 2],
    wavelength_um: f64,
}

impl Chosen {
    fn of(lens: &Sequential, text: &LensText, choices: &ImportChoices) -> Result<Self, Fault> {
        let pick = |what: &str, number: usize, count: usize| {
            text.fault_of_file(
                format!("{}, and {what} {number} requested", counted(count, what)),
                format!("a {what} from 1 to {count}"),
            )
        };
        let field = choices.field.checked_sub(1).and_then(|i| lens.field.get(i));
        let wave = choices.wavelength.unwrap_or(lens.primary + 1);
        let um = wave.checked_sub(1).and_then(|i| lens.wavelength_um.get(i));
        Ok(Self {
            number: choices.field,
            field: *field.ok_or_else(|| pick("field", choices.field, lens.field.len()))?,
            wavelength_um: *um.ok_or_else(|| pick("wavelength", wave, lens.wavelength_um.len()))?,
        })
    }
}

/// What a scene is made of.
struct Import<'a> {
    lens: &'a Sequential,
    text: &'a LensText,
    media: &'a [MediumBehind],
    first: &'a FirstOrder,
    chosen: Chosen,
    grids: BTreeMap<PathBuf, Arc<Array2<f64>>>,
}

impl Import<'_> {
    /// The scene, its sensor under the chief ray, and where its first element stands.
    fn scene(&self, losses: &mut Losses) -> Result<(Scene, f64), Fault> {
        let (mut scene, lines, start) = self.checked_scene(losses)?;
        let built =
            |scene: &Scene| system(scene, 0).map_err(|fault| self.addressed(&fault, &lines));
        let mut made = built(&scene)?;
        if centre_aperture(&mut scene, chief_entry(&made), losses) {
            made = built(&scene)?;
        }
        let shift = match chief_landing(&made) {
            Some(landing) => landing.at,
            None => {
                let slopes = self.first.field_slopes(self.lens, self.chosen.field);
                losses.warn(
                    "No chief ray reaches the image: the sensor stands where the paraxial one does.",
                );
                slopes.map(|slope| slope * self.first.image_height)
            }
        };
        // Traced rays leave 1e-20 mm where the chief ray is the axis; zero is added, so that no zero has a sign.
        let shifted = shift_sensor(scene, shift.map(|at| (at * 1e9).round() / 1e9 + 0.0));
        let scene = self.parsed(&shifted);
        let scene = scene.map_err(|fault| self.addressed(&fault, &lines))?;
        Ok((scene, start))
    }

    /// The scene with rims as wide as surfaces allow, the line of each element, and where the first one stands.
    fn checked_scene(&self, losses: &mut Losses) -> Result<(Scene, Vec<usize>, f64), Fault> {
        let slopes = self.first.field_slopes(self.lens, self.chosen.field);
        let fields = self.lens.field.iter();
        let steep = fields.map(|field| {
            let [x, y] = self.first.field_slopes(self.lens, *field);
            x.hypot(y)
        });
        let steepest = steep.fold(0.0, f64::max);
        let mut fault = None;
        for rims in ATTEMPTS {
            let mut own = losses.clone();
            let laying = Laying {
                lens: self.lens,
                media: self.media,
                first: self.first,
                slopes,
                steepest: match rims.fields {
                    Fields::All => steepest,
                    Fields::Chosen => slopes[0].hypot(slopes[1]),
                    Fields::Axis => 0.0,
                },
                rims,
            };
            let Elements {
                element,
                line,
                start,
            } = laying.elements(self.text, &mut own)?;
            let light = self.light(slopes, start)?;
            let scene = assembled(self.lens, self.first, self.ambient(), light, element);
            match self.parsed(&scene) {
                Ok(scene) => {
                    *losses = own;
                    return Ok((scene, line, start));
                }
                // What the first attempt finds says most.
                Err(found) => fault = fault.or_else(|| Some(self.addressed(&found, &line))),
            }
        }
        Err(fault.unwrap_or_else(|| self.text.fault_of_file("no scene", "a lens")))
    }

    /// The medium of the object; none for air.
    fn ambient(&self) -> Option<&Material> {
        self.media
            .first()
            .and_then(|medium| medium.material.as_ref())
    }

    /// The light of the chosen field.
    fn light(&self, slopes: [f64; 2], start: f64) -> Result<Light, Fault> {
        let distance = self.lens.object_distance();
        if self.lens.field_kind == FieldKind::ObjectHeight && distance.is_none() {
            let expected = "fields by angles, for an object that is infinitely far";
            return Err(self
                .text
                .fault_of_file("fields by heights of the object", expected));
        }
        if !slopes.iter().all(|slope| slope.abs() < 1e6) {
            let found = format!("field {} at a right angle", self.chosen.number);
            return Err(self.text.fault_of_file(found, "a field before the lens"));
        }
        Ok(Light {
            slopes,
            object_mm: distance.map(|distance| {
                let pupil = distance + self.first.pupil_position;
                let [x, y] = slopes.map(|slope| -slope * pupil);
                [x, y, -distance - start]
            }),
            wavelength_um: self.chosen.wavelength_um,
        })
    }

    /// A scene as its text says it, with its arrays, checked.
    fn parsed(&self, scene: &Scene) -> Result<Scene, Fault> {
        let scene = Scene::parse(&scene.to_toml()?, Path::new(""))?;
        let arrays = named_arrays(&scene, &self.grids);
        with_arrays(scene, &arrays)
    }

    /// A fault of the scene at the line of the file that its element comes from.
    fn addressed(&self, fault: &Fault, lines: &[usize]) -> Fault {
        let path = fault.address.path.as_str();
        let number = path
            .strip_prefix("element[")
            .and_then(|rest| rest.split_once(']'));
        let line = number.and_then(|(number, _)| lines.get(number.parse::<usize>().ok()?));
        let key = path.rsplit('.').next().unwrap_or(path);
        let found = format!("in the scene {key}: {}", fault.found);
        match line {
            Some(line) => self
                .text
                .fault_of_line(*line, found, fault.expected.clone()),
            None => self.text.fault_of_file(found, fault.expected.clone()),
        }
    }

    fn report(&self, scene: &Scene, losses: Losses) -> ImportReport {
        let mut report = ImportReport {
            read: self.sentences(scene),
            numbers: self.numbers(scene),
            warnings: losses.warnings,
            changed: losses.changed,
            left_out: losses.left_out,
        };
        let (fields, waves) = (self.lens.field.len(), self.lens.wavelength_um.len());
        if fields > 1 {
            let text = format!(
                "The rest of the {fields} fields (--field N takes one), and their weights."
            );
            report.left_out.push(text);
        }
        if waves > 1 {
            let text = format!(
                "The rest of the {waves} wavelengths (--wavelength N takes one), and their weights."
            );
            report.left_out.push(text);
        }
        report.left_out.push(
            "Polarisation, absorption in glass, apodisation, merit functions and temperatures other than that of the catalogue."
                .to_owned(),
        );
        report
    }

    /// What was read, and what the scene has of it.
    fn sentences(&self, scene: &Scene) -> Vec<String> {
        let (fields, waves) = (self.lens.field.len(), self.lens.wavelength_um.len());
        let [x, y] = self.chosen.field;
        let unit = match self.lens.field_kind {
            FieldKind::Angle => "°",
            _ => " mm",
        };
        let sensor = match scene.element.last() {
            Some(Element::Sensor(sensor)) => format!(
                "The sensor of {} × {} pixels stands at the image, its middle under the chief ray; its pitch of {:.4} µm is a \
                 quarter of the wavelength times the working f-number.",
                sensor.pixels[0], sensor.pixels[1], sensor.pitch_um[0]
            ),
            _ => String::new(),
        };
        vec![
            format!(
                "Read {}: {} surfaces with object and image, {}, {}.",
                self.text.file_name(),
                self.lens.surface.len(),
                counted(fields, "field"),
                counted(waves, "wavelength")
            ),
            format!(
                "The scene has field {} at ({x}, {y}){unit} and the wavelength {} µm.",
                self.chosen.number, self.chosen.wavelength_um
            ),
            sensor,
        ]
    }

    /// First-order data, those of the scene's system where it is centred.
    fn numbers(&self, scene: &Scene) -> Vec<ReportedNumber> {
        let cardinal = system(scene, 0)
            .ok()
            .and_then(|made| Cardinal::of_system(&made).ok()?);
        let first = self.first;
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let stated = |wanted: fn(ApertureRule) -> Option<f64>| wanted(self.lens.aperture);
        let line = |name: &str, value: Option<f64>, stated: Option<f64>| ReportedNumber {
            name: name.to_owned(),
            value,
            stated,
        };
        let focal_length = cardinal.as_ref().map(Cardinal::focal_length);
        vec![
            line("focal length (mm)", focal_length.and_then(finite), None),
            line(
                "back focal distance (mm)",
                cardinal.map(|one| one.back_focus()).and_then(finite),
                None,
            ),
            line(
                "focal length, axis unfolded (mm)",
                finite(first.focal_length),
                None,
            ),
            line(
                "entrance pupil diameter (mm)",
                finite(first.pupil_diameter),
                stated(|rule| match rule {
                    ApertureRule::EntrancePupil(width) => Some(width),
                    _ => None,
                }),
            ),
            line(
                "entrance pupil position (mm)",
                finite(first.pupil_position),
                None,
            ),
            line("stop radius (mm)", finite(first.stop_radius), None),
            line(
                "image-space f-number",
                finite(first.focal_length.abs() / first.pupil_diameter),
                stated(|rule| match rule {
                    ApertureRule::ImageFNumber(number) => Some(number),
                    _ => None,
                }),
            ),
            line(
                "working f-number",
                finite(first.working_f_number()),
                stated(|rule| match rule {
                    ApertureRule::WorkingFNumber(number) => Some(number),
                    _ => None,
                }),
            ),
        ]
    }
}
