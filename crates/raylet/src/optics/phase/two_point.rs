//! The phase of a hologram of two points: it turns the wave of the reference into that of the object.

use crate::math::real::Real;
use crate::optics::phase::placement::Placement;
use crate::optics::shape::Shape;

/// A wave as it crosses an element, given on the element's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordedWave {
    /// Collimated, with these direction cosines.
    Collimated([f64; 3]),
    /// From a point [x, y, z] in mm, or to it, where `converges`.
    Point {
        /// The point; its z is not zero.
        at: [f64; 3],
        /// Whether the light runs to the point.
        converges: bool,
    },
}

/// φ = k (path of the object's wave − path of the reference's) on the surface of the element, zero at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoPoint {
    /// The wave that leaves the element.
    pub object: RecordedWave,
    /// The wave that lights it.
    pub reference: RecordedWave,
    /// Wavenumbers 2πn/λ at the wavelength of the construction, of the object and of the reference, in rad/mm.
    pub wavenumbers: [f64; 2],
    /// Diffraction order of which this is the phase.
    pub order: f64,
    /// The surface of the element, and where the hologram's own axes stand on it.
    pub surface: (Shape, Placement),
}

impl RecordedWave {
    /// The path to a point in mm, zero at the origin.
    fn path<T: Real>(&self, [x, y, z]: [T; 3]) -> T {
        match *self {
            Self::Collimated([p, q, r]) => x * p + y * q + z * r,
            Self::Point {
                at: [a, b, c],
                converges,
            } => {
                // |r − o| − |o| without cancellation.
                let (u, v, w) = (x - a, y - b, z - c);
                let distance = (u * u + v * v + w * w).sqrt();
                let middle = (a * a + b * b + c * c).sqrt();
                let path = ((u - a) * x + (v - b) * y + (w - c) * z) / (distance + middle);
                path * if converges { -1.0 } else { 1.0 }
            }
        }
    }
}

impl TwoPoint {
    /// The phase in rad at the point of the element over (x, y) of the hologram's own axes.
    pub fn phase<T: Real>(&self, x: T, y: T) -> T {
        let [object, reference] = self.wavenumbers.map(|k| k * self.order);
        let at = [x, y, self.height(x, y)];
        self.object.path(at) * object - self.reference.path(at) * reference
    }

    /// The height of the surface; zero where there is none, which no light reaches.
    fn height<T: Real>(&self, x: T, y: T) -> T {
        let (shape, placement) = &self.surface;
        let [x, y] = placement.outwards(x, y);
        let height = shape.height(x, y);
        height.map_or_else(|| T::constant(0.0), |height| height.z)
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::two_point::{RecordedWave, TwoPoint};
    use crate::optics::shape::Shape;

    /// A hologram of a point 30 mm aside and 40 mm behind, lit from a point 50 mm before it, on a plane and on a sphere, off
    /// centre and turned: the optical paths from the one to the other over all places of the element differ by whole waves
    /// less the phase.
    #[test]
    fn light_of_the_reference_goes_on_to_the_object() {
        let k = 9000.0;
        let (from, to) = ([1.0, -2.0, -50.0], [30.0, 0.0, 40.0]);
        for shape in [Shape::Plane, Shape::sphere(25.0)] {
            let placement = Placement {
                centre: [0.7, -0.4],
                rotation: 0.3,
            };
            let hologram = TwoPoint {
                object: RecordedWave::Point {
                    at: to,
                    converges: true,
                },
                reference: RecordedWave::Point {
                    at: from,
                    converges: false,
                },
                wavenumbers: [k, k],
                order: 1.0,
                surface: (shape.clone(), placement),
            };
            let way = |x: f64, y: f64, at: [f64; 3]| {
                let [u, v] = placement.outwards(x, y);
                let z = shape.sag(u, v).expect("on the sphere");
                ((x - at[0]).powi(2) + (y - at[1]).powi(2) + (z - at[2]).powi(2)).sqrt()
            };
            let total = |x: f64, y: f64| way(x, y, from) + way(x, y, to) + hologram.phase(x, y) / k;
            for (x, y) in [(3.0, 0.0), (-2.0, 5.0), (0.1, -7.0)] {
                assert!((total(x, y) - total(0.0, 0.0)).abs() < 1e-12);
            }
        }
    }
}
