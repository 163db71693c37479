//! Hops that need no rays: from a plane or curved screen to a parallel plane, through homogeneous or
//! plane-parallel media.
//!
//! Band-limited angular spectrum. The plane waves of a period P larger than both screens are summed
//! with the pixel's own spectrum (the nodes integrate the box pixels), and a taper over landing offsets
//! removes the directions whose periodic copies would reach the target (after Matsushima and Shimobaba,
//! Opt. Express 17, 19662, 2009, who cut where this tapers).

use ndarray::{Array1, Array2};
use num_complex::Complex64;

use crate::math::chirp::{Chirp2, Comb};
use crate::math::lanes::LANES;
use crate::wave::free::free_plan::{FreePlan, Slab, zone_width};
use crate::wave::free::slab_transfer::{Crossings, SlabTransfer};
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;
use crate::wave::grid::raster::Raster;
use crate::wave::patches::patch::Band;

/// A free hop between parallel planes.
#[derive(Clone, Debug)]
pub struct FreeHop {
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// The media between, in order.
    pub slabs: Vec<Slab>,
    /// Position of the receiving plane's origin in the emitting plane, in mm.
    pub offset: [f64; 2],
    /// Direction of the incident light, optical cosines: the lattice of plane waves has a node there.
    pub chief: [f64; 2],
    /// The least period P over W, the sum of the half widths of screen and target; at least 2.
    pub padding: f64,
    /// The least P − 2W in widths of a Fresnel zone of light that lands W away. The taper falls over directions that land between
    /// W and P − W: the narrower this range, the more the taper blurs the arriving light.
    pub clear: f64,
}

/// A period of this many times W leaves enough for steep light at any distance.
const CLEARS_STEEP: f64 = 4.0;

/// The part of the taper's range whose directions the nodes of a screen are to resolve: they do not lead to the target.
const RESOLVED_TAPER: f64 = 0.2;

/// [`FreeHop::clear`] for an error of 1e-3. Behind random pixels errors are 4e-4 to 1.3e-3 where W is half a zone, 8e-5 where
/// it is one zone, 1e-5 where it is five; behind open apertures a tenth of that.
pub const CLEAR: f64 = 13.0;

/// A period for an error below 1e-3 is taken if it is this many times the period for 1e-3. Where it is not, the error
/// hardly depends on it, and a tighter target does not change it by chance.
const WIDER: f64 = 1.15;

/// [`FreeHop::clear`] for an error.
pub(crate) fn clear_for(error: f64) -> f64 {
    (CLEAR + 2.5 * (1e-3 / error).ln()).clamp(6.0, 30.0)
}

/// A curved screen under a field: its heights at the nodes, and the sign with which light leaves along its
/// local z axis. Nothing for a plane.
pub(crate) type Surface<'a> = Option<(&'a Heights, f64)>;

/// The field that leaves a screen.
#[derive(Clone, Copy)]
pub(crate) struct EmittedField<'a> {
    /// Its values at the nodes of the screen.
    pub field: &'a Field,
    /// The surface of a curved screen.
    pub surface: Surface<'a>,
}

/// A parameter of a hop without rays: the same hop with the parameter a little smaller and a little larger.
pub(crate) struct PerturbedFreeHops {
    /// The hop with the smaller value.
    pub below: FreeHop,
    /// The hop with the larger value.
    pub above: FreeHop,
    /// The difference of the two values.
    pub distance: f64,
}

