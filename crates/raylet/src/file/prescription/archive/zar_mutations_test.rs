//! Tests: altered archives give a scene or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_archives` makes a long run.

use std::path::Path;

use crate::file::prescription::archive::zar_test::{LENS, archive, catalogue};
use crate::file::prescription::import::{ImportChoices, import_bytes};
use crate::fixtures::mutations::{Numbers, altered_bytes, mutation_count};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 600;

#[test]
fn mutated_archives_give_a_scene_or_an_error() {
    let count = mutation_count(MUTATIONS);
    let glasses = catalogue(1.6);
    let mut good = 0;
    for seed in 0..count {
        let mut numbers = Numbers(seed);
        let [lens, agf] = [["a.zmx", "b.agf"], ["a.zmx.LZW", "b.agf.LZW"]][numbers.below(2)];
        let files = [
            (lens, LENS.as_bytes()),
            (agf, glasses.as_bytes()),
            ("c.zec", b"abc"),
        ];
        let version = [1002, 1004][numbers.below(2)];
        let bytes = altered_bytes(&archive(version, &files), 72, &mut numbers);
        let choices = ImportChoices {
            skip_unknown: numbers.below(2) == 0,
            ..ImportChoices::default()
        };
        match import_bytes(&bytes, Path::new("a.zar"), &choices) {
            Ok(lens) => {
                assert!(lens.report.to_string().len() < 20_000, "seed {seed}");
                good += 1;
            }
            Err(fault) => {
                let message = fault.to_string();
                assert!(message.starts_with("a.zar"), "seed {seed}: {message}");
                assert!(message.len() < 20_000, "seed {seed}");
            }
        }
    }
    assert!(good > count / 20, "{good} of {count}");
}
