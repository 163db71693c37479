//! The light of a scene as the object and the field of a prescription.

use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::FieldKind;
use crate::file::scene::illumination::Illumination;
use crate::file::scene::scene_file::Scene;

/// The object and the field.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OutgoingLight {
    /// Distance from the object to the start of the axis in mm; infinite for collimated light.
    pub distance_mm: f64,
    /// What the numbers of the field are.
    pub kind: FieldKind,
    /// The fields [x, y] in degrees or mm.
    pub field: Vec<[f64; 2]>,
}

impl OutgoingLight {
    /// The light of a scene.
    pub(crate) fn of(scene: &Scene, losses: &mut Losses) -> Self {
        tell(scene, losses);
        match &scene.source {
            Illumination::Plane(plane) => Self::collimated(vec![plane.angle_deg]),
            Illumination::Point(point) => Self::from(point.position_mm),
            Illumination::Gaussian(beam) => {
                // Far from its waist a beam is the wave of a point there.
                let [x, y] = beam.waist_radius_um.map(|radius| radius * 1e-3);
                let wavelength = scene.wavelength_um.first().copied().unwrap_or(0.5) * 1e-3;
                let rayleigh = std::f64::consts::PI * x.max(y).powi(2) / wavelength;
                match -beam.waist_mm[2] > rayleigh {
                    true => Self::from(beam.waist_mm),
                    false => Self::collimated(vec![beam.angle_deg]),
                }
            }
            Illumination::Field(_) => Self::collimated(vec![[0.0; 2]]),
            Illumination::Fibre(fibre) => {
                let [x, y] = fibre.decenter_mm;
                Self::from([x, y, -fibre.distance_mm])
            }
        }
    }

    /// Collimated light of angles whose sines are its direction cosines: a prescription has those whose tangents are slopes.
    fn collimated(angles: Vec<[f64; 2]>) -> Self {
        let field = angles.into_iter().map(|angle| {
            let [p, q] = angle.map(|angle| angle.to_radians().sin());
            let along = (1.0 - p * p - q * q).max(0.0).sqrt();
            [p, q].map(|cosine| cosine.atan2(along).to_degrees())
        });
        Self {
            distance_mm: f64::INFINITY,
            kind: FieldKind::Angle,
            field: field.collect(),
        }
    }

    /// The light of a point, from the start of the axis.
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self {
            distance_mm: 0.0 - z,
            kind: FieldKind::ObjectHeight,
            field: vec![[x, y]],
        }
    }
}

/// What of the light a prescription does not have.
fn tell(scene: &Scene, losses: &mut Losses) {
    let taper = match &scene.source {
        Illumination::Plane(plane) => plane.taper.is_some(),
        Illumination::Point(point) => point.taper.is_some(),
        _ => false,
    };
    if taper {
        losses.leave_out(
            "The fall of the amplitude over the beam: rays of the file have equal weights.",
        );
    }
    match &scene.source {
        Illumination::Gaussian(_) => losses.change(
            "The Gaussian beam is collimated light, or that of a point in its waist where that is far before the first element: \
             diffraction and the profile of the beam are lost.",
        ),
        Illumination::Field(_) => losses.change(
            "The field of the source is collimated light along the axis: its amplitude and phase are lost.",
        ),
        Illumination::Fibre(_) => losses.change(
            "The fibre is a point at its end: its mode, and so how the light falls off with the angle, is lost.",
        ),
        Illumination::Plane(_) | Illumination::Point(_) => {}
    }
    if scene.design.is_some() {
        losses.leave_out("The design: variables, losses, and its fields.");
    }
    if scene.hologram.is_some() {
        losses.leave_out("The target of the hologram.");
    }
}
