//! The way back is the transpose of the way there.

use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use raylet::optics::screen::Act;
use raylet::optics::system::System;

use crate::gradients::stage::{cases, noise};

/// The system with other pixels on one of its screens.
pub(crate) fn with_pixels(system: &System, number: usize, purpose: u32) -> System {
    let mut changed = system.clone();
    if let Act::Doe(doe) = &mut changed.screens[number].act
        && let Some(pixels) = doe.free_pixels_mut()
    {
        let (ny, nx) = pixels.values.dim();
        pixels.values = noise([ny, nx], purpose);
    }
    changed
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
            let forward: Complex64 = field_bar
                .iter()
                .zip(&field)
                .map(|(a, b)| a.conj() * b)
                .sum();
            let back: Complex64 = bar.iter().zip(&pixels).map(|(a, b)| a.conj() * b).sum();
            let norm = |list: &ndarray::Array2<Complex64>| {
                list.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt()
            };
            let error = (forward - back).norm() / (norm(&field_bar) * norm(&field));
            assert!(error < 1e-12, "{}, element {number}: {error:e}", case.name);
        }
        assert!(elements > 0, "{}", case.name);
    }
}

/// Beamlets are kept from the first run on; that changes no bit, whether weak modes are left out or not.
#[test]
fn kept_beamlets_change_no_bit() {
    let wanted = ["lens", "rims and a tilt"];
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
            }
        }
    }
}
