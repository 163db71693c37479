//! Tests: altered archives give a scene or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_archives` makes a long run.

use std::path::Path;

use crate::file::prescription::archive::zar_test::{LENS, archive, catalogue};
use crate::file::prescription::import::{ImportChoices, import_bytes};

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

/// The bytes of an archive, with one to three places altered; most places are in headers.
fn altered(mut bytes: Vec<u8>, numbers: &mut Numbers) -> Vec<u8> {
    for _ in 0..=numbers.below(3) {
        let end = [72, bytes.len(), bytes.len()][numbers.below(3)];
        let at = numbers.below(end.min(bytes.len()));
        match numbers.below(6) {
            0 | 1 => bytes[at] ^= 1 << numbers.below(8),
            2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][numbers.below(5)],
            3 => {
                let end = (at + 8).min(bytes.len());
                bytes[at..end].fill([0, 0x7f, 0xff][numbers.below(3)]);
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
fn mutated_archives_give_a_scene_or_an_error() {
    let wanted = std::env::var("RAYLET_MUTATIONS").ok();
    let count = wanted.map_or(MUTATIONS, |count| count.parse().unwrap());
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
        let bytes = altered(archive(version, &files), &mut numbers);
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
