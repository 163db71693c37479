//! Scenes with every shape and aperture, and those that must be refused at the right place.

use std::path::Path;

use ndarray::Array2;
use ndarray_npy::write_npy;

use crate::engine::geometrical::layout_rays::layout_rays;
use crate::file::model::build::system;
use crate::file::model::prescription::parts;
use crate::file::scene::scene_file::Scene;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Outline;
use crate::optics::doe::Layer;
use crate::optics::phase::profile::Profile;
use crate::optics::screen::ScreenKind;
use crate::optics::shape::Shape;

/// A scene with one of every shape and aperture.
pub(crate) const SCENE: &str = include_str!("../../../tests/scenes/every_shape.toml");

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("demo.toml")).map_err(|fault| fault.to_string())
}

/// Reads the scene with this array of heights beside it.
fn read(heights: &Array2<f64>) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("demo.toml");
    std::fs::write(&path, SCENE).expect("written");
    write_npy(folder.path().join("heights.npy"), heights).expect("written");
    Scene::read(&path).map_err(|fault| fault.to_string())
}

fn bowl(count: usize) -> Array2<f64> {
    let place = |i: usize| i as f64 - 0.5 * (count - 1) as f64;
    Array2::from_shape_fn((count, count), |(j, i)| {
        0.2 * (place(i).powi(2) + place(j).powi(2))
    })
}

#[test]
fn every_shape_is_read_written_and_built() {
    let scene = parse(SCENE).unwrap_or_else(|fault| panic!("{fault}"));
    let text = scene.to_toml().unwrap_or_else(|fault| panic!("{fault}"));
    let mut again = parse(&text).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    again.origin = scene.origin.clone();
    assert_eq!(scene, again);

    let scene = read(&bowl(10)).unwrap_or_else(|fault| panic!("{fault}"));
    let system = system(&scene, 0).unwrap_or_else(|fault| panic!("{fault}"));
    let list = parts(&scene, &system);
    let words: Vec<&str> = list.iter().map(|part| part.word()).collect();
    let expected = [
        "doe", "biconic", "freeform", "cylinder", "toroid", "freeform", "freeform", "doe", "stop",
        "mirror", "mirror", "sensor",
    ];
    assert_eq!(words, expected);

    // Radii at the vertex, of the curved element and the toroid, and heights in the units of their keys.
    assert_eq!(list[0].radii(), [Some(30.0); 2]);
    let [x, y] = list[4].radii().map(|radius| radius.unwrap_or(f64::NAN));
    assert!((x - 60.0).abs() < 1e-12 && (y - 40.0).abs() < 1e-12);
    let z = |part: usize, x, y| list[part].shape().height(x, y).map(|height| height.z);
    let [toric, sum] = [z(2, 2.0, 2.0), z(2, 0.0, 0.0)].map(|z| z.unwrap_or(f64::NAN));
    let conic = 50.0 - (2500.0f64 - 8.0).sqrt();
    assert!(sum == 0.0 && (toric - (conic + 1e-5 * 64.0 + 0.005 - 0.002)).abs() < 1e-14);
    // The bowl is 0.2 µm per squared step of 0.5 mm.
    assert!((z(10, 1.0, 0.5).unwrap_or(f64::NAN) - 0.2e-3 * 5.0).abs() < 1e-15);
    assert!(z(10, 2.3, 0.0).is_none());
}

#[test]
fn a_paraxial_lens_is_the_ideal_phase_in_its_aperture() {
    let scene = read(&bowl(10)).unwrap_or_else(|fault| panic!("{fault}"));
    let system = system(&scene, 0).unwrap_or_else(|fault| panic!("{fault}"));
    let ScreenKind::Doe(lens) = &system.screens[1].kind else {
        panic!("{:?}", system.screens[1]);
    };
    let [Layer::Phase(Profile::Lens { focal_length, .. })] = lens.layers[..] else {
        panic!("{:?}", lens.layers);
    };
    assert_eq!(focal_length, 80.0);
    assert!(matches!(lens.aperture.outline, Outline::Blocked { .. }));
    assert!(!lens.aperture.contains(1.0, 0.0) && lens.aperture.contains(1.0, 0.2));
    // Equal paths to the focus: flat phase plus k times the distance.
    let k = system.wavenumber();
    let total = |x: f64| {
        lens.layers.len() as f64 * {
            let [Layer::Phase(profile)] = &lens.layers[..] else {
                return f64::NAN;
            };
            profile.phase(x, 0.0) + k * x.hypot(80.0)
        }
    };
    assert!((total(2.5) - total(0.0)).abs() < 1e-8);
    assert_eq!(system.screens[1].shape, Shape::Plane);
}

