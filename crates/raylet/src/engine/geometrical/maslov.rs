//! The geometrical field where rays cross: every ray of smooth elements as one plane wave.
//!
//! In a focus the tube of a ray has no width, and a field built from tubes has no value. Its directions still
//! spread, and the sum of plane waves over them is finite (Maslov's method: Kravtsov and Orlov, "Caustics,
//! catastrophes and wave fields", Springer 1999). Here the waves are plane on the sphere about the middle of
//! the first screen's light: U(s) = Σ W·exp(ik[L + p′·(s − s′) + ½(s − s′)ᵀQ(s − s′)]) over cells of that
//! screen, |W| = (k/2π)√|det(∂p′/∂x − Q ∂s/∂x)| times the area of the cell. With Q = (∂p′/∂p)(∂s/∂p)⁻¹ of
//! the middle ray that is the kernel from a point of the screen to a point near its focus, so that the edge of
//! the screen diffracts as it should; edges behind it do not diffract.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::chain::arriving_light::sensor_of;
use crate::engine::geometrical::eikonal::{EikonalError, check_smooth};
use crate::engine::geometrical::ray_tube::{
    Matrix, RayTube, aperture_of, determinant, inverse, product, signature, trace_tube,
};
use crate::engine::progress::{Cancelled, Reply};
use crate::math::nufft::NufftError;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;
use crate::wave::beamlet::plane::{PlaneSum, PlaneWave};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::raster::Raster;

/// Relative tolerance of the sum.
const TOLERANCE: f64 = 1e-9;

/// Rays of a chunk: the unit of the sum.
const CHUNK: usize = 1 << 18;

/// The amplitude of the plane wave of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// By the density of directions: this gives the true field.
    Density,
    /// Equal for all rays, with Q = 0, as in the source paper's reference: right up to a factor where directions
    /// are spread evenly over the first screen.
    Equal,
}

/// Why the sum cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DirectionsError {
    /// The system has no smooth phases, no edge, or no sensor.
    #[error(transparent)]
    Rays(#[from] EikonalError),
    /// The sum cannot be planned.
    #[error(transparent)]
    Sum(#[from] NufftError),
    /// The progress callback cancelled the sum.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The field at the sensor's pixel centres from `count` rays along each axis of the first screen's outline, and
/// the number of rays that arrive. `progress` is called with the share that is done.
///
/// # Errors
/// Elements without a smooth phase, a first screen without an edge, no sensor, no ray that arrives, or `progress`
/// that cancels the sum.
pub fn sum_of_directions<R: Reply>(
    system: &System,
    count: usize,
    strength: Strength,
    progress: &(dyn Fn(f64) -> R + Sync),
) -> Result<(Field, u64), DirectionsError> {
    check_smooth(system)?;
    let first = &system.screens[0];
    let name = || first.name.clone();
    let [x0, x1, y0, y1] = first
        .bounds()
        .ok_or_else(|| EikonalError::Boundless(name()))?;
    let sensor = sensor_of(system).map_err(|_| EikonalError::NoSensor(name()))?;
    let grid = Grid::of(sensor);
    let raster = Raster {
        start: [grid.x.start, grid.y.start],
        pitch: [grid.x.pitch, grid.y.pitch],
        size: [grid.x.len(), grid.y.len()],
    };
    let open = unstopped(system);
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    let cells = Cells {
        sphere: match strength {
            Strength::Density => sphere(&open, middle),
            Strength::Equal => [[0.0; 2]; 2],
        },
        open,
        aperture: aperture_of(first),
        start: [x0, y0],
        size: [(x1 - x0) / count as f64, (y1 - y0) / count as f64],
        system,
        strength,
    };
    let mut sum = PlaneSum::new(raster, system.wavenumber(), TOLERANCE)?;
    let mut rays = 0;
    let all = count * count;
    for start in (0..all).step_by(CHUNK) {
        let end = all.min(start + CHUNK);
        let waves: Vec<PlaneWave> = (start..end)
            .into_par_iter()
            .filter_map(|n| cells.wave([n % count, n / count]))
            .collect();
        rays += waves.len() as u64;
        sum.add(&waves);
        Cancelled::check(progress(end as f64 / all as f64).flow())?;
    }
    if rays == 0 {
        return Err(EikonalError::Dark(name()).into());
    }
    let mut values: Array2<Complex64> = sum.finish();
    for ((j, i), value) in values.indexed_iter_mut() {
        let s = [grid.x.node(i), grid.y.node(j)];
        *value *= Complex64::cis(0.5 * system.wavenumber() * form(cells.sphere, s));
    }
    Ok((Field { grid, values }, rays))
}

/// Q of the ray in the middle, (∂p′/∂p)(∂s/∂p)⁻¹, which is symmetric; none where there is none.
fn sphere(open: &System, middle: [f64; 2]) -> Matrix {
    let tube = trace_tube(open, middle).ok();
    let found = tube.and_then(|tube| Some(product(tube.swing, inverse(tube.throw)?)));
    found.unwrap_or([[0.0; 2]; 2])
}

/// sᵀQs.
fn form(q: Matrix, s: [f64; 2]) -> f64 {
    (0..2)
        .map(|a| s[a] * (q[a][0] * s[0] + q[a][1] * s[1]))
        .sum()
}

/// The system whose first screen is open, for rays at the middle of cells that its edge cuts.
fn unstopped(system: &System) -> System {
    let mut open = system.clone();
    if let Some(first) = open.screens.first_mut() {
        match &mut first.kind {
            ScreenKind::Stop(aperture) => *aperture = Aperture::OPEN,
            ScreenKind::Doe(doe) => doe.aperture = Aperture::OPEN,
            ScreenKind::Sensor(_) => {}
        }
    }
    open
}

/// The cells of the first screen.
struct Cells<'a> {
    system: &'a System,
    /// Q of the waves.
    sphere: Matrix,
    /// The system with an open first screen, and what its aperture is.
    open: System,
    aperture: Aperture,
    start: [f64; 2],
    size: [f64; 2],
    strength: Strength,
}

impl Cells<'_> {
    /// The plane wave of the ray in the middle of a cell.
    fn wave(&self, cell: [usize; 2]) -> Option<PlaneWave> {
        let edge = |a: usize, step: usize| self.start[a] + (cell[a] + step) as f64 * self.size[a];
        let open = self
            .aperture
            .coverage(edge(0, 0), edge(0, 1), edge(1, 0), edge(1, 1));
        if open == 0.0 {
            return None;
        }
        let at = [0, 1].map(|a| edge(a, 0) + 0.5 * self.size[a]);
        let tube = trace_tube(&self.open, at).ok()?;
        let k = self.system.wavenumber();
        let first: &Screen = &self.system.screens[0];
        let light = self.system.source.field(
            first.frame.to_global(Vec3::new(at[0], at[1], 0.0)),
            k * first.index,
        );
        let area = open * self.size[0] * self.size[1];
        let strength = match self.strength {
            Strength::Density => density(&tube, self.sphere, k),
            Strength::Equal => Complex64::ONE,
        };
        // In front of exp(½ik sᵀQs), which all waves have, a wave goes along p′ − Qs′.
        let (q, s) = (self.sphere, tube.at);
        let path = tube.path - 0.5 * form(q, s);
        Some(PlaneWave {
            at: s,
            cosines: [0, 1].map(|a| tube.cosines[a] - q[a][0] * s[0] - q[a][1] * s[1]),
            amplitude: light * strength * area * Complex64::cis(k * path),
        })
    }
}

