//! Systems at their real size: what they take, and how exact they are.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`cases`] | The systems, what stands at their stops, and their fields |
//! | [`measure`] | One case: its run, its expected error, and its error against the integral over the stop |
//! | [`on_axis`] | The exact field of systems that are figures of revolution and lit along their axis, at their full size |
//! | [`resources`] | Processor time and memory of this process |

pub mod cases;
pub mod measure;
pub mod on_axis;
pub mod resources;
