//! The list of problems of the accuracy report, whole or in reduced form.

use raylet::engine::plan::settings::{Method, Settings};
use raylet::math::part::part;
use raylet::optics::refraction::Coating;
use raylet::optics::system::System;
use raylet_testkit::parts::plane_wave;

use crate::numerics::pixels::Pixels;
use crate::problems::dim::{DIM_LENSES, DimLens};
use crate::problems::mirror::{self, Coat};
use crate::problems::problem::{
    Problem, axis, checkerboard, doe, face, grating_pixels, random_amplitude, random_pixels, sensor,
};
use crate::problems::slanted::{slanted, tilted_planes};
use crate::problems::strong::{
    BeamPath, Effort, FULL, QUICK, after_lens, around_lens, before_lens, between_lenses,
    stop_before_lens, stopped, two_screens,
};
use crate::references::collins::{Abcd, CollinsIntegral};
use crate::references::rayleigh_sommerfeld::rayleigh_sommerfeld;

/// The reference that is itself an approximation.
pub const COLLINS: &str = "Collins, direct sum";

/// Index of N-BK7 at 0.7 µm.
const BK7: f64 = 1.513_063_997_196;

/// For tilted glass the sensor needs a longer period; its points are few.
const SLANTED: Effort = Effort {
    period: 400.0,
    density: 3.0,
};

/// All problems; the reduced list leaves out the slow ones and computes coarser references.
pub fn problems(reduced: bool) -> Vec<Problem> {
    let effort = if reduced { QUICK } else { FULL };
    let mut list = in_free_space(reduced);
    for convex_first in [true, false] {
        for back in [44.7, 40.0] {
            list.push(catalogue_lens(convex_first, back));
        }
    }
    list.extend(mirrors(reduced));
    list.push(before_lens("random 2λ pixels", random(), 250.0, effort));
    if !reduced {
        list.extend(strong_lenses(effort));
    }
    list.extend(tilted_planes());
    if !reduced {
        list.extend(slanted(SLANTED));
        list.extend(DIM_LENSES.map(DimLens::problem));
    }
    list
}

/// Pixels of λ/2 in free space; the reduced list has one distance.
fn in_free_space(reduced: bool) -> Vec<Problem> {
    let distances: &[f64] = if reduced {
        &[120.0]
    } else {
        &[30.0, 120.0, 400.0]
    };
    let mut list = Vec::new();
    for &z in distances {
        for tilt in [0.0, 10.0] {
            let pixels = random_pixels(120, 0.5);
            list.push(free_space("random λ/2 pixels", pixels, z, tilt));
        }
        let pixels = checkerboard(120, 0.5);
        list.push(free_space("checkerboard of λ/2 pixels", pixels, z, 0.0));
    }
    list.push(free_space(
        "random amplitude and phase, λ/2 pixels",
        random_amplitude(120, 0.5),
        120.0,
        0.0,
    ));
    list
}

/// Diffractive mirrors; the reduced list has that of random pixels.
fn mirrors(reduced: bool) -> Vec<Problem> {
    let mut list = Vec::new();
    for (name, coat) in [
        ("random 2λ pixels", Coat::Random(2.0)),
        ("bare mirror", Coat::Bare),
        ("phase of a lens", Coat::Focus(250.0)),
        ("phases of two lenses, added", Coat::TwoFoci(0.08, 250.0)),
    ] {
        if !reduced || coat == Coat::Random(2.0) {
            list.extend(bump(name, coat));
        }
    }
    list
}

/// Pixels before, behind and between strong lenses, and before other pixels.
fn strong_lenses(effort: Effort) -> Vec<Problem> {
    let name = "random 2λ pixels";
    let grating = grating_pixels(120, 0.5, 0.25);
    let aside = aside(random_pixels(60, 2.0), 20..50);
    let path = |gap, back| BeamPath {
        radius: 40.0,
        gap,
        back,
    };
    vec![
        before_lens(name, random(), 375.0, effort),
        before_lens("grating of sine 0.25", grating, 375.0, effort),
        before_lens("random 2λ pixels, 40λ off the axis", aside, 250.0, effort),
        two_screens(random(), other(), 200.0, 120.0, effort),
        around_lens(random(), other(), 40.0, 120.0, effort),
        stopped(random(), 40.0, 120.0, effort),
        stop_before_lens(60.0, 250.0, effort),
        stop_before_lens(45.0, 250.0, effort),
        after_lens(name, random(), path(50.0, 200.0), effort),
        between_lenses(name, random(), path(20.0, 180.0), effort),
    ]
}

/// Random pixels of 2λ.
fn random() -> Pixels {
    random_pixels(30, 2.0)
}

