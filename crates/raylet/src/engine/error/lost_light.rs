//! Where the light goes that no beamlet follows.
//!
//! A hop follows only the directions that can reach its target. What the screen sends elsewhere is lost
//! for a reason: it lands beside the target, meets a rim, is totally reflected, is evanescent. An estimate
//! takes narrow patches in many places of the screen, whose plane waves go in *all* directions, sends
//! a ray along each, and adds up the energy by what became of the ray. Its shares are estimates: they
//! divide energy that is known exactly.

use rayon::prelude::*;

use crate::engine::error::tally::{FATES, Fate};
use crate::math::random::{Purpose, pair};
use crate::optics::ray::Loss;
use crate::optics::system::Hop;
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::heights::Heights;
use crate::wave::patches::curved::CurvedPatches;
use crate::wave::patches::patch::{Band, Patches, Spectrum};
use crate::wave::patches::window::{Positions, Synthesis};

/// Width σ of a narrow patch and its period, in wavelengths of the medium.
const WIDTH: f64 = 2.5;
const PERIOD: f64 = 15.0;

/// Places along each axis at most, and how many σ they are apart where there are fewer.
const PLACES: f64 = 8.0;
const APART: f64 = 2.0;

/// Samples per wavelength of the medium: what a hard edge sends to 5 … 7 times the index is taken for light that
/// propagates, a twelfth of its evanescent energy.
const SAMPLES: f64 = 6.0;

/// The local spectrum of a patch in all directions, as a plan that serves every place.
struct Lens {
    axis: Axis,
    band: Band,
    patches: Patches,
    middle: usize,
}

/// Energy by fate in units that only compare; what lands on the second screen is [`Fate::Elsewhere`], for
/// there is no reason why it should not have been followed.
///
/// `light` is the field just behind the first screen, on any grid.
pub(crate) fn lost_light(hop: &Hop, light: &(dyn Fn(Grid) -> Field + Sync)) -> [f64; FATES.len()] {
    let mut energy = [0.0; FATES.len()];
    let Some([x0, x1, y0, y1]) = hop.from.bounds() else {
        return energy;
    };
    let lens = Lens::new(hop);
    let apart = APART * WIDTH * hop.wavelength / hop.from.index_behind();
    let [columns, rows] =
        [x1 - x0, y1 - y0].map(|wide| (wide / apart).ceil().clamp(1.0, PLACES) as usize);
    let parts: Vec<_> = (0..rows * columns)
        .into_par_iter()
        .map(|place| {
            // Places are drawn one in each cell of a grid over the screen.
            let [u, v] = pair(0, [place as u32, 0, 0, Purpose::LostLight as u32]);
            let share = |cell: usize, u: f64, cells: usize| (cell as f64 + u) / cells as f64;
            let at = [
                x0 + (x1 - x0) * share(place % columns, u, columns),
                y0 + (y1 - y0) * share(place / columns, v, rows),
            ];
            lens.sample_at(hop, at, light)
        })
        .collect();
    for part in parts {
        energy = std::array::from_fn(|i| energy[i] + part[i]);
    }
    energy
}

impl Lens {
    fn new(hop: &Hop) -> Self {
        let n = hop.from.index_behind();
        let wavelength = hop.wavelength / n;
        let (sigma, period) = (WIDTH * wavelength, PERIOD * wavelength);
        let axis = Axis::uniform((PERIOD * SAMPLES) as usize, wavelength / SAMPLES, 0.0);
        // The middle one of enough windows for its coverage to be that of a whole lattice.
        let count = 9;
        let positions = Positions {
            start: -0.5 * (count - 1) as f64 * 1.5 * sigma,
            step: 1.5 * sigma,
            count,
            sigma,
            reach: 0.5 * period,
            synthesis: Synthesis::Window,
        };
        let band = Band::between(0.0, hop.wavelength / period, -n, n);
        let patches = Patches::new(
            [&axis; 2],
            [&positions; 2],
            [&band; 2],
            hop.wavenumber(),
            period,
        );
        Self {
            axis,
            band,
            patches,
            middle: (count / 2) * count + count / 2,
        }
    }

