//! raylet: optics made of lenses, mirrors and diffractive elements.
//!
//! The library is built in layers that only look down:
//! `math` (numbers, no light), `optics` (what the parts are), `wave` (what happens to waves),
//! `engine` (propagation from screen to screen), `design` (what should change), `file` (how it is written down).

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
    pub(crate) mod noise;
    pub(crate) mod parts;
    pub(crate) mod scattered;
}

pub mod design;
pub mod engine;
pub mod file;
pub mod math;
pub mod optics;
pub mod wave;

/// The examples of the user guide, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rays.md")]
pub struct Guide;