/// As many from another part of the same noise.
fn other() -> Pixels {
    let noise = random_pixels(60, 2.0);
    let part = part(noise.transmission.view(), 30.., 30..);
    Pixels {
        transmission: part.to_owned(),
        ..noise
    }
}

/// A mirror 160λ wide on a Gaussian bump, seen 250λ away: without rays, and by beamlets.
fn bump(name: &str, coat: Coat) -> [Problem; 2] {
    let nodes = if let Coat::Random(_) = coat { 6 } else { 4 };
    [Method::Auto, Method::Beamlet].map(|method| {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let mirror = mirror::MirrorProblem {
            coat,
            width: 160.0,
            distance: 250.0,
            points: 24,
            pitch: 1.3,
        };
        mirror.problem(name, settings, nodes)
    })
}

/// Pixels that are dark but for these columns, and as many rows about the middle.
fn aside(mut pixels: Pixels, columns: std::ops::Range<usize>) -> Pixels {
    let rows = 15..45;
    for ((j, i), value) in pixels.transmission.indexed_iter_mut() {
        if !(columns.contains(&i) && rows.contains(&j)) {
            *value = num_complex::Complex64::ZERO;
        }
    }
    pixels
}

/// 60λ of pixels in free space, against the direct sum over box pixels.
fn free_space(name: &str, pixels: Pixels, z: f64, degrees: f64) -> Problem {
    let (count, pitch) = (40, 1.7);
    let tilt = [degrees.to_radians().sin(), 0.0];
    Problem {
        name: format!("{name}, {z}λ of free space, light at {degrees}°"),
        reference: "Rayleigh–Sommerfeld, direct sum",
        system: System {
            wavelength: 1.0,
            source: plane_wave(tilt),
            screens: vec![doe(0.0, &pixels), sensor(z, count, pitch)],
            trains: vec![vec![]],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let at = axis(count, pitch);
            let row = |y: &f64| at.iter().map(|x| [*x, *y, z]).collect::<Vec<_>>();
            let points: Vec<[f64; 3]> = at.iter().flat_map(row).collect();
            let field = rayleigh_sommerfeld(&pixels, tilt, 1.0, 4, &points);
            ndarray::Array2::from_shape_fn((count, count), |(j, i)| field[j * count + i])
        }),
    }
}

/// A hologram of random 12.6 µm cells in a disc, through the LA1131-A, against Collins' integral: in
/// its focus and out of it, convex or plane side first. In mm, at 0.7 µm.
fn catalogue_lens(convex_first: bool, back: f64) -> Problem {
    let (wavelength, pitch, count) = (0.7e-3, 6.3e-3, 100);
    let mut pixels = random_pixels(count, pitch);
    let coarse = random_pixels(count / 2, 2.0 * pitch);
    for ((j, i), value) in pixels.transmission.indexed_iter_mut() {
        let middle = 0.5 * (count as f64 - 1.0);
        let inside = (i as f64 - middle).hypot(j as f64 - middle) <= 0.5 * count as f64;
        *value = coarse.transmission[[j / 2, i / 2]] * f64::from(inside);
    }
    let (radius, plane) = (25.8, f64::INFINITY);
    let surface = |z, radius, index| face(z, radius, 12.7, Coating::Ideal, index);
    let (radii, power) = if convex_first {
        ([radius, plane], [(BK7 - 1.0) / radius, 0.0])
    } else {
        ([plane, -radius], [0.0, (BK7 - 1.0) / radius])
    };
    let train = vec![
        surface(3.0, radii[0], [1.0, BK7]),
        surface(8.3, radii[1], [BK7, 1.0]),
    ];
    let abcd = Abcd::identity()
        .drift(3.0, 1.0)
        .refract(power[0])
        .drift(5.3, BK7)
        .refract(power[1])
        .drift(back, 1.0);
    let side = if convex_first { "convex" } else { "plane" };
    Problem {
        name: format!("hologram, LA1131-A {side} side first, sensor {back} mm behind it"),
        reference: COLLINS,
        system: System {
            wavelength,
            source: plane_wave([0.0; 2]),
            screens: vec![doe(0.0, &pixels), sensor(8.3 + back, 128, pitch)],
            trains: vec![train],
        },
        settings: Settings::default(),
        exact: Box::new(move || {
            let at = axis(128, pitch);
            let integral = CollinsIntegral {
                pixels: &pixels,
                wavelength,
                train: abcd,
                nodes: 4,
            };
            match integral.field([0.0; 2], [&at, &at]) {
                Ok(field) => field,
                #[expect(
                    clippy::unreachable,
                    reason = "an instrument that is set up wrongly must stop"
                )]
                Err(_) => unreachable!("no sensor of this suite stands in an image of the pixels"),
            }
        }),
    }
}
