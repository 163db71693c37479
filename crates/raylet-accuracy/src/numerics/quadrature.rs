//! Gauss–Legendre quadrature on an interval.

/// Nodes in (−1, 1) and weights (their sum is 2) of the Gauss–Legendre rule with `count` ≥ 1
/// nodes, exact for polynomials of degree 2·`count` − 1.
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count)
        .map(|index| {
            // Newton's method from the classical estimate of the root.
            let guess = (index as f64 + 0.75) / (count as f64 + 0.5);
            let mut node = -(std::f64::consts::PI * guess).cos();
            for _ in 0..20 {
                let (value, slope) = legendre(count, node);
                node -= value / slope;
            }
            let (_, slope) = legendre(count, node);
            (node, 2.0 / ((1.0 - node * node) * slope * slope))
        })
        .collect()
}

/// The Legendre polynomial of degree `degree` ≥ 1 at |x| < 1, and its slope.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for order in 2..=degree {
        let order = order as f64;
        let next = ((2.0 * order - 1.0) * x * value - (order - 1.0) * before) / order;
        (before, value) = (value, next);
    }
    (value, degree as f64 * (before - x * value) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use crate::numerics::quadrature::gauss_legendre;

    #[test]
    fn integrates_the_highest_even_power_it_promises() {
        for count in 1..=24 {
            let power = 2 * count as i32 - 2;
            let rule = gauss_legendre(count);
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
            assert!((sum - 2.0 / f64::from(power + 1)).abs() < 1e-14, "{count}");
        }
    }
}
