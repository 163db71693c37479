//! The cells of an element that its aperture leaves open: those whose centre lies inside of it.

use crate::optics::aperture::Aperture;
use crate::optics::phase::placement::Placement;
use crate::optics::surface_coordinates::SurfaceCoordinates;

/// The value of a cell outside of the aperture: it has none. Files hold level 0 or height 0 there.
pub(crate) const CLOSED: f64 = f64::NAN;

/// An aperture over a grid of cells.
#[derive(Clone, Debug)]
pub(crate) struct OpenPart {
    /// The aperture on the axes of the element.
    pub aperture: Aperture,
    /// Where the axes of the cells stand on the element.
    pub placement: Placement,
    /// The lengths along a curved surface that the cells are counted in, where they are.
    pub along: Option<SurfaceCoordinates>,
    /// Distance of neighbouring cells along x and y, in mm.
    pub pitch_mm: [f64; 2],
}

impl OpenPart {
    /// Whether the centre of the cell [x, y] of a grid of this size lies inside.
    fn holds(&self, [x, y]: [usize; 2], [nx, ny]: [usize; 2]) -> bool {
        let [dx, dy] = self.pitch_mm;
        let at = |i: usize, count: usize, pitch: f64| {
            (i as f64 - 0.5 * (count.saturating_sub(1)) as f64) * pitch
        };
        let own = self.placement.outwards(at(x, nx, dx), at(y, ny, dy));
        let place = match &self.along {
            Some(along) => along.point_at(own),
            None => Some(own),
        };
        place.is_some_and(|[x, y]| self.aperture.contains(x, y))
    }

    /// Takes the values of row `y` from the cells outside.
    pub(crate) fn close(&self, y: usize, size: [usize; 2], values: &mut [f64]) {
        for (x, value) in values.iter_mut().enumerate() {
            if !self.holds([x, y], size) {
                *value = CLOSED;
            }
        }
    }

    /// How many cells lie outside.
    pub(crate) fn closed(&self, size: [usize; 2]) -> u64 {
        let [nx, ny] = size;
        let row = |y| (0..nx).filter(|x| !self.holds([*x, y], size)).count() as u64;
        (0..ny).map(row).sum()
    }

    /// The largest distance along x or y from the middle of the cells to the edge of the aperture, in mm.
    pub(crate) fn reach(&self) -> Option<f64> {
        let seen = self.aperture.seen_from(self.placement);
        let bounds = seen.bounds().filter(|_| self.along.is_none())?;
        Some(bounds.iter().fold(0.0, |far, side| far.max(side.abs())))
    }
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::open_part::OpenPart;
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::conic::Conic;
    use crate::optics::phase::placement::Placement;
    use crate::optics::shape::Shape;
    use crate::optics::surface_coordinates::SurfaceCoordinates;

    fn part(aperture: Aperture) -> OpenPart {
        OpenPart {
            aperture,
            placement: Placement::NONE,
            along: None,
            pitch_mm: [1.0, 0.5],
        }
    }

    #[test]
    fn centres_decide() {
        // Centres at −1, 0, 1 along x and −0.5, 0, 0.5 along y: the corners are 1.118 from the middle.
        let disc = part(Aperture::disc(1.1));
        assert_eq!((disc.closed([3, 3]), disc.reach()), (4, Some(1.1)));
        let ring = part(disc.aperture.clone().blocked(Aperture::disc(0.1)));
        assert_eq!(ring.closed([3, 3]), 5);
        let mut row = [1.0, 2.0, 3.0];
        ring.close(1, [3, 3], &mut row);
        assert!(row[0] == 1.0 && row[1].is_nan() && row[2] == 3.0);
    }

    #[test]
    fn cells_stand_where_their_layer_does() {
        // A half plane x < 0.75 of the element, seen by cells that are shifted by 0.5 and turned by 90 degrees.
        let half = Outline::Rectangle {
            half_x: 5.0,
            half_y: 5.0,
        };
        let aperture = Aperture {
            outline: half,
            centre: [-4.25, 0.0],
        };
        let shifted = OpenPart {
            placement: Placement {
                centre: [0.5, 0.0],
                rotation: std::f64::consts::FRAC_PI_2,
            },
            ..part(aperture)
        };
        // x = 0.5 − v, and the rows have v = −0.5, 0 and 0.5.
        let closed = [0, 1, 2].map(|y| {
            let mut row = [0.0];
            shifted.close(y, [1, 3], &mut row);
            row[0].is_nan()
        });
        assert_eq!(closed, [true, false, false]);
    }

    #[test]
    fn lengths_along_a_surface_are_longer_than_their_projections() {
        // On a sphere of radius 2 the point at x = 1 has the length 2 asin(1/2) = 1.047.
        let sphere = Shape::Conic(Conic {
            curvature: 0.5,
            conic: 0.0,
        });
        let curved = OpenPart {
            along: SurfaceCoordinates::of(&sphere),
            ..part(Aperture::disc(0.999))
        };
        assert_eq!(part(Aperture::disc(0.999)).closed([3, 1]), 2);
        assert_eq!(curved.closed([3, 1]), 0);
        assert_eq!(curved.reach(), None);
    }
}
