//! The text that something was read from, so that later findings can still point into it.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::file::arrays::regular_file;
use crate::file::decode::fault::{Address, Excerpt, Fault};
use crate::file::decode::path_step::{PathStep, path_steps};

/// The largest scene that is read, in bytes. Numbers by the million belong in array files, and as a tree of values a text
/// takes up to 90 times as much memory.
const LARGEST_SCENE: u64 = 1_000_000;

/// A TOML file's name and text. The default is an empty text of no file: things made in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// The file the text stood in; names of other files in it are relative to its folder.
    pub file: PathBuf,
    /// The text itself.
    pub text: Arc<str>,
}

impl Origin {
    /// A text and the name of the file it belongs to, which is not opened.
    pub fn new(text: &str, file: &Path) -> Self {
        Self {
            file: file.to_path_buf(),
            text: text.into(),
        }
    }

    /// The whole text of a file.
    ///
    /// # Errors
    /// A file that is not regular, is larger than 1 MB, cannot be read, or is not UTF-8.
    pub(crate) fn read(file: &Path) -> Result<Self, Fault> {
        let refuse = |found: String| Fault::of_file(file, found, "a readable TOML file");
        let text = regular_file::read_text(file, LARGEST_SCENE).map_err(refuse)?;
        Ok(Self::new(&text, file))
    }

    /// A file named in the text: relative to the folder of this file.
    pub fn beside(&self, name: &Path) -> PathBuf {
        self.file
            .parent()
            .map_or_else(|| name.to_path_buf(), |folder| folder.join(name))
    }

    /// A fault of the field at a dotted path such as `element[2].surface[0].glass`.
    ///
    /// A path that leads nowhere is shown at the deepest table on its way that exists.
    pub(crate) fn fault(
        &self,
        path: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        let span = DeTable::parse(&self.text)
            .ok()
            .and_then(|table| locate(table.get_ref(), path));
        Fault::at(self.address(path.to_owned(), span), found, expected)
    }

    /// A fault of another file that the field at `path` names, reported at that field.
    pub(crate) fn fault_of_file(&self, path: &str, inner: Fault) -> Fault {
        let found = format!("{}: {}", inner.address, inner.found);
        Fault {
            hint: inner.hint,
            ..self.fault(path, found, inner.expected)
        }
    }

    /// The address of a range of bytes of this text.
    pub(crate) fn address(&self, path: String, span: Option<Range<usize>>) -> Address {
        Address {
            file: self.file.clone(),
            path,
            excerpt: span.map(|span| Excerpt::new(&self.text, span)),
        }
    }
}

/// The bytes of the value at a path, or of the deepest table on the way to it.
fn locate(root: &DeTable<'_>, path: &str) -> Option<Range<usize>> {
    let mut steps = path_steps(path).map_while(|step| step);
    let Some(PathStep::Key(first)) = steps.next() else {
        return None;
    };
    let mut value: &Spanned<DeValue<'_>> = root.get(first.as_str())?;
    for step in steps {
        let next = match (step, value.get_ref()) {
            (PathStep::Key(key), DeValue::Table(table)) => table.get(key.as_str()),
            (PathStep::Index(index), DeValue::Array(array)) => array.get(index),
            _ => None,
        };
        let Some(next) = next else { break };
        value = next;
    }
    Some(value.span())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::decode::fault::Fault;
    use crate::file::decode::origin::Origin;

    const TEXT: &str = "a = 1\n[[element]]\nkind = 'doe'\n[[element]]\nkind = 'lens'\n\
        [[element.surface]]\nglass = 'N-BK7'\n[[element.surface]]\nradius = 3\nlist = [1, [2, 3]]\n";

    fn place(path: &str) -> (usize, usize, String) {
        let origin = Origin::new(TEXT, Path::new("folder/x.toml"));
        let excerpt = origin.fault(path, "x", "y").address.excerpt;
        excerpt.map_or((0, 0, String::new()), |e| {
            let meant = e.text.chars().skip(e.column - 1).take(e.width).collect();
            (e.line, e.column, meant)
        })
    }

    #[test]
    fn paths_lead_to_their_values() {
        assert_eq!(place("a"), (1, 5, "1".into()));
        assert_eq!(place("element[0].kind"), (3, 8, "'doe'".into()));
        assert_eq!(
            place("element[1].surface[0].glass"),
            (7, 9, "'N-BK7'".into())
        );
        assert_eq!(
            place("element[1].surface[1].list[1][0]"),
            (10, 13, "2".into())
        );
        assert_eq!(place("nothing.here"), (0, 0, String::new()));
    }

    #[test]
    fn missing_keys_lead_to_their_table() {
        assert_eq!(
            place("element[1].surface[1].glass"),
            (8, 1, "[[element.surface]]".into())
        );
        assert_eq!(
            place("element[1].thickness_mm"),
            (4, 1, "[[element]]".into())
        );
    }

    #[test]
    fn other_files_are_reported_at_the_field_that_names_them() {
        let origin = Origin::new(TEXT, Path::new("folder/x.toml"));
        let file = origin.beside(Path::new("p.npy"));
        assert_eq!(file, Path::new("folder/p.npy"));
        let fault = origin.fault_of_file("a", Fault::of_file(&file, "2 axes", "3"));
        let text = fault.to_string();
        assert!(text.starts_with("folder/x.toml:1:5: a: found folder/p.npy: 2 axes, expected 3"));
    }
}
