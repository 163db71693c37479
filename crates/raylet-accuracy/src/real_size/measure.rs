//! One case: its run, its expected error, and its error against the integral over the stop.

use std::error::Error;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Outline;
use raylet::optics::doe::Doe;
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::system::System;

use crate::objective::ray_integral::{cell_nodes, field, polar_nodes};
use crate::objective::surface_integral::field_at;
use crate::real_size::cases::{Case, Reference};
use crate::real_size::resources::{peak_megabytes, processor_seconds};

/// What a case took, and how exact it is.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Processor time in seconds, of all threads.
    pub processor: f64,
    /// Wall time in seconds.
    pub wall: f64,
    /// Largest memory of the process up to the end of the run, in MB.
    pub megabytes: f64,
    /// Expected relative error of the field.
    pub expected: f64,
    /// The part of it that is counted for edges of lenses, which the reference does not know.
    pub rims: f64,
    /// Relative L2 error of the field on a block of pixels about the brightest one, nothing fitted; nothing where the
    /// reference does not apply.
    pub error: Option<f64>,
}

/// Runs a case and its reference.
///
/// # Errors
/// When the scene has a fault, or the system is refused.
pub fn measure(case: &Case) -> Result<Measured, Box<dyn Error>> {
    let (system, settings) = case.system()?;
    let (clock, start) = (Instant::now(), processor_seconds());
    let outcome = simulate(&system, &settings, &|_| {})?;
    Ok(Measured {
        processor: processor_seconds() - start,
        wall: clock.elapsed().as_secs_f64(),
        megabytes: peak_megabytes(),
        expected: outcome.expected_error().unwrap_or(0.0),
        rims: (outcome.hops.iter()).fold(0.0, |all, hop| hop.tally.edge.hypot(all)),
        error: error(case, &system, &outcome.field.values),
    })
}

/// The error on the block of pixels about the brightest one.
fn error(case: &Case, system: &System, ours: &Array2<Complex64>) -> Option<f64> {
    if case.reference == Reference::Surface {
        return surface_error(case, system, ours);
    }
    let [i, j] = corner(ours, case.block);
    let mut part = system.clone();
    focus_on(part.screens.last_mut()?, [i, j], case.block)?;
    let exact = reference(case, &part)?;
    let pairs = exact.indexed_iter();
    let off = pairs.map(|((row, column), exact)| (ours[[j + row, i + column]] - exact).norm_sqr());
    let all = exact.iter().map(|exact| exact.norm_sqr());
    Some((off.sum::<f64>() / all.sum::<f64>()).sqrt())
}

/// The error on pixels spread over the sensor, behind a reflecting element.
fn surface_error(case: &Case, system: &System, ours: &Array2<Complex64>) -> Option<f64> {
    let screen = system.screens.last()?;
    let ScreenKind::Sensor(sensor) = screen.kind else {
        return None;
    };
    // The middles of as many parts of each side, [x, y].
    let index = |a: usize, i: usize| (2 * i + 1) * sensor.pixels[a] / (2 * case.block);
    let spread = (0..case.block).flat_map(|j| (0..case.block).map(move |i| [i, j]));
    let pixels: Vec<[usize; 2]> = spread.map(|[i, j]| [index(0, i), index(1, j)]).collect();
    let place =
        |a: usize, i: usize| (i as f64 + 0.5 - 0.5 * sensor.pixels[a] as f64) * sensor.pitch[a];
    let global =
        |[i, j]: &[usize; 2]| (screen.frame).to_global(Vec3::new(place(0, *i), place(1, *j), 0.0));
    let points: Vec<Vec3> = pixels.iter().map(global).collect();
    let exact = field_at(system, &points, case.nodes)?;
    let off = pixels
        .iter()
        .zip(&exact)
        .map(|([i, j], exact)| (ours[[*j, *i]] - exact).norm_sqr());
    let all = exact.iter().map(|exact| exact.norm_sqr());
    Some((off.sum::<f64>() / all.sum::<f64>()).sqrt())
}

/// The first column and row of the block of so many pixels whose middle is nearest to the brightest pixel.
fn corner(values: &Array2<Complex64>, block: usize) -> [usize; 2] {
    let brighter =
        |a: &(_, &Complex64), b: &(_, &Complex64)| a.1.norm_sqr().total_cmp(&b.1.norm_sqr());
    let brightest = values.indexed_iter().max_by(brighter);
    let (row, column) = brightest.map_or((0, 0), |(at, _)| at);
    let first = |at: usize, count: usize| at.saturating_sub(block / 2).min(count - block);
    [first(column, values.ncols()), first(row, values.nrows())]
}

/// Makes a sensor the block of its pixels from this column and row on; nothing for other screens.
fn focus_on(screen: &mut Screen, first: [usize; 2], block: usize) -> Option<()> {
    let ScreenKind::Sensor(sensor) = &mut screen.kind else {
        return None;
    };
    let Sensor { pixels, pitch } = *sensor;
    let middle = |a: usize| first[a] as f64 + 0.5 * (block as f64 - pixels[a] as f64);
    let [x, y] = [0, 1].map(|a| middle(a) * pitch[a]);
    sensor.pixels = [block; 2];
    screen.frame = screen.frame.moved(Vec3::new(x, y, 0.0));
    Some(())
}

/// The field by the integral over the stop.
fn reference(case: &Case, system: &System) -> Option<Array2<Complex64>> {
    let stop = &system.screens[system.screens.len() - 2];
    let doe = match &stop.kind {
        ScreenKind::Doe(doe) => doe.clone(),
        ScreenKind::Stop(aperture) => Doe {
            layers: Vec::new(),
            aperture: aperture.clone(),
            reflect: false,
        },
        ScreenKind::Sensor(_) => return None,
    };
    if let Some(pixels) = doe.pixels() {
        let cell = pixels.pitch[0].min(pixels.pitch[1]) / case.cells as f64;
        return field(system, &cell_nodes(&doe, cell));
    }
    let [left, right, _, _] = doe.aperture.bounds()?;
    if let Outline::Disc { radius } = doe.aperture.outline {
        return field(system, &polar_nodes(&doe, radius, case.nodes));
    }
    let cell = (right - left) / case.nodes[0] as f64;
    field(system, &cell_nodes(&doe, cell))
}
