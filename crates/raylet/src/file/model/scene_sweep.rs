//! The runs of a sweep: a scene in several fields of light, with its sensor at several distances.

use crate::engine::geometrical::chief_ray::chief_landing;
use crate::file::decode::fault::Fault;
use crate::file::model::build;
use crate::file::result::channel::Place;
use crate::file::scene::illumination::Illumination;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::variable::{VariableAddress, VariableScene};

/// The scene with its light and its sensor at a place. If the sensor is to `follow`, it moves aside with the chief ray of
/// the first wavelength, through the middle of the element that limits the light, also where an obstruction stops it.
///
/// # Errors
/// A place that the scene has not, or a chief ray that does not come to the sensor.
pub fn scene_at_place(scene: &Scene, place: &Place, follow: bool) -> Result<Scene, Fault> {
    let at_place = with_numbers(scene, &numbers(scene, place))?;
    match follow {
        true => following(&at_place),
        false => Ok(at_place),
    }
}

/// The fields of light that a scene names: that of its source, and those of its design.
pub fn named_fields(scene: &Scene) -> Vec<Place> {
    let (mut angle_deg, mut position_mm) = (None, None);
    match &scene.source {
        Illumination::Plane(plane) => angle_deg = Some(plane.angle_deg),
        Illumination::Gaussian(beam) => angle_deg = Some(beam.angle_deg),
        Illumination::Point(point) => position_mm = Some(point.position_mm),
        Illumination::Field(_) | Illumination::Fibre(_) => (),
    }
    let own = Place {
        angle_deg,
        position_mm,
        ..Place::default()
    };
    let mut fields = vec![own];

    // Those of the design that a source of this kind can have.
    for view in scene.design.iter().flat_map(|design| &design.field) {
        let field = Place {
            angle_deg: view.angle_deg,
            position_mm: view.position_mm,
            ..Place::default()
        };
        let fits = field.angle_deg.is_some() == own.angle_deg.is_some()
            && field.position_mm.is_some() == own.position_mm.is_some();
        if fits && !fields.contains(&field) {
            fields.push(field);
        }
    }
    fields
}

/// The paths of the numbers that a place gives, with their values.
fn numbers(scene: &Scene, place: &Place) -> Vec<(String, f64)> {
    let mut list = Vec::new();
    let mut add = |key: &str, values: &[f64]| {
        let paths = (0..values.len()).map(|axis| format!("source.{key}[{axis}]"));
        list.extend(paths.zip(values.iter().copied()));
    };
    if let Some(angle) = place.angle_deg {
        add("angle_deg", &angle);
    }
    if let Some(position) = place.position_mm {
        add("position_mm", &position);
    }
    if let Some(distance) = place.distance_mm {
        let before = scene.element.len().saturating_sub(2);
        list.push((format!("element[{before}].thickness_mm"), distance));
    }
    list
}

/// The scene with other values of these numbers.
fn with_numbers(scene: &Scene, numbers: &[(String, f64)]) -> Result<Scene, Fault> {
    let varied = VariableScene::new(scene)?;
    let addresses: Vec<VariableAddress> = (numbers.iter())
        .map(|(path, _)| VariableAddress::new(&varied, path, path))
        .collect::<Result<_, Fault>>()?;
    let values: Vec<f64> = numbers.iter().map(|(_, value)| *value).collect();
    varied.with_parameters(&addresses, &values)
}

/// The scene with its sensor about the chief ray.
fn following(scene: &Scene) -> Result<Scene, Fault> {
    let system = build::system(scene, 0)?;
    let last = scene.element.len().saturating_sub(1);
    let path = format!("element[{last}].decenter_mm");
    let (Some(chief), Some(element)) = (chief_landing(&system), scene.element.last()) else {
        let found = "a chief ray that does not come to the sensor";
        return Err(scene.fault(
            &path,
            found,
            "a sensor that it meets, or one that stays in its place",
        ));
    };
    let [x, y] = element.decenter_mm();
    let moved = [
        (format!("{path}[0]"), x + chief.at[0]),
        (format!("{path}[1]"), y + chief.at[1]),
    ];
    with_numbers(scene, &moved)
}
