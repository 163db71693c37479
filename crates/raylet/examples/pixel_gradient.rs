//! The gradient of the light in a spot by the phases of all pixels, through a lens: beside a difference, and for a few steps
//! uphill.
//!
//! `cargo run --release --package raylet --example pixel_gradient`

use std::error::Error;

use ndarray::{Array2, Zip};
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::optics::assembly::part_check::BuildError;
use raylet::optics::doe::Doe;
use raylet::optics::screen::ScreenKind;
use raylet::wave::grid::transmission::phase_bar;
use raylet::{LinearisedSystem, Settings, System, SystemBuilder};

/// Pixels of the element and of the sensor along each side.
const PIXELS: usize = 32;
const POINTS: usize = 24;

/// Phases in rad before a lens of 50 mm, whose sensor is not in its focus.
fn system(phases: &Array2<f64>) -> Result<System, BuildError> {
    SystemBuilder::new(0.7e-3)
        .phase_pixels("pixels", phases, [12e-3; 2])
        .gap(3.0)
        .surface(25.8, "N-BK7", 6.0)
        .gap(5.3)
        .surface(f64::INFINITY, "air", 6.0)
        .gap(30.0)
        .sensor([POINTS; 2], [12e-3; 2])
        .build()
}

/// The element of a system, the first screen.
fn element(system: &System) -> Result<&Doe, &'static str> {
    match system.screens.first().map(|screen| &screen.kind) {
        Some(ScreenKind::Doe(doe)) => Ok(doe),
        _ => Err("a system without an element"),
    }
}

/// The light in the spot, Σ|U|² over a square of pixels, and its gradient by the phases.
fn evaluate(
    linearised: &LinearisedSystem,
    system: &System,
) -> Result<(f64, Array2<f64>), Box<dyn Error>> {
    let pass = linearised.forward(system)?;
    let inside = |(j, i): (usize, usize)| (10..13).contains(&j) && (14..17).contains(&i);
    let mut bar = pass.field.values.clone();
    bar.indexed_iter_mut()
        .filter(|(at, _)| !inside(*at))
        .for_each(|(_, value)| *value *= 0.0);
    let light = bar.iter().map(|u| u.norm_sqr()).sum();

    // L = Σ|U|² has the cotangent Ū = 2U; with v the pixels, Im(v̄ v*) is the gradient by their phases.
    let back = linearised.adjoint(system, &[], &pass, &(bar * 2.0))?;
    let pixels = element(system)?.free_pixels().ok_or("no pixels")?;
    let pixels_bar = back.pixels.first().and_then(Option::as_ref);
    let gradient = phase_bar(pixels_bar.ok_or("no gradient")?, &pixels.values);
    Ok((light, gradient))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut phases = Array2::from_shape_fn((PIXELS, PIXELS), |(j, i)| {
        0.3 * ((3 * i + 5 * j) % 7) as f64
    });

    // Windows, directions and modes are chosen once; then the same ones serve for all phases.
    let settings = Settings {
        mode_threshold: Some(0.0),
        ..Settings::default()
    };
    let planned = LinearisedSystem::new(&system(&phases)?, &[], &settings);
    let linearised = planned.map_err(|error: LinearisedSystemError| error.to_string())?;
    let (first, gradient) = evaluate(&linearised, &system(&phases)?)?;

    // Along its own direction the gradient is its norm; a central difference says the same.
    let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    let at = |step: f64| -> Result<f64, Box<dyn Error>> {
        let moved = &phases + &(&gradient * (step / norm));
        Ok(evaluate(&linearised, &system(&moved)?)?.0)
    };
    let slope = (at(1e-3)? - at(-1e-3)?) / 2e-3;
    println!("slope by the gradient {norm:.6e}, by a difference {slope:.6e}");
    if (norm / slope - 1.0).abs() > 1e-5 {
        return Err("the gradient is not the slope".into());
    }

    // Each step turns the phase of the steepest pixel by 0.3 rad.
    let mut light = first;
    for _ in 0..10 {
        let (now, gradient) = evaluate(&linearised, &system(&phases)?)?;
        let steepest = gradient.iter().fold(0.0f64, |most, g| most.max(g.abs()));
        Zip::from(&mut phases)
            .and(&gradient)
            .for_each(|phase, g| *phase += 0.3 * g / steepest);
        light = now;
    }
    println!("light in the spot: {first:.3e}, after ten steps {light:.3e}");
    match light > 2.0 * first {
        true => Ok(()),
        false => Err("the light has not grown".into()),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_example_holds() {
        crate::main().unwrap();
    }
}
