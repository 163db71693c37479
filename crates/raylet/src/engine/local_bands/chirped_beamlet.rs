//! One beamlet that starts with the curvature of its carrier, and the aberration inside it.
//!
//! Its phase space is sheared: displaced by u in place it is displaced by Qu in direction, as the wave itself. So its
//! width is not tied to the curvature of the light.

use crate::engine::beamlet::beamlet_aberration::{
    Aberration, directions, left_on_lattice, phase_point, symplectic,
};
use crate::math::complex::{Complex, Symmetric};
use crate::optics::ray::Loss;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::carrier::Carrier;

/// What a window sends out: Gaussians of one width about its carrier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChirpedStart {
    /// The carrier about the window's centre.
    pub carrier: Carrier,
    /// Width σ in mm.
    pub sigma: f64,
}

/// What the windows of two tiles leave of the cubic phase where they meet, over half the change kσ²ΔQ of their chirp. Behind cubic
/// phases the errors are 0.9 to 1.5 of that.
const LEFT_BETWEEN_TILES: f64 = 1.2;

/// Displaced rays are traced at these parts of their distance.
pub(crate) const NEARER: [f64; 3] = [1.0, 0.5, 0.25];

/// The part of the mean square cubic phase that a lattice of windows sees, where neighbouring rays are lost and before a run: about
/// the mean behind lenses and tilted planes.
pub(crate) const USUALLY_ON_LATTICE: f64 = 0.36;

impl ChirpedStart {
    /// The beamlet of unit coefficient in the direction Δp beside the carrier, where it lands.
    ///
    /// # Errors
    /// How its chief ray was lost, if it was.
    #[inline]
    pub(crate) fn launch(&self, hop: &Hop, dp: [f64; 2]) -> Result<Arrival, Loss> {
        let (k, Carrier { at, p, .. }) = (hop.wavenumber(), self.carrier);
        let carried = hop.carry_along(at, [p[0] + dp[0], p[1] + dp[1]], self.curvature(k))?;
        Ok(carried.arrival(k))
    }

    /// The same in many directions.
    pub(crate) fn launch_all(&self, hop: &Hop, dp: &[[f64; 2]]) -> Vec<Result<Arrival, Loss>> {
        let (k, Carrier { at, p, .. }) = (hop.wavenumber(), self.carrier);
        let starts = dp
            .iter()
            .map(|dp| [at[0], at[1], p[0] + dp[0], p[1] + dp[1]]);
        let carried = hop.carry_all_along(self.curvature(k), &starts.collect::<Vec<_>>());
        let arrivals = carried.into_iter();
        arrivals.map(|one| one.map(|one| one.arrival(k))).collect()
    }

    /// The complex curvature with which beamlets start.
    pub(crate) fn curvature(&self, k: f64) -> Symmetric<f64> {
        let (width, [xx, xy, yy]) = (1.0 / (k * self.sigma * self.sigma), self.carrier.q);
        Symmetric {
            xx: Complex::new(xx, width),
            xy: Complex::new(xy, 0.0),
            yy: Complex::new(yy, width),
        }
    }

    /// The part of the cubic phase inside beamlets that the windows of neighbouring tiles leave, whose curvatures differ by a
    /// `change` in 1/mm.
    ///
    /// Windows of one curvature cancel it: it is odd in the distance from the beamlet's centre. Its size goes with the shear of the
    /// beamlets, so where two shears meet their halves differ.
    pub(crate) fn left_between_tiles(&self, k: f64, change: f64) -> f64 {
        let flat = Carrier {
            q: [0.0; 3],
            ..self.carrier
        };
        let chirp = |curvature: f64| k * self.sigma * self.sigma * curvature;
        let own = chirp(self.carrier.curvature_change(&flat));
        (LEFT_BETWEEN_TILES * 0.5 * chirp(change) / (1.0 + own)).min(1.0)
    }

    /// The aberration inside a beamlet, for sums over all places and directions; nothing when the ray or one of its
    /// neighbours is lost.
    pub(crate) fn aberration(&self, hop: &Hop, dp: [f64; 2]) -> Option<Aberration> {
        let k = hop.wavenumber();
        let spread = 1.0 / (k * self.sigma);
        let displacements = directions().map(|[x, y, px, py]| {
            self.sheared([x * self.sigma, y * self.sigma], [px * spread, py * spread])
        });
        // Where an edge stops most of the displaced rays, nearer ones give the same: the means grow with the sixth and the
        // fourth power of the distance.
        NEARER.iter().find_map(|part| {
            let nearer = displacements.map(|d| d.map(|d| part * d));
            let found = self.phases_at(hop, dp, &nearer)?;
            let [fourth, sixth] = [part.powi(4), part.powi(6)];
            Some(Aberration {
                cubic: k * k * found.cubic / sixth,
                quartic: k * found.quartic / fourth,
                lattice: k * k * found.lattice / sixth,
            })
        })
    }

