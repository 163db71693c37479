//! The elements of a scene, laid as the surfaces of a sequential prescription.

use crate::file::decode::fault::Fault;
use crate::file::model::scene_media::{index, medium};
use crate::file::prescription::element_parts::disc;
use crate::file::prescription::export::held_phase::{HeldLayer, Standing, held_layer, joined};
use crate::file::prescription::export::lens_edges::LensEdge;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::{Action, Behind, Curve, Face, GlassRequest, Turn};
use crate::file::scene::aperture::{Aperture, Rim};
use crate::file::scene::element::{Coordinates, DoeElement, Element, LensElement, SensorElement};
use crate::file::scene::layer::Layer;
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::surface_shape::SurfaceShape;
use crate::optics::media::catalog;

/// How a message says that parts may be left out.
pub(crate) const SKIP: &str =
    "--skip-unknown leaves out what the file cannot hold (in Python, skip_unknown=True)";

/// The surfaces of a scene, from the object to the image.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaidSurfaces {
    /// The surfaces.
    pub surface: Vec<Face>,
    /// The media behind them.
    pub media: Vec<MediumBehind>,
    /// The path in the scene from which each comes.
    pub path: Vec<String>,
    /// How far the sensor reaches in mm.
    pub sensor_mm: f64,
}

/// The surfaces of a scene whose object is this far before its axis in mm.
///
/// # Errors
/// An element that no prescription holds, unless `skip_unknown`; an unknown glass or a wavelength outside its range.
pub(crate) fn lay(
    scene: &Scene,
    object_mm: f64,
    skip_unknown: bool,
    losses: &mut Losses,
) -> Result<LaidSurfaces, Fault> {
    let wavelength = scene.wavelength_mm(0)?;
    let ambient = behind_of(scene, &scene.ambient, wavelength, "ambient")?;
    let object = Face {
        action: Action::Border,
        thickness_mm: object_mm,
        ..Face::turned([0, 0], Turn::default())
    };
    let mut laying = Laying {
        scene,
        wavelength,
        skip_unknown,
        losses,
        ambient: ambient.clone(),
        inside: ambient.clone(),
        beam: scene.source.beam_radius_mm(),
        laid: LaidSurfaces {
            surface: vec![object],
            media: vec![ambient],
            path: vec!["source".to_owned()],
            sensor_mm: 0.0,
        },
    };
    for (number, element) in scene.element.iter().enumerate() {
        laying.place(&format!("element[{number}]"), element)?;
    }
    Ok(laying.laid)
}

/// A medium as what is behind a surface.
fn behind_of(
    scene: &Scene,
    material: &Material,
    wavelength: f64,
    path: &str,
) -> Result<MediumBehind, Fault> {
    let found = medium(scene, material, path)?;
    Ok(MediumBehind {
        material: (!is_air(material)).then(|| material.clone()),
        index: index(scene, &found, wavelength, path)?,
    })
}

/// Whether a material is what files leave empty.
fn is_air(material: &Material) -> bool {
    match material {
        Material::Named(name) => catalog::glass(name).is_ok_and(|glass| {
            let names = ["air", "vacuum"];
            glass.names.first().is_some_and(|name| names.contains(name))
        }),
        Material::Own(_) => false,
    }
}

/// What acts at a surface.
struct Part<'a> {
    path: String,
    name: Option<&'a str>,
    action: Action,
    curve: Curve,
    phase: Vec<Layer>,
    reflects: bool,
    /// The medium behind it, where it is another one.
    behind: Option<MediumBehind>,
    open: Aperture,
    /// Whether light passes it only within its aperture.
    screen: bool,
}

/// A scene as it is laid.
struct Laying<'a> {
    scene: &'a Scene,
    wavelength: f64,
    skip_unknown: bool,
    losses: &'a mut Losses,
    ambient: MediumBehind,
    inside: MediumBehind,
    /// Radius of the beam in mm, until the first surface.
    beam: Option<f64>,
    laid: LaidSurfaces,
}

