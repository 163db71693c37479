//! Glasses by name: catalogues of the makers and a list of single materials, with their sources.
//!
//! The data is a reduction of the refractiveindex.info database (CC0 1.0); `data/README.md` says what
//! was taken and how. What a name means:
//!
//! * `SCHOTT:N-BK7`, catalogue and glass, always means that glass. `MATERIAL:` is the list of single
//!   materials (`fused silica`, `CaF2`, `PMMA`, `water`, …), among them `air` and `vacuum`, both of
//!   index exactly 1.
//! * Capitals, spaces, hyphens and underscores do not matter: `nbk7` is N-BK7.
//! * A name without catalogue means the one glass that has it, or SCHOTT's among several. Other
//!   makers' glasses of one name differ (HIKARI's F1 and CDGM's by 0.02), so such a name is refused.
//! * `BaF2` (a crystal) and `BAF2` (a glass) differ by capitals alone: the first is taken as written,
//!   the second is refused, because lens files put every name in capitals.
//!
//! Birefringent crystals mean their ordinary index; `-e` at the end of the name selects the other.
//! The medium's own name is always catalogue and glass, so that a report names what was taken.

use std::collections::HashMap;
use std::sync::LazyLock;

use thiserror::Error;

use crate::optics::media::dispersion::{Dispersion, Formula};
use crate::optics::media::medium::{Medium, MediumError};

/// The data, one glass a line; `data/README.md` explains the columns.
const DATA: &str = include_str!("../../../data/glass.tsv");

/// The catalogue whose glasses need no catalogue in their name.
const FIRST_CATALOGUE: &str = "SCHOTT";

/// How many near names an error offers.
const SUGGESTIONS: usize = 5;

static GLASSES: LazyLock<Vec<Glass>> = LazyLock::new(|| {
    let (mut catalogue, mut source) = ("", "");
    let read = |line: &'static str| {
        if let Some(found) = line.strip_prefix("= ") {
            (catalogue, source) = found.split_once('\t')?;
            return None;
        }
        Glass::read(catalogue, source, line)
    };
    DATA.lines().filter_map(read).collect()
});

/// Where glasses stand in the list, and the first of their names that is compared so.
static BY_NAME: LazyLock<HashMap<String, Vec<(usize, &'static str)>>> = LazyLock::new(|| {
    let mut found: HashMap<String, Vec<(usize, &'static str)>> = HashMap::new();
    for (place, glass) in GLASSES.iter().enumerate() {
        for name in &glass.names {
            let places = found.entry(compared(name).collect()).or_default();
            if places.last().is_none_or(|(last, _)| *last != place) {
                places.push((place, name));
            }
        }
    }
    found
});

/// Why a name gives no medium.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CatalogError {
    /// No glass has the name.
    #[error("no glass is named '{name}'; the nearest names are {}", nearest.join(", "))]
    Unknown {
        /// The requested name.
        name: String,
        /// The nearest known names, best first, each with its catalogue.
        nearest: Vec<String>,
    },
    /// Several glasses have the name, and nothing says which is meant.
    #[error("the name '{name}' may mean {}; write one of these", meanings.join(" or "))]
    Ambiguous {
        /// The requested name.
        name: String,
        /// The glasses that have it, each with its catalogue.
        meanings: Vec<String>,
    },
    /// The data of a glass gives no medium.
    #[error(transparent)]
    Medium(#[from] MediumError),
}

/// An entry of the catalogue.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// The maker's catalogue, or `MATERIAL`.
    pub catalogue: &'static str,
    /// Names of the medium, the proper one first.
    pub names: Vec<&'static str>,
    /// Where the numbers come from, and the temperature they hold at where it is known.
    pub source: &'static str,
    /// The index that the maker publishes at 0.5875618 µm (helium d), where the database has it.
    pub published_nd: Option<f64>,
    form: &'static str,
    range: &'static str,
    numbers: &'static str,
}

/// All glasses: single materials first, then catalogue by catalogue.
pub fn glasses() -> &'static [Glass] {
    &GLASSES
}

/// The medium of a glass by name; see the head of this file for what names mean.
///
/// # Errors
/// [`CatalogError::Unknown`] with the nearest names, or [`CatalogError::Ambiguous`] with the meanings.
pub fn medium(name: &str) -> Result<Medium, CatalogError> {
    Ok(glass(name)?.medium()?)
}

