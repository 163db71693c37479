//! Where and how many rays start.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdFrom, f64x8};

use crate::engine::geometrical::system_trace::{first_meeting, starting_hit};
use crate::engine::ray_block::block::{Packet, RayBlock};
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::passage::Passage;
use crate::math::lanes::{LANES, Lanes};
use crate::math::vec3::Vec3;
use crate::optics::frame::Frame;
use crate::optics::ray::{Loss, Ray};
use crate::optics::screen::Screen;
use crate::optics::source::Source;
use crate::optics::system::System;

/// Where and how rays start; a list of one direction, light or point serves all rays.
#[derive(Clone, Copy, Debug)]
pub enum RayOrigins<'a> {
    /// With light of the system's source, moved or turned.
    Lit {
        /// For each ray, the unit direction of collimated light or the place of a point source in mm, global.
        light: &'a [[f64; 3]],
        /// Above which x and y rays meet the first screen, on its axes.
        at: [&'a [f64]; 2],
        /// In mm the x and y that stand there as −1 and 1: half widths, or [`RayOrigins::IN_MM`].
        between: [[f64; 2]; 2],
    },
    /// At points with directions of their own.
    Free {
        /// The points in mm, global.
        points: &'a [[f64; 3]],
        /// Unit directions, global.
        directions: &'a [[f64; 3]],
    },
}

/// Places x and y, and in mm where they are −1 and 1.
type Places<'a> = ([&'a [f64]; 2], [[f64; 2]; 2]);

/// The entry of a ray in a list that may have one for all.
fn of_ray(list: &[[f64; 3]], ray: usize) -> Vec3 {
    let [x, y, z] = match list {
        [all] => *all,
        list => list[ray],
    };
    Vec3::new(x, y, z)
}

/// A wave whose rays start eight at a time on a plane screen.
enum Wave {
    /// Collimated light whose phase is zero at a point.
    Plane(Vec3),
    /// Light of a point whose phase is zero at another point.
    Point(Vec3),
}

