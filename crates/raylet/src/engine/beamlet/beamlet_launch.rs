//! One beamlet from its place on a screen to its landing on the next.

use crate::engine::ray_block::hop_rays::{HopRays, RayStart};
use crate::engine::trace::launch_plane::LaunchPlane;
use crate::optics::ray::Loss;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;

/// A beamlet of width σ and unit coefficient at the end of a hop, its optical path's phase included.
///
/// # Errors
/// How its chief ray was lost, if it was.
pub fn launch_beamlet(hop: &Hop, at: [f64; 2], p: [f64; 2], sigma: f64) -> Result<Arrival, Loss> {
    launch_beamlet_from(&LaunchPlane::new(hop.from, at)?, hop, p, sigma)
}

/// [`launch_beamlet`] from a launch plane that is known.
///
/// # Errors
/// How its chief ray was lost, if it was.
#[inline]
pub(crate) fn launch_beamlet_from(
    launch_plane: &LaunchPlane,
    hop: &Hop,
    p: [f64; 2],
    sigma: f64,
) -> Result<Arrival, Loss> {
    let k = hop.wavenumber();
    let start = launch_plane.window(sigma, k);
    let carried =
        launch_plane
            .hop(hop)
            .carry_beamlet(launch_plane.at(), launch_plane.cosines(p)?, start)?;
    Ok(carried.arrival(k))
}

/// The same of many beamlets, or how their chief rays are lost.
pub(crate) fn launch_beamlets_from(
    launch_plane: &LaunchPlane,
    hop: &Hop,
    directions: &[[f64; 2]],
    sigma: f64,
) -> Vec<Result<Arrival, Loss>> {
    let hop = launch_plane.hop(hop);
    if !hop.to.is_plane() {
        let one = |p: &[f64; 2]| launch_beamlet_from(launch_plane, &hop, *p, sigma);
        return directions.iter().map(one).collect();
    }
    let k = hop.wavenumber();
    let turned: Vec<_> = { directions.iter() }
        .map(|p| launch_plane.cosines(*p))
        .collect();
    let [x, y] = launch_plane.at();
    let kept: Vec<RayStart> = { turned.iter().flatten() }
        .map(|[p, q]| [x, y, *p, *q])
        .collect();
    let carried = HopRays::new(&hop).carry_beamlets(launch_plane.window(sigma, k), &kept);
    let mut carried = carried.into_iter();
    let landed = |p: Result<[f64; 2], Loss>| {
        p?;
        let carried = carried.next().unwrap_or(Err(Loss::Missed))?;
        Ok(carried.arrival(k))
    };
    turned.into_iter().map(landed).collect()
}
