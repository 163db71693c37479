//! From what a scene says of its light to the source of its system.

use ndarray::Array2;
use num_complex::Complex64;

use crate::file::decode::fault::Fault;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::illumination::{
    BeamTaper, ConeTaper, FibreIllumination, FibreProfile, Illumination,
};
use crate::file::scene::scene_file::Scene;
use crate::math::vec3::Vec3;
use crate::optics::beams::fibre_mode::FibreMode;
use crate::optics::beams::gaussian_beam::GaussianBeam;
use crate::optics::beams::gaussian_mode::GaussianMode;
use crate::optics::beams::sampled_field::sampled_field;
use crate::optics::beams::taper::Taper;
use crate::optics::doe::Doe;
use crate::optics::frame::Frame;
use crate::optics::source::{Source, direction_at};

/// Micrometres in a millimetre.
const UM: f64 = 1e-3;

/// Where the light of a scene goes.
pub(crate) struct LitAxis<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where the first screen stands, at whose vertex phases are zero.
    pub first: Frame,
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
    /// Index of the ambient medium.
    pub around: f64,
}

/// What makes the light of a scene of a plane wave where it is given on a plane: its samples as an element there. Nothing for
/// other light.
///
/// # Errors
/// Samples that are not loaded, or a mode that the fibre does not guide or that reaches too far outside.
pub(crate) fn source_element(
    scene: &Scene,
    arrays: &Arrays,
    wavelength: f64,
) -> Result<Option<Doe>, Fault> {
    let (samples, pitch) = match &scene.source {
        Illumination::Field(field) => {
            let missing = || {
                let found = "an array that is not loaded";
                scene.fault("source.samples", found, "an array file")
            };
            let samples = arrays.source_samples().ok_or_else(missing)?;
            (samples, field.pitch_um.map(|pitch| pitch * UM))
        }
        Illumination::Fibre(fibre) => fibre_samples(scene, fibre, wavelength)?,
        _ => return Ok(None),
    };
    Ok(Some(sampled_field(&samples, pitch)))
}

/// The samples of a fibre's mode, and their distances in mm.
fn fibre_samples(
    scene: &Scene,
    fibre: &FibreIllumination,
    wavelength: f64,
) -> Result<(Array2<Complex64>, [f64; 2]), Fault> {
    let (radius, aperture) = match fibre.profile() {
        Some(FibreProfile::StepIndex([radius, aperture])) => (radius * UM, aperture),
        Some(FibreProfile::Gaussian(diameter)) => {
            let (samples, pitch) = GaussianMode::of_diameter(diameter * UM).samples();
            return Ok((samples, [pitch; 2]));
        }
        // Scenes are checked for this when they are read.
        None => return Err(scene.fault("source", "no mode", "a mode of a fibre")),
    };
    let v = std::f64::consts::TAU / wavelength * radius * aperture;
    let rotation = fibre.rotation_deg.to_radians();
    let mode = FibreMode::new(radius, v, fibre.mode, rotation).map_err(|error| {
        let expected = "a mode that the fibre guides at all wavelengths";
        scene.fault("source.mode", error.to_string(), expected)
    })?;
    let (samples, pitch) = mode.samples().ok_or_else(|| {
        let found = format!("a mode that reaches far beyond the core, at V = {v:.4}");
        let expected = "a mode farther from where it is cut off";
        scene.fault("source.mode", found, expected)
    })?;
    Ok((samples, [pitch; 2]))
}

impl LitAxis<'_> {
    /// The source, its phase zero at the first screen's vertex.
    ///
    /// # Errors
    /// Angles that no direction has, or a numerical aperture that the ambient medium has not.
    pub(crate) fn source(&self) -> Result<Source, Fault> {
        let origin = self.first.origin;
        match &self.scene.source {
            Illumination::Plane(plane) => {
                let direction = self.direction("angle_deg", plane.angle_deg)?;
                Ok(match &plane.taper {
                    None => Source::Plane { direction, origin },
                    Some(taper) => self.tapered_plane(direction, taper),
                })
            }
            Illumination::Point(point) => match &point.taper {
                None => Ok(Source::point(point.position_mm, origin)),
                Some(taper) => self.tapered_point(point.position_mm, taper),
            },
            Illumination::Gaussian(beam) => {
                let [x, y, z] = beam.waist_mm;
                Ok(Source::Gaussian(GaussianBeam::new(
                    Vec3::new(x, y, z),
                    self.direction("angle_deg", beam.angle_deg)?,
                    beam.waist_radius_um.map(|radius| radius * UM),
                    beam.rotation_deg.to_radians(),
                    std::f64::consts::TAU * self.around / self.wavelength,
                )))
            }
            Illumination::Field(_) | Illumination::Fibre(_) => Ok(Source::Plane {
                direction: self.first.z,
                origin,
            }),
        }
    }

    fn tapered_plane(&self, direction: Vec3, taper: &BeamTaper) -> Source {
        let ([x, y], rotation) = (taper.centre_mm, taper.rotation_deg.to_radians());
        Source::TaperedPlane {
            direction,
            origin: self.first.origin,
            centre: self.first.origin + Vec3::new(x, y, 0.0),
            taper: Taper::about(direction, taper.radius_mm, taper.order, rotation),
        }
    }

    /// A point's light over half angles, or over numerical apertures.
    fn tapered_point(&self, [x, y, z]: [f64; 3], taper: &ConeTaper) -> Result<Source, Fault> {
        let widths = match (taper.numerical_aperture, taper.half_angle_deg) {
            (Some(apertures), _) => apertures.map(|aperture| aperture / self.around),
            (None, angles) => angles.unwrap_or([90.0; 2]).map(|a| a.to_radians().sin()),
        };
        if let Some(wide) = widths.into_iter().find(|width| *width >= 1.0) {
            let found = (wide * self.around).to_string();
            let expected = format!("less than {}, the index of the ambient medium", self.around);
            let path = "source.taper.numerical_aperture";
            return Err(self.scene.fault(path, found, expected));
        }
        let middle = self.direction("taper.angle_deg", taper.angle_deg)?;
        Ok(Source::TaperedPoint {
            position: Vec3::new(x, y, z),
            reference: self.first.origin,
            taper: Taper::about(middle, widths, taper.order, taper.rotation_deg.to_radians()),
        })
    }

    /// The direction of light at these angles in degrees, under a key of the source.
    ///
    /// # Errors
    /// Angles that no direction has.
    fn direction(&self, key: &str, angle_deg: [f64; 2]) -> Result<Vec3, Fault> {
        let angle = angle_deg.map(f64::to_radians);
        direction_at(angle).ok_or_else(|| {
            let [x, y] = angle.map(f64::sin);
            let found = format!("direction cosines {x:.3} and {y:.3}");
            let expected = "angles whose sines' squares add up to less than one";
            self.scene.fault(&format!("source.{key}"), found, expected)
        })
    }
}
