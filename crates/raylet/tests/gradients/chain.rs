//! The adjoint of a whole run is the transpose of the run.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;

use crate::gradients::stage::{cases, noise};

/// The system with other pixels on one of its screens.
pub(crate) fn with_pixels(system: &System, number: usize, purpose: u32) -> System {
    let mut changed = system.clone();
    if let ScreenKind::Doe(doe) = &mut changed.screens[number].kind
        && let Some(pixels) = doe.free_pixels_mut()
    {
        let (ny, nx) = pixels.values.dim();
        pixels.values = noise([ny, nx], purpose);
    }
    changed
}

/// How far apart two inner products are, relative to the arrays of the first one.
fn apart(there: [&Array2<Complex64>; 2], back: [&Array2<Complex64>; 2]) -> f64 {
    let product = |[a, b]: [&Array2<Complex64>; 2]| -> Complex64 {
        a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    };
    let norm = |list: &Array2<Complex64>| list.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
    (product(there) - product(back)).norm() / (norm(there[0]) * norm(there[1]))
}

/// The field is linear in each element: Σ Ū* U(v) = Σ v̄* v for any pixels v.
#[test]
fn chain_dot_product_slow() {
    for case in cases() {
        let linearised = LinearisedSystem::new(&case.system, &[], &case.settings).unwrap();
        let trace = linearised.forward(&case.system).unwrap();
        let (ny, nx) = trace.field.values.dim();
        let field_bar = noise([ny, nx], 40);
        let gradient = linearised
            .adjoint(&case.system, &[], &trace, &field_bar)
            .unwrap();
        let mut elements = 0;
        for (number, bar) in gradient.pixels.iter().enumerate() {
            let Some(bar) = bar else { continue };
            elements += 1;
            let changed = with_pixels(&case.system, number, 50);
            let field = linearised.forward(&changed).unwrap().field.values;
            let pixels = noise([bar.nrows(), bar.ncols()], 50);
            let error = apart([&field_bar, &field], [bar, &pixels]);
            assert!(error < 1e-12, "{}, element {number}: {error:e}", case.name);
        }
        assert!(elements > 0, "{}", case.name);
    }
}

/// Where weak modes are left out, the field is linear in each element for the modes that its own light keeps.
#[test]
fn dot_product_without_weak_modes() {
    let (wanted, mut elements) = (["lens", "rims and a tilt"], 0);
    for case in cases().iter().filter(|case| wanted.contains(&case.name)) {
        let all = LinearisedSystem::new(&case.system, &[], &case.settings).unwrap();
        let settings = Settings {
            mode_threshold: Some(1e-1),
            ..case.settings.clone()
        };
        let linearised = LinearisedSystem::new(&case.system, &[], &settings).unwrap();
        let trace = linearised.forward(&case.system).unwrap();
        let field = &trace.field.values;
        assert_ne!(*field, all.forward(&case.system).unwrap().field.values);

        let (ny, nx) = field.dim();
        let field_bar = noise([ny, nx], 40);
        let gradient = linearised.adjoint(&case.system, &[], &trace, &field_bar);
        for (screen, bar) in case.system.screens.iter().zip(gradient.unwrap().pixels) {
            if let (ScreenKind::Doe(doe), Some(bar)) = (&screen.kind, bar)
                && let Some(pixels) = doe.clone().free_pixels_mut()
            {
                let error = apart([&field_bar, field], [&bar, &pixels.values]);
                assert!(error < 1e-12, "{}: {error:e}", case.name);
                elements += 1;
            }
        }
    }
    assert_eq!(elements, wanted.len());
}

/// Beamlets are kept from the first run on; that changes no bit, whether weak modes are left out or not.
#[test]
fn kept_beamlets_change_no_bit() {
    let (wanted, mut runs) = (["lens", "rims and a tilt"], 0);
    for case in cases().iter().filter(|case| wanted.contains(&case.name)) {
        for mode_threshold in [Some(0.0), Some(1e-2)] {
            let settings = Settings {
                mode_threshold,
                ..case.settings.clone()
            };
            let anew = simulate(&case.system, &settings, &|_| {}).unwrap();
            let linearised = LinearisedSystem::new(&case.system, &[], &settings).unwrap();
            for _ in 0..2 {
                let trace = linearised.forward(&case.system).unwrap();
                assert_eq!(trace.field.values, anew.field.values, "{}", case.name);
                runs += 1;
            }
        }
    }
    assert_eq!(runs, 4 * wanted.len());
}
