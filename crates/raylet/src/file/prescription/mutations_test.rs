//! Tests: lens files whose bytes, lines and numbers are altered give a scene or an error with its file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated` makes a long run of each format.

use std::fs;
use std::path::Path;

use crate::file::prescription::import::{ImportChoices, import_bytes};
use crate::file::prescription::lens_text::decoded;
use crate::file::scene::scene_file::Scene;
use crate::fixtures::mutations::{Numbers, mutation_count};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 600;

/// Words that stand in place of numbers.
const NUMBERS: [&str; 20] = [
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "1e-320",
    "1e-12",
    "1e12",
    "-1e12",
    "1e155",
    "1e308",
    "nan",
    "inf",
    "-inf",
    "INFINITY",
    "9223372036854775808",
    "0.1",
    "1e6",
    "",
    "x",
];

/// Records of Zemax that stand in place of others.
const ZEMAX: [&str; 34] = [
    "SURF 3",
    "STOP",
    "TYPE STANDARD",
    "TYPE EVENASPH",
    "TYPE ODDASPHE",
    "TYPE XASPHERE",
    "TYPE XPOLYNOM",
    "TYPE BICONICX",
    "TYPE TOROIDAL",
    "TYPE COORDBRK",
    "TYPE PARAXIAL",
    "TYPE DGRATING",
    "TYPE BINARY_2",
    "GLAS MIRROR",
    "GLAS ___BLANK 1 0 1.7 30",
    "GLAS N-BK7",
    "XDAT 1 3",
    "XDAT 2 2",
    "XDAT 3 0.01",
    "PARM 1 0.1",
    "OBSC 0 1",
    "UNIT IN",
    "FNUM 2 1",
    "FLOA",
    "TYPE SZERNSAG",
    "TYPE FZERNSAG",
    "TYPE FZERNPHA",
    "TYPE GRID_SAG",
    "TYPE GRID_PHA",
    "GDAT 4 4 9 9 0 0",
    "GARR 0 1 0 0 0 0",
    "TYPE BLACKBOX",
    "MNUM 2 1",
    "THIC 1 2 3.5 0 0",
];

/// Commands of CODE V that stand in place of others.
const CODEV: [&str; 45] = [
    "S 50 5 NBK7_SCHOTT",
    "s .1 &",
    "S 0 -5 REFL",
    "S",
    "SI 0 0.1",
    "SO 0 100",
    "S2 20 3 517.642",
    "STO",
    "STO S2",
    "RDM",
    "RDM N",
    "DIM I",
    "FNO 4",
    "NA 0.2",
    "NAO 0.1",
    "YAN 0 5 10",
    "YIM F2 3",
    "YOB 1 2",
    "WL 656 587 486",
    "REF 2",
    "CIR 2",
    "CIR OBS L'a' 0.5",
    "REX 2; REY 3; ADY 1; ARO 20",
    "ELX EDG 2",
    "CON; K -1",
    "ASP; A 1e-4; B 1e-6",
    "YTO; RDX 20",
    "CYL",
    "SPS ODD; SCO C4 1e-4",
    "SPS XYP; SCO C7 1e-4",
    "SPS ZFR; SCO NRADIUS 9; SCO C8 1e-4",
    "XDE 1; YDE 2; ZDE 3; ADE 10; BDE 5",
    "DAR",
    "ADE 30; BEN",
    "REV",
    "DIF DOE; HCT R; HWL 550; HCO C1 -1e-3; HCO C3 1e-9",
    "DIF GRT; GRS 0.002; GRO 1",
    "PRV; PWL 400 500 600; 'G' 1.5 1.4 1.3; END",
    "GLA 'G'",
    "PIM",
    "PIK RDY S2 RDY S1 -1",
    "THI UMY 0.1",
    "ZOO 2",
    "ZOO THI S1 2 3",
    "GO",
];

