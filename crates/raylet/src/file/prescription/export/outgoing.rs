//! From a scene to a sequential prescription.

use crate::file::decode::fault::Fault;
use crate::file::prescription::export::held_phase::Refusal;
use crate::file::prescription::export::laying_surfaces::lay;
use crate::file::prescription::export::limiting_stop::limit_light;
use crate::file::prescription::export::outgoing_light::OutgoingLight;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::{Action, ApertureRule, Curve, Face, Sequential};
use crate::file::scene::element::Element;
use crate::file::scene::scene_file::Scene;

/// The name that an import gives to the aperture before a lens.
const APERTURE: &str = "aperture";

/// A scene as a prescription.
#[derive(Clone, Debug)]
pub(crate) struct Outgoing {
    /// The prescription.
    pub lens: Sequential,
    /// The media behind its surfaces.
    pub media: Vec<MediumBehind>,
    /// The path in the scene from which each surface comes.
    pub path: Vec<String>,
    /// Position of its first surface, from the start of the scene's axis in mm.
    pub start_mm: f64,
    /// How far the sensor reaches in mm, from its middle.
    pub sensor_mm: f64,
}

impl Outgoing {
    /// The prescription of a scene at its first wavelength. What no prescription holds is left out if `skip_unknown`.
    ///
    /// # Errors
    /// An element that no prescription holds, an unknown glass or a wavelength outside its range, at its key.
    pub(crate) fn of(
        scene: &Scene,
        skip_unknown: bool,
        losses: &mut Losses,
    ) -> Result<Self, Fault> {
        let light = OutgoingLight::of(scene, losses);
        let wavelength = scene.wavelength_mm(0)?;
        let laid = lay(scene, light.distance_mm, skip_unknown, losses)?;
        let mut outgoing = Self {
            lens: Sequential {
                title: scene.title.clone(),
                surface: laid.surface,
                stop: 1,
                aperture: ApertureRule::EntrancePupil(1.0),
                field_kind: light.kind,
                field: light.field,
                wavelength_um: scene.wavelength_um.clone(),
                primary: 0,
                catalogues: Vec::new(),
                focused: None,
            },
            media: laid.media,
            path: laid.path,
            start_mm: 0.0,
            sensor_mm: laid.sensor_mm,
        };
        let limited = limit_light(&mut outgoing.lens, &outgoing.media, wavelength);
        if !limited {
            losses.warn(
                "No rim limits the light on the axis by a pupil at a finite place: the first surface is the stop.",
            );
        }
        outgoing.drop_aperture(scene, wavelength, losses);
        Ok(outgoing)
    }

    /// Takes out of its surfaces what a format does not hold: they are conics without a phase then.
    pub(crate) fn leave_out(
        &mut self,
        holds: fn(&Self, &Face) -> Result<(), Refusal>,
        losses: &mut Losses,
    ) {
        let refused = |face: &Face| holds(self, face).err();
        let refusals: Vec<Option<Refusal>> = self.lens.surface.iter().map(refused).collect();
        if refusals.iter().all(Option::is_none) {
            return;
        }
        let surfaces = self.lens.surface.iter_mut().zip(&self.path).zip(refusals);
        for ((face, path), refusal) in surfaces {
            let Some((found, _)) = refusal else { continue };
            losses.warn(format!(
                "{path} is a conic without a phase in the file, which cannot hold {found}. Light behind it goes another way."
            ));
            face.phase.clear();
            face.action = Action::Border;
            face.curve = Curve {
                curvature: face.curve.curvature,
                conic: face.curve.conic,
                ..Curve::default()
            };
        }
        let first_um = self.lens.wavelength_um.first().copied();
        limit_light(&mut self.lens, &self.media, first_um.unwrap_or(0.55) * 1e-3);
    }

    /// Leaves out the aperture that an import puts before a lens, where it does not limit the light.
    fn drop_aperture(&mut self, scene: &Scene, wavelength: f64, losses: &mut Losses) {
        let named = scene.element.first().and_then(Element::name) == Some(APERTURE);
        let (Some(face), true) = (self.lens.surface.get(1), named) else {
            return;
        };
        let own = self.path.get(1).is_some_and(|path| path == "element[0]");
        let round = face.outline.as_ref().is_some_and(|one| one.disc.is_some());
        let gap = face.thickness_mm;
        if !own
            || !round
            || !face.blocked.is_empty()
            || self.lens.stop == 1
            || self.lens.image() < 3
        {
            return;
        }
        self.lens.surface.remove(1);
        self.media.remove(1);
        self.path.remove(1);
        self.start_mm += gap;
        if let Some(object) = self.lens.surface.first_mut() {
            object.thickness_mm += gap;
        }
        for (number, face) in self.lens.surface.iter_mut().enumerate() {
            face.number = number;
        }
        self.lens.stop -= 1;
        // The pupil is where it was.
        limit_light(&mut self.lens, &self.media, wavelength);
        losses.change(
            "The aperture before the first element, which an import puts there, is left out: it is wider than the light.",
        );
    }
}
