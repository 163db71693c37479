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
    /// Σ thickness/index of the slabs, in mm.
    pub depth: f64,
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
}
