//! The losses of a design, as a scene describes them.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::losses::spots::Sharing;
use crate::file::decode::number::{not_empty, not_negative, positive};
use crate::file::decode::tagged::tagged;

tagged! {
    /// A loss of a design: a number to be made small.
    pub enum LossSpecification {
        /// 1 − NCC² with a picture, however bright it is.
        Likeness(PictureLoss) = "likeness",
        /// The mean square distance from a picture.
        Mse(MseLoss) = "mse",
        /// −log of the share of the light sent out that falls on its target.
        Efficiency(EfficiencyLoss) = "efficiency",
        /// 1 − the share of the light on the sensor that falls within circles.
        EncircledEnergy(CirclesLoss) = "encircled_energy",
        /// How bright the light is at points.
        Spot(SpotLoss) = "spot",
        /// 1 − the share of the light sent out that is in a target mode: amplitude and phase.
        Overlap(OverlapLoss) = "overlap",
    }
}

/// Declares a loss, with the keys that all of them have.
macro_rules! loss_table {
    (
        $(#[$meta:meta])*
        pub struct $name:ident { $($own:tt)* }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// Factor of this loss.
            #[serde(default = "one", deserialize_with = "positive")]
            #[schemars(extend("minimum" = 1e-12))]
            pub weight: f64,
            /// The scene's wavelengths in micrometres at which it counts; all of them by default. Its weight is
            /// shared by all runs in which it counts.
            #[serde(default)]
            pub wavelength_um: Option<Vec<f64>>,
            /// Numbers, from 0, of the `[[design.field]]`s in which it counts; all of them by default.
            #[serde(default)]
            pub field: Option<Vec<usize>>,
            $($own)*
        }

        impl $name {
            /// The keys that all losses have.
            fn common(&self) -> Common<'_> {
                Common {
                    weight: self.weight,
                    wavelength_um: self.wavelength_um.as_deref(),
                    field: self.field.as_deref(),
                }
            }
        }
    };
}

loss_table! {
    /// 1 − NCC² with a picture.
    pub struct PictureLoss {
        /// The picture, a PNG file; that of `[hologram]` by default.
        #[serde(default)]
        pub picture: Option<PathBuf>,
        /// Width and height of the picture on the sensor in millimetres.
        #[serde(default, deserialize_with = "positive")]
        pub size_mm: Option<[f64; 2]>,
        /// Where the light matters.
        #[serde(default)]
        pub care: Compared,
        /// A PNG file as large as the picture: black where the light does not matter.
        #[serde(default)]
        pub mask: Option<PathBuf>,
    }
}

loss_table! {
    /// The mean of (scale·I − T)² over the sensor's pixels, T the picture.
    pub struct MseLoss {
        /// The picture, a PNG file; that of `[hologram]` by default.
        #[serde(default)]
        pub picture: Option<PathBuf>,
        /// Width and height of the picture on the sensor in millimetres.
        #[serde(default, deserialize_with = "positive")]
        pub size_mm: Option<[f64; 2]>,
        /// Where the light matters.
        #[serde(default)]
        pub care: Compared,
        /// A PNG file as large as the picture: black where the light does not matter.
        #[serde(default)]
        pub mask: Option<PathBuf>,
        /// The picture's white over the intensity that is to look white, in units of the source's. Without it
        /// intensities and picture both count with sum 1, and the loss is the sum of squares.
        #[serde(default, deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub scale: Option<f64>,
    }
}

loss_table! {
    /// −log of a share of the light that is sent out: of what falls into the lit part of a picture, or into
    /// circles.
    pub struct EfficiencyLoss {
        /// The picture, a PNG file; that of `[hologram]` by default, where no circles are given.
        #[serde(default)]
        pub picture: Option<PathBuf>,
        /// Width and height of the picture on the sensor in millimetres.
        #[serde(default, deserialize_with = "positive")]
        pub size_mm: Option<[f64; 2]>,
        /// Middles of circles, [x, y] in millimetres from the sensor's middle.
        #[serde(default)]
        pub at_mm: Vec<[f64; 2]>,
        /// Radius of the circles in millimetres.
        #[serde(default, deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub radius_mm: Option<f64>,
    }
}

loss_table! {
    /// 1 − encircled energy.
    pub struct CirclesLoss {
        /// Middles of the circles, [x, y] in millimetres from the sensor's middle.
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub at_mm: Vec<[f64; 2]>,
        /// Radius of the circles in millimetres.
        #[serde(deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub radius_mm: f64,
    }
}

loss_table! {
    /// The brightness s of points: 1 − mean s, or −mean log s.
    pub struct SpotLoss {
        /// The points, [x, y] in millimetres from the sensor's middle.
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub at_mm: Vec<[f64; 2]>,
        /// Distance at which a perfect wave from the whole aperture would focus: with it s is a Strehl ratio, the
        /// intensity over (open area/λf)². Without it s is the share of the light that falls on the point's pixel.
        #[serde(default, deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub focal_length_mm: Option<f64>,
        /// How points share the light.
        #[serde(default)]
        pub sharing: Sharing,
        /// Factor of the variance of the brightness over its squared mean, which is added.
        #[serde(default, deserialize_with = "not_negative")]
        #[schemars(extend("minimum" = 0))]
        pub evenness: f64,
    }
}

loss_table! {
    /// 1 − the share of the light in a mode whose amplitude is the root of a picture and whose phase is flat.
    pub struct OverlapLoss {
        /// The picture of the mode's intensity, a PNG file; that of `[hologram]` by default.
        #[serde(default)]
        pub picture: Option<PathBuf>,
        /// Width and height of the picture on the sensor in millimetres.
        #[serde(default, deserialize_with = "positive")]
        pub size_mm: Option<[f64; 2]>,
    }
}

/// Where on the sensor the light matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Compared {
    /// Everywhere.
    #[default]
    Sensor,
    /// Within the picture's outline.
    Outline,
}

/// The keys that all losses have.
pub(crate) struct Common<'w> {
    /// Factor of the loss.
    pub(crate) weight: f64,
    /// Wavelengths at which it counts.
    pub(crate) wavelength_um: Option<&'w [f64]>,
    /// Fields in which it counts.
    pub(crate) field: Option<&'w [usize]>,
}

impl LossSpecification {
    /// The keys that all losses have.
    pub(crate) fn common(&self) -> Common<'_> {
        match self {
            LossSpecification::Likeness(spec) => spec.common(),
            LossSpecification::Mse(spec) => spec.common(),
            LossSpecification::Efficiency(spec) => spec.common(),
            LossSpecification::EncircledEnergy(spec) => spec.common(),
            LossSpecification::Spot(spec) => spec.common(),
            LossSpecification::Overlap(spec) => spec.common(),
        }
    }

    /// Its `kind`.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            LossSpecification::Likeness(_) => "likeness",
            LossSpecification::Mse(_) => "mse",
            LossSpecification::Efficiency(_) => "efficiency",
            LossSpecification::EncircledEnergy(_) => "encircled_energy",
            LossSpecification::Spot(_) => "spot",
            LossSpecification::Overlap(_) => "overlap",
        }
    }
}

fn one() -> f64 {
    1.0
}
