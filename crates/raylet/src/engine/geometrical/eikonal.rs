//! The geometrical field on a sensor behind smooth elements: no diffraction, exact aberrations.
//!
//! The first screen is cut into small cells. For every sensor pixel that a cell may light, the ray that
//! starts in the cell and ends at the pixel's centre is found by Newton's method; its path gives the
//! phase, its tube the amplitude, each line focus it passed −π/2. Sheets that overlap add. Pixels near
//! a caustic or focus, where the tube is narrower than a Fresnel zone, stay dark and are counted.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::geometrical::ray_tube::{RayTube, inverse, trace_tube};
use crate::math::vec3::Vec3;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;
use crate::wave::grid::field::{Field, Grid};

/// Why the generalised law of refraction cannot carry a system's light.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EikonalError {
    /// An element has no smooth phase.
    #[error(
        "the generalised law of refraction does not apply: '{0}' has pixels or a sum of \
         transmissions, whose phase has no gradient; expected analytic phases only"
    )]
    NotSmooth(String),
    /// An element stands on a curved surface.
    #[error("the generalised law of refraction is here for plane elements; '{0}' is curved")]
    Curved(String),
    /// The first screen has no edge.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
    /// The last screen is no sensor.
    #[error("the last screen is '{0}', expected a sensor")]
    NoSensor(String),
    /// No ray ends on the sensor.
    #[error("no ray from '{0}' ends on the sensor")]
    Dark(String),
    /// All the light on the sensor is close to a focus.
    #[error(
        "the generalised law of refraction does not apply: the sensor lies in a focus or caustic \
         (Fresnel number {fresnel:.2}, expected above {LEAST_FRESNEL}), where rays cross and only \
         diffraction limits the field"
    )]
    Focus {
        /// The largest Fresnel number of a ray on the sensor.
        fresnel: f64,
    },
}

/// Least Fresnel number of a pixel that is used.
pub(crate) const LEAST_FRESNEL: f64 = 1.0;

/// Cells along each axis of the first screen.
const CELLS: usize = 160;

/// Newton steps allowed; two or three are usual.
const STEPS: usize = 12;

/// The result.
#[derive(Clone, Debug)]
pub struct Geometrical {
    /// Field at the pixel centres.
    pub field: Field,
    /// Pixels that some ray reaches.
    pub lit: u64,
    /// Pixels left dark because a sheet that reaches them has a focus or caustic too close.
    pub unresolved: u64,
    /// Smallest Fresnel number among the pixels used.
    pub fresnel: f64,
    /// Rays traced.
    pub rays: u64,
}

/// One sheet's contribution to a pixel.
struct Share {
    pixel: [usize; 2],
    value: Complex64,
    fresnel: f64,
}

/// A ray that all but ends at the centre of a pixel.
struct NearRay {
    /// Where it starts on the first screen, in mm.
    start: [f64; 2],
    /// From there to the start of the ray that ends at the centre, in mm.
    step: [f64; 2],
    /// The tube about it.
    tube: RayTube,
}

/// What one row of cells lights.
struct Row {
    shares: Vec<Share>,
    rays: u64,
    /// Largest Fresnel number of a cell's corner that lands on the sensor.
    fresnel: Option<f64>,
}

