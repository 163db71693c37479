//! The lens of an archive of OpticStudio, the catalogues of glasses beside it, and the names of what is not used.

use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::archive::zar_archive::Archive;

/// A lens of an archive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ArchivedLens {
    /// How faults name the lens file, and its bytes.
    pub lens: (PathBuf, Vec<u8>),
    /// The same of each catalogue of glasses (.agf).
    pub catalogues: Vec<(PathBuf, Vec<u8>)>,
    /// Names of the other files.
    pub unused: Vec<String>,
}

/// The lens of an archive whose faults name it as `path`.
///
/// # Errors
/// Bytes that are no archive, or one without a lens file of Zemax (.zmx) or with several.
pub(crate) fn archived_lens(source: impl Read + Seek, path: &Path) -> Result<ArchivedLens, Fault> {
    let mut archive = Archive::open(source, path)?;
    let names: Vec<String> = archive.names().map(str::to_owned).collect();
    let ends = |name: &str, end: &str| {
        let found = Path::new(name).extension();
        found.is_some_and(|found| found.eq_ignore_ascii_case(end))
    };
    let of_kind = |end: &str| -> Vec<usize> {
        let numbered = names.iter().enumerate();
        let kind = numbered.filter(|(_, name)| ends(name, end));
        kind.map(|(number, _)| number).collect()
    };
    let lenses = of_kind("zmx");
    let [lens] = lenses[..] else {
        return Err(no_single_lens(path, &names, &lenses));
    };
    let lens = archive.file(lens)?;
    let catalogues = of_kind("agf").into_iter();
    let catalogues = catalogues.map(|number| archive.file(number));
    let unused = names
        .iter()
        .filter(|name| !ends(name, "zmx") && !ends(name, "agf"));
    Ok(ArchivedLens {
        lens,
        catalogues: catalogues.collect::<Result<_, _>>()?,
        unused: unused.cloned().collect(),
    })
}

impl ArchivedLens {
    /// What the archive has, for a report.
    pub(crate) fn read_sentence(&self, path: &Path) -> String {
        let name = |path: &Path| {
            let name = path.file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        let catalogues: Vec<String> = self.catalogues.iter().map(|(path, _)| name(path)).collect();
        let glasses = match catalogues.is_empty() {
            true => String::new(),
            false => format!(", and glasses of {} come first", catalogues.join(", ")),
        };
        let (archive, lens) = (name(path), name(&self.lens.0));
        shortened(&format!(
            "The lens is {lens} of the archive {archive}{glasses}."
        ))
    }

    /// What of the archive is not used, for a report; none where everything is.
    pub(crate) fn unused_sentence(&self) -> Option<String> {
        let names = shortened(&self.unused.join(", "));
        (!self.unused.is_empty())
            .then(|| format!("Files of the archive that are not used: {names}."))
    }
}

/// The fault of an archive without a lens, or with several.
fn no_single_lens(path: &Path, names: &[String], lenses: &[usize]) -> Fault {
    let listed = |numbers: &mut dyn Iterator<Item = usize>| {
        let found = numbers.filter_map(|number| names.get(number).cloned());
        found.collect::<Vec<_>>().join(", ")
    };
    let found = match lenses.len() {
        0 => format!("no lens file among {}", listed(&mut (0..names.len()))),
        _ => format!(
            "several lens files: {}",
            listed(&mut lenses.iter().copied())
        ),
    };
    let fault = Fault::of_file(path, shortened(&found), "one lens file of Zemax (.zmx)");
    // Newer versions keep the lens in a format of their own.
    match names
        .iter()
        .any(|name| name.to_ascii_lowercase().ends_with(".zos"))
    {
        true => fault.hint("a .zos is not read: save the lens as .zmx in OpticStudio"),
        false => fault,
    }
}
