//! The drawing of a system: its parts cut by a plane, and a few rays.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use raylet::engine::geometrical::layout_rays::{Deflection, LayoutRay, layout_rays};
use raylet::file::model::prescription::{Part, parts};
use raylet::file::scene::scene_file::Scene;
use raylet::math::vec3::Vec3;
use raylet::optics::screen::ScreenKind;
use raylet::optics::source::Source;
use raylet::optics::system::System;

use crate::figure::{Figure, Panel};
use crate::panel::FigureError;
use crate::part_section::{Place, Plane, between, label, line, symbols};
use crate::section_panel::{LayoutScene, RayPath, shared};

/// A second panel shows the light alone where it takes less than this share of the parts' height.
const THIN: f64 = 0.3;

/// Device pixels per pixel of a figure.
const SCALE: f64 = 1.5;

/// A system in one field of light.
#[derive(Clone, Debug)]
pub struct FieldView<'a> {
    /// What tells the field from others.
    pub name: String,
    /// The system with this light.
    pub system: &'a System,
}

/// What is drawn of a system: its parts, and the rays of every field with the number of its colour.
struct Drawn<'a> {
    parts: Vec<Part<'a>>,
    /// The sensors of further fields that stand elsewhere.
    sensors: Vec<Part<'a>>,
    trails: Vec<(LayoutRay, usize)>,
    /// What the colours mean; empty where there is one.
    groups: Vec<String>,
}

impl<'a> Drawn<'a> {
    /// Of several fields each has its colour; of one field the rays have that of how elements turned them.
    fn new(scene: &'a Scene, views: &'a [FieldView], plane: &Plane) -> Self {
        let mut drawn = Drawn {
            parts: Vec::new(),
            sensors: Vec::new(),
            trails: Vec::new(),
            groups: Vec::new(),
        };
        for (number, view) in views.iter().enumerate() {
            let rays = layout_rays(view.system, plane.normal).into_iter();
            drawn.trails.extend(rays.map(|ray| {
                let group = match (views.len(), ray.turn) {
                    (2.., _) => number,
                    (_, Deflection::Straight) => 0,
                    (_, Deflection::Up) => 1,
                    (_, Deflection::Down) => 2,
                };
                (ray, group)
            }));
            let mut seen = parts(scene, view.system);
            if number == 0 {
                drawn.parts = seen;
            } else if let (Some(last), Some(sensor)) = (drawn.parts.last(), seen.pop())
                && (sensor.frame().origin - last.frame().origin).norm() > 0.0
            {
                drawn.sensors.push(sensor);
            }
        }
        if views.len() > 1 {
            drawn.groups = views.iter().map(|view| view.name.clone()).collect();
        } else if drawn.trails.iter().any(|(_, group)| *group > 0) {
            let turns = ["undeflected", "to the upper side", "to the lower side"];
            drawn.groups = turns.map(String::from).to_vec();
        }
        drawn
    }
}

/// A system in some fields of light, cut by the plane through z in which it is bent, as plain geometry, and the name of
/// its transverse axis, "x" or "y". The parts are those of the first view.
pub fn layout(scene: &Scene, views: &[FieldView]) -> (LayoutScene, &'static str) {
    let plane = plane_of(views);
    let drawn = drawing(&Drawn::new(scene, views, &plane), &plane, None);
    (drawn, plane.name)
}

/// The system as PNG, as the light of one wavelength sees it in some fields.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn layout_png(scene: &Scene, views: &[FieldView]) -> Result<Vec<u8>, FigureError> {
    let plane = plane_of(views);
    let drawn = Drawn::new(scene, views, &plane);

    // Where the light is thin against the parts, a second view shows what it meets.
    let light = extent(
        (drawn.trails.iter())
            .flat_map(|(ray, _)| &ray.points)
            .map(|p| plane.at(*p)[1]),
    );
    let whole = drawing(&drawn, &plane, None);
    let all = extent(whole.surfaces.iter().flat_map(|c| &c.points).map(|p| p[1]));
    let thin = match (light, all) {
        (Some([a, b]), Some([c, d])) if b - a < THIN * (d - c) => {
            let room = 0.25 * (b - a).max(1e-3 * (d - c));
            Some([a - room, b + room])
        }
        _ => None,
    };
    let panel = |content: LayoutScene, title: &str| -> Vec<Panel<'static>> {
        vec![
            Panel::layout(content)
                .transverse(plane.name)
                .title(title)
                .into(),
        ]
    };
    let section = format!("Section through z and {}", plane.name);
    let mut rows = vec![panel(whole, &section)];
    if let Some(window) = thin {
        let close = drawing(&drawn, &plane, Some(window));
        rows.push(panel(close, "The light, close up"));
    }
    let title = match scene.title.as_str() {
        "" => String::from("Layout"),
        title => title.to_owned(),
    };
    Figure::new(rows, title).to_png(SCALE)
}

