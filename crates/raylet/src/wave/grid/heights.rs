//! A curved screen under the nodes of a grid, and fields known on levels above and below it.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::chebyshev::Levels;
use crate::optics::conic::Conic;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::wave::grid::field::{Field, Grid};

/// Height and slope of a screen over its local plane, at the nodes of a grid, indexed [y, x].
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// z in mm; zero where the screen does not exist.
    pub z: Array2<f64>,
    /// ∂z/∂x and ∂z/∂y.
    pub slope: [Array2<f64>; 2],
    /// The conic about the origin on which all nodes lie, if they do.
    pub conic: Option<Conic>,
}

impl Heights {
    /// The heights of a plane: zero, with zero slope.
    pub fn flat(grid: &Grid) -> Self {
        let shape = grid.shape();
        Self {
            z: Array2::zeros(shape),
            slope: [Array2::zeros(shape), Array2::zeros(shape)],
            conic: None,
        }
    }

    /// The heights of a screen at the nodes of a grid.
    pub(crate) fn on(screen: &Screen, grid: &Grid) -> Self {
        let mut heights = Self::flat(grid);
        if screen.is_plane() {
            return heights;
        }
        if let Shape::Conic(conic) = &screen.shape {
            heights.conic = Some(*conic);
        }
        let [sx, sy] = &mut heights.slope;
        ndarray::Zip::indexed(&mut heights.z)
            .and(sx)
            .and(sy)
            .par_for_each(|(j, i), z, sx, sy| {
                if let Some(here) = screen.height([grid.x.node(i), grid.y.node(j)]) {
                    (*z, *sx, *sy) = (here.z, here.slope[0], here.slope[1]);
                }
            });
        heights
    }
}

/// Levels between two heights, enough for light whose normal cosines (signed, optical) lie between `low` and `high`.
/// They are few, because the mean phase of the light is taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Heights of the levels, in mm.
    pub levels: Levels,
    /// Phase per mm that is taken out, k times the mean normal cosine.
    pub carrier: f64,
}

/// Error that the levels may add to a field.
const LEVEL_TOLERANCE: f64 = 1e-5;

impl Stack {
    /// The levels for heights from `bottom` to `top`, in mm; `k` is the vacuum wavenumber.
    pub(crate) fn new(range: [f64; 2], cosines: [f64; 2], k: f64) -> Self {
        Self::within(LEVEL_TOLERANCE, range, cosines, k)
    }

    /// The levels that add a relative error of about `tolerance`, for heights from `bottom` to `top` in mm.
    pub(crate) fn within(
        tolerance: f64,
        [bottom, top]: [f64; 2],
        [low, high]: [f64; 2],
        k: f64,
    ) -> Self {
        Self {
            levels: Levels::new(bottom, top, 0.5 * k * (high - low), tolerance),
            carrier: 0.5 * k * (low + high),
        }
    }

    /// Number of levels.
    pub(crate) fn len(&self) -> usize {
        self.levels.at.len()
    }

    /// The level in the middle, and the largest distance of another from it, in mm.
    pub(crate) fn middle(&self) -> [f64; 2] {
        let at = &self.levels.at;
        let middle = at.get(at.len() / 2).copied().unwrap_or(0.0);
        let apart = at.iter().map(|level| (level - middle).abs());
        [middle, apart.fold(0.0, f64::max)]
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.levels.at.is_empty()
    }

    /// The field on a curved screen from the fields on the levels, all at the same nodes:
    /// U(z) = Σᵢ ℓᵢ(z) e^{iκ(z − zᵢ)} Uᵢ with the carrier κ.
    pub(crate) fn merge(&self, fields: &[Field], heights: &Heights) -> Field {
        let mut merged = Field::zeros(fields[0].grid.clone());
        ndarray::Zip::indexed(merged.values.rows_mut()).par_for_each(|j, mut row| {
            let mut shares = vec![0.0; self.len()];
            for (i, value) in row.iter_mut().enumerate() {
                let z = heights.z[[j, i]];
                self.levels.shares(z, &mut shares);
                for ((field, level), share) in fields.iter().zip(&self.levels.at).zip(&shares) {
                    let turn = Complex64::from_polar(*share, self.carrier * (z - level));
                    *value += field.values[[j, i]] * turn;
                }
            }
        });
        merged
    }

    /// The conjugate transpose of [`Stack::merge`]: what each level gets back.
    pub(crate) fn merge_adjoint(&self, merged_bar: &Field, heights: &Heights) -> Vec<Field> {
        let level = |number: usize| {
            let mut bar = merged_bar.clone();
            ndarray::Zip::from(&mut bar.values)
                .and(&heights.z)
                // value += sheet·turn
                .par_for_each(|bar, z| *bar = self.part(*bar, *z, number));
            bar
        };
        (0..self.len()).map(level).collect()
    }