/// The entry of a glass by name; see the head of this file for what names mean.
///
/// # Errors
/// As for [`medium`].
pub fn glass(name: &str) -> Result<&'static Glass, CatalogError> {
    let (catalogue, own) = split(name);
    let named = BY_NAME.get(&compared(own).collect::<String>());
    let mut found: Vec<(&Glass, &str)> = { named.into_iter().flatten() }
        .map(|(place, known)| (&glasses()[*place], *known))
        .filter(|(glass, _)| catalogue.is_none_or(|name| same(glass.catalogue, name)))
        .collect();

    // Small letters are a choice, so a name that has them and is spelled as a glass is that glass.
    if own.contains(char::is_lowercase) && found.iter().any(|(_, known)| *known == own) {
        found.retain(|(_, known)| *known == own);
    }

    match found[..] {
        [] => Err(CatalogError::Unknown {
            name: name.to_owned(),
            nearest: nearest(catalogue, own),
        }),
        [(glass, _)] => Ok(glass),
        [..] => found
            .iter()
            .find(|(glass, _)| glass.catalogue == FIRST_CATALOGUE)
            .map(|(glass, _)| *glass)
            .ok_or_else(|| CatalogError::Ambiguous {
                name: name.to_owned(),
                meanings: found.iter().map(|(glass, _)| glass.name()).collect(),
            }),
    }
}

impl Glass {
    /// The entry of one line; none for a remark.
    fn read(catalogue: &'static str, source: &'static str, line: &'static str) -> Option<Self> {
        let columns: Vec<&'static str> = line.split('\t').collect();
        let [names, form, range, nd, numbers] = columns[..] else {
            return None;
        };
        Some(Self {
            catalogue,
            names: names.split(';').collect(),
            source,
            published_nd: nd.parse().ok(),
            form,
            range,
            numbers,
        })
    }

    /// Catalogue and proper name: `SCHOTT:N-BK7`.
    pub fn name(&self) -> String {
        let proper = self.names.first().copied().unwrap_or_default();
        format!("{}:{proper}", self.catalogue)
    }

    /// The medium.
    ///
    /// # Errors
    /// [`MediumError::Malformed`] if the data file is damaged.
    pub fn medium(&self) -> Result<Medium, MediumError> {
        let numbers = numbers(self.numbers);
        let formula = |formula| Dispersion::Formula {
            formula,
            coefficients: numbers.clone(),
            range_um: ends(self.range),
        };
        let dispersion = match self.form {
            "1" => formula(Formula::Sellmeier),
            "2" => formula(Formula::SellmeierSquared),
            "3" => formula(Formula::PowerSeries),
            "4" => formula(Formula::Rational),
            "5" => formula(Formula::Cauchy),
            "n" => Dispersion::Table {
                wavelengths_um: numbers.iter().copied().step_by(2).collect(),
                indices: numbers.iter().copied().skip(1).step_by(2).collect(),
            },
            // A constant; in a damaged file not a number, which is refused.
            _ => Dispersion::Constant(numbers.first().copied().unwrap_or(f64::NAN)),
        };
        Medium::new(self.name(), self.source, dispersion)
    }
}

/// The numbers of a column; what is none becomes not a number, which a medium refuses.
fn numbers(column: &str) -> Vec<f64> {
    column
        .split(' ')
        .map(|number| number.parse().unwrap_or(f64::NAN))
        .collect()
}

/// The two ends of a range.
fn ends(column: &str) -> [f64; 2] {
    match numbers(column)[..] {
        [from, to] => [from, to],
        _ => [f64::NAN; 2],
    }
}

/// Catalogue, if there is one, and glass.
fn split(name: &str) -> (Option<&str>, &str) {
    match name.split_once(':') {
        Some((catalogue, own)) => (Some(catalogue.trim()), own.trim()),
        None => (None, name.trim()),
    }
}

/// The characters of a name that are compared.
fn compared(name: &str) -> impl Iterator<Item = char> {
    name.chars()
        .filter(|c| !matches!(c, '-' | '_') && !c.is_whitespace())
        .flat_map(char::to_lowercase)
}

fn same(a: &str, b: &str) -> bool {
    compared(a).eq(compared(b))
}

