//! Drawing from a list of weights, with and without replacement.

use fearless_simd::{Simd, SimdBase, SimdFrom, SimdMask, dispatch, f64x8};

use crate::math::lanes::LANES;
use crate::math::simd_level::level;

/// Memory for drawing from lists of weights.
#[derive(Debug, Default)]
pub struct DrawScratch {
    /// Sums of the weights up to each one, and behind them some that no number reaches.
    sums: Vec<f64>,
    /// For each of equal cells of the total the first block of eight sums that reaches it: the search begins there.
    first: Vec<u32>,
    counts: Vec<u32>,
}

/// How often each of `weights` is drawn in as many independent draws as there are `uniforms`, with
/// probability proportional to the weight: (index, count), ascending, only those drawn at all.
///
/// `uniforms` are uniform in \[0, 1). Without positive weights nothing is drawn.
pub fn draw(weights: &[f64], uniforms: &[f64]) -> Vec<(u32, u32)> {
    let mut drawn = Vec::new();
    draw_into(weights, uniforms, &mut DrawScratch::default(), &mut drawn);
    drawn
}

/// The same in place of what `drawn` holds, for many lists; the sum of the weights.
pub fn draw_into(
    weights: &[f64],
    uniforms: &[f64],
    scratch: &mut DrawScratch,
    drawn: &mut Vec<(u32, u32)>,
) -> f64 {
    drawn.clear();
    let total = dispatch!(level(), simd => scratch.sum_up(simd, weights));
    if !(total > 0.0 && total.is_finite()) {
        return total;
    }
    let blocks = weights.len().div_ceil(LANES);
    let cells = blocks.min(uniforms.len().max(1)) * 2;
    let scale = cells as f64 / total;
    scratch.divide(blocks, cells, scale);
    scratch.counts.clear();
    scratch.counts.resize(weights.len(), 0);
    dispatch!(level(), simd => count(simd, scratch, uniforms, [total, scale]));

    // Each entry is written; only behind one that was drawn does the next get a new place.
    drawn.resize(weights.len().min(uniforms.len()) + 1, (0, 0));
    let mut place = 0;
    for (index, count) in scratch.counts.iter().enumerate() {
        drawn[place] = (index as u32, *count);
        place += usize::from(*count > 0);
    }
    drawn.truncate(place);
    total
}

impl DrawScratch {
    /// Sums up the weights, and returns the total. Rounding may leave a number above the last of the sums; it belongs to
    /// the last weight above zero, whose sum is infinite.
    #[inline(always)]
    fn sum_up<S: Simd>(&mut self, _: S, weights: &[f64]) -> f64 {
        self.sums.resize((weights.len() / LANES + 4) * LANES, 0.0);
        let mut total = 0.0;
        let (blocks, rest) = weights.as_chunks::<LANES>();
        let (sums, behind) = self
            .sums
            .as_chunks_mut::<LANES>()
            .0
            .split_at_mut(blocks.len());
        for (block, sums) in blocks.iter().zip(sums) {
            // The blocks do not wait for each other, but for the last sum.
            let within = partial_sums(block);
            *sums = within.map(|sum| total + sum);
            total += within[LANES - 1];
        }
        let mut block = [0.0; LANES];
        block[..rest.len()].copy_from_slice(rest);
        let within = partial_sums(&block);
        behind[0] = within.map(|sum| total + sum);
        total += within[LANES - 1];
        let last = weights.iter().rposition(|weight| *weight > 0.0);
        self.sums[last.unwrap_or(0)..].fill(f64::INFINITY);
        total
    }

    /// For each cell finds the first block of sums whose last one lies in it or beyond.
    fn divide(&mut self, blocks: usize, cells: usize, scale: f64) {
        let Self { sums, first, .. } = self;
        first.clear();
        first.resize(cells + 2, 0);
        let ends = sums.iter().skip(LANES - 1).step_by(LANES);
        for (block, sum) in ends.take(blocks).enumerate() {
            first[cell(*sum, scale, cells) + 1] = block as u32 + 1;
        }
        let mut most = 0;
        for first in first {
            most = most.max(*first);
            *first = most;
        }
    }
}