/// Carries the light of a system of smooth elements to its sensor.
///
/// # Errors
/// When an element has no smooth phase, a screen no edge, no ray arrives, or the whole sensor lies in a
/// focus.
pub fn carry(system: &System) -> Result<Geometrical, EikonalError> {
    let (first, grid) = prepare(system)?;
    let bounds = first
        .bounds()
        .ok_or_else(|| EikonalError::Boundless(first.name.clone()))?;
    let pixel_rays = PixelRays::new(system, &grid, bounds);

    // Row by row of cells; rows are added in order, so the sum has the same bits for any threads.
    let rows: Vec<Row> = (0..CELLS)
        .into_par_iter()
        .map(|j| pixel_rays.row(j))
        .collect();
    let mut field = Field::zeros(grid);
    let mut worst = ndarray::Array2::from_elem(field.values.raw_dim(), f64::INFINITY);
    let (mut rays, mut best) = (0, None::<f64>);
    for row in rows {
        rays += row.rays;
        best = row.fresnel.map(|n| best.map_or(n, |m| m.max(n))).or(best);
        for share in row.shares {
            let [i, j] = share.pixel;
            field.values[[j, i]] += share.value;
            worst[[j, i]] = share.fresnel.min(worst[[j, i]]);
        }
    }

    // What is too close to a focus is taken out.
    let (mut lit, mut unresolved, mut fresnel) = (0, 0, f64::INFINITY);
    for (value, worst) in field.values.iter_mut().zip(&worst) {
        lit += u64::from(worst.is_finite());
        if *worst < LEAST_FRESNEL {
            *value = Complex64::ZERO;
            unresolved += 1;
        } else {
            fresnel = fresnel.min(*worst);
        }
    }
    if lit == unresolved {
        // Where rays do land on the sensor, they are so close that they miss every pixel's centre.
        return Err(match best {
            Some(fresnel) => EikonalError::Focus { fresnel },
            None => EikonalError::Dark(first.name.clone()),
        });
    }
    Ok(Geometrical {
        field,
        lit,
        unresolved,
        fresnel,
        rays,
    })
}

/// Whether every element of a system has a smooth phase.
///
/// # Errors
/// [`EikonalError::NotSmooth`] with the first that has not, [`EikonalError::Curved`] with the first that is
/// no plane.
pub(crate) fn check_smooth(system: &System) -> Result<(), EikonalError> {
    let rough = system.screens.iter().find(|screen| match &screen.kind {
        ScreenKind::Doe(doe) => doe.profiles().is_none(),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => false,
    });
    if let Some(screen) = rough {
        return Err(EikonalError::NotSmooth(screen.name.clone()));
    }
    match system.screens.iter().find(|screen| !screen.is_plane()) {
        Some(screen) => Err(EikonalError::Curved(screen.name.clone())),
        None => Ok(()),
    }
}

/// The first screen and the sensor's grid of a system that geometrical optics applies to.
fn prepare(system: &System) -> Result<(&Screen, Grid), EikonalError> {
    check_smooth(system)?;
    match (system.screens.first(), system.screens.last()) {
        (Some(first), Some(last)) => match &last.kind {
            ScreenKind::Sensor(sensor) => Ok((first, Grid::of(sensor))),
            _ => Err(EikonalError::NoSensor(last.name.clone())),
        },
        _ => Err(EikonalError::NoSensor(String::new())),
    }
}

/// Finds the rays that end at pixel centres.
struct PixelRays<'a> {
    system: &'a System,
    open: System,
    grid: &'a Grid,
    start: [f64; 2],
    cell: [f64; 2],
    half: f64,
}

impl<'a> PixelRays<'a> {
    fn new(system: &'a System, grid: &'a Grid, [x0, x1, y0, y1]: [f64; 4]) -> Self {
        let cell = [x1 - x0, y1 - y0].map(|width| width / CELLS as f64);
        Self {
            system,
            open: system.without_edges(),
            grid,
            start: [x0, y0],
            cell,
            half: 0.5 * (x1 - x0).min(y1 - y0),
        }
    }

