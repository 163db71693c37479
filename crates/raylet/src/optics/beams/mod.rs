//! Kinds of light that sources send.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`gaussian_beam`] | Light with a waist, as from a laser or a single-mode fibre |
//! | [`taper`] | Tapers: amplitudes that fall off aside, as those of laser beams and laser diodes |

pub mod gaussian_beam;
pub mod taper;
