//! Small, strongly refracting lenses, against surface-to-surface diffraction integrals.
//!
//! Lengths are in wavelengths. Plano-convex lenses of radius 200, index 1.5, 100 across and 25 thick;
//! every interface has unit transmission, as the reference's has.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::Settings;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::refraction::Coating;
use raylet::optics::screen::ScreenKind;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_testkit::parts::{on_axis, plane_wave, screen};

use crate::numerics::pixels::Pixels;
use crate::problems::problem::{Problem, axis, doe, face, sensor};
use crate::references::lens_train::{LensTrain, PlanoConvex, Source, Step};

/// The lens.
pub const LENS: PlanoConvex = PlanoConvex {
    radius: 200.0,
    thickness: 25.0,
    index: 1.5,
    semi_aperture: 50.0,
    gap_before: 20.0,
};

/// How exactly the reference is computed: period and samples per wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Period of its plane waves.
    pub period: f64,
    /// Samples per wavelength on surfaces.
    pub density: f64,
}

/// Converged to about 3e-5.
pub const FULL: Effort = Effort {
    period: 432.0,
    density: 5.0,
};

/// Converged to about 3e-4.
pub const QUICK: Effort = Effort {
    period: 360.0,
    density: 3.0,
};

impl Effort {
    fn train(self) -> LensTrain {
        LensTrain {
            samples: (self.density * self.period).round() as usize,
            ..LensTrain::converged(1.0, self.period)
        }
    }
}

/// The lens's surfaces for raylet, its first vertex at `z`.
fn lens(z: f64) -> Vec<Surface> {
    let index = LENS.index;
    vec![
        face(
            z,
            LENS.radius,
            LENS.semi_aperture,
            Coating::Unit,
            [1.0, index],
        ),
        face(
            z + LENS.thickness,
            f64::INFINITY,
            1e6,
            Coating::Unit,
            [index, 1.0],
        ),
    ]
}

/// Points of the sensor along each axis, and their distance.
const SENSOR: (usize, f64) = (60, 0.7);

fn exact(effort: Effort, source: Source, steps: &[Step]) -> Array2<Complex64> {
    let points = axis(SENSOR.0, SENSOR.1);
    let half = 0.5 * SENSOR.0 as f64 * SENSOR.1;
    match effort.train().run(source, steps, half) {
        Ok(spectrum) => spectrum.on_grid(&points, &points),
        #[expect(
            clippy::unreachable,
            reason = "an instrument that is set up wrongly must stop"
        )]
        Err(error) => unreachable!("the period is chosen long enough: {error:?}"),
    }
}

/// A bare stop before the lens, the sensor `back` behind its plane face.
pub fn stop_before_lens(radius: f64, back: f64, effort: Effort) -> Problem {
    let depth = LENS.gap_before + LENS.thickness;
    Problem {
        name: format!("stop of radius {radius}λ, lens of radius 50λ, sensor {back}λ behind it"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(radius))),
                sensor(depth + back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![lens(LENS.gap_before)],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.push(Step::Drift(back));
            exact(effort, Source::Disc(radius, [0.0; 2]), &steps)
        }),
    }
}

/// Pixels before the lens, the sensor `back` behind its plane face.
pub fn before_lens(name: &str, pixels: Pixels, back: f64, effort: Effort) -> Problem {
    let depth = LENS.gap_before + LENS.thickness;
    Problem {
        name: format!("{name}, lens, sensor {back}λ behind it"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![doe(0.0, &pixels), sensor(depth + back, SENSOR.0, SENSOR.1)],
            trains: vec![lens(LENS.gap_before)],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.push(Step::Drift(back));
            exact(effort, Source::Pixels(&pixels, [0.0; 2]), &steps)
        }),
    }
}

/// The way of a hard-edged collimated beam through the lens to pixels and the sensor; in wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct BeamPath {
    /// Radius of the beam before the lens.
    pub radius: f64,
    /// From the lens to the pixels.
    pub gap: f64,
    /// To the sensor, from the pixels or the lens behind them.
    pub back: f64,
}

