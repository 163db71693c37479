//! Plain pictures: reading and writing PNG, and changing their number of pixels.
//!
//! Arrays are indexed [y, x] with row 0 at the smallest y, so the first row of a file, which is
//! its top, becomes the last row of the array.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use ndarray::{Array2, ArrayView2, Axis, Zip};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;

/// Largest number of pixels read or written: 100 million.
pub(crate) const PIXEL_LIMIT: u64 = 100_000_000;

/// Why a picture could not be read or written; each message starts with the file's path.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file could not be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file concerned.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file is not regular, or cannot be opened.
    #[error("{}: {found}", path.display())]
    Unreadable {
        /// The file concerned.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// The picture takes more memory than allowed.
    #[error("{}: found {found}, expected {expected}", path.display())]
    Memory {
        /// The file concerned.
        path: PathBuf,
        /// How much it takes.
        found: String,
        /// How much is allowed.
        expected: String,
    },
    /// The file is not a PNG.
    #[error("{}: expected a PNG image, found {found}", path.display())]
    NotPng {
        /// The file concerned.
        path: PathBuf,
        /// What the first bytes look like.
        found: &'static str,
    },
    /// The picture has more pixels than `PIXEL_LIMIT`.
    #[error("{}: expected at most {PIXEL_LIMIT} pixels, found {width} x {height}", path.display())]
    TooLarge {
        /// The file concerned.
        path: PathBuf,
        /// Pixels across.
        width: u64,
        /// Pixels down.
        height: u64,
    },
    /// The PNG is damaged or uses something the decoder does not know.
    #[error("{}: expected a readable PNG image, found: {source}", path.display())]
    Decode {
        /// The file concerned.
        path: PathBuf,
        /// The error of the decoder.
        source: png::DecodingError,
    },
    /// The picture could not be written as PNG.
    #[error("{}: the PNG image could not be written: {source}", path.display())]
    Encode {
        /// The file concerned.
        path: PathBuf,
        /// The error of the encoder.
        source: png::EncodingError,
    },
    /// The values cannot be mapped to grey levels.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Values {
        /// The file concerned.
        path: PathBuf,
        /// What would have been accepted.
        expected: &'static str,
        /// What was given.
        found: String,
    },
}

/// Reads a PNG (8 or 16 bit; grey, RGB or palette, with or without alpha) as grey values 0..=1.
///
/// The result is indexed [y, x] with y upwards. Stored values are taken as they are, without
/// undoing a display gamma; colours become the Rec. 709 luma 0.2126 R + 0.7152 G + 0.0722 B of
/// the stored values; what is transparent is dark (the value times alpha). Of an animation the
/// first frame is read. Errors name the file; pictures over `PIXEL_LIMIT`, and those which take more
/// than the limit on memory while they are read, are refused before memory is taken for them.
pub fn read_gray(path: impl AsRef<Path>, limit: MemoryLimit) -> Result<Array2<f64>, ImageError> {
    let path = path.as_ref();
    let io = |source| ImageError::Io {
        path: path.into(),
        source,
    };
    let decode = |source| ImageError::Decode {
        path: path.into(),
        source,
    };

    // Look at the first bytes: another format deserves its name in the message.
    let file = regular_file::open(path).map_err(|found| ImageError::Unreadable {
        path: path.into(),
        found,
    })?;
    let mut file = BufReader::new(file);
    let mut magic = Vec::with_capacity(12);
    file.by_ref().take(12).read_to_end(&mut magic).map_err(io)?;
    if let Some(found) = foreign_format(&magic) {
        let path = path.into();
        return Err(ImageError::NotPng { path, found });
    }
    file.rewind().map_err(io)?;

    // The header comes before the pixels, so the size is known before memory is taken.
    let most = usize::try_from(limit.bytes).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(file, png::Limits { bytes: most });
    let header = decoder.read_header_info().map_err(decode)?;
    let (width, height) = (header.width, header.height);
    refuse_large(path, width.into(), height.into())?;

    // Palettes, low bit depths and transparency keys are expanded to plain channels.
    decoder.set_transformations(png::Transformations::EXPAND);
    // Texts and colour profiles, which may be packed and large, are not read.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(decode)?;
    let size = reader.output_buffer_size();
    let size = size.ok_or_else(|| decode(png::DecodingError::LimitsExceeded))?;
    let values = 8 * u64::from(width) * u64::from(height);
    let taken = values.saturating_add(size as u64);
    let what = format!("{width} x {height} pixels");
    limit
        .check(what, taken)
        .map_err(|(found, expected)| ImageError::Memory {
            path: path.into(),
            found,
            expected,
        })?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(decode)?;

    Ok(gray_values(&frame, &bytes))
}

