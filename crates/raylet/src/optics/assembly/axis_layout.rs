//! Where parts stand along an axis, and the screens and trains that they make.
//!
//! The axis starts at the global origin along +z. Tilts turn it for what follows; mirrors turn the light back, so that
//! distances behind an odd number of mirrors are negative. Scene files and [`SystemBuilder`] both lay their parts here.
//!
//! [`SystemBuilder`]: crate::optics::assembly::system_builder::SystemBuilder

use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::frame::Frame;
use crate::optics::refraction::{Coating, Interface};
use crate::optics::screen::{MediumBehind, Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::source::Source;
use crate::optics::surface::Surface;
use crate::optics::system::System;

/// A surface where it stands: what a ray meets, whatever happens to it there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedShape {
    /// Its shape in its own frame.
    pub shape: Shape,
    /// Where it stands.
    pub frame: Frame,
    /// The part of it that is used.
    pub aperture: Aperture,
}

/// The axis as it is laid, part by part.
#[derive(Clone, Debug)]
pub(crate) struct AxisLayout {
    axis: Frame,
    /// +1 while light runs towards the axis's +z, −1 after an odd number of mirrors.
    towards: f64,
    /// Index of the medium the light is in.
    index: f64,
    beam_radius: Option<f64>,
    screens: Vec<Screen>,
    trains: Vec<Vec<Surface>>,
}

impl AxisLayout {
    /// An axis without parts, in a medium of this index. The light has the radius `beam_radius` in mm where no
    /// aperture limits it.
    pub(crate) fn new(index: f64, beam_radius: Option<f64>) -> Self {
        Self {
            axis: Frame::GLOBAL,
            towards: 1.0,
            index,
            beam_radius,
            screens: Vec::new(),
            trains: Vec::new(),
        }
    }

    /// Index of the medium that the light is in, behind the last part.
    pub(crate) fn index(&self) -> f64 {
        self.index
    }

    /// +1 where light runs towards the axis's +z, −1 behind an odd number of mirrors.
    pub(crate) fn towards(&self) -> f64 {
        self.towards
    }

    /// Whether no part has met the light yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.screens.is_empty()
    }

    /// Where a part stands that is moved by `decentre` mm aside of the axis and then turned by `tilt` rad.
    pub(crate) fn frame(&self, [dx, dy]: [f64; 2], tilt: [f64; 3]) -> Frame {
        self.axis.moved(Vec3::new(dx, dy, 0.0)).tilted(tilt)
    }

    /// Lets the axis go on from this frame.
    pub(crate) fn turn(&mut self, frame: Frame) {
        self.axis = frame;
    }

    /// Goes on along the axis by `distance` mm.
    pub(crate) fn advance(&mut self, distance: f64) {
        self.axis = self.axis.moved(Vec3::new(0.0, 0.0, distance));
    }

    /// Adds a screen. Where it reflects, light turns back.
    pub(crate) fn screen(&mut self, name: String, frame: Frame, shape: Shape, kind: ScreenKind) {
        if !self.screens.is_empty() && self.trains.len() < self.screens.len() {
            self.trains.push(Vec::new());
        }
        let screen = Screen {
            name,
            frame,
            shape,
            kind,
            index: self.index,
            behind: None,
            arrives: self.towards,
        };
        self.towards = screen.leaves();
        self.screens.push(screen);
    }

    /// Puts the last screen on an interface: this medium is behind it.
    pub(crate) fn enter_medium(&mut self, behind: MediumBehind) {
        if let Some(screen) = self
            .screens
            .last_mut()
            .filter(|_| behind.index != self.index)
        {
            screen.behind = Some(behind);
            self.index = behind.index;
        }
    }

    /// Adds a surface that light crosses into a medium of the index `behind`.
    pub(crate) fn refract(&mut self, face: PlacedShape, coating: Coating, behind: f64) {
        self.enter(&face);
        let before = std::mem::replace(&mut self.index, behind);
        self.surface(face, Interface::Refract, coating, [before, behind]);
    }

    /// Adds a mirror: light turns back.
    pub(crate) fn reflect(&mut self, face: PlacedShape) {
        self.enter(&face);
        let index = [self.index; 2];
        self.surface(face, Interface::Reflect, Coating::Ideal, index);
        self.towards = -self.towards;
    }

    /// Where the first screen stands; the light's phase is zero at its vertex.
    pub(crate) fn start(&self) -> Frame {
        let first = self.screens.first();
        first.map_or(Frame::GLOBAL, |screen| screen.frame)
    }

    /// The system of these parts at a vacuum wavelength in mm.
    pub(crate) fn into_system(self, wavelength: f64, source: Source) -> System {
        System {
            wavelength,
            source,
            screens: self.screens,
            trains: self.trains,
        }
    }

    /// Where light meets a surface first, an aperture of the beam's radius (or the surface's own) stands
    /// before it: the field has to live on some screen.
    fn enter(&mut self, face: &PlacedShape) {
        if self.screens.is_empty() {
            let beam = self.beam_radius.map(Aperture::disc);
            let kind = ScreenKind::Stop(beam.unwrap_or_else(|| face.aperture.clone()));
            self.screen(String::from("entrance"), face.frame, Shape::Plane, kind);
        }
    }

    fn surface(
        &mut self,
        face: PlacedShape,
        interface: Interface,
        coating: Coating,
        index: [f64; 2],
    ) {
        if self.trains.len() < self.screens.len() {
            self.trains.push(Vec::new());
        }
        if let Some(train) = self.trains.last_mut() {
            train.push(Surface {
                shape: face.shape,
                frame: face.frame,
                aperture: face.aperture,
                interface,
                coating,
                index,
            });
        }
    }
}
