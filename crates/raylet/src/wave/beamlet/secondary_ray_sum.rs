//! Rays of any tracer on a sensor: the coherent sum of what they bring, and the transposed call.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::nufft::NufftError;
use crate::optics::bundle::{Hit, RayError, Rays, check_finite, check_positive};
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::beams::Beams;
use crate::wave::beamlet::plane::{PlaneSum, PlaneWave};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// The wave that an arriving ray adds to the field on the sensor. α is its weight times exp(ik·path), s the place
/// where it lands in mm, and p its optical direction cosines there.
#[derive(Clone, Copy, Debug)]
pub enum Wavelet<'a> {
    /// α·exp(ik p·(x − s)): correct behind empty space, biased behind surfaces with power.
    Plain,
    /// The wave of [`Wavelet::Plain`] times the prefactor √det(D + ikσ²C), from the beamlets: correct behind lenses and
    /// mirrors.
    Prefactor(&'a Beams),
    /// α·amplitude·exp(ik[p·(x − s) + ½(x − s)ᵀG(x − s)]), the beamlets themselves.
    Beamlet(&'a Beams),
}

/// Why rays cannot be summed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SecondaryRayError {
    /// The arrays or settings are wrong.
    #[error(transparent)]
    Rays(#[from] RayError),
    /// The sum of plane waves cannot be planned.
    #[error(transparent)]
    Sum(#[from] NufftError),
    /// The screen is not a plane sensor.
    #[error("screen '{0}' is not a plane sensor, expected one")]
    NoSensor(String),
}

/// Cotangents of what rays bring to a sensor, one for each ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SecondaryRaySumBar {
    /// Cotangent of the weight.
    pub weight: Vec<Complex64>,
    /// Derivative by the optical path, in 1/mm.
    pub path: Vec<f64>,
    /// Derivative by the place, along the sensor's x and y axes, in 1/mm.
    pub at: Vec<[f64; 2]>,
    /// Derivative by the optical direction cosines along these axes.
    pub cosines: Vec<[f64; 2]>,
    /// For beamlets the cotangent of the amplitude gained on the way; else empty.
    pub amplitude: Vec<Complex64>,
    /// For beamlets the cotangent of the curvature (xx, xy, yy), in mm; else empty.
    pub curvature: Vec<[Complex64; 3]>,
}

/// The sum of rays on a sensor.
#[derive(Clone, Copy, Debug)]
pub struct SecondaryRaySum<'a> {
    screen: &'a Screen,
    raster: Raster,
    wavelength: f64,
    tolerance: f64,
    k: f64,
}

