//! Systems in code: parts by their usual numbers, with one clear error.

use std::f64::consts::FRAC_PI_2;

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::assembly::axis_layout::AxisLayout;
use crate::optics::assembly::glass::Glass;
use crate::optics::assembly::part_check::{BuildError, Mismatch, check_above_zero};
use crate::optics::assembly::part_laying::{BuilderCall, Laying, address, glass_index};
use crate::optics::beams::fibre_mode::FibreMode;
use crate::optics::beams::gaussian_beam::GaussianBeam;
use crate::optics::beams::sampled_field::sampled_field;
use crate::optics::beams::taper::Taper;
use crate::optics::doe::{Doe, Layer};
use crate::optics::phase::placement::Placement;
use crate::optics::pixels::active_area::ActiveArea;
use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
use crate::optics::refraction::Coating;
use crate::optics::screen::Sensor;
use crate::optics::shape::Shape;
use crate::optics::source::{Source, direction_at};
use crate::optics::system::System;

/// Where the light comes from, before the first screen is known.
#[derive(Clone, Debug)]
enum Light {
    /// Collimated, at these angles to the yz and xz planes, in rad.
    Collimated([f64; 2]),
    /// From a point, in mm.
    Point([f64; 3]),
    /// Collimated, with a taper: its angles in rad, its widths in mm and its order.
    TaperedBeam([f64; 2], [f64; 2], u32),
    /// From a point in mm, with a taper about +z: its half angles in rad and its order.
    TaperedPoint([f64; 3], [f64; 2], u32),
    /// Samples of a field at these distances in mm, so far before the first part in mm.
    Samples(Array2<Complex64>, [f64; 2], f64),
    /// A mode of a fibre that ends so far before the first part in mm.
    Fibre(FibreMode, f64),
    /// A Gaussian beam: its waist in mm, the radii there in mm, and its angles in rad.
    Gaussian([f64; 3], [f64; 2], [f64; 2]),
}

/// Lays parts along an axis and makes the [`System`] of them.
///
/// The axis starts at the global origin towards +z. Lengths are in mm, angles in rad. Each call adds one part where the
/// axis has come to; [`SystemBuilder::gap`] goes on to the vertex of the next. What is wrong is reported by
/// [`SystemBuilder::build`], the first part first.
///
/// ```
/// use raylet::optics::aperture::Aperture;
/// use raylet::optics::assembly::system_builder::SystemBuilder;
///
/// // A plano-convex lens behind a stop of 2 mm radius, and a sensor in its focus.
/// let system = SystemBuilder::new(0.55e-3)
///     .stop(Aperture::disc(2.0))
///     .gap(1.0)
///     .surface(25.8, "N-BK7", 12.7)
///     .gap(5.3)
///     .surface(f64::INFINITY, "air", 12.7)
///     .gap(46.2)
///     .sensor([64, 64], [2e-3, 2e-3])
///     .build()?;
/// assert_eq!((system.screens.len(), system.trains[0].len()), (2, 2));
///
/// let refused = SystemBuilder::new(0.55e-3).surface(25.8, "NBK77", 12.7).build();
/// assert!(refused.is_err_and(|error| error.to_string().starts_with("surface 1: found no glass is named 'NBK77'")));
/// # Ok::<(), raylet::optics::assembly::part_check::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SystemBuilder {
    wavelength: f64,
    light: Light,
    beam_radius: Option<f64>,
    ambient: Glass,
    coating: Coating,
    parts: Vec<BuilderCall>,
}

impl SystemBuilder {
    /// A system without parts, in air, with collimated light along the axis; `wavelength` is that of the vacuum in mm.
    pub fn new(wavelength: f64) -> Self {
        Self {
            wavelength,
            light: Light::Collimated([0.0; 2]),
            beam_radius: None,
            ambient: Glass::from("air"),
            coating: Coating::default(),
            parts: Vec::new(),
        }
    }

