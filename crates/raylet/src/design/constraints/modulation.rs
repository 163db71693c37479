//! Which property of an element's pixels is free: phases, amplitudes, both, or two phases whose waves are added.

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

use crate::design::constraints::constraint::{Constraints, ModulatedElement};
use crate::design::losses::smoothness::roughness;

/// The free values of each pixel: phase, amplitude, both, or two phases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Modulation {
    /// The phase φ in rad.
    Phase,
    /// The amplitude a, 0 to 1.
    Amplitude,
    /// Phase and amplitude, a·e^{iφ}: phases first among the parameters.
    Both,
    /// Two phases, w₁·e^{iφ₁} + w₂·e^{iφ₂} with these weights.
    TwoPhase([Complex64; 2]),
}

/// The map from the parameters of an element to the transmission of its pixels, and its adjoint.
///
/// Parameters are planes of blocks one behind the other, [plane, y, x]. The constraints apply to each plane of phases.
/// Of amplitudes only blocks and blur are constrained; an amplitude weakens a pixel as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Modulator {
    modulation: Modulation,
    constraints: Constraints,
    smoothness: f64,
}

/// An element as made from parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaped {
    /// Each plane of phases as made.
    pub phases: Vec<ModulatedElement>,
    /// The amplitude of each pixel, [y, x], where it is free.
    pub amplitude: Option<Array2<f64>>,
}

impl From<Constraints> for Modulator {
    /// Phases alone.
    fn from(constraints: Constraints) -> Self {
        Self::new(Modulation::Phase, constraints)
    }
}

impl Modulator {
    /// A modulator with these constraints on each plane, and no penalty on steps.
    pub fn new(modulation: Modulation, constraints: Constraints) -> Self {
        Self {
            modulation,
            constraints,
            smoothness: 0.0,
        }
    }

    /// Adds a penalty on steps between neighbouring phases: `price` times their [`roughness`] is added to the loss.
    pub fn smooth(mut self, price: f64) -> Self {
        self.smoothness = price;
        self
    }

    /// The constraints on each plane.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// The free values of each pixel.
    pub fn modulation(&self) -> Modulation {
        self.modulation
    }

    /// Number of planes of phases, and of amplitudes.
    pub fn planes(&self) -> [usize; 2] {
        match self.modulation {
            Modulation::Phase => [1, 0],
            Modulation::Amplitude => [0, 1],
            Modulation::Both => [1, 1],
            Modulation::TwoPhase(_) => [2, 0],
        }
    }

    /// Number of parameters.
    pub fn count(&self) -> usize {
        let (rows, columns) = self.constraints.free();
        self.planes().iter().sum::<usize>() * rows * columns
    }

    /// The parameters' bounds, plane by plane, where they have some.
    pub fn bounds(&self) -> Vec<Option<[f64; 2]>> {
        let [phases, amplitudes] = self.planes();
        let mut bounds = vec![self.constraints.bounds(); phases];
        bounds.extend(vec![Some([0.0, 1.0]); amplitudes]);
        bounds
    }

    /// A plane of the parameters, [y, x].
    fn plane(&self, parameters: &[f64], number: usize) -> Array2<f64> {
        let (rows, columns) = self.constraints.free();
        let first = number * rows * columns;
        Array2::from_shape_fn((rows, columns), |(j, i)| {
            parameters[first + j * columns + i]
        })
    }

    /// The element, `share` of the iterations done (0 to 1: how hard soft levels are).
    pub fn make(&self, parameters: &[f64], share: f64) -> Shaped {
        let [phases, amplitudes] = self.planes();
        let plane = |number| self.plane(parameters, number);
        let phase = |number| self.constraints.make(plane(number).view(), share);
        let amplitude = (amplitudes > 0).then(|| {
            let plane = plane(phases);
            self.constraints.spread(plane.view())
        });
        Shaped {
            phases: (0..phases).map(phase).collect(),
            amplitude,
        }
    }

