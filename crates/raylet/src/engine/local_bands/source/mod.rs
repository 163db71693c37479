//! The light of a source on the first screen.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `source_light` | The light of a source on the first screen |
//! | `source_aperture` | Whether the aperture of the first screen cuts light that matters |
//! | `source_windows` | A smooth source: one beamlet a window |
//! | `source_aberration` | What the sum of a smooth source's beamlets departs by from its wave |

pub(crate) mod source_aberration;
pub(crate) mod source_aperture;
pub(crate) mod source_light;
pub(crate) mod source_windows;
