//! Choices on the command line that take the place of the scene's.

use clap::{Args, ValueEnum};
use raylet::engine::plan::settings::{Method, Settings};

use crate::failure::Failure;

/// Options that every computing verb takes.
#[derive(Args)]
pub(crate) struct Overrides {
    /// How fields are carried through lenses, in place of the scene's settings.method.
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    /// What promises the target error at the least cost.
    Auto,
    /// Gaussian beamlets.
    Beamlet,
    /// Plane wavelets.
    Plane,
    /// Random patches and drawn modes, as first published.
    Paper,
}

impl Overrides {
    /// Applies the options to the settings and starts the threads.
    pub(crate) fn apply(&self, settings: &mut Settings) -> Result<(), Failure> {
        if let Some(method) = self.method {
            settings.method = match method {
                MethodName::Auto => Method::Auto,
                MethodName::Beamlet => Method::Beamlet,
                MethodName::Plane => Method::Plane,
                MethodName::Paper => Method::Paper,
            };
        }
        start_threads(self.threads)
    }
}

/// Starts the number of threads that the user chose.
pub(crate) fn start_threads(threads: Option<u16>) -> Result<(), Failure> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .map_err(|error| Failure::new(format!("cannot start {threads} threads: {error}")))?;
    }
    Ok(())
}
