//! Where the light comes from, as a scene file describes it.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::number::{
    LEAST, acute, count, one_or_pair_schema, pitch, positive, share, some_widths, taper_order,
    widths,
};
use crate::file::decode::shared_keys::table;
use crate::file::decode::tagged::tagged;
use crate::file::scene::source_plane::SourcePlane;

tagged! {
    /// A coherent source.
    pub enum Illumination {
        /// Collimated light of unit amplitude.
        Plane(PlaneIllumination) = "plane",
        /// A spherical wave from a point.
        Point(PointIllumination) = "point",
        /// A Gaussian beam, as of a laser or a single-mode fibre.
        Gaussian(GaussianIllumination) = "gaussian",
        /// A field on a plane before the first element.
        Field(FieldIllumination) = "field",
        /// A mode of a fibre that ends before the first element.
        Fibre(FibreIllumination) = "fibre",
    }
}

/// A plane wave of unit amplitude with phase zero at the first element's vertex.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneIllumination {
    /// Direction [ax, ay] in degrees: its direction cosines along x and y are sin ax and sin ay.
    #[serde(default, deserialize_with = "acute")]
    pub angle_deg: [f64; 2],
    /// How the amplitude falls off aside of the axis of the beam; even without it.
    #[serde(default)]
    pub taper: Option<BeamTaper>,
    /// Radius in millimetres of a hard-edged beam on the first element.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub beam_radius_mm: Option<f64>,
}

/// A spherical wave, of unit amplitude at the first element's vertex.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointIllumination {
    /// The luminous point [x, y, z] in millimetres from the origin, where the axis begins: the first element's
    /// vertex, before coordinate breaks and shifts. z is below zero.
    pub position_mm: [f64; 3],
    /// How the amplitude falls off over directions; even without it.
    #[serde(default)]
    pub taper: Option<ConeTaper>,
    /// Radius in millimetres of a hard-edged beam on the first element.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub beam_radius_mm: Option<f64>,
}

/// A paraxial Gaussian beam, of unit amplitude and phase zero at the centre of its waist. That of a single-mode fibre has
/// half its mode field diameter as the radius of the waist, at the end of the fibre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaussianIllumination {
    /// Radius of the waist in micrometres, where the intensity is 1/e² of that in the middle: one number, or one along each
    /// of its axes.
    #[serde(deserialize_with = "pitch")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub waist_radius_um: [f64; 2],
    /// Centre of the waist [x, y, z] in millimetres from the origin, where the axis begins: the first element's vertex, before
    /// coordinate breaks and shifts.
    #[serde(default)]
    pub waist_mm: [f64; 3],
    /// Direction [ax, ay] in degrees: its direction cosines along x and y are sin ax and sin ay.
    #[serde(default, deserialize_with = "acute")]
    pub angle_deg: [f64; 2],
    /// Angle of the first axis of the waist in degrees, from x towards y.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Radius in millimetres of a hard-edged aperture on the first element.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub beam_radius_mm: Option<f64>,
}

/// The amplitude exp(−ρ^{2m}) over places, ρ² = (u/a)² + (v/b)² across the beam's direction: as of a collimated laser beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeamTaper {
    /// Radius in millimetres at which the intensity is 1/e² of that in the middle: one number, or a and b.
    #[serde(deserialize_with = "widths")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub radius_mm: [f64; 2],
    /// Order m from 1 to 50: 1 for a Gaussian, more for a flatter top.
    #[serde(default = "gaussian", deserialize_with = "taper_order")]
    #[schemars(extend("minimum" = 1, "maximum" = 50))]
    pub order: u32,
    /// The middle of the beam [x, y] in millimetres from the first element's vertex.
    #[serde(default)]
    pub centre_mm: [f64; 2],
    /// Angle of u in degrees, from x towards y.
    #[serde(default)]
    pub rotation_deg: f64,
}

/// The amplitude exp(−ρ^{2m}) over directions, ρ² = (u/a)² + (v/b)² of direction cosines u and v across the middle: as of a laser
/// diode. Its widths are given by half angles or by numerical apertures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeTaper {
    /// Half angle in degrees at which the intensity is 1/e² of that in the middle, whose sine is a width: one number, or
    /// those for a and b.
    #[serde(default, deserialize_with = "some_widths")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub half_angle_deg: Option<[f64; 2]>,
    /// In its place the numerical aperture: the sine of that angle times the index of the ambient medium.
    #[serde(default, deserialize_with = "some_widths")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub numerical_aperture: Option<[f64; 2]>,
    /// Order m from 1 to 50: 1 for a Gaussian, more for a flatter top.
    #[serde(default = "gaussian", deserialize_with = "taper_order")]
    #[schemars(extend("minimum" = 1, "maximum" = 50))]
    pub order: u32,
    /// Direction of the middle [ax, ay] in degrees: its direction cosines along x and y are sin ax and sin ay.
    #[serde(default, deserialize_with = "acute")]
    pub angle_deg: [f64; 2],
    /// Angle of u in degrees, from x towards y.
    #[serde(default)]
    pub rotation_deg: f64,
}

fn gaussian() -> u32 {
    1
}

fn fundamental() -> [u32; 2] {
    [0, 1]
}

table! {
    /// A complex field of a limited band on a plane before the first element, by samples at the Nyquist rate or closer. It is zero
    /// beyond them.
    pub struct FieldIllumination with [before] {
        /// Array of the samples, complex or real, indexed [y, x], in a NumPy file or a map (.dat, .tif, .fits, .h5); the row index grows with y.
        pub samples: PathBuf,
        /// Name of the array in a .npz file.
        #[serde(default)]
        pub key: Option<String>,
        /// Distance of neighbouring samples in micrometres: one number, or [x, y].
        #[serde(deserialize_with = "pitch")]
        #[schemars(schema_with = "one_or_pair_schema")]
        pub pitch_um: [f64; 2],
        /// Number of samples [nx, ny]; checked against the array.
        #[serde(default, deserialize_with = "count")]
        pub size: Option<[usize; 2]>,
    }
}

