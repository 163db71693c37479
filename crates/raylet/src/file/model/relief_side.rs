//! On which side of an interface a relief stands.
//!
//! A relief of a lens's own material reaches into the other medium by its height h. Light runs h in the material instead of
//! that medium, whichever of the two comes first: phase k(n − n′)h, n′ the index of the medium whose place it takes.

use crate::file::decode::fault::Fault;
use crate::file::scene::layer::Side;
use crate::file::scene::scene_file::Scene;

/// Where a relief of index `own` stands between two media, before and behind. Nothing where its material is neither and
/// no side is stated.
pub(crate) fn side_of_relief(
    own: f64,
    [before, behind]: [f64; 2],
    stated: Option<Side>,
) -> Option<Side> {
    match stated {
        Some(side) => Some(side),
        None if before == behind || own == behind => Some(Side::Before),
        None => (own == before).then_some(Side::Behind),
    }
}

/// A relief of a third material whose side is not stated, at the path of its layer.
pub(crate) fn unplaced(scene: &Scene, path: &str) -> Fault {
    let found = "a material that is neither the medium before the element nor the one behind";
    let expected = "one of the two, or stands_in = \"before\" or \"behind\"";
    scene.fault(&format!("{path}.glass"), found, expected)
}

#[cfg(test)]
mod tests {
    use crate::file::model::relief_side::side_of_relief;
    use crate::file::scene::layer::Side;

    #[test]
    fn a_relief_of_a_lens_stands_in_the_other_medium() {
        let (air, glass, resin) = (1.0, 1.5, 1.6);
        let side = |own, media| side_of_relief(own, media, None);
        assert_eq!(side(glass, [glass, air]), Some(Side::Behind));
        assert_eq!(side(glass, [air, glass]), Some(Side::Before));
        assert_eq!(side(air, [air, glass]), Some(Side::Behind));
        assert_eq!(side(resin, [air, air]), Some(Side::Before));
        assert_eq!(side(resin, [air, glass]), None);
        let behind = side_of_relief(resin, [glass, air], Some(Side::Behind));
        assert_eq!(behind, Some(Side::Behind));
    }
}
