//! The parts of a system cut by the plane of a drawing: their lines, symbols, glass and names.

#![expect(
    clippy::indexing_slicing,
    reason = "lines have a first and a last place, and points two coordinates"
)]

use raylet::engine::geometrical::layout_rays::cut;
use raylet::file::model::prescription::{Kind, Part};
use raylet::math::vec3::Vec3;
use raylet::optics::refraction::Interface;
use raylet::optics::screen::ScreenKind;

use crate::section_panel::{Curve, CurveKind, Label, Polygon};

/// Points along the cut of a part.
const POINTS: i32 = 1200;

/// Points of a drawn curve.
const DRAWN: usize = 80;

/// The plane of the drawing: global z to the right, and x or y up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub(crate) up: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) name: &'static str,
}

impl Plane {
    /// Where a point of space is drawn.
    pub(crate) fn at(&self, point: Vec3) -> [f64; 2] {
        [point.z, point.dot(self.up)]
    }
}

/// A place on the cut of a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) at: [f64; 2],
    /// Whether light may pass (or turn back) there.
    pub(crate) open: bool,
}

/// A part cut by the plane, as places from one end of its aperture to the other.
pub(crate) fn line(part: &Part, plane: &Plane, window: Option<[f64; 2]>) -> Vec<Place> {
    let Some([x0, x1, y0, y1]) = part.bounds() else {
        return Vec::new();
    };
    let frame = part.frame();
    let u = cut(frame, plane.normal);
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];

    // How far the line through the middle runs inside the box.
    let half = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
    let reach = (0..2)
        .map(|a| half[a] / u[a].abs().max(1e-12))
        .fold(f64::INFINITY, f64::min);
    let all = (0..=POINTS).filter_map(|i| {
        let t = reach * (2.0 * f64::from(i) / f64::from(POINTS) - 1.0);
        let (x, y) = (middle[0] + t * u[0], middle[1] + t * u[1]);
        let height = part.shape().height(x, y)?;
        let at = plane.at(frame.to_global(Vec3::new(x, y, height.z)));
        let open = part.aperture().is_none_or(|a| a.contains(x, y));
        Some(Place { at, open })
    });
    let shown = |p: &Place| window.is_none_or(|[lo, hi]| p.at[1] >= lo && p.at[1] <= hi);
    let places: Vec<Place> = all.filter(shown).collect();
    let ends = [
        places.iter().position(|p| p.open),
        places.iter().rposition(|p| p.open),
    ];
    match ends {
        [Some(first), Some(last)] => thinned(&places[first..=last]),
        _ => Vec::new(),
    }
}

/// At most some eighty places of a line, its ends among them.
fn thinned(places: &[Place]) -> Vec<Place> {
    let last = places.len() - 1;
    let count = DRAWN.min(last.max(1));
    (0..=count).map(|i| places[i * last / count]).collect()
}

/// The symbols of a part whose cut is `line`; the part before it stands at `before`.
pub(crate) fn symbols(
    part: &Part,
    line: &[Place],
    before: Option<Vec3>,
    plane: &Plane,
) -> Vec<Curve> {
    if line.len() < 2 {
        return Vec::new();
    }
    let here = plane.at(part.frame().origin);
    let from = before.map_or([here[0] - 1.0, here[1]], |point| plane.at(point));
    let travel = [here[0] - from[0], here[1] - from[1]];
    let (kind, side) = match part.kind {
        Kind::Surface(surface) if surface.interface == Interface::Reflect => {
            (CurveKind::Mirror, 1.0)
        }
        Kind::Surface(_) => (CurveKind::Surface, 1.0),
        Kind::Screen(screen) => match &screen.kind {
            ScreenKind::Stop(_) => (CurveKind::Stop, 1.0),
            ScreenKind::Sensor(_) => (CurveKind::Sensor, 1.0),
            ScreenKind::Doe(doe) if doe.reflect => (CurveKind::Doe, -1.0),
            ScreenKind::Doe(_) => (CurveKind::Doe, 1.0),
        },
    };

    // Symbols with a back and a front have it to the right of their points.
    let mut places = line.to_vec();
    let (first, last) = (places[0].at, places[places.len() - 1].at);
    let right = [last[1] - first[1], first[0] - last[0]];
    if (right[0] * travel[0] + right[1] * travel[1]) * side < 0.0 {
        places.reverse();
    }

    // A stop is drawn by its ends and by what stands inside; other parts where they are open.
    if kind == CurveKind::Stop {
        let mut curves = runs(&places, false, CurveKind::Surface);
        let points = points(&places);
        curves.push(Curve { points, kind });
        return curves;
    }
    runs(&places, true, kind)
}

/// The curves along which a part is open, or is not.
fn runs(places: &[Place], open: bool, kind: CurveKind) -> Vec<Curve> {
    let stretches = places.split(|place| place.open != open);
    stretches
        .filter(|stretch| stretch.len() > 1)
        .map(points)
        .map(|points| Curve { points, kind })
        .collect()
}

fn points(places: &[Place]) -> Vec<[f64; 2]> {
    places.iter().map(|place| place.at).collect()
}

/// The region between two cuts.
pub(crate) fn between(first: &[Place], second: &[Place]) -> Polygon {
    let (first, second) = (points(first), points(second));
    let mut points = first.clone();
    let chord = |line: &[[f64; 2]]| match (line.first(), line.last()) {
        (Some(a), Some(b)) => [b[0] - a[0], b[1] - a[1]],
        _ => [0.0; 2],
    };
    // The return path runs along the second cut against the first one's direction, so that sides do not cross.
    let ([ax, ay], [bx, by]) = (chord(&first), chord(&second));
    if ax * bx + ay * by > 0.0 {
        points.extend(second.iter().rev());
    } else {
        points.extend(second);
    }
    Polygon { points }
}

/// The name of an element at its first part, above it.
pub(crate) fn label(part: &Part, line: &[Place]) -> Option<Label> {
    let [index, count] = part.surface;
    if index > 0 {
        return None;
    }
    let text = match (part.named, count) {
        (true, _) => part.name.clone(),
        (false, 1) => part.word().to_owned(),
        (false, _) => String::from("lens"),
    };
    let top = points(line)
        .into_iter()
        .max_by(|a, b| a[1].total_cmp(&b[1]))?;
    Some(Label { at: top, text })
}

#[cfg(test)]
mod tests {
    use raylet::optics::polygon::{area, crosses_itself};

    use crate::part_section::{Place, between};

    /// A thick tilted plate seen close up, each face drawn either way: its sides never cross.
    #[test]
    fn glass_between_tilted_faces_does_not_cross_itself() {
        let cut = |ends: [[f64; 2]; 2]| ends.map(|at| Place { at, open: true });
        let (front, back) = (
            [[9.55, -0.77], [10.35, 0.58]],
            [[11.85, -0.77], [12.65, 0.58]],
        );
        for back in [back, [back[1], back[0]]] {
            let region = between(&cut(front), &cut(back)).points;
            assert!(!crosses_itself(&region), "{region:?}");
            assert!((area(&region).abs() - 2.3 * 1.35).abs() < 1e-12);
        }
    }
}
