//! The sum of beamlets on a sensor, by sectors of direction.
//!
//! A beamlet that is wide beside the pixels is a plane wave with a slow envelope. Beamlets of one sector of direction share a
//! carrier; their envelopes are added on samples [`COARSE`] times as far apart as the pixels, and all sectors are
//! interpolated to the pixels at the end. Carriers that differ by a whole cycle a pixel are the same at all pixels, so a
//! lattice of [`SECTORS`]² carriers serves every direction. Other beamlets are added to the pixels themselves.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::sinc::WindowedSinc;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::beamlet_sum::{Canvas, Evaluations};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// The distance of samples of an envelope, in pixels.
const COARSE: usize = 4;

/// Envelopes have at most this part of the band of their samples.
const FILLED: f64 = 0.5;

/// Samples on either side of a pixel from which its value is interpolated. With [`FILLED`] the error is about 1e-7.
const REACH: usize = 10;

/// Carriers along an axis: neighbours are two thirds of an envelope's band apart.
const SECTORS: usize = 12;

/// Sensors with more pixels have no sectors, whose memory would grow with them.
const LARGEST: usize = 256 * 256;

/// Sensors have sectors where the samples of an envelope are at most this part of the pixels.
const WORTH: f64 = 0.5;

/// An envelope's band ends at this part of the threshold.
const BEYOND: f64 = 0.1;

/// A sum of beamlets on the pixels of a sensor.
pub(crate) struct SectorSum {
    pixels: Canvas,
    sectors: Sectors,
    /// The sums of envelopes, of those sectors that have any.
    sums: Vec<Option<Canvas>>,
}

/// The cotangent of a [`SectorSum`]: that of the pixels, and of the samples of each sector.
pub(crate) struct SectorBar {
    pixels: Canvas,
    sectors: Sectors,
    bars: Vec<Canvas>,
}

/// The sectors of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct Sectors {
    pixels: Raster,
    /// The samples of an envelope; nothing where no sectors are used.
    coarse: Option<Raster>,
    /// Weights of the samples on which a pixel depends, for each place between two samples.
    weights: [[f64; 2 * REACH]; COARSE],
}

/// A beamlet without the carrier of its sector.
#[derive(Clone, Copy, Debug)]
struct Envelope {
    sector: usize,
    arrival: Arrival,
    /// The carrier where the beamlet lands, conjugate: the amplitude has this factor.
    turn: Complex64,
}

impl SectorSum {
    /// An empty sum on the pixels of a raster.
    pub(crate) fn new(raster: Raster) -> Self {
        Self {
            pixels: Canvas::new(raster),
            sectors: Sectors::of(raster),
            sums: (0..SECTORS * SECTORS).map(|_| None).collect(),
        }
    }

    /// Adds beamlets, each where it exceeds `threshold` of its own peak; `k` is the vacuum wavenumber.
    pub(crate) fn add(&mut self, arrivals: &[Arrival], k: f64, threshold: f64) -> Evaluations {
        let Some(coarse) = self.sectors.coarse else {
            return self.pixels.add(arrivals, k, threshold);
        };
        let envelope = |arrival| self.sectors.envelope(arrival, k, threshold);
        let found: Vec<Option<Envelope>> = arrivals.par_iter().map(envelope).collect();
        let mut of_sector = vec![Vec::new(); self.sums.len()];
        let mut others = Vec::new();
        for (arrival, envelope) in arrivals.iter().zip(found) {
            match envelope {
                Some(Envelope {
                    sector, arrival, ..
                }) => of_sector[sector].push(arrival),
                None => others.push(*arrival),
            }
        }
        let lit = self.sums.par_iter_mut().zip(of_sector);
        let lit = lit.filter(|(_, envelopes)| !envelopes.is_empty());
        let values: Evaluations = lit
            .map(|(sum, envelopes)| {
                let sum = sum.get_or_insert_with(|| Canvas::new(coarse));
                sum.add(&envelopes, k, threshold)
            })
            .sum();
        values + self.pixels.add(&others, k, threshold)
    }

    /// The sum, indexed [y, x].
    pub(crate) fn finish(self) -> Array2<Complex64> {
        let mut total = self.pixels.finish();
        let sums: Vec<_> = self
            .sums
            .into_iter()
            .map(|sum| sum.map(Canvas::finish))
            .collect();
        let columns = |x: usize| {
            let of_column = (0..SECTORS).map(|y| sums[y * SECTORS + x].as_ref());
            self.sectors.interpolate(x, of_column)
        };
        let parts: Vec<_> = (0..SECTORS).into_par_iter().map(columns).collect();
        parts.into_iter().flatten().for_each(|part| total += &part);
        total
    }
}

