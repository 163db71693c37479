//! Scenes that must be read, and scenes that must be refused at the right place.

use std::collections::BTreeMap;
use std::path::Path;

use ndarray::{Array2, array};
use ndarray_npy::write_npy;
use num_complex::Complex64;

use crate::file::arrays::array::BorrowedArray;
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::file::scene::scene_file::Scene;

/// A scene with one of everything.
pub(crate) const SCENE: &str = r#"version = 1
title = "A hologram through a real lens"
wavelength_um = [0.7, 0.55]
seed = 3

[source]
kind = "plane"
angle_deg = [0.5, 0]

[[element]]
kind = "doe"
name = "hologram"
thickness_mm = 3.0
aperture = { disc = { radius_mm = 0.63 } }
[[element.layer]]
kind = "pixels"
pitch_um = 6.3
phase = "phase.npy"
amplitude = "amplitude.npy"
[[element.layer]]
kind = "sum"
weights = [1, -0.5]
terms = [
  [{ kind = "grating", period_um = 20 }],
  [{ kind = "vortex", charge = 2 }, { kind = "axicon", angle_deg = 1 }],
]

[[element]]
kind = "lens"
name = "LA1131-A"
thickness_mm = 44.7
[[element.surface]]
radius_mm = 25.8
thickness_mm = 5.3
glass = "N-BK7"
semi_aperture_mm = 12.7
[[element.surface]]
radius_mm = -inf
semi_aperture_mm = 12.7

[[element]]
kind = "stop"
thickness_mm = 1
aperture = { annulus = { inner_radius_mm = 1, outer_radius_mm = 2, centre_mm = [0, 1] } }

[[element]]
kind = "surface"
radius_mm = 60
semi_aperture_mm = 5
thickness_mm = 4
glass = { index = 1.5 }

[[element]]
kind = "mirror"
thickness_mm = -9
semi_aperture_mm = 5
conic = -1
aspheric = [1e-6]

[[element]]
kind = "coordinate_break"
tilt_deg = [0, 10, 0]

[[element]]
kind = "sensor"
pixels = [64, 32]
pitch_um = [2, 3]

[settings]
method = "beamlet"
coating = "fresnel"
paper = { rays = 1000 }

[hologram]
target = "photo.png"
element = "hologram"
size_mm = [0.1, 0.1]
"#;

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("demo.toml")).map_err(|fault| fault.to_string())
}

/// The scene with one passage replaced.
pub(crate) fn altered(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    SCENE.replacen(from, to, 1)
}

#[test]
fn values_arrive() {
    let scene = parse(SCENE).unwrap_or_else(|fault| panic!("{fault}"));
    assert_eq!(scene.wavelength_um, [0.7, 0.55]);
    assert_eq!(scene.element.len(), 7);
    assert_eq!(scene.settings.paper.rays, Some(1000));
    assert_eq!(scene.settings.target_error, 1e-3);
    let Element::Doe(doe) = &scene.element[0] else {
        panic!("{:?}", scene.element[0]);
    };
    match &doe.layer[..] {
        [Layer::Pixels(pixels), Layer::Sum(sum)] => {
            assert_eq!(pixels.pitch_um, [6.3, 6.3]);
            assert_eq!(sum.terms.iter().map(Vec::len).collect::<Vec<_>>(), [1, 2]);
        }
        other => panic!("{other:?}"),
    }
    let Element::Lens(lens) = &scene.element[1] else {
        panic!("{:?}", scene.element[1]);
    };
    assert_eq!(lens.surface[1].radius_mm, Some(f64::NEG_INFINITY));
    let shape = lens.surface[1].surface_shape().optics(None);
    assert_eq!(shape, Some(crate::optics::shape::Shape::Plane));
}

#[test]
fn written_scenes_read_back_the_same() {
    let scene = parse(SCENE).unwrap_or_else(|fault| panic!("{fault}"));
    let text = scene.to_toml().unwrap_or_else(|fault| panic!("{fault}"));
    let mut again = parse(&text).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    again.origin = scene.origin.clone();
    assert_eq!(scene, again);
}

