//! The document of a run, `result.json`: what was computed, how, how well, and what became of the light.
//!
//! Every key is explained in docs/result.md.

use serde::{Deserialize, Serialize};

use crate::engine::error::run_warnings::misses;
use crate::engine::plan::settings::{
    Correction, Density, Method, Paper, Positions, Sag, Sampler, Settings,
};
use crate::file::result::channel::Channel;
use crate::file::result::machine::Machine;
use crate::file::scene::scene_file::Scene;
use crate::wave::patches::tile::TileWindow;

/// Micrometres in a millimetre.
const UM: f64 = 1e3;

/// The version of the document that this program writes.
pub(crate) const VERSION: u32 = 1;

/// A whole run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of the document.
    pub version: u32,
    /// The verb of the program that made it.
    pub verb: String,
    /// The scene's title.
    pub title: String,
    /// The scene file, as it was named.
    pub scene: String,
    /// The settings as they were used.
    pub settings: SettingsEntry,
    /// One entry per wavelength, in a sweep for each of its fields and distances.
    pub channels: Vec<Channel>,
    /// Seconds from reading the scene to the last field.
    pub seconds: f64,
    /// Program and machine.
    pub machine: Machine,
    /// The other files of the folder.
    pub files: Vec<String>,
}

/// The settings of a run, in the units of the scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    missing_docs,
    reason = "named and explained in docs/result.md, and as in the scene file"
)]
pub struct SettingsEntry {
    pub method: Method,
    pub target_error: f64,
    pub sigma_um: Option<f64>,
    pub step: Option<f64>,
    pub period: f64,
    pub mode_threshold: f64,
    pub footprint_threshold: f64,
    pub correction: Correction,
    pub padding: f64,
    pub nufft_tolerance: f64,
    pub paper: PaperEntry,
    pub seed: u64,
    pub memory_limit_mb: f64,
}

/// The settings of the paper's method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    missing_docs,
    reason = "named and explained in docs/result.md, and as in the scene file"
)]
pub struct PaperEntry {
    pub rays: usize,
    pub secondary: usize,
    pub patch_um: Option<f64>,
    pub window: TileWindow,
    pub padding: f64,
    pub orders: usize,
    pub positions: Positions,
    pub coverage: bool,
    pub density: Density,
    pub sampler: Sampler,
    pub sag: Sag,
    pub obliquity: bool,
}

/// The mark of an expected error that misses the target, in words; empty for others.
pub fn above_target(error: f64, target_error: f64) -> String {
    match misses(error, target_error) {
        true => format!(" (above the target {target_error:.0e})"),
        false => String::new(),
    }
}

impl Report {
    /// The document of a run that the program's `verb` made, without the names of its other files.
    pub fn new(
        verb: &str,
        scene: &Scene,
        settings: &Settings,
        channels: Vec<Channel>,
        seconds: f64,
    ) -> Self {
        Self {
            version: VERSION,
            verb: verb.to_owned(),
            title: scene.title.clone(),
            scene: scene.origin.file.display().to_string(),
            settings: SettingsEntry::new(settings),
            channels,
            seconds,
            machine: Machine::here(),
            files: Vec::new(),
        }
    }
}

impl SettingsEntry {
    /// The entry of these settings.
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            method: settings.method,
            target_error: settings.target_error,
            sigma_um: settings.sigma.map(|sigma| sigma * UM),
            step: settings.step,
            period: settings.patch_period(),
            mode_threshold: settings.weakest_mode(),
            footprint_threshold: settings.footprint_edge(),
            correction: settings.correction,
            padding: settings.padding,
            nufft_tolerance: settings.nufft_tolerance,
            paper: PaperEntry::new(&settings.paper),
            seed: settings.seed,
            memory_limit_mb: settings.memory_limit as f64 * 1e-6,
        }
    }
}

impl PaperEntry {
    fn new(paper: &Paper) -> Self {
        Self {
            rays: paper.rays,
            secondary: paper.secondary,
            patch_um: paper.patch.map(|patch| patch * UM),
            window: paper.window,
            padding: paper.padding,
            orders: paper.orders,
            positions: paper.positions,
            coverage: paper.coverage,
            density: paper.density,
            sampler: paper.sampler,
            sag: paper.sag,
            obliquity: paper.obliquity,
        }
    }
}
