//! The way of light through the bare apertures and smooth elements that follow a screen, to the next other element or the sensor.
//!
//! A bare aperture leaves directions as they are, and a smooth phase changes each by the slope that it has there. So of the
//! light that an element or an edge sends there aside, only that counts which goes on to the next other element or the sensor,
//! and the light of the source itself, which the edges on the way may diffract. What an edge diffracts of light that another
//! edge has sent more than some diffraction widths aside is left out: it is the product of two small shares. Pixels send much
//! of their light aside, and the edge of an aperture may turn it to the sensor: behind them all directions are followed. With
//! fewer, the field behind a small stop that follows random pixels was wrong by 1.6e-2 in place of 1e-3.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::target::{MARGIN, TargetRegion};
use crate::engine::local_bands::window_directions::{RayWay, WindowDirections, window_directions};
use crate::math::complex::{Complex, Symmetric};
use crate::optics::doe::Doe;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::surface::{Surface, without_edges};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::element_phase::ElementPhase;

/// How far beside the target light counts, in diffraction widths λ/D of each screen before it: this over the threshold of the run.
/// An edge there may turn light of another edge to the target. Behind an annulus and a lens of half a millimetre, and behind a
/// singlet and an annular stop, the error is 6.5e-3 and 1.1e-2 with 4 widths, 9.0e-4 and 2.3e-3 with 40; 7.6e-4 and 1.8e-3 are expected.
const WIDTHS_BY_THRESHOLD: f64 = 0.04;

/// Points along each axis at which the bend of a smooth element is sampled.
const BEND_SAMPLES: usize = 9;

/// Smooth elements are passed whose bend makes the map of directions before to directions behind them differ by at most this from
/// its mean: only one direction of a window leads to each place then.
const UNEVEN: f64 = 0.5;

/// What stands behind the screens that follow a screen, and the way there.
pub(crate) struct OnwardWay<'a> {
    way: SmoothWay<'a>,
    target: TargetRegion,
}

impl<'a> OnwardWay<'a> {
    /// Of the hop with this number; nothing where it ends at the sensor or at an element that does not bend light smoothly, begins
    /// at pixels, or where what follows has no edge.
    pub(crate) fn behind(
        system: &'a System,
        settings: &LocalBandSettings,
        number: usize,
        edge: f64,
    ) -> Option<Self> {
        let from = system.screens.get(number)?;
        if matches!(&from.kind, ScreenKind::Doe(doe) if doe.pixels().is_some()) {
            return None;
        }
        let passes = |n: &usize| passes(system, [number, *n]);
        let last = (number + 1..system.screens.len()).find(|n| !passes(n))?;
        if last == number + 1 {
            return None;
        }
        let to = system.screens.get(last)?;
        let margin = settings
            .windows(last)
            .map_or(0.0, |next| MARGIN * next.sigma);
        let mut target = TargetRegion::of(to, margin, edge)?;
        for passed in number + 1..last {
            let widths = WIDTHS_BY_THRESHOLD / settings.threshold;
            let beside = widths * diffraction_width(system, [passed, last])?;
            let sides = target.bounds.iter_mut().enumerate();
            sides.for_each(|(side, end)| *end += if side % 2 == 0 { -beside } else { beside });
        }
        Some(Self {
            way: SmoothWay::between(system, [number, last])?,
            target,
        })
    }

    /// Of the directions that lead from a window to the next screen, those that lead on, or are no farther than `own` from
    /// the window's carrier; nothing where none does.
    fn among(
        &self,
        found: WindowDirections,
        start: &ChirpedStart,
        own: [f64; 2],
    ) -> Option<WindowDirections> {
        let Some(on) = window_directions(&self.way, start, &self.target) else {
            return Some(found);
        };
        let mut both = found;
        for (a, own) in own.into_iter().enumerate() {
            let [low, high] = [2 * a, 2 * a + 1];
            both.bounds[low] = found.bounds[low].max(on.bounds[low].min(-own));
            both.bounds[high] = found.bounds[high].min(on.bounds[high].max(own));
        }
        let some = (0..2).all(|a| both.bounds[2 * a] < both.bounds[2 * a + 1]);
        some.then_some(both)
    }
}

