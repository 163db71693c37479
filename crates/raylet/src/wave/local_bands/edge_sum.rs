//! What an edge under one window sends far beside the way of the light, as an integral along the edge.
//!
//! Far from the light's own direction a plane wave exp(iks·u) of a window has light of the edge alone. By parts its coefficient
//! ∫F exp(−iks·u) du/P² over what the edge leaves open of the smooth F is
//!
//! (i/kP²) ∮ F (s·n)/|s|² (1 + i(s·u)/(kσ²|s|²)) exp(−iks·u) dl
//!
//! along the edge, with its outward normal n, s beside the light's direction there, and the slope −F u/σ² of the window itself;
//! what follows is smaller by 1/(kσ|s|)². Points of the edge stand a part of σ apart, where nodes in the plane would have to
//! resolve exp(iks·u).

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;

use crate::wave::local_bands::fourier_axis::Modes;
use crate::wave::local_bands::window_transform::{SampleLine, interpolation};

/// A point of the edge under a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeNode {
    /// Its place in mm.
    pub at: [f64; 2],
    /// The outward normal times the length of edge that it stands for, in mm.
    pub normal: [f64; 2],
    /// The direction of the light there beside its carriers.
    pub beside: [f64; 2],
}

/// The edge under a tile.
pub(crate) struct EdgeLight {
    /// Its points.
    pub nodes: Vec<EdgeNode>,
    /// The element there, over its carrier.
    pub through: Vec<Complex64>,
}

/// Cotangents at the points of an edge.
#[derive(Default)]
pub(crate) struct EdgeBar {
    /// Of the element there.
    pub through: Vec<Complex64>,
    /// Of the place of the edge along its outward normal, in 1/mm.
    pub place: Vec<f64>,
}

impl EdgeBar {
    /// Zeros at so many points.
    pub(crate) fn zeros(count: usize) -> Self {
        Self {
            through: vec![Complex64::ZERO; count],
            place: vec![0.0; count],
        }
    }
}

/// The plane waves of a window to be computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeModes {
    /// All along x and y.
    pub modes: [Modes; 2],
    /// Those that have another source, along x and y: they stay zero.
    pub resolved: Option<[Modes; 2]>,
    /// Half the band of the light along the edge.
    pub half_band: f64,
    /// Width of the window in mm.
    pub sigma: f64,
}

/// The linear map from the samples under one window, [y, x], to the plane waves of its edge, [m_y, m_x].
pub(crate) struct EdgeSum {
    waves: EdgeModes,
    nodes: Vec<EdgeNode>,
    /// The direction of the edge at some of them, and that of the light beside its carriers along it.
    tangents: Vec<[f64; 3]>,
    /// From samples along x and y to the edge, a row per point.
    to_nodes: [Array2<f64>; 2],
    /// The centre of the window, in mm.
    centre: [f64; 2],
    k: f64,
}

/// Every so many points of the edge are looked at to find which plane waves it sends.
const SEEN: usize = 4;

impl EdgeSum {
    /// Plans it, for the points of an edge under a window.
    pub(crate) fn new(nodes: Vec<EdgeNode>, samples: [&SampleLine; 2], waves: EdgeModes) -> Self {
        let to_nodes = [0, 1].map(|a| interpolation(samples[a], nodes.iter().map(|n| n.at[a])));
        let tangent = |node: &EdgeNode| {
            let [x, y] = node.normal;
            let [x, y] = [y, -x].map(|part| part / x.hypot(y));
            [x, y, node.beside[0] * x + node.beside[1] * y]
        };
        Self {
            tangents: nodes.iter().step_by(SEEN).map(tangent).collect(),
            waves,
            nodes,
            to_nodes,
            centre: samples.map(|line| line.centre),
            k: samples[0].k,
        }
    }

    /// The light at the points of the edge.
    fn at_nodes(&self, samples: &Array2<Complex64>) -> Vec<Complex64> {
        let [x, y] = &self.to_nodes;
        let along = |n: usize| {
            let rows = samples.rows().into_iter().zip(y.row(n));
            rows.map(|(row, by)| {
                let sum: Complex64 = row.iter().zip(x.row(n)).map(|(v, w)| v * w).sum();
                sum * by
            })
            .sum()
        };
        (0..self.nodes.len()).map(along).collect()
    }

