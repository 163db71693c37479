//! Losses by the share of the light that goes to its target.

use ndarray::{Array2, ArrayView2, Zip};

use crate::design::losses::loss::{
    Loss, LossError, LossValue, check_pixels, check_positive, weights,
};
use crate::optics::aperture::Aperture;
use crate::wave::grid::raster::Raster;

/// The whole of which the light in the window is a share.
#[derive(Clone, Debug, PartialEq)]
enum Whole {
    /// Of this sum of intensities, which all the light would make.
    Incident(f64),
    /// Of what is on the sensor, pixels weighted.
    Seen(Array2<f64>),
}

/// The share s of the light that falls into a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// How much of each pixel lies in the window, and how much it counts.
    window: Array2<f64>,
    whole: Whole,
    /// L = −β·log s; else L = 1 − s.
    beta: Option<f64>,
}

impl Share {
    /// L = −β·log s, s the light in a window (0 to 1 at each pixel, [y, x]) over the light sent out.
    ///
    /// `power` is that of the light sent out, ∫|U|² in mm², and `area` of a pixel of the sensor in mm².
    /// Added to a likeness with a small β it buys light for little likeness. Infinite while the window is
    /// dark.
    ///
    /// # Errors
    /// When the window is empty or not between 0 and 1, or a number is not positive.
    pub fn efficiency(
        window: Array2<f64>,
        power: f64,
        area: f64,
        beta: f64,
    ) -> Result<Self, LossError> {
        check_pixels("the window", &window, 1.0)?;
        check_positive("the light's power", power)?;
        check_positive("the area of a pixel", area)?;
        check_positive("the factor of the efficiency", beta)?;
        Ok(Self {
            window,
            whole: Whole::Incident(power / area),
            beta: Some(beta),
        })
    }

    /// [`Share::efficiency`] with β = 1, the window all points within a radius (mm) of any of these (x, y in mm);
    /// `power` is that of the light sent out, ∫|U|² in mm².
    ///
    /// # Errors
    /// When no point is on the sensor, or a number is not positive.
    pub fn within(
        raster: &Raster,
        points: &[[f64; 2]],
        radius: f64,
        power: f64,
    ) -> Result<Self, LossError> {
        check_positive("the radius", radius)?;
        let window = circles(raster, points, radius);
        Self::efficiency(window, power, raster.pitch[0] * raster.pitch[1], 1.0)
    }

    /// L = 1 − s, s the encircled energy: light within a radius (mm) of any of the points (x, y in mm)
    /// over all light on the sensor, each pixel counted with its weight, 0 (don't care) to 1.
    ///
    /// Pixels that a circle cuts count by the area inside. 1 where all is dark.
    ///
    /// # Errors
    /// When no point is on the sensor, the radius is not positive, or weights make no sense.
    pub fn encircled(
        raster: &Raster,
        points: &[[f64; 2]],
        radius: f64,
        weight: Option<Array2<f64>>,
    ) -> Result<Self, LossError> {
        check_positive("the radius", radius)?;
        let weight = weights(weight, (raster.size[1], raster.size[0]))?;
        let window = circles(raster, points, radius) * &weight;
        check_pixels("the light within the circles", &window, 1.0)?;
        Ok(Self {
            window,
            whole: Whole::Seen(weight),
            beta: None,
        })
    }

    /// The share itself.
    pub fn of(&self, intensity: ArrayView2<'_, f64>) -> f64 {
        let inside = weighted(&self.window, intensity);
        let whole = match &self.whole {
            Whole::Incident(whole) => *whole,
            Whole::Seen(weight) => weighted(weight, intensity),
        };
        if whole > 0.0 { inside / whole } else { 0.0 }
    }
}

/// How much of each pixel lies within a radius of any of the points, [y, x].
fn circles(raster: &Raster, points: &[[f64; 2]], radius: f64) -> Array2<f64> {
    let [dx, dy] = raster.pitch;
    let mut window = Array2::zeros((raster.size[1], raster.size[0]));
    for point in points {
        let circle = Aperture {
            centre: *point,
            ..Aperture::disc(radius)
        };
        for ((j, i), inside) in window.indexed_iter_mut() {
            let x = raster.start[0] + (i as f64 - 0.5) * dx;
            let y = raster.start[1] + (j as f64 - 0.5) * dy;
            *inside = f64::min(*inside + circle.coverage(x, x + dx, y, y + dy), 1.0);
        }
    }
    window
}

fn weighted(weight: &Array2<f64>, intensity: ArrayView2<'_, f64>) -> f64 {
    Zip::from(weight)
        .and(intensity)
        .fold(0.0, |sum, w, i| sum + w * i)
}

impl Loss for Share {
    fn shape(&self) -> (usize, usize) {
        self.window.dim()
    }

    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
        let share = self.of(intensity);
        let (value, slope) = match self.beta {
            Some(_) if share <= 0.0 => (f64::INFINITY, 0.0),
            Some(beta) => (-beta * share.ln(), -beta / share),
            None => (1.0 - share, -1.0),
        };

