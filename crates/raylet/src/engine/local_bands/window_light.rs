//! The light under one window, from the samples of its tile, and back.
//!
//! `carry_kept_dot_product` (in `carry.rs`) tests the adjoint as a part of the whole run.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::part::part;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::window_transform::SampleLine;
use crate::wave::patches::window::Positions;

/// The linear map from the samples of a tile to the light under one window.
pub(crate) struct WindowLight {
    /// The samples under the window along x and y, and ĝ there.
    weights: [(Range<usize>, Vec<f64>); 2],
    /// The carriers' phase at the window's centre.
    carried: Complex64,
    /// The window's centre in mm.
    centre: [f64; 2],
    /// Vacuum wavenumber in rad/mm.
    k: f64,
}

impl WindowLight {
    /// That of a window of a tile with these samples, the carriers of the arriving light and of the element there.
    pub(crate) fn new(
        positions: &[Positions; 2],
        samples: &[Axis; 2],
        window: [usize; 2],
        carriers: &[Carrier; 2],
        k: f64,
    ) -> Self {
        let weights = [0, 1].map(|a| {
            let axis = &samples[a];
            let (range, mut weights) = positions[a].analysis(axis, window[a]);
            weights.iter_mut().for_each(|weight| *weight /= axis.pitch);
            (range, weights)
        });
        let centre = [0, 1].map(|a| positions[a].at(window[a]));
        let [arrived, own] = carriers.map(|carrier| carrier.removed(centre, k).conj());
        Self {
            weights,
            carried: arrived * own,
            centre,
            k,
        }
    }

    /// The samples under the window along x and y, of those of its tile.
    pub(crate) fn lines<'a>(&self, samples: &'a [Axis; 2]) -> [SampleLine<'a>; 2] {
        [0, 1].map(|a| SampleLine {
            axis: &samples[a],
            range: (self.weights[a].0.start, self.weights[a].0.end),
            centre: self.centre[a],
            k: self.k,
        })
    }

    /// The light under the window times ĝ, over the carriers about its centre.
    pub(crate) fn windowed(&self, values: &Array2<Complex64>) -> Array2<Complex64> {
        let [x, y] = &self.weights;
        let mut light = part(values.view(), y.0.clone(), x.0.clone()).to_owned();
        for ((j, i), value) in light.indexed_iter_mut() {
            *value *= self.carried * (x.1[i] * y.1[j]);
        }
        light
    }

    /// The conjugate transpose: adds to the cotangents of the samples.
    pub(crate) fn windowed_adjoint(
        &self,
        light_bar: &Array2<Complex64>,
        values_bar: &mut Array2<Complex64>,
    ) {
        let [x, y] = &self.weights;
        let mut under = part(values_bar.view_mut(), y.0.clone(), x.0.clone());
        for ((j, i), bar) in light_bar.indexed_iter() {
            under[[j, i]] += bar * self.carried.conj() * (x.1[i] * y.1[j]);
        }
    }
}