/// (k/2π)√|det(∂p′/∂x − Q ∂s/∂x)| of a tube, with what surfaces take, and the phase that makes the sum equal
/// to the tube's own field wherever that exists: by the method of stationary phase.
fn density(tube: &RayTube, q: Matrix, k: f64) -> Complex64 {
    let part = product(q, tube.spread);
    let turn = [0, 1].map(|a| [0, 1].map(|b| tube.turn[a][b] - part[a][b]));
    let passed = tube.amplitude * determinant(tube.spread).abs().sqrt();
    let size = 0.5 * k / std::f64::consts::PI * determinant(turn).abs().sqrt();
    let quarters = 2 * tube.foci + signature(turn, tube.spread);
    let angle = -0.25 * std::f64::consts::PI * f64::from(quarters);
    Complex64::from_polar(passed * size, angle)
}

#[cfg(test)]
mod tests {
    use crate::engine::chain::simulate::simulate;
    use crate::engine::geometrical::maslov::{Strength, sum_of_directions};
    use crate::engine::plan::settings::{Method, Settings};
    use crate::fixtures::paper_systems::{Window, grating};
    use crate::wave::grid::metrics::field_error;

    /// A lens of 3 mm that brings a grating's light to a focus, before it: beamlets find the same field.
    #[test]
    fn directions_make_the_field_of_beamlets_slow() {
        let sensor = Window {
            middle: [0.16, 0.0],
            count: 61,
            pitch: 4e-3,
        };
        let system = grating(1.5, false, sensor);
        let beamlets = Settings {
            method: Method::Beamlet,
            ..Settings::default()
        };
        let exact = simulate(&system, &beamlets, &|_| {}).unwrap();
        let error = |strength| {
            let (field, rays) = sum_of_directions(&system, 400, strength, &|_| {}).unwrap();
            assert!(rays > 120_000);
            field_error(field.values.view(), exact.field.values.view()).unwrap()
        };
        let density = error(Strength::Density);
        assert!(density < 5e-4, "{density:e}");
        assert!(error(Strength::Equal) > 0.5);
    }
}
