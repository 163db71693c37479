//! Derivatives of a number by parameters of a system, from those by the places, directions and paths of a block's rays.
//!
//! Rays go back part by part. Each part that changes with a parameter adds what it changes there, and hands the derivatives on to the
//! part before. The work does not grow with the number of parameters, but for those of the same part.

use fearless_simd::{Select, Simd, SimdBase, SimdFrom, f64x8};

use crate::engine::ray_block::block::{Column, PACKETS, RayBlock};
use crate::engine::ray_block::block_step::{LaneCompanion, LaneEncounter};
use crate::engine::ray_block::lane_shape::LaneBending;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::part_change::PartChange;
use crate::engine::ray_block::tangents::carry_tangent_adjoint;
use crate::math::lanes::{LANES, Lanes};

/// The derivatives of a number by a block's rays where they are, and by all parameters of parts behind.
pub(crate) struct ParameterGradient<'a> {
    moved: [Column; 3],
    turned: [Column; 3],
    longer: Column,
    /// Paths of rays that arrive, NaN for others.
    arrives: Column,
    /// Those of the part that the rays go back through next.
    changes: &'a [PartChange<'a>],
    /// Sums over the rays of the same lane, for each parameter.
    sums: Vec<Lanes>,
}

const ZERO: Column = [[0.0; LANES]; PACKETS];

impl<'a> ParameterGradient<'a> {
    /// Of so many parameters.
    pub(crate) fn new(parameters: usize) -> Self {
        Self {
            moved: [ZERO; 3],
            turned: [ZERO; 3],
            longer: ZERO,
            arrives: ZERO,
            changes: &[],
            sums: vec![[0.0; LANES]; parameters],
        }
    }

    /// The rays of a block are on the last part, in a medium of index `n`: derivatives by their x, y, cosines along x and y, and
    /// paths.
    pub(crate) fn land(&mut self, block: &RayBlock, by_rays: [Option<&[f64]>; 5], n: f64) {
        [self.moved[2], self.turned[2]] = [ZERO; 2];
        let [mx, my, _] = &mut self.moved;
        let [tx, ty, _] = &mut self.turned;
        let places = [mx, my, tx, ty, &mut self.longer];
        for ((place, column), by_rays) in places.into_iter().enumerate().zip(by_rays) {
            *column = ZERO;
            // cosines = n·d
            let scale = if matches!(place, 2 | 3) { n } else { 1.0 };
            let numbers = column.as_flattened_mut().iter_mut();
            { numbers.zip(by_rays.unwrap_or_default()) }.for_each(|(to, by)| *to = scale * by);
        }
        self.arrives = block.path;
    }

    /// The rays go back through a part that changes so.
    pub(crate) fn come_to(&mut self, changes: &'a [PartChange<'a>]) {
        self.changes = changes;
    }

    /// Adds to the derivative by a parameter.
    pub(crate) fn add(&mut self, parameter: usize, number: f64) {
        self.sums[parameter][0] += number;
    }

    /// The derivatives by all parameters.
    pub(crate) fn sums(&self) -> Vec<f64> {
        let sums = self.sums.iter();
        sums.map(|lanes| lanes.iter().sum()).collect()
    }
}

impl LaneCompanion for ParameterGradient<'_> {
    #[inline(always)]
    fn launch<S: Simd>(&mut self, _: usize, _: LaneVec3<S>, _: [f64x8<S>; 2], _: f64) {}

    #[inline(always)]
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, at: usize, encounter: &LaneEncounter<S, C>) {
        let simd = encounter.direction.x.simd;
        let shorter = -1.0 / encounter.meeting.along;
        let longer = f64x8::simd_from(simd, self.longer[at]);
        let pair = [&mut self.moved, &mut self.turned];
        let back = carry_tangent_adjoint(at, encounter, shorter, pair, longer * encounter.index);
        let arrives = f64x8::simd_from(simd, self.arrives[at]);
        let (arrives, zero) = (arrives.simd_eq(arrives), f64x8::splat(simd, 0.0));
        for change in self.changes {
            let by_change = arrives.select(change.begin_adjoint(encounter, &back, longer), zero);
            let sum = &mut self.sums[change.parameter];
            *sum = *(f64x8::simd_from(simd, *sum) + by_change).as_array();
        }
    }
}
