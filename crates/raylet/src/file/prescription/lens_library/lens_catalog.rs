//! The lens files that raylet carries, by part number. `data/lenses/NOTICE.md` has their sources and licences.

use std::path::Path;

use thiserror::Error;

use crate::file::decode::fault::Fault;
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};
use crate::file::prescription::lens_library::lens_facts::LensFacts;

/// How many near names an error offers.
const SUGGESTIONS: usize = 5;

/// A lens that raylet carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogLens {
    /// The maker's part number.
    pub part: &'static str,
    /// The maker.
    pub maker: &'static str,
    /// What it is, in words.
    pub kind: &'static str,
    /// The name of its file.
    pub file: &'static str,
    bytes: &'static [u8],
}

/// A lens of the catalogue from its part number, maker, kind and file.
macro_rules! carried {
    ($part:literal, $maker:literal, $kind:literal, $file:literal) => {
        CatalogLens {
            part: $part,
            maker: $maker,
            kind: $kind,
            file: $file,
            bytes: include_bytes!(concat!("../../../../data/lenses/", $file)),
        }
    };
}

/// All lenses.
const LENSES: [CatalogLens; 8] = [
    carried!(
        "32-327",
        "Edmund Optics",
        "cemented achromat",
        "CODV_32327.seq"
    ),
    carried!(
        "35-571",
        "Edmund Optics",
        "off-axis parabolic mirror",
        "CODV_35571.seq"
    ),
    carried!(
        "49-663",
        "Edmund Optics",
        "aspherised achromat",
        "CODV_49664.seq"
    ),
    carried!(
        "55-278",
        "Edmund Optics",
        "pair of achromats",
        "zmax_55278.zmx"
    ),
    carried!(
        "65-564",
        "Edmund Optics",
        "cemented achromat",
        "CODV_65564.seq"
    ),
    carried!(
        "65-988",
        "Edmund Optics",
        "hybrid asphere with a kinoform",
        "CODV_65988.seq"
    ),
    carried!(
        "ACL3026U",
        "Thorlabs",
        "aspheric condenser",
        "ACL3026U-Zemax(ZMX).zmx"
    ),
    carried!("LA1131-A", "Thorlabs", "plano-convex lens", "LA1131-A.csv"),
];

/// A name that no lens has.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("no lens of the catalogue is named '{name}'; the nearest are {}", nearest.join(", "))]
pub struct UnknownLens {
    /// The requested name.
    pub name: String,
    /// The nearest part numbers, best first.
    pub nearest: Vec<String>,
}

/// All lenses that raylet carries.
pub fn lenses() -> &'static [CatalogLens] {
    &LENSES
}

/// The lens of a part number, with or without its maker; hyphens, blanks and capitals do not matter.
///
/// # Errors
/// A name that no lens has, with the nearest part numbers.
pub fn catalog_lens(name: &str) -> Result<&'static CatalogLens, UnknownLens> {
    let sought = compared(name);
    let same = |lens: &&CatalogLens| {
        let part = compared(lens.part);
        let whole = [compared(lens.maker), compared("Edmund"), "eo".to_owned()];
        sought == part || whole.iter().any(|maker| sought == format!("{maker}{part}"))
    };
    LENSES.iter().find(same).ok_or_else(|| UnknownLens {
        name: name.chars().take(100).collect(),
        nearest: nearest(&sought),
    })
}

/// The characters of a name that are compared.
fn compared(name: &str) -> String {
    let kept = name.chars().filter(|c| c.is_alphanumeric());
    kept.take(100).flat_map(char::to_lowercase).collect()
}

fn nearest(sought: &str) -> Vec<String> {
    let edits = |lens: &&CatalogLens| {
        let own = compared(lens.part);
        let apart = sought.is_empty() || !own.contains(sought);
        (apart, strsim::damerau_levenshtein(&own, sought))
    };
    let mut ranked: Vec<&CatalogLens> = LENSES.iter().collect();
    ranked.sort_by_key(edits);
    let parts = ranked
        .iter()
        .take(SUGGESTIONS)
        .map(|lens| lens.part.to_owned());
    parts.collect()
}

impl CatalogLens {
    /// Its bytes.
    pub fn bytes(&self) -> &'static [u8] {
        self.bytes
    }

    /// Its focal length, diameter and so on, with its own name and maker.
    ///
    /// # Errors
    /// The first fault of its file.
    pub fn facts(&self) -> Result<LensFacts, Fault> {
        let facts = LensFacts::of(self.bytes, Path::new(self.file))?;
        Ok(LensFacts {
            name: self.kind.to_owned(),
            maker: Some(self.maker.to_owned()),
            ..facts
        })
    }

    /// Its scene.
    ///
    /// # Errors
    /// A choice that its file does not have.
    pub fn import(&self, choices: &ImportChoices) -> Result<ImportedLens, Fault> {
        import_bytes(self.bytes, Path::new(self.file), choices)
    }
}
