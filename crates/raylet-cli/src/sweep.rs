//! What a command line varies: fields of light, wavelengths and distances of the sensor, a run for each.

use std::sync::Arc;

use clap::Args;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::plan::settings::Settings;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::model::scene_sweep::scene_at_place;
use raylet::file::result::channel::Place;
use raylet::file::result::channel::micrometres;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;

use crate::failure::Failure;

/// Options of a verb that takes several runs at once.
#[derive(Args)]
pub(crate) struct Sweep {
    /// A field of light in place of the scene's: the angles X,Y of collimated light in degrees, or the place X,Y,Z of a
    /// point source in mm. Given several times, each is a run of its own.
    #[arg(long, value_name = "X,Y[,Z]", value_parser = field, allow_hyphen_values = true)]
    field: Vec<Place>,
    /// Distance of the sensor from the element before it in mm, in place of the scene's. Given several times, each is a
    /// run of its own.
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    distance_mm: Vec<f64>,
    /// Moves the sensor aside with the chief ray of each field, at the first wavelength.
    #[arg(long)]
    follow: bool,
}

/// One run: a system at one of its wavelengths.
pub(crate) struct Run {
    /// Where its light comes from and its sensor stands, as far as that is varied.
    pub(crate) place: Place,
    /// The scene, there.
    scene: Arc<Scene>,
    /// The system.
    pub(crate) system: System,
}

impl Sweep {
    /// The runs of a scene by field, then wavelength, then distance. All are built here, so that faults show before the
    /// first is run.
    pub(crate) fn runs(&self, scene: &Scene, settings: &Settings) -> Result<Vec<Run>, Failure> {
        let mut runs = Vec::new();
        for field in or_as_it_is(&self.field) {
            let mut scenes = Vec::new();
            for distance_mm in or_as_it_is(&self.distance_mm) {
                let place = Place {
                    distance_mm,
                    ..field.unwrap_or_default()
                };
                let swept = scene_at_place(scene, &place, self.follow)?;
                scenes.push((place, Arc::new(swept)));
            }
            for channel in 0..scene.wavelength_um.len() {
                for (place, scene) in &scenes {
                    runs.push(Run {
                        place: *place,
                        scene: Arc::clone(scene),
                        system: build::system(scene, channel)?,
                    });
                }
            }
        }
        check_memory(&runs, settings)?;
        Ok(runs)
    }
}

impl AsRef<System> for Run {
    fn as_ref(&self) -> &System {
        &self.system
    }
}

impl Run {
    /// What tells it from the others.
    pub(crate) fn name(&self) -> String {
        let wavelength = micrometres(self.system.wavelength);
        self.place.before(format!("λ = {wavelength} µm"))
    }

    /// The fault of a run, at the element of the scene that it belongs to.
    pub(crate) fn fault(&self, settings: &Settings, error: &SimulateError) -> Fault {
        simulate_fault(&self.scene, &self.system, settings, error)
    }
}

/// The values that are varied; one run as the scene has it where there are none.
fn or_as_it_is<T: Copy>(values: &[T]) -> Vec<Option<T>> {
    match values {
        [] => vec![None],
        _ => values.iter().copied().map(Some).collect(),
    }
}

/// The fields on the sensor of all runs must fit in memory, twice: beside them their pictures are made.
fn check_memory(runs: &[Run], settings: &Settings) -> Result<(), Failure> {
    let sensors = runs
        .iter()
        .filter_map(|run| match run.system.screens.last()?.kind {
            ScreenKind::Sensor(sensor) => Some(sensor.pixels),
            _ => None,
        });
    let bytes: f64 = sensors.map(|[nx, ny]| 32.0 * nx as f64 * ny as f64).sum();
    if bytes <= settings.memory_limit as f64 {
        return Ok(());
    }
    Err(Failure::new(format!(
        "the fields of {} runs take {:.3} MB with their pictures, expected at most {:.3} MB (settings.memory_limit_mb)",
        runs.len(),
        1e-6 * bytes,
        1e-6 * settings.memory_limit as f64
    )))
}

/// A field on the command line.
fn field(text: &str) -> Result<Place, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let mut place = Place::default();
    match numbers.as_deref() {
        Ok(&[x, y]) => place.angle_deg = Some([x, y]),
        Ok(&[x, y, z]) => place.position_mm = Some([x, y, z]),
        _ => {
            return Err(String::from(
                "expected two angles X,Y in degrees, or a place X,Y,Z in mm",
            ));
        }
    }
    Ok(place)
}
