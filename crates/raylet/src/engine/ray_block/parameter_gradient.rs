//! Derivatives of a number by parameters of a system, from those by the places, directions and paths of a block's rays.
//!
//! Rays go back part by part. Each part that changes with a parameter adds what it changes there, and hands the derivatives on to the
//! part before. The work does not grow with the number of parameters, but for those of the same part.

use fearless_simd::{Select, Simd, SimdBase, SimdFrom, f64x8};

use crate::engine::ray_block::block::{Column, PACKETS};
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
    /// One for rays that arrive, NaN for others.
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

    /// New rays are on the last part.
    pub(crate) fn restart(&mut self) {
        [self.moved, self.turned] = [[ZERO; 3]; 2];
        [self.longer, self.arrives] = [ZERO, [[f64::NAN; LANES]; PACKETS]];
    }

    /// Ray `i` arrives: derivatives by its x, y, its unit directions along x and y, and its path.
    pub(crate) fn set(&mut self, i: usize, [x, y, p, q, longer]: [f64; 5]) {
        let (at, lane) = (i / LANES, i % LANES);
        for (axis, (place, direction)) in [(x, p), (y, q)].into_iter().enumerate() {
            self.moved[axis][at][lane] = place;
            self.turned[axis][at][lane] = direction;
        }
        self.longer[at][lane] = longer;
        self.arrives[at][lane] = 1.0;
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
