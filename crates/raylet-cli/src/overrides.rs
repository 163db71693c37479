//! Choices on the command line that take the place of the scene's.

use clap::Args;
use raylet::engine::plan::settings::{Method, Settings};
use serde::de::DeserializeOwned;
use serde::de::IntoDeserializer;
use serde::de::value::Error;

use crate::failure::Failure;

/// Options that every computing verb takes.
#[derive(Args)]
pub(crate) struct Overrides {
    /// How fields are carried through lenses, in place of the scene's settings.method: auto (what promises the target
    /// error at the least cost), beamlet, local_bands (no screen sampled as a whole), plane, or paper (random patches and
    /// drawn modes, as first published).
    #[arg(long, value_parser = by_name::<Method>)]
    method: Option<Method>,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Overrides {
    /// Applies the options to the settings and starts the threads.
    pub(crate) fn apply(&self, settings: &mut Settings) -> Result<(), Failure> {
        if let Some(method) = self.method {
            settings.method = method;
        }
        start_threads(self.threads)
    }
}

/// An option by its name in scenes.
pub(crate) fn by_name<T: DeserializeOwned>(name: &str) -> Result<T, Error> {
    T::deserialize(name.into_deserializer())
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
