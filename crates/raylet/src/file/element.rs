//! Elements of a scene: what stands along the axis, as a scene file describes it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::tagged;
use crate::file::layer::Layer;
use crate::file::material::Material;
use crate::file::number::{not_empty, not_negative, one_or_pair_schema, pitch, positive, radius};
use crate::optics::shape::{Conic, Shape};

tagged! {
    /// One element along the axis. Light runs towards +z first; `thickness_mm` leads from an element's
    /// last vertex to the next element's vertex and is negative while light runs towards −z, after an
    /// odd number of mirrors.
    pub enum Element {
        /// A plane diffractive element, by transmission or reflection.
        Doe(DoeElement) = "doe",
        /// A group of refracting surfaces that moves as one.
        Lens(LensElement) = "lens",
        /// A single refracting surface.
        Surface(SurfaceElement) = "surface",
        /// A mirror.
        Mirror(MirrorElement) = "mirror",
        /// An opening in an opaque screen.
        Stop(StopElement) = "stop",
        /// A turn and shift of the axis for all that follows.
        CoordinateBreak(CoordinateBreak) = "coordinate_break",
        /// The plane where the field is wanted; the last element.
        Sensor(SensorElement) = "sensor",
    }
}

/// A plane diffractive element.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DoeElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the axis to the next element's vertex in millimetres.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Tilt of this element alone in degrees: about its x, then its new y, then its new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of this element alone along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
    /// The open part; nothing passes outside.
    pub aperture: Aperture,
    /// Whether light goes on by reflection.
    #[serde(default)]
    pub reflect: bool,
    /// Factors of the complex transmission; phases add.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub layer: Vec<Layer>,
}

/// A group of refracting surfaces that moves as one, such as a lens from a catalogue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LensElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the axis from the last surface's vertex to the next element in millimetres.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Tilt of the group in degrees about its first vertex: about x, then the new y, then the new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of the group along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
    /// Its surfaces in the order light meets them.
    #[serde(deserialize_with = "not_empty")]
    #[schemars(extend("minItems" = 1))]
    pub surface: Vec<LensSurface>,
}

/// One surface of a lens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LensSurface {
    /// Radius of curvature at the vertex in millimetres: positive when the centre lies at larger z;
    /// a plane when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_mm: Option<f64>,
    /// Conic constant: 0 sphere, −1 paraboloid, below −1 hyperboloid.
    #[serde(default)]
    pub conic: f64,
    /// Coefficients of r⁴, r⁶, r⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
    #[serde(default)]
    pub aspheric: Vec<f64>,
    /// Radius of the clear aperture in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub semi_aperture_mm: f64,
    /// Distance to the next surface of the group in millimetres; absent on the last.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Medium after this surface; absent on the last, where it is the ambient medium again.
    #[serde(default)]
    pub glass: Option<Material>,
    /// How the surface transmits; the scene's setting when absent.
    #[serde(default)]
    pub coating: Option<Coating>,
}

/// A single refracting surface between two media.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the axis to the next element's vertex in millimetres.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Tilt of this surface alone in degrees: about its x, then its new y, then its new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of this surface alone along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
    /// Radius of curvature at the vertex in millimetres: positive when the centre lies at larger z;
    /// a plane when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_mm: Option<f64>,
    /// Conic constant: 0 sphere, −1 paraboloid, below −1 hyperboloid.
    #[serde(default)]
    pub conic: f64,
    /// Coefficients of r⁴, r⁶, r⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
    #[serde(default)]
    pub aspheric: Vec<f64>,
    /// Radius of the clear aperture in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub semi_aperture_mm: f64,
    /// Medium after the surface; the ambient medium when absent.
    #[serde(default)]
    pub glass: Option<Material>,
    /// How the surface transmits; the scene's setting when absent.
    #[serde(default)]
    pub coating: Option<Coating>,
}

/// A mirror. After it light runs the other way, so the thicknesses that follow change sign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MirrorElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the axis to the next element's vertex in millimetres; zero or less after an odd
    /// number of mirrors.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Tilt of this mirror alone in degrees: about its x, then its new y, then its new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of this mirror alone along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
    /// Radius of curvature at the vertex in millimetres: positive when the centre lies at larger z;
    /// a plane when absent or inf.
    #[serde(default, deserialize_with = "radius")]
    pub radius_mm: Option<f64>,
    /// Conic constant: 0 sphere, −1 paraboloid, below −1 hyperboloid.
    #[serde(default)]
    pub conic: f64,
    /// Coefficients of r⁴, r⁶, r⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
    #[serde(default)]
    pub aspheric: Vec<f64>,
    /// Radius of the clear aperture in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub semi_aperture_mm: f64,
}

