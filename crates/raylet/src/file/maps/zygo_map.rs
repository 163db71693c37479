//! Height maps of Zygo's MetroPro (.dat). Numbers are big endian.
//!
//! | byte | what | as |
//! | --- | --- | --- |
//! | 0 | 0x881B036F, 0x881B0370 or 0x881B0371 | u32 |
//! | 6 | bytes of the header: 834, or 4096 with the last mark | u32 |
//! | 52, 54, 56 | columns, rows and number of the intensity pictures | u16 |
//! | 68, 70 | columns and rows of the heights | u16 |
//! | 164, 168, 176 | scale factor S, wavelength λ in m, obliquity factor O | f32 |
//! | 184 | distance of neighbouring samples in m, 0 where it is not known | f32 |
//! | 218 | resolution R: 0 is 4096, 1 is 32768, 2 is 131072 | u16 |
//! | 232 | sign | u16 |
//!
//! Behind the header stand the intensities, u16, and the heights, i32, in units of S O λ / R. Numbers from
//! 2147483640 on are missing samples. The first row is the top of the picture.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::maps::measured_map::MeasuredMap;

/// The marks at the start, with the bytes of the header behind them.
const MARKS: [(u32, u64); 3] = [(0x881B_036F, 834), (0x881B_0370, 834), (0x881B_0371, 4096)];

/// Bytes of the shortest header.
const SHORTEST: usize = 834;

/// The least number that means a missing sample.
const MISSING: i32 = 2_147_483_640;

/// What the header says.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Header {
    /// Byte at which the heights begin.
    data: u64,
    /// Columns and rows of the heights.
    size: [u16; 2],
    /// Metres of a unit of the heights.
    unit_m: f64,
    /// Distance of neighbouring samples in m; 0 where it is not known.
    pitch_m: f64,
    /// Whether heights may be inverted.
    sign: u16,
}

/// Reads the heights in m.
///
/// # Errors
/// A file that cannot be read, is no such map, is too short, or does not fit into the limit.
pub(crate) fn read_zygo(path: &Path, limit: MemoryLimit) -> Result<MeasuredMap, Fault> {
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let file = regular_file::open(path)
        .map_err(|found| refuse((found, String::from("a map of MetroPro (.dat)"))))?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let mut file = BufReader::new(file);
    let mut start = Vec::with_capacity(SHORTEST);
    let got = file.by_ref().take(SHORTEST as u64).read_to_end(&mut start);
    got.map_err(|error| refuse((error.to_string(), String::from("a header"))))?;
    let header = Header::parse(&start, length).map_err(refuse)?;
    let values = heights(&mut file, &header, limit).map_err(refuse)?;

    let mut map = MeasuredMap::of(Array::Real(values));
    map.unit = Some(String::from("m"));
    map.quantity = String::from("height");
    let pitch_um = header.pitch_m * 1e6;
    map.pitch_um = (pitch_um > 0.0).then_some([pitch_um; 2]);
    if header.sign != 0 {
        map.doubts.push(format!(
            "sign {} in byte 232: public readers disagree whether heights are inverted then",
            header.sign
        ));
    }
    Ok(map)
}

impl Header {
    /// The header of a file of this length.
    fn parse(start: &[u8], length: u64) -> Result<Self, (String, String)> {
        let mark = number::<4>(start, 0).map(u32::from_be_bytes);
        let known = MARKS.iter().find(|(known, _)| Some(*known) == mark);
        let Some((_, bytes)) = known else {
            let found = mark.map_or(String::from("an empty file"), |mark| {
                format!("{mark:#010x}")
            });
            let expected = "a map of MetroPro: 0x881B036F, 0x881B0370 or 0x881B0371 at byte 0";
            return Err((format!("{found} at byte 0"), expected.to_owned()));
        };
        if start.len() < SHORTEST {
            let found = format!("{} bytes", start.len());
            return Err((found, format!("a header of {SHORTEST} bytes")));
        }
        let whole = |at| number::<2>(start, at).map_or(0, u16::from_be_bytes);
        let real = |at| f64::from(number::<4>(start, at).map_or(0.0, f32::from_be_bytes));
        let said = u64::from(number::<4>(start, 6).map_or(0, u32::from_be_bytes));
        if said != *bytes {
            let found = format!("a header of {said} bytes in byte 6");
            return Err((found, format!("{bytes} with this mark")));
        }

        // The unit of the heights.
        let resolution = match whole(218) {
            0 => 4096.0,
            1 => 32768.0,
            2 => 131_072.0,
            other => {
                let found = format!("resolution {other} in byte 218");
                return Err((found, String::from("0, 1 or 2")));
            }
        };
        for (name, at, least) in [
            ("scale factor", 164, f64::NEG_INFINITY),
            ("wavelength in m", 168, 1e-12),
            ("obliquity factor", 176, f64::NEG_INFINITY),
            ("pitch in m", 184, 0.0),
        ] {
            if !(real(at) >= least && real(at).abs() < 1e9) {
                let found = format!("{name} {} in byte {at}", real(at));
                return Err((found, format!("a number of {least} and more, below 1e9")));
            }
        }
        let size = [whole(68), whole(70)];
        if size.contains(&0) {
            let found = format!("{} x {} heights in byte 68", size[0], size[1]);
            return Err((found, String::from("at least 1 x 1")));
        }
        Ok(Self {
            data: bytes + intensity_bytes([whole(52), whole(54), whole(56)], *bytes, size, length)?,
            size,
            unit_m: real(164) * real(176) * real(168) / resolution,
            pitch_m: real(184),
            sign: whole(232),
        })
    }
}

/// Bytes of the pictures of intensity before the heights. Files without a number of pictures may have one.
fn intensity_bytes(
    [nx, ny, count]: [u16; 3],
    header: u64,
    size: [u16; 2],
    length: u64,
) -> Result<u64, (String, String)> {
    let heights = 4 * u64::from(size[0]) * u64::from(size[1]);
    let picture = 2 * u64::from(nx) * u64::from(ny);
    let intensities = match count {
        0 if length == header + heights => 0,
        0 => picture,
        count => picture * u64::from(count),
    };
    let expected = header + intensities + heights;
    match length {
        length if length < expected => Err((
            format!("{length} bytes"),
            format!("{expected}: header, intensities and heights as the header says"),
        )),
        _ => Ok(intensities),
    }
}

/// The heights in m, [y, x]; the top row of the file comes last.
fn heights(
    file: &mut BufReader<File>,
    header: &Header,
    limit: MemoryLimit,
) -> Result<Array2<f64>, (String, String)> {
    let [nx, ny] = header.size.map(usize::from);
    limit.check(format!("{ny} x {nx} heights"), 8 * (nx * ny) as u64)?;
    let broken = |error: std::io::Error| (error.to_string(), String::from("all heights"));
    file.seek(SeekFrom::Start(header.data)).map_err(broken)?;
    let mut values = Array2::zeros((ny, nx));
    let mut bytes = vec![0; 4 * nx];
    for mut row in values.rows_mut().into_iter().rev() {
        file.read_exact(&mut bytes).map_err(broken)?;
        for (value, four) in row.iter_mut().zip(bytes.as_chunks::<4>().0) {
            let stored = i32::from_be_bytes(*four);
            *value = match stored {
                MISSING.. => f64::NAN,
                stored => f64::from(stored) * header.unit_m,
            };
        }
    }
    Ok(values)
}

/// The bytes of a number.
fn number<const N: usize>(start: &[u8], at: usize) -> Option<[u8; N]> {
    start.get(at..)?.first_chunk().copied()
}
