//! Rays, and their Jacobians, from screen to screen.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, dispatch, f64x8};

use crate::engine::ray_block::block::{BLOCK, Packet, RayBlock};
use crate::engine::ray_block::block_step::{LaneCompanion, step};
use crate::engine::ray_block::lane_beamlets::LaneBeamlets;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::prepared_part::PreparedPart;
pub use crate::engine::ray_block::tangents::Jacobian;
use crate::engine::ray_block::tangents::Tangents;
use crate::engine::trace::ray_trace::{Carried, Landing, LocatedScreen, emit_locally};
use crate::math::complex::Symmetric;
use crate::math::lanes::{LANES, Lanes};
use crate::math::simd_level::level;
use crate::optics::ray::Loss;
use crate::optics::screen::Screen;
use crate::optics::system::Hop;

/// Where a ray starts: (x, y) in mm on the first screen, and its optical direction cosines there.
pub type RayStart = [f64; 4];

/// Where a ray lands, or how it is lost.
pub type Traced = Result<Landing, Loss>;

/// A hop made ready for many rays.
pub struct HopRays<'a> {
    from: &'a Screen,
    to: &'a Screen,
    parts: Vec<PreparedPart<'a>>,
    /// The processor's vector instructions.
    pub(crate) level: Level,
}

/// The memory in which a block of rays and their derivatives are traced.
pub(crate) struct JacobianScratch {
    block: RayBlock,
    tangents: Tangents,
}

impl JacobianScratch {
    /// Memory for one block.
    pub(crate) fn new() -> Self {
        Self {
            block: RayBlock::empty(),
            tangents: Tangents::zero(),
        }
    }
}

/// Where many rays land, in columns with an entry for each; those of lost rays hold NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LandingColumns {
    /// Positions along x and y of the screen, in mm.
    pub at: [Vec<f64>; 2],
    /// Optical direction cosines along x and y of the screen.
    pub cosines: [Vec<f64>; 2],
    /// Optical paths from the starts, in mm.
    pub path: Vec<f64>,
    /// Why rays are lost.
    pub lost: Vec<Option<Loss>>,
}

impl LandingColumns {
    /// The columns without entries, and room for these.
    pub(crate) fn restart(&mut self, rays: usize) {
        let Self {
            at: [x, y],
            cosines: [p, q],
            path,
            lost,
        } = self;
        for column in [x, y, p, q, path] {
            column.clear();
            column.reserve(rays);
        }
        lost.clear();
        lost.reserve(rays);
    }

    /// Adds the rays of a block on a screen in a medium of index `n`.
    fn extend(&mut self, block: &RayBlock, rays: usize, n: f64) {
        for axis in 0..2 {
            let positions = block.position[axis].as_flattened();
            let directions = block.direction[axis].as_flattened();
            self.at[axis].extend_from_slice(&positions[..rays]);
            self.cosines[axis].extend(directions[..rays].iter().map(|d| d * n));
        }
        self.path
            .extend_from_slice(&block.path.as_flattened()[..rays]);
        self.lost.extend_from_slice(&block.lost[..rays]);
    }
}

impl<'a> HopRays<'a> {
    /// Through this hop.
    pub fn new(hop: &Hop<'a>) -> Self {
        let mut before = &hop.from.frame;
        let mut parts = Vec::with_capacity(hop.train.len() + 1);
        for surface in hop.train {
            parts.push(PreparedPart::surface(before, surface));
            before = &surface.frame;
        }
        parts.push(PreparedPart::screen(before, hop.to));
        Self {
            from: hop.from,
            to: hop.to,
            parts,
            level: level(),
        }
    }

    /// Where rays land.
    pub fn trace(&self, starts: &[RayStart]) -> Vec<Traced> {
        let mut landings = Vec::with_capacity(starts.len());
        let mut block = RayBlock::empty();
        for group in starts.chunks(BLOCK) {
            self.carry(&mut block, group, &mut ());
            for i in 0..group.len() {
                landings.push(self.landing(&block, i));
            }
        }
        landings
    }

    /// The same in columns, in place of what these hold.
    pub fn trace_into(&self, starts: &[RayStart], landings: &mut LandingColumns) {
        landings.restart(starts.len());
        self.trace_more(starts, landings);
    }

    /// The same behind what the columns hold.
    pub(crate) fn trace_more(&self, starts: &[RayStart], landings: &mut LandingColumns) {
        let mut block = RayBlock::empty();
        for group in starts.chunks(BLOCK) {
            self.carry(&mut block, group, &mut ());
            landings.extend(&block, group.len(), self.to.index);
        }
    }

    /// Where rays from (x, y) land, along each of these optical direction cosines.
    pub fn trace_from(&self, [x, y]: [f64; 2], directions: &[[f64; 2]]) -> Vec<Traced> {
        let starts: Vec<RayStart> = directions.iter().map(|[p, q]| [x, y, *p, *q]).collect();
        self.trace(&starts)
    }

    /// Where rays land, with their Jacobians.
    pub fn jacobians(&self, starts: &[RayStart]) -> Vec<Result<(Landing, Jacobian), Loss>> {
        let mut found = Vec::with_capacity(starts.len());
        self.jacobians_into(starts, &mut JacobianScratch::new(), &mut found);
        found
    }

