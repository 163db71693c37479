//! The share of a beamlet's energy that its tail brings to a target beside which its ray lands, by real rays.
//!
//! Where a beamlet is too aberrated to count, its Gaussian says little about its tail. The ray map's linear part
//! names the ray of the beamlet that would land on the nearest point of the target at the smallest distance r in
//! phase space, where the Wigner distribution is exp(−r²) of its peak. Real rays then give the true distance.

use crate::engine::trace::launch_plane::LaunchPlane;
use crate::math::erfc::erfc;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Tail;

/// Tails that are discarded count in the error up to this distance r, where the amplitude is exp(−r²/2). It is the same
/// for all target errors.
const COUNTED: f64 = 3.0;

/// Real rays that are traced to find the distance.
const TRIALS: usize = 3;

/// A beamlet as it leaves.
pub(crate) struct LeavingBeamlet<'a> {
    /// The plane from which it leaves.
    pub launch_plane: &'a LaunchPlane,
    /// Its optical direction cosines on the screen.
    pub p: [f64; 2],
    /// Its width σ in mm.
    pub sigma: f64,
}

/// The share of a beamlet's energy that falls into the box `[x_min, x_max, y_min, y_max]` (mm) on the next screen,
/// for a ray that lands beside it with the Gaussian tail `tail`; zero where real rays do not get there within
/// r = 3.
pub(crate) fn discarded_tail_share(
    hop: &Hop,
    leaving: &LeavingBeamlet,
    bounds: [f64; 4],
    tail: Tail,
) -> f64 {
    match distances(hop, leaving, bounds) {
        Some([_, real]) if real > COUNTED => 0.0,
        Some([linear, real]) => (tail.share * erfc(real) / erfc(linear)).min(1.0),
        None => 0.0,
    }
}

