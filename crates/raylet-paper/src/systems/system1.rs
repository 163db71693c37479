//! System 1 of the source paper: a weak grating over the whole of a plano-convex lens, near its focus.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::fmt::Write;
use std::ops::Range;
use std::time::Instant;

use raylet::engine::geometrical::maslov::{Strength, sum_of_directions};
use raylet::engine::plan::settings::{Method, Paper, Settings};
use raylet::optics::system::System;
use raylet_testkit::paper_systems::{GRATING_SENSOR, READINGS, Window, grating};

use crate::study::{Effort, Study};
use crate::study_error::StudyError;
use crate::systems::method_comparison::{Cost, MethodRun, Shown, figure, light};
use crate::systems::system_table::{Board, DrawnRun, Rod, in_parts, once};

/// Patch of the paper in mm, and its period over that: 40 pixels, padded to 156.
const PATCH: f64 = 40.0 * 6.3e-3;
const PADDING: f64 = 3.9;

/// Sizes of the study.
struct Sizes {
    radius: f64,
    sensor: Window,
    /// Rays along each axis of the references.
    reference: usize,
    /// Positions of the paper's method, by text and by released code, and draws at each.
    positions: [usize; 2],
    draws: usize,
    parts: usize,
    /// Pixels along each side of the part about the peak.
    part: usize,
}

impl Sizes {
    fn new(quick: bool) -> Self {
        if quick {
            return Self {
                radius: 1.5,
                sensor: Window {
                    count: 201,
                    pitch: 2.5e-3,
                    ..GRATING_SENSOR
                },
                reference: 200,
                positions: [2000, 400],
                draws: 200,
                parts: 2,
                part: 60,
            };
        }
        Self {
            radius: 12.7,
            sensor: GRATING_SENSOR,
            reference: 1156,
            positions: [1_640_000, 65_536],
            draws: 1000,
            parts: 20,
            part: 100,
        }
    }
}

/// Carries the light of the grating by every method, and compares them.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn system1(effort: Effort) -> Result<Study, StudyError> {
    let sizes = Sizes::new(effort.quick);
    let smooth = grating(sizes.radius, false, sizes.sensor);
    let named = [
        ("rays, by density of directions", Strength::Density),
        (
            "rays of equal strength (paper's reference)",
            Strength::Equal,
        ),
    ];
    let mut runs = Vec::new();
    for (name, strength) in named {
        runs.push(geometrical(name, &smooth, &sizes, strength)?);
    }

    // The default method on the part about the peak; on all pixels plane wavelets, whose cost does not grow
    // with them.
    let part = about_peak(&runs[0], &sizes);
    let near = grating(sizes.radius, false, window(&part, sizes.sensor));
    let near = once(
        "default: beamlets",
        &near,
        &Settings::default(),
        effort.display,
    )?;
    runs.extend(drawn(&sizes, effort)?);
    let planes = Settings {
        method: Method::Plane,
        ..Settings::default()
    };
    runs.push(once("plane wavelets", &smooth, &planes, effort.display)?);
    let board = compared(&runs, &near, &part, sizes.sensor);
    let notes = readings(&sizes)?;
    let picture = picture(&runs, &near, &part, &sizes)?;
    let title = "System 1: a grating of 30 rad/mm and the LA1131-A";
    Ok(board.study(title, &notes, vec![(String::from("system1.png"), picture)]))
}

/// The paper's method with the numbers of its text and of its code, on pixels.
fn drawn(sizes: &Sizes, effort: Effort) -> Result<Vec<MethodRun>, StudyError> {
    let pixels = grating(sizes.radius, true, sizes.sensor);
    let names = ["paper's method, text", "paper's method, code"];
    let runs = names.iter().zip(sizes.positions).map(|(name, rays)| {
        let paper = Paper {
            rays,
            secondary: sizes.draws,
            patch: Some(PATCH),
            padding: PADDING,
            ..Paper::default()
        };
        let run = DrawnRun {
            name,
            system: &pixels,
            paper: &paper,
            parts: sizes.parts,
        };
        in_parts(&run, effort, &mut |_| {})
    });
    runs.collect()
}

