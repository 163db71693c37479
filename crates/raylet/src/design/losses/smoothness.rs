//! A penalty on steps between neighbouring pixels.

use ndarray::{Array2, ArrayView2};

use crate::design::losses::loss::LossValue;

/// The mean over neighbours of |e^{iφ} − e^{iφ′}|² = 2 − 2cos(φ − φ′), and its gradient to the phases,
/// [y, x]: the mean square of the steps, in rad², where they are small; 2 for noise, 4 at most. Whole turns
/// cost nothing.
///
/// Neighbours are pixels side by side along x or y, both `open`; without any the value is zero.
pub fn roughness(phase: ArrayView2<'_, f64>, open: Option<ArrayView2<'_, bool>>) -> LossValue {
    let (ny, nx) = phase.dim();
    let counts = |at: [usize; 2]| open.is_none_or(|open| open[at]);
    let mut bar = Array2::zeros((ny, nx));
    let (mut sum, mut pairs) = (0.0, 0.0);
    let mut meet = |a: [usize; 2], b: [usize; 2]| {
        if counts(a) && counts(b) {
            let step = phase[a] - phase[b];
            // 2 − 2cos = 4sin²(½·): exact for small steps.
            sum += 4.0 * (0.5 * step).sin().powi(2);
            pairs += 1.0;
            bar[a] += 2.0 * step.sin();
            bar[b] -= 2.0 * step.sin();
        }
    };
    for j in 0..ny {
        for i in 0..nx {
            if i + 1 < nx {
                meet([j, i + 1], [j, i]);
            }
            if j + 1 < ny {
                meet([j + 1, i], [j, i]);
            }
        }
    }
    let count = f64::max(pairs, 1.0);
    LossValue {
        value: sum / count,
        bar: bar / count,
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::design::losses::smoothness::roughness;
    use crate::fixtures::noise::real_noise;

    /// Values from 0 to 6.
    fn values(purpose: u32) -> Array2<f64> {
        real_noise((6, 8), 6, [0, purpose]) * 6.0
    }

    #[test]
    fn central_differences() {
        let (phase, direction) = (values(0), values(1) - 3.0);
        let open = values(2).mapv(|value| value > 2.0);
        for open in [None, Some(open.view())] {
            let at = |step: f64| roughness((&phase + &(&direction * step)).view(), open).value;
            let near = (at(1e-3) - at(-1e-3)) / 2e-3;
            let far = (at(2e-3) - at(-2e-3)) / 4e-3;
            let slope = (roughness(phase.view(), open).bar * &direction).sum();
            let off = ((4.0 * near - far) / 3.0 - slope).abs() / slope.abs();
            assert!(off < 1e-9, "{off:e}");
        }
    }

    #[test]
    fn slopes_checkers_and_turns() {
        let slope = Array2::from_shape_fn((40, 50), |(j, i)| 3e-4 * i as f64 + 4e-4 * j as f64);
        let pairs = [40.0 * 49.0, 39.0 * 50.0];
        let exact = (9e-8 * pairs[0] + 16e-8 * pairs[1]) / (pairs[0] + pairs[1]);
        assert!((roughness(slope.view(), None).value / exact - 1.0).abs() < 1e-7);

        let turns = slope.mapv(|phase| phase.rem_euclid(5e-3) * std::f64::consts::TAU / 5e-3);
        let whole = &slope * (std::f64::consts::TAU / 5e-3);
        let [wrapped, plain] = [turns, whole].map(|phase| roughness(phase.view(), None));
        assert!((wrapped.value - plain.value).abs() < 1e-13);
        assert!(
            (wrapped.bar - plain.bar)
                .iter()
                .all(|off| off.abs() < 1e-13)
        );

        let checkers =
            Array2::from_shape_fn((5, 5), |(j, i)| std::f64::consts::PI * ((i + j) % 2) as f64);
        assert!((roughness(checkers.view(), None).value - 4.0).abs() < 1e-15);
        assert_eq!(roughness(Array2::zeros((1, 1)).view(), None).value, 0.0);
    }
}
