//! Carries strengths of scattered points to a periodic grid, and values of the grid to the points.
//!
//! Points are sorted, chunk by chunk, into tiles of the grid small enough for the nearest cache. A tile
//! gathers its points in a buffer of its own and is then added to the grid; every second row of tiles is
//! worked on at once, so that no two threads touch the same grid row. Chunks and order are fixed, so
//! results are the same to the last bit for any number of threads.

use fearless_simd::{Level, Simd, SimdFloat, dispatch, f64x4, f64x8};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::kaiser::{Kaiser, LANES};
use crate::math::simd_level::level;

/// Grid points of a tile along either axis.
const TILE: usize = 16;
/// What its points touch: the tile and the width of a kernel.
const REACH: usize = TILE + LANES;
/// Chunks sorted before they are spread, which bounds the memory in use.
const BATCH: usize = 16;

/// A tile's own buffer: rows of real, then imaginary parts.
type Buffer = [[[f64; REACH]; 2]; REACH];

/// A point in grid steps, each coordinate from 0 to the grid's size, with what belongs to it.
#[derive(Clone, Copy, Debug, Default)]
struct Placed<T> {
    x: f64,
    y: f64,
    value: T,
}

/// Points with strengths, in the order of their tiles, and where the points of each tile end.
type Part<'a> = (&'a [Placed<Complex64>], &'a [u32]);

/// Points with strengths in the order of their tiles, with the memory to sort others.
#[derive(Debug, Default)]
pub(crate) struct SortedPoints {
    placed: Vec<Placed<Complex64>>,
    ends: Vec<u32>,
    keys: Vec<u32>,
}

/// The points of one chunk, in the order of their tiles.
struct Sorted<'a, T> {
    placed: &'a mut [Placed<T>],
    /// Where the points of each tile end; those of the next begin there.
    ends: &'a mut [u32],
    /// The tile of each point before sorting.
    keys: &'a mut [u32],
}

/// The layout of a periodic grid in tiles.
///
/// A grid with margins is a vector of rows of `stride` real then `stride` imaginary parts, which exceed
/// the period on the far side by what the kernels touch there.
#[derive(Clone, Debug)]
pub(crate) struct Tiles {
    /// Grid points \[y, x\] of one period.
    pub(crate) shape: [usize; 2],
    pub(crate) kernel: Kaiser,
    count: [usize; 2],
    stride: usize,
    level: Level,
}

impl Tiles {
    pub(crate) fn new(shape: [usize; 2], kernel: Kaiser) -> Self {
        let count = shape.map(|points| points.div_ceil(TILE));
        Self {
            shape,
            kernel,
            count,
            stride: count[1] * TILE + LANES,
            level: level(),
        }
    }

    /// Number of points sorted at a time: enough that a tile gets a few, few enough for the cache.
    fn chunk(&self) -> usize {
        (32 * self.count[0] * self.count[1]).clamp(1 << 13, 1 << 18)
    }

    fn row(&self) -> usize {
        2 * self.stride
    }

    fn rows(&self) -> usize {
        self.count[0] * TILE + LANES
    }

    /// A grid with margins of zeros.
    pub(crate) fn blank(&self) -> Vec<f64> {
        vec![0.0; self.rows() * self.row()]
    }

    /// Adds Σᵢ strengthᵢ·φ(x − xᵢ)·φ(y − yᵢ) to a grid with margins, points (x, y) in radians of the period.
    pub(crate) fn spread(&self, points: &[[f64; 2]], strengths: &[Complex64], grid: &mut [f64]) {
        let (chunk, tiles) = (self.chunk(), self.count[0] * self.count[1]);
        let room = points.len().min(BATCH * chunk);
        let mut placed = vec![Placed::default(); room];
        let mut keys = vec![0; room];
        let mut ends = vec![0; tiles * room.div_ceil(chunk)];
        for (points, strengths) in points
            .chunks(BATCH * chunk)
            .zip(strengths.chunks(BATCH * chunk))
        {
            // Sort each chunk into its own part of the buffers.
            let buffers = placed.par_chunks_mut(chunk).zip(keys.par_chunks_mut(chunk));
            let inputs = points.par_chunks(chunk).zip(strengths.par_chunks(chunk));
            let all = inputs.zip(buffers).zip(ends.par_chunks_mut(tiles));
            all.for_each(|(((points, strengths), (placed, keys)), ends)| {
                let placed = &mut placed[..points.len()];
                self.sort(points, |i| strengths[i], Sorted { placed, ends, keys });
            });
            let sorted: Vec<_> = placed.chunks(chunk).zip(ends.chunks(tiles)).collect();
            self.spread_parts(&sorted[..points.len().div_ceil(chunk)], grid);
        }
    }

