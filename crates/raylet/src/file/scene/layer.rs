//! Layers of a diffractive element, as a scene file describes them.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::complex_number::ComplexNumber;
use crate::file::decode::number::{
    acute, count, not_empty, not_negative, not_zero, one_or_pair_schema, pitch, positive,
    wavelength, whole_or_part, width,
};
use crate::file::decode::shared_keys::table;
use crate::file::decode::tagged::tagged;
use crate::file::scene::material::Material;
use crate::optics::phase::placement::Placement;
use crate::optics::pixels::active_area::{ActiveArea, FillError, Rest};
use crate::optics::pixels::fringing::Fringing;
use crate::optics::pixels::pixel_grid::PixelForm;

tagged! {
    /// One factor of a diffractive element's complex transmission. Layers of an element multiply, so
    /// their phases add. A phase φ multiplies the field by exp(+iφ).
    pub enum Layer {
        /// A grid of pixels with phase, amplitude or complex transmission from array files.
        Pixels(PixelLayer) = "pixels",
        /// A grid of material heights from an array file: phase k (n − n_ambient) h.
        Height(HeightLayer) = "height",
        /// A linear phase: one order of a blazed grating.
        Grating(GratingLayer) = "grating",
        /// An ideal diffractive lens: equal optical path to its focus.
        Lens(FocusLayer) = "lens",
        /// A conical phase that turns light towards the axis by one angle everywhere.
        Axicon(AxiconLayer) = "axicon",
        /// A spiral phase.
        Vortex(VortexLayer) = "vortex",
        /// Even powers of the radius.
        Radial(RadialLayer) = "radial",
        /// A phase of the radius by samples, with a cubic spline through them.
        RadialTable(RadialTableLayer) = "radial_table",
        /// A smooth phase by samples on a grid, with a bicubic spline between them.
        PhaseGrid(PhaseGridLayer) = "phase_grid",
        /// Zernike polynomials.
        Zernike(ZernikeLayer) = "zernike",
        /// Products of powers of x and y.
        Polynomial(PolynomialLayer) = "xy",
        /// A hologram that turns the wave of a reference into that of an object.
        TwoPoint(TwoPointLayer) = "two_point",
        /// A smooth phase as a blazed or stepped profile, with its diffraction orders.
        Kinoform(KinoformLayer) = "kinoform",
        /// A sum of transmissions, each a product of layers.
        Sum(SumLayer) = "sum",
    }
}

impl Layer {
    /// Where the own axes of an analytic phase stand; nothing for other layers.
    pub(crate) fn placement(&self) -> Option<Placement> {
        match self {
            Layer::Grating(layer) => Some(layer.placement()),
            Layer::Lens(layer) => Some(layer.placement()),
            Layer::Axicon(layer) => Some(layer.placement()),
            Layer::Vortex(layer) => Some(layer.placement()),
            Layer::Radial(layer) => Some(layer.placement()),
            Layer::RadialTable(layer) => Some(layer.placement()),
            Layer::PhaseGrid(layer) => Some(layer.placement()),
            Layer::Zernike(layer) => Some(layer.placement()),
            Layer::Polynomial(layer) => Some(layer.placement()),
            Layer::TwoPoint(layer) => Some(layer.placement()),
            Layer::Pixels(_) | Layer::Height(_) | Layer::Kinoform(_) | Layer::Sum(_) => None,
        }
    }
}

