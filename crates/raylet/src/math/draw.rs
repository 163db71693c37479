//! Drawing from a list of weights, with and without replacement.

/// How often each of `weights` is drawn in as many independent draws as there are `uniforms`, with
/// probability proportional to the weight: (index, count), ascending, only those drawn at all.
///
/// `uniforms` are uniform in \[0, 1). Without positive weights nothing is drawn.
pub fn draw(weights: &[f64], uniforms: &[f64]) -> Vec<(usize, u32)> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let sums = partial_sums(weights);

    // The first index that a number of each of equal cells of [0, 1) can belong to: the search begins there.
    let cells = weights.len().min(uniforms.len().max(1));
    let step = total / cells as f64;
    let mut first = Vec::with_capacity(cells);
    let mut index = 0;
    for cell in 0..cells {
        while sums[index] <= cell as f64 * step {
            index += 1;
        }
        first.push(index as u32);
    }
    let mut counts = vec![0u32; weights.len()];
    for uniform in uniforms {
        let (place, cell) = (uniform * total, (uniform * cells as f64) as usize);
        let mut index = first[cell.min(cells - 1)] as usize;
        // Rounding may put a number into the next cell.
        while index > 0 && sums[index - 1] > place {
            index -= 1;
        }
        while sums[index] <= place {
            index += 1;
        }
        counts[index] += 1;
    }
    let drawn = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    drawn.map(|(index, count)| (index, *count)).collect()
}

/// Sums of the weights up to each one. Rounding may leave a number above the last of them; it belongs to the last weight
/// above zero, whose sum is infinite.
fn partial_sums(weights: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut sums: Vec<f64> = weights
        .iter()
        .map(|weight| {
            sum += weight;
            sum
        })
        .collect();
    let last = weights.iter().rposition(|weight| *weight > 0.0);
    sums[last.unwrap_or(0)..].fill(f64::INFINITY);
    sums
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
            let share = weights[index] / 10.0;
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
                counts[index] = count;
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
