//! Where the light comes from: the field it puts on the first screen.

use num_complex::Complex64;

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::beams::gaussian_beam::GaussianBeam;
use crate::optics::beams::taper::Taper;

/// A coherent source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Collimated light: a plane wave of unit amplitude, phase zero at `origin`.
    Plane {
        /// Unit direction of travel, global.
        direction: Vec3,
        /// Where its phase is zero, in mm.
        origin: Vec3,
    },
    /// A spherical wave from a point, with unit amplitude and phase zero at `reference`.
    Point {
        /// The luminous point, in mm, global.
        position: Vec3,
        /// Where the field is one, in mm.
        reference: Vec3,
    },
    /// Collimated light whose amplitude falls off aside of its axis: a plane wave times a taper over places.
    TaperedPlane {
        /// Unit direction of travel, global.
        direction: Vec3,
        /// Where its phase is zero, in mm.
        origin: Vec3,
        /// A point of its axis, in mm.
        centre: Vec3,
        /// The taper over places from the axis, its widths in mm.
        taper: Taper,
    },
    /// A point's light whose amplitude falls off over angles: a spherical wave times a taper over direction cosines.
    TaperedPoint {
        /// The luminous point, in mm, global.
        position: Vec3,
        /// Where the field is one but for the taper, in mm.
        reference: Vec3,
        /// The taper over unit directions, its widths the sines of half angles.
        taper: Taper,
    },
    /// A Gaussian beam.
    Gaussian(GaussianBeam),
}

/// Plane waves in the spectrum of a Gaussian beam of radius w differ from its axis by up to this over kw: the rest has
/// 1e-4 of the amplitude of the strongest.
const TAIL: f64 = 6.0;

impl Source {
    /// Collimated light at these angles in rad, whose sines are its direction cosines along x and y; its phase is zero
    /// at `origin`. Nothing where no direction has such angles.
    pub fn collimated(angle: [f64; 2], origin: Vec3) -> Option<Self> {
        direction_at(angle).map(|direction| Source::Plane { direction, origin })
    }

    /// Light from a point in mm, global; the field is one at `reference`.
    pub fn point([x, y, z]: [f64; 3], reference: Vec3) -> Self {
        Source::Point {
            position: Vec3::new(x, y, z),
            reference,
        }
    }

    /// The field at a global point, in a medium of wavenumber `k` = 2πn/λ (rad/mm).
    pub fn field(&self, point: Vec3, k: f64) -> Complex64 {
        match self {
            Source::Plane { direction, origin } => {
                Complex64::cis(k * direction.dot(point - *origin))
            }
            Source::Point {
                position,
                reference,
            } => {
                let (r, r0) = ((point - *position).norm(), (*reference - *position).norm());
                // r − r₀ from the difference of squares keeps the phase of far points exact.
                let from_reference = point - *reference;
                let gap = from_reference.dot(point + *reference + *position * -2.0) / (r + r0);
                Complex64::from_polar(r0 / r, k * gap)
            }
            Source::TaperedPlane { centre, taper, .. } => {
                self.untapered().field(point, k) * taper.amplitude(point - *centre)
            }
            Source::TaperedPoint { taper, .. } => {
                let towards = self.direction(point);
                self.untapered().field(point, k) * taper.amplitude(towards)
            }
            Source::Gaussian(beam) => beam.field(point, k),
        }
    }

    /// The same light from another unit direction, if it is collimated, or from another place in mm, if it is that of a
    /// point; a Gaussian beam stays as it is.
    pub(crate) fn with_light(&self, light: Vec3) -> Self {
        let mut other = *self;
        match &mut other {
            Source::Plane { direction, .. } | Source::TaperedPlane { direction, .. } => {
                *direction = light;
            }
            Source::Point { position, .. } | Source::TaperedPoint { position, .. } => {
                *position = light;
            }
            Source::Gaussian(_) => {}
        }
        other
    }

    /// The same wave with an even amplitude, where it has a taper.
    fn untapered(&self) -> Self {
        match *self {
            Source::TaperedPlane {
                direction, origin, ..
            } => Source::Plane { direction, origin },
            Source::TaperedPoint {
                position,
                reference,
                ..
            } => Source::Point {
                position,
                reference,
            },
            other => other,
        }
    }