/// The plane, of the two through the z axis, in which more of the system is tilted, shifted or turned.
fn plane_of(views: &[FieldView]) -> Plane {
    let scores = views.iter().map(|view| bends(view.system));
    let score = scores.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    let (x, y) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0));
    if score[0] > score[1] {
        Plane {
            up: x,
            normal: y * -1.0,
            name: "x",
        }
    } else {
        Plane {
            up: y,
            normal: x,
            name: "y",
        }
    }
}

/// How much of a system is tilted, shifted or turned along x and y.
fn bends(system: &System) -> [f64; 2] {
    let mut score = [0.0f64; 2];
    let mut add = |v: Vec3, weight: f64| {
        score[0] += weight * v.x.abs();
        score[1] += weight * v.y.abs();
    };
    let screens = system.screens.iter().map(|s| &s.frame);
    let surfaces = system.trains.iter().flatten().map(|s| &s.frame);
    for frame in screens.chain(surfaces) {
        add(frame.z, 10.0);
        add(frame.origin, 1.0);
    }
    match system.source {
        Source::Plane { direction, .. } | Source::TaperedPlane { direction, .. } => {
            add(direction, 3.0);
        }
        Source::Point { position, .. } | Source::TaperedPoint { position, .. } => {
            add(position, 1.0);
        }
        Source::Gaussian(beam) => add(beam.axes[2], 3.0),
    }
    // A smooth phase that turns the light as a whole, such as a grating.
    for screen in &system.screens {
        if let ScreenKind::Doe(doe) = &screen.kind
            && let Some([gx, gy]) = doe.phase_gradient(0.0, 0.0)
        {
            let turned = system.wavelength / std::f64::consts::TAU;
            add(Vec3::new(gx * turned, gy * turned, 0.0), 3.0);
        }
    }
    score
}

/// The range of finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| {
        let [lo, hi] = range.unwrap_or([v, v]);
        Some([lo.min(v), hi.max(v)])
    })
}