impl<'a> SecondaryRaySum<'a> {
    /// A sum on a plane sensor, whose pixel centres are the points of the sum; `wavelength` is that of
    /// the vacuum, in mm. `tolerance`: beamlets end where they fall below this share of their peak; plane
    /// waves are summed to this relative error.
    ///
    /// # Errors
    /// When the screen is no plane sensor, or a number is out of range.
    pub fn new(
        screen: &'a Screen,
        wavelength: f64,
        tolerance: f64,
    ) -> Result<Self, SecondaryRayError> {
        let ScreenKind::Sensor(sensor) = &screen.kind else {
            return Err(SecondaryRayError::NoSensor(screen.name.clone()));
        };
        if !screen.is_plane() {
            return Err(SecondaryRayError::NoSensor(screen.name.clone()));
        }
        check_positive("wavelength", wavelength)?;
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(SecondaryRayError::Rays(RayError::Setting {
                field: "tolerance",
                found: tolerance.to_string(),
                expected: "a share between 0 and 1",
            }));
        }
        Ok(Self {
            screen,
            raster: Raster::of(sensor),
            wavelength,
            tolerance,
            k: std::f64::consts::TAU / wavelength,
        })
    }

    /// The rays on the sensor's own axes.
    ///
    /// # Errors
    /// When the arrays are wrong.
    pub fn hits(&self, rays: &Rays) -> Result<Vec<Hit>, RayError> {
        rays.hits(self.screen, self.wavelength)
    }

    /// The field that rays bring to the sensor's pixel centres, indexed [y, x].
    ///
    /// # Errors
    /// When the arrays are wrong, or the tolerance is out of reach.
    pub fn sum(
        &self,
        rays: &Rays,
        wavelet: &Wavelet,
    ) -> Result<Array2<Complex64>, SecondaryRayError> {
        let hits = self.hits(rays)?;
        match wavelet {
            Wavelet::Beamlet(beams) => {
                beams.check(rays.len())?;
                let mut canvas = Canvas::new(self.raster);
                canvas.add(&self.arrivals(rays, &hits, beams), self.k, self.tolerance);
                Ok(canvas.finish())
            }
            Wavelet::Plain | Wavelet::Prefactor(_) => {
                let factors = self.factors(&hits, wavelet)?;
                let mut sum = PlaneSum::new(self.raster, self.k, self.tolerance)?;
                sum.add(&self.waves(rays, &hits, &factors));
                Ok(sum.finish())
            }
        }
    }

    /// The conjugate transpose of [`SecondaryRaySum::sum`] by the weights, and the gradients by path, place
    /// and direction, given cotangents of the field, indexed [y, x]; for beamlets by their amplitudes and
    /// curvatures too. The prefactor of plane waves is held constant.
    ///
    /// # Errors
    /// As [`SecondaryRaySum::sum`], and when the cotangents have another shape than the sensor.
    pub fn sum_adjoint(
        &self,
        rays: &Rays,
        wavelet: &Wavelet,
        field_bar: &Array2<Complex64>,
    ) -> Result<SecondaryRaySumBar, SecondaryRayError> {
        let hits = self.hits(rays)?;
        let [nx, ny] = self.raster.size;
        if field_bar.dim() != (ny, nx) {
            return Err(SecondaryRayError::Rays(RayError::Setting {
                field: "field_bar",
                found: format!("an array of shape {:?}", field_bar.shape()),
                expected: "the shape [ny, nx] of the sensor",
            }));
        }
        check_finite("field_bar", field_bar.iter().map(|v| [v.re, v.im]))?;
        let mut bar = SecondaryRaySumBar::default();
        match wavelet {
            Wavelet::Beamlet(beams) => {
                beams.check(rays.len())?;
                let arrivals = self.arrivals(rays, &hits, beams);
                let canvas = Canvas::holding(self.raster, field_bar);
                let moments = canvas.add_adjoint(&arrivals, self.k, self.tolerance);
                for (i, moments) in moments.iter().enumerate() {
                    let gain = beams.amplitude[i];
                    bar.push(self.k, rays.weight[i], gain, &arrivals[i], moments);
                }
            }
            Wavelet::Plain | Wavelet::Prefactor(_) => {
                let factors = self.factors(&hits, wavelet)?;
                let waves = self.waves(rays, &hits, &factors);
                let sum = PlaneSum::new(self.raster, self.k, self.tolerance)?;
                let moments = sum.add_adjoint(field_bar, &waves);
                for (i, [one, u, v]) in moments.into_iter().enumerate() {
                    let flat = Arrival {
                        at: waves[i].at,
                        cosines: waves[i].cosines,
                        amplitude: waves[i].amplitude,
                        curvature: [Complex64::ZERO; 3],
                    };
                    let none = Complex64::ZERO;
                    let moments = [one, u, v, none, none, none];
                    bar.push(self.k, rays.weight[i], factors[i], &flat, &moments);
                }
                bar.amplitude.clear();
                bar.curvature.clear();
            }
        }
        // α = weight·gain·exp(ik·path)
        for (weight, path) in bar.weight.iter_mut().zip(rays.path) {
            *weight *= Complex64::cis(-self.k * path);
        }
        for (amplitude, path) in bar.amplitude.iter_mut().zip(rays.path) {
            *amplitude *= Complex64::cis(-self.k * path);
        }
        Ok(bar)
    }

    /// What the plane wave of each ray is multiplied by beside its weight and path.
    fn factors(&self, hits: &[Hit], wavelet: &Wavelet) -> Result<Vec<Complex64>, RayError> {
        let beams = match wavelet {
            Wavelet::Plain => return Ok(vec![Complex64::ONE; hits.len()]),
            Wavelet::Prefactor(beams) | Wavelet::Beamlet(beams) => beams,
        };
        beams.check(hits.len())?;
        let factor = |(i, hit): (usize, &Hit)| {
            let beamlet = Arrival {
                at: hit.at,
                cosines: hit.cosines,
                amplitude: beams.amplitude[i],
                curvature: beams.curvature[i],
            };
            PlaneWave::from_beamlet(&beamlet).amplitude
        };
        Ok(hits.iter().enumerate().map(factor).collect())
    }

    fn arrivals(&self, rays: &Rays, hits: &[Hit], beams: &Beams) -> Vec<Arrival> {
        let arrival = |(i, hit): (usize, &Hit)| Arrival {
            at: hit.at,
            cosines: hit.cosines,
            amplitude: rays.weight[i] * beams.amplitude[i] * Complex64::cis(self.k * rays.path[i]),
            curvature: beams.curvature[i],
        };
        hits.iter().enumerate().map(arrival).collect()
    }

    fn waves(&self, rays: &Rays, hits: &[Hit], factors: &[Complex64]) -> Vec<PlaneWave> {
        let wave = |(i, hit): (usize, &Hit)| PlaneWave {
            at: hit.at,
            cosines: hit.cosines,
            amplitude: rays.weight[i] * factors[i] * Complex64::cis(self.k * rays.path[i]),
        };
        hits.iter().enumerate().map(wave).collect()
    }
}

