//! Whether the aperture of the first screen cuts light that matters, or only says where windows stand.

use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::SourceAperture;
use crate::engine::local_bands::source_light::source_carrier;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;

/// Light that lands this far outside the next screen's aperture matters still, as a share of the aperture's width.
const BESIDE: f64 = 0.1;

/// What the aperture of the first screen does: it is soft where that is a stop, the amplitude of the light is even, and the light
/// at its rim is lost or lands far outside the aperture of the next screen.
///
/// # Errors
/// When the system has no screen.
pub(crate) fn source_aperture(system: &System) -> Result<SourceAperture, LocalBandError> {
    let first = system.screens.first().ok_or(LocalBandError::NoSensor)?;
    let (ScreenKind::Stop(aperture), Some(hop)) = (&first.kind, system.hops().next()) else {
        return Ok(SourceAperture::Hard);
    };
    if !system.source.is_even() {
        return Ok(SourceAperture::Hard);
    }
    let matters = |at: &[f64; 2]| {
        let carrier = source_carrier(&system.source, first, *at);
        let landing = hop.trace_along(*at, carrier.p, &mut ());
        landing.is_ok_and(|landing| meets(hop.to, landing.at))
    };
    Ok(match aperture.rim().iter().any(matters) {
        true => SourceAperture::Hard,
        false => SourceAperture::Soft,
    })
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
