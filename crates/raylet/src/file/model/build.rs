//! From a scene to the optical system it describes, one wavelength at a time.

use crate::engine::plan::settings::{Paper, Settings};
use crate::file::decode::fault::Fault;
use crate::file::model::element_layers::ElementLayers;
use crate::file::model::light::{LitAxis, source_element};
use crate::file::model::scene_arrays::Arrays;
use crate::file::model::scene_media::{index, medium};
use crate::file::scene::element::{DoeElement, Element, LensElement, ParaxialLens, SensorElement};
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::settings as keys;
use crate::file::scene::surface_shape::SurfaceShape;
use crate::math::vec3::Vec3;
use crate::optics::assembly::axis_layout::{AxisLayout, PlacedShape};
use crate::optics::doe::{Doe, Layer};
use crate::optics::frame::Frame;
use crate::optics::media::medium::Medium;
use crate::optics::phase::profile::Profile;
use crate::optics::refraction::Coating;
use crate::optics::screen::{MediumBehind, ScreenKind, Sensor};
use crate::optics::shape::Shape;
use crate::optics::system::System;

/// What the plane is called on which the light is given.
pub(crate) const SOURCE: &str = "source";

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

/// The system that a scene describes at its `channel`-th wavelength.
///
/// # Errors
/// An unknown glass, a wavelength outside a glass's range, arrays that are not loaded, or pixel grids
/// of one element that do not share their lattice; reported at the field.
pub fn system(scene: &Scene, channel: usize) -> Result<System, Fault> {
    system_with(scene, &scene.arrays, channel)
}

/// [`system`] with arrays from elsewhere, as [`Scene::load_with`] gives them.
///
/// # Errors
/// As [`system`].
pub fn system_with(scene: &Scene, arrays: &Arrays, channel: usize) -> Result<System, Fault> {
    let wavelength = scene.wavelength_mm(channel)?;
    let ambient = medium(scene, &scene.ambient, "ambient")?;
    let around = index(scene, &ambient, wavelength, "ambient")?;
    let mut layout = Layout {
        scene,
        arrays,
        wavelength,
        inside: ambient.clone(),
        ambient,
        axis: AxisLayout::new(around, scene.source.beam_radius_mm()),
    };
    layout.place_source()?;
    for (number, element) in scene.element.iter().enumerate() {
        layout.place(number, element)?;
    }
    let lit = LitAxis {
        scene,
        first: layout.axis.start(),
        wavelength,
        around,
    };
    let source = lit.source()?;
    Ok(layout.axis.into_system(wavelength, source))
}

/// The scene whose elements are laid along an axis.
struct Layout<'a, 'l> {
    scene: &'a Scene,
    arrays: &'a Arrays<'l>,
    wavelength: f64,
    ambient: Medium,
    axis: AxisLayout,
    /// The medium before the element that is laid.
    inside: Medium,
}

impl Layout<'_, '_> {
    /// Puts the plane on which the light is given before the first element, if it is given on one.
    fn place_source(&mut self) -> Result<(), Fault> {
        let element = source_element(self.scene, self.arrays, self.wavelength)?;
        let (Some(element), Some(plane)) = (element, self.scene.source.plane()) else {
            return Ok(());
        };
        self.axis.advance(-plane.distance_mm);
        let tilt = plane.tilt_deg.map(f64::to_radians);
        let frame = self.axis.frame(plane.decenter_mm, tilt);
        let kind = ScreenKind::Doe(element);
        (self.axis).screen(String::from(SOURCE), frame, Shape::Plane, kind);
        self.axis.advance(plane.distance_mm);
        Ok(())
    }

