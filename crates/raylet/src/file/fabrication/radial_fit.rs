//! Coefficients of a phase that depends on the radius alone: φ = A₀ + Σ Aᵢ (r/R)^{2i}, as the surface BINARY_2 of Zemax
//! OpticStudio has them without A₀.
//!
//! Means over rings of the width of a cell are unwrapped from the centre outwards, and fitted. What this fit leaves of each
//! cell, between −π and π, is fitted again: so the result is the least squares over all cells. Polynomials that are orthogonal
//! over the disc keep this exact for many coefficients.

use std::f64::consts::TAU;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, choice_fault};
use crate::file::fabrication::open_part::OpenPart;

/// Fits of what the fit before has left.
const REFINEMENTS: usize = 3;

/// A rotational phase.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RadialFit {
    /// The radius R in mm: half of the smaller width of the cells, or the reach of the aperture if that is less.
    pub radius_mm: f64,
    /// A₁, A₂, … in rad.
    pub coefficients: Vec<f64>,
    /// A₀ in rad.
    pub constant: f64,
    /// Root mean square of what is left, in rad.
    pub residual: f64,
    /// Number of cells within the radius.
    pub count: u64,
}

/// Equations of least squares, as their sums.
struct Normal {
    matrix: Vec<Vec<f64>>,
    right: Vec<f64>,
    squares: f64,
    weight: f64,
}

impl Normal {
    fn new(count: usize) -> Self {
        Self {
            matrix: vec![vec![0.0; count]; count],
            right: vec![0.0; count],
            squares: 0.0,
            weight: 0.0,
        }
    }

    /// Adds an equation: a sum of the basis is a value.
    fn add(&mut self, basis: &[f64], value: f64, weight: f64) {
        for ((row, right), b) in self.matrix.iter_mut().zip(&mut self.right).zip(basis) {
            *right += weight * b * value;
            for (cell, c) in row.iter_mut().zip(basis) {
                *cell += weight * b * c;
            }
        }
        self.squares += weight * value * value;
        self.weight += weight;
    }

    /// Root mean square of the values.
    fn rms(&self) -> f64 {
        (self.squares / self.weight).sqrt()
    }

    /// The solution by elimination; nothing where the equations leave it open.
    fn solve(mut self) -> Option<Vec<f64>> {
        let count = self.right.len();
        let largest = self
            .matrix
            .iter()
            .flatten()
            .fold(0.0_f64, |most, a| most.max(a.abs()));
        for step in 0..count {
            let pivot_row = self.matrix.get(step)?.clone();
            let pivot_right = *self.right.get(step)?;
            let pivot = *pivot_row.get(step)?;
            // The matrix is positive, so that no exchange of rows is needed.
            if pivot.is_nan() || pivot <= 1e-13 * largest {
                return None;
            }
            let rows = self.matrix.iter_mut().zip(&mut self.right).enumerate();
            for (_, (row, right)) in rows.filter(|(i, _)| *i != step) {
                let factor = row.get(step)? / pivot;
                for (cell, above) in row.iter_mut().zip(&pivot_row) {
                    *cell -= factor * above;
                }
                *right -= factor * pivot_right;
            }
        }
        let diagonal = self.matrix.iter().enumerate().map(|(i, row)| row.get(i));
        let solved = diagonal.zip(&self.right).map(|(d, right)| Some(right / d?));
        solved.collect()
    }
}

/// Legendre polynomials of 2t − 1, from degree 0.
fn basis(t: f64, values: &mut [f64]) {
    let x = 2.0 * t - 1.0;
    let (mut before, mut now) = (0.0, 1.0);
    for (degree, value) in values.iter_mut().enumerate() {
        *value = now;
        let n = degree as f64;
        let next = ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0);
        (before, now) = (now, next);
    }
}

