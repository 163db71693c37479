//! The beamlets of one window.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_aberration::Aberration;
use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::error::tally::Fate;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::hop_changes::{HopChanges, SentBeamlet};
use crate::engine::local_bands::target::TargetRegion;
use crate::math::erfc::erfc;
use crate::optics::aperture::Aperture;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::wavelet::{Arrival, Tail};
use crate::wave::local_bands::fourier_axis::Modes;

/// Largest η that is corrected. Windows whose centres lie outside an aperture have more aberration there than in their
/// light. The field of a telephone's lens has errors of 6.3e-4 and 7.0e-4 with 0.15 here, 4.7e-4 and 5.5e-4 with 0.8.
const CORRECTABLE: f64 = 0.8;

/// Width of a square of directions, in optical cosines, whose beamlets share the aberration of their strongest one.
const ALIKE: f64 = 0.1;

/// Windows farther inside an edge than this, in σ, do not notice it.
const BESIDE_EDGE: f64 = 3.0;

/// Plane waves of an edge alone are left out where they are weaker than this share of what others are: each is weak, and together
/// they are one wave.
pub(crate) const WEAKER_OF_EDGE: f64 = 0.3;

/// Of the plane waves that are left out one is traced for so many times the energy of the weakest one that is followed.
const WEAK_SAMPLE: f64 = 4.0;

/// What all windows of a hop share when they send their beamlets.
#[derive(Clone, Copy)]
pub(crate) struct Emission<'a> {
    /// The hop.
    pub hop: &'a Hop<'a>,
    /// The target of the beamlets.
    pub target: &'a TargetRegion,
    /// Plane waves weaker than this are left out.
    pub weakest: f64,
    /// Energy of the plane waves of a window under a unit plane wave.
    pub unit: f64,
    /// Whether the aberration inside beamlets is corrected.
    pub corrected: bool,
    /// The aperture of the emitting screen.
    pub aperture: Option<&'a Aperture>,
    /// How far beside smooth light, in optical cosines, the first orders of the lattice of windows lie; nothing for the light of
    /// pixels, which has all directions.
    pub beside: Option<f64>,
}

/// Beamlets that reach the target, with statistics of how they came about.
#[derive(Default)]
pub(crate) struct Emitted {
    /// The beamlets.
    pub arrivals: Vec<Arrival>,
    /// What beamlets of a source start with that pass the aperture at the end of the hop.
    pub passing: Vec<ChirpedStart>,
    /// The statistics.
    pub statistics: HopStatistics,
    /// Energy of plane waves that were left out since the last one of them was sampled, in parts of what a sample stands for.
    unsampled: f64,
}

/// Plane waves of a window, and where they go.
pub(crate) struct WindowWaves {
    /// The carrier and width of the window.
    pub start: ChirpedStart,
    /// The change of curvature to the next tile, in 1/mm.
    pub curvature_change: f64,
    /// Their directions beside the carrier along x and y.
    pub modes: [Modes; 2],
    /// Their coefficients, [m_y, m_x].
    pub coefficients: Array2<Complex64>,
}

impl WindowWaves {
    /// The direction of a plane wave beside the carrier.
    fn direction(&self, (my, mx): (usize, usize)) -> [f64; 2] {
        [self.modes[0].at(mx), self.modes[1].at(my)]
    }
}

/// The plane waves of a window that reach the target: their indices, and their beamlets of coefficient one.
#[derive(Default)]
struct Kept {
    places: Vec<(usize, usize)>,
    beamlets: Vec<Arrival>,
    /// For each beamlet its tail at the edge of the target, and the energy that it brings to the target.
    tails: Vec<(Tail, f64)>,
}

impl Kept {
    /// The number of the strongest of some beamlets.
    fn strongest(&self, numbers: impl Iterator<Item = usize>) -> Option<usize> {
        numbers.max_by(|a, b| self.tails[*a].1.total_cmp(&self.tails[*b].1))
    }
}

