//! Rays of any tracer at a diffractive element: the secondary rays that leave it, and the transposed call.
//!
//! About each arriving ray a patch of the element is cut out, lit as that ray says, and split into plane
//! waves; each plane wave is a secondary ray that carries weight·exp(ik·path). Where the rays arrive, how
//! they got there and what becomes of the secondary rays is up to their tracer; arrays go in and come out.
//!
//! All rays of one call belong to one wavefront: where their windows overlap, they are shares of the same
//! light. Light of several wavefronts is several calls, whose fields add.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::external::scatter_settings::{Coverage, ScatterError, Scattering};
use crate::engine::external::secondary_rays::{ChosenMode, SecondaryRays};
use crate::engine::progress::{Cancelled, Pulse};
use crate::math::vec3::Vec3;
use crate::optics::bundle::{Hit, RayError, Rays, check_finite, check_length, check_positive};
use crate::optics::deflection::transmitted;
use crate::optics::doe::Doe;
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::grid::field::Grid;
use crate::wave::grid::heights::Heights;
use crate::wave::grid::sampling::{Reach, plan_grid};
use crate::wave::grid::transmission::{NoPixels, phase_bar, pixels_bar, screen_transmission};
use crate::wave::patches::local_spectrum::{Emitter, LocalSpectrum, Window};
use crate::wave::patches::window::Synthesis;
use crate::wave::patches::window_coverage::window_coverage;

/// Cotangents of what secondary rays are made from.
#[derive(Clone, Debug)]
pub struct ScatterBar {
    /// Cotangent of the element's transmission at its nodes ([`Scatter::grid`]), indexed [y, x].
    pub transmission: Array2<Complex64>,
    /// Cotangent of the complex amplitude of each arriving ray.
    pub weight: Vec<Complex64>,
}

/// Rays on a diffractive element, ready to be scattered.
pub struct Scatter<'a> {
    screen: &'a Screen,
    doe: &'a Doe,
    rays: Rays<'a>,
    hits: Vec<Hit>,
    /// The amplitude of each arriving ray behind the interface, if the element stands on one: zero where it is totally reflected.
    arrived: Vec<Complex64>,
    curvature: Option<&'a [[f64; 3]]>,
    settings: Scattering,
    k: f64,
    grid: Grid,
    heights: Option<Heights>,
    open: Array2<bool>,
    /// What the element transmits at its nodes.
    transmission: Array2<Complex64>,
    /// The share of it that one window takes, beside the window itself.
    share: Array2<f64>,
    /// The two multiplied.
    shared: Array2<Complex64>,
    floor: f64,
}

/// Rays whose patches are worked on before their cotangents are added up.
const CHUNK: usize = 64;

impl<'a> Scatter<'a> {
    /// Takes rays that arrive at a diffractive element; `wavelength` is that of the vacuum, in mm.
    ///
    /// `curvature`, one entry for each ray where it is given, holds the second derivatives (xx, xy, yy) in
    /// 1/mm of the arriving light's optical path along the axes of the plane that touches the element (on a
    /// plane element its own x and y axes): (n/R)(δ − dₐd_b) for a spherical wave of radius R and direction
    /// cosines d, R positive when it diverges. Without it every ray is taken for a plane wave.
    ///
    /// # Errors
    /// When arrays or settings are wrong, or the element has no edge or needs too many samples.
    pub fn new(
        screen: &'a Screen,
        wavelength: f64,
        rays: Rays<'a>,
        curvature: Option<&'a [[f64; 3]]>,
        settings: Scattering,
    ) -> Result<Self, ScatterError> {
        let ScreenKind::Doe(doe) = &screen.kind else {
            return Err(ScatterError::NoElement(screen.name.clone()));
        };
        if doe.pixels().is_some_and(|own| !own.placement.is_none()) {
            return Err(ScatterError::PlacedPixels(screen.name.clone()));
        }
        settings.check()?;
        check_positive("wavelength", wavelength)?;
        settings.check_modes(screen.index_behind(), wavelength)?;
        let hits = rays.hits(screen, wavelength)?;
        let arrived = hits.iter().zip(rays.weight).map(|(hit, weight)| {
            let factor = transmitted(screen, &screen.shape, hit.at, hit.cosines);
            factor.map_or(Complex64::ZERO, |factor| *weight * factor)
        });
        let arrived = arrived.collect();
        if let Some(curvature) = curvature {
            check_length("curvature", curvature.len(), rays.len(), "position")?;
            check_finite("curvature", curvature.iter().copied())?;
        }

        // The element on nodes that resolve what arrives and what may leave.
        let reach = Reach {
            arriving: arriving(&hits, curvature, &settings),
            leaving: leaving(screen, &settings),
        };
        let grid = plan_grid(screen, reach, wavelength, settings.samples)?;
        let transmission = screen_transmission(screen, &grid);
        let aperture = Screen {
            kind: ScreenKind::Stop(doe.aperture.clone()),
            ..screen.clone()
        };
        let open = screen_transmission(&aperture, &grid).mapv(|t| t != Complex64::ZERO);
        let share = share(&hits, &grid, &settings);
        let mut scatter = Self {
            screen,
            doe,
            rays,
            hits,
            arrived,
            curvature,
            settings,
            k: std::f64::consts::TAU / wavelength,
            heights: (!screen.is_plane()).then(|| Heights::on(screen, &grid)),
            open,
            shared: &transmission * &share,
            transmission,
            share,
            grid,
            floor: 0.0,
        };
        scatter.floor = settings.threshold * scatter.strongest();
        Ok(scatter)
    }

