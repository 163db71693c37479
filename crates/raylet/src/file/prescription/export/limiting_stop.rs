//! Which surface limits the light on the axis: the aperture stop of a prescription.

use crate::file::prescription::export::lens_edges::LensEdge;
use crate::file::prescription::first_order::FirstOrder;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::sequential::{Action, ApertureRule, Behind, Face, Sequential};

/// Rims whose shares of the light differ by less are equal.
const EQUAL: f64 = 1e-9;

/// The radius of the rim of a surface in mm; none where it has no rim.
pub(crate) fn rim_radius(face: &Face) -> Option<f64> {
    let outline = face.outline.as_ref().and_then(LensEdge::of);
    match (outline, face.semi_diameter) {
        (Some(edge), _) => Some(edge.radius()),
        (None, size) => size.map(|(size, _)| size),
    }
}

/// Makes the surface that limits the light on the axis the stop, and gives the entrance pupil that its rim has; false where no
/// rim limits light from the object, and the first one is the stop.
pub(crate) fn limit_light(lens: &mut Sequential, media: &[MediumBehind], wavelength: f64) -> bool {
    let turns = |face: &Face| matches!(face.action, Action::Turn(_));
    let mut places = lens.surface.iter().skip(1);
    lens.stop = 1 + places.position(|face| !turns(face)).unwrap_or(0);
    lens.aperture = ApertureRule::EntrancePupil(2.0);
    let Ok(unit) = FirstOrder::of(lens, media, wavelength) else {
        return false;
    };
    let mut best: Option<(f64, bool, usize)> = None;
    for (i, face) in lens.surface.iter().enumerate().skip(1) {
        let (Some(rim), false) = (rim_radius(face), turns(face) || i == lens.image()) else {
            continue;
        };
        let [height, _] = unit.heights(i, [0.0; 2]);
        let share = rim / height;
        let plain = is_plain(i, lens, media);
        let better = best.is_none_or(|(least, stops, _)| {
            share < least * (1.0 - EQUAL) || (share <= least * (1.0 + EQUAL) && plain && !stops)
        });
        if share.is_finite() && better {
            best = Some((share, plain, i));
        }
    }
    let Some((share, _, stop)) = best else {
        return false;
    };
    let first = lens.stop;
    lens.stop = stop;
    lens.aperture = ApertureRule::EntrancePupil(2.0 * share);
    let filled = fill_stop(lens, media, wavelength, share);
    if !filled {
        lens.stop = first;
    }
    filled
}

/// Gives the lens the entrance pupil whose light fills the rim of its stop.
fn fill_stop(lens: &mut Sequential, media: &[MediumBehind], wavelength: f64, share: f64) -> bool {
    let rim = lens.surface.get(lens.stop).and_then(rim_radius);
    let first = FirstOrder::of(lens, media, wavelength);
    match (first, rim) {
        (Ok(first), Some(rim)) => {
            let width = 2.0 * share * rim / first.stop_radius;
            lens.aperture = ApertureRule::EntrancePupil(width);
            true
        }
        _ => false,
    }
}

/// Whether a surface only limits the light.
fn is_plain(i: usize, lens: &Sequential, media: &[MediumBehind]) -> bool {
    let same = match (media.get(i - 1), media.get(i)) {
        (Some(before), Some(behind)) => before.material == behind.material,
        _ => false,
    };
    let face = lens.surface.get(i);
    same && face.is_some_and(|face| {
        face.action == Action::Border && face.phase.is_empty() && face.behind != Behind::Reflected
    })
}
