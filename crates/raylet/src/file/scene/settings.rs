//! How a scene is to be computed, and the table of a hologram.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::plan::settings::{Correction, Density, Method, Positions, Sag, Sampler};
use crate::file::decode::number::{
    count, from_one, period, positive, share, step, target, tolerance, width,
};
use crate::optics::refraction::Coating;
use crate::wave::patches::tile::TileWindow;

/// How the scene is computed. What is absent is chosen from the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Which method carries the field through the lenses.
    pub method: Method,
    /// Relative error of the field that the automatic choices aim at, by the power of ten at or below it.
    #[serde(deserialize_with = "target")]
    #[schemars(extend("minimum" = 1e-12, "exclusiveMaximum" = 1))]
    pub target_error: f64,
    /// Standard deviation of the window of a beamlet in micrometres.
    #[serde(deserialize_with = "width")]
    #[schemars(extend("minimum" = 1e-6, "maximum" = 1e9))]
    pub sigma_um: Option<f64>,
    /// Distance of neighbouring windows, in units of sigma; at most 3.
    #[serde(deserialize_with = "step")]
    #[schemars(extend("minimum" = 0.01, "maximum" = 3))]
    pub step: Option<f64>,
    /// Period of a window's spectrum, in units of sigma, from 2 to 100.
    #[serde(deserialize_with = "period")]
    #[schemars(extend("minimum" = 2, "maximum" = 100))]
    pub period: Option<f64>,
    /// Spectral modes below this share of the strongest are left out.
    #[serde(deserialize_with = "share")]
    #[schemars(extend("minimum" = 1e-30, "exclusiveMaximum" = 1))]
    pub mode_threshold: Option<f64>,
    /// A beamlet is cut off where it falls below this share of its peak.
    #[serde(deserialize_with = "share")]
    #[schemars(extend("minimum" = 1e-30, "exclusiveMaximum" = 1))]
    pub footprint_threshold: Option<f64>,
    /// Whether beamlets are corrected beyond their second order.
    pub correction: Correction,
    /// Relative error of the nonuniform Fourier transforms, from 1e-13 to 0.1.
    #[serde(deserialize_with = "tolerance")]
    #[schemars(extend("minimum" = 1e-13, "maximum" = 0.1))]
    pub nufft_tolerance: Option<f64>,
    /// How refracting surfaces transmit that have no coating of their own.
    pub coating: Coating,
    /// Numbers of the method `paper`.
    pub paper: Paper,
    /// The most memory that arrays may take, in units of 10⁶ bytes; if absent, half of what is free when the run starts.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub memory_limit_mb: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            target_error: 1e-3,
            sigma_um: None,
            step: None,
            period: None,
            mode_threshold: None,
            footprint_threshold: None,
            correction: Correction::default(),
            nufft_tolerance: None,
            coating: Coating::default(),
            paper: Paper::default(),
            memory_limit_mb: None,
        }
    }
}

/// Numbers of the method `paper`. What is absent is chosen from the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Paper {
    /// Number of positions; grids take the nearest that fills them.
    #[serde(deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub rays: Option<usize>,
    /// Number of modes drawn at each position.
    #[serde(deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub secondary: Option<usize>,
    /// Width of the square patch in micrometres.
    #[serde(deserialize_with = "width")]
    #[schemars(extend("minimum" = 1e-6, "maximum" = 1e9))]
    pub patch_um: Option<f64>,
    /// What the field in a patch is multiplied by.
    pub window: TileWindow,
    /// Width of the padded patch in units of the patch.
    #[serde(deserialize_with = "from_one")]
    #[schemars(extend("minimum" = 1, "maximum" = 1e6))]
    pub padding: Option<f64>,
    /// How many bands of the pixels' Fourier transform the modes span.
    #[serde(deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub orders: Option<usize>,
    /// How positions are chosen.
    pub positions: Positions,
    /// Whether the field is divided by the sum of the windows that cover it, not by the one expected.
    pub coverage: bool,
    /// Which modes are drawn more often.
    pub density: Density,
    /// How modes are drawn.
    pub sampler: Sampler,
    /// How a patch of a curved element uses its height.
    pub sag: Sag,
    /// Whether contributions carry an obliquity factor.
    pub obliquity: bool,
}

/// A hologram to be computed, so that the sensor shows an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hologram {
    /// The target image on the sensor: a PNG file.
    pub target: PathBuf,
    /// Name of the diffractive element that takes the hologram.
    pub element: String,
    /// Width and height of the image on the sensor in millimetres.
    #[serde(deserialize_with = "positive")]
    pub size_mm: [f64; 2],
    /// Number of iterations.
    #[serde(default = "hundred", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub iterations: usize,
    /// Share of the light that the picture is to have, between 0 and 1; what is found has somewhat less. Without it
    /// iterations trade light for likeness.
    #[serde(default, deserialize_with = "share")]
    #[schemars(extend("minimum" = 1e-30, "exclusiveMaximum" = 1))]
    pub efficiency_goal: Option<f64>,
    /// Whether the lenses are replaced by their principal planes during the search for the hologram.
    #[serde(default = "yes")]
    pub principal_planes: bool,
    /// Whether dark and bright are exchanged.
    #[serde(default)]
    pub invert: bool,
    /// Whether the image is mirrored left to right.
    #[serde(default)]
    pub flip_x: bool,
    /// Whether the image is mirrored top to bottom.
    #[serde(default)]
    pub flip_y: bool,
}

fn hundred() -> usize {
    100
}

fn yes() -> bool {
    true
}
