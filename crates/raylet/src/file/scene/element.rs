//! Elements of a scene: what stands along the axis, as a scene file describes it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::number::{count, not_empty, not_zero, one_or_pair_schema, pitch};
use crate::file::decode::shared_keys::table;
use crate::file::decode::tagged::tagged;
use crate::file::scene::aperture::Aperture;
use crate::file::scene::layer::Layer;
use crate::file::scene::material::Material;
use crate::file::scene::surface_shape::SurfaceShape;
use crate::optics::refraction::Coating;

tagged! {
    /// One element along the axis. Light runs towards +z first; `thickness_mm` leads from an element's
    /// last vertex to the next element's vertex and is negative while light runs towards −z, after an
    /// odd number of mirrors.
    pub enum Element {
        /// A diffractive element, by transmission or reflection.
        Doe(DoeElement) = "doe",
        /// A group of refracting surfaces that moves as one.
        Lens(LensElement) = "lens",
        /// A single refracting surface.
        Surface(SurfaceElement) = "surface",
        /// A mirror.
        Mirror(MirrorElement) = "mirror",
        /// An ideal thin lens.
        ParaxialLens(ParaxialLens) = "paraxial_lens",
        /// An aperture in an opaque screen.
        Stop(StopElement) = "stop",
        /// A turn and shift of the axis for all that follows.
        CoordinateBreak(CoordinateBreak) = "coordinate_break",
        /// The plane where the field is computed; the last element.
        Sensor(SensorElement) = "sensor",
    }
}

table! {
    /// A diffractive element on a plane or curved surface.
    pub struct DoeElement with [place, way, curve] {
        /// The open part; nothing passes outside.
        pub aperture: Aperture,
        /// Medium behind the element, where it stands on an interface, such as a surface of a lens: the surface
        /// refracts too. The medium before the element when absent.
        #[serde(default)]
        pub glass: Option<Material>,
        /// How that interface transmits; the scene's setting when absent. Only with `glass`: an element that reflects has none.
        #[serde(default)]
        pub coating: Option<Coating>,
        /// Whether light goes on by reflection.
        #[serde(default)]
        pub reflect: bool,
        /// What the layers are functions of.
        #[serde(default)]
        pub coordinates: Coordinates,
        /// Factors of the complex transmission; phases add.
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub layer: Vec<Layer>,
    }
}

table! {
    /// A group of refracting surfaces that moves as one, such as a lens from a catalogue; it is tilted
    /// about its first vertex.
    pub struct LensElement with [place, way] {
        /// Its surfaces in the order light meets them.
        #[serde(deserialize_with = "not_empty")]
        #[schemars(extend("minItems" = 1))]
        pub surface: Vec<LensSurface>,
    }
}

