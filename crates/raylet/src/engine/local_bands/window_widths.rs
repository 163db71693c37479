//! How wide the windows of each screen may be.
//!
//! Chirped beamlets are as many at any width, and windows fewer the wider they are, until the aberration inside a
//! beamlet stops it. It is sampled along rays of the source that meet each aperture, with the curvature that the wave
//! has there.

use crate::engine::error::window_error::left_by_lattice;
use crate::engine::local_bands::chirped_beamlet::{ChirpedStart, USUALLY_ON_LATTICE};
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::outside_aberration::outside_aberration;
use crate::engine::local_bands::settings::{LocalBandPlan, SourceAperture, TILE};
use crate::engine::local_bands::source::source_aberration::source_aberration;
use crate::engine::local_bands::source::source_light::source_carrier;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::optics::system::{Hop, System};
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::element_samples::Element;
use crate::wave::local_bands::folded_fourier::fast_length;
use crate::wave::local_bands::tiling::WindowShape;

/// Rays along each side of the first screen.
pub(crate) const SIDE: usize = 33;

/// Rays along which aberration is sampled on each screen, about.
const SAMPLED: usize = 40;

/// Widths to choose from: these powers of the root of the root of two, times the wavelength.
const WIDTHS: std::ops::Range<i32> = 8..64;

/// A window is at most this share of the size of its screen.
const LARGEST: f64 = 0.08;

/// A window is at most this share of the radius over which the light of the source falls.
const OF_RADIUS: f64 = 0.5;

/// Share of the target error that aberration may have in one hop.
const SHARE: f64 = 0.25;

/// The same of a smooth source, whose windows cost little: one beamlet each.
const SHARE_OF_SOURCE: f64 = 0.05;

/// Pixels in a period up to which fast transforms are considered.
const LONGEST_TRANSFORM: f64 = 1e5;

/// A period becomes longer by this factor at most, so that it is a whole number of pixels.
const LONGER: f64 = 1.05;

/// Whether a hop starts with a smooth source or with windows of all directions.
fn is_smooth(number: usize, aperture: SourceAperture) -> bool {
    number == 0 && aperture == SourceAperture::Soft
}

/// The widest windows of each screen but the last, in mm, with which the aberration inside beamlets, corrected as far
/// as it can be, stays below a target relative error of the field; windows stand a `step` of so many σ apart.
///
/// # Errors
/// When a screen has no edge or layers of another kind, or no ray of the source meets an aperture.
pub(crate) fn window_widths(
    system: &System,
    aperture: SourceAperture,
    step: f64,
    error: f64,
) -> Result<Vec<f64>, LocalBandError> {
    let leaving = leaving_carriers(system, aperture)?;
    let hops = system.hops().enumerate().zip(&leaving);
    let widths = hops.map(|((number, hop), sampled)| {
        let source = is_smooth(number, aperture).then_some(&system.source);
        let left = |sigma: f64| match source {
            Some(source) => source_aberration_left(&hop, sampled, sigma, source),
            None => aberration_left(&hop, sampled, sigma, step),
        };
        let share = source.map_or(SHARE, |_| SHARE_OF_SOURCE);
        let limit = match number {
            0 => OF_RADIUS * source_radius(system, &hop),
            _ => f64::INFINITY,
        };
        widest(&hop, limit, share * error, left)
    });
    Ok(widths.collect())
}

/// The error to expect from the aberration inside beamlets of a hop, along carriers that leave.
pub(crate) fn expected_aberration(
    hop: &Hop,
    source: &Source,
    sampled: &[Carrier],
    plan: &LocalBandPlan,
) -> f64 {
    match plan.smooth {
        true => source_aberration_left(hop, sampled, plan.sigma, source),
        false => aberration_left(hop, sampled, plan.sigma, plan.step),
    }
}

