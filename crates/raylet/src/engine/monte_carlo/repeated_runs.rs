//! A random run in parts: each has a seed of its own and is an estimate of the whole field, and their mean is
//! what one run of all positions estimates. A part can be looked at, kept, and added to later.

use std::time::Instant;

use ndarray::{Array2, Zip};
use num_complex::Complex64;

use crate::engine::chain::outcome::Progress;
use crate::engine::chain::simulate::simulate;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::Reply;
use crate::optics::system::System;
use crate::wave::grid::field::Field;

/// The parts of a random run so far.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatedRuns {
    /// Sum of the parts' fields.
    pub sum: Array2<Complex64>,
    /// Sum of their squared moduli, over all samples.
    pub squares: f64,
    /// Number of parts.
    pub parts: usize,
    /// Draws, and rays that were followed for them: equal draws of a position are one ray.
    pub draws: f64,
    /// Rays followed.
    pub rays: u64,
    /// Seconds.
    pub seconds: f64,
}

impl RepeatedRuns {
    /// No part yet, for a sensor of [ny, nx] samples.
    pub fn new(shape: [usize; 2]) -> Self {
        Self {
            sum: Array2::zeros(shape),
            squares: 0.0,
            parts: 0,
            draws: 0.0,
            rays: 0,
            seconds: 0.0,
        }
    }

    /// Adds a part: the system by these settings, whose seed is moved on by the parts before.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn add<R: Reply>(
        &mut self,
        system: &System,
        settings: &Settings,
        progress: &(dyn Fn(Progress) -> R + Sync),
    ) -> Result<(), SimulateError> {
        let clock = Instant::now();
        let settings = Settings {
            seed: settings.seed + self.parts as u64,
            ..settings.clone()
        };
        let outcome = simulate(system, &settings, progress)?;
        let Field { values, .. } = outcome.field;
        self.squares += values.iter().map(|u| u.norm_sqr()).sum::<f64>();
        Zip::from(&mut self.sum)
            .and(&values)
            .for_each(|sum, u| *sum += u);
        self.parts += 1;
        for hop in &outcome.hops {
            self.draws += hop.method.rays();
            self.rays += hop.tally.total_rays();
        }
        self.seconds += clock.elapsed().as_secs_f64();
        Ok(())
    }

    /// The mean of the parts.
    pub fn mean(&self) -> Array2<Complex64> {
        self.sum.mapv(|u| u / self.parts.max(1) as f64)
    }

    /// The standard error of the mean over its norm, from how the parts differ; nothing for a single one.
    pub fn standard_error(&self) -> Option<f64> {
        let count = self.parts as f64;
        let whole = self.sum.iter().map(|u| u.norm_sqr()).sum::<f64>() / (count * count);
        let spread = (self.squares - count * whole).max(0.0) / (count * (count - 1.0));
        (self.parts > 1 && whole > 0.0).then(|| (spread / whole).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::engine::chain::simulate::simulate;
    use crate::engine::monte_carlo::repeated_runs::RepeatedRuns;
    use crate::engine::plan::settings::{Method, Paper, Positions, Sampler, Settings};
    use crate::fixtures::paper_systems::near_hologram;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::wave::grid::metrics::field_error;

    /// The mean comes as near to the field with all modes as its standard error says.
    #[test]
    fn parts_differ_as_their_mean_errs_slow() {
        let phase = Array2::from_shape_fn((20, 20), |(j, i)| (i * i + 3 * j) as f64);
        let system = near_hologram(&phase, PixelForm::Point);
        let settings = |sampler| Settings {
            method: Method::Paper,
            paper: Paper {
                rays: 1,
                secondary: 2000,
                patch: Some(0.126),
                positions: Positions::Grid,
                sampler,
                ..Paper::default()
            },
            ..Settings::default()
        };
        let all = simulate(&system, &settings(Sampler::All), &|_| {}).unwrap();
        let mut repeats = RepeatedRuns::new([20, 20]);
        assert_eq!(repeats.standard_error(), None);
        for _ in 0..20 {
            repeats
                .add(&system, &settings(Sampler::Multinomial), &|_| {})
                .unwrap();
        }
        let error = field_error(repeats.mean().view(), all.field.values.view()).unwrap();
        let said = repeats.standard_error().unwrap();
        assert!((error / said - 1.0).abs() < 0.2, "{error:e} {said:e}");
        assert_eq!(repeats.draws, 40_000.0);
        assert!(repeats.rays < 40_000);
    }
}