/// Everything against both references, of which the first is the truth: on the part about the peak, then on all
/// of the sensor.
fn compared(
    runs: &[MethodRun],
    near: &MethodRun,
    part: &[Range<usize>; 2],
    sensor: Window,
) -> Board {
    let crop = |run: &MethodRun| run.cropped(part.clone());
    let fields = [crop(&runs[0]).field, crop(&runs[1]).field];
    let rod = |name, field| Rod { name, field };
    let rods = [
        rod("density, about the peak", fields[0].view()),
        rod("equal, about the peak", fields[1].view()),
    ];
    let whole = [rod("density, all pixels", runs[0].field.view())];
    let mut board = Board::default();
    for run in runs {
        board.add(&crop(run), &rods, None);
        board.note_peak(run.peak().map(|at| place(at, sensor)));
        let all = MethodRun {
            name: format!("{}, all pixels", run.name),
            ..run.clone()
        };
        board.add(&all, &whole, None);
    }
    board.add(near, &rods, None);
    board
}

/// A part of a sensor as a sensor of its own.
fn window(part: &[Range<usize>; 2], sensor: Window) -> Window {
    let ends = [part[0].start, part[1].start].map(|i| i as f64);
    let count = part[0].len();
    let middle = |a: usize, start: f64| {
        let from_middle = start + 0.5 * (count as f64 - sensor.count as f64);
        sensor.middle[a] + from_middle * sensor.pitch
    };
    Window {
        middle: [middle(0, ends[1]), middle(1, ends[0])],
        count,
        pitch: sensor.pitch,
    }
}

/// The sum of one ray for each cell of the grating.
fn geometrical(
    name: &str,
    system: &System,
    sizes: &Sizes,
    strength: Strength,
) -> Result<MethodRun, StudyError> {
    let clock = Instant::now();
    let (field, rays) = sum_of_directions(system, sizes.reference, strength, &|_| {})?;
    Ok(MethodRun {
        name: name.to_owned(),
        field: field.values,
        cost: Cost::since(clock, rays),
        standard_error: None,
    })
}

/// Rows and columns of the part of the sensor about its brightest pixel.
fn about_peak(run: &MethodRun, sizes: &Sizes) -> [Range<usize>; 2] {
    let (count, part) = (sizes.sensor.count, sizes.part);
    let peak = run.peak().unwrap_or([count / 2; 2]);
    peak.map(|at| {
        let first = at.saturating_sub(part / 2).min(count - part);
        first..first + part
    })
}

/// The place [x, y] in µm of a pixel [row, column].
fn place([row, column]: [usize; 2], sensor: Window) -> [f64; 2] {
    let along = |a: usize, i: usize| {
        let from_middle = i as f64 - 0.5 * (sensor.count as f64 - 1.0);
        1e3 * (sensor.middle[a] + from_middle * sensor.pitch)
    };
    [along(0, column), along(1, row)]
}

/// Where the brightest pixel is by every reading of the system.
fn readings(sizes: &Sizes) -> Result<String, StudyError> {
    let mut text = String::from("Brightest pixel by each reading, by density of directions:\n");
    for reading in READINGS {
        let system = reading.apply(grating(sizes.radius, false, sizes.sensor));
        let (field, rays) =
            sum_of_directions(&system, sizes.reference, Strength::Density, &|_| {})?;
        let run = MethodRun {
            name: reading.name().to_owned(),
            field: field.values,
            cost: Cost::since(Instant::now(), rays),
            standard_error: None,
        };
        let [x, y] = run
            .peak()
            .map_or([f64::NAN; 2], |at| place(at, sizes.sensor));
        let _ = writeln!(text, "  {}: ({x:.2}, {y:.2}) µm", reading.name());
    }
    Ok(text)
}

/// The light about the peak by every method.
fn picture(
    runs: &[MethodRun],
    near: &MethodRun,
    part: &[Range<usize>; 2],
    sizes: &Sizes,
) -> Result<Vec<u8>, StudyError> {
    let half = 0.5 * sizes.sensor.pitch;
    let edge = |a: usize, range: &Range<usize>| {
        let at = |i: usize| 1e-3 * place([i; 2], sizes.sensor)[a];
        [at(range.start) - half, at(range.end - 1) + half]
    };
    let shown = |run: &MethodRun| Shown {
        title: run.name.clone(),
        note: String::new(),
        values: light(run.field.view()),
        edges: [edge(0, &part[1]), edge(1, &part[0])],
    };
    let cropped: Vec<MethodRun> = runs.iter().map(|t| t.cropped(part.clone())).collect();
    let all: Vec<Shown> = cropped.iter().chain([near]).map(shown).collect();
    let (upper, lower) = all.split_at(all.len() / 2);
    let rows = vec![upper.to_vec(), lower.to_vec()];
    Ok(figure("System 1: about the peak", rows, Vec::new())?)
}
