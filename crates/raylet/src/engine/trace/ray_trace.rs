//! The one trace of a ray from screen to screen through a train of surfaces.

use fearless_simd::{Simd, dispatch};
use num_complex::Complex64;

use crate::math::complex::{Complex, Symmetric};
use crate::math::real::{Dual, Real};
use crate::math::simd_level::level;
use crate::math::vec3::Vec3;
use crate::optics::frame::{Axes, Frame};
use crate::optics::ray::{Loss, Ray};
use crate::optics::refraction::refract;
use crate::optics::screen::Screen;
use crate::optics::shape::{Bending, Shape};
use crate::optics::surface::Face;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::{Arrival, Beamlet, Companion, Encounter};

/// A ray where it meets a receiving screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing<T = f64> {
    /// Position in the screen's plane, in mm.
    pub at: [T; 2],
    /// Optical direction cosines (index × cosine) along the screen's axes.
    pub cosines: [T; 2],
    /// Optical path from the start, in mm.
    pub path: T,
}

/// A beamlet where it meets a receiving screen.
#[derive(Clone, Copy, Debug)]
pub struct Carried<T = f64> {
    /// Its chief ray.
    pub landing: Landing<T>,
    /// Its amplitude, one at the start; the optical path's phase is not in it.
    pub amplitude: Complex<T>,
    /// Its curvature along the screen's axes, in 1/mm.
    pub curvature: Symmetric<T>,
}

impl Carried {
    /// The beamlet ready to be summed, its optical path's phase included; `k` is the vacuum wavenumber.
    #[inline]
    pub(crate) fn arrival(&self, k: f64) -> Arrival {
        let g = self.curvature;
        Arrival {
            at: self.landing.at,
            cosines: self.landing.cosines,
            amplitude: self.amplitude.value() * Complex64::cis(k * self.landing.path),
            curvature: [g.xx.value(), g.xy.value(), g.yy.value()],
        }
    }
}

impl Landing<Dual<4>> {
    /// The landing, and its Jacobian, rows (s_x, s_y, p′_x, p′_y).
    pub(crate) fn with_jacobian(&self) -> (Landing<f64>, [[f64; 4]; 4]) {
        let plain = Landing {
            at: self.at.map(|v| v.value),
            cosines: self.cosines.map(|v| v.value),
            path: self.path.value,
        };
        let ([x, y], [px, py]) = (self.at, self.cosines);
        (plain, [x, y, px, py].map(|row| row.tangent))
    }
}

/// A screen as a ray of numbers `T` meets it.
pub(crate) struct LocatedScreen<'a, T, A, S> {
    /// The screen as it is.
    pub screen: &'a Screen,
    /// Its shape.
    pub shape: &'a S,
    /// Where it stands.
    pub axes: &'a A,
    /// Refractive index on the side where the ray is.
    pub index: T,
}

impl<'a, T: Real> LocatedScreen<'a, T, Frame, Shape> {
    /// A screen that stands still and that rays leave.
    #[inline(always)]
    pub(crate) fn left(screen: &'a Screen) -> Self {
        Self {
            screen,
            shape: &screen.shape,
            axes: &screen.frame,
            index: T::constant(screen.index_behind()),
        }
    }

    /// A screen that stands still and that rays reach.
    #[inline(always)]
    pub(crate) fn reached(screen: &'a Screen) -> Self {
        Self {
            screen,
            shape: &screen.shape,
            axes: &screen.frame,
            index: T::constant(screen.index),
        }
    }
}

/// The ray that leaves a screen above (x, y) with optical direction cosines p along its axes.
///
/// # Errors
/// [`Loss::Evanescent`] when |p| is not below the index; [`Loss::Missed`] where a curved screen does not
/// exist, or when the ray would leave on its wrong side.
#[inline(always)]
pub(crate) fn emit<T: Real, A: Axes<T>, S: Bending<T>>(
    from: &LocatedScreen<T, A, S>,
    at: [T; 2],
    p: [T; 2],
) -> Result<Ray<T>, Loss> {
    let (local, _) = emit_locally(from, at, p)?;
    let position = from.axes.to_global(local.position);
    Ok(Ray::new(
        position,
        from.axes.direction_to_global(local.direction),
    ))
}

