//! `raylet paper`: numbers, pictures, and a folder that says whose it is.

use std::fs;
use std::process::Command;

/// The document of a quick study, whose pictures have these names.
fn study(name: &str, pictures: &[&str]) -> serde_json::Value {
    let room = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room.path())
        .args(["paper", name, "--quick", "--out", "out"])
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{errors}");
    for picture in pictures {
        let file = room.path().join(format!("out/{picture}.png"));
        assert!(fs::read(file).unwrap().starts_with(b"\x89PNG"));
    }
    let document = fs::read_to_string(room.path().join("out/paper.json")).unwrap();
    serde_json::from_str(&document).unwrap()
}

#[test]
fn figure_three_ranks_the_sampling_methods_slow() {
    let room = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(room.path())
            .args(arguments)
            .output()
            .unwrap()
    };
    let output = run(&["paper", "fig3", "--quick", "--out", "fig3"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{errors}");
    assert!(
        text.contains("Metalens") && text.contains("Siemens"),
        "{text}"
    );
    let document = fs::read_to_string(room.path().join("fig3/paper.json")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    for (place, name) in ["metalens", "star"].iter().enumerate() {
        assert_eq!(document["tasks"][place]["name"], *name);
        let picture = fs::read(room.path().join(format!("fig3/{name}.png"))).unwrap();
        assert!(picture.starts_with(b"\x89PNG"));

        // The last of three numbers of draws: uniform is worst, systematic best.
        let error = |method: usize| {
            document["tasks"][place]["methods"][method]["errors"][2][1]
                .as_f64()
                .unwrap()
        };
        assert!(error(2) < error(1) && error(1) < error(0), "{text}");
    }

    assert_eq!(
        document["files"],
        serde_json::json!([
            "metalens.png",
            "metalens.toml",
            "metalens.npy",
            "star.png",
            "star.toml",
            "star.npy"
        ])
    );

    // The elements are there as scenes.
    let seen = run(&["simulate", "fig3/metalens.toml", "--out", "seen"]);
    assert!(
        seen.status.success(),
        "{}",
        String::from_utf8_lossy(&seen.stderr)
    );

    // Done again into the same folder it takes the place of the first; a file of the user's is in the way.
    let again = run(&["paper", "fig3", "--quick", "--out", "fig3"]);
    let errors = String::from_utf8(again.stderr).unwrap();
    assert!(again.status.success(), "{errors}");
    fs::write(room.path().join("fig3/notes.txt"), "mine").unwrap();
    let refused = run(&["paper", "fig3", "--quick", "--out", "fig3"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        String::from_utf8(refused.stderr)
            .unwrap()
            .contains("notes.txt")
    );

    // No study is called so.
    let refused = run(&["paper", "fig9"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8(refused.stderr).unwrap().contains("fig3"));
}

#[test]
fn figure_two_ranks_planes_and_rules() {
    let document = study("fig2", &["patches", "rays", "curvature"]);

    // A flat patch errs, one with the height hardly; dividing by the coverage needs the fewest rays.
    let patches = document["flat_patches"].as_array().unwrap();
    assert!(!patches.is_empty());
    for bent in patches {
        let error = |method: &str| bent[method][0].as_f64().unwrap();
        assert!(error("with_height") < error("incident"), "{bent}");
        assert!(error("incident") < error("tangent"), "{bent}");
    }
    let rays = |number: usize| document["needs"][number]["rays"].as_u64().unwrap();
    for side in 0..3 {
        let [dilated, jittered, divided] = [1, 2, 3].map(|rule| rays(3 * rule + side));
        assert!(divided < jittered && jittered < dilated);
    }
}

#[test]
fn figure_six_in_seconds_slow() {
    let names = ["foci_flat", "letter_flat", "foci_curved", "letter_curved"];
    let document = study("fig6", &names);
    for (place, name) in names.iter().enumerate() {
        let mirror = &document["mirrors"][place];
        assert_eq!(mirror["name"], *name);
        let error = |method: usize| mirror["outcomes"][method]["field_error"].as_f64().unwrap();
        let methods = mirror["outcomes"].as_array().unwrap().len();
        assert!(error(1) < 1e-4, "{name}: {}", error(1));
        assert!(error(2) > error(methods - 1), "{name}");
    }
}

#[test]
fn figure_five_in_seconds_slow() {
    let document = study("fig5", &["fig5"]);
    let number = |row: usize, what: &str| document["designs"][row][what].as_f64().unwrap();
    for row in 0..3 {
        assert!(
            (number(row, "ncc") - number(row, "ncc_by_collins")).abs() < 5e-3,
            "{document}"
        );
        assert!(number(row, "field_error_to_collins") < 2e-2, "{document}");
    }
    assert!(number(0, "ncc") < number(1, "ncc") - 0.05, "{document}");
    assert!(
        number(2, "light_in_picture") > 1.5 * number(1, "light_in_picture"),
        "{document}"
    );
}

#[test]
fn designs_of_the_curved_mirror_in_seconds() {
    let document = study("fig6-foci", &["square", "disc", "disc_weighted"]);
    let foci = |row: usize| {
        let numbers = &document["mirrors"][row]["separation_and_fwhm_um"];
        [0, 1, 2].map(|n| numbers[n].as_f64().unwrap())
    };
    let mean = |row: usize| 0.5 * (foci(row)[1] + foci(row)[2]);
    for row in 0..3 {
        assert!((foci(row)[0] - 8.0).abs() < 0.1, "{document}");
    }
    assert!(mean(0) < mean(1) && mean(2) < mean(1), "{document}");
    assert!(mean(1) < 1.3, "{document}");

    let document = study("fig6-s", &["letter"]);
    let like = document["ncc_by_direct_integral"].as_f64().unwrap();
    assert!(like > 0.9, "{document}");
}

/// The systems at small size: references, the paper's method and the default one, a picture, and nothing left of
/// the parts.
#[test]
fn systems_in_seconds_slow() {
    let room = tempfile::tempdir().unwrap();
    for (name, methods) in [("system1", 11), ("system2", 8), ("system3", 10)] {
        let output = Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(room.path())
            .args(["paper", name, "--quick", "--out", name])
            .output()
            .unwrap();
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{errors}");
        let folder = room.path().join(name);
        let document = fs::read_to_string(folder.join("paper.json")).unwrap();
        let document: serde_json::Value = serde_json::from_str(&document).unwrap();
        assert_eq!(document["methods"].as_array().unwrap().len(), methods);
        for file in document["files"].as_array().unwrap() {
            assert!(folder.join(file.as_str().unwrap()).is_file());
        }
        assert!(!room.path().join(format!("{name}.parts")).exists());

        // The default method against its reference; the picture of the right design through the lens.
        let like = |method: usize, against: usize| {
            document["methods"][method]["matches"][against]["match"]["field_error"]
                .as_f64()
                .unwrap()
        };
        match name {
            "system1" => assert!(like(8, 0) < 2e-2 && like(10, 0) < 1e-3, "{document}"),
            "system2" => assert!(like(7, 2) < 2e-3, "{document}"),
            _ => {
                let picture =
                    |method: usize| document["methods"][method]["ncc_with_picture"].as_f64();
                assert!(
                    picture(0).unwrap() < 0.8 && picture(5).unwrap() > 0.95,
                    "{document}"
                );
            }
        }
    }
}
