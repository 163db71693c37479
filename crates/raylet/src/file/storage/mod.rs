//! How results reach the disk: whole, under locks, and only over what raylet wrote.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `parent_folders` | The folders around a path, which may not be there yet |
//! | `hidden` | Files and folders that are written under a hidden name, and take their own name when they are complete |
//! | `lock` | Locks that the kernel holds, and that end with their process |
//! | `unfinished` | Drafts, locks and folders that this process has on the disk only while it works |
//! | `seal` | How raylet recognises folders that it wrote: checksums in their document |
//! | `sweep` | What killed runs left behind: hidden drafts and locks that nobody holds any more |
//! | `folder` | Output folders that appear whole or not at all |
//! | `own_file` | Single files that raylet may replace: its own, unchanged since |
//! | `run_folder` | The folder in which one run at a time keeps what it has, such as the checkpoints of a design |
//! | `checkpoint` | Checkpoints of a run: a file that is whole or not there, and the one before it |
//! | `partial` | A random run that is not finished: its parts so far in a file, from which it goes on later |
//! | `killed_test` | Tests: results whose writers are killed at any moment |

pub mod checkpoint;
pub mod folder;
pub mod hidden;
#[cfg(test)]
mod killed_test;
pub(crate) mod lock;
pub mod own_file;
pub(crate) mod parent_folders;
pub mod partial;
pub mod run_folder;
pub(crate) mod seal;
pub(crate) mod sweep;
pub mod unfinished;
