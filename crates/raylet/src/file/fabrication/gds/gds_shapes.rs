//! For tests: all polygons of a GDSII file, those of arrays at each of their places.

use std::collections::BTreeMap;
use std::io::Cursor;

use crate::file::fabrication::gds::gds_elements::{Element, Records, Shape, trimmed};
use crate::file::fabrication::gds::gds_record::kind;

/// A polygon: its layer, its data type, and its corners without the first one again.
pub(crate) type Drawn = (u16, u16, Vec<[i64; 2]>);

/// The polygons of the last structure of a file, which may refer to the one before, in an order of their own.
pub(crate) fn gds_shapes(bytes: &[u8]) -> Vec<Drawn> {
    let mut records = Records::new(Cursor::new(bytes));
    let mut structures: BTreeMap<Vec<u8>, Vec<Drawn>> = BTreeMap::new();
    let mut last = Vec::new();
    loop {
        let (kind, data) = records.next().unwrap();
        if kind == kind::ENDLIB {
            break;
        }
        if kind != kind::STRNAME {
            continue;
        }
        let name = trimmed(data).to_vec();
        last = structure(&mut records, &structures);
        structures.insert(name, last.clone());
    }
    last.sort();
    last
}

fn structure(
    records: &mut Records<Cursor<&[u8]>>,
    others: &BTreeMap<Vec<u8>, Vec<Drawn>>,
) -> Vec<Drawn> {
    let mut shapes = Vec::new();
    loop {
        match records.element().unwrap() {
            Element::Shape(shape) => shapes.push(drawn(&shape)),
            Element::Reference(one) => {
                for row in 0..one.counts[1] {
                    for column in 0..one.counts[0] {
                        let [x, y] = one.origin;
                        let at = [x + column * one.steps[0], y + row * one.steps[1]];
                        shapes.extend(others[&one.name].iter().map(|shape| moved(shape, at)));
                    }
                }
            }
            Element::Other => {}
            Element::End => return shapes,
        }
    }
}

fn drawn(shape: &Shape) -> Drawn {
    let count = shape.corners.len() - 1;
    let corners = shape.corners[..count].iter();
    let corners = corners.map(|at| at.map(i64::from)).collect();
    (shape.layer, shape.data_type, corners)
}

/// A polygon at another place.
pub(crate) fn moved((layer, data_type, corners): &Drawn, [dx, dy]: [i64; 2]) -> Drawn {
    let corners = corners.iter().map(|[x, y]| [x + dx, y + dy]).collect();
    (*layer, *data_type, corners)
}
