//! The search for a mirror's pixels, which several studies use. Checkpoints let a stopped search go on.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::path::Path;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::design::mirrors::mirror::MirrorEvaluation;
use raylet::design::optimizers::lbfgs::LbfgsSettings;
use raylet::design::optimizers::optimizer::{Method, Optimizer};
use raylet::design::optimizers::space::Space;
use raylet::design::optimizers::step::Step;
use raylet::design::run::State;
use raylet::engine::chain::outcome::Progress;
use raylet::file::storage::checkpoint::Checkpoints;
use raylet::file::storage::own_file::Replace;
use raylet::wave::grid::metrics::ncc;
use serde::{Deserialize, Serialize};

use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show};
use crate::mirrors::conformal_seen::Seen;
use crate::mirrors::mirror_chart::MirrorChart;
use crate::mirrors::mirror_design::MirrorSearch;
use crate::progress_display::ProgressDisplay;
use crate::study::Effort;
use crate::study_error::StudyError;

/// Iterations between two checkpoints.
const KEEP: usize = 5;

/// A search as it stands.
#[derive(Clone, Serialize, Deserialize)]
struct Saved {
    search: Optimizer,
    evaluations: usize,
    seconds: f64,
    /// Iteration and score.
    course: Vec<[f64; 2]>,
}

/// A mirror whose pixels were designed.
pub(crate) struct Sought {
    pub(crate) mirror: Conformal,
    pub(crate) aperture: LitArea,
    pub(crate) search: MirrorSearch,
    /// The phases that were found.
    pub(crate) phases: Vec<f64>,
    pub(crate) iterations: usize,
    pub(crate) evaluations: usize,
    /// Seconds of the search, whenever it ran.
    pub(crate) seconds: f64,
    course: Vec<[f64; 2]>,
}

/// Seeks the pixels of a mirror in so many iterations.
pub(crate) fn seek(
    name: &str,
    mirror: Conformal,
    aperture: LitArea,
    iterations: usize,
    effort: Effort,
) -> Result<Sought, StudyError> {
    let clock = Instant::now();
    let search = MirrorSearch::new(&mirror, aperture)?;
    let fresh = fresh(&search)?;
    let kept = effort.keep.map(|keep| {
        let description = format!("{name} {mirror:?} {aperture:?}");
        let bytes = State::saved_bytes(&fresh.search, iterations);
        Checkpoints::within(&keep.join(name), &description, bytes)
    });
    let mut saved = begin(kept.as_ref(), fresh)?;
    let earlier = saved.seconds;
    let mut steps = (effort.display).search(name, saved.search.iteration(), iterations);
    while saved.search.iteration() < iterations {
        let evaluation = search.design.evaluate(saved.search.point());
        let step = saved.search.report(evaluation.value, &evaluation.gradient);
        saved.evaluations += 1;
        saved.seconds = earlier + clock.elapsed().as_secs_f64();
        if let Step::Finished(_) = step {
            break;
        }
        if step != Step::Accepted {
            continue;
        }
        let (done, score) = (
            saved.search.iteration(),
            score(&mirror, &search, &evaluation),
        );
        saved.course.push([done as f64, score]);
        steps.note(done, &format!("{} {score:.4}", score_name(mirror.show)));
        if let Some(kept) = kept.as_ref().filter(|_| done.is_multiple_of(KEEP)) {
            kept.write(&saved)?;
        }
    }
    steps.end();
    let best = saved.search.best().map(|(point, _)| point.to_vec());
    Ok(Sought {
        phases: best.unwrap_or_else(|| search.start.clone()),
        mirror,
        aperture,
        search,
        iterations: saved.search.iteration(),
        evaluations: saved.evaluations,
        seconds: saved.seconds,
        course: saved.course,
    })
}

