//! Tests: scenes and lens files, written as lens files and read again: the same first-order data, and the same rays.

use std::fs;
use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::model::build::system;
use crate::file::prescription::export::lens_export::{WrittenLens, lens_file};
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes, import_lens};
use crate::file::prescription::import_report::ImportReport;
use crate::file::prescription::optiland_test::{folder, landing_of};
use crate::file::scene::element::{Element, StopElement};
use crate::file::scene::scene_file::Scene;
use crate::math::vec3::Vec3;
use crate::optics::source::Source;

/// Starts as shares of the radius of the entrance pupil, and slopes against that of the axis.
const RAYS: [[f64; 4]; 4] = [
    [0.0, 0.0, 0.0, 0.0],
    [0.0, 0.7, 0.0, 0.0],
    [0.4, -0.3, 0.0, 0.0],
    [-0.2, 0.3, 0.004, -0.007],
];

/// Glasses that the catalogue does not have.
fn choices() -> ImportChoices {
    let other = [("L-TIM28_MOLD", "L-TIM28"), ("SK19", "N-SK16")];
    let pairs = other.map(|(name, other)| (name.to_owned(), other.to_owned()));
    ImportChoices {
        glasses: pairs.into(),
        ..ImportChoices::default()
    }
}

fn read(written: &WrittenLens, name: &str) -> ImportedLens {
    import_bytes(&written.bytes, Path::new(name), &ImportChoices::default())
        .unwrap_or_else(|fault| panic!("{fault}\n{}", String::from_utf8_lossy(&written.bytes)))
}

/// The scene as if it were an import of the file that is written of it.
fn original(scene: &Scene, written: &WrittenLens) -> ImportedLens {
    let mut scene = scene.clone();
    // The image of a tilted sensor stands where its middle is.
    if let Some(Element::Sensor(sensor)) = scene.element.last_mut()
        && sensor.tilt_deg != [0.0; 3]
    {
        sensor.decenter_mm = [0.0; 2];
    }
    ImportedLens {
        scene,
        report: ImportReport::default(),
        first_element_mm: -written.first_surface_mm,
        arrays: Vec::new(),
    }
}

/// The largest difference of landings in mm, over the size of the lens.
fn apart(scene: &Scene, written: &WrittenLens, again: &ImportedLens) -> f64 {
    let number = |name| written.report.number(name).unwrap_or(0.0);
    let radius = 0.5 * number("entrance pupil diameter (mm)");
    let size = radius
        + number("focal length, axis unfolded (mm)")
            .abs()
            .min(1e3 * radius);
    let first = original(scene, written);
    let differences = RAYS.map(|[x, y, p, q]| {
        let direction = Vec3::new(p, q, (1.0 - p * p - q * q).sqrt());
        let start = [x * radius, y * radius];
        let both = [&first, again].map(|lens| landing_of(lens, start, direction));
        match both {
            [Some(one), Some(two)] => (one[0] - two[0]).hypot(one[1] - two[1]) / size,
            // The pupil of a rod lens is wider than the rod: its outer rays miss it, in both.
            [None, None] if [x, y] != [0.0; 2] => 0.0,
            _ => f64::INFINITY,
        }
    });
    differences.into_iter().fold(0.0, f64::max)
}

/// First-order data that differ by more than 1e-12 of themselves.
fn different_numbers(written: &WrittenLens, again: &ImportedLens) -> Vec<String> {
    let mut differ = Vec::new();
    for name in [
        "focal length, axis unfolded (mm)",
        "entrance pupil diameter (mm)",
        "stop radius (mm)",
        "working f-number",
    ] {
        let [ours, theirs] = [&written.report, &again.report].map(|report| report.number(name));
        let same = match (ours, theirs) {
            (Some(ours), Some(theirs)) => (ours / theirs - 1.0).abs() < 1e-12,
            // Without power the focal length is infinite, or as long as rounding says.
            (ours, theirs) => ours.is_none_or(|f| f > 1e12) && theirs.is_none_or(|f| f > 1e12),
        };
        if !same {
            differ.push(format!("{name}: {ours:?} {theirs:?}"));
        }
    }
    differ
}

