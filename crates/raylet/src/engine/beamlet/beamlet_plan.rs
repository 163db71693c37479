//! The plan of a beamlet sum: width, positions and directions, and what they will cost.
//!
//! The width is chosen by real rays: their aberration inside one beamlet, as a function of σ, against
//! the work that σ takes.

use crate::engine::beamlet::beamlet_aberration::aberration;
use crate::engine::beamlet::beamlet_error::{ExpectedErrors, FARTHEST, TRUSTED_TAIL, WidthErrors};
use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::window_error::window_error;
use crate::engine::plan::direction_spread::{
    DirectionEnvelope, LightDirections, weighted_quantile,
};
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::{Correction, Settings};
use crate::engine::trace::direction_search::{
    ALL, DirectionSearch, SearchGoal, SearchRay, search_directions,
};
use crate::optics::screen::Act;
use crate::optics::system::Hop;
use crate::wave::patches::patch::Band;
use crate::wave::patches::window::Positions;

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
    /// Rays that the plan expects to follow.
    pub rays: f64,
    /// Seconds on one core that it expects.
    pub seconds: f64,
}

/// Measured on one core of a 3 GHz processor: seconds per beamlet traced, per ray of the aberration
/// estimate, and per value summed. They only shape the choice between equal errors.
const BEAMLET_SECONDS: f64 = 4e-7;
const ESTIMATE_SECONDS: f64 = 7e-6;
const VALUE_SECONDS: f64 = 6e-10;

/// The widths tried, σ₀·2^{j/4}.
const WIDTHS: std::ops::RangeInclusive<i32> = -6..=4;