/// For each hop, carriers along rays of the source that leave its first screen and meet the aperture of its second.
///
/// # Errors
/// As [`window_widths`].
pub(crate) fn leaving_carriers(
    system: &System,
    aperture: SourceAperture,
) -> Result<Vec<Vec<Carrier>>, LocalBandError> {
    let mut carriers = source_carriers(system)?;
    let mut leaving = Vec::new();
    for (number, hop) in system.hops().enumerate() {
        if !is_smooth(number, aperture) {
            carriers = behind(&hop, &carriers)?;
        }
        let onwards: Vec<(Carrier, Carrier)> = carriers
            .iter()
            .filter_map(|carrier| Some((*carrier, carried(&hop, carrier)?)))
            .filter(|(_, landed)| opens(hop.to, landed.at))
            .collect();
        if onwards.is_empty() {
            return Err(LocalBandError::NoLight(hop.to.name.clone()));
        }
        let stride = onwards.len().div_ceil(SAMPLED);
        leaving.push(onwards.iter().step_by(stride).map(|pair| pair.0).collect());
        carriers = onwards.into_iter().map(|pair| pair.1).collect();
    }
    Ok(leaving)
}

/// Carriers of the source over the first screen.
///
/// # Errors
/// When the screen has no edge.
pub(crate) fn source_carriers(system: &System) -> Result<Vec<Carrier>, LocalBandError> {
    let screen = system.screens.first().ok_or(LocalBandError::NoSensor)?;
    let boundless = || LocalBandError::Boundless(screen.name.clone());
    let [x0, x1, y0, y1] = screen.bounds().ok_or_else(boundless)?;
    let place = |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / SIDE as f64;
    let all = (0..SIDE * SIDE).map(|n| [place(x0, x1, n % SIDE), place(y0, y1, n / SIDE)]);
    let open = all.filter(|at| opens(screen, *at));
    Ok(open
        .map(|at| source_carrier(&system.source, screen, at))
        .collect())
}

/// Whether light at a point of a screen goes on; on a sensor everywhere.
fn opens(screen: &Screen, [x, y]: [f64; 2]) -> bool {
    match &screen.kind {
        ScreenKind::Sensor(_) => true,
        ScreenKind::Stop(aperture) => aperture.contains(x, y),
        ScreenKind::Doe(doe) => doe.aperture.contains(x, y),
    }
}

/// Carriers behind the element of a hop's first screen.
pub(crate) fn behind(hop: &Hop, carriers: &[Carrier]) -> Result<Vec<Carrier>, LocalBandError> {
    let layers = || LocalBandError::Layers(hop.from.name.clone());
    let element = Element::of(hop.from).ok_or_else(layers)?;
    let bent = |carrier: &Carrier| {
        let own = element.phase().carrier(carrier.at, 0.0, hop.wavenumber());
        carrier.times(own.p, own.q)
    };
    Ok(carriers.iter().map(bent).collect())
}

/// A carrier at the end of a hop: its ray, and Q′ = (C + DQ)(A + BQ)⁻¹; nothing where the ray is lost or at a focus.
fn carried(hop: &Hop, carrier: &Carrier) -> Option<Carrier> {
    let (landing, j) = hop.jacobian_along(carrier.at, carrier.p).ok()?;
    let [xx, xy, yy] = carrier.q;
    let q = [[xx, xy], [xy, yy]];
    let block = |row: usize, a: usize, b: usize| {
        j[row + a][b] + j[row + a][2] * q[0][b] + j[row + a][3] * q[1][b]
    };
    let place = |a, b| block(0, a, b);
    let slope = |a, b| block(2, a, b);
    let determinant = place(0, 0) * place(1, 1) - place(0, 1) * place(1, 0);
    let product = |a: usize, b: usize| {
        let [first, second] = [slope(a, 0), slope(a, 1)];
        match b {
            0 => (first * place(1, 1) - second * place(1, 0)) / determinant,
            _ => (second * place(0, 0) - first * place(0, 1)) / determinant,
        }
    };
    let q = [
        product(0, 0),
        0.5 * (product(0, 1) + product(1, 0)),
        product(1, 1),
    ];
    q.iter().all(|q| q.is_finite()).then_some(Carrier {
        at: landing.at,
        p: landing.cosines,
        q,
    })
}

