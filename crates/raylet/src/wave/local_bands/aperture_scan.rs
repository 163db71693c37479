//! The open shares of many cells.

use crate::optics::aperture::Aperture;

/// The open shares of cells along a row, from low to high x. The depth of one cell inside or outside the edge says
/// how near an edge can be, so most cells need no evaluation of their own.
pub(crate) struct ApertureScan<'a> {
    aperture: &'a Aperture,
    /// The row's span along y, in mm.
    row: [f64; 2],
    /// Cells are known to have this share up to that x.
    known: (f64, f64),
}

impl<'a> ApertureScan<'a> {
    pub(crate) fn new(aperture: &'a Aperture, row: [f64; 2]) -> Self {
        Self {
            aperture,
            row,
            known: (0.0, f64::NEG_INFINITY),
        }
    }

    /// The open share of the cell with this span along x.
    pub(crate) fn open(&mut self, [x0, x1]: [f64; 2]) -> f64 {
        let [y0, y1] = self.row;
        let x = 0.5 * (x0 + x1);
        let (share, end) = self.known;
        if x + 0.5 * (x1 - x0 + y1 - y0) < end {
            return share;
        }
        let y = 0.5 * (y0 + y1);
        let half = 0.5 * (x1 - x0).hypot(y1 - y0);
        let depth = self.aperture.depth(x, y);
        if depth.abs() <= half {
            return self.aperture.coverage(x0, x1, y0, y1);
        }
        let share = if depth > 0.0 { 1.0 } else { 0.0 };
        self.known = (share, x + depth.abs());
        share
    }

    /// The open shares of cells along the row, from low to high x.
    pub(crate) fn fill(mut self, spans: &[[f64; 2]], open: &mut [f64]) {
        let half_height = 0.5 * (self.row[1] - self.row[0]);
        let (mut spans, mut open) = (spans, open);
        while let (Some(span), false) = (spans.first(), open.is_empty()) {
            let share = self.open(*span);

            // Most cells have the share of the cell before.
            let (_, end) = self.known;
            let behind = spans.partition_point(|[_, x1]| x1 + half_height < end);
            let equal = behind.clamp(1, spans.len()).min(open.len());
            let (these, others) = open.split_at_mut(equal);
            these.fill(share);
            (spans, open) = (spans.get(equal..).unwrap_or_default(), others);
        }
    }

    /// How many cells from this one on, each as wide, have the share that was found last.
    pub(crate) fn equal_cells(&self, [x0, x1]: [f64; 2]) -> usize {
        let [y0, y1] = self.row;
        let (_, end) = self.known;
        let room = end - 0.5 * (x0 + x1) - 0.5 * (x1 - x0 + y1 - y0);
        ((room / (x1 - x0)).ceil().max(1.0)) as usize
    }
}
