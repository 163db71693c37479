//! Where a screen's field is sampled, and what the screen does to it there.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::optics::aperture::Aperture;
use crate::optics::doe::Doe;
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::grid::aperture_coverage::ApertureCoverage;
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::raster::Raster;
use crate::wave::grid::screen_axis::{open_axis, pixel_axis};
use crate::wave::grid::singular_cells::SingularNodes;

/// Why a screen cannot be sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SamplingError {
    /// The screen has no edge, so there is no finite field on it.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
    /// A curved screen exists nowhere within its edge.
    #[error(
        "the surface of screen '{0}' does not exist within its edge; make its aperture smaller"
    )]
    Absent(String),
    /// The grid would be larger than allowed.
    #[error(
        "the field on screen '{screen}' needs {needed} × {needed_y} samples, more than the {allowed} \
         allowed; reduce its size or its steepest phase, or raise memory_limit_mb"
    )]
    TooLarge {
        /// The screen.
        screen: String,
        /// Samples along x.
        needed: usize,
        /// Samples along y.
        needed_y: usize,
        /// Samples allowed altogether.
        allowed: usize,
    },
}

/// The range of optical direction cosines a grid must resolve, per axis [x, y].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// Largest |p| of the arriving light.
    pub arriving: [f64; 2],
    /// Largest |p| of the light that matters behind the screen.
    pub leaving: [f64; 2],
}

/// Plans the nodes of a screen: the pixels of its element, or equal cells over its aperture, with enough Gauss
/// nodes each for what arrives, what the element adds and what matters behind it.
///
/// # Errors
/// When the screen has no edge, or needs more than `allowed` samples.
pub(crate) fn plan_grid(
    screen: &Screen,
    reach: Reach,
    wavelength: f64,
    allowed: usize,
) -> Result<Grid, SamplingError> {
    let bounds = screen
        .bounds()
        .ok_or_else(|| SamplingError::Boundless(screen.name.clone()))?;
    let doe = match &screen.kind {
        ScreenKind::Doe(doe) => Some(doe),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    };
    let slope = doe.map_or([0.0; 2], |doe| {
        doe.steepest(bounds)
            .map(|g| g * wavelength / std::f64::consts::TAU)
    });
    let relief = screen
        .relief()
        .ok_or_else(|| SamplingError::Absent(screen.name.clone()))?;
    let swing = swing(screen, reach);
    let total =
        |a: usize| reach.arriving[a] + slope[a] + reach.leaving[a] + relief.slope[a] * swing;

    let cut = !ends_with_cells(screen, doe, bounds);
    let axis = |a: usize| {
        let frequency = total(a) / wavelength;
        match doe.and_then(|doe| doe.pixels()) {
            Some(pixels) => {
                let side = doe.map_or(1.0, |doe| doe.active_sides()[a]);
                pixel_axis(&pixels.lattice(), a, side, frequency, cut)
            }
            None => {
                let on_surface = doe.is_some_and(Doe::has_surface_pixels);
                open_axis(
                    [bounds[2 * a], bounds[2 * a + 1]],
                    frequency,
                    on_surface,
                    cut,
                )
            }
        }
    };
    let grid = Grid {
        x: axis(0),
        y: axis(1),
    };
    let [needed_y, needed] = grid.shape();
    if needed.saturating_mul(needed_y) > allowed {
        return Err(SamplingError::TooLarge {
            screen: screen.name.clone(),
            needed,
            needed_y,
            allowed,
        });
    }
    Ok(grid)
}

/// The largest change of the normal cosine of light at a screen. On a curved screen this times the slope is a phase
/// rate.
fn swing(screen: &Screen, reach: Reach) -> f64 {
    let n = screen.index;
    if screen.leaves() != screen.arrives {
        return 2.0 * n;
    }
    let least = |p: [f64; 2]| (n * n - p[0] * p[0] - p[1] * p[1]).max(0.0).sqrt();
    n - least(reach.arriving).min(least(reach.leaving))
}

