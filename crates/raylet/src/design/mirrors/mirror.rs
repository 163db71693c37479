//! A design of the pixels of a curved mirror: phases, or two phases whose waves add up, with the gradient of a
//! loss of the light on a plane sensor.
//!
//! Losses are of shares: |U|² times the area of a sensor's pixel, over all light that leaves the mirror. So light
//! that misses the sensor counts as lost, whatever the modulus of the pixels.

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

use crate::design::losses::loss::Loss;
use crate::engine::chain::arriving_light::{illuminate, sensor_of};
use crate::engine::chain::simulate_error::SimulateError;
use crate::math::vec3::Vec3;
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;
use crate::wave::free::pixel_hop::{PixelHop, TargetPlane};
use crate::wave::grid::field::{Axis, Grid};
use crate::wave::grid::raster::Raster;

/// The free values of each pixel: one phase, or two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreePixelValue {
    /// φ: the pixel reflects e^{iφ}.
    Phase,
    /// φ₁ and φ₂: the pixel reflects e^{iφ₁} + e^{iφ₂}, of modulus 0 to 2.
    TwoPhases,
}

impl FreePixelValue {
    /// Phases of each pixel.
    pub(crate) fn count(self) -> usize {
        match self {
            FreePixelValue::Phase => 1,
            FreePixelValue::TwoPhases => 2,
        }
    }

    /// The reflections, [y, x], by phases in rad: first those of all pixels, then the second ones of all.
    pub(crate) fn reflect(self, phases: &[f64], shape: (usize, usize)) -> Array2<Complex64> {
        let pixels = shape.0 * shape.1;
        Array2::from_shape_fn(shape, |(j, i)| {
            let own = phases.iter().skip(j * shape.1 + i).step_by(pixels);
            own.map(|phase| Complex64::cis(*phase)).sum()
        })
    }

    /// The derivatives by the phases from the cotangents of the reflections: Im(t̄ e^{−iφ}) for each.
    pub(crate) fn reflect_adjoint(
        self,
        phases: &[f64],
        values_bar: ArrayView2<Complex64>,
    ) -> Vec<f64> {
        let bars = values_bar.iter().cycle();
        let one = |(phase, bar): (&f64, &Complex64)| (bar * Complex64::cis(-phase)).im;
        phases.iter().zip(bars).map(one).collect()
    }
}

/// A mirror whose pixels are designed.
pub struct MirrorDesign {
    hop: PixelHop,
    shape: (usize, usize),
    /// Area of each pixel within the aperture over that of a pixel of the sensor, [y, x].
    area: Array2<f64>,
    freedom: FreePixelValue,
    loss: Box<dyn Loss>,
}

/// One evaluation of the phases.
pub struct MirrorEvaluation {
    /// The loss.
    pub value: f64,
    /// Derivative of the loss by each phase, in 1/rad.
    pub gradient: Vec<f64>,
    /// Share of the light behind the mirror on each pixel of the sensor, [y, x].
    pub shares: Array2<f64>,
}

/// Why a mirror cannot be designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MirrorError {
    /// It has no sensor.
    #[error(transparent)]
    Sensor(#[from] SimulateError),
    /// It is not one pixelated element.
    #[error("expected one element of pixels before the sensor")]
    Pixels,
    /// The loss is for another sensor.
    #[error("a loss for {expected:?} pixels (rows, columns) on a sensor of {found:?}")]
    Shape {
        /// What the loss expects.
        expected: (usize, usize),
        /// What the sensor has.
        found: (usize, usize),
    },
}

impl MirrorDesign {
    /// The design of the mirror of a system that is lit along its axis and has a sensor parallel to it. The loss gets
    /// the share of the light on each pixel of the sensor, [y, x].
    ///
    /// # Errors
    /// When the system is another, or the loss is for another sensor.
    pub fn new(
        system: &System,
        freedom: FreePixelValue,
        loss: Box<dyn Loss>,
    ) -> Result<Self, MirrorError> {
        let raster = Raster::of(sensor_of(system)?);
        let found = (raster.size[1], raster.size[0]);
        if loss.shape() != found {
            let expected = loss.shape();
            return Err(MirrorError::Shape { expected, found });
        }
        let [screen, last] = &system.screens[..] else {
            return Err(MirrorError::Pixels);
        };
        let ScreenKind::Doe(doe) = &screen.kind else {
            return Err(MirrorError::Pixels);
        };
        let pixels = doe.free_pixels().ok_or(MirrorError::Pixels)?;
        let (shape, pitch) = (pixels.values.dim(), pixels.pitch);
        let grid = Grid {
            x: Axis::uniform(shape.1, pitch[0], 0.0),
            y: Axis::uniform(shape.0, pitch[1], 0.0),
        };
        let whole = pitch[0] * pitch[1];
        let mut area = Array2::from_shape_fn(shape, |(j, i)| {
            let ([x0, x1], [y0, y1]) = (grid.x.span(i), grid.y.span(j));
            doe.aperture.coverage(x0, x1, y0, y1)
        });
        let mut arrived = illuminate(system, grid);
        Zip::from(&mut arrived.values)
            .and(&area)
            .for_each(|u, open| *u *= open);
        area *= whole / (raster.pitch[0] * raster.pitch[1]);

        // The sensor's middle as the mirror sees it.
        let middle = screen
            .frame
            .to_local(last.frame.to_global(Vec3::new(0.0, 0.0, 0.0)));
        let start = [raster.start[0] + middle.x, raster.start[1] + middle.y];
        let target = Raster { start, ..raster };
        let plane = TargetPlane {
            distance: middle.z,
            target: &target,
        };
        let hop = PixelHop::new(screen, &arrived, plane, system.wavelength);
        Ok(Self {
            hop,
            shape,
            area,
            freedom,
            loss,
        })
    }

