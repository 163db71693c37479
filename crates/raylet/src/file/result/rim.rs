//! What a report says of the rim of a surface.

use serde::{Deserialize, Serialize};

use crate::engine::rims::rim_screens::{NoScreen, Rim, RimTreatment};

/// The rim of a surface in a hop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RimEntry {
    /// Name of the rim.
    pub name: String,
    /// How the run treats it: `screen`, `ignored`, `by ray` or `entrance`.
    pub treatment: String,
    /// Root of the share that it cuts of the energy on its way to the second screen, which the error of
    /// leaving it out does not exceed.
    pub bound: f64,
    /// The expected error of clipping single rays at it.
    pub error: f64,
    /// A warning about this treatment; none where it is fine.
    pub warning: Option<String>,
}

impl RimEntry {
    /// The entry of a rim.
    pub fn new(rim: &Rim) -> Self {
        let treatment = match rim.treatment {
            RimTreatment::Screen => "screen",
            RimTreatment::Ignored => "ignored",
            RimTreatment::ByRay(_) => "by ray",
            RimTreatment::Entrance => "entrance",
        };
        let warning = match rim.treatment {
            RimTreatment::ByRay(reason) => Some(format!(
                "{} cuts {:.1e} of the energy ray by ray, without diffraction: {}; about {:.1e} of the field is wrong",
                rim.name,
                rim.cut,
                words(reason),
                rim.error()
            )),
            RimTreatment::Screen | RimTreatment::Ignored | RimTreatment::Entrance => None,
        };
        Self {
            name: rim.name.clone(),
            treatment: treatment.to_owned(),
            bound: rim.bound(),
            error: rim.error(),
            warning,
        }
    }

    /// The entry in a line.
    pub fn line(&self) -> String {
        let Self { name, bound, .. } = self;
        match (&self.warning, self.treatment.as_str()) {
            (Some(warning), _) => format!("warning: {warning}"),
            (None, "screen") => {
                format!("{name}: a screen; left out it might cost {bound:.1e} of the field")
            }
            (None, "entrance") => {
                format!("{name}: the edge of the entrance before it, which diffracts")
            }
            (None, _) => format!("{name}: left out, {bound:.1e} of the field at most"),
        }
    }
}

/// Why a rim is no screen, in words.
fn words(reason: NoScreen) -> String {
    match reason {
        NoScreen::Absent => String::from("its surface does not exist everywhere within it"),
        NoScreen::TooLarge { samples, allowed } => {
            format!(
                "as a screen it takes {samples} samples along its diameter, more than {allowed}"
            )
        }
    }
}