/// Whether the aperture of a screen ends at the outer sides of its cells, so that it cuts none of them.
fn ends_with_cells(screen: &Screen, doe: Option<&Doe>, bounds: [f64; 4]) -> bool {
    let Some(pixels) = doe.and_then(|doe| doe.pixels()) else {
        return screen.is_rectangular();
    };
    let (rows, columns) = pixels.values.dim();
    let half = [columns, rows].map(|cells| 0.5 * cells as f64);
    let on_side = |a: usize, end: f64| {
        let place = end / pixels.pitch[a] + half[a];
        (place - place.round()).abs() < 1e-9
    };
    let open = doe.is_some_and(|doe| doe.aperture == Aperture::OPEN);
    open || screen.is_rectangular() && (0..4).all(|i| on_side(i / 2, bounds[i]))
}

/// Multiplies an arriving field by the screen's transmission, and by what its aperture lets through of the
/// nodes ([`ApertureCoverage`]); about singular points by what the cells have there ([`SingularNodes`]).
pub(crate) fn apply_screen(screen: &Screen, field: &mut Field) {
    let (doe, aperture) = parts(screen);
    for_open_nodes(aperture, field, |value, at, cell, open| {
        *value *= open * doe.map_or(Complex64::ONE, |doe| doe.transmission_over(at, cell));
    });
    if let Some(doe) = doe {
        singular_nodes(doe, &field.grid).apply(&mut field.values);
    }
}

/// What an element has at the nodes about singular points of its phase.
pub(crate) fn singular_nodes(doe: &Doe, grid: &Grid) -> SingularNodes {
    SingularNodes::of_cells(&doe.singular_phases(), [&grid.x, &grid.y])
}

/// ∫|U|² behind a screen, from the field before it and behind it on one grid. Weights in cells that an edge cuts integrate the
/// edge times a smooth factor, not its square: behind a stop, ∫|U|² is the overlap of both fields.
pub(crate) fn power_behind(screen: &Screen, before: &Field, behind: &Field) -> f64 {
    match screen.kind {
        ScreenKind::Stop(_) => before.overlap(behind),
        ScreenKind::Doe(_) | ScreenKind::Sensor(_) => behind.power(),
    }
}

/// The conjugate transpose of [`apply_screen`] with respect to the arriving field, in place; and, from the field
/// that arrived, the cotangent of the transmission of the pixels of the element's first pixel layer, [y, x].
pub(crate) fn apply_screen_adjoint(
    screen: &Screen,
    arrived: &Field,
    bar: &mut Field,
) -> Option<Array2<Complex64>> {
    let (doe, aperture) = parts(screen);
    if let Some(doe) = doe {
        singular_nodes(doe, &bar.grid).apply_adjoint(&mut bar.values);
    }
    let pixels_bar = doe.and_then(|doe| pixels_cotangent(doe, arrived, bar));

    // The field: value = arrived·(open·t).
    for_open_nodes(aperture, bar, |value, at, cell, open| {
        let through = doe.map_or(Complex64::ONE, |doe| doe.transmission_over(at, cell));
        *value *= open * through.conj();
    });
    pixels_bar
}

/// The cotangent of the pixels a design may change: value = arrived·open·t, t linear in each pixel.
fn pixels_cotangent(doe: &Doe, arrived: &Field, bar: &Field) -> Option<Array2<Complex64>> {
    let mut total = Array2::zeros(doe.free_pixels()?.values.dim());
    let grid = &arrived.grid;
    let (spans_x, spans_y) = (spans(&grid.x), spans(&grid.y));
    let aperture = ApertureCoverage::new(&doe.aperture, grid);
    let nodes = grid.y.offsets.len();
    for row in 0..grid.y.cells {
        for ((g, i), open) in aperture.row(row).indexed_iter() {
            let j = row * nodes + g;
            let weight = bar.values[[j, i]] * arrived.values[[j, i]].conj() * open;
            if weight != Complex64::ZERO {
                let mut add = |pixel: [usize; 2], by: Complex64| total[pixel] += weight * by.conj();
                let at = [grid.x.node(i), grid.y.node(j)];
                doe.visit_pixels(at, [spans_x[i], spans_y[j]], &mut add);
            }
        }
    }
    Some(total)
}

