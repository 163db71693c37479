//! Cells of equal value as few rectangles: equal neighbours along a row become runs, and runs that the next row repeats
//! become higher. Only the rectangles that reach into the last row are in memory.

/// A rectangle of cells of one value, from the first to behind the last along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    /// Along x.
    pub x: [usize; 2],
    /// Along y.
    pub y: [usize; 2],
    /// What its cells have.
    pub value: u16,
}

/// Rectangles that are not closed yet, in the order of their x.
#[derive(Debug, Default)]
pub(crate) struct Merging {
    open: Vec<Rectangle>,
    next: Vec<Rectangle>,
    rows: usize,
}

impl Merging {
    /// Adds a row, and hands on the rectangles that it does not continue. Cells of value 0 are empty.
    ///
    /// # Errors
    /// An error of `close`.
    pub(crate) fn add<E>(
        &mut self,
        row: &[u16],
        mut close: impl FnMut(Rectangle) -> Result<(), E>,
    ) -> Result<(), E> {
        let y = self.rows;
        self.next.clear();
        let mut earlier = self.open.iter().peekable();
        let mut start = 0;
        for run in row.chunk_by(|a, b| a == b) {
            let x = [start, start + run.len()];
            start += run.len();
            let value = run.first().copied().unwrap_or(0);
            if value == 0 {
                continue;
            }
            // What began further left, or elsewhere, ends here.
            while let Some(old) = earlier.next_if(|old| old.x[0] < x[0]) {
                close(*old)?;
            }
            let same = earlier.next_if(|old| old.x[0] == x[0]);
            let [y0, y1] = match same {
                Some(old) if old.x == x && old.value == value => [old.y[0], y + 1],
                Some(old) => {
                    close(*old)?;
                    [y, y + 1]
                }
                None => [y, y + 1],
            };
            self.next.push(Rectangle {
                x,
                y: [y0, y1],
                value,
            });
        }
        for old in earlier {
            close(*old)?;
        }
        std::mem::swap(&mut self.open, &mut self.next);
        self.rows += 1;
        Ok(())
    }

    /// Hands on the rectangles that reach into the last row.
    ///
    /// # Errors
    /// An error of `close`.
    pub(crate) fn finish<E>(
        self,
        mut close: impl FnMut(Rectangle) -> Result<(), E>,
    ) -> Result<(), E> {
        self.open.into_iter().try_for_each(&mut close)
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use ndarray::{Array2, array};

    use crate::file::fabrication::masks::rectangles::{Merging, Rectangle};

    fn rectangles(cells: &Array2<u16>) -> Vec<Rectangle> {
        let mut found = Vec::new();
        let mut keep = |rectangle| -> Result<(), Infallible> {
            found.push(rectangle);
            Ok(())
        };
        let mut merging = Merging::default();
        for row in cells.rows() {
            let Ok(()) = merging.add(row.as_slice().unwrap(), &mut keep);
        }
        let Ok(()) = merging.finish(&mut keep);
        found
    }

    /// The rectangles cover each cell that is not empty once, with its value.
    fn covered(cells: &Array2<u16>) -> usize {
        let found = rectangles(cells);
        let mut again = Array2::zeros(cells.dim());
        for rectangle in &found {
            for y in rectangle.y[0]..rectangle.y[1] {
                for x in rectangle.x[0]..rectangle.x[1] {
                    assert_eq!(again[[y, x]], 0, "{rectangle:?}");
                    again[[y, x]] = rectangle.value;
                }
            }
        }
        assert_eq!(again, cells);
        found.len()
    }

    #[test]
    fn equal_cells_are_joined() {
        assert_eq!(covered(&Array2::from_elem((5, 7), 2)), 1);
        assert_eq!(covered(&Array2::zeros((5, 7))), 0);
        assert_eq!(
            covered(&array![[1, 1, 0, 2], [1, 1, 0, 2], [0, 1, 1, 2]]),
            3
        );
        assert_eq!(covered(&array![[1, 2], [2, 1]]), 4);
        // A run of another width in its place begins anew.
        assert_eq!(covered(&array![[0, 1, 1, 1], [1, 1, 1, 0]]), 2);
    }

    #[test]
    fn random_cells_are_covered_once() {
        let mut number = 1_u64;
        for size in [(1, 1), (1, 40), (40, 1), (31, 17), (64, 64)] {
            let cells = Array2::from_shape_fn(size, |_| {
                number = number
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                ((number >> 33) % 3) as u16
            });
            covered(&cells);
        }
    }
}