    /// Places one element and moves the axis on to the next.
    fn place(&mut self, number: usize, element: &Element) -> Result<(), Fault> {
        let path = format!("element[{number}]");
        let tilt = element.tilt_deg().map(f64::to_radians);
        let frame = self.axis.frame(element.decenter_mm(), tilt);
        let name = self.scene.element_name(number);
        let mut along = element.thickness_mm().unwrap_or(0.0);
        match element {
            Element::Doe(doe) => self.doe(doe, name, frame, &path)?,
            Element::ParaxialLens(lens) => {
                let kind = ScreenKind::Doe(self.paraxial_lens(lens));
                self.check_beam(&path)?;
                self.axis.screen(name, frame, Shape::Plane, kind);
            }
            Element::Stop(stop) => {
                let kind = ScreenKind::Stop(stop.aperture.optics());
                self.check_beam(&path)?;
                self.axis.screen(name, frame, Shape::Plane, kind);
            }
            Element::Sensor(sensor) => self.sensor(name, frame, sensor, &path)?,
            Element::Lens(lens) => along += self.lens(lens, frame, &path)?,
            Element::Surface(surface) => {
                let glass = surface.glass.as_ref();
                let (after, medium) = self.after(glass, &format!("{path}.glass"))?;
                let face = PlacedShape {
                    shape: self.shape(&surface.surface_shape(), &path)?,
                    frame,
                    aperture: surface.rim().optics(),
                };
                self.axis
                    .refract(face, self.coating(surface.coating), after);
                self.inside = medium;
            }
            Element::Mirror(mirror) => self.axis.reflect(PlacedShape {
                shape: self.shape(&mirror.surface_shape(), &path)?,
                frame,
                aperture: mirror.rim().optics(),
            }),
            Element::CoordinateBreak(_) => self.axis.turn(frame),
        }
        self.axis.advance(along);
        Ok(())
    }

    /// An element, and the medium behind it where it is an interface.
    fn doe(
        &mut self,
        doe: &DoeElement,
        name: String,
        frame: Frame,
        path: &str,
    ) -> Result<(), Fault> {
        let shape = self.shape(&doe.surface_shape(), path)?;
        let behind = self.behind(doe, path)?;
        let after = behind.as_ref().map_or(&self.inside, |(_, medium)| medium);
        let here = self.axis.index();
        let layers = ElementLayers {
            scene: self.scene,
            arrays: self.arrays,
            wavelength: self.wavelength,
            media: [&self.inside, after],
            indices: [
                here,
                behind.as_ref().map_or(here, |(behind, _)| behind.index),
            ],
            arrives: self.axis.towards(),
            leaves: self.axis.towards() * if doe.reflect { -1.0 } else { 1.0 },
            shape: &shape,
        };
        let kind = ScreenKind::Doe(layers.doe(doe, path)?);
        self.check_beam(path)?;
        self.axis.screen(name, frame, shape, kind);
        if let Some((behind, medium)) = behind {
            self.axis.enter_medium(behind);
            self.inside = medium;
        }
        Ok(())
    }

    fn sensor(
        &mut self,
        name: String,
        frame: Frame,
        sensor: &SensorElement,
        path: &str,
    ) -> Result<(), Fault> {
        if self.axis.is_empty() {
            return Err(self.scene.fault(
                path,
                "a sensor as the only element",
                "at least one element before the sensor",
            ));
        }
        let kind = ScreenKind::Sensor(Sensor {
            pixels: sensor.pixels,
            pitch: sensor.pitch_um.map(|p| p * UM),
        });
        self.axis.screen(name, frame, Shape::Plane, kind);
        Ok(())
    }

    /// The surfaces of a lens; returns its thickness along the axis.
    fn lens(&mut self, lens: &LensElement, frame: Frame, path: &str) -> Result<f64, Fault> {
        let mut depth = 0.0;
        let last = lens.surface.len() - 1;
        for (number, surface) in lens.surface.iter().enumerate() {
            let path = format!("{path}.surface[{number}]");
            let glass = surface.glass.as_ref().filter(|_| number < last);
            let (after, medium) = self.after(glass, &format!("{path}.glass"))?;
            let face = PlacedShape {
                shape: self.shape(&surface.surface_shape(), &path)?,
                frame: frame.moved(Vec3::new(0.0, 0.0, depth)),
                aperture: surface.rim().optics(),
            };
            self.axis
                .refract(face, self.coating(surface.coating), after);
            self.inside = medium;
            depth += surface.thickness_mm.unwrap_or(0.0);
        }
        Ok(depth)
    }

