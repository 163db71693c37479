//! From free parameters to what a tool can make: one step forward, one step back.
//!
//! parameters → blur → blocks of pixels → relief (levels, heights) → transmission of each pixel.
//! The same step makes what is simulated in every iteration and, with all iterations done, what is
//! exported.

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

use crate::design::constraints::feature::{Blocks, Blur, FeatureError};
use crate::design::constraints::relief::Relief;

/// The limits of a fabrication tool, for pixels of any number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Pixels along a side of the blocks that have one value; 1 for none.
    pub block: usize,
    /// Radius of the conic blur, in blocks, if any.
    pub blur: Option<f64>,
    /// Levels or heights of material, if not any phase can be made.
    pub relief: Option<Relief>,
}

impl Rules {
    /// Any phase in any pixel.
    pub const NONE: Rules = Rules {
        block: 1,
        blur: None,
        relief: None,
    };
}

/// Rules for an element of a certain size.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    blocks: Blocks,
    blur: Option<Blur>,
    relief: Option<Relief>,
}

/// An element as made from parameters. Arrays are of its pixels, [y, x].
#[derive(Clone, Debug, PartialEq)]
pub struct ModulatedElement {
    /// Phase of the active part of each pixel in rad, within the relief's range if there is one.
    pub phase: Array2<f64>,
    /// Height of the relief in mm (in rad for phases on levels), if there is one.
    pub height: Option<Array2<f64>>,
    /// Mean complex transmission of each pixel.
    pub transmission: Array2<Complex64>,
    /// The phase that the relief is to make, and the share of the iterations done.
    requested: Array2<f64>,
    share: f64,
}

impl Constraints {
    /// The constraints for an element of `shape` rows and columns of pixels.
    ///
    /// # Errors
    /// When blocks or blur make no sense.
    pub fn new(rules: Rules, shape: (usize, usize)) -> Result<Self, FeatureError> {
        let blocks = Blocks::new(rules.block, shape)?;
        let blur = rules.blur.map(|radius| Blur::new(radius, blocks.coarse()));
        Ok(Self {
            blocks,
            blur: blur.transpose()?,
            relief: rules.relief,
        })
    }

    /// Rows and columns of the parameters, which are phases in rad.
    pub fn free(&self) -> (usize, usize) {
        self.blocks.coarse()
    }

    /// Whether what is made depends on the share of the iterations done.
    pub fn hardens(&self) -> bool {
        self.relief.is_some_and(|relief| relief.hardens())
    }

    /// The phases that parameters may be, where they do not wrap.
    pub fn bounds(&self) -> Option<[f64; 2]> {
        self.relief.and_then(|relief| relief.bounds())
    }

    /// Phase per height in rad/mm, if heights are made.
    pub fn per_height(&self) -> Option<f64> {
        self.relief.map(|relief| relief.factor())
    }

    /// The value of each pixel before levels: blurred, then block by block.
    pub fn spread(&self, parameters: ArrayView2<'_, f64>) -> Array2<f64> {
        match &self.blur {
            Some(blur) => self.blocks.spread(blur.soften(parameters).view()),
            None => self.blocks.spread(parameters),
        }
    }

    /// The cotangent of the parameters from that of [`Constraints::spread`].
    pub fn spread_adjoint(&self, pixels_bar: ArrayView2<'_, f64>) -> Array2<f64> {
        // pixels = blocks(blur(parameters))
        let bar = self.blocks.spread_adjoint(pixels_bar);
        match &self.blur {
            Some(blur) => blur.soften_adjoint(bar.view()),
            None => bar,
        }
    }

    /// The element, `share` of the iterations done (0 to 1: how hard soft levels are).
    pub fn make(&self, parameters: ArrayView2<'_, f64>, share: f64) -> ModulatedElement {
        let requested = self.spread(parameters);
        let height = self.relief.map(|relief| {
            let height = |phase: &f64| relief.height(*phase, share);
            Zip::from(&requested).par_map_collect(height)
        });
        let phase = match (&height, &self.relief) {
            (Some(height), Some(relief)) => height * relief.factor(),
            _ => requested.clone(),
        };
        let transmit = |phase: &f64| Complex64::cis(*phase);
        ModulatedElement {
            transmission: Zip::from(&phase).par_map_collect(transmit),
            phase,
            height,
            requested,
            share,
        }
    }

