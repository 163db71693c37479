//! A field as a beam file of Zemax (.zbf): zeros around it, the pilot beam, the report.

use std::f64::consts::PI;
use std::io::{self, Write};
use std::path::Path;

use ndarray::{Array1, ArrayView2, Axis};
use num_complex::Complex64;

use crate::file::arrays::npz::Fields;
use crate::file::beams::zbf_header::{BYTES, Header, Pilot};
use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_report::{ExportReport, short};

/// The fewest samples along an axis that OpticStudio takes; all its numbers of samples are powers of two.
const FEWEST: usize = 32;

/// How one channel of a field becomes a beam.
pub(crate) struct BeamPlan<'a> {
    field: ArrayView2<'a, Complex64>,
    header: Header,
    /// Samples of zeros before the field along x and y.
    before: [usize; 2],
    /// Where the sample in the middle of the beam lies on the axes of the field, in mm.
    middle_mm: [f64; 2],
}

impl<'a> BeamPlan<'a> {
    /// Plans the beam of channel `k` of fields.
    ///
    /// # Errors
    /// Axes of one sample or with unequal steps, or too many samples for a beam file.
    pub(crate) fn new(path: &Path, fields: &'a Fields, k: usize) -> Result<Self, Fault> {
        let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
        let x = BeamAxis::new("x_mm", &fields.x_mm).map_err(refuse)?;
        let y = BeamAxis::new("y_mm", &fields.y_mm).map_err(refuse)?;
        let wavelength_um = fields.wavelength_um.index_axis(Axis(0), k).into_scalar();
        let field = fields.field.index_axis(Axis(0), k);
        let wavelength_mm = wavelength_um * 1e-3;
        let waists = waists(field, [&fields.x_mm, &fields.y_mm], [x.step, y.step]);
        Ok(Self {
            field,
            header: Header {
                version: 1,
                size: [x.count, y.count],
                polarised: false,
                unit: "mm",
                step_mm: [x.step, y.step],
                pilot: waists.map(|waist| Pilot {
                    z: 0.0,
                    rayleigh: PI * waist * waist / wavelength_mm,
                    waist,
                }),
                wavelength_mm,
                index: 1.0,
                bytes: BYTES,
            },
            before: [x.before, y.before],
            middle_mm: [x.middle, y.middle],
        })
    }

    /// Writes the file, row by row.
    pub(crate) fn write(&self, mut out: impl Write) -> io::Result<()> {
        out.write_all(&self.header.to_bytes())?;
        let scale = self.header.scale();
        let [nx, ny] = self.header.size.map(|count| count as usize);
        let mut row = Vec::with_capacity(16 * nx);
        for y in 0..ny {
            row.clear();
            row.resize(16 * self.before[0], 0);
            let inside = y.checked_sub(self.before[1]);
            if let Some(y) = inside.filter(|y| *y < self.field.nrows()) {
                for u in self.field.row(y) {
                    let e = u.conj() * scale;
                    row.extend(e.re.to_le_bytes());
                    row.extend(e.im.to_le_bytes());
                }
            }
            row.resize(16 * nx, 0);
            out.write_all(&row)?;
        }
        out.flush()
    }

    /// Reports what the file holds.
    pub(crate) fn report(&self) -> ExportReport {
        let mut report = ExportReport::default();
        let Header { size, step_mm, .. } = &self.header;
        let (rows, columns) = self.field.dim();
        let [dx, dy] = step_mm.map(short);
        let around = match [size[0] as usize, size[1] as usize] == [columns, rows] {
            true => String::new(),
            false => format!(", zeros around the {columns} x {rows} of the field"),
        };
        report.line(
            "Beam",
            format!(
                "{} x {} samples of {dx} x {dy} mm{around}",
                size[0], size[1]
            ),
        );
        let wavelength_um = self.header.vacuum_um();
        report.line(
            "Wavelength",
            format!("{} µm, index 1", short(wavelength_um)),
        );
        let [x, y] = self.middle_mm.map(short);
        report.line(
            "Middle",
            format!(
                "sample {}, {} from 1; it is at x, y = {x}, {y} mm of the field",
                size[0] / 2 + 1,
                size[1] / 2 + 1
            ),
        );
        let power =
            self.field.iter().map(Complex64::norm_sqr).sum::<f64>() * step_mm[0] * step_mm[1];
        report.line(
            "Scale",
            format!(
                "Ex = amplitude · {} mm, so that |Ex|² is the power of a sample",
                short(self.header.scale())
            ),
        );
        report.line(
            "Power",
            format!("{} (mm² of raylet, the sum of |Ex|²)", short(power)),
        );
        report.line("Phase", "conjugated, as exp(−ikz); relative to a plane");
        self.report_pilot(&mut report);
        report.number("power", power);
        report.number("wavelength_um", wavelength_um);
        report.number("middle_x_mm", self.middle_mm[0]);
        report.number("middle_y_mm", self.middle_mm[1]);
        report.lost.push(String::from(
            "the place of the beam: OpticStudio takes its middle as the axis",
        ));
        report
    }

    /// Reports the pilot beam.
    fn report_pilot(&self, report: &mut ExportReport) {
        let pilot = self.header.pilot;
        report.line(
            "Pilot beam (x, y)",
            format!(
                "waist {} mm here, from the widths of the intensity; Rayleigh range {} mm",
                pilot.map(|p| short(p.waist)).join(", "),
                pilot.map(|p| short(p.rayleigh)).join(", ")
            ),
        );
    }
}

/// An axis of a field as that of a beam.
struct BeamAxis {
    step: f64,
    count: u32,
    before: usize,
    middle: f64,
}

impl BeamAxis {
    /// Puts the sample behind the middle of an axis, or in it, at that of the beam. Refusals are (found, expected).
    fn new(name: &str, axis: &Array1<f64>) -> Result<Self, (String, String)> {
        let (n, first, last) = match (axis.first(), axis.last()) {
            (Some(first), Some(last)) if axis.len() > 1 => (axis.len(), *first, *last),
            _ => {
                let found = format!("`{name}` of {} sample", axis.len());
                return Err((
                    found,
                    String::from("at least two: their distance is not known"),
                ));
            }
        };
        let step = (last - first) / (n - 1) as f64;
        let count = n.max(FEWEST).next_power_of_two();
        let too_many = |_| {
            (
                format!("`{name}` of {n} samples"),
                String::from("fewer than 2³⁰"),
            )
        };
        let count = i32::try_from(count).map_err(too_many)?;
        Ok(Self {
            step,
            count: count.cast_unsigned(),
            before: count.cast_unsigned() as usize / 2 - n / 2,
            middle: axis[n / 2],
        })
    }
}

/// The radii at which a Gaussian with the widths of the intensity falls to 1/e², along x and y; a step where it has none.
fn waists(field: ArrayView2<'_, Complex64>, axes: [&Array1<f64>; 2], steps: [f64; 2]) -> [f64; 2] {
    let mut sums = [[0.0; 3]; 2];
    for ((j, i), u) in field.indexed_iter() {
        let power = u.norm_sqr();
        for (sum, place) in sums.iter_mut().zip([axes[0][i], axes[1][j]]) {
            for (s, value) in sum.iter_mut().zip([1.0, place, place * place]) {
                *s += power * value;
            }
        }
    }
    let mut waists = steps;
    for (waist, [power, first, second]) in waists.iter_mut().zip(sums) {
        let variance = second / power - (first / power).powi(2);
        if variance.is_finite() && variance > 0.0 {
            *waist = waist.max(2.0 * variance.sqrt());
        }
    }
    waists
}