    /// Collimated light that comes at these angles in rad: its direction cosines along x and y are their sines.
    pub fn collimated(mut self, angle: [f64; 2]) -> Self {
        self.light = Light::Collimated(angle);
        self
    }

    /// Light from a point, given in global coordinates in mm.
    pub fn point_source(mut self, position: [f64; 3]) -> Self {
        self.light = Light::Point(position);
        self
    }

    /// Collimated light as of a laser, at these angles in rad: its amplitude is exp(−ρ^{2m}) about the first part's vertex,
    /// with the radii along x and y (1/e² of the intensity) in mm, and its order m.
    pub fn tapered_beam(mut self, angle: [f64; 2], radii: [f64; 2], order: u32) -> Self {
        self.light = Light::TaperedBeam(angle, radii, order);
        self
    }

    /// Light from a point in mm, as of a laser diode: its amplitude is exp(−ρ^{2m}) over direction cosines, with the half
    /// angles along x and y (1/e² of the intensity) in rad, and its order m.
    pub fn tapered_point(mut self, position: [f64; 3], half_angles: [f64; 2], order: u32) -> Self {
        self.light = Light::TaperedPoint(position, half_angles, order);
        self
    }

    /// A field of a limited band by samples [y, x] and their distances along x and y in mm, on a plane across the axis
    /// `distance` mm before the first part. It is zero beyond them.
    pub fn field_source(
        mut self,
        samples: Array2<Complex64>,
        pitch: [f64; 2],
        distance: f64,
    ) -> Self {
        self.light = Light::Samples(samples, pitch, distance);
        self
    }

    /// A mode of a fibre that ends `distance` mm before the first part.
    pub fn fibre_source(mut self, mode: FibreMode, distance: f64) -> Self {
        self.light = Light::Fibre(mode, distance);
        self
    }

    /// A Gaussian beam by the centre of its waist in global coordinates in mm, the radii there along x and y (1/e² of the
    /// intensity) in mm, and the angles at which it comes in rad.
    pub fn gaussian_beam(mut self, waist: [f64; 3], radii: [f64; 2], angle: [f64; 2]) -> Self {
        self.light = Light::Gaussian(waist, radii, angle);
        self
    }

    /// Radius of the beam in mm, where the first part is a surface or mirror: without it the aperture of that part
    /// limits the light.
    pub fn beam_radius(mut self, radius: f64) -> Self {
        self.beam_radius = Some(radius);
        self
    }

    /// The medium before the first part, and around all of them; air by default.
    pub fn ambient(mut self, medium: impl Into<Glass>) -> Self {
        self.ambient = medium.into();
        self
    }

    /// Coating of all refracting surfaces, which sets how much they transmit; [`Coating::Ideal`] by default.
    pub fn coating(mut self, coating: Coating) -> Self {
        self.coating = coating;
        self
    }

    /// The distance from the vertex of the last part to that of the next, in mm; negative where light runs towards −z.
    pub fn gap(self, distance: f64) -> Self {
        self.with(BuilderCall::Gap(distance))
    }

    /// Moves the next part, and nothing behind it, aside by `decentre` mm and turns it by `tilt` rad, right-handed,
    /// about its x axis, its new y axis and its new z axis.
    pub fn offset(self, decentre: [f64; 2], tilt: [f64; 3]) -> Self {
        self.with(BuilderCall::Offset(decentre, tilt))
    }

    /// Moves the axis, with all parts that follow, aside by `decentre` mm and turns it by `tilt` rad, as in
    /// [`SystemBuilder::offset`].
    pub fn turn(self, decentre: [f64; 2], tilt: [f64; 3]) -> Self {
        self.with(BuilderCall::Turn(decentre, tilt))
    }

