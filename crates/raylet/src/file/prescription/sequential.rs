//! A sequential prescription: what any program for lens design writes down of a lens, in millimetres, whatever its format.

use crate::file::prescription::face_grid::{FaceGrid, GridKind};
use crate::file::scene::aperture::Aperture;
use crate::file::scene::layer::Layer;
use crate::file::scene::material::OwnMedium;
use crate::file::scene::surface_shape::{Shape, Straight};
use crate::optics::zernike::ZernikeSum;

/// A lens as a list of surfaces, with its light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sequential {
    /// What the file calls it.
    pub title: String,
    /// The surfaces; the first is the object and the last the image.
    pub surface: Vec<Face>,
    /// Number of the aperture stop among them.
    pub stop: usize,
    /// What says how wide the light is.
    pub aperture: ApertureRule,
    /// What the numbers of a field are.
    pub field_kind: FieldKind,
    /// The fields [x, y], in degrees or mm.
    pub field: Vec<[f64; 2]>,
    /// The wavelengths in µm.
    pub wavelength_um: Vec<f64>,
    /// Number of the primary wavelength among them.
    pub primary: usize,
    /// Catalogues in which glasses are sought, in this order.
    pub catalogues: Vec<String>,
    /// The surface whose distance to the next is to be that of the paraxial image, at the primary wavelength.
    pub focused: Option<usize>,
}

/// What says how wide the light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ApertureRule {
    /// Diameter of the entrance pupil in mm.
    EntrancePupil(f64),
    /// Focal length over the diameter of the entrance pupil.
    ImageFNumber(f64),
    /// 1 over twice the slope of the paraxial marginal ray at the image, times the index there.
    WorkingFNumber(f64),
    /// Sine of the half angle at the object, in air.
    ObjectSine(f64),
    /// The stop is as wide as the semi-diameter of its surface.
    StopSize,
}

/// What the numbers of a field are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FieldKind {
    /// Angles in degrees whose tangents are the slopes of the chief ray.
    Angle,
    /// The place of the object in mm.
    ObjectHeight,
    /// The place of the paraxial image in mm.
    ImageHeight,
    /// The place where the real chief ray meets the image, in mm.
    RealImageHeight,
}

/// A surface of a prescription.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Face {
    /// Its number in the file.
    pub number: usize,
    /// The line of the file where it begins.
    pub line: usize,
    /// What the file calls it.
    pub comment: String,
    /// What it does to the light or to the axis.
    pub action: Action,
    /// Distance to the next surface in mm; infinite before the first surface of a lens for distant objects.
    pub thickness_mm: f64,
    /// Its curve.
    pub curve: Curve,
    /// Phases of a diffractive element on it.
    pub phase: Vec<Layer>,
    /// Values on a grid that its curve or its phase names.
    pub grid: Option<FaceGrid>,
    /// What follows it.
    pub behind: Behind,
    /// Its semi-diameter in mm, and whether the user fixed it.
    pub semi_diameter: Option<(f64, bool)>,
    /// Whether its semi-diameter clips light where it does nothing else, and where it is the stop.
    pub clips: bool,
    /// The outline of its aperture, where it has one of its own.
    pub outline: Option<Aperture>,
    /// What is blocked in it.
    pub blocked: Vec<Aperture>,
}

/// What a surface does to the light or to the axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    /// A border between two media, or none.
    Border,
    /// An ideal thin lens of this focal length in mm.
    IdealLens(f64),
    /// A new axis for all that follows.
    Turn(Turn),
}

/// A shift and turns of the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turn {
    /// The shift along x and y in mm.
    pub decenter_mm: [f64; 2],
    /// The shift along z in mm, at the same time.
    pub along_mm: f64,
    /// The turns about x, y and z in degrees, right-handed, each about the axes as the one before left them.
    pub tilt_deg: [f64; 3],
    /// Whether the turns come first, about z, then y, then x, and the shift after them.
    pub tilt_first: bool,
}

