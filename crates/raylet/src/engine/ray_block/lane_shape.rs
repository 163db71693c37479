//! Where eight rays meet a shape, and its normal there.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdFrom, f64x8, mask64x8};

use crate::engine::ray_block::lane_vec3::{LaneVec3, one_of};
use crate::math::lanes::{LANES, Lanes};
use crate::optics::conic::Conic;
use crate::optics::shape::Shape;

/// Where eight rays meet a shape, on its axes.
pub(crate) struct Meeting<S: Simd, C> {
    /// Distances along the rays in mm.
    pub length: f64x8<S>,
    /// The points.
    pub hit: LaneVec3<S>,
    /// Normals there, towards the local +z, of any length.
    pub normal: LaneVec3<S>,
    /// Squares of the lengths of the normals.
    pub square: f64x8<S>,
    /// Products of the normals with the unit directions of the rays.
    pub along: f64x8<S>,
    /// Which rays meet the shape.
    pub met: mask64x8<S>,
    /// How the normals change along the shape.
    pub bending: C,
}

/// A shape that eight rays meet at once.
pub(crate) trait LaneShape {
    /// How its normal changes.
    type Bending<S: Simd>: LaneBending<S>;
    /// Where rays meet it; positions and unit directions on its axes.
    fn meet<S: Simd>(
        &self,
        simd: S,
        position: LaneVec3<S>,
        direction: LaneVec3<S>,
    ) -> Meeting<S, Self::Bending<S>>;
}

/// How normals change along a shape.
pub(crate) trait LaneBending<S: Simd> {
    /// The change of the normal where the point moves along the shape. It is a symmetric map, of second derivatives.
    fn normal_change(&self, moved: LaneVec3<S>) -> LaneVec3<S>;
}

/// z = 0.
pub(crate) struct LanePlane;

/// A conic; a sphere where `SPHERE`.
pub(crate) struct LaneConic<const SPHERE: bool>(pub Conic);

/// Any shape: its rays go one by one.
pub(crate) struct LaneAny<'a>(pub &'a Shape);

/// Which numbers are finite.
#[inline(always)]
fn finite<S: Simd>(x: f64x8<S>) -> mask64x8<S> {
    x.abs().simd_lt(f64x8::splat(x.simd, f64::INFINITY))
}

/// A plane's normal is the same everywhere.
pub(crate) struct Unbent;

impl<S: Simd> LaneBending<S> for Unbent {
    #[inline(always)]
    fn normal_change(&self, moved: LaneVec3<S>) -> LaneVec3<S> {
        let zero = f64x8::splat(moved.x.simd, 0.0);
        LaneVec3::new(zero, zero, zero)
    }
}

impl LaneShape for LanePlane {
    type Bending<S: Simd> = Unbent;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, p: LaneVec3<S>, d: LaneVec3<S>) -> Meeting<S, Unbent> {
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let length = -p.z / d.z;
        Meeting {
            length,
            // Zero, but for rays that are not there.
            hit: p.plus(d.times(length)).with_z(length * 0.0),
            normal: LaneVec3::new(zero, zero, one),
            square: one,
            along: d.z,
            met: finite(length),
            bending: Unbent,
        }
    }
}

/// The normal of a conic is linear in the point.
pub(crate) struct ConicBending(Conic);

impl<S: Simd> LaneBending<S> for ConicBending {
    #[inline(always)]
    fn normal_change(&self, moved: LaneVec3<S>) -> LaneVec3<S> {
        let Conic { curvature, conic } = self.0;
        let turned = moved.scaled(-curvature);
        turned.with_z(turned.z * (1.0 + conic))
    }
}

