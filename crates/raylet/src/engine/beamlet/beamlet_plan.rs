//! The plan of a beamlet sum: width, positions and directions, and what they will cost.
//!
//! The width is chosen in `beamlet_width.rs`.

use crate::engine::beamlet::beamlet_aberration::aberration;
use crate::engine::beamlet::beamlet_error::{FARTHEST, TRUSTED_TAIL, WidthErrors};
use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::error::window_error::window_error;
use crate::engine::geometrical::system_trace::passes;
use crate::engine::plan::direction_spread::{
    DirectionEnvelope, LightDirections, weighted_quantile,
};
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::Settings;
use crate::engine::plan::work::Work;
use crate::engine::trace::direction_search::{
    ALL, DirectionSearch, SearchGoal, SearchRay, search_directions,
};
use crate::optics::screen::ScreenKind;
use crate::optics::system::Hop;
use crate::wave::patches::patch::Band;

/// The lattice of a beamlet sum.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamletPlan {
    /// Width σ in mm.
    pub sigma: f64,
    /// Distance of windows in mm.
    pub step: f64,
    /// Period of a patch in mm.
    pub period: f64,
    /// The error at which thresholds aim: that of the settings, or a larger one where no width meets it.
    pub target_error: f64,
    /// Directions along x and y.
    pub bands: [Band; 2],
    /// Whether σ is the smallest or largest of the widths tried, so that a width outside them may be better.
    pub at_limit: bool,
    /// Whether each beamlet's aberration is corrected.
    pub correct: bool,
    /// Whether beamlets that land beside the target have tails that cannot be trusted unseen, or are corrected anyway.
    pub doubtful_rim: bool,
    /// Estimated error from aberration at this σ, uncorrected.
    pub eta: f64,
    /// Estimated error after the correction.
    pub eta_corrected: f64,
    /// Mean cubic phase ε₃ inside beamlets, in rad.
    pub cubic: f64,
    /// Estimated error from tails of beamlets beside the target that are too aberrated to count.
    pub dropped: f64,
    /// Half width of a typical footprint on the target, in mm.
    pub footprint: f64,
    /// Largest optical direction cosines on the receiving screen, along x and y.
    pub arriving: [f64; 2],
    /// |p| on the receiving screen below which most of the light stays, along x and y.
    pub usual: [f64; 2],
    /// What the plan expects to take; of a plan that is only compared, in the weights of the choice.
    pub work: Work,
}

/// Weight of light that misses the sensor behind later screens.
const IRRELEVANT: f64 = 1e-6;

/// Rays of the search that sample the errors of each width.
const SAMPLE_RAYS: usize = 300;

/// Distance from the target up to which landing rays are followed, in typical footprints.
pub(crate) const MARGIN: f64 = 2.5;

/// A target error that no beamlet sum reaches.
const FINEST: f64 = 1e-6;

/// Share of the error from discarded tails below which other errors add nothing.
const BESIDE_DISCARDED: f64 = 0.01;

/// What a beamlet plan is made from.
pub(crate) struct Planner<'a> {
    /// The hop.
    pub hop: &'a Hop<'a>,
    /// The lit part of the first screen, `[x_min, x_max, y_min, y_max]` in mm.
    pub from: [f64; 4],
    /// The part of the second screen that the light must reach.
    pub to: [f64; 4],
    /// The incident light.
    pub light: LightDirections,
    /// How it is spread over directions behind the first screen.
    pub envelope: DirectionEnvelope,
    /// Distance of sample points on the target, when it is known.
    pub pitch: Option<[f64; 2]>,
    /// Where the light goes behind the second screen.
    pub downstream: &'a Downstream<'a>,
    /// Thresholds and aims.
    pub settings: &'a Settings,
}

