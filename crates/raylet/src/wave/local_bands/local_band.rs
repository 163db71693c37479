//! The directions beside its carrier that a piece of light has, and the samples that it needs.

use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::carrier::Carrier;

/// Share of the strong beamlets whose directions a band holds.
const HELD: f64 = 0.999;

/// The strongest beamlet of a tile counts as at least this share of the screen's bright light. Otherwise a few weak
/// beamlets would decide the band of a dark tile.
const DARK: f64 = 0.1;

/// Samples per sample that the band needs.
const OVERSAMPLING: f64 = 1.1;

/// Half the band of a window itself, in units of 1/(kσ), for windows a `step` of so many σ apart: the division by the
/// coverage has sidebands, each with the tail of the Gaussian down to the threshold.
pub(crate) fn window_half_band(step: f64, threshold: f64) -> f64 {
    let turn = std::f64::consts::PI / step;
    let (mut band, mut height, mut place) = (0.0f64, 1.0f64, 0.0);
    while height > threshold {
        band = band.max(place + (2.0 * (height / threshold).ln()).sqrt());
        height *= (-turn * turn).exp();
        place += 2.0 * turn;
    }
    band
}

/// The pitch at which light of this half band is sampled, in mm.
pub(crate) fn sample_pitch(half_band: f64, wavelength: f64) -> f64 {
    wavelength / (2.0 * OVERSAMPLING * half_band)
}

/// A block of windows, as beamlets meet it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WindowBlock {
    /// The box of the centres of its windows, `[x_min, x_max, y_min, y_max]` in mm.
    pub centres: [f64; 4],
    /// Width σ of its windows, in mm.
    pub sigma: f64,
    /// Beamlets weaker than this share of the strongest do not count.
    pub threshold: f64,
    /// Amplitude of the bright beamlets of the screen.
    pub bright: f64,
}

/// How far directions of light differ from those of its carrier along x and y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Nearly the largest departure of all that the windows see.
    pub largest: [f64; 2],
    /// The root mean square by energy.
    pub usual: [f64; 2],
}

impl Spread {
    /// That of light that is even over its directions.
    pub(crate) fn even(largest: [f64; 2]) -> Self {
        let usual = largest.map(|side| side / 3f64.sqrt());
        Self { largest, usual }
    }
}

impl WindowBlock {
    /// Amplitude with which the windows see a beamlet.
    fn strength(&self, arrival: &Arrival) -> f64 {
        let [x0, x1, y0, y1] = self.centres;
        let outside = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
        let [u, v] = arrival.at;
        let (u, v) = (outside(u, x0, x1), outside(v, y0, y1));
        let far = (u * u + v * v) / (4.0 * self.sigma * self.sigma);
        arrival.amplitude.norm() * (-far).exp()
    }

    /// How far directions of beamlets differ from the carrier's along x and y.
    pub(crate) fn spread(&self, arrivals: &[Arrival], carrier: &Carrier) -> Spread {
        let strengths: Vec<f64> = arrivals.iter().map(|a| self.strength(a)).collect();
        let strongest = strengths.iter().fold(DARK * self.bright, |a, b| a.max(*b));
        let mut departures = [Vec::new(), Vec::new()];
        let (mut energy, mut squares) = (0.0, [0.0; 2]);
        for (arrival, strength) in arrivals.iter().zip(strengths) {
            let departure = carrier.departure(arrival);
            energy += strength * strength;
            for (a, departure) in departure.into_iter().enumerate() {
                squares[a] += (strength * departure).powi(2);
                if strength > self.threshold * strongest {
                    departures[a].push(departure.abs());
                }
            }
        }
        let largest = departures.map(|mut list| {
            let place = (HELD * list.len().saturating_sub(1) as f64).ceil() as usize;
            list.sort_by(f64::total_cmp);
            list.get(place).copied().unwrap_or(0.0)
        });
        let usual = squares.map(|sum| (sum / energy.max(f64::MIN_POSITIVE)).sqrt());
        Spread { largest, usual }
    }
}

/// The amplitude that all but a hundredth of the beamlets stay below.
pub(crate) fn bright_amplitude(arrivals: &[Arrival]) -> f64 {
    let mut sizes: Vec<f64> = arrivals.iter().map(|a| a.amplitude.norm()).collect();
    let place = sizes.len() * 99 / 100;
    if place >= sizes.len() {
        return 0.0;
    }
    *sizes.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use crate::wave::local_bands::local_band::window_half_band;

    /// The spectrum of g/Σg² outside the band is below the threshold, and just inside it is not.
    #[test]
    fn divided_windows_end_with_their_band() {
        for step in [1.25, 1.5, 1.75] {
            let cover = |u: f64| {
                let term = |j: i32| (-(u - step * f64::from(j)).powi(2)).exp();
                (-9..=9).map(term).sum::<f64>()
            };
            let at = |p: f64| {
                let node = |i: i32| {
                    let u = f64::from(i) * 0.02;
                    (-0.5 * u * u).exp() / cover(u) * (p * u).cos()
                };
                (-400..=400).map(node).sum::<f64>().abs()
            };
            let band = window_half_band(step, 1e-3);
            for step_out in 0..20 {
                assert!(
                    at(band + 0.1 * f64::from(step_out)) < 1.1e-3 * at(0.0),
                    "{step}"
                );
            }
            assert!(at(0.9 * band) > 1e-3 * at(0.0), "{step}");
        }
    }
}