    /// Puts points and strengths in the order of their tiles, in place of what `sorted` holds.
    pub(crate) fn sort_into(
        &self,
        points: &[[f64; 2]],
        strengths: &[Complex64],
        sorted: &mut SortedPoints,
    ) {
        let SortedPoints { placed, ends, keys } = sorted;
        placed.resize(points.len(), Placed::default());
        keys.resize(points.len(), 0);
        ends.resize(self.count[0] * self.count[1], 0);
        self.sort(points, |i| strengths[i], Sorted { placed, ends, keys });
    }

    /// [`Tiles::spread`] of points that are sorted already.
    pub(crate) fn spread_sorted(&self, parts: &[SortedPoints], grid: &mut [f64]) {
        let sorted: Vec<_> = parts
            .iter()
            .map(|part| (part.placed.as_slice(), part.ends.as_slice()))
            .collect();
        self.spread_parts(&sorted, grid);
    }

    /// Spreads even rows of tiles, then odd ones, each with the rows that it touches to itself.
    fn spread_parts(&self, sorted: &[Part], grid: &mut [f64]) {
        for parity in 0..2 {
            let strips = grid[parity * TILE * self.row()..].par_chunks_mut(REACH * self.row());
            strips.enumerate().for_each(|(i, strip)| {
                let tile_row = 2 * i + parity;
                if tile_row < self.count[0] {
                    self.spread_strip(sorted, tile_row, strip);
                }
            });
        }
    }

    /// Sorts points by tile (counting sort), each with its `value(i)`.
    fn sort<T: Copy>(
        &self,
        points: &[[f64; 2]],
        value: impl Fn(usize) -> T,
        sorted: Sorted<'_, T>,
    ) {
        dispatch!(self.level, simd => sort_in(simd, self, points, &value, sorted));
    }

    /// Adds the points of one row of tiles to the grid rows that they touch.
    fn spread_strip(&self, sorted: &[Part], tile_row: usize, strip: &mut [f64]) {
        match self.kernel.width {
            0..=4 => dispatch!(self.level, simd => {
                spread_strip_in::<_, f64x4<_>, 1>(simd, self, sorted, tile_row, strip)
            }),
            5..=8 => dispatch!(self.level, simd => {
                spread_strip_in::<_, f64x8<_>, 1>(simd, self, sorted, tile_row, strip)
            }),
            9..=12 => dispatch!(self.level, simd => {
                spread_strip_in::<_, f64x4<_>, 3>(simd, self, sorted, tile_row, strip)
            }),
            _ => dispatch!(self.level, simd => {
                spread_strip_in::<_, f64x8<_>, 2>(simd, self, sorted, tile_row, strip)
            }),
        }
    }

    /// Moves what a tile's buffer holds to the grid rows it belongs to.
    #[inline(always)]
    fn empty_buffer(&self, buffer: &mut Buffer, column: usize, strip: &mut [f64]) {
        let touched = TILE + self.kernel.width - 1;
        let rows = strip.chunks_exact_mut(self.row());
        for (row, parts) in rows.zip(&mut buffer[..touched]) {
            for (row, part) in row.chunks_exact_mut(self.stride).zip(parts) {
                let row = &mut row[column * TILE..][..REACH];
                row.iter_mut()
                    .zip(part.iter())
                    .for_each(|(row, part)| *row += part);
                part.fill(0.0);
            }
        }
    }

