//! From a scene to the optical system it describes, one wavelength at a time.

use num_complex::Complex64;

use crate::engine::plan::settings::{Paper, Settings};
use crate::file::decode::fault::Fault;
use crate::file::model::light::{LitAxis, source_element};
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::element::{
    self, Coordinates, Element, LensElement, ParaxialLens, SensorElement,
};
use crate::file::scene::layer;
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::settings as keys;
use crate::file::scene::surface_shape::SurfaceShape;
use crate::math::vec3::Vec3;
use crate::optics::assembly::axis_layout::{AxisLayout, PlacedShape};
use crate::optics::doe::{Doe, Lattice, Layer, PixelForm, Pixels, lattices};
use crate::optics::frame::Frame;
use crate::optics::media::catalog;
use crate::optics::media::medium::{Medium, MediumError};
use crate::optics::phase::blaze::Blaze;
use crate::optics::phase::profile::Profile;
use crate::optics::phase::two_point::{RecordedWave, TwoPoint};
use crate::optics::refraction::Coating;
use crate::optics::screen::{MediumBehind, ScreenKind, Sensor};
use crate::optics::shape::Shape;
use crate::optics::surface_coordinates::SurfaceCoordinates;
use crate::optics::system::System;
use crate::optics::zernike::ZernikeSum;

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
        ambient,
        axis: AxisLayout::new(around, scene.source.beam_radius_mm()),
        behind: around,
        leaves: 1.0,
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

/// The index of a material of the scene at its `channel`-th wavelength; faults are reported at `path`.
///
/// # Errors
/// An unknown glass, or a wavelength outside its range.
pub(crate) fn index_at(
    scene: &Scene,
    material: &Material,
    channel: usize,
    path: &str,
) -> Result<f64, Fault> {
    let medium = medium(scene, material, path)?;
    index(scene, &medium, scene.wavelength_mm(channel)?, path)
}

fn medium(scene: &Scene, material: &Material, path: &str) -> Result<Medium, Fault> {
    match material {
        Material::Own(own) => {
            (own.medium()).map_err(|(found, expected)| scene.fault(path, found, expected))
        }
        Material::Named(name) => catalog::medium(name)
            .map_err(|error| scene.fault(path, error.to_string(), "a name of the glass catalogue")),
    }
}

fn index(scene: &Scene, medium: &Medium, wavelength: f64, path: &str) -> Result<f64, Fault> {
    medium.index(wavelength).map_err(|error| match error {
        MediumError::OutOfRange {
            name,
            wavelength_um,
            from_um,
            to_um,
        } => {
            let found = format!("{name} at a wavelength of {wavelength_um} µm");
            let expected = format!("one from {from_um} to {to_um} µm, where it is known");
            scene.fault(path, found, expected)
        }
        other => {
            let expected = "a medium that is known at the scene's wavelengths";
            scene.fault(path, other.to_string(), expected)
        }
    })
}

