//! Designs a phase hologram on the paraxial train of a lens, and looks at it through the real lens.
//!
//! `cargo run --release --package raylet --example hologram_through_lens`

use std::error::Error;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::design::holograms::hologram::{HologramTask, design};
use raylet::design::losses::target::Target;
use raylet::optics::assembly::part_check::BuildError;
use raylet::optics::paraxial::Abcd;
use raylet::wave::grid::metrics::ncc;
use raylet::wave::grid::raster::Raster;
use raylet::{Settings, System, SystemBuilder, simulate};
use raylet_testkit::smiley::smiley;

/// Wavelength and pitch of the pixels in mm, and their number along each side.
const WAVELENGTH: f64 = 0.7e-3;
const PITCH: f64 = 6.3e-3;
const PIXELS: usize = 80;

/// Pixels of the sensor along each side, and their pitch in mm.
const POINTS: usize = 100;
const SPACING: f64 = 28e-3;

/// Phases in rad before a plano-convex lens (Thorlabs LA1131-A), and the sensor behind it.
fn system(phases: &Array2<f64>) -> Result<System, BuildError> {
    SystemBuilder::new(WAVELENGTH)
        .phase_pixels("hologram", phases, [PITCH; 2])
        .gap(3.0)
        .surface(25.8, "N-BK7", 12.7)
        .gap(5.3)
        .surface(f64::INFINITY, "air", 12.7)
        .gap(44.7)
        .sensor([POINTS; 2], [SPACING; 2])
        .build()
}

fn main() -> Result<(), Box<dyn Error>> {
    // The paraxial train needs the places of the parts, whatever the phases.
    let blank = system(&Array2::zeros((PIXELS, PIXELS)))?;
    let hop = blank.hops().next().ok_or("a system without hops")?;
    let found = design(
        &HologramTask {
            wavelength: WAVELENGTH,
            train: Abcd::between(&hop)?,
            pitch: [PITCH; 2],
            incident: Array2::from_elem((PIXELS, PIXELS), Complex64::ONE),
            target: Target {
                image: smiley(100),
                size: [2.0; 2],
                blur: [0.0; 2],
            },
            sensor: [POINTS as f64 * SPACING; 2],
            iterations: 60,
            efficiency: 0.0,
        },
        &mut |_| {},
    )?;
    println!(
        "likeness on the paraxial train: {:.4}",
        found.score.ncc_sensor
    );

    // The same phases in the real lens.
    let outcome = simulate(&system(&found.phase)?, &Settings::default(), &|_| {})?;
    let raster = Raster {
        start: [outcome.field.grid.x.node(0), outcome.field.grid.y.node(0)],
        pitch: [SPACING; 2],
        size: [POINTS; 2],
    };
    let picture = found.target.on(&raster);
    let seen = ncc(outcome.field.intensity().view(), picture.view()).ok_or("a dark sensor")?;
    println!("likeness through the real lens: {seen:.4}");
    for hop in &outcome.hops {
        if let Some(budget) = hop.budget() {
            println!("estimated error of the field: {:.1e}", budget.total());
        }
    }
    match (seen - found.score.ncc_sensor).abs() < 0.02 {
        true => Ok(()),
        false => Err("the lens shows something else than its paraxial train".into()),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_example_holds() {
        crate::main().unwrap();
    }
}
