//! Gaussian beams: light with a waist, as from a laser or a single-mode fibre.

use num_complex::Complex64;

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::beams::taper::axes_about;

/// A paraxial Gaussian beam, of unit amplitude and phase zero at the centre of its waist. Its angle of divergence λ/πw must be
/// small: the field is off by some (λ/πw)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianBeam {
    /// Centre of the waist in mm, global.
    pub waist: Vec3,
    /// Unit vectors along the two axes of the waist, and the direction of travel.
    pub axes: [Vec3; 3],
    /// Rayleigh range along each axis of the waist, πnw²/λ, in mm.
    pub rayleigh: [f64; 2],
}

impl GaussianBeam {
    /// A beam with these radii (1/e² of the intensity) along the axes of its waist in mm, in a medium of wavenumber
    /// `k` = 2πn/λ; the first axis is turned by `rotation` rad from x towards y.
    pub fn new(waist: Vec3, direction: Vec3, radii: [f64; 2], rotation: f64, k: f64) -> Self {
        Self {
            waist,
            axes: axes_about(direction, rotation),
            rayleigh: radii.map(|w| 0.5 * k * w * w),
        }
    }

    /// A point on the beam's own axes, from the centre of the waist.
    fn inwards<T: Real>(&self, point: Vec3<T>) -> [T; 3] {
        let from_waist = point - Vec3::constant(self.waist);
        self.axes.map(|axis| Vec3::constant(axis).dot(from_waist))
    }

    /// The field at a global point: for each axis √(q₀/q) exp(ik x²/2q) with q = z − i zR.
    pub fn field(&self, point: Vec3, k: f64) -> Complex64 {
        let [x, y, z] = self.inwards(point);
        let along = |x: f64, rayleigh: f64| {
            let q = Complex64::new(z, -rayleigh);
            let chirp = Complex64::new(0.0, 0.5 * k * x * x) / q;
            (Complex64::new(0.0, -rayleigh) / q).sqrt() * chirp.exp()
        };
        let [rx, ry] = self.rayleigh;
        along(x, rx) * along(y, ry) * Complex64::cis(k * z)
    }

    /// The length in mm by which wavefronts lead at a global point, zero at the waist, without Gouy's phase.
    pub fn path(&self, point: Vec3) -> f64 {
        let [x, y, z] = self.inwards(point);
        let [rx, ry] = self.rayleigh;
        let bent = |x: f64, rayleigh: f64| 0.5 * x * x * z / (z * z + rayleigh * rayleigh);
        z + bent(x, rx) + bent(y, ry)
    }

    /// The unit normal of the wavefront at a global point.
    pub fn direction<T: Real>(&self, point: Vec3<T>) -> Vec3<T> {
        let [x, y, z] = self.inwards(point);
        let slope = |x: T, rayleigh: f64| x * z / (z * z + rayleigh * rayleigh);
        let [rx, ry] = self.rayleigh;
        let [first, second, along] = self.axes.map(Vec3::constant);
        (first * slope(x, rx) + second * slope(y, ry) + along).unit()
    }

    /// The smaller of the two radii (1/e² of the intensity) at a global point, in mm, in a medium of wavenumber `k`.
    pub fn radius_at(&self, point: Vec3, k: f64) -> f64 {
        let [_, _, z] = self.inwards(point);
        let radius = |rayleigh: f64| (2.0 * rayleigh / k).sqrt() * (z / rayleigh).hypot(1.0);
        self.rayleigh
            .map(radius)
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::math::vec3::Vec3;
    use crate::optics::beams::gaussian_beam::GaussianBeam;

    const K: f64 = 1e4;

    fn beam() -> GaussianBeam {
        let direction = Vec3::new(0.01, -0.02, 1.0).unit();
        GaussianBeam::new(Vec3::new(0.2, 0.1, -30.0), direction, [0.08, 0.05], 0.5, K)
    }

    /// ∇²U + k²U = 0 up to the paraxial approximation: its error is of the order of (2/kw)² of the term that the envelope
    /// brings, here 2e-5.
    #[test]
    fn the_field_solves_the_wave_equation() {
        let beam = beam();
        let at = Vec3::new(0.43, -0.28, -10.0);
        let along = beam.axes;
        // The envelope, whose second differences lose no digits to the carrier.
        let envelope = |point: Vec3| {
            let z = (point - beam.waist).dot(along[2]);
            beam.field(point, K) * Complex64::cis(-K * z)
        };
        let second = |axis: Vec3, h: f64| {
            let [plus, minus] = [1.0, -1.0].map(|sign| envelope(at + axis * (sign * h)));
            (plus + minus - envelope(at) * 2.0) / (h * h)
        };
        let h = 1e-3;
        let first = (envelope(at + along[2] * h) - envelope(at + along[2] * -h)) / (2.0 * h);
        let rest = second(along[0], h) + second(along[1], h) + first * Complex64::new(0.0, 2.0 * K);
        let size = second(along[0], h).norm() + second(along[1], h).norm();
        assert!(rest.norm() < 1e-3 * size, "{} {size}", rest.norm());
    }

    /// The directions are those in which the phase of the field grows.
    #[test]
    fn directions_and_paths_follow_the_phase() {
        let beam = beam();
        let (at, h) = (Vec3::new(0.43, -0.28, -10.0), 1e-5);
        let direction = beam.direction(at);
        let axes = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
        for axis in axes {
            let [plus, minus] = [1.0, -1.0].map(|sign| at + axis * (sign * h));
            let ratio = beam.field(plus, K) / beam.field(minus, K);
            let slope = ratio.arg() / (2.0 * h * K);
            assert!((slope - axis.dot(direction)).abs() < 2e-6, "{slope}");
            let path = (beam.path(plus) - beam.path(minus)) / (2.0 * h);
            assert!((slope - path).abs() < 2e-6, "{slope} {path}");
        }
    }

    /// At the waist the field is real there and falls to 1/e at the radius; a Rayleigh range behind it both radii are √2
    /// times as large.
    #[test]
    fn radii_are_those_of_the_waist() {
        let axis = Vec3::new(0.0, 0.0, 1.0);
        let beam = GaussianBeam::new(Vec3::new(0.0, 0.0, 0.0), axis, [0.08, 0.05], 0.0, K);
        let edge = beam.field(Vec3::new(0.08, 0.0, 0.0), K);
        assert!((edge - Complex64::from((-1.0f64).exp())).norm() < 1e-12);
        let edge = beam.field(Vec3::new(0.0, 0.05, 0.0), K);
        assert!((edge - Complex64::from((-1.0f64).exp())).norm() < 1e-12);
        let behind = Vec3::new(0.0, 0.0, 0.5 * K * 0.05 * 0.05);
        let radius = beam.radius_at(behind, K);
        assert!((radius - 0.05 * 2f64.sqrt()).abs() < 1e-12, "{radius}");
    }
}