/// The distance r from the beamlet's ray to the ray that lands on the nearest point of the box, by the linear map and
/// by real rays; nothing where these are lost or go the other way.
fn distances(hop: &Hop, leaving: &LeavingBeamlet, bounds: [f64; 4]) -> Option<[f64; 2]> {
    let launch_plane = leaving.launch_plane;
    let (hop, at, p) = (
        &launch_plane.hop(hop),
        launch_plane.at(),
        launch_plane.cosines(leaving.p).ok()?,
    );
    let (landing, jacobian) = hop.jacobian(at, p).ok()?;
    let missing = [0, 1].map(|a| {
        let [low, high] = [bounds[2 * a], bounds[2 * a + 1]];
        landing.at[a].clamp(low, high) - landing.at[a]
    });
    let length = missing[0].hypot(missing[1]);
    if length == 0.0 {
        return Some([0.0; 2]);
    }

    // The displacement of least norm, in units of the beamlet's widths, that the linear map brings there.
    let sigma = leaving.sigma;
    let narrow = 1.0 / (hop.wavenumber() * sigma);
    let scale = [sigma, sigma, narrow, narrow];
    let map = [0, 1].map(|a| [0, 1, 2, 3].map(|i| jacobian[a][i] * scale[i]));
    let dot = |a: usize, b: usize| (0..4).map(|i| map[a][i] * map[b][i]).sum::<f64>();
    let (xx, xy, yy) = (dot(0, 0), dot(0, 1), dot(1, 1));
    let determinant = xx * yy - xy * xy;
    let u = [
        (yy * missing[0] - xy * missing[1]) / determinant,
        (xx * missing[1] - xy * missing[0]) / determinant,
    ];
    let least = [0, 1, 2, 3].map(|i| u[0] * map[0][i] + u[1] * map[1][i]);
    let linear = least.iter().map(|v| v * v).sum::<f64>().sqrt();

    // How many times that displacement real rays need, by secants from the beamlet's own ray.
    let mut times = 1.0;
    for _ in 0..TRIALS {
        let moved = [0, 1, 2, 3].map(|i| times * least[i] * scale[i]);
        let (at, p) = (
            [at[0] + moved[0], at[1] + moved[1]],
            [p[0] + moved[2], p[1] + moved[3]],
        );
        let found = hop.trace(at, p, &mut ()).ok()?;
        let reached = (0..2)
            .map(|a| (found.at[a] - landing.at[a]) * missing[a] / length)
            .sum::<f64>();
        if reached <= 0.0 {
            return None;
        }
        times *= length / reached;
    }
    Some([linear, times * linear])
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::beamlet::beamlet_launch::launch_beamlet_from;
    use crate::engine::beamlet::discarded_tail::{LeavingBeamlet, discarded_tail_share};
    use crate::engine::trace::launch_plane::LaunchPlane;
    use crate::fixtures::parts::{self, on_axis, screen};
    use crate::math::vec3::Vec3;

    use crate::optics::screen::Screen;

    use crate::optics::system::Hop;
    use crate::wave::beamlet::wavelet::Tail;

    fn sensor(distance: f64, tilt: f64) -> Screen {
        let frame = on_axis(distance).tilted([0.0, tilt, 0.0]);
        screen(frame, parts::sensor(1, 1.0))
    }

    /// The energy flux on a box of the screen of the Gaussian exp(−s²/2σ² + ikp·s), as a share of all that leaves its
    /// plane, by Rayleigh and Sommerfeld's sum over the Gaussian; lengths in wavelengths.
    fn by_waves(to: &Screen, p: [f64; 2], sigma: f64, bounds: [f64; 4]) -> f64 {
        let k = std::f64::consts::TAU;
        let grid = |low: f64, high: f64, step: f64| {
            let count = ((high - low) / step).ceil() as usize;
            let step = (high - low) / count as f64;
            (0..count).map(move |i| (low + (i as f64 + 0.5) * step, step))
        };
        let reach = 5.0 * sigma;
        let source: Vec<_> = grid(-reach, reach, 0.4)
            .flat_map(|(x, dx)| grid(-reach, reach, 0.4).map(move |(y, dy)| ([x, y], dx * dy)))
            .map(|(s, area)| {
                let size = (-(s[0] * s[0] + s[1] * s[1]) / (2.0 * sigma * sigma)).exp() * area;
                let phase = k * (p[0] * s[0] + p[1] * s[1]);
                (s, Complex64::from_polar(size, phase))
            })
            .collect();
        let mut landed = 0.0;
        let [x0, x1, y0, y1] = bounds;
        for (x, dx) in grid(x0, x1, 5.0) {
            for (y, dy) in grid(y0, y1, 10.0) {
                let frame = &to.frame;
                let at = frame.origin + frame.x * x + frame.y * y;
                let (mut u, mut slope) = (Complex64::ZERO, Complex64::ZERO);
                for (s, value) in &source {
                    let r = at - Vec3::new(s[0], s[1], 0.0);
                    let length = r.norm();
                    let wave = value * Complex64::cis(k * length) * r.z / (length * length);
                    u += wave;
                    slope += wave * r.dot(frame.z) / length;
                }
                landed += (u.conj() * slope).re * dx * dy;
            }
        }
        let cosine = (1.0 - p[0] * p[0] - p[1] * p[1]).sqrt();
        landed / (std::f64::consts::PI * sigma * sigma * cosine)
    }

    /// Beamlets that land beside a sensor in free space: the Gaussian holds for wide, steep ones. For narrow, grazing ones it
    /// is wrong by up to 60 times, and real rays are right within a factor of two.
    #[test]
    fn shares_are_those_of_the_wave() {
        for (distance, tilt, p, sigma, beside) in [
            (2000.0, 0.0, 0.1, 12.0, 1.5),
            (200.0, 0.0, 0.7, 1.5, 1.8),
            (200.0, 0.0, 0.7, 1.5, -1.8),
            (200.0, 0.5, 0.3, 1.5, -2.0),
            (200.0, 0.5, 0.6, 1.5, -2.0),
        ] {
            let (from, to) = (sensor(0.0, 0.0), sensor(distance, tilt));
            let hop = Hop {
                wavelength: 1.0,
                from: &from,
                train: &[],
                to: &to,
            };
            let launch_plane = LaunchPlane::new(&from, [0.0; 2]).unwrap();
            let leaving = LeavingBeamlet {
                launch_plane: &launch_plane,
                p: [p, 0.0],
                sigma,
            };
            let arrival = launch_beamlet_from(&launch_plane, &hop, leaving.p, sigma).unwrap();
            let k = hop.wavenumber();
            let [wx, wy] = arrival.footprint(k, (-0.5f64).exp());
            let x = arrival.at[0] + beside * wx;
            let far = x + 2.5 * f64::signum(beside) * wx;
            let bounds = [x.min(far), x.max(far), -3.0 * wy, 3.0 * wy];
            let tail = Tail::of(&arrival, bounds, k);
            let share = discarded_tail_share(&hop, &leaving, bounds, tail);
            let ratio = share / by_waves(&to, leaving.p, sigma, bounds);
            assert!(
                (0.5..2.0).contains(&ratio),
                "{distance} {tilt} {p} {sigma} {beside}: {ratio}"
            );
        }
    }
}
