//! A grid of pixels, and what lies between their centres.

use ndarray::Array2;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::optics::phase::placement::Placement;
use crate::optics::pixels::active_area::ActiveArea;
use crate::optics::pixels::pixel_shares::PixelShares;

/// What a pixel's value means between the pixel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PixelForm {
    /// Constant over the pixel, as on a real pixelated element.
    #[default]
    Box,
    /// One point sample at the centre that weighs the pixel's area.
    Point,
    // Constant in the outer half pixels.
    /// Bilinear interpolation of the transmission between the centres.
    Bilinear,
    /// Interpolation of samples of a limited band, zero beyond the grid: right to 8e-5 where they stand at twice the Nyquist
    /// rate.
    BandLimited,
}

impl PixelForm {
    /// Whether a pixel has one value, which no neighbour takes part in.
    pub(crate) fn is_even(self) -> bool {
        matches!(self, Self::Box | Self::Point)
    }
}

/// A grid of pixels, indexed [y, x]; row index grows with y.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Distance of neighbouring pixel centres along x and y, in mm.
    pub pitch: [f64; 2],
    /// Complex transmission of each pixel.
    pub values: Array2<Complex64>,
    /// What lies between the centres.
    pub form: PixelForm,
    /// The part of each pixel that has its value; the whole pixel for forms other than [`PixelForm::Box`].
    pub active: ActiveArea,
    /// Where the axes through their middle, along rows and columns, stand on the element.
    pub placement: Placement,
}

/// What makes up a pixel grid, whatever its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    /// Distance of neighbouring pixel centres along x and y, in mm.
    pub pitch: [f64; 2],
    /// Number of rows and of columns.
    pub shape: (usize, usize),
    /// What lies between the centres.
    pub form: PixelForm,
    /// The sides of the active area over the pitch.
    pub sides: [f64; 2],
    /// Where its axes stand on the element.
    pub placement: Placement,
}

impl Lattice {
    /// Whether one sampling holds for this grid and another: a grid without gaps is sampled by the other's nodes.
    pub(crate) fn agrees_with(&self, other: &Self) -> bool {
        let whole = [1.0; 2];
        self.pitch == other.pitch
            && self.shape == other.shape
            && self.form == other.form
            && self.placement == other.placement
            && (self.sides == other.sides || self.sides == whole || other.sides == whole)
    }
}

/// Where a place along an axis lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PixelPlace {
    /// In the active area of a column or row.
    Active(usize),
    /// Between two active areas.
    Gap,
    /// Outside the grid.
    Outside,
}

impl Pixels {
    /// The grid without its values.
    pub(crate) fn lattice(&self) -> Lattice {
        Lattice {
            pitch: self.pitch,
            shape: self.values.dim(),
            form: self.form,
            sides: self.active.sides,
            placement: self.placement,
        }
    }

    /// The transmission at (x, y); zero outside the grid.
    pub(crate) fn at(&self, x: f64, y: f64) -> Complex64 {
        if !self.active.is_whole() {
            let [u, v] = self.placement.inwards(x, y);
            return self.value_at(self.place(0, u), self.place(1, v));
        }
        let part = |(pixel, share)| self.values[pixel] * share;
        self.shares(x, y).map(part).sum()
    }

    /// The transmission of box pixels at a place along x and one along y.
    pub(crate) fn value_at(&self, column: PixelPlace, row: PixelPlace) -> Complex64 {
        match (column, row) {
            (PixelPlace::Outside, _) | (_, PixelPlace::Outside) => Complex64::ZERO,
            (PixelPlace::Active(column), PixelPlace::Active(row)) => self.values[[row, column]],
            _ => self.active.rest.transmission(),
        }
    }

    /// The same grid with the mean of each pixel over its active area and its gap.
    pub(crate) fn without_gaps(&self) -> Self {
        Self {
            values: self.values.mapv(|value| self.active.mean(value)),
            active: ActiveArea::WHOLE,
            ..*self
        }
    }

    /// The pixels whose values take part in the transmission at (x, y), with their shares; none in gaps and outside the
    /// grid.
    pub(crate) fn shares(&self, x: f64, y: f64) -> impl Iterator<Item = ([usize; 2], f64)> {
        let (ny, nx) = self.values.dim();
        let [x, y] = self.placement.inwards(x, y);
        let u = x / self.pitch[0] + 0.5 * nx as f64;
        let v = y / self.pitch[1] + 0.5 * ny as f64;
        let on_grid = u >= 0.0 && v >= 0.0 && u < nx as f64 && v < ny as f64;
        let inside = on_grid && self.active.holds(0, u.fract()) && self.active.holds(1, v.fract());

        let split = |t: f64, n: usize| match self.form {
            PixelForm::Box | PixelForm::Point => PixelShares::one(t as usize),
            PixelForm::Bilinear => PixelShares::linear(t - 0.5, n),
            PixelForm::BandLimited => PixelShares::band_limited(t - 0.5, n),
        };
        let columns = split(u, nx);
        let pairs = split(v, ny).pixels().flat_map(move |(row, b)| {
            let along = columns.pixels();
            along.map(move |(column, a)| ([row, column], a * b))
        });
        pairs.filter(move |(_, share)| inside && *share != 0.0)
    }