#[test]
fn shortest_scene_has_defaults() {
    let text = "version = 1\nwavelength_um = 0.5\nsource = { kind = 'plane' }\n\
        [[element]]\nkind = 'stop'\nthickness_mm = 10\naperture.disc.radius_mm = 1\n\
        [[element]]\nkind = 'sensor'\npixels = [8, 8]\npitch_um = 10\n";
    let scene = parse(text).unwrap_or_else(|fault| panic!("{fault}"));
    assert_eq!((scene.seed, scene.settings.memory_limit_mb), (1, None));
}

/// Replaces a passage and expects words in the refusal, the address among them.
#[rustfmt::skip]
const REFUSED: &[(&str, &str, &[&str])] = &[
    // Text and version.
    ("seed = 3", "seed = = 3", &["demo.toml:4:8", "expected valid TOML"]),
    ("title =", "version = 1\ntitle =", &["demo.toml:2:1", "duplicate key"]),
    ("version = 1", "version = 2", &["demo.toml:1:11: version", "found 2, expected 1", "newer"]),
    ("version = 1\n", "\n", &["demo.toml:1:1", "no `version`"]),
    ("version = 1", "version = \"1\"", &["demo.toml:1:11", "the string \"1\"", "whole number"]),
    // Keys and kinds, at every depth.
    ("seed =", "sead =", &["demo.toml:4:1: sead", "unknown key", "did you mean `seed`?"]),
    ("angle_deg = [0.5", "angle = [0.5", &["demo.toml:8:1: source.angle", "did you mean `angle_deg`?"]),
    ("kind = \"plane\"", "kind = \"plain\"", &["demo.toml:7:8: source.kind", "did you mean `plane`?"]),
    ("kind = \"lens\"", "kind = \"lense\"", &["demo.toml:29:8: element[1].kind", "did you mean `lens`?"]),
    ("kind = \"lens\"\n", "", &["demo.toml:28:1: element[1]", "no `kind`", "[[element]]"]),
    ("kind = \"lens\"", "kind = 3", &["demo.toml:29:8: element[1].kind", "found 3, expected a string"]),
    ("radius_mm = 25.8", "raduis_mm = 25.8", &["demo.toml:33:1: element[1].surface[0].raduis_mm", "did you mean `radius_mm`?", "^^^^^^^^^"]),
    ("kind = \"stop\"", "kind = \"stop\"\ncolour = 1", &["demo.toml:43:1: element[2].colour", "unknown key"]),
    ("disc = { radius_mm", "disk = { radius_mm", &["demo.toml:14:14: element[0].aperture.disk", "did you mean `disc`?"]),
    ("disc = { radius_mm", "disc = { radius", &["demo.toml:14:23: element[0].aperture.disc.radius", "did you mean `radius_mm`?"]),
    ("kind = \"vortex\", charge", "kind = \"vortex\", charges", &["demo.toml:25:23: element[0].layer[1].terms[1][0].charges", "did you mean `charge`?"]),
    ("kind = \"grating\"", "kind = \"grid\"", &["demo.toml:24:13: element[0].layer[1].terms[0][0].kind", "`grating`"]),
    ("method = \"beamlet\"", "method = \"beam\"", &["demo.toml:70:10: settings.method", "did you mean `beamlet`?"]),
    ("{ rays = 1000 }", "{ ray = 1000 }", &["demo.toml:72:11: settings.paper.ray", "did you mean `rays`?"]),
    ("{ rays = 1000 }", "{ positions = \"random\" }", &["demo.toml:72:23: settings.paper.positions", "random", "`jittered`"]),
    ("{ rays = 1000 }", "{ coverage = 1 }", &["demo.toml:72:22: settings.paper.coverage", "found 1"]),
    ("{ rays = 1000 }", "{ density = \"uniforn\" }", &["demo.toml:72:21: settings.paper.density", "did you mean `uniform`?"]),
    ("{ rays = 1000 }", "{ sampler = \"sistematic\" }", &["demo.toml:72:21: settings.paper.sampler", "did you mean `systematic`?"]),
    ("{ rays = 1000 }", "{ sag = \"flat\" }", &["demo.toml:72:17: settings.paper.sag", "`tangent`"]),
    ("{ rays = 1000 }", "{ inside = true }", &["demo.toml:72:11: settings.paper.inside", "unknown key"]),
    ("glass = { index = 1.5 }", "glass = { indx = 1.5 }", &["demo.toml:51:11: element[3].glass.indx", "did you mean `index`?"]),
    ("[settings]", "[setings]", &["demo.toml:69:2: setings", "did you mean `settings`?"]),
    // Types and lengths.
    ("seed = 3", "seed = -3", &["demo.toml:4:8: seed", "found -3"]),
    ("seed = 3", "seed = 99999999999999999999", &["demo.toml:4:8: seed", "64 bits"]),
    ("thickness_mm = 3.0", "thickness_mm = \"3 mm\"", &["demo.toml:13:16: element[0].thickness_mm", "the string \"3 mm\", expected a number"]),
    ("tilt_deg = [0, 10, 0]", "tilt_deg = [0, 10]", &["demo.toml:62:12: element[5].tilt_deg", "a list of 2 values, expected a list of 3 values"]),
    ("angle_deg = [0.5, 0]", "angle_deg = [0.5, 0, 0]", &["demo.toml:8:13: source.angle_deg", "a list of 3 values, expected a list of 2 values"]),
    ("[source]", "[[source]]", &["demo.toml:6:1: source", "found a list, expected a table with a `kind`"]),
    ("glass = \"N-BK7\"", "glass = \"N-BK8\"", &["demo.toml:35:9: element[1].surface[0].glass", "no glass is named 'N-BK8'; the nearest names are SCHOTT:N-BK7", "a name of the glass catalogue"]),
    ("glass = { index = 1.5 }", "glass = { nd = 1.5 }", &["demo.toml:51:9: element[3].glass", "a medium with nd, expected one of: index; nd and vd"]),
    ("glass = \"N-BK7\"", "glass = 1.5", &["demo.toml:35:9: element[1].surface[0].glass", "found 1.5, expected the name of a glass or { index"]),
    ("pitch_um = [2, 3]", "pitch_um = [2, 3, 4]", &["demo.toml:67:12: element[6].pitch_um", "one number, or two"]),
    // Ranges.
    ("thickness_mm = 3.0", "thickness_mm = nan", &["demo.toml:13:16: element[0].thickness_mm", "found nan, expected a finite number"]),
    ("thickness_mm = 3.0", "thickness_mm = inf", &["demo.toml:13:16", "found inf"]),
    ("[0.5, 0]", "[0.5, nan]", &["demo.toml:8:19: source.angle_deg[1]", "nan"]),
    ("[0.5, 0]", "[95, 0]", &["demo.toml:8:13: source.angle_deg", "found 95", "between -90 and 90"]),
    ("[0.7, 0.55]", "[]", &["demo.toml:3:17: wavelength_um", "an empty list"]),
    ("[0.7, 0.55]", "700", &["demo.toml:3:17: wavelength_um", "found 700", "micrometres"]),
    ("[0.7, 0.55]", "nan", &["demo.toml:3:17: wavelength_um"]),
    ("pitch_um = 6.3", "pitch_um = -6.3", &["demo.toml:17:12: element[0].layer[0].pitch_um", "found -6.3, expected a length above zero"]),
    ("radius_mm = 0.63", "radius_mm = 0", &["demo.toml:14:35: element[0].aperture.disc.radius_mm", "above zero"]),
    ("radius_mm = 25.8", "radius_mm = 0", &["demo.toml:33:13: element[1].surface[0].radius_mm", "inf for a plane"]),
    ("radius_mm = 25.8", "radius_mm = nan", &["demo.toml:33:13: element[1].surface[0].radius_mm"]),
    ("pixels = [64, 32]", "pixels = [64, 0]", &["demo.toml:66:10: element[6].pixels", "found 0"]),
    ("pixels = [64, 32]", "pixels = [640000, 320000]", &["demo.toml:66:10: element[6].pixels", "memory_limit_mb"]),
    ("index = 1.5", "index = 0.5", &["demo.toml:51:19: element[3].glass.index", "from 1 to 10"]),
    ("period_um = 20", "period_um = 0", &["demo.toml:24:36: element[0].layer[1].terms[0][0].period_um", "above zero"]),
    // Parts that do not fit together.
    ("kind = \"sensor\"\npixels = [64, 32]\npitch_um = [2, 3]", "kind = \"coordinate_break\"", &["element[6].kind", "no sensor"]),
    ("[settings]", "[[element]]\nkind = \"stop\"\naperture.disc.radius_mm = 1\nthickness_mm = 1\n[settings]", &["demo.toml:65:8: element[6].kind", "the sensor at the end"]),
    ("[settings]", "[[element]]\nkind = \"sensor\"\npixels = [1, 1]\npitch_um = 1\n[settings]", &["demo.toml:70:8: element[7].kind", "a second sensor"]),
    ("thickness_mm = 3.0\n", "", &["demo.toml:10:1: element[0]", "no `thickness_mm`"]),
    ("pixels = [64, 32]", "pixels = [64, 32]\nthickness_mm = 1", &["demo.toml:67:1: element[6].thickness_mm", "unknown key"]),
    ("thickness_mm = 44.7", "thickness_mm = -44.7", &["demo.toml:31:16: element[1].thickness_mm", "no mirror"]),
    ("thickness_mm = -9", "thickness_mm = 9", &["demo.toml:55:16: element[4].thickness_mm", "odd number of mirrors"]),
    ("radius_mm = 25.8", "radius_mm = -12.5", &["demo.toml:36:20: element[1].surface[0].semi_aperture_mm", "its conic ends before"]),
    ("thickness_mm = 5.3", "thickness_mm = 3.3", &["demo.toml:34:16: element[1].surface[0].thickness_mm", "crosses this one at r = 12.6"]),
    ("-inf\nsemi_aperture_mm = 12.7", "-inf\nsemi_aperture_mm = 12.7\nglass = 'SF6'", &["demo.toml:40:9: element[1].surface[1].glass", "after the last surface"]),
    ("-inf\nsemi", "-inf\nthickness_mm = 1\nsemi", &["demo.toml:39:16: element[1].surface[1].thickness_mm", "on the last surface"]),
    ("glass = \"N-BK7\"\n", "", &["demo.toml:32:1: element[1].surface[0]", "no `glass`"]),
    ("inner_radius_mm = 1,", "inner_radius_mm = 2,", &["demo.toml:44:44: element[2].aperture.annulus.inner_radius_mm", "less than outer_radius_mm = 2"]),
    ("weights = [1, -0.5]", "weights = [1]", &["demo.toml:22:11: element[0].layer[1].weights", "2, one for each term"]),
    ("weights = [1, -0.5]", "weights = [1, [0, 1, 2]]", &["demo.toml:22:15: element[0].layer[1].weights[1]", "a number, or [re, im] of a complex one"]),
    ("weights = [1, -0.5]", "weights = [1, [0, inf]]", &["demo.toml:22:19: element[0].layer[1].weights[1][1]", "a finite number"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0, 0.2, 0.4], phase_rad = [0, 1, 2]", &["element[0].layer[1].terms[1][0].radius_mm", "at least 4"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0, 0.2, 0.4, 0.7], phase_rad = [0, 1, 2]", &["element[0].layer[1].terms[1][0].phase_rad", "4, one for each radius"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0.1, 0.2, 0.4, 0.7], phase_rad = [0, 1, 2, 3]", &["element[0].layer[1].terms[1][0].radius_mm[0]", "begins at the centre"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0, 0.4, 0.2, 0.7], phase_rad = [0, 1, 2, 3]", &["element[0].layer[1].terms[1][0].radius_mm[2]", "more than 0.4"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0, 0.2, 0.4, 0.6], phase_rad = [0, 1, 2, 3]", &["element[0].layer[1].terms[1][0].radius_mm", "up to 0.630000 mm, where the aperture ends"]),
    ("kind = \"vortex\", charge = 2", "kind = \"radial_table\", radius_mm = [0, 0.2, 0.4, 0.65], phase_rad = [0, 1, 2, 3], centre_mm = [0.03, 0]", &["element[0].layer[1].terms[1][0].radius_mm", "up to 0.660000 mm"]),
    ("amplitude = \"amplitude.npy\"", "amplitude = \"amplitude.npy\"\nfly_back_um = 7", &["element[0].layer[0].fly_back_um", "at most 6.3, for a pitch of 6.3"]),
    ("amplitude = \"amplitude.npy\"", "amplitude = \"amplitude.npy\"\ncrosstalk_um = 64", &["element[0].layer[0].crosstalk_um", "at most 63"]),
    ("amplitude = \"amplitude.npy\"", "amplitude = \"amplitude.npy\"\ncrosstalk_um = 1\nsub_pixels = 65", &["element[0].layer[0].sub_pixels", "from 2 to 64"]),
    ("amplitude = \"amplitude.npy\"", "amplitude = \"amplitude.npy\"\nfly_back_um = 1\nfill = 0.9", &["element[0].layer[0].fly_back_um", "fill = 1, or fly_back_um = 0"]),
    ("amplitude = \"amplitude.npy\"", "amplitude = \"amplitude.npy\"\ncrosstalk_um = 1\npixel = \"point\"", &["element[0].layer[0].crosstalk_um", "pixel = \"box\", or crosstalk_um = 0"]),
    ("[{ kind = \"grating\", period_um = 20 }]", "[]", &["demo.toml:24:3: element[0].layer[1].terms[0]", "an empty term"]),
    ("amplitude =", "transmission =", &["demo.toml:19:16: element[0].layer[0].transmission", "either the transmission or its parts"]),
    ("phase = \"phase.npy\"\namplitude = \"amplitude.npy\"\n", "", &["demo.toml:15:1: element[0].layer[0]", "no array"]),
    ("name = \"LA1131-A\"", "name = \"hologram\"", &["demo.toml:30:8: element[1].name", "of its own"]),
    ("element = \"hologram\"", "element = \"holgram\"", &["demo.toml:76:11: hologram.element", "did you mean \"hologram\"?"]),
    ("element = \"hologram\"", "element = \"LA1131-A\"", &["demo.toml:76:11: hologram.element", "not of kind \"doe\""]),
    ("kind = \"plane\"\nangle_deg = [0.5, 0]", "kind = \"point\"\nposition_mm = [0, 0, 5]", &["demo.toml:8:22: source.position_mm[2]", "less than zero"]),
];

#[test]
fn refusals_have_an_address() {
    let mut wrong = String::new();
    for (from, to, words) in REFUSED {
        let refusal = match parse(&altered(from, to)) {
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
fn cut_and_shortened_texts_are_refused_or_read_but_never_panic() {
    for end in 0..SCENE.len() {
        let _ = SCENE.get(..end).map(parse);
    }
    let lines: Vec<&str> = SCENE.lines().collect();
    for skipped in 0..lines.len() {
        let _ = parse(
            &[&lines[..skipped], &lines[skipped + 1..]]
                .concat()
                .join("\n"),
        );
    }
}

#[test]
fn later_findings_point_into_the_text() {
    let scene = parse(SCENE).unwrap_or_else(|fault| panic!("{fault}"));
    let fault = scene.fault("element[1].surface[0].glass", "an unknown glass", "a glass");
    let expected = "demo.toml:35:9: element[1].surface[0].glass: found an unknown glass, expected a glass\n    |\n 35 | glass = \"N-BK7\"\n    |         ^^^^^^^";
    assert_eq!(fault.to_string(), expected);
}

/// Writes the scene and its arrays into a new folder and reads it from there.
fn read(
    phase: &Array2<f64>,
    amplitude: &Array2<f64>,
) -> (Result<Scene, String>, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("demo.toml");
    std::fs::write(&path, SCENE).expect("written");
    write_npy(folder.path().join("phase.npy"), phase).expect("written");
    write_npy(folder.path().join("amplitude.npy"), amplitude).expect("written");
    let scene = Scene::read(&path).map_err(|fault| fault.to_string());
    (scene, folder)
}

#[test]
fn arrays_are_loaded_and_checked_where_they_are_named() {
    let phase = array![[0.0, 1.0, -2.0], [0.5, 3.0, 40.0]];
    let amplitude = array![[1.0, 0.5, 0.0], [1.0, 1.0, -1.0]];
    let (scene, _folder) = read(&phase, &amplitude);
    let scene = scene.unwrap_or_else(|fault| panic!("{fault}"));
    let Element::Doe(doe) = &scene.element[0] else {
        panic!("{:?}", scene.element[0]);
    };
    let Layer::Pixels(pixels) = &doe.layer[0] else {
        panic!("{:?}", doe.layer[0]);
    };
    let made = scene.arrays.transmission(pixels, "element[0].layer[0]");
    let expected = Array2::from_shape_fn((2, 3), |at| {
        Complex64::from_polar(1.0, phase[at]) * amplitude[at]
    });
    assert_eq!(made, Some(expected));

    let (refused, _folder) = read(&phase, &array![[1.0, 1.0]]);
    let refusal = refused.err().unwrap_or_default();
    for word in [
        "demo.toml:19:13: element[0].layer[0].amplitude",
        "1 rows of 2",
        "2 rows of 3",
    ] {
        assert!(refusal.contains(word), "{refusal}");
    }

    let (refused, _folder) = read(&phase.mapv(|x| x / 0.0), &amplitude);
    let refusal = refused.err().unwrap_or_default();
    for word in [
        "demo.toml:18:9: element[0].layer[0].phase",
        "phase.npy: NaN at [0, 0]",
    ] {
        assert!(refusal.contains(word), "{refusal}");
    }

    let missing = Scene::parse(SCENE, Path::new("nowhere/demo.toml")).and_then(Scene::load);
    let refusal = missing
        .err()
        .map(|fault| fault.to_string())
        .unwrap_or_default();
    assert!(
        refusal.contains(":18:9") && refusal.contains("No such file"),
        "{refusal}"
    );
}

/// Arrays of a caller take the place of files, and are refused at their fields as those are.
#[test]
fn arrays_may_be_lent() {
    let scene = Scene::parse(SCENE, Path::new("nowhere/demo.toml")).expect("a scene");
    let phase = array![[0.0, 1.0, -2.0], [0.5, 3.0, 40.0]];
    let amplitude = array![[1.0, 0.5, 0.0], [1.0, 1.0, -1.0]];
    let field = |key: &str| format!("element[0].layer[0].{key}");
    let lend = |phase: &Array2<f64>| {
        let lent = BTreeMap::from([
            (field("phase"), BorrowedArray::Real(phase.view())),
            (field("amplitude"), BorrowedArray::Real(amplitude.view())),
        ]);
        let arrays = scene.load_with(&lent);
        arrays.map(|arrays| arrays.get(&field("phase")).map(|look| look.shape()))
    };
    assert_eq!(lend(&phase), Ok(Some([2, 3])));
    let refusal = lend(&phase.mapv(|x| x / 0.0)).expect_err("not finite");
    assert_eq!(refusal.address.path, field("phase"));
    assert!(refusal.found.contains("NaN at [0, 0]"), "{refusal}");
}