/// The same ray on the axes of the screen, and the slopes of the screen where it starts.
///
/// # Errors
/// As [`emit`].
#[inline(always)]
pub(crate) fn emit_locally<T: Real, A, S: Bending<T>>(
    from: &LocatedScreen<T, A, S>,
    at: [T; 2],
    p: [T; 2],
) -> Result<(Ray<T>, [T; 2]), Loss> {
    let (screen, n) = (from.screen, from.index);
    let under = n * n - (p[0] * p[0] + p[1] * p[1]);
    if under.value() <= 0.0 {
        return Err(Loss::Evanescent);
    }
    let local = Vec3::new(p[0], p[1], under.sqrt() * screen.leaves()) * (T::constant(1.0) / n);
    let zero = T::constant(0.0);
    let (mut z, mut slope) = (zero, [zero; 2]);
    if !from.shape.is_plane() {
        let height = from.shape.height(at[0], at[1]).ok_or(Loss::Missed)?;
        let [sx, sy] = height.slope;
        let lift = local.z - local.x * sx - local.y * sy;
        if lift.value() * screen.leaves() <= 0.0 {
            return Err(Loss::Missed);
        }
        (z, slope) = (height.z, [sx, sy]);
    }
    Ok((Ray::new(Vec3::new(at[0], at[1], z), local), slope))
}

/// Takes a ray through a train of surfaces, and reports every flight and bend to the companion.
///
/// # Errors
/// How the ray was lost, if it was.
#[inline(always)]
pub(crate) fn trace_train<T: Real, F: Face<T>, C: Companion<T>>(
    train: &[F],
    mut ray: Ray<T>,
    companion: &mut C,
) -> Result<Ray<T>, Loss> {
    companion.visit(ray.position);
    for face in train {
        // Meet the surface in its own frame.
        let (surface, frame, index) = (face.surface(), face.axes(), face.index());
        let position = frame.to_local(ray.position);
        let direction = frame.direction_to_local(ray.direction);
        let length = face.meet(position, direction)?;
        let hit = position + direction * length;
        if !surface.aperture.contains(hit.x.value(), hit.y.value()) {
            return Err(Loss::Clipped);
        }
        companion.fly(length, index[0]);
        ray = ray.flown(length, index[0]);
        companion.visit(ray.position);

        // Its normal there, turned along the ray.
        let height = face.height(hit.x, hit.y).ok_or(Loss::Missed)?;
        let [sx, sy] = height.slope;
        let up = Vec3::new(-sx, -sy, T::constant(1.0)).unit();
        let side = T::constant(1.0).along(up.dot(direction));
        let normal = up * side;

        // Bend.
        let refracted = refract(surface.interface, surface.coating, direction, normal, index)?;
        companion.refract(&Encounter {
            frame,
            height: &height,
            normal,
            side: side.value(),
            refracted: &refracted,
            index,
        });
        ray.direction = frame.direction_to_global(refracted.direction);
    }
    Ok(ray)
}

/// Lets a ray fly to a screen.
///
/// # Errors
/// [`Loss::Missed`] when it runs parallel to the screen or away from the side it should arrive at.
#[inline(always)]
pub(crate) fn land<T: Real, A: Axes<T>, S: Bending<T>, C: Companion<T>>(
    to: &LocatedScreen<T, A, S>,
    ray: Ray<T>,
    companion: &mut C,
) -> Result<Landing<T>, Loss> {
    let screen = to.screen;
    let position = to.axes.to_local(ray.position);
    let direction = to.axes.direction_to_local(ray.direction);
    if direction.z.value() * screen.arrives <= 0.0 {
        return Err(Loss::Missed);
    }
    let length = to.shape.meet(position, direction)?;
    let n = to.index;
    companion.fly(length, n);
    let hit = position + direction * length;
    companion.visit(ray.position + ray.direction * length);
    Ok(Landing {
        at: [hit.x, hit.y],
        cosines: [direction.x * n, direction.y * n],
        path: ray.path + length * n,
    })
}

