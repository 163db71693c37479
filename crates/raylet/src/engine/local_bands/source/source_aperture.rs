//! Whether the aperture of the first screen cuts light that matters, or only says where windows stand.
//!
//! An edge matters where the next screen sees it, and where light that it diffracts gets to the sensor: beside little light,
//! or none, that is all there is, and a stop near by lets it pass.

use std::f64::consts::PI;

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::edge_band::{normals, span_across_edge};
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::SourceAperture;
use crate::engine::local_bands::source::source_light::source_carrier;
use crate::engine::local_bands::target::TargetRegion;
use crate::engine::local_bands::window_directions::window_directions;
use crate::engine::local_bands::window_widths::{SIDE, source_carriers};
use crate::engine::rims::onward::Onward;
use crate::engine::rims::source_ray::SourceRay;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Outline;
use crate::optics::doe::Doe;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::local_bands::carrier::Carrier;

/// Light that lands this far outside the next screen's aperture matters still, as a share of the aperture's width.
const BESIDE: f64 = 0.1;

/// Share of the target error that the diffraction of an edge which is left out may cost.
const SHARE: f64 = 0.1;

/// Light at an edge is dark where its amplitude is this part of a threshold of the largest one.
const DARK: f64 = 0.03;

/// Width of the windows at an edge from which directions to the target are sought, in wavelengths; only rays through their
/// middles count.
const WIDTH: f64 = 100.0;

/// Directions along a normal of the edge whose rays are followed to the sensor, and where the first of them stands, as a part
/// of the last one.
const DIRECTIONS: usize = 24;
const NEAREST: f64 = 1e-4;

/// What the aperture of the first screen does: it is soft where that is a stop with one edge, the amplitude of the light is even,
/// the light at its rim is lost or lands far outside the aperture of the next screen, and what the edge sends to the sensor by
/// diffraction is a small part of a target error of the field, or not known because pixels follow the next screen.
///
/// # Errors
/// When the system has no screen.
pub(crate) fn source_aperture(
    system: &System,
    error: f64,
) -> Result<SourceAperture, LocalBandError> {
    let first = system.screens.first().ok_or(LocalBandError::NoSensor)?;
    let (ScreenKind::Stop(aperture), Some(hop)) = (&first.kind, system.hops().next()) else {
        return Ok(SourceAperture::Hard);
    };
    let more_edges = matches!(
        aperture.outline,
        Outline::Annulus { .. } | Outline::Blocked { .. }
    );
    if more_edges || !system.source.is_even() {
        return Ok(SourceAperture::Hard);
    }
    let matters = |at: &[f64; 2]| {
        let carrier = source_carrier(&system.source, first, *at);
        let landing = hop.trace_along(*at, carrier.p, &mut ());
        landing.is_ok_and(|landing| meets(hop.to, landing.at))
    };
    let rim = aperture.rim();
    // Pixels behind the next screen turn light everywhere; what they do with this light is not known here.
    let onward = Onward::behind(system, 0);
    let known = onward.is_known() || matches!(hop.to.kind, ScreenKind::Sensor(_));
    let seen =
        rim.iter().any(matters) || known && diffracted(system, &hop, onward, &rim)? > SHARE * error;
    Ok(match seen {
        true => SourceAperture::Hard,
        false => SourceAperture::Soft,
    })
}

/// Whether light whose amplitude falls off, as of a laser, is too weak at the edge of the first screen for the edge to matter:
/// its amplitude there, over the largest one, is a small part of a threshold. The edge is a circle or rectangle, and the light
/// does not fall off between two places of it that are looked at.
pub(crate) fn has_dark_rim(system: &System, threshold: f64) -> bool {
    let (Some(screen), Some(hop)) = (system.screens.first(), system.hops().next()) else {
        return false;
    };
    let (ScreenKind::Stop(aperture) | ScreenKind::Doe(Doe { aperture, .. })) = &screen.kind else {
        return false;
    };
    let simple = matches!(
        aperture.outline,
        Outline::Disc { .. } | Outline::Rectangle { .. }
    );
    if !simple || system.source.is_even() || !screen.is_plane() {
        return false;
    }
    let k = hop.wavenumber() * screen.index;
    let place = |[x, y]: [f64; 2]| screen.frame.to_global(Vec3::new(x, y, 0.0));
    let amplitude = |at: [f64; 2]| system.source.field(place(at), k).norm();
    let rim = aperture.rim();
    let largest = |all: &mut dyn Iterator<Item = [f64; 2]>| all.map(amplitude).fold(0.0, f64::max);
    let Ok(open) = source_carriers(system) else {
        return false;
    };
    let brightest = largest(&mut open.iter().map(|carrier| carrier.at));
    let apart = rim.iter().zip(rim.iter().skip(1));
    let apart = apart
        .map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]))
        .fold(0.0, f64::max);
    let falls = rim.iter().map(|at| system.source.radius_at(place(*at), k));
    let seen = falls.fold(f64::INFINITY, f64::min) > apart;
    seen && largest(&mut rim.iter().copied()) < DARK * threshold * brightest
}

