//! Designed scenes seen by references that share no code with raylet's rays.
//!
//! `cargo run --release -p raylet-accuracy --example designed -- overlap SCENE` prints the share of the light in the
//! mode of an overlap, behind planes of pixels in free space; `… -- spots SCENE` the brightness of each
//! spot at each wavelength, behind one analytic phase and one lens.

use std::path::Path;

use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet_accuracy::designed::{overlap, spots};

fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["overlap", scene] => {
            let scene = Scene::read(Path::new(scene))?;
            let share = overlap(&scene, &build::system(&scene, 0)?)?;
            println!(
                "share of the light in the mode {:.5}, on the sensor {:.5}",
                share.mode, share.seen
            );
            println!("NCC of the intensity with the picture {:.5}", share.ncc);
        }
        ["spots", scene] => {
            let scene = Scene::read(Path::new(scene))?;
            let found = spots(&scene)?;
            for spot in &found {
                let [field, channel] = spot.place;
                let wavelength = scene.wavelength_um[channel];
                println!("field {field}, {wavelength} µm: {:.4}", spot.strehl);
            }
            let sum: f64 = found.iter().map(|spot| -spot.strehl.ln()).sum();
            println!("mean −log {:.4}", sum / found.len() as f64);
        }
        _ => return Err("expected overlap SCENE or spots SCENE".into()),
    }
    Ok(())
}
