//! The choice of the width σ of beamlets, and of the distance of their windows.
//!
//! Each width has an error, found by real rays, and takes work. The choice is the cheapest width whose error is within its
//! share of the target; of widths that take equally long, the most accurate one. Work is counted in seconds of single rays
//! (`cost_model.rs`).

use crate::engine::beamlet::beamlet_error::ExpectedErrors;
use crate::engine::beamlet::beamlet_plan::{Arrived, BeamletPlan, Planner};
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::plan::settings::Correction;
use crate::engine::plan::work::Work;
use crate::engine::trace::direction_search::{DirectionSearch, SearchRay};
use crate::wave::patches::window::Positions;

/// The widths tried, σ₀·2^{j/4}.
const WIDTHS: std::ops::RangeInclusive<i32> = -6..=4;

/// The distances of windows tried, in σ.
const STEPS: [f64; 5] = [1.1, 1.25, 1.5, 1.75, 2.0];

/// Share of the target error that aberration and windows may have.
const SHARE: f64 = 0.5;

/// A plan is as accurate as the best one within this factor.
const ALIKE: f64 = 1.5;

/// Plans whose forecast seconds differ by less than this factor take equally long: forecasts are not more accurate.
const AS_FAST: f64 = 1.15;

/// Share of the least error that windows may add where no plan is within the target.
const WINDOWS: f64 = 0.1;

impl Planner<'_> {
    /// The widths to try.
    pub(crate) fn widths(&self, sample_rays: &[SearchRay]) -> Vec<f64> {
        if let Some(sigma) = self.settings.sigma {
            return vec![sigma];
        }
        let start = starting_width(self.hop, self.from, sample_rays);
        WIDTHS
            .map(|j| start * 2f64.powf(0.25 * f64::from(j)))
            .collect()
    }

    /// The cheapest plan within its share of the target error, or else of those as accurate as the best and
    /// with windows that add little to it; none where no error is a number. The list holds each width with its
    /// errors.
    pub(crate) fn choose(
        &self,
        search: &DirectionSearch,
        sample_rays: &[SearchRay],
        widths: &[(f64, ExpectedErrors)],
    ) -> Option<BeamletPlan> {
        let at_width = |&(sigma, expected): &(f64, ExpectedErrors)| {
            self.candidates(search, sample_rays, sigma, expected)
        };
        let mut candidates: Vec<_> = widths.iter().flat_map(at_width).collect();
        let share = SHARE * self.settings.target_error;
        let errors = candidates.iter().map(BeamletPlan::error_of_beamlets);
        let least = errors.fold(f64::INFINITY, f64::min);
        candidates.retain(|plan| plan.error_of_beamlets() <= share.max(ALIKE * least));
        if least > share {
            let windows = |plan: &BeamletPlan| plan.window_error(plan.cubic);
            let best = candidates.iter().map(windows).fold(f64::INFINITY, f64::min);
            let limit = best.max(share).max(WINDOWS * least);
            candidates.retain(|plan| windows(plan) <= limit);
        }

        // The most accurate one of those that take as long as the cheapest.
        let seconds = candidates.iter().map(|plan| plan.work.seconds);
        let fastest = seconds.fold(f64::INFINITY, f64::min);
        candidates.retain(|plan| plan.work.seconds <= AS_FAST * fastest);
        let errors = |plan: &BeamletPlan| plan.error_of_beamlets();
        candidates
            .into_iter()
            .min_by(|a, b| errors(a).total_cmp(&errors(b)))
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
                Positions::covering(edges, sigma, step * sigma, 0.5 * period).count
            };
            let counts = [positions(0), positions(1), bands[0].count, bands[1].count];
            counts.map(|count| count as f64).iter().product::<f64>()
        };
        let spacing = self.spacing(arriving);
        let values = std::f64::consts::PI * footprint * footprint / (spacing[0] * spacing[1]);
        let each = self.cost_of_beamlet(correct, values);
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
            work: Work {
                rays: rays(step),
                values: rays(step) * values,
                seconds: rays(step) * each,
            },
        };
        let given = settings.step.map(|step| vec![step]);
        let steps = given.unwrap_or_else(|| STEPS.to_vec());
        steps.into_iter().map(at).collect()
    }
}