table! {
    /// A mode of a fibre, at its end before the first element: the Gaussian of a mode field diameter, or the mode LP_lm of a
    /// weakly guiding step-index fibre. Its largest amplitude is one.
    pub struct FibreIllumination with [before] {
        /// Mode field diameter in micrometres, where the intensity is 1/e² of that in the middle, at all wavelengths.
        #[serde(default, deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub mode_field_diameter_um: Option<f64>,
        /// Radius of the core of a step-index fibre in micrometres.
        #[serde(default, deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub core_radius_um: Option<f64>,
        /// Numerical aperture √(n₁² − n₂²) of core and cladding, below 1.
        #[serde(default, deserialize_with = "share")]
        #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
        pub numerical_aperture: Option<f64>,
        /// The mode [l, m] of a step-index fibre: 2l maxima around, m rings; [0, 1] is the fundamental mode.
        #[serde(default = "fundamental")]
        pub mode: [u32; 2],
        /// Angle in degrees of a maximum, from x towards y.
        #[serde(default)]
        pub rotation_deg: f64,
    }
}

impl Illumination {
    /// The plane on which the light is given, where it is given on one.
    pub(crate) fn plane(&self) -> Option<SourcePlane> {
        match self {
            Self::Field(field) => Some(field.plane()),
            Self::Fibre(fibre) => Some(fibre.plane()),
            Self::Plane(_) | Self::Point(_) | Self::Gaussian(_) => None,
        }
    }

    /// Radius in mm of a hard-edged beam on the first element, where one is stated.
    pub(crate) fn beam_radius_mm(&self) -> Option<f64> {
        match self {
            Self::Plane(plane) => plane.beam_radius_mm,
            Self::Point(point) => point.beam_radius_mm,
            Self::Gaussian(beam) => beam.beam_radius_mm,
            Self::Field(_) | Self::Fibre(_) => None,
        }
    }

    /// What no single value shows to be wrong: a key, what it has, and what is expected.
    pub(crate) fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        let point = match self {
            Self::Point(point) => point,
            Self::Fibre(fibre) => return fibre.fault(),
            Self::Plane(_) | Self::Gaussian(_) | Self::Field(_) => return None,
        };
        let z = point.position_mm[2];
        if z > -LEAST {
            let expected =
                "less than zero, at most -1e-12: the point lies before the first element";
            return Some(("position_mm[2]", z.to_string(), expected));
        }
        let taper = point.taper.as_ref()?;
        match (taper.half_angle_deg, taper.numerical_aperture) {
            (Some(angles), None) => {
                let wide = angles.into_iter().find(|angle| *angle >= 90.0)?;
                let expected = "half angles below 90 degrees";
                Some(("taper.half_angle_deg", wide.to_string(), expected))
            }
            (None, Some(_)) => None,
            (both, _) => {
                let found = both.map_or("neither", |_| "both");
                let expected = "half_angle_deg or numerical_aperture";
                Some(("taper", found.to_owned(), expected))
            }
        }
    }
}

/// The most maxima around, or rings, of a mode.
const MOST_LOBES: u32 = 50;

/// What says which mode a fibre has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FibreProfile {
    /// A Gaussian of this mode field diameter in micrometres.
    Gaussian(f64),
    /// A step-index fibre: the radius of its core in micrometres, and its numerical aperture.
    StepIndex([f64; 2]),
}

impl FibreIllumination {
    /// Which of its keys say what mode it has; nothing where none or too many do.
    pub(crate) fn profile(&self) -> Option<FibreProfile> {
        let step_index = (self.core_radius_um, self.numerical_aperture);
        match (self.mode_field_diameter_um, step_index) {
            (Some(diameter), (None, None)) => Some(FibreProfile::Gaussian(diameter)),
            (None, (Some(radius), Some(aperture))) => {
                Some(FibreProfile::StepIndex([radius, aperture]))
            }
            _ => None,
        }
    }

    /// Keys that do not go together, or a mode without a name.
    fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        let [l, m] = self.mode;
        match self.profile() {
            None => {
                let expected =
                    "mode_field_diameter_um alone, or core_radius_um and numerical_aperture";
                let given = [
                    ("mode_field_diameter_um", self.mode_field_diameter_um),
                    ("core_radius_um", self.core_radius_um),
                    ("numerical_aperture", self.numerical_aperture),
                ];
                let names = given.iter().filter(|key| key.1.is_some()).map(|key| key.0);
                let found = names.collect::<Vec<_>>().join(" and ");
                let found = if found.is_empty() {
                    "none of its keys".to_owned()
                } else {
                    found
                };
                Some(("mode_field_diameter_um", found, expected))
            }
            Some(FibreProfile::Gaussian(_)) => {
                let expected = "[0, 1] where mode_field_diameter_um is given: it has one mode";
                (self.mode != fundamental()).then(|| ("mode", format!("[{l}, {m}]"), expected))
            }
            Some(FibreProfile::StepIndex(_)) => {
                let named = l <= MOST_LOBES && (1..=MOST_LOBES).contains(&m);
                let expected = "[l, m] with l from 0 to 50 and m from 1 to 50";
                (!named).then(|| ("mode", format!("[{l}, {m}]"), expected))
            }
        }
    }
}
