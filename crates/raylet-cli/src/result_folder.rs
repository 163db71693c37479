//! Everything that a run leaves behind, as one folder.

#![expect(
    clippy::indexing_slicing,
    reason = "elements are numbered by the systems they were built into"
)]

use std::fs::File;
use std::io;
use std::path::Path;

use ndarray::{Array1, Array2, Array3, Axis, stack};
use ndarray_npy::WriteNpyExt;
use raylet::file::arrays::npz::Fields;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build::system;
use raylet::file::model::scene_sweep::{named_fields, scene_at_place};
use raylet::file::result::channel::micrometres;
use raylet::file::result::channel::{Channel, Place};
use raylet::file::result::report::Report;
use raylet::file::result::result_folder::{FIELD_FILE, ResultFolder};
use raylet::file::result::run_table::RunTable;
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::folder::OutputFolder;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;
use raylet_plot::layout_picture::{FieldView, layout_png};
use raylet_plot::panel::FigureError;
use raylet_plot::pictures::{DoeView, doe_png, sensor_png};
use raylet_plot::sensor_panels::MOST_CHANNELS;

/// The fields of all channels, which share the sensor's grid. A single field is not copied.
pub(crate) fn gather(systems: &[System], mut fields: Vec<Field>) -> Fields {
    let (x, y) = match fields.first() {
        Some(field) => (field.grid.x.nodes(), field.grid.y.nodes()),
        None => (Vec::new(), Vec::new()),
    };
    let single = fields.pop_if(|_| systems.len() == 1);
    let field = match single {
        Some(field) => field.values.insert_axis(Axis(0)),
        None => {
            let mut all = Array3::zeros((fields.len(), y.len(), x.len()));
            for (mut slice, field) in all.axis_iter_mut(Axis(0)).zip(fields) {
                slice.assign(&field.values);
            }
            all
        }
    };
    Fields {
        field,
        x_mm: Array1::from(x),
        y_mm: Array1::from(y),
        wavelength_um: systems.iter().map(|s| micrometres(s.wavelength)).collect(),
    }
}

/// The standard error of a field at each sample, indexed [y, x].
pub(crate) type StandardError = Array2<f64>;

/// The file that holds a row for each run.
const TABLE_FILE: &str = "table.csv";

/// The file that holds the standard errors.
const NOISE_FILE: &str = "standard_error.npy";

/// Writes standard errors of the fields of all channels as a .npy file, float64 [channel, y, x].
fn write_noise(errors: &[StandardError], file: &mut File) -> io::Result<()> {
    let views: Vec<_> = errors.iter().map(|error| error.view()).collect();
    let all = stack(Axis(0), &views).map_err(io::Error::other)?;
    all.write_npy(file).map_err(io::Error::other)
}

/// The light of a run on its sensor.
pub(crate) struct Light<'a> {
    /// The fields of all channels.
    pub(crate) fields: Fields,
    /// Their standard errors; empty where a run has none.
    pub(crate) errors: &'a [StandardError],
}

/// Draws the pictures of a run and writes them with its fields, their standard errors where there is one for
/// every channel, and its document; returns the document as written, which names the files. The systems are
/// one per channel.
///
/// # Errors
/// Fields or numbers that are not finite, a picture that cannot be drawn, or a folder that cannot be written; then
/// nothing is left behind.
pub(crate) fn publish(
    target: &OutputFolder,
    scene: &Scene,
    systems: &[System],
    light: Light,
    mut report: Report,
) -> Result<Report, Fault> {
    let Light { fields, errors } = light;
    let refuse = |error: FigureError| {
        Fault::of_file(
            target.path(),
            error.to_string(),
            "pictures that can be drawn",
        )
    };
    fields.check_for(Path::new(FIELD_FILE))?;
    let mut pictures = pictures(scene, systems, &fields, &report.channels).map_err(refuse)?;
    if let Some(layout) = layout(scene, systems, &report.channels)? {
        pictures.push((String::from("layout.png"), layout.map_err(refuse)?));
    }
    report.files = vec![FIELD_FILE.to_owned(), TABLE_FILE.to_owned()];
    report
        .files
        .extend(pictures.iter().map(|(name, _)| name.clone()));

    let mut draft = target.draft()?;
    draft.write(TABLE_FILE, RunTable::new(&report).csv().as_bytes())?;
    if !errors.is_empty() && errors.len() == systems.len() {
        report.files.push(NOISE_FILE.to_owned());
        draft.fill(NOISE_FILE, &|file| write_noise(errors, file))?;
    }
    for (name, bytes) in &pictures {
        draft.write(name, bytes)?;
    }
    let folder = ResultFolder { report, fields };
    folder.publish(draft)?;
    Ok(folder.report)
}

