//! What should change.

pub mod conformal;
pub mod descent;
pub mod exact;
pub mod hologram;
pub mod lbfgs;
pub mod likeness;
pub mod long;
pub mod loss;
pub mod near;
pub mod optimizer;
pub mod patterns;
pub mod problems;
pub mod schedule;
pub mod share;
pub mod smiley;
pub mod space;
pub mod spots;
pub mod start;
pub mod step;
pub mod target;
pub mod wolfe;