    /// Where a place in mm along the own x (axis 0) or y (axis 1) lies among box pixels.
    fn place(&self, axis: usize, place: f64) -> PixelPlace {
        let (ny, nx) = self.values.dim();
        let count = [nx, ny][axis];
        let t = place / self.pitch[axis] + 0.5 * count as f64;
        match t >= 0.0 && t < count as f64 {
            true if self.active.holds(axis, t.fract()) => PixelPlace::Active(t as usize),
            true => PixelPlace::Gap,
            false => PixelPlace::Outside,
        }
    }

    /// Where some places in mm along the own x (axis 0) or y (axis 1) lie among box pixels.
    pub(crate) fn places(&self, axis: usize, places: &[f64]) -> Vec<PixelPlace> {
        places.iter().map(|at| self.place(axis, *at)).collect()
    }

    /// A box about the grid on the element, `[x_min, x_max, y_min, y_max]` in mm: its outline, unless it is turned.
    pub(crate) fn bounds(&self) -> [f64; 4] {
        let (ny, nx) = self.values.dim();
        let half_x = 0.5 * nx as f64 * self.pitch[0];
        let half_y = 0.5 * ny as f64 * self.pitch[1];
        let (sin, cos) = self.placement.rotation.sin_cos();
        let across = half_x * cos.abs() + half_y * sin.abs();
        let up = half_x * sin.abs() + half_y * cos.abs();
        let [x, y] = self.placement.centre;
        [x - across, x + across, y - up, y + up]
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;
    use num_complex::Complex64;

    use crate::optics::phase::placement::Placement;
    use crate::optics::pixels::active_area::{ActiveArea, Rest};
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};

    fn grid(form: PixelForm) -> Pixels {
        Pixels {
            pitch: [1.0, 2.0],
            values: array![[1.0, 2.0], [3.0, 4.0]].mapv(|v| Complex64::new(v, 0.0)),
            form,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        }
    }

    /// A turn by a right angle and a shift: the pixel at the lower left comes to the lower right.
    #[test]
    fn a_placed_grid_is_turned_about_its_centre() {
        let pixels = Pixels {
            placement: Placement {
                centre: [10.0, 20.0],
                rotation: std::f64::consts::FRAC_PI_2,
            },
            ..grid(PixelForm::Box)
        };
        assert_eq!(pixels.at(11.0, 19.5).re, 1.0);
        assert_eq!(pixels.at(11.0, 20.5).re, 2.0);
        assert_eq!(pixels.at(9.0, 19.5).re, 3.0);
        assert_eq!(pixels.at(0.5, 1.0).re, 0.0);
        let exact = [8.0, 12.0, 19.0, 21.0];
        let bounds = pixels.bounds();
        assert!(
            bounds.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-14),
            "{bounds:?}"
        );
    }

    #[test]
    fn rows_grow_with_y() {
        let pixels = grid(PixelForm::Box);
        assert_eq!(pixels.at(-0.5, -1.0).re, 1.0);
        assert_eq!(pixels.at(0.5, -1.0).re, 2.0);
        assert_eq!(pixels.at(-0.5, 1.0).re, 3.0);
        assert_eq!(pixels.at(1.5, 0.0).re, 0.0);
    }

    #[test]
    fn bilinear_meets_the_centres() {
        let pixels = grid(PixelForm::Bilinear);
        assert!((pixels.at(0.5, 1.0).re - 4.0).abs() < 1e-15);
        assert!((pixels.at(0.0, 0.0).re - 2.5).abs() < 1e-15);
        assert!((pixels.at(0.99, 1.9).re - 4.0).abs() < 1e-15);
    }

    /// The active area is a rectangle about the centre of each pixel; around it is the gap, and outside nothing.
    #[test]
    fn gaps_lie_around_the_active_area() {
        let active = ActiveArea {
            sides: [0.8, 0.5],
            rest: Rest::Flat,
        };
        let pixels = Pixels {
            active,
            ..grid(PixelForm::Box)
        };
        assert_eq!(pixels.at(-0.89, -1.0).re, 1.0);
        assert_eq!(pixels.at(-0.91, -1.0).re, 1.0);
        assert_eq!(pixels.at(0.11, 1.49).re, 4.0);
        assert_eq!(pixels.at(0.09, 1.0).re, 1.0);
        assert_eq!(pixels.at(0.5, 1.51).re, 1.0);
        assert_eq!(pixels.at(1.01, 1.0).re, 0.0);
        assert_eq!(pixels.shares(0.09, 1.0).count(), 0);
        assert_eq!(pixels.shares(0.11, 1.0).count(), 1);
        let mean = pixels.without_gaps().at(0.5, 1.0).re;
        assert!((mean - (0.4 * 4.0 + 0.6)).abs() < 1e-15);
    }
}