/// The pictures of a run, by file name.
fn pictures(
    scene: &Scene,
    systems: &[System],
    fields: &Fields,
    channels: &[Channel],
) -> Result<Vec<(String, Vec<u8>)>, FigureError> {
    let title = match scene.title.as_str() {
        "" => "Sensor",
        title => title,
    };
    let names: Vec<String> = channels.iter().map(Channel::name).collect();
    let is_sweep = (channels.iter()).any(|channel| channel.place != Place::default());
    let sensor = sensor_png(fields, title, &names, is_sweep)?;
    let mut list = vec![(String::from("sensor.png"), sensor)];
    let Some(first) = systems.first() else {
        return Ok(list);
    };
    // An element acts alike in every field.
    let place = channels.first().map(|channel| channel.place);
    let waves: Vec<&System> = (systems.iter().zip(channels))
        .filter(|(_, channel)| Some(channel.place) == place)
        .map(|(system, _)| system)
        .collect();
    let shown = match waves.len() {
        count if count > MOST_CHANNELS => 1,
        count => count,
    };
    for (number, screen) in first.screens.iter().enumerate() {
        let views: Vec<DoeView> = (waves.iter().take(shown))
            .filter_map(|system| match &system.screens[number].kind {
                ScreenKind::Doe(doe) => Some(DoeView {
                    doe,
                    wavelength_um: micrometres(system.wavelength),
                }),
                _ => None,
            })
            .collect();
        if views.is_empty() {
            continue;
        }
        if let Some(png) = doe_png(&views, &screen.name)? {
            let taken: Vec<&str> = list.iter().map(|(name, _)| name.as_str()).collect();
            list.push((file_name(&screen.name, number, &taken), png));
        }
    }
    Ok(list)
}

/// The section through the first system with the light of all fields that were run; where these were not chosen, of all
/// that the scene names.
fn layout(
    scene: &Scene,
    systems: &[System],
    channels: &[Channel],
) -> Result<Option<Result<Vec<u8>, FigureError>>, Fault> {
    let mut views: Vec<FieldView> = Vec::new();
    for (system, channel) in systems.iter().zip(channels) {
        let name = channel.place.light().unwrap_or_default();
        if views.iter().all(|view| view.name != name) {
            views.push(FieldView { name, system });
        }
    }

    // The first is the source's own.
    let named = match views.as_slice() {
        [only] if only.name.is_empty() => named_fields(scene),
        _ => Vec::new(),
    };
    let others = named.iter().skip(1);
    let others: Vec<System> = others
        .map(|place| system(&scene_at_place(scene, place, false)?, 0))
        .collect::<Result<_, Fault>>()?;
    if let ([own, fields @ ..], [view]) = (named.as_slice(), views.as_mut_slice()) {
        view.name = own.light().unwrap_or_default();
        views.extend(
            (fields.iter().zip(&others)).map(|(place, system)| FieldView {
                name: place.light().unwrap_or_default(),
                system,
            }),
        );
    }
    Ok((!views.is_empty()).then(|| layout_png(scene, &views)))
}

/// A file name for an element's picture, of letters that every file system takes; its number where the
/// name says too little or is taken.
fn file_name(name: &str, number: usize, taken: &[&str]) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    let stem: String = name.chars().map(plain).take(80).collect();
    let stem = match name.starts_with("element[") {
        true => number.to_string(),
        false => stem,
    };
    let file = format!("doe-{stem}.png");
    let folded = file.to_lowercase();
    match taken.iter().any(|other| other.to_lowercase() == folded) {
        true => format!("doe-{stem}-{number}.png"),
        false => file,
    }
}

#[cfg(test)]
mod tests {
    use crate::result_folder::file_name;

    #[test]
    fn file_names_are_plain_and_distinct() {
        assert_eq!(file_name("LA1131-A", 0, &[]), "doe-LA1131-A.png");
        assert_eq!(file_name("../a b/c", 0, &[]), "doe-..-a-b-c.png");
        assert_eq!(file_name("element[3]", 1, &[]), "doe-1.png");
        assert_eq!(file_name("A", 2, &["doe-a.png"]), "doe-A-2.png");
    }
}
