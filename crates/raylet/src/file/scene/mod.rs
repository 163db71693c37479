//! The content of a scene file.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `scene_file` | The scene file: everything that a run needs, in one TOML text with array files beside it |
//! | `illumination` | Where the light comes from, as a scene file describes it |
//! | `source_plane` | The plane on which the light of a source is given |
//! | `element` | Elements of a scene: what stands along the axis, as a scene file describes it |
//! | `layer` | Layers of a diffractive element, as a scene file describes them |
//! | `material` | A medium, as a scene file names it |
//! | `aperture` | Clear apertures, as a scene file describes them |
//! | `surface_shape` | Shapes of surfaces, as a scene file describes them |
//! | `settings` | How a scene is to be computed, and the table of a hologram |
//! | `design` | What a scene says about its design by gradients |
//! | `estimator` | Which beamlets the evaluations of a design follow |
//! | `loss_specification` | The losses of a design, as a scene describes them |
//! | `element_names` | What elements are called: by their names, or by their places where they have none |
//! | `check` | Faults of a scene that no single value shows: parts that do not fit together |
//! | `array_loading` | The arrays of a scene, and what makes one whose file is missing |
//! | `layer_check` | Faults of an element's layers that no single value shows |
//! | `variable` | Numbers of a scene by their address, so that a design may change any of them |
//! | `scene_test` | Tests: scenes that must be read, and scenes that must be refused at the right place |
//! | `schema_test` | Tests: the JSON Schema of a scene file against good and bad scenes |
//! | `surfaces_test` | Tests: scenes with every shape and aperture, and those that must be refused |

pub mod aperture;
mod array_loading;
pub(crate) mod check;
pub mod design;
pub mod element;
pub(crate) mod element_names;
pub mod estimator;
pub mod illumination;
pub mod layer;
pub(crate) mod layer_check;
pub mod loss_specification;
pub mod material;
pub mod scene_file;
#[cfg(test)]
pub(crate) mod scene_test;
#[cfg(test)]
mod schema_test;
pub mod settings;
pub(crate) mod source_plane;
pub mod surface_shape;
#[cfg(test)]
pub(crate) mod surfaces_test;
pub mod variable;
