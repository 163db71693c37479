//! The picture of a comparison: the light of A and B, and what differs.

#![expect(
    clippy::indexing_slicing,
    reason = "wavelengths are counted by both sides, which were found to have the same"
)]

use ndarray::{Array2, Axis, Zip};
use raylet::file::arrays::npz::Fields;
use raylet::file::result::comparison::Side;

use crate::colour::ColourMap;
use crate::figure::{Figure, Panel};
use crate::panel::FigureError;
use crate::sensor_panels::{MOST_CHANNELS, edges};

/// Decades of the logarithmic rows.
const DECADES: i32 = 5;

/// Device pixels per pixel of the figure.
const SCALE: f64 = 1.5;

/// What a pair of rows shows, each [y, x].
struct Pair {
    a: Array2<f64>,
    b: Array2<f64>,
    /// |U_A − U_B|².
    residual: Array2<f64>,
    /// |U_A|² − |U_B|².
    difference: Array2<f64>,
    note: String,
}

impl Pair {
    /// The channels of a range, intensities added.
    fn of(a: &Fields, b: &Fields, channels: std::ops::Range<usize>, note: String) -> Self {
        let mut pair = Self {
            a: Array2::zeros((a.y_mm.len(), a.x_mm.len())),
            b: Array2::zeros((a.y_mm.len(), a.x_mm.len())),
            residual: Array2::zeros((a.y_mm.len(), a.x_mm.len())),
            difference: Array2::zeros((0, 0)),
            note,
        };
        for k in channels {
            let [u, v] = [a, b].map(|fields| fields.field.index_axis(Axis(0), k));
            Zip::from(&mut pair.a)
                .and(u)
                .for_each(|sum, u| *sum += u.norm_sqr());
            Zip::from(&mut pair.b)
                .and(v)
                .for_each(|sum, v| *sum += v.norm_sqr());
            let add =
                |sum: &mut f64, u: &_, v: &_| *sum += num_complex::Complex64::norm_sqr(&(u - v));
            Zip::from(&mut pair.residual).and(u).and(v).for_each(add);
        }
        pair.difference = &pair.a - &pair.b;
        pair
    }

    /// Intensities and their difference, then logarithms; all intensities on one scale.
    fn rows(&self, [xs, ys]: [[f64; 2]; 2]) -> [Vec<Panel<'_>>; 2] {
        let most = self
            .a
            .iter()
            .chain(&self.b)
            .fold(0.0, |most: f64, v| most.max(*v));
        let most = if most > 0.0 { most } else { 1.0 };
        let difference = Panel::image(&self.difference, xs, ys)
            .title("Intensity A − B")
            .colours(ColourMap::Difference)
            .quantity("|A|² − |B|²", "");
        let linear = |values| {
            Panel::image(values, xs, ys)
                .note(self.note.clone())
                .range([0.0, most])
        };
        let logarithmic = |values| {
            let range = [most * 10f64.powi(-DECADES), most];
            linear(values).log().range(range)
        };
        [
            vec![
                linear(&self.a)
                    .title("Intensity A")
                    .quantity("|A|²", "")
                    .into(),
                linear(&self.b)
                    .title("Intensity B")
                    .quantity("|B|²", "")
                    .into(),
                difference.note(self.note.clone()).into(),
            ],
            vec![
                logarithmic(&self.a)
                    .title("Intensity A, logarithmic")
                    .quantity("|A|²", "")
                    .into(),
                logarithmic(&self.b)
                    .title("Intensity B, logarithmic")
                    .quantity("|B|²", "")
                    .into(),
                logarithmic(&self.residual)
                    .title("Field error, logarithmic")
                    .quantity("|A − B|²", "")
                    .into(),
            ],
        ]
    }
}