/// Replaces a passage and expects words in the refusal, the address among them.
#[rustfmt::skip]
const REFUSED: &[(&str, &str, &[&str])] = &[
    // Kinds and keys.
    ("kind = \"biconic\"", "kind = \"biconc\"", &["demo.toml:20:18: element[1].surface[0].shape.kind", "did you mean `biconic`?"]),
    ("{ kind = \"biconic\", ", "{ ", &["demo.toml:20:9: element[1].surface[0].shape", "no `kind`"]),
    ("radius_x_mm", "radius_x", &["demo.toml:20:29: element[1].surface[0].shape.radius_x", "did you mean `radius_x_mm`?"]),
    ("rotation_radius_mm = 60", "rotation_mm = 60", &["element[3].shape.rotation_mm", "did you mean `rotation_radius_mm`?"]),
    ("straight_along = \"x\"", "straight_along = \"z\"", &["element[2].shape.straight_along", "`x`, `y`"]),
    ("straight_along = \"x\", ", "", &["element[2].shape", "no `straight_along`"]),
    ("straight_along = \"x\", radius_mm = 25", "straight_along = \"x\"", &["element[2].shape", "no `radius_mm`"]),
    ("coefficients = [0.01, 0, 1e-4]", "coefficients = []", &["element[4].shape.coefficients", "an empty list"]),
    ("coefficients = [0.01", "coefficients_um = [0.01", &["element[4].shape.coefficients_um", "did you mean `coefficients`?"]),
    ("norm_radius_mm = 3", "norm_radius_mm = 0", &["element[5].shape.norm_radius_mm", "above zero"]),
    ("{ x = 2, height_um = 5 }", "{ x = 2 }", &["element[1].surface[1].shape.terms[0]", "no `height_um`"]),
    ("{ x = 2, height_um = 5 }", "{ x = 41, height_um = 5 }", &["element[1].surface[1].shape.terms[0].x", "found 41", "up to 40"]),
    ("{ x = 2, height_um = 5 }", "{ x = -2, height_um = 5 }", &["element[1].surface[1].shape.terms[0].x", "found -2"]),
    ("sigma_mm = 2", "sigma_mm = -2", &["element[8].shape.bumps[1].sigma_mm", "above zero"]),
    ("pitch_um = 500, ", "", &["element[9].shape", "no `pitch_um`"]),
    ("focal_length_mm = 80", "focal_length_mm = 0", &["element[6].focal_length_mm", "other than zero"]),
    ("focal_length_mm = 80\n", "", &["element[6]", "no `focal_length_mm`"]),
    ("kind = \"paraxial_lens\"", "kind = \"paraxial_lens\"\nradius_mm = 3", &["element[6].radius_mm", "unknown key"]),
    // Keys that do not fit together.
    ("shape = { kind = \"toroid\"", "radius_mm = 9\nshape = { kind = \"toroid\"", &["element[3].radius_mm", "a shape of kind \"toroid\"", "inside `shape`"]),
    ("shape = { kind = \"cylinder\"", "conic = -1\nshape = { kind = \"cylinder\"", &["element[2].conic", "\"cylinder\""]),
    ("semi_aperture_mm = 3\nshape = { kind = \"toroid\"", "shape = { kind = \"toroid\"", &["element[3]: found no `semi_aperture_mm`", "or `aperture`"]),
    ("semi_aperture_mm = 3\nshape = { kind = \"toroid\"", "semi_aperture_mm = 3\naperture.disc.radius_mm = 3\nshape = { kind = \"toroid\"", &["element[3].aperture", "beside semi_aperture_mm"]),
    // Surfaces that end too soon.
    ("radius_x_mm = 20", "radius_x_mm = 2", &["demo.toml:19:12: element[1].surface[0].aperture", "where the surface does not exist"]),
    ("radius_mm = 30", "radius_mm = 0.9", &["demo.toml:10:12: element[0].aperture", "where the surface does not exist"]),
    ("rotation_radius_mm = 60", "rotation_radius_mm = 2.9", &["element[3].semi_aperture_mm", "where the surface does not exist"]),
    // Apertures.
    ("sides = 6", "sides = 2", &["element[0].aperture.regular_polygon.sides", "found 2", "from 3"]),
    ("sides = 6, ", "", &["element[0].aperture.regular_polygon", "no `sides`"]),
    ("rotation_deg = 10", "rotation = 10", &["element[0].aperture.regular_polygon.rotation", "did you mean `rotation_deg`?"]),
    ("[[-2, -2], [2, -2], [0, 2.5]]", "[[-2, -2], [2, -2]]", &["element[7].aperture.polygon.corners_mm", "2 corners"]),
    ("[[-2, -2], [2, -2], [0, 2.5]]", "[[-2, -2], [2, -2], [-2, 2], [2, 2]]", &["element[7].aperture.polygon.corners_mm", "sides cross"]),
    ("[[-2, -2], [2, -2], [0, 2.5]]", "[[-2, -2], [0, 0], [1, 1]]", &["element[7].aperture.polygon.corners_mm", "on one line"]),
    ("[[-2, -2], [2, -2], [0, 2.5]]", "[[-2, -2], [2, -2, 1], [0, 2.5]]", &["element[7].aperture.polygon.corners_mm[1]", "a list of 2 values"]),
    ("aperture = { polygon = {", "aperture = { disc = { radius_mm = 1 }, polygon = {", &["element[7].aperture", "several outlines"]),
    ("blocked = [{ disc = { radius_mm = 0.5 } }]", "blocked = [{}]", &["element[7].aperture.blocked[0]", "no outline", "`regular_polygon`"]),
    ("blocked = [{ disc = { radius_mm = 0.5 } }]", "blocked = { disc = { radius_mm = 0.5 } }", &["element[7].aperture.blocked", "found a table"]),
    ("inner_radius_mm = 0.5", "inner_radius_mm = 2.5", &["element[9].aperture.annulus.inner_radius_mm", "less than outer_radius_mm = 2"]),
];

