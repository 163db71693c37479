//! Who runs which rays.

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and hops, screens, patches and nodes are counted by the lists they number"
)]

pub mod account;
pub mod advice;
pub mod aim;
pub mod anchor;
pub mod backend;
pub mod beamlet_error;
pub mod beamlets;
pub mod bench;
pub mod beyond;
pub mod budget;
pub mod carry;
pub mod census;
pub mod cpu;
pub mod directions;
pub mod drawn;
pub mod edge_light;
pub mod eikonal;
pub mod facet;
pub mod fan;
pub mod flatness;
pub mod follow;
pub mod forecast;
pub mod launch;
pub mod light;
pub mod look;
pub mod paper;
pub mod paper_plan;
pub mod pencil;
pub mod plan;
pub mod plan_error;
pub mod plane;
pub mod reason;
pub mod reference;
pub mod repeat;
pub mod rims;
pub mod ripple;
pub mod route;
pub mod scatter;
pub mod scattering;
pub mod seat;
pub mod secondary;
pub mod settings;
pub mod shelf;
pub mod simulate;
pub mod sketch;
pub mod spot_check;
pub mod stray_tail;
pub mod survey;
pub mod sway;
pub mod tally;
pub mod tube;
pub mod volley;
pub mod walk;
pub mod workload;
