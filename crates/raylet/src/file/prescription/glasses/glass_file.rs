//! Glasses of users: catalogues in the format of Zemax (.agf).
//!
//! A glass has a record NM (name, number of its formula), CD (coefficients) and LD (shortest and longest wavelength in µm).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::glasses::formula_table::tabulated;
use crate::file::prescription::lens_file::bytes_of;
use crate::file::prescription::lens_text::{LensText, Record};
use crate::file::scene::material::OwnMedium;

/// The range in µm of a glass whose file states none.
const RANGE: [f64; 2] = [0.3, 2.5];

/// The formulas by their numbers from 1.
const FORMULAS: [&str; 13] = [
    "Schott",
    "Sellmeier 1",
    "Herzberger",
    "Sellmeier 2",
    "Conrady",
    "Sellmeier 3",
    "Handbook of Optics 1",
    "Handbook of Optics 2",
    "Sellmeier 4",
    "Extended",
    "Sellmeier 5",
    "Extended 2",
    "Extended 3",
];

/// The numbers of formulas Σ K λ²/(λ² − L), which scenes have themselves.
const SELLMEIER: [usize; 3] = [2, 6, 11];

/// Catalogues of a user, in the order in which names are sought in them.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlassFiles(Vec<GlassFile>);

/// One catalogue.
#[derive(Clone, Debug)]
struct GlassFile {
    text: LensText,
    glasses: BTreeMap<String, Entry>,
}

/// A glass of a catalogue.
#[derive(Clone, Debug)]
struct Entry {
    name: String,
    /// The line of its record NM.
    line: usize,
    formula: usize,
    coefficients: Vec<f64>,
    range_um: [f64; 2],
    /// A fault of its records, for a lens that has it.
    fault: Option<Fault>,
}

/// A glass that was found, and where, in words.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundGlass {
    /// Its medium.
    pub medium: OwnMedium,
    /// Where it stands and how the scene has it.
    pub source: String,
}

impl GlassFiles {
    /// Reads catalogues.
    ///
    /// # Errors
    /// A file that cannot be read, or the first fault of its text with its line.
    pub(crate) fn read(paths: &[PathBuf]) -> Result<Self, Fault> {
        let read = |path: &PathBuf| {
            let bytes = bytes_of(path, "a readable catalogue of glasses (.agf)")?;
            GlassFile::read(&bytes, path)
        };
        Ok(Self(paths.iter().map(read).collect::<Result<_, _>>()?))
    }

    /// The same catalogues and then those of an archive, of which the ones that a lens names come first, in its order.
    ///
    /// # Errors
    /// The first fault of a catalogue's text, with its line.
    pub(crate) fn followed_by(
        mut self,
        archived: &[(PathBuf, Vec<u8>)],
        order: &[String],
    ) -> Result<Self, Fault> {
        let place = |path: &Path| {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let named = order
                .iter()
                .position(|name| name.eq_ignore_ascii_case(&stem));
            named.unwrap_or(order.len())
        };
        let mut sorted: Vec<_> = archived.iter().collect();
        sorted.sort_by_key(|(path, _)| place(path));
        for (path, bytes) in sorted {
            self.0.push(GlassFile::read(bytes, path)?);
        }
        Ok(self)
    }

    /// The glass of this name in the first catalogue that has it.
    ///
    /// # Errors
    /// A glass whose formula has no index in its range, at its line.
    pub(crate) fn find(&self, name: &str) -> Result<Option<FoundGlass>, Fault> {
        let key = compared(name);
        for file in &self.0 {
            if let Some(entry) = file.glasses.get(&key) {
                return file.found(entry).map(Some);
            }
        }
        Ok(None)
    }
}

