//! The elements of a scene from the surfaces of a prescription.

use std::collections::BTreeSet;

use crate::file::decode::fault::Fault;
use crate::file::prescription::element_parts::{
    disc, height, hollow, name, rim, set_thickness, widen,
};
use crate::file::prescription::first_order::FirstOrder;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::rim_sizes::Rims;
use crate::file::prescription::sequential::{Action, Behind, Face, Sequential, Turn};
use crate::file::scene::aperture::Aperture;
use crate::file::scene::element::{
    CoordinateBreak, Coordinates, DoeElement, Element, MirrorElement, ParaxialLens, StopElement,
    SurfaceElement,
};
use crate::file::scene::material::{Material, air};
use crate::optics::assembly::part_check::expected_heading;

/// How much wider than the light the aperture before a lens is.
const WIDER: f64 = 1.25;

/// Elements in the order light meets them, without the sensor.
#[derive(Clone, Debug)]
pub(crate) struct Elements {
    /// The elements.
    pub element: Vec<Element>,
    /// The line of the file that each comes from.
    pub line: Vec<usize>,
    /// Position of the first one, from the first surface of the file in mm.
    pub start: f64,
}

/// What elements are made of.
pub(crate) struct Laying<'a> {
    /// The prescription.
    pub lens: &'a Sequential,
    /// The media behind its surfaces.
    pub media: &'a [MediumBehind],
    /// Its first-order data.
    pub first: &'a FirstOrder,
    /// Slopes of the chief ray of the field that the scene has.
    pub slopes: [f64; 2],
    /// The largest slope of any field.
    pub steepest: f64,
    /// How wide rims are that the file does not fix.
    pub rims: Rims,
}