/// Sums up to each of eight numbers.
#[inline(always)]
fn partial_sums(numbers: &[f64; LANES]) -> [f64; LANES] {
    let mut sum = 0.0;
    numbers.map(|number| {
        sum += number;
        sum
    })
}

/// The cell in which a place of [0, total) is, or an end beyond the last. It never falls from one place to the next.
#[inline(always)]
fn cell(place: f64, scale: f64, cells: usize) -> usize {
    ((place * scale) as u32 as usize).min(cells)
}

/// Counts the first index whose sum exceeds a number's place, for each number.
#[inline(always)]
fn count<S: Simd>(simd: S, scratch: &mut DrawScratch, uniforms: &[f64], [total, scale]: [f64; 2]) {
    let DrawScratch {
        sums,
        first,
        counts,
    } = scratch;
    let (sums, _) = sums.as_chunks::<LANES>();
    let cells = first.len() - 2;
    for uniform in uniforms {
        let place = uniform * total;
        let place_of_all = f64x8::splat(simd, place);
        let below = |block: usize| {
            let eight = f64x8::simd_from(simd, sums[block]);
            eight.simd_le(place_of_all).to_bitmask().count_ones() as usize
        };
        // A cell seldom reaches into a third block, so that the loop seldom goes on.
        let mut block = first[cell(place, scale, cells)] as usize;
        let mut index = block * LANES + below(block) + below(block + 1);
        while index == (block + 2) * LANES {
            block += 2;
            index += below(block) + below(block + 1);
        }
        counts[index] += 1;
    }
}

/// Probabilities min(1, const·weight) that add up to `count`; one for every positive weight when there
/// are no more than that.
pub(crate) fn inclusion(weights: &[f64], count: usize) -> Vec<f64> {
    let positive = weights.iter().filter(|w| **w > 0.0).count();
    if positive <= count {
        return weights
            .iter()
            .map(|w| if *w > 0.0 { 1.0 } else { 0.0 })
            .collect();
    }

    // Those that reach one are certain; what they leave is shared by the others, until none more does.
    let mut scale = 0.0;
    loop {
        let (mut certain, mut rest) = (0, 0.0);
        for weight in weights {
            if scale * weight >= 1.0 {
                certain += 1;
            } else {
                rest += weight;
            }
        }
        let next = (count - certain.min(count)) as f64 / rest;
        if next <= scale {
            return weights.iter().map(|w| (scale * w).min(1.0)).collect();
        }
        scale = next;
    }
}

