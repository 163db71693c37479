//! Gradients of raylet against adjoints and differences of the references.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`gradient_error`] | The losses that are differentiated, and the relative error of a gradient |
//! | [`gradient_problems`] | Gradients by the pixels of an element, against adjoints of direct sums |
//! | [`sensitivity`] | Derivatives behind a small, strong lens, against central differences of surface integrals |

pub mod gradient_error;
pub mod gradient_problems;
pub mod sensitivity;