    /// The same in place of what `found` holds, for many calls with few rays.
    pub(crate) fn jacobians_into(
        &self,
        starts: &[RayStart],
        scratch: &mut JacobianScratch,
        found: &mut Vec<Result<(Landing, Jacobian), Loss>>,
    ) {
        found.clear();
        let JacobianScratch { block, tangents } = scratch;
        for group in starts.chunks(BLOCK) {
            self.carry(block, group, tangents);
            for i in 0..group.len() {
                let (landing, n) = (self.landing(block, i), self.to.index);
                found.push(landing.map(|landing| (landing, tangents.jacobian(i, n))));
            }
        }
    }

    /// Where beamlets land that start along these rays with curvature `q` in 1/mm: as [`Hop::carry_beamlet`]. Both screens
    /// must be planes.
    pub fn carry_beamlets(
        &self,
        q: Symmetric<f64>,
        starts: &[RayStart],
    ) -> Vec<Result<Carried, Loss>> {
        let mut carried = Vec::with_capacity(starts.len());
        let (mut block, mut beamlets) = (RayBlock::empty(), LaneBeamlets::new(q));
        for group in starts.chunks(BLOCK) {
            self.carry(&mut block, group, &mut beamlets);
            for i in 0..group.len() {
                carried.push(self.landing(&block, i).map(|landing| {
                    let (amplitude, curvature) = beamlets.landed(i, self.to.index);
                    Carried {
                        landing,
                        amplitude,
                        curvature,
                    }
                }));
            }
        }
        carried
    }

    /// A block of rays from the first screen to the second.
    fn carry(&self, block: &mut RayBlock, starts: &[RayStart], companion: &mut impl LaneCompanion) {
        block.restart();
        for (i, start) in starts.iter().enumerate() {
            block.start(i, *start);
        }
        dispatch!(self.level, simd => {
            launch(simd, self.from, block, companion);
            for part in &self.parts {
                step(simd, block, part, companion);
                block.forget();
            }
        });
    }

    #[inline(always)]
    fn landing(&self, block: &RayBlock, i: usize) -> Traced {
        if let Some(loss) = block.lost[i] {
            return Err(loss);
        }
        let (at, lane, n) = (i / LANES, i % LANES, self.to.index);
        let [x, y, _] = &block.position;
        let [p, q, _] = &block.direction;
        Ok(Landing {
            at: [x[at][lane], y[at][lane]],
            cosines: [p[at][lane] * n, q[at][lane] * n],
            path: block.path[at][lane],
        })
    }
}

/// Lets the rays of a block leave a screen, from where [`RayBlock::start`] puts them.
#[inline(always)]
fn launch<S: Simd>(
    simd: S,
    from: &Screen,
    block: &mut RayBlock,
    companion: &mut impl LaneCompanion,
) {
    let n = from.index_behind();
    let zero = f64x8::splat(simd, 0.0);
    for at in 0..block.packets() {
        // Those that leave a plane go together.
        let mut slope = [zero; 2];
        if from.is_plane() {
            let start = block.packet(simd, at);
            let (p, q) = (start.direction.x, start.direction.y);
            let under = n * n - (p * p + q * q);
            let direction = LaneVec3::new(p, q, under.sqrt() * from.leaves()).scaled(1.0 / n);
            let ray = Packet {
                position: start.position.with_z(zero),
                direction,
                ..start
            };
            block.put(at, &ray);
            if !under.simd_gt(zero).all_true() {
                lose_evanescent(block, at);
            }
        } else {
            let [sx, sy] = launch_each(from, block, at);
            slope = [f64x8::simd_from(simd, sx), f64x8::simd_from(simd, sy)];
        }
        companion.launch(at, block.packet(simd, at).direction, slope, n);
    }
}

/// Loses those of eight rays that came to no direction.
#[cold]
fn lose_evanescent(block: &mut RayBlock, at: usize) {
    for lane in 0..LANES {
        let along = block.direction[2][at][lane];
        if (along.is_nan() || along == 0.0) && !block.path[at][lane].is_nan() {
            block.erase(at * LANES + lane, Loss::Evanescent);
        }
    }
}

/// Eight rays that leave a curved screen, each alone; the slopes of the screen where they do.
#[inline(never)]
fn launch_each(from: &Screen, block: &mut RayBlock, at: usize) -> [Lanes; 2] {
    let located = LocatedScreen::left(from);
    let [mut across, mut up] = [[0.0; LANES]; 2];
    for (lane, (slope_x, slope_y)) in across.iter_mut().zip(&mut up).enumerate() {
        let start = block.ray(at * LANES + lane);
        if start.path.is_nan() {
            continue;
        }
        let (place, p) = (start.position, start.direction);
        match emit_locally(&located, [place.x, place.y], [p.x, p.y]) {
            Ok((ray, [sx, sy])) => {
                block.set(at * LANES + lane, &ray);
                (*slope_x, *slope_y) = (sx, sy);
            }
            Err(loss) => block.erase(at * LANES + lane, loss),
        }
    }
    [across, up]
}
