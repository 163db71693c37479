//! The parts of a [`SystemBuilder`], checked and laid on the axis one by one.
//!
//! [`SystemBuilder`]: crate::optics::assembly::system_builder::SystemBuilder

use crate::optics::aperture::Aperture;
use crate::optics::assembly::axis_layout::{AxisLayout, PlacedShape};
use crate::optics::assembly::glass::Glass;
use crate::optics::assembly::part_check::{
    Mismatch, check_aperture, check_element, check_face, check_finite, check_heading, check_places,
    check_sensor, check_transmits,
};
use crate::optics::doe::Doe;
use crate::optics::frame::Frame;
use crate::optics::refraction::Coating;
use crate::optics::screen::{MediumBehind, ScreenKind, Sensor};
use crate::optics::shape::Shape;

/// One call of the builder: lengths in mm, angles in rad.
#[derive(Clone, Debug)]
pub(crate) enum BuilderCall {
    Gap(f64),
    /// The next part is moved aside and turned.
    Offset([f64; 2], [f64; 3]),
    /// The axis is moved aside and turned.
    Turn([f64; 2], [f64; 3]),
    Surface(Shape, Aperture, Glass),
    Mirror(Shape, Aperture),
    Stop(Aperture),
    /// Where it stands on an interface, with the medium behind it.
    Element(String, Shape, Doe, Option<Glass>),
    Sensor(Sensor),
}

impl BuilderCall {
    fn kind(&self) -> &'static str {
        match self {
            BuilderCall::Gap(_) => "gap",
            BuilderCall::Offset(..) => "offset",
            BuilderCall::Turn(..) => "turn",
            BuilderCall::Surface(..) => "surface",
            BuilderCall::Mirror(..) => "mirror",
            BuilderCall::Stop(_) => "stop",
            BuilderCall::Element(..) => "element",
            BuilderCall::Sensor(_) => "sensor",
        }
    }
}

/// What a part is called in errors: its name, or its kind and its number among the parts of that kind.
pub(crate) fn address(parts: &[BuilderCall], number: usize) -> String {
    let up_to = || parts.iter().take(number + 1);
    match up_to().next_back() {
        Some(BuilderCall::Element(name, ..)) => format!("element '{name}'"),
        Some(part) => {
            let alike = up_to().filter(|other| other.kind() == part.kind());
            format!("{} {}", part.kind(), alike.count())
        }
        None => String::from("no part"),
    }
}

/// Index of a medium at a vacuum wavelength in mm.
pub(crate) fn glass_index(glass: &Glass, wavelength: f64) -> Result<f64, Mismatch> {
    let index = glass.index(wavelength);
    index.map_err(|found| Mismatch::new(found, "a medium that is known at the wavelength"))
}

/// The axis while parts are laid on it.
pub(crate) struct Laying {
    axis: AxisLayout,
    wavelength: f64,
    coating: Coating,
    beam_radius: Option<f64>,
    /// How the next part is moved and turned.
    next: Option<([f64; 2], [f64; 3])>,
    /// Whether the sensor stands.
    ended: bool,
}

impl Laying {
    /// An axis without parts in a medium of the index `ambient`.
    pub(crate) fn new(
        wavelength: f64,
        coating: Coating,
        beam_radius: Option<f64>,
        ambient: f64,
    ) -> Self {
        Self {
            axis: AxisLayout::new(ambient, beam_radius),
            wavelength,
            coating,
            beam_radius,
            next: None,
            ended: false,
        }
    }

    /// Puts an element that makes the light so far before the first part in mm.
    pub(crate) fn lay_source(&mut self, element: Doe, distance: f64) {
        self.axis.advance(-distance);
        let frame = self.axis.frame([0.0; 2], [0.0; 3]);
        let (name, kind) = (String::from("source"), ScreenKind::Doe(element));
        self.axis.screen(name, frame, Shape::Plane, kind);
        self.axis.advance(distance);
    }