    /// The medium of this material, or the ambient medium, with its index.
    fn after(&self, glass: Option<&Material>, path: &str) -> Result<(f64, Medium), Fault> {
        let medium = match glass {
            Some(material) => medium(self.scene, material, path)?,
            None => self.ambient.clone(),
        };
        Ok((index(self.scene, &medium, self.wavelength, path)?, medium))
    }

    /// The shape of a surface at a path.
    fn shape(&self, shape: &SurfaceShape<'_>, path: &str) -> Result<Shape, Fault> {
        self.arrays.shape(shape, path).ok_or_else(|| {
            self.scene.fault(
                &format!("{path}.shape.height_um"),
                "an array that is not loaded",
                "an array file",
            )
        })
    }

    /// How a surface transmits: by its own coating, or that of the whole scene.
    fn coating(&self, own: Option<Coating>) -> Coating {
        own.unwrap_or(self.scene.settings.coating)
    }

    /// A stop or element that meets the light first limits it itself: no beam radius is stated then.
    fn check_beam(&self, path: &str) -> Result<(), Fault> {
        if self.axis.is_empty() && self.scene.source.beam_radius_mm().is_some() {
            return Err(self.scene.fault(
                "source.beam_radius_mm",
                format!("a beam radius, though the first element ({path}) has an aperture"),
                "no beam_radius_mm: that element's aperture limits the beam",
            ));
        }
        Ok(())
    }

    /// The medium behind an element on an interface.
    ///
    /// # Errors
    /// An unknown medium; light that is reflected.
    fn behind(
        &self,
        doe: &DoeElement,
        path: &str,
    ) -> Result<Option<(MediumBehind, Medium)>, Fault> {
        let Some(glass) = &doe.glass else {
            return Ok(None);
        };
        let path = format!("{path}.glass");
        if doe.reflect {
            let found = "a medium behind an element that reflects light";
            return Err(self.scene.fault(&path, found, "no glass, or no reflect"));
        }
        let (index, medium) = self.after(Some(glass), &path)?;
        let coating = self.coating(doe.coating);
        Ok(Some((MediumBehind { index, coating }, medium)))
    }

    /// The ideal phase for collimated light along the axis, at this wavelength.
    fn paraxial_lens(&self, lens: &ParaxialLens) -> Doe {
        let phase = Profile::Lens {
            focal_length: lens.focal_length_mm,
            wavenumber: std::f64::consts::TAU * self.axis.index() / self.wavelength,
        };
        Doe {
            layers: vec![Layer::Phase(phase)],
            aperture: lens.aperture.optics(),
            reflect: false,
        }
    }
}

/// The settings of a run, as a scene states them; what it leaves out keeps the engine's default.
pub fn settings(scene: &Scene) -> Settings {
    let given = &scene.settings;
    let standard = Settings::default();
    Settings {
        method: given.method,
        target_error: given.target_error,
        sigma: given.sigma_um.map(|s| s * UM),
        step: given.step,
        period: given.period,
        mode_threshold: given.mode_threshold,
        footprint_threshold: given.footprint_threshold,
        correction: given.correction,
        padding: standard.padding,
        nufft_tolerance: given.nufft_tolerance.unwrap_or(standard.nufft_tolerance),
        paper: paper(&given.paper, standard.paper),
        seed: scene.seed,
        memory_limit: usize::try_from(scene.memory_limit()).unwrap_or(usize::MAX),
    }
}

/// The settings of the method `paper`.
fn paper(given: &keys::Paper, standard: Paper) -> Paper {
    Paper {
        rays: given.rays.unwrap_or(standard.rays),
        secondary: given.secondary.unwrap_or(standard.secondary),
        patch: given.patch_um.map(|p| p * UM),
        window: given.window,
        padding: given.padding.unwrap_or(standard.padding),
        orders: given.orders.unwrap_or(standard.orders),
        positions: given.positions,
        coverage: given.coverage,
        density: given.density,
        sampler: given.sampler,
        sag: given.sag,
        obliquity: given.obliquity,
    }
}
