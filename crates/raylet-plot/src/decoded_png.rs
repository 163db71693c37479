//! For tests: the pixels of a PNG.

use std::collections::HashMap;
use std::ops::Range;

/// The colour of the ground on which figures are drawn.
const GROUND: [u8; 3] = [255; 3];

/// In parts of a picture every so many columns and rows are looked at.
const STRIDE: usize = 4;

/// A picture of three bytes a pixel.
pub(crate) struct DecodedPng {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Row by row from the top.
    bytes: Vec<u8>,
}

impl DecodedPng {
    /// Unpacks a PNG.
    pub(crate) fn of(png: &[u8]) -> Self {
        let decoder = png::Decoder::new(std::io::Cursor::new(png));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Self {
            width: info.width as usize,
            height: info.height as usize,
            bytes,
        }
    }

    /// The colour of a pixel by its column and row.
    pub(crate) fn at(&self, [x, y]: [usize; 2]) -> [u8; 3] {
        let at = 3 * (y * self.width + x);
        [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]]
    }

    /// The first and the last column with a pixel of this colour.
    pub(crate) fn columns(&self, colour: [u8; 3]) -> Option<[usize; 2]> {
        let mut columns = (0..self.width).filter(|x| self.column_has(*x, colour));
        let first = columns.next()?;
        Some([first, columns.next_back().unwrap_or(first)])
    }

    /// Whether a pixel of this column has this colour.
    pub(crate) fn column_has(&self, x: usize, colour: [u8; 3]) -> bool {
        (0..self.height).any(|y| self.at([x, y]) == colour)
    }

    /// The commonest colour but for the ground in a part of the picture.
    pub(crate) fn commonest(&self, columns: Range<usize>, rows: Range<usize>) -> Option<[u8; 3]> {
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        for y in rows.step_by(STRIDE) {
            for x in columns.clone().step_by(STRIDE) {
                *counts.entry(self.at([x, y])).or_default() += 1;
            }
        }
        counts.remove(&GROUND);
        let most = counts.into_iter().max_by_key(|(_, count)| *count);
        most.map(|(colour, _)| colour)
    }
}