    /// One period of a grid, the margins added to where they belong.
    pub(crate) fn fold(&self, grid: &[f64]) -> Array2<Complex64> {
        let [ny, nx] = self.shape;
        let mut folded = Array2::zeros(self.shape);
        let rows: Vec<_> = folded.axis_iter_mut(Axis(0)).collect();
        rows.into_par_iter().enumerate().for_each(|(y, out)| {
            let Some(out) = out.into_slice() else {
                return;
            };
            for row in grid.chunks_exact(self.row()).skip(y).step_by(ny) {
                let (re, im) = row.split_at(self.stride);
                for (re, im) in re.chunks(nx).zip(im.chunks(nx)) {
                    dispatch!(self.level, simd => add_complex(simd, [re, im], out));
                }
            }
        });
        folded
    }

    /// The grid with margins that repeat its period: the adjoint of [`Tiles::fold`].
    pub(crate) fn unfold(&self, period: &Array2<Complex64>) -> Vec<f64> {
        let [ny, nx] = self.shape;
        let mut grid = vec![0.0; self.rows() * self.row()];
        grid.par_chunks_exact_mut(self.row())
            .enumerate()
            .for_each(|(y, row)| {
                let values = period.row(y % ny);
                let (re, im) = row.split_at_mut(self.stride);
                for (re, im) in re.chunks_mut(nx).zip(im.chunks_mut(nx)) {
                    for ((re, im), value) in re.iter_mut().zip(im).zip(&values) {
                        (*re, *im) = (value.re, value.im);
                    }
                }
            });
        grid
    }

    /// Σ over the grid of value·φ(x − xᵢ)·φ(y − yᵢ) at each point: the adjoint of [`Tiles::spread`].
    pub(crate) fn interpolate(&self, grid: &[f64], points: &[[f64; 2]]) -> Vec<Complex64> {
        let (chunk, tiles) = (self.chunk(), self.count[0] * self.count[1]);
        let room = points.len().min(chunk);
        let buffers = || (vec![Placed::default(); room], vec![0; room], vec![0; tiles]);
        let mut out = vec![Complex64::ZERO; points.len()];
        let all = points.par_chunks(chunk).zip(out.par_chunks_mut(chunk));
        all.for_each_init(buffers, |(placed, keys, ends), (points, out)| {
            let placed = &mut placed[..points.len()];
            self.sort(points, |i| i as u32, Sorted { placed, keys, ends });
            self.interpolate_chunk(grid, placed, ends, out);
        });
        out
    }

    /// Values of the grid at the sorted points of one chunk.
    fn interpolate_chunk(
        &self,
        grid: &[f64],
        placed: &[Placed<u32>],
        ends: &[u32],
        out: &mut [Complex64],
    ) {
        let (level, kernel) = (self.level, &self.kernel);
        let mut buffer = [[[0.0; REACH]; 2]; REACH];
        for tile in 0..ends.len() {
            let piece = piece(placed, ends, tile);
            if piece.is_empty() {
                continue;
            }
            self.load_buffer(grid, tile, &mut buffer);
            let buffer = &buffer;
            match kernel.width {
                0..=4 => dispatch!(level, simd => {
                    interpolate_piece::<_, f64x4<_>, 1>(simd, kernel, piece, buffer, out)
                }),
                5..=8 => dispatch!(level, simd => {
                    interpolate_piece::<_, f64x8<_>, 1>(simd, kernel, piece, buffer, out)
                }),
                9..=12 => dispatch!(level, simd => {
                    interpolate_piece::<_, f64x4<_>, 3>(simd, kernel, piece, buffer, out)
                }),
                _ => dispatch!(level, simd => {
                    interpolate_piece::<_, f64x8<_>, 2>(simd, kernel, piece, buffer, out)
                }),
            }
        }
    }