impl GlassFile {
    /// Reads the bytes of a catalogue.
    fn read(bytes: &[u8], path: &Path) -> Result<Self, Fault> {
        let text = LensText::new(bytes, path);
        let mut glasses: BTreeMap<String, Entry> = BTreeMap::new();
        let mut current: Option<Entry> = None;
        let keep = |entry: Option<Entry>, glasses: &mut BTreeMap<String, Entry>| {
            if let Some(entry) = entry {
                glasses.entry(compared(&entry.name)).or_insert(entry);
            }
        };
        for record in text.records() {
            if record.word == "NM" {
                keep(current.take(), &mut glasses);
                current = Some(Entry::new(&text, &record)?);
            } else if let Some(entry) = &mut current
                && let Err(fault) = entry.read_record(&text, &record)
            {
                entry.fault.get_or_insert(fault);
            }
        }
        keep(current, &mut glasses);
        if glasses.is_empty() {
            let expected = "records NM, CD and LD, as catalogues of Zemax have them";
            return Err(text.fault_of_file("no glasses", expected));
        }
        Ok(Self { text, glasses })
    }

    fn found(&self, entry: &Entry) -> Result<FoundGlass, Fault> {
        if let Some(fault) = &entry.fault {
            return Err(fault.clone());
        }
        let kind = FORMULAS.get(entry.formula - 1).copied().unwrap_or_default();
        let file = self.text.file_name();
        let source = format!("line {} of {file}, by its formula {kind}", entry.line);
        let refuse = |found: String| {
            let expected = "a formula with an index from 1 to 10 in its range (CD, LD)";
            self.text.fault_of_line(entry.line, found, expected)
        };
        if SELLMEIER.contains(&entry.formula) {
            let pairs = entry.coefficients.as_chunks().0.to_vec();
            let medium = OwnMedium {
                sellmeier: Some(pairs),
                range_um: Some(entry.range_um),
                ..OwnMedium::default()
            };
            medium.medium().map_err(|(found, _)| refuse(found))?;
            return Ok(FoundGlass { medium, source });
        }
        let table = tabulated(|um| entry.index(um), entry.range_um);
        let (medium, error) = table.ok_or_else(|| {
            let [from, to] = entry.range_um;
            refuse(format!("a glass without an index from {from} to {to} µm"))
        })?;
        let count = medium.indices.as_ref().map_or(0, Vec::len);
        Ok(FoundGlass {
            medium,
            source: format!("{source}, as a table of {count} indices that keeps it to {error:.0e}"),
        })
    }
}

impl Entry {
    /// The glass of a record NM: its name, and the number of its formula. Faults of a glass count where a lens has it: a
    /// catalogue has many others.
    fn new(text: &LensText, record: &Record<'_>) -> Result<Self, Fault> {
        let name = record.values.first().copied().unwrap_or_default();
        if name.is_empty() {
            return Err(text.fault(record.word, "a glass without a name", "its name behind NM"));
        }
        let formula = Self::formula(text, record);
        Ok(Self {
            name: name.to_owned(),
            line: record.line,
            formula: formula.as_ref().map_or(1, |number| *number),
            coefficients: Vec::new(),
            range_um: RANGE,
            fault: formula.err(),
        })
    }

    /// The number of its formula.
    fn formula(text: &LensText, record: &Record<'_>) -> Result<usize, Fault> {
        let number = text.value(record, 1)?;
        if number.fract() == 0.0 && (1.0..=13.0).contains(&number) {
            return Ok(number as usize);
        }
        let word = record.values.get(1).copied().unwrap_or(record.word);
        let found = format!("a formula of number {}", shortened(word));
        Err(text.fault(word, found, "a formula from 1 to 13"))
    }

    fn read_record(&mut self, text: &LensText, record: &Record<'_>) -> Result<(), Fault> {
        match record.word {
            "CD" => {
                let words = record.values.iter().take(10);
                let numbers: Result<Vec<f64>, Fault> =
                    words.map(|word| text.number(word)).collect();
                self.coefficients = numbers?;
                self.coefficients.resize(10, 0.0);
            }
            "LD" => {
                let range = [text.value(record, 0)?, text.value(record, 1)?];
                if !(range[0] > 0.0 && range[1] > range[0]) {
                    let found = format!("wavelengths from {} to {} µm", range[0], range[1]);
                    let expected = "a shorter and a longer wavelength in µm";
                    return Err(text.fault(record.word, found, expected));
                }
                self.range_um = range;
            }
            _ => {}
        }
        Ok(())
    }

