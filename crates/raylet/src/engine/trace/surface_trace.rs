//! Rays and beamlets between screens in the coordinates of the light on their surfaces.
//!
//! On a curved screen the light is a function of the x and y below its surface: E(x, y, s(x, y)). A wave with optical
//! cosines (p, q) along the screen's axes has the slopes P = p + q∇s there, and to the curvature of the wave along the
//! surface that of the surface is added, q∇∇s. Both are exact along a ray; what a beamlet leaves out is its aberration,
//! which the rays have too. Elements multiply E(x, y, s(x, y)), so they and windows are those of a plane. On a plane all
//! of this is what [`Hop::trace`] and [`Hop::carry_beamlet`] do.
//!
//! A beamlet that arrives at an interface gets the factor by which the interface transmits it.

use crate::engine::ray_block::hop_rays::{HopRays, RayStart, Traced};
use crate::engine::trace::ray_trace::{
    BeamletStart, Carried, Landing, LocatedScreen, emit, land, trace_train,
};
use crate::math::complex::Symmetric;
use crate::math::real::{Dual, Real};
use crate::math::vec3::Vec3;
use crate::optics::deflection::transmitted;
use crate::optics::frame::Axes;
use crate::optics::ray::{Loss, Ray};
use crate::optics::shape::Bending;
use crate::optics::surface::Face;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::{Beamlet, Companion};

/// A ray on a curved screen.
struct Standing<T> {
    /// Its optical cosine along the screen's z axis.
    along: T,
    /// ∇s there.
    slope: [T; 2],
    /// ∇∇s there: xx, xy, yy.
    hessian: [T; 3],
}

impl<T: Real> Standing<T> {
    /// A ray that leaves with slopes P of its wave along the surface: p + q∇s = P and |p|² + q² = n², on the side
    /// where light leaves.
    fn leaving<A: Axes<T>, S: Bending<T>>(
        from: &LocatedScreen<T, A, S>,
        at: [T; 2],
        p: [T; 2],
    ) -> Result<(Self, Ray<T>), Loss> {
        let (screen, n) = (from.screen, from.index);
        let height = from.shape.height(at[0], at[1]).ok_or(Loss::Missed)?;
        let [sx, sy] = height.slope;
        let steep = sx * sx + sy * sy + 1.0;
        let tilted = p[0] * sx + p[1] * sy;
        let under = tilted * tilted + steep * (n * n - p[0] * p[0] - p[1] * p[1]);
        if under.value() <= 0.0 {
            return Err(Loss::Evanescent);
        }
        let along = (tilted + under.sqrt() * screen.leaves()) / steep;
        let local = Vec3::new(p[0] - along * sx, p[1] - along * sy, along);
        let position = from.axes.to_global(Vec3::new(at[0], at[1], height.z));
        let direction = from
            .axes
            .direction_to_global(local * (T::constant(1.0) / n));
        let standing = Self {
            along,
            slope: height.slope,
            hessian: height.hessian,
        };
        Ok((standing, Ray::new(position, direction)))
    }

    /// A ray that has landed.
    fn landed<A: Axes<T>, S: Bending<T>>(
        to: &LocatedScreen<T, A, S>,
        landing: &Landing<T>,
    ) -> Result<Self, Loss> {
        let (screen, [px, py]) = (to.screen, landing.cosines);
        let [x, y] = landing.at;
        let height = to.shape.height(x, y).ok_or(Loss::Missed)?;
        let square = to.index * to.index - px * px - py * py;
        Ok(Self {
            along: square.sqrt() * screen.arrives,
            slope: height.slope,
            hessian: height.hessian,
        })
    }

    /// The slopes of its wave along the surface.
    fn slopes(&self, [px, py]: [T; 2]) -> [T; 2] {
        [
            px + self.along * self.slope[0],
            py + self.along * self.slope[1],
        ]
    }

    /// How the surface moves with x and with y, global.
    fn tangents<A: Axes<T>>(&self, axes: &A) -> [Vec3<T>; 2] {
        let [sx, sy] = self.slope;
        let [one, zero] = [1.0, 0.0].map(T::constant);
        [Vec3::new(one, zero, sx), Vec3::new(zero, one, sy)].map(|v| axes.direction_to_global(v))
    }

    /// A curvature with `sign` times what the surface adds to it.
    fn with_surface(&self, curvature: Symmetric<T>, sign: f64) -> Symmetric<T> {
        let [xx, xy, yy] = self.hessian.map(|second| second * self.along * sign);
        let mut sum = curvature;
        sum.xx.re = sum.xx.re + xx;
        sum.xy.re = sum.xy.re + xy;
        sum.yy.re = sum.yy.re + yy;
        sum
    }
}

/// A ray that leaves a screen with slopes p of its wave along the surface.
fn ray_leaving<T: Real, A: Axes<T>, S: Bending<T>>(
    from: &LocatedScreen<T, A, S>,
    at: [T; 2],
    p: [T; 2],
) -> Result<Ray<T>, Loss> {
    match from.shape.is_plane() {
        true => emit(from, at, p),
        false => Ok(Standing::leaving(from, at, p)?.1),
    }
}

