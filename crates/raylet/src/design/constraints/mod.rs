//! Constraints: from free parameters to pixels that can be made.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`constraint`] | The chain of constraints of one element, and its adjoint |
//! | [`feature`] | The smallest feature: blocks of pixels, or a blur |
//! | [`modulation`] | What of the pixels is free: phases, amplitudes, both, or two phases |
//! | [`relief`] | Levels of phase, or a height of material |
//! | [`staircase`] | Stairs of allowed levels, hard or softened |

pub mod constraint;
pub mod feature;
pub mod modulation;
pub mod relief;
pub mod staircase;