    /// Checks a part and adds it.
    pub(crate) fn lay(&mut self, part: &BuilderCall) -> Result<(), Mismatch> {
        if self.ended {
            let found = "a part behind the sensor";
            return Err(Mismatch::new(found, "the sensor as the last part"));
        }
        match part {
            BuilderCall::Gap(distance) => {
                check_heading(*distance, self.axis.towards())?;
                self.axis.advance(*distance);
            }
            BuilderCall::Offset(decentre, tilt) => {
                check_finite(decentre, tilt)?;
                self.next = Some((*decentre, *tilt));
            }
            BuilderCall::Turn(decentre, tilt) => {
                check_finite(decentre, tilt)?;
                self.axis.turn(self.axis.frame(*decentre, *tilt));
            }
            BuilderCall::Surface(shape, aperture, behind) => {
                let face = self.face(shape, aperture)?;
                let behind = glass_index(behind, self.wavelength)?;
                self.axis.refract(face, self.coating, behind);
            }
            BuilderCall::Mirror(shape, aperture) => {
                let face = self.face(shape, aperture)?;
                self.axis.reflect(face);
            }
            BuilderCall::Stop(aperture) => {
                check_aperture(aperture)?;
                self.limit(
                    String::from("stop"),
                    Shape::Plane,
                    ScreenKind::Stop(aperture.clone()),
                )?;
            }
            BuilderCall::Element(name, shape, doe, behind) => {
                check_element(doe)?;
                check_places(shape, doe)?;
                let (shape, kind) = (shape.clone(), ScreenKind::Doe(doe.clone()));
                match behind {
                    None => self.limit(name.clone(), shape, kind)?,
                    Some(behind) => {
                        check_transmits(doe)?;
                        let behind = MediumBehind {
                            index: glass_index(behind, self.wavelength)?,
                            coating: self.coating,
                        };
                        self.check_beam()?;
                        let frame = self.frame();
                        self.axis.screen(name.clone(), frame, shape, kind);
                        self.axis.enter_medium(behind);
                    }
                }
            }
            BuilderCall::Sensor(sensor) => self.sensor(*sensor)?,
        }
        Ok(())
    }

    /// The axis with all its parts.
    pub(crate) fn end(self) -> Result<AxisLayout, Mismatch> {
        match self.ended {
            true => Ok(self.axis),
            false => Err(Mismatch::new("no sensor", "one as the last part")),
        }
    }

    fn frame(&mut self) -> Frame {
        let (decentre, tilt) = self.next.take().unwrap_or_default();
        self.axis.frame(decentre, tilt)
    }

    fn face(&mut self, shape: &Shape, aperture: &Aperture) -> Result<PlacedShape, Mismatch> {
        check_face(shape, aperture)?;
        Ok(PlacedShape {
            shape: shape.clone(),
            frame: self.frame(),
            aperture: aperture.clone(),
        })
    }

    /// A stop or element in one medium.
    fn limit(&mut self, name: String, shape: Shape, kind: ScreenKind) -> Result<(), Mismatch> {
        self.check_beam()?;
        let frame = self.frame();
        self.axis.screen(name, frame, shape, kind);
        Ok(())
    }

    /// A beam radius has no use where a stop or element meets the light first.
    fn check_beam(&self) -> Result<(), Mismatch> {
        if let Some(radius) = self.beam_radius.filter(|_| self.axis.is_empty()) {
            return Err(Mismatch::new(
                format!("a beam radius of {radius} mm, though this part meets the light first"),
                "no beam radius: the aperture of this part limits the light",
            ));
        }
        Ok(())
    }

    fn sensor(&mut self, sensor: Sensor) -> Result<(), Mismatch> {
        check_sensor(&sensor)?;
        if self.axis.is_empty() {
            let found = "a sensor as the only part";
            let expected = "at least one part before the sensor";
            return Err(Mismatch::new(found, expected));
        }
        let frame = self.frame();
        let name = String::from("sensor");
        self.axis
            .screen(name, frame, Shape::Plane, ScreenKind::Sensor(sensor));
        self.ended = true;
        Ok(())
    }
}
