//! The library against the references of this crate, and the report itself.
//!
//! One program for all files: it compiles in a fraction of the time of one program each.

mod accuracy;
mod designed;
mod dim;
mod estimates;
mod gradients;
mod methods;
mod objective;
mod paper_curved;
mod paraxial;
mod rayleigh;
mod rays;
mod readme;
mod real_size;
mod reference;
mod report;
mod rims;
