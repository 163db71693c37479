//! How alike the fields of two runs are, channel by channel and in total.

use std::path::{Path, PathBuf};

use ndarray::{Array2, ArrayView, ArrayView2, Axis, Dimension};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::zbf_fields::BeamChoices;
use crate::file::decode::fault::Fault;
use crate::file::result::field_source::FieldSource;
use crate::file::result::light_metrics::Metrics;
use crate::wave::grid::metrics::{field_error, ncc, shape_error, unit_sum_mse};

/// Version of the document that a comparison writes.
pub(crate) const VERSION: u32 = 1;

/// How far positions in mm and wavelengths in µm of one grid may lie apart.
const TOLERANCE: f64 = 1e-9;

/// The fields of a run and where they were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The file.
    pub path: PathBuf,
    /// The fields on the sensor, one for each wavelength.
    pub fields: Fields,
    /// What of the file is not in the fields, as sentences; beam files hold more than a field.
    pub left_out: Vec<String>,
}

/// The likeness of two runs, A and B.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The version of this document.
    pub version: u32,
    /// The file of A.
    pub a: PathBuf,
    /// The file of B, the reference.
    pub b: PathBuf,
    /// Each wavelength.
    pub channels: Vec<ChannelLikeness>,
    /// All wavelengths: intensities added, fields side by side with one factor for all.
    pub total: Likeness,
}

/// How alike two runs are at one wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelLikeness {
    /// Vacuum wavelength in micrometres.
    pub wavelength_um: f64,
    /// The numbers.
    #[serde(flatten)]
    pub likeness: Likeness,
}

/// How alike a field A is to a reference B; absent numbers do not exist, as of dark fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Likeness {
    /// Normalised cross-correlation of the intensities, means not removed.
    pub ncc: Option<f64>,
    /// Mean square difference of the intensities after division by their sums.
    pub unit_sum_mse: Option<f64>,
    /// ‖A − B‖ / ‖B‖ of the complex fields.
    pub field_error: Option<f64>,
    /// ‖A − c·B‖ / ‖A‖ with the best complex factor c.
    pub shape_error: Option<f64>,
    /// The factor c of `shape_error`.
    pub factor: Option<Factor>,
    /// The spot of A.
    pub a: Metrics,
    /// The spot of B.
    pub b: Metrics,
}

/// A complex factor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// |c|.
    pub modulus: f64,
    /// arg c in radians.
    pub phase_rad: f64,
}

impl Side {
    /// Reads a field.npz, the one in a folder of results, or a beam file (.zbf), of which Ex is taken.
    ///
    /// # Errors
    /// A file that cannot be used, arrays beyond the limit, or positions with unequal steps.
    pub fn read(path: &Path, limit: MemoryLimit) -> Result<Self, Fault> {
        let source = FieldSource::read(path, BeamChoices::default(), limit)?;
        Ok(Self {
            path: source.path,
            fields: source.fields,
            left_out: source.report.lost,
        })
    }

    /// The area of a sample in mm²; an axis of one sample counts as 1 mm.
    fn area(&self) -> f64 {
        [&self.fields.x_mm, &self.fields.y_mm]
            .map(|axis| {
                if axis.len() < 2 {
                    1.0
                } else {
                    axis[1] - axis[0]
                }
            })
            .iter()
            .product()
    }

    /// The spot of an intensity on this grid.
    fn metrics(&self, intensity: ArrayView2<'_, f64>) -> Metrics {
        let (x, y) = (self.fields.x_mm.to_vec(), self.fields.y_mm.to_vec());
        Metrics::of_light(intensity, [&x, &y], intensity.sum() * self.area())
    }
}

impl Comparison {
    /// Compares A with the reference B.
    ///
    /// # Errors
    /// Grids or wavelengths that differ.
    pub fn of(a: &Side, b: &Side) -> Result<Self, Fault> {
        check_grids(a, b)?;
        let sides = [a, b];
        let channel = |(k, wavelength): (usize, &f64)| {
            let fields = sides.map(|side| side.fields.field.index_axis(Axis(0), k));
            let light = fields.map(|field| field.mapv(|u| u.norm_sqr()));
            ChannelLikeness {
                wavelength_um: *wavelength,
                likeness: Likeness::of(sides, fields, &light),
            }
        };
        let channels = a.fields.wavelength_um.iter().enumerate().map(channel);
        let sums = sides.map(|side| side.fields.total_intensity());
        Ok(Self {
            version: VERSION,
            a: a.path.clone(),
            b: b.path.clone(),
            channels: channels.collect(),
            total: Likeness::of(sides, sides.map(|side| side.fields.field.view()), &sums),
        })
    }
}