table! {
    /// One surface of a lens.
    pub struct LensSurface with [curve, rim] {
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
}

table! {
    /// A single refracting surface between two media.
    pub struct SurfaceElement with [place, way, curve, rim] {
        /// Medium after the surface; the ambient medium when absent.
        #[serde(default)]
        pub glass: Option<Material>,
        /// How the surface transmits; the scene's setting when absent.
        #[serde(default)]
        pub coating: Option<Coating>,
    }
}

table! {
    /// A mirror. After it light runs the other way, so the thicknesses that follow change sign.
    pub struct MirrorElement with [place, way, curve, rim] {}
}

table! {
    /// An ideal thin lens: the phase that sends collimated light along its axis to one point without
    /// aberration, at every wavelength of the scene. Other light meets the same phase, so away from the
    /// axis and at other distances it is a perfect lens only as far as its angles are small.
    pub struct ParaxialLens with [place, way] {
        /// Focal length in millimetres in the medium around it; negative diverges.
        #[serde(deserialize_with = "not_zero")]
        pub focal_length_mm: f64,
        /// The open part; nothing passes outside.
        pub aperture: Aperture,
    }
}

table! {
    /// An aperture in an opaque plane.
    pub struct StopElement with [place, way] {
        /// The open part.
        pub aperture: Aperture,
    }
}

table! {
    /// A new axis for all that follows: shifted first, then turned, then followed by `thickness_mm`.
    pub struct CoordinateBreak with [place] {
        /// Distance along the new axis to the next element's vertex in millimetres; of either sign.
        #[serde(default)]
        pub thickness_mm: f64,
    }
}

table! {
    /// The plane where the field is computed: sample points at the centres of a grid of pixels.
    pub struct SensorElement with [place] {
        /// Number of pixels [nx, ny].
        #[serde(deserialize_with = "count")]
        pub pixels: [usize; 2],
        /// Distance of neighbouring pixel centres in micrometres: one number, or [x, y].
        #[serde(deserialize_with = "pitch")]
        #[schemars(schema_with = "one_or_pair_schema")]
        pub pitch_um: [f64; 2],
    }
}

/// What the layers of a diffractive element on a curved surface are functions of. The aperture is always
/// over local x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coordinates {
    /// Local x and y: the element as it looks along its axis.
    #[default]
    Projected,
    /// Lengths along the surface: on a surface of revolution the radius is the length of the meridian from
    /// the vertex and the azimuth stays; on a cylinder the length along the curve from the vertex line takes
    /// the place of its x or y. Other surfaces have none.
    Surface,
}

/// What every element has in common.
macro_rules! common {
    ($element:expr, $any:ident => $value:expr) => {
        match $element {
            Element::Doe($any) => $value,
            Element::Lens($any) => $value,
            Element::Surface($any) => $value,
            Element::Mirror($any) => $value,
            Element::ParaxialLens($any) => $value,
            Element::Stop($any) => $value,
            Element::CoordinateBreak($any) => $value,
            Element::Sensor($any) => $value,
        }
    };
}

/// What is expected where an element is named whose pixels are designed.
pub(crate) const WITH_PIXELS: &str = "the name of a diffractive element with a layer of pixels";

impl Element {
    /// Its name, if it has one.
    pub(crate) fn name(&self) -> Option<&str> {
        common!(self, any => any.name.as_deref())
    }

    /// The distance to the next element in mm; nothing for the sensor.
    pub(crate) fn thickness_mm(&self) -> Option<f64> {
        match self {
            Element::Doe(any) => any.thickness_mm,
            Element::Lens(any) => any.thickness_mm,
            Element::Surface(any) => any.thickness_mm,
            Element::Mirror(any) => any.thickness_mm,
            Element::ParaxialLens(any) => any.thickness_mm,
            Element::Stop(any) => any.thickness_mm,
            Element::CoordinateBreak(any) => Some(any.thickness_mm),
            Element::Sensor(_) => None,
        }
    }

    /// Its own tilt in degrees about x, y and z.
    pub(crate) fn tilt_deg(&self) -> [f64; 3] {
        common!(self, any => any.tilt_deg)
    }

    /// Its own shift along x and y in mm.
    pub(crate) fn decenter_mm(&self) -> [f64; 2] {
        common!(self, any => any.decenter_mm)
    }

    /// Whether light turns back at it.
    pub(crate) fn reflects(&self) -> bool {
        match self {
            Element::Mirror(_) => true,
            Element::Doe(doe) => doe.reflect,
            _ => false,
        }
    }

    /// The keys that describe its curved surfaces, each with its path from the element.
    pub(crate) fn surface_shapes(&self) -> Vec<(String, SurfaceShape<'_>)> {
        let own = |shape| vec![(String::new(), shape)];
        match self {
            Element::Doe(doe) => own(doe.surface_shape()),
            Element::Surface(surface) => own(surface.surface_shape()),
            Element::Mirror(mirror) => own(mirror.surface_shape()),
            Element::Lens(lens) => {
                let surfaces = lens.surface.iter().enumerate();
                surfaces
                    .map(|(i, surface)| (format!(".surface[{i}]"), surface.surface_shape()))
                    .collect()
            }
            _ => Vec::new(),
        }
    }
}