impl Emission<'_> {
    /// The same for plane waves of an edge alone.
    pub(crate) fn of_edge(&self) -> Self {
        Self {
            weakest: WEAKER_OF_EDGE * self.weakest,
            ..*self
        }
    }

    /// Traces the plane waves of a window to the target, as beamlets, and adds those that arrive to `out`.
    pub(crate) fn send(&self, waves: &WindowWaves, out: &mut Emitted) {
        let kept = self.kept(waves, &mut out.statistics);
        out.statistics.modes += waves.coefficients.len() as u64;
        self.sample_weak(waves, out);
        for (place, mut beamlet) in kept.places.into_iter().zip(kept.beamlets) {
            beamlet.amplitude *= waves.coefficients[place];
            out.arrivals.push(beamlet);
        }
    }

    /// Traces some of the plane waves that are left out, evenly over their energy, to see how much of it falls on the target.
    fn sample_weak(&self, waves: &WindowWaves, out: &mut Emitted) {
        let weakest = self.weakest * self.weakest;
        let mut sampled = Vec::new();
        for (place, c) in waves.coefficients.indexed_iter() {
            let energy = c.norm_sqr();
            if energy > 0.0 && energy <= weakest {
                out.unsampled += energy / (WEAK_SAMPLE * weakest);
            }
            if out.unsampled >= 1.0 {
                out.unsampled -= 1.0;
                sampled.push(waves.direction(place));
            }
        }
        let k = self.hop.wavenumber();
        let landed = waves.start.launch_all(self.hop, &sampled);
        let falls = |beamlet: &Arrival| Tail::of(beamlet, self.target.bounds, k).share;
        let shares: f64 = landed.iter().flatten().map(falls).sum();
        for (sum, part) in
            (out.statistics.tally.weak_sample.iter_mut()).zip([sampled.len() as f64, shares])
        {
            *sum += part;
        }
    }

    /// The conjugate transpose, for the plane waves that are kept: from the moments that the cotangent has under what a
    /// window sends, which `bars` gives for these beamlets, to the cotangents of its coefficients; adds to the
    /// derivatives with respect to the parameters with which the hop changes.
    pub(crate) fn send_adjoint(
        &self,
        waves: &WindowWaves,
        changes: &HopChanges,
        bars: impl FnOnce(&[Arrival]) -> Vec<Moments>,
        parameters: &mut [f64],
    ) -> Array2<Complex64> {
        let kept = self.kept(waves, &mut HopStatistics::default());
        let mut coefficients_bar = Array2::zeros(waves.coefficients.dim());
        let bars = bars(&kept.beamlets);
        for ((place, beamlet), moments) in kept.places.iter().zip(&kept.beamlets).zip(&bars) {
            coefficients_bar[*place] = beamlet.amplitude.conj() * moments[0];
            let sent = SentBeamlet {
                start: &waves.start,
                dp: waves.direction(*place),
                amplitude: beamlet.amplitude * waves.coefficients[*place],
                moments,
            };
            changes.pull_beamlet(&sent, parameters);
        }
        coefficients_bar
    }

    /// Finds the plane waves that are strong enough and reach the target.
    fn kept(&self, waves: &WindowWaves, statistics: &mut HopStatistics) -> Kept {
        let k = self.hop.wavenumber();
        let mut kept = Kept::default();
        let mut strong = Vec::new();
        for (place, c) in waves.coefficients.indexed_iter() {
            let share = c.norm_sqr() / self.unit;
            match c.norm_sqr() <= self.weakest * self.weakest {
                true => statistics.tally.add_energy(Fate::Weak, share),
                false => strong.push((place, share)),
            }
        }

        // All of them go together.
        let directions = strong.iter().map(|(place, _)| waves.direction(*place));
        let landed = waves
            .start
            .launch_all(self.hop, &directions.collect::<Vec<_>>());
        for ((place, share), beamlet) in strong.into_iter().zip(landed) {
            let beamlet = match beamlet {
                Ok(beamlet) => beamlet,
                Err(loss) => {
                    statistics.tally.count(Fate::Lost(loss), share);
                    continue;
                }
            };
            let tail = Tail::of(&beamlet, self.target.bounds, k);
            statistics.tally.beyond_footprints += share * self.target.cut(&beamlet, &tail, k);
            if !self.target.meets(&beamlet, k) {
                statistics.tally.count(Fate::Outside, share);
                continue;
            }
            statistics.tally.count(Fate::Arrived, share);
            kept.tails.push((tail, share * tail.share));
            kept.places.push(place);
            kept.beamlets.push(beamlet);
        }
        for alike in groups_alike(waves, &kept) {
            self.correct(waves, &mut kept, &alike, statistics);
        }
        kept
    }

    /// The start of beamlets where the light of a window is: beside an edge not at its centre, but at the mean place of
    /// its energy, as if the edge were straight and the light even.
    fn amid_light(&self, start: &ChirpedStart) -> ChirpedStart {
        let [x, y] = start.carrier.at;
        let depth = (self.aperture).map_or(f64::INFINITY, |a| a.depth(x, y));
        let part = depth / start.sigma;
        if part > BESIDE_EDGE {
            return *start;
        }

        // The mean of u over the energy exp(−u²/σ²) that is inside; far outside it tends to the edge itself.
        let inside = PI.sqrt() * erfc(-part);
        let aside = match inside > f64::MIN_POSITIVE {
            true => (-part * part).exp() / inside,
            false => -part,
        };

        // Inwards, along the slope of the depth.
        let inwards = (self.aperture).map_or([0.0; 2], |a| a.depth_slope([x, y], start.sigma));
        let moved = inwards.map(|slope| aside * start.sigma * slope);
        ChirpedStart {
            carrier: start.carrier.about([x + moved[0], y + moved[1]]),
            ..*start
        }
    }

    /// Whether a window's centre is outside the aperture.
    fn is_outside(&self, start: &ChirpedStart) -> bool {
        let [x, y] = start.carrier.at;
        self.aperture.is_some_and(|a| a.depth(x, y) < 0.0)
    }

    /// Corrects the aberration inside some beamlets of a window by that of their strongest one, and counts that which
    /// their light has.
    fn correct(
        &self,
        waves: &WindowWaves,
        kept: &mut Kept,
        alike: &[usize],
        statistics: &mut HopStatistics,
    ) {
        let Some(strongest) = kept.strongest(alike.iter().copied()) else {
            return;
        };
        let (start, dp) = (&waves.start, waves.direction(kept.places[strongest]));
        let found = start.aberration(self.hop, dp);
        let lit = self.amid_light(start);
        let counted = match lit.carrier == start.carrier {
            true => found,
            false => lit.aberration(self.hop, dp),
        };
        let own = kept.tails[strongest].0.share;
        let orders = self.beside.map_or(1.0, |beside| {
            self.target.orders(self.hop, start, dp, beside, own)
        });
        let outside = self.is_outside(start);
        let part = start.left_between_tiles(self.hop.wavenumber(), waves.curvature_change);
        for (tail, energy) in alike.iter().map(|number| &kept.tails[*number]) {
            let error = |counted: Aberration| counted.at_distance(tail.distance).error();
            let there = counted.map(|counted| {
                let there = error(counted).with_part_of_cubic(part);
                there.with_orders(orders)
            });
            statistics.tally.add_aberration(there, *energy);
            if outside {
                (statistics.tally).add_aberration_outside(found, counted, *energy);
            }
        }
        if let Some(found) = found.filter(|_| self.corrected) {
            let factor = found.correction_up_to(CORRECTABLE);
            for number in alike {
                kept.beamlets[*number].amplitude *= factor;
            }
        }
    }
}

