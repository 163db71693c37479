//! One hop of a run: its plan, its rays, its power and its error, as `result.json` has them.

use serde::{Deserialize, Serialize};

use crate::engine::beamlet::beamlet_plan::BeamletPlan;
use crate::engine::chain::outcome::HopReport;
use crate::engine::error::tally::{Fate, Tally};
use crate::engine::local_bands::settings::LocalBandPlan;
use crate::engine::monte_carlo::tangent_patch_error::TangentPatchError;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::method_reason::{method_name, reason};
use crate::engine::plan::settings::Settings;
use crate::file::result::rim::RimEntry;
use crate::optics::ray::Loss;
use crate::optics::system::Hop;
use crate::wave::patches::patch::Band;

/// Micrometres in a millimetre.
const UM: f64 = 1e3;

/// One hop from screen to screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HopEntry {
    /// Method of the hop, with its plan.
    pub plan: PlanEntry,
    /// Samples of the field on the first screen, [ny, nx]; nothing for local bands, which have no whole field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<[usize; 2]>,
    /// Rays by fate.
    pub rays: Fates<u64>,
    /// Energy by fate, as shares of all that the tally counted.
    pub energy_share: Fates<f64>,
    /// Values summed on the second screen.
    pub evaluations: u64,
    /// ∫|U|² in mm² for unit amplitude.
    pub power: Power,
    /// Expected error by cause; none for methods whose errors are not estimated.
    pub error: Option<ErrorEntry>,
    /// Standard error of the field from what was drawn at random, relative to the field; none where
    /// nothing was, or positions are not independent. It knows of no bias.
    #[serde(default)]
    pub standard_error: Option<f64>,
    /// Aberration inside beamlets, before and after correction.
    pub aberration: [f64; 2],
    /// The rims of its surfaces; the last of them may be the screen where it ends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rims: Vec<RimEntry>,
    /// Seconds it took.
    pub seconds: f64,
}

/// The plan of a hop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanEntry {
    /// Name of the first screen.
    pub from: String,
    /// Name of the second screen.
    pub to: String,
    /// The method's name.
    pub method: String,
    /// Why it was chosen.
    pub why: String,
    /// Directions along x and y; nothing for local bands, where each window has its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directions: Option<[Directions; 2]>,
    /// Rays that the plan expected.
    pub expected_rays: f64,
    /// The lattice of beamlets, where there are any.
    pub beamlets: Option<BeamletEntry>,
    /// The lattice of plane wavelets, where there are any.
    pub planes: Option<PlaneEntry>,
    /// The patches and modes of the paper's method, where it is used.
    pub paper: Option<DrawEntry>,
    /// The windows of local bands, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local_bands: Option<LocalBandEntry>,
}

/// The windows of a hop by local bands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalBandEntry {
    /// Width σ of the windows in micrometres.
    pub sigma_um: f64,
    /// Distance of windows in micrometres.
    pub step_um: f64,
    /// Period of their plane waves in micrometres.
    pub period_um: f64,
    /// Number of windows along x and y of the first screen's box.
    pub windows: [usize; 2],
    /// Whether each has the one direction of a smooth source.
    pub smooth: bool,
    /// Whether the aberration inside beamlets was corrected.
    pub corrected: bool,
}

/// The lattice of a sum of plane wavelets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneEntry {
    /// Width σ of the windows in micrometres.
    pub sigma_um: f64,
    /// Distance of windows along x and y in micrometres.
    pub steps_um: [f64; 2],
    /// Period of a patch in micrometres.
    pub period_um: f64,
}

/// What the paper's method draws in a hop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawEntry {
    /// Positions of patches.
    pub positions: usize,
    /// Modes drawn, or followed, at each.
    pub secondary: usize,
    /// Side of the patch in micrometres.
    pub side_um: f64,
    /// Its period in micrometres.
    pub period_um: f64,
    /// A warning where patches ignore the height of a curved screen; none where it does not matter.
    pub warning: Option<String>,
}

/// The directions of plane waves along one axis, as optical direction cosines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Directions {
    /// The lowest one.
    pub lowest: f64,
    /// The highest one.
    pub highest: f64,
    /// Number of directions.
    pub count: usize,
}

/// The lattice of a beamlet sum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeamletEntry {
    /// Width σ of the windows in micrometres.
    pub sigma_um: f64,
    /// Distance of windows in micrometres.
    pub step_um: f64,
    /// Period of a patch in micrometres.
    pub period_um: f64,
    /// Half width of a typical footprint on the second screen in micrometres.
    pub footprint_um: f64,
    /// Whether the aberration inside beamlets was corrected.
    pub corrected: bool,
    /// Seconds on one core that the plan expected.
    pub expected_seconds: f64,
    /// The error from aberration inside beamlets that the plan expected.
    pub expected_error: f64,
}

/// One number for each fate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    missing_docs,
    reason = "the fates of the tally, explained in docs/result.md"
)]
pub struct Fates<T> {
    pub arrived: T,
    pub outside: T,
    pub clipped: T,
    pub missed: T,
    pub total_reflection: T,
    pub evanescent: T,
    pub not_converged: T,
    pub below_threshold: T,
    pub unresolved: T,
    pub elsewhere: T,
}

