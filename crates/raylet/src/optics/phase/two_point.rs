//! The phase of a hologram of two points: it turns the wave of the reference into that of the object.

use crate::math::real::Real;

/// A wave as it crosses the plane of an element, given on the element's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordedWave {
    /// Collimated, with these direction cosines along x and y.
    Collimated([f64; 2]),
    /// From a point [x, y, z] in mm, or to it, where `converges`.
    Point {
        /// The point; its z is not zero.
        at: [f64; 3],
        /// Whether the light runs to the point.
        converges: bool,
    },
}

/// φ = k (path of the object's wave − path of the reference's), zero at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoPoint {
    /// The wave that leaves the element.
    pub object: RecordedWave,
    /// The wave that lights it.
    pub reference: RecordedWave,
    /// Wavenumbers 2πn/λ at the wavelength of the construction, of the object and of the reference, in rad/mm.
    pub wavenumbers: [f64; 2],
    /// Diffraction order of which this is the phase.
    pub order: f64,
}

impl RecordedWave {
    /// The path to (x, y, 0) in mm, zero at the origin.
    fn path<T: Real>(&self, x: T, y: T) -> T {
        match *self {
            Self::Collimated([p, q]) => x * p + y * q,
            Self::Point {
                at: [a, b, c],
                converges,
            } => {
                // |r − o| − |o| without cancellation.
                let (u, v) = (x - a, y - b);
                let distance = (u * u + v * v + c * c).sqrt();
                let middle = (a * a + b * b + c * c).sqrt();
                let path = ((u - a) * x + (v - b) * y) / (distance + middle);
                path * if converges { -1.0 } else { 1.0 }
            }
        }
    }
}

impl TwoPoint {
    /// The phase in rad at a point of the element.
    pub fn phase<T: Real>(&self, x: T, y: T) -> T {
        let [object, reference] = self.wavenumbers.map(|k| k * self.order);
        self.object.path(x, y) * object - self.reference.path(x, y) * reference
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::phase::two_point::{RecordedWave, TwoPoint};

    /// A hologram of a point 30 mm aside and 40 mm behind, lit from a point 50 mm before it: the optical paths from the one to
    /// the other over all places of the element differ by whole waves less the phase.
    #[test]
    fn light_of_the_reference_goes_on_to_the_object() {
        let k = 9000.0;
        let (from, to) = ([1.0, -2.0, -50.0], [30.0, 0.0, 40.0]);
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
        };
        let way = |x: f64, y: f64, at: [f64; 3]| {
            ((x - at[0]).powi(2) + (y - at[1]).powi(2) + at[2].powi(2)).sqrt()
        };
        let total = |x: f64, y: f64| way(x, y, from) + way(x, y, to) + hologram.phase(x, y) / k;
        for (x, y) in [(3.0, 0.0), (-2.0, 5.0), (0.1, -7.0)] {
            assert!((total(x, y) - total(0.0, 0.0)).abs() < 1e-12);
        }
    }
}