/// The scene whose elements are laid along an axis.
struct Layout<'a, 'l> {
    scene: &'a Scene,
    arrays: &'a Arrays<'l>,
    wavelength: f64,
    ambient: Medium,
    axis: AxisLayout,
    /// Index of the medium behind the element that is laid.
    behind: f64,
    /// +1 where light leaves the element that is laid towards its +z, else −1.
    leaves: f64,
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
            Element::Doe(doe) => {
                let shape = self.shape(&doe.surface_shape(), &path)?;
                let behind = self.behind(doe, &path)?;
                self.behind = behind.map_or(self.axis.index(), |behind| behind.index);
                self.leaves = self.axis.towards() * if doe.reflect { -1.0 } else { 1.0 };
                let kind = ScreenKind::Doe(self.doe(doe, &shape, &path)?);
                self.check_beam(&path)?;
                self.axis.screen(name, frame, shape, kind);
                if let Some(behind) = behind {
                    self.axis.enter_medium(behind);
                }
            }
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
                let after = self.after(glass, &format!("{path}.glass"))?;
                let face = PlacedShape {
                    shape: self.shape(&surface.surface_shape(), &path)?,
                    frame,
                    aperture: surface.rim().optics(),
                };
                self.axis
                    .refract(face, self.coating(surface.coating), after);
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
            let after = self.after(glass, &format!("{path}.glass"))?;
            let face = PlacedShape {
                shape: self.shape(&surface.surface_shape(), &path)?,
                frame: frame.moved(Vec3::new(0.0, 0.0, depth)),
                aperture: surface.rim().optics(),
            };
            self.axis
                .refract(face, self.coating(surface.coating), after);
            depth += surface.thickness_mm.unwrap_or(0.0);
        }
        Ok(depth)
    }

    /// Index of the medium behind a surface: its glass, or the ambient medium.
    fn after(&self, glass: Option<&Material>, path: &str) -> Result<f64, Fault> {
        let medium = match glass {
            Some(material) => medium(self.scene, material, path)?,
            None => self.ambient.clone(),
        };
        index(self.scene, &medium, self.wavelength, path)
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
    /// An unknown medium; light that is reflected; heights, which stand in one medium.
    fn behind(&self, doe: &element::DoeElement, path: &str) -> Result<Option<MediumBehind>, Fault> {
        let Some(glass) = &doe.glass else {
            return Ok(None);
        };
        let path = format!("{path}.glass");
        let refuse = |found: &str, expected: &str| Err(self.scene.fault(&path, found, expected));
        if doe.reflect {
            let found = "a medium behind an element that reflects light";
            return refuse(found, "no glass, or no reflect");
        }
        if doe.layer.iter().any(layer::Layer::has_heights) {
            let found = "a medium behind an element with a layer of heights";
            return refuse(
                found,
                "layers of phase, or heights on an element in one medium",
            );
        }
        Ok(Some(MediumBehind {
            index: self.after(Some(glass), &path)?,
            coating: self.coating(doe.coating),
        }))
    }

    fn doe(&self, doe: &element::DoeElement, shape: &Shape, path: &str) -> Result<Doe, Fault> {
        let layers = self.layers(&doe.layer, &format!("{path}.layer"))?;
        let doe = Doe {
            layers: match doe.coordinates {
                Coordinates::Projected => layers,
                Coordinates::Surface => vec![self.on_surface(layers, shape, path)?],
            },
            aperture: doe.aperture.optics(),
            reflect: doe.reflect,
        };
        if !doe.shares_lattice() {
            return Err(self.scene.fault(
                &format!("{path}.layer"),
                "pixel grids of different pitch, size or pixel form in one element",
                "grids that share their lattice; or two elements at a distance",
            ));
        }
        Ok(doe)
    }

    /// Layers on the own coordinates of a surface.
    fn on_surface(&self, layers: Vec<Layer>, shape: &Shape, path: &str) -> Result<Layer, Fault> {
        let place = format!("{path}.coordinates");
        let is_point = |lattice: &Lattice| lattice.form == PixelForm::Point;
        if lattices(&layers).iter().any(is_point) {
            let found = "\"surface\" with pixels that are points";
            let expected = "pixel = \"box\" or \"bilinear\", or coordinates = \"projected\"";
            return Err(self.scene.fault(&place, found, expected));
        }
        let own = SurfaceCoordinates::of(shape).ok_or_else(|| {
            let found = "\"surface\" on a surface that is curved in two ways";
            let expected = "a surface of revolution about its own axis or a cylinder, or coordinates = \
                            \"projected\"";
            self.scene.fault(&place, found, expected)
        })?;
        Ok(Layer::OnSurface(Box::new(own), layers))
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

    fn layers(&self, layers: &[layer::Layer], path: &str) -> Result<Vec<Layer>, Fault> {
        let one = |(i, layer): (usize, &layer::Layer)| self.layer(layer, &format!("{path}[{i}]"));
        layers.iter().enumerate().map(one).collect()
    }

    fn layer(&self, layer: &layer::Layer, path: &str) -> Result<Layer, Fault> {
        let k = std::f64::consts::TAU / self.wavelength;
        let missing = || {
            self.scene.fault(
                path,
                "an array that is not loaded",
                "an array file, or size = [nx, ny]",
            )
        };
        Ok(match layer {
            layer::Layer::Pixels(pixels) => {
                let values = self.arrays.transmission(pixels, path).ok_or_else(missing)?;
                grid(pixels.pitch_um, values, pixels.pixel)
            }
            layer::Layer::Height(relief) => {
                let heights = self.arrays.heights_um(path).ok_or_else(missing)?;
                let place = format!("{path}.glass");
                let step = self.after(Some(&relief.glass), &place)? - self.axis.index();
                let values = heights.mapv(|h| Complex64::cis(k * step * h * UM));
                grid(relief.pitch_um, values, relief.pixel)
            }
            layer::Layer::Sum(sum) => {
                let mut terms = Vec::new();
                for (i, term) in sum.terms.iter().enumerate() {
                    let weight = sum.weights.as_ref().and_then(|w| w.get(i)).copied();
                    let weight = weight.unwrap_or(1.0);
                    let layers = self.layers(term, &format!("{path}.terms[{i}]"))?;
                    terms.push((Complex64::new(weight, 0.0), layers));
                }
                Layer::Sum(terms)
            }
            layer::Layer::Kinoform(kinoform) => self.kinoform(kinoform, path)?,
            _ => Layer::Phase(self.placed_profile(layer)),
        })
    }

    /// The orders of a kinoform, each a term of a sum.
    fn kinoform(&self, kinoform: &layer::KinoformLayer, path: &str) -> Result<Layer, Fault> {
        let made_for = self.made_for(kinoform.wavelength_um);
        let step = |wavelength: f64| -> Result<f64, Fault> {
            let Some(glass) = &kinoform.glass else {
                return Ok(1.0);
            };
            let path = format!("{path}.glass");
            let inside = index(
                self.scene,
                &medium(self.scene, glass, &path)?,
                wavelength,
                &path,
            )?;
            Ok(inside - index(self.scene, &self.ambient, wavelength, &path)?)
        };
        let alpha = made_for / self.wavelength * step(self.wavelength)? / step(made_for)?;
        if !alpha.is_finite() {
            let found = "a material with the index of the ambient medium";
            return Err(self
                .scene
                .fault(&format!("{path}.glass"), found, "another material"));
        }
        let blaze = kinoform.levels.map_or(Blaze::Continuous, Blaze::Levels);
        let phases: Vec<Profile> = (kinoform.layer.iter())
            .map(|layer| self.placed_profile(layer))
            .collect();
        let term = |order: &i32| {
            let layers = phases.iter().map(|phase| Layer::Phase(phase.times(*order)));
            (blaze.amplitude(alpha, *order), layers.collect())
        };
        Ok(Layer::Sum(kinoform.orders.iter().map(term).collect()))
    }

    /// The analytic phase of a layer where its own axes stand.
    fn placed_profile(&self, layer: &layer::Layer) -> Profile {
        let own = self.profile(layer);
        match layer.placement() {
            Some(placement) => own.placed(placement),
            None => own,
        }
    }

    /// The analytic phase of a layer that is one; zero for the others.
    fn profile(&self, layer: &layer::Layer) -> Profile {
        let k = std::f64::consts::TAU / self.wavelength;
        match layer {
            layer::Layer::Grating(grating) => {
                let rate =
                    std::f64::consts::TAU * f64::from(grating.order) / (grating.period_um * UM);
                let (sin, cos) = grating.direction_deg.to_radians().sin_cos();
                Profile::Linear {
                    gradient: [rate * cos, rate * sin],
                }
            }
            layer::Layer::Lens(lens) => {
                let made_for = self.made_for(lens.wavelength_um);
                Profile::Lens {
                    focal_length: lens.focal_length_mm,
                    wavenumber: std::f64::consts::TAU * self.behind / made_for,
                }
            }
            layer::Layer::Axicon(axicon) => Profile::Axicon {
                slope: -k * self.behind * axicon.angle_deg.to_radians().sin(),
            },
            layer::Layer::Vortex(vortex) => Profile::Vortex {
                charge: vortex.charge,
            },
            layer::Layer::Radial(radial) => Profile::Radial {
                radius: radial.norm_radius_mm,
                coefficients: radial.coefficients.clone(),
            },
            layer::Layer::Zernike(zernike) => Profile::Zernike(ZernikeSum::new(
                zernike.norm_radius_mm,
                zernike.coefficients.clone(),
            )),
            layer::Layer::Polynomial(sum) => Profile::Polynomial {
                radius: sum.norm_radius_mm,
                terms: (sum.terms.iter())
                    .map(|term| ([term.x, term.y], term.coefficient))
                    .collect(),
            },
            layer::Layer::TwoPoint(hologram) => Profile::TwoPoint(self.two_point(hologram)),
            layer::Layer::Pixels(_)
            | layer::Layer::Height(_)
            | layer::Layer::Kinoform(_)
            | layer::Layer::Sum(_) => Profile::Linear { gradient: [0.0; 2] },
        }
    }

    /// The phase of a hologram of two points.
    fn two_point(&self, hologram: &layer::TwoPointLayer) -> TwoPoint {
        let made_for = self.made_for(hologram.wavelength_um);
        // The light comes from where its way leads backwards, and goes to where it leads.
        let wave = |wave: &layer::RecordedWave, heading: f64| match wave.point_mm {
            Some(at) => RecordedWave::Point {
                at,
                converges: at[2] * heading > 0.0,
            },
            None => RecordedWave::Collimated(wave.angle_deg.map(|angle| angle.to_radians().sin())),
        };
        TwoPoint {
            object: wave(&hologram.object, self.leaves),
            reference: wave(&hologram.reference, self.axis.towards()),
            wavenumbers: [self.behind, self.axis.index()]
                .map(|index| std::f64::consts::TAU * index / made_for),
            order: f64::from(hologram.order),
        }
    }

    /// The wavelength in mm for which a layer is made: its own, or else the scene's first.
    fn made_for(&self, own_um: Option<f64>) -> f64 {
        let first = self.scene.wavelength_um.first().copied();
        own_um.or(first).map_or(self.wavelength, |um| um * UM)
    }
}

fn grid(pitch_um: [f64; 2], values: ndarray::Array2<Complex64>, form: PixelForm) -> Layer {
    Layer::Pixels(Pixels {
        pitch: pitch_um.map(|p| p * UM),
        values,
        form,
    })
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
        memory_limit: (given.memory_limit_mb * 1e6) as usize,
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