    /// An amplitude that none of the plane waves exceeds behind a transmission of one, but for terms of higher order.
    pub(crate) fn strongest(&self, samples: &Array2<Complex64>) -> f64 {
        let nearest = self.nodes.iter().map(|node| self.least(node));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        let light = self.at_nodes(samples);
        let pieces = self.nodes.iter().zip(&light);
        let sum: f64 = pieces
            .map(|(node, light)| light.norm() * node.normal[0].hypot(node.normal[1]))
            .sum();
        sum / (self.k * nearest * self.period().powi(2))
    }

    /// The smallest direction beside the light at a point of the edge that is computed.
    fn least(&self, node: &EdgeNode) -> f64 {
        let beside = |a: usize| {
            let modes = &self.waves.modes[a];
            let ends = [0, modes.count.max(1) - 1].map(|m| modes.at(m) + modes.shift);
            let nearest = node.beside[a].clamp(ends[0], ends[1]);
            (nearest - node.beside[a]).abs()
        };
        let outside = beside(0).hypot(beside(1));
        let Some(resolved) = &self.waves.resolved else {
            return outside;
        };
        let inside = |a: usize| {
            let modes = &resolved[a];
            let ends = [-1.0, modes.count as f64]
                .map(|m| (modes.first as f64 + m) * modes.spacing + modes.shift - node.beside[a]);
            ends[0].abs().min(ends[1].abs())
        };
        outside.max(inside(0).min(inside(1)))
    }

    fn period(&self) -> f64 {
        TAU / (self.k * self.waves.modes[0].spacing)
    }

