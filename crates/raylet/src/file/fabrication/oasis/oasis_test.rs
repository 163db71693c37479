//! Tests: files of the format OASIS hold the shapes of those of the format GDSII. The decoder here knows the format alone.

use std::io::Read;
use std::path::Path;

use flate2::read::DeflateDecoder;
use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Masks, Quantity};
use crate::file::fabrication::gds::gds_shapes::{Drawn, gds_shapes, moved};
use crate::file::fabrication::masks::mask_file::MaskFile;
use crate::file::fabrication::masks::mask_plan::MaskLayer;
use crate::file::fabrication::oasis::oasis_writer::OasisFile;

/// Bytes that are read one after another.
struct Bytes {
    bytes: Vec<u8>,
    at: usize,
}

impl Bytes {
    fn byte(&mut self) -> u8 {
        self.at += 1;
        self.bytes[self.at - 1]
    }

    fn take(&mut self, count: usize) -> Vec<u8> {
        self.at += count;
        self.bytes[self.at - count..self.at].to_vec()
    }

    fn unsigned(&mut self) -> i64 {
        let mut value = 0;
        for place in 0.. {
            let byte = self.byte();
            value |= i64::from(byte & 0x7f) << (7 * place);
            if byte < 0x80 {
                return value;
            }
        }
        value
    }

    fn signed(&mut self) -> i64 {
        let value = self.unsigned();
        if value & 1 == 1 {
            -(value >> 1)
        } else {
            value >> 1
        }
    }

    fn text(&mut self) -> String {
        let length = self.unsigned() as usize;
        String::from_utf8(self.take(length)).unwrap()
    }
}

/// What is known while records are decoded.
#[derive(Default)]
struct Decoded {
    cells: Vec<(String, Vec<Drawn>)>,
    layer: [i64; 2],
    size: [i64; 2],
    at: [i64; 2],
}

impl Decoded {
    /// Decodes all records; true where the last one was the end.
    fn records(&mut self, bytes: &mut Bytes) -> bool {
        while bytes.at < bytes.bytes.len() {
            match bytes.byte() {
                2 => return true,
                14 => {
                    self.cells.push((bytes.text(), Vec::new()));
                    self.at = [0; 2];
                }
                16 => {}
                17 => self.placement(bytes),
                20 => self.rectangle(bytes),
                21 => self.polygon(bytes),
                34 => {
                    assert_eq!(bytes.byte(), 0);
                    let (all, packed) = (bytes.unsigned() as usize, bytes.unsigned() as usize);
                    let mut inner = Vec::new();
                    let packed = bytes.take(packed);
                    DeflateDecoder::new(&packed[..])
                        .read_to_end(&mut inner)
                        .unwrap();
                    assert_eq!(inner.len(), all);
                    let mut inner = Bytes {
                        bytes: inner,
                        at: 0,
                    };
                    assert!(!self.records(&mut inner));
                }
                other => panic!("record {other}"),
            }
        }
        false
    }

    fn layer(&mut self, states: u8, bytes: &mut Bytes) {
        for (bit, to) in [1, 2].into_iter().zip(&mut self.layer) {
            if states & bit != 0 {
                *to = bytes.unsigned();
            }
        }
    }

    fn place(&mut self, states: u8, bytes: &mut Bytes) {
        for (bit, to) in [0x10, 0x08].into_iter().zip(&mut self.at) {
            if states & bit != 0 {
                *to += bytes.signed();
            }
        }
    }

    fn keep(&mut self, corners: Vec<[i64; 2]>) {
        let [layer, data_type] = self.layer.map(|number| number as u16);
        let (_, shapes) = self.cells.last_mut().unwrap();
        shapes.push((layer, data_type, corners));
    }

