//! Conics that bring every ray to one point over one optical path.

use crate::rays::stage::{OwnedHop, conic, screen};
use raylet_testkit::parts::{face, mirror, on_axis};

/// Allowed difference of optical paths and distance from the focus, in mm.
const EXACT: f64 = 1e-12;

/// Rays that start at `starts`, [x, y, p_x, p_y], must all end on the axis after a path of `path` mm.
fn assert_stigmatic(owned: &OwnedHop, starts: &[[f64; 4]], path: f64) {
    for &[x, y, px, py] in starts {
        let landing = owned.hop().trace([x, y], [px, py], &mut ()).unwrap();
        assert!(
            landing.at[0].hypot(landing.at[1]) < EXACT,
            "{x} {y} {px} {py}: {landing:?}"
        );
        assert!(
            (landing.path - path).abs() < EXACT,
            "{x} {y} {px} {py}: path {} for {path}",
            landing.path
        );
    }
}

/// Parallel rays at several heights, up to `height`.
fn collimated(height: f64) -> Vec<[f64; 4]> {
    [[0.0, 0.0], [0.3, 0.0], [-0.5, 0.4], [0.0, -1.0], [0.6, 0.8]]
        .map(|[x, y]| [height * x, height * y, 0.0, 0.0])
        .to_vec()
}

/// An ellipsoid of conic constant −1/n² focuses collimated light inside the glass, at nR/(n − 1).
#[test]
fn ellipsoid_focuses_collimated_light_into_glass() {
    for (n, radius, height) in [(1.5, 20.0, 18.0), (1.8, 30.0, 25.0), (4.0, 12.0, 10.0)] {
        let focus = n * radius / (n - 1.0);
        let shape = conic(radius, -1.0 / (n * n));
        let owned = OwnedHop {
            from: screen(on_axis(-5.0), 1.0, 1.0),
            train: vec![face(on_axis(0.0), shape, [1.0, n])],
            to: screen(on_axis(focus), n, 1.0),
        };
        assert_stigmatic(&owned, &collimated(height), 5.0 + n * focus);
    }
}

/// A hyperboloid of conic constant −n² focuses light that is collimated in glass in air, at |R|/(n − 1).
#[test]
fn hyperboloid_focuses_collimated_light_out_of_glass() {
    for (n, radius, height) in [(1.5, 20.0, 15.0), (1.8, 30.0, 20.0)] {
        let focus = radius / (n - 1.0);
        let shape = conic(-radius, -n * n);
        let owned = OwnedHop {
            from: screen(on_axis(-20.0), n, 1.0),
            train: vec![face(on_axis(0.0), shape, [n, 1.0])],
            to: screen(on_axis(focus), 1.0, 1.0),
        };
        assert_stigmatic(&owned, &collimated(height), 20.0 * n + focus);
    }
}

/// A plano-hyperbolic collimator and its mirror image: a point becomes a point again.
#[test]
fn two_hyperboloids_image_a_point_into_a_point() {
    let (n, radius, thickness) = (1.6, 18.0, 9.0);
    let focus = radius / (n - 1.0);
    let owned = OwnedHop {
        from: screen(on_axis(-focus), 1.0, 1.0),
        train: vec![
            face(on_axis(0.0), conic(radius, -n * n), [1.0, n]),
            face(on_axis(thickness), conic(-radius, -n * n), [n, 1.0]),
        ],
        to: screen(on_axis(thickness + focus), 1.0, 1.0),
    };
    let starts = [0.0, 0.1, 0.25, 0.4].map(|p| [0.0, 0.0, 0.8 * p, -0.6 * p]);
    assert_stigmatic(&owned, &starts, 2.0 * focus + n * thickness);
}

/// A paraboloid and a hyperboloid whose far focus is the paraboloid's: Cassegrain's telescope.
#[test]
fn hyperbolic_mirror_moves_the_focus_of_a_parabola() {
    // The foci of a conic stand at R/(1 + e) and R/(1 − e); here 30 mm before and 100 mm behind.
    let (before, behind) = (30.0, 100.0);
    let e = (behind + before) / (behind - before);
    let radius = -before * (1.0 + e);
    let owned = OwnedHop {
        from: screen(on_axis(-150.0), 1.0, 1.0),
        train: vec![
            mirror(on_axis(0.0), conic(-200.0, -1.0)),
            mirror(on_axis(-100.0 + before), conic(radius, -e * e)),
        ],
        to: screen(on_axis(-100.0 + before + behind), 1.0, 1.0),
    };
    assert_stigmatic(&owned, &collimated(40.0), 150.0 + 100.0 - before + behind);
}

/// The aplanatic points seen from air: light that converges towards (1 + n)R behind a sphere of glass
/// meets at (1 + 1/n)R in it, with sines in the ratio n.
#[test]
fn sphere_shortens_a_focus_at_its_aplanatic_points() {
    let (n, radius) = (1.7, 15.0);
    let (far, near) = (radius * (1.0 + n), radius * (1.0 + 1.0 / n));
    let owned = OwnedHop {
        from: screen(on_axis(far), 1.0, 1.0),
        train: vec![face(on_axis(0.0), conic(radius, 0.0), [1.0, n])],
        to: screen(on_axis(near), n, 1.0),
    };
    // Rays are launched from the virtual focus and fly back to the sphere first.
    let starts = [0.0, 0.1, 0.3, 0.5].map(|p| [0.0, 0.0, 0.6 * p, 0.8 * p]);
    assert_stigmatic(&owned, &starts, n * near - far);
    for [x, y, px, py] in starts {
        let landing = owned.hop().trace([x, y], [px, py], &mut ()).unwrap();
        let [qx, qy] = landing.cosines;
        assert!((qx - n * n * px).abs() < 1e-14 && (qy - n * n * py).abs() < 1e-14);
    }
}