table! {
    /// A grid of pixels, centred unless `centre_mm` says otherwise. Arrays are 2-D, indexed [y, x]; the row index grows with y. Files are
    /// those of NumPy (.npy, or .npz where the array is found under `key`) or maps (.dat, .tif, .fits, .h5).
    pub struct PixelLayer with [axes] {
        /// Distance of neighbouring pixel centres in micrometres: one number, or [x, y].
        #[serde(deserialize_with = "pitch")]
        #[schemars(schema_with = "one_or_pair_schema")]
        pub pitch_um: [f64; 2],
        /// Number of pixels [nx, ny]. Needed only where no array gives it, for a hologram that is still to
        /// be computed; checked against the arrays otherwise.
        #[serde(default, deserialize_with = "count")]
        pub size: Option<[usize; 2]>,
        /// Real array of the phase in radians, before `phase_scale`.
        #[serde(default)]
        pub phase: Option<PathBuf>,
        /// Factor on the phase array, such as 6.2832 for a file in waves.
        #[serde(default = "one", deserialize_with = "not_zero")]
        pub phase_scale: f64,
        /// Real array of the field amplitude (not the intensity).
        #[serde(default)]
        pub amplitude: Option<PathBuf>,
        /// Complex array of the field transmission, instead of phase and amplitude.
        #[serde(default)]
        pub transmission: Option<PathBuf>,
        /// Name of the array in .npz files. Without it: the array named like the key that names the file
        /// (`phase`, `amplitude`, `transmission`), or else the only array of the file.
        #[serde(default)]
        pub key: Option<String>,
        /// What lies between the pixel centres.
        #[serde(default)]
        pub pixel: PixelForm,
        /// Share of the area of a box pixel that carries its phase, amplitude or transmission, above 0 and up to 1: a rectangle
        /// about its centre with the pixel's proportions.
        #[serde(default = "one", deserialize_with = "whole_or_part")]
        #[schemars(extend("minimum" = 1e-12, "maximum" = 1))]
        pub fill: f64,
        /// What the rest of a pixel does.
        #[serde(default)]
        pub rest: Rest,
        /// Width in micrometres of the ramp on which the phase flies back where neighbours differ by more than π, about their
        /// common edge; at most the pitch. Phases are taken between 0 and 2π.
        #[serde(default, deserialize_with = "not_negative")]
        #[schemars(extend("minimum" = 0))]
        pub fly_back_um: f64,
        /// Standard deviation in micrometres of the Gaussian with which the phase between 0 and 2π is convolved; at most ten times
        /// the pitch.
        #[serde(default, deserialize_with = "not_negative")]
        #[schemars(extend("minimum" = 0))]
        pub crosstalk_um: f64,
        /// Parts of a pixel along each axis, each with its mean transmission, where there is fly-back or crosstalk; from 2 to 64.
        #[serde(default = "sub_pixels")]
        #[schemars(extend("minimum" = 2, "maximum" = 64))]
        pub sub_pixels: usize,
    }
}

impl PixelLayer {
    /// The part of each pixel that has its value.
    ///
    /// # Errors
    /// A share that is not above 0 and up to 1.
    pub(crate) fn active(&self) -> Result<ActiveArea, FillError> {
        ActiveArea::of_fill(self.fill, self.rest)
    }

    /// What lies between the pixels, where something does.
    pub(crate) fn fringing(&self) -> Option<Fringing> {
        (self.fly_back_um > 0.0 || self.crosstalk_um > 0.0).then_some(Fringing {
            fly_back: self.fly_back_um * 1e-3,
            crosstalk: self.crosstalk_um * 1e-3,
            sub_pixels: self.sub_pixels,
        })
    }
}

/// A side of an element on an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// That from which light comes.
    Before,
    /// That to which it goes.
    Behind,
}

impl Side {
    /// What is on this side, of what is before and behind.
    pub(crate) fn of<T>(self, [before, behind]: [T; 2]) -> T {
        match self {
            Self::Before => before,
            Self::Behind => behind,
        }
    }
}

table! {
    /// A relief of one material in the medium about the element, or from one of the two media at an interface into the other.
    pub struct HeightLayer with [axes] {
        /// Distance of neighbouring pixel centres in micrometres: one number, or [x, y].
        #[serde(deserialize_with = "pitch")]
        #[schemars(schema_with = "one_or_pair_schema")]
        pub pitch_um: [f64; 2],
        /// Number of pixels [nx, ny]. Needed only for heights that are still to be designed; checked against the
        /// array otherwise.
        #[serde(default, deserialize_with = "count")]
        pub size: Option<[usize; 2]>,
        /// Real 2-D array of heights in micrometres, indexed [y, x], in a NumPy file or a map (.dat, .tif, .fits, .h5).
        pub height_um: PathBuf,
        /// The material of the relief: a catalogue name or { index = … }. On an interface it is one of the two media, and the
        /// relief reaches into the other.
        pub glass: Material,
        /// On an interface, the medium in which a relief of a third material stands.
        #[serde(default)]
        pub stands_in: Option<Side>,
        /// Name of the array in a .npz file; without it `height_um`, or else its only array.
        #[serde(default)]
        pub key: Option<String>,
        /// What lies between the pixel centres.
        #[serde(default)]
        pub pixel: PixelForm,
    }
}

