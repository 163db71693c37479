//! The field that a reflecting element on a curved surface sends to a few points, by the first Rayleigh–Sommerfeld integral
//! over the true surface.
//!
//! U(P) = (1/2π) ∫ U (N·(P−X)/r) (1/r − ik) e^{ikr}/r dx dy, N = ±(−∇s, 1) on the side of the points, X the points of the
//! surface, r = |P−X|. On the surface U is the light of the source times the element's transmission. No rays are traced.

use num_complex::Complex64;
use rayon::prelude::*;

use raylet::math::vec3::Vec3;
use raylet::optics::doe::Doe;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::system::System;

use crate::numerics::phase::cis_turns;
use crate::numerics::quadrature::gauss_legendre;

/// Fewest nodes around a ring.
const AROUND: f64 = 64.0;

/// A point of the surface, with the light there behind the element times the area below it in mm².
struct Node {
    at: Vec3,
    /// The normal (−∇s, 1) on the side of the points, global.
    normal: Vec3,
    light: Complex64,
}

/// The field at global points, from the first screen of a system, which is an element with a disc as its aperture.
///
/// The nodes stand on so many rings, by Gauss' rule along the radius, and so many around the outermost one; fewer around
/// the others, in proportion. Nothing where the first screen is another one.
pub fn field_at(
    system: &System,
    points: &[Vec3],
    [rings, spokes]: [usize; 2],
) -> Option<Vec<Complex64>> {
    let screen = system.screens.first()?;
    let ScreenKind::Doe(doe) = &screen.kind else {
        return None;
    };
    let [_, radius, _, _] = doe.aperture.bounds()?;
    let dark = || vec![Complex64::ZERO; points.len()];
    let add = |mut sum: Vec<Complex64>, part: Vec<Complex64>| {
        sum.iter_mut()
            .zip(part)
            .for_each(|(sum, part)| *sum += part);
        sum
    };
    let parts: Option<Vec<Vec<Complex64>>> = gauss_legendre(rings)
        .into_par_iter()
        .map(|(t, w)| {
            let (r, width) = (0.5 * radius * (t + 1.0), 0.5 * radius * w);
            let around = (AROUND + spokes as f64 * r / radius).ceil();
            let step = std::f64::consts::TAU / around;
            let mut sums = dark();
            for n in 0..around as usize {
                let (s, c) = (step * (n as f64 + 0.5)).sin_cos();
                let node = node(system, screen, doe, [r * c, r * s], width * r * step)?;
                for (sum, point) in sums.iter_mut().zip(points) {
                    *sum += radiated(&node, *point, system.wavenumber());
                }
            }
            Some(sums)
        })
        .collect();
    Some(parts?.into_iter().fold(dark(), add))
}

/// The node above (x, y) that represents this area.
fn node(system: &System, screen: &Screen, doe: &Doe, [x, y]: [f64; 2], area: f64) -> Option<Node> {
    let height = screen.height([x, y])?;
    let [sx, sy] = height.slope;
    let at = screen.frame.to_global(Vec3::new(x, y, height.z));
    // Light goes back to the side from which it came.
    let normal = Vec3::new(-sx, -sy, 1.0) * -screen.arrives;
    let light = system.source.field(at, system.wavenumber()) * doe.transmission(x, y) * area;
    let normal = screen.frame.direction_to_global(normal);
    Some(Node { at, normal, light })
}

/// What a node sends to a point.
fn radiated(node: &Node, point: Vec3, k: f64) -> Complex64 {
    let turn = std::f64::consts::TAU;
    let way = point - node.at;
    let r = way.norm();
    let (c, s) = cis_turns(k * r / turn);
    let size = node.normal.dot(way) / (r * r * turn);
    node.light * Complex64::new(c, s) * Complex64::new(1.0 / r, -k) * size
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;
    use raylet::math::vec3::Vec3;
    use raylet::optics::aperture::Aperture;
    use raylet::optics::doe::Doe;
    use raylet::optics::screen::{Screen, ScreenKind};
    use raylet::optics::source::Source;
    use raylet::optics::system::System;
    use raylet_testkit::parts::{conic, on_axis, screen, sensor};

    use crate::objective::surface_integral::field_at;

    /// Light from the centre of a spherical mirror comes back there. All distances are R, and the obliquity makes the integral
    /// over the plane one over the cap of height h, 2πRh: U = (1/R − ik) e^{ikR} h.
    #[test]
    fn light_from_the_centre_of_a_sphere_comes_back() {
        let (radius, semi): (f64, f64) = (60.0, 10.0);
        let mirror = Doe {
            layers: Vec::new(),
            aperture: Aperture::disc(semi),
            reflect: true,
        };
        let mirror = Screen {
            shape: conic(-1.0 / radius, 0.0),
            ..screen(on_axis(0.0), ScreenKind::Doe(mirror))
        };
        let centre = Vec3::new(0.0, 0.0, -radius);
        let system = System {
            wavelength: 0.532e-3,
            source: Source::point([0.0, 0.0, -radius], Vec3::new(0.0, 0.0, 0.0)),
            screens: vec![mirror, screen(on_axis(-radius), sensor(1, 1e-3))],
            trains: vec![Vec::new()],
        };
        let found = field_at(&system, &[centre], [12, 16]).unwrap()[0];
        let k = system.wavenumber();
        let height = radius - (radius * radius - semi * semi).sqrt();
        let exact = Complex64::new(1.0 / radius, -k) * Complex64::cis(k * radius) * height;
        assert!(
            (found - exact).norm() < 1e-8 * exact.norm(),
            "{found} {exact}"
        );
    }
}
