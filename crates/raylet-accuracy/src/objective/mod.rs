//! A photographic objective with an element at its stop, far larger than whole fields can be held.
//!
//! Its reference takes rays from the library, and nothing else.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`triplet`] | A Cooke triplet f = 50 mm |
//! | [`masks`] | What may stand at its stop |
//! | [`ray_integral`] | The field on its sensor: rays to its stop, and from there to each pixel |

pub mod masks;
pub mod ray_integral;
pub mod triplet;