impl Laying<'_> {
    /// The elements of all surfaces between object and image.
    ///
    /// # Errors
    /// A surface that has no counterpart, with its line.
    pub(crate) fn elements(&self, text: &LensText, losses: &mut Losses) -> Result<Elements, Fault> {
        let mut laid = Elements {
            element: Vec::new(),
            line: Vec::new(),
            start: 0.0,
        };
        let mut names = BTreeSet::from(["sensor".to_owned(), "aperture".to_owned()]);
        for (i, face) in self.lens.surface.iter().enumerate().skip(1) {
            if i == self.lens.image() {
                break;
            }
            if let Action::Turn(turn) = face.action {
                if i == self.lens.stop {
                    let found = "the stop on a coordinate break";
                    return Err(text.fault_of_line(face.line, found, "a stop on a surface"));
                }
                for part in breaks(turn) {
                    laid.push(Element::CoordinateBreak(part), face.line);
                }
            } else if let Some(mut element) = self.element(i, face, text, losses)? {
                name(&mut element, self.word(i, face, &mut names));
                match self.own_stop(i, &mut element, &laid, losses) {
                    Some((stop, before)) if before => {
                        laid.advance(-stop.thickness_mm.unwrap_or(0.0));
                        laid.push(Element::Stop(stop), face.line);
                        laid.push(element, face.line);
                    }
                    Some((stop, _)) => {
                        set_thickness(&mut element, -stop.thickness_mm.unwrap_or(0.0));
                        laid.push(element, face.line);
                        laid.push(Element::Stop(stop), face.line);
                    }
                    None => laid.push(element, face.line),
                }
            }
            laid.advance(face.thickness_mm);
        }
        if !laid.begins_with_stop(self.lens) {
            self.put_aperture_before(&mut laid, losses);
        }
        laid.keep_headings(losses);
        Ok(laid)
    }

    /// The element of a surface; none where it does nothing.
    fn element(
        &self,
        i: usize,
        face: &Face,
        text: &LensText,
        losses: &mut Losses,
    ) -> Result<Option<Element>, Fault> {
        let (Some(before), Some(behind)) = (self.media.get(i - 1), self.media.get(i)) else {
            return Ok(None);
        };
        let crosses = before.material != behind.material;
        if let Action::IdealLens(focal_length_mm) = face.action {
            if crosses {
                let found = "an ideal lens between two media";
                let expected = "the same medium on both sides";
                return Err(text.fault_of_line(face.line, found, expected));
            }
            let lens = self.ideal_lens(i, face, focal_length_mm, losses);
            return Ok(Some(Element::ParaxialLens(lens)));
        }
        if !face.phase.is_empty() {
            return Ok(Some(Element::Doe(self.doe(i, face, crosses, losses))));
        }
        let curve = face.curve.clone();
        let (semi_aperture_mm, aperture) = rim(self.aperture(i, face, losses));
        if face.behind == Behind::Reflected {
            return Ok(Some(Element::Mirror(MirrorElement {
                name: None,
                tilt_deg: [0.0; 3],
                decenter_mm: [0.0; 2],
                thickness_mm: Some(0.0),
                radius_mm: curve.radius_mm(),
                conic: curve.conic,
                aspheric: curve.aspheric,
                shape: curve.shape,
                semi_aperture_mm,
                aperture,
            })));
        }
        if crosses {
            return Ok(Some(Element::Surface(SurfaceElement {
                name: None,
                tilt_deg: [0.0; 3],
                decenter_mm: [0.0; 2],
                thickness_mm: Some(0.0),
                radius_mm: curve.radius_mm(),
                conic: curve.conic,
                aspheric: curve.aspheric,
                shape: curve.shape,
                semi_aperture_mm,
                aperture,
                glass: self.material(behind),
                coating: None,
            })));
        }
        Ok(self.screen(i, face, losses))
    }

    /// The medium behind a surface; none for air, unless the object is in another medium.
    fn material(&self, behind: &MediumBehind) -> Option<Material> {
        let object = self
            .media
            .first()
            .and_then(|medium| medium.material.as_ref());
        let named = behind.material.clone();
        named.or_else(|| object.map(|_| air()))
    }

    fn ideal_lens(
        &self,
        i: usize,
        face: &Face,
        focal_length_mm: f64,
        losses: &mut Losses,
    ) -> ParaxialLens {
        ParaxialLens {
            name: None,
            tilt_deg: [0.0; 3],
            decenter_mm: [0.0; 2],
            thickness_mm: Some(0.0),
            focal_length_mm,
            aperture: self.aperture(i, face, losses),
        }
    }

    /// A surface between equal media is a stop if it is the aperture stop or has an aperture of its own, and nothing else.
    fn screen(&self, i: usize, face: &Face, losses: &mut Losses) -> Option<Element> {
        let rimmed = face.clips && face.semi_diameter.is_some();
        let own = rimmed || face.outline.is_some() || !face.blocked.is_empty();
        let cuts = i == self.lens.stop || own;
        if cuts && face.curve.vertex_curvature() != 0.0 {
            losses.change(format!(
                "Surface {}: a curved stop between equal media is a plane one at its vertex.",
                face.number
            ));
        }
        cuts.then(|| {
            Element::Stop(StopElement {
                name: None,
                tilt_deg: [0.0; 3],
                decenter_mm: [0.0; 2],
                thickness_mm: Some(0.0),
                aperture: self.aperture(i, face, losses),
            })
        })
    }

    /// A surface with a phase, on an interface or between equal media.
    fn doe(&self, i: usize, face: &Face, crosses: bool, losses: &mut Losses) -> DoeElement {
        let curve = face.curve.clone();
        let behind = self.media.get(i).and_then(|medium| medium.material.clone());
        DoeElement {
            name: None,
            tilt_deg: [0.0; 3],
            decenter_mm: [0.0; 2],
            thickness_mm: Some(0.0),
            radius_mm: curve.radius_mm(),
            conic: curve.conic,
            aspheric: curve.aspheric,
            shape: curve.shape,
            aperture: self.aperture(i, face, losses),
            glass: crosses.then(|| behind.unwrap_or_else(air)),
            coating: None,
            reflect: face.behind == Behind::Reflected,
            coordinates: Coordinates::default(),
            layer: face.phase.clone(),
        }
    }

    /// The open part of a surface.
    fn aperture(&self, i: usize, face: &Face, losses: &mut Losses) -> Aperture {
        let own = face.outline.clone();
        let open = match own {
            _ if i == self.lens.stop => self.stop_aperture(face, losses),
            Some(own) => own,
            None => disc(self.semi_diameter(i, face, losses)),
        };
        Aperture {
            blocked: face.blocked.clone(),
            ..open
        }
    }

    /// The stop is as wide as the light that the file asks for, unless an aperture of its own is smaller.
    fn stop_aperture(&self, face: &Face, losses: &mut Losses) -> Aperture {
        let radius = self.first.stop_radius;
        match &face.outline {
            None => disc(self.stop_radius(face, losses)),
            Some(Aperture {
                disc: Some(own), ..
            }) if own.centre_mm == [0.0; 2] && own.radius_mm >= radius => disc(radius),
            Some(own) => {
                losses.change(format!(
                    "Surface {}: the stop is the aperture that the file gives to its surface, and the light does not fill the \
                     pupil that the file asks for ({radius:.6} mm in radius at the stop).",
                    face.number
                ));
                own.clone()
            }
        }
    }

    /// The radius of a stop without an outline in mm: that of the light, or of a smaller rim that clips it.
    fn stop_radius(&self, face: &Face, losses: &mut Losses) -> f64 {
        let radius = self.first.stop_radius;
        match face.semi_diameter {
            // Files write sizes with some digits, and the light is computed.
            Some((rim, _)) if face.clips && rim < radius * (1.0 - 1e-6) => {
                losses.change(format!(
                    "Surface {}: its aperture of radius {rim:.6} mm is the stop, and cuts the light that the file asks for \
                     ({radius:.6} mm in radius there).",
                    face.number
                ));
                rim
            }
            _ => radius,
        }
    }

    /// A stop of its own for an aperture stop on a surface behind other parts, in the plane of the rim of the light there, so
    /// that its edge diffracts; and whether it stands before the surface. Its thickness leads to the vertex.
    fn own_stop(
        &self,
        i: usize,
        element: &mut Element,
        laid: &Elements,
        losses: &mut Losses,
    ) -> Option<(StopElement, bool)> {
        let face = self.lens.surface.get(i)?;
        let plain = face.outline.is_none() && face.blocked.is_empty();
        let bends = matches!(element, Element::Surface(_) | Element::Mirror(_));
        if i != self.lens.stop || laid.element.is_empty() || !bends || !plain {
            return None;
        }
        let (radius, heading) = (self.stop_radius(face, losses), laid.heading());
        let rim = height(element, radius)? * heading;
        let place = if rim <= 0.0 {
            // The light meets the rim before the vertex.
            (laid.room() >= -rim).then_some((rim, true))?
        } else if element.reflects() || face.thickness_mm * heading < rim {
            (0.0, true)
        } else {
            (rim, false)
        };
        let semi_diameter = face.semi_diameter.map_or(0.0, |(size, _)| size);
        widen(element, semi_diameter.max(1.05 * radius));
        let mut called = format!("stop on surface {}", face.number);
        if element.name() == Some("stop") {
            called = "stop".to_owned();
            name(element, format!("surface {}", face.number));
        }
        let (at, before) = place;
        losses.change(format!(
            "Surface {}: the stop of radius {radius:.6} mm on it is a plane one at the edge of the light, {:.6} mm from its \
             vertex.",
            face.number,
            at * heading
        ));
        let stop = StopElement {
            name: Some(called),
            tilt_deg: [0.0; 3],
            decenter_mm: [0.0; 2],
            thickness_mm: Some(-at * heading),
            aperture: disc(radius),
        };
        Some((stop, before))
    }

    /// The radius of a rim in mm.
    fn semi_diameter(&self, i: usize, face: &Face, losses: &mut Losses) -> f64 {
        match face.semi_diameter {
            Some((size, true)) => size,
            Some((size, false)) => {
                if self.rims.computed > 1.0 {
                    losses.change(
                        "Semi-diameters that the file computed from the light of its fields are 5 % wider, so that they cut none \
                         of it; fixed ones are kept.",
                    );
                }
                size * self.rims.computed
            }
            None => {
                let [marginal, chief] = self.first.heights(i, [self.steepest, 0.0]);
                let light = self.rims.missing * (marginal + chief);
                losses.change(self.rims.sentence());
                light.max(0.1 * self.first.pupil_diameter)
            }
        }
    }

    /// What an element is called.
    fn word(&self, i: usize, face: &Face, names: &mut BTreeSet<String>) -> String {
        let comment: String = face.comment.chars().filter(|c| !c.is_control()).collect();
        let plain = match comment.trim() {
            "" if i == self.lens.stop => "stop".to_owned(),
            "" => format!("surface {}", face.number),
            comment => comment.to_owned(),
        };
        let name = match names.contains(&plain) {
            true => format!("{plain} (surface {})", face.number),
            false => plain,
        };
        names.insert(name.clone());
        name
    }

    /// An aperture before all elements, wider than the light that goes through the stop.
    fn put_aperture_before(&self, laid: &mut Elements, losses: &mut Losses) {
        let [marginal, chief] = self.first.heights(1, self.slopes);
        let radius = WIDER * (marginal + chief);

        // Before the rim of a surface that is hollow towards the light.
        let depth = laid
            .element
            .first()
            .map_or(0.0, |first| hollow(first, radius));
        let mut gap = laid.start.max(depth + 0.1 * radius);
        if let Some(object) = self.lens.object_distance() {
            gap = gap.min(0.5 * (object + laid.start));
        }
        laid.start -= gap;
        losses.change(format!(
            "An aperture of radius {radius:.6} mm stands {gap:.6} mm before the first element, a quarter wider than the \
             paraxial light of the field: raylet takes the light from there to the stop."
        ));
        laid.element.insert(
            0,
            Element::Stop(StopElement {
                name: Some("aperture".to_owned()),
                tilt_deg: [0.0; 3],
                decenter_mm: [0.0; 2],
                thickness_mm: Some(gap),
                aperture: disc(radius),
            }),
        );
        laid.line
            .insert(0, self.lens.surface.get(1).map_or(1, |face| face.line));
    }
}

