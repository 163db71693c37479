//! Perturbed systems with a screen at every rim at which the planned one has a screen.

use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::rims::rim_screens::Rimmed;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::system::System;

/// The variations with a screen at every rim, as the system has them.
///
/// # Errors
/// When a perturbed system has other parts.
pub(crate) fn rimmed_variations(
    planned: &Rimmed,
    variations: &[Variation],
) -> Result<Vec<Variation>, LinearisedSystemError> {
    let system = &planned.system;
    let mut list = Vec::new();
    for (parameter, variation) in variations.iter().enumerate() {
        let [below, above] =
            [&variation.below, &variation.above].map(|system| planned.like(system));
        for other in [&below, &above] {
            let trains = other.trains.iter().zip(&system.trains);
            let alike = other.trains.len() == system.trains.len()
                && trains.into_iter().all(|(a, b)| a.len() == b.len());
            if !alike {
                return Err(LinearisedSystemError::Parts(parameter));
            }
        }
        list.push(Variation {
            below,
            above,
            distance: variation.distance,
        });
    }
    Ok(list)
}

/// Refuses variations in which the surface of a screen changes: whole fields do not follow it.
///
/// # Errors
/// When there is one.
pub(crate) fn surfaces_stay(
    system: &System,
    variations: &[Variation],
) -> Result<(), LinearisedSystemError> {
    for (parameter, variation) in variations.iter().enumerate() {
        for other in [&variation.below, &variation.above] {
            let mut screens = other.screens.iter().zip(&system.screens);
            if let Some((_, here)) = screens.find(|(screen, here)| screen.shape != here.shape) {
                let screen = here.name.clone();
                return Err(LinearisedSystemError::Substrate { parameter, screen });
            }
        }
    }
    Ok(())
}