/// The distances of windows tried, in σ.
const STEPS: [f64; 5] = [1.1, 1.25, 1.5, 1.75, 2.0];

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
            return Ok(self.complete(first, widths));
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
        Ok(relaxed.complete(chosen.ok_or_else(not_finite)?, widths))
    }

    /// The widths to try.
    fn widths(&self, sample_rays: &[SearchRay]) -> Vec<f64> {
        if let Some(sigma) = self.settings.sigma {
            return vec![sigma];
        }
        let start = starting_width(self.hop, self.from, sample_rays);
        WIDTHS
            .map(|j| start * 2f64.powf(0.25 * f64::from(j)))
            .collect()
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
        let work = self.workload(&chosen, self.spacing(chosen.arriving));
        (chosen.rays, chosen.seconds) = (work.rays, work.seconds);
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

    /// What a width with these errors would give, with windows at each distance, and its cost on the sample rays of
    /// all light.
    fn candidates(
        &self,
        search: &DirectionSearch,
        sample_rays: &[SearchRay],
        sigma: f64,
        expected: ExpectedErrors,
    ) -> Vec<BeamletPlan> {
        let settings = self.settings;
        let Arrived {
            footprint,
            largest: arriving,
            usual,
        } = self.arrival(sample_rays, sigma);
        let correct = match settings.correction {
            Correction::On => true,
            Correction::Off => false,
            Correction::Auto => expected.eta > 0.1 * settings.target_error,
        };

        // Cost: positions × directions, each traced once and summed over its footprint.
        let period = settings.patch_period() * sigma;
        let bands = self.bands(search, period);
        let rays = |step: f64| {
            let positions = |a: usize| {
                let edges = [self.from[2 * a], self.from[2 * a + 1]];
                Positions::cover(edges, sigma, step * sigma, 0.5 * period).count
            };
            let counts = [positions(0), positions(1), bands[0].count, bands[1].count];
            counts.map(|count| count as f64).iter().product::<f64>()
        };
        let spacing = self.spacing(arriving);
        let values = std::f64::consts::PI * footprint * footprint / (spacing[0] * spacing[1]);
        let estimate = if correct { ESTIMATE_SECONDS } else { 0.0 };
        let each = BEAMLET_SECONDS + estimate + values * VALUE_SECONDS;
        let at = |step: f64| BeamletPlan {
            sigma,
            step: step * sigma,
            period,
            target_error: settings.target_error,
            bands,
            correct,
            at_limit: false,
            doubtful_rim: true,
            eta: expected.eta,
            eta_corrected: expected.eta_corrected,
            cubic: expected.cubic,
            dropped: expected.dropped,
            footprint,
            arriving,
            usual,
            rays: rays(step),
            seconds: rays(step) * each,
        };
        let given = settings.step.map(|step| vec![step]);
        let steps = given.unwrap_or_else(|| STEPS.to_vec());
        steps.into_iter().map(at).collect()
    }

    /// Distance of the points summed on the target, where light has these largest cosines.
    fn spacing(&self, arriving: [f64; 2]) -> [f64; 2] {
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
        if !matches!(self.hop.to.act, Act::Sensor(_)) {
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

/// σ₀ = (k‖∂p′/∂x‖)^{−1/2}, the width whose beamlets spread least behind the train's power, by the
/// median of the search; without power √(‖∂s/∂p‖/k), and never more than a quarter of the screen.
pub(crate) fn starting_width(hop: &Hop, from: [f64; 4], sample_rays: &[SearchRay]) -> f64 {
    let k = hop.wavenumber();
    let wavelength = hop.wavelength;
    let norm = |ray: &SearchRay, row: usize, column: usize| {
        let j = &ray.jacobian;
        let squares = (0..2).flat_map(|a| (0..2).map(move |b| j[row + a][column + b].powi(2)));
        (0.5 * squares.sum::<f64>()).sqrt()
    };
    let median = |row: usize, column: usize| {
        let mut values: Vec<f64> = sample_rays
            .iter()
            .map(|ray| norm(ray, row, column))
            .collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (power, throw) = (median(2, 0), median(0, 2));
    let by_power = (k * power).powf(-0.5);
    let by_throw = (throw / k).sqrt().max(3.0 * wavelength);
    let [x0, x1, y0, y1] = from;
    let largest = 0.25 * (x1 - x0).max(y1 - y0);
    let powered = power * throw > 1e-3;
    let start = if powered {
        by_power
    } else {
        by_power.min(by_throw)
    };
    start.min(largest).max(1.5 * wavelength)
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
    fn error_of_beamlets(&self) -> f64 {
        let left = if self.correct {
            self.eta_corrected
        } else {
            self.eta
        };
        left.hypot(self.window_error(self.cubic))
    }

    /// The error to expect from windows and period alone, for the cubic phase `cubic` (rad).
    pub(crate) fn window_error(&self, cubic: f64) -> f64 {
        window_error(self.step / self.sigma, self.period / self.sigma, cubic)
    }
}

/// Share of the target error that aberration and windows may have.
const SHARE: f64 = 0.5;

/// A plan is as accurate as the best one within this factor.
const ALIKE: f64 = 1.5;

/// Share of the least error that windows may add where no plan is within the target.
const WINDOWS: f64 = 0.1;

impl Planner<'_> {
    /// The cheapest plan within its share of the target error, or else of those as accurate as the best and
    /// with windows that add little to it; none where no error is a number. The list holds each width with its
    /// errors.
    fn choose(
        &self,
        search: &DirectionSearch,
        sample_rays: &[SearchRay],
        widths: &[(f64, ExpectedErrors)],
    ) -> Option<BeamletPlan> {
        let at_width = |&(sigma, expected): &(f64, ExpectedErrors)| {
            self.candidates(search, sample_rays, sigma, expected)
        };
        let mut candidates: Vec<_> = widths.iter().flat_map(at_width).collect();
        let aim = SHARE * self.settings.target_error;
        let errors = candidates.iter().map(BeamletPlan::error_of_beamlets);
        let least = errors.fold(f64::INFINITY, f64::min);
        candidates.retain(|plan| plan.error_of_beamlets() <= aim.max(ALIKE * least));
        if least > aim {
            let windows = |plan: &BeamletPlan| plan.window_error(plan.cubic);
            let best = candidates.iter().map(windows).fold(f64::INFINITY, f64::min);
            let limit = best.max(aim).max(WINDOWS * least);
            candidates.retain(|plan| windows(plan) <= limit);
        }
        candidates
            .into_iter()
            .min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }
}