/// A landing with the slopes of its wave along the surface in place of its cosines.
fn along_surface<T: Real, A: Axes<T>, S: Bending<T>>(
    to: &LocatedScreen<T, A, S>,
    landing: Landing<T>,
) -> Result<Landing<T>, Loss> {
    if to.shape.is_plane() {
        return Ok(landing);
    }
    let cosines = Standing::landed(to, &landing)?.slopes(landing.cosines);
    Ok(Landing { cosines, ..landing })
}

impl Hop<'_> {
    /// [`Hop::trace`] with the slopes of the wave along both surfaces.
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    pub(crate) fn trace_along<T: Real>(
        &self,
        at: [T; 2],
        p: [T; 2],
        companion: &mut impl Companion<T>,
    ) -> Result<Landing<T>, Loss> {
        let (from, to) = (
            LocatedScreen::left(self.from),
            LocatedScreen::reached(self.to),
        );
        let ray = trace_train(self.train, ray_leaving(&from, at, p)?, companion)?;
        along_surface(&to, land(&to, ray, companion)?)
    }

    /// The same for many rays.
    pub(crate) fn trace_all_along(&self, starts: &[RayStart]) -> Vec<Traced> {
        if self.from.is_plane() && self.to.is_plane() {
            return HopRays::new(self).trace(starts);
        }
        let one = |[x, y, p, q]: &RayStart| self.trace_along([*x, *y], [*p, *q], &mut ());
        starts.iter().map(one).collect()
    }

    /// [`Hop::jacobian`] with the slopes of the wave along both surfaces.
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    pub(crate) fn jacobian_along(
        &self,
        at: [f64; 2],
        p: [f64; 2],
    ) -> Result<(Landing<f64>, [[f64; 4]; 4]), Loss> {
        let start = [Dual::<4>::variable(at[0], 0), Dual::variable(at[1], 1)];
        let slopes = [Dual::variable(p[0], 2), Dual::variable(p[1], 3)];
        Ok(self.trace_along(start, slopes, &mut ())?.with_jacobian())
    }

    /// [`Hop::carry_beamlet`] with slopes and curvature of the wave along both surfaces, and what the interface under
    /// the second screen transmits.
    ///
    /// # Errors
    /// How the ray was lost, if it was.
    #[inline]
    pub(crate) fn carry_along<T: Real>(
        &self,
        at: [T; 2],
        p: [T; 2],
        q: Symmetric<T>,
    ) -> Result<Carried<T>, Loss> {
        if self.from.is_plane() && self.to.is_plane() && self.to.behind.is_none() {
            return self.carry_beamlet(at, p, q);
        }
        let (from, to) = (
            LocatedScreen::left(self.from),
            LocatedScreen::reached(self.to),
        );
        carry_along(&from, self.train, &to, BeamletStart { at, p, q })
    }

    /// The same for many beamlets that start with one curvature.
    pub(crate) fn carry_all_along(
        &self,
        q: Symmetric<f64>,
        starts: &[RayStart],
    ) -> Vec<Result<Carried, Loss>> {
        if self.from.is_plane() && self.to.is_plane() && self.to.behind.is_none() {
            return HopRays::new(self).carry_beamlets(q, starts);
        }
        let one = |[x, y, px, py]: &RayStart| self.carry_along([*x, *y], [*px, *py], q);
        starts.iter().map(one).collect()
    }
}

/// A beamlet from surface to surface, with slopes and curvature of the wave along both.
///
/// # Errors
/// How the ray was lost, if it was.
pub(crate) fn carry_along<T: Real, A: Axes<T>, F: Face<T>, S: Bending<T>, B: Bending<T>>(
    from: &LocatedScreen<T, A, S>,
    train: &[F],
    to: &LocatedScreen<T, A, B>,
    start: BeamletStart<T>,
) -> Result<Carried<T>, Loss> {
    let BeamletStart { at, p, q } = start;
    let (ray, mut beamlet) = if from.shape.is_plane() {
        let ray = emit(from, at, p)?;
        (ray, Beamlet::launch(ray.direction, from.axes, q))
    } else {
        let (standing, ray) = Standing::leaving(from, at, p)?;
        let tangents = standing.tangents(from.axes);
        let q = standing.with_surface(q, -1.0);
        (ray, Beamlet::launch_along(ray.direction, tangents, q))
    };
    let ray = trace_train(train, ray, &mut beamlet)?;
    let landing = land(to, ray, &mut beamlet)?;
    let factor = transmitted(to.screen, to.shape, landing.at, landing.cosines)?;
    let amplitude = beamlet.amplitude.scale(factor);
    if to.shape.is_plane() {
        return Ok(Carried {
            landing,
            amplitude,
            curvature: beamlet.land(to.axes),
        });
    }
    let standing = Standing::landed(to, &landing)?;
    let curvature = beamlet.land_along(standing.tangents(to.axes));
    let cosines = standing.slopes(landing.cosines);
    Ok(Carried {
        landing: Landing { cosines, ..landing },
        amplitude,
        curvature: standing.with_surface(curvature, 1.0),
    })
}