/// Decoded bytes as grey values [y, x] with y upwards.
fn gray_values(frame: &png::OutputInfo, bytes: &[u8]) -> Array2<f64> {
    let channels = frame.color_type.samples();
    let wide = frame.bit_depth == png::BitDepth::Sixteen;
    // The decoder has filled all bytes; one that were not there would be black.
    let byte = |row: usize, i: usize| {
        let found = bytes.get(row * frame.line_size + i);
        found.copied().unwrap_or_default()
    };
    let sample = |row: usize, i: usize| match wide {
        true => f64::from(u16::from_be_bytes([2 * i, 2 * i + 1].map(|i| byte(row, i)))) / 65535.0,
        false => f64::from(byte(row, i)) / 255.0,
    };

    // The file's rows run downwards, ours upwards.
    let (nx, ny) = (frame.width as usize, frame.height as usize);
    Array2::from_shape_fn((ny, nx), |(y, x)| {
        let c = |k| sample(ny - 1 - y, x * channels + k);
        match channels {
            1 => c(0),
            2 => c(0) * c(1),
            3 => luma(c(0), c(1), c(2)),
            _ => luma(c(0), c(1), c(2)) * c(3),
        }
    })
}

/// Rec. 709 luma of three colour values.
fn luma(r: f64, g: f64, b: f64) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The name of what a file that is not a PNG starts with; `None` for a PNG.
fn foreign_format(magic: &[u8]) -> Option<&'static str> {
    let known: [(&[u8], &str); 9] = [
        (b"\xff\xd8\xff", "a JPEG image"),
        (b"GIF8", "a GIF image"),
        (b"BM", "a BMP image"),
        (b"II*\0", "a TIFF image"),
        (b"MM\0*", "a TIFF image"),
        (b"RIFF", "a WebP image or another RIFF file"),
        (b"\x93NUMPY", "a NumPy array"),
        (b"%PDF", "a PDF document"),
        (b"<", "an SVG, XML or HTML text"),
    ];
    let named = || known.iter().find(|(start, _)| magic.starts_with(start));
    match magic {
        [] => Some("an empty file"),
        m if m.starts_with(b"\x89PNG\r\n\x1a\n") => None,
        _ => Some(named().map_or("an unknown format", |(_, name)| name)),
    }
}

/// Holds the limit on pixels.
fn refuse_large(path: &Path, width: u64, height: u64) -> Result<(), ImageError> {
    if width.saturating_mul(height) <= PIXEL_LIMIT {
        return Ok(());
    }
    let path = path.into();
    Err(ImageError::TooLarge {
        path,
        width,
        height,
    })
}

/// Writes values [y, x] as a 16-bit grey PNG, `black` as 0 and `white` as 65535.
///
/// Values between are mapped linearly and rounded, values outside are clipped; row 0 becomes
/// the bottom of the picture. Non-finite values and an empty range are errors.
pub fn write_gray16(
    path: impl AsRef<Path>,
    values: ArrayView2<f64>,
    [black, white]: [f64; 2],
) -> Result<(), ImageError> {
    // Refuse what has no grey level.
    let path = path.as_ref();
    let refuse = |expected, found| ImageError::Values {
        path: path.into(),
        expected,
        found,
    };
    let (ny, nx) = values.dim();
    let lost = values.iter().filter(|v| !v.is_finite()).count();
    refuse_large(path, nx as u64, ny as u64)?;
    if nx == 0 || ny == 0 {
        return Err(refuse("at least one pixel", format!("{nx} x {ny}")));
    }
    if lost > 0 {
        return Err(refuse("finite values", format!("{lost} that are not")));
    }
    let span = white - black;
    if !(span.is_finite() && span != 0.0) {
        let found = format!("[{black}, {white}]");
        return Err(refuse(
            "two different finite values for black and white",
            found,
        ));
    }

    // Top row first, two bytes a pixel, the high one first.
    let mut bytes = Vec::with_capacity(2 * nx * ny);
    for row in values.axis_iter(Axis(0)).rev() {
        for &value in row {
            let level = ((value - black) / span * 65535.0).round() as u16;
            bytes.extend_from_slice(&level.to_be_bytes());
        }
    }
    let file = File::create(path).map_err(|source| ImageError::Io {
        path: path.into(),
        source,
    })?;
    let format = PixelFormat {
        color: png::ColorType::Grayscale,
        depth: png::BitDepth::Sixteen,
    };
    encode(BufWriter::new(file), [nx, ny], format, &bytes).map_err(|source| ImageError::Encode {
        path: path.into(),
        source,
    })
}

