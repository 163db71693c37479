//! Rays of the light itself: from the source, on through every screen, as the screens turn them.
//!
//! They show where most of the energy goes before any field is known. Behind smooth elements there is one for
//! each place; behind pixels the pixels' own diffraction makes many.

use crate::engine::rims::pixel_light::{PixelLight, PixelValues};
use crate::engine::rims::source_ray::SourceRay;
use crate::math::vec3::Vec3;
use crate::optics::deflection::deflected;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};

/// Places along each axis of the first screen from which rays are sent: behind pixels, where each place sends
/// many, and behind smooth elements and stops, where each sends one.
const PLACES: [usize; 2] = [7, 41];

/// Behind pixels a place moves within its cell by these steps from cell to cell (Roberts' sequence of low
/// discrepancy). So the share of places near an edge is that of the area near it.
const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Most rays of one screen that are followed from the next.
const MOST: usize = 300;

/// The source's light on its first screen, evenly over the aperture.
pub(crate) fn source_rays(system: &System) -> Vec<SourceRay> {
    let screen = &system.screens[0];
    let Some([x0, x1, y0, y1]) = screen.bounds() else {
        return Vec::new();
    };
    let pixels = has_pixels(screen);
    let along = PLACES[usize::from(!pixels)];
    let within = |n: usize, step: f64| {
        if pixels {
            (n as f64 * step).fract()
        } else {
            0.5
        }
    };
    let place =
        |i: usize, a: f64, b: f64, share: f64| a + (b - a) * (i as f64 + share) / along as f64;
    let places = (0..along * along).map(|n| {
        let x = place(n % along, x0, x1, within(n, STEPS[0]));
        [x, place(n / along, y0, y1, within(n, STEPS[1]))]
    });
    let lit = places.filter(|at| is_open(screen, *at));
    lit.map(|at| {
        let z = screen.height(at).map_or(0.0, |here| here.z);
        let here = screen.frame.to_global(Vec3::new(at[0], at[1], z));
        let field = system
            .source
            .field(here, system.wavenumber() * screen.index);
        let d = screen
            .frame
            .direction_to_local(system.source.direction(here));
        SourceRay {
            at,
            p: [d.x * screen.index, d.y * screen.index],
            energy: field.norm_sqr(),
            spread: [0.0; 2],
        }
    })
    .collect()
}

/// Whether light passes a screen at a place.
pub(crate) fn is_open(screen: &Screen, [x, y]: [f64; 2]) -> bool {
    match &screen.kind {
        ScreenKind::Stop(aperture) => aperture.contains(x, y),
        ScreenKind::Doe(doe) => doe.aperture.contains(x, y),
        ScreenKind::Sensor(_) => true,
    }
}

/// Whether a screen has pixels that diffract.
fn has_pixels(screen: &Screen) -> bool {
    match &screen.kind {
        ScreenKind::Doe(doe) => doe.pixels().is_some(),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => false,
    }
}

/// The rays that leave a screen for those that arrive: behind pixels, where there are many for each, for a part
/// of them.
pub(crate) fn rays_behind(
    hop: &Hop,
    arriving: &[SourceRay],
    values: PixelValues,
) -> Vec<SourceRay> {
    let light = match &hop.from.kind {
        ScreenKind::Doe(doe) => PixelLight::new(doe, hop.wavelength, values),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    };
    let Some(light) = light else {
        return arriving
            .iter()
            .map(|source_ray| ray_behind(hop, source_ray))
            .collect();
    };
    let stride = arriving.len().div_ceil(MOST).max(1);
    let some = arriving.iter().step_by(stride);
    some.flat_map(|source_ray| light.rays(hop, source_ray))
        .collect()
}

/// The ray that leaves a stop or a smooth element.
pub(crate) fn ray_behind(hop: &Hop, source_ray: &SourceRay) -> SourceRay {
    let SourceRay { at, p, .. } = *source_ray;
    let gradient = match &hop.from.kind {
        ScreenKind::Doe(doe) => doe.ray_gradient(at[0], at[1]),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    };
    let [gx, gy] = gradient.unwrap_or([0.0; 2]);
    let k = hop.wavenumber();
    let kick = [gx / k, gy / k];
    let straight = [p[0] + kick[0], p[1] + kick[1]];
    let p = match hop.from.is_plane() {
        true => straight,
        false => deflected(hop.from, at, p, kick).unwrap_or(straight),
    };
    SourceRay { p, ..*source_ray }
}