/// The light that the edge of the first screen sends to the sensor by diffraction, as an error of the field there if it is left
/// out: the root of its power over that of the rays which get there; infinite where none does.
fn diffracted(
    system: &System,
    hop: &Hop,
    onward: Onward,
    rim: &[[f64; 2]],
) -> Result<f64, LocalBandError> {
    let boundless = || LocalBandError::Boundless(hop.to.name.clone());
    let way = WayToSensor {
        hop,
        target: TargetRegion::of(hop.to, 0.0, 1.0).ok_or_else(boundless)?,
        onward,
    };
    let open = source_carriers(system)?;
    let arriving: f64 = open.iter().map(|ray| way.arrives(ray.at, ray.p)).sum();
    let bounds = hop.from.bounds().unwrap_or_default();
    let area = (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]);

    // Each side of the rim, from its first point to the next one.
    let next = rim.iter().cycle().skip(1);
    let side = |(from, to): (&[f64; 2], &[f64; 2])| {
        let along = [to[0] - from[0], to[1] - from[1]];
        way.edge_power(source_carrier(&system.source, hop.from, *from), along)
    };
    let power: f64 = rim.iter().zip(next).map(side).sum();
    Ok((power * (SIDE * SIDE) as f64 / (arriving * area)).sqrt())
}

/// The way of light from the first screen to the sensor.
struct WayToSensor<'a> {
    hop: &'a Hop<'a>,
    target: TargetRegion,
    onward: Onward<'a>,
}

impl WayToSensor<'_> {
    /// One for a ray which passes the next screen and then lands on the sensor or close to it, else zero.
    fn arrives(&self, at: [f64; 2], p: [f64; 2]) -> f64 {
        let Ok(landing) = self.hop.trace_along(at, p, &mut ()) else {
            return 0.0;
        };
        let ray = SourceRay {
            at: landing.at,
            p: landing.cosines,
            energy: 1.0,
            spread: [0.0; 2],
        };
        match self.target.holds(landing.at) {
            true => self.onward.reach(ray).near,
            false => 0.0,
        }
    }

    /// The power that a side of an edge, `along` in mm, sends there by diffraction, for light of |U|² = 1, in mm²: as in
    /// `edge_band`, of directions whose rays arrive.
    fn edge_power(&self, carrier: Carrier, along: [f64; 2]) -> f64 {
        let sigma = WIDTH * self.hop.wavelength;
        let start = ChirpedStart { carrier, sigma };
        let Some(found) = window_directions(self.hop, &start, &self.target) else {
            return 0.0;
        };
        let side = |normal: [f64; 2]| match span_across_edge(&found, normal, 0.0) {
            Some(span) => self.across_edge(&carrier, normal, span),
            None => 0.0,
        };
        let sum: f64 = normals(along).map(side).iter().sum();
        along[0].hypot(along[1]) * sum / (2.0 * PI * self.hop.wavenumber())
    }

    /// ∫ds/s² along the normal of an edge, over the directions of a span whose rays arrive.
    fn across_edge(&self, carrier: &Carrier, normal: [f64; 2], [near, far]: [f64; 2]) -> f64 {
        let near = near.max(NEAREST * far);
        // Equal steps of the logarithm, each with the direction in its middle.
        let step = (far / near).ln() / DIRECTIONS as f64;
        let part = |n: usize| {
            let s = near * (step * (n as f64 + 0.5)).exp();
            let p = [0, 1].map(|a| carrier.p[a] + s * normal[a]);
            self.arrives(carrier.at, p) * 2.0 * (0.5 * step).sinh() / s
        };
        (0..DIRECTIONS).map(part).sum()
    }
}