impl RayOrigins<'_> {
    /// The scale of places that are given in mm.
    pub const IN_MM: [[f64; 2]; 2] = [[-1.0, 1.0]; 2];

    /// How many rays there are.
    pub fn len(&self) -> usize {
        match self {
            RayOrigins::Lit { at: [x, _], .. } => x.len(),
            RayOrigins::Free { points, directions } => match [points.len(), directions.len()] {
                [0, _] | [_, 0] => 0,
                [points, directions] => points.max(directions),
            },
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The light of ray `ray`, and above which (x, y) it meets the first screen.
    ///
    /// # Errors
    /// [`Loss::Missed`] where it does not meet it.
    pub fn of(&self, system: &System, ray: usize) -> Result<(Source, [f64; 2]), Loss> {
        match self {
            RayOrigins::Lit { light, at, between } => {
                let source = system.source.with_light(of_ray(light, ray));
                let place = |axis: usize| {
                    let [low, high] = between[axis];
                    0.5 * (low + high + at[axis][ray] * (high - low))
                };
                Ok((source, [place(0), place(1)]))
            }
            RayOrigins::Free { points, directions } => {
                let [origin, direction] = [points, directions].map(|list| of_ray(list, ray));
                let at = first_meeting(system, origin, direction)?;
                Ok((Source::Plane { direction, origin }, at))
            }
        }
    }

    /// Puts `rays` rays from number `first` on into a block, on the axes of the first screen.
    #[inline(always)]
    pub(crate) fn launch<S: Simd>(
        &self,
        simd: S,
        system: &System,
        block: &mut RayBlock,
        [first, rays]: [usize; 2],
    ) {
        block.restart();
        if let (RayOrigins::Lit { light, at, between }, Some((wave, screen))) = (self, wave(system))
        {
            let starts = (*light, (*at, *between));
            wave.launch(simd, screen, block, starts, [first, rays]);
            return;
        }
        for i in 0..rays {
            match self.alone(system, first + i) {
                Ok(ray) => block.set(i, &ray),
                Err(loss) => block.erase(i, loss),
            }
        }
    }

    /// Ray `ray` on the axes of the first screen.
    fn alone(&self, system: &System, ray: usize) -> Result<Ray, Loss> {
        let screen = system.screens.first().ok_or(Loss::Missed)?;
        let (source, at) = self.of(system, ray)?;
        let hit = starting_hit(system, &source, at)?;
        Ok(Ray {
            position: screen.frame.to_local(hit.point),
            direction: screen.frame.direction_to_local(hit.direction),
            path: hit.path,
        })
    }
}

/// The wave of a system whose rays start eight at a time, and the screen where they do; nothing for a beam, or before a
/// curved screen.
fn wave(system: &System) -> Option<(Wave, &Screen)> {
    let screen = system.screens.first().filter(|screen| screen.is_plane())?;
    let wave = match system.source {
        Source::Plane { origin, .. } | Source::TaperedPlane { origin, .. } => Wave::Plane(origin),
        Source::Point { reference, .. } | Source::TaperedPoint { reference, .. } => {
            Wave::Point(reference)
        }
        Source::Gaussian(_) => return None,
    };
    Some((wave, screen))
}

impl Wave {
    /// Puts `rays` rays from number `first` on into a block, on the axes of a plane screen.
    #[inline(always)]
    fn launch<S: Simd>(
        &self,
        simd: S,
        screen: &Screen,
        block: &mut RayBlock,
        (light, at): (&[[f64; 3]], Places),
        [first, rays]: [usize; 2],
    ) {
        let outwards = Passage::new(&screen.frame, &Frame::GLOBAL);
        let inwards = Passage::new(&Frame::GLOBAL, &screen.frame);
        for begin in (0..rays).step_by(LANES) {
            let group = [first + begin, LANES.min(rays - begin)];
            let place = places(simd, at, group);
            let light = lights(simd, light, group);
            let (path, direction) = self.rays(outwards.points(place), light, screen.index);
            let packet = Packet {
                position: place,
                direction: inwards.directions(direction),
                path,
            };
            block.put_new(begin, group[1], &packet);
        }
    }

    /// Optical paths in a medium of index `n` at eight points, and directions of light there.
    #[inline(always)]
    fn rays<S: Simd>(
        &self,
        point: LaneVec3<S>,
        light: LaneVec3<S>,
        n: f64,
    ) -> (f64x8<S>, LaneVec3<S>) {
        match self {
            Wave::Plane(origin) => {
                let from = point.plus(LaneVec3::all(point.x.simd, -*origin));
                (light.dot(from) * n, light)
            }
            Wave::Point(reference) => {
                let ray = point.plus(light.scaled(-1.0));
                let zero = light
                    .scaled(-1.0)
                    .plus(LaneVec3::all(point.x.simd, *reference));
                let (length, zero) = (ray.dot(ray).sqrt(), zero.dot(zero).sqrt());
                ((length - zero) * n, ray.times(1.0 / length))
            }
        }
    }
}

/// Points of the plane z = 0 for up to eight rays.
#[inline(always)]
fn places<S: Simd>(simd: S, ([x, y], between): Places, [first, rays]: [usize; 2]) -> LaneVec3<S> {
    let place = |axis: usize, column: &[f64]| {
        let [low, high] = between[axis];
        let lanes = taken(&column[first..first + rays]);
        (f64x8::simd_from(simd, lanes) * (high - low) + (low + high)) * 0.5
    };
    LaneVec3::new(place(0, x), place(1, y), f64x8::splat(simd, 0.0))
}

/// Up to eight numbers, and zeros behind them; eight are read at once.
#[inline(always)]
fn taken(numbers: &[f64]) -> Lanes {
    Lanes::try_from(numbers).unwrap_or_else(|_| {
        let mut lanes = [0.0; LANES];
        lanes[..numbers.len()].copy_from_slice(numbers);
        lanes
    })
}

/// The light of up to eight rays.
#[inline(always)]
fn lights<S: Simd>(simd: S, light: &[[f64; 3]], [first, rays]: [usize; 2]) -> LaneVec3<S> {
    if let [[x, y, z]] = light {
        return LaneVec3::all(simd, Vec3::new(*x, *y, *z));
    }
    let mut lanes = [[0.0; LANES]; 3];
    for (lane, [x, y, z]) in light[first..first + rays].iter().enumerate() {
        lanes[0][lane] = *x;
        lanes[1][lane] = *y;
        lanes[2][lane] = *z;
    }
    LaneVec3::new(
        f64x8::simd_from(simd, lanes[0]),
        f64x8::simd_from(simd, lanes[1]),
        f64x8::simd_from(simd, lanes[2]),
    )
}
