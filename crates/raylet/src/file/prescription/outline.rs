//! Apertures of surfaces from the numbers of a file: outlines and where they stand.

use crate::file::scene::aperture::{Annulus, Aperture, Disc, Polygon, Rectangle};

/// Corners of the polygon that stands for an ellipse.
pub(crate) const CORNERS: usize = 360;

/// An outline in the unit of its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RawEdge {
    /// Open between two radii.
    Ring([f64; 2]),
    /// Open within the half widths of a rectangle.
    Rectangle([f64; 2]),
    /// Open within the half axes of an ellipse.
    Ellipse([f64; 2]),
}

impl RawEdge {
    /// The aperture in mm about a centre in the unit of the file, turned from x towards y; none without an inside.
    pub(crate) fn aperture(
        self,
        centre: [f64; 2],
        rotation_deg: f64,
        unit: f64,
    ) -> Option<Aperture> {
        let centre_mm = centre.map(|at| at * unit);
        let (Self::Ring(sizes) | Self::Rectangle(sizes) | Self::Ellipse(sizes)) = self;
        let [first, second] = sizes.map(|size| size * unit);
        let large = |size: f64| size > 1e-12;
        let mut aperture = Aperture::default();
        match self {
            Self::Ring(_) if large(second) && !large(first) => {
                let radius_mm = second;
                aperture.disc = Some(Disc {
                    radius_mm,
                    centre_mm,
                });
            }
            Self::Ring(_) if second > first && large(first) => {
                aperture.annulus = Some(Annulus {
                    inner_radius_mm: first,
                    outer_radius_mm: second,
                    centre_mm,
                });
            }
            Self::Rectangle(_) if large(first) && large(second) => {
                aperture.rectangle = Some(Rectangle {
                    width_mm: 2.0 * first,
                    height_mm: 2.0 * second,
                    rotation_deg,
                    centre_mm,
                });
            }
            Self::Ellipse(_) if large(first) && large(second) => {
                let (turn_sin, turn_cos) = rotation_deg.to_radians().sin_cos();
                let corner = |i: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / CORNERS as f64).sin_cos();
                    let [x, y] = [first * cos, second * sin];
                    [turn_cos * x - turn_sin * y, turn_sin * x + turn_cos * y]
                };
                aperture.polygon = Some(Polygon {
                    corners_mm: (0..CORNERS).map(corner).collect(),
                    centre_mm,
                });
            }
            _ => return None,
        }
        Some(aperture)
    }
}
