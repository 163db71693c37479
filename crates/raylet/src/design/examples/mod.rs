//! Systems and pictures on which methods are shown.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`patterns`] | Two elements in free space on which ways to sample are compared |
//! | [`problems`] | The three systems of the source paper |
//! | [`smiley`] | The line drawing of the source paper's holograms |

pub mod patterns;
pub mod problems;
pub mod smiley;