impl FreeHop {
    /// Chooses period and directions for a field within `from` and a target within `to`, both
    /// `[x_min, x_max, y_min, y_max]` in mm on their own planes.
    pub fn plan(&self, from: [f64; 4], to: [f64; 4]) -> FreePlan {
        let wavelength = std::f64::consts::TAU / self.k;
        let lowest = self
            .slabs
            .iter()
            .map(|s| s.index)
            .fold(f64::INFINITY, f64::min);
        let depth: f64 = self.slabs.iter().map(|s| s.thickness.abs() / s.index).sum();
        let axis = |a: usize| {
            // W covers every path from a point of the screen to a point of the target.
            let low = to[2 * a] + self.offset[a] - from[2 * a + 1];
            let high = to[2 * a + 1] + self.offset[a] - from[2 * a];
            let span = 0.5 * (high - low).max(0.0) + (0.5 * (high + low)).abs();
            let zone = match self.padding < CLEARS_STEEP {
                true => zone_width(wavelength, depth, span),
                false => (wavelength * depth).sqrt(),
            };
            let cleared = |clear: f64| (self.padding * span).max(2.0 * span + clear * zone);
            let usual = cleared(self.clear.min(CLEAR));
            let wider = cleared(self.clear);
            let period = if wider > WIDER * usual { wider } else { usual };
            // Beyond the direction that lands P − W away nothing is kept.
            let limit = self.direction_to(period - span, lowest);
            let band = Band::between(self.chief[a], wavelength / period, -limit, limit);
            (period, span, band)
        };
        let (x, y) = (axis(0), axis(1));
        let plan = FreePlan {
            period: [x.0, y.0],
            span: [x.1, y.1],
            bands: [x.2, y.2],
            reach: [lowest; 2],
            depth,
            wavelength,
        };
        let reach = |a: usize| {
            let [full, none] = plan.taper(a);
            let resolved = full + RESOLVED_TAPER * (none - full);
            self.direction_to(resolved, lowest)
        };
        FreePlan {
            reach: [reach(0), reach(1)],
            ..plan
        }
    }

    /// The cosine along an axis of the plane wave that lands this far away; `most` where none below does.
    fn direction_to(&self, landing: f64, most: f64) -> f64 {
        let (mut inside, mut outside) = (0.0, most);
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            match self.landing(middle, middle * middle) {
                Some(reached) if reached < landing => inside = middle,
                _ => outside = middle,
            }
        }
        outside
    }

    /// The landing offset along an axis of a plane wave with cosine p there and square |p|²; nothing
    /// when it is evanescent somewhere.
    fn landing(&self, p: f64, square: f64) -> Option<f64> {
        let mut total = 0.0;
        for slab in &self.slabs {
            let under = slab.index * slab.index - square;
            if under <= 0.0 {
                return None;
            }
            total += slab.thickness.abs() * p / under.sqrt();
        }
        Some(total)
    }

    /// Carries a field to the raster of the receiving plane. From a curved screen, along whose local z axis
    /// light leaves with a sign, by Weyl's sum over the true surface,
    /// c(p) = 1/P² Σ U e^{−ik(p·x ± q s)} N·(p, ±q)/(±q) dA with N = (−∇s, 1),
    /// the surface taken apart into levels. `plan` is that of [`FreeHop::plan`]; the result is the complex field at the
    /// points of the raster, in the unit of the field's own values, [y, x].
    pub fn carry(
        &self,
        field: &Field,
        surface: Surface,
        target: &Raster,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        let mut waves = self.emission_spectrum(field, surface, plan);
        self.cross(&mut waves, plan);
        self.land(&waves, target, plan)
    }

    /// The conjugate transpose of [`FreeHop::carry`], from the target's points to the nodes of the field, and the
    /// derivative with respect to each parameter. A parameter is given by `neighbours`: the hops with a slightly
    /// smaller and a slightly larger value, and the difference of the values. Dark nodes of a curved screen stay dark.
    pub(crate) fn carry_adjoint(
        &self,
        target_bar: &Array2<Complex64>,
        target: &Raster,
        emitted: EmittedField,
        plan: &FreePlan,
        perturbed: &[PerturbedFreeHops],
    ) -> (Array2<Complex64>, Vec<f64>) {
        let EmittedField { field, surface } = emitted;
        let mut waves_bar = self.land_adjoint(target_bar, target, plan);
        self.cross_adjoint(&mut waves_bar, plan);
        let mut parameters = Vec::new();
        if !perturbed.is_empty() {
            let waves = self.emission_spectrum(field, surface, plan);
            let along = |pair: &PerturbedFreeHops| pull(pair, &waves, &waves_bar, plan);
            parameters = perturbed.iter().map(along).collect();
        }
        (
            self.emission_spectrum_adjoint(&waves_bar, field, surface, plan),
            parameters,
        )
    }

    /// Each wave crosses the slabs.
    fn cross(&self, waves: &mut Array2<Complex64>, plan: &FreePlan) {
        let [band_x, band_y] = &plan.bands;
        let transfer = SlabTransfer::new(&self.slabs, plan);
        ndarray::Zip::indexed(waves.rows_mut()).par_for_each(|j, row| {
            let py = band_y.at(j);
            transfer.apply(row, |i| [band_x.at(i), py]);
        });
    }

    /// The conjugate transpose of [`FreeHop::cross`].
    fn cross_adjoint(&self, waves_bar: &mut Array2<Complex64>, plan: &FreePlan) {
        let [band_x, band_y] = &plan.bands;
        let transfer = SlabTransfer::new(&self.slabs, plan);
        ndarray::Zip::indexed(waves_bar.rows_mut()).par_for_each(|j, row| {
            let py = band_y.at(j);
            transfer.apply_adjoint(row, |i| [band_x.at(i), py]);
        });
    }

    /// Plane waves to the target's points, in the emitting plane's coordinates.
    fn land(
        &self,
        waves: &Array2<Complex64>,
        target: &Raster,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        self.points(target, plan).apply(waves.view())
    }

    /// The conjugate transpose of [`FreeHop::land`].
    fn land_adjoint(
        &self,
        target_bar: &Array2<Complex64>,
        target: &Raster,
        plan: &FreePlan,
    ) -> Array2<Complex64> {
        self.points(target, plan).apply_adjoint(target_bar.view())
    }

    /// The transform from a plan's directions to the target's points.
    fn points(&self, target: &Raster, plan: &FreePlan) -> Chirp2 {
        let [band_x, band_y] = &plan.bands;
        let points = |a: usize| Comb {
            start: target.start[a] + self.offset[a],
            step: target.pitch[a],
            count: target.size[a],
        };
        Chirp2::new(
            band_comb(band_y),
            band_comb(band_x),
            points(1),
            points(0),
            self.k,
        )
    }
}