#[test]
fn lens_files_are_the_same_lenses_when_they_are_written_and_read_again() {
    let mut files: Vec<_> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let end = path.extension().unwrap_or_default();
            end.eq_ignore_ascii_case("zmx") || end.eq_ignore_ascii_case("seq")
        })
        .collect();
    files.sort();
    let (mut lenses, mut differ, mut largest) = (0, Vec::new(), 0.0f64);
    for path in &files {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let lens = import_lens(path, &choices()).unwrap_or_else(|fault| panic!("{fault}"));
        for target in ["a.zmx", "a.seq"] {
            let written = lens_file(&lens.scene, Path::new(target), false)
                .unwrap_or_else(|fault| panic!("{name} {target}: {fault}"));
            let again = read(&written, target);
            let numbers = different_numbers(&written, &again);
            let rays = apart(&lens.scene, &written, &again);
            if !numbers.is_empty() || rays > 1e-12 {
                differ.push(format!("{name} {target}: {numbers:?} {rays:e}"));
            }
            largest = largest.max(rays);
            lenses += 1;
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(lenses >= 98, "{lenses}");
}

/// The text of a scene with these elements between a stop and a sensor.
fn scene_of(elements: &str) -> String {
    format!(
        "version = 1\ntitle = \"Größe\"\nwavelength_um = 0.6\nsource = {{ kind = \"plane\" }}\n\
         [[element]]\nkind = \"stop\"\nthickness_mm = 2\naperture = {{ disc = {{ radius_mm = 1 }} }}\n{elements}\n\
         [[element]]\nkind = \"sensor\"\npixels = [8, 8]\npitch_um = 1\n"
    )
}

fn parsed(text: &str) -> Scene {
    Scene::parse(text, Path::new("a.toml")).unwrap_or_else(|fault| panic!("{fault}"))
}

/// A surface with these keys, a plane behind it.
fn singlet(keys: &str) -> String {
    format!(
        "[[element]]\nkind = \"surface\"\nthickness_mm = 3\nglass = \"N-SF11\"\nsemi_aperture_mm = 2\n{keys}\n\
         [[element]]\nkind = \"surface\"\nthickness_mm = 20\nsemi_aperture_mm = 3\n"
    )
}

fn doe(keys: &str) -> String {
    format!(
        "[[element]]\nkind = \"doe\"\nthickness_mm = 20\naperture = {{ disc = {{ radius_mm = 2 }} }}\n{keys}\n"
    )
}

/// Elements, and in which formats they are written and read again.
fn elements() -> Vec<(String, &'static [&'static str])> {
    let (both, seq): (&[&str], &[&str]) = (&["a.zmx", "a.seq"], &["a.seq"]);
    let mut list: Vec<(String, &[&str])> = [
        "radius_mm = 20\nconic = -0.5",
        "radius_mm = 20\nconic = -0.5\naspheric = [1e-5, -2e-7]",
        "radius_mm = 20\naspheric = [1e-5, 0, 0, 0, 0, 0, 0, 1e-13]",
        "radius_mm = 20\nshape = { kind = \"odd\", coefficients = [1e-3, 2e-4, 1e-5] }",
        "radius_mm = 20\naspheric = [1e-5, 1e-6, 1e-7, 1e-8]\nshape = { kind = \"odd\", coefficients = [1e-3] }",
        "radius_mm = -20\nshape = { kind = \"odd\", coefficients = [0, 2e-4] }",
        "shape = { kind = \"biconic\", radius_x_mm = 30, radius_y_mm = 20, conic_x = 0.5, conic_y = -1 }",
        "shape = { kind = \"cylinder\", straight_along = \"x\", radius_mm = 20, conic = -0.5 }",
        "shape = { kind = \"cylinder\", straight_along = \"y\", radius_mm = 20, conic = -0.5 }",
        "shape = { kind = \"toroid\", radius_mm = 20, rotation_radius_mm = 35, conic = 0.3, aspheric = [1e-5, 1e-7] }",
        "radius_mm = 40\naspheric = [1e-5]\nshape = { kind = \"xy\", norm_radius_mm = 2, terms = [\
         { x = 1, y = 2, height_um = 3 }, { x = 0, y = 3, height_um = -2 }, { height_um = 50 }] }",
    ]
    .map(|keys| (singlet(keys), both))
    .into();
    let zernike = "radius_mm = 40\naspheric = [1e-5]\n\
                   shape = { kind = \"zernike\", norm_radius_mm = 2, coefficients_um = [5, 1, 2, 3, 4, 1, -2] }";
    list.push((singlet(zernike), seq));
    for layer in [
        "{ kind = \"grating\", period_um = 20, direction_deg = 90 }",
        "{ kind = \"grating\", period_um = 20, direction_deg = -90, order = 2 }",
        "{ kind = \"grating\", period_um = 30, direction_deg = 25 }",
        "{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300, 4] }",
        "{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300, 4], centre_mm = [0.3, -0.2] }",
        "{ kind = \"zernike\", norm_radius_mm = 2, coefficients = [1, 20, 30, -100, 5, 6, 7] }",
        "{ kind = \"xy\", norm_radius_mm = 2, rotation_deg = 30, terms = [{ x = 2, coefficient = -200 }, \
         { x = 1, y = 1, coefficient = 30 }] }",
        "{ kind = \"lens\", focal_length_mm = 25 }",
        "{ kind = \"kinoform\", layer = [{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300] }] }",
        "{ kind = \"kinoform\", orders = [2], layer = [{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-150] }] }",
        "{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300] }, { kind = \"grating\", period_um = 50 }",
    ] {
        list.push((doe(&format!("layer = [{layer}]")), both));
    }
    for keys in [
        "tilt_deg = [0, 0, 0]\nreflect = true\nthickness_mm = -20",
        "radius_mm = 30\naspheric = [1e-5]\nglass = \"N-BK7\"\nthickness_mm = 20",
    ] {
        let layer = "layer = [{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300, 4] }]";
        let text = doe(&format!("{keys}\n{layer}"));
        list.push((text.replacen("thickness_mm = 20\n", "", 1), both));
    }
    list.extend(turned().map(|text| (text.to_owned(), both)));
    list
}