/// Coefficients of 1, t, t², … of a sum of these polynomials.
fn powers(sum: &[f64]) -> Vec<f64> {
    let mut powers = vec![0.0; sum.len()];
    for (degree, factor) in sum.iter().enumerate() {
        // From one power to the next: (k + i)(k − i + 1) / i² and the other sign.
        let mut term = if degree.is_multiple_of(2) { 1.0 } else { -1.0 };
        for (i, power) in powers.iter_mut().take(degree + 1).enumerate() {
            if i > 0 {
                let (k, i) = (degree as f64, i as f64);
                term *= -(k + i) * (k - i + 1.0) / (i * i);
            }
            *power += factor * term;
        }
    }
    powers
}

/// A phase between −π and π.
fn wrapped(phase: f64) -> f64 {
    phase - TAU * (phase / TAU).round()
}

/// Where a cell is: its radius over that of the disc, squared.
struct Disc {
    size: [usize; 2],
    pitch_mm: [f64; 2],
    radius_mm: f64,
}

impl Disc {
    /// r²/R² of all cells of a row.
    fn row(&self, y: usize) -> impl Iterator<Item = f64> {
        let ([nx, ny], [dx, dy]) = (self.size, self.pitch_mm);
        let at = |i: usize, count: usize, pitch: f64| {
            (i as f64 - 0.5 * (count.saturating_sub(1)) as f64) * pitch / self.radius_mm
        };
        let v = at(y, ny, dy);
        (0..nx).map(move |x| at(x, nx, dx).powi(2) + v * v)
    }
}

/// Whether a cell, of which r²/R² and the phase are known, is within the radius and open.
fn is_within((t, phase): &(f64, &f64)) -> bool {
    *t <= 1.0 && !phase.is_nan()
}

/// Fits the phase of cells.
///
/// # Errors
/// Cells without a phase, too few of them, or a phase that is not that of a radius.
pub(crate) fn fit_radial(cells: &mut Cells, choices: &ExportChoices) -> Result<RadialFit, Fault> {
    let relief = cells.relief;
    let as_phase = match cells.quantity {
        Quantity::Phase => 1.0,
        Quantity::Height if relief.depth_um().is_some() => relief.phase(1.0).unwrap_or_default(),
        other => {
            let found = format!("values of a {}", other.with_unit());
            let expected = "phases, or heights of a known relief (--index, --wavelength-um)";
            return Err(choice_fault(&cells.file, "quantity", found, expected));
        }
    };
    let ([nx, ny], [dx, dy]) = (cells.size(), cells.pitch_um);
    let pitch_mm = [dx * 1e-3, dy * 1e-3];
    let half = 0.5 * (nx as f64 * pitch_mm[0]).min(ny as f64 * pitch_mm[1]);
    let reach = cells.open.as_ref().and_then(OpenPart::reach);
    let disc = Disc {
        size: [nx, ny],
        pitch_mm,
        radius_mm: half.min(reach.unwrap_or(half)),
    };
    let file = cells.file.clone();
    let few = || {
        let found = format!("{} coefficients for {nx} x {ny} cells", choices.terms);
        choice_fault(
            &file,
            "terms",
            found,
            "fewer coefficients than rings of cells",
        )
    };
    let rings = (disc.radius_mm / pitch_mm[0].min(pitch_mm[1])).ceil() as usize;
    if rings <= choices.terms {
        return Err(few());
    }
    let start = rings_of(cells, &disc, (rings, as_phase))?;
    let mut sum = fit_rings(&start, choices.terms + 1).ok_or_else(few)?;

    // What is left of each cell is fitted again; the last time only measures it.
    let mut values = vec![0.0; sum.len()];
    for round in 0..=REFINEMENTS {
        let mut left = Normal::new(sum.len());
        cells.each_row(|y, phases| {
            for (t, phase) in disc.row(y).zip(phases).filter(is_within) {
                basis(t, &mut values);
                let fit: f64 = values.iter().zip(&sum).map(|(b, c)| b * c).sum();
                left.add(&values, wrapped(as_phase * phase - fit), 1.0);
            }
            Ok(())
        })?;
        let (rms, count) = (left.rms(), left.weight);
        if round == REFINEMENTS {
            return finished(cells, choices, (disc.radius_mm, &sum), (rms, count));
        }
        let more = left.solve().ok_or_else(|| {
            let found = "cells that do not decide on the coefficients";
            choice_fault(&cells.file, "terms", found, "fewer coefficients")
        })?;
        sum.iter_mut().zip(more).for_each(|(c, more)| *c += more);
    }
    Err(choice_fault(&cells.file, "terms", "no fit", "one"))
}