/// Whether light from one screen passes another as rays do: it is a bare aperture, or a plane element of smooth phases that bends
/// light nearly evenly.
fn passes(system: &System, [from, to]: [usize; 2]) -> bool {
    let Some(screen) = system.screens.get(to) else {
        return false;
    };
    match &screen.kind {
        ScreenKind::Stop(_) => true,
        ScreenKind::Sensor(_) => false,
        ScreenKind::Doe(doe) => {
            let smooth = doe.profiles().is_some();
            let flat = screen.is_plane() && screen.behind.is_none();
            smooth && flat && bends_evenly(system, [from, to], doe).unwrap_or(false)
        }
    }
}

/// Whether the directions behind an element are nearly a linear map of those at an earlier screen: p′ = p + ∇φ(s)/k at s = Lp, so
/// that ∂p′/∂p = 1 + HL/k with the second derivatives H of the phase. Nothing where no ray gets there.
fn bends_evenly(system: &System, [from, to]: [usize; 2], doe: &Doe) -> Option<bool> {
    let (_, lever) = SmoothWay::between(system, [from, to])?.land([0.0; 2], [0.0; 2])?;
    let [x0, x1, y0, y1] = doe.aperture.bounds()?;
    let (phase, k) = (phase_of(doe), system.wavenumber());
    let place =
        |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / BEND_SAMPLES as f64;
    let samples = BEND_SAMPLES * BEND_SAMPLES;
    let places = (0..samples).map(|n| {
        [
            place(x0, x1, n % BEND_SAMPLES),
            place(y0, y1, n / BEND_SAMPLES),
        ]
    });
    let inside = places.filter(|[x, y]| doe.aperture.contains(*x, *y));
    let map = |at: [f64; 2]| {
        let [xx, xy, yy] = phase.carrier(at, 0.0, k).q;
        let row = |a: f64, b: f64| [0, 1].map(|c| a * lever[0][c] + b * lever[1][c]);
        let ([a, b], [c, d]) = (row(xx, xy), row(xy, yy));
        [1.0 + a, b, c, 1.0 + d]
    };
    let maps: Vec<[f64; 4]> = inside.map(map).collect();
    let mean = [0, 1, 2, 3].map(|i| maps.iter().map(|m| m[i]).sum::<f64>() / maps.len() as f64);
    let [a, b, c, d] = mean;
    let determinant = a * d - b * c;
    let uneven = |m: &[f64; 4]| {
        let [ma, mb, mc, md] = *m;
        let [e, f] = [d * ma - b * mc, d * mb - b * md].map(|x| x / determinant);
        let [g, h] = [a * mc - c * ma, a * md - c * mb].map(|x| x / determinant);
        ((e - 1.0).powi(2) + f * f + g * g + (h - 1.0).powi(2)).sqrt()
    };
    Some(maps.iter().all(|m| uneven(m) < UNEVEN))
}

/// The phase of an element.
fn phase_of(doe: &Doe) -> ElementPhase<'_> {
    ElementPhase {
        doe: Some(doe),
        aperture: doe.aperture.clone(),
    }
}

/// A way past bare apertures and through smooth elements: surfaces without edges, and the elements between them.
struct SmoothWay<'a> {
    wavelength: f64,
    legs: Vec<Leg<'a>>,
}

/// A part of a way, up to an element or its end.
struct Leg<'a> {
    from: &'a Screen,
    train: Vec<Surface>,
    to: &'a Screen,
}

impl<'a> SmoothWay<'a> {
    /// From one screen to another.
    fn between(system: &'a System, [from, last]: [usize; 2]) -> Option<Self> {
        let is_element = |n: &usize| matches!(system.screens[*n].kind, ScreenKind::Doe(_));
        let ends = (from + 1..last).filter(is_element).chain([last]);
        let mut legs = Vec::new();
        let mut begin = from;
        for end in ends {
            let trains = system.trains.get(begin..end)?.iter();
            legs.push(Leg {
                from: system.screens.get(begin)?,
                train: trains.flat_map(|train| without_edges(train)).collect(),
                to: system.screens.get(end)?,
            });
            begin = end;
        }
        Some(Self {
            wavelength: system.wavelength,
            legs,
        })
    }

