//! Derivatives of rays through a whole system by its parameters, many rays at once.
//!
//! They are those of [`RaySensitivity`](crate::engine::geometrical::system_trace::RaySensitivity), whose single rays serve systems
//! with elements and curved screens.

use std::ops::Range;

use fearless_simd::dispatch;
use ndarray::{Array3, ArrayViewMut3, Axis};
use rayon::prelude::*;

use crate::engine::progress::{Cancelled, Pulse};
use crate::engine::ray_block::block::{BLOCK, RayBlock};
use crate::engine::ray_block::parameter_gradient::ParameterGradient;
use crate::engine::ray_block::parameter_tangents::ParameterTangents;
use crate::engine::ray_block::part_change::PartChange;
use crate::engine::ray_block::ray_origins::RayOrigins;
use crate::engine::ray_block::system_rays::{ROW, SystemRays};
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;

/// Derivatives of a number by the x and y (mm) of rays on the sensor, their optical cosines along x and y, and their paths (mm).
pub type ByLandings<'a> = [Option<&'a [f64]>; 5];

/// A system whose rays change with parameters.
pub struct SystemDerivatives<'a> {
    rays: SystemRays<'a>,
    /// How each part changes, in the order of the light.
    changes: Vec<Vec<PartChange<'a>>>,
    /// The index before the sensor, and its derivatives.
    index: f64,
    index_slopes: Vec<f64>,
}

impl<'a> SystemDerivatives<'a> {
    /// Of a system and its variations; nothing where single rays must serve: where elements or curved stops turn rays, or a
    /// parameter changes the kind of a part or the medium at the start.
    pub fn new(system: &'a System, variations: &'a [Variation]) -> Option<Self> {
        let all = variations.iter().flat_map(|v| [&v.below, &v.above]);
        let first = |system: &System| system.screens.first().map(Screen::index_behind);
        let fits = |other: &System| is_plain(other) && first(other) == first(system);
        if !(is_plain(system) && all.into_iter().all(fits)) {
            return None;
        }
        let rays = SystemRays::new(system);
        let mut changes: Vec<Vec<PartChange>> = rays.stations.iter().map(|_| Vec::new()).collect();
        for (parameter, variation) in variations.iter().enumerate() {
            let [below, above] = [&variation.below, &variation.above].map(SystemRays::new);
            if below.parts() != rays.parts() || above.parts() != rays.parts() {
                return None;
            }
            let stations = below.stations.into_iter().zip(above.stations);
            let here = rays.stations.iter().zip(&mut changes);
            for ((station, changes), (below, above)) in here.zip(stations) {
                let (Some(part), Some(below), Some(above)) =
                    (&station.part, below.part, above.part)
                else {
                    continue;
                };
                let parts = [below, above];
                let change = PartChange::between(parameter, part, parts, variation.distance);
                changes.extend(change.ok()?);
            }
        }
        let index = |system: &System| Some(system.screens.last()?.index);
        let slope = |v: &Variation| Some((index(&v.above)? - index(&v.below)?) / v.distance);
        Some(Self {
            rays,
            changes,
            index: index(system)?,
            index_slopes: variations.iter().map(slope).collect::<Option<_>>()?,
        })
    }

    /// Derivatives (parameters, 5, rays) of x, y (mm), the optical cosines along x and y, and the path (mm) on the sensor, on its axes.
    /// Rays start at fixed places of the first screen. Those of lost rays are NaN.
    ///
    /// # Errors
    /// When the pulse breaks.
    pub fn derivatives(
        &self,
        origins: RayOrigins,
        pulse: &Pulse,
    ) -> Result<Array3<f64>, Cancelled> {
        let mut all = Array3::zeros((self.index_slopes.len(), 5, origins.len()));
        let row = ROW * BLOCK;
        let pieces: Vec<_> = all.axis_chunks_iter_mut(Axis(2), row).collect();
        let numbered = pieces.into_par_iter().enumerate();
        numbered.try_for_each(|(number, piece)| {
            Cancelled::check(pulse())?;
            self.follow(number * row, origins, piece);
            Ok(())
        })?;
        Ok(all)
    }

    /// Those of the rays of a piece, of which the first has the number `first`.
    fn follow(&self, first: usize, origins: RayOrigins, mut piece: ArrayViewMut3<f64>) {
        let mut block = RayBlock::empty();
        let mut tangents = ParameterTangents::new(self.index_slopes.len());
        let (rays, count) = (&self.rays, piece.len_of(Axis(2)));
        for start in (0..count).step_by(BLOCK) {
            let group = [first + start, BLOCK.min(count - start)];
            dispatch!(rays.level, simd => origins.launch(simd, rays.system, &mut block, group));
            tangents.restart();
            for (station, changes) in rays.stations.iter().zip(&self.changes) {
                tangents.come_to(changes);
                rays.visit(station, &mut block, &mut tangents);
                block.forget();
            }
            tangents.come_to(&[]);
            self.write(&block, &tangents, [start, group[1]], &mut piece);
        }
    }

