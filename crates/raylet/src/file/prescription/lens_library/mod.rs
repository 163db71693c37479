//! Lenses by name: those that raylet carries, and folders of lens files of users.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `lens_facts` | What a list of lenses says of one: its maker, focal length, diameter |
//! | `lens_catalog` | The lens files that raylet carries, by part number |
//! | `lens_folder` | A folder of lens files, and how it is searched |
//! | `folder_index` | The index of a folder as a file |
//! | `lens_library_test` | Tests: the catalogue, and folders of lens files |

pub(crate) mod folder_index;
pub mod lens_catalog;
pub mod lens_facts;
pub mod lens_folder;
#[cfg(test)]
mod lens_library_test;
