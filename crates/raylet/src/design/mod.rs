//! What should change.

pub mod conformal;
pub mod descent;
pub mod exact;
pub mod hologram;
pub mod lbfgs;
pub mod long;
pub mod near;
pub mod optimizer;
pub mod patterns;
pub mod problems;
pub mod schedule;
pub mod smiley;
pub mod space;
pub mod start;
pub mod step;
pub mod target;
pub mod wolfe;
