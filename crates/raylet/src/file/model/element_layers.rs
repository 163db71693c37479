//! The layers of a diffractive element, from the keys of a scene to what they do to light.

use num_complex::Complex64;

use crate::file::decode::fault::Fault;
use crate::file::model::relief_side::{side_of_relief, unplaced};
use crate::file::model::scene_arrays::Arrays;
use crate::file::model::scene_media::{index, medium};
use crate::file::scene::element::{Coordinates, DoeElement};
use crate::file::scene::layer::{self, HeightLayer, KinoformLayer, PhaseGridLayer};
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::optics::doe::{Doe, Layer, lattices};
use crate::optics::media::medium::Medium;
use crate::optics::phase::blaze::Blaze;
use crate::optics::phase::phase_grid::PhaseGrid;
use crate::optics::phase::placement::Placement;
use crate::optics::phase::profile::Profile;
use crate::optics::phase::radial_table::RadialTable;
use crate::optics::phase::two_point::{RecordedWave, TwoPoint};
use crate::optics::pixels::active_area::ActiveArea;
use crate::optics::pixels::pixel_axes::is_same_from_pixels;
use crate::optics::pixels::pixel_grid::{Lattice, PixelForm, Pixels};
use crate::optics::shape::Shape;
use crate::optics::surface_coordinates::SurfaceCoordinates;
use crate::optics::zernike::ZernikeSum;

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

/// Where an element stands, and what its layers are made from.
pub(crate) struct ElementLayers<'a, 'l> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its arrays.
    pub arrays: &'a Arrays<'l>,
    /// In mm.
    pub wavelength: f64,
    /// The media before and behind the element; the same where it stands in one.
    pub media: [&'a Medium; 2],
    /// Their indices.
    pub indices: [f64; 2],
    /// +1 where light arrives towards the element's +z, else −1.
    pub arrives: f64,
    /// The same where it leaves.
    pub leaves: f64,
    /// The surface on which the element stands.
    pub shape: &'a Shape,
}

/// A layer of phases on own coordinates, as phases over x and y; nothing with pixels.
fn phase_along(own: &SurfaceCoordinates, layer: &Layer) -> Option<Layer> {
    match layer {
        Layer::Phase(profile) => {
            let profile = Box::new(profile.clone());
            let along = Profile::AlongSurface(Box::new(own.clone()), profile);
            Some(Layer::Phase(along))
        }
        Layer::Sum(terms) => {
            let terms = terms.iter().map(|(weight, layers)| {
                let layers = layers.iter().map(|layer| phase_along(own, layer));
                Some((*weight, layers.collect::<Option<Vec<Layer>>>()?))
            });
            terms.collect::<Option<Vec<_>>>().map(Layer::Sum)
        }
        Layer::Pixels(_) | Layer::OnSurface(..) => None,
    }
}

impl ElementLayers<'_, '_> {
    /// The element with these keys at a path.
    ///
    /// # Errors
    /// Arrays that are not loaded, unknown materials, pixel grids that do not share their lattice.
    pub(crate) fn doe(&self, doe: &DoeElement, path: &str) -> Result<Doe, Fault> {
        let layers = self.layers(&doe.layer, &format!("{path}.layer"))?;
        self.check_holograms(doe, path)?;
        let doe = Doe {
            layers: match doe.coordinates {
                Coordinates::Projected => layers,
                Coordinates::Surface => self.on_surface(layers, path)?,
            },
            aperture: doe.aperture.optics(),
            reflect: doe.reflect,
        };
        if !is_same_from_pixels(self.shape, &doe) {
            return Err(self.scene.fault(
                &format!("{path}.layer"),
                "pixels that are off centre, or turned, on a curved surface",
                "centred pixels on the element, which decenter_mm and tilt_deg move and turn as a whole; a plane element; or \
                 rotation_deg alone on a surface of revolution",
            ));
        }
        if !doe.shares_lattice() {
            return Err(self.scene.fault(
                &format!("{path}.layer"),
                "pixel grids of different pitch, size, pixel form, fill or place in one element",
                "grids that share their lattice; or two elements at a distance",
            ));
        }
        Ok(doe)
    }

    /// A hologram of two points knows its places in space, not along a curved surface.
    fn check_holograms(&self, doe: &DoeElement, path: &str) -> Result<(), Fault> {
        let along = doe.coordinates == Coordinates::Surface && *self.shape != Shape::Plane;
        if along && holds_two_point(&doe.layer) {
            return Err(self.scene.fault(
                &format!("{path}.coordinates"),
                "\"surface\" with a hologram of two points on a curved element",
                "\"projected\"",
            ));
        }
        Ok(())
    }

