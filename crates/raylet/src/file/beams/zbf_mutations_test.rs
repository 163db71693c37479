//! Tests: altered beam files give a field or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_beam` makes a long run.

use std::fs;

use crate::file::beams::zbf_fields::{BeamChoices, read_zbf};
use crate::file::beams::zbf_test::{LIMIT, bytes_of};
use crate::fixtures::mutations::{Numbers, altered_bytes, mutation_count};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 600;

#[test]
fn mutated_beam_files_give_a_field_or_an_error() {
    let count = mutation_count(MUTATIONS);
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.zbf");
    let mut good = 0;
    for seed in 0..count {
        let mut numbers = Numbers(seed);
        let layout = [20, 10, 11][numbers.below(3)];
        let file = bytes_of(
            layout,
            [5, 4],
            numbers.below(2) == 0,
            numbers.below(4) as u32,
        );
        fs::write(&path, altered_bytes(&file, 196, &mut numbers)).unwrap();
        let choices = BeamChoices {
            second: numbers.below(3) == 0,
            sphere: numbers.below(3) == 0,
        };
        match read_zbf(&path, choices, LIMIT) {
            Ok((fields, report)) => {
                assert!(fields.check_for(&path).is_ok(), "seed {seed}");
                assert_eq!(fields.field.dim(), (1, 4, 5), "seed {seed}");
                assert!(report.to_string().len() < 5000, "seed {seed}");
                good += 1;
            }
            Err(fault) => {
                let message = fault.to_string();
                assert!(message.contains("a.zbf"), "seed {seed}: {message}");
                assert!(message.len() < 5000, "seed {seed}");
            }
        }
    }
    assert!(good > count / 20, "{good} of {count}");
}
