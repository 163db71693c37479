//! Draws scenes/smiley.png: a line drawing on black, 100 × 100 pixels, the target of the source paper's
//! free-space and lens holograms by its description (a ring, two elliptical eyes, a smile with end ticks).
//!
//! `cargo run --release -p raylet --example draw_smiley -- scenes/smiley.png`

use ndarray::Array2;
use raylet::file::image::{ImageError, write_gray16};

const SIDE: usize = 100;
/// Points per pixel along x and y, for smooth edges.
const FINE: usize = 8;
const STROKE: f64 = 3.0;

/// Whether the point (x, y), in pixels from the top left corner, is part of the drawing.
fn inked(x: f64, y: f64) -> bool {
    let half = 0.5 * STROKE;
    let stroke = |cx: f64, cy: f64, radius: f64| ((x - cx).hypot(y - cy) - radius).abs() < half;
    let head = stroke(50.0, 50.0, 34.5);
    let eye = |cx: f64| ((x - cx) / 3.5).powi(2) + ((y - 40.0) / 7.0).powi(2) < 1.0;
    // The smile: the lower part of a circle through its two ends and its lowest point.
    let (reach, depth, end) = (23.5, 15.0, 56.5);
    let radius = (reach * reach + depth * depth) / (2.0 * depth);
    let centre = end + depth - radius;
    let smile = y > end && stroke(50.0, centre, radius);
    // A short tick along the radius at each end.
    let tick = |side: f64| {
        let (dx, dy) = (side * reach / radius, (end - centre) / radius);
        let (u, v) = (x - 50.0, y - centre);
        let (along, across) = (u * dx + v * dy - radius, u * dy - v * dx);
        along.abs() < 3.0 && across.abs() < half
    };
    head || eye(38.5) || eye(61.5) || smile || tick(1.0) || tick(-1.0)
}

fn main() -> Result<(), ImageError> {
    let path = std::env::args().nth(1);
    let path = path.unwrap_or_else(|| String::from("scenes/smiley.png"));
    // Row 0 is the bottom of the picture.
    let values = Array2::from_shape_fn((SIDE, SIDE), |(j, i)| {
        let fine = |cell: usize, t: usize| cell as f64 + (t as f64 + 0.5) / FINE as f64;
        let inked_points = (0..FINE * FINE)
            .filter(|t| inked(fine(i, t % FINE), fine(SIDE - 1 - j, t / FINE)))
            .count();
        inked_points as f64 / (FINE * FINE) as f64
    });
    write_gray16(path, values.view(), [0.0, 1.0])
}
