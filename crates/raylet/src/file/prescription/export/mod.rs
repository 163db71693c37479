//! Scenes written as prescriptions of other programs.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `power_products` | Sums of products of powers of x and y |
//! | `held_phase` | Phases of layers in the forms that prescriptions hold |
//! | `lens_edges` | Apertures in the forms that prescriptions hold |
//! | `laying_surfaces` | The elements of a scene, laid as surfaces |
//! | `outgoing` | From a scene to a sequential prescription |
//! | `outgoing_light` | The light of a scene as the object and the field of a prescription |
//! | `limiting_stop` | Which surface limits the light on the axis |
//! | `zemax_types` | Curves and phases as surfaces of OpticStudio: a type and its numbers |
//! | `zemax_glasses` | Media as glasses of OpticStudio |
//! | `zemax_writer` | A prescription as the text of a Zemax file (.zmx) |
//! | `codev_shapes` | Curves and phases as commands of CODE V |
//! | `codev_glasses` | Media as glasses of CODE V |
//! | `codev_writer` | A prescription as the text of a CODE V file (.seq) |
//! | `lens_export` | A scene as a lens file, with a report of what was changed and left out |
//! | `lens_export_test` | Tests: scenes and lens files, written and read again |
//! | `written_shapes_test` | Tests: surfaces and phases of written files, against the formulas of their types |

pub(crate) mod codev_glasses;
pub(crate) mod codev_shapes;
pub(crate) mod codev_writer;
pub(crate) mod held_phase;
pub(crate) mod laying_surfaces;
pub(crate) mod lens_edges;
pub mod lens_export;
#[cfg(test)]
mod lens_export_test;
pub(crate) mod limiting_stop;
pub(crate) mod outgoing;
pub(crate) mod outgoing_light;
pub(crate) mod power_products;
#[cfg(test)]
mod written_shapes_test;
pub(crate) mod zemax_glasses;
pub(crate) mod zemax_types;
pub(crate) mod zemax_writer;
