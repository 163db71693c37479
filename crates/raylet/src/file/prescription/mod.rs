//! Prescriptions of other programs for lens design, read into scenes.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `lens_text` | The text of a lens file: its encoding, its lines as records, and faults that point into it |
//! | `lens_file` | The bytes of a lens file on the disk |
//! | `sequential` | A sequential prescription, in millimetres, whatever its format |
//! | `face_grid` | Values on a grid that shape a surface of a lens file or its phase |
//! | `imported_grids` | Arrays of values inside a lens file, which its scene names |
//! | `import_report` | What an import tells: what was read, what was changed, and what was left out |
//! | `outline` | Apertures of surfaces, from the numbers of a file |
//! | `zernike_order` | Zernike polynomials in the orders of other programs |
//! | `zemax` | Files of Zemax and OpticStudio (.zmx) |
//! | `codev` | Files of CODE V (.seq) |
//! | `archive` | Archives of OpticStudio (.zar) with a lens and its glasses |
//! | `lens_table` | A table of surfaces (.csv) as a sequential prescription |
//! | `glasses` | Glasses: catalogues of users, the media of a prescription |
//! | `first_order` | First-order optics of a prescription: pupils, the size of its stop |
//! | `rim_sizes` | How wide the rims of surfaces are that a file does not fix |
//! | `element_parts` | Parts of a scene's elements that an import makes and alters: rims, names, distances |
//! | `scene_elements` | The elements of a scene from the surfaces of a prescription |
//! | `scene_light` | The light and the sensor of a scene from a prescription |
//! | `scene_text` | A scene as the text of a file that people read |
//! | [`export`] | Scenes written as prescriptions of other programs |
//! | [`lens_library`] | Lenses by name: those that raylet carries, and folders of users |
//! | `import` | From the file of a program for lens design to a scene, with a report |
//! | `shapes_test` | Tests: surfaces of Zemax files, against the formulas of their types |
//! | `zernike_test` | Tests: Zernike surfaces and phases, against their formulas and against what OpticStudio stored |
//! | `grids_test` | Tests: grids of values inside Zemax files, and as files that scenes name |
//! | `import_test` | Tests: whole Zemax files by hand, their axes, apertures, fields, glasses and faults |
//! | `optiland_test` | Tests: lens files of other projects, against Optiland and against what OpticStudio left in them |
//! | `rayoptics_test` | Tests: files of CODE V and Zemax of other projects, against ray-optics |
//! | `mutations_test` | Tests: altered lens files give a scene or an error |

pub(crate) mod archive;
pub(crate) mod codev;
pub(crate) mod element_parts;
pub mod export;
pub(crate) mod face_grid;
pub(crate) mod first_order;
pub(crate) mod glasses;
#[cfg(test)]
mod grids_test;
pub mod import;
pub mod import_report;
#[cfg(test)]
mod import_test;
pub mod imported_grids;
pub(crate) mod lens_file;
pub mod lens_library;
pub(crate) mod lens_table;
pub(crate) mod lens_text;
#[cfg(test)]
mod mutations_test;
#[cfg(test)]
pub(crate) mod optiland_test;
pub(crate) mod outline;
#[cfg(test)]
mod rayoptics_test;
pub(crate) mod rim_sizes;
pub(crate) mod scene_elements;
pub(crate) mod scene_light;
pub mod scene_text;
pub(crate) mod sequential;
#[cfg(test)]
mod shapes_test;
pub(crate) mod zemax;
pub(crate) mod zernike_order;
#[cfg(test)]
mod zernike_test;
