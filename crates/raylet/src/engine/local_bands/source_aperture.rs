//! Whether the aperture of the first screen cuts light that matters, or only says where windows stand.
//!
//! An edge matters where the next screen sees it, and where it sends light to a sensor by diffraction: beside little light,
//! or none, that is all there is.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::edge_band::edge_power;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::SourceAperture;
use crate::engine::local_bands::source_light::source_carrier;
use crate::engine::local_bands::target::TargetRegion;
use crate::engine::local_bands::window_directions::window_directions;
use crate::engine::local_bands::window_widths::{SIDE, source_carriers};
use crate::optics::aperture::Outline;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};

/// Light that lands this far outside the next screen's aperture matters still, as a share of the aperture's width.
const BESIDE: f64 = 0.1;

/// Share of the target error that the diffraction of an edge which is left out may cost.
const SHARE: f64 = 0.1;

/// Width of the windows at an edge from which directions to the target are sought, in wavelengths; only rays through their
/// middles count.
const WIDTH: f64 = 100.0;

/// What the aperture of the first screen does: it is soft where that is a stop with one edge, the amplitude of the light is even,
/// the light at its rim is lost or lands far outside the aperture of the next screen, and what the edge sends to a sensor by
/// diffraction is a small part of a target error of the field.
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
    // Of what arrives at an element far from the light's own way, little comes to the sensor.
    let alone = matches!(hop.to.kind, ScreenKind::Sensor(_));
    let seen = rim.iter().any(matters) || alone && diffracted(system, &hop, &rim)? > SHARE * error;
    Ok(match seen {
        true => SourceAperture::Hard,
        false => SourceAperture::Soft,
    })
}

/// The light that the edge of the first screen sends to the next one by diffraction, as an error of the field there if it is
/// left out: the root of its power over that of the rays which land there; infinite where none does.
fn diffracted(system: &System, hop: &Hop, rim: &[[f64; 2]]) -> Result<f64, LocalBandError> {
    let boundless = || LocalBandError::Boundless(hop.to.name.clone());
    let target = TargetRegion::of(hop.to, 0.0, 1.0).ok_or_else(boundless)?;
    let open = source_carriers(system)?;
    let lands = |at: [f64; 2], p: [f64; 2]| {
        let landing = hop.trace_along(at, p, &mut ());
        landing.is_ok_and(|landing| target.holds(landing.at))
    };
    let landing = open.iter().filter(|ray| lands(ray.at, ray.p)).count();
    let bounds = hop.from.bounds().unwrap_or_default();
    let cell = (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]) / (SIDE * SIDE) as f64;

    // Each side of the rim, from its first point to the next one.
    let next = rim.iter().cycle().skip(1);
    let side = |(from, to): (&[f64; 2], &[f64; 2])| {
        let along = [to[0] - from[0], to[1] - from[1]];
        let start = ChirpedStart {
            carrier: source_carrier(&system.source, hop.from, *from),
            sigma: WIDTH * hop.wavelength,
        };
        let found = window_directions(hop, &start, &target);
        found.map_or(0.0, |found| edge_power(&found, along, hop.wavenumber()))
    };
    let power: f64 = rim.iter().zip(next).map(side).sum();
    Ok((power / (landing as f64 * cell)).sqrt())
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