/// The numbers of beamlets whose directions are alike: those in one square of directions, one square about the strongest.
fn groups_alike(waves: &WindowWaves, kept: &Kept) -> Vec<Vec<usize>> {
    let direction = |number: usize| waves.direction(kept.places[number]);
    let Some(middle) = kept.strongest(0..kept.places.len()).map(direction) else {
        return Vec::new();
    };
    let mut groups: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
    for number in 0..kept.places.len() {
        let p = direction(number);
        let square = [0, 1].map(|a| ((p[a] - middle[a]) / ALIKE).round() as i32);
        groups.entry(square).or_default().push(number);
    }
    groups.into_values().collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
    use crate::engine::local_bands::emission::{Emission, Emitted, WindowWaves};
    use crate::engine::local_bands::hop_changes::HopChanges;
    use crate::engine::local_bands::target::TargetRegion;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{on_axis, open_screen, screen, sensor};
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::frame::Frame;
    use crate::optics::screen::Screen;
    use crate::optics::system::Hop;
    use crate::wave::beamlet::wavelet::{Arrival, Tail};
    use crate::wave::local_bands::carrier::Carrier;
    use crate::wave::local_bands::fourier_axis::Modes;

    /// Free space of 20 mm between a plane and a small sensor.
    struct Space {
        from: Screen,
        to: Screen,
        target: TargetRegion,
    }

    impl Space {
        fn new() -> Self {
            let to = screen(on_axis(20.0), sensor(10, 0.02));
            Self {
                from: open_screen(Frame::GLOBAL),
                target: TargetRegion::of(&to, 0.0, 1e-3).unwrap(),
                to,
            }
        }

        fn hop(&self) -> Hop<'_> {
            Hop {
                wavelength: 0.5e-3,
                from: &self.from,
                train: &[],
                to: &self.to,
            }
        }

        /// What all windows of this hop share, on a plane with this aperture.
        fn emission<'a>(
            &'a self,
            hop: &'a Hop<'a>,
            aperture: Option<&'a Aperture>,
        ) -> Emission<'a> {
            Emission {
                hop,
                target: &self.target,
                weakest: 0.2,
                unit: 1.0,
                corrected: true,
                aperture,
                beside: None,
            }
        }
    }

    /// The start of a window at a place, in a curved wave that is a little inclined.
    fn start(at: [f64; 2], sigma: f64) -> ChirpedStart {
        ChirpedStart {
            carrier: Carrier {
                at,
                p: [0.01, 0.0],
                q: [-0.03, 0.001, -0.02],
            },
            sigma,
        }
    }

    /// Beside the edge of a half plane, beamlets are looked at in the mean place of the window's energy that is inside
    /// it.
    #[test]
    fn the_light_of_a_window_beside_an_edge_is_inside() {
        let space = Space::new();
        let hop = space.hop();
        let (edge, sigma) = (1.5, 0.05);
        let aperture = Aperture {
            outline: Outline::Rectangle {
                half_x: edge,
                half_y: 40.0,
            },
            centre: [0.0; 2],
        };
        let emission = space.emission(&hop, Some(&aperture));
        for part in [-30.0, -4.0, -1.2, 0.0, 0.7, 3.5] {
            let start = start([edge - part * sigma, 2.0], sigma);
            // Midpoints of the window inside the edge, energies relative to the largest.
            let [mut energy, mut moment] = [0.0; 2];
            for n in 0..8000 {
                let u = -part + (f64::from(n) + 0.5) * 1e-3;
                let weight = (part.min(0.0).powi(2) - u * u).exp();
                energy += weight;
                moment += weight * u;
            }
            let [x, y] = emission.amid_light(&start).carrier.at;
            let exact = start.carrier.at[0] - sigma * moment / energy;
            assert!((x - exact).abs() < 0.05 * sigma, "{part}: {x} {exact}");
            assert!((y - 2.0).abs() < 1e-9, "{y}");
        }
    }

    /// The sample of the plane waves that are left out has the share of their energy on the target that all of them have,
    /// though they come in many small windows.
    #[test]
    fn a_sample_tells_how_much_weak_light_meets_the_target() {
        let space = Space::new();
        let hop = space.hop();
        let emission = space.emission(&hop, None);
        let modes = Modes::between(-0.012, 0.012, 2.4e-3, 0.0);
        let (mut out, mut all, mut landing) = (Emitted::default(), 0.0, 0.0);
        for number in 0..400 {
            let waves = WindowWaves {
                start: start([1e-4 * f64::from(number), 0.0], 0.2),
                curvature_change: 0.0,
                modes: [modes, modes],
                coefficients: noise((11, 11), number) * Complex64::from(0.3),
            };
            emission.send(&waves, &mut out);
            for (place, c) in waves.coefficients.indexed_iter() {
                if c.norm() <= emission.weakest {
                    let sent = waves.start.launch(&hop, waves.direction(place)).unwrap();
                    let falls = Tail::of(&sent, space.target.bounds, hop.wavenumber()).share;
                    all += c.norm_sqr();
                    landing += falls * c.norm_sqr();
                }
            }
        }
        let [sampled, falling] = out.statistics.tally.weak_sample;
        assert!((sampled - all / (4.0 * 0.04)).abs() < 1.0, "{sampled}");
        let ratio = falling / sampled / (landing / all);
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
        let share = landing / all;
        assert!((0.05..0.6).contains(&share), "{share}");
    }

    #[test]
    fn send_dot_product() {
        let space = Space::new();
        let hop = space.hop();
        let emission = space.emission(&hop, None);
        let modes = Modes::between(-0.02, 0.02, 2e-3, 0.0);
        let waves = WindowWaves {
            start: start([0.1, -0.05], 0.05),
            curvature_change: 0.0,
            modes: [modes, modes],
            coefficients: noise((21, 21), 0),
        };
        let mut out = Emitted::default();
        emission.send(&waves, &mut out);
        let there = &out.arrivals;
        assert!((20..400).contains(&there.len()), "{}", there.len());
        let bar = noise((1, there.len()), 1);
        let zero = Complex64::ZERO;
        let moments = |_: &[Arrival]| bar.iter().map(|bar| [*bar, zero, zero, zero, zero, zero]);
        let back = emission.send_adjoint(
            &waves,
            &HopChanges::new(&[], 0, hop).unwrap(),
            |there| moments(there).collect(),
            &mut [],
        );
        let pairs = there.iter().zip(&bar);
        let forward: Complex64 = pairs.map(|(a, b)| b.conj() * a.amplitude).sum();
        let pairs = waves.coefficients.iter().zip(&back);
        let reverse: Complex64 = pairs.map(|(a, b)| b.conj() * a).sum();
        assert!((forward - reverse).norm() < 1e-12, "{forward} {reverse}");
    }
}