/// Whether a point lies in a screen's aperture, or not far outside.
fn meets(screen: &Screen, [x, y]: [f64; 2]) -> bool {
    let Some([x0, x1, y0, y1]) = screen.bounds() else {
        return true;
    };
    let margin = BESIDE * (x1 - x0).max(y1 - y0);
    let depth = match &screen.kind {
        ScreenKind::Stop(aperture) => aperture.depth(x, y),
        ScreenKind::Doe(doe) => doe.aperture.depth(x, y),
        ScreenKind::Sensor(_) => 0.0,
    };
    let inside = |at: f64, low: f64, high: f64| (low - margin..=high + margin).contains(&at);
    inside(x, x0, x1) && inside(y, y0, y1) && depth > -margin
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use crate::engine::local_bands::settings::SourceAperture;
    use crate::engine::local_bands::source::source_aperture::{has_dark_rim, source_aperture};
    use crate::fixtures::parts::{element, lit, on_axis, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::beams::taper::Taper;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::optics::source::Source;

    /// A beam of radius 1 with its middle at x, in this aperture: at the distance d of the edge its amplitude is exp(−d²).
    fn dark(aperture: Aperture, x: f64) -> bool {
        let first = screen(Frame::GLOBAL, ScreenKind::Stop(aperture));
        let last = screen(on_axis(50.0), sensor(10, 0.1));
        let mut system = lit(vec![first, last], vec![vec![]]);
        let direction = Vec3::new(0.0, 0.0, 1.0);
        system.wavelength = 0.5e-3;
        system.source = Source::TaperedPlane {
            direction,
            origin: Vec3::new(0.0, 0.0, 0.0),
            centre: Vec3::new(x, 0.0, 0.0),
            taper: Taper::about(direction, [1.0; 2], 1, 0.0),
        };
        has_dark_rim(&system, 1e-3)
    }

    #[test]
    fn a_rim_is_dark_where_a_beam_has_fallen_off() {
        assert!(dark(Aperture::disc(4.0), 0.0));
        assert!(dark(
            Aperture::turned_rectangle(4.0, 5.0, 0.0, [0.0; 2]),
            0.5
        ));
        assert!(!dark(Aperture::disc(2.5), 0.0));
        assert!(!dark(Aperture::disc(4.0), 2.0));

        // Beams narrower than the distance of two places of the edge, and edges inside the beam.
        assert!(!dark(Aperture::disc(400.0), 0.0));
        let annulus = Outline::Annulus {
            inner: 0.5,
            outer: 4.0,
        };
        let centre = [0.0; 2];
        assert!(!dark(
            Aperture {
                outline: annulus,
                centre
            },
            0.0
        ));
    }

    #[test]
    fn even_light_has_no_dark_rim() {
        let first = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(4.0)));
        let last = screen(on_axis(50.0), sensor(10, 0.1));
        assert!(!has_dark_rim(&lit(vec![first, last], vec![vec![]]), 1e-3));
    }

    /// What the aperture of a first stop does for light of a point 10.8 mm before it, with this screen 12.4 mm behind it and a
    /// sensor of 32 pixels of a pitch a distance farther on.
    fn seen_from(next: ScreenKind, distance: f64, pitch: f64) -> SourceAperture {
        let stop = Aperture::turned_rectangle(0.216, 0.184, 0.0, [0.0; 2]);
        let screens = vec![
            screen(Frame::GLOBAL, ScreenKind::Stop(stop)),
            screen(on_axis(12.4), next),
            screen(on_axis(12.4 + distance), sensor(32, pitch)),
        ];
        let mut system = lit(screens, vec![vec![], vec![]]);
        system.wavelength = 0.5e-3;
        system.source = Source::Point {
            position: Vec3::new(-0.1, 0.0, -10.8),
            reference: Vec3::new(0.0, 0.0, 0.0),
        };
        source_aperture(&system, 1e-3).unwrap()
    }

    /// The shadow of the rim lies 0.2 mm beside a stop of 0.24 mm, whose light the fringes of the rim change by a tenth: taken for
    /// soft, the field on the sensor was wrong by 0.1. Behind a lens of the same aperture that light lands 0.1 mm beside the image
    /// of the source: a sensor there does not see it, a larger one does.
    #[test]
    fn fringes_that_get_to_the_sensor_count() {
        let aperture = Aperture::disc(0.236);
        let stop = ScreenKind::Stop(aperture.clone());
        assert_eq!(seen_from(stop, 10.5, 0.02), SourceAperture::Hard);
        let lens = Profile::Lens {
            focal_length: 8.0,
            wavenumber: TAU / 0.5e-3,
        };
        let lens = ScreenKind::Doe(element(Layer::Phase(lens), aperture));
        assert_eq!(seen_from(lens.clone(), 12.2, 1e-3), SourceAperture::Soft);
        assert_eq!(seen_from(lens, 12.2, 10e-3), SourceAperture::Hard);
    }
}