/// An opening in an opaque plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the axis to the next element's vertex in millimetres.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// Tilt of the stop alone in degrees: about its x, then its new y, then its new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of the stop alone along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
    /// The open part.
    pub aperture: Aperture,
}

/// A new axis for all that follows: shifted first, then turned, then followed by `thickness_mm`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoordinateBreak {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Distance along the new axis to the next element's vertex in millimetres; of either sign.
    #[serde(default)]
    pub thickness_mm: f64,
    /// Turn in degrees: about x, then the new y, then the new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift along x and y in millimetres.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
}

/// The plane where the field is wanted: sample points at the centres of a grid of pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorElement {
    /// Name in reports; unique in the scene.
    #[serde(default)]
    pub name: Option<String>,
    /// Number of pixels [nx, ny].
    #[serde(deserialize_with = "positive")]
    pub pixels: [usize; 2],
    /// Distance of neighbouring pixel centres in micrometres: one number, or [x, y].
    #[serde(deserialize_with = "pitch")]
    #[schemars(schema_with = "one_or_pair_schema")]
    pub pitch_um: [f64; 2],
    /// Tilt of the sensor in degrees: about its x, then its new y, then its new z axis.
    #[serde(default)]
    pub tilt_deg: [f64; 3],
    /// Shift of the sensor along x and y in millimetres, before its tilt.
    #[serde(default)]
    pub decenter_mm: [f64; 2],
}

/// The open part of an element, such as { disc = { radius_mm = 0.63 } }.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Aperture {
    /// Within a circle.
    Disc(Disc),
    /// Within a rectangle along x and y.
    Rectangle(Rectangle),
    /// Between two circles.
    Annulus(Annulus),
}

/// The inside of a circle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The inside of a rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Full width along x in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_mm: f64,
    /// Full height along y in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The ring between two circles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Annulus {
    /// Radius of the obstruction in millimetres.
    #[serde(deserialize_with = "not_negative")]
    #[schemars(extend("minimum" = 0))]
    pub inner_radius_mm: f64,
    /// Radius of the opening in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub outer_radius_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// How much of the field a refracting surface transmits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coating {
    /// An ideal antireflection coating: all the energy at every angle.
    #[default]
    Ideal,
    /// A bare surface in unpolarised light.
    Fresnel,
    /// The field amplitude goes on unchanged.
    Unit,
}

/// What every element has in common.
macro_rules! common {
    ($element:expr, $any:ident => $value:expr) => {
        match $element {
            Element::Doe($any) => $value,
            Element::Lens($any) => $value,
            Element::Surface($any) => $value,
            Element::Mirror($any) => $value,
            Element::Stop($any) => $value,
            Element::CoordinateBreak($any) => $value,
            Element::Sensor($any) => $value,
        }
    };
}

impl Element {
    /// Its name, if it has one.
    pub fn name(&self) -> Option<&str> {
        common!(self, any => any.name.as_deref())
    }

    /// The distance to the next element in mm; nothing for the sensor.
    pub fn thickness_mm(&self) -> Option<f64> {
        match self {
            Element::Doe(any) => any.thickness_mm,
            Element::Lens(any) => any.thickness_mm,
            Element::Surface(any) => any.thickness_mm,
            Element::Mirror(any) => any.thickness_mm,
            Element::Stop(any) => any.thickness_mm,
            Element::CoordinateBreak(any) => Some(any.thickness_mm),
            Element::Sensor(_) => None,
        }
    }

    /// Its own tilt in degrees about x, y and z.
    pub fn tilt_deg(&self) -> [f64; 3] {
        common!(self, any => any.tilt_deg)
    }

    /// Its own shift along x and y in mm.
    pub fn decenter_mm(&self) -> [f64; 2] {
        common!(self, any => any.decenter_mm)
    }

    /// Whether light turns back at it.
    pub fn reflects(&self) -> bool {
        match self {
            Element::Mirror(_) => true,
            Element::Doe(doe) => doe.reflect,
            _ => false,
        }
    }
}

/// The shape that a radius in mm, a conic constant and aspheric coefficients describe.
fn shape(radius_mm: Option<f64>, conic: f64, aspheric: &[f64]) -> Shape {
    let curvature = radius_mm.map_or(0.0, |radius| 1.0 / radius);
    let base = Conic { curvature, conic };
    if aspheric.iter().any(|&coefficient| coefficient != 0.0) {
        Shape::Asphere {
            base,
            coefficients: aspheric.to_vec(),
        }
    } else if curvature == 0.0 {
        Shape::Plane
    } else {
        Shape::Conic(base)
    }
}

impl LensSurface {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        shape(self.radius_mm, self.conic, &self.aspheric)
    }
}

impl SurfaceElement {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        shape(self.radius_mm, self.conic, &self.aspheric)
    }
}

impl MirrorElement {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        shape(self.radius_mm, self.conic, &self.aspheric)
    }
}
