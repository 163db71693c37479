//! The largest errors that rows of the accuracy report may have: at most three times those that were measured when
//! the bounds were set.

/// A line for each row: its bound, a bar, its name; of gradients another bar and the loss.
const BOUNDS: &str = include_str!("../data/bounds.txt");

/// The bound of a row; nothing if none is recorded.
pub fn bound(row: &str) -> Option<f64> {
    let of_row = |line: &str| {
        let (bound, name) = line.split_once(" | ")?;
        (name == row).then(|| bound.parse().ok()).flatten()
    };
    BOUNDS.lines().find_map(of_row)
}