impl Planner<'_> {
    /// Chooses the beamlets, given the rays that reach the target.
    ///
    /// Where no width meets the target error, thresholds aim at the error that can be reached: finer ones would
    /// cost work and gain nothing.
    ///
    /// # Errors
    /// When the error of no width is a number.
    pub(crate) fn plan(&self, search: &DirectionSearch) -> Result<BeamletPlan, PlanError> {
        let sample_rays = sample_rays(search);
        let relevant = self.relevant_rays(&sample_rays);
        let widths = self.widths(&sample_rays);
        let beside = self.rays_beside(&sample_rays);
        let errors = WidthErrors {
            hop: self.hop,
            to: self.to,
            weight: |ray: &SearchRay| self.weight(ray),
        };
        let found = widths
            .iter()
            .map(|&sigma| (sigma, errors.at(&relevant, &beside, sigma)))
            .collect::<Vec<_>>();

        let not_finite = || PlanError::NotFinite {
            from: self.hop.from.name.clone(),
            to: self.hop.to.name.clone(),
        };
        let first = self
            .choose(search, &sample_rays, &found)
            .ok_or_else(not_finite)?;
        if first.expected_error() <= self.settings.target_error {
            let first = self.complete(first, widths);
            return Ok(self.reported(first, &relevant, &beside));
        }
        // What can be reached is found alike for all targets, so that all that miss it get the same plan.
        let finest = Planner {
            settings: &self.settings.aiming_at(FINEST),
            ..*self
        };
        let best = finest
            .choose(search, &sample_rays, &found)
            .ok_or_else(not_finite)?;
        let attainable = best
            .error_of_beamlets()
            .max(BESIDE_DISCARDED * best.dropped);
        let settings = self
            .settings
            .aiming_at(attainable.max(self.settings.target_error));
        let relaxed = Planner {
            settings: &settings,
            ..*self
        };
        let chosen = relaxed.choose(search, &sample_rays, &found);
        let chosen = relaxed.complete(chosen.ok_or_else(not_finite)?, widths);
        Ok(self.reported(chosen, &relevant, &beside))
    }

    /// The chosen plan with the errors of the light that comes through the aperture. Rays of the search start all over the
    /// box about it, and at its corners they may meet rims: where the width is chosen, that is a margin.
    fn reported(
        &self,
        mut chosen: BeamletPlan,
        relevant: &[SearchRay],
        beside: &[SearchRay],
    ) -> BeamletPlan {
        let lit = |rays: &[SearchRay]| {
            let inside = rays.iter().filter(|ray| passes(self.hop.from, ray.at));
            inside.copied().collect::<Vec<_>>()
        };
        let errors = WidthErrors {
            hop: self.hop,
            to: self.to,
            weight: |ray: &SearchRay| self.weight(ray),
        };
        let found = errors.at(&lit(relevant), &lit(beside), chosen.sigma);
        let all = [found.eta, found.eta_corrected, found.cubic, found.dropped];
        if all.iter().all(|error| error.is_finite()) {
            [
                chosen.eta,
                chosen.eta_corrected,
                chosen.cubic,
                chosen.dropped,
            ] = all;
        }
        chosen
    }

    /// The plan with what can be found only for the width that was chosen.
    fn complete(&self, mut chosen: BeamletPlan, widths: Vec<f64>) -> BeamletPlan {
        let ends = [widths.first(), widths.last()];
        chosen.at_limit = widths.len() > 1 && ends.contains(&Some(&chosen.sigma));

        // With the footprint known, take in the directions that only its rim brings to the target, from
        // all places that have a patch.
        let beside = 0.5 * chosen.period;
        let [x0, x1, y0, y1] = self.from;
        let places = [x0 - beside, x1 + beside, y0 - beside, y1 + beside];
        let goal = match chosen.correct {
            true => SearchGoal::Bounds(ALL),
            false => SearchGoal::Rim,
        };
        let margin = [MARGIN * chosen.footprint; 2];
        let wider = search_directions(self.hop, places, self.to, margin, goal);
        chosen.bands = self.bands(&wider, chosen.period);
        chosen.doubtful_rim = chosen.correct || self.is_doubtful(&wider, chosen.sigma);

        // Work is estimated more closely than for the choice.
        chosen.work = self.workload(&chosen, self.spacing(chosen.arriving));
        chosen
    }

    /// The lattice of directions that a search has found, at a patch period in mm.
    pub(crate) fn bands(&self, search: &DirectionSearch, period: f64) -> [Band; 2] {
        let p = search.band.map(|p| if p.is_finite() { p } else { 0.0 });
        let spacing = self.hop.wavelength / period;
        [
            Band::between(self.light.chief[0], spacing, p[0], p[1]),
            Band::between(self.light.chief[1], spacing, p[2], p[3]),
        ]
    }

    /// Whether some ray that lands beside the target has more aberration than its tail may have.
    fn is_doubtful(&self, search: &DirectionSearch, sigma: f64) -> bool {
        let stride = search.rim.len().div_ceil(SAMPLE_RAYS).max(1);
        let k = self.hop.wavenumber();
        search.rim.iter().step_by(stride).any(|ray| {
            aberration(self.hop, ray.at, ray.p, sigma, k)
                .is_none_or(|found| found.eta() > TRUSTED_TAIL)
        })
    }

    /// The rays that sample the errors: where stops follow, those that lead through them to the sensor,
    /// sought on their own because they may be few among all; else `sample_rays`.
    fn relevant_rays(&self, sample_rays: &[SearchRay]) -> Vec<SearchRay> {
        let here = |ray: &SearchRay| {
            let (landing, jacobian) = self.hop.jacobian(ray.at, ray.p).ok()?;
            let ray = SearchRay {
                landing,
                jacobian,
                ..*ray
            };
            let relevant = self.downstream.is_relevant(landing.at, landing.cosines);
            relevant.then_some(ray)
        };
        let sought = || {
            let (train, to) = self.downstream.joined(self.hop)?;
            let joined = Hop {
                train: &train,
                to,
                ..*self.hop
            };
            let search =
                search_directions(&joined, self.from, to.bounds()?, [0.0; 2], SearchGoal::Rays);
            Some(search.rays.iter().filter_map(here).collect::<Vec<_>>())
        };
        match sought() {
            Some(rays) if !rays.is_empty() => thinned(&rays),
            _ => sample_rays.to_vec(),
        }
    }

    /// Distance of the points summed on the target, where light has these largest cosines.
    pub(crate) fn spacing(&self, arriving: [f64; 2]) -> [f64; 2] {
        let nyquist = arriving.map(|p| self.hop.wavelength / (3.0 * p.max(1e-3)));
        self.pitch.unwrap_or(nyquist)
    }

    /// The weight of a sample ray: how much light goes its way, if that light can reach the sensor.
    pub(crate) fn weight(&self, ray: &SearchRay) -> f64 {
        let relevant = self
            .downstream
            .is_relevant(ray.landing.at, ray.landing.cosines);
        let share = if relevant { 1.0 } else { IRRELEVANT };
        self.envelope.weight(ray.p) * ray.area * share
    }

    /// Rays that land beside the sensor, whose beamlets' tails fall on it; none where other screens follow.
    fn rays_beside(&self, sample_rays: &[SearchRay]) -> Vec<SearchRay> {
        if !matches!(self.hop.to.kind, ScreenKind::Sensor(_)) {
            return Vec::new();
        }
        // The same rays whatever the target error is, so that a tighter one gives the same errors.
        let settings = Settings {
            footprint_threshold: Some((-0.5 * FARTHEST * FARTHEST).exp()),
            ..self.settings.clone()
        };
        let alike = Planner {
            settings: &settings,
            ..*self
        };
        let start = starting_width(self.hop, self.from, sample_rays);
        let sigma = self.settings.sigma.unwrap_or(start);
        let footprint = alike.arrival(sample_rays, sigma).footprint;
        let margin = [MARGIN * footprint; 2];
        let wider = search_directions(self.hop, self.from, self.to, margin, SearchGoal::Rim);
        thinned(&wider.rim)
    }

    /// What arrives: half width of the footprints on the target, of which 95 % of the light has smaller
    /// ones, and direction cosines there, the beamlets' own spread included.
    pub(crate) fn arrival(&self, sample_rays: &[SearchRay], sigma: f64) -> Arrived {
        let k = self.hop.wavenumber();
        let threshold = self.settings.footprint_edge();
        let mut footprints = Vec::new();
        let mut cosines = [Vec::new(), Vec::new()];
        let mut largest = [0.0f64; 2];
        for ray in sample_rays {
            let Ok(arrival) = launch_beamlet(self.hop, ray.at, ray.p, sigma) else {
                continue;
            };
            let weight = self.weight(ray);
            let [x, y] = arrival.footprint(k, threshold);
            footprints.push((x.max(y), weight));
            let spread = arrival.spread(k, threshold);
            for a in 0..2 {
                let p = arrival.cosines[a].abs() + spread[a];
                largest[a] = largest[a].max(p);
                cosines[a].push((p, weight));
            }
        }
        let n = self.hop.to.index;
        Arrived {
            footprint: weighted_quantile(footprints, 0.95),
            largest: largest.map(|p| p.min(n)),
            usual: cosines.map(|list| weighted_quantile(list, 0.95).min(n)),
        }
    }
}

