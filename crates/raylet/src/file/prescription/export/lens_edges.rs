//! Apertures in the forms that prescriptions hold: circles, rings, rectangles and ellipses.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::file::prescription::outline::CORNERS;
use crate::file::scene::aperture::{Aperture, Polygon};

/// How far corners may lie from an ellipse, as a share of its size.
const ON_ELLIPSE: f64 = 1e-9;

/// The form of an edge, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum EdgeForm {
    /// Between two radii; the first is zero for a circle.
    Ring([f64; 2]),
    /// Within half widths along x and y.
    Rectangle([f64; 2]),
    /// Within half axes along x and y.
    Ellipse([f64; 2]),
}

/// An edge of an aperture, or of what is blocked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LensEdge {
    /// Its form.
    pub form: EdgeForm,
    /// Its centre in mm.
    pub centre_mm: [f64; 2],
    /// Its turn in degrees from x towards y.
    pub rotation_deg: f64,
    /// Whether it is a circle about another form.
    pub wider: bool,
}

impl LensEdge {
    /// The outline of an aperture without what is blocked in it; none where it has no outline.
    pub(crate) fn of(aperture: &Aperture) -> Option<Self> {
        let edge = |form, centre_mm| Self {
            form,
            centre_mm,
            rotation_deg: 0.0,
            wider: false,
        };
        if let Some(disc) = &aperture.disc {
            return Some(edge(EdgeForm::Ring([0.0, disc.radius_mm]), disc.centre_mm));
        }
        if let Some(ring) = &aperture.annulus {
            let radii = [ring.inner_radius_mm, ring.outer_radius_mm];
            return Some(edge(EdgeForm::Ring(radii), ring.centre_mm));
        }
        if let Some(one) = &aperture.rectangle {
            let mut half = [0.5 * one.width_mm, 0.5 * one.height_mm];
            let quarters = one.rotation_deg / 90.0;
            let mut rotation_deg = one.rotation_deg;
            if quarters.fract() == 0.0 {
                rotation_deg = 0.0;
                if quarters.rem_euclid(2.0) == 1.0 {
                    half.reverse();
                }
            }
            return Some(Self {
                rotation_deg,
                ..edge(EdgeForm::Rectangle(half), one.centre_mm)
            });
        }
        if let Some(one) = &aperture.regular_polygon {
            let circle = edge(EdgeForm::Ring([0.0, one.radius_mm]), one.centre_mm);
            return Some(circle.widened());
        }
        let one = aperture.polygon.as_ref()?;
        Some(ellipse(one).unwrap_or_else(|| {
            let radii = one.corners_mm.iter().map(|[x, y]| x.hypot(*y));
            let radius = radii.fold(0.0, f64::max);
            edge(EdgeForm::Ring([0.0, radius]), one.centre_mm).widened()
        }))
    }

    /// The same as a circle about another form.
    fn widened(self) -> Self {
        Self {
            wider: true,
            ..self
        }
    }

    /// The circle about it.
    pub(crate) fn circle(self) -> Self {
        Self {
            form: EdgeForm::Ring([0.0, self.radius()]),
            rotation_deg: 0.0,
            ..self.widened()
        }
    }

    /// The radius of the circle about it, from its own centre, in mm.
    pub(crate) fn radius(&self) -> f64 {
        match self.form {
            EdgeForm::Ring([_, radius]) => radius,
            EdgeForm::Rectangle([x, y]) => x.hypot(y),
            EdgeForm::Ellipse([x, y]) => x.max(y),
        }
    }

    /// Whether it is a circle about the axis.
    pub(crate) fn is_centred_circle(&self) -> bool {
        matches!(self.form, EdgeForm::Ring([inner, _]) if inner == 0.0)
            && self.centre_mm == [0.0; 2]
    }
}

/// The ellipse whose polygon an import made; none for another polygon.
fn ellipse(polygon: &Polygon) -> Option<LensEdge> {
    let corners = &polygon.corners_mm;
    if corners.len() != CORNERS {
        return None;
    }
    let [a, b] = [corners.first()?, corners.get(CORNERS / 4)?];
    let (first, second) = (a[0].hypot(a[1]), b[0].hypot(b[1]));
    let turn = a[1].atan2(a[0]);
    let on_it = |(i, corner): (usize, &[f64; 2])| {
        let (sin, cos) = (TAU * i as f64 / CORNERS as f64).sin_cos();
        let [x, y] = [first * cos, second * sin];
        let [turn_sin, turn_cos] = [turn.sin(), turn.cos()];
        let place = [turn_cos * x - turn_sin * y, turn_sin * x + turn_cos * y];
        let off = (place[0] - corner[0]).hypot(place[1] - corner[1]);
        off <= ON_ELLIPSE * first.max(second)
    };
    let mut half = [first, second];
    let mut rotation = turn;
    if (turn.abs() - FRAC_PI_2).abs() < ON_ELLIPSE {
        half.reverse();
        rotation = 0.0;
    }
    corners.iter().enumerate().all(on_it).then_some(LensEdge {
        form: EdgeForm::Ellipse(half),
        centre_mm: polygon.centre_mm,
        rotation_deg: rotation.to_degrees(),
        wider: false,
    })
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::export::lens_edges::{EdgeForm, LensEdge};
    use crate::file::prescription::outline::RawEdge;
    use crate::file::scene::aperture::{Aperture, Rectangle, RegularPolygon};

    #[test]
    fn forms_are_those_of_the_apertures() {
        for rotation in [0.0, 30.0] {
            let aperture = RawEdge::Ellipse([2.0, 3.0]).aperture([0.5, 0.0], rotation, 1.0);
            let edge = LensEdge::of(&aperture.unwrap()).unwrap();
            let EdgeForm::Ellipse([x, y]) = edge.form else {
                panic!("{edge:?}");
            };
            assert!((x - 2.0).abs() < 1e-12 && (y - 3.0).abs() < 1e-12);
            assert!((edge.rotation_deg - rotation).abs() < 1e-12);
            assert_eq!(edge.centre_mm, [0.5, 0.0]);
        }
        let aperture = Aperture {
            rectangle: Some(Rectangle {
                width_mm: 2.0,
                height_mm: 6.0,
                rotation_deg: -90.0,
                centre_mm: [0.0; 2],
            }),
            ..Aperture::default()
        };
        let edge = LensEdge::of(&aperture).unwrap();
        assert_eq!(
            (edge.form, edge.rotation_deg),
            (EdgeForm::Rectangle([3.0, 1.0]), 0.0)
        );
        assert!((edge.circle().radius() - 10f64.sqrt()).abs() < 1e-12);
        let aperture = Aperture {
            regular_polygon: Some(RegularPolygon {
                sides: 6,
                radius_mm: 2.0,
                rotation_deg: 0.0,
                centre_mm: [0.0; 2],
            }),
            ..Aperture::default()
        };
        let edge = LensEdge::of(&aperture).unwrap();
        assert!(edge.wider && edge.is_centred_circle());
        assert_eq!(LensEdge::of(&Aperture::default()), None);
    }
}
