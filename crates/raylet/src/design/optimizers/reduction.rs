//! Sums over long lists of numbers: the same bits for any number of threads.
//!
//! Lists are cut into chunks of one size whatever the machine; each chunk is summed in a fixed order, and
//! the chunks' sums are added one after the other.

use rayon::prelude::*;

/// Numbers in a chunk: enough work to start a thread for.
const CHUNK: usize = 8192;

/// Running sums inside a chunk: as many as fill the registers of a processor.
const LANES: usize = 8;

/// Σ aᵢbᵢ.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    in_order(chunks.map(|(a, b)| lanes(a, b, |a, b| a * b)).collect())
}

/// Σ aᵢbᵢ over those i for which `mask` is true.
pub(crate) fn dot_where(mask: &[bool], a: &[f64], b: &[f64]) -> f64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    let chunks = chunks.zip(mask.par_chunks(CHUNK));
    let one = |((a, b), mask): ((&[f64], &[f64]), &[bool])| {
        let mut sum = 0.0;
        for ((a, b), counts) in a.iter().zip(b).zip(mask) {
            sum += if *counts { a * b } else { 0.0 };
        }
        sum
    };
    in_order(chunks.map(one).collect())
}

/// Σ (aᵢbᵢ)².
pub(crate) fn square(a: &[f64], b: &[f64]) -> f64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    in_order(
        chunks
            .map(|(a, b)| lanes(a, b, |a, b| (a * b) * (a * b)))
            .collect(),
    )
}

/// Replaces each number: `change(index, number)`.
pub(crate) fn change(values: &mut [f64], change: impl Fn(usize, f64) -> f64 + Sync) {
    let chunks = values.par_chunks_mut(CHUNK).enumerate();
    chunks.for_each(|(number, chunk)| {
        for (i, value) in chunk.iter_mut().enumerate() {
            *value = change(number * CHUNK + i, *value);
        }
    });
}

/// to += factor·from.
pub(crate) fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    let chunks = to.par_chunks_mut(CHUNK).zip(from.par_chunks(CHUNK));
    chunks.for_each(|(to, from)| {
        for (to, from) in to.iter_mut().zip(from) {
            *to += factor * from;
        }
    });
}

/// The smallest or largest, by `pick`, of a value of each index; `start` when there are none.
pub(crate) fn extreme(
    count: usize,
    start: f64,
    value: impl Fn(usize) -> f64 + Sync,
    pick: impl Fn(f64, f64) -> f64 + Sync,
) -> f64 {
    let chunks = (0..count.div_ceil(CHUNK)).into_par_iter();
    let one = |chunk: usize| {
        let indices = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
        indices.map(&value).fold(start, &pick)
    };
    let all: Vec<f64> = chunks.map(one).collect();
    all.into_iter().fold(start, &pick)
}

/// Sums of one chunk, side by side, then added up.
#[inline]
fn lanes(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += term(a[lane], b[lane]);
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| term(*a, *b));
    rest.fold(sums.iter().sum(), |sum, term| sum + term)
}

fn in_order(sums: Vec<f64>) -> f64 {
    sums.into_iter().sum()
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::reduction;
    use crate::fixtures::noise::real_noise;

    /// Values from −½ to ½.
    fn values(count: usize, purpose: u32) -> Vec<f64> {
        let drawn = real_noise((count, 1), 4, [0, purpose]) - 0.5;
        drawn.into_iter().collect()
    }

    #[test]
    fn sums_are_those_of_a_plain_loop() {
        for count in [0, 1, 7, 8, 8191, 8192, 8193, 30_000] {
            let (a, b) = (values(count, 0), values(count, 1));
            let mask: Vec<bool> = a.iter().map(|a| *a > 0.1).collect();
            let pairs = || a.iter().zip(&b).zip(&mask);
            let plain: f64 = pairs().map(|((a, b), _)| a * b).sum();
            let some: f64 = pairs().filter(|(_, m)| **m).map(|((a, b), _)| a * b).sum();
            let squares: f64 = pairs().map(|((a, b), _)| (a * b).powi(2)).sum();
            assert!((reduction::dot(&a, &b) - plain).abs() < 1e-12);
            assert!((reduction::dot_where(&mask, &a, &b) - some).abs() < 1e-12);
            assert!((reduction::square(&a, &b) - squares).abs() < 1e-11);
            let largest = reduction::extreme(count, -1.0, |i| a[i], f64::max);
            assert_eq!(largest, a.iter().copied().fold(-1.0, f64::max));

            let mut to = b.clone();
            reduction::add(&mut to, 2.0, &a);
            reduction::change(&mut to, |i, value| value - b[i]);
            let off = |(to, a): (&f64, &f64)| (to - 2.0 * a).abs();
            assert!(to.iter().zip(&a).map(off).all(|off| off < 1e-15));
        }
    }

    #[test]
    fn same_bits_for_any_number_of_threads() {
        let (a, b) = (values(100_000, 2), values(100_000, 3));
        let sums = [1, 2, 3, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| reduction::dot(&a, &b).to_bits())
        });
        assert!(sums.iter().all(|sum| *sum == sums[0]));
    }
}
