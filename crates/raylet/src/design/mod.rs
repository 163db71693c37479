//! What should change.

#![expect(
    clippy::indexing_slicing,
    reason = "parameters and pixels are indexed by loops over the sizes of the element they belong to"
)]

pub mod conformal;
pub mod conformal_design;
pub mod constraint;
pub mod descent;
pub mod estimator;
pub mod exact;
pub mod feature;
pub mod fill;
pub mod hologram;
pub mod lbfgs;
pub mod likeness;
pub mod loss;
pub mod mirror;
pub mod modulation;
pub mod near;
pub mod optimizer;
pub mod overlap;
pub mod patterns;
pub mod problems;
pub mod project;
pub mod reduction;
pub mod relief;
pub mod run;
pub mod schedule;
pub mod share;
pub mod smiley;
pub mod smoothness;
pub mod space;
pub mod spots;
pub mod staircase;
pub mod start;
pub mod step;
pub mod target;
pub mod wolfe;
