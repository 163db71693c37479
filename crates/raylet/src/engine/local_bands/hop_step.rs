//! One hop: all its tiles, forward and back.
//!
//! `carry_kept_dot_product` (in `carry.rs`) tests the adjoint of the hop as a part of the whole run.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlet::mode_histogram::ModeHistogram;
use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::emission::{Emission, Emitted};
use crate::engine::local_bands::held_light::ArrivingLight;
use crate::engine::local_bands::hop_cotangents::{Back, HopBar, chunk_back};
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::onward_way::OnwardWay;
use crate::engine::local_bands::passing_light::{LEFT_OF_CUBIC, OpenGate, OpenWay, PassingStarts};
use crate::engine::local_bands::settings::{
    LocalBandPlan, LocalBandSettings, SOURCE_STEP, SourceAperture,
};
use crate::engine::local_bands::source::source_aperture::has_dark_rim;
use crate::engine::local_bands::source::source_windows::SourceWindows;
use crate::engine::local_bands::target::{MARGIN, TargetRegion};
use crate::engine::local_bands::tile_plan::{TileRun, grown};
use crate::engine::local_bands::tile_run::{TileBar, TileValues};
use crate::engine::local_bands::window_widths::period_over_pixels;
use crate::engine::progress::{Cancelled, ShareDone};
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::direction_sectors::SectorSum;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::element_samples::Element;
use crate::wave::local_bands::reused_array;
use crate::wave::local_bands::tiling::{EdgeContact, REACH, Tile, Tiling, WindowShape};

/// Beamlets of a smooth source end at this share of the threshold: each of them counts in full.
const SOURCE_EDGE: f64 = 0.1;

/// Tiles that are worked on between two sums at most, and first of all.
const CHUNK: usize = 64;
const FIRST_CHUNK: usize = 8;

/// Beamlets that wait to be summed, about: fewer tiles are worked on where each sends many.
pub(crate) const BEAMLETS_AT_ONCE: u64 = 1_000_000;

/// Tiles from which the light that reaches the target is estimated.
const SAMPLE: usize = 32;

/// Tiles from which a forecast tells how many plane waves are followed.
const FORECAST_SAMPLE: usize = 2;

/// The light of sampled tiles is kept in this many times the room of one array.
const KEPT: u64 = 4;

/// The light that a hop sends to its second screen.
pub(crate) struct Sent {
    /// Counts and energies of the plane waves and beamlets.
    pub statistics: HopStatistics,
    /// The beamlets of each tile; none where the hop ends at the sensor.
    pub tiles: Vec<Vec<Arrival>>,
    /// Plane waves weaker than this were left out.
    pub weakest: f64,
    /// What light of the source starts with that passes the second screen as it is.
    pub passing: PassingStarts,
}

/// What a hop needs from its run: the sum on the sensor, the progress callback and the memory in use.
pub(crate) struct Work<'a> {
    pub sum: &'a mut SectorSum,
    pub progress: &'a ShareDone<'a>,
    /// Number of beamlets that are held in memory beside those that the hop sends.
    pub held: usize,
    /// Memory of each beamlet in bytes, with what its adjoint will need.
    pub bytes: usize,
    /// Whether light of the source passes bare apertures as it is, and what that starts with which has passed those so far.
    pub passing: Option<PassingStarts>,
}

/// One hop, ready to run.
pub(crate) struct HopStep<'a> {
    system: &'a System,
    settings: &'a LocalBandSettings,
    number: usize,
    /// The hop.
    pub hop: Hop<'a>,
    /// What stands on its first screen; nothing where a smooth source has one beamlet a window.
    element: Option<Element<'a>>,
    /// Whether its element, or one before it, has pixels.
    behind_pixels: bool,
    shape: WindowShape,
    tiling: Tiling,
    /// The target of the light.
    pub target: TargetRegion,
    /// What stands behind it, where light passes it as rays do.
    pub onward: Option<OnwardWay<'a>>,
}

