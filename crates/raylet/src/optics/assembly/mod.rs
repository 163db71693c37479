//! Systems from parts laid one behind another.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `axis_layout` | Where parts stand along an axis, and the screens and trains that they make |
//! | [`glass`] | What a medium may be given as: a name of the catalogue, an index, or itself |
//! | [`part_check`] | What may be wrong with one part, and the error that says so |
//! | `part_laying` | The parts of a builder, checked and laid on the axis one by one |
//! | [`system_builder`] | Systems in code: parts by their usual numbers, with one clear error |

pub(crate) mod axis_layout;
pub mod glass;
pub mod part_check;
mod part_laying;
pub mod system_builder;
