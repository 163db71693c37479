//! Diffractive mirrors on curved substrates.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`mirror`] | The design of the pixels of a curved mirror, with its gradient |

pub mod mirror;
