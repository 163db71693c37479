//! One beamlet of a patch aimed at the target: where it lands, its shape there, and whether it is accurate
//! enough. Nothing of this depends on the field.

use crate::engine::beamlet::aberration_sample::AberrationSamples;
use crate::engine::beamlet::beamlet_aberration::Aberration;
use crate::engine::beamlet::beamlet_error::TRUSTED_TAIL;
use crate::engine::beamlet::beamlet_launch::{launch_beamlet_from, launch_beamlets_from};
use crate::engine::beamlet::discarded_tail::{LeavingBeamlet, discarded_tail_share};
use crate::engine::chain::backend::Job;
use crate::engine::error::tally::Fate;
use crate::engine::trace::launch_plane::LaunchPlane;
use crate::optics::ray::Loss;
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::wavelet::Arrival;

/// A beamlet that reaches the target.
pub(crate) struct TargetBeamlet {
    /// The beamlet of coefficient one, the correction of its aberration included.
    pub arrival: Arrival,
    /// Whether the aberration inside it had to be sampled.
    pub needed: bool,
    /// What was found then; nothing where its neighbours are lost.
    pub found: Option<Aberration>,
}

/// A beamlet that adds nothing to the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiscardedBeamlet {
    /// What became of it.
    pub fate: Fate,
    /// The share of its energy that its tail would bring to the target where the light ends, by real rays.
    pub share: f64,
    /// The share of its energy that falls on the target beyond the end of its footprint where the light ends.
    pub cut: f64,
}

impl From<Fate> for DiscardedBeamlet {
    fn from(fate: Fate) -> Self {
        Self {
            fate,
            share: 0.0,
            cut: 0.0,
        }
    }
}

/// Where the beamlets of a patch leave.
pub(crate) struct LaunchPlanes {
    /// On the hop that was planned.
    launch_plane: LaunchPlane,
    /// On the hop itself, if it is another one.
    moved: Option<LaunchPlane>,
}

impl LaunchPlanes {
    /// The launch plane above (x, y) of the first screen of a job.
    ///
    /// # Errors
    /// [`Loss::Missed`] where a curved screen does not exist.
    pub(crate) fn new(job: &Job, at: [f64; 2]) -> Result<Self, Loss> {
        let moved = job.planned.map(|_| LaunchPlane::new(job.hop.from, at));
        Ok(Self {
            launch_plane: LaunchPlane::new(job.chooser().from, at)?,
            moved: moved.transpose()?,
        })
    }

    /// Beamlets of coefficient one in these modes on the hop that was planned, where they land.
    pub(crate) fn landed(&self, job: &Job, modes: &[[usize; 2]]) -> Vec<Result<Arrival, Loss>> {
        let directions: Vec<_> = modes.iter().map(|mode| direction(job, *mode)).collect();
        let sigma = job.plan.sigma;
        launch_beamlets_from(&self.launch_plane, job.chooser(), &directions, sigma)
    }

    /// The launch plane on the hop itself.
    pub(crate) fn launch_plane(&self) -> &LaunchPlane {
        self.moved.as_ref().unwrap_or(&self.launch_plane)
    }
}

/// Optical direction cosines of a mode.
fn direction(job: &Job, mode: [usize; 2]) -> [f64; 2] {
    let [bx, by] = &job.plan.bands;
    [bx.at(mode[0]), by.at(mode[1])]
}

/// Aims one beamlet, which [`LaunchPlanes::landed`] let land; its aberration is sampled if something depends on it.
///
/// # Errors
/// Its fate when it does not reach the target, or is not accurate there.
pub(crate) fn target_beamlet(
    job: &Job,
    LaunchPlanes {
        launch_plane,
        moved,
    }: &LaunchPlanes,
    (mode, landed): ([usize; 2], Result<Arrival, Loss>),
    to: &Canvas,
    samples: &mut AberrationSamples,
) -> Result<TargetBeamlet, DiscardedBeamlet> {
    let k = job.hop.wavenumber();
    let p = direction(job, mode);
    let mut arrival = landed.map_err(Fate::Lost)?;
    let edge = job.settings.footprint_edge();
    if !to.meets(&arrival, k, edge) {
        return Err(DiscardedBeamlet {
            cut: match job.downstream.ends_here() {
                true => to.cut(&arrival, k, edge),
                false => 0.0,
            },
            ..Fate::Outside.into()
        });
    }

    // The aberration inside the beamlet is corrected, or is a reason to leave it out.
    let beside = !to.contains(arrival.at);
    let needed = job.plan.correct || (beside && job.plan.doubtful_rim);
    let found = if needed { samples.between(mode) } else { None };
    if needed && beside && found.is_none_or(|found| found.eta() > TRUSTED_TAIL) {
        let leaving = LeavingBeamlet {
            launch_plane,
            p,
            sigma: job.plan.sigma,
        };
        let share =
            || discarded_tail_share(job.chooser(), &leaving, to.bounds(), to.tail(&arrival, k));
        return Err(DiscardedBeamlet {
            fate: Fate::Unresolved,
            share: if job.downstream.ends_here() {
                share()
            } else {
                0.0
            },
            cut: 0.0,
        });
    }
    if let Some(moved) = moved {
        arrival = launch_beamlet_from(moved, &job.hop, p, job.plan.sigma).map_err(Fate::Lost)?;
    }
    if let Some(found) = found
        && job.plan.correct
    {
        arrival.amplitude *= found.correction();
    }
    Ok(TargetBeamlet {
        arrival,
        needed,
        found,
    })
}
