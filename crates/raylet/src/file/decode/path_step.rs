//! The steps of an address in a document, such as `element[1].surface[0].radius_mm`.

/// A step from a value of a document to one inside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PathStep {
    /// To the value of a key of a table.
    Key(String),
    /// To an entry of a list, counted from zero.
    Index(usize),
}

/// The steps of an address: `a[1].b` is key, index, key. Where it is none, nothing stands in place of a step.
pub(crate) fn path_steps(path: &str) -> impl Iterator<Item = Option<PathStep>> + '_ {
    path.split('.').flat_map(|part| {
        let (key, indices) = part.split_at(part.find('[').unwrap_or(part.len()));
        let key = (!key.is_empty()).then(|| PathStep::Key(key.to_owned()));
        let whole = indices.is_empty() || indices.ends_with(']');
        let indices = indices.split_terminator(']').map(move |index| {
            let index = index.strip_prefix('[').filter(|_| whole)?;
            Some(PathStep::Index(index.parse().ok()?))
        });
        std::iter::once(key).chain(indices)
    })
}

#[cfg(test)]
mod tests {
    use crate::file::decode::path_step::PathStep::{Index, Key};
    use crate::file::decode::path_step::{PathStep, path_steps};

    fn all(path: &str) -> Option<Vec<PathStep>> {
        path_steps(path).collect()
    }

    #[test]
    fn addresses_are_keys_and_indices() {
        let key = |name: &str| Key(name.into());
        let steps = vec![key("a"), Index(1), Index(20), key("b_c"), key("d")];
        assert_eq!(all("a[1][20].b_c.d"), Some(steps));
    }

    #[test]
    fn what_is_no_address_has_a_gap() {
        for path in [
            "", ".", "a.", "[1]", "a[", "a[1", "a[x]", "a[1]b", "a[-1]", "a[]",
        ] {
            assert_eq!(all(path), None, "{path}");
        }
    }
}
