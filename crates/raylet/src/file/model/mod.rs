//! From a scene to the system, hologram or design that it describes.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `build` | From a scene to the optical system it describes, one wavelength at a time |
//! | `element_layers` | The layers of a diffractive element, from the keys of a scene to what they do to light |
//! | `relief_side` | On which side of an interface a relief stands |
//! | `light` | From what a scene says of its light to the source of its system |
//! | `prescription` | The parts of a system in the order light meets them, with the names the scene gives them |
//! | `scene_arrays` | All the arrays that the layers of a scene name, and the transmissions they make |
//! | `scene_media` | The materials that a scene names, as media with an index at each wavelength |
//! | `phase_units` | Warnings about phases in degrees or grey levels |
//! | `hologram` | The hologram of a scene |
//! | `fringed_pixels` | Pixels with fly-back or crosstalk, refused where their gradient is needed |
//! | `pixel_part` | The elements whose pixels a scene designs |
//! | `project` | The design of a scene: losses, what is free, the start, the outputs |
//! | `design_targets` | The runs that a design evaluates, and their losses |
//! | `scene_sweep` | The runs of a sweep: a scene in several fields of light, with its sensor at several distances |
//! | `variations` | A system at values of a scene's numbers, and its perturbed systems for derivatives |
//! | `error_location` | Faults found while computing, reported at the element of the scene they belong to |
//! | `magnitude_test` | Tests: numbers that no system has, in every numeric key of every scene |

pub mod build;
pub mod design_targets;
pub(crate) mod element_layers;
pub mod error_location;
pub mod fringed_pixels;
pub mod hologram;
pub(crate) mod light;
#[cfg(test)]
mod magnitude_test;
pub mod phase_units;
pub mod pixel_part;
pub mod prescription;
pub mod project;
pub(crate) mod relief_side;
pub mod scene_arrays;
pub(crate) mod scene_media;
pub mod scene_sweep;
pub mod variations;
