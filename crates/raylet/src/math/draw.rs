//! Drawing from a list of weights, with replacement.

/// How often each of `weights` is drawn in as many independent draws as there are `numbers`, with
/// probability proportional to the weight: (index, count), ascending, only those drawn at all.
///
/// `numbers` are uniform in \[0, 1) and are sorted on the way. Without positive weights nothing is drawn.
pub fn draw(weights: &[f64], numbers: &mut [f64]) -> Vec<(usize, u32)> {
    let total: f64 = weights.iter().sum();
    if total.is_nan() || total <= 0.0 {
        return Vec::new();
    }
    numbers.sort_unstable_by(f64::total_cmp);
    let mut drawn: Vec<(usize, u32)> = Vec::new();
    let (mut sum, mut next) = (0.0, 0);
    let last = weights.iter().rposition(|w| *w > 0.0).unwrap_or(0);
    for (index, weight) in weights.iter().enumerate() {
        sum += weight;
        // Rounding may leave the last number above the last partial sum; it belongs to the last weight.
        let limit = if index == last {
            f64::INFINITY
        } else {
            sum / total
        };
        let count = numbers[next..].iter().take_while(|u| **u < limit).count();
        if count > 0 {
            drawn.push((index, count as u32));
            next += count;
        }
        if next == numbers.len() {
            break;
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use crate::math::draw::draw;
    use crate::math::random::uniform;

    #[test]
    fn counts_follow_the_weights() {
        let weights = [0.0, 3.0, 1.0, 0.0, 6.0, 0.0];
        let count = 200_000u32;
        let mut numbers: Vec<f64> = (0..count).map(|i| uniform(9, [i, 0, 0, 0])).collect();
        let drawn = draw(&weights, &mut numbers);
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

    #[test]
    fn nothing_is_drawn_from_nothing() {
        assert!(draw(&[0.0, 0.0], &mut [0.3, 0.4]).is_empty());
        assert!(draw(&[], &mut [0.3]).is_empty());
        assert_eq!(draw(&[1.0, 1e-30], &mut [0.999_999_999]), [(0, 1)]);
    }
}
