//! `raylet lenses [FOLDER]`: the lens files of a folder, or the lenses that raylet carries.

use std::path::PathBuf;

use clap::Args;
use raylet::file::prescription::lens_library::lens_catalog::lenses;
use raylet::file::prescription::lens_library::lens_facts::LensFacts;
use raylet::file::prescription::lens_library::lens_folder::{LensFolder, LensSearch};

use crate::failure::Failure;
use crate::say::{complain, say};

/// Lists the lens files of a folder that fit, or the lenses that raylet carries.
#[derive(Args)]
pub(crate) struct Lenses {
    /// The folder, with the folders in it; the lenses that raylet carries without it.
    folder: Option<PathBuf>,
    /// Smallest and largest focal length in mm, A,B.
    #[arg(long, value_name = "A,B", value_parser = range)]
    #[arg(allow_negative_numbers = true)]
    focal_mm: Option<[f64; 2]>,
    /// Smallest and largest diameter in mm, A,B.
    #[arg(long, value_name = "A,B", value_parser = range)]
    diameter_mm: Option<[f64; 2]>,
    /// Smallest and largest f-number, A,B.
    #[arg(long, value_name = "A,B", value_parser = range)]
    f_number: Option<[f64; 2]>,
    /// A part of the maker's name.
    #[arg(long, value_name = "NAME")]
    maker: Option<String>,
    /// Words in the name or the path.
    #[arg(long, value_name = "WORDS")]
    text: Option<String>,
    /// Keeps an index of the folder in this file, so that the next call reads changed files alone.
    #[arg(long, value_name = "FILE", requires = "folder")]
    index: Option<PathBuf>,
}

impl Lenses {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let sought = LensSearch {
            focal_length_mm: self.focal_mm,
            diameter_mm: self.diameter_mm,
            f_number: self.f_number,
            maker: self.maker.clone(),
            text: self.text.clone(),
        };
        let mut text = heading();
        let Some(folder) = &self.folder else {
            for lens in lenses() {
                let facts = lens.facts()?;
                let path = PathBuf::from(lens.part);
                if sought.fits(&path, &facts) {
                    text.push_str(&row(&facts, lens.part));
                }
            }
            return say(&text);
        };
        let found = LensFolder::open(folder, self.index.as_deref())?;
        for (path, facts) in found.search(&sought) {
            let inside = path.strip_prefix(folder).unwrap_or(path);
            text.push_str(&row(facts, &inside.display().to_string()));
        }
        for (path, fault) in found.faults() {
            let first = fault.lines().next().unwrap_or_default();
            let name = path.display().to_string();
            let told = if first.contains(&name) {
                first.to_owned()
            } else {
                format!("{name}: {first}")
            };
            complain(&format!("not read: {told}"));
        }
        say(&text)
    }
}

/// The names of the columns.
fn heading() -> String {
    format!(
        "{:>10} {:>9} {:>7}  {:<14} lens, file or part\n",
        "f (mm)", "Ø (mm)", "f/D", "maker"
    )
}

/// One lens.
fn row(facts: &LensFacts, place: &str) -> String {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
    };
    format!(
        "{:>10} {:>9} {:>7}  {:<14} {}, {place}\n",
        number(facts.focal_length_mm, 3),
        number(Some(facts.diameter_mm), 3),
        number(facts.f_number, 2),
        facts.maker.as_deref().unwrap_or("-"),
        facts.name,
    )
}

/// Two numbers, the smaller one first.
fn range(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([from, to]) if from <= to => Ok([*from, *to]),
        _ => Err(String::from(
            "expected two numbers A,B, the smaller one first",
        )),
    }
}