table! {
    /// One order of a blazed grating: optical direction cosines grow by order · wavelength / period.
    pub struct GratingLayer with [axes] {
        /// Period in micrometres.
        #[serde(deserialize_with = "width")]
        #[schemars(extend("minimum" = 1e-6, "maximum" = 1e9))]
        pub period_um: f64,
        /// Direction towards which the first order turns, in degrees from x towards y.
        #[serde(default)]
        pub direction_deg: f64,
        /// Diffraction order.
        #[serde(default = "first")]
        pub order: i32,
    }
}

table! {
    /// An ideal diffractive lens.
    pub struct FocusLayer with [axes] {
        /// Focal length in millimetres in the medium behind the element, at the design wavelength; negative diverges.
        #[serde(deserialize_with = "not_zero")]
        pub focal_length_mm: f64,
        /// Design wavelength in micrometres; the scene's first wavelength without it.
        #[serde(default, deserialize_with = "wavelength")]
        #[schemars(extend("minimum" = 0.01, "maximum" = 100))]
        pub wavelength_um: Option<f64>,
    }
}

table! {
    /// A conical phase.
    pub struct AxiconLayer with [axes] {
        /// Angle in degrees by which collimated light is turned towards the axis; negative turns away.
        #[serde(deserialize_with = "acute")]
        #[schemars(extend("exclusiveMinimum" = -90, "exclusiveMaximum" = 90))]
        pub angle_deg: f64,
    }
}

table! {
    /// A spiral phase, charge times the angle about the axis.
    pub struct VortexLayer with [axes] {
        /// Topological charge: turns of 2π in one round.
        pub charge: i32,
    }
}

table! {
    /// Phase Σ aᵢ (r/ρ)^{2i} with i from 1.
    pub struct RadialLayer with [axes] {
        /// Radius ρ in millimetres at which every power is one.
        #[serde(deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub norm_radius_mm: f64,
        /// Coefficients in radians of (r/ρ)², (r/ρ)⁴, …
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub coefficients: Vec<f64>,
    }
}

table! {
    /// A phase of the radius by samples: the cubic spline through them, level at the centre.
    pub struct RadialTableLayer with [axes] {
        /// Radii of the samples in millimetres, from 0 and growing, to the edge of the aperture or beyond; at least 4.
        #[schemars(length(min = 4))]
        pub radius_mm: Vec<f64>,
        /// The phase in radians at each radius.
        #[schemars(length(min = 4))]
        pub phase_rad: Vec<f64>,
    }
}

table! {
    /// A smooth phase by samples on a centred grid: the bicubic spline through them, which is not wrapped.
    pub struct PhaseGridLayer with [axes] {
        /// Distance of neighbouring samples in micrometres: one number, or [x, y].
        #[serde(deserialize_with = "pitch")]
        #[schemars(schema_with = "one_or_pair_schema")]
        pub pitch_um: [f64; 2],
        /// Number of samples [nx, ny]; checked against the array.
        #[serde(default, deserialize_with = "count")]
        pub size: Option<[usize; 2]>,
        /// Real 2-D array of the phase in radians without jumps of 2π, indexed [y, x] with rows growing with y, at least 4 × 4,
        /// in a NumPy file or a map (.dat, .tif, .fits, .h5). The outer samples lie at the edge of the aperture or beyond.
        pub phase: PathBuf,
        /// Name of the array in a .npz file; without it `phase`, or else its only array.
        #[serde(default)]
        pub key: Option<String>,
    }
}

