//! Drawn beamlets: estimates whose mean is the exact field and gradient, and the control variate that reduces their noise.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::control_variate::ControlVariate;
use raylet::engine::chain::forward_pass::Gradient;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::engine::monte_carlo::mode_sampling::{Drawing, Draws, PatchDraws};
use raylet::engine::progress::uncancelled;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;
use raylet::wave::grid::metrics::field_error;

use crate::gradients::stage::{exact, lens, lit, noise, pixels, screen};
use raylet_testkit::parts::sensor;

/// Pixels, two lens faces and a sensor.
fn behind_lens() -> System {
    lit(
        vec![
            screen(0.0, pixels(7, 4.0, 2, PixelForm::Box)),
            screen(330.0, sensor(12, 2.0)),
        ],
        vec![lens()],
    )
}

fn draws(drawing: Drawing, each: usize, seed: u64) -> Draws {
    Draws {
        drawing,
        each,
        seed,
    }
}

fn dot(a: &Array2<Complex64>, b: &Array2<Complex64>) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

fn distance(a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    field_error(a.view(), b.view()).unwrap()
}

/// The same draws there and back: Σ Ū* Â u = Σ (ÂᴴŪ)* u.
#[test]
fn drawn_dot_product() {
    let system = behind_lens();
    let linearised = LinearisedSystem::new(&system, &[], &exact()).unwrap();
    let behind = linearised.pass(&system).unwrap().behind;
    for drawing in [Drawing::WithoutReplacement, Drawing::Multinomial] {
        let drawn = linearised.drawn(draws(drawing, 20, 5));
        let field = drawn
            .propagate(&system, &behind, &uncancelled)
            .unwrap()
            .values;
        let field_bar = noise([12, 12], 40);
        let bar = drawn
            .propagate_adjoint(&system, &behind, &field_bar, &uncancelled)
            .unwrap()
            .values;
        let error = (dot(&field_bar, &field) - dot(&bar, &behind.values)).norm();
        let error = error / dot(&field_bar, &field).norm();
        assert!(error < 1e-12, "{drawing:?}: {error:e}");
    }
}

/// The mean of many estimates is the exact field, and so is one estimate without replacement of all modes.
#[test]
fn estimates_have_the_exact_mean() {
    let system = behind_lens();
    let linearised = LinearisedSystem::new(&system, &[], &exact()).unwrap();
    let whole = linearised.forward(&system).unwrap().field.values;
    let all = linearised.drawn(draws(Drawing::WithoutReplacement, usize::MAX, 1));
    let field = all.forward(&system).unwrap().field.values;
    assert!(distance(&field, &whole) < 1e-12);

    let drawings = [
        Drawing::WithoutReplacement,
        Drawing::Multinomial,
        Drawing::Gumbel { temperature: 1.0 },
    ];
    for drawing in drawings {
        let (mut sum, mut square) = (Array2::<Complex64>::zeros(whole.raw_dim()), 0.0);
        let seeds = 24;
        for seed in 1..=seeds {
            let drawn = linearised.drawn(draws(drawing, 16, seed));
            let field = drawn.forward(&system).unwrap().field.values;
            square += distance(&field, &whole).powi(2);
            sum += &field;
        }
        let one = (square / seeds as f64).sqrt();
        let mean = distance(&(sum / seeds as f64), &whole) * (seeds as f64).sqrt();
        assert!(
            one > 0.05 && (0.7..1.4).contains(&(mean / one)),
            "{drawing:?}: {one} {mean}"
        );
    }
}

/// The same system with its pixels' phases a little different.
fn turned(system: &System) -> System {
    let mut system = system.clone();
    let values = pixels_of(&mut system);
    let turn = noise([7, 7], 42);
    values.zip_mut_with(&turn, |v, turn| *v *= Complex64::cis(0.2 * turn.re));
    system
}

/// The pixels of the element.
fn pixels_of(system: &mut System) -> &mut Array2<Complex64> {
    let ScreenKind::Doe(doe) = &mut system.screens[0].kind else {
        unreachable!("it is an element")
    };
    &mut doe.free_pixels_mut().unwrap().values
}

