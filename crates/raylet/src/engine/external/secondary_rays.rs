//! The secondary rays of a diffractive element, and which of a patch's modes become rays.

use std::ops::Range;

use num_complex::Complex64;

use crate::engine::external::scatter_settings::Drawing;
use crate::engine::plan::settings::Sampler;
use crate::math::draw::{draw, inclusion, systematic};
use crate::math::hilbert::hilbert_order;
use crate::math::random::{Purpose, pair, uniform};

/// Secondary rays, in arrays of one length; those of one parent stand together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SecondaryRays {
    /// Index of the arriving ray that each comes from.
    pub parent: Vec<usize>,
    /// Starting point of each ray on the element, in mm, global.
    pub position: Vec<[f64; 3]>,
    /// Unit direction of travel, global.
    pub direction: Vec<[f64; 3]>,
    /// Optical path so far, in mm: that of its parent.
    pub path: Vec<f64>,
    /// Complex weight, the parent's included, without the phase of the path.
    pub weight: Vec<Complex64>,
    /// W (xx, xy, yy) in mm⁻² of the window exp(−½uᵀWu) with which a beamlet starts, on the axes of the
    /// plane that touches the element there (`Screen::tangent`): 1/σ² on a plane. Zero for square windows.
    pub window: Vec<[f64; 3]>,
    /// Cosine against the element's normal, positive.
    pub cosine: Vec<f64>,
    /// √(Σ|c|² below the threshold / Σ|c|²): the share of the field that was left out.
    pub dropped: f64,
    /// Mode of each ray: its indices [m_y, m_x] in the patch of its parent.
    pub mode: Vec<[usize; 2]>,
    /// How often the mode was drawn over how often it was expected; held constant in gradients.
    pub times: Vec<f64>,
}

impl SecondaryRays {
    /// Number of rays.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parent.is_empty()
    }

    /// The rays of all arriving rays, from those of each and its energies: Σ|c|² above the threshold and altogether.
    pub(crate) fn gathered(parts: Vec<(Self, [f64; 2])>) -> Self {
        let (mut all, mut energy) = (Self::default(), [0.0; 2]);
        for (part, [kept, total]) in parts {
            all.append(part);
            energy = [energy[0] + kept, energy[1] + total];
        }
        if energy[1] > 0.0 {
            all.dropped = (1.0 - energy[0] / energy[1]).max(0.0).sqrt();
        }
        all
    }

    /// Adds other rays behind these; what they dropped is not taken over.
    pub fn append(&mut self, mut other: SecondaryRays) {
        self.parent.append(&mut other.parent);
        self.position.append(&mut other.position);
        self.direction.append(&mut other.direction);
        self.path.append(&mut other.path);
        self.weight.append(&mut other.weight);
        self.window.append(&mut other.window);
        self.cosine.append(&mut other.cosine);
        self.mode.append(&mut other.mode);
        self.times.append(&mut other.times);
    }

    /// Ranges of rays with one parent.
    pub(crate) fn families(&self) -> Vec<Range<usize>> {
        let mut families: Vec<Range<usize>> = Vec::new();
        for (i, parent) in self.parent.iter().enumerate() {
            match families.last_mut() {
                Some(family) if self.parent[family.start] == *parent => family.end = i + 1,
                _ => families.push(i..i + 1),
            }
        }
        families
    }
}

/// A mode of a patch that becomes a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChosenMode {
    /// Its indices [m_y, m_x].
    pub mode: [usize; 2],
    /// How often it was drawn over how often that was expected.
    pub times: f64,
}

impl Drawing {
    /// Which modes of the patch of one ray become rays, given their sizes, [m_y, m_x] in rows, with zero for
    /// those that do not.
    pub(crate) fn choose(
        &self,
        sizes: &[f64],
        (ny, nx): (usize, usize),
        ray: usize,
    ) -> Vec<ChosenMode> {
        let chosen = |index: usize, times: f64| ChosenMode {
            mode: [index / nx, index % nx],
            times,
        };
        let kept = |index: &usize| sizes[*index] > 0.0;
        let all = || {
            let indices = (0..sizes.len()).filter(kept);
            indices.map(|index| chosen(index, 1.0)).collect()
        };
        if (0..sizes.len()).filter(kept).count() <= self.most {
            return all();
        }
        let address = |number: u32| [ray as u32, number, 0, Purpose::SecondaryRay as u32];
        match self.sampler {
            Sampler::All => all(),
            Sampler::Multinomial => {
                let each = sizes.iter().sum::<f64>() / self.most as f64;
                let numbers: Vec<f64> = (0..self.most.div_ceil(2) as u32)
                    .flat_map(|number| pair(self.seed, address(number)))
                    .take(self.most)
                    .collect();
                draw(sizes, &numbers)
                    .into_iter()
                    .map(|(index, drawn)| (index as usize, f64::from(drawn)))
                    .map(|(index, drawn)| chosen(index, drawn * each / sizes[index]))
                    .collect()
            }
            Sampler::Systematic => {
                let expected = inclusion(sizes, self.most);
                let offset = uniform(self.seed, address(0));
                systematic(&expected, &hilbert_order([nx, ny]), offset)
                    .into_iter()
                    .map(|index| chosen(index, 1.0 / expected[index]))
                    .collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::external::scatter_settings::Drawing;
    use crate::engine::plan::settings::Sampler;

    /// Each sampler's mean over many rays is what all modes would give; a systematic draw is never above the
    /// requested number.
    #[test]
    fn draws_are_right_on_average() {
        let sizes: Vec<f64> = (0..35).map(|i| f64::from(i % 7) * 0.3).collect();
        for sampler in [Sampler::Systematic, Sampler::Multinomial] {
            let drawing = Drawing {
                sampler,
                most: 9,
                seed: 4,
            };
            let runs = 40_000;
            let mut mean = [0.0; 35];
            for ray in 0..runs {
                let chosen = drawing.choose(&sizes, (5, 7), ray);
                assert!(chosen.len() <= 9);
                for one in chosen {
                    mean[one.mode[0] * 7 + one.mode[1]] += one.times / runs as f64;
                }
            }
            for (mean, size) in mean.iter().zip(&sizes) {
                let expected = if *size > 0.0 { 1.0 } else { 0.0 };
                // Multinomial: variance (1/π − 1)/N of the mean of N = 9·runs draws, π ≥ 0.3/35.
                let spread = (120.0 / (9.0 * runs as f64)).sqrt();
                assert!((mean - expected).abs() < 4.0 * spread, "{sampler:?} {mean}");
            }
        }
    }

    #[test]
    fn all_are_taken_when_there_are_few() {
        let drawing = Drawing {
            sampler: Sampler::Multinomial,
            most: 3,
            seed: 1,
        };
        let chosen = drawing.choose(&[0.0, 1.0, 0.0, 2.0], (2, 2), 0);
        assert_eq!(
            chosen.iter().map(|c| c.mode).collect::<Vec<_>>(),
            [[0, 1], [1, 1]]
        );
        assert!(chosen.iter().all(|c| c.times == 1.0));
    }
}
