//! One run of a document: one wavelength, and in a sweep one field of light and one distance of the sensor.

#![expect(
    clippy::indexing_slicing,
    reason = "rims number the hops they were found in"
)]

use serde::{Deserialize, Serialize};

use crate::engine::chain::outcome::Outcome;
use crate::engine::chain::reference::Reference;
use crate::engine::error::run_warnings::{misses, run_warnings};
use crate::engine::plan::settings::Settings;
use crate::file::result::hop_entry::HopEntry;
use crate::file::result::light_metrics::Metrics;
use crate::file::result::reference_step::StepEntry;
use crate::file::result::rim::RimEntry;
use crate::optics::system::System;

/// A wavelength in micrometres, to 1e-12 µm, so that it reads as the scene states it.
pub fn micrometres(wavelength: f64) -> f64 {
    (wavelength * 1e15).round() / 1e12
}

/// One wavelength of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Where the light comes from and the sensor stands, in a sweep.
    #[serde(flatten)]
    pub place: Place,
    /// Vacuum wavelength in micrometres.
    pub wavelength_um: f64,
    /// Its hops from screen to screen.
    pub hops: Vec<HopEntry>,
    /// The steps of a reference, which has no hops.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepEntry>,
    /// Expected relative error of the complex field: the root of the hops' squares; none where one of
    /// them has none.
    pub error: Option<f64>,
    /// Whether that error reaches the target; none where there is none.
    #[serde(default)]
    pub target_reached: Option<bool>,
    /// Share of the light behind the first screen that the sensor receives; none for a first screen without an edge.
    #[serde(default)]
    pub light_share: Option<f64>,
    /// Power, peak and spot on the sensor.
    pub metrics: Metrics,
    /// Seconds it took, its plan among them.
    #[serde(default)]
    pub seconds: f64,
    /// What a user must know of this result; empty where all is well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// What a sweep varies beside the wavelength; nothing where it was not varied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Direction of collimated light in degrees, as in `[source]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<[f64; 2]>,
    /// Place of a point source in mm, as in `[source]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_mm: Option<[f64; 3]>,
    /// Distance of the sensor from the element before it in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

impl Channel {
    /// The entry of a simulated wavelength that took so many seconds.
    pub fn new(outcome: &Outcome, settings: &Settings, seconds: f64) -> Self {
        // As it was run: rims that are screens have hops of their own.
        let system = &outcome.rimmed.system;
        let mut hops: Vec<HopEntry> = system
            .hops()
            .zip(&outcome.hops)
            .map(|(hop, report)| HopEntry::new(&hop, report, settings))
            .collect();
        for rim in &outcome.rimmed.rims {
            hops[rim.hop].rims.push(RimEntry::new(rim));
        }
        let totals = hops.iter().map(|hop| hop.error.map(|error| error.total));
        let squares: Option<f64> = totals.map(|total| Some(total?.powi(2))).sum();
        let error = squares.map(f64::sqrt);
        let powers: Vec<_> = (hops.iter())
            .map(|hop| [hop.power.behind, hop.power.landed])
            .collect();
        Self {
            place: Place::default(),
            wavelength_um: micrometres(system.wavelength),
            error,
            target_reached: error.map(|error| !misses(error, settings.target_error)),
            light_share: light_share(&powers),
            hops,
            steps: Vec::new(),
            metrics: Metrics::of(&outcome.field),
            seconds,
            warnings: run_warnings(outcome, settings),
        }
    }

    /// The entry of a wavelength's reference, which took so many seconds.
    pub fn of_reference(system: &System, reference: &Reference, seconds: f64) -> Self {
        let steps: Vec<StepEntry> = reference.steps.iter().map(StepEntry::new).collect();
        let powers: Vec<_> = (steps.iter())
            .map(|step| [step.power[1], step.power[2]])
            .collect();
        Self {
            place: Place::default(),
            wavelength_um: micrometres(system.wavelength),
            error: None,
            target_reached: None,
            light_share: light_share(&powers),
            hops: Vec::new(),
            steps,
            metrics: Metrics::of(&reference.field),
            seconds,
            warnings: Vec::new(),
        }
    }

    /// What tells this run from others of its document, such as "20°, 0°, λ = 0.55 µm".
    pub fn name(&self) -> String {
        self.place.before(format!("λ = {} µm", self.wavelength_um))
    }

    /// The methods that carried the light, each once, in the order of the hops.
    pub fn methods(&self) -> Vec<&str> {
        let hops = self.hops.iter().map(|hop| hop.plan.method.as_str());
        let steps = self.steps.iter().map(|step| step.method.as_str());
        let mut list = Vec::new();
        for method in hops.chain(steps) {
            if !list.contains(&method) {
                list.push(method);
            }
        }
        list
    }
}

impl Place {
    /// A text behind the words for this place.
    pub fn before(&self, text: String) -> String {
        let distance = self
            .distance_mm
            .map(|distance| format!("sensor at {distance} mm"));
        let parts = [self.light(), distance, Some(text)];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// The words for where the light comes from, if that is known.
    pub fn light(&self) -> Option<String> {
        let angle = self.angle_deg.map(|[x, y]| format!("{x}°, {y}°"));
        let position = || {
            let [x, y, z] = self.position_mm?;
            Some(format!("source at {x}, {y}, {z} mm"))
        };
        angle.or_else(position)
    }
}

/// The share of the light that the last screen receives, from the powers behind and at the end of each hop.
fn light_share(powers: &[[Option<f64>; 2]]) -> Option<f64> {
    let behind = powers.first()?[0]?;
    let landed = powers.last()?[1]?;
    (behind > 0.0).then(|| landed / behind)
}