    /// The index at a wavelength in µm; not a number where the formula has none.
    fn index(&self, um: f64) -> f64 {
        let c = |place: usize| self.coefficients.get(place).copied().unwrap_or(0.0);
        let square = um * um;
        // Σ of coefficients from `first` on times powers of λ.
        let series = |powers: &[i32]| -> f64 {
            let terms = powers.iter().enumerate();
            terms.map(|(place, power)| c(place) * um.powi(*power)).sum()
        };
        let squared = match self.formula {
            1 => series(&[0, 2, -2, -4, -6, -8]),
            3 => {
                let l = 1.0 / (square - 0.028);
                let rest = c(3) * square + c(4) * square.powi(2) + c(5) * square.powi(3);
                return c(0) + c(1) * l + c(2) * l * l + rest;
            }
            4 => {
                let first = c(1) * square / (square - c(2) * c(2));
                1.0 + c(0) + first + c(3) / (square - c(4) * c(4))
            }
            5 => return c(0) + c(1) / um + c(2) / um.powf(3.5),
            7 => c(0) + c(1) / (square - c(2)) - c(3) * square,
            8 => c(0) + c(1) * square / (square - c(2)) - c(3) * square,
            9 => c(0) + c(1) * square / (square - c(2)) + c(3) * square / (square - c(4)),
            10 => series(&[0, 2, -2, -4, -6, -8, -10, -12]),
            12 => series(&[0, 2, -2, -4, -6, -8, 4, 6]),
            13 => series(&[0, 2, 4, -2, -4, -6, -8, -10, -12]),
            _ => {
                let pairs = self.coefficients.as_chunks::<2>().0.iter();
                1.0 + pairs.map(|[k, l]| k * square / (square - l)).sum::<f64>()
            }
        };
        squared.sqrt()
    }
}