impl Elements {
    fn push(&mut self, element: Element, line: usize) {
        self.element.push(element);
        self.line.push(line);
    }

    /// +1 where light runs towards the axis's +z behind the last element, −1 where it runs back.
    fn heading(&self) -> f64 {
        let mirrors = self.element.iter().filter(|element| element.reflects());
        if mirrors.count() % 2 == 0 { 1.0 } else { -1.0 }
    }

    /// How far a part may stand before the end of the axis, along the way of the light in mm.
    fn room(&self) -> f64 {
        match self.element.last() {
            Some(Element::CoordinateBreak(_)) => f64::INFINITY,
            Some(last) => last.thickness_mm().unwrap_or(0.0) * self.heading(),
            None => 0.0,
        }
    }

    /// Goes on along the axis by a distance in mm.
    fn advance(&mut self, distance: f64) {
        match self.element.last_mut() {
            Some(last) => {
                let old = last.thickness_mm().unwrap_or(0.0);
                set_thickness(last, old + distance);
            }
            None => self.start += distance,
        }
    }

    /// Whether the light meets its stop first, without a turn of the axis before.
    fn begins_with_stop(&self, lens: &Sequential) -> bool {
        let line = lens.surface.get(lens.stop).map(|face| face.line);
        let turned = matches!(self.element.first(), Some(Element::CoordinateBreak(_)));
        !turned && line == self.line.first().copied()
    }

