//! Altered files, for tests that readers give a result or an error and never end otherwise.

/// Values that take the place of a byte.
const BYTES: [u8; 5] = [0, 1, 0x7f, 0x80, 0xff];

/// Characters that take the place of one in a text.
const CHARACTERS: &[u8] = b"0123456789-.eT' \n";

/// Numbers of a hash, one after another.
pub struct Numbers(pub u64);

impl Numbers {
    /// The next one below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end.max(1) as u64) as usize
    }
}

/// How many mutations a test makes: so many as `RAYLET_MUTATIONS` says, or the `usual` number.
pub fn mutation_count(usual: u64) -> u64 {
    let wanted = std::env::var("RAYLET_MUTATIONS").ok();
    wanted.and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// The bytes of a file, with one to four places altered; half of the places are among the first `head` bytes.
pub fn altered_bytes(file: &[u8], head: usize, numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=numbers.below(4) {
        let end = match numbers.below(2) {
            0 => head.min(bytes.len()),
            _ => bytes.len(),
        };
        let at = numbers.below(end);
        alter(&mut bytes, at, numbers);
        if bytes.is_empty() {
            bytes.push(0);
        }
    }
    bytes
}

/// Alters what stands at a place: bits, one byte or eight, a character, a piece that is doubled or lost, or the end of the file.
fn alter(bytes: &mut Vec<u8>, at: usize, numbers: &mut Numbers) {
    let other = BYTES.get(numbers.below(BYTES.len())).copied();
    let other = other.unwrap_or_default();
    let character = CHARACTERS.get(numbers.below(CHARACTERS.len())).copied();
    let character = character.unwrap_or_default();
    match numbers.below(8) {
        0 | 1 => {
            let bit = 1 << numbers.below(8);
            bytes
                .iter_mut()
                .skip(at)
                .take(1)
                .for_each(|byte| *byte ^= bit);
        }
        2 => bytes
            .iter_mut()
            .skip(at)
            .take(1)
            .for_each(|byte| *byte = other),
        3 => bytes
            .iter_mut()
            .skip(at)
            .take(8)
            .for_each(|byte| *byte = other),
        4 => {
            let from = numbers.below(bytes.len());
            let piece: Vec<u8> = bytes.iter().skip(from).take(64).copied().collect();
            bytes.splice(at..at, piece);
        }
        5 => bytes
            .iter_mut()
            .skip(at)
            .take(1)
            .for_each(|byte| *byte = character),
        6 => drop(bytes.drain(at..(at + 1 + numbers.below(16)).min(bytes.len()))),
        _ => bytes.truncate(at.max(1)),
    }
}