/// The element of a screen, if it has one, and its aperture.
fn parts(screen: &Screen) -> (Option<&Doe>, &Aperture) {
    match &screen.kind {
        ScreenKind::Doe(doe) => (Some(doe), &doe.aperture),
        ScreenKind::Stop(aperture) => (None, aperture),
        ScreenKind::Sensor(_) => (None, &Aperture::OPEN),
    }
}

/// Changes the value of each node that an aperture leaves open at least in part, from its place, its spans
/// and its weight; the other nodes become zero.
fn for_open_nodes(
    aperture: &Aperture,
    field: &mut Field,
    change: impl Fn(&mut Complex64, [f64; 2], [[f64; 2]; 2], f64) + Sync,
) {
    let Field { grid, values } = field;
    let (spans_x, spans_y) = (spans(&grid.x), spans(&grid.y));
    let aperture = ApertureCoverage::new(aperture, grid);
    let nodes = grid.y.offsets.len();
    let rows = values.axis_chunks_iter_mut(ndarray::Axis(0), nodes);
    rows.into_par_iter()
        .enumerate()
        .for_each(|(row, mut values)| {
            let weights = aperture.row(row);
            for (((g, i), value), open) in values.indexed_iter_mut().zip(&weights) {
                let j = row * nodes + g;
                if *open == 0.0 {
                    *value = Complex64::ZERO;
                } else {
                    let at = [grid.x.node(i), grid.y.node(j)];
                    change(value, at, [spans_x[i], spans_y[j]], *open);
                }
            }
        });
}

/// What each node of an axis represents.
fn spans(axis: &Axis) -> Vec<[f64; 2]> {
    (0..axis.len()).map(|i| axis.span(i)).collect()
}

/// The raster on which an arriving field is summed before it meets a screen: over the screen's aperture
/// and a margin for the interpolation, at a pitch of λ/(3 p_max).
///
/// # Errors
/// As [`plan_grid`].
pub(crate) fn plan_raster(
    screen: &Screen,
    reach: [f64; 2],
    wavelength: f64,
    allowed: usize,
) -> Result<Raster, SamplingError> {
    let bounds = screen
        .bounds()
        .ok_or_else(|| SamplingError::Boundless(screen.name.clone()))?;
    let pitch = reach.map(|p| wavelength / (3.0 * p.max(1e-3)));
    let mut raster = Raster {
        start: [0.0; 2],
        pitch,
        size: [0; 2],
    };
    for a in 0..2 {
        let [low, high] = [bounds[2 * a], bounds[2 * a + 1]];
        let across = ((high - low) / pitch[a]).ceil() as usize;
        raster.size[a] = across.saturating_add(TAPS + 1);
        raster.start[a] = 0.5 * (low + high) - 0.5 * (raster.size[a] as f64 - 1.0) * pitch[a];
    }
    if raster.size[0].saturating_mul(raster.size[1]) > allowed {
        return Err(SamplingError::TooLarge {
            screen: screen.name.clone(),
            needed: raster.size[0],
            needed_y: raster.size[1],
            allowed,
        });
    }
    Ok(raster)
}

/// Samples that take part in one interpolated value.
const TAPS: usize = 24;