impl SectorBar {
    /// Of the cotangent at the pixels of a raster, indexed [y, x].
    pub(crate) fn new(raster: Raster, values: &Array2<Complex64>) -> Self {
        let sectors = Sectors::of(raster);
        let columns = |x: usize| sectors.interpolate_adjoint(x, values);
        let bars: Vec<Vec<Canvas>> = match sectors.coarse {
            Some(_) => (0..SECTORS).into_par_iter().map(columns).collect(),
            None => Vec::new(),
        };
        Self {
            pixels: Canvas::holding(raster, values),
            sectors,
            bars: bars.into_iter().flatten().collect(),
        }
    }

    /// The conjugate transpose of [`SectorSum::add`] and [`SectorSum::finish`]: moments of the cotangent under beamlets of
    /// unit amplitude, as [`Canvas::add_adjoint`] has them.
    pub(crate) fn add_adjoint(&self, arrivals: &[Arrival], k: f64, threshold: f64) -> Vec<Moments> {
        let moments = |arrival: &Arrival| match self.sectors.envelope(arrival, k, threshold) {
            None => self.pixels.moments(arrival, k, threshold),
            Some(Envelope {
                sector,
                arrival,
                turn,
            }) => {
                let [y, x] = [sector / SECTORS, sector % SECTORS];
                let bar = &self.bars[x * SECTORS + y];
                (bar.moments(&arrival, k, threshold)).map(|moment| moment * turn.conj())
            }
        };
        arrivals.par_iter().map(moments).collect()
    }
}

impl Sectors {
    /// Those of the pixels of a raster.
    pub(crate) fn of(pixels: Raster) -> Self {
        let kernel = WindowedSinc::new(REACH, FILLED);
        let weights = std::array::from_fn(|place| {
            let after = place as f64 / COARSE as f64;
            std::array::from_fn(|tap| kernel.weight(tap as f64 - (REACH as f64 - 1.0) - after))
        });
        let pitch = pixels.pitch.map(|pitch| COARSE as f64 * pitch);
        let coarse = Raster {
            start: [0, 1].map(|a| pixels.start[a] - REACH as f64 * pitch[a]),
            pitch,
            size: (pixels.size).map(|size| size.saturating_sub(1) / COARSE + 2 * REACH + 1),
        };
        let count = |raster: &Raster| raster.size[0] * raster.size[1];
        let worth = count(&coarse) as f64 <= WORTH * count(&pixels) as f64;
        Self {
            pixels,
            coarse: (worth && count(&pixels) <= LARGEST).then_some(coarse),
            weights,
        }
    }

    /// About how many values a beamlet has that is added.
    pub(crate) fn values(&self, arrival: &Arrival, k: f64, threshold: f64) -> f64 {
        let samples = match (self.envelope(arrival, k, threshold), self.coarse) {
            (Some(_), Some(coarse)) => coarse,
            _ => self.pixels,
        };
        let reach = arrival.footprint(k, threshold);
        let along = |a: usize| {
            let first = samples.start[a] - 0.5 * samples.pitch[a];
            let last = first + samples.size[a] as f64 * samples.pitch[a];
            let low = (arrival.at[a] - reach[a]).max(first);
            ((arrival.at[a] + reach[a]).min(last) - low).max(0.0) / samples.pitch[a]
        };
        // An ellipse fills this much of its box.
        std::f64::consts::FRAC_PI_4 * along(0) * along(1)
    }

    /// A beamlet without the carrier of its sector; nothing where its envelope is not slow enough, or has no end.
    fn envelope(&self, arrival: &Arrival, k: f64, threshold: f64) -> Option<Envelope> {
        self.coarse?;
        let reach = arrival.footprint(k, threshold);
        let beyond = arrival.footprint(k, BEYOND * threshold);
        let [xx, xy, yy] = arrival.curvature;

        // Where its footprint meets the pixels, from its ray.
        let (mut middle, mut half) = ([0.0; 2], [0.0; 2]);
        for a in 0..2 {
            let first = self.pixels.start[a] - arrival.at[a];
            let last = first + (self.pixels.size[a] as f64 - 1.0) * self.pixels.pitch[a];
            let margin = (REACH * COARSE) as f64 * self.pixels.pitch[a];
            let low = (first - margin).max(-reach[a]);
            let high = (last + margin).min(reach[a]);
            if !reach[a].is_finite() || first > reach[a] || last < -reach[a] {
                return None;
            }
            (middle[a], half[a]) = (0.5 * (low + high), 0.5 * (high - low));
        }

        // Its direction there, in cycles a pixel, and how far others are from it.
        let rows = [[xx, xy], [xy, yy]];
        let mut sector = [0.0; 2];
        for a in 0..2 {
            let [g, h] = rows[a];
            let direction = arrival.cosines[a] + g.re * middle[0] + h.re * middle[1];
            let around = g.re.abs() * half[0] + h.re.abs() * half[1];
            let spread = g.im.abs() * beyond[0] + h.im.abs() * beyond[1];
            let cycles = k * self.pixels.pitch[a] / TAU;
            sector[a] = (direction * cycles * SECTORS as f64).round();
            let aside = (direction * cycles - sector[a] / SECTORS as f64).abs();
            if aside + (around + spread) * cycles > 0.5 * FILLED / COARSE as f64 {
                return None;
            }
        }
        Some(self.without_carrier(arrival, k, sector))
    }