    /// The transmission of each pixel for light to which the element gives `ratio` times its phases.
    pub fn transmission(&self, shaped: &Shaped, ratio: f64) -> Array2<Complex64> {
        let planes = shaped.phases.iter();
        let mut planes = planes.map(|made| self.constraints.transmission_at(made, ratio));
        let first = planes.next();
        match (first, &shaped.amplitude, self.modulation) {
            (Some(first), None, Modulation::TwoPhase([w, v])) => {
                let second = planes.next().unwrap_or_else(|| first.clone());
                Zip::from(&first)
                    .and(&second)
                    .map_collect(|a, b| a * w + b * v)
            }
            (Some(first), Some(amplitude), _) => {
                Zip::from(&first).and(amplitude).map_collect(|t, a| t * *a)
            }
            (Some(first), None, _) => first,
            (None, amplitude, _) => match amplitude {
                Some(amplitude) => amplitude.mapv(Complex64::from),
                None => Array2::default((0, 0)),
            },
        }
    }

    /// The cotangent of the parameters from that of [`Modulator::transmission`].
    pub fn transmission_adjoint(
        &self,
        shaped: &Shaped,
        ratio: f64,
        transmission_bar: ArrayView2<'_, Complex64>,
    ) -> Vec<f64> {
        let mut planes: Vec<Array2<f64>> = Vec::new();
        let weights = match self.modulation {
            Modulation::TwoPhase(weights) => weights,
            _ => [Complex64::ONE; 2],
        };
        for (made, weight) in shaped.phases.iter().zip(weights) {
            // t = Σ w·phasor, or a·phasor
            let bar = match &shaped.amplitude {
                Some(amplitude) => Zip::from(transmission_bar)
                    .and(amplitude)
                    .map_collect(|bar, a| bar * *a),
                None => transmission_bar.mapv(|bar| bar * weight.conj()),
            };
            let rules = &self.constraints;
            planes.push(rules.transmission_adjoint(made, ratio, bar.view()));
        }
        if shaped.amplitude.is_some() {
            // t = a·phasor, the phasor one without phases
            let phasor = shaped.phases.first();
            let phasor = phasor.map(|made| self.constraints.transmission_at(made, ratio));
            let bar = match phasor {
                Some(phasor) => Zip::from(&phasor)
                    .and(transmission_bar)
                    .map_collect(|t, bar| (t.conj() * bar).re),
                None => transmission_bar.mapv(|bar| bar.re),
            };
            planes.push(self.constraints.spread_adjoint(bar.view()));
        }
        flat(&planes)
    }

    /// The penalty on steps between neighbours, and its gradient to the parameters; nothing where there is none.
    pub fn price(&self, shaped: &Shaped) -> Option<(f64, Vec<f64>)> {
        if self.smoothness == 0.0 {
            return None;
        }
        let mut total = 0.0;
        let mut planes = Vec::new();
        for made in &shaped.phases {
            let rough = roughness(made.phase.view(), None);
            total += self.smoothness * rough.value;
            let none = Array2::zeros(made.phase.dim());
            let bar = rough.bar * self.smoothness;
            let back = self
                .constraints
                .make_adjoint(made, none.view(), Some(bar.view()));
            planes.push(back);
        }
        let [_, amplitudes] = self.planes();
        planes.extend((0..amplitudes).map(|_| Array2::zeros(self.constraints.free())));
        Some((total, flat(&planes)))
    }
}

