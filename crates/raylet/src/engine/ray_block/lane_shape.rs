//! Where eight rays meet a shape, and its normal there.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, f64x8, mask64x8};

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
    /// The change of the normal where the point moves along the shape.
    fn normal_change(&self, moved: LaneVec3<S>) -> LaneVec3<S>;
}

/// z = 0.
pub(crate) struct LanePlane;

/// A conic; a sphere where `SPHERE`.
pub(crate) struct LaneConic<const SPHERE: bool>(pub Conic);

/// A conic with even powers of the radius.
pub(crate) struct LaneAsphere<'a> {
    /// The conic.
    pub base: Conic,
    /// Coefficients of r⁴, r⁶, …
    pub coefficients: &'a [f64],
    /// The same shape, for rays that have to search.
    pub shape: &'a Shape,
}

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

/// A height that depends on u = r² alone, with its derivatives by u.
struct RoundHeight<S: Simd> {
    z: f64x8<S>,
    first: f64x8<S>,
    second: f64x8<S>,
}

/// Steps of Newton's method at most.
const STEPS: usize = 12;

/// Steps this small in mm are the last: what they leave is of the order of their squares.
const LAST_STEP: f64 = 1e-8;

impl LaneAsphere<'_> {
    #[inline(always)]
    fn height<S: Simd>(&self, simd: S, u: f64x8<S>) -> RoundHeight<S> {
        let Conic { curvature, conic } = self.base;
        let k = (1.0 + conic) * curvature * curvature;
        let root = (u * -k + 1.0).sqrt();
        let below = root + 1.0;
        let both = 1.0 / (root * below);
        let inverse = both * below;
        let zero = f64x8::splat(simd, 0.0);
        let (mut f, mut df, mut ddf) = (zero, zero, zero);
        for a in self.coefficients.iter().rev().copied().chain([0.0, 0.0]) {
            ddf = ddf * u + df * 2.0;
            df = df * u + f;
            f = f * u + a;
        }
        RoundHeight {
            z: u * root * both * curvature + f,
            first: inverse * (0.5 * curvature) + df,
            second: inverse * inverse * inverse * (0.25 * curvature * k) + ddf,
        }
    }

    /// Distances of rays for which whole steps do not lead to the shape: one by one. NaN where they miss it.
    #[cold]
    #[inline(never)]
    fn search(&self, lengths: &mut Lanes, which: u64, [p, d]: [[Lanes; 3]; 2]) {
        for i in (0..LANES).filter(|i| which >> i & 1 == 1) {
            let found = self.shape.meet(one_of(&p, i), one_of(&d, i));
            lengths[i] = found.unwrap_or(f64::NAN);
        }
    }
}

impl LaneShape for LaneAsphere<'_> {
    type Bending<S: Simd> = HeightBending<S>;

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        p: LaneVec3<S>,
        d: LaneVec3<S>,
    ) -> Meeting<S, HeightBending<S>> {
        // From where a ray meets the conic, by Newton's method. Each step must bring it nearer.
        let last = f64x8::splat(simd, LAST_STEP);
        let mut length = LaneConic::<false>(self.base).meet(simd, p, d).length;
        let mut before = f64x8::splat(simd, f64::INFINITY);
        let (mut lost, mut going) = (mask64x8::splat(simd, false), mask64x8::splat(simd, true));
        let alive = p.x.simd_eq(p.x);
        for _ in 0..STEPS {
            let at = p.plus(d.times(length));
            let h = self.height(simd, at.x * at.x + at.y * at.y);
            let apart = at.z - h.z;
            let slope = d.z - h.first * 2.0 * (at.x * d.x + at.y * d.y);
            lost |= going & !apart.abs().simd_lt(before);
            before = going.select(apart.abs(), before);
            let step = going.select(apart / slope, f64x8::splat(simd, 0.0));
            length -= step;
            going = going & alive & !lost & !step.abs().simd_le(last);
            if !going.any_true() {
                break;
            }
        }

        // The others search, each alone.
        let search = alive & (lost | going);
        if search.any_true() {
            let mut lengths = *length.as_array();
            self.search(&mut lengths, search.to_bitmask(), [p.arrays(), d.arrays()]);
            length = f64x8::simd_from(simd, lengths);
        }
        self.met_at(simd, p, d, length)
    }
}

impl LaneAsphere<'_> {
    /// The meeting at these distances.
    #[inline(always)]
    fn met_at<S: Simd>(
        &self,
        simd: S,
        p: LaneVec3<S>,
        d: LaneVec3<S>,
        length: f64x8<S>,
    ) -> Meeting<S, HeightBending<S>> {
        let hit = p.plus(d.times(length));
        let (x, y) = (hit.x, hit.y);
        let h = self.height(simd, x * x + y * y);
        let (slope, twice) = (h.first * 2.0, h.second * 4.0);
        let normal = LaneVec3::new(-(x * slope), -(y * slope), f64x8::splat(simd, 1.0));
        Meeting {
            length,
            hit,
            normal,
            square: normal.dot(normal),
            along: normal.dot(d),
            met: finite(slope),
            bending: HeightBending([slope + x * x * twice, x * y * twice, slope + y * y * twice]),
        }
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
        let normal = LaneVec3::new(-sx, -sy, f64x8::splat(simd, 1.0));
        Meeting {
            length,
            hit: p.plus(d.times(length)),
            normal,
            square: normal.dot(normal),
            along: normal.dot(d),
            met: finite(sx),
            bending: HeightBending([xx, xy, yy]),
        }
    }
}

impl LaneAny<'_> {
    /// Distance, slopes and second derivatives for each of eight rays; NaN for those that miss.
    #[inline(never)]
    fn meet_each(&self, [p, d]: [[Lanes; 3]; 2]) -> [Lanes; 6] {
        let mut found = [[f64::NAN; LANES]; 6];
        for i in 0..LANES {
            let (p, d) = (one_of(&p, i), one_of(&d, i));
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
