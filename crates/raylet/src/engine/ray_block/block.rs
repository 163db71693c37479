//! Rays in columns, and what became of them.

use fearless_simd::{Simd, SimdBase, SimdFrom, f64x8};

use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::math::lanes::{LANES, Lanes};
use crate::math::vec3::Vec3;
use crate::optics::ray::{Loss, Ray};

/// Vectors of eight rays in a block: its columns stay in the first cache.
pub(crate) const PACKETS: usize = 16;

/// Rays of a block.
pub(crate) const BLOCK: usize = PACKETS * LANES;

/// A column of a block.
pub(crate) type Column = [Lanes; PACKETS];

/// Eight vectors from three columns.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, columns: &[Column; 3], at: usize) -> LaneVec3<S> {
    LaneVec3::new(
        f64x8::simd_from(simd, columns[0][at]),
        f64x8::simd_from(simd, columns[1][at]),
        f64x8::simd_from(simd, columns[2][at]),
    )
}

/// Eight vectors into three columns.
#[inline(always)]
pub(crate) fn store<S: Simd>(columns: &mut [Column; 3], at: usize, vectors: LaneVec3<S>) {
    columns[0][at] = *vectors.x.as_array();
    columns[1][at] = *vectors.y.as_array();
    columns[2][at] = *vectors.z.as_array();
}

/// A column of numbers that are not there.
const NOTHING: Column = [[f64::NAN; LANES]; PACKETS];

/// Up to [`BLOCK`] rays on the axes of the part where they are.
#[derive(Clone)]
pub(crate) struct RayBlock {
    /// Positions in mm.
    pub position: [Column; 3],
    /// Unit directions.
    pub direction: [Column; 3],
    /// Optical paths in mm.
    pub path: Column,
    /// Why rays are lost; the columns of a lost ray hold NaN.
    pub lost: [Option<Loss>; BLOCK],
    /// Rays that were lost at the last part.
    pub just_lost: Vec<usize>,
    /// Rays that were set.
    rays: usize,
}

/// Eight rays of a block.
#[derive(Clone, Copy)]
pub(crate) struct Packet<S: Simd> {
    /// Positions in mm.
    pub position: LaneVec3<S>,
    /// Unit directions.
    pub direction: LaneVec3<S>,
    /// Optical paths in mm.
    pub path: f64x8<S>,
}

impl RayBlock {
    /// A block without rays.
    pub(crate) fn empty() -> Self {
        Self {
            position: [NOTHING; 3],
            direction: [NOTHING; 3],
            path: NOTHING,
            lost: [None; BLOCK],
            just_lost: Vec::new(),
            rays: 0,
        }
    }

    /// The same block without rays.
    pub(crate) fn restart(&mut self) {
        // A ray without a place or path is not there.
        self.position[0] = NOTHING;
        self.path = NOTHING;
        self.just_lost.clear();
        self.rays = 0;
    }

    /// Becomes a copy of another block.
    pub(crate) fn copy(&mut self, other: &Self) {
        self.position = other.position;
        self.direction = other.direction;
        (self.path, self.lost, self.rays) = (other.path, other.lost, other.rays);
        self.just_lost.clone_from(&other.just_lost);
    }

    /// How many rays it has, lost ones among them.
    #[inline(always)]
    pub(crate) fn rays(&self) -> usize {
        self.rays
    }

    /// Vectors that hold its rays.
    #[inline(always)]
    pub(crate) fn packets(&self) -> usize {
        self.rays.div_ceil(LANES).min(PACKETS)
    }

    /// Eight of its rays.
    #[inline(always)]
    pub(crate) fn packet<S: Simd>(&self, simd: S, at: usize) -> Packet<S> {
        Packet {
            position: load(simd, &self.position, at),
            direction: load(simd, &self.direction, at),
            path: f64x8::simd_from(simd, self.path[at]),
        }
    }

    /// Puts eight rays back.
    #[inline(always)]
    pub(crate) fn put<S: Simd>(&mut self, at: usize, packet: &Packet<S>) {
        store(&mut self.position, at, packet.position);
        store(&mut self.direction, at, packet.direction);
        self.path[at] = *packet.path.as_array();
    }

    /// Sets the first `rays` of eight rays as those from number `first` on, a multiple of eight.
    #[inline(always)]
    pub(crate) fn put_new<S: Simd>(&mut self, first: usize, rays: usize, packet: &Packet<S>) {
        let at = first / LANES;
        self.put(at, packet);
        self.path[at][rays..].fill(f64::NAN);
        self.lost[first..first + rays].fill(None);
        self.rays = self.rays.max(first + rays);
    }

    /// Sets ray `i`, on the axes of the part where it is.
    pub(crate) fn set(&mut self, i: usize, ray: &Ray) {
        let (at, lane) = (i / LANES, i % LANES);
        let (p, d) = (ray.position, ray.direction);
        for (axis, (p, d)) in [(p.x, d.x), (p.y, d.y), (p.z, d.z)].into_iter().enumerate() {
            self.position[axis][at][lane] = p;
            self.direction[axis][at][lane] = d;
        }
        self.path[at][lane] = ray.path;
        self.lost[i] = None;
        self.rays = self.rays.max(i + 1);
    }

    /// Sets where ray `i` starts from a screen: its (x, y), and its optical direction cosines in place of a direction.
    #[inline(always)]
    pub(crate) fn start(&mut self, i: usize, [x, y, p, q]: [f64; 4]) {
        let (at, lane) = (i / LANES, i % LANES);
        self.position[0][at][lane] = x;
        self.position[1][at][lane] = y;
        self.direction[0][at][lane] = p;
        self.direction[1][at][lane] = q;
        self.path[at][lane] = 0.0;
        self.lost[i] = None;
        self.rays = self.rays.max(i + 1);
    }

    /// Ray `i`.
    pub(crate) fn ray(&self, i: usize) -> Ray {
        let (at, lane) = (i / LANES, i % LANES);
        let vector = |columns: &[Column; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| columns[axis][at][lane]);
            Vec3::new(x, y, z)
        };
        Ray {
            position: vector(&self.position),
            direction: vector(&self.direction),
            path: self.path[at][lane],
        }
    }

    /// Ray `i` is lost; its numbers stay until [`RayBlock::forget`].
    #[cold]
    pub(crate) fn lose(&mut self, i: usize, loss: Loss) {
        self.lost[i] = Some(loss);
        self.just_lost.push(i);
    }

    /// Ray `i` is lost, and has no numbers.
    #[cold]
    pub(crate) fn erase(&mut self, i: usize, loss: Loss) {
        self.lost[i] = Some(loss);
        self.rays = self.rays.max(i + 1);
        self.clear(i);
    }

    /// Takes the numbers from the rays that were just lost.
    pub(crate) fn forget(&mut self) {
        for i in std::mem::take(&mut self.just_lost) {
            self.clear(i);
        }
    }

    fn clear(&mut self, i: usize) {
        let (at, lane) = (i / LANES, i % LANES);
        for axis in 0..3 {
            self.position[axis][at][lane] = f64::NAN;
            self.direction[axis][at][lane] = f64::NAN;
        }
        self.path[at][lane] = f64::NAN;
    }
}