    /// Copies what the points of a tile touch to a buffer.
    fn load_buffer(&self, grid: &[f64], tile: usize, buffer: &mut Buffer) {
        let touched = TILE + self.kernel.width - 1;
        let (row, column) = (tile / self.count[1] * TILE, tile % self.count[1] * TILE);
        let rows = grid.chunks_exact(self.row()).skip(row);
        for (row, parts) in rows.zip(&mut buffer[..touched]) {
            for (row, part) in row.chunks_exact(self.stride).zip(parts) {
                part.copy_from_slice(&row[column..][..REACH]);
            }
        }
    }
}

/// The points of one tile among those of a chunk.
fn piece<'a, T>(placed: &'a [Placed<T>], ends: &[u32], tile: usize) -> &'a [Placed<T>] {
    let start = if tile == 0 { 0 } else { ends[tile - 1] };
    &placed[start as usize..ends[tile] as usize]
}

/// An angle in grid steps, from 0 up to but not including `period`.
#[inline(always)]
fn steps(angle: f64, period: f64) -> f64 {
    let turns = angle * (0.5 * std::f64::consts::FRAC_1_PI);
    let steps = (turns - turns.floor()) * period;
    // A tiny negative angle rounds up to the whole period.
    if steps < period { steps } else { 0.0 }
}

/// The tile along an axis in which a point is, without a conversion that would leave the vectors of the processor: the low
/// bits of a whole number plus 2⁵² are that number.
#[inline(always)]
fn tile_of(steps: f64) -> u32 {
    let tile = (steps * (1.0 / TILE as f64)).floor();
    (tile + 4_503_599_627_370_496.0).to_bits() as u32
}

/// Counting sort: tile of each point, number of points in each tile, then each point to its place.
#[inline(always)]
fn sort_in<S: Simd, T: Copy>(
    _: S,
    tiles: &Tiles,
    points: &[[f64; 2]],
    value: &impl Fn(usize) -> T,
    sorted: Sorted<'_, T>,
) {
    let [height, width] = tiles.shape.map(|points| points as f64);
    let columns = tiles.count[1] as u32;
    for (key, &[u, v]) in sorted.keys.iter_mut().zip(points) {
        *key = tile_of(steps(v, height)) * columns + tile_of(steps(u, width));
    }
    let keys = &sorted.keys[..points.len()];
    sorted.ends.fill(0);
    keys.iter().for_each(|&key| sorted.ends[key as usize] += 1);

    // Each count becomes the start of its tile; placing the points moves it on to the end.
    let mut start = 0;
    for end in sorted.ends.iter_mut() {
        start += std::mem::replace(end, start);
    }
    for (i, (&key, &[u, v])) in keys.iter().zip(points).enumerate() {
        let place = &mut sorted.ends[key as usize];
        sorted.placed[*place as usize] = Placed {
            x: steps(u, width),
            y: steps(v, height),
            value: value(i),
        };
        *place += 1;
    }
}

/// The kernel's taps along both axes for fractions after the grid point, `N` vectors each.
#[inline(always)]
fn taps<S: Simd, V: SimdFloat<S, Element = f64>, const N: usize>(
    simd: S,
    kernel: &Kaiser,
    [x, y]: [f64; 2],
) -> ([V; N], [f64; LANES]) {
    let [x, y] = [x, y].map(|fraction| V::splat(simd, 2.0 * fraction - 1.0));
    let (mut along_x, mut along_y) = ([V::splat(simd, 0.0); N], [V::splat(simd, 0.0); N]);
    for line in &kernel.coefficients {
        for n in 0..N {
            let coefficient = V::from_slice(simd, &line[n * V::LEN..][..V::LEN]);
            along_x[n] = along_x[n].mul_add(x, coefficient);
            along_y[n] = along_y[n].mul_add(y, coefficient);
        }
    }
    let mut weights = [0.0; LANES];
    for n in 0..N {
        along_y[n].store_slice(&mut weights[n * V::LEN..][..V::LEN]);
    }
    (along_x, weights)
}

