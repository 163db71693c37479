//! Rays of whole systems in blocks are the rays that are followed one by one.

use raylet::engine::geometrical::system_trace::trace_system;
use raylet::engine::progress::uncancelled;
use raylet::engine::ray_block::ray_origins::RayOrigins;
use raylet::engine::ray_block::system_rays::SystemRays;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::math::random::pair;
use raylet::optics::ray::Loss;
use raylet::optics::source::Source;
use raylet::optics::system::System;
use raylet_testkit::scenes::scene_path;

/// Systems with aspheres, mirrors, a spider, elements on a lens and on a ball, light of a plane wave and of a point.
const SCENES: [&str; 7] = [
    "real_size/cooke_triplet",
    "real_size/phone_lens",
    "real_size/double_gauss",
    "real_size/cassegrain",
    "real_size/hybrid_asphere",
    "real_size/combiner",
    "real_size/telescope_doublet",
];

/// More than a block, and no multiple of eight.
const RAYS: usize = 301;

/// Places over the first screen and somewhat beyond it.
fn places(system: &System) -> [Vec<f64>; 2] {
    let [x0, x1, y0, y1] = system.screens[0].bounds().unwrap();
    let place = |i: u32, axis: usize, low: f64, high: f64| {
        let share = 1.1 * (pair(3, [i, 0, 0, 0])[axis] - 0.5);
        0.5 * (low + high) + share * (high - low)
    };
    [(0, x0, x1), (1, y0, y1)].map(|(axis, low, high)| {
        (0..RAYS as u32)
            .map(|i| place(i, axis, low, high))
            .collect()
    })
}

/// Compares rays at all parts, and returns how many arrive and how many are clipped.
fn compare(system: &System, origins: RayOrigins, name: &str) -> [usize; 2] {
    let rays = SystemRays::new(system);
    let all: Vec<usize> = (0..rays.parts()).collect();
    let tracks = rays.trace(origins, &all, &uncancelled).unwrap();
    let mut counts = [0; 2];
    for i in 0..origins.len() {
        let (hits, lost) = match origins.of(system, i) {
            Ok((source, at)) => {
                let ray = trace_system(system, &source, at);
                (ray.hits, ray.lost)
            }
            Err(loss) => (Vec::new(), Some(loss)),
        };
        assert_eq!(tracks.lost[i], lost, "{name}: ray {i}");
        for part in 0..rays.parts() {
            let point = [0, 1, 2].map(|axis| tracks.points[[axis, part, i]]);
            let direction = [0, 1, 2].map(|axis| tracks.directions[[axis, part, i]]);
            let Some(hit) = hits.get(part) else {
                assert!(point.iter().chain(&direction).all(|x| x.is_nan()));
                assert!(tracks.paths[[part, i]].is_nan());
                continue;
            };
            let ours = { point.into_iter() }
                .chain(direction)
                .chain([tracks.paths[[part, i]]]);
            let (p, d) = (hit.point, hit.direction);
            for (ours, alone) in ours.zip([p.x, p.y, p.z, d.x, d.y, d.z, hit.path]) {
                let close = 1e-11 * (1.0 + alone.abs());
                assert!(
                    (ours - alone).abs() < close,
                    "{name}: {i} {part} {ours} {alone}"
                );
            }
        }
        counts[0] += usize::from(lost.is_none());
        counts[1] += usize::from(lost == Some(Loss::Clipped));
    }
    counts
}

#[test]
fn blocks_through_the_shipped_systems_are_single_rays() {
    let mut clipped = 0;
    for name in SCENES {
        let scene = Scene::read(&scene_path(name)).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let [x, y] = places(&system);
        let light = match system.source {
            Source::Plane { direction, .. } => direction,
            Source::Point { position, .. } => position,
            other => panic!("{other:?}"),
        };
        let light = [[light.x, light.y, light.z]];
        let at = [&x[..], &y[..]];
        let between = RayOrigins::IN_MM;
        let light = &light;
        let counts = compare(&system, RayOrigins::Lit { light, at, between }, name);
        // Light of its own for each ray.
        let light = &vec![light[0]; RAYS];
        let same = compare(&system, RayOrigins::Lit { light, at, between }, name);
        assert_eq!(counts, same);
        assert!(counts[0] > 20, "{name}: {counts:?}");
        clipped += counts[1];
    }
    assert!(clipped > 100, "{clipped}");
}

/// Rays that start in front of a lens with directions of their own, some of which miss it.
#[test]
fn free_rays_are_single_rays() {
    let scene = Scene::read(&scene_path("real_size/cooke_triplet")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    let directions: Vec<[f64; 3]> = (0..RAYS as u32)
        .map(|i| {
            let [x, y] = pair(4, [i, 0, 0, 0]).map(|u| 0.5 * (u - 0.5));
            [x, y, (1.0 - x * x - y * y).sqrt()]
        })
        .collect();
    let origins = RayOrigins::Free {
        points: &[[0.5, -0.2, -40.0]],
        directions: &directions,
    };
    let [arrived, clipped] = compare(&system, origins, "free");
    assert!(arrived > 10 && clipped > 50, "{arrived} {clipped}");
}
