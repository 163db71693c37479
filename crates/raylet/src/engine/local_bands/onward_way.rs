//! The way of light through the bare apertures that follow a screen, to the next element or the sensor.
//!
//! A bare aperture leaves directions as they are. So of the light that an element or an edge sends there aside, only that counts
//! which goes on to the next element or the sensor, and the light of the source itself, which the aperture may diffract. What an
//! edge diffracts of light that another edge has diffracted to pass it is left out: it is the product of two small shares.
//! Pixels send much of their light aside, and the edge of an aperture may turn it to the sensor: behind them all directions are
//! followed. With fewer, the field behind a small stop that follows random pixels was wrong by 1.6e-2 in place of 1e-3.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::target::{MARGIN, TargetRegion};
use crate::engine::local_bands::window_directions::{WindowDirections, window_directions};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::surface::{Surface, without_edges};
use crate::optics::system::{Hop, System};

/// How far beside the target light counts, in diffraction widths λ/D of each bare aperture before it.
const WIDTHS: f64 = 4.0;

/// What stands behind the bare apertures that follow a screen, and the surfaces on the way there.
pub(crate) struct OnwardWay<'a> {
    wavelength: f64,
    from: &'a Screen,
    train: Vec<Surface>,
    to: &'a Screen,
    target: TargetRegion,
}

impl<'a> OnwardWay<'a> {
    /// Of the hop with this number; nothing where it ends at an element or the sensor, begins at pixels, or where what follows has
    /// no edge.
    pub(crate) fn behind(
        system: &'a System,
        settings: &LocalBandSettings,
        number: usize,
        edge: f64,
    ) -> Option<Self> {
        let bare = |screen: &Screen| matches!(screen.kind, ScreenKind::Stop(_));
        let from = system.screens.get(number)?;
        if matches!(&from.kind, ScreenKind::Doe(doe) if doe.pixels().is_some()) {
            return None;
        }
        let last = (number + 1..system.screens.len()).find(|n| !bare(&system.screens[*n]))?;
        if last == number + 1 {
            return None;
        }
        let to = system.screens.get(last)?;
        let margin = settings
            .windows(last)
            .map_or(0.0, |next| MARGIN * next.sigma);
        let mut target = TargetRegion::of(to, margin, edge)?;
        for bare in number + 1..last {
            let beside = diffracted_aside(system, [bare, last])?;
            let sides = target.bounds.iter_mut().enumerate();
            sides.for_each(|(side, end)| *end += if side % 2 == 0 { -beside } else { beside });
        }
        Some(Self {
            wavelength: system.wavelength,
            from,
            train: open_train(system, [number, last])?,
            to,
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
        let hop = Hop {
            wavelength: self.wavelength,
            from: self.from,
            train: &self.train,
            to: self.to,
        };
        let Some(on) = window_directions(&hop, start, &self.target) else {
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

/// The surfaces between two screens, without edges.
fn open_train(system: &System, [from, to]: [usize; 2]) -> Option<Vec<Surface>> {
    let trains = system.trains.get(from..to)?.iter();
    Some(trains.flat_map(|train| without_edges(train)).collect())
}

/// How far aside a bare aperture spreads light on a later screen, in mm; nothing where no ray gets there.
fn diffracted_aside(system: &System, [bare, last]: [usize; 2]) -> Option<f64> {
    let hop = Hop {
        wavelength: system.wavelength,
        from: system.screens.get(bare)?,
        train: &open_train(system, [bare, last])?,
        to: system.screens.get(last)?,
    };
    let [x0, x1, y0, y1] = hop.from.bounds()?;
    let (_, j) = hop.jacobian([0.0; 2], [0.0; 2]).ok()?;
    let widest = [j[0][2], j[0][3], j[1][2], j[1][3]].map(f64::abs);
    let widest = widest.into_iter().fold(0.0, f64::max);
    Some(WIDTHS * hop.wavelength / (x1 - x0).min(y1 - y0) * widest)
}

/// The directions from a window that lead to the target of a hop; where that is a bare aperture, those that lead `onward`, or are
/// no farther than `own` from the window's carrier; nothing where none does.
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
    use crate::fixtures::parts::{lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
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
        let system = system();
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
        let onward = OnwardWay::behind(&system, &settings, 0, 1e-3);
        directions_onward(&hop, &start, &target, onward.as_ref(), [0.01; 2])
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

    /// A hop that ends at the sensor has no way on.
    #[test]
    fn a_sensor_ends_the_way() {
        let settings = LocalBandSettings::new(vec![0.1, 0.1]);
        assert!(OnwardWay::behind(&system(), &settings, 0, 1e-3).is_some());
        assert!(OnwardWay::behind(&system(), &settings, 1, 1e-3).is_none());
    }
}