    /// The corner (i, j) of the cells.
    fn corner(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.start[0] + i as f64 * self.cell[0],
            self.start[1] + j as f64 * self.cell[1],
        ]
    }

    /// Everything that one row of cells lights.
    fn row(&self, j: usize) -> Row {
        let corners = [j, j + 1].map(|j| {
            (0..=CELLS)
                .map(|i| {
                    let start = self.corner(i, j);
                    trace_tube(&self.open, start).ok().map(|tube| (start, tube))
                })
                .collect::<Vec<_>>()
        });
        let on_sensor = |(_, tube): &&([f64; 2], RayTube)| {
            [&self.grid.x, &self.grid.y]
                .iter()
                .zip(tube.at)
                .all(|(axis, s)| {
                    let [low, high] = axis.edges();
                    (low..=high).contains(&s)
                })
        };
        let fresnel = corners
            .iter()
            .flatten()
            .flatten()
            .filter(on_sensor)
            .map(|(_, tube)| tube.fresnel_number(self.half, self.system.wavelength))
            .reduce(f64::max);
        let mut rays = 2 * (CELLS as u64 + 1);
        let mut shares = Vec::new();
        for i in 0..CELLS {
            let around = [(0, 0), (0, 1), (1, 0), (1, 1)];
            let tubes: Vec<([f64; 2], RayTube)> = around
                .iter()
                .filter_map(|&(b, a)| corners[b][i + a])
                .collect();
            for pixel in self.pixels(&tubes, [i, j]) {
                if let Some(share) = self.share(&tubes, [i, j], pixel, &mut rays) {
                    shares.push(share);
                }
            }
        }
        Row {
            shares,
            rays,
            fresnel,
        }
    }

    /// The pixels that a cell may light: the box about what every corner's tube says of all corners.
    fn pixels(&self, tubes: &[([f64; 2], RayTube)], [i, j]: [usize; 2]) -> Vec<[usize; 2]> {
        let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for (start, tube) in tubes {
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let corner = self.corner(i + a, j + b);
                let step = [corner[0] - start[0], corner[1] - start[1]];
                for (axis, [low, high]) in reach.iter_mut().enumerate() {
                    let row = tube.spread[axis];
                    let s = tube.at[axis] + row[0] * step[0] + row[1] * step[1];
                    (*low, *high) = (low.min(s), high.max(s));
                }
            }
        }
        let range = |axis: usize| {
            let (line, [low, high]) = ([&self.grid.x, &self.grid.y][axis], reach[axis]);
            let margin = 0.1 * (high - low);
            let index = |s: f64| ((s - line.start) / line.pitch).clamp(-1.0, line.cells as f64);
            let first = index(low - margin).ceil().max(0.0) as usize;
            first..(index(high + margin).floor() + 1.0).max(0.0) as usize
        };
        if tubes.is_empty() {
            return Vec::new();
        }
        let (columns, rows) = (range(0), range(1));
        let (nx, ny) = (self.grid.x.cells, self.grid.y.cells);
        rows.take_while(|&y| y < ny)
            .flat_map(|y| columns.clone().take_while(|&x| x < nx).map(move |x| [x, y]))
            .collect()
    }

    /// The ray of one cell that ends at a pixel's centre, if there is one.
    fn share(
        &self,
        tubes: &[([f64; 2], RayTube)],
        cell: [usize; 2],
        pixel: [usize; 2],
        rays: &mut u64,
    ) -> Option<Share> {
        let goal = [self.grid.x.node(pixel[0]), self.grid.y.node(pixel[1])];
        let miss = |tube: &RayTube| [goal[0] - tube.at[0], goal[1] - tube.at[1]];
        let distance = |tube: &RayTube| miss(tube)[0].hypot(miss(tube)[1]);
        let nearest = tubes
            .iter()
            .min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)))?;

        // Newton's method on the landing point, within and near the cell.
        let (mut start, mut tube) = *nearest;
        for _ in 0..STEPS {
            let m = inverse(tube.spread)?;
            let [dx, dy] = miss(&tube);
            let step = m.map(|row| row[0] * dx + row[1] * dy);
            if (0..2).all(|a| step[a].abs() < 1e-6 * self.cell[a]) {
                return self.settle(&NearRay { start, step, tube }, cell, pixel, rays);
            }
            start = [start[0] + step[0], start[1] + step[1]];
            let away = |a: usize| self.place(start, a) - cell[a] as f64 - 0.5;
            if !(0..2).all(|a| away(a).abs() < 3.0) {
                return None;
            }
            *rays += 1;
            tube = trace_tube(&self.open, start).ok()?;
        }
        None
    }

    /// Position in cells from the corner of all.
    fn place(&self, start: [f64; 2], axis: usize) -> f64 {
        (start[axis] - self.start[axis]) / self.cell[axis]
    }

    /// The contribution of a ray that all but ends at the pixel, if it starts in its cell and nothing
    /// stands in its way.
    fn settle(
        &self,
        NearRay { start, step, tube }: &NearRay,
        cell: [usize; 2],
        pixel: [usize; 2],
        rays: &mut u64,
    ) -> Option<Share> {
        // Neighbouring cells find the same start to 1e-11; the shift keeps pixels off their border.
        let exact = [start[0] + step[0], start[1] + step[1]];
        let inside = |a: usize| (self.place(exact, a) + 1e-7).floor() == cell[a] as f64;
        if !(inside(0) && inside(1)) {
            return None;
        }
        *rays += 1;
        trace_tube(self.system, *start).ok()?;

        // The phase of the start's ray, carried over the rest of the way to the pixel by its gradient p.
        let first = &self.system.screens[0];
        let wavelength = self.system.wavelength;
        let k = self.system.wavenumber();
        let goal = [self.grid.x.node(pixel[0]), self.grid.y.node(pixel[1])];
        let rest: f64 = (0..2)
            .map(|a| tube.cosines[a] * (goal[a] - tube.at[a]))
            .sum();
        let global = first.frame.to_global(Vec3::new(start[0], start[1], 0.0));
        let incident = self.system.source.field(global, k * first.index);
        let gouy = -std::f64::consts::FRAC_PI_2 * f64::from(tube.foci);
        Some(Share {
            pixel,
            value: incident * Complex64::from_polar(tube.amplitude, k * (tube.path + rest) + gouy),
            fresnel: tube.fresnel_number(self.half, wavelength),
        })
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::geometrical::eikonal::{EikonalError, carry};
    use crate::fixtures::parts::{conic, element, face, on_axis, plane_wave, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::optics::surface::Surface;
    use crate::optics::system::System;
    use crate::optics::zernike::ZernikeSum;
    use crate::wave::grid::field::{Axis, Field};

    const WAVELENGTH: f64 = 0.7e-3;
    const K: f64 = std::f64::consts::TAU / WAVELENGTH;
    const HALF: f64 = 4.0;
    const TILT: f64 = 0.005;

    /// A square diffractive lens, lit at a small angle, and a sensor.
    fn weak_lens(focal_length: f64, z: f64, sensor: ScreenKind) -> System {
        let lens = Layer::Phase(Profile::Lens {
            focal_length,
            wavenumber: K,
        });
        let square = Aperture::turned_rectangle(HALF, HALF, 0.0, [0.0; 2]);
        System {
            wavelength: WAVELENGTH,
            source: plane_wave([TILT, 0.0]),
            screens: vec![
                screen(on_axis(0.0), ScreenKind::Doe(element(lens, square))),
                screen(on_axis(z), sensor),
            ],
            trains: vec![vec![]],
        }
    }

    /// One factor of the Fresnel integral behind that lens: (iλz)^{−1/2} ∫ e^{ik(px − x²/2f + (x−s)²/2z)} dx.
    fn fresnel(s: f64, tilt: f64, focal_length: f64, z: f64) -> Complex64 {
        let axis = Axis::gauss(8000, 2.0 * HALF / 8000.0, 0.0, 4);
        let sum: Complex64 = (0..axis.len())
            .map(|i| {
                let x = axis.node(i);
                let path = tilt * x - 0.5 * x * x / focal_length + 0.5 * (x - s).powi(2) / z;
                Complex64::from_polar(axis.weight(i), K * path)
            })
            .sum();
        sum / Complex64::new(0.0, WAVELENGTH * z).sqrt()
    }

    /// The relative error of a field whose exact values at z are products of factors along x and y.
    fn error_of(field: &Field, x: &[Complex64], y: &[Complex64], z: f64) -> f64 {
        let (mut off, mut norm) = (0.0, 0.0);
        for ((j, i), value) in field.values.indexed_iter() {
            let exact = x[i] * y[j] * Complex64::cis(K * z);
            off += (value - exact).norm_sqr();
            norm += exact.norm_sqr();
        }
        (off / norm).sqrt()
    }

    /// Before and behind the focus, where every ray has crossed all others: absolute phases. What is left
    /// is the diffraction of the edges, which shrinks with the root of the Fresnel number.
    #[test]
    fn weak_lens_agrees_with_the_fresnel_integral() {
        for (z, width, bound) in [(20.0, 4.0, 2e-2), (1200.0, 8.0, 8e-2)] {
            let (focal_length, n) = (400.0, 60);
            let sensor = sensor(n, width / n as f64);
            let mut system = weak_lens(focal_length, z, sensor);
            let centre = TILT * z;
            system.screens[1].frame.origin.x = centre;
            let ours = carry(&system).unwrap();
            assert_eq!((ours.lit, ours.unresolved), ((n * n) as u64, 0));

            let axis = &ours.field.grid.x;
            let along = |shift: f64, tilt: f64| -> Vec<Complex64> {
                (0..n)
                    .map(|i| fresnel(axis.node(i) + shift, tilt, focal_length, z))
                    .collect()
            };
            let (x, y) = (along(centre, TILT), along(0.0, 0.0));
            let error = error_of(&ours.field, &x, &y, z);
            assert!(error < bound, "{z}: {error:e}");
        }
    }

    /// Behind the line focus of a cylinder lens rays have crossed along one axis only: a quarter of a wave, whose
    /// sign two foci do not show.
    #[test]
    fn light_behind_a_line_focus_agrees_with_the_fresnel_integral() {
        let (focal_length, z, n) = (400.0, 1200.0, 40);
        // φ = −Kx²/2f is half a defocus, r², and half an astigmatism, x² − y²; Z₄ has a piston, which Z₁ takes away.
        let mut coefficients = vec![0.0; 6];
        let bend = -0.25 * K * HALF * HALF / focal_length;
        coefficients[0] = 0.5 * bend;
        (coefficients[3], coefficients[5]) = (bend / 12.0f64.sqrt(), bend / 6.0f64.sqrt());
        let mut system = weak_lens(focal_length, z, sensor(n, 2.0 / n as f64));
        let square = Aperture::turned_rectangle(HALF, HALF, 0.0, [0.0; 2]);
        let cylinder = Layer::Phase(Profile::Zernike(ZernikeSum::new(HALF, coefficients)));
        system.source = plane_wave([0.0; 2]);
        system.screens[0].kind = ScreenKind::Doe(element(cylinder, square));
        let ours = carry(&system).unwrap();
        assert_eq!((ours.lit, ours.unresolved), ((n * n) as u64, 0));

        let axis = &ours.field.grid.x;
        let along = |focal_length: f64| -> Vec<Complex64> {
            let at = |i| fresnel(axis.node(i), 0.0, focal_length, z);
            (0..n).map(at).collect()
        };
        let (x, y) = (along(focal_length), along(f64::INFINITY));
        let error = error_of(&ours.field, &x, &y, z);
        assert!(error < 8e-2, "{error:e}");
    }

    #[test]
    fn power_through_a_thick_lens_is_kept() {
        // A disc of light through a strong plano-convex lens, caught whole before its focus.
        let surface = |z: f64, curvature: f64, index: [f64; 2]| Surface {
            aperture: Aperture::disc(6.0),
            ..face(on_axis(z), conic(curvature, 0.0), index)
        };
        let radius = 3.0;
        let mut system = weak_lens(1.0, 15.0, sensor(400, 0.012));
        system.screens[0].kind = ScreenKind::Stop(Aperture::disc(radius));
        system.trains[0] = vec![
            surface(1.0, 1.0 / 25.8, [1.0, 1.5]),
            surface(6.0, 0.0, [1.5, 1.0]),
        ];
        let caught = carry(&system).unwrap();
        let area = std::f64::consts::PI * radius * radius;
        let share = caught.field.power() / area;
        assert!((share - 1.0).abs() < 2e-3, "{share}");
    }

    #[test]
    fn focus_is_refused() {
        let mut system = weak_lens(200.0, 199.9, sensor(31, 0.5e-3));
        system.screens[1].frame.origin.x = 1.0;
        let refused = carry(&system).unwrap_err();
        assert!(matches!(refused, EikonalError::Focus { .. }), "{refused}");
    }
}
