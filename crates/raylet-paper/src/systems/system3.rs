//! System 3 of the source paper: a hologram before a plano-convex lens.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::design::holograms::hologram::{HologramTask, design};
use raylet::design::losses::target::Target;
use raylet::engine::chain::reference::{ReferenceOptions, reference};
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::{Paper, Sampler, Settings};
use raylet::file::arrays::phase_file::npy;
use raylet::optics::paraxial::Abcd;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::ncc;
use raylet_plot::chart_panel::Series;
use raylet_testkit::paper_systems::{PITCH, WAVELENGTH, lens_hologram, open};
use raylet_testkit::smiley::smiley;

use crate::study::{Effort, Study};
use crate::study_error::StudyError;
use crate::systems::method_comparison::{Cost, Match, MethodRun, Shown, figure, light};
use crate::systems::system_table::{Board, DrawnRun, Rod, by_paper, in_parts, once};

/// Pixels along each side of hologram and sensor.
const COUNT: usize = 200;

/// Sizes of the study.
struct Sizes {
    iterations: usize,
    /// Positions for the two designs, draws at each, and parts.
    positions: [usize; 2],
    draws: usize,
    parts: usize,
    /// Positions at which every mode is followed.
    thorough: usize,
}

impl Sizes {
    fn new(quick: bool) -> Self {
        if quick {
            return Self {
                iterations: 30,
                positions: [200, 100],
                draws: 2000,
                parts: 2,
                thorough: 9,
            };
        }
        Self {
            iterations: 300,
            positions: [400_000, 100_000],
            draws: 10_000,
            parts: 20,
            thorough: 2500,
        }
    }
}

/// What became of one design.
struct Design {
    runs: Vec<MethodRun>,
    curves: [Series; 2],
}

/// Designs the hologram for two trains, carries its light by every method, and compares them.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn system3(effort: Effort) -> Result<Study, StudyError> {
    let sizes = Sizes::new(effort.quick);
    let target = smiley(COUNT);
    let mut board = Board::default();
    let mut designs = Vec::new();
    let mut files = Vec::new();
    let names = ["lens taken to be thin", "principal planes"];
    for ((number, name), positions) in names.iter().enumerate().zip(sizes.positions) {
        let phase = found(&sizes, number == 0)?;
        files.push((
            format!("system3-{}.npy", ["thin", "principal"][number]),
            npy(&phase)?,
        ));
        let work = Work {
            sizes: &sizes,
            positions,
            effort,
        };
        let design = carried(name, &phase, &target, work)?;
        for run in &design.runs {
            let rods = [Rod {
                name: "default: beamlets",
                field: design.runs[0].field.view(),
            }];
            board.add(run, &rods, Some(&target));
        }
        designs.push(design);
    }
    files.insert(0, (String::from("system3.png"), picture(&target, designs)?));
    let notes = "Pixels are points, as in the paper; \"box pixels\" is what a real element does.\nThe phases are \
                 our own (Gerchberg–Saxton on the paraxial train); the paper's is not to be had.\n";
    Ok(board.study(
        "System 3: a hologram of 200² pixels before the LA1131-A",
        notes,
        files,
    ))
}

/// The phase that shows the picture on the paraxial train, or on that of a thin lens.
fn found(sizes: &Sizes, thin: bool) -> Result<Array2<f64>, StudyError> {
    let blank = lens_hologram(&Array2::zeros((COUNT, COUNT)), PixelForm::Box);
    let Some(hop) = blank.hops().next() else {
        return Err(StudyError::from("a system without a hop"));
    };
    let train = if thin {
        Abcd::between_as_thin_lens(&hop)?
    } else {
        Abcd::between(&hop)?
    };
    let size = [COUNT as f64 * PITCH; 2];
    let task = HologramTask {
        wavelength: WAVELENGTH,
        train,
        pitch: [PITCH; 2],
        incident: open(COUNT).mapv(Complex64::from),
        target: Target {
            image: smiley(COUNT / 2),
            size,
            blur: [0.0; 2],
        },
        sensor: size,
        iterations: sizes.iterations,
        efficiency: 0.0,
    };
    Ok(design(&task, &mut |_| {})?.phase)
}

