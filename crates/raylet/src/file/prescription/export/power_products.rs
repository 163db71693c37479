//! Sums of products of powers of x and y.

use std::collections::BTreeMap;

/// Σ a xⁱ yʲ, by the powers [i, j]; lengths in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PowerProducts(BTreeMap<[u32; 2], f64>);

impl PowerProducts {
    /// One product.
    pub(crate) fn of(powers: [u32; 2], a: f64) -> Self {
        Self(BTreeMap::from([(powers, a)]))
    }

    /// Adds another sum.
    pub(crate) fn add(&mut self, other: &Self) {
        for (powers, a) in &other.0 {
            *self.0.entry(*powers).or_default() += a;
        }
    }

    /// The sum times a number.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let scaled = self.0.iter().map(|(powers, a)| (*powers, factor * a));
        Self(scaled.collect())
    }

    /// The product with another sum.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for ([i, j], a) in &self.0 {
            for ([k, l], b) in &other.0 {
                *product.0.entry([i + k, j + l]).or_default() += a * b;
            }
        }
        product
    }

    /// A power of the sum.
    pub(crate) fn power(&self, exponent: u32) -> Self {
        (0..exponent).fold(Self::of([0, 0], 1.0), |product, _| product.times(self))
    }

    /// The sum with other sums in place of x and y.
    pub(crate) fn with(&self, [x, y]: [&Self; 2]) -> Self {
        let mut sum = Self::default();
        for ([i, j], a) in &self.0 {
            sum.add(&x.power(*i).times(&y.power(*j)).scaled(*a));
        }
        sum
    }

    /// Σ aᵢ r^{2i} with i from 1.
    pub(crate) fn of_even_powers(coefficients: &[f64]) -> Self {
        let mut square = Self::of([2, 0], 1.0);
        square.add(&Self::of([0, 2], 1.0));
        let (mut sum, mut power) = (Self::default(), Self::of([0, 0], 1.0));
        for a in coefficients {
            power = power.times(&square);
            sum.add(&power.scaled(*a));
        }
        sum
    }

    /// The coefficient of these powers.
    pub(crate) fn at(&self, powers: [u32; 2]) -> f64 {
        self.0.get(&powers).copied().unwrap_or(0.0)
    }

    /// The terms that are not zero.
    pub(crate) fn terms(&self) -> impl Iterator<Item = ([u32; 2], f64)> {
        let terms = self.0.iter().map(|(powers, a)| (*powers, *a));
        terms.filter(|(_, a)| *a != 0.0)
    }

    /// The highest sum of two powers.
    pub(crate) fn degree(&self) -> u32 {
        self.terms().map(|([i, j], _)| i + j).max().unwrap_or(0)
    }

    /// Coefficients of x, y, x², xy, y², x³, … at a norm radius, up to the last one that is not zero.
    pub(crate) fn listed(&self, norm_radius: f64) -> Vec<f64> {
        let orders = 1..=self.degree();
        let powers = orders.flat_map(|order| (0..=order).map(move |y| [order - y, y]));
        let mut list: Vec<f64> = powers
            .map(|[x, y]| self.at([x, y]) * norm_radius.powi((x + y) as i32))
            .collect();
        while list.last() == Some(&0.0) {
            list.pop();
        }
        list
    }
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::export::power_products::PowerProducts;

    #[test]
    fn products_and_powers_have_the_values_of_their_formulas() {
        let mut sum = PowerProducts::of([1, 0], 2.0);
        sum.add(&PowerProducts::of([0, 2], -3.0));
        sum.add(&PowerProducts::of([0, 0], 0.5));
        let value = |sum: &PowerProducts, x: f64, y: f64| -> f64 {
            let terms = sum.terms();
            terms
                .map(|([i, j], a)| a * x.powi(i as i32) * y.powi(j as i32))
                .sum()
        };
        let (x, y) = (0.7, -1.3);
        let plain: f64 = 2.0 * x - 3.0 * y * y + 0.5;
        assert!((value(&sum.power(3), x, y) - plain.powi(3)).abs() < 1e-12);
        let (new_x, new_y) = (PowerProducts::of([0, 1], 1.0), sum.clone());
        let shifted = sum.with([&new_x, &new_y]);
        let expected = 2.0 * y - 3.0 * plain * plain + 0.5;
        assert!((value(&shifted, x, y) - expected).abs() < 1e-12);
        let even = PowerProducts::of_even_powers(&[0.5, -0.25]);
        let square = x * x + y * y;
        assert!((value(&even, x, y) - (0.5 * square - 0.25 * square * square)).abs() < 1e-12);
        assert_eq!(even.listed(2.0)[..5], [0.0, 0.0, 2.0, 0.0, 2.0]);
        assert_eq!(even.degree(), 4);
    }
}
