//! Propagation: how the field on one screen becomes the field on the next.
//!
//! | folder | what it holds |
//! | --- | --- |
//! | [`plan`] | Which method carries a hop, and with which settings |
//! | [`trace`] | Rays through one hop |
//! | [`ray_block`] | Many rays at once, in columns |
//! | [`geometrical`] | Rays through a whole system, and geometrical fields |
//! | [`beamlet`] | Beamlets of one hop: plan, errors, landing |
//! | [`plane_wave`] | Plane wavelets with a prefactor |
//! | [`monte_carlo`] | Random estimates: the source paper's method, and beamlets that are drawn |
//! | [`free`] | Hops without rays |
//! | [`rims`] | Rims of surfaces inside a train that cut light |
//! | [`error`] | Fates of rays and energy, the error budget, warnings |
//! | [`external`] | Rays of other ray tracers at a diffractive element |
//! | [`local_bands`] | Screens that are never held as a whole: their light tile by tile |
//! | [`chain`] | Runs of a whole system, forward and back |
//! | [`sweep`] | Several runs side by side |
//! | [`progress`] | Progress callbacks, and how they cancel long work |

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and hops, screens, patches and nodes are counted by the lists they number"
)]

pub mod beamlet;
pub mod chain;
pub mod error;
pub mod external;
pub mod free;
pub mod geometrical;
pub mod local_bands;
pub mod monte_carlo;
pub mod plan;
pub mod plane_wave;
pub mod progress;
pub mod ray_block;
pub mod rims;
pub mod sweep;
pub mod trace;
