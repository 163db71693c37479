//! raylet-plot: pictures of optical systems, fields, diffractive elements and designs.
//!
//! It draws what the library has computed, and computes nothing of its own.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`figure`] | figures: panels in rows, as SVG or PNG |
//! | [`panel`] | what all panels share: title, axes, margins, errors |
//! | [`image_panel`] | a panel of coloured values, with its colour bar |
//! | [`chart_panel`] | a panel of lines |
//! | [`layout_panel`] | a panel with a section through a system |
//! | [`colour`] | colour maps and scales |
//! | `axis`, `label`, `svg` | ticks; words that keep clear of each other; writing SVG |
//! | [`pictures`] | the sensor and the elements of a result |
//! | [`layout_picture`] | the drawing of a system and a few rays |
//! | [`design_chart`] | the course of a design |
//! | [`contrast`] | two results side by side |
//! | [`text_table`] | plain text tables |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod axis;
pub mod chart_panel;
pub mod colour;
pub mod contrast;
pub mod design_chart;
pub mod figure;
pub mod image_panel;
mod label;
pub mod layout_panel;
pub mod layout_picture;
pub mod panel;
pub mod pictures;
mod svg;
pub mod text_table;