/// Power through a hop, ∫|U|² in mm² for unit amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// Before the first screen acts, over its aperture; nothing for local bands, which have no whole field.
    pub before: Option<f64>,
    /// Just behind it; likewise.
    pub behind: Option<f64>,
    /// On the second screen; for local bands on the sensor alone.
    pub landed: Option<f64>,
}

/// Expected relative errors of the field, by cause.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorEntry {
    /// Aberration inside beamlets.
    pub aberration: f64,
    /// Windows and periods.
    pub windows: f64,
    /// Modes below the threshold.
    pub dropped: f64,
    /// Rims of curved surfaces that cut light.
    pub rims: f64,
    /// The root of the sum of squares.
    pub total: f64,
}

impl HopEntry {
    /// The entry of a hop.
    pub(crate) fn new(hop: &Hop, report: &HopReport, settings: &Settings) -> Self {
        let tally = &report.tally;
        let budget = report.budget();
        let [before, behind, landed] = report.power;
        Self {
            plan: PlanEntry::new(hop, &report.method, settings),
            samples: report.samples,
            rays: Fates::of(|fate| tally.rays(fate)),
            energy_share: Fates::of(|fate| tally.share(fate)),
            evaluations: tally.evaluations,
            power: Power {
                before,
                behind,
                landed,
            },
            error: budget.map(|budget| ErrorEntry {
                aberration: budget.aberration,
                windows: budget.windows,
                dropped: budget.dropped,
                rims: budget.rims,
                total: budget.total(),
            }),
            standard_error: tally.standard_error(),
            aberration: [Tally::eta, Tally::eta_corrected].map(|estimate| estimate(tally)),
            rims: Vec::new(),
            seconds: report.seconds,
        }
    }
}

impl PlanEntry {
    /// The entry of a hop's plan.
    pub fn new(hop: &Hop, method: &HopMethod, settings: &Settings) -> Self {
        let directions = |plan: &Plan| plan.bands().each_ref().map(Directions::of);
        let mut entry = Self {
            from: hop.from.name.clone(),
            to: hop.to.name.clone(),
            method: method_name(method).to_owned(),
            why: reason(hop, method, settings),
            directions: method.whole_field().map(directions),
            expected_rays: method.rays(),
            beamlets: None,
            planes: None,
            paper: None,
            local_bands: None,
        };
        let warning = TangentPatchError::of(hop, method).and_then(|flat| flat.warning());
        let plan = match method {
            HopMethod::WholeField(plan) => plan,
            HopMethod::LocalBands(plan) => {
                entry.local_bands = Some(LocalBandEntry::new(plan));
                return entry;
            }
        };
        match plan {
            Plan::Free(..) => {}
            Plan::Beamlets(plan) => entry.beamlets = Some(BeamletEntry::new(plan)),
            Plan::Planes(plan) => {
                entry.planes = Some(PlaneEntry {
                    sigma_um: plan.sigma * UM,
                    steps_um: plan.step.map(|step| step * UM),
                    period_um: plan.period * UM,
                });
            }
            Plan::Paper(plan) => {
                entry.paper = Some(DrawEntry {
                    positions: plan.positions,
                    secondary: (plan.rays() / plan.positions.max(1) as f64) as usize,
                    side_um: plan.side * UM,
                    period_um: plan.period * UM,
                    warning,
                });
            }
        }
        entry
    }
}

impl BeamletEntry {
    fn new(plan: &BeamletPlan) -> Self {
        Self {
            sigma_um: plan.sigma * UM,
            step_um: plan.step * UM,
            period_um: plan.period * UM,
            footprint_um: plan.footprint * UM,
            corrected: plan.correct,
            expected_seconds: plan.work.seconds,
            expected_error: plan.expected_error(),
        }
    }
}

impl LocalBandEntry {
    fn new(plan: &LocalBandPlan) -> Self {
        Self {
            sigma_um: plan.sigma * UM,
            step_um: plan.step * plan.sigma * UM,
            period_um: plan.period * plan.sigma * UM,
            windows: plan.windows,
            smooth: plan.smooth,
            corrected: plan.corrected,
        }
    }
}

impl Directions {
    fn of(band: &Band) -> Self {
        Self {
            lowest: band.at(0),
            highest: band.at(band.count.max(1) - 1),
            count: band.count,
        }
    }
}

impl<T> Fates<T> {
    fn of(of: impl Fn(Fate) -> T) -> Self {
        Self {
            arrived: of(Fate::Arrived),
            outside: of(Fate::Outside),
            clipped: of(Fate::Lost(Loss::Clipped)),
            missed: of(Fate::Lost(Loss::Missed)),
            total_reflection: of(Fate::Lost(Loss::TotalReflection)),
            evanescent: of(Fate::Lost(Loss::Evanescent)),
            not_converged: of(Fate::Lost(Loss::NotConverged)),
            below_threshold: of(Fate::Weak),
            unresolved: of(Fate::Unresolved),
            elsewhere: of(Fate::Elsewhere),
        }
    }
}
