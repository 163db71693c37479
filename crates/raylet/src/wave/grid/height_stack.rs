//! Light that is summed before a screen: on the screen's plane, or on levels around a curved screen.

use ndarray::Array2;
use num_complex::Complex64;

use crate::optics::screen::Screen;
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::heights::{Heights, Stack};
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::{interpolate, interpolate_adjoint};

/// Fields on parallel planes at the levels of a screen, all on the same raster.
#[derive(Clone, Debug)]
pub struct HeightStack {
    /// The planes' sample points.
    pub raster: Raster,
    /// The levels, of a curved screen; a plane screen has its own plane only.
    pub stack: Option<Stack>,
    /// The field on each level, indexed [y, x].
    pub values: Vec<Array2<Complex64>>,
}

impl HeightStack {
    /// The field of a plane screen.
    pub(crate) fn plane(raster: Raster, values: Array2<Complex64>) -> Self {
        Self {
            raster,
            stack: None,
            values: vec![values],
        }
    }

    /// The field on the screen itself at the nodes of a grid.
    pub(crate) fn on(&self, screen: &Screen, grid: &Grid) -> Field {
        let levels: Vec<Field> = self
            .values
            .iter()
            .map(|values| interpolate(&self.raster, values, grid))
            .collect();
        match &self.stack {
            Some(stack) => stack.merge(&levels, &Heights::on(screen, grid)),
            None => levels
                .into_iter()
                .next()
                .unwrap_or_else(|| Field::zeros(grid.clone())),
        }
    }

    /// The conjugate transpose of [`HeightStack::on`]: from the field on the screen to the levels. The values on the
    /// levels are not used.
    pub(crate) fn on_adjoint(&self, screen: &Screen, field_bar: &Field) -> Vec<Array2<Complex64>> {
        let back = |bar: &Field| interpolate_adjoint(&self.raster, bar);
        match &self.stack {
            Some(stack) => {
                let heights = Heights::on(screen, &field_bar.grid);
                let levels = stack.merge_adjoint(field_bar, &heights);
                levels.iter().map(back).collect()
            }
            None => vec![back(field_bar)],
        }
    }

    /// ∫|U|² on the middle level, in mm² for unit amplitude.
    pub(crate) fn power(&self) -> f64 {
        self.raster.power(&self.values[self.values.len() / 2])
    }

    /// The field on the middle level.
    pub(crate) fn into_middle(mut self) -> Array2<Complex64> {
        let middle = self.values.len() / 2;
        self.values.swap_remove(middle)
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{conic, open_screen};
    use crate::optics::frame::Frame;
    use crate::optics::screen::Screen;
    use crate::optics::shape::Shape;
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::height_stack::HeightStack;
    use crate::wave::grid::heights::Stack;
    use crate::wave::grid::raster::Raster;

    #[test]
    fn on_dot_product() {
        let grid = Grid {
            x: Axis::gauss(14, 0.5, 0.0, 2),
            y: Axis::uniform(25, 0.3, 0.0),
        };
        let curved = conic(0.05, 0.0);
        let levels = Stack::new([0.0, 1.5], [0.7, 1.0], std::f64::consts::TAU);
        for (shape, stack) in [(Shape::Plane, None), (curved, Some(levels))] {
            let screen = Screen {
                shape,
                ..open_screen(Frame::GLOBAL)
            };
            let count = stack.as_ref().map_or(1, Stack::len);
            let stack = HeightStack {
                raster: Raster {
                    start: [-9.0, -9.0],
                    pitch: [0.4, 0.45],
                    size: [46, 41],
                },
                stack,
                values: (0..count).map(|n| noise((41, 46), n as u32)).collect(),
            };
            let bar = Field {
                values: noise(grid.shape(), 100),
                grid: grid.clone(),
            };
            let there = stack.on(&screen, &grid).values;
            let back = stack.on_adjoint(&screen, &bar);
            let pairs: Vec<(&Array2<Complex64>, &Array2<Complex64>)> =
                back.iter().zip(&stack.values).collect();
            assert_transposed(&[(&bar.values, &there)], &pairs);
        }
    }
}
