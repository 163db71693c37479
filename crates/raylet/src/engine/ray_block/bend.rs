//! Refraction and reflection of eight rays, and of their derivatives.
//!
//! With a normal N of any length, g = N·N, a = d·N and the ratio r of the indices, the direction behind is d′ = r d + Γ N:
//! Γ = (±√(g(1 − r²) + r²a²) − r a)/g behind an interface, with the sign of a, and −2a/g with r = 1 behind a mirror.
//! `gradients_are_dot_products_with_derivatives` holds the adjoint.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f64x8, mask64x8};

use crate::engine::ray_block::lane_shape::Meeting;
use crate::engine::ray_block::lane_vec3::LaneVec3;

/// What a part does to the direction of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bend {
    /// Nothing.
    Pass,
    /// Snell's law, with the index before over the index behind.
    Refract(f64),
    /// The law of reflection.
    Reflect,
}

/// Eight rays behind a part.
pub(crate) struct Bent<S: Simd> {
    /// Their unit directions.
    pub direction: LaneVec3<S>,
    /// Γ.
    pub gamma: f64x8<S>,
    /// The root in Γ, with the sign of a; zero for a mirror.
    pub root: f64x8<S>,
    /// Which of them go on; the others are totally reflected.
    pub goes_on: mask64x8<S>,
}

impl Bend {
    /// Eight rays of unit directions `d` behind the part that they meet.
    #[inline(always)]
    pub(crate) fn bend<S: Simd, C>(self, d: LaneVec3<S>, at: &Meeting<S, C>) -> Bent<S> {
        let simd = d.x.simd;
        let zero = f64x8::splat(simd, 0.0);
        let all = mask64x8::splat(simd, true);
        match self {
            Bend::Pass => Bent {
                direction: d,
                gamma: zero,
                root: zero,
                goes_on: all,
            },
            Bend::Reflect => {
                let gamma = at.along * -2.0 / at.square;
                Bent {
                    direction: d.plus(at.normal.times(gamma)),
                    gamma,
                    root: zero,
                    goes_on: all,
                }
            }
            Bend::Refract(ratio) => {
                let under =
                    at.square * (1.0 - ratio * ratio) + at.along * at.along * (ratio * ratio);
                let root = under.sqrt().copysign(at.along);
                let gamma = (root - at.along * ratio) / at.square;
                Bent {
                    direction: d.scaled(ratio).plus(at.normal.times(gamma)),
                    gamma,
                    root,
                    goes_on: under.simd_gt(zero),
                }
            }
        }
    }

    /// The change of the direction behind, where the normal that a ray meets changes, and its direction.
    #[inline(always)]
    pub(crate) fn change<S: Simd, C>(
        self,
        d: LaneVec3<S>,
        at: &Meeting<S, C>,
        bent: &Bent<S>,
        [normal, turned]: [LaneVec3<S>; 2],
    ) -> LaneVec3<S> {
        let along = turned.dot(at.normal) + d.dot(normal);
        let square = at.normal.dot(normal) * 2.0;
        let (ratio, gamma) = match self {
            Bend::Pass => return turned,
            Bend::Reflect => (1.0, (along * -2.0 - bent.gamma * square) / at.square),
            Bend::Refract(ratio) => {
                let r2 = ratio * ratio;
                let root = (square * (0.5 * (1.0 - r2)) + at.along * along * r2) / bent.root;
                let gamma = (root - along * ratio - bent.gamma * square) / at.square;
                (ratio, gamma)
            }
        };
        let kept = turned.scaled(ratio);
        kept.plus(at.normal.times(gamma))
            .plus(normal.times(bent.gamma))
    }

    /// Derivatives by the normal that a ray meets, and by its direction, from those by its direction behind.
    #[inline(always)]
    pub(crate) fn change_adjoint<S: Simd, C>(
        self,
        d: LaneVec3<S>,
        at: &Meeting<S, C>,
        bent: &Bent<S>,
        behind: LaneVec3<S>,
    ) -> [LaneVec3<S>; 2] {
        let gamma = at.normal.dot(behind) / at.square;
        let square = gamma * bent.gamma * -1.0;
        let (ratio, along, square) = match self {
            Bend::Pass => return [behind.scaled(0.0), behind],
            Bend::Reflect => (1.0, gamma * -2.0, square),
            Bend::Refract(ratio) => {
                let (r2, root) = (ratio * ratio, gamma / bent.root);
                let along = root * at.along * r2 - gamma * ratio;
                (ratio, along, root * (0.5 * (1.0 - r2)) + square)
            }
        };
        let normal = { behind.times(bent.gamma) }
            .plus(d.times(along))
            .plus(at.normal.times(square * 2.0));
        [normal, behind.scaled(ratio).plus(at.normal.times(along))]
    }

    /// The change of the direction behind with the ratio of the indices; zero for what does not refract.
    #[inline(always)]
    pub(crate) fn change_by_ratio<S: Simd, C>(
        self,
        d: LaneVec3<S>,
        at: &Meeting<S, C>,
        bent: &Bent<S>,
    ) -> LaneVec3<S> {
        let Bend::Refract(ratio) = self else {
            return d.scaled(0.0);
        };
        let root = (at.along * at.along - at.square) * ratio / bent.root;
        d.plus(at.normal.times((root - at.along) / at.square))
    }
}