    /// A distance against the way of the light is laid by a turn of the axis that turns nothing.
    fn keep_headings(&mut self, losses: &mut Losses) {
        let mut heading = 1.0;
        let (mut element, mut line) = (Vec::new(), Vec::new());
        for (mut one, number) in self.element.drain(..).zip(self.line.drain(..)) {
            if one.reflects() {
                heading = -heading;
            }
            let thickness = one.thickness_mm().unwrap_or(0.0);
            let free = matches!(one, Element::CoordinateBreak(_));
            let back = !free && expected_heading(thickness, heading).is_some();
            if back {
                set_thickness(&mut one, 0.0);
            }
            element.push(one);
            line.push(number);
            if back {
                losses.warn(format!(
                    "The distance {thickness} mm behind the surface of line {number} leads against the way of the light, \
                     which has to go back virtually there."
                ));
                let part = CoordinateBreak {
                    name: None,
                    tilt_deg: [0.0; 3],
                    decenter_mm: [0.0; 2],
                    thickness_mm: thickness,
                };
                element.push(Element::CoordinateBreak(part));
                line.push(number);
            }
        }
        (self.element, self.line) = (element, line);
    }
}

/// The turns of the axis of a coordinate break: one, or more where its tilts come first or it shifts along the axis.
pub(crate) fn breaks(turn: Turn) -> Vec<CoordinateBreak> {
    let part = |decenter_mm, tilt_deg| CoordinateBreak {
        name: None,
        tilt_deg,
        decenter_mm,
        thickness_mm: 0.0,
    };
    let shift = CoordinateBreak {
        thickness_mm: turn.along_mm,
        ..part(turn.decenter_mm, [0.0; 3])
    };
    let [x, y, z] = turn.tilt_deg;
    if !turn.tilt_first {
        return match turn.along_mm == 0.0 {
            true => vec![part(turn.decenter_mm, turn.tilt_deg)],
            false => vec![shift, part([0.0; 2], turn.tilt_deg)],
        };
    }
    let parts = [
        part([0.0; 2], [0.0, 0.0, z]),
        part([0.0; 2], [0.0, y, 0.0]),
        part([0.0; 2], [x, 0.0, 0.0]),
        shift,
    ];
    let idle = part([0.0; 2], [0.0; 3]);
    let mut used: Vec<CoordinateBreak> = parts.into_iter().filter(|part| *part != idle).collect();
    if used.is_empty() {
        used.push(idle);
    }
    used
}
