//! Beamlets that are drawn instead of followed all: estimates of a hop and of its transpose.
//!
//! Of the K modes c of a patch N are drawn. Without replacement a mode has the probability π of being among them and
//! brings c/π; drawn independently with π = |c|/Σ|c| it brings c/(Nπ) each time. In both the mean is the exact sum.
//! The adjoint holds the draws and their probabilities constant, as the source paper's public code does. The paper's
//! text instead draws the largest of log π + Gumbel noise, and differentiates the soft maximum of which this is the
//! limit (straight through: Jang, Gu and Poole, ICLR 2017); its cost is N·K a patch, and its mean is not the
//! gradient.

use ndarray::{Array2, Zip};
use num_complex::Complex64;

use crate::math::draw::{draw, inclusion, systematic};
use crate::math::hilbert::hilbert_order;
use crate::math::random::{Purpose, pair, uniform};

/// How modes are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drawing {
    /// Without replacement, at equal distances of summed probability along Hilbert's curve: half of the
    /// probability in proportion to |c|, half alike for all, since what a mode means for a gradient does not
    /// depend on how strong it is.
    WithoutReplacement,
    /// Independently, in proportion to |c|.
    Multinomial,
    /// The same draws, with the gradient of a soft maximum of this temperature.
    Gumbel {
        /// Temperature: the gradient's variance grows as it falls, its bias as it grows.
        temperature: f64,
    },
}

/// The draws of a run: rule, number and seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draws {
    /// Rule by which modes are drawn.
    pub drawing: Drawing,
    /// Number of draws from each patch.
    pub each: usize,
    /// Seed; another one for every evaluation.
    pub seed: u64,
}

/// The draws of one patch of one hop.
#[derive(Clone, Copy, Debug)]
pub struct PatchDraws {
    /// The draws.
    pub draws: Draws,
    /// Number of the hop, and of the patch.
    pub at: [u32; 2],
}

/// What random numbers are drawn for.
const BEAMLET: u32 = Purpose::DrawnBeamlet as u32;
const NOISE: u32 = Purpose::DrawnNoise as u32;

impl PatchDraws {
    /// By what each mode is multiplied, [m_y, m_x]: zero where it is not drawn.
    pub(crate) fn weights(&self, modes: &Array2<Complex64>) -> Array2<f64> {
        let size: Vec<f64> = modes.iter().map(|c| c.norm()).collect();
        let total: f64 = size.iter().sum();
        let mut weights = Array2::zeros(modes.raw_dim());
        if size.is_empty() || total == 0.0 {
            return weights;
        }
        let each = self.draws.each as f64;
        let shape = [modes.ncols(), modes.nrows()];
        let mut give = |index: usize, weight: f64| {
            weights[[index / shape[0], index % shape[0]]] = weight;
        };
        match self.draws.drawing {
            Drawing::WithoutReplacement => {
                let mean = total / size.len() as f64;
                let mixed: Vec<f64> = size.iter().map(|size| size + mean).collect();
                let expected = inclusion(&mixed, self.draws.each);
                let offset = uniform(self.draws.seed, [BEAMLET, self.at[0], self.at[1], 0]);
                for index in systematic(&expected, &hilbert_order(shape), offset) {
                    give(index, 1.0 / expected[index]);
                }
            }
            Drawing::Multinomial => {
                for (index, count) in draw(&size, &self.numbers()) {
                    let index = index as usize;
                    give(index, f64::from(count) * total / (each * size[index]));
                }
            }
            Drawing::Gumbel { .. } => {
                let mut counts = vec![0u32; size.len()];
                (0..self.draws.each as u32)
                    .filter_map(|draw| largest(&self.scores(&size, draw)))
                    .for_each(|index| counts[index] += 1);
                for (index, count) in counts.into_iter().enumerate().filter(|(_, c)| *c > 0) {
                    give(index, f64::from(count) * total / (each * size[index]));
                }
            }
        }
        weights
    }

