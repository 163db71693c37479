//! Fixtures that the tests of all crates share.
//!
//! The unit tests of the library compile `parts.rs`, `noise.rs` and `scattered.rs` as their own module `fixtures`: types
//! of this crate belong to another copy of the library than the one under test. So these files name the library
//! `raylet`, and each other by `super`.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`parts`] | Screens, surfaces and sources of small systems |
//! | [`noise`] | Random values by address |
//! | [`scattered`] | A tilted element with rays on it, for scattering |
//! | [`scenes`] | Scene files of the repository and texts of scenes |

pub mod noise;
pub mod parts;
pub mod scattered;
pub mod scenes;
