//! A relief as a closed surface of triangles (.stl, binary).
//!
//! The top is a height over each place, so that it never meets itself: flat cells have steep walls of a small width between
//! them. Walls without a width would share an edge where two high cells touch at a corner, and such a surface is not closed.

use std::io::{self, Write};
use std::path::Path;

use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::{ExportChoices, Top, choice_fault};
use crate::file::fabrication::made_values::MadeValues;

/// Width of walls as a share of the pitch: 32-bit numbers resolve it over 100 000 cells.
const WALL: f64 = 1.0 / 64.0;

/// Vertices of a relief, line by line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReliefGrid {
    /// Whether a cell has four vertices, or one at its centre.
    pub stairs: bool,
    /// Width of walls in µm.
    pub wall_um: f64,
    /// Thickness of the base in µm.
    pub base_um: f64,
    /// Factor on all lengths in µm.
    pub scale: f64,
}

/// A vertex.
type Vertex = [f32; 3];

/// Triangles that are written, and the volume that they enclose.
struct Mesh<'a, W> {
    out: &'a mut W,
    triangles: u64,
}

impl<W: Write> Mesh<'_, W> {
    /// One triangle: its normal, its vertices against the clock as seen from outside, and two bytes of nothing.
    fn triangle(&mut self, [a, b, c]: [Vertex; 3]) -> io::Result<()> {
        let way = |to: Vertex, from: Vertex| {
            let [x, y, z] = to;
            let [u, v, w] = from;
            [x - u, y - v, z - w].map(f64::from)
        };
        let ([x, y, z], [u, v, w]) = (way(b, a), way(c, a));
        let normal = [y * w - z * v, z * u - x * w, x * v - y * u];
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let mut bytes = [0_u8; 50];
        let numbers = normal.map(|n| {
            if length > 0.0 {
                (n / length) as f32
            } else {
                0.0
            }
        });
        let all = [numbers, a, b, c];
        let numbers = all.iter().flatten();
        for (to, number) in bytes.chunks_exact_mut(4).zip(numbers) {
            to.copy_from_slice(&number.to_le_bytes());
        }
        self.triangles += 1;
        self.out.write_all(&bytes)
    }

    /// Four vertices against the clock.
    fn quad(&mut self, [a, b, c, d]: [Vertex; 4]) -> io::Result<()> {
        self.triangle([a, b, c])?;
        self.triangle([a, c, d])
    }
}

/// The same vertex on the bottom.
fn below([x, y, _]: Vertex) -> Vertex {
    [x, y, 0.0]
}

impl ReliefGrid {
    /// The grid for cells whose heights in µm lie in a range.
    ///
    /// # Errors
    /// Walls as wide as cells, a base that the heights cut, or too many triangles for the format.
    pub(crate) fn plan(
        file: &Path,
        cells: &Cells,
        [low, _]: [f64; 2],
        choices: &ExportChoices,
    ) -> Result<Self, Fault> {
        let [dx, dy] = cells.pitch_um;
        let pitch = dx.min(dy);
        let wall_um = choices.wall_um.unwrap_or(pitch * WALL);
        if wall_um >= pitch {
            let found = format!("walls of {wall_um} µm");
            let expected = format!("less than the pitch of {pitch} µm");
            return Err(choice_fault(file, "wall_um", found, expected));
        }
        if choices.base_um + low <= 0.0 {
            let found = format!("{} µm under heights from {low} µm", choices.base_um);
            let expected = "a base that stays above zero";
            return Err(choice_fault(file, "base_um", found, expected));
        }
        let grid = Self {
            stairs: choices.top == Top::Stairs,
            wall_um,
            base_um: choices.base_um,
            scale: if choices.micrometres { 1.0 } else { 1e-3 },
        };
        let [nx, ny] = cells.size();
        if !grid.stairs && nx.min(ny) < 2 {
            let found = format!("{nx} x {ny} cells");
            let expected = "at least 2 x 2 for a smooth surface";
            return Err(choice_fault(file, "top", found, expected));
        }
        let triangles = grid.triangles(cells.size());
        match u32::try_from(triangles) {
            Ok(_) => Ok(grid),
            Err(_) => {
                let found = format!("a relief of {triangles} triangles");
                Err(Fault::of_file(
                    file,
                    found,
                    "at most 4294967295, of which a file has a count",
                ))
            }
        }
    }

    /// Vertices along x and y.
    fn counts(&self, [nx, ny]: [usize; 2]) -> [usize; 2] {
        match self.stairs {
            true => [2 * nx, 2 * ny],
            false => [nx, ny],
        }
    }

    /// Number of triangles for so many cells: the top, the sides, and the bottom as a fan.
    pub(crate) fn triangles(&self, size: [usize; 2]) -> u64 {
        let [nx, ny] = self.counts(size).map(|n| n.saturating_sub(1) as u64);
        let rim = 2 * (nx + ny);
        2 * nx * ny + 2 * rim + rim
    }

