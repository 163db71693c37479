//! Keys that several tables of a scene file share, written once.
//!
//! serde's own way to share fields, `flatten`, cannot refuse unknown keys and loses their addresses.

/// Declares a table of a scene file: the keys of some groups, then its own.
///
/// Groups are `place` (name, tilt, shift), `way` (the distance to what follows), `curve` (the shape of a
/// surface), `rim` (its clear aperture), `axes` (where the own axes of a layer stand) and `before` (where the plane of a
/// source stands).
macro_rules! table {
    (
        $(#[$meta:meta])*
        pub struct $name:ident with [$($group:ident),*] { $($own:tt)* }
    ) => {
        table!(@fields [$($group)*] $name [$(#[$meta])*] [$($own)*] []);
        $(table!(@methods $group $name);)*
    };
    (@fields [place $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Name in reports; unique in the scene.
            #[serde(default)]
            pub name: Option<String>,
            /// Tilt of this element alone in degrees: about its x, then its new y, then its new z axis.
            #[serde(default)]
            pub tilt_deg: [f64; 3],
            /// Shift of this element alone along x and y in millimetres, before its tilt.
            #[serde(default)]
            pub decenter_mm: [f64; 2],
        ]);
    };
    (@fields [way $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Distance along the axis from its (last) vertex to the next element's vertex in
            /// millimetres; zero or less after an odd number of mirrors.
            #[serde(default)]
            pub thickness_mm: Option<f64>,
        ]);
    };
    (@fields [curve $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Radius of curvature at the vertex in millimetres: positive when the centre lies at larger
            /// z; a plane when absent or inf.
            #[serde(default, deserialize_with = "crate::file::decode::number::radius")]
            pub radius_mm: Option<f64>,
            /// Conic constant: 0 sphere, −1 paraboloid, below −1 hyperboloid.
            #[serde(default)]
            pub conic: f64,
            /// Coefficients of r⁴, r⁶, r⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
            #[serde(default)]
            pub aspheric: Vec<f64>,
            /// A shape that is no conic with even powers of r: it replaces them, or is added to them.
            #[serde(default)]
            pub shape: Option<crate::file::scene::surface_shape::Shape>,
        ]);
    };
    (@fields [rim $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Radius of the clear aperture in millimetres.
            #[serde(default, deserialize_with = "crate::file::decode::number::positive")]
            #[schemars(extend("minimum" = 1e-12))]
            pub semi_aperture_mm: Option<f64>,
            /// The clear aperture where it is no centred disc, instead of `semi_aperture_mm`.
            #[serde(default)]
            pub aperture: Option<crate::file::scene::aperture::Aperture>,
        ]);
    };
    (@fields [axes $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Where the centre of the layer stands on the element, in millimetres.
            #[serde(default)]
            pub centre_mm: [f64; 2],
            /// By how much the layer is turned about its centre, in degrees from x towards y.
            #[serde(default)]
            pub rotation_deg: f64,
        ]);
    };
    (@fields [before $($more:ident)*] $name:ident $meta:tt $own:tt [$($fields:tt)*]) => {
        table!(@fields [$($more)*] $name $meta $own [
            $($fields)*
            /// Distance in millimetres from its plane to the first element's vertex, above zero.
            #[serde(deserialize_with = "crate::file::decode::number::positive")]
            #[schemars(extend("minimum" = 1e-12))]
            pub distance_mm: f64,
            /// Shift of its plane along x and y in millimetres, before its tilt.
            #[serde(default)]
            pub decenter_mm: [f64; 2],
            /// Tilt of its plane in degrees: about its x, then its new y, then its new z axis.
            #[serde(default)]
            pub tilt_deg: [f64; 3],
        ]);
    };
    (@fields [] $name:ident [$($meta:tt)*] [$($own:tt)*] [$($fields:tt)*]) => {
        $($meta)*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($fields)*
            $($own)*
        }
    };
    (@methods axes $name:ident) => {
        impl $name {
            /// Where its own axes stand.
            pub(crate) fn placement(&self) -> crate::optics::phase::placement::Placement {
                crate::optics::phase::placement::Placement {
                    centre: self.centre_mm,
                    rotation: self.rotation_deg.to_radians(),
                }
            }
        }
    };
    (@methods before $name:ident) => {
        impl $name {
            /// Where its plane stands.
            pub(crate) fn plane(&self) -> crate::file::scene::source_plane::SourcePlane {
                crate::file::scene::source_plane::SourcePlane {
                    distance_mm: self.distance_mm,
                    decenter_mm: self.decenter_mm,
                    tilt_deg: self.tilt_deg,
                }
            }
        }
    };
    (@methods place $name:ident) => {};
    (@methods way $name:ident) => {};
    (@methods curve $name:ident) => {
        impl $name {
            /// The keys that describe its shape.
            pub fn surface_shape(&self) -> crate::file::scene::surface_shape::SurfaceShape<'_> {
                crate::file::scene::surface_shape::SurfaceShape {
                    radius_mm: self.radius_mm,
                    conic: self.conic,
                    aspheric: &self.aspheric,
                    shape: self.shape.as_ref(),
                }
            }
        }
    };
    (@methods rim $name:ident) => {
        impl $name {
            /// The keys that describe its clear aperture.
            pub fn rim(&self) -> crate::file::scene::aperture::Rim<'_> {
                crate::file::scene::aperture::Rim {
                    semi_aperture_mm: self.semi_aperture_mm,
                    aperture: self.aperture.as_ref(),
                }
            }
        }
    };
}
pub(crate) use table;
