//! A block through one part.

use fearless_simd::{Simd, SimdBase, SimdMask, f64x8, mask64x8};

use crate::engine::ray_block::bend::{Bend, Bent};
use crate::engine::ray_block::block::{Packet, RayBlock};
use crate::engine::ray_block::lane_asphere::LaneAsphere;
use crate::engine::ray_block::lane_shape::{
    LaneAny, LaneBending, LaneConic, LanePlane, LaneShape, Meeting,
};
use crate::engine::ray_block::lane_vec3::{LaneVec3, one_of};
use crate::engine::ray_block::passage::Passage;
use crate::engine::ray_block::prepared_part::{Edge, PreparedPart};
use crate::math::lanes::{LANES, Lanes};
use crate::optics::ray::Loss;
use crate::optics::refraction::Coating;
use crate::optics::shape::Shape;

/// Eight rays at a part.
pub(crate) struct LaneEncounter<'a, S: Simd, C> {
    /// They themselves, on the axes of the part before.
    pub before: &'a Packet<S>,
    /// How they came from these axes.
    pub passage: &'a Passage,
    /// Refractive index before the part.
    pub index: f64,
    /// What the part does to them.
    pub bend: Bend,
    /// How much of the field it transmits, if it refracts.
    pub coating: Coating,
    /// Their directions before, on the axes of the part.
    pub direction: LaneVec3<S>,
    /// Where they meet it.
    pub meeting: &'a Meeting<S, C>,
    /// Their directions behind.
    pub bent: &'a Bent<S>,
}

/// What goes with the rays of a block, such as their derivatives.
pub(crate) trait LaneCompanion {
    /// Eight rays, the `at`-th of the block, leave a screen with directions `d` into a medium of index `n`, where the screen
    /// has a slope; on its axes.
    fn launch<S: Simd>(&mut self, at: usize, d: LaneVec3<S>, slope: [f64x8<S>; 2], n: f64);
    /// Eight rays, the `at`-th of the block, are at a part.
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, at: usize, encounter: &LaneEncounter<S, C>);
}

/// Nothing goes with the rays.
impl LaneCompanion for () {
    #[inline(always)]
    fn launch<S: Simd>(&mut self, _: usize, _: LaneVec3<S>, _: [f64x8<S>; 2], _: f64) {}
    #[inline(always)]
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, _: usize, _: &LaneEncounter<S, C>) {}
}

/// Takes the rays of a block to a part, on its axes, and through it.
#[inline(always)]
pub(crate) fn step<S: Simd>(
    simd: S,
    block: &mut RayBlock,
    part: &PreparedPart,
    companion: &mut impl LaneCompanion,
) {
    match part.shape {
        Shape::Plane => through(simd, block, part, &LanePlane, companion),
        Shape::Conic(conic) if conic.conic == 0.0 => {
            through(simd, block, part, &LaneConic::<true>(*conic), companion);
        }
        Shape::Conic(conic) => {
            through(simd, block, part, &LaneConic::<false>(*conic), companion);
        }
        shape => match LaneAsphere::of(shape) {
            Some(asphere) => through(simd, block, part, &asphere, companion),
            None => through(simd, block, part, &LaneAny(shape), companion),
        },
    }
}

#[inline(always)]
fn through<S: Simd, L: LaneShape>(
    simd: S,
    block: &mut RayBlock,
    part: &PreparedPart,
    shape: &L,
    companion: &mut impl LaneCompanion,
) {
    for at in 0..block.packets() {
        // Meet the part on its axes.
        let ray = block.packet(simd, at);
        let p = part.passage.points(ray.position);
        let d = part.passage.directions(ray.direction);
        let meeting = shape.meet(simd, p, d);
        let arrives = match part.arrives {
            Some(sign) => (d.z * sign).simd_gt(f64x8::splat(simd, 0.0)),
            None => mask64x8::splat(simd, true),
        };
        let inside = part.edge.contains(meeting.hit.x, meeting.hit.y);

        // Bend.
        let bent = part.bend.bend(d, &meeting);
        let encounter = LaneEncounter {
            before: &ray,
            passage: &part.passage,
            index: part.index,
            bend: part.bend,
            coating: part.coating,
            direction: d,
            meeting: &meeting,
            bent: &bent,
        };
        companion.follow(at, &encounter);
        block.put(
            at,
            &Packet {
                position: meeting.hit,
                direction: bent.direction,
                path: ray.path + meeting.length * part.index,
            },
        );

        // Lost rays are rare.
        let alive = ray.path.simd_eq(ray.path);
        let met = meeting.met & arrives;
        if (alive & !(met & inside & bent.goes_on)).any_true() {
            let masks = [
                alive.to_bitmask(),
                met.to_bitmask(),
                inside.to_bitmask(),
                bent.goes_on.to_bitmask(),
            ];
            lose(block, at, part, masks, [p.arrays(), d.arrays()]);
        }
    }
}

/// Loses the rays of a block that are outside an edge; their numbers stay until [`RayBlock::forget`].
#[inline(always)]
pub(crate) fn clip<S: Simd>(simd: S, block: &mut RayBlock, edge: &Edge) {
    for at in 0..block.packets() {
        let ray = block.packet(simd, at);
        let alive = ray.path.simd_eq(ray.path);
        let outside = alive & !edge.contains(ray.position.x, ray.position.y);
        if outside.any_true() {
            let outside = outside.to_bitmask();
            for lane in (0..LANES).filter(|lane| outside >> lane & 1 == 1) {
                block.lose(at * LANES + lane, Loss::Clipped);
            }
        }
    }
}

/// Loses those of eight rays that came but did not meet the part, met it outside, or do not go on; totally reflected ones
/// keep the direction in which they came.
#[cold]
#[inline(never)]
fn lose(
    block: &mut RayBlock,
    at: usize,
    part: &PreparedPart,
    [alive, met, inside, goes_on]: [u64; 4],
    [p, d]: [[Lanes; 3]; 2],
) {
    for lane in (0..LANES).filter(|lane| alive >> lane & 1 == 1) {
        let has = |mask: u64| mask >> lane & 1 == 1;
        let i = at * LANES + lane;
        if !has(met) {
            let reason = part.shape.meet(one_of(&p, lane), one_of(&d, lane)).err();
            block.erase(i, reason.unwrap_or(Loss::Missed));
        } else if !has(inside) {
            block.erase(i, Loss::Clipped);
        } else if !has(goes_on) {
            for (behind, before) in block.direction.iter_mut().zip(&d) {
                behind[at][lane] = before[lane];
            }
            block.lose(i, Loss::TotalReflection);
        }
    }
}
