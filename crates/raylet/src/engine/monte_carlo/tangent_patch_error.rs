//! The error of patches that replace a curved screen by the planes that touch it.
//!
//! At its edge a patch of side D lies D²/8R from the plane that touches a surface of radius R. Light that
//! comes with the normal cosine a and leaves with q there has the phase k(q − a)·D²/8R wrong: for a mirror
//! 2k·D²/8R. The turn arcsin(D/2R) of the surface over half a patch, small as it may be, says nothing about it.

use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::Sag;
use crate::optics::system::Hop;

/// Phase errors above this are worth a warning, in rad.
const WORTH_SAYING: f64 = 0.5;

/// How flat a patch is against its screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TangentPatchError {
    /// Side of the patch in mm.
    pub side: f64,
    /// Smallest radius of curvature of the screen in mm.
    pub radius: f64,
    /// Phase error at the edge of the patch in rad, where the screen is most curved.
    pub phase: f64,
    /// Turn of the surface over half the patch in rad.
    pub angle: f64,
}

impl TangentPatchError {
    /// That of a hop whose patches ignore heights; nothing for others, and for plane screens.
    pub(crate) fn of(hop: &Hop, method: &HopMethod) -> Option<Self> {
        let HopMethod::WholeField(Plan::Paper(plan)) = method else {
            return None;
        };
        let (leaves, side) = (hop.from.index_behind() * hop.from.leaves(), plan.side);
        let ignored = match plan.sag {
            Sag::True => return None,
            Sag::Tangent => leaves - plan.along,
            Sag::Incident => leaves,
        };
        let radius = hop.from.smallest_radius()?;
        Some(Self {
            side,
            radius,
            phase: hop.wavenumber() * ignored.abs() * side * side / (8.0 * radius),
            angle: (0.5 * side / radius).min(1.0).asin(),
        })
    }

    /// The warning that it deserves.
    pub(crate) fn warning(&self) -> Option<String> {
        (self.phase > WORTH_SAYING).then(|| {
            format!(
                "patches of {:.1} µm lie on planes that touch a surface whose smallest radius is \
                 {:.1} µm: at their edges the phase is wrong by up to {:.2} rad (the angle arcsin(D/2R) is \
                 only {:.3} rad); take smaller patches, or the height into account (paper.sag = \"true\")",
                self.side * 1e3,
                self.radius * 1e3,
                self.phase,
                self.angle
            )
        })
    }
}
