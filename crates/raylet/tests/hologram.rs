//! Holograms designed on the paraxial train, looked at through the real lens.

use std::fs;

use raylet::design::holograms::hologram::{Hologram, design};
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use raylet::file::arrays::phase_file::PhaseFile;
use raylet::file::model::build;
use raylet::file::model::hologram::commission;
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::own_file::Replace;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::field::Grid;
use raylet::wave::grid::metrics::ncc;
use raylet::wave::grid::raster::Raster;
use raylet_testkit::scenes::scene_folder;

/// What the sensor shows: NCC with the softened picture over the whole sensor and within the picture's
/// outline, with the sharp picture within the outline, and the share of the light within the outline.
#[derive(Debug)]
struct Seen {
    sensor: f64,
    picture: f64,
    sharp: f64,
    efficiency: f64,
}

/// Designs the hologram of a scene, writes it, reads the scene with it, and carries the light to sensors at distances in
/// mm behind the lens.
fn seen<const N: usize>(name: &str, naive: bool, distances: [&str; N]) -> (Hologram, [Seen; N]) {
    let scenes = scene_folder();
    let room = tempfile::tempdir().unwrap();
    for file in [name, "photograph.png", "smiley.png"] {
        fs::copy(scenes.join(file), room.path().join(file)).unwrap();
    }
    let path = room.path().join(name);
    let job = commission(&Scene::open(&path).unwrap(), naive).unwrap();
    let found = design(&job.task, &mut |_| {}).unwrap();
    let file = job.file.clone().unwrap();
    assert!(!file.exists());
    let claimed = PhaseFile::claim(&file, Replace::Own).unwrap();
    job.write(&found.phase, &claimed).unwrap();

    let text = fs::read_to_string(&path).unwrap();
    let place = "thickness_mm = 44.7";
    assert!(text.contains(place));
    let seen = distances.map(|distance| {
        let moved = text.replace(place, &format!("thickness_mm = {distance}"));
        fs::write(&path, moved).unwrap();
        let system = build::system(&Scene::read(&path).unwrap(), 0).unwrap();
        let outcome = simulate(&system, &Settings::default(), &|_| {}).unwrap();
        observed(&system, &outcome, &found)
    });
    (found, seen)
}

fn observed(system: &System, outcome: &Outcome, found: &Hologram) -> Seen {
    let intensity = outcome.field.intensity();
    let ScreenKind::Sensor(sensor) = &system.screens[1].kind else {
        panic!("the second screen is the sensor");
    };
    let grid = Grid::of(sensor);
    let raster = Raster {
        start: [grid.x.start, grid.y.start],
        pitch: sensor.pitch,
        size: sensor.pixels,
    };
    let soft = found.target.on(&raster);
    let inside = found.target.inside(&raster);
    let inside = inside.mapv(|inside| f64::from(u8::from(inside)));
    let mut sharp = found.target.clone();
    sharp.blur = [0.0; 2];
    let within = &intensity * &inside;
    let area = raster.pitch[0] * raster.pitch[1];
    Seen {
        sensor: ncc(intensity.view(), soft.view()).unwrap(),
        picture: ncc(within.view(), (&soft * &inside).view()).unwrap(),
        sharp: ncc(within.view(), sharp.on(&raster).view()).unwrap(),
        efficiency: within.sum() * area / outcome.hops[0].power[1].unwrap(),
    }
}

#[test]
fn photograph_comes_through_the_real_lens() {
    let (found, [seen]) = seen("hologram_through_lens.toml", false, ["44.7"]);
    assert!(seen.sensor > 0.998 && seen.picture > 0.998, "{seen:?}");
    assert!(seen.sharp > 0.995, "{seen:?}");
    assert!((seen.efficiency - found.score.efficiency).abs() < 1e-3);
}

#[test]
fn principal_planes_matter_slow() {
    // The paraxial scores hardly differ; the real lens separates the designs.
    let (with, [through]) = seen("smiley_through_lens.toml", false, ["44.7"]);
    let (without, [astray, moved]) = seen("smiley_through_lens.toml", true, ["44.7", "46.49717"]);
    assert!((with.score.ncc - without.score.ncc).abs() < 1e-3);
    assert!(through.sensor > 0.994, "{through:?}");
    assert!(astray.sensor < 0.81, "{astray:?}");

    // What was designed for a thin lens at the vertex, 50 mm before the sensor, is right where the rear
    // principal plane, 5.3 mm / 1.513064 inside, is 50 mm before it.
    assert!((moved.sensor - without.score.ncc).abs() < 1e-4, "{moved:?}");
}

#[test]
fn photograph_without_principal_planes_is_worse() {
    let (_, [seen]) = seen("hologram_through_lens.toml", true, ["44.7"]);
    assert!(seen.sensor < 0.94, "{seen:?}");
}