    /// What the field at one height puts on one level.
    #[inline]
    pub(crate) fn part(&self, value: Complex64, z: f64, number: usize) -> Complex64 {
        if value == Complex64::ZERO {
            return value;
        }
        let turn = -self.carrier * (z - self.levels.at[number]);
        value * Complex64::from_polar(self.levels.share(z, number), turn)
    }

    /// The conjugate transpose of [`Stack::part`].
    #[inline]
    pub(crate) fn part_adjoint(&self, part_bar: Complex64, z: f64, number: usize) -> Complex64 {
        let turn = self.carrier * (z - self.levels.at[number]);
        part_bar * Complex64::from_polar(self.levels.share(z, number), turn)
    }

    /// What the field at one height puts on each level, so that Σ U e^{−iκ′z} over heights, for every κ′
    /// of the stack, is Σᵢ e^{−iκ′zᵢ} of what the levels hold: U·ℓᵢ(z)·e^{−iκ(z − zᵢ)}.
    #[inline]
    pub(crate) fn split(
        &self,
        value: Complex64,
        z: f64,
        shares: &mut [f64],
        parts: &mut [Complex64],
    ) {
        self.levels.shares(z, shares);
        for ((part, level), share) in parts.iter_mut().zip(&self.levels.at).zip(shares.iter()) {
            *part = value * Complex64::from_polar(*share, -self.carrier * (z - level));
        }
    }
}

/// A field on a curved screen that is taken apart into levels, level by level. What levels share is known.
pub(crate) struct SplitField<'a> {
    stack: &'a Stack,
    /// Heights of the nodes, none of which is that of a level.
    z: Array2<f64>,
    /// The field times e^{−iκz}, over the sum of the levels' shares.
    shared: Array2<Complex64>,
}

/// Nodes that are on a level are moved off it by this part of what the levels span.
const OFF_LEVEL: f64 = 1e-13;

impl<'a> SplitField<'a> {
    /// A field with these values at the nodes.
    pub(crate) fn new(values: &Array2<Complex64>, heights: &Heights, stack: &'a Stack) -> Self {
        let at = &stack.levels.at;
        let span = match at.len() {
            0 | 1 => 1.0,
            count => at[count - 1] - at[0],
        };
        let off = |z: &f64| match at.contains(z) {
            true => z + OFF_LEVEL * span,
            false => *z,
        };
        let z = ndarray::Zip::from(&heights.z).par_map_collect(off);
        let share = |value: &Complex64, z: &f64| match *value == Complex64::ZERO {
            true => *value,
            false => {
                value * Complex64::from_polar(1.0 / stack.levels.total(*z), -stack.carrier * z)
            }
        };
        let shared = ndarray::Zip::from(values).and(&z).par_map_collect(share);
        Self { stack, z, shared }
    }

    /// What one level holds, as [`Stack::part`] has it for each node.
    pub(crate) fn level(&self, number: usize) -> Array2<Complex64> {
        let Stack { levels, carrier } = self.stack;
        let (at, turn) = (
            levels.at[number],
            Complex64::cis(carrier * levels.at[number]),
        );
        let weight = turn * levels.weight(number);
        ndarray::Zip::from(&self.shared)
            .and(&self.z)
            .par_map_collect(|shared, z| shared * weight / (z - at))
    }
}

