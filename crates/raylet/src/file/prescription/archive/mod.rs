//! Archives of OpticStudio (.zar): a lens with its catalogues of glasses.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `lzw` | The compression of their files |
//! | `zar_block` | Blocks: the header and the place of each file |
//! | `zar_archive` | The files of an archive, unpacked within a limit on memory |
//! | `zar_lens` | The lens of an archive, its catalogues, and what is not used |
//! | `zar_writer` | Archives that tests write, compressed by an encoder of their own |
//! | `zar_test` | Tests: archives byte by byte, their lenses, glasses and faults |
//! | `zar_mutations_test` | Tests: altered archives give a scene or an error |

pub(crate) mod lzw;
pub(crate) mod zar_archive;
pub(crate) mod zar_block;
pub(crate) mod zar_lens;
#[cfg(test)]
mod zar_mutations_test;
#[cfg(test)]
mod zar_test;
#[cfg(test)]
mod zar_writer;