/// An 8-bit RGB PNG in memory; `bytes` are rows from the top, three a pixel.
///
/// # Errors
/// A size of zero, or bytes that are not three for each pixel.
pub fn encode_rgb(size: [usize; 2], bytes: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let format = PixelFormat {
        color: png::ColorType::Rgb,
        depth: png::BitDepth::Eight,
    };
    encode(&mut out, size, format, bytes).map(|()| out)
}

/// What a pixel of a PNG holds.
#[derive(Clone, Copy)]
struct PixelFormat {
    /// Its channels.
    color: png::ColorType,
    /// Bits of one channel.
    depth: png::BitDepth,
}

/// Writes one PNG of the given [across, down] size.
fn encode(
    out: impl Write,
    [nx, ny]: [usize; 2],
    format: PixelFormat,
    bytes: &[u8],
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, nx as u32, ny as u32);
    encoder.set_color(format.color);
    encoder.set_depth(format.depth);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

/// The picture on another grid over the same extent, by area averaging.
///
/// Each new pixel is the mean of the old picture, taken as constant over each old pixel, over
/// the new pixel's area: the overall mean is kept exactly, shrinking does not alias, and
/// enlarging repeats pixels. `shape` is [ny, nx]; an empty picture or shape gives zeros.
pub fn area_mean(values: ArrayView2<f64>, shape: [usize; 2]) -> Array2<f64> {
    area_mean_of(values, shape, &|value| value)
}

/// [`area_mean`] of `function` of the values, without a copy of the picture; the result is `[ny, nx]`.
pub fn area_mean_of(
    values: ArrayView2<f64>,
    [ny, nx]: [usize; 2],
    function: &dyn Fn(f64) -> f64,
) -> Array2<f64> {
    if values.is_empty() {
        return Array2::zeros((ny, nx));
    }
    let flattened = resize_rows(values, ny, function);
    let narrowed = resize_rows(flattened.view().reversed_axes(), nx, &|value| value);
    narrowed.reversed_axes().as_standard_layout().into_owned()
}

