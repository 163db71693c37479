//! Fixtures that the tests of all crates share.
//!
//! The unit tests of the library compile these files, but for `scenes.rs` and `strong_mirror.rs`, as their own module `fixtures`: types of this crate belong to another copy of the library than the one under test. So these files name the
//! library `raylet`, and each other by `super`. Tests of these files run there too.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`parts`] | Screens, surfaces and sources of small systems |
//! | [`noise`] | Random values by address |
//! | [`paper_systems`] | The three systems of the source paper |
//! | [`patterns`] | Two elements in free space on which ways to sample are compared |
//! | [`smiley`] | The line drawing of the source paper's holograms |
//! | [`strong_mirror`] | A small mirror on which beamlets miss their target error |
//! | [`mutations`] | Altered files, for tests of readers |
//! | [`dot_product`] | The inner products of dot-product tests |
//! | [`scattered`] | A tilted element with rays on it, for scattering |
//! | [`scenes`] | Scene files of the repository and texts of scenes |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

pub mod dot_product;
pub mod mutations;
pub mod noise;
pub mod paper_systems;
pub mod parts;
pub mod patterns;
pub mod scattered;
pub mod scenes;
pub mod smiley;
pub mod strong_mirror;
