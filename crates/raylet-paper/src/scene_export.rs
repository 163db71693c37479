//! A study's system as a scene file with its arrays: one pixelated element in collimated light, and a sensor.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use ndarray::Array2;
use ndarray_npy::{WriteNpyError, WriteNpyExt};
use raylet::optics::aperture::Outline;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::freeform::Term;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::sag_grid::SagGrid;
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::Shape;
use raylet::optics::system::System;

/// A millimetre in micrometres.
const UM: f64 = 1e3;

/// Names and contents of files.
pub type Files = Vec<(String, Vec<u8>)>;

/// The scene file `{stem}.toml` and the arrays beside it, as names and contents; nothing where the system is
/// of another kind: first a plane element, one on Gaussian bumps or one on a grid of heights, that has one layer of
/// pixels, within a disc or a rectangle or their own edge; then the sensor. Light comes along the axis; where it comes along −z,
/// the scene is the system's mirror image in the plane z = 0, which shows the same.
///
/// # Errors
/// When an array cannot be written as .npy.
pub fn scene_files(
    system: &System,
    stem: &str,
    title: &str,
) -> Result<Option<Files>, WriteNpyError> {
    let Some((element, doe, pixels, sensor)) = parts(system) else {
        return Ok(None);
    };
    let (Some((shape, heights)), Some(aperture)) = (shape(element, stem), aperture(doe, pixels))
    else {
        return Ok(None);
    };
    let place = system.screens[1].frame.origin;
    let turn = if doe.reflect { "reflect = true\n" } else { "" };
    let form = match pixels.form {
        PixelForm::Box => "box",
        PixelForm::Point => "point",
        PixelForm::Bilinear => "bilinear",
        PixelForm::BandLimited => "band_limited",
    };
    let text = format!(
        "version = 1\ntitle = \"{title}\"\nwavelength_um = {}\n\n[source]\nkind = \"plane\"\n\n\
         [[element]]\nkind = \"doe\"\nname = \"element\"\n{turn}thickness_mm = {}\n{aperture}{shape}\
         [[element.layer]]\nkind = \"pixels\"\npitch_um = [{}, {}]\ntransmission = \"{stem}.npy\"\n\
         pixel = \"{form}\"\n\n[[element]]\nkind = \"sensor\"\nname = \"sensor\"\n\
         pixels = [{}, {}]\npitch_um = [{}, {}]\n",
        system.wavelength * UM,
        place.z * element.arrives,
        pixels.pitch[0] * UM,
        pixels.pitch[1] * UM,
        sensor.pixels[0],
        sensor.pixels[1],
        sensor.pitch[0] * UM,
        sensor.pitch[1] * UM,
    );
    let mut files = vec![(format!("{stem}.toml"), text.into_bytes())];
    let mut bytes = Vec::new();
    pixels.values.write_npy(&mut bytes)?;
    files.push((format!("{stem}.npy"), bytes));
    if let Some(heights) = heights {
        let mut bytes = Vec::new();
        heights.write_npy(&mut bytes)?;
        files.push((format!("{stem}_heights.npy"), bytes));
    }
    Ok(Some(files))
}

/// The element's screen, the element, its pixels and the sensor.
fn parts(system: &System) -> Option<(&Screen, &Doe, &Pixels, &Sensor)> {
    let [element, sensor] = system.screens.as_slice() else {
        return None;
    };
    let centred = sensor.frame.origin.x == 0.0 && sensor.frame.origin.y == 0.0;
    let (ScreenKind::Doe(doe), ScreenKind::Sensor(sensor)) = (&element.kind, &sensor.kind) else {
        return None;
    };
    match doe.layers.as_slice() {
        [Layer::Pixels(pixels)] if centred => Some((element, doe, pixels, sensor)),
        _ => None,
    }
}

