//! The levels of all cells, looked at once before they are written: how far values are from them, the smallest feature, and
//! the tile that repeats.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::levels::Levels;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Survey {
    /// Root mean square and largest distance of values from their levels.
    pub off: [f64; 2],
    /// Number of cells of each level.
    pub counts: Vec<u64>,
    /// The smallest width along x and along y of a run of equal cells between two others, in cells.
    pub feature: [Option<usize>; 2],
    /// Cells [nx, ny] of the smallest tile that makes the whole by repetition.
    pub tile: [usize; 2],
}

/// The levels of one row.
pub(crate) fn row_levels(levels: &Levels, values: &[f64], row: &mut [u16]) {
    for (to, value) in row.iter_mut().zip(values) {
        *to = levels.of(*value).0;
    }
}

/// Surveys all cells.
///
/// # Errors
/// A row that cannot be read.
pub(crate) fn survey(cells: &mut Cells, levels: &Levels) -> Result<Survey, Fault> {
    let [nx, _] = cells.size();
    let (mut squares, mut largest, mut open) = (0.0, 0.0_f64, 0_u64);
    let mut counts = vec![0_u64; usize::from(levels.count)];
    let mut row = vec![0_u16; nx];
    let mut columns = Columns {
        last: Vec::new(),
        run: vec![0; nx],
        smallest: None,
    };
    let mut across = None;
    let (mut periods, mut hashes) = (1, Vec::new());
    cells.each_row(|_, values| {
        for (to, value) in row.iter_mut().zip(values) {
            let (level, off) = levels.of(*value);
            *to = level;
            open += u64::from(!value.is_nan());
            squares += off * off;
            largest = largest.max(off.abs());
            if let Some(count) = counts.get_mut(usize::from(level)) {
                *count += 1;
            }
        }
        across = least(across, shortest(&row));
        columns.add(&row);
        if periods < nx {
            periods = common(periods, period(&row), nx);
        }
        let mut hasher = DefaultHasher::new();
        row.hash(&mut hasher);
        hashes.push(hasher.finish());
        Ok(())
    })?;
    Ok(Survey {
        off: [(squares / open as f64).sqrt(), largest],
        counts,
        feature: [across, columns.smallest],
        tile: [periods, period(&hashes)],
    })
}

/// The smaller of two numbers that may be missing.
fn least(a: Option<usize>, b: Option<usize>) -> Option<usize> {
    a.into_iter().chain(b).min()
}

/// The shortest run of equal cells between two others.
fn shortest(row: &[u16]) -> Option<usize> {
    let runs = row.chunk_by(|a, b| a == b).map(<[u16]>::len);
    let count = row.chunk_by(|a, b| a == b).count();
    runs.skip(1).take(count.saturating_sub(2)).min()
}

/// Runs of equal cells along y, column by column.
struct Columns {
    last: Vec<u16>,
    /// Cells of the run so far; 0 for one that began at the edge.
    run: Vec<u32>,
    smallest: Option<usize>,
}

impl Columns {
    fn add(&mut self, row: &[u16]) {
        if self.last.is_empty() {
            self.last = row.to_vec();
            return;
        }
        let columns = self.last.iter_mut().zip(&mut self.run).zip(row);
        for ((last, run), level) in columns {
            if level == last {
                *run += u32::from(*run > 0);
                continue;
            }
            if *run > 0 {
                self.smallest = least(self.smallest, Some(*run as usize));
            }
            (*last, *run) = (*level, 1);
        }
    }
}

/// The smallest number of items that make a list by whole repetitions.
fn period<T: PartialEq>(list: &[T]) -> usize {
    // How long a beginning of the list also ends its first 1, 2, … items.
    let mut border: Vec<usize> = vec![0];
    let mut long = 0;
    for item in list.iter().skip(1) {
        while long > 0 && list.get(long) != Some(item) {
            long = border.get(long - 1).copied().unwrap_or(0);
        }
        if list.get(long) == Some(item) {
            long += 1;
        }
        border.push(long);
    }
    let period = list.len() - border.last().copied().unwrap_or(0);
    match list.len().is_multiple_of(period) {
        true => period,
        false => list.len(),
    }
}

/// The smallest common multiple of two periods of a row of `all` cells.
fn common(a: usize, b: usize, all: usize) -> usize {
    let multiples = (1..).map(|i| i * a.max(b));
    let mut found = multiples.take_while(|m| *m < all);
    found
        .find(|m| m.is_multiple_of(a.min(b)) && all.is_multiple_of(*m))
        .unwrap_or(all)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ndarray::Array2;

    use crate::file::arrays::array::BorrowedArray;
    use crate::file::fabrication::cell_rows::{BorrowedRows, Cells, Part};
    use crate::file::fabrication::export_choices::Quantity;
    use crate::file::fabrication::level_survey::{Survey, common, period, survey};
    use crate::file::fabrication::levels::Levels;

    fn surveyed(values: Array2<f64>) -> Survey {
        let rows = BorrowedRows {
            array: BorrowedArray::Real(values.view()),
            part: Part::Phase,
            scale: 1.0,
        };
        let mut cells = Cells {
            quantity: Quantity::Level,
            ..Cells::new(Box::new(rows), [1.0; 2], Path::new("a.npy"))
        };
        let levels = Levels {
            count: 4,
            lowest: 0.0,
            step: 1.0,
            wraps: false,
        };
        survey(&mut cells, &levels).unwrap()
    }

    #[test]
    fn tiles_and_features_are_found() {
        // A tile of 3 x 2 cells, repeated.
        let tile = [[0.0, 1.0, 1.0], [2.0, 2.0, 3.0]];
        let found = surveyed(Array2::from_shape_fn((8, 9), |(y, x)| tile[y % 2][x % 3]));
        assert_eq!((found.tile, found.feature), ([3, 2], [Some(1), Some(1)]));
        assert_eq!(found.counts, [12, 24, 24, 12]);
        assert_eq!(found.off, [0.0, 0.0]);

        // Stripes of 2 and 3 cells along x; nothing changes along y. Values are off by a tenth and not at all.
        let stripes = [0.1, 0.1, 1.0, 1.0, 1.0, 0.1, 0.1, 0.1, 0.1, 1.0];
        let found = surveyed(Array2::from_shape_fn((4, 10), |(_, x)| stripes[x]));
        assert_eq!((found.tile, found.feature), ([10, 1], [Some(3), None]));
        assert!(
            (found.off[1] - 0.1).abs() < 1e-12 && (found.off[0] - 0.1 * 0.6_f64.sqrt()) < 1e-12
        );
    }

    #[test]
    fn periods_are_whole_parts() {
        assert_eq!(period(&[1, 2, 1, 2, 1, 2]), 2);
        assert_eq!(period(&[1, 2, 1, 2, 1]), 5);
        assert_eq!(period(&[7, 7, 7]), 1);
        assert_eq!(period(&[1, 1, 2, 1, 1, 1]), 6);
        assert_eq!(common(2, 3, 12), 6);
        assert_eq!(common(4, 6, 24), 12);
        assert_eq!(common(5, 4, 20), 20);
    }
}
