//! Analytic phases of diffractive elements.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`profile`] | Phases by formulas, with their gradients |
//! | [`placement`] | A phase whose own axes are off centre or turned |
//! | [`blaze`] | The diffraction orders of a blazed or stepped profile |
//! | [`two_point`] | The phase that turns one wave into another: holograms of two points |

pub mod blaze;
pub mod placement;
pub mod profile;
pub mod two_point;
