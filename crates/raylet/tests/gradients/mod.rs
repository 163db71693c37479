//! Gradients through whole systems: the transpose of the chain, differences of losses, independent adjoints.

mod chain;
mod differences;
mod drawn;
mod local_bands;
mod stage;