    /// The nodes on which the element is known, on its local plane.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The element's transmission at its nodes, apertures weighted by area, indexed [y, x].
    pub fn transmission(&self) -> &Array2<Complex64> {
        &self.transmission
    }

    /// The largest share that one window takes of an open node, over the mean: near one for evenly spread
    /// rays, large where they leave a gap; infinite where no window reaches an open node.
    pub fn unevenness(&self) -> f64 {
        let (mut most, mut sum, mut count) = (0.0f64, 0.0, 0.0);
        for (share, _) in self.share.iter().zip(&self.open).filter(|(_, open)| **open) {
            let share = if *share > 0.0 { *share } else { f64::INFINITY };
            most = most.max(share);
            sum += share.min(f64::MAX);
            count += 1.0;
        }
        most * count / sum
    }

    /// The map from transmission to modes about one ray.
    fn spectrum(&self, ray: usize) -> Option<LocalSpectrum> {
        let emitter = Emitter {
            screen: self.screen,
            grid: &self.grid,
            heights: self.heights.as_ref(),
            open: &self.open,
            k: self.k,
            window: self.settings.window,
            period: self.settings.period,
            towards: self.settings.followed(self.screen.index_behind()),
        };
        LocalSpectrum::new(&emitter, &self.hits[ray], self.curvature.map(|k| k[ray]))
    }

    /// The strongest mode of all rays.
    fn strongest(&self) -> f64 {
        if self.settings.threshold == 0.0 {
            return 0.0;
        }
        let strongest = |ray: usize| {
            let cut = self.spectrum(ray)?.cut(&self.shared);
            let peak = cut.iter().map(|c| c.norm_sqr()).fold(0.0, f64::max);
            Some(peak.sqrt() * self.arrived[ray].norm())
        };
        let all = (0..self.hits.len()).into_par_iter();
        all.filter_map(strongest).reduce(|| 0.0, f64::max)
    }

    /// The secondary rays of some of the arriving rays. Modes that do not propagate, are not to be followed, are too
    /// weak or were not drawn are left out. The same for any number of threads and any division into ranges.
    pub fn scatter(&self, rays: Range<usize>) -> SecondaryRays {
        let parts: Vec<(SecondaryRays, [f64; 2])> = (rays.start..rays.end.min(self.hits.len()))
            .into_par_iter()
            .filter_map(|ray| self.split(ray))
            .collect();
        SecondaryRays::gathered(parts)
    }

