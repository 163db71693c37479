//! Which samples are missing, and the nearest others in their place.

use ndarray::Array2;

/// What stands in the place of missing samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fill {
    /// This value.
    Value(f64),
    /// That of the nearest sample that is there, in steps of the grid.
    Nearest,
}

/// How many samples are missing, and the first of them in words; none where all are there.
pub(crate) fn missing(values: &Array2<f64>) -> Option<String> {
    let mut lost = values.indexed_iter().filter(|(_, value)| value.is_nan());
    let ((y, x), _) = lost.next()?;
    let count = 1 + lost.count();
    Some(format!(
        "{count} missing samples of {}, the first at [{y}, {x}]",
        values.len()
    ))
}

/// Fills the missing samples. A map without any other sample stays as it is.
pub(crate) fn fill(values: &mut Array2<f64>, with: Fill) {
    match with {
        Fill::Value(value) => {
            let filled = |sample: f64| if sample.is_nan() { value } else { sample };
            values.mapv_inplace(filled);
        }
        Fill::Nearest => fill_nearest(values),
    }
}

/// Puts the nearest sample in the place of each missing one.
fn fill_nearest(values: &mut Array2<f64>) {
    let near = nearest_in_columns(values);
    let known = values.clone();
    for (y, mut row) in values.rows_mut().into_iter().enumerate() {
        let near = near.row(y);
        for (x, value) in row.iter_mut().enumerate() {
            if !value.is_nan() {
                continue;
            }

            // Columns are searched outwards until they are farther than the best sample.
            let mut best: Option<(usize, [usize; 2])> = None;
            for step in 0..near.len() {
                if best.is_some_and(|(square, _)| step * step >= square) {
                    break;
                }
                for column in [x.checked_sub(step), x.checked_add(step)] {
                    let Some(column) = column else { continue };
                    let Some(Some(row)) = near.get(column) else {
                        continue;
                    };
                    let square = step * step + row.abs_diff(y).pow(2);
                    if best.is_none_or(|(least, _)| square < least) {
                        best = Some((square, [*row, column]));
                    }
                }
            }
            let found = best.and_then(|(_, place)| known.get(place));
            if let Some(found) = found {
                *value = *found;
            }
        }
    }
}

/// For each sample the row of the nearest one in its column that is there.
fn nearest_in_columns(values: &Array2<f64>) -> Array2<Option<usize>> {
    let mut near = Array2::from_elem(values.dim(), None);
    for (column, mut near) in values.columns().into_iter().zip(near.columns_mut()) {
        let mut last = None;
        for (y, (value, near)) in column.iter().zip(near.iter_mut()).enumerate() {
            last = if value.is_nan() { last } else { Some(y) };
            *near = last;
        }

        // The same from the other end; the nearer one stays.
        let mut next: Option<usize> = None;
        let pairs = column.iter().zip(near.iter_mut()).enumerate();
        for (y, (value, near)) in pairs.collect::<Vec<_>>().into_iter().rev() {
            next = if value.is_nan() { next } else { Some(y) };
            *near = match (*near, next) {
                (Some(before), Some(after)) if after.abs_diff(y) < y.abs_diff(before) => {
                    Some(after)
                }
                (None, after) => after,
                (before, _) => before,
            };
        }
    }
    near
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use crate::file::maps::missing_samples::{Fill, fill, missing};
    use crate::math::random::uniform;

    const LOST: f64 = f64::NAN;

    #[test]
    fn missing_samples_are_counted() {
        assert_eq!(missing(&array![[1.0, 2.0]]), None);
        let lost = missing(&array![[1.0, 2.0], [3.0, LOST], [LOST, 1.0]]);
        let expected = "2 missing samples of 6, the first at [1, 1]";
        assert_eq!(lost.as_deref(), Some(expected));
    }

    /// Against a search through all samples.
    #[test]
    fn the_nearest_sample_is_taken() {
        let mut values = Array2::from_shape_fn((17, 23), |(y, x)| {
            let keep = uniform(7, [y as u32, x as u32, 0, 0]) < 0.1;
            if keep { (23 * y + x) as f64 } else { LOST }
        });
        let known = values.clone();
        fill(&mut values, Fill::Nearest);
        let square = |a: (usize, usize), value: f64| {
            let b = (value as usize / 23, value as usize % 23);
            a.0.abs_diff(b.0).pow(2) + a.1.abs_diff(b.1).pow(2)
        };
        for (at, value) in values.indexed_iter() {
            let least = known.iter().filter(|value| !value.is_nan());
            let least = least.map(|value| square(at, *value)).min();
            assert_eq!(Some(square(at, *value)), least, "{at:?}");
        }
    }

    #[test]
    fn nothing_is_made_of_nothing() {
        let mut values = array![[LOST, LOST]];
        fill(&mut values, Fill::Nearest);
        assert!(values.iter().all(|value| value.is_nan()));
        fill(&mut values, Fill::Value(0.5));
        assert_eq!(values, array![[0.5, 0.5]]);
    }
}
