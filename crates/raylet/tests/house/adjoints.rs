//! The rule on adjoints: each stands below its forward step, in a file with a dot-product test.

use crate::source::Source;

/// Adjoints without a forward step above them, or without a test.
pub(crate) fn lone_adjoints(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in sources {
        let tested = text.contains("dot_product") || text.contains("inner_product");
        for name in functions(text) {
            let Some(forward) = name.strip_suffix("_adjoint") else {
                continue;
            };
            let up = text.find(&format!("fn {forward}"));
            let down = text.find(&format!("fn {name}"));
            if up >= down {
                found.push(format!("{path}: {name} has no forward"));
            }
            if !tested {
                found.push(format!("{path}: {name} has no dot-product test"));
            }
        }
    }
    found
}

/// The names of the functions of a text.
fn functions(text: &str) -> impl Iterator<Item = &str> {
    let heads = text.split("fn ").skip(1);
    heads.map(|head| {
        let end = head.find(|c: char| !c.is_alphanumeric() && c != '_');
        &head[..end.unwrap_or(head.len())]
    })
}