impl<const SPHERE: bool> LaneShape for LaneConic<SPHERE> {
    type Bending<S: Simd> = ConicBending;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, p: LaneVec3<S>, d: LaneVec3<S>) -> Meeting<S, ConicBending> {
        // As for single rays (`Conic::meet`). The root of the discriminant is the product of the direction with the normal
        // (−cx, −cy, 1 − (1+κ)cz).
        let Conic { curvature, conic } = self.0;
        let conic = if SPHERE { 0.0 } else { conic };
        let near = -p.dot(d);
        let r = p.plus(d.times(near));
        let a = (d.z * d.z * conic + 1.0) * curvature;
        let b = (r.dot(d) + r.z * d.z * conic) * curvature - d.z;
        let e = (r.dot(r) + r.z * r.z * conic) * curvature - r.z * 2.0;
        let along = (b * b - a * e).sqrt().copysign(d.z);
        let length = e / (along - b);
        let hit = r.plus(d.times(length));
        let up = 1.0 - hit.z * ((1.0 + conic) * curvature);
        let normal = hit.scaled(-curvature).with_z(up);
        let one = f64x8::splat(simd, 1.0);
        Meeting {
            length: near + length,
            hit,
            normal,
            square: if SPHERE { one } else { normal.dot(normal) },
            along,
            met: finite(length) & up.simd_gt(f64x8::splat(simd, 0.0)),
            bending: ConicBending(self.0),
        }
    }
}

/// The normal (−s_x, −s_y, 1) of a height changes with its second derivatives xx, xy, yy.
pub(crate) struct HeightBending<S: Simd>([f64x8<S>; 3]);

impl<S: Simd> Meeting<S, HeightBending<S>> {
    /// Where rays of directions `d` meet a height of these slopes and second derivatives; nowhere where the slope is NaN.
    #[inline(always)]
    pub(crate) fn on_height(
        length: f64x8<S>,
        hit: LaneVec3<S>,
        d: LaneVec3<S>,
        [sx, sy]: [f64x8<S>; 2],
        hessian: [f64x8<S>; 3],
    ) -> Self {
        let normal = LaneVec3::new(-sx, -sy, f64x8::splat(sx.simd, 1.0));
        Self {
            length,
            hit,
            normal,
            square: normal.dot(normal),
            along: normal.dot(d),
            met: finite(sx),
            bending: HeightBending(hessian),
        }
    }
}

impl<S: Simd> LaneBending<S> for HeightBending<S> {
    #[inline(always)]
    fn normal_change(&self, moved: LaneVec3<S>) -> LaneVec3<S> {
        let ([xx, xy, yy], LaneVec3 { x, y, z }) = (self.0, moved);
        LaneVec3::new(
            -(x * xx + y * xy),
            -(x * xy + y * yy),
            f64x8::splat(z.simd, 0.0),
        )
    }
}

impl LaneShape for LaneAny<'_> {
    type Bending<S: Simd> = HeightBending<S>;

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        p: LaneVec3<S>,
        d: LaneVec3<S>,
    ) -> Meeting<S, HeightBending<S>> {
        let [length, sx, sy, xx, xy, yy] = self.meet_each([p.arrays(), d.arrays()]);
        let length = f64x8::simd_from(simd, length);
        let (sx, sy) = (f64x8::simd_from(simd, sx), f64x8::simd_from(simd, sy));
        let xx = f64x8::simd_from(simd, xx);
        let xy = f64x8::simd_from(simd, xy);
        let yy = f64x8::simd_from(simd, yy);
        let hit = p.plus(d.times(length));
        Meeting::on_height(length, hit, d, [sx, sy], [xx, xy, yy])
    }
}

impl LaneAny<'_> {
    /// Distance, slopes and second derivatives for each of eight rays; NaN for those that miss.
    #[inline(never)]
    fn meet_each(&self, [p, d]: [[Lanes; 3]; 2]) -> [Lanes; 6] {
        let mut found = [[f64::NAN; LANES]; 6];
        for i in 0..LANES {
            let (p, d) = (one_of(&p, i), one_of(&d, i));
            if p.x.is_nan() {
                continue;
            }
            let Ok(length) = self.0.meet(p, d) else {
                continue;
            };
            let hit = p + d * length;
            if let Some(h) = self.0.height(hit.x, hit.y) {
                let ([sx, sy], [xx, xy, yy]) = (h.slope, h.hessian);
                for (column, value) in found.iter_mut().zip([length, sx, sy, xx, xy, yy]) {
                    column[i] = value;
                }
            }
        }
        found
    }
}