    /// The cotangent of the parameters, from those of the transmission and, where a penalty acts on it, of
    /// the phase.
    pub fn make_adjoint(
        &self,
        made: &ModulatedElement,
        transmission_bar: ArrayView2<'_, Complex64>,
        phase_bar: Option<ArrayView2<'_, f64>>,
    ) -> Array2<f64> {
        // transmission = exp(iφ): Im(t̄ e^{−iφ})
        let transmit = |phase: &f64, bar: &Complex64| (bar * Complex64::cis(-phase)).im;
        let mut bar = Zip::from(&made.phase)
            .and(transmission_bar)
            .par_map_collect(transmit);
        if let Some(phase_bar) = phase_bar {
            bar += &phase_bar;
        }

        // phase = relief(requested)
        if let Some(relief) = &self.relief {
            let share = made.share;
            Zip::from(&mut bar)
                .and(&made.requested)
                .par_for_each(|bar, requested| *bar = relief.make_adjoint(*requested, share, *bar));
        }

        // requested = blocks(blur(parameters))
        self.spread_adjoint(bar.view())
    }

    /// Parameters whose blocks have the mean direction of these phases of pixels.
    pub fn block_phases(&self, phase: ArrayView2<'_, f64>) -> Array2<f64> {
        let part = |of: fn(f64) -> f64| self.blocks.spread_adjoint(phase.mapv(of).view());
        let (cos, sin) = (part(f64::cos), part(f64::sin));
        Zip::from(&sin)
            .and(&cos)
            .map_collect(|sin, cos| sin.atan2(*cos))
    }

    /// Parameters whose blocks have the mean of these values of pixels.
    pub fn block_means(&self, values: ArrayView2<'_, f64>) -> Array2<f64> {
        let ones = Array2::ones(values.dim());
        self.blocks.spread_adjoint(values) / self.blocks.spread_adjoint(ones.view())
    }

    /// The transmission of each pixel for light to which the element gives `ratio` times its phase.
    pub fn transmission_at(&self, made: &ModulatedElement, ratio: f64) -> Array2<Complex64> {
        if ratio == 1.0 {
            return made.transmission.clone();
        }
        let transmit = |phase: &f64| Complex64::cis(ratio * phase);
        Zip::from(&made.phase).par_map_collect(transmit)
    }

    /// The cotangent of the parameters from that of [`Constraints::transmission_at`].
    pub fn transmission_adjoint(
        &self,
        made: &ModulatedElement,
        ratio: f64,
        transmission_bar: ArrayView2<'_, Complex64>,
    ) -> Array2<f64> {
        if ratio == 1.0 {
            return self.make_adjoint(made, transmission_bar, None);
        }
        // transmission = exp(i·ratio·φ)
        let transmit =
            |phase: &f64, bar: &Complex64| ratio * (bar * Complex64::cis(-ratio * phase)).im;
        let phase_bar = Zip::from(&made.phase)
            .and(transmission_bar)
            .par_map_collect(transmit);
        let none = Array2::zeros(made.phase.dim());
        self.make_adjoint(made, none.view(), Some(phase_bar.view()))
    }

