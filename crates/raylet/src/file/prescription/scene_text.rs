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
    let stays = |line: &&str| {
        if line.starts_with('[') {
            within_settings = line.starts_with("[settings");
        }
        !within_settings && !DEFAULTS.contains(line)
    };
    let kept: Vec<&str> = whole.lines().filter(stays).collect();
    let mut blank = false;
    for (i, line) in kept.iter().enumerate() {
        // A table that only holds other tables needs no heading of its own.
        let next = kept.iter().skip(i + 1).find(|line| !line.is_empty());
        let inner = line.strip_suffix(']').map(|start| format!("{start}."));
        let holds = |inner: String| next.is_some_and(|next| next.starts_with(&inner));
        let heading = line.starts_with('[') && !line.starts_with("[[");
        if (heading && inner.is_some_and(holds)) || (blank && line.is_empty()) {
            continue;
        }
        blank = line.is_empty();
        text += line;
        text.push('\n');
    }
    Ok(format!("{}\n", text.trim_end()))
}
