//! The target image on the sensor, on any raster.

use ndarray::Array2;

use crate::wave::grid::raster::Raster;

/// A picture of box pixels, centred on the sensor, and how much it is softened.
///
/// A picture finer than the optics can resolve is not a fair goal. The softening convolves it with
/// cos²(πx/2w)/w, |x| < w, whose full width at half maximum is w, along each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Intensities, indexed [y, x] with y upwards, none below zero.
    pub image: Array2<f64>,
    /// Its width and height on the sensor in mm.
    pub size: [f64; 2],
    /// Full widths w at half maximum of the softening along x and y in mm; zero leaves it sharp.
    pub blur: [f64; 2],
}

impl Target {
    /// The target intensity at the points of a raster, [y, x]; zero outside the picture.
    pub fn on(&self, raster: &Raster) -> Array2<f64> {
        let shares = |axis: usize| {
            let cells = [self.image.ncols(), self.image.nrows()][axis];
            let [size, blur] = [self.size[axis], self.blur[axis]];
            let pitch = size / cells as f64;
            Array2::from_shape_fn((raster.size[axis], cells), |(i, cell)| {
                let from = raster.start[axis] + i as f64 * raster.pitch[axis] + 0.5 * size;
                let passed = |edge: f64| softened_step(from - edge, blur);
                passed(cell as f64 * pitch) - passed((cell + 1) as f64 * pitch)
            })
        };
        shares(1).dot(&self.image).dot(&shares(0).t())
    }

    /// Which points of a raster lie inside the picture's outline, [y, x].
    pub fn inside(&self, raster: &Raster) -> Array2<bool> {
        let within = |axis: usize, i: usize| {
            let place = raster.start[axis] + i as f64 * raster.pitch[axis];
            place.abs() <= 0.5 * self.size[axis]
        };
        Array2::from_shape_fn((raster.size[1], raster.size[0]), |(j, i)| {
            within(0, i) && within(1, j)
        })
    }
}

/// The integral of the softening up to t: a step of width 2w.
fn softened_step(t: f64, blur: f64) -> f64 {
    if blur <= 0.0 {
        return if t < 0.0 { 0.0 } else { 1.0 };
    }
    let u = (t / blur).clamp(-1.0, 1.0);
    0.5 * (1.0 + u + (std::f64::consts::PI * u).sin() / std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use crate::design::losses::target::Target;
    use crate::wave::grid::raster::Raster;

    fn raster(pitch: f64, size: [usize; 2]) -> Raster {
        Raster {
            start: size.map(|n| -0.5 * (n as f64 - 1.0) * pitch),
            pitch: [pitch; 2],
            size,
        }
    }

    #[test]
    fn sharp_pictures_are_upright_and_repeat_their_pixels() {
        let target = Target {
            image: array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            size: [3.0, 2.0],
            blur: [0.0; 2],
        };
        // Row 0 is low in y, column 0 low in x; around the picture it is dark.
        let found = target.on(&raster(1.0, [5, 4]));
        assert_eq!(found.row(0).sum(), 0.0);
        assert_eq!(found.row(1), array![0.0, 1.0, 2.0, 3.0, 0.0]);
        assert_eq!(found.row(2), array![0.0, 4.0, 5.0, 6.0, 0.0]);
        let inside = target.inside(&raster(1.0, [5, 4]));
        assert_eq!(inside.iter().filter(|inside| **inside).count(), 6);
    }

    #[test]
    fn softening_is_a_convolution_with_a_cosine_square() {
        let target = Target {
            image: array![[1.0, 0.2], [0.5, 0.9]],
            size: [0.8, 0.6],
            blur: [0.3, 0.2],
        };
        // By the midpoint rule, spectrally exact for the kernel itself; edges fall between its points.
        let at = [0.13, -0.07];
        let points = 4000;
        let kernel = |u: f64| (0.5 * std::f64::consts::PI * u).cos().powi(2);
        let lines = [0, 1].map(|axis| {
            let mut shares = [0.0; 2];
            for i in 0..points {
                let u = 2.0 * (f64::from(i) + 0.5) / f64::from(points) - 1.0;
                let place = at[axis] - u * target.blur[axis] + 0.5 * target.size[axis];
                let cell = (2.0 * place / target.size[axis]).floor();
                if cell == 0.0 || cell == 1.0 {
                    shares[cell as usize] += kernel(u) * 2.0 / f64::from(points);
                }
            }
            shares
        });
        let mut expected = 0.0;
        for ((j, i), value) in target.image.indexed_iter() {
            expected += value * lines[0][i] * lines[1][j];
        }
        let one = Raster {
            start: at,
            pitch: [1.0; 2],
            size: [1, 1],
        };
        assert!((target.on(&one)[[0, 0]] - expected).abs() < 1e-3);

        // Nothing is lost: the sum over a fine raster is the picture's.
        let sum = target.on(&raster(0.01, [160, 140])).sum() * 1e-4;
        let area = 0.4 * 0.3;
        let whole: f64 = target.image.sum() * area;
        assert!((sum - whole).abs() < 1e-6, "{sum} {whole}");
    }
}