    /// The element to be exported: what the last iteration saw.
    pub fn finish(&self, parameters: ArrayView2<'_, f64>) -> ModulatedElement {
        self.make(parameters, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use ndarray::{Array2, ArrayView2};
    use num_complex::Complex64;

    use crate::design::constraints::constraint::{Constraints, ModulatedElement, Rules};
    use crate::design::constraints::relief::{Levels, Relief};
    use crate::design::constraints::staircase::Hardening;
    use crate::design::losses::likeness::{Brightness, Likeness};
    use crate::design::losses::loss::Loss;
    use crate::design::optimizers::descent::Rule;
    use crate::design::optimizers::lbfgs::LbfgsSettings;
    use crate::design::optimizers::optimizer::{Method, Optimizer};
    use crate::design::optimizers::schedule::Schedule;
    use crate::design::optimizers::space::Space;
    use crate::fixtures::noise::real_noise;

    /// Phases from −π to π.
    fn phases(shape: (usize, usize), purpose: u32) -> Array2<f64> {
        real_noise(shape, 5, [0, purpose]).mapv(|turn| 2.0 * PI * (turn - 0.5))
    }

    fn levels(count: usize, hardening: Hardening) -> Option<Relief> {
        let levels = Levels { count, hardening };
        Some(Relief::phases(levels).unwrap())
    }

    #[test]
    fn make_dot_product_with_differences_through_the_whole_chain() {
        let rules = Rules {
            block: 2,
            blur: Some(1.5),
            relief: levels(4, Hardening::Annealed),
        };
        let shape = (9, 12);
        let chain = Constraints::new(rules, shape).unwrap();
        assert_eq!(chain.free(), (5, 6));
        let bar = Array2::from_shape_fn(shape, |at| {
            Complex64::new(phases(shape, 1)[at], phases(shape, 2)[at])
        });
        let (free, change) = (phases((5, 6), 3), phases((5, 6), 4));
        let pull = phases(shape, 5);
        for share in [0.0, 0.4, 0.7] {
            // ⟨bar, transmission⟩ + ⟨pull, phase⟩, where the phase may wrap by whole turns.
            let value = |made: &ModulatedElement| {
                let seen = made.transmission.iter().zip(&bar);
                seen.map(|(t, bar)| (bar.conj() * t).re).sum::<f64>()
            };
            let at = |step: f64| chain.make((&free + &(&change * step)).view(), share);
            let h = 1e-5;
            let turned = (&at(h).phase - &at(-h).phase).mapv(|d| d - TAU * (d / TAU).round());
            let slope = (value(&at(h)) - value(&at(-h)) + (&turned * &pull).sum()) / (2.0 * h);
            let made = at(0.0);
            let back = chain.make_adjoint(&made, bar.view(), Some(pull.view()));
            let off = ((&back * &change).sum() - slope).abs() / slope.abs();
            assert!(off < 1e-7, "{share} {off:e}");
        }
    }

    /// The same for light to which the element gives a part of its phase, or more than that.
    #[test]
    fn transmission_dot_product_with_differences() {
        let rules = Rules {
            block: 2,
            blur: Some(1.5),
            ..Rules::NONE
        };
        let shape = (9, 12);
        let chain = Constraints::new(rules, shape).unwrap();
        let [re, im] = [1, 2].map(|part| phases(shape, part));
        let bar = Array2::from_shape_fn(shape, |at| Complex64::new(re[at], im[at]));
        let (free, change) = (phases((5, 6), 3), phases((5, 6), 4));
        let at = |step: f64| chain.make((&free + &(&change * step)).view(), 0.0);
        for ratio in [0.7, 1.0, 1.3] {
            let value = |step: f64| {
                let seen = chain.transmission_at(&at(step), ratio);
                let pairs = seen.iter().zip(&bar);
                pairs.map(|(t, bar)| (bar.conj() * t).re).sum::<f64>()
            };
            let h = 1e-5;
            let slope = (value(h) - value(-h)) / (2.0 * h);
            let back = chain.transmission_adjoint(&at(0.0), ratio, bar.view());
            let off = ((&back * &change).sum() - slope).abs() / slope.abs();
            assert!(off < 1e-7, "{ratio} {off:e}");
        }
    }

    /// A far field of 16 × 16 places from 24 × 24 pixels, and how unlike a picture of stripes it is.
    struct Far {
        waves: Array2<Complex64>,
        loss: Likeness,
    }

    impl Far {
        fn new() -> Self {
            let waves = Array2::from_shape_fn((16, 24), |(v, j)| {
                Complex64::cis(-TAU * (v as f64 - 7.5) * (j as f64 - 11.5) / 24.0)
            });
            let stripes = Array2::from_shape_fn((16, 16), |(v, u)| {
                let lit = (v + 2 * u) % 5 == 0 && v > 2 && (2..14).contains(&u);
                if lit || u == v { 1.0 } else { 0.0 }
            });
            let loss = Likeness::new(stripes, None, Brightness::Free).unwrap();
            Self { waves, loss }
        }

        /// Value, and cotangent of the transmission.
        fn evaluate(&self, transmission: &Array2<Complex64>) -> (f64, Array2<Complex64>) {
            let seen = self.waves.dot(transmission).dot(&self.waves.t());
            let found = self.loss.evaluate(seen.mapv(|u| u.norm_sqr()).view());
            let bar = seen * found.bar.mapv(|bar| Complex64::from(2.0 * bar));
            let back = self.waves.mapv(|wave| wave.conj());
            (found.value, back.t().dot(&bar).dot(&back))
        }

        /// Parameters after so many evaluations, levels ever harder, and what was looked at last.
        fn design(
            &self,
            chain: &Constraints,
            method: Method,
            start: Array2<f64>,
            count: usize,
        ) -> (Array2<f64>, ModulatedElement) {
            let (shape, point) = (start.dim(), start.into_raw_vec_and_offset().0);
            let space = Space::free(point.len());
            let mut search = method.start(point, space).unwrap();
            let at = |search: &Optimizer| {
                let point = ArrayView2::from_shape(shape, search.point());
                point.unwrap().to_owned()
            };
            for i in 0..=count {
                let free = at(&search);
                let made = chain.make(free.view(), i as f64 / count as f64);
                let (value, bar) = self.evaluate(&made.transmission);
                if i == count {
                    return (free, made);
                }
                let back = chain.make_adjoint(&made, bar.view(), None);
                search.report(value, back.as_slice().unwrap());
            }
            panic!("the last evaluation returns")
        }
    }

    #[test]
    fn what_is_exported_is_what_was_optimised_and_annealing_beats_rounding_slow() {
        let (far, shape) = (Far::new(), (24, 24));
        let smooth = Constraints::new(Rules::NONE, shape).unwrap();
        let lbfgs = Method::Lbfgs(LbfgsSettings::default());
        let (best, _) = far.design(&smooth, lbfgs, phases(shape, 7), 200);
        let adam = Method::Descent(Rule::ADAM, Schedule::Constant { rate: 0.03 });
        for (count, gain) in [(2, 2.0), (4, 5.0), (8, 5.0)] {
            let rules = Rules {
                relief: levels(count, Hardening::Annealed),
                ..Rules::NONE
            };
            let chain = Constraints::new(rules, shape).unwrap();
            let (free, last) = far.design(&chain, adam, best.clone(), 300);
            let exported = chain.finish(free.view());
            assert_eq!(exported.transmission, last.transmission);
            assert_eq!(exported.phase, last.phase);
            assert_eq!(exported.height, last.height);
            let level = TAU / count as f64;
            assert!(
                last.phase
                    .iter()
                    .all(|phase| phase / level == (phase / level).round())
            );

            // Against the best without levels, rounded afterwards.
            let value = |made: &ModulatedElement| far.evaluate(&made.transmission).0;
            let (annealed, rounded) = (value(&exported), value(&chain.finish(best.view())));
            assert!(gain * annealed < rounded, "{count}: {annealed} {rounded}");
        }
    }

    #[test]
    fn blocks_hold_with_all_other_constraints() {
        let rules = Rules {
            block: 3,
            blur: Some(2.0),
            relief: levels(2, Hardening::StraightThrough),
        };
        let chain = Constraints::new(rules, (9, 9)).unwrap();
        let made = chain.make(phases((3, 3), 8).view(), 0.3);
        for ((j, i), phase) in made.phase.indexed_iter() {
            assert_eq!(*phase, made.phase[[3 * (j / 3), 3 * (i / 3)]]);
        }
        let none = Constraints::new(Rules::NONE, (4, 4)).unwrap();
        let free = phases((4, 4), 9);
        assert_eq!(none.finish(free.view()).phase, free);
        assert!(
            Constraints::new(
                Rules {
                    block: 0,
                    ..Rules::NONE
                },
                (4, 4)
            )
            .is_err()
        );
    }
}