    /// Number of phases.
    pub fn len(&self) -> usize {
        self.freedom.count() * self.area.len()
    }

    /// Whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }

    /// The reflections of the pixels by their phases, [y, x].
    pub fn reflections(&self, phases: &[f64]) -> Array2<Complex64> {
        self.freedom.reflect(phases, self.shape)
    }

    /// The phases in rad that send light back to where a field on the sensor's pixels says it comes from, [y, x] both.
    pub fn conjugate(&self, field: ArrayView2<Complex64>) -> Array2<f64> {
        self.hop.carry_adjoint(field).mapv(|u| u.arg())
    }

    /// The share of the light on each pixel of the sensor for reflections, [y, x].
    pub fn shares(&self, values: ArrayView2<Complex64>) -> Array2<f64> {
        let sent = self.sent(values);
        self.hop.carry(values).mapv(|u| u.norm_sqr() / sent)
    }

    /// ∫|U|² behind the mirror, over the area of a pixel of the sensor.
    fn sent(&self, values: ArrayView2<Complex64>) -> f64 {
        let sent = Zip::from(values).and(&self.area);
        sent.fold(0.0, |sum, value, area| sum + value.norm_sqr() * area)
    }

    /// Value and gradient for phases in rad.
    pub fn evaluate(&self, phases: &[f64]) -> MirrorEvaluation {
        let values = self.reflections(phases);
        let field = self.hop.carry(values.view());
        let sent = self.sent(values.view());
        let shares = field.mapv(|u| u.norm_sqr() / sent);

        // share = |U|²/sent: Ū = 2·bar·U/sent, and sent falls by the shares' own weight.
        let found = self.loss.evaluate(shares.view());
        let mut field_bar = field;
        field_bar.zip_mut_with(&found.bar, |u, bar| *u *= 2.0 * bar / sent);
        let mut values_bar = self.hop.carry_adjoint(field_bar.view());
        let pull = 2.0 * (&found.bar * &shares).sum() / sent;
        Zip::from(&mut values_bar)
            .and(&values)
            .and(&self.area)
            .for_each(|bar, value, area| *bar -= value * (pull * area));
        MirrorEvaluation {
            value: found.value,
            gradient: self.freedom.reflect_adjoint(phases, values_bar.view()),
            shares,
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::design::holograms::start::random_phase;
    use crate::design::losses::likeness::{Brightness, Likeness};
    use crate::design::mirrors::mirror::{FreePixelValue, MirrorDesign, MirrorError};
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{element, on_axis, pixel_layer, screen, sensor};
    use crate::math::random::Purpose;
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::conic::Conic;
    use crate::optics::frame::Frame;
    use crate::optics::freeform::Term;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::shape::Shape;
    use crate::optics::source::Source;
    use crate::optics::system::System;

    /// Pixels along each side of the mirror.
    const COUNT: usize = 41;

    /// A round mirror with a Gaussian bump of one wavelength, lit along −z, and a sensor above it.
    fn system() -> System {
        let ones = Array2::from_elem((COUNT, COUNT), Complex64::ONE);
        let mut doe = element(
            pixel_layer(ones, 5e-4, PixelForm::Box),
            Aperture::disc(0.01),
        );
        doe.reflect = true;
        let base = Conic {
            curvature: 0.0,
            conic: 0.0,
        };
        let bump = Term::Gaussian {
            height: 1.012e-3,
            centre: [0.0; 2],
            sigma: 6.4e-3,
        };
        let mirror = Screen {
            shape: Shape::Freeform {
                base,
                terms: vec![bump],
            },
            arrives: -1.0,
            ..screen(Frame::GLOBAL, ScreenKind::Doe(doe))
        };
        System {
            wavelength: 1e-3,
            source: Source::Plane {
                direction: Vec3::new(0.0, 0.0, -1.0),
                origin: Vec3::new(0.0, 0.0, 0.0),
            },
            screens: vec![mirror, screen(on_axis(0.02004), sensor(20, 1e-3))],
            trains: vec![vec![]],
        }
    }

    fn design(freedom: FreePixelValue, brightness: Brightness) -> MirrorDesign {
        // As large as the shares are.
        let target = Array2::from_shape_fn((20, 20), |(j, i)| 4e-4 * ((i * j) % 7) as f64);
        let loss = Likeness::new(target, None, brightness).unwrap();
        MirrorDesign::new(&system(), freedom, Box::new(loss)).unwrap()
    }

    #[test]
    fn reflect_dot_product_with_differences() {
        let (shape, freedom) = ((3, 4), FreePixelValue::TwoPhases);
        let phases: Vec<f64> = (0..24).map(|n| f64::from(n * n)).collect();
        let bar = noise(shape, 1);
        let back = freedom.reflect_adjoint(&phases, bar.view());
        for n in 0..24 {
            let at = |step: f64| {
                let mut phases = phases.clone();
                phases[n] += step;
                let values = freedom.reflect(&phases, shape);
                let pairs = bar.iter().zip(&values);
                pairs
                    .map(|(bar, value)| (bar.conj() * value).re)
                    .sum::<f64>()
            };
            let h = 1e-3;
            let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            assert!((slope - back[n]).abs() < 1e-9, "{slope} {}", back[n]);
        }
        let one = FreePixelValue::Phase.reflect(&phases[..12], shape);
        assert!(one.iter().all(|value| (value.norm() - 1.0).abs() < 1e-15));
    }

    /// The whole chain, of one phase and of two, for losses that do and do not see how much light is lost.
    #[test]
    fn pixel_phases_match_central_differences() {
        for freedom in [FreePixelValue::Phase, FreePixelValue::TwoPhases] {
            for brightness in [Brightness::Free, Brightness::Given { scale: 1.0 }] {
                let design = design(freedom, brightness);
                let rows = design.len() / COUNT;
                let phases = random_phase(3, 0, Purpose::StartPhase, (rows, COUNT))
                    .into_raw_vec_and_offset()
                    .0;
                let way = random_phase(4, 0, Purpose::StartPhase, (rows, COUNT))
                    .into_raw_vec_and_offset()
                    .0;
                let at = |step: f64| {
                    let there: Vec<f64> =
                        phases.iter().zip(&way).map(|(p, d)| p + step * d).collect();
                    design.evaluate(&there).value
                };
                let near = (at(1e-4) - at(-1e-4)) / 2e-4;
                let far = (at(2e-4) - at(-2e-4)) / 4e-4;
                let slope = (4.0 * near - far) / 3.0;
                let gradient = design.evaluate(&phases).gradient;
                let found: f64 = gradient.iter().zip(&way).map(|(g, d)| g * d).sum();
                let size: f64 = gradient
                    .iter()
                    .zip(&way)
                    .map(|(g, d)| (g * d).powi(2))
                    .sum();
                let error = (found - slope).abs() / size.sqrt();
                assert!(error < 1e-7, "{freedom:?} {brightness:?}: {found} {slope}");
            }
        }
    }

    /// No more light arrives than is sent, and twice the modulus is the same share.
    #[test]
    fn shares_are_of_the_light_that_is_sent() {
        let design = design(FreePixelValue::TwoPhases, Brightness::Free);
        let one = random_phase(5, 0, Purpose::StartPhase, (design.len() / 2, 1))
            .into_raw_vec_and_offset()
            .0;
        let both: Vec<f64> = one.iter().chain(&one).copied().collect();
        let shares = design.evaluate(&both).shares;
        assert!((0.05..1.0).contains(&shares.sum()), "{}", shares.sum());
        let phase = self::design(FreePixelValue::Phase, Brightness::Free);
        let same = phase.evaluate(&one).shares;
        assert!((&shares - &same).iter().all(|off| off.abs() < 1e-12));
    }

    #[test]
    fn other_systems_are_refused() {
        let loss = || {
            let target = Array2::ones((20, 20));
            Box::new(Likeness::new(target, None, Brightness::Free).unwrap())
        };
        let mut other = system();
        other.screens.remove(0);
        let refused = MirrorDesign::new(&other, FreePixelValue::Phase, loss());
        assert!(matches!(refused, Err(MirrorError::Pixels)));
        let target = Array2::ones((20, 21));
        let wide = Likeness::new(target, None, Brightness::Free).unwrap();
        let refused = MirrorDesign::new(&system(), FreePixelValue::Phase, Box::new(wide));
        assert!(matches!(refused, Err(MirrorError::Shape { .. })));
    }
}