/// What a width brings to the target.
pub(crate) struct Arrived {
    /// Half width of a typical footprint, in mm.
    pub footprint: f64,
    /// Largest |p|.
    pub largest: [f64; 2],
    /// |p| below which most of the light stays.
    pub usual: [f64; 2],
}

/// The rays of a search that sample its errors.
pub(crate) fn sample_rays(search: &DirectionSearch) -> Vec<SearchRay> {
    thinned(&search.rays)
}

/// Evenly spaced rays of a list, at most as many as are sampled; each represents the light of those left out.
fn thinned(rays: &[SearchRay]) -> Vec<SearchRay> {
    let stride = rays.len().div_ceil(SAMPLE_RAYS).max(1);
    let one = |ray: &SearchRay| SearchRay {
        area: ray.area * stride as f64,
        ..*ray
    };
    rays.iter().step_by(stride).map(one).collect()
}

impl BeamletPlan {
    /// The bounds of its directions, `[p_x low, p_x high, p_y low, p_y high]`, and half a spacing more.
    pub(crate) fn limits(&self) -> [f64; 4] {
        let [[x0, x1], [y0, y1]] = self.bands.map(|band| {
            let beside = 0.5 * band.spacing;
            [
                band.at(0) - beside,
                band.at(band.count.saturating_sub(1)) + beside,
            ]
        });
        [x0, x1, y0, y1]
    }

    /// The error to expect: that of beamlets and that of tails which are discarded.
    pub(crate) fn expected_error(&self) -> f64 {
        self.error_of_beamlets().hypot(self.dropped)
    }

    /// The error to expect from aberration inside beamlets, with the correction if it is applied, and from
    /// windows and period.
    pub(crate) fn error_of_beamlets(&self) -> f64 {
        let left = if self.correct {
            self.eta_corrected
        } else {
            self.eta
        };
        left.hypot(self.window_error(self.cubic))
    }

    /// The part of dropped modes that shows in the field, as a ratio of amplitudes: there are (period/step)² times more modes
    /// than the field has numbers, and the sum over patches cancels what no field has.
    pub(crate) fn share_of_dropped(&self) -> f64 {
        self.step / self.period
    }

    /// The error to expect from windows and period alone, for the cubic phase `cubic` (rad).
    pub(crate) fn window_error(&self, cubic: f64) -> f64 {
        window_error(self.step / self.sigma, self.period / self.sigma, cubic)
    }
}
