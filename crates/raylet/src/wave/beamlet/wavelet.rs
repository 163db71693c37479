//! Beamlets: the Gaussian wavelet that a ray carries, in the ray's own frame.
//!
//! A beamlet is exp(ik[path + p·u + ½ uᵀGu]) with complex curvature G, kept as a tensor across the ray.
//! In this form its amplitude has no cosine factors, whatever the tilts and the number of mirrors
//! (Greynolds, Proc. SPIE 560, 33, 1985; Arnaud, Appl. Opt. 24, 538, 1985).

use crate::math::complex::{Complex, Symmetric};
use crate::math::erfc::erfc;
use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::frame::Axes;
use crate::optics::refraction::Refracted;
use crate::optics::shape::Height;

/// A ray at one surface: what the trace of the ray tells its companion there.
pub struct Encounter<'a, T, A> {
    /// The surface's frame.
    pub frame: &'a A,
    /// Height and derivatives at the hit, in the surface's frame.
    pub height: &'a Height<T>,
    /// Unit normal along the incoming ray, in the surface's frame.
    pub normal: Vec3<T>,
    /// +1 when that normal points to the surface's +z, else −1.
    pub side: f64,
    /// The direction behind the surface, in the surface's frame, with the loss of amplitude.
    pub refracted: &'a Refracted<T>,
    /// Refractive index before and behind the surface.
    pub index: [T; 2],
}

/// A quantity that is carried along a ray, such as a beamlet.
pub trait Companion<T: Real> {
    /// The ray flies `length` mm through a medium.
    fn fly(&mut self, length: T, index: T);
    /// The ray is refracted at a surface.
    fn refract<A: Axes<T>>(&mut self, encounter: &Encounter<T, A>);
    /// The ray stands at a global point, at its start and after each flight.
    fn visit(&mut self, _point: Vec3<T>) {}
}

/// Nothing travels along.
impl<T: Real> Companion<T> for () {
    #[inline(always)]
    fn fly(&mut self, _length: T, _index: T) {}
    #[inline(always)]
    fn refract<A: Axes<T>>(&mut self, _encounter: &Encounter<T, A>) {}
}

/// A beamlet's amplitude and curvature.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beamlet<T = f64> {
    /// Complex amplitude, one at the start.
    pub amplitude: Complex<T>,
    /// G⊥ along `across` and direction × across, in 1/mm (vacuum wavenumber convention).
    pub curvature: Symmetric<T>,
    /// First transverse axis, global, orthogonal to the ray.
    pub across: Vec3<T>,
    /// The ray's unit direction, global.
    direction: Vec3<T>,
}

impl<T: Real> Beamlet<T> {
    /// The beamlet that stands on a screen with curvature `q` (1/mm) along the screen's x and y axes:
    /// G⊥ = P⁻ᵀ q P⁻¹, P_ab = e_a · axis_b.
    #[inline(always)]
    pub(crate) fn launch<A: Axes<T>>(direction: Vec3<T>, screen: &A, q: Symmetric<T>) -> Self {
        Self::launch_along(direction, screen.across(), q)
    }

    /// [`Beamlet::launch`] with the curvature `q` along two vectors that span a plane, of any length and angle.
    #[inline(always)]
    pub(crate) fn launch_along(direction: Vec3<T>, [x, y]: [Vec3<T>; 2], q: Symmetric<T>) -> Self {
        let across = (x + direction * -direction.dot(x)).unit();
        let along = direction.cross(across);
        let p = [[across.dot(x), across.dot(y)], [along.dot(x), along.dot(y)]];
        Self {
            amplitude: Complex::one(),
            curvature: q.congruent(inverse(p)),
            across,
            direction,
        }
    }

    /// The curvature along a receiving screen's axes, G = PᵀG⊥P.
    #[inline(always)]
    pub(crate) fn land<A: Axes<T>>(&self, screen: &A) -> Symmetric<T> {
        self.land_along(screen.across())
    }

    /// The same along two vectors that span a plane, of any length and angle.
    #[inline(always)]
    pub(crate) fn land_along(&self, [x, y]: [Vec3<T>; 2]) -> Symmetric<T> {
        let along = self.direction.cross(self.across);
        self.curvature.congruent([
            [self.across.dot(x), self.across.dot(y)],
            [along.dot(x), along.dot(y)],
        ])
    }
}

impl<T: Real> Companion<T> for Beamlet<T> {
    #[inline(always)]
    fn fly(&mut self, length: T, index: T) {
        let (curvature, root) = self.curvature.fly(length / index);
        self.curvature = curvature;
        self.amplitude = self.amplitude * root;
    }

