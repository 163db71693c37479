//! raylet-paper: the source paper's studies and systems, done again.
//!
//! Each study is a function that returns a [`study::Study`]: text, a document and pictures.
//!
//! | folder or file | what it holds |
//! | --- | --- |
//! | [`patches`] | Figures 2 and 3: patches on an element, and the secondary rays of one patch |
//! | [`systems`] | Figure 4: three systems, each by several methods |
//! | [`fig5`], `fig5_chart` | Figure 5: a hologram before a lens, by three designs |
//! | [`mirrors`] | Figure 6: conformal mirrors |
//! | [`study`], [`study_error`], [`progress_display`] | What a study takes, returns and shows |
//! | [`scene_export`] | A system of a study as a scene file with its arrays |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

pub mod fig5;
mod fig5_chart;
pub mod mirrors;
pub mod patches;
pub mod progress_display;
pub mod scene_export;
pub mod study;
pub mod study_error;
pub mod systems;
