//! The light under one window, from the samples of its tile, and back.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::tile_plan::{TargetedWindow, TilePlan, TileRun};
use crate::math::part::part;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::window_transform::SampleLine;

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

impl TileRun<'_> {
    /// The light under a window of a tile.
    pub(crate) fn window_light(&self, plan: &TilePlan, targeted: &TargetedWindow) -> WindowLight {
        let (at, k) = (targeted.start.carrier.at, self.k());
        let weights = [0, 1].map(|a| {
            let axis = &plan.samples[a];
            let (range, mut weights) = self.tiling.positions[a].analysis(axis, targeted.window[a]);
            weights.iter_mut().for_each(|weight| *weight /= axis.pitch);
            (range, weights)
        });
        let [arrived, own] = plan.carriers.map(|carrier| carrier.removed(at, k).conj());
        WindowLight {
            weights,
            carried: arrived * own,
            centre: at,
            k,
        }
    }
}

impl WindowLight {
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
    pub(crate) fn add_adjoint(
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