impl<'a> HopStep<'a> {
    /// Plans the hop with this number.
    ///
    /// # Errors
    /// When a screen has no edge or reflects into another medium, an element has layers of another kind, or a width is
    /// missing.
    pub(crate) fn new(
        system: &'a System,
        settings: &'a LocalBandSettings,
        number: usize,
        hop: Hop<'a>,
    ) -> Result<Self, LocalBandError> {
        for screen in [hop.from, hop.to] {
            if screen.behind.is_some() && screen.leaves() != screen.arrives {
                return Err(LocalBandError::Mirror(screen.name.clone()));
            }
        }
        let missing = |screen: &Screen| LocalBandError::NoWidth(screen.name.clone());
        let boundless = |screen: &Screen| LocalBandError::Boundless(screen.name.clone());
        let mut shape = settings.windows(number).ok_or_else(|| missing(hop.from))?;
        let margin = match settings.windows(number + 1) {
            Some(next) => MARGIN * next.sigma,
            None if matches!(hop.to.kind, ScreenKind::Sensor(_)) => 0.0,
            None => return Err(missing(hop.to)),
        };
        let stop = matches!(hop.from.kind, ScreenKind::Stop(_));
        let soft = number == 0 && stop && settings.aperture == SourceAperture::Soft;
        let mut edge = settings.threshold;
        let element = if soft {
            shape.step = SOURCE_STEP;
            edge *= SOURCE_EDGE;
            None
        } else {
            let layers = || LocalBandError::Layers(hop.from.name.clone());
            let element = Element::of(hop.from).ok_or_else(layers)?;
            shape.period = period_over_pixels(shape, &element);
            Some(element)
        };
        let bounds = hop.from.bounds().ok_or_else(|| boundless(hop.from))?;
        let dark_rim = number == 0 && !soft && has_dark_rim(system, settings.threshold);
        let tiling = Tiling::over(bounds, shape, settings.tile).with_dark_rim(dark_rim);
        let windows = [0, 1].map(|a| tiling.positions[a].count);
        let allowed = settings.windows_allowed();
        if windows[0].saturating_mul(windows[1]) > allowed {
            let screen = hop.from.name.clone();
            return Err(LocalBandError::Windows {
                screen,
                windows,
                allowed,
            });
        }
        let has_pixels = |screen| Element::of(screen).is_some_and(|e| e.pixels().is_some());
        Ok(Self {
            system,
            settings,
            number,
            hop,
            behind_pixels: system.screens[..=number].iter().any(has_pixels),
            element,
            shape,
            tiling,
            onward: OnwardWay::behind(system, settings, number, edge),
            target: TargetRegion::of(hop.to, margin, edge).ok_or_else(|| boundless(hop.to))?,
        })
    }

    /// Lets beamlets end where those of a smooth source do.
    pub(crate) fn widen_footprints(&mut self) {
        self.target.edge *= SOURCE_EDGE;
    }

