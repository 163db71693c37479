//! raylet-paper: the source paper's studies and systems, done again.
//!
//! Each study is a function that returns a [`study::Study`]: text, a document and pictures.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`study`], [`study_error`], [`progress_display`] | what a study takes, returns and shows |
//! | [`fig2`] | [`covering`] of a hologram by patches, its [`covering_chart`], and the cost of a [`flat_patch`] |
//! | [`fig3`] | [`convergence`] with secondary rays |
//! | [`fig5`], `fig5_chart` | a hologram before a lens, by three designs |
//! | [`fig6`] | a [`conformal`] mirror by several methods, and the [`conformal_chart`] |
//! | [`fig6_foci`], [`fig6_s`] | mirrors designed by gradients: `mirror` seeks, [`conformal_seen`] measures, [`mirror_chart`] draws |
//! | [`system1`], [`system2`], [`system3`] | the systems of figure 4: [`systems`] compares each [`method_comparison`] |
//! | [`posed`] | a system of a study as a scene file with its arrays |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

pub mod conformal;
pub mod conformal_chart;
pub mod conformal_seen;
pub mod convergence;
pub mod covering;
pub mod covering_chart;
pub mod fig2;
pub mod fig3;
pub mod fig5;
mod fig5_chart;
pub mod fig6;
pub mod fig6_foci;
pub mod fig6_s;
pub mod flat_patch;
pub mod method_comparison;
mod mirror;
pub mod mirror_chart;
pub mod posed;
pub mod progress_display;
pub mod study;
pub mod study_error;
pub mod system1;
pub mod system2;
pub mod system3;
pub mod systems;
