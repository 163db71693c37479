//! Derivatives of a loss behind a small, strong lens, against central differences of surface integrals.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::engine::plan::settings::Settings;
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::optics::refraction::Coating;
use raylet::optics::system::System;
use raylet_testkit::parts::plane_wave;

use crate::gradients::gradient_error::{Comparison, Loss};
use crate::numerics::pixels::Pixels;
use crate::problems::problem::{axis, doe, face, random_pixels, sensor};
use crate::references::lens_train::{LensTrain, PlanoConvex, Source, Step};

/// A lens and where the sensor stands behind it, in wavelengths.
#[derive(Clone, Copy, Debug)]
struct Setup {
    lens: PlanoConvex,
    back: f64,
}

const SETUP: Setup = Setup {
    lens: PlanoConvex {
        radius: 100.0,
        thickness: 12.0,
        index: 1.5,
        semi_aperture: 30.0,
        gap_before: 15.0,
    },
    back: 110.0,
};

/// Points of the sensor along each axis, and their distance.
const SENSOR: (usize, f64) = (28, 0.9);

/// Pixels along each axis, and their pitch.
const PIXELS: (usize, f64) = (12, 2.0);

/// Converged to about 1e-3.
const REFERENCE: LensTrain = LensTrain {
    wavelength: 1.0,
    period: 240.0,
    samples: 720,
    reach: 1.0,
    extra: 5.0,
    stencil: 6,
    pixel_nodes: 8,
};

impl Setup {
    fn system(&self, pixels: &Pixels) -> System {
        let lens = self.lens;
        let vertex = lens.gap_before;
        let rear = vertex + lens.thickness;
        let bent = [1.0, lens.index];
        let train = vec![
            face(vertex, lens.radius, lens.semi_aperture, Coating::Unit, bent),
            face(rear, f64::INFINITY, 1e6, Coating::Unit, [lens.index, 1.0]),
        ];
        System {
            wavelength: 1.0,
            source: plane_wave([0.0; 2]),
            screens: vec![
                doe(0.0, pixels),
                sensor(rear + self.back, SENSOR.0, SENSOR.1),
            ],
            trains: vec![train],
        }
    }

    fn exact(&self, pixels: &Pixels) -> Array2<Complex64> {
        let mut steps = self.lens.convex_first();
        steps.push(Step::Drift(self.back));
        let points = axis(SENSOR.0, SENSOR.1);
        let half = 0.5 * SENSOR.0 as f64 * SENSOR.1;
        match REFERENCE.run(Source::Pixels(pixels, [0.0; 2]), &steps, half) {
            Ok(spectrum) => spectrum.on_grid(&points, &points),
            #[expect(
                clippy::unreachable,
                reason = "an instrument that is set up wrongly must stop"
            )]
            Err(error) => unreachable!("the period is chosen long enough: {error:?}"),
        }
    }
}

/// A parameter: its name, its step, and the change.
type Parameter = (&'static str, f64, fn(&mut Setup, f64));

/// The lens's and the sensor's; their steps turn the light's phase by some 0.05.
const PARAMETERS: [Parameter; 4] = [
    ("position of the sensor", 0.1, |setup, by| setup.back += by),
    ("curvature", 4e-5, |setup, by| {
        setup.lens.radius = 1.0 / (1.0 / setup.lens.radius + by);
    }),
    ("thickness", 0.1, |setup, by| setup.lens.thickness += by),
    ("index", 5e-4, |setup, by| setup.lens.index += by),
];

/// Pixels and parameters of a hologram and a lens; the reduced list has the pixels only.
pub fn through_lens(reduced: bool) -> Vec<Comparison> {
    let comparison = |name: &str, run: Run| {
        Comparison::new(
            format!("{name} before a lens of radius 100λ"),
            "Σ(I − T)²",
            "differences of surface integrals",
            run,
        )
    };
    let mut list = vec![comparison(
        "phases of 12 of 12² random 2λ pixels",
        Box::new(pixel_phases),
    )];
    let parameters = if reduced { 0 } else { PARAMETERS.len() };
    for (number, (name, ..)) in PARAMETERS.iter().enumerate().take(parameters) {
        let name = format!("{name}, 12² random 2λ pixels");
        list.push(comparison(&name, Box::new(move || parameter(number))));
    }
    list
}

type Run = Box<dyn Fn() -> Result<[Vec<f64>; 2], LinearisedSystemError>>;

/// The pixels that are looked at.
fn chosen() -> Vec<[usize; 2]> {
    (0..12).map(|n| [n, (5 * n + 2) % PIXELS.0]).collect()
}

/// Derivatives along single pixels' phases.
fn pixel_phases() -> Result<[Vec<f64>; 2], LinearisedSystemError> {
    let pixels = random_pixels(PIXELS.0, PIXELS.1);
    let system = SETUP.system(&pixels);
    let linearised = LinearisedSystem::new(&system, &[], &Settings::default())?;
    let trace = linearised.forward(&system)?;
    let bar = Loss::Image.bar(&trace.field.values);
    let gradient = linearised.adjoint(&system, &[], &trace, &bar)?;
    let Some(bar) = &gradient.pixels[0] else {
        return Ok([vec![], vec![]]);
    };

    // Fields add: what one pixel brings is found with all others dark.
    let all = SETUP.exact(&pixels);
    let step = 0.01;
    let (mut ours, mut exact) = (Vec::new(), Vec::new());
    for pixel in chosen() {
        let value = pixels.transmission[pixel];
        ours.push((bar[pixel] * value.conj()).im);
        let mut alone = Array2::zeros(pixels.transmission.dim());
        alone[pixel] = value;
        let part = SETUP.exact(&Pixels {
            pitch: PIXELS.1,
            transmission: alone,
        });
        let loss = |by: f64| {
            let turn = Complex64::cis(by) - 1.0;
            Loss::Image.value(&(&all + &part.mapv(|u| u * turn)))
        };
        exact.push((loss(step) - loss(-step)) / (2.0 * step));
    }
    Ok([ours, exact])
}

/// The derivative along one parameter.
fn parameter(number: usize) -> Result<[Vec<f64>; 2], LinearisedSystemError> {
    let (_, step, change) = PARAMETERS[number];
    let pixels = random_pixels(PIXELS.0, PIXELS.1);
    let moved = |by: f64| {
        let mut setup = SETUP;
        change(&mut setup, by);
        setup
    };
    let system = SETUP.system(&pixels);
    let variation = Variation {
        below: moved(-0.01 * step).system(&pixels),
        above: moved(0.01 * step).system(&pixels),
        distance: 0.02 * step,
    };
    let variations = [variation];
    let linearised = LinearisedSystem::new(&system, &variations, &Settings::default())?;
    let trace = linearised.forward(&system)?;
    let bar = Loss::Image.bar(&trace.field.values);
    let gradient = linearised.adjoint(&system, &variations, &trace, &bar)?;

    let loss = |by: f64| Loss::Image.value(&moved(by).exact(&pixels));
    let slope = (loss(step) - loss(-step)) / (2.0 * step);
    Ok([gradient.parameters, vec![slope]])
}
