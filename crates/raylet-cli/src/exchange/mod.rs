//! Verbs that exchange files with other programs.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `import` | `raylet import LENS`: a scene from the file of a program for lens design |
//! | `export` | `raylet export SOURCE -o FILE`: an element as files that foundries and other programs take, or a scene as a lens file |
//! | `lenses` | `raylet lenses [FOLDER]`: the lens files of a folder, or the lenses that raylet carries |
//! | `convert` | `raylet convert SOURCE -o FILE`: a field as a beam file of OpticStudio, or back |

pub(crate) mod convert;
pub(crate) mod export;
pub(crate) mod import;
pub(crate) mod lenses;