/// The curve of a surface, as scene files describe it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Curve {
    /// Curvature at the vertex in 1/mm.
    pub curvature: f64,
    /// Conic constant.
    pub conic: f64,
    /// Coefficients of r⁴, r⁶, … in mm⁻³, mm⁻⁵, …
    pub aspheric: Vec<f64>,
    /// What replaces them or is added to them.
    pub shape: Option<Shape>,
}

/// What follows a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Behind {
    /// Air.
    Air,
    /// The medium before it: the surface reflects.
    Reflected,
    /// A glass.
    Glass(GlassRequest),
}

/// A glass as a file asks for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GlassRequest {
    /// The line of the file.
    pub line: usize,
    /// Its name; empty where numbers alone say what it is.
    pub name: String,
    /// The maker that the file names with it; a name without one is sought in the catalogues of the file.
    pub maker: Option<String>,
    /// Index at the d line and Abbe number, where the file states them; an Abbe number of zero stands for none.
    pub code: Option<[f64; 2]>,
    /// Its indices, where the file itself has them.
    pub own: Option<Box<OwnMedium>>,
}

impl Face {
    /// A surface that only turns the axis, of this number and line.
    pub(crate) fn turned([number, line]: [usize; 2], turn: Turn) -> Self {
        Self {
            number,
            line,
            comment: String::new(),
            action: Action::Turn(turn),
            thickness_mm: 0.0,
            curve: Curve::default(),
            phase: Vec::new(),
            grid: None,
            behind: Behind::Air,
            semi_diameter: None,
            clips: false,
            outline: None,
            blocked: Vec::new(),
        }
    }
}

impl Face {
    /// The second derivative by y of its grid in the middle, where it has one of this kind: in 1/mm of heights, in rad/mm² of phases.
    pub(crate) fn grid_curvature(&self, kind: GridKind) -> f64 {
        let grid = self.grid.as_ref().filter(|grid| grid.kind == kind);
        let unit = match kind {
            GridKind::Sag => 1e-3,
            GridKind::Phase => 1.0,
        };
        grid.map_or(0.0, |grid| unit * grid.curvature_y())
    }
}

impl Curve {
    /// Radius of curvature in mm; none for a plane.
    pub(crate) fn radius_mm(&self) -> Option<f64> {
        (self.curvature != 0.0).then(|| 1.0 / self.curvature)
    }

    /// Curvature at the vertex along y in 1/mm, with what the shape adds.
    pub(crate) fn vertex_curvature(&self) -> f64 {
        let of_radius = |radius: Option<f64>| radius.map_or(0.0, |radius| 1.0 / radius);
        match &self.shape {
            Some(Shape::Biconic(one)) => of_radius(one.radius_y_mm),
            Some(Shape::Toroid(one)) => of_radius(one.radius_mm),
            Some(Shape::Cylinder(one)) => match one.straight_along {
                Straight::X => of_radius(one.radius_mm),
                Straight::Y => 0.0,
            },
            Some(Shape::Odd(sum)) => {
                self.curvature + 2.0 * sum.coefficients.get(1).copied().unwrap_or(0.0)
            }
            Some(Shape::Polynomial(sum)) => {
                let squares = sum.terms.iter().filter(|term| (term.x, term.y) == (0, 2));
                let height_um: f64 = squares.map(|term| term.height_um).sum();
                self.curvature + 2e-3 * height_um / sum.norm_radius_mm.powi(2)
            }
            Some(Shape::Zernike(sum)) => {
                let sum = ZernikeSum::new(sum.norm_radius_mm, sum.coefficients_um.clone());
                self.curvature + 1e-3 * sum.curvature_y()
            }
            _ => self.curvature,
        }
    }
}

impl Sequential {
    /// Number of the image among the surfaces.
    pub(crate) fn image(&self) -> usize {
        self.surface.len().saturating_sub(1)
    }

    /// The distance from the object to the first surface in mm, where it is finite.
    pub(crate) fn object_distance(&self) -> Option<f64> {
        let distance = self.surface.first().map(|object| object.thickness_mm);
        distance.filter(|distance| distance.is_finite())
    }
}
