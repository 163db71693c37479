//! A conformal diffractive mirror by several methods, against the direct integral over its surface.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::reference::{ReferenceError, ReferenceOptions, reference};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::{Method, Paper, Positions, Sag, Settings};
use raylet::math::part::part;
use raylet::optics::system::System;
use raylet::wave::grid::field::{Axis, Field, Grid};
use raylet::wave::grid::metrics::{field_error, fwhm, ncc, peak, shape_error};

use crate::mirrors::conformal_mirror::{Conformal, Show, Window};

/// Samples along each axis of a window about a focus, and their distance in mm.
const FOCUS: (usize, f64) = (41, 1e-4);

/// Samples along each axis of the window of the letter, and their distance at full size in mm.
const LETTER: (usize, f64) = (63, 2.6e-3);

/// Side of a patch in mm at full size, and its period over its side: 201 of 401 pixels.
const SIDE: f64 = 0.1005;
const PADDING: f64 = 401.0 / 201.0;

/// How often the paper's method draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Incident rays.
    pub rays: usize,
    /// Secondary rays of each.
    pub secondary: usize,
}

/// A method to carry the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropagationMethod {
    /// The direct integral.
    Exact,
    /// As by default.
    Default,
    /// The paper's method.
    Paper(Sag, Draws),
}

impl PropagationMethod {
    /// Its name.
    pub fn name(self) -> String {
        let (sag, draws) = match self {
            PropagationMethod::Exact => return String::from("direct integral over the surface"),
            PropagationMethod::Default => return String::from("default"),
            PropagationMethod::Paper(sag, draws) => (sag, draws),
        };
        let on = match sag {
            Sag::Tangent => "tangent planes",
            Sag::Incident => "incident light on the surface",
            Sag::True => "with the height",
        };
        format!("paper, {on}, {} × {}", draws.rays, draws.secondary)
    }
}

/// What one method gave.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The method.
    pub method: PropagationMethod,
    /// Field error and error of its shape against the direct integral.
    pub errors: [f64; 2],
    /// Normalised correlation of the intensity with that of the direct integral.
    pub like: f64,
    /// Distance of the two foci and their mean full widths at half maximum along x and y, in mm.
    pub foci: Option<[f64; 3]>,
    /// Normalised correlation with the letter.
    pub letter: Option<f64>,
    /// Rays followed, or pairs of the direct integral.
    pub work: f64,
    /// Seconds it took.
    pub seconds: f64,
    /// The fields in the windows.
    pub fields: Vec<Field>,
}

/// A mirror, by all methods.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The mirror.
    pub mirror: Conformal,
    /// The direct integral first.
    pub outcomes: Vec<Outcome>,
}

/// The windows of the sensor that are looked at, and one that holds them at its ends.
fn windows(mirror: &Conformal) -> (Vec<Window>, Window) {
    match mirror.show {
        Show::Foci => {
            let (pixels, pitch) = FOCUS;
            let [left, right] = mirror.foci();
            let window = |x: f64| Window {
                x,
                pixels: [pixels; 2],
                pitch,
            };
            let strip = Window {
                pixels: [((right - left) / pitch).round() as usize + pixels, pixels],
                ..window(0.0)
            };
            (vec![window(left), window(right)], strip)
        }
        Show::Letter => {
            let window = Window {
                x: 0.0,
                pixels: [LETTER.0; 2],
                pitch: LETTER.1 * mirror.scale,
            };
            (vec![window], window)
        }
    }
}

/// The fields at both ends of a strip as those of windows; all of it where it is one window.
fn ends(strip: Field, windows: &[Window]) -> Vec<Field> {
    let (count, pitch) = (windows[0].pixels[0], windows[0].pitch);
    if windows.len() == 1 {
        return vec![strip];
    }
    let last = strip.values.ncols() - count;
    let window = |first: usize| Field {
        grid: Grid {
            x: Axis::uniform(count, pitch, 0.0),
            y: strip.grid.y.clone(),
        },
        values: part(strip.values.view(), .., first..first + count).to_owned(),
    };
    vec![window(0), window(last)]
}

/// The settings of a method.
fn settings(mirror: &Conformal, method: PropagationMethod) -> Settings {
    let PropagationMethod::Paper(sag, draws) = method else {
        return Settings::default();
    };
    Settings {
        method: Method::Paper,
        paper: Paper {
            rays: draws.rays,
            secondary: draws.secondary,
            patch: Some(SIDE * mirror.scale),
            padding: PADDING,
            positions: Positions::Dilated,
            coverage: true,
            sag,
            ..Paper::default()
        },
        ..Settings::default()
    }
}

/// The fields in the windows, and the work they took.
fn carry(
    mirror: &Conformal,
    method: PropagationMethod,
) -> Result<(Vec<Field>, f64), ReferenceError> {
    let settings = settings(mirror, method);
    let (windows, strip) = windows(mirror);
    if method != PropagationMethod::Exact {
        let outcome = simulate(&mirror.system(strip), &settings, &|_| {})?;
        let rays = outcome.hops.iter().map(|hop| hop.tally.total_rays());
        let rays = rays.sum::<u64>() as f64;
        return Ok((ends(outcome.field, &windows), rays));
    }

    // Point by point: only where it is looked at.
    let choice = ReferenceOptions {
        approach: Approach::RayleighSommerfeld,
        ..ReferenceOptions::default()
    };
    let (mut fields, mut pairs) = (Vec::new(), 0.0);
    for window in windows {
        let exact = reference(&mirror.system(window), &settings, choice, &|_| {})?;
        pairs += exact.steps.iter().map(|step| step.work).sum::<f64>();
        fields.push(exact.field);
    }
    Ok((fields, pairs))
}