/// The comparison of two fields on one grid as PNG: two rows for each of up to three wavelengths; for more,
/// those of the sum.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn contrast_png(a: &Side, b: &Side, title: &str) -> Result<Vec<u8>, FigureError> {
    let (a, b) = (&a.fields, &b.fields);
    let ranges = [edges(&a.x_mm.to_vec()), edges(&a.y_mm.to_vec())];
    let count = a.wavelength_um.len();
    let pairs: Vec<Pair> = match count <= MOST_CHANNELS {
        true => (0..count)
            .map(|k| Pair::of(a, b, k..k + 1, format!("λ = {} µm", a.wavelength_um[k])))
            .collect(),
        false => vec![Pair::of(
            a,
            b,
            0..count,
            format!("sum of {count} wavelengths"),
        )],
    };
    let rows = pairs.iter().flat_map(|pair| pair.rows(ranges)).collect();
    Figure::new(rows, title).width(1500.0).to_png(SCALE)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use ndarray::{Array1, Array3};
    use num_complex::Complex64;
    use raylet::file::arrays::npz::Fields;
    use raylet::file::result::comparison::Side;

    use crate::colour::{ColourMap, ColourScale};
    use crate::contrast::{Pair, contrast_png};
    use crate::decoded_png::DecodedPng;

    fn side(channels: usize, value: Complex64) -> Side {
        Side {
            path: PathBuf::from("field.npz"),
            fields: Fields {
                field: Array3::from_elem((channels, 4, 5), value),
                x_mm: Array1::linspace(-0.2, 0.2, 5),
                y_mm: Array1::linspace(-0.15, 0.15, 4),
                wavelength_um: Array1::linspace(0.5, 0.6, channels),
            },
            left_out: Vec::new(),
        }
    }

    #[test]
    fn sums_and_residuals() {
        let [a, b] = [Complex64::new(1.0, 2.0), Complex64::new(3.0, 1.0)].map(|u| side(4, u));
        let pair = Pair::of(&a.fields, &b.fields, 0..4, String::new());
        assert_eq!(pair.a[[3, 4]], 20.0);
        assert_eq!(pair.b[[0, 0]], 40.0);
        assert_eq!(pair.residual[[1, 2]], 20.0);
    }

    /// The colour of a value.
    fn colour(scale: ColourScale, value: f64) -> Option<[u8; 3]> {
        scale.colours([value].iter(), 1.0).try_into().ok()
    }

    /// What two rows of panels show for intensities that are the same everywhere: A, B and their difference, and the
    /// logarithms of A, B and the residual.
    fn expected([a, b, residual]: [f64; 3]) -> [[Option<[u8; 3]>; 3]; 2] {
        let most = if a.max(b) > 0.0 { a.max(b) } else { 1.0 };
        let map = ColourMap::Inferno;
        let linear = |value| {
            let (range, log) = ([0.0, most], false);
            colour(ColourScale { map, range, log }, value)
        };
        let logarithm = |value| {
            let (range, log) = ([1e-5 * most, most], true);
            colour(ColourScale { map, range, log }, value)
        };
        let difference = ColourScale::fitted(ColourMap::Difference, a - b, a - b);
        [
            [linear(a), linear(b), colour(difference, a - b)],
            [logarithm(a), logarithm(b), logarithm(residual)],
        ]
    }

    /// Two rows for each of one and two wavelengths, and for the sum of five; each panel is filled with the colour of
    /// its value.
    #[test]
    fn every_kind_of_field_has_a_picture() {
        let (lit, dim, dark) = (Complex64::new(0.0, 2.0), Complex64::ONE, Complex64::ZERO);
        for (channels, [a, b], values) in [
            (1, [lit, lit], [4.0, 4.0, 0.0]),
            (1, [lit, dim], [4.0, 1.0, 5.0]),
            (5, [lit, dark], [20.0, 0.0, 20.0]),
            (2, [dark, dark], [0.0; 3]),
        ] {
            let png = contrast_png(&side(channels, a), &side(channels, b), "A and B");
            let picture = DecodedPng::of(&png.unwrap());
            let (w, h) = (picture.width, picture.height);
            assert_eq!(w, 2250);
            let rows = if channels == 2 { 4 } else { 2 };
            for row in 0..rows {
                let part = |column: usize| {
                    let across = column * w / 3..(column + 1) * w / 3;
                    picture.commonest(across, row * h / rows..(row + 1) * h / rows)
                };
                let found = [0, 1, 2].map(part);
                assert_eq!(found, expected(values)[row % 2], "{values:?}, row {row}");
            }
        }
    }
}