/// A lens in a hard-edged collimated beam, then pixels, then the sensor.
pub fn after_lens(name: &str, pixels: Pixels, path: BeamPath, effort: Effort) -> Problem {
    let BeamPath { radius, gap, back } = path;
    let depth = LENS.gap_before + LENS.thickness + gap;
    Problem {
        name: format!("lens, {name} {gap}λ behind it, sensor {back}λ on"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(radius))),
                doe(depth, &pixels),
                sensor(depth + back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![lens(LENS.gap_before), vec![]],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.extend([Step::Drift(gap), Step::Pixels(&pixels), Step::Drift(back)]);
            exact(effort, Source::Disc(radius, [0.0; 2]), &steps)
        }),
    }
}

/// A lens in a hard-edged collimated beam, pixels, a second lens, the sensor.
pub fn between_lenses(name: &str, pixels: Pixels, path: BeamPath, effort: Effort) -> Problem {
    let BeamPath { radius, gap, back } = path;
    let middle = LENS.gap_before + LENS.thickness + gap;
    let second = middle + LENS.gap_before;
    let end = second + LENS.thickness + back;
    Problem {
        name: format!("lens, {name}, lens, sensor {back}λ behind it"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(radius))),
                doe(middle, &pixels),
                sensor(end, SENSOR.0, SENSOR.1),
            ],
            trains: vec![lens(LENS.gap_before), lens(second)],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.extend([Step::Drift(gap), Step::Pixels(&pixels)]);
            steps.extend(LENS.convex_first());
            steps.push(Step::Drift(back));
            exact(effort, Source::Disc(radius, [0.0; 2]), &steps)
        }),
    }
}

/// Two planes of pixels in free space.
pub fn two_screens(first: Pixels, second: Pixels, gap: f64, back: f64, effort: Effort) -> Problem {
    Problem {
        name: format!("random pixels, random pixels {gap}λ on, sensor {back}λ on"),
        reference: "plane waves, pixel by pixel",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                doe(0.0, &first),
                doe(gap, &second),
                sensor(gap + back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![vec![], vec![]],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let steps = [Step::Drift(gap), Step::Pixels(&second), Step::Drift(back)];
            exact(effort, Source::Pixels(&first, [0.0; 2]), &steps)
        }),
    }
}

/// Pixels, the lens, pixels `gap` behind it, the sensor.
pub fn around_lens(first: Pixels, second: Pixels, gap: f64, back: f64, effort: Effort) -> Problem {
    let depth = LENS.gap_before + LENS.thickness + gap;
    Problem {
        name: format!("random pixels, lens, random pixels {gap}λ behind it, sensor {back}λ on"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                doe(0.0, &first),
                doe(depth, &second),
                sensor(depth + back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![lens(LENS.gap_before), vec![]],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.extend([Step::Drift(gap), Step::Pixels(&second), Step::Drift(back)]);
            exact(effort, Source::Pixels(&first, [0.0; 2]), &steps)
        }),
    }
}

/// Pixels, the lens, a rectangular aperture `gap` behind it that stands aside, the sensor.
pub fn stopped(pixels: Pixels, gap: f64, back: f64, effort: Effort) -> Problem {
    let depth = LENS.gap_before + LENS.thickness + gap;
    // Open from −10λ to 50λ along x and −22λ to 22λ along y; as pixels of 2λ for the reference.
    let aperture = Aperture {
        outline: Outline::Rectangle {
            half_x: 30.0,
            half_y: 22.0,
        },
        centre: [20.0, 0.0],
    };
    let open = |j: usize, i: usize| (20..50).contains(&i) && (14..36).contains(&j);
    let mask = Pixels {
        pitch: 2.0,
        transmission: Array2::from_shape_fn((50, 50), |(j, i)| {
            Complex64::new(f64::from(u8::from(open(j, i))), 0.0)
        }),
    };
    Problem {
        name: format!("random pixels, lens, off-centre stop {gap}λ behind it, sensor {back}λ on"),
        reference: "surface integrals",
        system: System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                doe(0.0, &pixels),
                screen(on_axis(depth), ScreenKind::Stop(aperture)),
                sensor(depth + back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![lens(LENS.gap_before), vec![]],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let mut steps = LENS.convex_first();
            steps.extend([Step::Drift(gap), Step::Pixels(&mask), Step::Drift(back)]);
            exact(effort, Source::Pixels(&pixels, [0.0; 2]), &steps)
        }),
    }
}