    /// A spherical surface by its radius in mm, positive where the centre lies at larger z, infinite for a plane; the
    /// medium behind it; and half its clear diameter in mm.
    pub fn surface(self, radius: f64, behind: impl Into<Glass>, semi_aperture: f64) -> Self {
        let aperture = Aperture::disc(semi_aperture);
        self.shaped_surface(Shape::sphere(radius), behind, aperture)
    }

    /// A refracting surface of any shape.
    pub fn shaped_surface(
        self,
        shape: Shape,
        behind: impl Into<Glass>,
        aperture: Aperture,
    ) -> Self {
        self.with(BuilderCall::Surface(shape, aperture, behind.into()))
    }

    /// A spherical mirror by its radius and half its clear diameter in mm. Light runs back behind it.
    pub fn mirror(self, radius: f64, semi_aperture: f64) -> Self {
        self.shaped_mirror(Shape::sphere(radius), Aperture::disc(semi_aperture))
    }

    /// A mirror of any shape.
    pub fn shaped_mirror(self, shape: Shape, aperture: Aperture) -> Self {
        self.with(BuilderCall::Mirror(shape, aperture))
    }

    /// An aperture.
    pub fn stop(self, aperture: Aperture) -> Self {
        self.with(BuilderCall::Stop(aperture))
    }

    /// A plane element of phase pixels: their phases in rad, [y, x], and the distances of their centres along x and y
    /// in mm. Each phase holds over its whole pixel.
    pub fn phase_pixels(self, name: &str, phases: &Array2<f64>, pitch: [f64; 2]) -> Self {
        self.pixels(name, phases.mapv(Complex64::cis), pitch)
    }

    /// A plane element of pixels with complex transmissions, [y, x], and the distances of their centres along x and y
    /// in mm.
    pub fn pixels(self, name: &str, values: Array2<Complex64>, pitch: [f64; 2]) -> Self {
        let pixels = Pixels {
            pitch,
            values,
            form: PixelForm::Box,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        };
        let doe = Doe {
            layers: vec![Layer::Pixels(pixels)],
            aperture: Aperture::OPEN,
            reflect: false,
        };
        self.element(name, Shape::Plane, doe)
    }

    /// A diffractive element of any layers on a surface of any shape.
    pub fn element(self, name: &str, shape: Shape, doe: Doe) -> Self {
        self.with(BuilderCall::Element(name.to_owned(), shape, doe, None))
    }

    /// A diffractive element on an interface: the medium `behind` begins at its surface, which also refracts.
    pub fn element_into(
        self,
        name: &str,
        shape: Shape,
        doe: Doe,
        behind: impl Into<Glass>,
    ) -> Self {
        let behind = Some(behind.into());
        self.with(BuilderCall::Element(name.to_owned(), shape, doe, behind))
    }

    /// The sensor, the last part: its pixels [nx, ny], and the distances of their centres along x and y in mm.
    pub fn sensor(self, pixels: [usize; 2], pitch: [f64; 2]) -> Self {
        self.with(BuilderCall::Sensor(Sensor { pixels, pitch }))
    }

    /// The system of all parts.
    ///
    /// # Errors
    /// The first part that is wrong: an unknown glass, one that is not known at the wavelength, a number out of its
    /// range, a surface that does not exist all over its aperture, or a sensor that is missing or not the last part.
    pub fn build(self) -> Result<System, BuildError> {
        let light = |wrong| error("light", wrong);
        check_above_zero("a wavelength", self.wavelength).map_err(light)?;
        if let Some(radius) = self.beam_radius {
            check_above_zero("a beam radius", radius).map_err(light)?;
        }
        let ambient = glass_index(&self.ambient, self.wavelength);
        let ambient = ambient.map_err(|wrong| error("ambient", wrong))?;
        let mut laying = Laying::new(self.wavelength, self.coating, self.beam_radius, ambient);
        if let Some((element, distance)) = self.source_element().map_err(light)? {
            laying.lay_source(element, distance);
        }
        for (number, part) in self.parts.iter().enumerate() {
            let laid = laying.lay(part);
            laid.map_err(|wrong| error(&address(&self.parts, number), wrong))?;
        }
        let axis = laying.end().map_err(|wrong| error("end", wrong))?;
        let source = self.source(&axis, ambient).map_err(light)?;
        Ok(axis.into_system(self.wavelength, source))
    }

