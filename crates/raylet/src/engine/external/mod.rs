//! Rays of other ray tracers at a diffractive element.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`scatter`] | The secondary rays that leave an element, and the transposed call |
//! | [`scatter_settings`] | The choices of a scattering, and why one is impossible |
//! | [`secondary_rays`] | The secondary rays, and which modes of a patch become rays |

pub mod scatter;
pub mod scatter_settings;
pub mod secondary_rays;