/// Planes one behind the other.
fn flat(planes: &[Array2<f64>]) -> Vec<f64> {
    planes
        .iter()
        .flat_map(|plane| plane.iter().copied())
        .collect()
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::design::constraints::constraint::{Constraints, Rules};
    use crate::design::constraints::modulation::{Modulation, Modulator};
    use crate::design::constraints::relief::{Levels, Relief};
    use crate::design::constraints::staircase::Hardening;
    use crate::fixtures::noise::noise;

    const SHAPE: (usize, usize) = (7, 8);

    fn modulators() -> Vec<Modulator> {
        let levels = Levels {
            count: 4,
            hardening: Hardening::Annealed,
        };
        let rules = Rules {
            block: 2,
            blur: Some(1.5),
            relief: Some(Relief::phases(levels).unwrap()),
        };
        let kinds = [
            Modulation::Phase,
            Modulation::Amplitude,
            Modulation::Both,
            Modulation::TwoPhase([Complex64::ONE, Complex64::new(0.2, -0.7)]),
        ];
        let of = |rules: Rules| {
            kinds.map(|kind| Modulator::new(kind, Constraints::new(rules, SHAPE).unwrap()))
        };
        [of(Rules::NONE), of(rules)].concat()
    }

    /// Parameters within 0.1 and 0.9, and a direction.
    fn point(count: usize, purpose: u32) -> Vec<f64> {
        noise((1, count), purpose)
            .iter()
            .map(|v| 0.5 + 0.8 * v.re)
            .collect()
    }

    #[test]
    fn transmission_dot_product_with_differences() {
        for modulator in modulators() {
            let (at, along) = (point(modulator.count(), 1), point(modulator.count(), 2));
            let bar = noise(SHAPE, 3);
            for ratio in [1.0, 0.8] {
                let moved = |by: f64| -> Array2<Complex64> {
                    let moved: Vec<f64> = at.iter().zip(&along).map(|(a, d)| a + by * d).collect();
                    modulator.transmission(&modulator.make(&moved, 0.4), ratio)
                };
                let change = (moved(1e-5) - moved(-1e-5)) / Complex64::from(2e-5);
                let there: f64 = bar
                    .iter()
                    .zip(&change)
                    .map(|(b, t)| (b.conj() * t).re)
                    .sum();
                let shaped = modulator.make(&at, 0.4);
                let back = modulator.transmission_adjoint(&shaped, ratio, bar.view());
                let back: f64 = back.iter().zip(&along).map(|(a, d)| a * d).sum();
                let off = (there - back).abs() / there.abs();
                assert!(off < 1e-7, "{:?} {ratio}: {off:e}", modulator.modulation());
            }
        }
    }

    #[test]
    fn prices_of_steps_have_their_gradients() {
        for modulator in modulators() {
            assert_eq!(
                modulator.price(&modulator.make(&point(modulator.count(), 1), 0.0)),
                None
            );
            let modulator = modulator.smooth(0.3);
            let (at, along) = (point(modulator.count(), 4), point(modulator.count(), 5));
            let price = |by: f64| {
                let moved: Vec<f64> = at.iter().zip(&along).map(|(a, d)| a + by * d).collect();
                modulator.price(&modulator.make(&moved, 0.4)).unwrap()
            };
            let slope = (price(1e-5).0 - price(-1e-5).0) / 2e-5;
            let found: f64 = price(0.0).1.iter().zip(&along).map(|(a, d)| a * d).sum();
            assert!((found - slope).abs() < 1e-8 + 1e-7 * slope.abs());
        }
    }

    #[test]
    fn transmissions_are_what_is_said() {
        let rules = Constraints::new(Rules::NONE, (1, 2)).unwrap();
        let seen = |kind, parameters: &[f64]| {
            let modulator = Modulator::new(kind, rules.clone());
            assert_eq!(modulator.count(), parameters.len());
            let shaped = modulator.make(parameters, 1.0);
            modulator.transmission(&shaped, 1.0)[[0, 1]]
        };
        let cis = Complex64::cis;
        let close = |a: Complex64, b: Complex64| (a - b).norm() < 1e-15;
        assert!(close(seen(Modulation::Phase, &[0.1, 0.2]), cis(0.2)));
        assert!(close(
            seen(Modulation::Amplitude, &[0.1, 0.2]),
            Complex64::from(0.2)
        ));
        let both = seen(Modulation::Both, &[0.1, 0.2, 0.3, 0.4]);
        assert!(close(both, cis(0.2) * 0.4));
        let half = Complex64::new(0.0, 0.5);
        let two = seen(
            Modulation::TwoPhase([Complex64::ONE, half]),
            &[0.1, 0.2, 0.3, 0.4],
        );
        assert!(close(two, cis(0.2) + cis(0.4) * half));
        let both = Modulator::new(Modulation::Both, rules);
        assert_eq!(both.bounds(), [None, Some([0.0, 1.0])]);
    }
}
