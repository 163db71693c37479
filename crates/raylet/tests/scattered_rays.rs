//! What goes into and comes out of a scattering: the same for any ranges and threads, unit directions, and
//! one clear error for every wrong array.

use raylet::engine::external::scatter::Scatter;
use raylet::engine::external::scatter_settings::{Coverage, Scattering};
use raylet::engine::external::secondary_rays::SecondaryRays;
use raylet::math::vec3::Vec3;
use raylet::optics::screen::Screen;
use raylet_testkit::noise::column;
use raylet_testkit::scattered::{COUNT, Columns, tilted_element};

fn settings() -> Scattering {
    Scattering {
        threshold: 1e-2,
        ..Scattering::beamlets(2.0)
    }
}

fn plan<'a>(screen: &'a Screen, columns: &'a Columns, settings: Scattering) -> Scatter<'a> {
    Scatter::new(
        screen,
        1.0,
        columns.rays(),
        Some(&columns.curvature),
        settings,
    )
    .unwrap()
}

#[test]
fn ranges_and_threads_change_nothing() {
    let screen = tilted_element(0.01, &column(COUNT * COUNT, 1));
    let columns = Columns::on(&screen);
    let plan = plan(&screen, &columns, settings());
    let whole = plan.scatter(0..49);
    let mut parts = SecondaryRays::default();
    for range in [0..20, 20..21, 21..60] {
        parts.append(plan.scatter(range));
    }
    parts.dropped = whole.dropped;
    assert_eq!(whole, parts);
    assert!(
        whole.dropped > 0.0 && whole.dropped < 0.1,
        "{}",
        whole.dropped
    );
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .unwrap();
    assert_eq!(whole, pool.install(|| plan.scatter(0..49)));
    assert!(plan.unevenness() < 1.6, "{}", plan.unevenness());

    // Each ray leaves from its place to the side of reflection, as a unit vector.
    let axis = screen.frame.z;
    for i in 0..whole.len() {
        let [x, y, z] = whole.direction[i];
        let d = Vec3::new(x, y, z);
        assert!((d.norm() - 1.0).abs() < 1e-14 && d.dot(axis) < 0.2);
        assert_eq!(whole.path[i], columns.path[whole.parent[i]]);
        let (at, from) = (whole.position[i], columns.position[whole.parent[i]]);
        assert!((0..3).all(|c| (at[c] - from[c]).abs() < 1e-12));
    }
}

/// The error message after `change` to good rays.
fn fault(change: impl Fn(&mut Columns, &mut Scattering)) -> String {
    let screen = tilted_element(0.0, &column(COUNT * COUNT, 1));
    let mut columns = Columns::on(&screen);
    let mut settings = settings();
    change(&mut columns, &mut settings);
    let curvature = Some(&columns.curvature[..]);
    let plan = Scatter::new(&screen, 1.0, columns.rays(), curvature, settings);
    plan.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn bad_input_is_one_clear_error() {
    let expect_words = |text: String, words: [&str; 3]| {
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    };
    expect_words(
        fault(|c, _| c.path.truncate(40)),
        ["path", "40", "expected 49"],
    );
    expect_words(
        fault(|c, _| c.curvature.truncate(2)),
        ["curvature", "2", "expected 49"],
    );
    expect_words(
        fault(|c, _| c.weight[5].im = f64::NAN),
        ["weight[5]", "NaN", "finite"],
    );
    expect_words(
        fault(|c, _| c.direction[7] = [0.0; 3]),
        ["direction[7]", "length 0", "unit vector"],
    );
    expect_words(
        fault(|c, _| c.position[8][2] += 0.5),
        [
            "position[8]",
            "off the surface of screen 'mirror'",
            "at most",
        ],
    );
    expect_words(
        fault(|c, _| c.direction[9] = [0.0, 0.0, -1.0]),
        ["direction[9]", "cosine -0.9", "sign 1"],
    );
    expect_words(
        fault(|_, s| *s = Scattering::beamlets(-1.0)),
        ["window sigma", "-1", "positive"],
    );
    expect_words(
        fault(|_, s| s.coverage = Coverage::Area(0.0)),
        ["area of a ray", "0", "positive"],
    );
    expect_words(fault(|_, s| s.threshold = 2.0), ["threshold", "2", "share"]);
    expect_words(
        fault(|_, s| s.samples = 100),
        ["period", "modes of a patch", "fewer directions"],
    );
    expect_words(
        fault(|_, s| s.samples = 700),
        ["screen 'mirror'", "samples", "700"],
    );
    assert_eq!(fault(|_, _| {}), "");
}

/// Rays whose parent is no arriving ray have neither weights nor a transpose; before one was foreign, they had both.
#[test]
fn foreign_rays_have_no_weights_and_no_transpose() {
    let screen = tilted_element(0.0, &column(COUNT * COUNT, 1));
    let columns = Columns::on(&screen);
    let plan = plan(&screen, &columns, settings());
    let mut secondary = plan.scatter(0..2);
    let bar = column(secondary.len(), 4);
    plan.weigh(&secondary).unwrap();
    plan.weigh_adjoint(&secondary, &bar).unwrap();
    secondary.parent[0] = 49;
    let weights = plan.weigh(&secondary).unwrap_err();
    let transpose = plan.weigh_adjoint(&secondary, &bar).unwrap_err();
    for found in [weights, transpose].map(|error| error.to_string()) {
        assert!(found.contains("parent is 49"), "{found}");
    }
}

#[test]
fn a_transpose_needs_a_cotangent_for_every_ray() {
    let screen = tilted_element(0.0, &column(COUNT * COUNT, 1));
    let columns = Columns::on(&screen);
    let plan = plan(&screen, &columns, settings());
    let secondary = plan.scatter(0..2);
    let count = secondary.len();
    for given in [0, count - 1, count + 1] {
        let found = plan.weigh_adjoint(&secondary, &column(given, 4));
        let found = found.unwrap_err().to_string();
        let expected = format!("weight_bar has {given} entries, expected {count}");
        assert!(found.contains(&expected), "{found}");
    }
}
