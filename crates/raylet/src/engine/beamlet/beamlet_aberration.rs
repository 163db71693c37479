//! The aberration inside one beamlet, which the parabasal map leaves out: its size, and the factor that corrects it.
//!
//! The cubic and quartic parts of the ray map's Hamiltonian are found from real rays displaced by the
//! beamlet's own width in phase space, in 24 directions that with their opposites form a spherical
//! 7-design, so the Gaussian averages are exact.

use num_complex::Complex64;

use crate::engine::ray_block::hop_rays::{HopRays, RayStart};
use crate::engine::trace::launch_plane::LaunchPlane;
use crate::engine::trace::ray_trace::Landing;
use crate::optics::system::Hop;

/// Higher-order aberration inside one beamlet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Aberration {
    /// ε₃², the mean square cubic phase (rad²).
    pub cubic: f64,
    /// m₄, the mean quartic phase (rad).
    pub quartic: f64,
    /// The part of ε₃² that a lattice of windows leaves, but for the factor of their distance (rad²).
    pub lattice: f64,
}

/// What the aberration inside a beamlet does to the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AberrationError {
    /// η, the relative error of the field without a correction, at most 1.
    pub plain: f64,
    /// What the correction leaves of it.
    pub left: f64,
    /// ε₃², the mean square cubic phase (rad²).
    pub cubic: f64,
    /// The part of it that the lattice of windows leaves, but for the factor of their distance (rad²), as far as it falls on
    /// the target.
    pub lattice: f64,
    /// The energy of the lattice's first orders that falls on the target, over that of the light itself; at most one.
    pub orders: f64,
}

impl AberrationError {
    /// The same where this part of the lattice's first orders falls on the target.
    pub(crate) fn with_orders(&self, orders: f64) -> Self {
        Self {
            lattice: orders * self.lattice,
            orders,
            ..*self
        }
    }

    /// The same where neighbours leave this part of the cubic phase, which they cancel otherwise.
    pub(crate) fn with_part_of_cubic(&self, part: f64) -> Self {
        let left = self.left.hypot(part * self.cubic.sqrt()).min(1.0);
        Self { left, ..*self }
    }
}

/// Largest η that is corrected.
pub(crate) const CORRECTABLE: f64 = 0.15;

/// What the correction leaves, over η(ε₃ + η): between 2 and 5 behind tilted sensors and rims.
const LEFT: f64 = 3.0;

impl Aberration {
    /// η of one beamlet: the modulus of what the correction changes, √((½ε₃²)² + (3m₄)²), at most 1.
    pub(crate) fn eta(&self) -> f64 {
        self.change().norm().min(1.0)
    }

    /// The logarithm of the correction, ½ε₃² − 3i m₄.
    fn change(&self) -> Complex64 {
        Complex64::new(0.5 * self.cubic, -3.0 * self.quartic)
    }

    /// The same beamlet's aberration at a distance r from its ray, where its amplitude is exp(−r²/2) of the
    /// peak: the cubic phase grows as r³, the quartic one as r⁴, from ⟨r⁶⟩ = 24 and ⟨r⁴⟩ = 6 over the beamlet's
    /// energy in its four dimensions.
    pub(crate) fn at_distance(&self, r: f64) -> Self {
        let sixth = (r.powi(6) / 24.0).max(1.0);
        Self {
            cubic: self.cubic * sixth,
            quartic: self.quartic * (r.powi(4) / 6.0).max(1.0),
            lattice: self.lattice * sixth,
        }
    }

    /// What the correction leaves of it, some η(ε₃ + η); all of it where there is none.
    pub(crate) fn left(&self) -> f64 {
        let eta = self.eta();
        if eta > CORRECTABLE {
            return eta;
        }
        (LEFT * eta * (self.cubic.sqrt() + eta)).min(eta)
    }

    /// What it does to the field.
    pub(crate) fn error(&self) -> AberrationError {
        AberrationError {
            plain: self.eta(),
            left: self.left(),
            cubic: self.cubic,
            lattice: self.lattice,
            orders: 1.0,
        }
    }