/// Area averaging of a function of the values along the first axis alone.
fn resize_rows(values: ArrayView2<f64>, new: usize, function: &dyn Fn(f64) -> f64) -> Array2<f64> {
    let (old, width) = values.dim();
    let mut out = Array2::zeros((new, width));
    let ratio = old as f64 / new as f64;
    for (j, mut row) in out.axis_iter_mut(Axis(0)).enumerate() {
        // The new row covers old rows from `from` to `to`, the outer ones in part.
        let (from, to) = (j as f64 * ratio, (j + 1) as f64 * ratio);
        let last = (to.ceil() as usize).min(old);
        for i in (from as usize).min(old - 1)..last {
            let weight = (to.min((i + 1) as f64) - from.max(i as f64)).max(0.0) / ratio;
            Zip::from(&mut row)
                .and(values.row(i))
                .for_each(|sum, v| *sum += weight * function(*v));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use crate::file::arrays::image::{
        ImageError, PixelFormat, area_mean, encode, read_gray, write_gray16,
    };
    use crate::file::arrays::memory::MemoryLimit;

    const LIMIT: MemoryLimit = MemoryLimit {
        bytes: 1_000_000,
        set_by: "settings.memory_limit_mb",
    };

    const GRAY: PixelFormat = PixelFormat {
        color: png::ColorType::Grayscale,
        depth: png::BitDepth::Eight,
    };

    const RGBA: PixelFormat = PixelFormat {
        color: png::ColorType::Rgba,
        depth: png::BitDepth::Eight,
    };

    /// A PNG of the given kind in a temporary file.
    fn png_file(size: [usize; 2], format: PixelFormat, bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        encode(file.as_file(), size, format, bytes).unwrap();
        file
    }

    #[test]
    fn sixteen_bits_survive_the_round_trip() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let values = Array2::from_shape_fn((5, 7), |(y, x)| (y * 7 + x) as f64 * 1873.0 / 65535.0);
        write_gray16(file.path(), values.view(), [0.0, 1.0]).unwrap();
        let back = read_gray(file.path(), LIMIT).unwrap();
        assert!((&back - &values).iter().all(|d| d.abs() < 1e-15));
    }

    #[test]
    fn the_top_of_the_file_is_plus_y() {
        let file = png_file([2, 2], GRAY, &[255, 0, 51, 102]);
        let back = read_gray(file.path(), LIMIT).unwrap();
        assert_eq!(back, array![[0.2, 0.4], [1.0, 0.0]]);
    }

    #[test]
    fn colour_becomes_luma_and_transparency_dark() {
        let pixels = [0, 255, 0, 255, 255, 255, 255, 0, 255, 0, 0, 51];
        let file = png_file([3, 1], RGBA, &pixels);
        let back = read_gray(file.path(), LIMIT).unwrap();
        let want = array![[0.7152, 0.0, 0.2126 * 0.2]];
        assert!((&back - &want).iter().all(|d| d.abs() < 1e-15), "{back}");
    }

    #[test]
    fn a_palette_is_looked_up() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::One);
        encoder.set_palette(vec![51, 51, 51, 255, 255, 255]);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[0b0100_0000]).unwrap();
        writer.finish().unwrap();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        let back = read_gray(file.path(), LIMIT).unwrap();
        assert!((back[[0, 0]] - 0.2).abs() < 1e-15 && (back[[0, 1]] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn errors_name_the_file_and_what_was_found() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let name = file.path().to_str().unwrap();
        std::fs::write(file.path(), b"\xff\xd8\xff\xe0rest").unwrap();
        let message = read_gray(file.path(), LIMIT).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("{name}: expected a PNG image, found a JPEG image")
        );
        let nan = array![[f64::NAN, 1.0]];
        let message = write_gray16(file.path(), nan.view(), [0.0, 1.0]).unwrap_err();
        let want = format!("{name}: expected finite values, found 1 that are not");
        assert_eq!(message.to_string(), want);
    }

    #[test]
    fn a_huge_header_is_refused_and_a_cut_file_is_an_error() {
        // A valid header that promises 2^31 - 1 pixels squared, with nothing behind it.
        let small = png_file([3, 3], GRAY, &[7; 9]);
        let bytes = std::fs::read(small.path()).unwrap();
        let mut huge = bytes.clone();
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        let crc = crc32(&huge[12..29]).to_be_bytes();
        huge[29..33].copy_from_slice(&crc);
        std::fs::write(small.path(), &huge).unwrap();
        let error = read_gray(small.path(), LIMIT).unwrap_err();
        assert!(matches!(error, ImageError::TooLarge { .. }), "{error}");

        // A file cut short is damaged, not empty.
        std::fs::write(small.path(), &bytes[..bytes.len() - 20]).unwrap();
        let error = read_gray(small.path(), LIMIT).unwrap_err();
        assert!(matches!(error, ImageError::Decode { .. }), "{error}");
    }

    /// 10,000² pixels in 16-bit RGBA, which once took 1.58 GB whatever the limit; the pixels behind the header
    /// are missing here.
    #[test]
    fn a_picture_beyond_the_limit_is_refused_by_its_header() {
        let wide = PixelFormat {
            depth: png::BitDepth::Sixteen,
            ..RGBA
        };
        let file = png_file([1, 1], wide, &[0; 8]);
        let mut bytes = std::fs::read(file.path()).unwrap();
        for place in [16, 20] {
            bytes[place..place + 4].copy_from_slice(&10_000u32.to_be_bytes());
        }
        let crc = crc32(&bytes[12..29]).to_be_bytes();
        bytes[29..33].copy_from_slice(&crc);
        std::fs::write(file.path(), &bytes).unwrap();
        let limit = MemoryLimit::of_settings(100_000_000);
        let message = read_gray(file.path(), limit).unwrap_err().to_string();
        for words in [
            "10000 x 10000",
            "take 1600 MB",
            "at most 100 MB",
            "memory_limit_mb",
        ] {
            assert!(message.contains(words), "{message}");
        }
    }

    /// The checksum of PNG chunks, bit by bit.
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |c: u32| (c >> 1) ^ (0xedb8_8320 * (c & 1));
        let byte = |c: u32, b: &u8| (0..8).fold(c ^ u32::from(*b), |c, _| step(c));
        !bytes.iter().fold(u32::MAX, byte)
    }

    #[test]
    fn resizing_keeps_the_mean_and_repeats_pixels() {
        let values = Array2::from_shape_fn((6, 9), |(y, x)| ((3 * y + 5 * x) % 7) as f64);
        for shape in [[6, 9], [3, 3], [4, 5], [13, 2], [60, 90]] {
            let mean = area_mean(values.view(), shape).mean().unwrap();
            assert!((mean - values.mean().unwrap()).abs() < 1e-13, "{shape:?}");
        }
        assert_eq!(area_mean(values.view(), [6, 9]), values);
        let large = area_mean(array![[1.0, 2.0], [3.0, 4.0]].view(), [4, 4]);
        assert_eq!(large.row(1), array![1.0, 1.0, 2.0, 2.0]);
        assert_eq!(large.row(2), array![3.0, 3.0, 4.0, 4.0]);
    }
}
