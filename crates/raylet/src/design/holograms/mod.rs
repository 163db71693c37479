//! Phase holograms by iterative Fourier transform algorithms.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`hologram`] | Holograms through a paraxial train |
//! | [`near`] | Holograms for a sensor close behind them (Gerchberg and Saxton) |
//! | `start` | Phases to start a design from |

pub mod hologram;
pub mod near;
pub(crate) mod start;