    /// The cotangent of the modes from that of the field, given as b, its product with each mode's conjugate
    /// beamlet: [m_y, m_x] as the modes. For linear estimates the conjugate transpose of the weights;
    /// `drawn_dot_product` in the crate's tests holds it.
    pub fn weights_adjoint(
        &self,
        modes: &Array2<Complex64>,
        b: &Array2<Complex64>,
    ) -> Array2<Complex64> {
        let weights = self.weights(modes);
        match self.draws.drawing {
            Drawing::WithoutReplacement | Drawing::Multinomial => b * &weights,
            Drawing::Gumbel { temperature } => self.soft(modes, b, &weights, temperature),
        }
    }

    /// Straight through: a draw of mode m brings z = e^{iθ}Σ|c|/N, so that the draws' part is that of θ and of the
    /// sum; which mode is drawn has the derivative of the soft maximum.
    fn soft(
        &self,
        modes: &Array2<Complex64>,
        b: &Array2<Complex64>,
        weights: &Array2<f64>,
        temperature: f64,
    ) -> Array2<Complex64> {
        let size: Vec<f64> = modes.iter().map(|c| c.norm()).collect();
        let total: f64 = size.iter().sum();
        let each = self.draws.each as f64;

        // Re(b*z) of every mode: what one more draw of it would change.
        let unit = |c: &Complex64| if c.norm() > 0.0 { c / c.norm() } else { *c };
        let gains: Vec<f64> = modes
            .iter()
            .zip(b)
            .map(|(c, b)| (b.conj() * unit(c)).re * total / each)
            .collect();
        let mut scores_bar = vec![0.0; size.len()];
        for draw in 0..self.draws.each as u32 {
            let soft = softmax(&self.scores(&size, draw), temperature);
            let mean: f64 = soft.iter().zip(&gains).map(|(y, gain)| y * gain).sum();
            for ((bar, y), gain) in scores_bar.iter_mut().zip(&soft).zip(&gains) {
                *bar += y * (gain - mean) / temperature;
            }
        }

        // The sum Σ|c| is a factor of all; θ is that of the draws.
        let counted = Zip::from(modes).and(b).and(weights);
        let factor: f64 = counted.fold(0.0, |sum, c, b, w| sum + (b.conj() * c * *w).re) / total;
        let mut bar = Array2::zeros(modes.raw_dim());
        Zip::from(&mut bar)
            .and(modes)
            .and(b)
            .and(weights)
            .for_each(|bar, c, b, weight| {
                let along = unit(c);
                // Only what turns c: i·Im.
                let turn = (along.conj() * b * *weight).im;
                *bar = along * Complex64::new(factor, turn);
            });
        for ((bar, c), score) in bar.iter_mut().zip(modes).zip(scores_bar) {
            let square = c.norm_sqr();
            if square > 0.0 {
                *bar += c * (score / square);
            }
        }
        bar
    }

    /// log|c| with the noise of one draw; minus infinity for modes without light.
    fn scores(&self, size: &[f64], draw: u32) -> Vec<f64> {
        let noise = |index: usize| {
            let at = [NOISE | (self.at[0] << 8), draw, self.at[1], index as u32];
            let u = uniform(self.draws.seed, at).max(f64::MIN_POSITIVE);
            -(-u.ln()).ln()
        };
        let score = |(index, size): (usize, &f64)| size.ln() + noise(index);
        size.iter().enumerate().map(score).collect()
    }

    /// A random number for each draw.
    fn numbers(&self) -> Vec<f64> {
        (0..self.draws.each.div_ceil(2) as u32)
            .flat_map(|n| pair(self.draws.seed, [BEAMLET, self.at[0], self.at[1], n + 1]))
            .take(self.draws.each)
            .collect()
    }
}

/// The place of the largest score; nothing where there is none.
fn largest(scores: &[f64]) -> Option<usize> {
    let best = scores
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))?;
    best.1.is_finite().then_some(best.0)
}

/// e^{s/T} over its sum.
fn softmax(scores: &[f64], temperature: f64) -> Vec<f64> {
    let top = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut soft: Vec<f64> = scores
        .iter()
        .map(|score| ((score - top) / temperature).exp())
        .collect();
    let sum: f64 = soft.iter().sum();
    soft.iter_mut().for_each(|y| *y /= sum);
    soft
}
