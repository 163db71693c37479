//! Several runs side by side.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`simulate_all`] | Runs that share the threads and keep to one memory limit |
//! | `memory_watch` | The memory that runs take, measured while they work |

pub(crate) mod memory_watch;
pub mod simulate_all;