    /// Direction of a plane wave beside the carriers.
    fn direction(&self, place: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|a| self.waves.modes[a].at(place[a]) + self.waves.modes[a].shift)
    }

    /// Whether an edge sends light into a direction: straight across itself, within the band of the light.
    fn sends(&self, s: [f64; 2]) -> bool {
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let along = self
            .tangents
            .iter()
            .map(|[x, y, by]| s[0] * x + s[1] * y - by);
        let [low, high] = along.fold(nothing, |[low, high], t| [low.min(t), high.max(t)]);
        low <= self.waves.half_band && high >= -self.waves.half_band
    }

    /// Whether another source has a plane wave.
    fn is_resolved(&self, place: [usize; 2]) -> bool {
        self.waves.resolved.as_ref().is_some_and(|resolved| {
            (0..2).all(|a| {
                let number = self.waves.modes[a].first + place[a] as i64;
                let first = resolved[a].first;
                (first..first + resolved[a].count as i64).contains(&number)
            })
        })
    }

    /// Calls `each` with the place [m_y, m_x] of each plane wave and its factors at the points of the edge.
    fn visit(&self, mut each: impl FnMut([usize; 2], &[Complex64])) {
        let phases = [0, 1].map(|a| {
            let modes = &self.waves.modes[a];
            let phase = |(m, n): (usize, usize)| {
                let u = self.nodes[n].at[a] - self.centre[a];
                Complex64::cis(-self.k * (modes.at(m) + modes.shift) * u)
            };
            Array2::from_shape_fn((modes.count, self.nodes.len()), phase)
        });
        let mut factors = vec![Complex64::ZERO; self.nodes.len()];
        let scale = 1.0 / (self.k * self.period().powi(2));
        let slope = 1.0 / (self.k * self.waves.sigma.powi(2));
        for my in 0..self.waves.modes[1].count {
            for mx in 0..self.waves.modes[0].count {
                let s = self.direction([mx, my]);
                if self.is_resolved([mx, my]) || !self.sends(s) {
                    continue;
                }
                let phases = phases[0].row(mx).into_iter().zip(phases[1].row(my));
                for ((factor, node), (x, y)) in factors.iter_mut().zip(&self.nodes).zip(phases) {
                    let p = [0, 1].map(|a| s[a] - node.beside[a]);
                    let u = [0, 1].map(|a| node.at[a] - self.centre[a]);
                    let square = 1.0 / (p[0] * p[0] + p[1] * p[1]);
                    let across = (p[0] * node.normal[0] + p[1] * node.normal[1]) * square * scale;
                    let next = (p[0] * u[0] + p[1] * u[1]) * square * slope;
                    // i·across·(1 + i·next)
                    *factor = Complex64::new(-across * next, across) * (x * y);
                }
                each([my, mx], &factors);
            }
        }
    }

    fn zeros(&self) -> Array2<Complex64> {
        Array2::zeros((self.waves.modes[1].count, self.waves.modes[0].count))
    }

    /// The plane waves of the light times the transmission at the points of the edge.
    pub(crate) fn apply(
        &self,
        samples: &Array2<Complex64>,
        through: &[Complex64],
    ) -> Array2<Complex64> {
        let mut light = self.at_nodes(samples);
        light
            .iter_mut()
            .zip(through)
            .for_each(|(light, t)| *light *= t);
        let mut waves = self.zeros();
        self.visit(|place, factors| {
            waves[place] = factors.iter().zip(&light).map(|(f, light)| f * light).sum();
        });
        waves
    }

    /// The conjugate transpose: the cotangents of the samples, of the transmission, and of the places of the edge, which turn the
    /// phase of its plane waves.
    pub(crate) fn apply_adjoint(
        &self,
        samples: &Array2<Complex64>,
        through: &[Complex64],
        waves_bar: &Array2<Complex64>,
    ) -> (Array2<Complex64>, EdgeBar) {
        let light = self.at_nodes(samples);
        let mut after_bar = vec![Complex64::ZERO; self.nodes.len()];
        let mut bars = EdgeBar::zeros(self.nodes.len());
        self.visit(|[my, mx], factors| {
            let (bar, s) = (waves_bar[[my, mx]], self.direction([mx, my]));
            for (n, factor) in factors.iter().enumerate() {
                after_bar[n] += factor.conj() * bar;
                let EdgeNode { normal, beside, .. } = self.nodes[n];
                let [x, y] = normal.map(|part| part / normal[0].hypot(normal[1]));
                let across = (s[0] - beside[0]) * x + (s[1] - beside[1]) * y;
                // −ik·across·wave
                let wave = bar.conj() * factor * light[n] * through[n];
                bars.place[n] += self.k * across * wave.im;
            }
        });
        let each = bars.through.iter_mut().zip(&light).zip(&after_bar);
        each.for_each(|((to, light), bar)| *to = light.conj() * bar);

        // light = Σ y·x·samples
        let mut samples_bar = Array2::zeros(samples.dim());
        let [x, y] = &self.to_nodes;
        for (n, (bar, t)) in after_bar.iter().zip(through).enumerate() {
            let bar = bar * t.conj();
            for (mut row, by) in samples_bar.rows_mut().into_iter().zip(y.row(n)) {
                let each = row.iter_mut().zip(x.row(n));
                each.for_each(|(sample, w): (&mut Complex64, _)| *sample += bar * (by * w));
            }
        }
        (samples_bar, bars)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::optics::aperture::Aperture;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::edge_points::edge_points;
    use crate::wave::local_bands::edge_sum::{EdgeModes, EdgeNode, EdgeSum};
    use crate::wave::local_bands::fourier_axis::Modes;
    use crate::wave::local_bands::window_transform::SampleLine;
    use ndarray::Array2;

    const K: f64 = 1.2e4;
    const SIGMA: f64 = 0.05;
    const CENTRE: [f64; 2] = [0.98, 0.3];

    fn axis(a: usize) -> Axis {
        Axis::uniform(43, 0.01, CENTRE[a])
    }

    fn line(axis: &Axis, a: usize) -> SampleLine<'_> {
        SampleLine {
            axis,
            range: (0, 43),
            centre: CENTRE[a],
            k: K,
        }
    }

    /// A disc whose edge runs through the window, in light that runs a little aside.
    fn nodes(beside: [f64; 2]) -> Vec<EdgeNode> {
        let area = [0.7, 1.2, 0.0, 0.6];
        let points = edge_points(&Aperture::disc(1.03), area, 0.16 * SIGMA);
        let node = |p: &_| {
            let crate::wave::local_bands::edge_points::EdgePoint { at, normal } = *p;
            EdgeNode { at, normal, beside }
        };
        points.iter().map(node).collect()
    }

    fn waves(shift: f64) -> EdgeModes {
        EdgeModes {
            modes: [
                Modes::between(0.1, 0.2, 4e-3, shift),
                Modes::between(0.02, 0.07, 4e-3, shift),
            ],
            resolved: None,
            half_band: 8e-3,
            sigma: SIGMA,
        }
    }

    #[test]
    fn edge_sum_dot_product() {
        let axes = [axis(0), axis(1)];
        let lines = [line(&axes[0], 0), line(&axes[1], 1)];
        let sum = EdgeSum::new(nodes([0.0; 2]), lines.each_ref(), waves(0.0));
        let values = noise((43, 43), 0);
        let through: Vec<Complex64> = noise((1, sum.nodes.len()), 1).into_iter().collect();
        let there = sum.apply(&values, &through);
        assert!(there.iter().filter(|v| v.norm() > 0.0).count() > 20);
        let bar = noise(there.dim(), 2);
        let (back, bars) = sum.apply_adjoint(&values, &through, &bar);
        let listed = |v: Vec<Complex64>| Array2::from_shape_vec((1, v.len()), v).unwrap();
        let (through, through_bar) = (listed(through), listed(bars.through));
        assert_transposed(&[(&bar, &there)], &[(&back, &values)]);
        assert_transposed(&[(&bar, &there)], &[(&through_bar, &through)]);
    }

    /// The plane waves of a window beside the edge of a disc are those of a fine sum over what is open, where they are strong;
    /// also in light that does not run along with its carrier.
    #[test]
    fn an_edge_sends_what_a_fine_sum_has() {
        let axes = [axis(0), axis(1)];
        let lines = [line(&axes[0], 0), line(&axes[1], 1)];
        let aside = [4e-3, -3e-3];
        let light = |x: f64, y: f64| {
            let [u, v] = [x - CENTRE[0], y - CENTRE[1]];
            let window = (-0.5 * (u * u + v * v) / (SIGMA * SIGMA)).exp();
            Complex64::from_polar(window, K * (aside[0] * u + aside[1] * v))
        };
        let values =
            Array2::from_shape_fn((43, 43), |(j, i)| light(axes[0].node(i), axes[1].node(j)));
        let sum = EdgeSum::new(nodes(aside), lines.each_ref(), waves(1e-3));
        let found = sum.apply(&values, &vec![Complex64::ONE; sum.nodes.len()]);
        let strongest = found.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(sum.strongest(&values) > strongest);

        // Lines along x end at the edge: Gauss points resolve the waves along them, equal steps across.
        let (step, reach) = (2.5e-4, 4.5 * SIGMA);
        let rows = (2.0 * reach / step) as usize;
        let exact = |s: [f64; 2]| {
            let row = |j: usize| {
                let y = CENTRE[1] - reach + (j as f64 + 0.5) * step;
                let end = (1.03f64 * 1.03 - y * y).sqrt().min(CENTRE[0] + reach);
                let start = CENTRE[0] - reach;
                let along = Axis::gauss(160, (end - start) / 160.0, 0.5 * (start + end), 8);
                let point = |n: usize| {
                    let x = along.node(n);
                    let phase = -K * (s[0] * (x - CENTRE[0]) + s[1] * (y - CENTRE[1]));
                    light(x, y) * Complex64::cis(phase) * along.weight(n)
                };
                (0..along.len()).map(point).sum::<Complex64>()
            };
            let whole: Complex64 = (0..rows).map(row).sum();
            whole * step / sum.period().powi(2)
        };
        let (mut off, mut all) = (0.0, 0.0);
        for my in (0..found.nrows()).step_by(3) {
            for mx in (0..found.ncols()).step_by(7) {
                let expected = exact(sum.direction([mx, my]));
                off += (found[[my, mx]] - expected).norm_sqr();
                all += expected.norm_sqr();
            }
        }
        let error = (off / all).sqrt();
        assert!(error < 2e-3, "{error:e}");
    }

    /// Plane waves that have another source stay zero.
    #[test]
    fn resolved_plane_waves_stay_zero() {
        let axes = [axis(0), axis(1)];
        let lines = [line(&axes[0], 0), line(&axes[1], 1)];
        let resolved = [Modes::between(0.0, 0.15, 4e-3, 0.0); 2];
        let limited = EdgeModes {
            resolved: Some(resolved),
            ..waves(0.0)
        };
        let values = noise((43, 43), 0);
        let sums =
            [waves(0.0), limited].map(|w| EdgeSum::new(nodes([0.0; 2]), lines.each_ref(), w));
        let through = vec![Complex64::ONE; sums[0].nodes.len()];
        let [all, limited] = sums.each_ref().map(|sum| sum.apply(&values, &through));
        for ((my, mx), value) in limited.indexed_iter() {
            let [x, y] = sums[0].direction([mx, my]);
            let kept = if x < 0.15 && y < 0.15 {
                Complex64::ZERO
            } else {
                all[[my, mx]]
            };
            assert_eq!(*value, kept);
        }
        assert!(limited.iter().any(|v| v.norm() > 0.0));
    }
}