table! {
    /// Phase Σ aⱼ Zⱼ(x/ρ, y/ρ) in Noll's order and normalisation.
    pub struct ZernikeLayer with [axes] {
        /// Radius ρ in millimetres of the unit circle.
        #[serde(deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub norm_radius_mm: f64,
        /// Coefficients in radians of Noll's Z₁ (piston), Z₂ (tilt in x), Z₃ (tilt in y), Z₄ (defocus), …
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub coefficients: Vec<f64>,
    }
}

table! {
    /// Phase Σ a (x/ρ)ⁱ (y/ρ)ʲ.
    pub struct PolynomialLayer with [axes] {
        /// Length ρ in millimetres at which every power is one.
        #[serde(deserialize_with = "positive")]
        #[schemars(extend("minimum" = 1e-12))]
        pub norm_radius_mm: f64,
        /// The terms.
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub terms: Vec<PhaseTerm>,
    }
}

/// One product of powers of x and y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhaseTerm {
    /// Power of x/ρ, up to 40.
    #[serde(default)]
    pub x: u32,
    /// Power of y/ρ, up to 40.
    #[serde(default)]
    pub y: u32,
    /// Coefficient in radians.
    pub coefficient: f64,
}

table! {
    /// A hologram of two points: phase k (path of the object's wave − path of the reference's), zero at its centre.
    pub struct TwoPointLayer with [axes] {
        /// The wave that leaves the element.
        pub object: RecordedWave,
        /// The wave that lights the element; without it collimated light along the axis.
        #[serde(default)]
        pub reference: RecordedWave,
        /// Wavelength of the construction in micrometres; the scene's first wavelength without it.
        #[serde(default, deserialize_with = "wavelength")]
        #[schemars(extend("minimum" = 0.01, "maximum" = 100))]
        pub wavelength_um: Option<f64>,
        /// Diffraction order.
        #[serde(default = "first")]
        pub order: i32,
    }
}

/// A wave of a hologram: collimated light, or that of a point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordedWave {
    /// The point [x, y, z] in millimetres on the element's own axes, z not zero. Light comes from a point on the side it
    /// comes from, and runs to a point on the side to which it goes.
    #[serde(default)]
    pub point_mm: Option<[f64; 3]>,
    /// Direction [ax, ay] of collimated light in degrees: its direction cosines along x and y are sin ax and sin ay.
    #[serde(default, deserialize_with = "acute")]
    pub angle_deg: [f64; 2],
}

/// A smooth phase folded into a profile whose height makes one wave at the design wavelength: Σ cₘ exp(imφ) over orders m,
/// with the cₘ of the profile at each wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KinoformLayer {
    /// Analytic layers, whose phases add to that of the first order.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub layer: Vec<Layer>,
    /// The diffraction orders that are computed.
    #[serde(default = "first_orders", deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub orders: Vec<i32>,
    /// Equal steps of a period, from 2; a ramp without it.
    #[serde(default)]
    pub levels: Option<u32>,
    /// Design wavelength in micrometres; the scene's first wavelength without it.
    #[serde(default, deserialize_with = "wavelength")]
    #[schemars(extend("minimum" = 0.01, "maximum" = 100))]
    pub wavelength_um: Option<f64>,
    /// The material of the profile: a catalogue name or a table of its own numbers. On an interface it is one of the two media.
    /// Without it the material has no dispersion.
    #[serde(default)]
    pub glass: Option<Material>,
    /// On an interface, the medium in which a profile of a third material stands.
    #[serde(default)]
    pub stands_in: Option<Side>,
}

/// A sum of complex transmissions, each the product of the layers of one term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SumLayer {
    /// The terms, each a list of layers.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub terms: Vec<Vec<Layer>>,
    /// Factor on the field of each term: a number, or [re, im] of a complex one; 1 for all without it.
    #[serde(default)]
    pub weights: Option<Vec<ComplexNumber>>,
}

fn one() -> f64 {
    1.0
}

fn sub_pixels() -> usize {
    4
}

fn first_orders() -> Vec<i32> {
    vec![0, 1, 2]
}

fn first() -> i32 {
    1
}
