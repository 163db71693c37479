//! A part of a scene file that is being checked.

use crate::file::decode::fault::Fault;
use crate::file::decode::origin::Origin;

/// The dotted path of a part and the text it stands in.
pub(crate) struct Place<'o> {
    /// The text.
    pub(crate) origin: &'o Origin,
    /// The path, such as `element[2]`.
    pub(crate) path: String,
}

impl Place<'_> {
    /// A part of this part, such as `.surface[1]`.
    pub(crate) fn inner(&self, step: &str) -> Self {
        Place {
            origin: self.origin,
            path: format!("{}{step}", self.path),
        }
    }

    /// The refusal of this part.
    pub(crate) fn refuse<T>(
        &self,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Result<T, Fault> {
        Err(self.origin.fault(&self.path, found, expected))
    }
}
