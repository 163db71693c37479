//! The angular spectrum of a frame that repeats: what patches with zeros around them up to one period bring
//! together.
//!
//! All patches of period P have the same plane waves, so their sum is the spectrum of the sum of what they
//! hold, c(p) = 1/P² Σ U e^{−ik p·x} dA, with all copies at distance P.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet::math::chirp::{Chirp2, Comb};
use raylet::wave::grid::field::{Axis, Grid};
use raylet::wave::grid::raster::Raster;
use raylet::wave::patches::patch::Band;

/// A hop through vacuum from one plane to another, with one period.
pub struct PeriodicHop {
    spread: Chirp2,
    land: Chirp2,
    /// Phase of each wave over the distance, times the share of one node; zero where it is evanescent.
    transfer: Array2<Complex64>,
}

impl PeriodicHop {
    /// From a grid with one node in each cell, by the plane waves of `bands`, to points `distance` mm
    /// further; `k` is the wavenumber in rad/mm.
    pub fn new(k: f64, bands: &[Band; 2], grid: &Grid, distance: f64, to: &Raster) -> Self {
        let waves = bands.map(|band| Comb {
            start: band.at(0),
            step: band.spacing,
            count: band.count,
        });
        let nodes = |axis: &Axis| Comb {
            start: axis.node(0),
            step: axis.pitch,
            count: axis.len(),
        };
        let points = |start: f64, step: f64, count: usize| Comb { start, step, count };
        let ([x, y], [dx, dy], [nx, ny]) = (to.start, to.pitch, to.size);
        let period = bands.map(|band| std::f64::consts::TAU / (k * band.spacing));
        let share = grid.x.pitch * grid.y.pitch / (period[0] * period[1]);
        let shape = (bands[1].count, bands[0].count);
        let transfer = Array2::from_shape_fn(shape, |(j, i)| {
            let under = 1.0 - bands[0].at(i).powi(2) - bands[1].at(j).powi(2);
            match under > 0.0 {
                true => Complex64::from_polar(share, k * distance * under.sqrt()),
                false => Complex64::ZERO,
            }
        });
        Self {
            spread: Chirp2::new(nodes(&grid.y), nodes(&grid.x), waves[1], waves[0], -k),
            land: Chirp2::new(waves[1], waves[0], points(y, dy, ny), points(x, dx, nx), k),
            transfer,
        }
    }

    /// Carries the values at the grid's nodes to the points.
    pub fn carry(&self, values: ArrayView2<Complex64>) -> Array2<Complex64> {
        let mut waves = self.spread.apply(values);
        waves *= &self.transfer;
        self.land.apply(waves.view())
    }
}
