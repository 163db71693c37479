//! Tests: altered beam files give a field or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_beam` makes a long run.

use std::fs;

use crate::file::beams::zbf_fields::{BeamChoices, read_zbf};
use crate::file::beams::zbf_test::{LIMIT, bytes_of};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 600;

/// Numbers of a hash, one after another.
struct Numbers(u64);

impl Numbers {
    /// The next one below `end`.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end.max(1) as u64) as usize
    }
}

/// The bytes of a file, with one to three places altered; half of the places are in the header.
fn altered(mut bytes: Vec<u8>, numbers: &mut Numbers) -> Vec<u8> {
    for _ in 0..=numbers.below(3) {
        let end = if numbers.below(2) == 0 {
            196
        } else {
            bytes.len()
        };
        let at = numbers.below(end.min(bytes.len()));
        match numbers.below(6) {
            0 | 1 => bytes[at] ^= 1 << numbers.below(8),
            2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][numbers.below(5)],
            3 => {
                let end = (at + 8).min(bytes.len());
                bytes[at..end].fill([0x7f, 0x80, 0xff][numbers.below(3)]);
            }
            4 => drop(bytes.drain(at..(at + 1 + numbers.below(16)).min(bytes.len()))),
            _ => bytes.truncate(at.max(1)),
        }
        if bytes.is_empty() {
            bytes.push(0);
        }
    }
    bytes
}

#[test]
fn mutated_beam_files_give_a_field_or_an_error() {
    let wanted = std::env::var("RAYLET_MUTATIONS").ok();
    let count = wanted.map_or(MUTATIONS, |count| count.parse().unwrap());
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
        fs::write(&path, altered(file, &mut numbers)).unwrap();
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