    /// H = P₁ᵀG⊥P₁ + (n₁cos χ₁ − n₂cos χ₂)S on tangent axes, then G⊥′ = P₂⁻ᵀHP₂⁻¹ across the new ray.
    #[inline(always)]
    fn refract<A: Axes<T>>(&mut self, e: &Encounter<T, A>) {
        let across = e.frame.direction_to_local(self.across);
        let along = e.frame.direction_to_local(self.direction).cross(across);

        // Tangent axes follow the old transverse axis, so nothing is singular at normal incidence.
        let t1 = (across + e.normal * -across.dot(e.normal)).unit();
        let t2 = e.normal.cross(t1);
        let before = [
            [across.dot(t1), across.dot(t2)],
            [along.dot(t1), along.dot(t2)],
        ];
        let mut h = self.curvature.congruent(before);

        // The second fundamental form of the height along the normal, weighted by the index step.
        let [sx, sy] = e.height.slope;
        let scale = T::constant(e.side) / (sx * sx + sy * sy + 1.0).sqrt();
        let step =
            (e.refracted.cosine_in * e.index[0] - e.refracted.cosine_out * e.index[1]) * scale;
        let [xx, xy, yy] = e.height.hessian;
        let form = |a: Vec3<T>, b: Vec3<T>| {
            (xx * a.x * b.x + xy * (a.x * b.y + a.y * b.x) + yy * a.y * b.y) * step
        };
        h.xx.re = h.xx.re + form(t1, t1);
        h.xy.re = h.xy.re + form(t1, t2);
        h.yy.re = h.yy.re + form(t2, t2);

        // Across the new ray.
        let direction = e.refracted.direction;
        let across = (t1 + direction * -direction.dot(t1)).unit();
        let along = direction.cross(across);
        let after = [
            [across.dot(t1), across.dot(t2)],
            [along.dot(t1), along.dot(t2)],
        ];
        self.curvature = h.congruent(inverse(after));
        self.amplitude = self.amplitude.scale(e.refracted.transmission);
        self.across = e.frame.direction_to_global(across);
        self.direction = e.frame.direction_to_global(direction);
    }
}

/// Inverse of a real 2×2 matrix.
#[inline(always)]
fn inverse<T: Real>([[a, b], [c, d]]: [[T; 2]; 2]) -> [[T; 2]; 2] {
    let scale = T::constant(1.0) / (a * d - b * c);
    [[d * scale, -b * scale], [-c * scale, a * scale]]
}

/// A beamlet that has reached a screen, ready to be summed: amplitude·exp(ik[p·u + ½uᵀGu]), u = x − s.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Where its chief ray lands, in mm, screen coordinates.
    pub at: [f64; 2],
    /// Optical direction cosines along the screen's axes.
    pub cosines: [f64; 2],
    /// Complex amplitude, coefficient and optical path included.
    pub amplitude: num_complex::Complex64,
    /// Curvature along the screen's axes, in 1/mm: xx, xy, yy.
    pub curvature: [num_complex::Complex64; 3],
}

/// How a beamlet lies to a box on its screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tail {
    /// How much of its energy falls into the box, if the Gaussian holds there.
    pub share: f64,
    /// Distance r of its ray from the box: the amplitude at the edge is exp(−r²/2) of the peak.
    pub distance: f64,
}

/// So many widths inside an edge all of a beamlet's energy is on this side of it, to the last bit.
const DEEP: f64 = 6.0;

impl Tail {
    /// All of a beamlet's energy falls into the box.
    pub(crate) const WHOLE: Self = Self {
        share: 1.0,
        distance: 0.0,
    };

    /// Of a beamlet to the box `[x_min, x_max, y_min, y_max]` (mm).
    pub(crate) fn of(arrival: &Arrival, bounds: [f64; 4], k: f64) -> Self {
        let width = arrival.footprint(k, (-0.5f64).exp());
        let mut tail = Self::WHOLE;
        for a in 0..2 {
            let [low, high] = [bounds[2 * a], bounds[2 * a + 1]];
            let [below, above] = [low, high].map(|end| (end - arrival.at[a]) / width[a]);
            if below < -DEEP && above > DEEP {
                continue;
            }
            tail.share *= 0.5 * (erfc(below) - erfc(above));
            tail.distance = tail.distance.hypot(below.max(-above).max(0.0));
        }
        tail
    }
}

impl Arrival {
    /// Its modulus at a place, in parts of its peak.
    pub(crate) fn decay(&self, at: [f64; 2], k: f64) -> f64 {
        let [x, y] = [0, 1].map(|a| at[a] - self.at[a]);
        let [xx, xy, yy] = self.curvature.map(|g| g.im);
        (-0.5 * k * (xx * x * x + 2.0 * xy * x * y + yy * y * y)).exp()
    }

    /// Half widths of the box around the footprint where the Gaussian exceeds `threshold`, in mm;
    /// infinite when the curvature does not decay.
    #[inline]
    pub(crate) fn footprint(&self, k: f64, threshold: f64) -> [f64; 2] {
        let [xx, xy, yy] = self.curvature.map(|g| g.im);
        let determinant = xx * yy - xy * xy;
        if !(determinant > 0.0 && xx > 0.0) {
            return [f64::INFINITY; 2];
        }
        let reach = -2.0 * threshold.ln() / (k * determinant);
        [(reach * yy).sqrt(), (reach * xx).sqrt()]
    }

    /// Half widths, in optical direction cosines, of the beamlet's own angular spread.
    #[inline]
    pub(crate) fn spread(&self, k: f64, threshold: f64) -> [f64; 2] {
        let [xx, xy, yy] = self.curvature;
        let reach = self.footprint(k, threshold);
        [
            xx.norm() * reach[0] + xy.norm() * reach[1],
            xy.norm() * reach[0] + yy.norm() * reach[1],
        ]
    }
}