/// The fit, unless too much is left.
fn finished(
    cells: &Cells,
    choices: &ExportChoices,
    (radius_mm, sum): (f64, &[f64]),
    (residual, count): (f64, f64),
) -> Result<RadialFit, Fault> {
    if residual > choices.residual_rad {
        let found = format!("a phase that is off the fit by {residual:.3} rad (root mean square)");
        let expected = format!(
            "at most {} rad (--residual-rad): a phase of the radius alone, sampled finely, or more coefficients (--terms)",
            choices.residual_rad
        );
        return Err(Fault::of_file(&cells.file, found, expected));
    }
    let mut powers = powers(sum).into_iter();
    Ok(RadialFit {
        radius_mm,
        constant: powers.next().unwrap_or(0.0),
        coefficients: powers.collect(),
        residual,
        count: count as u64,
    })
}

/// Means over one ring.
#[derive(Clone, Copy, Default)]
struct Ring {
    cos: f64,
    sin: f64,
    t: f64,
    count: f64,
}

/// The mean of the cells of each ring, as a sum of vectors.
fn rings_of(
    cells: &mut Cells,
    disc: &Disc,
    (count, as_phase): (usize, f64),
) -> Result<Vec<Ring>, Fault> {
    let mut rings = vec![Ring::default(); count];
    cells.each_row(|y, phases| {
        for (t, phase) in disc.row(y).zip(phases).filter(is_within) {
            let number = ((t.sqrt() * count as f64) as usize).min(count - 1);
            if let Some(ring) = rings.get_mut(number) {
                let (sin, cos) = (as_phase * phase).sin_cos();
                ring.cos += cos;
                ring.sin += sin;
                ring.t += t;
                ring.count += 1.0;
            }
        }
        Ok(())
    })?;
    Ok(rings)
}

/// A fit of the rings, whose phases go on from one to the next as the slope before lets expect.
fn fit_rings(rings: &[Ring], count: usize) -> Option<Vec<f64>> {
    let mut equations = Normal::new(count);
    let mut values = vec![0.0; count];
    let mut last: Option<(f64, f64, f64)> = None;
    for ring in rings.iter().filter(|ring| ring.count > 0.0) {
        let (r, t) = ((ring.t / ring.count).sqrt(), ring.t / ring.count);
        let phase = ring.sin.atan2(ring.cos);
        let (phase, slope) = match last {
            None => (phase, 0.0),
            Some((before, at, slope)) => {
                // The slope of an even phase grows with the radius.
                let grown = if at > 0.0 { slope * r / at } else { slope };
                let expected = before + 0.5 * (slope + grown) * (r - at);
                let phase = expected + wrapped(phase - expected);
                (phase, (phase - before) / (r - at).max(1e-300))
            }
        };
        last = Some((phase, r, slope));
        basis(t, &mut values);
        equations.add(&values, phase, ring.count);
    }
    equations.solve()
}

