//! Beam files of Zemax (.zbf), read within a limit on memory.

use std::io::Read;
use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::beams::zbf_header::{BYTES, Header, SAMPLE, WHOLE};
use crate::file::decode::fault::Fault;

/// One component of a beam file as it stands there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beam {
    /// What stands before the samples.
    pub(crate) header: Header,
    /// The samples, [y, x]: the first one has the smallest x and y, and x runs faster.
    pub(crate) samples: Array2<Complex64>,
    /// Σ|E|² of the component that was not taken; 0 where there is none.
    pub(crate) other_power: f64,
}

/// Reads Ex, or Ey of a polarised file.
///
/// # Errors
/// A file that cannot be read, is not a beam file, is longer or shorter than its header says, or does not fit into
/// the limit; Ey of a file without it.
pub(crate) fn read_beam(path: &Path, second: bool, limit: MemoryLimit) -> Result<Beam, Fault> {
    let expected = "a beam file (.zbf) that can be read";
    let mut file =
        regular_file::open(path).map_err(|found| Fault::of_file(path, found, expected))?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    read_stream(&mut file, length, second, limit)
        .map_err(|(found, expected)| Fault::of_file(path, found, expected))
}

/// The same from the bytes of a file of this length. Refusals are (found, expected).
pub(crate) fn read_stream(
    mut file: impl Read,
    length: u64,
    second: bool,
    limit: MemoryLimit,
) -> Result<Beam, (String, String)> {
    let broken = |error: std::io::Error| (error.to_string(), String::from("samples to the end"));
    let mut start = Vec::with_capacity(BYTES);
    file.by_ref()
        .take(WHOLE as u64)
        .read_to_end(&mut start)
        .map_err(broken)?;

    // Samples of a file of version 0 may begin within the longest header.
    let mut rest = Vec::with_capacity(BYTES);
    file.by_ref()
        .take((BYTES - WHOLE) as u64)
        .read_to_end(&mut rest)
        .map_err(broken)?;
    start.extend(&rest);
    let header = Header::parse(&start, length)?;
    if second && !header.polarised {
        let found = String::from("a beam without polarisation");
        return Err((found, String::from("component x, or a polarised beam")));
    }
    let [nx, ny] = header.size.map(|count| count as usize);
    let samples = (nx as u64).saturating_mul(ny as u64);
    limit.check("samples", samples.saturating_mul(SAMPLE))?;
    let early = start.get(header.bytes..).unwrap_or_default();
    let mut samples_of_file = early.chain(file);
    let mut other_power = 0.0;
    let mut skipped = |source: &mut dyn Read| -> Result<(), (String, String)> {
        for _ in 0..ny {
            let row = read_row(source, nx).map_err(broken)?;
            other_power += row.iter().map(Complex64::norm_sqr).sum::<f64>();
        }
        Ok(())
    };
    if second {
        skipped(&mut samples_of_file)?;
    }
    let mut taken = Vec::with_capacity(nx.saturating_mul(ny));
    for _ in 0..ny {
        taken.extend(read_row(&mut samples_of_file, nx).map_err(broken)?);
    }
    if header.polarised && !second {
        skipped(&mut samples_of_file)?;
    }
    let samples = Array2::from_shape_vec((ny, nx), taken)
        .map_err(|error| (error.to_string(), String::from("whole rows")))?;
    Ok(Beam {
        header,
        samples,
        other_power,
    })
}

/// A row of samples.
fn read_row(source: &mut dyn Read, count: usize) -> std::io::Result<Vec<Complex64>> {
    let mut bytes = vec![0; count.saturating_mul(SAMPLE as usize)];
    source.read_exact(&mut bytes)?;
    let (pairs, _) = bytes.as_chunks::<16>();
    let number = |part: &[u8]| part.first_chunk().map_or(0.0, |b| f64::from_le_bytes(*b));
    Ok(pairs
        .iter()
        .map(|pair| {
            let (re, im) = pair.split_at(8);
            Complex64::new(number(re), number(im))
        })
        .collect())
}