    /// A beamlet without the carrier of these cycles in [`SECTORS`] pixels.
    fn without_carrier(&self, arrival: &Arrival, k: f64, cycles: [f64; 2]) -> Envelope {
        let mut envelope = *arrival;
        let mut turns = 0.0;
        let mut sector = [0; 2];
        for a in 0..2 {
            let per_mm = cycles[a] / (SECTORS as f64 * self.pixels.pitch[a]);
            envelope.cosines[a] -= TAU * per_mm / k;
            turns += per_mm * (arrival.at[a] - self.pixels.start[a]);
            sector[a] = cycles[a].rem_euclid(SECTORS as f64) as usize;
        }
        let turn = Complex64::cis(-TAU * turns);
        envelope.amplitude *= turn;
        Envelope {
            sector: sector[1] * SECTORS + sector[0],
            arrival: envelope,
            turn,
        }
    }

    /// The first sample on which a pixel depends, and the weights of all.
    fn taps(&self, pixel: usize) -> (usize, &[f64; 2 * REACH]) {
        (pixel / COARSE + 1, &self.weights[pixel % COARSE])
    }

    /// The field at the pixels of sectors that have the same carrier along x; nothing where all are empty.
    fn interpolate<'s>(
        &self,
        x: usize,
        sums: impl Iterator<Item = Option<&'s Array2<Complex64>>>,
    ) -> Option<Array2<Complex64>> {
        let [width, _] = self.coarse?.size;
        let [nx, ny] = self.pixels.size;
        let lit: Vec<_> = (sums.enumerate())
            .filter_map(|(y, sum)| Some((y, sum?)))
            .collect();
        if lit.is_empty() {
            return None;
        }
        let mut field = Array2::zeros((ny, nx));
        let (mut row, mut one) = (vec![Complex64::ZERO; width], vec![Complex64::ZERO; width]);
        for j in 0..ny {
            // Along y for each sector, with its carrier, then along x for all.
            row.fill(Complex64::ZERO);
            let (first, weights) = self.taps(j);
            for (y, sum) in &lit {
                one.fill(Complex64::ZERO);
                for (tap, weight) in weights.iter().enumerate() {
                    let samples = sum.row(first + tap);
                    (one.iter_mut().zip(samples))
                        .for_each(|(one, sample)| *one += sample * *weight);
                }
                let carrier = carrier(*y, j);
                (row.iter_mut().zip(&one)).for_each(|(row, one)| *row += one * carrier);
            }
            for i in 0..nx {
                let (first, weights) = self.taps(i);
                let taps = row[first..first + 2 * REACH].iter().zip(weights);
                let value: Complex64 = taps.map(|(sample, weight)| sample * *weight).sum();
                field[[j, i]] = value * carrier(x, i);
            }
        }
        Some(field)
    }

    /// The conjugate transpose of [`Sectors::interpolate`]: the cotangents of the sectors that have this carrier along x.
    fn interpolate_adjoint(&self, x: usize, field: &Array2<Complex64>) -> Vec<Canvas> {
        let Some(coarse) = self.coarse else {
            return Vec::new();
        };
        let [width, height] = coarse.size;
        let mut sums = vec![Array2::<Complex64>::zeros((height, width)); SECTORS];
        let mut row = vec![Complex64::ZERO; width];
        for (j, pixels) in field.rows().into_iter().enumerate() {
            row.fill(Complex64::ZERO);
            for (i, pixel) in pixels.iter().enumerate() {
                let (first, weights) = self.taps(i);
                let value = pixel * carrier(x, i).conj();
                let taps = row[first..first + 2 * REACH].iter_mut().zip(weights);
                taps.for_each(|(sample, weight)| *sample += value * *weight);
            }
            let (first, weights) = self.taps(j);
            for (y, sum) in sums.iter_mut().enumerate() {
                let carrier = carrier(y, j).conj();
                for (tap, weight) in weights.iter().enumerate() {
                    let factor = carrier * *weight;
                    let samples = sum.row_mut(first + tap);
                    (samples.into_iter().zip(&row))
                        .for_each(|(sample, row)| *sample += row * factor);
                }
            }
        }
        let holding = |sum: &Array2<Complex64>| Canvas::holding(coarse, sum);
        sums.iter().map(holding).collect()
    }
}

