//! Grey pictures (.tif) as maps. Whole numbers are taken as they are stored; the first row is the top of the picture.

use std::io::BufReader;
use std::path::Path;

use ndarray::Array2;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::maps::measured_map::MeasuredMap;

/// The most bytes that a byte of a packed file can become.
pub(crate) const MOST_UNPACKED: u64 = 2000;

/// The longest value of a tag in bytes: offsets of strips.
const LONGEST_TAG: usize = 16 << 20;

/// A picture that is open to be read.
type Picture = Decoder<BufReader<std::fs::File>>;

/// Reads a grey picture of 8, 16, 32 or 64 bits.
///
/// # Errors
/// A file that cannot be read, a picture of another kind, or one that does not fit into the limit.
pub(crate) fn read_tiff(path: &Path, limit: MemoryLimit) -> Result<MeasuredMap, Fault> {
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let file = regular_file::open(path)
        .map_err(|found| refuse((found, String::from("a TIFF picture that can be read"))))?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let mut picture = Decoder::new(BufReader::new(file))
        .map_err(words)
        .map_err(refuse)?;
    let size = checked_size(&mut picture, length, limit).map_err(refuse)?;
    let several = picture.more_images();
    let values = samples(picture, size).map_err(refuse)?;
    let mut map = MeasuredMap::of(Array::Real(values));
    if several {
        let doubt = "several pictures, of which the first was read";
        map.doubts.push(String::from(doubt));
    }
    Ok(map)
}

/// Columns and rows, of a picture that is grey and fits into the limit.
fn checked_size(
    picture: &mut Picture,
    length: u64,
    limit: MemoryLimit,
) -> Result<[usize; 2], (String, String)> {
    let (nx, ny) = picture.dimensions().map_err(words)?;
    let kind = picture.colortype().map_err(words)?;
    let ColorType::Gray(bits @ (8 | 16 | 32 | 64)) = kind else {
        let expected = "a grey picture of 8, 16, 32 or 64 bits";
        return Err((format!("a picture of kind {kind:?}"), expected.to_owned()));
    };

    // Tags that would turn or invert the values.
    for (tag, usual, what) in [
        (Tag::PhotometricInterpretation, 1, "black at zero"),
        (
            Tag::Orientation,
            1,
            "the first row at the top, the first column at the left",
        ),
    ] {
        let found: Option<u32> = picture.find_tag_unsigned(tag).map_err(words)?;
        if let Some(found) = found.filter(|found| *found != usual) {
            return Err((format!("{tag:?} {found}"), format!("{usual}: {what}")));
        }
    }
    let samples = u64::from(nx) * u64::from(ny);
    let bytes = samples.saturating_mul(u64::from(bits) / 8);
    if samples == 0 || bytes > length.saturating_mul(MOST_UNPACKED) {
        let found = format!("{nx} x {ny} samples in a file of {length} bytes");
        return Err((found, String::from("as many as it can hold")));
    }
    limit.check(
        format!("{ny} x {nx} samples"),
        samples.saturating_mul(8).saturating_add(bytes),
    )?;
    Ok([nx as usize, ny as usize])
}

/// The samples [y, x]; the top row of the file comes last.
fn samples(picture: Picture, [nx, ny]: [usize; 2]) -> Result<Array2<f64>, (String, String)> {
    let all = nx.saturating_mul(ny);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = all.saturating_mul(8).max(LONGEST_TAG);
    limits.intermediate_buffer_size = all.saturating_mul(8).saturating_add(1 << 20);
    limits.ifd_value_size = LONGEST_TAG;
    let mut picture = picture.with_limits(limits);
    let numbers: Vec<f64> = match picture.read_image().map_err(words)? {
        DecodingResult::U8(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::U16(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::U32(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::U64(stored) => stored.into_iter().map(|n| n as f64).collect(),
        DecodingResult::I8(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::I16(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::I32(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::I64(stored) => stored.into_iter().map(|n| n as f64).collect(),
        DecodingResult::F16(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::F32(stored) => stored.into_iter().map(f64::from).collect(),
        DecodingResult::F64(stored) => stored,
    };
    let found = format!("{} samples", numbers.len());
    let rows = Array2::from_shape_vec((ny, nx), numbers);
    let mut rows = rows.map_err(|_| (found, format!("{ny} x {nx}")))?;
    rows.invert_axis(ndarray::Axis(0));
    Ok(rows.as_standard_layout().into_owned())
}

fn words(error: TiffError) -> (String, String) {
    (error.to_string(), String::from("a TIFF picture"))
}
