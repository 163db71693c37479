//! The elements of a GDSII file, one after another. No length that the file states is believed before its bytes are there.

use std::io::{self, Read, Seek, SeekFrom};

use crate::file::fabrication::gds::gds_record::{kind, number};

/// Reads records.
pub(crate) struct Records<R> {
    input: R,
    /// Where the next record begins.
    pub at: u64,
    /// The data of the last record.
    data: Vec<u8>,
}

/// A reference to a structure, or an array of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reference {
    /// The name of the structure.
    pub name: Vec<u8>,
    /// Where the first stands.
    pub origin: [i64; 2],
    /// How many stand along x and y.
    pub counts: [i64; 2],
    /// From one to the next.
    pub steps: [i64; 2],
}

/// A polygon.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shape {
    /// Its layer.
    pub layer: u16,
    /// Its data type.
    pub data_type: u16,
    /// Its corners, the last of which is the first again.
    pub corners: Vec<[i32; 2]>,
}

/// What stands in a structure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Element {
    /// A polygon.
    Shape(Shape),
    /// References.
    Reference(Reference),
    /// What draws nothing, such as a text.
    Other,
    /// The end of the structure.
    End,
}

/// The data of an element so far.
#[derive(Default)]
struct Draft {
    shape: Shape,
    name: Vec<u8>,
    counts: Option<[i64; 2]>,
}

impl<R: Read + Seek> Records<R> {
    /// Records from the start of a stream.
    pub(crate) fn new(input: R) -> Self {
        Self {
            input,
            at: 0,
            data: Vec::new(),
        }
    }

    /// Goes to the place where a record begins.
    ///
    /// # Errors
    /// An error of the file system, in words.
    pub(crate) fn seek(&mut self, at: u64) -> Result<(), String> {
        let sought = self.input.seek(SeekFrom::Start(at));
        self.at = sought.map_err(|error| error.to_string())?;
        Ok(())
    }

    /// The kind and the data of the next record.
    ///
    /// # Errors
    /// A file that ends before, or a length that no record has, in words.
    pub(crate) fn next(&mut self) -> Result<(u16, &[u8]), String> {
        let at = self.at;
        let cut = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => format!("a file that ends in its record at byte {at}"),
            _ => error.to_string(),
        };
        let mut head = [0; 4];
        self.input.read_exact(&mut head).map_err(cut)?;
        let [a, b, c, d] = head;
        let length = usize::from(u16::from_be_bytes([a, b]));
        let Some(rest) = length.checked_sub(4) else {
            return Err(format!("a record of {length} bytes at byte {at}"));
        };
        // At most 65531 bytes.
        self.data.resize(rest, 0);
        self.input.read_exact(&mut self.data).map_err(cut)?;
        self.at += length as u64;
        Ok((u16::from_be_bytes([c, d]), &self.data))
    }

    /// The next element of a structure, whose name has been read.
    ///
    /// # Errors
    /// A record that does not belong here, or a turned reference, in words.
    pub(crate) fn element(&mut self) -> Result<Element, String> {
        let at = self.at;
        let (begun, _) = self.next()?;
        match begun {
            kind::ENDSTR => return Ok(Element::End),
            kind::BOUNDARY | kind::BOX | kind::SREF | kind::AREF => {}
            kind::TEXT | kind::NODE | kind::PATH => {}
            other => return Err(format!("a record of kind {other:#06x} at byte {at}")),
        }
        let mut draft = Draft::default();
        loop {
            let (kind, data) = self.next()?;
            match kind {
                kind::ENDEL => break,
                kind::ENDLIB | kind::ENDSTR | kind::BGNSTR => {
                    return Err(format!("an element without an end at byte {at}"));
                }
                _ => draft.take(kind, data, begun, at)?,
            }
        }
        draft.finish(begun, at)
    }
}

impl Draft {
    /// Takes one record of an element.
    fn take(&mut self, kind: u16, data: &[u8], begun: u16, at: u64) -> Result<(), String> {
        match kind {
            kind::LAYER => self.shape.layer = short(data),
            kind::DATATYPE | kind::BOXTYPE => self.shape.data_type = short(data),
            kind::SNAME => self.name = trimmed(data).to_vec(),
            kind::COLROW => {
                let (columns, rows) = data.split_at_checked(2).unwrap_or_default();
                self.counts = Some([short(columns), short(rows)].map(i64::from));
            }
            kind::XY => self.shape.corners = corners(data),
            kind::STRANS if begun != kind::TEXT && data.iter().any(|byte| *byte != 0) => {
                return Err(format!("a mirrored reference at byte {at}"));
            }
            kind::MAG | kind::ANGLE if begun != kind::TEXT => {
                let plain = if kind == kind::MAG { 1.0 } else { 0.0 };
                if real(data) != plain {
                    return Err(format!("a turned or scaled reference at byte {at}"));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The element that ends here.
    fn finish(self, begun: u16, at: u64) -> Result<Element, String> {
        match begun {
            kind::BOUNDARY | kind::BOX => Ok(Element::Shape(self.shape)),
            kind::SREF | kind::AREF => self.reference(begun, at),
            _ => Ok(Element::Other),
        }
    }

    fn reference(self, begun: u16, at: u64) -> Result<Element, String> {
        let broken = || format!("an array of references without a grid along x and y at byte {at}");
        let wide = |[x, y]: [i32; 2]| [i64::from(x), i64::from(y)];
        let mut places = self.shape.corners.into_iter().map(wide);
        let Some(origin) = places.next() else {
            return Err(format!("a reference without a place at byte {at}"));
        };
        let (mut counts, mut steps) = ([1; 2], [0; 2]);
        if begun == kind::AREF {
            let (Some([columns, rows]), Some([x, y0]), Some([x0, y])) =
                (self.counts, places.next(), places.next())
            else {
                return Err(broken());
            };
            let [width, height] = [x - origin[0], y - origin[1]];
            let on_axes = y0 == origin[1] && x0 == origin[0];
            let is_grid = columns > 0 && rows > 0 && width % columns == 0 && height % rows == 0;
            if !on_axes || !is_grid {
                return Err(broken());
            }
            counts = [columns, rows];
            steps = [width / columns, height / rows];
        }
        Ok(Element::Reference(Reference {
            name: self.name,
            origin,
            counts,
            steps,
        }))
    }
}

/// The first number of 16 bits; 0 where there is none.
pub(crate) fn short(data: &[u8]) -> u16 {
    data.first_chunk().map_or(0, |two| u16::from_be_bytes(*two))
}

/// The first real number; 0 where there is none.
pub(crate) fn real(data: &[u8]) -> f64 {
    data.first_chunk().map_or(0.0, |eight| number(*eight))
}

/// A name without the zeros behind it.
pub(crate) fn trimmed(data: &[u8]) -> &[u8] {
    let end = data.iter().rposition(|byte| *byte != 0);
    end.and_then(|end| data.get(..=end)).unwrap_or_default()
}

/// Points of 32 bits each.
fn corners(data: &[u8]) -> Vec<[i32; 2]> {
    let (points, _) = data.as_chunks::<8>();
    let point = |[a, b, c, d, e, f, g, h]: &[u8; 8]| {
        [
            i32::from_be_bytes([*a, *b, *c, *d]),
            i32::from_be_bytes([*e, *f, *g, *h]),
        ]
    };
    points.iter().map(point).collect()
}
