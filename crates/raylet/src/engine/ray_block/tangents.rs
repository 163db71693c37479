//! Derivatives of the rays of a block by where and along which cosines they start.
//!
//! `gradients_are_dot_products_with_derivatives` holds the adjoint.

use fearless_simd::{Simd, SimdBase, f64x8};

use crate::engine::ray_block::block::{Column, PACKETS, load, store};
use crate::engine::ray_block::block_step::{LaneCompanion, LaneEncounter};
use crate::engine::ray_block::lane_shape::LaneBending;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::math::lanes::LANES;

/// ∂(s, p′)/∂(x, p), rows (s_x, s_y, p′_x, p′_y).
pub type Jacobian = [[f64; 4]; 4];

/// The changes of positions and directions of a block's rays with each of the four numbers of their starts.
pub(crate) struct Tangents {
    moved: [[Column; 3]; 4],
    turned: [[Column; 3]; 4],
}

impl Tangents {
    /// None of them.
    pub(crate) fn zero() -> Self {
        Self {
            moved: [[[[0.0; LANES]; PACKETS]; 3]; 4],
            turned: [[[[0.0; LANES]; PACKETS]; 3]; 4],
        }
    }

    /// The Jacobian of ray `i` on a screen in a medium of index `n`.
    #[inline(always)]
    pub(crate) fn jacobian(&self, i: usize, n: f64) -> Jacobian {
        let (at, lane) = (i / LANES, i % LANES);
        let mut jacobian = [[0.0; 4]; 4];
        let variables = self.moved.iter().zip(&self.turned).enumerate();
        for (variable, (moved, turned)) in variables {
            for axis in 0..2 {
                jacobian[axis][variable] = moved[axis][at][lane];
                jacobian[2 + axis][variable] = turned[axis][at][lane] * n;
            }
        }
        jacobian
    }
}

impl LaneCompanion for Tangents {
    #[inline(always)]
    fn launch<S: Simd>(&mut self, at: usize, d: LaneVec3<S>, slope: [f64x8<S>; 2], n: f64) {
        let simd = d.x.simd;
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let (nothing, step) = (LaneVec3::new(zero, zero, zero), one / n);
        let [sx, sy] = slope;
        store(&mut self.moved[0], at, LaneVec3::new(one, zero, sx));
        store(&mut self.moved[1], at, LaneVec3::new(zero, one, sy));
        store(
            &mut self.turned[2],
            at,
            LaneVec3::new(step, zero, -d.x / d.z * step),
        );
        store(
            &mut self.turned[3],
            at,
            LaneVec3::new(zero, step, -d.y / d.z * step),
        );
        for start in 0..2 {
            store(&mut self.turned[start], at, nothing);
            store(&mut self.moved[2 + start], at, nothing);
        }
    }

    #[inline(always)]
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, at: usize, encounter: &LaneEncounter<S, C>) {
        let shorter = -1.0 / encounter.meeting.along;
        for (moved, turned) in self.moved.iter_mut().zip(&mut self.turned) {
            carry_tangent(at, encounter, shorter, [moved, turned]);
        }
    }
}

/// Carries the changes of positions and directions of eight rays, the `at`-th of a block, through a part; `shorter` is −1/(N·d).
/// Returns how much longer their ways to it become.
#[inline(always)]
pub(crate) fn carry_tangent<S: Simd, C: LaneBending<S>>(
    at: usize,
    encounter: &LaneEncounter<S, C>,
    shorter: f64x8<S>,
    [moved, turned]: [&mut [Column; 3]; 2],
) -> f64x8<S> {
    let LaneEncounter {
        passage,
        bend,
        direction,
        meeting,
        bent,
        ..
    } = *encounter;
    let simd = direction.x.simd;
    // The point moves along the part: N·δp = 0.
    let (before, start) = (load(simd, turned, at), load(simd, moved, at));
    let (before, start) = (passage.directions(before), passage.directions(start));
    let beside = start.plus(before.times(meeting.length));
    let longer = meeting.normal.dot(beside) * shorter;
    let along = beside.plus(direction.times(longer));
    let normal = meeting.bending.normal_change(along);
    let behind = bend.change(direction, meeting, bent, [normal, before]);
    store(moved, at, along);
    store(turned, at, behind);
    longer
}

/// Derivatives by what happens to eight rays at a part, on its axes.
pub(crate) struct PartDerivatives<S: Simd> {
    /// By the places from which they come.
    pub place: LaneVec3<S>,
    /// By the directions in which they come.
    pub turned: LaneVec3<S>,
    /// By F of the shape F = 0, whose gradient is the normal.
    pub raised: f64x8<S>,
    /// By the normal.
    pub normal: LaneVec3<S>,
    /// By the directions behind it.
    pub behind: LaneVec3<S>,
}

/// Carries derivatives by the positions and directions of eight rays, the `at`-th of a block, back through a part;
/// `shorter` is −1/(N·d), and `longer` the derivatives by the lengths of their ways to it.
#[inline(always)]
pub(crate) fn carry_tangent_adjoint<S: Simd, C: LaneBending<S>>(
    at: usize,
    encounter: &LaneEncounter<S, C>,
    shorter: f64x8<S>,
    [moved, turned]: [&mut [Column; 3]; 2],
    longer: f64x8<S>,
) -> PartDerivatives<S> {
    let LaneEncounter {
        passage,
        bend,
        direction,
        meeting,
        bent,
        ..
    } = *encounter;
    let simd = direction.x.simd;
    let (along, behind) = (load(simd, moved, at), load(simd, turned, at));
    let [normal, before] = bend.change_adjoint(direction, meeting, bent, behind);
    let along = along.plus(meeting.bending.normal_change(normal));
    let raised = (longer + direction.dot(along)) * shorter;
    let beside = along.plus(meeting.normal.times(raised));
    let before = before.plus(beside.times(meeting.length));
    store(moved, at, passage.directions_adjoint(beside));
    store(turned, at, passage.directions_adjoint(before));
    PartDerivatives {
        place: beside,
        turned: before,
        raised,
        normal,
        behind,
    }
}
