//! An estimate of the light that hard edges diffract into each direction.
//!
//! A straight edge of a uniformly lit aperture sends, for each length of it and towards either side, the energy
//! λ/(4π²q²) dq of each unit of area into directions that differ by q from the light's own along the edge's
//! normal (the mean of a slit's sinc² far from its middle). It decides which rims matter where little or none of
//! the light goes to the target by itself; it enters no field.

use crate::engine::rims::source_ray::{SourceRay, obliquity};
use crate::engine::rims::source_rays::ray_behind;
use crate::optics::aperture::Aperture;
use crate::optics::polygon;
use crate::optics::screen::ScreenKind;
use crate::optics::system::Hop;

/// Points along an outline at which edge waves begin.
const POINTS: usize = 32;

/// Directions towards either side at each point, equally far apart by ratio.
const DIRECTIONS: i32 = 14;

/// The energy that an edge sends into directions from `q` to `q + width` off the light's own, of light of unit
/// energy a length of it.
pub(crate) fn edge_energy(wavelength: f64, q: f64, width: f64) -> f64 {
    let four_pi_square = (2.0 * std::f64::consts::PI).powi(2);
    wavelength / four_pi_square * (1.0 / q - 1.0 / (q + width))
}

/// Rays for the light that the outline of a stop or a smooth element sends aside, for the rays that arrive there.
/// What pixels send aside is among the rays that leave them.
pub(crate) fn edge_waves(hop: &Hop, arriving: &[SourceRay]) -> Vec<SourceRay> {
    let aperture = match &hop.from.kind {
        ScreenKind::Stop(aperture) => aperture,
        ScreenKind::Doe(doe) if doe.pixels().is_none() => &doe.aperture,
        ScreenKind::Doe(_) | ScreenKind::Sensor(_) => &Aperture::OPEN,
    };
    let rim = aperture.rim();
    if rim.is_empty() || arriving.is_empty() {
        return Vec::new();
    }
    let area = polygon::area(&rim).abs();
    let each = area / arriving.len() as f64;
    let narrowest = separate(hop).max(hop.wavelength / (2.0 * area.sqrt()));
    let ratio = (2.0 * hop.from.index_behind() / narrowest).powf(1.0 / f64::from(DIRECTIONS));
    let stride = rim.len().div_ceil(POINTS);
    let starts = (0..rim.len()).step_by(stride);
    let wave = |i: usize| {
        let at = rim[i];
        let before = rim[(i + rim.len() - stride) % rim.len()];
        let after = rim[(i + stride) % rim.len()];
        let along = [0.5 * (after[0] - before[0]), 0.5 * (after[1] - before[1])];
        let length = along[0].hypot(along[1]);
        let normal = [along[1] / length, -along[0] / length];
        let nearest = nearest(arriving, at);
        let direct = ray_behind(hop, &SourceRay { at, ..nearest });
        let per_length = nearest.energy / each * length;
        (0..2 * DIRECTIONS).map(move |n| {
            let side = if n % 2 == 0 { 1.0 } else { -1.0 };
            let q = narrowest * ratio.powi(n / 2);
            let middle = side * q * ratio.sqrt();
            let p = [0, 1].map(|a| direct.p[a] + middle * normal[a]);
            let sent = edge_energy(hop.wavelength, q, q * (ratio - 1.0));
            SourceRay {
                at,
                p,
                energy: per_length * sent * obliquity(hop, p),
                spread: [0.0; 2],
            }
        })
    };
    let waves = starts.flat_map(wave);
    let runs = |wave: &SourceRay| wave.p[0].hypot(wave.p[1]) < hop.from.index_behind();
    waves.filter(runs).collect()
}

/// The smallest angle, in optical cosines, at which an edge wave has left the penumbra of its edge on the way to the
/// next surface or screen.
fn separate(hop: &Hop) -> f64 {
    let next = hop
        .train
        .first()
        .map_or(hop.to.frame, |surface| surface.frame);
    let way = (next.origin - hop.from.frame.origin).norm();
    (hop.wavelength * hop.from.index_behind() / way.max(hop.wavelength)).sqrt()
}

/// The arriving ray next to a place.
fn nearest(arriving: &[SourceRay], at: [f64; 2]) -> SourceRay {
    let far = |source_ray: &SourceRay| (source_ray.at[0] - at[0]).hypot(source_ray.at[1] - at[1]);
    let closer = |a: SourceRay, b: &SourceRay| if far(b) < far(&a) { *b } else { a };
    arriving.iter().fold(arriving[0], closer)
}

#[cfg(test)]
mod tests {
    use crate::engine::rims::edge_diffraction::edge_waves;
    use crate::engine::rims::source_ray::SourceRay;
    use crate::engine::rims::source_rays::source_rays;
    use crate::fixtures::parts::{lit, on_axis, screen, sensor};

    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;

    /// Beyond a cone, a disc's edge waves carry what Airy's pattern has there: J₀² + J₁² of 2πap/λ.
    #[test]
    fn edge_waves_carry_the_rings_of_airy() {
        let radius = 20.0;
        let stop = ScreenKind::Stop(Aperture::disc(radius));
        let far = screen(on_axis(1e4), sensor(1, 1.0));
        let system = lit(vec![screen(Frame::GLOBAL, stop), far], vec![vec![]]);
        let light = source_rays(&system);
        let hop = system.hops().next().unwrap();
        let whole: f64 = light.iter().map(|source_ray| source_ray.energy).sum();
        let waves = edge_waves(&hop, &light);
        for [low, high] in [[0.05, 0.15], [0.15, 0.45], [0.3, 0.9]] {
            // The mean over these cones, because the waves have few directions.
            let part = |wave: &SourceRay| {
                let sine = wave.p[0].hypot(wave.p[1]);
                wave.energy * (sine.min(high) - low).max(0.0) / (high - low)
            };
            let share = waves.iter().map(part).sum::<f64>() / whole;
            // Its slope is λ/(π²ap²) far out; the cosine of the direction times it has this integral up to sine one.
            let pi = std::f64::consts::PI;
            let weighted_tail = |sine: f64| (1.0 - sine * sine).sqrt() / sine - sine.acos();
            let sine = |n: i32| low + (high - low) * (f64::from(n) + 0.5) / 100.0;
            let far = (0..100).map(|n| weighted_tail(sine(n))).sum::<f64>() / 100.0;
            let expected = far / (pi * pi * radius);
            assert!(
                (share / expected - 1.0).abs() < 0.15,
                "{low} to {high}: {share:e} {expected:e}"
            );
        }
    }
}
