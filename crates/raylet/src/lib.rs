//! raylet simulates optics made of lenses, mirrors and diffractive elements, and designs the latter by gradients.
//!
//! # A hologram through a lens
//!
//! ```
//! use ndarray::Array2;
//! use raylet::{Settings, SystemBuilder, simulate};
//!
//! // Light of 0.7 µm meets 40 × 40 pixels of 6.3 µm with the phases of a grating; a lens brings it to a sensor in its
//! // focus. Lengths are in mm.
//! let (wavelength, pitch) = (0.7e-3, 6.3e-3);
//! let phases = Array2::from_shape_fn((40, 40), |(_, x)| 0.4 * x as f64);
//! let system = SystemBuilder::new(wavelength)
//!     .phase_pixels("grating", &phases, [pitch, pitch])
//!     .gap(3.0)
//!     .surface(25.8, "N-BK7", 12.7)
//!     .gap(5.3)
//!     .surface(f64::INFINITY, "air", 12.7)
//!     .gap(46.783)
//!     .sensor([61, 31], [0.02, 0.02])
//!     .build()?;
//!
//! let outcome = simulate(&system, &Settings::default(), &|_| {})?;
//!
//! // The brightest pixel is where the grating sends the light: x = f·sin θ, sin θ = 0.4 λ/(2π pitch).
//! let intensity = outcome.field.intensity();
//! let brightest = intensity.indexed_iter().max_by(|a, b| a.1.total_cmp(b.1));
//! let ((y, x), _) = brightest.ok_or("an empty sensor")?;
//! let sine = 0.4 * wavelength / (std::f64::consts::TAU * pitch);
//! let expected = 50.286 * sine;
//! assert!((outcome.field.grid.x.node(x) - expected).abs() < 0.02);
//! assert_eq!(y, 15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/hologram_through_lens.rs` designs such a hologram, `examples/pixel_gradient.rs` takes a gradient by pixels.
//!
//! # What there is
//!
//! | word | type | meaning |
//! | --- | --- | --- |
//! | system | [`System`] | all parts at one wavelength: screens joined by trains, and the source |
//! | screen | [`Screen`] | a plane or curved surface where the field is known: element, stop or sensor; the last one is the sensor |
//! | train | `Vec<`[`Surface`]`>` | the ordinary surfaces between two screens, lenses and mirrors; maybe none |
//! | hop | [`Hop`] | the step from a screen through a train to the next screen |
//! | field | [`Field`] | complex amplitudes of the light on the nodes of a grid, indexed [y, x] |
//!
//! [`SystemBuilder`] makes a system in code, and [`build::system`] makes it from a [`Scene`] file. [`simulate`] carries the
//! light of a system to its sensor. [`forecast`] says beforehand what a run will take. [`LinearisedSystem`] also goes back:
//! it gives the gradient of any real function of the field by pixels and by parameters of the system. [`Project`] runs a
//! design. [`ErrorBudget`] is what a run reports of its error.
//!
//! # Units and signs
//!
//! - Lengths are in millimetres (wavelengths too), angles in radians. Names that carry other units say so.
//! - Light that goes towards +z varies as exp(+ikz), k = 2π/λ, with the time factor exp(−iωt). A phase φ of an element
//!   multiplies the field by exp(+iφ).
//! - A radius is positive where the centre lies at larger z. Behind an odd number of mirrors distances are negative.
//! - Arrays are indexed [y, x]; the row index grows with y. Grids are centred on the origin of their screen.
//! - Tilts are right-handed, about x, then the new y, then the new z.
//! - Indices are relative to air, whose index is 1.
//! - The cotangent of a complex z is z̄ = ∂L/∂Re z + i ∂L/∂Im z. With v the pixels of an element, Im(v̄ v*) is the gradient
//!   by their phases.
//!
//! # Layers
//!
//! A module uses only those before it.
//!
//! | folder | what it holds |
//! | --- | --- |
//! | [`math`] | Numbers, no light |
//! | [`optics`] | What the parts are |
//! | [`wave`] | What happens to waves |
//! | [`engine`] | Propagation from screen to screen |
//! | [`design`] | What should change |
//! | [`mod@file`] | How it is written down |
//!
//! The types of the table, and those with which a run begins and ends, stand at the root as well: `use raylet::System`.
//!
//! [`build::system`]: file::model::build::system

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

#[cfg(test)]
extern crate self as raylet;

/// Fixtures of the unit tests: the files of raylet-testkit, compiled as a part of this crate, because that crate's types
/// belong to another copy of the library.
#[cfg(test)]
#[path = "../../raylet-testkit/src"]
#[allow(
    dead_code,
    unreachable_pub,
    reason = "the files are written for a crate of its own; not every test needs all of them"
)]
mod fixtures {
    pub(crate) mod dot_product;
    pub(crate) mod mutations;
    pub(crate) mod noise;
    pub(crate) mod paper_systems;
    pub(crate) mod parts;
    pub(crate) mod patterns;
    pub(crate) mod scattered;
    pub(crate) mod smiley;
}

pub mod design;
pub mod engine;
pub mod file;
pub mod math;
pub mod optics;
pub mod wave;

pub use design::project::Project;
pub use engine::chain::forecast::forecast;
pub use engine::chain::linearised_system::LinearisedSystem;
pub use engine::chain::outcome::Outcome;
pub use engine::chain::simulate::simulate;
pub use engine::error::error_budget::ErrorBudget;
pub use engine::plan::settings::Settings;
pub use file::scene::scene_file::Scene;
pub use optics::assembly::system_builder::SystemBuilder;
pub use optics::screen::Screen;
pub use optics::surface::Surface;
pub use optics::system::{Hop, System};
pub use wave::grid::field::Field;

/// The examples of the user guide, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rays.md")]
pub(crate) struct Guide;