/// Peak of a window along x and y in the window's own coordinates, by a parabola through the largest sample
/// and its neighbours, and the widths through it.
fn spot_metrics(field: &Field) -> Option<[f64; 4]> {
    let bright = field.intensity();
    let [x, y] = [&field.grid.x, &field.grid.y].map(|axis| axis.nodes());
    let [j, i] = peak(bright.view())?.at;
    if j == 0 || i == 0 || j + 1 == y.len() || i + 1 == x.len() {
        return None;
    }
    let top = |a: f64, b: f64, c: f64| 0.5 * (a - c) / (a - 2.0 * b + c);
    let along_x = top(bright[[j, i - 1]], bright[[j, i]], bright[[j, i + 1]]);
    let along_y = top(bright[[j - 1, i]], bright[[j, i]], bright[[j + 1, i]]);
    let [width_x, width_y] = fwhm(bright.view(), &x, &y);
    let at = |axis: &Axis, n: usize, shift: f64| axis.node(n) + shift * axis.pitch;
    Some([
        at(&field.grid.x, i, along_x),
        at(&field.grid.y, j, along_y),
        width_x?,
        width_y?,
    ])
}

/// Distance of the foci, and their mean full widths at half maximum along x and y, in mm, from the fields in windows
/// about them.
pub fn foci(mirror: &Conformal, fields: &[Field]) -> Option<[f64; 3]> {
    let [left, right] = [fields.first()?, fields.get(1)?].map(spot_metrics);
    let (left, right) = (left?, right?);
    let [a, b] = mirror.foci();
    let apart = [b + right[0] - a - left[0], right[1] - left[1]];
    Some([
        apart[0].hypot(apart[1]),
        0.5 * (left[2] + right[2]),
        0.5 * (left[3] + right[3]),
    ])
}

/// The letter on the samples of a field.
pub fn letter(mirror: &Conformal, field: &Field) -> Array2<f64> {
    let [x, y] = [&field.grid.x, &field.grid.y];
    Array2::from_shape_fn((y.len(), x.len()), |(j, i)| {
        match mirror.letter(x.node(i), y.node(j)) {
            true => 1.0,
            false => 0.0,
        }
    })
}

/// All samples of several fields in one row.
fn joined(fields: &[Field]) -> Array2<Complex64> {
    let values: Vec<Complex64> = fields
        .iter()
        .flat_map(|field| field.values.iter().copied())
        .collect();
    let count = values.len();
    Array2::from_shape_vec((1, count), values).unwrap_or_default()
}

impl Comparison {
    /// Carries the light by every method, the direct integral first.
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn measure(
        mirror: Conformal,
        methods: &[PropagationMethod],
    ) -> Result<Self, ReferenceError> {
        let mut outcomes: Vec<Outcome> = Vec::new();
        for &method in [PropagationMethod::Exact].iter().chain(methods) {
            let clock = Instant::now();
            let (fields, work) = carry(&mirror, method)?;
            let ours = joined(&fields);
            let exact = outcomes
                .first()
                .map_or_else(|| ours.clone(), |exact| joined(&exact.fields));
            let bright = |u: &Array2<Complex64>| u.mapv(|u| u.norm_sqr());
            let shape = shape_error(ours.view(), exact.view()).map(|shape| shape.error);
            let error = field_error(ours.view(), exact.view());
            let like = ncc(bright(&ours).view(), bright(&exact).view());
            outcomes.push(Outcome {
                method,
                errors: [error, shape].map(|error| error.unwrap_or(f64::NAN)),
                like: like.unwrap_or(f64::NAN),
                foci: foci(&mirror, &fields),
                letter: (mirror.show == Show::Letter)
                    .then(|| {
                        ncc(
                            fields[0].intensity().view(),
                            letter(&mirror, &fields[0]).view(),
                        )
                    })
                    .flatten(),
                work,
                seconds: clock.elapsed().as_secs_f64(),
                fields,
            });
        }
        Ok(Self { mirror, outcomes })
    }

    /// The mirror, and a sensor that holds what was looked at.
    pub fn system(&self) -> System {
        self.mirror.system(windows(&self.mirror).1)
    }

    /// The field of a wide window by default, for a picture.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn overview(mirror: &Conformal, pixels: usize) -> Result<Field, SimulateError> {
        let system = mirror.system(Window {
            x: 0.0,
            pixels: [pixels; 2],
            pitch: mirror.width() / pixels as f64,
        });
        Ok(simulate(&system, &Settings::default(), &|_| {})?.field)
    }
}

#[cfg(test)]
mod tests {
    use raylet::engine::plan::settings::Sag;

    use crate::mirrors::conformal_methods::{Comparison, Draws, PropagationMethod};
    use crate::mirrors::conformal_mirror::{Conformal, Show, Substrate};

    /// A tenth of the mirror: foci where they should be, whatever the substrate, by every method but planes.
    #[test]
    fn foci_stand_where_the_phase_sends_them_slow() {
        for substrate in [Substrate::Bumps, Substrate::Bump] {
            let mirror = Conformal {
                substrate,
                show: Show::Foci,
                scale: 0.1,
            };
            let draws = Draws {
                rays: 40,
                secondary: 1000,
            };
            let methods = [
                PropagationMethod::Default,
                PropagationMethod::Paper(Sag::True, draws),
            ];
            let found = Comparison::measure(mirror, &methods).unwrap();
            let [exact, ours] = [&found.outcomes[0], &found.outcomes[1]];
            assert!(ours.errors[0] < 2e-3, "{:?}", ours.errors);
            let [apart, wide, _] = exact.foci.unwrap();
            assert!((apart - 0.01).abs() < 1e-4, "{apart}");
            assert!((0.8e-3..1.5e-3).contains(&wide), "{wide}");
        }
    }
}