impl SecondaryRaySumBar {
    /// Cotangents of one ray from the moments of those of the field; of weight and amplitude without the
    /// phase of the path.
    fn push(
        &mut self,
        k: f64,
        weight: Complex64,
        gain: Complex64,
        arrival: &Arrival,
        moments: &[Complex64; 6],
    ) {
        let [one, u, v, uu, uv, vv] = *moments;
        let [p, q] = arrival.cosines;
        let [xx, xy, yy] = arrival.curvature;
        let alpha = arrival.amplitude;
        // field += α·exp(ik[p·(x−s) + ½(x−s)ᵀG(x−s)])
        let by_phase = |moment: Complex64| k * (moment * alpha.conj()).im;
        self.weight.push(one * gain.conj());
        self.amplitude.push(one * weight.conj());
        self.path.push(by_phase(one));
        self.cosines.push([by_phase(u), by_phase(v)]);
        let (xx, xy, yy) = (xx.conj(), xy.conj(), yy.conj());
        self.at.push([
            -by_phase(one * p + xx * u + xy * v),
            -by_phase(one * q + xy * u + yy * v),
        ]);
        let by_curvature = (Complex64::i() * k * alpha).conj();
        self.curvature.push([
            by_curvature * uu * 0.5,
            by_curvature * uv,
            by_curvature * vv * 0.5,
        ]);
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::screen;
    use crate::math::random::pair;
    use crate::math::vec3::Vec3;
    use crate::optics::bundle::Rays;
    use crate::optics::frame::Frame;
    use crate::optics::screen::{Screen, ScreenKind, Sensor};

    use crate::wave::beamlet::beams::Beams;
    use crate::wave::beamlet::secondary_ray_sum::{SecondaryRaySum, Wavelet};

    const WAVELENGTH: f64 = 1.0;

    fn sensor() -> Screen {
        let frame = Frame::GLOBAL.moved(Vec3::new(3.0, -5.0, 40.0));
        let pixels = ScreenKind::Sensor(Sensor {
            pixels: [41, 32],
            pitch: [0.7, 0.9],
        });
        Screen {
            index: 1.2,
            ..screen(frame.tilted([0.2, -0.3, 0.4]), pixels)
        }
    }

    /// Rays on the sensor, in columns.
    #[derive(Clone)]
    struct Columns {
        position: Vec<[f64; 3]>,
        direction: Vec<[f64; 3]>,
        path: Vec<f64>,
        weight: Vec<Complex64>,
        beams: Beams,
    }

    impl Columns {
        fn new(count: u32) -> Self {
            let draw = |i, what| pair(8, [i, what, 0, 0]).map(|u| u - 0.5);
            let complex = |i, what| {
                let [re, im] = draw(i, what);
                Complex64::new(re, im)
            };
            let curvature = |i| {
                let ([a, b], [c, d]) = (draw(i, 4), draw(i, 5));
                let [e, f] = draw(i, 6);
                [
                    Complex64::new(0.05 * a, 0.03 + 0.02 * b),
                    Complex64::new(0.05 * c, 0.02 * d),
                    Complex64::new(0.05 * e, 0.03 + 0.02 * f),
                ]
            };
            let mut columns = Self {
                position: Vec::new(),
                direction: Vec::new(),
                path: (0..count).map(|i| 70.0 * draw(i, 3)[0]).collect(),
                weight: (0..count).map(|i| complex(i, 2)).collect(),
                beams: Beams {
                    amplitude: (0..count).map(|i| complex(i, 7)).collect(),
                    curvature: (0..count).map(curvature).collect(),
                },
            };
            for i in 0..count {
                columns.push(draw(i, 0).map(|u| 30.0 * u), draw(i, 1).map(|u| 0.6 * u));
            }
            columns
        }

        /// A ray that lands at a place of the sensor with optical direction cosines.
        fn push(&mut self, [x, y]: [f64; 2], [p, q]: [f64; 2]) {
            let frame = sensor().frame;
            let n = sensor().index;
            let d = Vec3::new(p / n, q / n, (1.0 - (p * p + q * q) / (n * n)).sqrt());
            let (s, d) = (
                frame.to_global(Vec3::new(x, y, 0.0)),
                frame.direction_to_global(d),
            );
            self.position.push([s.x, s.y, s.z]);
            self.direction.push([d.x, d.y, d.z]);
        }

        fn rays(&self) -> Rays<'_> {
            Rays {
                position: &self.position,
                direction: &self.direction,
                path: &self.path,
                weight: &self.weight,
            }
        }
    }