    /// The optical path of the light at a global point in mm, zero where its phase is, in a medium of index `n`.
    pub fn path(&self, point: Vec3, n: f64) -> f64 {
        match self {
            Source::Plane { direction, origin }
            | Source::TaperedPlane {
                direction, origin, ..
            } => n * direction.dot(point - *origin),
            Source::Point {
                position,
                reference,
            }
            | Source::TaperedPoint {
                position,
                reference,
                ..
            } => n * ((point - *position).norm() - (*reference - *position).norm()),
            Source::Gaussian(beam) => n * beam.path(point),
        }
    }

    /// The unit direction of the light at a global point.
    pub fn direction<T: Real>(&self, point: Vec3<T>) -> Vec3<T> {
        match self {
            Source::Plane { direction, .. } | Source::TaperedPlane { direction, .. } => {
                Vec3::constant(*direction)
            }
            Source::Point { position, .. } | Source::TaperedPoint { position, .. } => {
                (point - Vec3::constant(*position)).unit()
            }
            Source::Gaussian(beam) => beam.direction(point),
        }
    }

    /// The radius in mm over which its amplitude falls at a global point, in a medium of wavenumber `k`; infinite for light
    /// of even amplitude.
    pub(crate) fn radius_at(&self, point: Vec3, k: f64) -> f64 {
        match self {
            Source::Plane { .. } | Source::Point { .. } => f64::INFINITY,
            Source::TaperedPlane { taper, .. } => taper.fall(),
            Source::TaperedPoint {
                position, taper, ..
            } => taper.fall() * (point - *position).norm(),
            Source::Gaussian(beam) => beam.radius_at(point, k),
        }
    }

    /// The point that it comes from, if it comes from one.
    pub fn point_of_light(&self) -> Option<Vec3> {
        match self {
            Source::Point { position, .. } | Source::TaperedPoint { position, .. } => {
                Some(*position)
            }
            Source::Plane { .. } | Source::TaperedPlane { .. } | Source::Gaussian(_) => None,
        }
    }

    /// A point and the direction of the middle of light whose amplitude falls off; nothing for light of even amplitude.
    pub(crate) fn middle(&self) -> Option<(Vec3, Vec3)> {
        match self {
            Source::Plane { .. } | Source::Point { .. } => None,
            Source::TaperedPlane {
                direction, centre, ..
            } => Some((*centre, *direction)),
            Source::TaperedPoint {
                position, taper, ..
            } => Some((*position, taper.axes[2])),
            Source::Gaussian(beam) => Some((beam.waist, beam.axes[2])),
        }
    }

    /// Whether its amplitude is even over its wavefronts.
    pub(crate) fn is_even(&self) -> bool {
        matches!(self, Source::Plane { .. } | Source::Point { .. })
    }

    /// How far the direction cosines of its plane waves differ from its direction at a global point, because its
    /// amplitude falls there.
    pub(crate) fn spread_at(&self, point: Vec3, k: f64) -> f64 {
        TAIL / (k * self.radius_at(point, k))
    }
}

/// The direction whose cosines along x and y are the sines of these angles in rad; nothing where there is none.
pub fn direction_at(angle: [f64; 2]) -> Option<Vec3> {
    let [x, y] = angle.map(f64::sin);
    let under = 1.0 - x * x - y * y;
    (under > 0.0).then(|| Vec3::new(x, y, under.sqrt()))
}

#[cfg(test)]
mod tests {
    use crate::math::vec3::Vec3;
    use crate::optics::source::Source;

    #[test]
    fn far_point_becomes_a_plane_wave() {
        let source = Source::Point {
            position: Vec3::new(0.0, 0.0, -1e9),
            reference: Vec3::new(0.0, 0.0, 0.0),
        };
        let k = std::f64::consts::TAU / 0.7e-3;
        let field = source.field(Vec3::new(0.3, 0.2, 0.01), k);
        let plane = Source::Plane {
            direction: Vec3::new(0.0, 0.0, 1.0),
            origin: Vec3::new(0.0, 0.0, 0.0),
        }
        .field(Vec3::new(0.3, 0.2, 0.01), k);
        assert!((field - plane).norm() < 1e-5);
    }
}