    /// Layers on the own coordinates of a surface: phases over x and y where all are phases, which every method knows.
    fn on_surface(&self, layers: Vec<Layer>, path: &str) -> Result<Vec<Layer>, Fault> {
        let place = format!("{path}.coordinates");
        let is_point = |lattice: &Lattice| lattice.form == PixelForm::Point;
        if lattices(&layers).iter().any(is_point) {
            let found = "\"surface\" with pixels that are points";
            let expected = "pixel = \"box\" or \"bilinear\", or coordinates = \"projected\"";
            return Err(self.scene.fault(&place, found, expected));
        }
        let own = SurfaceCoordinates::of(self.shape).ok_or_else(|| {
            let found = "\"surface\" on a surface that is curved in two ways";
            let expected = "a surface of revolution about its own axis or a cylinder, or coordinates = \
                            \"projected\"";
            self.scene.fault(&place, found, expected)
        })?;
        let phases = layers.iter().map(|layer| phase_along(&own, layer));
        let phases: Option<Vec<Layer>> = phases.collect();
        Ok(phases.unwrap_or_else(|| vec![Layer::OnSurface(Box::new(own), layers)]))
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
                let active = pixels.active().map_err(|error| {
                    let expected = "more than 0 and at most 1";
                    self.scene
                        .fault(&format!("{path}.fill"), error.to_string(), expected)
                })?;
                let (pitch_um, values) = match pixels.fringing() {
                    Some(fringing) => (
                        pixels
                            .pitch_um
                            .map(|pitch| pitch / pixels.sub_pixels as f64),
                        fringing.transmission(&values, pixels.pitch_um.map(|pitch| pitch * UM)),
                    ),
                    None => (pixels.pitch_um, values),
                };
                Layer::Pixels(Pixels {
                    active,
                    placement: pixels.placement(),
                    ..grid(pitch_um, values, pixels.pixel)
                })
            }
            layer::Layer::Height(relief) => {
                let heights = self.arrays.heights_um(path).ok_or_else(missing)?;
                let step = self.relief_step(relief, path)?;
                let values = heights.mapv(|h| Complex64::cis(k * step * h * UM));
                Layer::Pixels(Pixels {
                    placement: relief.placement(),
                    ..grid(relief.pitch_um, values, relief.pixel)
                })
            }
            layer::Layer::Sum(sum) => {
                let mut terms = Vec::new();
                for (i, term) in sum.terms.iter().enumerate() {
                    let weight = sum.weights.as_ref().and_then(|w| w.get(i));
                    let weight = weight.map_or(Complex64::ONE, |weight| weight.0);
                    let layers = self.layers(term, &format!("{path}.terms[{i}]"))?;
                    terms.push((weight, layers));
                }
                Layer::Sum(terms)
            }
            layer::Layer::Kinoform(kinoform) => self.kinoform(kinoform, path)?,
            _ => Layer::Phase(self.placed_profile(layer, path)?),
        })
    }

    /// The orders of a kinoform, each a term of a sum.
    fn kinoform(&self, kinoform: &KinoformLayer, path: &str) -> Result<Layer, Fault> {
        let made_for = self.made_for(kinoform.wavelength_um);
        let step = |wavelength: f64| -> Result<f64, Fault> {
            match &kinoform.glass {
                Some(glass) => self.kinoform_step(kinoform, glass, wavelength, path),
                None => Ok(1.0),
            }
        };
        let alpha = made_for / self.wavelength * step(self.wavelength)? / step(made_for)?;
        if !alpha.is_finite() {
            let found = "a material with the index of the medium in which its profile stands";
            return Err(self
                .scene
                .fault(&format!("{path}.glass"), found, "another material"));
        }
        let blaze = kinoform.levels.map_or(Blaze::Continuous, Blaze::Levels);
        let phases: Vec<Profile> = (kinoform.layer.iter().enumerate())
            .map(|(i, layer)| self.placed_profile(layer, &format!("{path}.layer[{i}]")))
            .collect::<Result<_, Fault>>()?;
        let term = |order: &i32| {
            let layers = phases.iter().map(|phase| Layer::Phase(phase.times(*order)));
            (blaze.amplitude(alpha, *order), layers.collect())
        };
        Ok(Layer::Sum(kinoform.orders.iter().map(term).collect()))
    }

    /// The index of a relief less that of the medium whose place it takes.
    fn relief_step(&self, relief: &HeightLayer, path: &str) -> Result<f64, Fault> {
        let place = format!("{path}.glass");
        let material = medium(self.scene, &relief.glass, &place)?;
        let own = index(self.scene, &material, self.wavelength, &place)?;
        let side = side_of_relief(own, self.indices, relief.stands_in);
        let side = side.ok_or_else(|| unplaced(self.scene, path))?;
        Ok(own - side.of(self.indices))
    }

    /// The index of a kinoform's material at a wavelength less that of the medium whose place it takes.
    fn kinoform_step(
        &self,
        kinoform: &KinoformLayer,
        glass: &Material,
        wavelength: f64,
        path: &str,
    ) -> Result<f64, Fault> {
        let place = format!("{path}.glass");
        let material = medium(self.scene, glass, &place)?;
        let at = |medium: &Medium, wavelength: f64| index(self.scene, medium, wavelength, &place);
        let own = at(&material, self.wavelength)?;
        let side = side_of_relief(own, self.indices, kinoform.stands_in);
        let side = side.ok_or_else(|| unplaced(self.scene, path))?;
        Ok(at(&material, wavelength)? - at(side.of(self.media), wavelength)?)
    }

    /// The analytic phase of a layer where its own axes stand.
    fn placed_profile(&self, layer: &layer::Layer, path: &str) -> Result<Profile, Fault> {
        let own = match layer {
            layer::Layer::PhaseGrid(grid) => self.phase_grid(grid, path)?,
            _ => self.profile(layer),
        };
        Ok(match layer.placement() {
            Some(placement) => own.placed(placement),
            None => own,
        })
    }

    /// The phase of samples on a grid.
    fn phase_grid(&self, layer: &PhaseGridLayer, path: &str) -> Result<Profile, Fault> {
        let phases = self.arrays.real(&format!("{path}.phase"));
        let grid = phases.and_then(|phases| {
            PhaseGrid::new(&phases.to_owned(), layer.pitch_um.map(|pitch| pitch * UM))
        });
        let missing = || {
            self.scene
                .fault(path, "an array that is not loaded", "an array file")
        };
        grid.map(Profile::Grid).ok_or_else(missing)
    }

    /// The phase of a layer that is a formula or a table; zero for the others.
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
                    wavenumber: std::f64::consts::TAU * self.indices[1] / made_for,
                }
            }
            layer::Layer::Axicon(axicon) => Profile::Axicon {
                slope: -k * self.indices[1] * axicon.angle_deg.to_radians().sin(),
            },
            layer::Layer::Vortex(vortex) => Profile::Vortex {
                charge: vortex.charge,
            },
            layer::Layer::Radial(radial) => Profile::Radial {
                radius: radial.norm_radius_mm,
                coefficients: radial.coefficients.clone(),
            },
            layer::Layer::RadialTable(table) => {
                let spline = RadialTable::new(&table.radius_mm, &table.phase_rad);
                spline.map_or_else(flat, Profile::RadialTable)
            }
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
            layer::Layer::PhaseGrid(_)
            | layer::Layer::Pixels(_)
            | layer::Layer::Height(_)
            | layer::Layer::Kinoform(_)
            | layer::Layer::Sum(_) => flat(),
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
            None => {
                let [p, q] = wave.angle_deg.map(|angle| angle.to_radians().sin());
                RecordedWave::Collimated([p, q, heading * (1.0 - p * p - q * q).sqrt()])
            }
        };
        TwoPoint {
            object: wave(&hologram.object, self.leaves),
            reference: wave(&hologram.reference, self.arrives),
            wavenumbers: [self.indices[1], self.indices[0]]
                .map(|index| std::f64::consts::TAU * index / made_for),
            order: f64::from(hologram.order),
            surface: (self.shape.clone(), hologram.placement()),
        }
    }

    /// The wavelength in mm for which a layer is made: its own, or else the scene's first.
    fn made_for(&self, own_um: Option<f64>) -> f64 {
        let first = self.scene.wavelength_um.first().copied();
        own_um.or(first).map_or(self.wavelength, |um| um * UM)
    }
}

/// Whether a hologram of two points is among layers, or within one of them.
fn holds_two_point(layers: &[layer::Layer]) -> bool {
    layers.iter().any(|layer| match layer {
        layer::Layer::TwoPoint(_) => true,
        layer::Layer::Kinoform(kinoform) => holds_two_point(&kinoform.layer),
        layer::Layer::Sum(sum) => sum.terms.iter().any(|term| holds_two_point(term)),
        _ => false,
    })
}

/// No phase.
fn flat() -> Profile {
    Profile::Linear { gradient: [0.0; 2] }
}

fn grid(pitch_um: [f64; 2], values: ndarray::Array2<Complex64>, form: PixelForm) -> Pixels {
    Pixels {
        pitch: pitch_um.map(|p| p * UM),
        values,
        form,
        active: ActiveArea::WHOLE,
        placement: Placement::NONE,
    }
}
