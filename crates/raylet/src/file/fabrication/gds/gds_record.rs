//! Records of a GDSII file: a length, a kind, a type of data, and the data, with the highest byte first.
//!
//! raylet writes them itself, because crates that write GDSII hold a whole library: gds21 takes 180 bytes of memory for each
//! rectangle, a gigabyte for ten million cells.

use std::io::{self, Write};

/// Kinds of records that are written or read, with their type of data in the low byte.
pub(crate) mod kind {
    pub(crate) const HEADER: u16 = 0x0002;
    pub(crate) const BGNLIB: u16 = 0x0102;
    pub(crate) const LIBNAME: u16 = 0x0206;
    pub(crate) const UNITS: u16 = 0x0305;
    pub(crate) const ENDLIB: u16 = 0x0400;
    pub(crate) const BGNSTR: u16 = 0x0502;
    pub(crate) const STRNAME: u16 = 0x0606;
    pub(crate) const ENDSTR: u16 = 0x0700;
    pub(crate) const BOUNDARY: u16 = 0x0800;
    pub(crate) const PATH: u16 = 0x0900;
    pub(crate) const SREF: u16 = 0x0A00;
    pub(crate) const AREF: u16 = 0x0B00;
    pub(crate) const TEXT: u16 = 0x0C00;
    pub(crate) const LAYER: u16 = 0x0D02;
    pub(crate) const DATATYPE: u16 = 0x0E02;
    pub(crate) const XY: u16 = 0x1003;
    pub(crate) const ENDEL: u16 = 0x1100;
    pub(crate) const SNAME: u16 = 0x1206;
    pub(crate) const COLROW: u16 = 0x1302;
    pub(crate) const NODE: u16 = 0x1500;
    pub(crate) const STRANS: u16 = 0x1A01;
    pub(crate) const MAG: u16 = 0x1B05;
    pub(crate) const ANGLE: u16 = 0x1C05;
    pub(crate) const BOX: u16 = 0x2D00;
    pub(crate) const BOXTYPE: u16 = 0x2E02;
}

/// Writes one record.
///
/// # Errors
/// Data too long for a record, or an error of the file system.
pub(crate) fn write_record(out: &mut impl Write, kind: u16, data: &[u8]) -> io::Result<()> {
    let length = u16::try_from(data.len() + 4).map_err(io::Error::other)?;
    out.write_all(&length.to_be_bytes())?;
    out.write_all(&kind.to_be_bytes())?;
    out.write_all(data)
}

/// Whole numbers of 16 bits.
pub(crate) fn shorts(numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_be_bytes()).collect()
}

/// Whole numbers of 32 bits.
pub(crate) fn longs(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_be_bytes()).collect()
}

/// A text, with a zero behind it where its length is odd.
pub(crate) fn text(text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    if !bytes.len().is_multiple_of(2) {
        bytes.push(0);
    }
    bytes
}

/// A real number: a sign, an exponent of 16 with an excess of 64 in 7 bits, and a fraction in 56 bits. Numbers out of range
/// become the nearest one in range.
pub(crate) fn real(value: f64) -> [u8; 8] {
    if value == 0.0 || value.is_nan() {
        return [0; 8];
    }
    let sign = if value < 0.0 { 1_u64 << 63 } else { 0 };
    let mut fraction = value.abs();
    let mut exponent = 64_i32;
    // Powers of 16 are exact.
    while fraction >= 1.0 && exponent < 127 {
        fraction /= 16.0;
        exponent += 1;
    }
    while fraction < 0.0625 && exponent > 0 {
        fraction *= 16.0;
        exponent -= 1;
    }
    let all = 1_u64 << 56;
    let bits = ((fraction * all as f64) as u64).min(all - 1);
    (sign | ((exponent as u64) << 56) | bits).to_be_bytes()
}

/// The number of eight such bytes.
pub(crate) fn number(bytes: [u8; 8]) -> f64 {
    let bits = u64::from_be_bytes(bytes);
    let exponent = ((bits >> 56) & 0x7f) as i32 - 64;
    let fraction = (bits & ((1 << 56) - 1)) as f64 / (1_u64 << 56) as f64;
    let size = fraction * 16_f64.powi(exponent);
    if bits >> 63 == 1 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::gds::gds_record::{
        kind, longs, number, real, shorts, text, write_record,
    };

    #[test]
    fn reals_are_excess_64() {
        // By hand: 1 = 16¹ · 1/16, −2 = −16¹ · 2/16, 0.001 and 1e-9 as the usual files have them.
        for (value, bytes) in [
            (0.0, [0; 8]),
            (1.0, [0x41, 0x10, 0, 0, 0, 0, 0, 0]),
            (-2.0, [0xC1, 0x20, 0, 0, 0, 0, 0, 0]),
            (0.5, [0x40, 0x80, 0, 0, 0, 0, 0, 0]),
            (16.0, [0x42, 0x10, 0, 0, 0, 0, 0, 0]),
        ] {
            assert_eq!(real(value), bytes, "{value}");
        }
        assert_eq!(real(1e-3)[..7], [0x3E, 0x41, 0x89, 0x37, 0x4B, 0xC6, 0xA7]);
        assert_eq!(real(1e-9)[..7], [0x39, 0x44, 0xB8, 0x2F, 0xA0, 0x9B, 0x5A]);
        for value in [1e-3, 1e-9, 5e-10, 1.0 / 3.0, -123_456.789, 7e70, 2.5e-70] {
            // A double has 53 bits, a fraction between 53 and 56: nothing is lost.
            assert_eq!(number(real(value)), value);
        }
        assert!(number(real(1e90)) > 7e75 && number(real(f64::INFINITY)) > 7e75);
    }

    #[test]
    fn the_highest_byte_comes_first() {
        let mut out = Vec::new();
        write_record(&mut out, kind::LAYER, &shorts(&[258])).unwrap();
        write_record(&mut out, kind::XY, &longs(&[-2, 65_536])).unwrap();
        write_record(&mut out, kind::STRNAME, &text("ABC")).unwrap();
        write_record(&mut out, kind::ENDEL, &[]).unwrap();
        let expected = [
            &[0, 6, 0x0D, 0x02, 1, 2][..],
            &[0, 12, 0x10, 0x03, 255, 255, 255, 254, 0, 1, 0, 0],
            &[0, 8, 0x06, 0x06, 65, 66, 67, 0],
            &[0, 4, 0x11, 0x00],
        ];
        assert_eq!(out, expected.concat());
        assert!(write_record(&mut out, kind::XY, &[0; 65_532]).is_err());
    }
}