impl Laying<'_> {
    /// Places an element.
    fn place(&mut self, path: &str, element: &Element) -> Result<(), Fault> {
        let there = Turn {
            decenter_mm: element.decenter_mm(),
            tilt_deg: element.tilt_deg(),
            ..Turn::default()
        };
        let moved = there != Turn::default();
        let along = element.thickness_mm().unwrap_or(0.0);
        if let Element::Sensor(sensor) = element {
            self.sensor(path, sensor, there);
            return Ok(());
        }
        if matches!(element, Element::CoordinateBreak(_)) {
            self.turn(path, there, along);
            return Ok(());
        }
        if moved {
            self.turn(path, there, 0.0);
        }
        let parts = self.parts(path, element)?;
        let depth = self.push_all(parts);
        if !moved {
            self.advance(along);
            return Ok(());
        }
        // The axis goes on from the first vertex as if the element were not turned.
        if depth != 0.0 {
            self.turn(path, Turn::default(), -depth);
        }
        let back = Turn {
            decenter_mm: there.decenter_mm.map(|shift| 0.0 - shift),
            tilt_deg: there.tilt_deg.map(|angle| 0.0 - angle),
            tilt_first: true,
            ..Turn::default()
        };
        self.turn(path, back, depth + along);
        Ok(())
    }

    /// The surfaces of an element with the distances between them.
    fn parts<'e>(
        &mut self,
        path: &str,
        element: &'e Element,
    ) -> Result<Vec<(Part<'e>, f64)>, Fault> {
        let plain = |open: &Aperture, action| Part {
            path: path.to_owned(),
            name: element.name(),
            action,
            curve: Curve::default(),
            phase: Vec::new(),
            reflects: false,
            behind: None,
            open: open.clone(),
            screen: true,
        };
        let one = |part| Ok(vec![(part, 0.0)]);
        match element {
            Element::Stop(stop) => one(plain(&stop.aperture, Action::Border)),
            Element::ParaxialLens(lens) => {
                let action = Action::IdealLens(lens.focal_length_mm);
                one(plain(&lens.aperture, action))
            }
            Element::Mirror(mirror) => one(Part {
                curve: curve(&mirror.surface_shape()),
                reflects: true,
                screen: false,
                ..plain(&open(&mirror.rim()), Action::Border)
            }),
            Element::Surface(surface) => one(Part {
                curve: curve(&surface.surface_shape()),
                behind: Some(self.after(surface.glass.as_ref(), &format!("{path}.glass"))?),
                screen: false,
                ..plain(&open(&surface.rim()), Action::Border)
            }),
            Element::Doe(doe) => {
                let part = plain(&doe.aperture, Action::Border);
                one(self.doe(doe, path, part)?)
            }
            Element::Lens(lens) => self.lens(lens, path, element.name()),
            Element::CoordinateBreak(_) | Element::Sensor(_) => Ok(Vec::new()),
        }
    }

    /// The surfaces of a lens.
    fn lens<'e>(
        &mut self,
        lens: &LensElement,
        path: &str,
        name: Option<&'e str>,
    ) -> Result<Vec<(Part<'e>, f64)>, Fault> {
        let last = lens.surface.len().saturating_sub(1);
        let mut list = Vec::new();
        for (number, surface) in lens.surface.iter().enumerate() {
            let path = format!("{path}.surface[{number}]");
            let glass = surface.glass.as_ref().filter(|_| number < last);
            let part = Part {
                name: name.filter(|_| number == 0),
                action: Action::Border,
                curve: curve(&surface.surface_shape()),
                phase: Vec::new(),
                reflects: false,
                behind: Some(self.after(glass, &format!("{path}.glass"))?),
                open: open(&surface.rim()),
                screen: false,
                path,
            };
            list.push((part, surface.thickness_mm.unwrap_or(0.0)));
        }
        Ok(list)
    }

    /// A diffractive element with the phases that a prescription holds.
    fn doe<'e>(&mut self, doe: &DoeElement, path: &str, part: Part<'e>) -> Result<Part<'e>, Fault> {
        let behind = match &doe.glass {
            Some(glass) => Some(self.after(Some(glass), &format!("{path}.glass"))?),
            None => None,
        };
        let curve = curve(&doe.surface_shape());
        let plane = curve == Curve::default();
        if doe.coordinates == Coordinates::Surface && !plane {
            let found = "\"surface\" on a curved element";
            self.refuse(&format!("{path}.coordinates"), found, "\"projected\"")?;
        }
        let reach_mm = LensEdge::of(&doe.aperture).map_or(1.0, |edge| {
            edge.radius() + edge.centre_mm[0].hypot(edge.centre_mm[1])
        });
        let standing = Standing {
            first_um: self.wavelength * 1e3,
            index: behind.as_ref().unwrap_or(&self.inside).index,
            reach_mm,
        };
        let held = self.held(doe, path, standing)?;
        Ok(Part {
            curve,
            phase: joined(&held, reach_mm).into_iter().collect(),
            reflects: doe.reflect,
            behind,
            ..part
        })
    }

    /// The layers that are held.
    fn held(
        &mut self,
        doe: &DoeElement,
        path: &str,
        standing: Standing,
    ) -> Result<Vec<HeldLayer>, Fault> {
        let mut list = Vec::new();
        for (number, layer) in doe.layer.iter().enumerate() {
            match held_layer(layer, standing) {
                Ok(held) => {
                    for remark in &held.remarks {
                        self.losses.change(format!("{path}: {remark}."));
                    }
                    list.push(held);
                }
                Err((found, expected)) => {
                    self.refuse(&format!("{path}.layer[{number}]"), found, expected)?;
                }
            }
        }
        Ok(list)
    }

    /// A part that no prescription holds: a fault, or a warning where such parts are left out.
    fn refuse(
        &mut self,
        path: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Result<(), Fault> {
        let found = found.into();
        if self.skip_unknown {
            self.losses.warn(format!(
                "{path} is left out: the file cannot hold {found}. Light behind it goes another way."
            ));
            return Ok(());
        }
        Err(self.scene.fault(path, found, expected).hint(SKIP))
    }

    fn after(&self, glass: Option<&Material>, path: &str) -> Result<MediumBehind, Fault> {
        match glass {
            Some(material) => behind_of(self.scene, material, self.wavelength, path),
            None => Ok(self.ambient.clone()),
        }
    }

    /// Adds surfaces; returns the distance from the first to the last in mm.
    fn push_all(&mut self, parts: Vec<(Part<'_>, f64)>) -> f64 {
        let mut depth = 0.0;
        for (part, distance) in parts {
            if let Some(radius) = self.beam.take().filter(|_| !part.screen) {
                self.entrance(&part.path, radius);
            }
            self.push(part);
            self.advance(distance);
            depth += distance;
        }
        depth
    }

    /// The stop of a beam of this radius before the first surface.
    fn entrance(&mut self, path: &str, radius: f64) {
        self.push(Part {
            path: path.to_owned(),
            name: Some("beam"),
            action: Action::Border,
            curve: Curve::default(),
            phase: Vec::new(),
            reflects: false,
            behind: None,
            open: disc(radius),
            screen: true,
        });
    }

    fn push(&mut self, part: Part<'_>) {
        let blocked = part.open.blocked.clone();
        let outline = Aperture {
            blocked: Vec::new(),
            ..part.open
        };
        // The rim of a lens or mirror is its semi-diameter; other apertures clip by themselves.
        let edge = LensEdge::of(&outline);
        let rim = edge.filter(|edge| edge.is_centred_circle() && !edge.wider && !part.screen);
        if let Some(behind) = part.behind {
            self.inside = behind;
        }
        let number = self.laid.surface.len();
        self.laid.surface.push(Face {
            number,
            line: 0,
            comment: part.name.unwrap_or_default().to_owned(),
            action: part.action,
            thickness_mm: 0.0,
            curve: part.curve,
            phase: part.phase,
            grid: None,
            behind: match part.reflects {
                true => Behind::Reflected,
                false => behind(&self.inside),
            },
            semi_diameter: rim.map(|edge| (edge.radius(), true)),
            clips: false,
            outline: (rim.is_none() && edge.is_some()).then_some(outline),
            blocked,
        });
        self.laid.media.push(self.inside.clone());
        self.laid.path.push(part.path);
    }

    /// Turns the axis, which goes on by a distance in mm.
    fn turn(&mut self, path: &str, turn: Turn, along: f64) {
        let number = self.laid.surface.len();
        self.laid.surface.push(Face {
            thickness_mm: along,
            behind: behind(&self.inside),
            ..Face::turned([number, 0], turn)
        });
        self.laid.media.push(self.inside.clone());
        self.laid.path.push(path.to_owned());
    }

    fn advance(&mut self, distance: f64) {
        if let Some(last) = self.laid.surface.last_mut() {
            last.thickness_mm += distance;
        }
    }

    /// The image, on the axis where the sensor is only shifted.
    fn sensor(&mut self, path: &str, sensor: &SensorElement, there: Turn) {
        let [nx, ny] = sensor.pixels;
        let [dx, dy] = sensor.pitch_um;
        let half = [nx as f64 * dx, ny as f64 * dy].map(|width| 0.5e-3 * width);
        let [x, y] = there.decenter_mm;
        if there.tilt_deg != [0.0; 3] {
            self.turn(path, there, 0.0);
        } else if [x, y] != [0.0; 2] {
            self.losses.change(format!(
                "The image stands on the axis; the middle of the sensor is at ({x}, {y}) mm on it."
            ));
        }
        self.losses.leave_out(format!(
            "The pixels of the sensor: {nx} × {ny} of {dx} × {dy} µm."
        ));
        self.laid.sensor_mm = half[0].hypot(half[1]) + x.hypot(y);
        self.push(Part {
            path: path.to_owned(),
            name: sensor.name.as_deref(),
            action: Action::Border,
            curve: Curve::default(),
            phase: Vec::new(),
            reflects: false,
            behind: None,
            open: Aperture::default(),
            screen: true,
        });
    }
}

fn curve(shape: &SurfaceShape<'_>) -> Curve {
    Curve {
        curvature: shape.radius_mm.map_or(0.0, |radius| 1.0 / radius),
        conic: shape.conic,
        aspheric: shape.aspheric.to_vec(),
        shape: shape.shape.cloned(),
    }
}

fn open(rim: &Rim<'_>) -> Aperture {
    match (rim.aperture, rim.semi_aperture_mm) {
        (Some(aperture), _) => aperture.clone(),
        (None, Some(radius)) => disc(radius),
        (None, None) => Aperture::default(),
    }
}

/// What follows a surface, as a prescription has it.
fn behind(medium: &MediumBehind) -> Behind {
    match &medium.material {
        None => Behind::Air,
        Some(material) => Behind::Glass(GlassRequest {
            line: 0,
            name: match material {
                Material::Named(name) => name.clone(),
                Material::Own(own) => own.to_string(),
            },
            maker: None,
            code: None,
            own: None,
        }),
    }
}