/// Systematic sampling without replacement (Madow, Ann. Math. Stat. 20, 333, 1949): the indices whose
/// share of the summed `probabilities`, taken in `order`, holds one of the points offset, offset + 1, ….
/// An index is among them with its own probability; those of probability one always are.
pub(crate) fn systematic(probabilities: &[f64], order: &[usize], offset: f64) -> Vec<usize> {
    let mut sum = 0.0;
    let mut next = offset;
    let mut drawn = Vec::new();
    for index in order {
        // Certain ones stand aside, so that rounding cannot lose them.
        let probability = probabilities[*index];
        if probability >= 1.0 {
            drawn.push(*index);
            continue;
        }
        sum += probability;
        if sum > next {
            drawn.push(*index);
            next += 1.0;
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use crate::math::draw::{draw, inclusion, systematic};
    use crate::math::random::uniform;

    #[test]
    fn counts_follow_the_weights() {
        let weights = [0.0, 3.0, 1.0, 0.0, 6.0, 0.0];
        let count = 200_000u32;
        let uniforms: Vec<f64> = (0..count).map(|i| uniform(9, [i, 0, 0, 0])).collect();
        let drawn = draw(&weights, &uniforms);
        assert_eq!(
            drawn.iter().map(|d| d.0).collect::<Vec<_>>(),
            [1, 2, 4],
            "weights of zero are never drawn"
        );
        assert_eq!(drawn.iter().map(|d| d.1).sum::<u32>(), count);
        for (index, drawn) in drawn {
            let share = weights[index as usize] / 10.0;
            let spread = (f64::from(count) * share * (1.0 - share)).sqrt();
            assert!((f64::from(drawn) - f64::from(count) * share).abs() < 4.0 * spread);
        }
    }

    /// Each number belongs to the first index whose partial sum exceeds it.
    #[test]
    fn numbers_find_their_indices() {
        for count in [1, 2, 7, 300] {
            let weight = |i: u32| uniform(4, [i, count, 0, 0]).powi(40).max(1e-200);
            let weights: Vec<f64> = (0..count)
                .map(|i| if i % 3 == 1 { 0.0 } else { weight(i) })
                .collect();
            let total: f64 = weights.iter().sum();
            let mut uniforms: Vec<f64> = (0..500).map(|i| uniform(5, [i, 0, 0, 0])).collect();
            uniforms.extend((0..count).map(|i| f64::from(i) / f64::from(count)));
            let mut expected = vec![0; weights.len()];
            for u in &uniforms {
                let mut sum = 0.0;
                let found = weights.iter().position(|weight| {
                    sum += weight;
                    *u < sum / total
                });
                let last = weights.iter().rposition(|weight| *weight > 0.0).unwrap();
                expected[found.unwrap_or(last).min(last)] += 1;
            }
            let mut counts = vec![0; weights.len()];
            for (index, count) in draw(&weights, &uniforms) {
                counts[index as usize] = count;
            }
            assert_eq!(counts, expected);
        }
    }

    #[test]
    fn nothing_is_drawn_from_nothing() {
        assert!(draw(&[0.0, 0.0], &[0.3, 0.4]).is_empty());
        assert!(draw(&[], &[0.3]).is_empty());
        assert_eq!(draw(&[1.0, 1e-30], &[0.999_999_999]), [(0, 1)]);
    }

    #[test]
    fn inclusion_is_proportional_up_to_one() {
        let weights = [5.0, 0.0, 1.0, 1.0, 40.0, 2.0];
        // 40 and then 5 are certain; one draw is left for 1 + 1 + 2.
        let p = inclusion(&weights, 3);
        for (ours, theirs) in p.iter().zip([1.0, 0.0, 0.25, 0.25, 1.0, 0.5]) {
            assert!((ours - theirs).abs() < 1e-15, "{p:?}");
        }
        assert_eq!(inclusion(&weights, 5), [1.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(inclusion(&weights, 9), inclusion(&weights, 5));
        assert_eq!(inclusion(&[0.0], 2), [0.0]);
    }

    #[test]
    fn systematic_draws_are_distinct_and_keep_their_probabilities() {
        let weights: Vec<f64> = (0..40).map(|i| uniform(4, [i, 0, 0, 0]).powi(3)).collect();
        let p = inclusion(&weights, 12);
        assert!((p.iter().sum::<f64>() - 12.0).abs() < 1e-12);
        let order: Vec<usize> = (0..40).map(|i| (i * 7) % 40).collect();
        let mut counts = [0u32; 40];
        let runs = 100_000;
        for run in 0..runs {
            let mut drawn = systematic(&p, &order, uniform(5, [run, 0, 0, 0]));
            drawn.sort_unstable();
            drawn.dedup();
            assert_eq!(drawn.len(), 12, "distinct draws of run {run}");
            drawn.iter().for_each(|index| counts[*index] += 1);
        }
        for (count, p) in counts.iter().zip(&p) {
            let spread = (f64::from(runs) * p * (1.0 - p)).sqrt();
            assert!((f64::from(*count) - f64::from(runs) * p).abs() <= 4.0 * spread);
        }
    }
}
