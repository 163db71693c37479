//! Rays through a whole system, with what they meet on the way.
//!
//! They are the rays of [`trace_system`](crate::engine::geometrical::system_trace::trace_system), many at once.

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use ndarray::{Array2, Array3, ArrayViewMut2, ArrayViewMut3, Axis};
use rayon::prelude::*;

use crate::engine::geometrical::system_trace::deflected_at;
use crate::engine::progress::{Cancelled, Pulse};
use crate::engine::ray_block::block::{BLOCK, RayBlock};
use crate::engine::ray_block::block_step::{LaneCompanion, clip, step};
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::passage::Passage;
use crate::engine::ray_block::prepared_part::{Edge, PreparedPart};
use crate::engine::ray_block::ray_origins::RayOrigins;
use crate::engine::trace::ray_trace::{LocatedScreen, emit_locally};
use crate::math::lanes::{LANES, Lanes};
use crate::math::simd_level::level;
use crate::optics::frame::Frame;
use crate::optics::ray::{Loss, Ray};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;

/// What rays met; what a lost ray did not reach is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracks {
    /// Global x, y, z in mm where rays meet parts: (3, parts, rays).
    pub points: Array3<f64>,
    /// Their unit directions behind the parts, global: (3, parts, rays).
    pub directions: Array3<f64>,
    /// Optical paths up to the parts in mm, from where the source's phase is zero: (parts, rays).
    pub paths: Array2<f64>,
    /// Why rays are lost.
    pub lost: Vec<Option<Loss>>,
}

/// A system made ready for many rays.
pub struct SystemRays<'a> {
    /// The system.
    pub(crate) system: &'a System,
    /// Its screens and surfaces in the order of the light.
    pub(crate) stations: Vec<Station<'a>>,
    /// The processor's vector instructions.
    pub(crate) level: Level,
}

/// A screen or surface on the way.
pub(crate) struct Station<'a> {
    /// How rays come there; nothing for the first screen.
    pub part: Option<PreparedPart<'a>>,
    /// From its axes to the global ones.
    outwards: Passage,
    /// The screen that it is.
    pub screen: Option<&'a Screen>,
}

/// Blocks that one thread follows in a row.
pub(crate) const ROW: usize = 16;

/// Where tracks are written: arrays as in [`Tracks`], rays beside each other in memory, whatever they hold.
pub struct TracksMut<'a> {
    /// Points.
    pub points: ArrayViewMut3<'a, f64>,
    /// Directions.
    pub directions: ArrayViewMut3<'a, f64>,
    /// Optical paths.
    pub paths: ArrayViewMut2<'a, f64>,
    /// Why rays are lost.
    pub lost: &'a mut [Option<Loss>],
}

impl<'a> SystemRays<'a> {
    /// Through all screens and surfaces of a system.
    pub fn new(system: &'a System) -> Self {
        let mut stations = Vec::new();
        let mut before: Option<&Frame> = None;
        let station = |part, frame: &Frame, screen| Station {
            part,
            outwards: Passage::new(frame, &Frame::GLOBAL),
            screen,
        };
        for (number, screen) in system.screens.iter().enumerate() {
            let part = before.map(|before| PreparedPart::screen(before, screen));
            stations.push(station(part, &screen.frame, Some(screen)));
            let mut last = &screen.frame;
            for surface in system.trains.get(number).into_iter().flatten() {
                let part = PreparedPart::surface(last, surface);
                stations.push(station(Some(part), &surface.frame, None));
                last = &surface.frame;
            }
            before = Some(last);
        }
        Self {
            system,
            stations,
            level: level(),
        }
    }

    /// How many parts rays meet: screens and surfaces, in the order of the light.
    pub fn parts(&self) -> usize {
        self.stations.len()
    }

    /// Follows rays, and writes down what they meet at the parts of these numbers.
    ///
    /// # Errors
    /// When the pulse breaks.
    pub fn trace(
        &self,
        origins: RayOrigins,
        recorded: &[usize],
        pulse: &Pulse,
    ) -> Result<Tracks, Cancelled> {
        let (parts, rays) = (recorded.len(), origins.len());
        let mut tracks = Tracks {
            points: Array3::zeros((3, parts, rays)),
            directions: Array3::zeros((3, parts, rays)),
            paths: Array2::zeros((parts, rays)),
            lost: vec![None; rays],
        };
        let mut to = TracksMut {
            points: tracks.points.view_mut(),
            directions: tracks.directions.view_mut(),
            paths: tracks.paths.view_mut(),
            lost: &mut tracks.lost,
        };
        self.trace_to(origins, recorded, &mut to, pulse)?;
        Ok(tracks)
    }

