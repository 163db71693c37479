//! The transform of a box, and the interpolation of samples by it.

use std::f64::consts::PI;

use crate::math::kaiser::bessel_i0;

/// sin(πt)/πt.
pub(crate) fn sinc(t: f64) -> f64 {
    if t == 0.0 {
        1.0
    } else {
        (PI * t).sin() / (PI * t)
    }
}

/// sinc(t) under a Kaiser window, which interpolates samples one apart from some neighbours on either side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WindowedSinc {
    reach: f64,
    beta: f64,
}

impl WindowedSinc {
    /// With `reach` samples on either side, for functions that have at most `filled` of the band of their samples. The error
    /// is about exp(−πr(1 − f)) of the function.
    pub(crate) fn new(reach: usize, filled: f64) -> Self {
        let reach = reach as f64;
        Self {
            reach,
            beta: PI * reach * (1.0 - filled),
        }
    }

    /// The weight of a sample at a distance of `t` samples.
    pub(crate) fn weight(&self, t: f64) -> f64 {
        let z = t / self.reach;
        match z.abs() < 1.0 {
            true => sinc(t) * bessel_i0(self.beta * (1.0 - z * z).sqrt()) / bessel_i0(self.beta),
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::math::sinc::WindowedSinc;

    /// Plane waves of every frequency in the band, between samples.
    #[test]
    fn samples_of_half_the_band_are_interpolated() {
        let kernel = WindowedSinc::new(10, 0.5);
        for n in 0..40 {
            let (frequency, at) = (0.25 * f64::from(n) / 39.0, 0.13 + f64::from(n % 5) * 0.17);
            let wave = |x: f64| (std::f64::consts::TAU * frequency * x).cos();
            let found: f64 = (-9..=10)
                .map(f64::from)
                .map(|x| kernel.weight(x - at) * wave(x))
                .sum();
            assert!((found - wave(at)).abs() < 2e-7, "{frequency} {at}");
        }
    }
}