    /// Its parts.
    fn hops(&self) -> impl Iterator<Item = Hop<'_>> {
        self.legs.iter().map(|leg| Hop {
            wavelength: self.wavelength,
            from: leg.from,
            train: &leg.train,
            to: leg.to,
        })
    }
}

/// The slope and the curvature that the element of a later part of a way gives light at a place.
fn bend(hop: &Hop, at: [f64; 2]) -> Carrier {
    match &hop.from.kind {
        ScreenKind::Doe(doe) => phase_of(doe).carrier(at, 0.0, hop.wavenumber()),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => Carrier {
            at,
            p: [0.0; 2],
            q: [0.0; 3],
        },
    }
}

impl RayWay for SmoothWay<'_> {
    fn land(&self, at: [f64; 2], p: [f64; 2]) -> Option<([f64; 2], [[f64; 2]; 2])> {
        let (mut at, mut p) = (at, p);
        // ∂(s, p)/∂p of the start, rows by s and p.
        let mut slope = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        for (number, hop) in self.hops().enumerate() {
            if number > 0 {
                let Carrier {
                    p: turn,
                    q: [xx, xy, yy],
                    ..
                } = bend(&hop, at);
                let [x, y, px, py] = slope;
                let bent = |p: [f64; 2], a: f64, b: f64| [0, 1].map(|c| p[c] + a * x[c] + b * y[c]);
                slope = [x, y, bent(px, xx, xy), bent(py, xy, yy)];
                p = [p[0] + turn[0], p[1] + turn[1]];
            }
            let (landing, j) = hop.jacobian_along(at, p).ok()?;
            slope = j.map(|row| {
                [0, 1].map(|c| row.iter().zip(&slope).map(|(j, slope)| j * slope[c]).sum())
            });
            (at, p) = (landing.at, landing.cosines);
        }
        Some((at, [slope[0], slope[1]]))
    }

    fn carry(&self, start: &ChirpedStart, dp: [f64; 2]) -> Option<Arrival> {
        let mut hops = self.hops();
        let mut arrival = start.launch(&hops.next()?, dp).ok()?;
        for hop in hops {
            let turned = bend(&hop, arrival.at);
            let p = [0, 1].map(|a| arrival.cosines[a] + turned.p[a]);
            let [xx, xy, yy] = [0, 1, 2].map(|i| {
                let own = arrival.curvature[i];
                Complex::new(own.re + turned.q[i], own.im)
            });
            let carried = hop.carry_along(arrival.at, p, Symmetric { xx, xy, yy });
            arrival = carried.ok()?.arrival(hop.wavenumber());
        }
        Some(arrival)
    }

    fn medium(&self) -> (f64, f64) {
        let index = self.legs.first().map_or(1.0, |leg| leg.from.index_behind());
        (std::f64::consts::TAU / self.wavelength, index)
    }
}

/// The diffraction width of a screen on a later one, in mm; nothing where no ray gets there.
fn diffraction_width(system: &System, [passed, last]: [usize; 2]) -> Option<f64> {
    let way = SmoothWay::between(system, [passed, last])?;
    let [x0, x1, y0, y1] = system.screens.get(passed)?.bounds()?;
    let (_, [a, b]) = way.land([0.0; 2], [0.0; 2])?;
    let widest = a.into_iter().chain(b).map(f64::abs).fold(0.0, f64::max);
    Some(system.wavelength / (x1 - x0).min(y1 - y0) * widest)
}

