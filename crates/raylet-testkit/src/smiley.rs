//! The line drawing of the source paper's holograms, by its description: a ring, two elliptical eyes, a smile
//! with a tick at each end, white on black.

use ndarray::Array2;

/// Side of the drawing in its own units, and the width of a line.
const SIDE: f64 = 100.0;
const STROKE: f64 = 3.0;

/// Points per unit along x and y, for smooth edges.
const FINE: f64 = 8.0;

/// The drawing on `side`² pixels, from 0 to 1; row 0 is the bottom.
pub fn smiley(side: usize) -> Array2<f64> {
    let unit = SIDE / side as f64;
    let fine = (FINE * unit).ceil() as usize;
    let place = |cell: usize, t: usize| unit * (cell as f64 + (t as f64 + 0.5) / fine as f64);
    Array2::from_shape_fn((side, side), |(j, i)| {
        let inked_points = (0..fine * fine)
            .filter(|t| inked(place(i, t % fine), place(side - 1 - j, t / fine)))
            .count();
        inked_points as f64 / (fine * fine) as f64
    })
}

/// Whether the point (x, y), from the top left corner, is part of the drawing.
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
/// A square picture enlarged to another number of pixels along its side by bilinear interpolation, corner pixels
/// onto corner pixels.
pub fn enlarged(picture: &Array2<f64>, side: usize) -> Array2<f64> {
    let last = picture.nrows() - 1;
    let split = |i: usize| {
        let place = i as f64 * last as f64 / (side.max(2) - 1) as f64;
        let low = (place as usize).min(last.saturating_sub(1));
        (low, (low + 1).min(last), place - low as f64)
    };
    Array2::from_shape_fn((side, side), |(j, i)| {
        let ((y0, y1, b), (x0, x1, a)) = (split(j), split(i));
        let row = |y: usize| picture[[y, x0]] * (1.0 - a) + picture[[y, x1]] * a;
        row(y0) * (1.0 - b) + row(y1) * b
    })
}