/// Elements that are tilted, shifted or folded.
fn turned() -> [&'static str; 5] {
    [
        "[[element]]\nkind = \"lens\"\ntilt_deg = [5, -3, 20]\ndecenter_mm = [0.2, -0.1]\nthickness_mm = 20\nsurface = [\
         { radius_mm = 25, thickness_mm = 3, glass = \"N-BK7\", semi_aperture_mm = 3 }, { radius_mm = -40, \
         semi_aperture_mm = 3 }]\n",
        "[[element]]\nkind = \"surface\"\nradius_mm = 20\ntilt_deg = [2, 3, 4]\ndecenter_mm = [0.1, 0.2]\nthickness_mm = 2\n\
         glass = { index = 1.6 }\nsemi_aperture_mm = 3\n[[element]]\nkind = \"mirror\"\nradius_mm = -80\ntilt_deg = [3, 0, 0]\n\
         semi_aperture_mm = 3\nthickness_mm = -1\n[[element]]\nkind = \"coordinate_break\"\ntilt_deg = [6, 0, 0]\n\
         thickness_mm = -2\n[[element]]\nkind = \"surface\"\nsemi_aperture_mm = 3\nthickness_mm = -9\n",
        "[[element]]\nkind = \"mirror\"\nradius_mm = -80\ntilt_deg = [10, 0, 0]\nsemi_aperture_mm = 3\nthickness_mm = 0\n[[element]]\n\
         kind = \"coordinate_break\"\ntilt_deg = [20, 0, 0]\ndecenter_mm = [0, 1]\nthickness_mm = -30\n",
        "[[element]]\nkind = \"lens\"\nthickness_mm = 20\nsurface = [\
         { radius_mm = 25, thickness_mm = 3, glass = { nd = 1.6, vd = 40.5 }, semi_aperture_mm = 3 },\
         { radius_mm = -20, thickness_mm = 1, glass = { nd = 1.61234567, vd = 40.123456 }, semi_aperture_mm = 3 },\
         { radius_mm = -30, thickness_mm = 1, glass = \"fused silica\", semi_aperture_mm = 3 },\
         { radius_mm = -30, thickness_mm = 1, glass = { wavelengths_um = [0.5, 0.6, 0.7, 0.8], indices = [1.7, 1.69, 1.68, \
         1.675] }, semi_aperture_mm = 3 },\
         { radius_mm = 50, thickness_mm = 1, glass = \"OHARA:S-LAH79\", semi_aperture_mm = 3 },\
         { radius_mm = -40, semi_aperture_mm = 3 }]\n",
        "[[element]]\nkind = \"surface\"\nradius_mm = 20\nthickness_mm = 2\nglass = \"N-BK7\"\naperture = { rectangle = { \
         width_mm = 3, height_mm = 4, centre_mm = [0.1, 0] }, blocked = [{ disc = { radius_mm = 0.2 } }, { disc = { \
         radius_mm = 0.1, centre_mm = [0.5, 0] } }] }\n[[element]]\nkind = \"surface\"\nthickness_mm = 5\n\
         semi_aperture_mm = 3\n[[element]]\nkind = \"stop\"\nthickness_mm = 5\naperture = { annulus = { inner_radius_mm = 0.1, \
         outer_radius_mm = 4 } }\n",
    ]
}