/// A name as names are compared: hyphens, underscores, blanks and capitals do not matter.
fn compared(name: &str) -> String {
    let letters = name
        .chars()
        .filter(|c| !matches!(c, '-' | '_') && !c.is_whitespace());
    letters.flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::prescription::glasses::glass_file::{Entry, GlassFile, GlassFiles};
    use crate::optics::media::catalog;

    fn files(text: &str) -> GlassFiles {
        GlassFiles(vec![
            GlassFile::read(text.as_bytes(), Path::new("a.agf")).unwrap(),
        ])
    }

    fn index(text: &str, name: &str, um: f64) -> f64 {
        let found = files(text).find(name).unwrap().unwrap();
        found.medium.medium().unwrap().index(um * 1e-3).unwrap()
    }

    /// Formula 2 with SCHOTT's published numbers is the glass of the catalogue, and so is the same glass by its series.
    #[test]
    fn a_glass_of_the_catalogue_has_its_index() {
        let text = "CC a catalogue\nNM N-BK7 2 517642.251 1.5168 64.17 0 1\nGC\nED 7.1 8.3 2.51 -0.0009 0\n\
                    CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653 0 0 0 0\nTD - 0\nLD 0.3 2.5\n";
        let glass = catalog::medium("SCHOTT:N-BK7").unwrap();
        for um in [0.3, 0.4861327, 0.5875618, 1.06, 2.5] {
            let known = glass.index(um * 1e-3).unwrap();
            for name in ["N-BK7", "nbk7"] {
                assert!((index(text, name, um) - known).abs() < 1e-12, "{um}");
            }
        }
        let found = files(text).find("NBK7").unwrap().unwrap();
        assert_eq!(found.source, "line 2 of a.agf, by its formula Sellmeier 1");
        assert!(files(text).find("N-BK8").unwrap().is_none());
    }

    /// Each formula with numbers of its own, beside its closed form written out.
    #[test]
    fn every_formula_is_its_closed_form() {
        let c = [
            2.2, 0.011, 0.012, 0.0013, 0.00014, 0.00015, 0.00016, 0.000017, 0.0000018, 0.0,
        ];
        let w: f64 = 0.6;
        let s = w * w;
        let l = 1.0 / (s - 0.028);
        let sum = |k: [f64; 5], l: [f64; 5]| -> f64 { (0..5).map(|i| k[i] * s / (s - l[i])).sum() };
        let pairs = sum(
            [c[0], c[2], c[4], c[6], c[8]],
            [c[1], c[3], c[5], c[7], c[9]],
        );
        let schott =
            c[0] + c[1] * s + c[2] / s + c[3] / s.powi(2) + c[4] / s.powi(3) + c[5] / s.powi(4);
        let extended = schott + c[6] / s.powi(5) + c[7] / s.powi(6);
        let third = c[0]
            + c[1] * s
            + c[2] * s.powi(2)
            + c[3] / s
            + c[4] / s.powi(2)
            + c[5] / s.powi(3)
            + c[6] / s.powi(4)
            + c[7] / s.powi(5)
            + c[8] / s.powi(6);
        for (formula, expected) in [
            (1, schott.sqrt()),
            (2, (1.0 + pairs).sqrt()),
            (
                3,
                c[0] + c[1] * l + c[2] * l * l + c[3] * s + c[4] * s.powi(2) + c[5] * s.powi(3),
            ),
            (
                4,
                (1.0 + c[0] + c[1] * s / (s - c[2].powi(2)) + c[3] / (s - c[4].powi(2))).sqrt(),
            ),
            (5, c[0] + c[1] / w + c[2] / w.powf(3.5)),
            (6, (1.0 + pairs).sqrt()),
            (7, (c[0] + c[1] / (s - c[2]) - c[3] * s).sqrt()),
            (8, (c[0] + c[1] * s / (s - c[2]) - c[3] * s).sqrt()),
            (
                9,
                (c[0] + c[1] * s / (s - c[2]) + c[3] * s / (s - c[4])).sqrt(),
            ),
            (10, extended.sqrt()),
            (11, (1.0 + pairs).sqrt()),
            (12, (schott + c[6] * s.powi(2) + c[7] * s.powi(3)).sqrt()),
            (13, third.sqrt()),
        ] {
            let entry = Entry {
                name: "A".to_owned(),
                line: 1,
                formula,
                coefficients: c.to_vec(),
                range_um: [0.4, 0.8],
                fault: None,
            };
            assert!(
                (entry.index(w) - expected).abs() < 1e-12,
                "{formula}: {} {expected}",
                entry.index(w)
            );
            // The scene has it, as a formula or as a table.
            let text = format!(
                "NM A {formula} 0 0 0\nCD {}\nLD 0.4 0.8\n",
                c.map(|c| c.to_string()).join(" ")
            );
            assert!((index(&text, "A", w) - expected).abs() < 2e-9, "{formula}");
        }
    }

    #[test]
    fn faults_name_the_line() {
        for (text, start) in [
            ("", "a.agf: found no glasses"),
            ("NM A 14 0 0 0\n", "a.agf:1:6: found a formula of number 14"),
            ("NM A x 0 0 0\n", "a.agf:1:6: found x"),
            ("NM A 2\nCD 1 y\n", "a.agf:2:6: found y"),
            (
                "NM A 2\nCD 1 0\nLD 0.8 0.4\n",
                "a.agf:3:1: found wavelengths from 0.8 to 0.4",
            ),
        ] {
            let read = GlassFile::read(text.as_bytes(), Path::new("a.agf"));
            let fault = match read {
                Ok(file) => GlassFiles(vec![file]).find("A").unwrap_err(),
                Err(fault) => fault,
            };
            assert!(fault.to_string().starts_with(start), "{fault}");
        }

        // The other glasses of the catalogue are as they are.
        let good = "NM B 2 0 0 0\nCD 1.2 0.01\nLD 0.4 0.8\n";
        let text = format!("NM A 2\nCD 1 0\nLD 0 0\n{good}");
        assert_eq!(index(&text, "B", 0.6), index(good, "B", 0.6));
        let fault = files("NM A 1 0 0 0\nCD -1 0\nLD 0.4 0.8\n")
            .find("A")
            .unwrap_err();
        assert!(
            fault
                .to_string()
                .starts_with("a.agf:1:1: found a glass without an index"),
            "{fault}"
        );
    }
}
