//! Rims of surfaces inside a train: which of them cut light, and how that is computed.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `curved_edge` | The error of the edge wave of a rim on a curved surface |
//! | `edge_diffraction` | Estimates of the light that hard edges diffract, by direction |
//! | `entrance_edge` | The rim of a first surface that is the edge of the entrance before it |
//! | `joined_screens` | One screen in place of several that stand in one place |
//! | `onward` | Whether light that arrives on a screen goes on to the sensor |
//! | `pixel_envelope` | How strongly pixels turn light of a direction to the sensor |
//! | [`pixel_light`] | The directions into which pixels send light, by the power spectrum about a place |
//! | `rim_light` | What rims do to light, by rays of the source |
//! | [`rim_screens`] | Rims that become screens, and the error of those that do not |
//! | `source_ray` | One ray of the source's light on a screen |
//! | `source_rays` | Rays of the light itself, from the source through every screen |
//! | `surface_edge` | The edge of a surface of a train, and where rays meet its plane |

pub(crate) mod curved_edge;
pub(crate) mod edge_diffraction;
pub(crate) mod entrance_edge;
pub(crate) mod joined_screens;
pub(crate) mod onward;
pub(crate) mod pixel_envelope;
pub mod pixel_light;
pub(crate) mod rim_light;
pub mod rim_screens;
pub(crate) mod source_ray;
pub(crate) mod source_rays;
pub(crate) mod surface_edge;
