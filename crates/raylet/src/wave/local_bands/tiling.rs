//! Windows over a screen, and the tiles in which they are worked on.
//!
//! Windows overlap many times, so the light under a block of neighbours is summed once, on the samples of their tile.

use std::ops::Range;

use crate::optics::aperture::Aperture;
use crate::wave::grid::field::Axis;
use crate::wave::grid::raster::Raster;
use crate::wave::patches::window::Positions;

/// Windows end at this many σ.
pub(crate) const REACH: f64 = 4.3;

/// A window whose centre lies this many σ inside an edge does not see it, and one this far outside has no light.
pub(crate) const CLEAR: f64 = 3.5;

/// Samples of a tile outside its windows, so that rounding leaves none out.
const SPARE: usize = 2;

/// The lattice of windows on a screen, dealt out in tiles.
#[derive(Clone, Debug)]
pub(crate) struct Tiling {
    /// Window positions along x and y.
    pub positions: [Positions; 2],
    /// Windows along each side of a tile.
    side: usize,
    /// Whether the light at the edge of the aperture is too weak for its windows to see it.
    dark_rim: bool,
}

/// How wide windows are and how densely they stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindowShape {
    /// Width σ in mm.
    pub sigma: f64,
    /// Distance of neighbours in σ.
    pub step: f64,
    /// Period of the plane waves of a window in σ.
    pub period: f64,
}

/// A block of neighbouring windows: their indices along x and y.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Along x and y.
    pub windows: [Range<usize>; 2],
}

/// A window that an aperture does not leave dark.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LitWindow {
    /// Its numbers along x and y.
    pub window: [usize; 2],
    /// Its centre in mm.
    pub at: [f64; 2],
    /// Whether the edge of the aperture cuts it.
    pub edge: EdgeContact,
    /// How deep its centre lies inside that edge, in σ.
    pub depth: f64,
}

/// How a window lies to the aperture of its screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeContact {
    /// It sees no edge.
    Inside,
    /// An edge cuts it.
    Cut,
    /// It has no light.
    Outside,
}

impl EdgeContact {
    /// Of a window, from the depth of its centre inside the edge in σ.
    pub(crate) fn of(depth: f64) -> Self {
        if depth >= CLEAR {
            Self::Inside
        } else if depth > -CLEAR {
            Self::Cut
        } else {
            Self::Outside
        }
    }
}

impl Tiling {
    /// Windows over a box `[x_min, x_max, y_min, y_max]` and across its edges, in tiles of `side`² windows.
    pub(crate) fn over(bounds: [f64; 4], shape: WindowShape, side: usize) -> Self {
        let WindowShape { sigma, step, .. } = shape;
        let [x0, x1, y0, y1] = bounds;
        let along = |edges| Positions::covering(edges, sigma, step * sigma, REACH * sigma);
        Self {
            positions: [along([x0, x1]), along([y0, y1])],
            side: side.max(1),
            dark_rim: false,
        }
    }

    /// The same windows where the light at the edge of the aperture is weak: none of them sees it.
    pub(crate) fn with_dark_rim(self, dark_rim: bool) -> Self {
        Self { dark_rim, ..self }
    }

    /// The tiles, row by row.
    pub(crate) fn tiles(&self) -> Vec<Tile> {
        let counts = [0, 1].map(|a| self.positions[a].count.div_ceil(self.side));
        let block = |a: usize, i: usize| {
            let first = i * self.side;
            first..(first + self.side).min(self.positions[a].count)
        };
        let all = (0..counts[1]).flat_map(|j| (0..counts[0]).map(move |i| [i, j]));
        all.map(|[i, j]| Tile {
            windows: [block(0, i), block(1, j)],
        })
        .collect()
    }

    /// The windows of a tile that an aperture does not leave dark, row by row.
    pub(crate) fn lit(&self, tile: &Tile, aperture: &Aperture) -> Vec<LitWindow> {
        let [columns, rows] = tile.windows.clone();
        let all = rows.flat_map(|j| columns.clone().map(move |i| [i, j]));
        let lying = |window: [usize; 2]| {
            let at = self.centre(window);
            let depth = aperture.depth(at[0], at[1]) / self.positions[0].sigma;
            let edge = match EdgeContact::of(depth) {
                EdgeContact::Cut if self.dark_rim => EdgeContact::Inside,
                other => other,
            };
            (edge != EdgeContact::Outside).then_some(LitWindow {
                window,
                at,
                edge,
                depth,
            })
        };
        all.filter_map(lying).collect()
    }

    /// The centre of a window, in mm.
    pub(crate) fn centre(&self, window: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|a| self.positions[a].at(window[a]))
    }

    /// The box of the centres of a tile's windows, `[x_min, x_max, y_min, y_max]` in mm.
    pub(crate) fn centres(&self, tile: &Tile) -> [f64; 4] {
        let end = |a: usize| {
            let Range { start, end } = tile.windows[a];
            [start, end.max(1) - 1].map(|i| self.positions[a].at(i))
        };
        let ([x0, x1], [y0, y1]) = (end(0), end(1));
        [x0, x1, y0, y1]
    }

    /// The centre of a tile, in mm.
    pub(crate) fn middle(&self, tile: &Tile) -> [f64; 2] {
        let [x0, x1, y0, y1] = self.centres(tile);
        [0.5 * (x0 + x1), 0.5 * (y0 + y1)]
    }

    /// Samples of these pitches under all windows of a tile.
    pub(crate) fn samples(&self, tile: &Tile, pitch: [f64; 2]) -> [Axis; 2] {
        let centres = self.centres(tile);
        [0, 1].map(|a| {
            let [low, high] = [centres[2 * a], centres[2 * a + 1]];
            let length = high - low + 2.0 * self.positions[a].reach;
            let count = (length / pitch[a]).ceil() as usize + SPARE;
            Axis::uniform(count, pitch[a], 0.5 * (low + high))
        })
    }
}

/// The raster of two uniform axes.
pub(crate) fn raster([x, y]: &[Axis; 2]) -> Raster {
    Raster {
        start: [x.start, y.start],
        pitch: [x.pitch, y.pitch],
        size: [x.cells, y.cells],
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::aperture::Aperture;
    use crate::wave::local_bands::tiling::{EdgeContact, LitWindow, Tiling, WindowShape};

    #[test]
    fn tiles_hold_every_window_once() {
        let shape = WindowShape {
            sigma: 0.2,
            step: 1.5,
            period: 6.0,
        };
        let tiling = Tiling::over([-1.0, 2.0, -0.5, 0.5], shape, 4);
        let mut seen = vec![0; tiling.positions[0].count * tiling.positions[1].count];
        for tile in tiling.tiles() {
            let open = tiling.lit(&tile, &Aperture::OPEN);
            let [x, y] = tiling.samples(&tile, [0.07, 0.05]);
            for LitWindow {
                window, at, edge, ..
            } in open
            {
                let [i, j] = window;
                assert_eq!(edge, EdgeContact::Inside);
                seen[j * tiling.positions[0].count + i] += 1;
                for (axis, at) in [(&x, at[0]), (&y, at[1])] {
                    let [low, high] = axis.edges();
                    assert!(low < at - 4.3 * 0.2 && at + 4.3 * 0.2 < high);
                }
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
        let disc = Aperture::disc(0.1);
        let lit = tiling
            .tiles()
            .iter()
            .map(|t| tiling.lit(t, &disc).len())
            .sum::<usize>();
        assert!((10..40).contains(&lit), "{lit}");
    }
}