    /// The factor exp(½ε₃² − 3i m₄) for the beamlet's amplitude; one where the expansion does not hold.
    pub(crate) fn correction(&self) -> Complex64 {
        self.correction_up_to(CORRECTABLE)
    }

    /// The same factor; one where η is larger than `largest`.
    pub(crate) fn correction_up_to(&self, largest: f64) -> Complex64 {
        if self.eta() > largest {
            return Complex64::ONE;
        }
        self.change().exp()
    }
}

/// The 24 unit vectors u = (u_x, u_y, u_px, u_py): axes, (1, ±1, ±1, ±1)/2 and (eᵢ ± eⱼ)/√2.
pub(crate) fn directions() -> [[f64; 4]; 24] {
    let mut list = [[0.0; 4]; 24];
    let mut count = 0;
    let mut push = |u: [f64; 4]| {
        list[count] = u;
        count += 1;
    };
    for i in 0..4 {
        let mut u = [0.0; 4];
        u[i] = 1.0;
        push(u);
    }
    for signs in 0..8 {
        let sign = |bit: i32| if signs >> bit & 1 == 0 { 0.5 } else { -0.5 };
        push([0.5, sign(0), sign(1), sign(2)]);
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for i in 0..4 {
        for j in i + 1..4 {
            for sign in [half, -half] {
                let mut u = [0.0; 4];
                (u[i], u[j]) = (half, sign);
                push(u);
            }
        }
    }
    list
}

/// The directions within the plane of a place and its cosine, at 0°, 90°, 45° and -45°, for x and y.
const PLANES: [[usize; 4]; 2] = [[0, 2, 14, 15], [1, 3, 20, 21]];

/// The mean square of what a lattice of windows along x and y leaves of a Hamiltonian H whose `cubic` values along
/// [`directions`] are known, before the factor of the distance of windows; nothing where a value that it needs is not known.
///
/// In the plane of a place and its cosine H is Re(A exp(3iθ) + B exp(iθ))r³. On a Gaussian a cosine is i times the place, so
/// H becomes 4Āu³ there. Parts of H that mix x and y leave a tenth as much.
pub(crate) fn left_on_lattice(cubic: &[Option<f64>; 24]) -> Option<f64> {
    let along = |plane: [usize; 4]| {
        let [zero, right, up, down] = plane.map(|number| cubic[number]);
        let (zero, right, up, down) = (zero?, right?, up?, down?);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let third = [zero - half * (up + down), right - half * (up - down)].map(|a| 0.5 * a);
        Some(16.0 * (third[0].powi(2) + third[1].powi(2)))
    };
    let [x, y] = PLANES.map(along);
    Some(2.0 * (x? + y?))
}

/// (s_x, s_y, p′_x, p′_y) of a landing.
pub(crate) fn phase_point(landing: &Landing) -> [f64; 4] {
    let ([x, y], [p, q]) = (landing.at, landing.cosines);
    [x, y, p, q]
}

/// The phase-space product a_s·b_p − a_p·b_s.
pub(crate) fn symplectic(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a[0] * b[2] + a[1] * b[3] - a[2] * b[0] - a[3] * b[1]
}

/// Aberration inside the beamlet of width `sigma` about the ray that leaves (x, y) along p; nothing when
/// the ray or one of its neighbours is lost. `k` is the vacuum wavenumber.
pub(crate) fn aberration(
    hop: &Hop,
    at: [f64; 2],
    p: [f64; 2],
    sigma: f64,
    k: f64,
) -> Option<Aberration> {
    // Positions and cosines on the plane that touches the screen are canonical variables.
    let launch_plane = LaunchPlane::new(hop.from, at).ok()?;
    let hop = launch_plane.hop(hop);
    let rays = HopRays::new(&hop);
    let ([x, y], [px, py]) = (launch_plane.at(), launch_plane.cosines(p).ok()?);
    let start = [x, y, px, py];
    let (centre, jacobian) = rays.jacobians(&[start]).pop()?.ok()?;
    let centre = phase_point(&centre);
    let scale = [sigma, sigma, 1.0 / (k * sigma), 1.0 / (k * sigma)];
    let displacements = directions().map(|u| std::array::from_fn(|i| u[i] * scale[i]));
    let (mut cubic, mut quartic) = ([None; 24], 0.0);
    for ((cubic, delta), [plus, minus]) in
        (cubic.iter_mut().zip(&displacements)).zip(displaced(&rays, start, &displacements)?)
    {
        // Their even and odd departures from the linear map, and the Hamiltonian's cubic and quartic.
        let linear: [f64; 4] =
            std::array::from_fn(|i| (0..4).map(|j| jacobian[i][j] * delta[j]).sum());
        let even = std::array::from_fn(|i| 0.5 * (plus[i] + minus[i]) - centre[i]);
        let odd = std::array::from_fn(|i| 0.5 * (plus[i] - minus[i]) - linear[i]);
        *cubic = Some(symplectic(&linear, &even) / 3.0);
        quartic += symplectic(&linear, &odd) / 4.0 / 24.0;
    }
    let squares = cubic.iter().flatten().map(|third| third * third);
    Some(Aberration {
        cubic: k * k * squares.sum::<f64>(),
        quartic: 6.0 * k * quartic,
        lattice: k * k * left_on_lattice(&cubic).unwrap_or_default(),
    })
}

/// Where the two real rays land that are displaced by ±δ, for each displacement δ; nothing when one is lost.
fn displaced(
    rays: &HopRays,
    start: RayStart,
    displacements: &[RayStart; 24],
) -> Option<[[[f64; 4]; 2]; 24]> {
    let mut starts = [start; 48];
    for (delta, pair) in displacements.iter().zip(starts.as_chunks_mut::<2>().0) {
        for a in 0..4 {
            pair[0][a] += delta[a];
            pair[1][a] -= delta[a];
        }
    }
    let mut found = [[[0.0; 4]; 2]; 24];
    for (i, landing) in rays.trace(&starts).iter().enumerate() {
        found[i / 2][i % 2] = phase_point(landing.as_ref().ok()?);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::beamlet::beamlet_aberration::{directions, left_on_lattice};

    /// A cubic form of places and cosines along x and y without order.
    fn cubic_form(u: [Complex64; 4]) -> Complex64 {
        let (mut sum, mut number) = (Complex64::ZERO, 0.0_f64);
        for i in 0..4 {
            for j in i..4 {
                for l in j..4 {
                    number += 1.0;
                    sum += u[i] * u[j] * u[l] * (2.3 * number).sin();
                }
            }
        }
        sum
    }

    /// On a Gaussian a cosine acts as i times the place.
    #[test]
    fn the_lattice_sees_what_acts_as_a_cubic_phase_on_a_gaussian() {
        let real = |u: [f64; 4]| cubic_form(u.map(Complex64::from)).re;
        let found = left_on_lattice(&directions().map(|u| Some(real(u)))).unwrap();
        let (one, i, zero) = (Complex64::ONE, Complex64::I, Complex64::ZERO);
        let [x, y] = [[one, zero, i, zero], [zero, one, zero, i]].map(cubic_form);
        let expected = 2.0 * (x.norm_sqr() + y.norm_sqr());
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn directions_average_like_the_sphere() {
        // Moments on the unit sphere of R⁴: ⟨u₁²⟩ = 1/4, ⟨u₁⁴⟩ = 1/8, ⟨u₁²u₂²⟩ = 1/24, ⟨u₁⁶⟩ = 5/64,
        // ⟨u₁⁴u₂²⟩ = 1/64, ⟨u₁²u₂²u₃²⟩ = 1/192.
        let mean = |f: &dyn Fn([f64; 4]) -> f64| directions().map(f).iter().sum::<f64>() / 24.0;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(mean(&|u| u.map(|v| v * v).iter().sum()), 1.0);
        close(mean(&|u| u[2].powi(4)), 1.0 / 8.0);
        close(mean(&|u| (u[0] * u[3]).powi(2)), 1.0 / 24.0);
        close(mean(&|u| u[1].powi(6)), 5.0 / 64.0);
        close(mean(&|u| u[1].powi(4) * u[2].powi(2)), 1.0 / 64.0);
        close(mean(&|u| (u[0] * u[1] * u[2]).powi(2)), 1.0 / 192.0);
    }
}
