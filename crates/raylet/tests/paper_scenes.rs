//! The scenes in scenes/paper are the problems of the paper's studies.

use num_complex::Complex64;
use raylet::engine::plan::settings::{Positions, Sampler};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet_testkit::paper_systems::{GRATING_SENSOR, grating, lens_hologram, near_hologram};
use raylet_testkit::scenes::scene_path;

/// Places, shapes, indices, sensor: everything but the element itself.
fn compare(ours: &System, theirs: &System) {
    assert!((ours.wavelength - theirs.wavelength).abs() < 1e-15);
    for (a, b) in ours.screens.iter().zip(&theirs.screens) {
        assert!((a.frame.origin - b.frame.origin).norm() < 1e-12);
        assert_eq!(a.bounds().is_some(), b.bounds().is_some());
        for (p, q) in a.bounds().unwrap().iter().zip(b.bounds().unwrap()) {
            assert!((p - q).abs() < 1e-12, "{} {p} {q}", a.name);
        }
    }
    for (a, b) in ours.trains[0].iter().zip(&theirs.trains[0]) {
        assert!((a.frame.origin - b.frame.origin).norm() < 1e-12);
        assert_eq!((&a.shape, &a.aperture), (&b.shape, &b.aperture));
        assert_eq!(a.index, b.index);
    }
    assert_eq!(ours.trains[0].len(), theirs.trains[0].len());
}

#[test]
fn system1_is_the_grating() {
    let scene = Scene::read(&scene_path("paper/system1")).unwrap();
    let (ours, theirs) = (
        build::system(&scene, 0).unwrap(),
        grating(12.7, false, GRATING_SENSOR),
    );
    compare(&ours, &theirs);
    let slope = |system: &System| match &system.screens[0].kind {
        ScreenKind::Doe(doe) => doe.phase_gradient(1.0, 2.0).unwrap(),
        _ => panic!("no element"),
    };
    for (p, q) in slope(&ours).iter().zip(slope(&theirs)) {
        assert!((p - q).abs() < 1e-9, "{p} {q}");
    }
    let paper = build::settings(&scene).paper;
    assert_eq!((paper.rays, paper.secondary), (1_640_000, 1000));
}

#[test]
fn system2_is_the_near_hologram() {
    let scene = Scene::read(&scene_path("paper/system2")).unwrap();
    let ours = build::system(&scene, 0).unwrap();
    let phase = match &ours.screens[0].kind {
        ScreenKind::Doe(doe) => doe.pixels().unwrap().values.mapv(|u| u.arg()),
        _ => panic!("no element"),
    };
    assert_eq!(phase.dim(), (100, 100));
    compare(&ours, &near_hologram(&phase, PixelForm::Box));
    let paper = build::settings(&scene).paper;
    assert_eq!(paper.positions, Positions::Grid);
    assert_eq!((paper.rays, paper.secondary), (1, 1 << 21));
}

#[test]
fn system3_is_the_hologram_and_the_lens() {
    // Its phase is computed by `raylet hologram`; here it is blank.
    let scene = Scene::open(&scene_path("paper/system3")).unwrap();
    let hologram = scene.hologram.clone().unwrap();
    assert_eq!(hologram.size_mm, [1.26; 2]);
    let task = raylet::file::model::hologram::commission(&scene, false)
        .unwrap()
        .task;
    let blank = lens_hologram(&ndarray::Array2::zeros((200, 200)), PixelForm::Point);
    let hop = blank.hops().next().unwrap();
    let train = raylet::optics::paraxial::Abcd::between(&hop).unwrap();
    assert!((task.train.a - train.a).abs() < 1e-12 && (task.train.b - train.b).abs() < 1e-9);
    assert_eq!(task.incident.dim(), (200, 200));
    let paper = build::settings(&scene).paper;
    assert_eq!((paper.rays, paper.secondary), (400_000, 10_000));
    assert_eq!(paper.sampler, Sampler::Multinomial);
}

/// Each of the two waves undoes the phase k(h − |F − X|) from the true surface to its focus.
#[test]
fn figure_6_has_its_two_foci() {
    let scene = Scene::read(&scene_path("paper/fig6_foci")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    let mirror = &system.screens[0];
    let ScreenKind::Doe(doe) = &mirror.kind else {
        panic!("no element");
    };
    let sensor = system.screens[1].frame.origin;
    assert!((mirror.smallest_radius().unwrap() - 0.5059).abs() < 1e-4);
    assert!((sensor.z + 0.2505).abs() < 1e-12 && doe.reflect);
    let k = std::f64::consts::TAU / 1e-3;
    let expected = |x: f64, y: f64| -> Complex64 {
        let h = -mirror.height([x, y]).unwrap().z;
        let to = |f: f64| ((f - x).powi(2) + y * y + (0.2505 - h).powi(2)).sqrt();
        [-0.05, 0.05]
            .map(|f| Complex64::cis(k * (h - to(f))))
            .iter()
            .sum()
    };
    let points = (0..400).map(|n| (f64::from(n % 20) - 9.5, f64::from(n / 20) - 9.5));
    let inside = points
        .map(|(i, j)| (0.012 * i, 0.012 * j))
        .filter(|(x, y)| x.hypot(*y) < 0.124);
    let pairs: Vec<_> = inside
        .map(|(x, y)| (doe.transmission(x, y), expected(x, y)))
        .collect();
    assert!(pairs.len() > 250);

    // But for one phase that is the same all over.
    let overlap: Complex64 = pairs.iter().map(|(a, b)| a.conj() * b).sum();
    let turn = Complex64::cis(overlap.arg());
    let worst = pairs
        .iter()
        .map(|(a, b)| (a * turn - b).norm())
        .fold(0.0, f64::max);
    assert!(worst < 3e-3, "{worst:e}");
}