/// Where and how a beamlet starts.
#[derive(Clone, Copy)]
pub(crate) struct BeamletStart<T> {
    /// The (x, y) above which it starts on the emitting screen.
    pub at: [T; 2],
    /// Its optical direction cosines.
    pub p: [T; 2],
    /// Its curvature on the emitting screen's axes.
    pub q: Symmetric<T>,
}

/// Takes a beamlet through a train to a screen.
///
/// # Errors
/// How the ray was lost, if it was.
#[inline(always)]
pub(crate) fn carry_beamlet<T: Real, A: Axes<T>, F: Face<T>, S: Bending<T>, B: Bending<T>>(
    from: &LocatedScreen<T, A, S>,
    train: &[F],
    to: &LocatedScreen<T, A, B>,
    start: BeamletStart<T>,
) -> Result<Carried<T>, Loss> {
    let BeamletStart { at, p, q } = start;
    let ray = emit(from, at, p)?;
    let mut beamlet = Beamlet::launch(ray.direction, from.axes, q);
    let ray = trace_train(train, ray, &mut beamlet)?;
    let landing = land(to, ray, &mut beamlet)?;
    Ok(Carried {
        landing,
        amplitude: beamlet.amplitude,
        curvature: beamlet.land(to.axes),
    })
}

impl Hop<'_> {
    /// A ray from (x, y) on the first screen along p to the second screen.
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    #[inline(always)]
    pub fn trace<T: Real, C: Companion<T>>(
        &self,
        at: [T; 2],
        p: [T; 2],
        companion: &mut C,
    ) -> Result<Landing<T>, Loss> {
        let ray = emit(&LocatedScreen::left(self.from), at, p)?;
        let ray = trace_train(self.train, ray, companion)?;
        land(&LocatedScreen::reached(self.to), ray, companion)
    }

    /// A beamlet from (x, y) on the first screen along p to the second screen. It starts with curvature `q` in 1/mm on
    /// the axes of the first screen.
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    #[inline(always)]
    pub fn carry_beamlet<T: Real>(
        &self,
        at: [T; 2],
        p: [T; 2],
        q: Symmetric<T>,
    ) -> Result<Carried<T>, Loss> {
        let (from, to) = (
            LocatedScreen::left(self.from),
            LocatedScreen::reached(self.to),
        );
        carry_beamlet(&from, self.train, &to, BeamletStart { at, p, q })
    }

    /// The ray with its Jacobian J = ∂(s, p′)/∂(x, p), rows (s_x, s_y, p′_x, p′_y).
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    pub fn jacobian(
        &self,
        at: [f64; 2],
        p: [f64; 2],
    ) -> Result<(Landing<f64>, [[f64; 4]; 4]), Loss> {
        // Four derivatives of a number are one vector of the machine.
        let landing = dispatch!(level(), simd => self.differentiate(simd, at, p))?;
        Ok(landing.with_jacobian())
    }

    /// The ray with its derivatives by where and along which cosines it starts.
    #[inline(always)]
    fn differentiate<S: Simd>(
        &self,
        _: S,
        at: [f64; 2],
        p: [f64; 2],
    ) -> Result<Landing<Dual<4>>, Loss> {
        let start = [Dual::variable(at[0], 0), Dual::variable(at[1], 1)];
        let cosines = [Dual::variable(p[0], 2), Dual::variable(p[1], 3)];
        self.trace(start, cosines, &mut ())
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::parts::{self, conic, face, on_axis, open_screen};
    use crate::math::complex::{Complex, Symmetric};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::refraction::Interface;
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;

    fn surface(frame: Frame, curvature: f64, interface: Interface, index: [f64; 2]) -> Surface {
        let conic = Conic {
            curvature,
            conic: -0.3,
        };
        let shape = Shape::Asphere {
            base: conic,
            coefficients: vec![2e-6],
        };
        Surface {
            aperture: Aperture::disc(10.0),
            interface,
            ..face(frame, shape, index)
        }
    }

    fn shift(z: f64) -> Vec3 {
        Vec3::new(0.2, -0.1, z)
    }

    /// A tilted lens followed by a tilted mirror, between tilted screens.
    fn with_system<R>(mirror: bool, test: impl Fn(Hop) -> R) -> R {
        let from = open_screen(Frame::GLOBAL.tilted([0.1, -0.2, 0.05]));
        let first = Frame::GLOBAL.moved(shift(8.0)).tilted([0.15, 0.1, 0.0]);
        let second = Frame::GLOBAL.moved(shift(12.0)).tilted([-0.1, 0.05, 0.3]);
        let mut train = vec![
            surface(first, 0.05, Interface::Refract, [1.0, 1.5]),
            surface(second, -0.04, Interface::Refract, [1.5, 1.0]),
        ];
        let mut to = open_screen(Frame::GLOBAL.moved(shift(40.0)).tilted([0.0, 0.3, 0.0]));
        if mirror {
            let fold = Frame::GLOBAL.moved(shift(25.0)).tilted([0.5, 0.0, 0.0]);
            train.push(surface(fold, -0.02, Interface::Reflect, [1.0, 1.0]));
            let direction = Vec3::new(0.0, 1.0f64.sin(), -(1.0f64.cos()));
            let mut frame = Frame::GLOBAL.moved(shift(25.0)).tilted([1.0, 0.2, 0.0]);
            frame.origin = frame.origin + direction * 30.0;
            to = open_screen(frame);
            to.arrives = -1.0;
        }
        let hop = Hop {
            wavelength: 1e-3,
            from: &from,
            train: &train,
            to: &to,
        };
        test(hop)
    }

    #[test]
    fn jacobian_is_symplectic() {
        for mirror in [false, true] {
            with_system(mirror, |hop| {
                let (_, j) = hop.jacobian([0.3, -0.4], [0.12, 0.07]).unwrap();
                // JᵀΩJ = Ω with Ω = [[0, 1], [−1, 0]]: columns paired as (s·p′ − p′·s).
                for a in 0..4 {
                    for b in 0..4 {
                        let omega: f64 = (0..2)
                            .map(|i| j[i][a] * j[i + 2][b] - j[i + 2][a] * j[i][b])
                            .sum();
                        let expected = match (a, b) {
                            (0, 2) | (1, 3) => 1.0,
                            (2, 0) | (3, 1) => -1.0,
                            _ => 0.0,
                        };
                        assert!((omega - expected).abs() < 1e-12, "{a} {b} {omega}");
                    }
                }
            });
        }
    }

    /// Complex 2×2 helpers for the independent form (A + Bq, C + Dq).
    type Matrix = [[Complex64; 2]; 2];

    fn block(j: &[[f64; 4]; 4], row: usize, q: Complex64) -> Matrix {
        std::array::from_fn(|a| std::array::from_fn(|b| q * j[row + a][2 + b] + j[row + a][b]))
    }

    fn determinant(m: &Matrix) -> Complex64 {
        m[0][0] * m[1][1] - m[0][1] * m[1][0]
    }

    #[test]
    fn beamlet_agrees_with_the_jacobian() {
        for mirror in [false, true] {
            with_system(mirror, |hop| {
                let (at, p) = ([0.3, -0.4], [0.12, 0.07]);
                let q = Complex64::new(0.0, 0.21);
                let start = Symmetric {
                    xx: Complex::new(0.0, 0.21),
                    xy: Complex::new(0.0, 0.0),
                    yy: Complex::new(0.0, 0.21),
                };
                let carried = hop.carry_beamlet(at, p, start).unwrap();
                let (landing, g) = (carried.landing, carried.curvature);
                let (_, j) = hop.jacobian(at, p).unwrap();
                let (m, n) = (block(&j, 0, q), block(&j, 2, q));
                let d = determinant(&m);
                // G = (C + Dq)(A + Bq)⁻¹.
                let inverse = [[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]];
                let product =
                    |a: usize, b: usize| n[a][0] * inverse[0][b] + n[a][1] * inverse[1][b];
                let scale = product(0, 0).norm();
                for (ours, theirs) in [
                    (g.xx, product(0, 0)),
                    (g.xy, product(0, 1)),
                    (g.xy, product(1, 0)),
                    (g.yy, product(1, 1)),
                ] {
                    assert!((ours.value() - theirs).norm() < 1e-10 * scale);
                }
                // |a|² |det(A + Bq)| keeps the power: with ideal coatings in one medium it equals
                // cos₁/cos₂, the cosines to the two screens.
                let cos = |p: [f64; 2]| (1.0 - p[0] * p[0] - p[1] * p[1]).sqrt();
                let power = carried.amplitude.value().norm_sqr() * d.norm();
                assert!((power - cos(p) / cos(landing.cosines)).abs() < 1e-10);
            });
        }
    }

    #[test]
    fn parabola_and_ellipse_bring_every_path_to_one_length() {
        // A parabolic mirror focuses collimated light, an ellipsoid one focus into the other.
        let plane = open_screen(on_axis(-30.0));
        let focus = |z: f64| {
            let mut s = open_screen(on_axis(z));
            s.arrives = -1.0;
            s
        };
        let mirror = |radius: f64, constant: f64| {
            parts::mirror(Frame::GLOBAL, conic(1.0 / radius, constant))
        };
        let train = [mirror(-80.0, -1.0)];
        let to = focus(-40.0);
        let hop = Hop {
            wavelength: 1e-3,
            from: &plane,
            train: &train,
            to: &to,
        };
        for x in [0.0, 3.0, 11.0] {
            let landing = hop.trace([x, 0.5 * x], [0.0, 0.0], &mut ()).unwrap();
            assert!(landing.at[0].hypot(landing.at[1]) < 1e-12);
            assert!((landing.path - 70.0).abs() < 1e-12);
        }
        // Ellipse with semi-axes a, b: R = b²/a, κ = −e², foci at a(1 ∓ e) from the vertex.
        let (a, e) = (50.0, 0.6f64);
        let train = [mirror(-a * (1.0 - e * e), -e * e)];
        let source = open_screen(on_axis(-a * (1.0 - e)));
        let to = focus(-a * (1.0 + e));
        let hop = Hop {
            wavelength: 1e-3,
            from: &source,
            train: &train,
            to: &to,
        };
        for p in [0.0, 0.2, 0.5] {
            let landing = hop.trace([0.0, 0.0], [p, -0.3 * p], &mut ()).unwrap();
            assert!(landing.at[0].hypot(landing.at[1]) < 1e-12, "{landing:?}");
            assert!((landing.path - 2.0 * a).abs() < 1e-12);
        }
    }

    #[test]
    fn sphere_is_stigmatic_at_its_aplanatic_points() {
        // Light in glass n aimed at R·(1 + n)/n … leaves as if from the conjugate at R·(1 + n).
        let (n, radius) = (1.5, -20.0);
        let surface = face(Frame::GLOBAL, conic(1.0 / radius, 0.0), [n, 1.0]);
        // Object at distance R(1 + 1/n) before the vertex; its virtual image at R(1 + n).
        let mut from = open_screen(on_axis(radius * (1.0 + 1.0 / n)));
        from.index = n;
        let to = open_screen(on_axis(radius * (1.0 + n)));
        let train = [surface];
        let hop = Hop {
            wavelength: 1e-3,
            from: &from,
            train: &train,
            to: &to,
        };
        let axis = hop.trace([0.0, 0.0], [0.0, 0.0], &mut ()).unwrap();
        for p in [0.1, 0.5, 0.9] {
            let landing = hop.trace([0.0, 0.0], [p, 0.3 * p], &mut ()).unwrap();
            assert!(landing.at[0].hypot(landing.at[1]) < 1e-12);
            assert!((landing.path - axis.path).abs() < 1e-12);
        }
    }
}
