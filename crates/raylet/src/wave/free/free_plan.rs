//! The slabs that a free hop crosses, and the plane waves that it takes.

use crate::wave::patches::patch::Band;

/// A plane-parallel layer of homogeneous medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Refractive index.
    pub index: f64,
    /// Thickness along the direction of travel, in mm.
    pub thickness: f64,
    /// Field transmission of the interface behind it at normal optical cosines (before, after); see
    /// [`crate::optics::refraction::Coating`].
    pub exit: Option<crate::optics::refraction::Coating>,
}

/// What a free hop will do: its directions along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreePlan {
    /// Period along each axis, in mm.
    pub period: [f64; 2],
    /// W along each axis, in mm.
    pub span: [f64; 2],
    /// Lattice of directions along each axis.
    pub bands: [Band; 2],
    /// Largest |p| along each axis that the screen's nodes resolve: of the light that reaches the target, with some of the taper's
    /// range, or of all plane waves.
    pub reach: [f64; 2],
    /// Σ thickness/index of the slabs, in mm.
    pub depth: f64,
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
}

/// Zones of steep light count as no wider than this part of the sum of half widths.
const WIDEST_ZONE: f64 = 0.3;

/// The width in mm of a Fresnel zone of light that lands W = `span` beside the place where it leaves, along that way. It grows
/// without limit where screens come close to each other, and is cut at a part of W there.
pub(in crate::wave) fn zone_width(wavelength: f64, depth: f64, span: f64) -> f64 {
    let usual = (wavelength * depth).sqrt();
    let widest = WIDEST_ZONE * span;
    if depth == 0.0 {
        return widest;
    }
    let steep = usual * (depth.hypot(span) / depth).powf(1.5);
    steep.min(widest).max(usual)
}

impl FreePlan {
    /// W and P − 2W along an axis, in widths of a Fresnel zone of light that lands W away.
    pub(crate) fn zones(&self, axis: usize) -> [f64; 2] {
        let (span, period) = (self.span[axis], self.period[axis]);
        let zone = zone_width(self.wavelength, self.depth, span);
        [span / zone, (period - 2.0 * span) / zone]
    }

    /// Largest |p| of its plane waves along each axis.
    pub(crate) fn largest(&self) -> [f64; 2] {
        (self.bands.each_ref()).map(|band| {
            let last = band.count.max(1) - 1;
            band.at(0).abs().max(band.at(last).abs())
        })
    }

    /// The landing offsets along an axis, in mm, up to which all light is kept, and from which on none is.
    pub(in crate::wave) fn taper(&self, axis: usize) -> [f64; 2] {
        let (span, period) = (self.span[axis], self.period[axis]);
        let clear = 1.5 * (self.wavelength * self.depth).sqrt();
        let full = span + clear.min(0.25 * (period - 2.0 * span));
        [full, period - span]
    }
}