    /// The secondary rays of all arriving rays, if there are at most `most`; the pulse is called for each arriving ray.
    ///
    /// # Errors
    /// More secondary rays than that, or a pulse that cancels the work.
    pub fn scatter_within(
        &self,
        most: usize,
        pulse: &Pulse,
    ) -> Result<SecondaryRays, ScatterError> {
        let count = AtomicUsize::new(0);
        let enough = || count.load(Ordering::Relaxed) > most;
        let rays = 0..self.hits.len();
        let parts = rays.into_par_iter().map(|ray| {
            Cancelled::check(pulse())?;
            let part = if enough() { None } else { self.split(ray) };
            let made = part.as_ref().map_or(0, |(part, _)| part.parent.len());
            count.fetch_add(made, Ordering::Relaxed);
            Ok(part)
        });
        let parts: Vec<Option<(SecondaryRays, [f64; 2])>> =
            parts.collect::<Result<_, Cancelled>>()?;
        if enough() {
            return Err(RayError::Setting {
                field: "rays",
                found: format!("more than {most} secondary rays, for which the memory limit has no room"),
                expected: "fewer directions to follow, a shorter period, a higher threshold or fewer rays",
            }
            .into());
        }
        let parts = parts.into_iter().flatten();
        Ok(SecondaryRays::gathered(parts.collect()))
    }

    /// The secondary rays of one arriving ray, and Σ|c|² above the threshold and altogether.
    fn split(&self, ray: usize) -> Option<(SecondaryRays, [f64; 2])> {
        let spectrum = self.spectrum(ray)?;
        let mut cut = spectrum.cut(&self.shared);
        cut.mapv_inplace(|c| c * self.arrived[ray]);
        let loud = |c: &Complex64| Some(c.norm()).filter(|size| *size >= self.floor);
        let sizes: Vec<f64> = cut.iter().map(|c| loud(c).unwrap_or(0.0)).collect();
        let energy = [
            sizes.iter().map(|size| size * size).sum(),
            cut.iter().map(|c| c.norm_sqr()).sum(),
        ];

        // What the rays of one patch have in common, in global coordinates.
        let frame = &self.screen.frame;
        let [x, y] = self.hits[ray].at;
        let position = frame.to_global(Vec3::new(x, y, spectrum.height));
        let window = match self.settings.window {
            Window::Gaussian { sigma } => spectrum.stretch.map(|v| v / (sigma * sigma)),
            Window::Square { .. } => [0.0; 3],
        };
        let mut part = SecondaryRays::default();
        for ChosenMode { mode, times } in self.settings.drawing.choose(&sizes, cut.dim(), ray) {
            let Some(leaving) = spectrum.modes[mode] else {
                continue;
            };
            let direction = frame.direction_to_global(leaving.direction);
            part.parent.push(ray);
            part.position.push([position.x, position.y, position.z]);
            part.direction.push([direction.x, direction.y, direction.z]);
            part.path.push(self.rays.path[ray]);
            part.weight.push(cut[mode] * times);
            part.window.push(window);
            part.cosine.push(leaving.cosine);
            part.mode.push(mode);
            part.times.push(times);
        }
        Some((part, energy))
    }

    /// The complex weights of given secondary rays, with this element and these amplitudes of the arriving rays: one
    /// weight for each secondary ray. The rays are not chosen again, as line searches and finite differences need it.
    ///
    /// # Errors
    /// When the rays are no secondary rays of these arriving rays.
    pub fn weigh(&self, secondary: &SecondaryRays) -> Result<Vec<Complex64>, RayError> {
        self.check(secondary)?;
        let weights: Vec<Vec<Complex64>> = secondary
            .families()
            .into_par_iter()
            .map(|family| {
                let ray = secondary.parent[family.start];
                let cut = self
                    .spectrum(ray)
                    .map(|spectrum| spectrum.cut(&self.shared));
                let weight = |i: usize| {
                    let c = cut.as_ref().and_then(|cut| cut.get(secondary.mode[i]));
                    c.map_or(Complex64::ZERO, |c| {
                        c * self.arrived[ray] * secondary.times[i]
                    })
                };
                family.map(weight).collect()
            })
            .collect();
        Ok(weights.into_iter().flatten().collect())
    }