    /// The same into arrays of a caller. All of them is written: lost rays leave NaN behind.
    ///
    /// # Errors
    /// When the pulse breaks.
    pub fn trace_to(
        &self,
        origins: RayOrigins,
        recorded: &[usize],
        tracks: &mut TracksMut,
        pulse: &Pulse,
    ) -> Result<(), Cancelled> {
        let row = ROW * BLOCK;
        let points = tracks.points.axis_chunks_iter_mut(Axis(2), row);
        let directions = tracks.directions.axis_chunks_iter_mut(Axis(2), row);
        let paths = tracks.paths.axis_chunks_iter_mut(Axis(1), row);
        let all = { points.zip(directions).zip(paths) }.zip(tracks.lost.chunks_mut(row));
        let pieces: Vec<TracksMut> = all
            .map(|(((points, directions), paths), lost)| TracksMut {
                points,
                directions,
                paths,
                lost,
            })
            .collect();
        pieces
            .into_par_iter()
            .enumerate()
            .try_for_each(|(number, piece)| {
                Cancelled::check(pulse())?;
                self.follow(number * row, origins, recorded, piece);
                Ok(())
            })
    }

    /// The rays of one piece of the tracks, of which the first has the number `first`.
    fn follow(&self, first: usize, origins: RayOrigins, recorded: &[usize], mut piece: TracksMut) {
        let mut block = RayBlock::empty();
        for start in (0..piece.lost.len()).step_by(BLOCK) {
            let range = start..piece.lost.len().min(start + BLOCK);
            let rays = [first + start, range.len()];
            dispatch!(self.level, simd => origins.launch(simd, self.system, &mut block, rays));
            for (number, station) in self.stations.iter().enumerate() {
                self.visit(station, &mut block, &mut ());
                for (slot, _) in
                    { recorded.iter().enumerate() }.filter(|(_, part)| **part == number)
                {
                    dispatch!(self.level, simd => piece.record(
                        simd,
                        &block,
                        &station.outwards,
                        [slot, start],
                    ));
                }
                block.forget();
            }
            piece.lost[range.clone()].copy_from_slice(&block.lost[..range.len()]);
        }
    }

    /// Takes a block to a part and through its surface; nothing happens at the first screen.
    pub(crate) fn pass(
        &self,
        station: &Station,
        block: &mut RayBlock,
        companion: &mut impl LaneCompanion,
    ) {
        if let Some(part) = &station.part {
            dispatch!(self.level, simd => step(simd, block, part, companion));
        }
    }

    /// Takes a block to a part and through it.
    pub(crate) fn visit(
        &self,
        station: &Station,
        block: &mut RayBlock,
        companion: &mut impl LaneCompanion,
    ) {
        self.pass(station, block, companion);
        let Some(screen) = station.screen else {
            return;
        };
        match &screen.kind {
            ScreenKind::Sensor(_) => return,
            ScreenKind::Stop(aperture) if screen.is_plane() => {
                let edge = Edge::of(aperture);
                dispatch!(self.level, simd => clip(simd, block, &edge));
                return;
            }
            ScreenKind::Stop(_) | ScreenKind::Doe(_) => {}
        }
        for i in 0..block.rays() {
            if block.lost[i].is_some() {
                continue;
            }
            let ray = block.ray(i);
            match onwards(screen, self.system.wavenumber(), &ray) {
                Ok(ray) => block.set(i, &ray),
                Err(loss) => block.lose(i, loss),
            }
        }
    }
}

/// A ray behind a screen, on its axes.
fn onwards(screen: &Screen, k: f64, ray: &Ray) -> Result<Ray, Loss> {
    let at = [ray.position.x, ray.position.y];
    let p = [ray.direction.x, ray.direction.y].map(|d| d * screen.index);
    let (p, added) = deflected_at(screen, k, at, p)?;
    let (leaving, _) = emit_locally(&LocatedScreen::left(screen), at, p)?;
    Ok(Ray {
        path: ray.path + added,
        ..leaving
    })
}

impl TracksMut<'_> {
    /// Writes down where the rays of a block are, on global axes, from the `start`-th of the piece on.
    #[inline(always)]
    fn record<S: Simd>(
        &mut self,
        simd: S,
        block: &RayBlock,
        outwards: &Passage,
        [slot, start]: [usize; 2],
    ) {
        let mut points = self.points.index_axis_mut(Axis(1), slot);
        let mut directions = self.directions.index_axis_mut(Axis(1), slot);
        let mut paths = self.paths.row_mut(slot);
        for at in 0..block.packets() {
            let ray = block.packet(simd, at);
            let (begin, first) = (at * LANES, start + at * LANES);
            let range = first..first + LANES.min(block.rays() - begin);
            write(&mut points, &range, outwards.points(ray.position));
            write(&mut directions, &range, outwards.directions(ray.direction));
            if let Some(paths) = paths.as_slice_mut() {
                put(&mut paths[range.clone()], &block.path[at]);
            }
        }
    }
}

/// Writes the components of up to eight vectors into the rows of an array.
#[inline(always)]
fn write<S: Simd>(rows: &mut ArrayViewMut2<f64>, range: &Range<usize>, vectors: LaneVec3<S>) {
    for (mut row, column) in rows.rows_mut().into_iter().zip(&vectors.arrays()) {
        if let Some(row) = row.as_slice_mut() {
            put(&mut row[range.clone()], column);
        }
    }
}

/// Writes the first of eight numbers to up to eight places; all of them go at once.
#[inline(always)]
fn put(places: &mut [f64], numbers: &Lanes) {
    match <&mut Lanes>::try_from(&mut *places) {
        Ok(all) => *all = *numbers,
        Err(_) => places.copy_from_slice(&numbers[..places.len()]),
    }
}
