//! Derivatives of the rays of a block by parameters of a system.
//!
//! A derivative begins at each part that changes with its parameter. Behind it it is carried like any tangent.

use fearless_simd::{Simd, SimdBase, SimdFrom, f64x8};

use crate::engine::ray_block::block::{Column, PACKETS, load, store};
use crate::engine::ray_block::block_step::{LaneCompanion, LaneEncounter};
use crate::engine::ray_block::lane_shape::LaneBending;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::part_change::{Beginning, PartChange};
use crate::engine::ray_block::tangents::carry_tangent;
use crate::math::lanes::LANES;

/// The changes of a block's rays with one parameter.
#[derive(Clone)]
struct Tangent {
    /// Whether a part that they have passed changes with it.
    begun: bool,
    moved: [Column; 3],
    turned: [Column; 3],
    longer: Column,
}

/// The changes of a block's rays with all parameters.
pub(crate) struct ParameterTangents<'a> {
    tangents: Vec<Tangent>,
    /// Those of the part that the rays come to next.
    changes: &'a [PartChange<'a>],
}

impl<'a> ParameterTangents<'a> {
    /// Of so many parameters.
    pub(crate) fn new(parameters: usize) -> Self {
        let zero: Column = [[0.0; LANES]; PACKETS];
        let none = Tangent {
            begun: false,
            moved: [zero; 3],
            turned: [zero; 3],
            longer: zero,
        };
        Self {
            tangents: vec![none; parameters],
            changes: &[],
        }
    }

    /// New rays start, which change with no parameter.
    pub(crate) fn restart(&mut self) {
        self.changes = &[];
        self.tangents
            .iter_mut()
            .for_each(|tangent| tangent.begun = false);
    }

    /// The rays come to a part that changes so.
    pub(crate) fn come_to(&mut self, changes: &'a [PartChange<'a>]) {
        for change in std::mem::replace(&mut self.changes, changes) {
            self.tangents[change.parameter].begun = true;
        }
    }

    /// The changes of x, y, of the unit directions along x and y, and of the paths of all rays with a parameter.
    pub(crate) fn of(&self, parameter: usize) -> [&Column; 5] {
        const ZERO: Column = [[0.0; LANES]; PACKETS];
        let Tangent {
            begun,
            moved: [x, y, _],
            turned: [p, q, _],
            longer,
        } = &self.tangents[parameter];
        match begun {
            true => [x, y, p, q, longer],
            false => [&ZERO; 5],
        }
    }
}

impl LaneCompanion for ParameterTangents<'_> {
    #[inline(always)]
    fn launch<S: Simd>(&mut self, _: usize, _: LaneVec3<S>, _: [f64x8<S>; 2], _: f64) {}

    #[inline(always)]
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, at: usize, encounter: &LaneEncounter<S, C>) {
        let simd = encounter.direction.x.simd;
        let shorter = -1.0 / encounter.meeting.along;
        for tangent in self.tangents.iter_mut().filter(|tangent| tangent.begun) {
            let pair = [&mut tangent.moved, &mut tangent.turned];
            let longer = carry_tangent(at, encounter, shorter, pair) * encounter.index;
            tangent.longer[at] = *(f64x8::simd_from(simd, tangent.longer[at]) + longer).as_array();
        }
        for change in self.changes {
            let beginning = change.begin(encounter, shorter);
            let tangent = &mut self.tangents[change.parameter];
            match tangent.begun {
                true => tangent.add(simd, at, &beginning),
                false => tangent.begin(at, &beginning),
            }
        }
    }
}

impl Tangent {
    /// Takes what begins at the first part that changes.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, at: usize, beginning: &Beginning<S>) {
        store(&mut self.moved, at, beginning.moved);
        store(&mut self.turned, at, beginning.turned);
        self.longer[at] = *beginning.longer.as_array();
    }

    /// Adds what begins at another part.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, at: usize, beginning: &Beginning<S>) {
        let sum = Beginning {
            moved: load(simd, &self.moved, at).plus(beginning.moved),
            turned: load(simd, &self.turned, at).plus(beginning.turned),
            longer: f64x8::simd_from(simd, self.longer[at]) + beginning.longer,
        };
        self.begin(at, &sum);
    }
}
