//! A phase that depends on the radius alone, by samples and the cubic spline through them.

use crate::math::real::Real;
use crate::math::spline::{FEWEST, even_pieces};

/// φ(r) by samples from r = 0. At the centre the slope is zero, so that the phase is smooth over x and y.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialTable {
    /// Radii of the samples in mm, from zero and growing.
    radii: Vec<f64>,
    /// The cubic in rad from each radius on.
    pieces: Vec<[f64; 4]>,
}

impl RadialTable {
    /// Fewest samples.
    pub const FEWEST: usize = FEWEST;

    /// The spline through phases in rad at these radii in mm; nothing unless there are as many phases as radii, at least
    /// [`Self::FEWEST`], and the radii grow from zero.
    pub fn new(radii: &[f64], phases: &[f64]) -> Option<Self> {
        let grows = radii
            .iter()
            .zip(radii.iter().skip(1))
            .all(|(low, high)| low < high);
        let fits =
            radii.len() == phases.len() && radii.len() >= FEWEST && radii.first() == Some(&0.0);
        (fits && grows).then(|| Self {
            radii: radii.to_vec(),
            pieces: even_pieces(radii, phases),
        })
    }

    /// The phase times a number.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let scaled = |piece: &[f64; 4]| piece.map(|c| factor * c);
        Self {
            radii: self.radii.clone(),
            pieces: self.pieces.iter().map(scaled).collect(),
        }
    }

    /// The phase in rad at a point; beyond the last sample it keeps its curvature.
    pub(crate) fn phase<T: Real>(&self, x: T, y: T) -> T {
        let square = x * x + y * y;
        let here = square.value().sqrt();
        let number = self.radii.partition_point(|r| *r <= here).saturating_sub(1);
        let (Some(knot), Some([a, b, c, d])) = (self.radii.get(number), self.pieces.get(number))
        else {
            return T::constant(f64::NAN);
        };
        if here == 0.0 {
            // The root has no derivative here, and r³ has none that counts.
            return square * *c + *a;
        }
        let t = square.sqrt() - *knot;
        ((t * *d + *c) * t + *b) * t + *a
    }
}

#[cfg(test)]
mod tests {
    use crate::math::jet::Jet;
    use crate::math::real::Real;
    use crate::optics::phase::radial_table::RadialTable;

    /// 30 (r/2)² − 4 (r/2)⁴ at a point.
    fn even<T: Real>(x: T, y: T) -> T {
        let u = (x * x + y * y) * 0.25;
        (u * -4.0 + 30.0) * u
    }

    fn table(samples: u32) -> RadialTable {
        let radii: Vec<f64> = (0..samples)
            .map(|i| 2.0 * f64::from(i) / f64::from(samples - 1))
            .collect();
        let phases: Vec<f64> = radii.iter().map(|r| even(*r, 0.0)).collect();
        RadialTable::new(&radii, &phases).unwrap()
    }

    /// Splines err by 5/384 h⁴ φ⁗ = 1.3e-7 rad for h = 0.04 mm and φ⁗ = −6 rad/mm⁴ inside, and somewhat more at the end.
    /// Their slopes err by some h³ φ⁗/24, their curvatures by h² φ⁗/12.
    #[test]
    fn phases_slopes_and_curvatures_are_those_of_what_was_sampled() {
        let table = table(51);
        for (x, y) in [
            (0.0, 0.0),
            (0.003, -0.002),
            (0.7, 0.4),
            (-1.2, 1.5),
            (0.0, -2.0),
        ] {
            let (x, y) = (Jet::variable(x, 0), Jet::variable(y, 1));
            let (found, exact) = (table.phase(x, y), even(x, y));
            assert!((found.value - exact.value).abs() < 3e-7);
            for axis in [0, 1] {
                assert!((found.slope[axis] - exact.slope[axis]).abs() < 3e-4);
            }
            for axis in [0, 1, 2] {
                assert!((found.hessian[axis] - exact.hessian[axis]).abs() < 2e-2);
            }
        }
    }

    #[test]
    fn the_error_falls_with_the_fourth_power() {
        let worst = |samples: u32| {
            let table = table(samples);
            (0..1000)
                .map(|i| 2e-3 * f64::from(i))
                .map(|r| (table.phase(0.6 * r, 0.8 * r) - even(0.6 * r, 0.8 * r)).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (worst(21), worst(41));
        assert!(coarse < 2e-5 && coarse / fine > 12.0, "{coarse:e} {fine:e}");
    }

    #[test]
    fn samples_that_are_no_table_are_none() {
        let none = |radii: &[f64], phases: &[f64]| RadialTable::new(radii, phases).is_none();
        assert!(none(&[0.0, 1.0, 2.0], &[0.0; 3]));
        assert!(none(&[0.0, 1.0, 2.0, 3.0], &[0.0; 5]));
        assert!(none(&[0.1, 1.0, 2.0, 3.0], &[0.0; 4]));
        assert!(none(&[0.0, 1.0, 1.0, 3.0], &[0.0; 4]));
    }
}