/// How much work a design gets.
#[derive(Clone, Copy)]
struct Work<'a> {
    sizes: &'a Sizes,
    /// Positions of the paper's method.
    positions: usize,
    effort: Effort<'a>,
}

/// A design through the real lens: by beamlets, without rays, and by the paper's method.
fn carried(
    name: &str,
    phase: &Array2<f64>,
    target: &Array2<f64>,
    work: Work,
) -> Result<Design, StudyError> {
    let Work {
        sizes,
        positions,
        effort,
    } = work;
    let (points, boxes) = (
        lens_hologram(phase, PixelForm::Point),
        lens_hologram(phase, PixelForm::Box),
    );
    let named = |what: &str| format!("{name}: {what}");
    let by = |what: &str, system: &System, settings: &Settings| {
        once(&named(what), system, settings, effort.display)
    };
    let ours = by("default, beamlets", &points, &Settings::default())?;
    let real = by("default, box pixels", &boxes, &Settings::default())?;
    let paraxial = collins(&named("Collins"), &points)?;
    let patches = Paper {
        rays: positions,
        secondary: sizes.draws,
        patch: Some(100.0 * PITCH),
        ..Paper::default()
    };
    let thorough = Paper {
        rays: sizes.thorough,
        coverage: true,
        sampler: Sampler::All,
        ..patches.clone()
    };
    let all = by("paper's method, all modes", &points, &by_paper(thorough))?;

    // The paper's method, and how it converges.
    let (mut likeness, mut errors) = (Vec::new(), Vec::new());
    let run = DrawnRun {
        name: &named("paper's method"),
        system: &points,
        paper: &patches,
        parts: sizes.parts,
    };
    let drawn = in_parts(&run, effort, &mut |so_far| {
        let draws = so_far.cost.draws;
        let shown = light(so_far.field.view());
        let score = ncc(shown.view(), target.view());
        let error = Match::of(so_far.field.view(), ours.field.view()).shape_error;
        likeness.push([draws, score.unwrap_or(f64::NAN)]);
        errors.push([draws, error.unwrap_or(f64::NAN)]);
    })?;
    let curves = [Series::line(name, likeness), Series::line(name, errors)];
    Ok(Design {
        runs: vec![ours, real, paraxial, all, drawn],
        curves,
    })
}

/// Collins' integral: the paraxial train without aberrations.
fn collins(name: &str, system: &System) -> Result<MethodRun, StudyError> {
    let clock = Instant::now();
    let choice = ReferenceOptions {
        approach: Approach::Collins,
        ..ReferenceOptions::default()
    };
    let found = reference(system, &Settings::default(), choice, &|_| {})?;
    Ok(MethodRun {
        name: name.to_owned(),
        field: found.field.values,
        cost: Cost::since(clock, 0),
        standard_error: None,
    })
}

/// For each design the target picture, ours, all modes of the paper's method and its draws; below them how it
/// converges.
fn picture(target: &Array2<f64>, designs: Vec<Design>) -> Result<Vec<u8>, StudyError> {
    let half = 0.5 * COUNT as f64 * PITCH;
    let shown = |title: &str, values: Array2<f64>| Shown {
        title: title.to_owned(),
        note: String::new(),
        values,
        edges: [[-half, half]; 2],
    };
    let (mut rows, mut scores, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    for design in designs {
        let mut row = vec![shown("target", target.clone())];
        for number in [0, 3, 4] {
            let run = &design.runs[number];
            row.push(shown(&run.name, light(run.field.view())));
        }
        rows.push(row);
        let [score, error] = design.curves;
        scores.push(score);
        errors.push(error);
    }
    let title = "System 3: intensity on the sensor";
    let curves = vec![("NCC with the picture", scores), ("shape error", errors)];
    Ok(figure(title, rows, curves)?)
}
