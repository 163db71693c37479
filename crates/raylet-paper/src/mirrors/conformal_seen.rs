//! What a mirror with given pixels shows, by the direct integral over its true surface.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use ndarray::{Array2, ArrayView1};
use num_complex::Complex64;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::chain::reference::{ReferenceError, ReferenceOptions, reference};
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::Settings;
use raylet::wave::grid::field::Field;
use raylet::wave::grid::metrics::{ncc, peak};

use crate::mirrors::conformal_methods::{foci, letter};
use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show, Window};

/// Samples along each axis of a window about a focus, and their distance in mm.
const FOCUS: (usize, f64) = (41, 1e-4);

/// Samples along each axis of the whole sensor; an even number, so that they lie between those of a design.
const LETTER: usize = 100;

/// What was found.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The fields about the foci, or on the whole sensor.
    pub fields: Vec<Field>,
    /// Where the middle of each of them is on the x axis, in mm.
    pub middles: Vec<f64>,
    /// Distance of the two foci and their mean full widths at half maximum along x and y, in mm.
    pub foci: Option<[f64; 3]>,
    /// The brightest side lobe on lines through a focus along x and y, over its peak; the mean of both foci.
    pub lobe: Option<f64>,
    /// Normalised correlation with the letter.
    pub letter: Option<f64>,
    /// Share of the light behind the mirror that falls into the windows, or into the letter.
    pub light: f64,
    /// Pairs of nodes and points that were summed.
    pub pairs: f64,
}

impl Seen {
    /// The light of a mirror whose pixels reflect these values, [y, x].
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn directly(
        mirror: &Conformal,
        values: &Array2<Complex64>,
        aperture: LitArea,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Self, ReferenceError> {
        let choice = ReferenceOptions {
            approach: Approach::RayleighSommerfeld,
            ..ReferenceOptions::default()
        };
        let (mut fields, mut pairs, mut inside) = (Vec::new(), 0.0, 0.0);
        let windows = windows(mirror);
        for window in &windows {
            let system = mirror.made(values.clone(), aperture, *window);
            let exact = reference(&system, &Settings::default(), choice, progress)?;
            let sent = exact.steps.first().and_then(|step| step.power[1]);
            let bright = exact.field.intensity();
            let lit = match mirror.show {
                Show::Foci => bright.sum(),
                Show::Letter => (&bright * &letter(mirror, &exact.field)).sum(),
            };
            inside += lit * window.pitch * window.pitch / sent.unwrap_or(f64::NAN);
            pairs += exact.steps.iter().map(|step| step.work).sum::<f64>();
            fields.push(exact.field);
        }
        let shown = |show: Show| mirror.show == show;
        let like = |field: &Field| ncc(field.intensity().view(), letter(mirror, field).view());
        Ok(Self {
            foci: shown(Show::Foci).then(|| foci(mirror, &fields)).flatten(),
            lobe: shown(Show::Foci).then(|| lobe(&fields)).flatten(),
            letter: shown(Show::Letter).then(|| like(&fields[0])).flatten(),
            light: inside,
            pairs,
            middles: windows.iter().map(|window| window.x).collect(),
            fields,
        })
    }
}

/// Where the sensor is looked at.
fn windows(mirror: &Conformal) -> Vec<Window> {
    let window = |x: f64, count: usize, pitch: f64| Window {
        x,
        pixels: [count; 2],
        pitch,
    };
    match mirror.show {
        Show::Foci => mirror.foci().map(|x| window(x, FOCUS.0, FOCUS.1)).to_vec(),
        Show::Letter => vec![window(0.0, LETTER, mirror.width() / LETTER as f64)],
    }
}

/// The brightest side lobe over the peak; the mean of all fields.
fn lobe(fields: &[Field]) -> Option<f64> {
    let mut sum = 0.0;
    for field in fields {
        let bright = field.intensity();
        let [j, i] = peak(bright.view())?.at;
        let along = beside(bright.row(j), i).max(beside(bright.column(i), j));
        sum += along / bright[[j, i]];
    }
    Some(sum / fields.len() as f64)
}

/// The largest value of a line beyond the first minima on either side of a peak.
fn beside(line: ArrayView1<f64>, peak: usize) -> f64 {
    let side_lobe = |values: Vec<f64>| {
        let fall = values.windows(2).position(|pair| pair[1] > pair[0]);
        let rest = values.iter().skip(fall.unwrap_or(values.len()));
        rest.fold(0.0f64, |most, value| most.max(*value))
    };
    let right = side_lobe(line.iter().skip(peak).copied().collect());
    right.max(side_lobe(
        line.iter().take(peak + 1).rev().copied().collect(),
    ))
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use crate::mirrors::conformal_seen::beside;

    #[test]
    fn side_lobes_are_beyond_the_first_minima() {
        let line = array![0.3, 0.1, 0.6, 1.0, 0.7, 0.2, 0.1, 0.4, 0.2];
        assert_eq!(beside(line.view(), 3), 0.4);
        assert_eq!(beside(array![0.1, 0.5, 1.0, 0.2].view(), 2), 0.0);
    }
}
