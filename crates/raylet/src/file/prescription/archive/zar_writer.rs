//! Archives that tests write: the two known kinds of blocks, and an encoder that knows its words by their bytes.

use std::collections::HashMap;

/// The compression of a text, as archives have it.
pub(crate) fn packed(text: &[u8]) -> Vec<u8> {
    let mut words: HashMap<Vec<u8>, usize> = (0..=255u8)
        .map(|byte| (vec![byte], usize::from(byte)))
        .collect();
    let (mut codes, mut word) = (Vec::new(), Vec::new());
    for byte in text {
        let mut longer = word.clone();
        longer.push(*byte);
        if words.contains_key(&longer) {
            word = longer;
            continue;
        }
        codes.push(words[&word]);
        words.insert(longer, words.len());
        word = vec![*byte];
    }
    if !word.is_empty() {
        codes.push(words[&word]);
    }
    bytes_of(&codes)
}

/// The compression of n(n + 1)/2 times the same byte by n codes, each of a word that is one byte longer than the last.
pub(crate) fn packed_run(n: usize) -> Vec<u8> {
    let longer = (0..n.saturating_sub(1)).map(|i| 256 + i);
    bytes_of(&[vec![usize::from(b'0')], longer.collect()].concat())
}

/// Codes of growing length, from the highest bit of the first byte.
fn bytes_of(codes: &[usize]) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    for (sent, code) in codes.iter().enumerate() {
        // The reader knows one word fewer than there are codes before this one.
        let width = (256 + sent.saturating_sub(1)).ilog2() + 1;
        bits.extend((0..width).rev().map(|bit| code >> bit & 1 == 1));
    }
    let byte = |bits: &[bool]| {
        let bits = bits.iter().enumerate();
        bits.fold(0u8, |byte, (place, bit)| {
            byte | u8::from(*bit) << (7 - place)
        })
    };
    bits.chunks(8).map(byte).collect()
}

/// A block of version 1002 or 1004 with a file, compressed where its name says so.
pub(crate) fn block(version: u32, name: &str, content: &[u8]) -> Vec<u8> {
    match name.to_ascii_uppercase().ends_with(".LZW") {
        true => block_of(version, name, &packed(content), content.len()),
        false => block_of(version, name, content, content.len()),
    }
}

/// A block with these bytes of a file, which states a length of the file.
pub(crate) fn block_of(version: u32, name: &str, data: &[u8], length: usize) -> Vec<u8> {
    let compressed = name.to_ascii_uppercase().ends_with(".LZW");
    let mut bytes = vec![0; if version == 1002 { 332 } else { 648 }];
    let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
    put(0, &version.to_le_bytes());
    put(8, &u32::from(compressed).to_le_bytes());
    if version == 1002 {
        put(12, &(data.len() as u32).to_le_bytes());
        put(32, name.as_bytes());
    } else {
        put(16, &(data.len() as u64).to_le_bytes());
        put(24, &(length as u64).to_le_bytes());
        let name: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
        put(48, &name);
    }
    bytes.extend(data);
    bytes
}