/// Smallest and largest normal cosine of light in a medium of index `n` whose directions lie in the box
/// `[x_low, x_high, y_low, y_high]`; zero at the smallest where it reaches grazing.
pub(crate) fn normal_cosines([x0, x1, y0, y1]: [f64; 4], n: f64) -> [f64; 2] {
    let nearest = |low: f64, high: f64| if low > 0.0 { low } else { (-high).max(0.0) };
    let least = nearest(x0, x1).powi(2) + nearest(y0, y1).powi(2);
    let most = x0.abs().max(x1.abs()).powi(2) + y0.abs().max(y1.abs()).powi(2);
    [most, least].map(|square| (n * n - square).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::{Heights, SplitField, Stack, normal_cosines};

    fn heights(grid: &Grid) -> Heights {
        let at = |(j, i): (usize, usize)| 4.0 * (0.2 * grid.x.node(i) + 0.3 * grid.y.node(j)).sin();
        let shape = grid.shape();
        Heights {
            z: Array2::from_shape_fn(shape, at),
            slope: [Array2::zeros(shape), Array2::zeros(shape)],
            conic: None,
        }
    }

    /// Plane waves of a wide cone, known on the levels, are known on the surface between.
    #[test]
    fn levels_give_the_field_between_them() {
        let k = std::f64::consts::TAU;
        let axis = Axis::uniform(20, 0.7, 0.0);
        let grid = Grid {
            x: axis.clone(),
            y: axis,
        };
        let heights = heights(&grid);
        let cosines = normal_cosines([-0.5, 0.3, -0.2, 0.4], 1.0);
        let stack = Stack::new([-4.0, 4.0], cosines, k);
        let waves = [[-0.5, 0.4], [0.3, 0.0], [0.0, 0.0], [-0.1, -0.2]];
        let light = |x: f64, y: f64, z: f64| -> Complex64 {
            let wave = |p: &[f64; 2]| {
                let q = (1.0 - p[0] * p[0] - p[1] * p[1]).sqrt();
                Complex64::cis(k * (p[0] * x + p[1] * y + q * z))
            };
            waves.iter().map(wave).sum()
        };
        let sheet = |z: f64| {
            let mut field = Field::zeros(grid.clone());
            for ((j, i), value) in field.values.indexed_iter_mut() {
                *value = light(grid.x.node(i), grid.y.node(j), z);
            }
            field
        };
        let fields: Vec<Field> = stack.levels.at.iter().map(|z| sheet(*z)).collect();
        let merged = stack.merge(&fields, &heights);
        for ((j, i), value) in merged.values.indexed_iter() {
            let exact = light(grid.x.node(i), grid.y.node(j), heights.z[[j, i]]);
            assert!((value - exact).norm() < 4e-4, "{}", stack.len());
        }

        // The other way round: sums over the surface are sums over the levels.
        let (mut shares, mut parts) = (vec![0.0; stack.len()], vec![Complex64::ZERO; stack.len()]);
        for kappa in [cosines[0] * k, 0.93 * k, cosines[1] * k] {
            for z in [-3.9, 0.2, 3.3] {
                stack.split(Complex64::ONE, z, &mut shares, &mut parts);
                let terms = parts.iter().zip(&stack.levels.at);
                let sum: Complex64 = terms.map(|(u, z)| u * Complex64::cis(-kappa * z)).sum();
                assert!((sum - Complex64::cis(-kappa * z)).norm() < 1e-4);
            }
        }
    }

    /// On a level, between levels and with one level alone; dark nodes stay dark.
    #[test]
    fn split_fields_have_the_parts_of_their_nodes() {
        let (stack, grid) = stack_and_grid();
        let mut values = noise(grid.shape(), 0);
        values[[3, 3]] = Complex64::ZERO;
        let flat = Stack::new([2.0, 2.0], [0.8, 1.0], 6.0);
        for (stack, level) in [(&stack, stack.levels.at[2]), (&flat, 2.0)] {
            let mut heights = heights(&grid);
            (heights.z[[5, 7]], heights.z[[3, 3]]) = (level, level);
            if stack.len() == 1 {
                heights.z.fill(level);
            }
            let split = SplitField::new(&values, &heights, stack);
            for number in 0..stack.len() {
                let found = split.level(number);
                for (at, value) in values.indexed_iter() {
                    let expected = stack.part(*value, heights.z[at], number);
                    let off = (found[at] - expected).norm();
                    assert!(
                        off < 1e-9 * value.norm() + 1e-300,
                        "{number} {at:?}: {off:e}"
                    );
                }
            }
        }
    }

    fn stack_and_grid() -> (Stack, Grid) {
        let axis = Axis::uniform(20, 0.7, 0.0);
        let grid = Grid {
            x: axis.clone(),
            y: axis,
        };
        let cosines = normal_cosines([-0.5, 0.3, -0.2, 0.4], 1.0);
        (
            Stack::new([-4.0, 4.0], cosines, std::f64::consts::TAU),
            grid,
        )
    }

    #[test]
    fn merge_dot_product() {
        let (stack, grid) = stack_and_grid();
        let heights = heights(&grid);
        let field = |purpose: usize| Field {
            grid: grid.clone(),
            values: noise(grid.shape(), purpose as u32),
        };
        let fields: Vec<Field> = (0..stack.len()).map(field).collect();
        let bar = field(100);
        let merged = stack.merge(&fields, &heights);
        let back = stack.merge_adjoint(&bar, &heights);
        let pairs = back.iter().zip(&fields);
        let pairs: Vec<_> = pairs.map(|(bar, u)| (&bar.values, &u.values)).collect();
        assert_transposed(&[(&bar.values, &merged.values)], &pairs);
    }

    #[test]
    fn part_dot_product() {
        let (stack, _) = stack_and_grid();
        let (value, bar) = (noise((1, 1), 0), noise((1, 1), 1));
        for number in 0..stack.len() {
            let there = value.mapv(|u| stack.part(u, 1.7, number));
            let back = bar.mapv(|u| stack.part_adjoint(u, 1.7, number));
            assert_transposed(&[(&bar, &there)], &[(&back, &value)]);
        }
    }
}