/// The derivative of a loss along one parameter, from the waves that leave and their cotangent. The derivative of
/// wave·transfer is wave·transfer times the logarithmic derivative of the transfer, landing offset included.
fn pull(
    perturbed: &PerturbedFreeHops,
    waves: &Array2<Complex64>,
    waves_bar: &Array2<Complex64>,
    plan: &FreePlan,
) -> f64 {
    let [band_x, band_y] = &plan.bands;
    let PerturbedFreeHops { below, above, .. } = perturbed;
    let transfers = [below, above].map(|hop| SlabTransfer::new(&hop.slabs, plan));
    let moved = [0, 1].map(|a| above.offset[a] - below.offset[a]);
    let mut rows = Array1::zeros(waves.nrows());
    ndarray::Zip::indexed(&mut rows).par_for_each(|j, sum: &mut f64| {
        let py = band_y.at(j);
        let mut pairs = waves.row(j).into_iter().zip(waves_bar.row(j));
        for first in (0..band_x.count).step_by(LANES) {
            let met = (transfers.each_ref()).map(|t| t.crossings(first, |i| [band_x.at(i), py]));
            for (n, (wave, bar)) in pairs.by_ref().take(LANES).enumerate() {
                let shift = band_x.at(first + n) * moved[0] + py * moved[1];
                *sum += (bar.conj() * wave * log_ratio(&met, n, shift, below.k)).re;
            }
        }
    });
    rows.sum() / perturbed.distance
}

/// The difference of two logarithms of transfer, of the `n`-th of eight waves; nothing where none is left of it.
fn log_ratio([low, high]: &[Crossings; 2], n: usize, shift: f64, k: f64) -> Complex64 {
    if low.size[n] <= 0.0 || high.size[n] <= 0.0 {
        return Complex64::ZERO;
    }
    let path = high.path[n] - low.path[n] + shift;
    Complex64::new((high.size[n] / low.size[n]).ln(), k * path)
}