/// The nearest names by edits, those that hold the name in full first; of a catalogue if there is one.
fn nearest(catalogue: Option<&str>, own: &str) -> Vec<String> {
    let sought: String = compared(own).collect();
    let in_catalogue = |glass: &&Glass| catalogue.is_some_and(|c| same(c, glass.catalogue));
    let known_catalogue = glasses().iter().any(|glass| in_catalogue(&glass));

    // How far each glass is by the nearest of its names; the order of the file settles ties.
    let mut ranked: Vec<(bool, usize, &Glass)> = glasses()
        .iter()
        .filter(|glass| !known_catalogue || in_catalogue(glass))
        .filter_map(|glass| {
            let (apart, edits) = glass
                .names
                .iter()
                .map(|known| {
                    let known: String = compared(known).collect();
                    let apart = sought.is_empty() || !known.contains(&sought);
                    (apart, strsim::damerau_levenshtein(&known, &sought))
                })
                .min()?;
            Some((apart, edits, glass))
        })
        .collect();
    ranked.sort_by_key(|(apart, edits, _)| (*apart, *edits));
    ranked
        .iter()
        .take(SUGGESTIONS)
        .map(|(_, _, glass)| glass.name())
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::optics::media::catalog::{CatalogError, DATA, glass, glasses, medium};
    use crate::optics::media::medium::{Medium, MediumError};

    /// The d line of helium, in millimetres.
    const D_LINE_MM: f64 = 0.5875618e-3;

    fn index(name: &str, wavelength_mm: f64) -> f64 {
        let medium = medium(name).expect("it is known");
        medium.index(wavelength_mm).expect("it is in range")
    }

    #[test]
    fn crown_at_700_nm_to_the_last_digit() {
        assert!((index("N-BK7", 0.7e-3) - 1.513063997196).abs() < 1e-12);
    }

    #[test]
    fn indices_are_those_that_makers_print() {
        // SCHOTT's data sheets; Malitson 1965 and 1963 (to within the digit printed); nD of water.
        for (name, um, printed, tolerance) in [
            ("N-BK7", 0.5875618, 1.51680, 5e-6),
            ("SF11", 0.5875618, 1.78472, 5e-6),
            ("N-SF11", 0.5875618, 1.78472, 5e-6),
            ("F2", 0.5875618, 1.62004, 5e-6),
            ("fused silica", 0.5875618, 1.45846, 5e-6),
            ("CaF2", 0.5875618, 1.43385, 5e-6),
            ("water", 0.589293, 1.33299, 5e-6),
            ("ZnSe", 10.6, 2.4028, 5e-5),
        ] {
            let found = index(name, um * 1e-3);
            assert!((found - printed).abs() < tolerance, "{name}: {found}");
        }

        // Crystran's handbook of 2023 for KRS-5, to all its digits.
        for (um, printed) in [
            (1.0, 2.44620),
            (5.0, 2.37979),
            (10.0, 2.37069),
            (20.0, 2.34058),
        ] {
            let found = index("KRS-5", um * 1e-3);
            assert!((found - printed).abs() < 6e-6, "{um}: {found}");
        }
    }

    #[test]
    fn plastics_and_semiconductors_agree_with_other_measurements_as_far_as_those_do() {
        // The table of Sultanova 2009, three digits; the catalogue has a fit to it.
        let um = [0.4368, 0.4861, 0.5876, 0.6328, 0.703, 0.833, 0.879, 1.052];
        let tables = [
            (
                "PMMA Sultanova",
                [1.502, 1.497, 1.491, 1.489, 1.486, 1.484, 1.483, 1.481],
                5.5e-4,
            ),
            (
                "polycarbonate",
                [1.612, 1.599, 1.585, 1.580, 1.575, 1.569, 1.568, 1.565],
                1.1e-3,
            ),
            (
                "polystyrene",
                [1.617, 1.606, 1.592, 1.587, 1.582, 1.577, 1.576, 1.572],
                8e-4,
            ),
            (
                "NAS-21",
                [1.593, 1.584, 1.571, 1.568, 1.564, 1.558, 1.557, 1.554],
                5.5e-4,
            ),
        ];
        for (name, printed, tolerance) in tables {
            for (um, n) in um.iter().zip(printed) {
                let found = index(name, um * 1e-3);
                assert!(
                    (found - n).abs() < tolerance,
                    "{name} at {um}: {found} for {n}"
                );
            }
        }

        // Another sample by another laboratory: lens designers' PMMA (nd 1.4918) against Beadie 2015,
        // Li 1980 against Salzberg and Burnett, Bond 1965 against Debenham.
        for (name, um, n, tolerance) in [
            ("PMMA", 0.5875618, 1.4918, 8e-4),
            ("Si", 4.0, 3.4229, 2.5e-3),
            ("Si", 10.0, 3.4150, 2.8e-3),
            ("Ge", 4.0, 4.0242, 6e-4),
            ("Ge", 10.0, 4.0025, 1.6e-3),
            ("ZnS", 1.0, 2.2932, 8e-4),
            ("ZnS", 2.0, 2.2653, 5e-5),
        ] {
            let found = index(name, um * 1e-3);
            assert!(
                (found - n).abs() < tolerance,
                "{name} at {um}: {found} for {n}"
            );
        }
    }

    #[test]
    fn every_formula_gives_the_index_its_maker_publishes() {
        let mut compared = 0;
        for glass in glasses() {
            let Some(nd) = glass.published_nd else {
                continue;
            };
            // BOROFLOAT's is printed to three decimals.
            let tolerance = if glass.names[0] == "BOROFLOAT33" {
                5e-4
            } else {
                4e-5
            };
            let found = index(&glass.name(), D_LINE_MM);
            assert!(
                (found - nd).abs() < tolerance,
                "{}: {found} for {nd}",
                glass.name()
            );
            compared += 1;
        }
        assert_eq!(compared, 1626);
    }

    #[test]
    fn every_line_of_the_data_is_a_glass() {
        let lines = DATA.lines().filter(|line| !line.starts_with(['=', '#']));
        assert_eq!(glasses().len(), lines.count());
        assert_eq!(glasses().len(), 1745);
        for glass in glasses() {
            let medium = glass.medium().expect("it is well formed");
            assert!(!glass.source.is_empty() && !medium.source().is_empty());
            let constant = medium.range_um().is_none();
            assert_eq!(constant, matches!(glass.names[0], "air" | "vacuum"));
        }
    }

    /// The largest step of the index over a range cut into equal ratios; checks that 1 < n < 6.
    fn largest_step(medium: &Medium, [from, to]: [f64; 2], cuts: u32) -> f64 {
        let at = |i: u32| {
            let um = from * (to / from).powf(f64::from(i) / f64::from(cuts));
            let n = medium.index(um * 1e-3).expect("it is in range");
            assert!(n > 1.0 && n < 6.0, "{}: {n} at {um} µm", medium.name());
            n
        };
        (1..=cuts)
            .map(|i| (at(i) - at(i - 1)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn every_index_is_plausible_and_continuous() {
        for glass in glasses() {
            let medium = glass.medium().expect("it is well formed");
            let Some(range) = medium.range_um() else {
                continue;
            };
            // Where nothing jumps, steps of a quarter the width are a quarter as high.
            let coarse = largest_step(&medium, range, 250);
            let fine = largest_step(&medium, range, 1000);
            assert!(fine < 0.35 * coarse, "{}: {coarse} {fine}", glass.name());
        }
    }

    #[test]
    fn names_are_found_however_they_are_written() {
        for name in [
            "N-BK7",
            "NBK7",
            "n-bk7",
            "N BK7",
            " n_bk7 ",
            "SCHOTT:N-BK7",
            "schott: nbk7",
        ] {
            assert_eq!(medium(name).expect(name).name(), "SCHOTT:N-BK7");
        }
        for name in [
            "fused silica",
            "F_SILICA",
            "SiO2",
            "Fused Silica",
            "material:silica",
        ] {
            assert_eq!(medium(name).expect(name).name(), "MATERIAL:fused silica");
        }
        // Every glass is found by catalogue and any of its names.
        for known in glasses() {
            for name in &known.names {
                let found = glass(&format!("{}:{name}", known.catalogue)).expect(name);
                assert_eq!(found, known);
            }
        }
    }

    #[test]
    fn a_name_that_several_bear_is_schotts_or_refused() {
        assert_eq!(medium("F2").expect("it is known").name(), "SCHOTT:F2");
        assert!((index("CDGM:F2", D_LINE_MM) - 1.612929).abs() < 1e-6);
        let error = medium("F1").expect_err("three makers have one");
        assert_eq!(
            error.to_string(),
            "the name 'F1' may mean CDGM:F1 or HIKARI:F1 or LZOS:F1; write one of these"
        );

        // The crystal and the glass that differ by a capital.
        assert_eq!(medium("BaF2").expect("as written").name(), "MATERIAL:BaF2");
        for name in ["BAF2", "baf2"] {
            assert!(matches!(medium(name), Err(CatalogError::Ambiguous { .. })));
        }
        assert_eq!(medium("CDGM:BAF2").expect("the glass").name(), "CDGM:BAF2");
    }

    #[test]
    fn an_unknown_name_brings_the_nearest() {
        let error = medium("BK7").expect_err("the glass with lead and arsenic is not listed");
        assert_eq!(
            error.to_string(),
            "no glass is named 'BK7'; the nearest names are SCHOTT:N-BK7, SCHOTT:P-BK7, \
             SUMITA:K-BK7, HIKARI:E-BK7, HIKARI:J-BK7"
        );
        let first = |name: &str| match medium(name) {
            Err(CatalogError::Unknown { nearest, .. }) => nearest[0].clone(),
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(first("fused silca"), "MATERIAL:fused silica");
        assert_eq!(first("vaccum"), "MATERIAL:vacuum");
        assert_eq!(first("OHARA:S-BSL77"), "OHARA:S-BSL7");
        assert_eq!(first("SCHOT:N-SF6"), "SCHOTT:N-SF6");
        assert!(matches!(medium(""), Err(CatalogError::Unknown { .. })));
    }

    #[test]
    fn surroundings_are_one_and_ranges_hold() {
        for name in ["air", "vacuum", "AIR"] {
            assert_eq!(index(name, 0.5e-3), 1.0);
            assert_eq!(index(name, 10.6e-3), 1.0);
        }
        let error = medium("SF11").expect("it is known").index(0.3e-3);
        assert!(matches!(error, Err(MediumError::OutOfRange { .. })));
    }
}
