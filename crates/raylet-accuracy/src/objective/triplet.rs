//! A Cooke triplet f = 50 mm, with whatever stands at its stop.

use raylet::optics::aperture::Aperture;
use raylet::optics::assembly::part_check::BuildError;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::doe::Doe;
use raylet::optics::shape::Shape;
use raylet::optics::system::System;

use crate::objective::ray_integral::chief_landing;

/// Wavelength in mm.
pub const WAVELENGTH: f64 = 0.55e-3;

/// Distance of the best focus from the last surface, in mm.
pub const FOCUS: f64 = 41.87;

/// Radius of the aperture before the first surface, and of all surfaces, in mm.
const SEMI_APERTURE: f64 = 16.0;

/// Distance of that aperture from the first surface, in mm.
const BEFORE: f64 = 1.0;

/// A triplet and the light that it sees.
#[derive(Clone, Debug)]
pub struct Triplet {
    /// What stands at the stop.
    pub element: Doe,
    /// Angle of the light to the axis, in degrees, towards +x.
    pub angle_deg: f64,
    /// Sensor pixels along each side.
    pub pixels: usize,
    /// Their pitch in mm.
    pub pitch: f64,
    /// All lengths of the lens over those of f = 50 mm; the element and the sensor have their own.
    pub scale: f64,
}

impl Triplet {
    /// With a bare stop of this radius in mm, 32² pixels of 1 µm about the chief ray.
    pub fn bare(radius: f64, angle_deg: f64) -> Self {
        Self {
            element: Doe {
                layers: Vec::new(),
                aperture: Aperture::disc(radius),
                reflect: false,
            },
            angle_deg,
            pixels: 32,
            pitch: 1e-3,
            scale: 1.0,
        }
    }

    /// The system, its sensor centred on the ray through the middle of the stop.
    ///
    /// # Errors
    /// When a number is out of its range.
    pub fn system(&self) -> Result<System, BuildError> {
        let centred = self.with_sensor_at(0.0)?;
        let chief = chief_landing(&centred, [0.0; 2]).map_or(0.0, |[x, _]| x);
        self.with_sensor_at(chief)
    }

    fn with_sensor_at(&self, x: f64) -> Result<System, BuildError> {
        let first = [
            (22.01359, 3.25896, "N-SK16"),
            (-435.76044, 6.00755, "air"),
            (-22.21328, 0.99997, "N-F2"),
            (20.29192, 4.75041, "air"),
        ];
        let last = [(79.68360, 2.95208, "N-SK16"), (-18.39533, FOCUS, "air")];
        let scale = self.scale;
        let surfaces = |builder: SystemBuilder, list: &[(f64, f64, &str)]| {
            list.iter().fold(builder, |builder, (radius, gap, glass)| {
                let surface = builder.surface(radius * scale, *glass, SEMI_APERTURE * scale);
                surface.gap(gap * scale)
            })
        };
        let builder = SystemBuilder::new(WAVELENGTH)
            .collimated([self.angle_deg.to_radians(), 0.0])
            .stop(Aperture::disc(SEMI_APERTURE * scale))
            .gap(BEFORE * scale);
        let builder = surfaces(builder, &first)
            .element("stop", Shape::Plane, self.element.clone())
            .gap(0.5 * scale);
        surfaces(builder, &last)
            .offset([x, 0.0], [0.0; 3])
            .sensor([self.pixels; 2], [self.pitch; 2])
            .build()
    }
}
