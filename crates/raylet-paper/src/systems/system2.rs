//! System 2 of the source paper: a hologram close to its sensor, nothing between.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::f64::consts::TAU;
use std::time::Instant;

use ndarray::{Array2, Zip};
use num_complex::Complex64;
use raylet::design::holograms::near::{NearSpace, NearTask, design};
use raylet::engine::chain::reference::{ReferenceOptions, reference};
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::{Paper, Positions, Sampler, Settings};
use raylet::file::arrays::phase_file::npy;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::system::System;
use raylet_testkit::paper_systems::{NEAR, PITCH, WAVELENGTH, near_hologram, open};
use raylet_testkit::smiley::smiley;

use crate::study::{Effort, Study};
use crate::study_error::StudyError;
use crate::systems::method_comparison::{Cost, MethodRun, Shown, figure, light};
use crate::systems::system_table::{Board, DrawnRun, Rod, by_paper, in_parts, once};

/// Periods of the angular spectrum over the hologram: the paper's, and one whose copies are far.
const PADDINGS: [usize; 2] = [2, 8];

/// Designs the hologram, carries its light by every method, and compares them.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn system2(effort: Effort) -> Result<Study, StudyError> {
    // Pixels along each side of hologram and sensor.
    let count = if effort.quick { 40 } else { 100 };
    let target = smiley(count);
    let task = NearTask {
        wavelength: WAVELENGTH,
        pitch: PITCH,
        distance: NEAR,
        amplitude: open(count),
        target: target.clone(),
        iterations: if effort.quick { 40 } else { 500 },
    };
    let (phase, _) = design(&task, &mut |_, _| {})?;
    let points = near_hologram(&phase, PixelForm::Point);
    let boxes = near_hologram(&phase, PixelForm::Box);

    // The field of the pixels' own band, and what real pixels do.
    let [near, wide] = PADDINGS.map(|padding| spectrum(&task, &phase, padding));
    let real = directly(&boxes)?;
    let rods = [
        Rod {
            name: "spectrum, period 2",
            field: near.field.view(),
        },
        Rod {
            name: "spectrum, period 8",
            field: wide.field.view(),
        },
        Rod {
            name: "Rayleigh–Sommerfeld, box pixels",
            field: real.field.view(),
        },
    ];
    let mut runs = vec![wide.clone(), real.clone()];
    runs.extend(methods(&points, effort)?);
    runs.push(once(
        "default: free hop, box pixels",
        &boxes,
        &Settings::default(),
        effort.display,
    )?);
    let mut board = Board::default();
    board.add(&near, &[], Some(&target));
    for run in &runs {
        board.add(run, &rods, Some(&target));
    }
    let image = picture(&near, &runs)?;
    let files = vec![
        (String::from("system2.png"), image),
        (String::from("system2.npy"), npy(&phase)?),
    ];
    Ok(board.study(
        &format!("System 2: a hologram of {count}² pixels, 1.26 mm before its sensor"),
        &notes(),
        files,
    ))
}

/// What disagrees.
fn notes() -> String {
    let (half, far) = (50.0 * PITCH, NEAR);
    format!(
        "The text gives an NA of 0.5; at {far} mm (the code) the edge is seen under {:.3}, and pixels of {:.1} µm \
         turn light by {:.4} at most.\nThe phase is our own (Gerchberg–Saxton on the angular spectrum); the \
         paper's is not to be had.\n",
        half.atan2(far).sin(),
        1e3 * PITCH,
        0.5 * WAVELENGTH / PITCH,
    )
}

/// The angular spectrum of the pixels' own band.
fn spectrum(task: &NearTask, phase: &Array2<f64>, padding: usize) -> MethodRun {
    let clock = Instant::now();
    let field = Zip::from(&task.amplitude)
        .and(phase)
        .map_collect(|size, phase| Complex64::from_polar(*size, phase.rem_euclid(TAU)));
    let space = NearSpace::new(WAVELENGTH, PITCH, NEAR, phase.ncols(), padding);
    MethodRun {
        name: format!("angular spectrum, period {padding}"),
        field: space.carry(field.view()),
        cost: Cost::since(clock, 0),
        standard_error: None,
    }
}

/// The direct sum over box pixels.
fn directly(boxes: &System) -> Result<MethodRun, StudyError> {
    let clock = Instant::now();
    let choice = ReferenceOptions {
        approach: Approach::RayleighSommerfeld,
        ..ReferenceOptions::default()
    };
    let found = reference(boxes, &Settings::default(), choice, &|_| {})?;
    Ok(MethodRun {
        name: String::from("Rayleigh–Sommerfeld sum, box pixels"),
        field: found.field.values,
        cost: Cost::since(clock, 0),
        standard_error: None,
    })
}

/// The paper's method: with all modes, by its code of the whole element, by its code of patches, by its text.
fn methods(points: &System, effort: Effort) -> Result<Vec<MethodRun>, StudyError> {
    let width = points.screens[0].bounds().map_or(0.0, |b| b[1] - b[0]);
    let whole = |sampler, secondary| Paper {
        rays: 1,
        secondary,
        patch: Some(width),
        positions: Positions::Grid,
        sampler,
        ..Paper::default()
    };
    let patches = |rays, secondary, patch: f64, padding| Paper {
        rays,
        secondary,
        patch: Some(patch),
        padding,
        ..Paper::default()
    };
    let share = |count: usize| if effort.quick { count / 64 } else { count };
    let all = by_paper(whole(Sampler::All, 1));
    let draws = share(1 << 21);
    let code = patches(share(16_384), 10_000, 0.5 * width, 3.92);
    let text = patches(128, if effort.quick { 1000 } else { 8000 }, width, 2.0);
    let by = |name: &str, paper: Paper, parts| {
        let run = DrawnRun {
            name,
            system: points,
            paper: &paper,
            parts,
        };
        in_parts(&run, effort, &mut |_| {})
    };
    Ok(vec![
        once(
            "paper's method, whole element, all modes",
            points,
            &all,
            effort.display,
        )?,
        by(
            "paper's method, whole element (code)",
            whole(Sampler::Multinomial, draws),
            1,
        )?,
        by("paper's method, patches of 50 pixels (code)", code, 16)?,
        by("paper's method, patches of 100 pixels (text)", text, 8)?,
    ])
}

/// The reference, the paper's method in its two published forms, and ours.
fn picture(near: &MethodRun, runs: &[MethodRun]) -> Result<Vec<u8>, StudyError> {
    let half = 0.5 * near.field.ncols() as f64 * PITCH;
    let shown = |run: &MethodRun| Shown {
        title: run.name.clone(),
        note: String::new(),
        values: light(run.field.view()),
        edges: [[-half, half]; 2],
    };
    let others: Vec<Shown> = runs.iter().map(shown).collect();
    let mut first = vec![shown(near)];
    let (upper, lower) = others.split_at(others.len() / 2);
    first.extend(upper.iter().cloned());
    Ok(figure(
        "System 2: intensity on the sensor",
        vec![first, lower.to_vec()],
        Vec::new(),
    )?)
}