/// Root mean square, over carriers, of the error that aberration inside beamlets of width σ leaves when it is corrected,
/// with what windows a `step` of so many σ apart leave of it, and with that of windows outside the aperture.
fn aberration_left(hop: &Hop, sampled: &[Carrier], sigma: f64, step: f64) -> f64 {
    let lattice = USUALLY_ON_LATTICE.sqrt() * left_by_lattice(step);
    let tile = TILE as f64 * step * sigma;
    let square = |carrier: &Carrier| {
        let start = ChirpedStart {
            carrier: *carrier,
            sigma,
        };
        let change = tile * curvature_slope(carrier, sampled);
        let part = lattice.hypot(start.left_between_tiles(hop.wavenumber(), change));
        let found = start.aberration(hop, [0.0; 2]);
        found.map_or(1.0, |found| {
            found.error().with_part_of_cubic(part).left.powi(2)
        })
    };
    let inside = sampled.iter().map(square).sum::<f64>() / sampled.len() as f64;
    (inside + outside_aberration(hop, sampled, sigma)).sqrt()
}

/// The same of a source that has one beamlet in each of its windows.
fn source_aberration_left(hop: &Hop, sampled: &[Carrier], sigma: f64, source: &Source) -> f64 {
    let square = |carrier: &Carrier| {
        let start = ChirpedStart {
            carrier: *carrier,
            sigma,
        };
        let found = source_aberration(&start, hop, source);
        found.map_or(1.0, |found| found.error().left.powi(2))
    };
    (sampled.iter().map(square).sum::<f64>() / sampled.len() as f64).sqrt()
}

/// How fast the curvature changes from one of some carriers to the nearest other one, in 1/mm².
fn curvature_slope(carrier: &Carrier, carriers: &[Carrier]) -> f64 {
    let apart = |other: &Carrier| {
        let [x, y] = [0, 1].map(|a| other.at[a] - carrier.at[a]);
        x.hypot(y)
    };
    let others = carriers.iter().filter(|other| other.at != carrier.at);
    let nearest = others.min_by(|a, b| apart(a).total_cmp(&apart(b)));
    nearest.map_or(0.0, |other| carrier.curvature_change(other) / apart(other))
}

/// The radius over which the light of the source falls on the first screen; infinite where its amplitude is even.
fn source_radius(system: &System, hop: &Hop) -> f64 {
    let k = hop.wavenumber() * hop.from.index;
    system.source.radius_at(hop.from.frame.origin, k)
}

/// The largest width that is small against the screen, at most `limit`, and leaves at most the error `allowed`. Where no
/// width leaves so little, the one that leaves least: narrow windows send beamlets that spread, and these meet
/// aberration as well.
fn widest(hop: &Hop, limit: f64, allowed: f64, left: impl Fn(f64) -> f64) -> f64 {
    let size = hop.from.bounds().map_or(limit, |[x0, x1, y0, y1]| {
        limit.min(LARGEST * (x1 - x0).max(y1 - y0))
    });
    let width = |power: i32| hop.wavelength * 2f64.powf(0.25 * f64::from(power));
    let (mut best, mut least) = (width(WIDTHS.start), f64::INFINITY);
    for sigma in WIDTHS.rev().map(width).filter(|sigma| *sigma <= size) {
        let error = left(sigma);
        if error <= allowed {
            return sigma;
        }
        if error < least {
            (best, least) = (sigma, error);
        }
    }
    best
}

/// The period of plane waves in σ: a whole number of square pixels that suits fast transforms, where one is near.
pub(crate) fn period_over_pixels(shape: WindowShape, element: &Element) -> f64 {
    let pitch = match element.pixels().map(|pixels| pixels.pitch) {
        Some([x, y]) if x == y => x,
        _ => return shape.period,
    };
    let least = shape.period * shape.sigma / pitch;
    if least > LONGEST_TRANSFORM {
        return shape.period;
    }
    let whole = fast_length(least.ceil() as usize) as f64;
    match whole <= LONGER * least {
        true => whole * pitch / shape.sigma,
        false => shape.period,
    }
}