impl RadialFit {
    /// The coefficients as a text, with the lines of a surface of a .zmx file.
    pub(crate) fn text(&self, name: &str) -> String {
        let mut text = format!(
            "# Phase of {name}: sum of A_i (r/R)^(2i) in rad, positive where the optical path is longer\n\
             # root mean square of what is left: {:.3e} rad over {} cells; constant left out: {:.6e} rad\n\
             R_mm {}\n",
            self.residual, self.count, self.constant, self.radius_mm
        );
        for (i, a) in (1..).zip(&self.coefficients) {
            text += &format!("A{i} {a:.12e}\n");
        }
        text += "\n# Lines of a surface of a .zmx file in mm (diffraction order 1):\n";
        text += "  TYPE BINARY_2\n  PARM 0 1\n";
        let mut extra = vec![self.coefficients.len() as f64, self.radius_mm];
        extra.extend(&self.coefficients);
        for (i, value) in (1..).zip(extra) {
            text += &format!(
                "  XDAT {i} {value:.12E} 0 0 1.000000000000E+00 0.000000000000E+00 0 \"\"\n"
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use ndarray::Array2;

    use crate::file::arrays::array::BorrowedArray;
    use crate::file::fabrication::cell_rows::{BorrowedRows, Cells, Part};
    use crate::file::fabrication::export_choices::{ExportChoices, Quantity};
    use crate::file::fabrication::radial_fit::{RadialFit, fit_radial};

    fn fitted(
        phase: &dyn Fn(f64, f64) -> f64,
        size: [usize; 2],
        terms: usize,
    ) -> Result<RadialFit, String> {
        let values = Array2::from_shape_fn((size[1], size[0]), |(y, x)| {
            let at = |i: usize, n: usize| (i as f64 - 0.5 * (n - 1) as f64) * 2e-3;
            phase(at(x, size[0]), at(y, size[1]))
        });
        let rows = BorrowedRows {
            array: BorrowedArray::Real(values.view()),
            part: Part::Phase,
            scale: 1.0,
        };
        let mut cells = Cells {
            quantity: Quantity::Phase,
            ..Cells::new(Box::new(rows), [2.0; 2], Path::new("a.npy"))
        };
        let choices = ExportChoices {
            terms,
            ..ExportChoices::default()
        };
        fit_radial(&mut cells, &choices).map_err(|fault| fault.to_string())
    }

    #[test]
    fn known_coefficients_are_found() {
        // A lens of 0.4 mm, f = 5 mm at 0.5 µm, with some spherical aberration; wrapped.
        let expected = [-50.0, 3.0, -1.0];
        let phase = |x: f64, y: f64| {
            let t = (x * x + y * y) / 0.04;
            (0.7 + expected[0] * t + expected[1] * t * t + expected[2] * t.powi(3)).rem_euclid(TAU)
        };
        for size in [[200, 200], [201, 260]] {
            let fit = fitted(&phase, size, 3).unwrap();
            let factor = fit.radius_mm / 0.2;
            for (i, (found, expected)) in fit.coefficients.iter().zip(expected).enumerate() {
                let expected = expected * factor.powi(2 * (i as i32 + 1));
                assert!((found - expected).abs() < 1e-8, "{found} {expected}");
            }
            assert!(
                fit.residual < 1e-9 && (fit.constant - 0.7).abs() < 1e-9,
                "{fit:?}"
            );
        }
        // More coefficients than the phase has: they vanish.
        let fit = fitted(&phase, [200, 200], 10).unwrap();
        assert!(
            fit.residual < 1e-8 && (fit.coefficients[0] + 50.0).abs() < 1e-3,
            "{fit:?}"
        );
    }

    #[test]
    fn levels_leave_their_rounding() {
        let step = TAU / 8.0;
        let phase = |x: f64, y: f64| {
            let t = (x * x + y * y) / 0.04;
            ((-40.0 * t / step).round() * step).rem_euclid(TAU)
        };
        let fit = fitted(&phase, [200, 200], 2).unwrap();
        let expected = step / 12.0_f64.sqrt();
        assert!(
            (fit.residual / expected - 1.0).abs() < 0.1,
            "{}",
            fit.residual
        );
        assert!((fit.coefficients[0] + 40.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn other_phases_are_refused() {
        let refusal = |phase: &dyn Fn(f64, f64) -> f64| fitted(phase, [64, 64], 4).unwrap_err();
        let tilted = refusal(&|x, _| 200.0 * x);
        assert!(
            tilted.contains("off the fit") && tilted.contains("--residual-rad"),
            "{tilted}"
        );
        let vortex = refusal(&|x, y| y.atan2(x));
        assert!(vortex.contains("off the fit"), "{vortex}");
        let few = fitted(&|_, _| 0.0, [8, 8], 8).unwrap_err();
        assert!(few.contains("terms"), "{few}");
    }
}
