//! A scene as a lens file of another program, with a report of what was changed and left out.

use std::path::Path;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::export::codev_writer::{codev_holds, codev_text};
use crate::file::prescription::export::laying_surfaces::SKIP;
use crate::file::prescription::export::outgoing::Outgoing;
use crate::file::prescription::export::zemax_writer::{zemax_holds, zemax_text};
use crate::file::prescription::first_order::FirstOrder;
use crate::file::prescription::import::{ImportChoices, import_lens};
use crate::file::prescription::import_report::{ImportReport, Losses, ReportedNumber};
use crate::file::scene::scene_file::Scene;
use crate::file::storage::own_file::{OwnFile, Replace};

/// What the user chooses of a lens file that is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LensExportChoices {
    /// Whether what the file cannot hold is left out.
    pub skip_unknown: bool,
    /// Whether files are replaced that raylet did not write.
    pub overwrite: bool,
}

/// A lens file that is not yet on the disk.
#[derive(Clone, Debug)]
pub struct WrittenLens {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What was written, changed and left out.
    pub report: ImportReport,
    /// Position of its first surface, from the start of the scene's axis in mm.
    pub first_surface_mm: f64,
}

/// A kind of lens file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Zemax,
    CodeV,
}

impl Format {
    /// The kind of a file by the end of its name.
    fn of(path: &Path) -> Result<Self, Fault> {
        let end = path.extension().unwrap_or_default().to_string_lossy();
        match end.to_ascii_lowercase().as_str() {
            "zmx" => Ok(Self::Zemax),
            "seq" => Ok(Self::CodeV),
            _ => {
                let found = format!("the end .{}", shortened(&end));
                Err(Fault::of_file(path, found, "a name ending in .zmx or .seq"))
            }
        }
    }
}

/// Whether a name is that of a lens file that is written.
pub fn is_lens_file(path: &Path) -> bool {
    Format::of(path).is_ok()
}

/// Writes a scene as a lens file of OpticStudio (.zmx) or CODE V (.seq).
///
/// # Errors
/// A part of the scene that the file cannot hold, at its key; or a file that may not be replaced or cannot be written.
pub fn export_lens(
    scene: &Scene,
    target: &Path,
    choices: LensExportChoices,
) -> Result<ImportReport, Fault> {
    // A place that cannot be written is refused before the work begins.
    let file = OwnFile::claim(target, Replace::any_if(choices.overwrite))?;
    let written = lens_file(scene, target, choices.skip_unknown)?;
    file.write(&written.bytes)?;
    Ok(written.report)
}

/// [`export_lens`] of a scene file (.toml), or of a lens file in one of the formats that are read.
///
/// # Errors
/// As [`export_lens`], or the first fault of the source.
pub fn export_lens_of(
    source: &Path,
    target: &Path,
    choices: LensExportChoices,
) -> Result<ImportReport, Fault> {
    let is_scene = source
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    if is_scene {
        return export_lens(&Scene::open(source)?, target, choices);
    }
    let imported = import_lens(source, &ImportChoices::default())?;
    let mut report = export_lens(&imported.scene, target, choices)?;
    report.warnings.splice(0..0, imported.report.warnings);
    report.changed.splice(0..0, imported.report.changed);
    report.left_out.splice(0..0, imported.report.left_out);
    Ok(report)
}

/// The lens file of a scene, in the format of a name.
///
/// # Errors
/// A part of the scene that the file cannot hold, at its key.
pub fn lens_file(scene: &Scene, name: &Path, skip_unknown: bool) -> Result<WrittenLens, Fault> {
    let format = Format::of(name)?;
    let mut losses = Losses::default();
    let mut outgoing = Outgoing::of(scene, skip_unknown, &mut losses)?;
    if skip_unknown {
        let holds = match format {
            Format::Zemax => zemax_holds,
            Format::CodeV => codev_holds,
        };
        outgoing.leave_out(holds, &mut losses);
    }
    let text = match format {
        Format::Zemax => zemax_text(&outgoing, &mut losses),
        Format::CodeV => codev_text(&outgoing, &mut losses),
    };
    let text = text.map_err(|(place, (found, expected))| {
        let path = outgoing.path.get(place).map_or("", String::as_str);
        scene.fault(path, found, expected).hint(SKIP)
    })?;
    losses.leave_out(
        "How raylet computes the scene (settings), and coatings: surfaces of the file have none.",
    );
    Ok(WrittenLens {
        bytes: encoded(text, format),
        report: report(&outgoing, format, name, losses),
        first_surface_mm: outgoing.start_mm,
    })
}

/// Text of other characters than those of ASCII is in UTF-16 for OpticStudio, as it writes it, and else in UTF-8.
fn encoded(text: String, format: Format) -> Vec<u8> {
    match text.is_ascii() || format == Format::CodeV {
        true => text.into_bytes(),
        false => std::iter::once(0xfeff)
            .chain(text.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect(),
    }
}

fn report(outgoing: &Outgoing, format: Format, name: &Path, losses: Losses) -> ImportReport {
    let lens = &outgoing.lens;
    let mut changed = losses.changed;
    changed.push(match format {
        Format::Zemax => {
            "Wavelengths stand as in the scene: OpticStudio means those in air, raylet those in vacuum (0.03 % longer).".to_owned()
        }
        Format::CodeV => "Wavelengths and indices stand as in the scene.".to_owned(),
    });
    let name = name.file_name().unwrap_or_default().to_string_lossy();
    let waves: Vec<String> = lens.wavelength_um.iter().map(f64::to_string).collect();
    ImportReport {
        read: vec![
            format!(
                "{name} has {} surfaces with object and image; surface {} limits the light and is the stop.",
                lens.surface.len(),
                lens.stop
            ),
            format!("Its wavelengths are {} µm.", waves.join(", ")),
        ],
        numbers: numbers(outgoing),
        warnings: losses.warnings,
        changed,
        left_out: losses.left_out,
    }
}

/// First-order data at the first wavelength.
fn numbers(outgoing: &Outgoing) -> Vec<ReportedNumber> {
    let lens = &outgoing.lens;
    let wavelength = lens.wavelength_um.first().copied().unwrap_or(0.55) * 1e-3;
    let Ok(first) = FirstOrder::of(lens, &outgoing.media, wavelength) else {
        return Vec::new();
    };
    let line = |name: &str, value: f64| ReportedNumber {
        name: name.to_owned(),
        value: Some(value).filter(|value| value.is_finite()),
        stated: None,
    };
    vec![
        line("focal length, axis unfolded (mm)", first.focal_length),
        line("entrance pupil diameter (mm)", first.pupil_diameter),
        line("entrance pupil position (mm)", first.pupil_position),
        line("stop radius (mm)", first.stop_radius),
        line(
            "image-space f-number",
            first.focal_length.abs() / first.pupil_diameter,
        ),
        line("working f-number", first.working_f_number()),
    ]
}