    fn inner(a: &Array2<Complex64>, b: &Array2<Complex64>) -> Complex64 {
        a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    }

    #[test]
    fn collect_dot_product() {
        let (screen, columns, bar) = (sensor(), Columns::new(60), noise((32, 41), 9));
        let ray_sum = SecondaryRaySum::new(&screen, WAVELENGTH, 1e-6).unwrap();
        for wavelet in [
            Wavelet::Plain,
            Wavelet::Prefactor(&columns.beams),
            Wavelet::Beamlet(&columns.beams),
        ] {
            let field = ray_sum.sum(&columns.rays(), &wavelet).unwrap();
            let back = ray_sum
                .sum_adjoint(&columns.rays(), &wavelet, &bar)
                .unwrap();
            let forward = inner(&bar, &field);
            let pairs = back.weight.iter().zip(&columns.weight);
            let reverse: Complex64 = pairs.map(|(bar, w)| bar.conj() * w).sum();
            let size = (inner(&bar, &bar) * inner(&field, &field)).norm().sqrt();
            assert!((forward - reverse).norm() < 1e-13 * size, "{wavelet:?}");
        }
    }

    /// Re⟨bar, field⟩ by central differences in what one ray is, against the gradients.
    #[test]
    fn gradients_match_differences() {
        let (screen, bar, h) = (sensor(), noise((32, 41), 9), 1e-5);
        let ray_sum = SecondaryRaySum::new(&screen, WAVELENGTH, 1e-11).unwrap();
        let columns = Columns::new(7);
        let hits = ray_sum.hits(&columns.rays()).unwrap();
        for beamlets in [false, true] {
            let value = |columns: &Columns| {
                let wavelet = if beamlets {
                    Wavelet::Beamlet(&columns.beams)
                } else {
                    Wavelet::Plain
                };
                inner(&bar, &ray_sum.sum(&columns.rays(), &wavelet).unwrap()).re
            };
            let wavelet = if beamlets {
                Wavelet::Beamlet(&columns.beams)
            } else {
                Wavelet::Plain
            };
            let back = ray_sum
                .sum_adjoint(&columns.rays(), &wavelet, &bar)
                .unwrap();
            let difference = |change: &dyn Fn(&mut Columns, f64)| {
                let [plus, minus] = [h, -h].map(|h| {
                    let mut moved = columns.clone();
                    change(&mut moved, h);
                    value(&moved)
                });
                (plus - minus) / (2.0 * h)
            };
            let ray = 4;
            let moved = |columns: &mut Columns, at: [f64; 2], cosines: [f64; 2]| {
                columns.push(at, cosines);
                columns.position.swap_remove(ray);
                columns.direction.swap_remove(ray);
            };
            let (at, p) = (hits[ray].at, hits[ray].cosines);
            let mut checks = vec![
                (
                    back.path[ray],
                    difference(&|columns, h| columns.path[ray] += h),
                ),
                (
                    back.at[ray][0],
                    difference(&|columns, h| moved(columns, [at[0] + h, at[1]], p)),
                ),
                (
                    back.at[ray][1],
                    difference(&|columns, h| moved(columns, [at[0], at[1] + h], p)),
                ),
                (
                    back.cosines[ray][0],
                    difference(&|columns, h| moved(columns, at, [p[0] + h, p[1]])),
                ),
                (
                    back.cosines[ray][1],
                    difference(&|columns, h| moved(columns, at, [p[0], p[1] + h])),
                ),
                (
                    back.weight[ray].im,
                    difference(&|columns, h| columns.weight[ray].im += h),
                ),
            ];
            if beamlets {
                checks.push((
                    back.amplitude[ray].re,
                    difference(&|columns, h| columns.beams.amplitude[ray].re += h),
                ));
                for c in 0..3 {
                    checks.push((
                        back.curvature[ray][c].re,
                        difference(&|columns, h| columns.beams.curvature[ray][c].re += 0.1 * h)
                            * 10.0,
                    ));
                    checks.push((
                        back.curvature[ray][c].im,
                        difference(&|columns, h| columns.beams.curvature[ray][c].im += 0.1 * h)
                            * 10.0,
                    ));
                }
            }
            for (number, (ours, theirs)) in checks.iter().enumerate() {
                assert!(
                    (ours - theirs).abs() < 1e-6 * (1.0 + theirs.abs()),
                    "{beamlets} {number}: {ours} {theirs}"
                );
            }
        }
    }

    #[test]
    fn wrong_arrays_are_refused() {
        let screen = sensor();
        let ray_sum = SecondaryRaySum::new(&screen, WAVELENGTH, 1e-6).unwrap();
        let columns = Columns::new(3);
        let bar = Array2::zeros((41, 32));
        let found = ray_sum.sum_adjoint(&columns.rays(), &Wavelet::Plain, &bar);
        let text = found.unwrap_err().to_string();
        assert!(
            text.contains("field_bar") && text.contains("[41, 32]"),
            "{text}"
        );
        let short = Beams::default();
        let found = ray_sum.sum(&columns.rays(), &Wavelet::Beamlet(&short));
        let text = found.unwrap_err().to_string();
        assert_eq!(
            text,
            "beam amplitude has 0 entries, expected 3: one for each position"
        );
        assert!(SecondaryRaySum::new(&screen, WAVELENGTH, 1.5).is_err());
    }
}
