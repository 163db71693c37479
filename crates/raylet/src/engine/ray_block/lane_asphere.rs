//! Where eight rays meet a conic with powers of the radius.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, f64x8, mask64x8};

use crate::engine::ray_block::lane_shape::{HeightBending, LaneConic, LaneShape, Meeting};
use crate::engine::ray_block::lane_vec3::{LaneVec3, one_of};
use crate::math::lanes::{LANES, Lanes};
use crate::optics::conic::Conic;
use crate::optics::freeform::Term;
use crate::optics::shape::Shape;

/// A conic with powers of the radius.
pub(crate) struct LaneAsphere<'a> {
    /// The conic.
    pub base: Conic,
    /// The powers.
    pub powers: LanePowers<'a>,
    /// The same shape, for rays that have to search.
    pub shape: &'a Shape,
}

/// Powers of the radius that are added to a conic.
#[derive(Clone, Copy)]
pub(crate) enum LanePowers<'a> {
    /// Coefficients of r⁴, r⁶, r⁸, …
    Even(&'a [f64]),
    /// Coefficients of r, r², r³, …
    All(&'a [f64]),
}

/// A height that depends on u = r² alone, with its derivatives by u.
struct RoundHeight<S: Simd> {
    z: f64x8<S>,
    first: f64x8<S>,
    second: f64x8<S>,
}

impl LanePowers<'_> {
    #[inline(always)]
    fn height<S: Simd>(self, simd: S, u: f64x8<S>) -> RoundHeight<S> {
        let zero = f64x8::splat(simd, 0.0);
        let mut sum = RoundHeight {
            z: zero,
            first: zero,
            second: zero,
        };
        match self {
            LanePowers::Even(coefficients) => {
                for a in coefficients.iter().rev().copied().chain([0.0, 0.0]) {
                    sum.second = sum.second * u + sum.first * 2.0;
                    sum.first = sum.first * u + sum.z;
                    sum.z = sum.z * u + a;
                }
            }
            LanePowers::All(coefficients) => {
                // d/du is (1/2r) d/dr. At the tip that an r term makes the slope counts as zero.
                let r = u.sqrt();
                let inverse = r.simd_gt(zero).select(1.0 / r, zero);
                for (i, a) in coefficients.iter().enumerate().rev() {
                    let power = (i + 1) as f64;
                    sum.z = (sum.z + *a) * r;
                    if power >= 2.0 {
                        sum.first = sum.first * r + 0.5 * power * a;
                    }
                    if power >= 3.0 {
                        sum.second = sum.second * r + 0.25 * power * (power - 2.0) * a;
                    }
                }
                let tip = inverse * (0.5 * coefficients.first().copied().unwrap_or(0.0));
                sum.first += tip;
                sum.second = sum.second * inverse - tip * inverse * inverse * 0.5;
            }
        }
        sum
    }
}

/// Steps of Newton's method at most.
const STEPS: usize = 12;

/// Steps this small in mm are the last: what they leave is of the order of their squares.
const LAST_STEP: f64 = 1e-8;

impl<'a> LaneAsphere<'a> {
    /// A shape that is a conic with powers of the radius; nothing for others.
    pub(crate) fn of(shape: &'a Shape) -> Option<Self> {
        let (base, powers) = match shape {
            Shape::Asphere { base, coefficients } => (base, LanePowers::Even(coefficients)),
            Shape::Freeform { base, terms } => match &terms[..] {
                [Term::Powers(coefficients)] => (base, LanePowers::All(coefficients)),
                _ => return None,
            },
            _ => return None,
        };
        Some(Self {
            base: *base,
            powers,
            shape,
        })
    }

    #[inline(always)]
    fn height<S: Simd>(&self, simd: S, u: f64x8<S>) -> RoundHeight<S> {
        let Conic { curvature, conic } = self.base;
        let k = (1.0 + conic) * curvature * curvature;
        let root = (u * -k + 1.0).sqrt();
        let below = root + 1.0;
        let both = 1.0 / (root * below);
        let inverse = both * below;
        let powers = self.powers.height(simd, u);
        RoundHeight {
            z: u * root * both * curvature + powers.z,
            first: inverse * (0.5 * curvature) + powers.first,
            second: inverse * inverse * inverse * (0.25 * curvature * k) + powers.second,
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
        let hessian = [slope + x * x * twice, x * y * twice, slope + y * y * twice];
        Meeting::on_height(length, hit, d, [x * slope, y * slope], hessian)
    }
}