/// What has changed since the exact evaluation, there and back: Σ (Ū − Ū₀)* (U − U₀) = Σ (v̄ − v̄₀)* (v − v₀) for pixels v.
#[test]
fn control_variate_dot_product() {
    let (mut before, mut after) = (behind_lens(), turned(&behind_lens()));
    let linearised = LinearisedSystem::new(&before, &[], &exact()).unwrap();
    let bars = [noise([12, 12], 43), noise([12, 12], 44)];
    let control_variate = ControlVariate::new(&linearised, &before, &uncancelled, |_| {
        Ok::<_, LinearisedSystemError>(bars[0].clone())
    })
    .unwrap();
    let there = linearised.forward(&before).unwrap();
    let back = linearised.adjoint(&before, &[], &there, &bars[0]).unwrap();
    let drawn = linearised.drawn(draws(Drawing::WithoutReplacement, 16, 3));
    let moved = control_variate
        .forward(&drawn, &after, &uncancelled)
        .unwrap();
    let returned = control_variate
        .forward_adjoint(&drawn, &after, &moved, &bars[1], &uncancelled)
        .unwrap();
    let pixels = |gradient: Gradient| gradient.pixels[0].clone().unwrap();
    let changed = pixels_of(&mut after).clone() - &*pixels_of(&mut before);
    let one = dot(
        &(&bars[1] - &bars[0]),
        &(&moved.field.values - &there.field.values),
    );
    let other = dot(&(pixels(returned) - pixels(back)), &changed);
    let error = (one - other).norm() / one.norm();
    assert!(error < 1e-12, "{error:e}");
}

/// At the point of its exact evaluation an estimate is exact whatever is drawn; near it, it is far better than without.
#[test]
fn control_variates_lower_the_noise() {
    let system = behind_lens();
    let linearised = LinearisedSystem::new(&system, &[], &exact()).unwrap();
    let target = noise([12, 12], 41);
    let field_bar = |field: &Field| &field.values - &target;
    let cotangent = |field: &Field| Ok::<_, LinearisedSystemError>(field_bar(field));
    let control_variate =
        ControlVariate::new(&linearised, &system, &uncancelled, cotangent).unwrap();
    let nearby = turned(&system);

    let drawn = linearised.drawn(draws(Drawing::WithoutReplacement, 16, 3));
    for (system, [field_limit, pixel_limit]) in [(&system, [1e-12; 2]), (&nearby, [0.1; 2])] {
        let exact = linearised.forward(system).unwrap();
        let bar = field_bar(&exact.field);
        let whole = linearised
            .adjoint(system, &[], &exact, &bar)
            .unwrap()
            .pixels[0]
            .clone();
        let trace = control_variate
            .forward(&drawn, system, &uncancelled)
            .unwrap();
        let bar = field_bar(&trace.field);
        let estimate = control_variate
            .forward_adjoint(&drawn, system, &trace, &bar, &uncancelled)
            .unwrap();
        let field = distance(&trace.field.values, &exact.field.values);
        let alone = drawn.forward(system).unwrap().field.values;
        let alone = distance(&alone, &exact.field.values);
        let pixels = distance(estimate.pixels[0].as_ref().unwrap(), &whole.unwrap());
        assert!(
            field < field_limit && pixels < pixel_limit,
            "{field:e} {pixels:e}"
        );
        assert!(field < 0.3 * alone, "{field:e} {alone:e}");
    }
}

/// Straight through is no unbiased way: of a linear loss its mean is the gradient only as the temperature falls.
#[test]
fn soft_maxima_bias_the_gradient() {
    let (modes, b) = (noise([2, 3], 60), noise([2, 3], 61));
    let bias = |temperature: f64| {
        let mut sum = Array2::<Complex64>::zeros((2, 3));
        let seeds = 40_000;
        for seed in 0..seeds {
            let draws = PatchDraws {
                draws: draws(Drawing::Gumbel { temperature }, 1, seed),
                at: [0, 0],
            };
            sum += &draws.weights_adjoint(&modes, &b);
        }
        distance(&(sum / seeds as f64), &b)
    };
    let [cold, warm, hot] = [0.1, 1.0, 10.0].map(bias);
    assert!(
        cold < 0.05 && warm > 2.0 * cold && hot > warm,
        "{cold} {warm} {hot}"
    );
}

/// What cannot be drawn is refused.
#[test]
fn control_variates_take_one_hop() {
    let mut screens = behind_lens().screens;
    screens.insert(1, screen(300.0, pixels(4, 4.0, 5, PixelForm::Box)));
    let two = lit(screens, vec![lens(), vec![]]);
    let linearised = LinearisedSystem::new(&two, &[], &exact()).unwrap();
    let refused = ControlVariate::new(&linearised, &two, &uncancelled, |field| {
        Ok(field.values.clone())
    });
    assert_eq!(
        refused.err(),
        Some(LinearisedSystemError::ControlVariate(2))
    );
}
