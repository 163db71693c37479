//! Diffractive mirrors on curved substrates.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`conformal`] | Phases of a conformal mirror from patches |
//! | [`conformal_design`] | The pixels of a conformal mirror as a design: targets and start |
//! | [`mirror`] | The design of the pixels of a curved mirror, with its gradient |

pub mod conformal;
pub mod conformal_design;
pub mod mirror;