    fn with(mut self, part: BuilderCall) -> Self {
        self.parts.push(part);
        self
    }

    /// What makes the light of a plane wave where it is given on a plane, and how far before the first part.
    fn source_element(&self) -> Result<Option<(Doe, f64)>, Mismatch> {
        let (element, distance) = match &self.light {
            Light::Samples(samples, pitch, distance) => {
                for pitch in pitch {
                    check_above_zero("a distance of samples", *pitch)?;
                }
                (sampled_field(samples, *pitch), *distance)
            }
            Light::Fibre(mode, distance) => {
                let (samples, pitch) = mode.samples().ok_or_else(|| {
                    let found = "a mode that reaches far beyond the core";
                    Mismatch::new(found, "a mode farther from where it is cut off")
                })?;
                (sampled_field(&samples, [pitch; 2]), *distance)
            }
            _ => return Ok(None),
        };
        check_above_zero("a distance of the source", distance)?;
        Ok(Some((element, distance)))
    }

    /// The source, in an ambient medium of this index.
    fn source(&self, axis: &AxisLayout, ambient: f64) -> Result<Source, Mismatch> {
        let origin = axis.start().origin;
        let towards = |angle: [f64; 2]| {
            direction_at(angle).ok_or_else(|| {
                let found = format!("angles of {angle:?} rad");
                Mismatch::new(found, "angles whose sines' squares add up to less than one")
            })
        };
        Ok(match self.light {
            Light::Samples(..) | Light::Fibre(..) => Source::Plane {
                direction: Vec3::new(0.0, 0.0, 1.0),
                origin,
            },
            Light::Point([x, y, z]) => Source::point([x, y, z], origin),
            Light::Collimated(angle) => Source::Plane {
                direction: towards(angle)?,
                origin,
            },
            Light::TaperedBeam(angle, radii, order) => {
                let direction = towards(angle)?;
                Source::TaperedPlane {
                    direction,
                    origin,
                    centre: origin,
                    taper: taper(direction, radii, order)?,
                }
            }
            Light::TaperedPoint([x, y, z], half_angles, order) => {
                if half_angles.into_iter().any(|angle| angle >= FRAC_PI_2) {
                    let found = format!("half angles of {half_angles:?} rad");
                    return Err(Mismatch::new(found, "half angles below a right angle"));
                }
                Source::TaperedPoint {
                    position: Vec3::new(x, y, z),
                    reference: origin,
                    taper: taper(Vec3::new(0.0, 0.0, 1.0), half_angles.map(f64::sin), order)?,
                }
            }
            Light::Gaussian([x, y, z], radii, angle) => {
                for radius in radii {
                    check_above_zero("a radius of the waist", radius)?;
                }
                let k = std::f64::consts::TAU * ambient / self.wavelength;
                let (waist, direction) = (Vec3::new(x, y, z), towards(angle)?);
                Source::Gaussian(GaussianBeam::new(waist, direction, radii, 0.0, k))
            }
        })
    }
}

/// A taper about a direction.
fn taper(direction: Vec3, widths: [f64; 2], order: u32) -> Result<Taper, Mismatch> {
    for width in widths {
        check_above_zero("a width of the taper", width)?;
    }
    if order == 0 {
        return Err(Mismatch::new("a taper of order 0", "an order from 1"));
    }
    Ok(Taper::about(direction, widths, order, 0.0))
}

fn error(part: &str, wrong: Mismatch) -> BuildError {
    BuildError {
        part: part.to_owned(),
        found: wrong.found,
        expected: wrong.expected.to_owned(),
    }
}