/// Interpolates a band-limited field from a raster to the nodes of a grid.
///
/// Kaiser-windowed sinc of 24 taps; for a field sampled 1.5 times above its Nyquist rate the error is
/// about 3e-6 of its amplitude.
pub(crate) fn interpolate(raster: &Raster, values: &Array2<Complex64>, grid: &Grid) -> Field {
    let along_x = taps(&grid.x, raster.start[0], raster.pitch[0], raster.size[0]);
    let along_y = taps(&grid.y, raster.start[1], raster.pitch[1], raster.size[1]);
    let mut rows = Array2::zeros((values.nrows(), grid.x.len()));
    ndarray::Zip::from(rows.rows_mut())
        .and(values.rows())
        .par_for_each(|mut out, row| {
            for (value, (first, weights)) in out.iter_mut().zip(&along_x) {
                let terms = row.iter().skip(*first).zip(weights);
                *value = terms.map(|(u, w)| u * w).sum::<Complex64>();
            }
        });
    let mut field = Field::zeros(grid.clone());
    ndarray::Zip::indexed(field.values.rows_mut()).par_for_each(|j, mut out| {
        let (first, weights) = &along_y[j];
        for (t, w) in weights.iter().enumerate() {
            out.scaled_add(Complex64::new(*w, 0.0), &rows.row(first + t));
        }
    });
    field
}

/// The conjugate transpose of [`interpolate`]: from the nodes of a grid to a raster.
pub(crate) fn interpolate_adjoint(raster: &Raster, field_bar: &Field) -> Array2<Complex64> {
    let grid = &field_bar.grid;
    let along_x = taps(&grid.x, raster.start[0], raster.pitch[0], raster.size[0]);
    let along_y = taps(&grid.y, raster.start[1], raster.pitch[1], raster.size[1]);
    // out += w·row, a strip of columns at a time
    let mut rows_bar: Array2<Complex64> = Array2::zeros((raster.size[1], grid.x.len()));
    let columns = ndarray::Axis(1);
    rows_bar
        .axis_chunks_iter_mut(columns, STRIP)
        .into_par_iter()
        .zip(field_bar.values.axis_chunks_iter(columns, STRIP))
        .for_each(|(mut rows_bar, bar)| {
            for ((first, weights), bar) in along_y.iter().zip(bar.rows()) {
                for (t, w) in weights.iter().enumerate() {
                    let mut row = rows_bar.row_mut(first + t);
                    row.scaled_add(Complex64::new(*w, 0.0), &bar);
                }
            }
        });
    // value = Σ u·w
    let mut values_bar = Array2::zeros((raster.size[1], raster.size[0]));
    ndarray::Zip::from(values_bar.rows_mut())
        .and(rows_bar.rows())
        .par_for_each(|mut values_bar, row| {
            for (bar, (first, weights)) in row.iter().zip(&along_x) {
                for (t, w) in weights.iter().enumerate() {
                    values_bar[first + t] += bar * w;
                }
            }
        });
    values_bar
}

/// Columns that one thread takes at a time.
const STRIP: usize = 64;

/// First raster index and weights for each node of an axis.
fn taps(axis: &Axis, start: f64, pitch: f64, size: usize) -> Vec<(usize, Vec<f64>)> {
    let half = 0.5 * TAPS as f64;
    // β = π·half·(1 − 1/1.5) balances pass band and stop band for 1.5-fold oversampling.
    let beta = std::f64::consts::PI * half / 3.0;
    let kernel = |t: f64| {
        if t.abs() >= half {
            return 0.0;
        }
        let sinc = if t == 0.0 {
            1.0
        } else {
            (std::f64::consts::PI * t).sin() / (std::f64::consts::PI * t)
        };
        sinc * bessel_i0(beta * (1.0 - (t / half).powi(2)).sqrt()) / bessel_i0(beta)
    };
    (0..axis.len())
        .map(|i| {
            let place = (axis.node(i) - start) / pitch;
            let first = (place - half).ceil().clamp(0.0, (size - TAPS) as f64) as usize;
            let weights = (0..TAPS)
                .map(|t| kernel(place - (first + t) as f64))
                .collect();
            (first, weights)
        })
        .collect()
}

