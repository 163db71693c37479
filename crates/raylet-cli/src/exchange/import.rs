//! `raylet import LENS`: a scene from the file of a program for lens design.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::Array2;
use raylet::file::arrays::phase_file::PhaseFile;
use raylet::file::decode::fault::Fault;
use raylet::file::prescription::import::{ImportChoices, ImportedLens, import_lens};
use raylet::file::prescription::scene_text::concise_toml;
use raylet::file::storage::own_file::{OwnFile, Replace};

use crate::failure::Failure;
use crate::say::{complain, say};

/// Makes a scene of a lens file of OpticStudio (.zmx, .zar) or CODE V (.seq), or of a table of surfaces (.csv), and reports what was
/// changed and left out.
#[derive(Args)]
pub(crate) struct Import {
    /// The lens file.
    lens: PathBuf,
    /// The scene file to be written. Without it the scene goes to standard output and the report to standard error.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The number of the field whose light the scene has, from 1.
    #[arg(long, value_name = "N", default_value_t = 1)]
    field: usize,
    /// The number of the wavelength, from 1; the primary one by default.
    #[arg(long, value_name = "N")]
    wavelength: Option<usize>,
    /// The number of the configuration or zoom position, from 1; the one whose values the file has by default.
    #[arg(long, value_name = "N")]
    configuration: Option<usize>,
    /// Takes another glass in place of one that the file names, such as BK7=N-BK7; may stand several times.
    #[arg(long, value_name = "NAME=GLASS", value_parser = replacement)]
    glass: Vec<(String, String)>,
    /// Seeks glasses in this catalogue (.agf) before that of raylet; may stand several times.
    #[arg(long, value_name = "FILE")]
    glasses: Vec<PathBuf>,
    /// Makes planes of surfaces of unknown types, and leaves out commands that are not known.
    #[arg(long)]
    skip_unknown: bool,
    /// Replaces a file that raylet did not write, or that was changed since.
    #[arg(long)]
    overwrite: bool,
}

impl Import {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        // A place that cannot be written is refused before the work begins.
        let replace = Replace::any_if(self.overwrite);
        let claim = |path: &PathBuf| OwnFile::claim(path, replace);
        let target = self.out.as_ref().map(claim).transpose()?;
        let choices = ImportChoices {
            field: self.field,
            wavelength: self.wavelength,
            configuration: self.configuration,
            skip_unknown: self.skip_unknown,
            glasses: self.glass.iter().cloned().collect::<BTreeMap<_, _>>(),
            glass_files: self.glasses.clone(),
        };
        let imported = import_lens(&self.lens, &choices)?;
        let name = self.lens.file_name().unwrap_or_default();
        let heading = format!(
            "Imported from {}, field {}.",
            name.to_string_lossy(),
            self.field
        );
        let text = concise_toml(&imported.scene, &heading)?;
        match target {
            Some(file) => {
                // Arrays that the scene names stand beside it, and are written before it.
                let arrays = claimed_arrays(&imported, file.path(), replace)?;
                for (array, values) in &arrays {
                    array.write(values)?;
                }
                file.write(text.as_bytes())?;
                let mut said = format!("{}Scene in {}\n", imported.report, file.path().display());
                for (array, _) in &arrays {
                    said += &format!("Array in {}\n", array.path().display());
                }
                say(&said)
            }
            None if !imported.arrays.is_empty() => Err(Failure::from(Fault::of_file(
                &self.lens,
                "a grid of values, which needs a file beside the scene",
                "a file for the scene (--out)",
            ))),
            None => {
                complain(imported.report.to_string().trim_end());
                say(&text)
            }
        }
    }
}

/// The files of the arrays that a scene at a path names, and their values.
fn claimed_arrays<'a>(
    imported: &'a ImportedLens,
    scene: &Path,
    replace: Replace,
) -> Result<Vec<(PhaseFile, &'a Array2<f64>)>, Fault> {
    let arrays = imported.arrays.iter().map(|array| {
        let path = scene.with_file_name(&array.file);
        Ok((PhaseFile::claim(&path, replace)?, &*array.values))
    });
    arrays.collect()
}

/// A glass in place of another on the command line.
fn replacement(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, glass)) if !name.is_empty() && !glass.is_empty() => {
            Ok((name.to_owned(), glass.to_owned()))
        }
        _ => Err(String::from("expected NAME=GLASS, such as BK7=N-BK7")),
    }
}
