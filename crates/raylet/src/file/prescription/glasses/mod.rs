//! Glasses of prescriptions.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `formula_table` | A formula of dispersion as the table of indices that a scene can hold |
//! | `glass_file` | Glasses of users: catalogues in the format of Zemax (.agf) |
//! | `glass_choice` | The media of a prescription: by names of the catalogue, or by numbers of the file |
//! | `glass_mutations_test` | Tests: altered catalogues of glasses give a medium or an error |

pub(crate) mod formula_table;
pub(crate) mod glass_choice;
pub(crate) mod glass_file;
#[cfg(test)]
mod glass_mutations_test;