/// The text of a file, with one to four of its lines or numbers altered.
fn altered(text: &str, records: &[&str], separator: u8, numbers: &mut Numbers) -> Vec<u8> {
    let separator = char::from(separator);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=numbers.below(4) {
        if lines.is_empty() {
            break;
        }
        let at = numbers.below(lines.len());
        let record = records[numbers.below(records.len())].to_owned();
        match numbers.below(9) {
            0 => lines.insert(at, record),
            1 => lines[at] = record,
            2 => drop(lines.remove(at)),
            3 => {
                let other = lines[numbers.below(lines.len())].clone();
                lines.insert(at, other);
            }
            4 => lines.truncate(at.max(1)),
            _ => {
                let mut words: Vec<&str> = match separator {
                    ' ' => lines[at].split_whitespace().collect(),
                    separator => lines[at].split(separator).collect(),
                };
                if words.len() > 1 {
                    let place = 1 + numbers.below(words.len() - 1);
                    words[place] = NUMBERS[numbers.below(NUMBERS.len())];
                }
                lines[at] = words.join(&separator.to_string());
            }
        }
    }
    let mut bytes = lines.join("\n").into_bytes();
    if numbers.below(8) == 0 && !bytes.is_empty() {
        let at = numbers.below(bytes.len());
        bytes[at] ^= 1 << numbers.below(8);
    }
    bytes
}

#[test]
fn mutated_files_of_zemax_give_a_scene_or_an_error() {
    mutate("zmx", &ZEMAX);
}

/// Lines of tables that stand in place of others.
const TABLE: [&str; 14] = [
    "radius, thickness, glass, semi_diameter, conic, a4",
    "curvature,thickness",
    "# wavelengths_um: 0.5, 0.6",
    "# wavelengths_um: 1e9",
    "# fields_deg: 0, 5, 80",
    "# object_mm: 100",
    "# object_mm: 0",
    "stop,,5,,4,,",
    "front,50,3,N-BK7,6,-0.5,1e-6",
    "a,-50,inf,mirror,6,,",
    "b,1e-9,3,NOGLASS,6,,",
    ",,,,,,,,,,,,",
    "c,0,0,,0,0,0",
    "\"quoted, name\",20,1,,3,,",
];

/// A table as the guide has it.
const TABLES: [&str; 2] = [
    "# wavelengths_um: 0.5876\nname, radius, thickness, glass, semi_diameter, conic, a4\nstop, , 5, , 4, ,\n\
     front, 50, 3, N-BK7, 6, -0.5, 1e-6\nback, -50, 40, , 6, ,\n",
    "# fields_deg: 0, 3\n# object_mm: 200\ncurvature,thickness,glass,semi_diameter,stop\n0.01,4,517642,8,\n-0.01,2,,8,\n\
     0,6,,3,x\n0.02,80,mirror,9,\n",
];

#[test]
fn mutated_tables_give_a_scene_or_an_error() {
    mutate_texts("csv", &TABLE, &TABLES.map(str::to_owned), b',');
}

#[test]
fn mutated_files_of_codev_give_a_scene_or_an_error() {
    mutate("seq", &CODEV);
}

/// Reads altered files of this kind.
fn mutate(kind: &str, records: &[&str]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/prescriptions");
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files
        .filter(|path| {
            path.extension()
                .is_some_and(|end| end.eq_ignore_ascii_case(kind))
        })
        .collect();
    files.sort();
    let texts: Vec<String> = files
        .iter()
        .map(|file| decoded(&fs::read(file).unwrap()))
        .collect();
    mutate_texts(kind, records, &texts, b' ');
}

/// Reads altered texts of this kind, whose words stand between separators.
fn mutate_texts(kind: &str, records: &[&str], texts: &[String], separator: u8) {
    let count = mutation_count(MUTATIONS);
    let (name, mut scenes) = (format!("a.{kind}"), 0);
    for seed in 0..count {
        let mut numbers = Numbers(seed);
        let bytes = altered(
            &texts[numbers.below(texts.len())],
            records,
            separator,
            &mut numbers,
        );
        let choices = ImportChoices {
            field: 1 + numbers.below(2),
            skip_unknown: numbers.below(2) == 0,
            configuration: [None, Some(1), Some(2)][numbers.below(3)],
            ..ImportChoices::default()
        };
        match import_bytes(&bytes, Path::new(&name), &choices) {
            Ok(lens) => {
                let text = lens.scene.to_toml().unwrap();
                assert!(Scene::parse(&text, Path::new("")).is_ok(), "seed {seed}");
                let mut numbers = lens.report.numbers.iter();
                let finite = numbers.all(|number| number.value.is_none_or(f64::is_finite));
                assert!(finite, "seed {seed}: {}", lens.report);
                scenes += 1;
            }
            Err(fault) => {
                let message = fault.to_string();
                assert!(message.starts_with(&name), "seed {seed}: {message}");
                assert!(message.len() < 20_000, "seed {seed}");
            }
        }
    }
    // Many mutations leave a lens; a table has few words that may be another.
    let part = if kind == "csv" { 20 } else { 5 };
    assert!(scenes > count / part, "{scenes} of {count}");
}