/// Everything as plain geometry, within a window of the transverse coordinate if one is given.
fn drawing(drawn: &Drawn, plane: &Plane, window: Option<[f64; 2]>) -> LayoutScene {
    let parts = &drawn.parts;
    let mut scene = LayoutScene {
        ray_groups: drawn.groups.clone(),
        ..LayoutScene::default()
    };
    for (ray, group) in &drawn.trails {
        scene.rays.push(RayPath {
            points: ray.points.iter().map(|p| plane.at(*p)).collect(),
            group: *group,
        });
    }
    let lines: Vec<Vec<Place>> = parts.iter().map(|part| line(part, plane, window)).collect();
    let ambient = parts.first().map_or(1.0, Part::index_before);
    for (number, part) in parts.iter().enumerate() {
        let before = number.checked_sub(1).map(|n| parts[n].frame().origin);
        scene
            .surfaces
            .extend(symbols(part, &lines[number], before, plane));
        if part.index() != ambient
            && let Some(next) = lines.get(number + 1)
        {
            scene.glass.push(between(&lines[number], next));
        }
        scene.labels.extend(label(part, &lines[number]));
    }
    for sensor in &drawn.sensors {
        let line = line(sensor, plane, window);
        scene.surfaces.extend(symbols(sensor, &line, None, plane));
    }
    scene.labels = shared(scene.labels);
    scene
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use ndarray_npy::write_npy;
    use raylet::file::model::build::system;
    use raylet::file::model::scene_sweep::scene_at_place;
    use raylet::file::result::channel::Place;
    use raylet::file::scene::scene_file::Scene;
    use raylet::optics::system::System;

    use crate::decoded_png::DecodedPng;
    use crate::layout_picture::{FieldView, layout, layout_png};
    use crate::section_panel::CurveKind;

    /// A scene with one of every shape and aperture, which the library's tests read.
    const SCENE: &str = include_str!("../../raylet/tests/scenes/every_shape.toml");

    /// What the scene's parts are drawn as, in its section through z and x. A disc inside the stop is a curve of its
    /// own, and so is each side of the ring; a bar across the ideal lens blocks the whole section.
    const KINDS: [CurveKind; 13] = [
        CurveKind::Doe,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Surface,
        CurveKind::Stop,
        CurveKind::Mirror,
        CurveKind::Mirror,
        CurveKind::Mirror,
        CurveKind::Sensor,
    ];

    /// z in mm of the first seven curves above x, by the numbers of the scene.
    fn heights(x: f64) -> [f64; 7] {
        let circle = |radius: f64| radius - (radius * radius - x * x).sqrt();
        let r = x.abs();
        let defocus = 3.0f64.sqrt() * (2.0 * x * x / 9.0 - 1.0);
        [
            circle(30.0),
            2.0 + circle(20.0),
            4.0 + circle(50.0) + 1e-5 * x.powi(4) + 5e-3 * (0.5 * x).powi(2),
            7.0,
            10.0 + circle(60.0),
            13.0 + 0.01 * r + 1e-4 * r.powi(3),
            16.0 + 1e-3 * defocus,
        ]
    }

    /// Colours of elements, glass and sensors.
    const ELEMENT: [u8; 3] = [0xa3, 0x15, 0x9a];
    const GLASS: [u8; 3] = [0xcf, 0xe2, 0xf4];
    const SENSOR: [u8; 3] = [0x0f, 0x76, 0x6e];

    /// The parts have their symbols and heights, and their colours stand in the picture where they do along z.
    #[test]
    fn every_shape_is_drawn() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("demo.toml");
        std::fs::write(&path, SCENE).unwrap();
        let place = |i: usize| i as f64 - 4.5;
        let bowl = Array2::from_shape_fn((10, 10), |(j, i)| {
            0.2 * (place(i).powi(2) + place(j).powi(2))
        });
        write_npy(folder.path().join("heights.npy"), &bowl).unwrap();
        let scene = Scene::read(&path).unwrap();
        let system = system(&scene, 0).unwrap();
        let views = [FieldView {
            name: String::new(),
            system: &system,
        }];
        let (drawn, up) = layout(&scene, &views);
        assert_eq!(up, "x");
        let kinds: Vec<CurveKind> = drawn.surfaces.iter().map(|curve| curve.kind).collect();
        assert_eq!(kinds, KINDS);
        for (number, curve) in drawn.surfaces.iter().take(7).enumerate() {
            assert!(curve.points.len() > 40, "{number}");
            for [z, x] in &curve.points {
                let off = z - heights(*x)[number];
                assert!(off.abs() < 1e-12, "{number}: {off:e} at {x}");
            }
        }

        // The element's line, three pixels wide, stands at 0 mm, the sensor at 26 mm.
        let picture = DecodedPng::of(&layout_png(&scene, &views).unwrap());
        assert_eq!(picture.width, 1800);
        let [element, glass, sensor] =
            [ELEMENT, GLASS, SENSOR].map(|colour| picture.columns(colour).unwrap());
        let start = element[0] as f64 + 1.5;
        let end = 0.5 * (sensor[0] + sensor[1]) as f64;
        let column = |z: f64| start + (end - start) * z / 26.0;
        for (found, z) in glass.into_iter().zip([2.0, 16.0]) {
            let off = found as f64 - column(z);
            assert!(off.abs() < 4.0, "{z}: {off}");
        }
        for (z, filled) in [
            (1.0, false),
            (3.0, true),
            (5.5, false),
            (8.5, true),
            (11.5, false),
            (14.5, true),
            (18.0, false),
        ] {
            let x = column(z).round() as usize;
            assert_eq!(picture.column_has(x, GLASS), filled, "{z}");
        }
    }

    /// A scene's system with light at an angle along x.
    fn at(scene: &Scene, angle: f64, follow: bool) -> System {
        let field = Place {
            angle_deg: Some([angle, 0.0]),
            ..Place::default()
        };
        system(&scene_at_place(scene, &field, follow).unwrap(), 0).unwrap()
    }

    /// A triplet before a narrow stop, on its axis and at 14° and 20°: five rays of each field come to the sensor, each
    /// field in its colour.
    #[test]
    fn rays_of_every_field_come_through_the_stop() {
        let text = include_str!("../../../scenes/real_size/cooke_triplet.toml");
        let path = std::path::Path::new("triplet.toml");
        let scene = Scene::parse(text, path).unwrap();
        let systems = [0.0, 14.0, 20.0].map(|angle| at(&scene, angle, false));
        let views = [0, 1, 2].map(|number| FieldView {
            name: format!("field {number}"),
            system: &systems[number],
        });
        let (drawn, up) = layout(&scene, &views);
        assert_eq!((up, drawn.ray_groups.len()), ("x", 3));
        let groups: Vec<usize> = drawn.rays.iter().map(|ray| ray.group).collect();
        assert_eq!(groups, [[0; 5], [1; 5], [2; 5]].concat());

        // They end in the sensor's plane, and start at five places.
        let sensor = drawn.surfaces.last().unwrap().points[0][0];
        for rays in drawn.rays.chunks(5) {
            for pair in rays.windows(2) {
                assert!(pair[1].points[1][1] > pair[0].points[1][1]);
            }
            for ray in rays {
                let off = ray.points.last().unwrap()[0] - sensor;
                assert!(off.abs() < 1e-9, "{off:e}");
            }
        }
    }

    /// A sensor that follows the light stands at every field.
    #[test]
    fn sensors_that_follow_the_light_are_all_drawn() {
        let text = include_str!("../../../scenes/achromat.toml");
        let scene = Scene::parse(text, std::path::Path::new("achromat.toml")).unwrap();
        let systems = [0.0, 5.0].map(|angle| at(&scene, angle, true));
        let views = systems.each_ref().map(|system| FieldView {
            name: String::new(),
            system,
        });
        let sensors = |views: &[FieldView]| {
            let curves = layout(&scene, views).0.surfaces;
            let kinds = curves.iter().map(|curve| curve.kind);
            kinds.filter(|kind| *kind == CurveKind::Sensor).count()
        };
        assert_eq!([sensors(&views), sensors(&views[..1])], [2, 1]);
    }

    /// An element on the front of a lens: the glass stands between the two, and none before the sensor.
    #[test]
    fn glass_behind_an_element_on_a_lens_ends_at_the_back() {
        let text = "version = 1\nwavelength_um = 0.5\nsource = { kind = \"plane\" }\n\
            [[element]]\nkind = \"doe\"\nradius_mm = 10\nthickness_mm = 3\nglass = { index = 1.5 }\n\
            aperture = { disc = { radius_mm = 2 } }\nlayer = [{ kind = \"lens\", focal_length_mm = 90 }]\n\
            [[element]]\nkind = \"surface\"\nthickness_mm = 20\nsemi_aperture_mm = 2\n\
            [[element]]\nkind = \"sensor\"\npixels = [8, 8]\npitch_um = 1\n";
        let scene = Scene::parse(text, std::path::Path::new("hybrid.toml")).unwrap();
        let (drawn, _) = layout(
            &scene,
            &[FieldView {
                name: String::new(),
                system: &system(&scene, 0).unwrap(),
            }],
        );
        assert_eq!(drawn.glass.len(), 1);
        let along = |end: f64| {
            drawn.glass[0]
                .points
                .iter()
                .map(move |at| (at[0] - end).abs())
        };
        assert!(along(3.0).fold(f64::INFINITY, f64::min) < 1e-9);
        assert!(drawn.glass[0].points.iter().all(|at| at[0] < 3.0 + 1e-9));
    }
}
