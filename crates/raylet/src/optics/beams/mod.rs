//! Kinds of light that sources send.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`fibre_mode`] | Modes of a weakly guiding step-index fibre: LP modes, of one polarisation |
//! | [`gaussian_beam`] | Light with a waist, as from a laser or a single-mode fibre |
//! | [`gaussian_mode`] | The mode of a single-mode fibre of which the mode field diameter is known |
//! | `sampled_field` | A field that is given on a plane by samples: an element there, which makes it of a plane wave |
//! | [`taper`] | Tapers: amplitudes that fall off aside, as those of laser beams and laser diodes |

pub mod fibre_mode;
pub mod gaussian_beam;
pub mod gaussian_mode;
pub(crate) mod sampled_field;
pub mod taper;