#[test]
fn elements_of_scenes_are_the_same_when_they_are_written_and_read_again() {
    let mut differ = Vec::new();
    for (elements, targets) in elements() {
        let scene = parsed(&scene_of(&elements));
        for target in targets {
            let written = lens_file(&scene, Path::new(target), false)
                .unwrap_or_else(|fault| panic!("{elements}\n{target}: {fault}"));
            let again = read(&written, target);
            let numbers = different_numbers(&written, &again);
            let rays = apart(&scene, &written, &again);
            if !numbers.is_empty() || rays > 1e-12 {
                differ.push(format!("{elements}\n{target}: {numbers:?} {rays:e}"));
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

/// Light of a point, of a beam before a lens, and in another medium than air.
#[test]
fn the_light_of_a_scene_is_that_of_its_file() {
    let point = "source = { kind = \"point\", position_mm = [1, -2, -40] }";
    let plane = "source = { kind = \"plane\", angle_deg = [3, -5] }";
    let elements = singlet("radius_mm = 20");
    for target in ["a.zmx", "a.seq"] {
        for source in [point, plane] {
            let text = scene_of(&elements).replace("source = { kind = \"plane\" }", source);
            for text in [text.clone(), format!("ambient = \"water\"\n{text}")] {
                let scene = parsed(&text);
                let written = lens_file(&scene, Path::new(target), false).unwrap();
                let again = read(&written, target);
                assert_eq!(different_numbers(&written, &again), Vec::<String>::new());
                assert!(apart(&scene, &written, &again) < 1e-12, "{text}");
                let [ours, theirs] = [&original(&scene, &written), &again].map(light);
                let off = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12, "{target} {text}");
            }
        }
    }
}

/// The direction of collimated light, or where its point stands from the first surface of the file.
fn light(lens: &ImportedLens) -> [f64; 3] {
    match system(&lens.scene, 0).unwrap().source {
        Source::Plane { direction, .. } => [direction.x, direction.y, direction.z],
        Source::Point { position, .. } => {
            [position.x, position.y, position.z + lens.first_element_mm]
        }
        other => panic!("{other:?}"),
    }
}

fn refused(scene: &Scene, target: &str) -> Fault {
    lens_file(scene, Path::new(target), false).unwrap_err()
}

#[test]
fn what_no_file_holds_is_refused_or_left_out_with_a_warning() {
    let folder = folder();
    let scenes = folder.parent().unwrap();
    let scene = Scene::open(&scenes.join("hologram_through_lens.toml")).unwrap();
    for target in ["a.zmx", "a.seq"] {
        let fault = refused(&scene, target);
        assert_eq!(fault.address.path, "element[0].layer[0]");
        assert!(fault.found.contains("pixels"), "{fault}");
        assert!(fault.hint.as_ref().unwrap().contains("--skip-unknown"));
        let written = lens_file(&scene, Path::new(target), true).unwrap();
        assert!(written.report.warnings[0].contains("element[0].layer[0]"));
        let again = read(&written, target);
        assert!(apart(&scene_without_pixels(&scene), &written, &again) < 1e-12);
    }
    let bumps =
        singlet("shape = { kind = \"gaussian\", bumps = [{ height_um = 1, sigma_mm = 1 }] }");
    let scene = parsed(&scene_of(&bumps));
    assert_eq!(refused(&scene, "a.zmx").address.path, "element[1]");
    assert_eq!(refused(&scene, "a.seq").address.path, "element[1]");
    let fault = lens_file(&scene, Path::new("a.len"), true).unwrap_err();
    assert!(fault.found.contains(".len"), "{fault}");
}

/// The scene with a stop in place of its hologram.
fn scene_without_pixels(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let Some(Element::Doe(doe)) = scene.element.first() else {
        panic!("no hologram");
    };
    scene.element[0] = Element::Stop(StopElement {
        name: doe.name.clone(),
        tilt_deg: doe.tilt_deg,
        decenter_mm: doe.decenter_mm,
        thickness_mm: doe.thickness_mm,
        aperture: doe.aperture.clone(),
    });
    scene
}

/// Kinds of layers in scenes of the repository that no file holds.
const WITHOUT_A_FILE: [&str; 4] = ["\"pixels\"", "\"vortex\"", "\"two_point\"", "\"sum\""];

/// The scenes of the repository.
fn scenes() -> Vec<PathBuf> {
    let root = folder().parent().unwrap().to_path_buf();
    let folders = [root.clone(), root.join("real_size"), root.join("paper")];
    let entries = folders
        .iter()
        .flat_map(|folder| fs::read_dir(folder).unwrap());
    let paths = entries.map(|entry| entry.unwrap().path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    scenes.collect()
}

#[test]
fn scenes_of_the_repository_are_the_same_or_refused_by_what_no_file_holds() {
    let (mut same, mut refused) = (0, 0);
    for path in scenes() {
        let scene = Scene::open(&path).unwrap();
        for target in ["a.zmx", "a.seq"] {
            match lens_file(&scene, Path::new(target), false) {
                Ok(written) => {
                    let again = read(&written, target);
                    let numbers = different_numbers(&written, &again);
                    assert!(numbers.is_empty(), "{}: {numbers:?}", path.display());
                    let rays = apart(&scene, &written, &again);
                    assert!(rays < 1e-12, "{}: {rays:e}", path.display());
                    same += 1;
                }
                Err(fault) => {
                    let known = WITHOUT_A_FILE.iter().any(|kind| fault.found.contains(kind));
                    assert!(known, "{fault}");
                    let written = lens_file(&scene, Path::new(target), true).unwrap();
                    assert!(!written.report.warnings.is_empty());
                    let again = read(&written, target);
                    assert!(different_numbers(&written, &again).is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(same >= 34 && refused >= 16, "{same} {refused}");
}
