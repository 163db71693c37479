//! Apertures of a Zemax file's surfaces: outlines, obscurations, and where they stand.

use crate::file::scene::aperture::{Annulus, Aperture, Disc, Polygon, Rectangle};

/// Corners of the polygon that stands for an ellipse.
const CORNERS: usize = 360;

/// An aperture record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RawEdge {
    /// Open between two radii.
    Ring([f64; 2]),
    /// Open within the half widths of a rectangle.
    Rectangle([f64; 2]),
    /// Open within the half axes of an ellipse.
    Ellipse([f64; 2]),
}

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

impl RawEdge {
    /// The aperture in mm about a centre in the unit of the file; none without an inside.
    pub(crate) fn aperture(self, centre: [f64; 2], unit: f64) -> Option<Aperture> {
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
                    rotation_deg: 0.0,
                    centre_mm,
                });
            }
            Self::Ellipse(_) if large(first) && large(second) => {
                let corner = |i: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / CORNERS as f64).sin_cos();
                    [first * cos, second * sin]
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
