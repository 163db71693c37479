//! Random numbers as addresses: a pure function of a seed and of where the number is used.
//!
//! There is no generator and no state, so a replayed, split or resumed calculation draws the same
//! numbers. The function is Philox4x32-10 (Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as
//! easy as 1, 2, 3", SC 2011): ten rounds of multiplication that scramble a counter under a key.

use fearless_simd::{Simd, dispatch};

use crate::math::lanes::LANES;
use crate::math::simd_level::level;

/// What random numbers are drawn for: the last word of their address, so that no two steps draw the same numbers.
///
/// For drawn beamlets it is the first word, and each iteration has its own seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Positions of patches of the source paper's method.
    PatchPosition = 1,
    /// Modes of such a patch.
    PatchMode = 2,
    /// Secondary rays of other tracers' rays.
    SecondaryRay = 3,
    /// Beamlets whose aberration is measured.
    AberrationSample = 4,
    /// Points at which a hop without rays is checked.
    SpotCheck = 5,
    /// Places at which lost light is divided by cause.
    LostLight = 6,
    /// Beamlets that an evaluation of a design follows.
    DrawnBeamlet = 7,
    /// Gumbel's noise on their weights.
    DrawnNoise = 8,
    /// Phases from which a design starts.
    StartPhase = 0x5354_4152,
    /// What sets the second phase of a pixel apart from the first at the start.
    SecondStartPhase = 0x5345_434F,
    /// Directions along which gradients are checked.
    GradientCheck = 0x4348_4543,
}

/// Scrambles a counter under a key; every counter gives four independent uniform words.
#[inline]
pub(crate) fn philox(mut key: [u32; 2], counter: [u32; 4]) -> [u32; 4] {
    let [mut a, mut b, mut c, mut d] = counter;
    for _ in 0..10 {
        // Two 32 × 32 → 64 bit products; high halves mix with the other words and the key.
        let first = u64::from(a) * 0xD251_1F53;
        let second = u64::from(c) * 0xCD9E_8D57;
        a = (second >> 32) as u32 ^ b ^ key[0];
        c = (first >> 32) as u32 ^ d ^ key[1];
        b = second as u32;
        d = first as u32;
        // The key advances by the golden ratio and √3 − 1.
        key[0] = key[0].wrapping_add(0x9E37_79B9);
        key[1] = key[1].wrapping_add(0xBB67_AE85);
    }
    [a, b, c, d]
}

/// Two independent numbers, uniform in \[0, 1) with 53 bits each, at the address
/// \[screen, patch, sample, purpose\].
///
/// The purpose ([`Purpose`]) separates numbers that different steps draw for the same sample.
#[inline]
pub fn pair(seed: u64, address: [u32; 4]) -> [f64; 2] {
    let key = [seed as u32, (seed >> 32) as u32];
    let [a, b, c, d] = philox(key, address);
    [unit(a, b), unit(c, d)]
}

/// One number, uniform in \[0, 1) with 53 bits: the first of [`pair`].
#[inline]
pub fn uniform(seed: u64, address: [u32; 4]) -> f64 {
    pair(seed, address)[0]
}

/// The numbers of [`pair`] at this address and those that follow along `sample`, one after another.
pub fn uniforms(seed: u64, address: [u32; 4], numbers: &mut [f64]) {
    dispatch!(level(), simd => uniforms_in(simd, seed, address, numbers));
}

/// Eight addresses at once, one in each lane.
#[inline(always)]
fn uniforms_in<S: Simd>(_: S, seed: u64, address: [u32; 4], numbers: &mut [f64]) {
    let [screen, patch, first, purpose] = address;
    for (group, numbers) in numbers.chunks_mut(2 * LANES).enumerate() {
        let begin = first.wrapping_add((group * LANES) as u32);
        let eight = pairs(seed, [screen, patch, begin, purpose]);
        numbers.copy_from_slice(&eight.as_flattened()[..numbers.len()]);
    }
}

