//! Gradients through whole systems: the transpose of the chain, differences of losses, independent adjoints.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `stage` | Small systems in wavelengths, with every kind of hop between them |
//! | `chain` | The adjoint of a whole run is the transpose of the run |
//! | `differences` | Gradients against central differences of the loss itself |
//! | `drawn` | Drawn beamlets, whose mean is the exact field and gradient, and their control variate |
//! | `local_bands` | Gradients by local bands against central differences of the loss |

mod chain;
mod differences;
mod drawn;
mod local_bands;
mod stage;