#[test]
fn refusals_have_an_address() {
    let mut wrong = String::new();
    for (from, to, words) in REFUSED {
        assert!(SCENE.contains(from), "{from}");
        let refusal = match parse(&SCENE.replacen(from, to, 1)) {
            Ok(_) => format!("read, although {from:?} became {to:?}"),
            Err(refusal) => refusal,
        };
        for word in words.iter().filter(|word| !refusal.contains(**word)) {
            wrong += &format!("{word:?} is missing in\n{refusal}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn grids_of_heights_are_checked_once_they_are_loaded() {
    let refusal = |heights: &Array2<f64>| read(heights).err().unwrap_or_default();
    // Nine points at 0.5 mm end at 2 mm, eight before the mirror's edge.
    assert!(read(&bowl(9)).is_ok());
    let short = refusal(&bowl(8));
    assert!(short.contains("element[9].aperture"), "{short}");
    assert!(
        short.contains("where the surface does not exist"),
        "{short}"
    );
    let few = refusal(&bowl(3));
    assert!(few.contains("element[9].shape.height_um"), "{few}");
    assert!(
        few.contains("3 rows of 3, expected at least 4 rows of 4"),
        "{few}"
    );
}

/// A stop, then a mirror that folds the axis by 90° about x, then a sensor `reach` mm beside it.
fn folded(mirror: &str, reach: f64) -> Scene {
    let text = format!(
        r#"version = 1
wavelength_um = 0.5
source = {{ kind = "plane" }}
[[element]]
kind = "stop"
thickness_mm = 10
aperture = {{ disc = {{ radius_mm = 1 }} }}
[[element]]
kind = "coordinate_break"
tilt_deg = [45, 0, 0]
[[element]]
kind = "mirror"
thickness_mm = 0
semi_aperture_mm = 3
{mirror}
[[element]]
kind = "coordinate_break"
tilt_deg = [45, 0, 0]
thickness_mm = -{reach}
[[element]]
kind = "sensor"
pixels = [8, 8]
pitch_um = 100
"#
    );
    parse(&text).unwrap_or_else(|fault| panic!("{fault}"))
}

#[test]
fn a_plane_mirror_between_coordinate_breaks_folds_the_axis() {
    let scene = folded("", 7.0);
    let system = system(&scene, 0).unwrap_or_else(|fault| panic!("{fault}"));
    // The axis is turned by 90° about x: the sensor stands 7 mm beside the mirror, facing it.
    let sensor = system.screens[1].frame;
    let at = [sensor.origin.x, sensor.origin.y, sensor.origin.z];
    let expected = [0.0, 7.0, 10.0];
    assert!(
        at.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
        "{at:?}"
    );
    for hop in system.hops() {
        for (x, y, p, q) in [
            (0.0, 0.0, 0.0, 0.0),
            (0.3, -0.5, 0.02, 0.05),
            (-0.7, 0.1, 0.0, -0.1),
        ] {
            // As on a straight axis of 17 mm, seen by the mirrored sensor; x is left alone.
            let landing = hop
                .trace([x, y], [p, q], &mut ())
                .unwrap_or_else(|loss| panic!("{loss:?}"));
            let cosine = (1.0f64 - p * p - q * q).sqrt();
            let straight = [x + 17.0 * p / cosine, y + 17.0 * q / cosine];
            assert!((landing.path - 17.0 / cosine).abs() < 1e-12);
            assert!((landing.at[0] - straight[0]).abs() < 1e-12);
            assert!((landing.at[1] - straight[1]).abs() < 1e-12, "{landing:?}");
        }
    }
}

#[test]
fn a_toroid_of_coddingtons_radii_folds_light_into_one_focus() {
    // At an angle of incidence i a mirror has 1/f = 2/(R cos i) in the plane of incidence and
    // 1/f = 2 cos i/R across it (Coddington).
    let (f, cos) = (50.0, 0.5f64.sqrt());
    let [tangential, sagittal] = [2.0 * f / cos, 2.0 * f * cos];
    let shape = format!(
        "shape = {{ kind = 'toroid', radius_mm = -{tangential}, rotation_radius_mm = -{sagittal} }}"
    );
    let scene = folded(&shape, f);
    let system = system(&scene, 0).unwrap_or_else(|fault| panic!("{fault}"));
    for hop in system.hops() {
        let (landing, j) = hop
            .jacobian([0.0; 2], [0.0; 2])
            .unwrap_or_else(|loss| panic!("{loss:?}"));
        assert!(landing.at[0].hypot(landing.at[1]) < 1e-12);
        // Collimated light: where it lands does not depend on where it starts, and y = f p.
        assert!(j[0][0].abs() < 1e-13 && j[1][1].abs() < 1e-13, "{j:?}");
        assert!((j[0][2].abs() - f).abs() < 1e-11 && (j[1][3].abs() - f).abs() < 1e-11);
    }
}

#[test]
fn layout_rays_follow_a_curved_element() {
    // A reflecting parabola of radius 40 whose diffractive lens of 60 mm adds to its own power:
    // 1/f = 1/20 + 1/60 on the axis, f = 15.
    let text = r#"version = 1
wavelength_um = 0.5
source = { kind = "plane" }
[[element]]
kind = "doe"
thickness_mm = -15
reflect = true
radius_mm = -40
conic = -1
aperture = { disc = { radius_mm = 0.1 } }
layer = [{ kind = "lens", focal_length_mm = 60 }]
[[element]]
kind = "sensor"
pixels = [8, 8]
pitch_um = 100
"#;
    let scene = parse(text).unwrap_or_else(|fault| panic!("{fault}"));
    let system = system(&scene, 0).unwrap_or_else(|fault| panic!("{fault}"));
    let rays = layout_rays(&system, Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(rays.len(), 5);
    for layout_ray in rays {
        let end = layout_ray.points[layout_ray.points.len() - 1];
        // The aberration of the third order is below y³/f² = 5e-6.
        assert!(
            layout_ray.arrived && (end.z + 15.0).abs() < 1e-12 && end.y.abs() < 5e-6,
            "{end:?}"
        );
    }
}

/// What has no interface has no coating either.
#[test]
fn a_coating_without_an_interface_is_refused() {
    let element = |keys: &str, thickness: i32| {
        parse(&format!(
            r#"version = 1
wavelength_um = 0.5
source = {{ kind = "plane" }}
[[element]]
kind = "doe"
thickness_mm = {thickness}
aperture = {{ disc = {{ radius_mm = 0.1 }} }}
layer = [{{ kind = "lens", focal_length_mm = 60 }}]
{keys}
[[element]]
kind = "sensor"
pixels = [8, 8]
pitch_um = 100
"#
        ))
    };
    let mirror = element("reflect = true\ncoating = \"fresnel\"", -15).unwrap_err();
    assert!(
        mirror.contains("element[0].coating: found a coating on an element that reflects light"),
        "{mirror}"
    );
    let free = element("coating = \"ideal\"", 15).unwrap_err();
    assert!(free.contains("element that is no interface"), "{free}");
    element("coating = \"ideal\"\nglass = \"N-BK7\"", 15).unwrap_or_else(|fault| panic!("{fault}"));
}
