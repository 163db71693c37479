//! A scene's system at some values of its parameters, and the perturbed systems from which derivatives by these parameters
//! come.

use rayon::prelude::*;

use crate::engine::trace::ray_sensitivity::Variation;
use crate::file::decode::fault::Fault;
use crate::file::model::build;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::variable::{VariableAddress, VariableScene};
use crate::optics::system::System;

/// Step of a parameter over its size, or the step itself where the parameter is zero.
pub(crate) const DERIVATIVE_STEP: f64 = 1e-5;

/// By how much a parameter of this value changes between the perturbed systems and the system itself.
fn step(value: f64) -> f64 {
    if value == 0.0 {
        DERIVATIVE_STEP
    } else {
        DERIVATIVE_STEP * value.abs()
    }
}

/// Parameters of a scene, with values that may differ from those in its file.
#[derive(Clone, Copy)]
pub struct ParameterValues<'a> {
    /// The scene.
    pub scene: &'a VariableScene,
    /// Where the parameters stand.
    pub addresses: &'a [VariableAddress],
    /// Their values, as [`VariableAddress::value`] counts: of a radius its curvature.
    pub values: &'a [f64],
}

/// The system of a wavelength (by its index) with these values of parameters, and its variation in each of them.
///
/// # Errors
/// A scene that is none with these parameters, or a little beside them.
pub fn varied_system(
    parameters: ParameterValues,
    arrays: &Arrays,
    channel: usize,
) -> Result<(System, Vec<Variation>), Fault> {
    let ParameterValues {
        scene,
        addresses,
        values,
    } = parameters;
    if addresses.is_empty() {
        let system = build::system_with(scene.scene(), arrays, channel)?;
        return Ok((system, Vec::new()));
    }
    let at = |values: &[f64]| {
        let scene = scene.with_parameters(addresses, values)?;
        build::system_with(&scene, arrays, channel)
    };
    let one = |(index, value): (usize, &f64)| Variation::new(values, index, step(*value), at);
    let variations: Vec<_> = values.par_iter().enumerate().map(one).collect();
    Ok((
        at(values)?,
        variations.into_iter().collect::<Result<_, Fault>>()?,
    ))
}

/// The variations of a scene's system of a wavelength (by its index) in the parameters at these paths, such as
/// `element[1].thickness_mm`. Each is by itself: the other parameters are read as the scene has them.
///
/// # Errors
/// A path that leads to no number, or a scene that is none a little beside its parameters.
pub fn variations(
    scene: &Scene,
    arrays: &Arrays,
    channel: usize,
    paths: &[String],
) -> Result<Vec<Variation>, Fault> {
    let scene = VariableScene::new(scene)?;
    let one = |path: &String| {
        let address = VariableAddress::new(&scene, path, "element")?;
        let value = address.value(&scene);
        Variation::new(&[value], 0, step(value), |values| {
            let scene = scene.with_parameters(std::slice::from_ref(&address), values)?;
            build::system_with(&scene, arrays, channel)
        })
    };
    // The first that is wrong is named, whichever thread ends first.
    let variations: Vec<Result<Variation, Fault>> = paths.par_iter().map(one).collect();
    variations.into_iter().collect()
}
