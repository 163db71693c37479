//! Tapers: amplitudes that fall off aside, as those of laser beams and laser diodes.

use crate::math::vec3::Vec3;

/// An amplitude exp(−ρ^{2m}), ρ² = (u/a)² + (v/b)², over two coordinates: the places of collimated light aside of an axis, or the
/// direction cosines of a point's light. Where ρ = 1 the intensity is 1/e² of that in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taper {
    /// Unit vectors along u and v, and that of the middle.
    pub axes: [Vec3; 3],
    /// The widths a and b.
    pub widths: [f64; 2],
    /// The order m: 1 for a Gaussian, more for a flatter top with steeper sides.
    pub order: u32,
}

/// How much faster than a Gaussian's of the same width a super-Gaussian's amplitude falls, over its order: the spectrum is
/// wider by so much down to 1e-4 of its peak. Between 1.17 and 1.31 for all orders from 2 to 20.
const STEEPNESS: f64 = 1.3;

impl Taper {
    /// A taper about a unit vector; u is turned by `rotation` rad from x towards y.
    pub fn about(middle: Vec3, widths: [f64; 2], order: u32, rotation: f64) -> Self {
        Self {
            axes: axes_about(middle, rotation),
            widths,
            order,
        }
    }

    /// The amplitude at a place from the middle, or for a unit direction.
    pub fn amplitude(&self, v: Vec3) -> f64 {
        let [a, b] = self.widths;
        let (u, v) = (self.axes[0].dot(v) / a, self.axes[1].dot(v) / b);
        (-(u * u + v * v).powf(f64::from(self.order))).exp()
    }

    /// The width of the Gaussian that falls as fast.
    pub(crate) fn fall(&self) -> f64 {
        let narrow = self.widths[0].min(self.widths[1]);
        match self.order {
            0 | 1 => narrow,
            order => narrow / (STEEPNESS * f64::from(order)),
        }
    }
}

/// Unit vectors across a direction and along it; the first is x turned by `rotation` rad towards y, as far as it stands across.
pub(crate) fn axes_about(direction: Vec3, rotation: f64) -> [Vec3; 3] {
    let (sin, cos) = rotation.sin_cos();
    let aside = Vec3::new(cos, sin, 0.0);
    let first = (aside + direction * -aside.dot(direction)).unit();
    [first, direction.cross(first), direction]
}

#[cfg(test)]
mod tests {
    use crate::math::vec3::Vec3;
    use crate::optics::beams::taper::Taper;

    /// 1/e² of the intensity at the widths, whatever the order, along axes that are turned.
    #[test]
    fn widths_are_those_of_the_intensity() {
        let middle = Vec3::new(0.1, -0.2, 1.0).unit();
        for order in [1, 2, 10] {
            let taper = Taper::about(middle, [0.3, 0.7], order, 0.4);
            for (axis, width) in taper.axes.into_iter().zip(taper.widths) {
                let edge = taper.amplitude(axis * width + middle * 5.0);
                assert!((edge * edge - (-2.0f64).exp()).abs() < 1e-14, "{edge}");
            }
            assert!((taper.amplitude(middle) - 1.0).abs() < 1e-12);
        }
    }

    /// Super-Gaussians have 1e-4 of the peak of their spectrum where a Gaussian of the width that `fall` gives has it: at
    /// 6 over that width.
    #[test]
    fn a_super_gaussian_has_the_spectrum_of_its_fall() {
        for order in [1, 2, 3, 6, 10] {
            let taper = Taper::about(Vec3::new(0.0, 0.0, 1.0), [1.0, 2.0], order, 0.0);
            let spectrum = |k: f64| {
                let place = |i: i32| 1e-3 * (f64::from(i) + 0.5);
                let part = |x: f64| taper.amplitude(Vec3::new(x, 0.0, 0.0)) * (k * x).cos();
                (0..4000).map(place).map(part).sum::<f64>()
            };
            let k = 6.2 / taper.fall();
            let beyond = (0..100).map(|i| spectrum(k * (1.0 + 0.01 * f64::from(i))).abs());
            let share = beyond.fold(0.0, f64::max) / spectrum(0.0);
            assert!(share < 1.1e-4, "{order}: {share:e}");
        }
    }
}