    /// A displacement in place, with what the carrier and a displacement in direction add to it.
    pub(crate) fn sheared(&self, u: [f64; 2], p: [f64; 2]) -> [f64; 4] {
        let [xx, xy, yy] = self.carrier.q;
        [
            u[0],
            u[1],
            p[0] + xx * u[0] + xy * u[1],
            p[1] + xy * u[0] + yy * u[1],
        ]
    }

    /// The cubic and the quartic Hamiltonian in mm, squared and as they are, that the linear map of rays leaves out at these
    /// displacements, from the rays that arrive; nothing where these are not the most.
    fn phases_at(
        &self,
        hop: &Hop,
        dp: [f64; 2],
        displacements: &[[f64; 4]; 24],
    ) -> Option<Aberration> {
        let Carrier { at, p, .. } = self.carrier;
        let start = [at[0], at[1], p[0] + dp[0], p[1] + dp[1]];
        let (centre, jacobian) = hop.jacobian_along(at, [start[2], start[3]]).ok()?;
        let centre = phase_point(&centre);
        let moved = |delta: &[f64; 4], sign: f64| [0, 1, 2, 3].map(|i| start[i] + sign * delta[i]);
        let starts = displacements
            .iter()
            .flat_map(|d| [moved(d, 1.0), moved(d, -1.0)]);
        let landings = hop.trace_all_along(&starts.collect::<Vec<_>>());
        let (mut thirds, mut fourth) = ([None; 24], 0.0);
        let pairs = displacements.iter().zip(landings.as_chunks::<2>().0);
        for (third, (delta, pair)) in thirds.iter_mut().zip(pairs) {
            let [Ok(plus), Ok(minus)] = pair else {
                continue;
            };
            let (plus, minus) = (phase_point(plus), phase_point(minus));
            let linear: [f64; 4] =
                std::array::from_fn(|i| (0..4).map(|j| jacobian[i][j] * delta[j]).sum());
            let even = std::array::from_fn(|i| 0.5 * (plus[i] + minus[i]) - centre[i]);
            let odd = std::array::from_fn(|i| 0.5 * (plus[i] - minus[i]) - linear[i]);
            *third = Some(symplectic(&linear, &even) / 3.0);
            fourth += symplectic(&linear, &odd) / 4.0;
        }
        let traced = thirds.iter().flatten().count();
        let squares: f64 = thirds.iter().flatten().map(|third| third * third).sum();
        let cubic = 24.0 * squares / traced as f64;
        (2 * traced > thirds.len()).then(|| Aberration {
            cubic,
            quartic: 6.0 * fourth / traced as f64,
            lattice: left_on_lattice(&thirds).unwrap_or(USUALLY_ON_LATTICE * cubic),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
    use crate::engine::local_bands::source::source_aberration::source_aberration;
    use crate::fixtures::parts::{conic, face, on_axis, open_screen, plane_wave, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;
    use crate::wave::local_bands::carrier::Carrier;

    /// Light at 2.9 mm before a ball face of 10 mm radius. An aperture of 2.92 mm stops most of the rays that are displaced by
    /// 0.05 mm. The means over nearer rays, and over fewer, stay within a factor of two.
    #[test]
    fn an_edge_beside_a_beamlet_leaves_its_aberration_known() {
        let found = |radius: f64| {
            let ball = Surface {
                aperture: Aperture::disc(radius),
                ..face(on_axis(1.0), conic(0.1, 0.0), [1.0, 1.5])
            };
            let (from, mut to) = (
                open_screen(on_axis(0.0)),
                screen(on_axis(20.0), sensor(8, 0.01)),
            );
            to.index = 1.5;
            let hop = Hop {
                wavelength: 0.5e-3,
                from: &from,
                train: &[ball],
                to: &to,
            };
            let carrier = Carrier {
                at: [2.9, 0.0],
                p: [0.0; 2],
                q: [0.0; 3],
            };
            let start = ChirpedStart {
                carrier,
                sigma: 0.05,
            };
            [
                start.aberration(&hop, [0.0; 2]),
                source_aberration(&start, &hop, &plane_wave([0.0; 2])).map(|found| found.phases),
            ]
        };
        let (open, cut) = (found(5.0), found(2.92));
        for (open, cut) in open.iter().zip(cut) {
            let (open, cut) = (open.unwrap(), cut.unwrap());
            let near = |a: f64, b: f64| (0.5..2.0).contains(&(b / a));
            assert!(near(open.cubic, cut.cubic), "{open:?} {cut:?}");
            assert!(near(open.quartic, cut.quartic), "{open:?} {cut:?}");
        }
    }
}