/// Adds real and imaginary parts to complex numbers.
#[inline(always)]
fn add_complex<S: Simd>(_: S, [re, im]: [&[f64]; 2], sums: &mut [Complex64]) {
    for (sum, (re, im)) in sums.iter_mut().zip(re.iter().zip(im)) {
        *sum += Complex64::new(*re, *im);
    }
}

/// Adds the points of one row of tiles to the grid rows that they touch.
#[inline(always)]
fn spread_strip_in<S: Simd, V: SimdFloat<S, Element = f64>, const N: usize>(
    simd: S,
    tiles: &Tiles,
    sorted: &[Part],
    tile_row: usize,
    strip: &mut [f64],
) {
    let mut buffer = [[[0.0; REACH]; 2]; REACH];
    for column in 0..tiles.count[1] {
        let mut points = 0;
        for (placed, ends) in sorted {
            let piece = piece(placed, ends, tile_row * tiles.count[1] + column);
            points += piece.len();
            spread_piece::<S, V, N>(simd, &tiles.kernel, piece, &mut buffer);
        }
        if points > 0 {
            tiles.empty_buffer(&mut buffer, column, strip);
        }
    }
}

/// Adds points of one tile to its buffer.
#[inline(always)]
fn spread_piece<S: Simd, V: SimdFloat<S, Element = f64>, const N: usize>(
    simd: S,
    kernel: &Kaiser,
    piece: &[Placed<Complex64>],
    buffer: &mut Buffer,
) {
    for point in piece {
        let (x, y) = (point.x as u32, point.y as u32);
        let fractions = [point.x - f64::from(x), point.y - f64::from(y)];
        let (along_x, weights) = taps::<S, V, N>(simd, kernel, fractions);
        let re = along_x.map(|tap| tap * point.value.re);
        let im = along_x.map(|tap| tap * point.value.im);

        // Position within the tile, which starts at a multiple of its size.
        let (x, y) = (x as usize % TILE, y as usize % TILE);
        for ([re_row, im_row], &weight) in buffer[y..y + kernel.width].iter_mut().zip(&weights) {
            let weight = V::splat(simd, weight);
            for n in 0..N {
                let part = &mut re_row[x + n * V::LEN..][..V::LEN];
                re[n]
                    .mul_add(weight, V::from_slice(simd, part))
                    .store_slice(part);
                let part = &mut im_row[x + n * V::LEN..][..V::LEN];
                im[n]
                    .mul_add(weight, V::from_slice(simd, part))
                    .store_slice(part);
            }
        }
    }
}

/// Values of the grid at the points of one tile, each written to its place before sorting.
#[inline(always)]
fn interpolate_piece<S: Simd, V: SimdFloat<S, Element = f64>, const N: usize>(
    simd: S,
    kernel: &Kaiser,
    piece: &[Placed<u32>],
    buffer: &Buffer,
    out: &mut [Complex64],
) {
    for point in piece {
        let (x, y) = (point.x as u32, point.y as u32);
        let fractions = [point.x - f64::from(x), point.y - f64::from(y)];
        let (along_x, weights) = taps::<S, V, N>(simd, kernel, fractions);

        // Down the columns first, then along the row.
        let (mut re, mut im) = ([V::splat(simd, 0.0); N], [V::splat(simd, 0.0); N]);
        let (x, y) = (x as usize % TILE, y as usize % TILE);
        for ([re_row, im_row], &weight) in buffer[y..y + kernel.width].iter().zip(&weights) {
            let weight = V::splat(simd, weight);
            for n in 0..N {
                let part = V::from_slice(simd, &re_row[x + n * V::LEN..][..V::LEN]);
                re[n] = part.mul_add(weight, re[n]);
                let part = V::from_slice(simd, &im_row[x + n * V::LEN..][..V::LEN]);
                im[n] = part.mul_add(weight, im[n]);
            }
        }
        let sum = |parts: [V; N]| {
            let total = (0..N).fold(V::splat(simd, 0.0), |sum, n| {
                parts[n].mul_add(along_x[n], sum)
            });
            total.as_slice().iter().sum()
        };
        out[point.value as usize] = Complex64::new(sum(re), sum(im));
    }
}
