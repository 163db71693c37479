//! What a reference did, as `result.json` has it.

use serde::{Deserialize, Serialize};

use crate::engine::chain::reference::ReferenceStep;

/// One step of a reference: a hop, or the whole system where rays are followed along smooth phases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepEntry {
    /// Name of its first screen.
    pub from: String,
    /// Name of its last screen.
    pub to: String,
    /// The method's name.
    pub method: String,
    /// Why this method: that it was chosen, or what stands against those before it.
    #[serde(default)]
    pub why: String,
    /// What the method leaves out; empty when nothing.
    pub neglects: String,
    /// Samples of the field on the first screen, [ny, nx]; zero where no field is needed.
    pub samples: [usize; 2],
    /// ∫|U|² in mm² for unit amplitude, before the first screen acts, behind it, and on the last screen.
    pub power: [Option<f64>; 3],
    /// Plane waves of a spectrum, node–point pairs of a direct sum, nodes of a Collins integral, or rays.
    pub work: f64,
    /// Sensor pixels left dark because they are too close to a focus or caustic.
    pub unresolved_pixels: u64,
    /// Seconds it took.
    pub seconds: f64,
}

impl StepEntry {
    /// The entry of a step.
    pub(crate) fn new(step: &ReferenceStep) -> Self {
        let [from, to] = step.screens.clone();
        Self {
            from,
            to,
            method: step.approach.name().to_owned(),
            why: step.why.clone(),
            neglects: step.neglects.to_owned(),
            samples: step.samples,
            power: step.power,
            work: step.work,
            unresolved_pixels: step.unresolved,
            seconds: step.seconds,
        }
    }

    /// The step in one line.
    pub fn line(&self) -> String {
        let mut line = format!(
            "{} to {}: {} ({})",
            self.from, self.to, self.method, self.why
        );
        if !self.neglects.is_empty() {
            line += &format!(", without {}", self.neglects);
        }
        if self.unresolved_pixels > 0 {
            let count = self.unresolved_pixels;
            line += &format!("; {count} pixels dark, too close to a focus or caustic");
        }
        line + &format!(", {:.2} s", self.seconds)
    }
}
