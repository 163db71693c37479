//! Mask files in the format OASIS.
//!
//! A record states only what differs from the record before, and places count from the last one. Shapes are packed in blocks
//! of a megabyte, and the end of the file has a checksum. raylet writes this itself, because crates that write OASIS hold a
//! whole library.

use std::io::{self, Write};

use crc32fast::Hasher;
use flate2::Compression;
use flate2::write::DeflateEncoder;

use crate::file::fabrication::masks::mask_file::{MaskFile, TILE, TileArray};
use crate::file::fabrication::masks::mask_plan::MaskLayer;
use crate::file::fabrication::oasis::oasis_record::{kind, real, signed, step, text, unsigned};

/// The first bytes of a file.
const MAGIC: &[u8] = b"%SEMI-OASIS\r\n";

/// Bytes of records that are packed at once.
const BLOCK: usize = 1 << 20;

/// Bytes that fill the last record up to its fixed length of 256.
const PADDING: usize = 248;

/// A number of the validation: a checksum of 32 bits.
const CRC32: u8 = 1;

/// What the last records have stated.
#[derive(Debug, Default)]
struct Modal {
    layer: Option<MaskLayer>,
    size: Option<[i64; 2]>,
    place: [i64; 2],
}

/// A file that is written.
pub(crate) struct OasisFile<W> {
    out: W,
    checksum: Hasher,
    /// Records that are not packed yet.
    block: Vec<u8>,
    last: Modal,
}

impl<W: Write> OasisFile<W> {
    /// Writes the head of a file: the version, the database units of a µm, and that there are no tables.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn new(out: W, unit_nm: f64) -> io::Result<Self> {
        let mut file = Self {
            out,
            checksum: Hasher::new(),
            block: Vec::with_capacity(BLOCK + 64),
            last: Modal::default(),
        };
        let mut head = MAGIC.to_vec();
        head.push(kind::START);
        text(&mut head, "1.0");
        real(&mut head, 1e3 / unit_nm);
        // Where six tables stand: here, and nowhere.
        head.extend([0; 13]);
        file.put(&head)?;
        Ok(file)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.checksum.update(bytes);
        self.out.write_all(bytes)
    }

    /// Packs what is waiting.
    fn flush(&mut self) -> io::Result<()> {
        if self.block.is_empty() {
            return Ok(());
        }
        let mut packed = DeflateEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&self.block)?;
        let packed = packed.finish()?;
        let mut head = vec![kind::CBLOCK, 0];
        unsigned(&mut head, self.block.len() as u64);
        unsigned(&mut head, packed.len() as u64);
        self.block.clear();
        self.put(&head)?;
        self.put(&packed)
    }

    /// Begins a record of a shape: its kind, what it states, and its layer if that is new.
    fn begin(&mut self, kind: u8, mut states: u8, layer: MaskLayer) {
        let last = self.last.layer.replace(layer);
        let is_new = |number: fn(MaskLayer) -> u16| last.map(number) != Some(number(layer));
        let numbers = [
            (0x01, layer.layer, is_new(|layer| layer.layer)),
            (0x02, layer.data_type, is_new(|layer| layer.data_type)),
        ];
        let new = numbers.iter().filter(|(_, _, is_new)| *is_new);
        states |= new.clone().fold(0, |bits, (bit, ..)| bits | bit);
        self.block.extend([kind, states]);
        for (_, number, _) in new {
            unsigned(&mut self.block, u64::from(*number));
        }
    }

    /// What a record states of its place: bits for x and y where they are new.
    fn moved(&self, [x, y]: [i64; 2]) -> u8 {
        let [u, v] = self.last.place;
        (if x == u { 0 } else { 0x10 }) | (if y == v { 0 } else { 0x08 })
    }

    /// Ends a record of a shape with its place.
    fn place(&mut self, place: [i64; 2]) -> io::Result<()> {
        let last = std::mem::replace(&mut self.last.place, place);
        for (to, from) in place.into_iter().zip(last) {
            if to != from {
                signed(&mut self.block, to - from);
            }
        }
        match self.block.len() < BLOCK {
            true => Ok(()),
            false => self.flush(),
        }
    }
}

impl<W: Write> MaskFile for OasisFile<W> {
    fn structure(&mut self, name: &str) -> io::Result<()> {
        self.flush()?;
        let mut record = vec![kind::CELL];
        text(&mut record, name);
        record.push(kind::XYRELATIVE);
        // Nothing is known at the beginning of a cell, and places count from the origin.
        self.last = Modal::default();
        self.put(&record)
    }

    fn rectangle(&mut self, layer: MaskLayer, [low, high]: [[i64; 2]; 2]) -> io::Result<()> {
        let [width, height] = [high[0] - low[0], high[1] - low[1]];
        let last = self.last.size.replace([width, height]);
        let is_new = [0, 1].map(|axis| {
            let own = if axis == 0 { width } else { height };
            last.is_none_or(|last| (if axis == 0 { last[0] } else { last[1] }) != own)
        });
        let states = (if is_new[0] { 0x40 } else { 0 }) | (if is_new[1] { 0x20 } else { 0 });
        self.begin(kind::RECTANGLE, states | self.moved(low), layer);
        for (side, is_new) in [width, height].into_iter().zip(is_new) {
            if is_new {
                unsigned(&mut self.block, side.unsigned_abs());
            }
        }
        self.place(low)
    }

    fn polygon(&mut self, layer: MaskLayer, corners: &[[i64; 2]]) -> io::Result<()> {
        let Some(first) = corners.first() else {
            return Ok(());
        };
        self.begin(kind::POLYGON, 0x20 | self.moved(*first), layer);
        // Steps of any direction from the first corner on; the last side closes the polygon.
        unsigned(&mut self.block, 4);
        unsigned(&mut self.block, corners.len() as u64 - 1);
        for ([x, y], [u, v]) in corners.iter().zip(corners.iter().skip(1)) {
            step(&mut self.block, [u - x, v - y]);
        }
        self.place(*first)
    }

    fn array(&mut self, array: TileArray) -> io::Result<()> {
        // A reference by name, with x, y and a repetition.
        self.block.extend([kind::PLACEMENT, 0xb8]);
        text(&mut self.block, TILE);
        array
            .corner
            .iter()
            .for_each(|at| signed(&mut self.block, *at));
        let beyond = array.counts.map(|count| count as u64);
        let spaces = array.steps.map(i64::unsigned_abs);
        let numbers = match (beyond, spaces) {
            ([columns, 1], [dx, _]) => vec![2, columns - 2, dx],
            ([1, rows], [_, dy]) => vec![3, rows - 2, dy],
            ([columns, rows], [dx, dy]) => vec![1, columns - 2, rows - 2, dx, dy],
        };
        for number in numbers {
            unsigned(&mut self.block, number);
        }
        Ok(())
    }

    fn end(&mut self) -> io::Result<()> {
        self.flush()?;
        let mut record = vec![kind::END];
        unsigned(&mut record, PADDING as u64);
        record.extend([0; PADDING]);
        record.push(CRC32);
        self.put(&record)?;
        let checksum = self.checksum.clone().finalize();
        self.out.write_all(&checksum.to_le_bytes())
    }
}
