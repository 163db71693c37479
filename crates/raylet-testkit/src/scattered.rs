//! A tilted element with rays on it, for scattering.

use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::bundle::Rays;
use raylet::optics::frame::Frame;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::Shape;

use super::noise::column;
use super::parts::{conic, element, pixel_layer, screen};

/// Pixels of the element along each side.
pub const COUNT: usize = 12;

/// A tilted reflecting element, plane or curved (by its curvature in 1/mm), of these pixels, row by row;
/// missing ones are zero.
pub fn tilted_element(curvature: f64, values: &[Complex64]) -> Screen {
    let value = |(j, i)| values.get(j * COUNT + i).copied().unwrap_or_default();
    let values = ndarray::Array2::from_shape_fn((COUNT, COUNT), value);
    let mut doe = element(pixel_layer(values, 1.5, PixelForm::Box), Aperture::OPEN);
    doe.reflect = true;
    let frame = Frame::GLOBAL.moved(Vec3::new(1.0, 2.0, 30.0));
    Screen {
        name: String::from("mirror"),
        shape: match curvature == 0.0 {
            true => Shape::Plane,
            false => conic(curvature, 0.0),
        },
        ..screen(frame.tilted([0.2, -0.1, 0.3]), ScreenKind::Doe(doe))
    }
}

/// Rays on a screen, in columns.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Where they are, in mm, global.
    pub position: Vec<[f64; 3]>,
    /// Where they go: unit vectors.
    pub direction: Vec<[f64; 3]>,
    /// Their optical paths in mm.
    pub path: Vec<f64>,
    /// Their complex amplitudes.
    pub weight: Vec<Complex64>,
    /// Curvatures of their wavefronts (xx, xy, yy), in 1/mm.
    pub curvature: Vec<[f64; 3]>,
}

impl Columns {
    /// Rays along z on a lattice of 7 by 7 places of a screen, with random weights.
    pub fn on(screen: &Screen) -> Self {
        let places = (0..49).map(|i| [3.0 * f64::from(i % 7) - 9.0, 3.0 * f64::from(i / 7) - 9.1]);
        let position = places.map(|[x, y]| {
            let z = screen.height([x, y]).map_or(f64::NAN, |here| here.z);
            let v = screen.frame.to_global(Vec3::new(x, y, z));
            [v.x, v.y, v.z]
        });
        Self {
            position: position.collect(),
            direction: vec![[0.0, 0.0, 1.0]; 49],
            path: (0..49).map(f64::from).collect(),
            weight: column(49, 3),
            curvature: vec![[0.01, 0.002, -0.005]; 49],
        }
    }

    /// The same as the library takes them.
    pub fn rays(&self) -> Rays<'_> {
        Rays {
            position: &self.position,
            direction: &self.direction,
            path: &self.path,
            weight: &self.weight,
        }
    }
}