impl Likeness {
    fn of<D: Dimension + Copy>(
        sides: [&Side; 2],
        [a, b]: [ArrayView<'_, Complex64, D>; 2],
        light: &[Array2<f64>; 2],
    ) -> Self {
        let [light_a, light_b] = light.each_ref().map(|array| array.view());
        let shape = shape_error(a, b);
        Self {
            ncc: ncc(light_a, light_b),
            unit_sum_mse: unit_sum_mse(light_a, light_b),
            field_error: field_error(a, b),
            shape_error: shape.map(|shape| shape.error),
            factor: shape.map(|shape| Factor {
                modulus: shape.factor.norm(),
                phase_rad: shape.factor.arg(),
            }),
            a: sides[0].metrics(light_a),
            b: sides[1].metrics(light_b),
        }
    }
}

/// Refuses fields on different grids; the fault names B and what A has.
fn check_grids(a: &Side, b: &Side) -> Result<(), Fault> {
    let of = |side: &Side| {
        let (channels, ny, nx) = side.fields.field.dim();
        format!("{channels} wavelengths of {ny} × {nx} samples")
    };
    let as_in = |what: String| format!("{what} as in {}", a.path.display());
    if a.fields.field.dim() != b.fields.field.dim() {
        return Err(Fault::of_file(&b.path, of(b), as_in(of(a))));
    }
    let axes = |fields: &Fields| {
        let Fields {
            x_mm,
            y_mm,
            wavelength_um,
            ..
        } = fields;
        [
            ("x_mm", x_mm),
            ("y_mm", y_mm),
            ("wavelength_um", wavelength_um),
        ]
        .map(|(n, v)| (n, v.clone()))
    };
    for ((name, ours), (_, theirs)) in axes(&a.fields).iter().zip(&axes(&b.fields)) {
        let apart = |(p, q): &(&f64, &f64)| (*p - *q).abs() > TOLERANCE;
        if let Some((k, (p, q))) = ours
            .iter()
            .zip(theirs)
            .enumerate()
            .find(|(_, pair)| apart(pair))
        {
            return Err(Fault::of_file(
                &b.path,
                format!("{name}[{k}] = {q}"),
                as_in(p.to_string()),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use ndarray::{Array1, Array3};
    use num_complex::Complex64;

    use crate::file::arrays::npz::Fields;
    use crate::file::result::comparison::{Comparison, Side};

    /// Two channels of a Gaussian spot of waist 0.1 mm, the second moved and brighter.
    fn side(factor: Complex64) -> Side {
        let axis = Array1::linspace(-0.5, 0.5, 51);
        let spot = |(c, j, i): (usize, usize, usize)| {
            let (x, y) = (axis[i] - 0.1 * c as f64, axis[j]);
            factor * (1.0 + c as f64) * (-(x * x + y * y) / 0.01).exp()
        };
        Side {
            path: PathBuf::from("field.npz"),
            fields: Fields {
                field: Array3::from_shape_fn((2, 51, 51), spot),
                wavelength_um: Array1::from(vec![0.5, 0.6]),
                x_mm: axis.clone(),
                y_mm: axis,
            },
            left_out: Vec::new(),
        }
    }

    #[test]
    fn a_factor_is_all_that_differs() {
        let factor = Complex64::from_polar(0.5, 1.0);
        let found = Comparison::of(&side(factor), &side(Complex64::ONE)).unwrap();
        let of_channels = found.channels.iter().map(|c| &c.likeness);
        for likeness in of_channels.chain([&found.total]) {
            assert!((likeness.ncc.unwrap() - 1.0).abs() < 1e-14);
            assert!(likeness.unit_sum_mse.unwrap() < 1e-30);
            assert!((likeness.field_error.unwrap() - (factor - 1.0).norm()).abs() < 1e-14);
            assert!(likeness.shape_error.unwrap() < 1e-14);
            assert!((likeness.factor.unwrap().modulus - 0.5).abs() < 1e-14);
            assert!((likeness.factor.unwrap().phase_rad - 1.0).abs() < 1e-14);
            assert!((likeness.b.power / likeness.a.power - 4.0).abs() < 1e-12);
        }

        // The powers π w²/2 times 1 and 4; the sum's centre follows the brighter channel.
        let power = 0.5 * std::f64::consts::PI * 0.01;
        assert!((found.channels[0].likeness.b.power - power).abs() < 1e-12);
        assert!((found.total.b.power - 5.0 * power).abs() < 1e-9);
        let [x, y] = found.total.b.centroid_mm.unwrap();
        assert!((x - 0.08).abs() < 1e-9 && y.abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn other_grids_are_refused() {
        let refusal = |change: fn(&mut Fields)| {
            let mut other = side(Complex64::ONE);
            change(&mut other.fields);
            Comparison::of(&side(Complex64::ONE), &other)
                .unwrap_err()
                .to_string()
        };
        let size = refusal(|fields| fields.field = Array3::zeros((2, 51, 50)));
        assert!(
            size.contains("51 × 50") && size.contains("51 × 51"),
            "{size}"
        );
        let place = refusal(|fields| fields.y_mm[3] += 2e-9);
        assert!(
            place.contains("y_mm[3]") && place.contains("-0.44"),
            "{place}"
        );
        let wavelength = refusal(|fields| fields.wavelength_um[1] = 0.7);
        assert!(
            wavelength.contains("0.7") && wavelength.contains("0.6"),
            "{wavelength}"
        );
    }

    #[test]
    fn dark_fields_have_no_numbers() {
        let dark = side(Complex64::ZERO);
        let found = Comparison::of(&dark, &dark).unwrap();
        assert_eq!(found.total.ncc, None);
        assert_eq!(found.total.factor, None);
        assert!(
            serde_json::to_string(&found)
                .unwrap()
                .contains("\"field_error\":null")
        );
    }
}