    /// Energy by fate at one place.
    fn sample_at(
        &self,
        hop: &Hop,
        at: [f64; 2],
        light: &(dyn Fn(Grid) -> Field + Sync),
    ) -> [f64; FATES.len()] {
        // The patch keeps its values and takes the coordinates of the plan.
        let moved = |a: usize| Axis {
            start: self.axis.start + at[a],
            ..self.axis.clone()
        };
        let there = Grid {
            x: moved(0),
            y: moved(1),
        };
        let here = Field {
            values: light(there.clone()).values,
            grid: Grid {
                x: self.axis.clone(),
                y: self.axis.clone(),
            },
        };
        let spectrum = match hop.from.is_plane() {
            true => self.patches.cut(&here, self.middle),
            false => CurvedPatches {
                patches: &self.patches,
                screen: hop.from,
                heights: &Heights::on(hop.from, &there),
                origin: at,
                bands: [&self.band; 2],
                k: hop.wavenumber(),
            }
            .cut(&here, self.middle),
        };
        let mut energy = [0.0; FATES.len()];
        if let Some(spectrum) = spectrum {
            self.spread(hop, at, &spectrum, &mut energy);
        }
        energy
    }

    fn spread(
        &self,
        hop: &Hop,
        at: [f64; 2],
        spectrum: &Spectrum,
        energy: &mut [f64; FATES.len()],
    ) {
        let n = hop.from.index_behind();
        let mut propagating = 0.0;
        for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
            let p = [self.band.at(mx), self.band.at(my)];
            if p[0].hypot(p[1]) >= n {
                continue;
            }
            propagating += c.norm_sqr();
            energy[fate(hop, at, p).place()] += c.norm_sqr();
        }
        let rest = (spectrum.energy - propagating).max(0.0);
        energy[Fate::Lost(Loss::Evanescent).place()] += rest;
    }
}

/// What becomes of a ray.
fn fate(hop: &Hop, at: [f64; 2], p: [f64; 2]) -> Fate {
    match hop.trace(at, p, &mut ()) {
        Err(loss) => Fate::Lost(loss),
        Ok(landing) => {
            let [x, y] = landing.at;
            let inside = hop
                .to
                .bounds()
                .is_some_and(|[x0, x1, y0, y1]| x >= x0 && x <= x1 && y >= y0 && y <= y1);
            if inside {
                Fate::Elsewhere
            } else {
                Fate::Outside
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::error::lost_light::lost_light;
    use crate::engine::error::tally::Fate;
    use crate::fixtures::parts::{box_pixels, face, on_axis, screen, sensor};

    use crate::optics::aperture::Aperture;

    use crate::optics::ray::Loss;

    use crate::optics::shape::Shape;
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;
    use crate::wave::grid::field::{Field, Grid};
    use crate::wave::grid::sampling::apply_screen;

    /// A grating of stripes with phases 0 and π, period 4λ, sends (2/πm)² of the light into each odd order
    /// m at sin θ = m/4. Behind it a window lets the first orders through and cuts the third ones; the
    /// fifth and higher ones are evanescent.
    #[test]
    fn orders_of_a_binary_grating_are_distinguished() {
        let stripe = |(_, x): (usize, usize)| Complex64::new(1.0 - 2.0 * (x % 2) as f64, 0.0);
        let grating = box_pixels(Array2::from_shape_fn((60, 60), stripe), 2.0);
        let from = screen(on_axis(0.0), grating);
        let to = screen(on_axis(1000.0), sensor(10, 1.0));
        let window = Surface {
            aperture: Aperture::disc(350.0),
            ..face(on_axis(500.0), Shape::Plane, [1.0, 1.0])
        };
        let hop = Hop {
            wavelength: 1.0,
            from: &from,
            train: &[window],
            to: &to,
        };
        let light = |grid: Grid| {
            let mut field = Field::zeros(grid);
            field.values.fill(Complex64::ONE);
            apply_screen(&from, &mut field);
            field
        };
        let energy = lost_light(&hop, &light);
        let total: f64 = energy.iter().sum();
        let share = |fate: Fate| energy[fate.place()] / total;
        let order = |m: f64| 2.0 * (2.0 / (std::f64::consts::PI * m)).powi(2);
        let evanescent = 1.0 - order(1.0) - order(3.0);
        let found = [
            (share(Fate::Outside), order(1.0)),
            (share(Fate::Lost(Loss::Clipped)), order(3.0)),
            (share(Fate::Lost(Loss::Evanescent)), evanescent),
        ];
        for (got, expected) in found {
            assert!((got - expected).abs() < 0.012, "{found:?}");
        }
    }
}