/// The carrier with these cycles in [`SECTORS`] pixels, at a pixel.
fn carrier(cycles: usize, pixel: usize) -> Complex64 {
    Complex64::cis(TAU * ((cycles * pixel) % SECTORS) as f64 / SECTORS as f64)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::wave::beamlet::beamlet_sum::Canvas;
    use crate::wave::beamlet::direction_sectors::{SectorBar, SectorSum};
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;

    const K: f64 = std::f64::consts::TAU / 0.55e-3;

    const RASTER: Raster = Raster {
        start: [-0.048, -0.03],
        pitch: [1.1e-3, 0.9e-3],
        size: [90, 77],
    };

    /// Beamlets in all directions, beside and over the sensor: four in five are wider than it, others narrow.
    fn arrivals() -> Vec<Arrival> {
        let random =
            |i: usize, j: usize| (((i * 37 + j * 101) as f64) * 0.618_033_988_7).fract() - 0.5;
        let one = |i: usize| {
            let width = if i.is_multiple_of(5) {
                0.004
            } else {
                0.05 + 0.05 * random(i, 1).abs()
            };
            let im = 1.0 / (K * width * width);
            Arrival {
                at: [0.2 * random(i, 4), 0.2 * random(i, 5)],
                cosines: [1.4 * random(i, 6), 1.4 * random(i, 7)],
                amplitude: Complex64::new(random(i, 8), random(i, 9)),
                curvature: [
                    Complex64::new(im * random(i, 10), im),
                    Complex64::new(im * random(i, 11), 0.5 * im * random(i, 3)),
                    Complex64::new(im * random(i, 12), 1.3 * im),
                ],
            }
        };
        (0..200).map(one).collect()
    }

    #[test]
    fn sectors_add_up_to_the_sum_on_the_pixels() {
        let (mut by_sectors, mut direct) = (SectorSum::new(RASTER), Canvas::new(RASTER));
        let values = by_sectors.add(&arrivals(), K, 1e-7);
        let all = direct.add(&arrivals(), K, 1e-7);
        assert!(2 * values < all, "{values} {all}");
        let (found, exact) = (by_sectors.finish(), direct.finish());
        let norm = |values: &Array2<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let error = (norm(&(&found - &exact)) / norm(&exact)).sqrt();
        assert!(error < 2e-7, "{error:e}");
    }

    /// The sum is linear in the amplitudes, and the first moments are the transpose; all moments are those on the pixels.
    #[test]
    fn add_dot_product() {
        let threshold = 1e-7;
        let bar = Array2::from_shape_fn((77, 90), |(j, i)| {
            let t = (j * 90 + i) as f64 * 0.618_033_988_7;
            Complex64::new(t.fract() - 0.5, (3.7 * t).fract() - 0.5)
        });
        let mut sum = SectorSum::new(RASTER);
        sum.add(&arrivals(), K, threshold);
        let sum = sum.finish();
        let moments = SectorBar::new(RASTER, &bar).add_adjoint(&arrivals(), K, threshold);
        let forward: Complex64 = bar.iter().zip(&sum).map(|(a, b)| a.conj() * b).sum();
        let pairs = moments.iter().zip(arrivals());
        let back: Complex64 = pairs.map(|(m, a)| m[0].conj() * a.amplitude).sum();
        let norm = |values: &Array2<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let size = (norm(&bar) * norm(&sum)).sqrt();
        assert!((forward - back).norm() < 1e-13 * size, "{forward} {back}");

        let direct = Canvas::holding(RASTER, &bar).add_adjoint(&arrivals(), K, threshold);
        for power in 0..6 {
            let part = |moments: &[[Complex64; 6]]| -> Vec<Complex64> {
                moments.iter().map(|moment| moment[power]).collect()
            };
            let (found, exact) = (part(&moments), part(&direct));
            let off: f64 = (found.iter().zip(&exact))
                .map(|(a, b)| (a - b).norm_sqr())
                .sum();
            let size: f64 = exact.iter().map(|b| b.norm_sqr()).sum();
            assert!(
                (off / size).sqrt() < 1e-5,
                "{power}: {:e}",
                (off / size).sqrt()
            );
        }
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut sum = SectorSum::new(RASTER);
                sum.add(&arrivals(), K, 1e-3);
                sum.finish()
            })
        };
        assert_eq!(run(1), run(3));
    }
}
