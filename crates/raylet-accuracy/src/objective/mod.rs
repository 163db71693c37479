//! A photographic objective with an element at its stop, far larger than whole fields can be held, and other systems of
//! such sizes.
//!
//! The reference of an objective takes rays from the library, and nothing else.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`triplet`] | A Cooke triplet f = 50 mm |
//! | [`masks`] | What may stand at its stop |
//! | [`ray_integral`] | The field on its sensor: rays to its stop, and from there to each pixel |
//! | [`surface_integral`] | The field behind a reflecting element on a curved surface, without rays |

pub mod masks;
pub mod ray_integral;
pub mod surface_integral;
pub mod triplet;
