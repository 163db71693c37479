//! Rays that other programs print.

use raylet::optics::system::System;
use raylet_testkit::scenes::scene_system;

/// Where a ray from (x, y) on the first screen lands on the plane of the sensor, from the axis.
fn landing(system: &System, at: [f64; 2], p: [f64; 2]) -> [f64; 2] {
    let hop = system.hops().next().unwrap();
    let landing = hop.trace(at, p, &mut ()).unwrap();
    let centre = hop.to.frame.origin;
    [landing.at[0] + centre.x, landing.at[1] + centre.y]
}

/// The lens of US patent 7,535,658 has odd and even powers of the radius in eight surfaces. The documentation of ray-optics
/// (docs/source/examples/Cell_Phone_lens) prints where an axial and a skew ray land.
#[test]
fn rays_through_a_lens_with_odd_powers_land_where_ray_optics_prints() {
    let (system, _) = scene_system("real_size/phone_patent").unwrap();
    let skew = [0.086_013_51, 0.173_027_17];
    let rays = [
        ([0.0, 1.0], [0.0; 2], [0.0, -0.02573]),
        (skew.map(|p| -p), skew, [0.49241, 0.99054]),
    ];
    for (at, p, printed) in rays {
        let found = landing(&system, at, p);
        for (found, printed) in found.into_iter().zip(printed) {
            assert!((found - printed).abs() < 1e-5, "{found} {printed}");
        }
    }
}