    /// The conjugate transpose of [`Scatter::weigh`]: from the cotangents of the secondary weights to those of the
    /// element and of the arriving amplitudes. The choice of modes and its probabilities are held constant. Where
    /// nothing was drawn at random, it is the exact transpose for the modes that were kept.
    ///
    /// # Errors
    /// When the rays are no secondary rays of these arriving rays, or there is not one cotangent for each.
    pub fn weigh_adjoint(
        &self,
        secondary: &SecondaryRays,
        weight_bar: &[Complex64],
    ) -> Result<ScatterBar, RayError> {
        self.check(secondary)?;
        let (found, expected) = (weight_bar.len(), secondary.len());
        check_length("weight_bar", found, expected, "secondary ray")?;
        let mut bar = ScatterBar {
            transmission: Array2::zeros(self.grid.shape()),
            weight: vec![Complex64::ZERO; self.hits.len()],
        };
        for families in secondary.families().chunks(CHUNK) {
            let parts: Vec<_> = families
                .par_iter()
                .map(|family| self.give_back(secondary, family.clone(), weight_bar))
                .collect();
            for (family, part) in families.iter().zip(parts) {
                let Some((spectrum, nodes, amplitude)) = part else {
                    continue;
                };
                spectrum.add_to(&nodes, &mut bar.transmission);
                bar.weight[secondary.parent[family.start]] += amplitude;
            }
        }
        // shared = transmission·share
        ndarray::Zip::from(&mut bar.transmission)
            .and(&self.share)
            .for_each(|t, share| *t *= share);
        Ok(bar)
    }

    /// The adjoint of one patch: its spectrum, and the cotangents of its nodes, [y, x], and of the arriving amplitude.
    fn give_back(
        &self,
        secondary: &SecondaryRays,
        family: Range<usize>,
        weight_bar: &[Complex64],
    ) -> Option<(LocalSpectrum, Array2<Complex64>, Complex64)> {
        let ray = secondary.parent[family.start];
        let spectrum = self.spectrum(ray)?;
        // weight = c·arrived·times, arrived = amplitude·factor
        let mut bar = Array2::zeros(spectrum.modes.dim());
        for i in family {
            if let Some(c) = bar.get_mut(secondary.mode[i]) {
                *c += weight_bar[i] * secondary.times[i];
            }
        }
        let cut = spectrum.cut(&self.shared);
        let arrived: Complex64 = cut.iter().zip(&bar).map(|(c, bar)| c.conj() * bar).sum();
        let hit = &self.hits[ray];
        let factor =
            transmitted(self.screen, &self.screen.shape, hit.at, hit.cosines).unwrap_or(0.0);
        let amplitude = arrived * factor;
        bar.mapv_inplace(|c| c * self.arrived[ray].conj());
        let nodes = spectrum.cut_adjoint(&bar);
        Some((spectrum, nodes, amplitude))
    }

    fn check(&self, secondary: &SecondaryRays) -> Result<(), RayError> {
        let fits = |parent: &usize| *parent < self.hits.len();
        match secondary.parent.iter().find(|parent| !fits(parent)) {
            None => Ok(()),
            Some(parent) => Err(RayError::Setting {
                field: "parent",
                found: parent.to_string(),
                expected: "the index of one of the arriving rays",
            }),
        }
    }

    /// Cotangents of the element's phase at its nodes in 1/rad, given those of its transmission: Im(t̄ t*).
    pub fn phase_bar(&self, bar: &ScatterBar) -> Array2<f64> {
        phase_bar(&bar.transmission, &self.transmission)
    }

    /// Cotangents of the element's complex pixels v, indexed [y, x], given those of its transmission;
    /// Im(v̄ v*) is the gradient by their phases.
    ///
    /// # Errors
    /// When the element is not one grid of box or point pixels, alone or times analytic phases.
    pub fn pixels_bar(&self, bar: &ScatterBar) -> Result<Array2<Complex64>, NoPixels> {
        pixels_bar(self.screen, self.doe, &self.grid, &bar.transmission)
    }
}

/// The share of each node that one window takes, beside the window itself.
fn share(hits: &[Hit], grid: &Grid, settings: &Scattering) -> Array2<f64> {
    let Scattering {
        window, synthesis, ..
    } = *settings;
    let circle = match synthesis {
        Synthesis::Window => std::f64::consts::PI,
        Synthesis::Plain => std::f64::consts::TAU,
    };
    match settings.coverage {
        Coverage::Area(area) => {
            let whole = match window {
                Window::Square { side } => side * side,
                Window::Gaussian { sigma } => circle * sigma * sigma,
            };
            Array2::from_elem(grid.shape(), area / whole)
        }
        Coverage::Divide => {
            let power = match synthesis {
                Synthesis::Window => 2,
                Synthesis::Plain => 1,
            };
            let centres: Vec<[f64; 2]> = hits.iter().map(|hit| hit.at).collect();
            let sum = window_coverage(&centres, grid, window, settings.period, power);
            sum.mapv(|sum| if sum > 0.0 { 1.0 / sum } else { 0.0 })
        }
    }
}

