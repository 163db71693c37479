//! Apertures of a Zemax file's surfaces: outlines and obscurations.

use crate::file::prescription::outline::RawEdge;

/// The record of a word: which outline, and whether it is what is blocked. None for another word.
pub(crate) fn edge_record(word: &str, sizes: [f64; 2]) -> Option<(RawEdge, bool)> {
    Some(match word {
        "CLAP" => (RawEdge::Ring(sizes), false),
        "OBSC" => (RawEdge::Ring(sizes), true),
        "SQAP" => (RawEdge::Rectangle(sizes), false),
        "SQOB" => (RawEdge::Rectangle(sizes), true),
        "ELAP" => (RawEdge::Ellipse(sizes), false),
        "ELOB" => (RawEdge::Ellipse(sizes), true),
        _ => return None,
    })
}