/// The search at its start.
fn fresh(search: &MirrorSearch) -> Result<Saved, StudyError> {
    let settings = LbfgsSettings {
        memory: 10,
        first: 0.1 * (search.start.len() as f64).sqrt(),
        ..LbfgsSettings::default()
    };
    let space = Space::free(search.start.len());
    Ok(Saved {
        search: Method::Lbfgs(settings).start(search.start.clone(), space)?,
        evaluations: 0,
        seconds: 0.0,
        course: Vec::new(),
    })
}

/// The search where it was, or at its start.
fn begin(kept: Option<&Checkpoints>, fresh: Saved) -> Result<Saved, StudyError> {
    let Some(kept) = kept else {
        return Ok(fresh);
    };
    let check = |saved: &Saved| {
        let checked = saved.search.check(&fresh.search);
        checked.map_err(|error| error.to_string())
    };
    match kept.read(check) {
        Ok(before) => Ok(before.state),
        Err(_) => kept
            .claim(Replace::Own)
            .map(|()| fresh)
            .map_err(StudyError::from),
    }
}

/// Likeness to the letter, or the share of the light in the samples at the foci.
fn score(mirror: &Conformal, search: &MirrorSearch, evaluation: &MirrorEvaluation) -> f64 {
    match mirror.show {
        Show::Letter => ncc(evaluation.shares.view(), search.target.view()).unwrap_or(0.0),
        Show::Foci => {
            let lit = evaluation.shares.iter().zip(&search.target);
            lit.filter(|(_, target)| **target > 0.0)
                .map(|(share, _)| share)
                .sum()
        }
    }
}

fn score_name(show: Show) -> &'static str {
    match show {
        Show::Letter => "NCC",
        Show::Foci => "light at the foci's samples",
    }
}

impl Sought {
    /// The reflections of the pixels, [y, x].
    pub(crate) fn values(&self) -> Array2<Complex64> {
        self.search.design.reflections(&self.phases)
    }

    /// The phases as arrays of pixels, [y, x].
    pub(crate) fn arrays(&self) -> Vec<Array2<f64>> {
        let count = self.mirror.count();
        let part =
            |phases: &[f64]| Array2::from_shape_fn((count, count), |(j, i)| phases[j * count + i]);
        self.phases.chunks(count * count).map(part).collect()
    }

    /// What the direct integral says of these reflections.
    pub(crate) fn seen(
        &self,
        name: &str,
        values: &Array2<Complex64>,
        display: &dyn ProgressDisplay,
    ) -> Result<Seen, StudyError> {
        let (meter, label) = (display.run(), format!("{name}, direct integral, "));
        let note = |progress: Progress| meter(&label, progress);
        Ok(Seen::directly(&self.mirror, values, self.aperture, &note)?)
    }

    /// The picture of these reflections.
    pub(crate) fn png(
        &self,
        title: &str,
        values: &Array2<Complex64>,
        seen: &Seen,
    ) -> Result<Vec<u8>, StudyError> {
        let open = |(j, i): (usize, usize)| {
            let [x, y] = [i, j].map(|n| self.mirror.place(n));
            self.aperture == LitArea::Square || x.hypot(y) <= 0.5 * self.mirror.width()
        };
        let shown = Array2::from_shape_fn(values.dim(), |at| match open(at) {
            true => values[at],
            false => Complex64::ZERO,
        });
        let shares = self.search.design.shares(values.view());
        let chart = MirrorChart {
            title,
            mirror: &self.mirror,
            values: &shown,
            shares: &shares,
            pitch: self.search.sensor.pitch,
            target: &self.search.target,
            seen,
            course: (score_name(self.mirror.show), self.course.clone()),
        };
        Ok(chart.png()?)
    }
}

/// Forgets what searches of these names kept.
pub(crate) fn forget(keep: Option<&Path>, names: &[&str]) -> Result<(), StudyError> {
    let folders = names
        .iter()
        .filter_map(|name| keep.map(|keep| keep.join(name)));
    for folder in folders {
        Checkpoints::within(&folder, "", 0).remove()?;
    }
    Ok(())
}
