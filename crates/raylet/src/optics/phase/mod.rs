//! Analytic phases of diffractive elements.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`profile`] | Phases by formulas, with their gradients |
//! | [`placement`] | Own axes of phases and pixels that are off centre or turned |
//! | [`radial_table`] | A phase of the radius by samples and the spline through them |
//! | [`phase_grid`] | A smooth phase by samples on a grid and the spline between them |
//! | [`blaze`] | The diffraction orders of a blazed or stepped profile |
//! | `smooth_orders` | The orders of an element without pixels: shares, slopes and curvatures |
//! | [`two_point`] | The phase that turns one wave into another: holograms of two points |
//! | [`vertex_power`] | The power of an element at its vertex |

pub mod blaze;
pub mod phase_grid;
pub mod placement;
pub mod profile;
pub mod radial_table;
pub(crate) mod smooth_orders;
pub mod two_point;
pub mod vertex_power;