    /// What stands on its first screen; nothing where a smooth source has one beamlet a window.
    pub(crate) fn element(&self) -> Option<&Element<'a>> {
        self.element.as_ref()
    }

    /// Whether what an edge without corners sends far is summed along it: light that goes to a sensor, but for that of pixels.
    pub(crate) fn sums_along_edge(&self) -> bool {
        let round = |aperture: &Aperture| {
            matches!(
                aperture.outline,
                Outline::Disc { .. } | Outline::Annulus { .. }
            )
        };
        let element = self.element.as_ref();
        self.ends() && element.is_some_and(|e| e.pixels().is_none() && round(e.aperture()))
    }

    /// Its windows.
    pub(crate) fn plan(&self) -> LocalBandPlan {
        let WindowShape {
            sigma,
            step,
            period,
        } = self.shape;
        LocalBandPlan {
            sigma,
            step,
            period,
            windows: [0, 1].map(|a| self.tiling.positions[a].count),
            smooth: self.element.is_none(),
            corrected: self.settings.corrected,
        }
    }

    /// Carries the light over the hop: to the sum on the sensor where it ends at the sensor, otherwise tile by tile.
    ///
    /// # Errors
    /// When the progress of `work` cancels the hop, or more beamlets are to be held than the memory limit has room for.
    pub(crate) fn carry(&self, light: &ArrivingLight, work: Work) -> Result<Sent, LocalBandError> {
        let Some(element) = &self.element else {
            let gate = self.gate(&work);
            let windows = SourceWindows {
                gate: gate.as_ref(),
                ..self.source_windows()
            };
            return self.each_tile(work, 0.0, |_, tile| windows.send(tile));
        };
        let run = self.run(light, element);
        let (weakest, known) = self.weakest(&run);
        let emission = self.emission(&run, weakest);
        let sent = self.each_tile(work, weakest, |number, tile| {
            run.send(tile, &emission, known.get(&number))
        });
        reused_array::release();
        sent.map_err(|error| match error {
            LocalBandError::Tile {
                screen, allowed, ..
            } => LocalBandError::Tile {
                values: self.largest_array(&run),
                screen,
                allowed,
            },
            other => other,
        })
    }

    /// Values of the largest array of all tiles.
    fn largest_array(&self, run: &TileRun) -> u64 {
        let tiles = self.tiling.tiles();
        let array = |tile: &Tile| {
            let mut statistics = HopStatistics::default();
            run.outline(tile, &mut statistics);
            statistics.largest_array
        };
        tiles.par_iter().map(array).max().unwrap_or(0)
    }

    /// The conjugate transpose, for the plane waves that are kept, and the derivatives with respect to parameters.
    ///
    /// # Errors
    /// When the pulse of `back` cancels the work.
    pub(crate) fn carry_adjoint(
        &self,
        light: &ArrivingLight,
        back: &Back,
    ) -> Result<HopBar, Cancelled> {
        let pixels = self.element.as_ref().and_then(Element::pixels);
        let mut total = HopBar {
            arriving: vec![[Complex64::ZERO; 6]; light.held()],
            pixels: pixels.map(|pixels| Array2::zeros(pixels.values.dim())),
            parameters: vec![0.0; back.changes.count],
        };
        let windows = self.source_windows();
        let emitting = (self.element.as_ref()).map(|element| {
            let run = self.run(light, element);
            let emission = self.emission(&run, back.weakest);
            (run, emission)
        });
        let tiles: Vec<(usize, Tile)> = self.tiling.tiles().into_iter().enumerate().collect();
        let at_once = chunk_back(light.held(), self.settings.memory_limit);
        for chunk in tiles.chunks(at_once) {
            let give_back = |(number, tile): &(usize, Tile)| {
                let mut place = back.bars.start(*number);
                let bars = |beamlets: &[Arrival]| {
                    place += beamlets.len();
                    let first = place - beamlets.len();
                    (back.bars).of(beamlets, first, &self.hop, self.target.edge)
                };
                match &emitting {
                    Some((run, emission)) => run.send_adjoint(tile, emission, &back.changes, bars),
                    None => TileBar {
                        parameters: windows.pull(tile, &back.changes, bars),
                        ..TileBar::default()
                    },
                }
            };
            let found: Vec<TileBar> = chunk.par_iter().map(give_back).collect();
            found.into_iter().for_each(|bar| total.add(bar));
            reused_array::release();
            Cancelled::check((back.pulse)())?;
        }
        Ok(total)
    }

    /// The windows of a smooth source.
    fn source_windows(&self) -> SourceWindows<'_> {
        SourceWindows {
            source: &self.system.source,
            hop: &self.hop,
            target: &self.target,
            tiling: &self.tiling,
            corrected: self.settings.corrected,
            unit: 1.0,
            left_of_cubic: 0.0,
            gate: None,
        }
    }

    /// The aperture at its end, where light of the source may pass.
    fn gate(&self, work: &Work) -> Option<OpenGate<'a>> {
        work.passing.as_ref()?;
        let allowed = self.settings.dropped.unwrap_or(self.settings.threshold);
        OpenGate::at_end_of(self.system, self.number, allowed)
    }

    /// The beamlets of the source that have passed the first screen, where they land.
    fn passed(&self, work: &Work) -> Vec<Emitted> {
        let starts = work.passing.iter().flatten();
        let starts: Vec<&Vec<ChirpedStart>> = starts.collect();
        let way = OpenWay::to_end_of(self.system, self.number);
        let (Some(way), Some(first)) = (way, self.settings.windows(0)) else {
            return Vec::new();
        };
        let gate = self.gate(work);
        let area = |step: f64, sigma: f64| (step * sigma).powi(2);
        let indices = way.hop().from.index_behind() / self.hop.from.index_behind();
        let WindowShape { step, sigma, .. } = self.shape;
        let windows = SourceWindows {
            hop: &way.hop(),
            unit: indices * area(SOURCE_STEP, first.sigma) / area(step, sigma),
            left_of_cubic: LEFT_OF_CUBIC,
            gate: gate.as_ref(),
            ..self.source_windows()
        };
        let send = |starts: &&Vec<ChirpedStart>| windows.send_from(starts);
        starts.par_iter().map(send).collect()
    }

    /// What all tiles share.
    fn run<'b>(&'b self, light: &ArrivingLight<'b>, element: &'b Element) -> TileRun<'b> {
        TileRun {
            hop: &self.hop,
            light: *light,
            element,
            tiling: &self.tiling,
            shape: self.shape,
            target: &self.target,
            onward: self.onward.as_ref(),
            settings: self.settings,
        }
    }

    /// What all windows share.
    fn emission(&self, run: &TileRun, weakest: f64) -> Emission<'_> {
        Emission {
            hop: &self.hop,
            target: &self.target,
            weakest,
            unit: run.unit(),
            corrected: self.settings.corrected,
            aperture: self.element.as_ref().map(|element| element.aperture()),
            beside: self.beside(),
        }
    }

    /// How far beside smooth light, in optical cosines, the first orders of the lattice of windows lie; nothing for the light of
    /// pixels, which has all directions.
    pub(crate) fn beside(&self) -> Option<f64> {
        (!self.behind_pixels).then(|| self.hop.wavelength / (self.shape.step * self.shape.sigma))
    }

    /// Windows with light: those inside the aperture, and those that its edge cuts.
    pub(crate) fn lit_windows(&self) -> [usize; 2] {
        let Some(element) = &self.element else {
            return [0; 2];
        };
        let mut counts = [0; 2];
        for tile in self.tiling.tiles() {
            for window in self.tiling.lit(&tile, element.aperture()) {
                counts[usize::from(window.edge == EdgeContact::Cut)] += 1;
            }
        }
        counts
    }

    /// Pitch of its element's pixels in mm, if there are any.
    pub(crate) fn pixel_pitch(&self) -> Option<[f64; 2]> {
        let pixels = self.element.as_ref()?.pixels()?;
        Some(pixels.pitch)
    }

    /// The amplitude below which plane waves are left out, from those of a sample of the windows; and the light that
    /// arrives at tiles of the sample, by their numbers, as far as it fits into memory.
    fn weakest(&self, run: &TileRun) -> (f64, HashMap<usize, TileValues>) {
        let tiles = self.tiling.tiles().into_iter().enumerate();
        let lit = |tile: &Tile| {
            let area = grown(self.tiling.centres(tile), REACH * self.shape.sigma);
            let open = !self.tiling.lit(tile, run.element.aperture()).is_empty();
            open && run.light.is_near(area)
        };
        let tiles: Vec<(usize, Tile)> = tiles.filter(|(_, tile)| lit(tile)).collect();
        let stride = tiles.len().div_ceil(SAMPLE).max(1);
        let sample: Vec<&(usize, Tile)> = tiles.iter().skip(stride / 2).step_by(stride).collect();
        let room = AtomicU64::new(KEPT * self.settings.values_allowed());
        let found: Vec<_> = sample
            .into_par_iter()
            .filter_map(|(number, tile)| {
                let (histogram, values) = run.histogram(tile)?;
                let size = values.0.len() as u64;
                let taken = room.fetch_update(Relaxed, Relaxed, |room| room.checked_sub(size));
                Some((histogram, taken.is_ok().then_some((*number, values))))
            })
            .collect();
        let (mut all, mut known) = (ModeHistogram::default(), HashMap::new());
        for (histogram, kept) in found {
            all = all.merge(histogram);
            known.extend(kept);
        }
        (self.floor(&all).sqrt(), known)
    }

    /// The energy below which plane waves are left out.
    fn floor(&self, all: &ModeHistogram) -> f64 {
        match self.settings.dropped {
            Some(error) => all.floor_of_share((error / self.plan().share_of_dropped()).powi(2)),
            None => all.strongest() * self.settings.threshold.powi(2),
        }
    }

    /// The share of the plane waves behind pixels that are strong enough to be followed where the source lights them, by the
    /// windows of a few tiles. Pixels that repeat have few orders.
    pub(crate) fn followed_share(&self) -> f64 {
        let Some(element) = &self.element else {
            return 1.0;
        };
        let k = self.hop.wavenumber();
        let light = ArrivingLight::Source(&self.system.source, self.hop.from, k);
        let run = self.run(&light, element);
        let tiles = self.tiling.tiles();
        let inside = |tile: &&Tile| {
            let lit = self.tiling.lit(tile, element.aperture());
            lit.iter().any(|window| window.edge == EdgeContact::Inside)
        };
        let lit: Vec<&Tile> = tiles.iter().filter(inside).collect();
        let stride = lit.len().div_ceil(FORECAST_SAMPLE).max(1);
        let sample = lit.iter().skip(stride / 2).step_by(stride);
        let found = sample.filter_map(|tile| Some(run.histogram(tile)?.0));
        let all = found.reduce(ModeHistogram::merge);
        all.map_or(1.0, |all| all.share_from(self.floor(&all)))
    }

    /// Works on all tiles, some at a time; what they send is added in their order.
    fn each_tile(
        &self,
        mut work: Work,
        weakest: f64,
        send: impl Fn(usize, &Tile) -> Emitted + Sync,
    ) -> Result<Sent, LocalBandError> {
        let mut sent = Sent {
            statistics: HopStatistics::default(),
            tiles: Vec::new(),
            weakest,
            passing: Vec::new(),
        };
        self.take(self.passed(&work), &mut work, &mut sent);
        let tiles = self.tiling.tiles();
        let (mut done, mut chunk) = (0, FIRST_CHUNK);
        while let Some(next) = tiles
            .get(done..(done + chunk).min(tiles.len()))
            .filter(|c| !c.is_empty())
        {
            let numbered = next.par_iter().enumerate();
            let emitted: Vec<Emitted> = numbered.map(|(i, tile)| send(done + i, tile)).collect();
            self.take(emitted, &mut work, &mut sent);
            self.check_room(&work, &sent.statistics)?;
            done += next.len();
            Cancelled::check((work.progress)(done as f64 / tiles.len() as f64))?;
            let of_tile = sent.statistics.beamlets() / done as u64 + 1;
            chunk = ((BEAMLETS_AT_ONCE / of_tile) as usize).clamp(1, CHUNK);
        }
        Ok(sent)
    }

    /// Adds what tiles send.
    fn take(&self, emitted: Vec<Emitted>, work: &mut Work, sent: &mut Sent) {
        let (k, ends) = (self.hop.wavenumber(), self.ends());
        for mut emitted in emitted {
            sent.statistics.add(&emitted.statistics);
            if !emitted.passing.is_empty() {
                sent.passing.push(emitted.passing);
            }
            if ends {
                let values = work.sum.add(&emitted.arrivals, k, self.target.edge);
                sent.statistics.tally.evaluations += values;
            } else {
                emitted.arrivals.shrink_to_fit();
                sent.tiles.push(emitted.arrivals);
            }
        }
    }

    /// Whether its light ends at a sensor.
    fn ends(&self) -> bool {
        matches!(self.hop.to.kind, ScreenKind::Sensor(_))
    }

    /// Refuses arrays that are too large, and more beamlets than fit into memory beside those that are held.
    fn check_room(&self, work: &Work, statistics: &HopStatistics) -> Result<(), LocalBandError> {
        let (values, allowed) = (statistics.largest_array, self.settings.values_allowed());
        if values > allowed {
            let screen = self.hop.from.name.clone();
            return Err(LocalBandError::Tile {
                screen,
                values,
                allowed,
            });
        }
        let beamlets = match self.ends() {
            true => work.held,
            false => work.held + statistics.beamlets() as usize,
        };
        match beamlets * work.bytes <= self.settings.memory_limit {
            true => Ok(()),
            false => Err(LocalBandError::Memory {
                screen: self.hop.to.name.clone(),
                limit_mb: self.settings.memory_limit / 1_000_000,
            }),
        }
    }
}