/// The line of the element's aperture: a disc, or a rectangle, of the pixels where it has no edge.
fn aperture(doe: &Doe, pixels: &Pixels) -> Option<String> {
    let [width, height] = match doe.aperture.outline {
        Outline::Disc { radius } => {
            return Some(format!(
                "aperture = {{ disc = {{ radius_mm = {radius} }} }}\n"
            ));
        }
        Outline::Rectangle { half_x, half_y } => [2.0 * half_x, 2.0 * half_y],
        Outline::Open => {
            let (ny, nx) = pixels.values.dim();
            [nx as f64 * pixels.pitch[0], ny as f64 * pixels.pitch[1]]
        }
        _ => return None,
    };
    Some(format!(
        "aperture = {{ rectangle = {{ width_mm = {width}, height_mm = {height} }} }}\n"
    ))
}

/// The line of the element's shape, and heights in µm where it is a grid of them.
fn shape(element: &Screen, stem: &str) -> Option<(String, Option<Array2<f64>>)> {
    let along = element.arrives;
    match &element.shape {
        Shape::Plane => Some((String::new(), None)),
        Shape::Freeform { base, terms } if base.curvature == 0.0 => match terms.as_slice() {
            [
                Term::Gaussian {
                    height,
                    centre,
                    sigma,
                },
            ] => {
                let bump = format!(
                    "{{ height_um = {}, sigma_mm = {sigma}, centre_mm = [{}, {}] }}",
                    height * along * UM,
                    centre[0],
                    centre[1]
                );
                let line = format!("shape = {{ kind = \"gaussian\", bumps = [{bump}] }}\n");
                Some((line, None))
            }
            [Term::Grid(grid)] => {
                let [px, py] = grid.pitch().map(|pitch| pitch * UM);
                let line = format!(
                    "shape = {{ kind = \"grid\", pitch_um = [{px}, {py}], height_um = \"{stem}_heights.npy\" }}\n"
                );
                Some((line, Some(heights(grid) * (along * UM))))
            }
            _ => None,
        },
        _ => None,
    }
}

/// The heights that a grid goes through, in mm.
fn heights(grid: &SagGrid) -> Array2<f64> {
    let (half, pitch) = (grid.half(), grid.pitch());
    let [nx, ny] = [0, 1].map(|a| (2.0 * half[a] / pitch[a]).round() as usize + 1);
    let place = |i: usize, a: usize| i as f64 * pitch[a] - half[a];
    Array2::from_shape_fn((ny, nx), |(j, i)| {
        grid.sag(place(i, 0), place(j, 1)).unwrap_or(0.0)
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use raylet::engine::chain::simulate::simulate;
    use raylet::engine::plan::settings::Settings;
    use raylet::file::model::build;
    use raylet::file::scene::scene_file::Scene;
    use raylet::optics::system::System;
    use raylet::wave::grid::metrics::field_error;
    use raylet_testkit::patterns::star_hologram;

    use crate::mirrors::conformal_mirror::{Conformal, Show, Substrate, Window};
    use crate::scene_export::scene_files;

    /// How far the field of the scene that is written is from that of the system itself.
    fn astray(system: &System) -> f64 {
        let room = tempfile::tempdir().unwrap();
        for (name, bytes) in scene_files(system, "study", "A study").unwrap().unwrap() {
            fs::write(room.path().join(name), bytes).unwrap();
        }
        let scene = Scene::read(&room.path().join("study.toml")).unwrap();
        let again = &build::system(&scene, 0).unwrap();
        let field = |system: &System| simulate(system, &Settings::default(), &|_| {}).unwrap();
        let [ours, theirs] = [again, system].map(|system| field(system).field.values);
        field_error(ours.view(), theirs.view()).unwrap()
    }

    #[test]
    fn what_is_written_is_the_study_itself_slow() {
        assert!(astray(&star_hologram(16, 0.7, 1e-3)) < 1e-9);
        for substrate in [Substrate::Bumps, Substrate::Bump] {
            let mirror = Conformal {
                substrate,
                show: Show::Foci,
                scale: 0.05,
            };
            let window = Window {
                x: 0.0,
                pixels: [11, 9],
                pitch: 1e-3,
            };
            let error = astray(&mirror.system(window));
            assert!(error < 1e-6, "{substrate:?} {error:e}");
        }
    }
}
