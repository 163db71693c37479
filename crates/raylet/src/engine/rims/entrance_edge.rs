//! The rim of a first surface whose edge the entrance before it has already: the light is cut there once, with diffraction.
//!
//! The field has to live on some screen, so an entrance with the aperture of the surface stands in the plane of its vertex.
//! Light that runs along the axis to the surface meets the same edge twice. What the entrance diffracts would be cut once
//! more by rays: a mirror of f/5 and 6 mm was 11 % wrong. Light at an angle meets the rim of a curved surface in another place
//! than that entrance, so the entrance moves to the plane of the rim: light that crosses the disc there, straight on, is the
//! light that meets the surface within its rim.

use crate::math::vec3::Vec3;
use crate::optics::aperture::Outline;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::optics::surface::Surface;
use crate::optics::system::Hop;

/// Whether the rim of the first surface of a hop is the edge of its first screen. Light that runs aside between the two is cut
/// in another place: the share of it may cost the field at most `limit`.
pub(crate) fn is_entrance_edge(hop: &Hop, source: &Source, limit: f64) -> bool {
    let Some(surface) = hop.train.first() else {
        return false;
    };
    let Some([x0, x1, y0, y1]) = hop
        .from
        .bounds()
        .filter(|_| is_same_edge(hop.from, surface))
    else {
        return false;
    };
    // Along the edge: how far light gets aside on its way from the plane of the vertex to the surface.
    let aside = |[x, y]: &[f64; 2]| {
        let sag = surface.shape.height(*x, *y)?.z;
        let point = hop.from.frame.to_global(Vec3::new(*x, *y, 0.0));
        let direction = hop.from.frame.direction_to_local(source.direction(point));
        Some(sag.abs() * direction.x.hypot(direction.y) / direction.z.abs())
    };
    let farthest = (surface.aperture.rim().iter().map(aside))
        .try_fold(0.0f64, |most, found| found.map(|found| most.max(found)));
    // A disc of radius R that moves by δ leaves 2δ/πR of itself.
    let radius = 0.5 * (x1 - x0).min(y1 - y0);
    farthest.is_some_and(|aside| {
        let share = 2.0 * aside / (std::f64::consts::PI * radius);
        share.sqrt() <= limit
    })
}

/// The first screen of a hop in the plane of the rim of the first surface, where it is the edge of that surface; nothing where the
/// rim lies in no plane, or light meets the back of the surface there.
pub(crate) fn entrance_at_rim(hop: &Hop, source: &Source) -> Option<Screen> {
    let surface = (hop.train.first()).filter(|surface| is_same_edge(hop.from, surface))?;
    let Outline::Disc { radius } = surface.aperture.outline else {
        return None;
    };
    if surface.aperture.centre != [0.0; 2] || !surface.shape.is_round() {
        return None;
    }
    let sag = surface.shape.height(radius, 0.0)?.z;
    let meets_front = |[x, y]: &[f64; 2]| {
        let height = surface.shape.height(*x, *y)?;
        let point = surface.frame.to_global(Vec3::new(*x, *y, height.z));
        let direction = surface.frame.direction_to_local(source.direction(point));
        let [sx, sy] = height.slope;
        let through = direction.z - direction.x * sx - direction.y * sy;
        Some(through * direction.z > 0.0)
    };
    let rim = surface.aperture.rim();
    let all = rim.iter().all(|at| meets_front(at).unwrap_or(false));
    all.then(|| Screen {
        frame: surface.frame.moved(Vec3::new(0.0, 0.0, sag)),
        ..hop.from.clone()
    })
}

/// Whether a screen is a stop with the aperture of a surface, in the plane of its vertex.
pub(crate) fn is_same_edge(screen: &Screen, surface: &Surface) -> bool {
    let stop = matches!(&screen.kind, ScreenKind::Stop(aperture) if *aperture == surface.aperture);
    stop && screen.is_plane() && screen.frame == surface.frame
}

#[cfg(test)]
mod tests {
    use crate::engine::rims::entrance_edge::is_entrance_edge;
    use crate::fixtures::parts::{conic, face, on_axis, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;
    use crate::optics::source::Source;
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;

    /// A disc of 1 mm before a surface of this curvature and aperture, in light at this angle.
    fn merged(curvature: f64, radius: f64, angle: f64) -> bool {
        let surface = Surface {
            aperture: Aperture::disc(radius),
            ..face(Frame::GLOBAL, conic(curvature, 0.0), [1.0, 1.5])
        };
        let from = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.0)));
        let to = screen(on_axis(9.0), sensor(8, 0.01));
        let hop = Hop {
            wavelength: 0.5e-3,
            from: &from,
            train: &[surface],
            to: &to,
        };
        let source = Source::Plane {
            direction: Vec3::new(angle.sin(), 0.0, angle.cos()),
            origin: Vec3::new(0.0, 0.0, 0.0),
        };
        is_entrance_edge(&hop, &source, 5e-4)
    }

    #[test]
    fn one_edge_is_met_twice_by_light_along_the_axis() {
        assert!(merged(0.1, 1.0, 0.0));
        // Beside a flat face, light in any direction.
        assert!(merged(0.0, 1.0, 0.3));
        assert!(!merged(0.1, 1.0, 0.3));
        assert!(!merged(0.1, 1.5, 0.0));
    }
}
