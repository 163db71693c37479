//! raylet-plot: pictures of optical systems, fields, diffractive elements and designs.
//!
//! It draws what the library has computed, and computes nothing of its own.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`figure`] | figures: panels in rows, as PNG |
//! | [`panel`] | what all panels share: title, axes, margins, errors |
//! | [`image_panel`] | a panel of coloured values, with its colour bar |
//! | [`chart_panel`] | a panel of lines |
//! | [`section_panel`] | a panel with a section through a system |
//! | [`colour`] | colour maps and scales |
//! | `axis`, `label`, `svg` | ticks; words that keep clear of each other; writing SVG |
//! | [`pictures`] | the sensor and the elements of a result |
//! | [`sensor_panels`] | what the picture of a sensor shows, on the command line and in Python |
//! | [`layout_picture`] | the drawing of a system and a few rays |
//! | `part_section` | the parts of a system, cut by the plane of a drawing |
//! | [`design_chart`] | the course of a design |
//! | [`contrast`] | two results side by side |
//! | [`text_table`] | plain text tables |
//! | `decoded_png` | for tests: the pixels of a PNG |
//!
//! Axes, legends and labels are this crate's own code. In November 2026 it was compared with plotters 0.3.7, of
//! September 2024, on an error chart, a field and a layout. plotters leaves to its caller the powers of ten on an axis,
//! the true aspect ratio, the colour bar, the unit, and names that keep clear of lines: 49, 54 and 52 lines of code
//! instead of 13, 8 and 15. Its SVG of a field of 240 x 160 values has 3.3 MB instead of 63 kB. Each length has to be
//! doubled by hand for a picture of twice the pixels, and letters are a fifth smaller than requested. It adds 10
//! packages. charming and plotly make PNG only with a JavaScript engine or a browser.

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
#[cfg(test)]
mod decoded_png;
pub mod design_chart;
pub mod figure;
pub mod image_panel;
mod label;
pub mod layout_picture;
pub mod panel;
mod part_section;
pub mod pictures;
pub mod section_panel;
pub mod sensor_panels;
mod svg;
pub mod text_table;