/// Largest |p| of the light that is followed behind the element, along x and y.
fn leaving(screen: &Screen, settings: &Scattering) -> [f64; 2] {
    let n = screen.index_behind();
    let [x0, x1, y0, y1] = settings.followed(n);
    [x0.abs().max(x1.abs()), y0.abs().max(y1.abs())].map(|p| p.min(n))
}

/// Largest |p| of the arriving light along x and y, curvature over half a period included.
fn arriving(hits: &[Hit], curvature: Option<&[[f64; 3]]>, settings: &Scattering) -> [f64; 2] {
    let half = 0.5 * settings.period;
    let mut largest = [0.0f64; 2];
    for (i, hit) in hits.iter().enumerate() {
        let [xx, xy, yy] = curvature.map_or([0.0; 3], |all| all[i]).map(f64::abs);
        let bent = [half * (xx + xy), half * (xy + yy)];
        for a in 0..2 {
            largest[a] = largest[a].max(hit.cosines[a].abs() + bent[a]);
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::external::scatter::Scatter;
    use crate::engine::external::scatter_settings::{Drawing, Scattering};
    use crate::engine::plan::settings::Sampler;
    use crate::fixtures::noise::column;
    use crate::fixtures::scattered::{COUNT, Columns, tilted_element};

    use crate::optics::screen::Screen;

    fn settings() -> Scattering {
        Scattering {
            threshold: 1e-2,
            ..Scattering::beamlets(2.0)
        }
    }

    fn plan<'a>(screen: &'a Screen, columns: &'a Columns, settings: Scattering) -> Scatter<'a> {
        Scatter::new(
            screen,
            1.0,
            columns.rays(),
            Some(&columns.curvature),
            settings,
        )
        .unwrap()
    }

    fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
        a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    }

    #[test]
    fn weigh_dot_product() {
        for (curvature, sampler) in [
            (0.0, Sampler::All),
            (0.0, Sampler::Systematic),
            (0.01, Sampler::Multinomial),
            (0.01, Sampler::All),
        ] {
            let pixels = column(COUNT * COUNT, 1);
            let screen = tilted_element(curvature, &pixels);
            let columns = Columns::on(&screen);
            let drawing = Drawing {
                sampler,
                most: 60,
                seed: 7,
            };
            let settings = Scattering {
                drawing,
                ..settings()
            };
            let plan = plan(&screen, &columns, settings);
            let secondary = plan.scatter(0..49);
            let weights = plan.weigh(&secondary).unwrap();
            assert_eq!(weights.len(), secondary.len());
            let off = weights.iter().zip(&secondary.weight);
            assert!(off.map(|(a, b)| (a - b).norm()).sum::<f64>() < 1e-12);

            let bar = column(weights.len(), 2);
            let back = plan.weigh_adjoint(&secondary, &bar).unwrap();
            let forward = inner(&bar, &weights);
            let size = (inner(&bar, &bar) * inner(&weights, &weights))
                .norm()
                .sqrt();
            // By the arriving amplitudes, by the nodes, by the pixels.
            let by_rays = inner(&back.weight, &columns.weight);
            let nodes = |a: &Array2<Complex64>| a.iter().copied().collect::<Vec<_>>();
            let by_nodes = inner(&nodes(&back.transmission), &nodes(plan.transmission()));
            let by_pixels = inner(&nodes(&plan.pixels_bar(&back).unwrap()), &pixels);
            for reverse in [by_rays, by_nodes, by_pixels] {
                assert!(
                    (forward - reverse).norm() < 1e-13 * size,
                    "{forward} {reverse}"
                );
            }

            // The phase of one pixel, by central differences of held rays.
            let value = |turn: f64| {
                let mut pixels = pixels.clone();
                pixels[77] *= Complex64::cis(turn);
                let screen = tilted_element(curvature, &pixels);
                let weights = self::plan(&screen, &columns, settings).weigh(&secondary);
                inner(&bar, &weights.unwrap()).re
            };
            let h = 1e-4;
            let difference = (value(h) - value(-h)) / (2.0 * h);
            let v_bar = plan.pixels_bar(&back).unwrap()[[77 / COUNT, 77 % COUNT]];
            let gradient = (v_bar * pixels[77].conj()).im;
            assert!((gradient - difference).abs() < 1e-7 * (1.0 + gradient.abs()));
        }
    }
}
