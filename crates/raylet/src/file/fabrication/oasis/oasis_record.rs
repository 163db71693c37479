//! Numbers and texts of an OASIS file: whole numbers have seven bits a byte, the lowest first.

/// Kinds of records.
pub(crate) mod kind {
    pub(crate) const START: u8 = 1;
    pub(crate) const END: u8 = 2;
    pub(crate) const CELL: u8 = 14;
    pub(crate) const XYRELATIVE: u8 = 16;
    pub(crate) const PLACEMENT: u8 = 17;
    pub(crate) const RECTANGLE: u8 = 20;
    pub(crate) const POLYGON: u8 = 21;
    pub(crate) const CBLOCK: u8 = 34;
}

/// Adds a whole number: the highest bit of a byte says that more follow.
pub(crate) fn unsigned(out: &mut Vec<u8>, mut value: u64) {
    while value > 0x7f {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Adds a whole number with its sign in the lowest bit.
pub(crate) fn signed(out: &mut Vec<u8>, value: i64) {
    unsigned(out, (value.unsigned_abs() << 1) | u64::from(value < 0));
}

/// Adds a step along x and y: the lowest bit says that both follow, the next is the sign of x.
pub(crate) fn step(out: &mut Vec<u8>, [x, y]: [i64; 2]) {
    unsigned(out, (x.unsigned_abs() << 2) | (u64::from(x < 0) << 1) | 1);
    signed(out, y);
}

/// Adds a positive real number: as a whole one if it is, or else in 64 bits.
pub(crate) fn real(out: &mut Vec<u8>, value: f64) {
    if value.fract() == 0.0 && (0.0..9e15).contains(&value) {
        out.push(0);
        unsigned(out, value as u64);
    } else {
        out.push(7);
        out.extend(value.to_le_bytes());
    }
}

/// Adds a text with its length.
pub(crate) fn text(out: &mut Vec<u8>, text: &str) {
    unsigned(out, text.len() as u64);
    out.extend(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::oasis::oasis_record::{real, signed, step, text, unsigned};

    fn made(write: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
        let mut out = Vec::new();
        write(&mut out);
        out
    }

    #[test]
    fn numbers_have_seven_bits_a_byte() {
        // By hand, after the tables of the format.
        assert_eq!(made(|out| unsigned(out, 0)), [0]);
        assert_eq!(made(|out| unsigned(out, 127)), [0x7f]);
        assert_eq!(made(|out| unsigned(out, 128)), [0x80, 0x01]);
        assert_eq!(made(|out| unsigned(out, 16_383)), [0xff, 0x7f]);
        assert_eq!(made(|out| signed(out, 1)), [0x02]);
        assert_eq!(made(|out| signed(out, -1)), [0x03]);
        assert_eq!(made(|out| signed(out, -64)), [0x81, 0x01]);
        assert_eq!(made(|out| step(out, [-3, 5])), [0x0f, 0x0a]);
        assert_eq!(made(|out| real(out, 1000.0)), [0, 0xe8, 0x07]);
        assert_eq!(
            made(|out| real(out, 0.5)),
            [7, 0, 0, 0, 0, 0, 0, 0xe0, 0x3f]
        );
        assert_eq!(made(|out| text(out, "AB")), [2, 65, 66]);
    }
}