/// The comb of a band's directions.
pub(in crate::wave) fn band_comb(band: &Band) -> Comb {
    Comb {
        start: band.at(0),
        step: band.spacing,
        count: band.count,
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::optics::refraction::Coating;
    use crate::wave::free::free_plan::Slab;
    use crate::wave::free::propagate::{CLEAR, EmittedField, FreeHop};
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::raster::Raster;

    /// Over no distance a field that propagates arrives as it is.
    #[test]
    fn no_distance_changes_nothing() {
        let axis = Axis::uniform(60, 0.2, 0.0);
        let mut field = Field::zeros(Grid {
            x: axis.clone(),
            y: axis.clone(),
        });
        for ((j, i), value) in field.values.indexed_iter_mut() {
            let (x, y) = (axis.node(i), axis.node(j));
            *value = Complex64::from_polar((-(x * x + y * y) / 2.0).exp(), 0.5 * x);
        }
        let hop = FreeHop {
            k: std::f64::consts::TAU,
            slabs: vec![Slab {
                index: 1.0,
                thickness: 0.0,
                exit: None,
            }],
            offset: [0.0; 2],
            chief: [0.0; 2],
            padding: 4.0,
            clear: CLEAR,
        };
        let raster = Raster {
            start: [axis.node(0); 2],
            pitch: [0.2; 2],
            size: [60; 2],
        };
        let plan = hop.plan([-6.0, 6.0, -6.0, 6.0], [-6.0, 6.0, -6.0, 6.0]);
        let carried = hop.carry(&field, None, &raster, &plan);
        for (there, here) in carried.iter().zip(&field.values) {
            assert!((there - here).norm() < 1e-6, "{there} {here}");
        }
    }

    /// A Gaussian beam has a closed form: the paraxial one, accurate to (λ/πw)² for a wide waist.
    #[test]
    fn gaussian_beam_spreads_as_it_should() {
        let (wavelength, waist, z) = (1e-3, 0.1, 60.0);
        let k = std::f64::consts::TAU / wavelength;
        let axis = Axis::uniform(120, 0.01, 0.0);
        let mut field = Field::zeros(Grid {
            x: axis.clone(),
            y: axis.clone(),
        });
        for ((j, i), value) in field.values.indexed_iter_mut() {
            let square = axis.node(i).powi(2) + axis.node(j).powi(2);
            *value = Complex64::new((-square / (waist * waist)).exp(), 0.0);
        }
        let hop = FreeHop {
            k,
            slabs: vec![Slab {
                index: 1.0,
                thickness: z,
                exit: None,
            }],
            offset: [0.1, -0.05],
            chief: [0.0, 0.0],
            padding: 4.0,
            clear: CLEAR,
        };
        let raster = Raster {
            start: [-0.4, -0.4],
            pitch: [0.02, 0.02],
            size: [41, 41],
        };
        let plan = hop.plan([-0.6, 0.6, -0.6, 0.6], [-0.4, 0.4, -0.4, 0.4]);
        let carried = hop.carry(&field, None, &raster, &plan);
        let q = Complex64::new(1.0, z / (0.5 * k * waist * waist));
        let (mut error, mut norm) = (0.0, 0.0);
        for ((j, i), value) in carried.indexed_iter() {
            let (x, y) = (-0.3 + 0.02 * i as f64, -0.45 + 0.02 * j as f64);
            let exact = (-(x * x + y * y) / (waist * waist) / q).exp() / q * Complex64::cis(k * z);
            error += (value - exact).norm_sqr();
            norm += exact.norm_sqr();
        }
        assert!((error / norm).sqrt() < 2e-4, "{:e}", (error / norm).sqrt());
    }

    /// Through two media, to a target aside.
    #[test]
    fn carry_dot_product() {
        let axis = Axis::gauss(20, 0.5, 0.0, 2);
        let grid = Grid {
            x: axis.clone(),
            y: axis.clone(),
        };
        let slab = |index: f64, exit: Option<Coating>| Slab {
            index,
            thickness: 6.0,
            exit,
        };
        let hop = FreeHop {
            k: std::f64::consts::TAU,
            slabs: vec![slab(1.0, Some(Coating::Fresnel)), slab(1.5, None)],
            offset: [0.6, -0.4],
            chief: [0.1, 0.0],
            padding: 4.0,
            clear: CLEAR,
        };
        let raster = Raster {
            start: [-4.0, -5.0],
            pitch: [0.3, 0.4],
            size: [27, 23],
        };
        let plan = hop.plan([-5.0, 5.0, -5.0, 5.0], [-4.0, 4.0, -5.0, 4.0]);
        let field = Field {
            values: noise(grid.shape(), 0),
            grid,
        };
        let there = hop.carry(&field, None, &raster, &plan);
        let bar = noise(there.dim(), 1);
        let emitted = EmittedField {
            field: &field,
            surface: None,
        };
        let (back, _) = hop.carry_adjoint(&bar, &raster, emitted, &plan, &[]);
        assert_transposed(&[(&bar, &there)], &[(&back, &field.values)]);
    }
}
