//! `raylet convert SOURCE -o FILE`: a field as a beam file of OpticStudio (.zbf), a FITS or HDF5 file, or a NumPy archive (.npz).

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use raylet::file::arrays::memory::{MachineMemory, MemoryLimit};
use raylet::file::beams::zbf_fields::BeamChoices;
use raylet::file::result::conversion::{ConversionChoices, convert_field};

use crate::compare::megabytes;
use crate::failure::Failure;
use crate::say::say;

/// Converts a field to or from a beam file of OpticStudio, a FITS or an HDF5 file, and reports what was left out.
#[derive(Args)]
pub(crate) struct Convert {
    /// A folder of results, a field.npz, a FITS file (.fits), an HDF5 file (.h5), or a beam file (.zbf).
    source: PathBuf,
    /// The file to be written; its end decides on the format: .zbf, .npz, .fits or .h5.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Takes wavelength N, from 1; a beam file holds one.
    #[arg(long, value_name = "N")]
    wavelength: Option<usize>,
    /// Component of a polarised beam file.
    #[arg(long, value_name = "C", default_value = "x")]
    component: Component,
    /// Adds the phase of the reference sphere of the pilot beam, where a beam file has one.
    #[arg(long)]
    sphere: bool,
    /// Replaces a file that raylet did not write, or that was changed since.
    #[arg(long)]
    overwrite: bool,
    /// The most memory that the field may take, in units of 10⁶ bytes; half of what is free by default.
    #[arg(long, value_name = "MB", value_parser = megabytes)]
    #[arg(allow_negative_numbers = true)]
    memory_limit_mb: Option<f64>,
}

/// A component of a polarised beam.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Component {
    /// Ex.
    X,
    /// Ey.
    Y,
}

impl Convert {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let given = self
            .memory_limit_mb
            .map(|megabytes| (megabytes * 1e6) as u64);
        let choices = ConversionChoices {
            wavelength: self.wavelength,
            beam: BeamChoices {
                second: self.component == Component::Y,
                sphere: self.sphere,
            },
            overwrite: self.overwrite,
            limit: MemoryLimit {
                bytes: given.unwrap_or_else(|| MachineMemory::now().usual_limit()),
                set_by: "--memory-limit-mb",
            },
        };
        let report = convert_field(&self.source, &self.out, &choices)?;
        say(&format!("{report}Written to {}\n", self.out.display()))
    }
}
