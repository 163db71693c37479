//! What a run leaves behind: its document, its fields, and how alike two of them are.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `report` | The document of a run, `result.json` |
//! | `hop_entry` | One hop of a run: its plan, rays, power and error |
//! | `light_metrics` | Power, peak and spot of the light on a sensor |
//! | `channel` | One run of a document: one wavelength, and in a sweep one field and one distance |
//! | `run_table` | The runs of a document as a table, a row for each |
//! | `rim` | What a report says of the rim of a surface |
//! | `reference_step` | What a reference did, as `result.json` has it |
//! | `machine` | The program and the machine that a result was made by |
//! | `document` | JSON documents whose numbers are all finite |
//! | `result_folder` | Folders of results: the document and the fields, written and read |
//! | `comparison` | How alike the fields of two runs are, channel by channel and in total |
//! | `field_source` | Fields that a user names: a folder of results, a field.npz, a beam file |
//! | `conversion` | Fields from one kind of file to another |

pub mod channel;
pub mod comparison;
pub mod conversion;
pub mod document;
pub(crate) mod field_source;
pub mod hop_entry;
pub mod light_metrics;
pub mod machine;
pub mod reference_step;
pub mod report;
pub mod result_folder;
pub mod rim;
pub mod run_table;
