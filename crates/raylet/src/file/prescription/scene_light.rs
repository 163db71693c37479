//! The light and the sensor of a scene from a prescription.

use crate::file::decode::origin::Origin;
use crate::file::model::scene_arrays::Arrays;
use crate::file::prescription::first_order::FirstOrder;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::Sequential;
use crate::file::scene::element::{Element, SensorElement};
use crate::file::scene::illumination::{Illumination, PlaneIllumination, PointIllumination};
use crate::file::scene::material::{Material, air};
use crate::file::scene::scene_file::{Scene, VERSION};
use crate::file::scene::settings::Settings;

/// Pixels along each side of the sensor.
const PIXELS: usize = 96;

/// The share of the wavelength times the f-number that is the pitch of pixels, and its bounds in µm.
const PITCH: f64 = 0.25;
const PITCHES: [f64; 2] = [1e-6, 1e6];

/// The light of one field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    /// Slopes of its chief ray at the entrance pupil.
    pub slopes: [f64; 2],
    /// The luminous point from the first element in mm; none where it is infinitely far.
    pub object_mm: Option<[f64; 3]>,
    /// The wavelength in µm.
    pub wavelength_um: f64,
}

/// The scene of these elements in the medium of the object (none for air), with a sensor at the image on its axis.
pub(crate) fn assembled(
    lens: &Sequential,
    first: &FirstOrder,
    ambient: Option<&Material>,
    light: Light,
    mut element: Vec<Element>,
) -> Scene {
    let number = first.working_f_number();
    let aperture = match number.is_finite() && number < 1e6 {
        true => number,
        // Parallel light: the sensor is as wide as the pupil.
        false => first.pupil_diameter * 1e3 / (PITCH * light.wavelength_um * PIXELS as f64),
    };
    let pitch = (PITCH * light.wavelength_um * aperture).clamp(PITCHES[0], PITCHES[1]);
    element.push(Element::Sensor(SensorElement {
        name: Some("sensor".to_owned()),
        tilt_deg: [0.0; 3],
        decenter_mm: [0.0; 2],
        pixels: [PIXELS; 2],
        pitch_um: [pitch; 2],
    }));
    Scene {
        version: VERSION,
        title: lens.title.clone(),
        wavelength_um: vec![light.wavelength_um],
        ambient: ambient.cloned().unwrap_or_else(air),
        seed: 1,
        source: illumination(light),
        element,
        settings: Settings::default(),
        hologram: None,
        design: None,
        origin: Origin::default(),
        arrays: Arrays::default(),
    }
}

fn illumination(light: Light) -> Illumination {
    match light.object_mm {
        Some(position_mm) => Illumination::Point(PointIllumination {
            position_mm,
            taper: None,
            beam_radius_mm: None,
        }),
        None => {
            // Slopes are the tangents of both angles; the scene has the angles whose sines are the direction cosines.
            let [x, y] = light.slopes;
            let length = (1.0 + x * x + y * y).sqrt();
            Illumination::Plane(PlaneIllumination {
                angle_deg: [x, y].map(|slope| (slope / length).asin().to_degrees()),
                taper: None,
                beam_radius_mm: None,
            })
        }
    }
}

/// The scene with its sensor aside of the axis by this shift in mm.
pub(crate) fn shift_sensor(mut scene: Scene, shift: [f64; 2]) -> Scene {
    if let Some(Element::Sensor(sensor)) = scene.element.last_mut() {
        sensor.decenter_mm = shift;
    }
    scene
}

/// Centres an aperture before the lens on the chief ray where that would miss it, as before mirrors off their axes; false where it
/// stays.
pub(crate) fn centre_aperture(
    scene: &mut Scene,
    entry: Option<[f64; 2]>,
    losses: &mut Losses,
) -> bool {
    let (Some(Element::Stop(stop)), Some([x, y])) = (scene.element.first_mut(), entry) else {
        return false;
    };
    let Some(disc) = &mut stop.aperture.disc else {
        return false;
    };
    let distance = x.hypot(y);
    let aside = distance > disc.radius_mm && distance.is_finite();
    if stop.name.as_deref() != Some("aperture") || !aside {
        return false;
    }
    disc.centre_mm = [x, y].map(|at| (at * 1e9).round() / 1e9 + 0.0);
    losses.change(format!(
        "The aperture before the first element is centred on the chief ray, at ({x:.6}, {y:.6}) mm."
    ));
    true
}