        // s = in/all: ds = (d in − s·d all)/all.
        let bar = match &self.whole {
            Whole::Incident(whole) => &self.window * (slope / whole),
            Whole::Seen(weight) => {
                let whole = weighted(weight, intensity);
                let gain = if whole > 0.0 { slope / whole } else { 0.0 };
                Zip::from(&self.window)
                    .and(weight)
                    .map_collect(|inside, w| gain * (inside - share * w))
            }
        };
        LossValue { value, bar }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use ndarray::Array2;

    use crate::design::losses::discrepancy::discrepancy;
    use crate::fixtures::noise::real_noise;

    use crate::design::losses::loss::Loss;
    use crate::design::losses::share::Share;
    use crate::wave::grid::raster::Raster;

    /// Jₙ(v), n = 0 and 1, by the midpoint rule for its integral: exact to rounding.
    fn bessel(v: f64) -> [f64; 2] {
        let points = 200;
        let angle = |i: usize| PI * (i as f64 + 0.5) / points as f64;
        let at = |order: f64| {
            let term = |i: usize| (order * angle(i) - v * angle(i).sin()).cos();
            (0..points).map(term).sum::<f64>() / points as f64
        };
        [at(0.0), at(1.0)]
    }

    fn raster(count: usize, pitch: f64) -> Raster {
        Raster {
            start: [-0.5 * (count as f64 - 1.0) * pitch; 2],
            pitch: [pitch; 2],
            size: [count; 2],
        }
    }

    #[test]
    fn encircled_energy_of_an_airy_pattern() {
        // (2J₁(v)/v)² holds the share 1 − J₀² − J₁² within v (Rayleigh, Phil. Mag. 11, 214, 1881).
        let raster = raster(401, 0.1);
        let place = |i: usize| raster.start[0] + i as f64 * raster.pitch[0];
        let airy = Array2::from_shape_fn((401, 401), |(j, i)| {
            let v = place(i).hypot(place(j)).max(1e-9);
            (2.0 * bessel(v)[1] / v).powi(2)
        });
        let within = |v: f64| 1.0 - bessel(v).iter().map(|j| j * j).sum::<f64>();
        let inner = Share::encircled(&raster, &[[0.0; 2]], 2.0, None).unwrap();
        let outer = Share::encircled(&raster, &[[0.0; 2]], 18.0, None).unwrap();
        // Cut pixels are taken as evenly lit: second order in the pitch.
        let found = inner.of(airy.view()) / outer.of(airy.view());
        let off = (found - within(2.0) / within(18.0)).abs();
        assert!(off < 2e-4, "{off:e}");
    }

    #[test]
    fn central_differences() {
        let intensity = real_noise((11, 11), 8, [0, 0]);
        let mask = real_noise((11, 11), 8, [0, 1]);
        let raster = raster(11, 0.2);
        let points = [[0.3, -0.4], [-0.5, 0.55]];
        let encircled = Share::encircled(&raster, &points, 0.45, Some(mask.clone())).unwrap();
        let efficiency = Share::efficiency(mask, 40.0, 0.04, 0.01).unwrap();
        let losses: [&dyn Loss; 2] = [&encircled, &efficiency];
        for loss in losses {
            let off = discrepancy(loss, intensity.view(), 2);
            assert!(off < 1e-10, "{off:e}");
        }

        // All light twice as bright: the same share of what is seen, twice the share of what was sent.
        let brighter = &intensity * 2.0;
        assert!((encircled.of(brighter.view()) - encircled.of(intensity.view())).abs() < 1e-15);
        let [one, two] = [&intensity, &brighter].map(|i| efficiency.evaluate(i.view()).value);
        assert!((one - two - 0.01 * f64::ln(2.0)).abs() < 1e-15);
    }

    #[test]
    fn efficiency_is_power_over_power() {
        // A window of half the pixels under uniform light of unit intensity, twice as much of it sent.
        let window = Array2::from_shape_fn((4, 4), |(j, _)| if j < 2 { 1.0 } else { 0.0 });
        let share = Share::efficiency(window.clone(), 32.0 * 0.25, 0.25, 1.0).unwrap();
        assert_eq!(share.of(Array2::ones((4, 4)).view()), 0.25);
        let dark = share.evaluate(Array2::zeros((4, 4)).view());
        assert_eq!((dark.value, dark.bar.sum()), (f64::INFINITY, 0.0));

        assert!(Share::efficiency(window.clone() * 2.0, 1.0, 1.0, 1.0).is_err());
        assert!(Share::efficiency(window.clone() * 0.0, 1.0, 1.0, 1.0).is_err());
        for bad in [0.0, -1.0, f64::NAN] {
            assert!(Share::efficiency(window.clone(), bad, 1.0, 1.0).is_err());
            assert!(Share::encircled(&raster(4, 1.0), &[[0.0; 2]], bad, None).is_err());
        }
        assert!(Share::encircled(&raster(4, 1.0), &[[9.0; 2]], 1.0, None).is_err());
    }
}
