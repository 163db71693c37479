//! Light that misses an opening: of a beam the first one of a system, of rays that of the next element.

use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};

/// Less than this share of the light that misses an opening is no news, in per cent.
const MISSED: f64 = 50.0;

/// Fewer rays than this tell no share.
const FEW: usize = 10;

/// A beam ends where its intensity is this much lower than in its middle.
const DIM: f64 = 1e-4;

/// Places along each axis, about a circle, and times the radius of the beam is doubled at most.
const FINE: usize = 151;
const ROUND: usize = 16;
const DOUBLINGS: usize = 60;

/// That most of a beam of finite width misses the opening of the first screen.
pub(crate) fn missed_light(system: &System) -> Option<String> {
    let screen = system.screens.first()?;
    let open = match &screen.kind {
        ScreenKind::Stop(aperture) => aperture,
        ScreenKind::Doe(doe) => &doe.aperture,
        ScreenKind::Sensor(_) => return None,
    };
    let (own, beam) = (screen.bounds()?, beam_box(system, screen)?);
    let through = power(system, screen, own, open);
    let all = power(system, screen, beam, &Aperture::OPEN);
    let share = 100.0 * (1.0 - through / all);
    (share > MISSED).then(|| {
        format!(
            "{} % of the source's light misses the opening of '{}'",
            digits(share),
            screen.name
        )
    })
}

/// That most of the rays that leave the first screen of a hop miss the opening of the element to which it leads, from their places
/// and directions.
pub(crate) fn beside_opening(hop: &Hop, rays: &[([f64; 2], [f64; 2])]) -> Option<String> {
    let ScreenKind::Doe(doe) = &hop.to.kind else {
        return None;
    };
    let [x0, x1, y0, y1] = doe.bounds()?;
    let landings = rays.iter().map(|(at, p)| hop.trace(*at, *p, &mut ()));
    let landings: Vec<[f64; 2]> = landings.flatten().map(|landing| landing.at).collect();
    let inside = |[x, y]: &&[f64; 2]| {
        (x0..=x1).contains(x) && (y0..=y1).contains(y) && doe.aperture.contains(*x, *y)
    };
    let (met, all) = (landings.iter().filter(inside).count(), landings.len());
    let share = 100.0 * (1.0 - met as f64 / all.max(1) as f64);
    (all >= FEW && share > MISSED).then(|| {
        format!(
            "about {share:.0} % of the light behind '{}' misses the opening of '{}'",
            hop.from.name, hop.to.name
        )
    })
}

/// A share near 100 % with the digits that tell it from 100 %, four at most.
fn digits(share: f64) -> String {
    match share > 99.5 {
        true => format!("{:.2}", share.min(99.99)),
        false => format!("{share:.0}"),
    }
}

/// The box of a beam on the plane of a screen, `[x_min, x_max, y_min, y_max]` in mm; nothing for light of even amplitude, and where
/// its middle does not meet the plane or is dark.
fn beam_box(system: &System, screen: &Screen) -> Option<[f64; 4]> {
    let (point, direction) = system.source.middle()?;
    let (from, way) = (
        screen.frame.to_local(point),
        screen.frame.direction_to_local(direction),
    );
    let centre = from + way * (-from.z / way.z);
    let brightness = |x: f64, y: f64| intensity(system, screen, [x, y]);
    let peak = brightness(centre.x, centre.y);
    if !(peak > 0.0 && peak.is_finite()) {
        return None;
    }
    let ends = |radius: &f64| {
        (0..ROUND).all(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / ROUND as f64).sin_cos();
            brightness(centre.x + radius * cos, centre.y + radius * sin) < DIM * peak
        })
    };
    let radii = (0..DOUBLINGS).map(|i| system.wavelength * 2f64.powi(i as i32));
    let radius = radii.into_iter().find(ends)?;
    Some([
        centre.x - radius,
        centre.x + radius,
        centre.y - radius,
        centre.y + radius,
    ])
}

/// The light of the source through an aperture within a box on the plane of a screen.
fn power(system: &System, screen: &Screen, [x0, x1, y0, y1]: [f64; 4], open: &Aperture) -> f64 {
    let place = |i: usize, low: f64, high: f64| low + (high - low) * (i as f64 + 0.5) / FINE as f64;
    let lattice = (0..FINE * FINE).map(|n| [place(n % FINE, x0, x1), place(n / FINE, y0, y1)]);
    let lit = lattice.filter(|[x, y]| open.contains(*x, *y));
    let sum: f64 = lit.map(|at| intensity(system, screen, at)).sum();
    sum * (x1 - x0) * (y1 - y0) / (FINE * FINE) as f64
}

/// |U|² of the source above a place of a screen.
fn intensity(system: &System, screen: &Screen, [x, y]: [f64; 2]) -> f64 {
    let k = system.wavenumber() * screen.index;
    let point = screen.frame.to_global(Vec3::new(x, y, 0.0));
    system.source.field(point, k).norm_sqr()
}

#[cfg(test)]
mod tests {
    use crate::engine::error::missed_light::{beside_opening, missed_light};
    use crate::fixtures::parts::{element, lit, on_axis, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::beams::gaussian_beam::GaussianBeam;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::optics::source::Source;
    use crate::optics::system::{Hop, System};

    /// A Gaussian beam of 100 wavelengths radius: exp(−2(a/w)²) of it misses a disc of radius a.
    #[test]
    fn a_beam_wider_than_the_opening_is_told_with_the_share_that_misses() {
        let beam = GaussianBeam::new(
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(0.0, 0.0, 1.0),
            [100.0; 2],
            0.0,
            std::f64::consts::TAU,
        );
        let system = |source: Option<Source>, radius: f64| {
            let first = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(radius)));
            let plain = lit(
                vec![first, screen(on_axis(900.0), sensor(8, 1.0))],
                vec![vec![]],
            );
            missed_light(&match source {
                Some(source) => System { source, ..plain },
                None => plain,
            })
        };
        let narrow = system(Some(Source::Gaussian(beam)), 30.0).unwrap();
        assert!(
            narrow.starts_with("84 % of the source's light misses the opening of 'stop'"),
            "{narrow}"
        );
        assert_eq!(system(Some(Source::Gaussian(beam)), 70.0), None);
        assert_eq!(system(None, 30.0), None);
    }

    /// Rays on a lattice of 11 by 11: a square of half its side has 5 by 5 of them.
    #[test]
    fn rays_beside_the_next_element_are_told() {
        let lattice = (0..121).map(|n| [n % 11, n / 11].map(|i| f64::from(i) * 0.2 - 1.0));
        let rays: Vec<_> = lattice.map(|at| (at, [0.0; 2])).collect();
        let from = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(2.0)));
        let said = |half: f64| {
            let open = Aperture::turned_rectangle(half, half, 0.0, [0.0; 2]);
            let flat = Layer::Phase(Profile::Axicon { slope: 0.0 });
            let to = screen(on_axis(9.0), ScreenKind::Doe(element(flat, open)));
            let hop = Hop {
                wavelength: 0.5e-3,
                from: &from,
                train: &[],
                to: &to,
            };
            beside_opening(&hop, &rays)
        };
        let text = said(0.5).unwrap();
        assert!(
            text.starts_with(
                "about 79 % of the light behind 'stop' misses the opening of 'element'"
            ),
            "{text}"
        );
        assert_eq!(said(0.9), None);
    }
}