/// The directions from a window that lead to the target of a hop; where light passes that as rays do, those that lead `onward`, or
/// are no farther than `own` from the window's carrier; nothing where none does.
pub(crate) fn directions_onward(
    hop: &Hop,
    start: &ChirpedStart,
    target: &TargetRegion,
    onward: Option<&OnwardWay>,
    own: [f64; 2],
) -> Option<WindowDirections> {
    let found = window_directions(hop, start, target)?;
    match onward {
        None => Some(found),
        Some(onward) => onward.among(found, start, own),
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
    use crate::engine::local_bands::onward_way::{OnwardWay, directions_onward};
    use crate::engine::local_bands::settings::LocalBandSettings;
    use crate::engine::local_bands::target::TargetRegion;
    use crate::engine::local_bands::window_directions::WindowDirections;
    use crate::fixtures::parts::{element, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::optics::system::System;
    use crate::wave::local_bands::carrier::Carrier;

    /// A stop, a wide stop 10 mm behind it, and a sensor of 0.2 mm 100 mm behind the first.
    fn system() -> System {
        let stop =
            |z: f64, radius: f64| screen(on_axis(z), ScreenKind::Stop(Aperture::disc(radius)));
        let screens = vec![
            stop(0.0, 1.0),
            stop(10.0, 5.0),
            screen(on_axis(100.0), sensor(10, 0.02)),
        ];
        let mut system = lit(screens, vec![vec![], vec![]]);
        system.wavelength = 0.5e-3;
        system
    }

    /// The directions along x that are followed from a window of the first stop whose light has this one.
    fn followed(p: f64) -> Option<WindowDirections> {
        followed_in(&system(), p, 0.01)
    }

    /// The same in a system with this band of light under the window.
    fn followed_in(system: &System, p: f64, own: f64) -> Option<WindowDirections> {
        let settings = LocalBandSettings::new(vec![0.1, 0.1]);
        let hop = system.hops().next().unwrap();
        let start = ChirpedStart {
            carrier: Carrier {
                at: [0.0; 2],
                p: [p, 0.0],
                q: [0.0; 3],
            },
            sigma: 0.1,
        };
        let target = TargetRegion::of(hop.to, 0.25, 1e-3).unwrap();
        let onward = OnwardWay::behind(system, &settings, 0, 1e-3);
        directions_onward(&hop, &start, &target, onward.as_ref(), [own; 2])
    }

    /// Directions up to 26° lead to the second stop. Of these, those within some milliradians lead to the sensor; the window's own
    /// light is followed too, wherever it goes.
    #[test]
    fn directions_lead_on_or_are_those_of_the_light() {
        let found = followed(0.0).unwrap().bounds;
        assert!(
            found
                .iter()
                .all(|side| (0.009..0.012).contains(&side.abs())),
            "{found:?}"
        );
        let aside = followed(0.2).unwrap().bounds;
        assert!((-0.22..-0.19).contains(&aside[0]), "{aside:?}");
        assert!((aside[1] - 0.01).abs() < 1e-12, "{aside:?}");
    }

    /// A lens in place of the second stop, in whose focus the sensor stands: a ray of direction p lands 90 mm·p aside, wherever
    /// it meets the lens. A phase that bends light so unevenly that several directions may lead to one place is not passed.
    #[test]
    fn smooth_elements_bend_the_way() {
        let wavenumber = std::f64::consts::TAU / 0.5e-3;
        let with = |phase: Profile| {
            let mut system = system();
            let element = element(Layer::Phase(phase), Aperture::disc(5.0));
            system.screens[1].kind = ScreenKind::Doe(element);
            system
        };
        let lens = with(Profile::Lens {
            focal_length: 90.0,
            wavenumber,
        });
        let found = followed_in(&lens, 0.0, 0.0).unwrap().bounds;
        // The beamlet of a window of 0.1 mm reaches 0.27 mm there, and the lens spreads light by 40 λ/D · 90 mm = 0.18 mm: with the
        // sensor 0.55 mm, times 1.15.
        assert!(
            found
                .iter()
                .all(|side| (0.0068..0.0073).contains(&side.abs())),
            "{found:?}"
        );
        let settings = LocalBandSettings::new(vec![0.1, 0.1]);
        assert!(OnwardWay::behind(&lens, &settings, 0, 1e-3).is_some());
        let steep = with(Profile::Polynomial {
            radius: 5.0,
            terms: vec![([3, 0], 2e4)],
        });
        assert!(OnwardWay::behind(&steep, &settings, 0, 1e-3).is_none());
    }

    /// A hop that ends at the sensor has no way on.
    #[test]
    fn a_sensor_ends_the_way() {
        let settings = LocalBandSettings::new(vec![0.1, 0.1]);
        assert!(OnwardWay::behind(&system(), &settings, 0, 1e-3).is_some());
        assert!(OnwardWay::behind(&system(), &settings, 1, 1e-3).is_none());
    }
}
