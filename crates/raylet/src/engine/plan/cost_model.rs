//! Measured seconds of one core, from which forecasts are made and methods are chosen.
//!
//! Beamlets from whole fields and local bands have rows of their own. Rays go through surfaces eight at a time.

use crate::optics::shape::Shape;
use crate::optics::surface::Surface;

/// The factor of a surface that is met by iteration.
const ITERATED: f64 = 2.0;

/// The factor of a surface with terms of any kind.
const FREEFORM: f64 = 3.5;

/// The conics that take a ray as long as these surfaces.
pub(crate) fn as_conics(train: &[Surface]) -> f64 {
    let factor = |surface: &Surface| match surface.shape {
        Shape::Plane | Shape::Conic(_) => 1.0,
        Shape::Asphere { .. } | Shape::Biconic(_) | Shape::Toroid(_) => ITERATED,
        Shape::Freeform { .. } => FREEFORM,
    };
    train.iter().map(factor).sum()
}

/// A beamlet sum from a whole field, measured with the lenses for phones and the other systems of real size.
pub(crate) mod beamlets {
    /// Every hop.
    pub(crate) const HOP: f64 = 0.3;

    /// A patch, with the spectrum of its window.
    pub(crate) const PATCH: f64 = 5e-5;

    /// A beamlet.
    pub(crate) const BEAMLET: f64 = 0.4e-6;

    /// A conic or plane that a beamlet crosses; other shapes take longer, as [`as_conics`](super::as_conics) says.
    pub(crate) const SURFACE: f64 = 1e-7;

    /// The correction of a beamlet's aberration; samples on a lattice serve several beamlets.
    pub(crate) const CORRECTION: f64 = 2e-7;

    /// A point at which a beamlet is summed.
    pub(crate) const VALUE: f64 = 5e-10;
}

/// What widths of beamlets are chosen by: costs of single rays. By those of rays in blocks, other widths are chosen, and the
/// gradient by a curvature in the report of accuracy has an error of 1.1e-2 instead of 4.3e-3.
pub(crate) mod beamlet_widths {
    /// A beamlet.
    pub(crate) const BEAMLET: f64 = 1.4e-6;

    /// A conic or plane that a beamlet crosses; other shapes count more.
    pub(crate) const SURFACE: f64 = 2.4e-7;
}

/// A hop by local bands.
pub(crate) mod local_bands {
    /// A window.
    pub(crate) const WINDOW: f64 = 5e-5;

    /// A window of a smooth source, which has one direction.
    pub(crate) const SMOOTH_WINDOW: f64 = 8e-6;

    /// A plane wave of a window.
    pub(crate) const WAVE: f64 = 0.4e-6;

    /// A plane wave of a window from an integral along an edge.
    pub(crate) const EDGE_WAVE: f64 = 0.3e-6;

    /// A conic or plane that a plane wave of a window crosses; other shapes take longer.
    pub(crate) const SURFACE: f64 = 0.05e-6;

    /// A complex product of a matrix transform.
    pub(crate) const PRODUCT: f64 = 0.35e-9;

    /// A node of the element.
    pub(crate) const NODE: f64 = 20e-9;

    /// An operation of a fast transform.
    pub(crate) const OPERATION: f64 = 0.3e-9;

    /// A value on the sensor.
    pub(crate) const VALUE: f64 = 2e-9;
}

/// A whole field.
pub(crate) mod whole_field {
    /// A sample of it.
    pub(crate) const SAMPLE: f64 = 2e-7;

    /// A sample or a plane wave in the transform of a level of a curved screen.
    pub(crate) const TRANSFORMED: f64 = 7e-8;
}

/// A reference without beamlets.
pub(crate) mod references {
    /// A plane wave of a spectrum, a node or a point of its transforms.
    pub(crate) const WAVE: f64 = 1.8e-7;

    /// A node of a direct sum, as it is prepared.
    pub(crate) const SAMPLE: f64 = 1e-7;

    /// A part that the ray of a pixel meets, with its search for the way there.
    pub(crate) const RAY_AT_PART: f64 = 1e-6;
}
