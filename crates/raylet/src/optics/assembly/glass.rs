//! What a medium may be given as: a name of the catalogue, an index, or the medium itself.

use crate::optics::media::catalog;
use crate::optics::media::medium::Medium;

/// A medium as code names it. Made from `"N-BK7"`, from `1.5` (the same index at every wavelength), or from a
/// [`Medium`].
#[derive(Clone, Debug)]
pub enum Glass {
    /// A name of the glass catalogue, as [`catalog::medium`] takes it; `"air"` among them.
    Named(String),
    /// A medium of its own.
    Medium(Medium),
}

impl Glass {
    /// Index of refraction at a vacuum wavelength in mm.
    ///
    /// # Errors
    /// An unknown name, or a wavelength at which the medium is not known, in words.
    pub(crate) fn index(&self, wavelength: f64) -> Result<f64, String> {
        let medium = match self {
            Glass::Named(name) => catalog::medium(name).map_err(|error| error.to_string())?,
            Glass::Medium(medium) => medium.clone(),
        };
        medium.index(wavelength).map_err(|error| error.to_string())
    }
}

impl From<&str> for Glass {
    fn from(name: &str) -> Self {
        Glass::Named(name.to_owned())
    }
}

impl From<f64> for Glass {
    fn from(index: f64) -> Self {
        Glass::Medium(Medium::constant(index))
    }
}

impl From<Medium> for Glass {
    fn from(medium: Medium) -> Self {
        Glass::Medium(medium)
    }
}
