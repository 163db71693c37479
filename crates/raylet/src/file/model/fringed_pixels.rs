//! Pixels with fly-back or crosstalk have no gradient by their values: what asks for it is refused.

use crate::file::decode::fault::Fault;
use crate::file::scene::element::Element;
use crate::file::scene::layer::{Layer, PixelLayer};
use crate::file::scene::scene_file::Scene;

/// What is expected in place of them.
const EXPECTED: &str = "0 where pixels are found or varied; what is found may be simulated with it";

/// Refuses pixels at a path with fly-back or crosstalk.
///
/// # Errors
/// Where there is one of them.
pub(crate) fn refuse_fringing(scene: &Scene, pixels: &PixelLayer, path: &str) -> Result<(), Fault> {
    let keys = [
        ("fly_back_um", pixels.fly_back_um),
        ("crosstalk_um", pixels.crosstalk_um),
    ];
    match keys.into_iter().find(|(_, value)| *value > 0.0) {
        Some((key, value)) => {
            Err(scene.fault(&format!("{path}.{key}"), value.to_string(), EXPECTED))
        }
        None => Ok(()),
    }
}

/// Refuses an element by its name whose layers have pixels with fly-back or crosstalk.
///
/// # Errors
/// The first such layer.
pub fn refuse_fringed_element(scene: &Scene, name: &str) -> Result<(), Fault> {
    let number = scene.number_of(name);
    let Some((number, Element::Doe(doe))) =
        number.and_then(|number| Some((number, scene.element.get(number)?)))
    else {
        return Ok(());
    };
    for (i, layer) in doe.layer.iter().enumerate() {
        if let Layer::Pixels(pixels) = layer {
            refuse_fringing(scene, pixels, &format!("element[{number}].layer[{i}]"))?;
        }
    }
    Ok(())
}
