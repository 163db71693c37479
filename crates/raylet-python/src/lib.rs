//! The extension module behind the Python package `raylet`: arrays and words in, arrays and words out. The
//! library defines what they mean, and `python/raylet` how they are called.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `scene` | A scene as Python holds it |
//! | `simulate` | The light of a scene on its sensor |
//! | `design` | Holograms and designs that a scene describes |
//! | `linearised_system` | A system as a function of pixels and parameters, with its gradient |
//! | `rays` | Rays of another tracer at a system's element and on its sensor |
//! | `trace` | Single rays through a system |
//! | `inspect` | What a system looks like: its parts, its section, its elements |
//! | `fabrication` | Elements as files that foundries and other programs take |
//! | `exchange` | Measured maps, and fields of other programs |
//! | `lenses` | Lens files that are written, and lenses by name |
//! | `files` | Files that Python writes: complete or not at all, and never in place of foreign ones |
//! | `arrays` | NumPy arrays that are read in place |
//! | `document` | Documents of Python as trees that the library decodes |
//! | `typed` | Arrays and dictionaries that declare their Python types; type stubs are made of these |
//! | `refusal` | Refusals of the library as Python exceptions |
//! | `watch` | Long work: without Python's lock, and cancelled when the user requests it |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod arrays;
mod design;
mod document;
mod exchange;
mod fabrication;
mod files;
mod inspect;
mod lenses;
mod linearised_system;
mod rays;
mod refusal;
mod scene;
mod simulate;
mod trace;
mod typed;
mod watch;

/// The extension module. Its words are those of the library; the package around it is what users meet.
#[pyo3::pymodule]
mod _raylet {
    #[pymodule_export]
    use crate::design::{design, hologram};
    #[pymodule_export]
    use crate::exchange::{read_beam, read_map, unit_factor, write_beam};
    #[pymodule_export]
    use crate::fabrication::{export_array, export_file, export_scene, read_masks};
    #[pymodule_export]
    use crate::files::write_files;
    #[pymodule_export]
    use crate::inspect::{check, element, glasses, layout, parts, schema, sensor_panels};
    #[pymodule_export]
    use crate::lenses::{LensFolder, catalog, export_lens, export_lens_file};
    #[pymodule_export]
    use crate::linearised_system::{LinearisedSystem, Passage};
    #[pymodule_export]
    use crate::rays::{beams, gather, gather_adjoint, scatter, scatter_adjoint};
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::trace::{chief_landing, trace, trace_adjoint};

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
