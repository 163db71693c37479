//! Figures 2 and 3: patches on an element, and the secondary rays of one patch.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`fig2`] | Figure 2: how many patches cover a hologram, what periods cost, and what flat patches cost |
//! | [`covering`] | How many patches it takes to cover a hologram, by rules of position |
//! | [`covering_chart`] | The pictures of it |
//! | [`periodic_hop`] | What patches of one period bring together |
//! | [`flat_patch`] | What a flat patch costs on a curved mirror |
//! | [`fig3`] | Figure 3: the error of one patch against the number of its secondary rays |
//! | [`convergence`] | How the method converges with secondary rays at one patch |

pub mod convergence;
pub mod covering;
pub mod covering_chart;
pub mod fig2;
pub mod fig3;
pub mod flat_patch;
pub mod periodic_hop;
