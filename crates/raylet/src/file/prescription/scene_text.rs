//! A scene as the text of a file that people read: without what is the same as if it were absent.

use crate::file::decode::fault::Fault;
use crate::file::scene::scene_file::Scene;

/// Lines of a scene's text that say what is true without them.
const DEFAULTS: [&str; 14] = [
    "ambient = \"air\"",
    "seed = 1",
    "conic = 0.0",
    "conic_x = 0.0",
    "conic_y = 0.0",
    "aspheric = []",
    "blocked = []",
    "reflect = false",
    "coordinates = \"projected\"",
    "tilt_deg = [0.0, 0.0, 0.0]",
    "decenter_mm = [0.0, 0.0]",
    "centre_mm = [0.0, 0.0]",
    "rotation_deg = 0.0",
    "angle_deg = [0.0, 0.0]",
];

/// The text of a scene without defaults and without its settings, which an import leaves at their defaults. Each line of the
/// heading is a comment at its beginning.
///
/// # Errors
/// As [`Scene::to_toml`].
pub fn concise_toml(scene: &Scene, heading: &str) -> Result<String, Fault> {
    let whole = scene.to_toml()?;
    let mut text = String::new();
    for line in heading.lines() {
        text += format!("# {line}").trim_end();
        text.push('\n');
    }
    let mut within_settings = false;
    for line in whole.lines() {
        if line.starts_with('[') {
            within_settings = line.starts_with("[settings");
        }
        if !within_settings && !DEFAULTS.contains(&line) {
            text += line;
            text.push('\n');
        }
    }
    Ok(text)
}
