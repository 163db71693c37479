//! The outline of an aperture as polygons for a mask file.
//!
//! What is open has an even depth, 0 outermost, and what is blocked in it an odd one: a ring is a disc of depth 0 with one of
//! depth 1 in it. So no polygon has a hole.

use std::f64::consts::TAU;
use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_choices::choice_fault;
use crate::optics::aperture::{Aperture, Outline};

/// Fewest and most corners of a circle. Records of a GDSII file hold 8190 points.
const CORNERS: [f64; 2] = [32.0, 8000.0];

/// A polygon of the outline of an aperture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaskOutline {
    /// How many outlines lie around it: even where it is open, odd where it is blocked.
    pub depth: u16,
    /// Its corners in database units from the middle of the cells.
    pub corners: Vec<[i64; 2]>,
}

/// All polygons of an aperture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Outlines {
    /// The polygons, what is around before what is inside.
    pub polygons: Vec<MaskOutline>,
    /// The largest distance in database units of a circle from its polygon.
    pub off: f64,
}

impl Outlines {
    /// The outlines of an aperture on the axes of the cells, for a database unit in nm.
    ///
    /// # Errors
    /// Corners beyond 32 bits.
    pub(crate) fn new(file: &Path, aperture: &Aperture, unit_nm: f64) -> Result<Self, Fault> {
        let mut outlines = Self::default();
        let per_mm = 1e6 / unit_nm;
        outlines.add(aperture, [0.0; 2], (0, per_mm));
        let corners = outlines.polygons.iter().flat_map(|one| &one.corners);
        let far = corners.flatten().map(|at| at.abs()).max().unwrap_or(0);
        match far > i64::from(i32::MAX) {
            false => Ok(outlines),
            true => {
                let found = format!("an aperture that reaches to {:.3} mm", far as f64 / per_mm);
                let expected = format!("at most {:.3} mm", f64::from(i32::MAX) / per_mm);
                Err(choice_fault(file, "aperture_layer", found, expected))
            }
        }
    }

    fn add(&mut self, aperture: &Aperture, [x, y]: [f64; 2], (depth, per_mm): (u16, f64)) {
        let centre = [x + aperture.centre[0], y + aperture.centre[1]];
        match &aperture.outline {
            Outline::Open => {}
            Outline::Disc { radius } => self.circle(*radius, centre, (depth, per_mm)),
            Outline::Annulus { inner, outer } => {
                self.circle(*outer, centre, (depth, per_mm));
                if *inner > 0.0 {
                    self.circle(*inner, centre, (depth + 1, per_mm));
                }
            }
            Outline::Rectangle { half_x, half_y } => {
                let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
                let corners = signs.map(|[i, j]| [i * half_x, j * half_y]);
                self.polygon(&corners, centre, (depth, per_mm));
            }
            Outline::Polygon { corners } => self.polygon(corners, centre, (depth, per_mm)),
            Outline::Blocked { open, by } => {
                self.add(open, centre, (depth, per_mm));
                self.add(by, centre, (depth.saturating_add(1), per_mm));
            }
        }
    }

    /// A circle as a polygon that leaves it by at most one database unit, or that has as many corners as may be.
    fn circle(&mut self, radius: f64, centre: [f64; 2], (depth, per_mm): (u16, f64)) {
        let units = radius * per_mm;
        // Half of the angle of a side whose middle is a unit inside the circle.
        let half = (1.0 - 1.0 / units.max(2.0)).acos();
        let [fewest, most] = CORNERS;
        let count = (0.25 * TAU / (2.0 * half)).ceil() * 4.0;
        let count = count.clamp(fewest, most);
        self.off = self.off.max(units * (1.0 - (0.5 * TAU / count).cos()));
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / count).sin_cos();
            [radius * cos, radius * sin]
        };
        let corners: Vec<[f64; 2]> = (0..count as usize).map(corner).collect();
        self.polygon(&corners, centre, (depth, per_mm));
    }

    fn polygon(&mut self, corners: &[[f64; 2]], [x, y]: [f64; 2], (depth, per_mm): (u16, f64)) {
        let mut list: Vec<[i64; 2]> = (corners.iter())
            .map(|[u, v]| [(x + u) * per_mm, (y + v) * per_mm].map(|at| at.round() as i64))
            .collect();
        // Corners that fall together on the grid of units are one.
        list.dedup();
        if list.len() > 1 && list.first() == list.last() {
            list.pop();
        }
        if list.len() >= 3 {
            self.polygons.push(MaskOutline {
                depth,
                corners: list,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use crate::file::fabrication::masks::outline::{MaskOutline, Outlines};
    use crate::optics::aperture::{Aperture, Outline};

    /// Twice the area by the corners, positive where they run against the clock.
    fn area(outline: &MaskOutline) -> f64 {
        let corners = &outline.corners;
        let next = corners.iter().cycle().skip(1);
        let sides = corners.iter().zip(next);
        0.5 * sides
            .map(|([x, y], [u, v])| (x * v - u * y) as f64)
            .sum::<f64>()
    }

    #[test]
    fn circles_are_off_by_a_unit() {
        let made = Outlines::new(Path::new("a.gds"), &Aperture::disc(0.5), 1.0).unwrap();
        let [disc] = &made.polygons[..] else {
            panic!("{} polygons", made.polygons.len());
        };
        assert!(made.off <= 1.0 && made.off > 0.9, "{}", made.off);
        let exact = PI * 5e5_f64.powi(2);
        assert!((area(disc) / exact - 1.0).abs() < 3e-6);
        for [x, y] in &disc.corners {
            assert!(((*x as f64).hypot(*y as f64) - 5e5).abs() < 0.75);
        }
        // A large one has as many corners as a record holds.
        let wide = Outlines::new(Path::new("a.gds"), &Aperture::disc(100.0), 1.0).unwrap();
        assert_eq!(wide.polygons[0].corners.len(), 8000);
        assert!((wide.off - 7.7).abs() < 0.1, "{}", wide.off);
        let far = Outlines::new(Path::new("a.gds"), &Aperture::disc(3000.0), 1.0).unwrap_err();
        assert!(far.to_string().contains("aperture_layer"), "{far}");
    }

    #[test]
    fn what_is_blocked_lies_deeper() {
        let ring = Aperture {
            outline: Outline::Annulus {
                inner: 0.2,
                outer: 0.5,
            },
            centre: [0.1, 0.0],
        };
        let bar = Aperture::turned_rectangle(1.0, 0.02, 0.0, [0.0, 0.3]);
        let open = ring.blocked(bar.clone().blocked(Aperture::disc(0.01)));
        let made = Outlines::new(Path::new("a.gds"), &open, 1.0).unwrap();
        let depths: Vec<u16> = made.polygons.iter().map(|one| one.depth).collect();
        assert_eq!(depths, [0, 1, 1, 2]);
        assert_eq!(area(&made.polygons[2]), 2e6 * 4e4);
        assert_eq!(made.polygons[2].corners[0], [-1_000_000, 280_000]);
    }
}
