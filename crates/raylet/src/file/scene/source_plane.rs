//! The plane on which the light of a source is given.

/// Where the plane of a source stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SourcePlane {
    /// From it to the first element's vertex, in mm.
    pub distance_mm: f64,
    /// Its shift in mm.
    pub decenter_mm: [f64; 2],
    /// Its tilt in degrees.
    pub tilt_deg: [f64; 3],
}
