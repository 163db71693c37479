//! The aberration of windows whose centres lie outside an aperture.
//!
//! Their beamlets start where no light is, and go through the parts of a lens behind that place. The surfaces of lenses with
//! many aspheric terms bend steeply there. Of what that aberration has beyond
//! the one at the rim, the part [`OUTSIDE`] shows in the field.

use crate::engine::error::tally::OUTSIDE;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::math::erfc::erfc;
use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::Hop;
use crate::wave::local_bands::carrier::Carrier;

/// Places along the rim, about.
const ALONG: usize = 12;

/// Distances outside it, in σ, in steps of [`APART`].
const DISTANCES: [f64; 5] = [0.25, 0.75, 1.25, 1.75, 2.25];
const APART: f64 = 0.5;

/// The mean square error that the aberration of windows outside the aperture of a hop's first screen brings, over the light
/// of all windows; carriers are known at these places inside it.
///
/// A window whose centre is d σ outside a straight edge has the share erfc(d)/2 of the energy of one inside.
pub(crate) fn outside_aberration(hop: &Hop, carriers: &[Carrier], sigma: f64) -> f64 {
    let Some((aperture, [x0, x1, y0, y1])) = aperture(hop.from).zip(hop.from.bounds()) else {
        return 0.0;
    };
    let rim = aperture.rim();
    let places = rim.iter().step_by(rim.len().div_ceil(ALONG).max(1));
    let squares = places.filter_map(|place| {
        let near = nearest(carriers, *place)?;
        let outwards = outwards(aperture, *place, sigma)?;
        let left = |distance: f64| {
            let at = [0, 1].map(|a| place[a] + distance * sigma * outwards[a]);
            let carrier = near.about(at);
            let found = ChirpedStart { carrier, sigma }.aberration(hop, [0.0; 2]);
            found.map_or(1.0, |found| found.left())
        };
        let lit = left(0.0);
        let square = |distance: f64| {
            let beyond = (left(distance) - lit).max(0.0);
            0.5 * erfc(distance) * (OUTSIDE * beyond).powi(2)
        };
        Some(DISTANCES.map(square).iter().sum::<f64>() * APART * sigma)
    });
    let (count, sum) = squares.fold((0, 0.0), |(count, sum), square| (count + 1, sum + square));
    // The length of the rim over the area: of discs and rectangles.
    let rim_over_area = 2.0 / (x1 - x0) + 2.0 / (y1 - y0);
    sum / f64::from(count.max(1)) * rim_over_area
}

/// The aperture of a screen.
fn aperture(screen: &Screen) -> Option<&Aperture> {
    match &screen.kind {
        ScreenKind::Stop(aperture) => Some(aperture),
        ScreenKind::Doe(doe) => Some(&doe.aperture),
        ScreenKind::Sensor(_) => None,
    }
}

/// The carrier nearest a place.
fn nearest(carriers: &[Carrier], [x, y]: [f64; 2]) -> Option<&Carrier> {
    let distance = |carrier: &Carrier| (carrier.at[0] - x).hypot(carrier.at[1] - y);
    let nearer = |a: &&Carrier, b: &&Carrier| distance(a).total_cmp(&distance(b));
    carriers.iter().min_by(nearer)
}

/// The direction away from an aperture at its rim; nothing where it has none.
fn outwards(aperture: &Aperture, at: [f64; 2], sigma: f64) -> Option<[f64; 2]> {
    let inwards = aperture.depth_slope(at, sigma);
    let length = inwards[0].hypot(inwards[1]);
    (length > 0.0).then(|| inwards.map(|slope| -slope / length))
}
