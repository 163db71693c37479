//! A folder of lens files, and how it is searched.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use rayon::prelude::*;

use crate::file::decode::fault::Fault;
use crate::file::prescription::import::LENS_ENDS;
use crate::file::prescription::lens_file::bytes_of;
use crate::file::prescription::lens_library::folder_index::{
    Index, Indexed, read_index, write_index,
};
use crate::file::prescription::lens_library::lens_facts::LensFacts;

/// How deep folders lie in each other at most, and most files that are listed.
const DEEPEST: usize = 40;
const MOST_FILES: usize = 1_000_000;

/// A lens file of a folder, or a folder in it that could not be listed.
#[derive(Clone, Debug, PartialEq)]
pub struct FolderLens {
    /// Its path.
    pub path: PathBuf,
    /// Its facts, or why it has none.
    pub facts: Result<LensFacts, String>,
}

/// The lens files of a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct LensFolder {
    /// All files, by their paths in the folder, and behind them the folders that could not be listed.
    pub lenses: Vec<FolderLens>,
    /// How many of them were read now; the index had the others.
    pub read: usize,
}

/// What is sought; everything by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LensSearch {
    /// The smallest and the largest focal length in mm.
    pub focal_length_mm: Option<[f64; 2]>,
    /// The smallest and the largest diameter in mm.
    pub diameter_mm: Option<[f64; 2]>,
    /// The smallest and the largest f-number.
    pub f_number: Option<[f64; 2]>,
    /// A part of the maker's name.
    pub maker: Option<String>,
    /// Words that stand in the name or the path, in any order.
    pub text: Option<String>,
}

impl LensFolder {
    /// Lists a folder and the folders in it, and reads its lens files. A folder in it that cannot be listed is a fault of that
    /// folder alone. With an `index` only files of another size or time than
    /// there are read, and the index is written again.
    ///
    /// # Errors
    /// A folder that cannot be listed; an index that is none, or may not be replaced.
    pub fn open(folder: &Path, index: Option<&Path>) -> Result<Self, Fault> {
        let known = match index {
            Some(path) => read_index(path)?,
            None => Index::new(),
        };
        let mut listing = Listing {
            root: folder,
            files: Vec::new(),
            refused: Vec::new(),
        };
        listing.add(folder, 0)?;
        if listing.files.len() > MOST_FILES {
            let count = format!("more than {MOST_FILES} lens files");
            return Err(Fault::of_file(folder, count, "fewer"));
        }
        let indexed: Vec<(String, Indexed, bool)> = listing
            .files
            .into_par_iter()
            .map(|(name, size, modified_ns)| {
                let same = known.get(&name);
                let same = same.filter(|old| (old.size, old.modified_ns) == (size, modified_ns));
                let entry = same.cloned().unwrap_or_else(|| Indexed {
                    size,
                    modified_ns,
                    facts: facts(&folder.join(&name)),
                });
                (name, entry, same.is_none())
            })
            .collect();
        let read = indexed.iter().filter(|(_, _, new)| *new).count();
        let all: Index = indexed
            .into_iter()
            .map(|(name, entry, _)| (name, entry))
            .collect();
        if let Some(path) = index.filter(|_| all != known) {
            write_index(path, &all)?;
        }
        let lenses = all.into_iter().map(|(name, entry)| FolderLens {
            path: folder.join(name),
            facts: entry.facts,
        });
        let refused = listing.refused.into_iter().map(|(path, fault)| FolderLens {
            path,
            facts: Err(fault.to_string()),
        });
        Ok(Self {
            lenses: lenses.chain(refused).collect(),
            read,
        })
    }

    /// The lenses that fit, by their paths.
    pub fn search(&self, sought: &LensSearch) -> Vec<(&Path, &LensFacts)> {
        let lenses = self.lenses.iter().filter_map(|lens| {
            let facts = lens.facts.as_ref().ok()?;
            sought
                .fits(&lens.path, facts)
                .then_some((lens.path.as_path(), facts))
        });
        lenses.collect()
    }

    /// The files that could not be read, each with why.
    pub fn faults(&self) -> impl Iterator<Item = (&Path, &str)> {
        self.lenses.iter().filter_map(|lens| {
            let fault = lens.facts.as_ref().err()?;
            Some((lens.path.as_path(), fault.as_str()))
        })
    }
}

impl LensSearch {
    /// Whether a lens fits. Focal lengths have their signs; a lens without power has none.
    pub fn fits(&self, path: &Path, facts: &LensFacts) -> bool {
        let within = |range: Option<[f64; 2]>, value: Option<f64>| {
            range.is_none_or(|[from, to]| value.is_some_and(|value| from <= value && value <= to))
        };
        let holds = |whole: &str, part: &str| whole.to_lowercase().contains(&part.to_lowercase());
        let maker = facts.maker.as_deref().unwrap_or_default();
        let words = format!("{} {} {maker}", facts.name, path.to_string_lossy());
        let text = self.text.as_deref().unwrap_or_default();
        within(self.focal_length_mm, facts.focal_length_mm)
            && within(self.diameter_mm, Some(facts.diameter_mm))
            && within(self.f_number, facts.f_number)
            && self.maker.as_ref().is_none_or(|part| holds(maker, part))
            && text.split_whitespace().all(|word| holds(&words, word))
    }
}

/// The facts of a file, or its fault as text.
fn facts(path: &Path) -> Result<LensFacts, String> {
    let bytes = bytes_of(path, "a readable lens file").map_err(|fault| fault.to_string())?;
    LensFacts::of(&bytes, path).map_err(|fault| fault.to_string())
}

/// What is found below a folder.
struct Listing<'a> {
    root: &'a Path,
    /// Lens files: path from the root, size and time of change.
    files: Vec<(String, u64, u64)>,
    /// Folders that could not be listed.
    refused: Vec<(PathBuf, Fault)>,
}

impl Listing<'_> {
    /// Adds what is below a folder. Links to folders are not followed.
    ///
    /// # Errors
    /// A folder that cannot be listed.
    fn add(&mut self, folder: &Path, depth: usize) -> Result<(), Fault> {
        let refuse = |found: String| Fault::of_file(folder, found, "a folder of lens files");
        if depth > DEEPEST {
            return Err(refuse(format!("a folder {depth} folders deep")));
        }
        let broken = |error: std::io::Error| refuse(error.to_string());
        for entry in fs::read_dir(folder).map_err(broken)? {
            let entry = entry.map_err(broken)?;
            let (path, kind) = (entry.path(), entry.file_type().map_err(broken)?);
            if kind.is_dir() {
                if let Err(fault) = self.add(&path, depth + 1) {
                    self.refused.push((path, fault));
                }
                continue;
            }
            self.add_file(&path);
        }
        Ok(())
    }

    /// Adds a lens file; other files are passed over, and links that lead nowhere.
    fn add_file(&mut self, path: &Path) {
        let end = path.extension().unwrap_or_default().to_string_lossy();
        let is_lens = LENS_ENDS
            .iter()
            .any(|known| end.eq_ignore_ascii_case(known));
        let (Ok(data), true) = (fs::metadata(path), is_lens) else {
            return;
        };
        if !data.is_file() || self.files.len() > MOST_FILES {
            return;
        }
        let time = data
            .modified()
            .ok()
            .and_then(|at| at.duration_since(UNIX_EPOCH).ok());
        let modified_ns = time.map_or(0, |time| time.as_nanos() as u64);
        let name = path.strip_prefix(self.root).unwrap_or(path);
        self.files
            .push((name.to_string_lossy().into_owned(), data.len(), modified_ns));
    }
}