    /// The places of all vertices along an axis, from the outer edge of the first cell or its centre.
    fn places(&self, count: usize, pitch_um: f64) -> Vec<f32> {
        let start = -0.5 * count as f64;
        let half_wall = 0.5 * self.wall_um / pitch_um;
        let place = |i: f64| ((start + i) * pitch_um * self.scale) as f32;
        let mut places = Vec::new();
        for i in 0..count {
            let at = i as f64;
            match self.stairs {
                true => {
                    places.push(place(if i == 0 { at } else { at + half_wall }));
                    let end = at + 1.0;
                    places.push(place(if i + 1 == count { end } else { end - half_wall }));
                }
                false => places.push(place(at + 0.5)),
            }
        }
        places
    }

    /// Writes a relief; returns the number of triangles.
    ///
    /// # Errors
    /// A row that cannot be read, or an error of the file system.
    pub(crate) fn write(
        &self,
        out: &mut impl Write,
        cells: &mut Cells,
        made: &MadeValues,
    ) -> io::Result<u64> {
        let [nx, ny] = cells.size();
        let [dx, dy] = cells.pitch_um;
        let (xs, ys) = (self.places(nx, dx), self.places(ny, dy));
        let promised = self.triangles([nx, ny]);
        let mut head = [b' '; 80];
        let title = b"raylet relief";
        head.iter_mut()
            .zip(title)
            .for_each(|(to, from)| *to = *from);
        out.write_all(&head)?;
        let count = u32::try_from(promised).map_err(io::Error::other)?;
        out.write_all(&count.to_le_bytes())?;

        // Lines of vertices from the smallest y; a row of cells has two of them, or one.
        let mut mesh = Mesh { out, triangles: 0 };
        let mut values = vec![0.0; nx];
        let (mut last, mut line): (Vec<Vertex>, Vec<Vertex>) = (Vec::new(), Vec::new());
        let lines = if self.stairs { 2 } else { 1 };
        for (y, ys) in ys.chunks(lines).enumerate() {
            made.row(cells, y, &mut values)?;
            for at in ys {
                line.clear();
                let heights = values
                    .iter()
                    .flat_map(|value| std::iter::repeat_n(value, lines));
                line.extend(
                    xs.iter().zip(heights).map(|(x, height)| {
                        [*x, *at, ((self.base_um + height) * self.scale) as f32]
                    }),
                );
                match last.is_empty() {
                    true => mesh.front(&line)?,
                    false => mesh.strip(&last, &line)?,
                }
                std::mem::swap(&mut last, &mut line);
            }
        }
        mesh.back(&last)?;
        mesh.bottom(&xs, &ys)?;
        Ok(mesh.triangles)
    }
}

impl<W: Write> Mesh<'_, W> {
    /// The top between two lines, and the sides at their ends.
    fn strip(&mut self, last: &[Vertex], line: &[Vertex]) -> io::Result<()> {
        let right = last.iter().skip(1).zip(line.iter().skip(1));
        for ((a, d), (b, c)) in last.iter().zip(line).zip(right) {
            self.quad([*a, *b, *c, *d])?;
        }
        if let (Some(p), Some(q)) = (last.first(), line.first()) {
            self.quad([below(*q), below(*p), *p, *q])?;
        }
        if let (Some(p), Some(q)) = (last.last(), line.last()) {
            self.quad([below(*p), below(*q), *q, *p])?;
        }
        Ok(())
    }

    /// The side of the smallest y.
    fn front(&mut self, line: &[Vertex]) -> io::Result<()> {
        for (a, b) in line.iter().zip(line.iter().skip(1)) {
            self.quad([below(*a), below(*b), *b, *a])?;
        }
        Ok(())
    }

    /// The side of the largest y.
    fn back(&mut self, line: &[Vertex]) -> io::Result<()> {
        for (a, b) in line.iter().zip(line.iter().skip(1)) {
            self.quad([below(*b), below(*a), *a, *b])?;
        }
        Ok(())
    }

    /// The bottom: a fan about its middle to every vertex of its rim.
    fn bottom(&mut self, xs: &[f32], ys: &[f32]) -> io::Result<()> {
        let (Some(x0), Some(x1), Some(y0), Some(y1)) =
            (xs.first(), xs.last(), ys.first(), ys.last())
        else {
            return Ok(());
        };
        let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0];
        for (a, b) in xs.iter().zip(xs.iter().skip(1)) {
            self.triangle([middle, [*b, *y0, 0.0], [*a, *y0, 0.0]])?;
            self.triangle([middle, [*a, *y1, 0.0], [*b, *y1, 0.0]])?;
        }
        for (a, b) in ys.iter().zip(ys.iter().skip(1)) {
            self.triangle([middle, [*x0, *a, 0.0], [*x0, *b, 0.0]])?;
            self.triangle([middle, [*x1, *b, 0.0], [*x1, *a, 0.0]])?;
        }
        Ok(())
    }
}