/// The pairs of eight addresses that follow each other along `sample`, by the rounds of [`philox`].
#[inline(always)]
fn pairs(seed: u64, [screen, patch, first, purpose]: [u32; 4]) -> [[f64; 2]; LANES] {
    const LOW: u64 = u32::MAX as u64;
    let mut key = [seed as u32, (seed >> 32) as u32];
    let [mut a, mut b, mut d] = [screen, patch, purpose].map(|word| [u64::from(word); LANES]);
    let mut c: [u64; LANES] = std::array::from_fn(|i| u64::from(first.wrapping_add(i as u32)));
    for _ in 0..10 {
        let keys = key.map(u64::from);
        for i in 0..LANES {
            let one = (a[i] & LOW) * 0xD251_1F53;
            let two = (c[i] & LOW) * 0xCD9E_8D57;
            (a[i], c[i]) = ((two >> 32) ^ b[i] ^ keys[0], (one >> 32) ^ d[i] ^ keys[1]);
            (b[i], d[i]) = (two & LOW, one & LOW);
        }
        key[0] = key[0].wrapping_add(0x9E37_79B9);
        key[1] = key[1].wrapping_add(0xBB67_AE85);
    }
    let mut pairs = [[0.0; 2]; LANES];
    for i in 0..LANES {
        pairs[i] = [fraction(b[i] << 32 | a[i]), fraction(d[i] << 32 | c[i])];
    }
    pairs
}

/// The upper 53 of 64 bits as a fraction.
#[inline]
fn unit(low: u32, high: u32) -> f64 {
    fraction(u64::from(high) << 32 | u64::from(low))
}

/// The same of one word.
#[inline(always)]
fn fraction(bits: u64) -> f64 {
    (bits >> 11) as f64 * (0.5_f64).powi(53)
}

#[cfg(test)]
mod tests {
    use crate::math::random::{pair, philox, uniform, uniforms};

    #[test]
    fn known_answers_of_random123() {
        let ones = u32::MAX;
        assert_eq!(
            philox([0; 2], [0; 4]),
            [0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8]
        );
        assert_eq!(
            philox([ones; 2], [ones; 4]),
            [0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd]
        );
        assert_eq!(
            philox(
                [0xa4093822, 0x299f31d0],
                [0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344]
            ),
            [0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1]
        );
    }

    #[test]
    fn lists_are_those_of_single_addresses() {
        for (count, first) in [(0, 0), (1, 3), (16, u32::MAX - 4), (37, 1_000)] {
            let mut numbers = vec![0.0; count];
            uniforms(u64::MAX - 77, [3, u32::MAX, first, 4], &mut numbers);
            for (i, number) in numbers.iter().enumerate() {
                let sample = first.wrapping_add(i as u32 / 2);
                assert_eq!(
                    *number,
                    pair(u64::MAX - 77, [3, u32::MAX, sample, 4])[i % 2]
                );
            }
        }
    }

    #[test]
    fn moments_of_the_uniform_distribution() {
        // Neighbouring addresses along each of the four axes: mean 1/2, variance 1/12, no correlation,
        // each within four standard deviations of its own estimate.
        let count = 200_000;
        for axis in 0..4 {
            let [mut mean, mut square, mut mixed, mut lagged] = [0.0; 4];
            let mut last = 0.0;
            for i in 0..count {
                let mut address = [3, 1, 4, 1];
                address[axis] = i;
                let [u, v] = pair(5, address).map(|u| u - 0.5);
                mean += u / f64::from(count);
                square += u * u / f64::from(count);
                mixed += u * v / f64::from(count);
                lagged += u * last / f64::from(count);
                last = u;
            }
            let root = f64::from(count).sqrt();
            assert!(mean.abs() < 4.0 * (1.0 / 12.0_f64).sqrt() / root);
            assert!((square - 1.0 / 12.0).abs() < 4.0 * (1.0 / 180.0_f64).sqrt() / root);
            assert!(mixed.abs() < 4.0 / 12.0 / root);
            assert!(lagged.abs() < 4.0 / 12.0 / root);
        }
    }

    #[test]
    fn within_the_half_open_interval_and_dependent_on_every_part_of_the_address() {
        let base = uniform(1, [0; 4]);
        for bit in 0..64 {
            assert_ne!(uniform(1 ^ 1 << bit, [0; 4]), base);
        }
        for word in 0..4 {
            for bit in 0..32 {
                let mut address = [0; 4];
                address[word] = 1 << bit;
                let value = uniform(1, address);
                assert!((0.0..1.0).contains(&value) && value != base);
            }
        }
    }
}
