//! The compression of files in archives of OpticStudio: LZW whose codes grow from 9 bits without a limit.
//!
//! Codes stand from the highest bit of a byte down. The first 256 words are the bytes; every code after the first one adds a word,
//! and a code has as many bits as the number of words. There is no code that ends the text or forgets words, as GIF, TIFF and
//! `compress` have: readers of those formats do not fit.
//!
//! Welch, "A technique for high-performance data compression", Computer 17(6), 8 (1984).

/// Words of one byte.
const BYTES: usize = 256;

/// Codes of growing length, from the highest bit of the first byte.
struct Codes<'a> {
    bytes: std::slice::Iter<'a, u8>,
    /// Bits that were taken from the bytes and from no code yet, the lowest `waiting` of them.
    held: u64,
    waiting: u32,
}

impl Codes<'_> {
    /// The next code of so many bits, at most 56; none where fewer are left.
    fn next(&mut self, bits: u32) -> Option<usize> {
        while self.waiting < bits {
            self.held = (self.held << 8) | u64::from(*self.bytes.next()?);
            self.waiting += 8;
        }
        self.waiting -= bits;
        let code = self.held >> self.waiting;
        self.held &= (1 << self.waiting) - 1;
        usize::try_from(code).ok()
    }
}

/// The bytes that were packed.
///
/// # Errors
/// A code that stands for no word, or more than `most` bytes, as what was found and what was expected.
pub(crate) fn unpacked(packed: &[u8], most: usize) -> Result<Vec<u8>, (String, String)> {
    let mut codes = Codes {
        bytes: packed.iter(),
        held: 0,
        waiting: 0,
    };
    // Where each longer word stands in the text: its first byte, and how many it has.
    let mut words: Vec<[usize; 2]> = Vec::new();
    let (mut text, mut before) = (Vec::new(), None);
    while let Some(code) = codes.next((BYTES + words.len()).ilog2() + 1) {
        // The word before, with the first byte of the one that comes, is a new one; that byte may be its own first.
        words.extend(before.map(|[start, length]: [usize; 2]| [start, length + 1]));
        let start = text.len();
        if let Ok(byte) = u8::try_from(code) {
            text.push(byte);
        } else {
            let known = BYTES + words.len();
            let Some([from, length]) = words.get(code - BYTES).copied() else {
                let found = format!("code {code} behind {start} unpacked bytes");
                return Err((found, format!("a code below {known}")));
            };
            for place in from..from + length {
                text.extend(text.get(place).copied());
            }
        }
        if text.len() > most {
            let found = format!("a file that is unpacked to more than {most} bytes");
            return Err((found, "a shorter one".to_owned()));
        }
        before = Some([start, text.len() - start]);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::archive::lzw::unpacked;
    use crate::file::prescription::archive::zar_writer::packed;

    /// Codes by hand: 9 bits each as long as there are fewer than 512 words.
    #[test]
    fn codes_are_words_that_grow() {
        // A, B, AB (256), ABA (258, which is added at the same time), and its first two letters (257 is BA).
        let bits: String = [65, 66, 256, 258, 257]
            .iter()
            .map(|code| format!("{code:09b}"))
            .collect();
        let bytes: Vec<u8> = bits
            .as_bytes()
            .chunks(8)
            .map(|bits| {
                let bits = format!("{:0<8}", std::str::from_utf8(bits).unwrap());
                u8::from_str_radix(&bits, 2).unwrap()
            })
            .collect();
        assert_eq!(unpacked(&bytes, 100).unwrap(), b"ABABABABA");
        assert_eq!(unpacked(&[], 0).unwrap(), b"");
    }

    #[test]
    fn texts_come_back_through_an_encoder() {
        let mut text = Vec::new();
        let mut state = 1u32;
        for length in [0, 1, 2, 300, 700, 3000, 60_000] {
            while text.len() < length {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                text.push([b' ', b'0', b'1', (state >> 24) as u8][(state >> 20) as usize % 4]);
            }
            assert_eq!(unpacked(&packed(&text), length).unwrap(), text, "{length}");
        }
        // A run of one byte has the longest words; it may not become larger than is allowed.
        let run = packed(&vec![7; 1_000_000]);
        assert!(run.len() < 2300, "{}", run.len());
        assert_eq!(unpacked(&run, 1_000_000).unwrap().len(), 1_000_000);
        let (found, _) = unpacked(&run, 999_999).unwrap_err();
        assert!(found.contains("more than 999999 bytes"), "{found}");
    }

    #[test]
    fn codes_without_a_word_are_refused() {
        // 9 bits of ones: code 511, where 256 words are known.
        let (found, expected) = unpacked(&[0xff, 0xff], 10).unwrap_err();
        assert_eq!(found, "code 511 behind 0 unpacked bytes");
        assert_eq!(expected, "a code below 256");
    }
}
