//! The problems on which raylet is measured: systems, and their fields by references.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`problem`] | What a problem is, and how far a field is from its reference |
//! | [`strong`] | Small, strongly refracting lenses |
//! | [`tilted`] | Tilted and decentred parts, each in a train with one strongly refracting lens or plate |
//! | [`fold`] | Tilted planes in free space, and a toroidal fold mirror |
//! | [`slanted`] | The list of problems with tilted, decentred and folded parts |
//! | [`mirror`] | Diffractive mirrors on a Gaussian bump, by direct sum over the true surface |
//! | [`dim`] | Lenses that send little light to their sensors |
//! | [`suite`] | The list of problems of the accuracy report |

pub mod dim;
pub mod fold;
pub mod mirror;
pub mod problem;
pub mod slanted;
pub mod strong;
pub mod suite;
pub mod tilted;
