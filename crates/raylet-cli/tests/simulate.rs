//! `raylet simulate` as a user runs it: complete results, the same for any number of threads, whole or
//! not at all.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use ndarray::Axis;
use raylet::file::result::result_folder::ResultFolder;
use raylet_testkit::scenes::scene_path;

use crate::stage::{SCENE, Stage, complaint, names};

fn is_png(path: &Path) -> bool {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    let first = bytes[0];
    frame.width >= 600 && bytes.iter().any(|b| *b != first)
}

#[test]
fn results_are_complete() {
    let stage = Stage::new(SCENE);
    let output = stage.raylet(&["simulate", "scene.toml"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let out = stage.join("scene-out");
    let files = [
        "doe-pixels.png",
        "field.npz",
        "layout.png",
        "result.json",
        "sensor.png",
        "table.csv",
    ];
    assert_eq!(names(&out), files);
    for picture in files.iter().filter(|name| name.ends_with(".png")) {
        assert!(is_png(&out.join(picture)), "{picture}");
    }

    // The numbers agree with each other.
    let ResultFolder { report, fields } = ResultFolder::read(&out).unwrap();
    assert_eq!(fields.field.dim(), (1, 40, 48));
    assert_eq!(fields.wavelength_um.to_vec(), [0.7]);
    assert!((fields.x_mm[1] - fields.x_mm[0] - 5e-3).abs() < 1e-15);
    let sum: f64 = fields.field.iter().map(|u| u.norm_sqr()).sum();
    let channel = &report.channels[0];
    assert!((channel.metrics.power - sum * 25e-6).abs() < 1e-12 * sum);
    // Power through the sensor has the mean cosine of its directions.
    let cosine = channel.hops[0].power.landed.unwrap() / channel.metrics.power;
    assert!((0.97..1.0).contains(&cosine), "{cosine}");
    assert!(channel.hops[0].rays.arrived > 0);
    assert!(
        channel
            .error
            .is_some_and(|error| error > 0.0 && error < 0.05)
    );
    assert_eq!(report.files.len(), 5);
    assert_eq!(
        report.machine.peak_memory_mb.is_some(),
        cfg!(target_os = "linux")
    );

    // What is said: numbers on standard output, plain lines of progress on standard error.
    let said = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(
        said.contains("scene-out") && said.contains("of the light"),
        "{said}"
    );
    assert_eq!(
        complaint(&output).matches("hop 1 of 1 to 'camera'").count(),
        1
    );
}

#[test]
fn every_key_is_documented() {
    let stage = Stage::new(SCENE);
    let output = stage.raylet(&["simulate", "scene.toml", "--method", "plane"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let text = fs::read_to_string(stage.join("scene-out/result.json")).unwrap();
    let mut keys = BTreeSet::new();
    collect(&serde_json::from_str(&text).unwrap(), &mut keys);
    // The other methods' plans are null in this run.
    for key in [
        "step_um",
        "footprint_um",
        "corrected",
        "expected_seconds",
        "positions",
        "side_um",
    ] {
        keys.insert(String::from(key));
    }
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/result.md");
    let book = fs::read_to_string(book).unwrap();
    assert!(keys.len() > 60);
    for key in keys {
        assert!(
            book.contains(&format!("`{key}`")),
            "docs/result.md lacks `{key}`"
        );
    }
}

fn collect(value: &serde_json::Value, keys: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, inner) in map {
                keys.insert(key.clone());
                collect(inner, keys);
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|inner| collect(inner, keys)),
        _ => {}
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let stage = Stage::new(SCENE);
    for method in ["auto", "plane", "paper"] {
        let run = |threads: &str| {
            let arguments = [
                "simulate",
                "scene.toml",
                "--out",
                "o",
                "--method",
                method,
                "--threads",
                threads,
            ];
            let output = stage.raylet(&arguments);
            assert!(output.status.success(), "{}", complaint(&output));
            assert_eq!(
                ResultFolder::read(&stage.join("o"))
                    .unwrap()
                    .report
                    .machine
                    .threads
                    .to_string(),
                threads
            );
            fs::read(stage.join("o/field.npz")).unwrap()
        };
        assert!(run("1") == run("2"), "{method}");
    }
}

#[test]
fn wavelengths_share_one_folder() {
    let scene = SCENE.replace(
        "wavelength_um = 0.7",
        "wavelength_um = [0.7, 0.45, 0.5, 0.6]",
    );
    let stage = Stage::new(&scene);
    let output = stage.raylet(&["simulate", "scene.toml"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let folder = ResultFolder::read(&stage.join("scene-out")).unwrap();
    assert_eq!(folder.fields.field.dim(), (4, 40, 48));
    assert_eq!(folder.fields.wavelength_um.to_vec(), [0.7, 0.45, 0.5, 0.6]);
    assert_eq!(folder.report.channels.len(), 4);
    assert!(is_png(&stage.join("scene-out/sensor.png")));
}

/// A focus in three fields, two colours and at two distances: the rows of the table are the runs of their scenes.
const LENS: &str = r#"version = 1
wavelength_um = [0.5, 0.55]
settings.target_error = 1e-2
source = { kind = "plane" }
[[element]]
kind = "doe"
layer = [{ kind = "lens", focal_length_mm = 2.0 }]
aperture = { disc = { radius_mm = 0.1 } }
thickness_mm = 2
[[element]]
kind = "sensor"
pixels = [24, 20]
pitch_um = 1
"#;

#[test]
fn a_sweep_has_a_row_for_each_run() {
    let stage = Stage::new(LENS);
    let swept = "simulate scene.toml --out swept --field 0,0 --field=-3,1 --field 5,0 --distance-mm 1.9 --distance-mm 2 --follow";
    let output = stage.raylet(&swept.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", complaint(&output));
    let ResultFolder { report, fields } = ResultFolder::read(&stage.join("swept")).unwrap();
    assert_eq!(fields.field.dim(), (12, 20, 24));
    let csv = fs::read_to_string(stage.join("swept/table.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0][..5],
        [
            "angle_x_deg",
            "angle_y_deg",
            "distance_mm",
            "wavelength_um",
            "error"
        ]
    );
    assert_eq!(rows[6][..4], ["-3.0", "1.0", "2.0", "0.5"]);
    assert_eq!(rows.len(), 13);
    assert!(rows.iter().all(|row| row.len() == 17));

    // The sensor follows: what is lit stands in its middle in every field.
    for channel in &report.channels {
        let [x, y] = channel.metrics.peak_mm.unwrap();
        assert!(
            x.abs() < 1.1e-3 && y.abs() < 1.1e-3,
            "{}: {x}, {y}",
            channel.name()
        );
        assert!(channel.target_reached.is_some() && channel.light_share.unwrap() > 0.5);
    }

    // One of its runs by a scene of its own.
    let own = LENS
        .replace("\"plane\" }", "\"plane\", angle_deg = [5, 0] }")
        .replace("thickness_mm = 2", "thickness_mm = 1.9")
        .replace(
            "pitch_um = 1",
            &format!(
                "pitch_um = 1\ndecenter_mm = [{}, 0]",
                1.9 * 5_f64.to_radians().tan()
            ),
        );
    fs::write(stage.join("own.toml"), own).unwrap();
    let output = stage.raylet(&["simulate", "own.toml", "--out", "own"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let one = ResultFolder::read(&stage.join("own")).unwrap();
    let (one, same) = (
        one.fields.field.index_axis(Axis(0), 1).to_owned(),
        fields.field.index_axis(Axis(0), 10),
    );
    let apart = (&one - &same)
        .iter()
        .map(|u| u.norm_sqr())
        .sum::<f64>()
        .sqrt();
    let whole = one.iter().map(|u| u.norm_sqr()).sum::<f64>().sqrt();
    assert!(apart < 1e-2 * whole, "{apart} of {whole}");

    // What is said is a table; what cannot be is refused.
    let said =
        String::from_utf8(output_of(&stage, &["--field", "0,0", "--field", "1,0"]).stdout).unwrap();
    assert!(said.starts_with("  all runs: method free\n"), "{said}");
    let rows = said.lines().take_while(|line| !line.contains(" threads"));
    assert!(
        rows.clone().count() == 7 && rows.clone().all(|line| line.chars().count() <= 80),
        "{said}"
    );
    for (bad, why) in [
        ("0", "two angles X,Y in degrees"),
        ("0,90", "degrees between -90 and 90"),
        ("0,0,-5", "source.position_mm"),
    ] {
        let output = output_of(&stage, &["--field", bad]);
        assert!(
            !output.status.success() && complaint(&output).contains(why),
            "{}",
            complaint(&output)
        );
    }
}

fn output_of(stage: &Stage, options: &[&str]) -> std::process::Output {
    stage.raylet(&[&["simulate", "scene.toml", "--out", "more"], options].concat())
}

#[test]
fn earlier_results_are_replaced_and_failures_change_nothing() {
    let stage = Stage::new(SCENE);
    let run = || stage.raylet(&["simulate", "scene.toml", "--out", "out"]);
    assert!(run().status.success());
    assert!(run().status.success());

    // What a user has put there since is not lost.
    let notes = stage.join("out/notes.txt");
    fs::write(&notes, "mine").unwrap();
    let output = run();
    assert_eq!(output.status.code(), Some(2));
    assert!(complaint(&output).contains("such as notes.txt"));
    assert_eq!(fs::read_to_string(&notes).unwrap(), "mine");
    fs::remove_file(&notes).unwrap();

    // A failing run leaves the earlier result as it was, and nothing beside it.
    let before = fs::read(stage.join("out/result.json")).unwrap();
    let dark = SCENE.replace("pitch_um = 5\n", "pitch_um = 5\ndecenter_mm = [300, 0]\n");
    fs::write(stage.join("scene.toml"), dark).unwrap();
    let output = run();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        complaint(&output).contains("scene.toml:"),
        "{}",
        complaint(&output)
    );
    assert_eq!(fs::read(stage.join("out/result.json")).unwrap(), before);
    assert_eq!(stage.names(), ["out", "phase.npy", "scene.toml"]);
}

#[test]
fn check_and_schema_report_without_running() {
    let stage = Stage::new(SCENE);
    let output = stage.raylet(&["check", "scene.toml"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    for piece in [
        "N-BK7",
        "1.513064",
        "focal length",
        "beamlet (1 curved surface",
        "pixel lattice of 'pixels'",
        " rays",
        " MB",
    ] {
        assert!(said.contains(piece), "{piece} not in\n{said}");
    }
    let output = stage.raylet(&["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema["title"], "raylet scene");
    assert_eq!(stage.names(), ["phase.npy", "scene.toml"]);
}

#[test]
fn check_warns_of_what_may_surprise() {
    let cases = [
        ("pitch_um = 5\n", "pitch_um = 45\n", "coarser than"),
        (
            "semi_aperture_mm = 1\n",
            "semi_aperture_mm = 0.3\n",
            "rim 1 behind pixels cuts",
        ),
        (
            "semi_aperture_mm = 1\n",
            "semi_aperture_mm = 0.1\n",
            "rim 1 behind pixels: a screen",
        ),
        (
            "pixels = [48, 40]",
            "pixels = [4800, 4000]",
            "much larger than the light",
        ),
        (
            "[source]",
            "settings.period = 4\n[source]",
            "aberration inside beamlets and their windows",
        ),
    ];
    for (from, to, warning) in cases {
        let stage = Stage::new(&SCENE.replace(from, to));
        let output = stage.raylet(&["check", "scene.toml"]);
        let said = String::from_utf8(output.stdout.clone()).unwrap();
        assert!(output.status.success(), "{to}{}", complaint(&output));
        assert!(
            said.contains(warning),
            "{to} should have '{warning}':\n{said}"
        );
    }
}

/// The triplet of 50 mm with a mask at its stop: no whole field, and one clear line of what it took.
#[test]
fn a_lens_of_full_size_goes_by_local_bands() {
    let stage = Stage::new(SCENE);
    let scene = scene_path("real_size/cooke_triplet");
    let scene = scene.to_str().unwrap();
    let output = stage.raylet(&["simulate", scene, "--out", "triplet"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let out = stage.join("triplet");
    assert!(is_png(&out.join("sensor.png")));
    let ResultFolder { report, .. } = ResultFolder::read(&out).unwrap();
    let channel = &report.channels[0];
    assert!(channel.error.is_some_and(|error| error < 1e-3));
    for hop in &channel.hops {
        assert_eq!(hop.plan.method, "local_bands");
        assert!(hop.samples.is_none() && hop.plan.directions.is_none());
        assert!(hop.rays.arrived > 1000);
        let bands = hop.plan.local_bands.as_ref().unwrap();
        assert!(bands.sigma_um > 50.0 && bands.windows[0] > 20);
    }
    // An even cone of f/4 has the mean cosine 1 − 1/256, times that of the chief ray, which comes at 15.3°. Pixels of 1 µm do not
    // tell its steeper part from light on the other side of the axis.
    let landed = channel.hops[1].power.landed.unwrap();
    let cosine = landed / channel.metrics.power / (1.0 - 1.0 / 256.0);
    assert!((0.960..0.970).contains(&cosine), "{cosine}");

    // The plan says the same.
    let output = stage.raylet(&["check", scene]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", complaint(&output));
    assert!(text.contains("no whole field"), "{text}");
}