/// Modified Bessel function I₀ by its power series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum, mut n) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= quarter / (n * n);
        sum += term;
        n += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{self, screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::active_area::ActiveArea;
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
    use crate::optics::screen::ScreenKind;
    use crate::wave::grid::field::Field;
    use crate::wave::grid::sampling::{apply_screen, apply_screen_adjoint, interpolate_adjoint};
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::wave::grid::field::{Axis, Grid};
    use crate::wave::grid::raster::Raster;
    use crate::wave::grid::sampling::interpolate;

    #[test]
    fn interpolation_is_exact_within_the_band() {
        // p_max = 0.9 at λ = 1: pitch λ/(3 p_max), nodes well inside the raster's margin.
        let raster = Raster {
            start: [-15.0, -15.0],
            pitch: [1.0 / 2.7; 2],
            size: [82, 82],
        };
        let wave = |x: f64, y: f64| {
            let k = std::f64::consts::TAU;
            Complex64::cis(k * (0.9 * x + 0.2 * y)) + Complex64::cis(k * (0.1 * x - 0.9 * y))
        };
        let values = Array2::from_shape_fn((82, 82), |(j, i)| {
            wave(-15.0 + i as f64 / 2.7, -15.0 + j as f64 / 2.7)
        });
        let grid = Grid {
            x: Axis::gauss(20, 0.5, 0.0, 3),
            y: Axis::gauss(20, 0.5, 0.0, 3),
        };
        let field = interpolate(&raster, &values, &grid);
        let mut worst = 0.0f64;
        for ((j, i), value) in field.values.indexed_iter() {
            worst = worst.max((value - wave(grid.x.node(i), grid.y.node(j))).norm());
        }
        assert!(worst < 1e-5, "{worst:e}");
    }

    #[test]
    fn interpolate_dot_product() {
        let raster = Raster {
            start: [-15.0, -12.0],
            pitch: [0.4, 0.5],
            size: [90, 60],
        };
        let grid = Grid {
            x: Axis::gauss(20, 0.5, 0.0, 3),
            y: Axis::uniform(70, 0.3, 0.4),
        };
        let values = noise((60, 90), 0);
        let bar = Field {
            values: noise(grid.shape(), 1),
            grid,
        };
        let there = interpolate(&raster, &values, &bar.grid).values;
        let back = interpolate_adjoint(&raster, &bar);
        assert_transposed(&[(&bar.values, &there)], &[(&back, &values)]);
    }

    /// Both transposes: to the field that arrives, and to the pixels.
    #[test]
    fn act_dot_product() {
        for form in [PixelForm::Box, PixelForm::Bilinear] {
            let element = |values: Array2<Complex64>| {
                let cone = Layer::Phase(Profile::Axicon { slope: 0.7 });
                let mut doe = parts::element(cone, Aperture::disc(4.3));
                doe.layers.push(Layer::Phase(Profile::Vortex { charge: 2 }));
                doe.layers.push(Layer::Pixels(Pixels {
                    pitch: [0.9, 1.1],
                    values,
                    form,
                    active: ActiveArea::WHOLE,
                    placement: Placement::NONE,
                }));
                screen(Frame::GLOBAL, ScreenKind::Doe(doe))
            };
            let grid = Grid {
                x: Axis::gauss(12, 0.9, 0.0, 3),
                y: Axis::uniform(33, 0.31, 0.0),
            };
            let arrived = Field {
                values: noise(grid.shape(), 2),
                grid,
            };
            let pixels = noise((9, 11), 3);
            let screen = element(pixels.clone());
            let mut behind = arrived.clone();
            apply_screen(&screen, &mut behind);
            let bar = noise(behind.values.dim(), 4);
            let mut arrived_bar = Field {
                values: bar.clone(),
                grid: arrived.grid.clone(),
            };
            let pixels_bar = apply_screen_adjoint(&screen, &arrived, &mut arrived_bar).unwrap();
            let there = [(&bar, &behind.values)];
            assert_transposed(&there, &[(&arrived_bar.values, &arrived.values)]);
            assert_transposed(&there, &[(&pixels_bar, &pixels)]);
        }
    }
}