    /// The gradient of a number by all parameters, from its derivatives by the x, y, cosines and path of each ray that
    /// [`Self::derivatives`] tells of; zero where there are none. Those of lost rays do not count. Rays are traced there and back,
    /// and memory does not grow with them. Any number of threads gives the same bits.
    ///
    /// # Errors
    /// When the pulse breaks.
    pub fn gradient(
        &self,
        origins: RayOrigins,
        by_landings: &ByLandings,
        pulse: &Pulse,
    ) -> Result<Vec<f64>, Cancelled> {
        let row = ROW * BLOCK;
        let pieces: Vec<usize> = (0..origins.len()).step_by(row).collect();
        let sums = pieces.into_par_iter().map(|first| {
            Cancelled::check(pulse())?;
            let rays = first..origins.len().min(first + row);
            Ok(self.follow_back(rays, origins, by_landings))
        });
        let mut gradient = vec![0.0; self.index_slopes.len()];
        for sums in sums.collect::<Result<Vec<_>, _>>()? {
            { gradient.iter_mut().zip(sums) }.for_each(|(total, sum)| *total += sum);
        }
        Ok(gradient)
    }

    /// That of some rays.
    fn follow_back(
        &self,
        all: Range<usize>,
        origins: RayOrigins,
        by_landings: &ByLandings,
    ) -> Vec<f64> {
        let rays = &self.rays;
        // The block before each part, and behind the last.
        let mut blocks = vec![RayBlock::empty(); rays.stations.len() + 1];
        let mut gradient = ParameterGradient::new(self.index_slopes.len());
        for start in all.clone().step_by(BLOCK) {
            let group = [start, BLOCK.min(all.end - start)];
            dispatch!(rays.level, simd => origins.launch(simd, rays.system, &mut blocks[0], group));
            for (number, station) in rays.stations.iter().enumerate() {
                let [before, behind] = &mut blocks[number..number + 2] else {
                    continue;
                };
                behind.copy(before);
                rays.visit(station, behind, &mut ());
                behind.forget();
            }
            if let Some(landed) = blocks.last() {
                self.land(landed, start, by_landings, &mut gradient);
            }
            let parts = rays.stations.iter().zip(&self.changes).zip(&mut blocks);
            for ((station, changes), block) in parts.rev() {
                gradient.come_to(changes);
                rays.pass(station, block, &mut gradient);
            }
        }
        gradient.sums()
    }

    /// The derivatives by the rays of a block on the sensor, of which the first has the number `first`.
    fn land(
        &self,
        block: &RayBlock,
        first: usize,
        by_landings: &ByLandings,
        gradient: &mut ParameterGradient,
    ) {
        let range = first..first + block.rays();
        let columns = { by_landings.each_ref() }.map(|column| Some(&(*column)?[range.clone()]));
        gradient.land(block, columns, self.index);
        // cosines = n·d
        let slopes = self.index_slopes.iter().enumerate();
        for (parameter, slope) in slopes.filter(|(_, slope)| **slope != 0.0) {
            let along = |axis: usize, i: usize| {
                let by_cosine = columns[2 + axis].map_or(0.0, |column| column[i]);
                by_cosine * block.direction[axis].as_flattened()[i]
            };
            for i in (0..block.rays()).filter(|i| block.lost[*i].is_none()) {
                gradient.add(parameter, slope * (along(0, i) + along(1, i)));
            }
        }
    }

    /// Writes down the derivatives of the rays of a block, from the `start`-th of the piece on.
    fn write(
        &self,
        block: &RayBlock,
        tangents: &ParameterTangents,
        [start, count]: [usize; 2],
        piece: &mut ArrayViewMut3<f64>,
    ) {
        let direction = [0, 1].map(|axis| block.direction[axis].as_flattened());
        let parameters = piece.outer_iter_mut().zip(&self.index_slopes);
        for (parameter, (mut rows, slope)) in parameters.enumerate() {
            let columns = { rows.outer_iter_mut() }.zip(tangents.of(parameter));
            for (row, (mut values, column)) in columns.enumerate() {
                let column = column.as_flattened();
                for (i, value) in values.iter_mut().skip(start).take(count).enumerate() {
                    *value = match row {
                        _ if block.lost[i].is_some() => f64::NAN,
                        // cosines = n·d
                        2 | 3 => self.index * column[i] + slope * direction[row - 2][i],
                        _ => column[i],
                    };
                }
            }
        }
    }
}

/// Whether rays go straight on at all screens, which are planes, and reach the sensor at the end.
fn is_plain(system: &System) -> bool {
    let Some((last, stops)) = system.screens.split_last() else {
        return false;
    };
    let straight = |screen: &Screen| {
        let stop = matches!(screen.kind, ScreenKind::Stop(_));
        stop && screen.is_plane() && screen.behind.is_none() && screen.leaves() == screen.arrives
    };
    stops.iter().all(straight) && matches!(last.kind, ScreenKind::Sensor(_))
}
