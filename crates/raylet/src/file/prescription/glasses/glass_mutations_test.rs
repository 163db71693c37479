//! Tests: altered catalogues of glasses give a medium or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_catalogues` makes a long run.

use std::path::Path;

use crate::file::prescription::glasses::glass_file::GlassFiles;
use crate::fixtures::mutations::{Numbers, mutation_count};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 600;

/// Words that stand in place of numbers.
const NUMBERS: [&str; 18] = [
    "0", "-0", "-1", "1", "2", "13", "14", "0.5", "1e-320", "1e-12", "1e12", "-1e12", "1e308",
    "nan", "inf", "-inf", "", "x",
];

/// Records that stand in place of others.
const RECORDS: [&str; 8] = [
    "NM B 1 0 1.5 60 0 1",
    "NM N-BK7 2",
    "NM",
    "CD 2.25 0 0 0 0 0",
    "CD 1.04 0.006 0.23 0.02 1.01 103.5 0 0 0 0",
    "LD 0.3 2.5",
    "LD 2.5 0.3",
    "GC a remark",
];

/// A catalogue with a glass of this formula.
fn catalogue(formula: usize) -> String {
    format!(
        "CC test\nNM A {formula} 517642 1.5168 64.2 0 1\nGC\nED 7.1 8.3 2.5 0 0\n\
         CD 2.2 0.011 0.012 0.0013 0.00014 0.00015 0.00016 0.000017 0.0000018 0\nTD - 0\nLD 0.4 0.8\n"
    )
}

/// A text with one to four of its lines or words altered.
fn altered(text: &str, numbers: &mut Numbers) -> Vec<u8> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=numbers.below(4) {
        if lines.is_empty() {
            break;
        }
        let at = numbers.below(lines.len());
        match numbers.below(7) {
            0 => lines.insert(at, RECORDS[numbers.below(RECORDS.len())].to_owned()),
            1 => drop(lines.remove(at)),
            _ => {
                let mut words: Vec<&str> = lines[at].split(' ').collect();
                let place = numbers.below(words.len());
                words[place] = NUMBERS[numbers.below(NUMBERS.len())];
                lines[at] = words.join(" ");
            }
        }
    }
    let mut bytes = lines.join("\n").into_bytes();
    if numbers.below(6) == 0 && !bytes.is_empty() {
        let at = numbers.below(bytes.len());
        bytes[at] ^= 1 << numbers.below(8);
    }
    bytes
}

#[test]
fn mutated_catalogues_give_a_medium_or_an_error() {
    let count = mutation_count(MUTATIONS);
    let mut good = 0;
    for seed in 0..count {
        let mut numbers = Numbers(seed);
        let bytes = altered(&catalogue(1 + numbers.below(13)), &mut numbers);
        let file = [(Path::new("a.agf").to_path_buf(), bytes)];
        let found = GlassFiles::default().followed_by(&file, &[]);
        match found.and_then(|files| files.find("A")) {
            Ok(Some(found)) => {
                let medium = found.medium.medium().unwrap();
                let range = found.medium.range_um.unwrap_or([0.4, 0.8]);
                let index = medium.index(0.5e-3 * (range[0] + range[1]));
                // A formula may have no real index there.
                assert!(
                    index.is_err() || index.is_ok_and(f64::is_finite),
                    "seed {seed}"
                );
                good += 1;
            }
            Ok(None) => {}
            Err(fault) => {
                let message = fault.to_string();
                assert!(message.starts_with("a.agf"), "seed {seed}: {message}");
                assert!(message.len() < 20_000, "seed {seed}");
            }
        }
    }
    assert!(good > count / 5, "{good} of {count}");
}