    fn rectangle(&mut self, bytes: &mut Bytes) {
        let states = bytes.byte();
        self.layer(states, bytes);
        for (bit, to) in [0x40, 0x20].into_iter().zip(&mut self.size) {
            if states & bit != 0 {
                *to = bytes.unsigned();
            }
        }
        self.place(states, bytes);
        let ([x, y], [w, h]) = (self.at, self.size);
        self.keep(vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]);
    }

    fn polygon(&mut self, bytes: &mut Bytes) {
        let states = bytes.byte();
        self.layer(states, bytes);
        assert_eq!((states & 0x20, bytes.unsigned()), (0x20, 4));
        let count = bytes.unsigned();
        let mut steps = Vec::new();
        for _ in 0..count {
            let first = bytes.unsigned();
            assert_eq!(first & 1, 1);
            let x = if first & 2 == 0 {
                first >> 2
            } else {
                -(first >> 2)
            };
            steps.push([x, bytes.signed()]);
        }
        self.place(states, bytes);
        let mut corners = vec![self.at];
        for [dx, dy] in steps {
            let [x, y] = *corners.last().unwrap();
            corners.push([x + dx, y + dy]);
        }
        self.keep(corners);
    }

    fn placement(&mut self, bytes: &mut Bytes) {
        assert_eq!(bytes.byte(), 0xb8);
        let name = bytes.text();
        let [x, y] = [bytes.signed(), bytes.signed()];
        let [columns, rows, dx, dy] = match bytes.unsigned() {
            1 => {
                let counts = [bytes.unsigned() + 2, bytes.unsigned() + 2];
                [counts[0], counts[1], bytes.unsigned(), bytes.unsigned()]
            }
            2 => [bytes.unsigned() + 2, 1, bytes.unsigned(), 0],
            3 => [1, bytes.unsigned() + 2, 0, bytes.unsigned()],
            other => panic!("repetition {other}"),
        };
        let known = self.cells.iter().find(|(own, _)| *own == name);
        let shapes = known.unwrap().1.clone();
        let (_, own) = self.cells.last_mut().unwrap();
        for row in 0..rows {
            for column in 0..columns {
                let at = [x + column * dx, y + row * dy];
                own.extend(shapes.iter().map(|shape| moved(shape, at)));
            }
        }
    }
}

/// The shapes of the last cell of a file, whose head, end and checksum are right; and the database units of a µm.
fn oasis_shapes(file: &[u8]) -> (Vec<Drawn>, i64) {
    assert_eq!(&file[..18], b"%SEMI-OASIS\r\n\x01\x031.0");
    let (body, checksum) = file.split_at(file.len() - 4);
    assert_eq!(checksum, crc32fast::hash(body).to_le_bytes());
    assert_eq!(file[file.len() - 256], 2);
    let mut bytes = Bytes {
        bytes: file.to_vec(),
        at: 18,
    };
    assert_eq!(bytes.byte(), 0);
    let units = bytes.unsigned();
    assert_eq!(bytes.take(13), [0; 13]);
    let mut decoded = Decoded::default();
    assert!(decoded.records(&mut bytes));
    assert_eq!(bytes.at, file.len() - 255);
    let (_, mut shapes) = decoded.cells.pop().unwrap();
    shapes.sort();
    (shapes, units)
}

fn exported(path: &Path, values: &Array2<f64>, choices: &ExportChoices) -> Vec<u8> {
    let source = ExportSource::Array(BorrowedArray::Real(values.view()));
    export_element(source, path, choices).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn oasis_files_hold_the_shapes_of_gdsii_files() {
    let room = tempfile::tempdir().unwrap();
    let (gds, oasis) = (room.path().join("a.gds"), room.path().join("a.oas"));
    let patterns: [fn(usize, usize) -> usize; 4] = [
        |y, x| (7 * y * y + 3 * x * x + x * y) % 4,
        |y, x| (y % 3 + 2 * (x % 4)) % 4,
        |y, x| 2 * (y % 2) + x % 48 / 24,
        |_, x| x % 6 / 2,
    ];
    for pattern in patterns {
        let values = Array2::from_shape_fn((30, 48), |(y, x)| pattern(y, x) as f64);
        for masks in [Masks::Each, Masks::Binary, Masks::Dose] {
            let choices = ExportChoices {
                pitch_um: Some([0.5, 0.75]),
                quantity: Quantity::Level,
                levels: Some(4),
                masks,
                gds_layer: 200,
                ..ExportChoices::default()
            };
            let (found, units) = oasis_shapes(&exported(&oasis, &values, &choices));
            let expected = gds_shapes(&exported(&gds, &values, &choices));
            assert_eq!((units, found), (1000, expected), "{masks:?}");
        }
    }
}

#[test]
fn polygons_and_many_blocks_are_written() {
    let mut out = Vec::new();
    let mut file = OasisFile::new(&mut out, 0.5).unwrap();
    file.structure("A").unwrap();
    let layer = MaskLayer {
        layer: 300,
        data_type: 1,
    };
    let corners = [[-5, 3], [100, -7], [20, 9000]];
    file.polygon(layer, &corners).unwrap();
    let mut expected = vec![(300, 1, corners.to_vec())];
    for i in 0..200_000_i64 {
        let (low, high) = ([i * 100_003, -i], [i * 100_003 + 7 + i % 3, 5]);
        file.rectangle(layer, [low, high]).unwrap();
        let [[x0, y0], [x1, y1]] = [low, high];
        expected.push((300, 1, vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]));
    }
    file.end().unwrap();
    let (found, units) = oasis_shapes(&out);
    expected.sort();
    assert_eq!(units, 2000);
    assert!(found == expected);
}
