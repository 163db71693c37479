//! The light of a source on the first screen, as it goes on to the element there.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::real::{Dual, Real};
use crate::math::vec3::Vec3;
use crate::optics::deflection::{deflected, transmitted};
use crate::optics::doe::Doe;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::aperture_scan::ApertureScan;
use crate::wave::local_bands::carrier::Carrier;

/// The field of a source on a screen above (x, y), behind the interface if the screen is one; `k` is the vacuum
/// wavenumber. Zero where the screen does not exist or reflects all.
pub(crate) fn source_field(source: &Source, screen: &Screen, at: [f64; 2], k: f64) -> Complex64 {
    let Some(height) = screen.height(at) else {
        return Complex64::ZERO;
    };
    let point = Vec3::new(at[0], at[1], height.z);
    let point = screen.frame.to_global(point);
    let field = source.field(point, k * screen.index);
    if screen.behind.is_none() {
        return field;
    }
    let direction = screen.frame.direction_to_local(source.direction(point)) * screen.index;
    let factor = transmitted(screen, &screen.shape, at, [direction.x, direction.y]);
    factor.map_or(Complex64::ZERO, |factor| field * factor)
}

/// The carrier of a source on a screen about (x, y): of the light as a function of x and y along its surface. Where the
/// screen does not exist its local plane takes its place.
pub(crate) fn source_carrier(source: &Source, screen: &Screen, at: [f64; 2]) -> Carrier {
    let still = |v: Vec3| Vec3::<Dual<2>>::constant(v);
    let frame = &screen.frame;
    let [x, y] = [0, 1].map(|a| Dual::<2>::variable(at[a], a));
    let point = still(frame.origin) + still(frame.x) * x + still(frame.y) * y;
    let height = match screen.is_plane() {
        true => None,
        false => screen.shape.height(x, y),
    };
    let point = match &height {
        Some(height) => point + still(frame.z) * height.z,
        None => point,
    };
    let direction = source.direction(point);
    let along = |axis: Vec3| still(axis).dot(direction) * screen.index;
    let (p, q) = (along(frame.x), along(frame.y));
    let (p, q) = match &height {
        Some(height) => {
            let up = along(frame.z);
            (p + up * height.slope[0], q + up * height.slope[1])
        }
        None => (p, q),
    };
    Carrier {
        at,
        p: [p.value(), q.value()],
        q: [p.tangent[0], p.tangent[1], q.tangent[1]],
    }
}

/// The light of a source over a carrier at samples of a screen, [y, x].
pub(crate) fn source_values(
    source: &Source,
    screen: &Screen,
    carrier: &Carrier,
    samples: &[Axis; 2],
    k: f64,
) -> Array2<Complex64> {
    let value = |(j, i)| {
        let at: [f64; 2] = [samples[0].node(i), samples[1].node(j)];
        source_field(source, screen, at, k) * carrier.removed(at, k)
    };
    Array2::from_shape_fn((samples[1].len(), samples[0].len()), value)
}

/// |U|² cos θ of the light at a screen, for an area over its local x and y, where an element adds `kick` to its optical
/// cosines; zero where the screen does not exist or the light does not go on.
fn power_density(
    source: &Source,
    screen: &Screen,
    at: [f64; 2],
    kick: [f64; 2],
    k: f64,
) -> Option<f64> {
    let height = screen.height(at)?;
    let point = screen.frame.to_global(Vec3::new(at[0], at[1], height.z));
    let direction = screen.frame.direction_to_local(source.direction(point));
    let [sx, sy] = height.slope;
    let mut through = direction.z - direction.x * sx - direction.y * sy;
    if kick != [0.0; 2] {
        let arriving = [direction.x, direction.y].map(|d| d * screen.index);
        let [px, py] = deflected(screen, at, arriving, kick)?;
        let along = (screen.index.powi(2) - px * px - py * py).max(0.0).sqrt();
        through = (along * screen.leaves() - px * sx - py * sy) / screen.index;
    }
    Some(source.field(point, k * screen.index).norm_sqr() * through.abs())
}

/// Cells along each side of a screen over which its light is summed: so many, or one a pixel up to the most.
const CELLS: usize = 512;
const MOST_CELLS: usize = 4096;

/// The power that leaves the first screen, in mm²: ∫|U|² cos θ over its surface, of what its element passes, in the directions
/// to which its smooth phase turns light; of the light before it where the screen is an interface or has pixels; nothing for
/// a screen without an edge.
pub(crate) fn power_behind(source: &Source, screen: &Screen, k: f64) -> Option<f64> {
    let [x0, x1, y0, y1] = screen.bounds()?;
    let (aperture, doe) = match &screen.kind {
        ScreenKind::Stop(aperture) => (aperture, None),
        ScreenKind::Doe(doe) => (&doe.aperture, Some(doe)),
        ScreenKind::Sensor(_) => return None,
    };
    let pixels = doe.and_then(Doe::pixels);
    let counts = pixels.map_or([0; 2], |pixels| {
        [pixels.values.ncols(), pixels.values.nrows()]
    });
    let [nx, ny] = counts.map(|count| count.clamp(CELLS, MOST_CELLS));
    let (dx, dy) = ((x1 - x0) / nx as f64, (y1 - y0) / ny as f64);
    let row = |j: usize| {
        let low = y0 + dy * j as f64;
        let mut scan = ApertureScan::new(aperture, [low, low + dy]);
        let cell = |i: usize| {
            let left = x0 + dx * i as f64;
            let open = scan.open([left, left + dx]);
            if open == 0.0 {
                return 0.0;
            }
            let at = [left + 0.5 * dx, low + 0.5 * dy];
            let passed = doe.map_or(1.0, |doe| doe.transmission(at[0], at[1]).norm_sqr());
            let smooth = doe.filter(|_| screen.behind.is_none() && pixels.is_none());
            let gradient = smooth.and_then(|doe| doe.ray_gradient(at[0], at[1]));
            let kick = gradient.map_or([0.0; 2], |gradient| gradient.map(|g| g / k));
            let density = power_density(source, screen, at, kick, k);
            open * passed * density.unwrap_or(0.0)
        };
        (0..nx).map(cell).sum::<f64>()
    };
    let rows: Vec<f64> = (0..ny).into_par_iter().map(row).collect();
    Some(rows.iter().sum::<f64>() * dx * dy)
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::source::source_light::{
        power_behind, source_carrier, source_field,
    };
    use crate::fixtures::parts::{conic, element, on_axis, open_screen, plane_wave, screen};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::beams::gaussian_beam::GaussianBeam;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::source::Source;

    /// A Gaussian beam of radius w has the power πw²/2, of which a disc of radius a passes 1 − exp(−2a²/w²).
    #[test]
    fn a_stop_passes_its_share_of_a_gaussian_beam() {
        let (k, w, a) = (1e4, 0.3, 0.2);
        let axis = Vec3::new(0.0, 0.0, 1.0);
        let beam = GaussianBeam::new(Vec3::new(0.0, 0.0, 0.0), axis, [w, w], 0.0, k);
        let stop = screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(a)));
        let found = power_behind(&Source::Gaussian(beam), &stop, k).unwrap();
        let exact = 0.5 * std::f64::consts::PI * w * w * (1.0 - (-2.0 * a * a / (w * w)).exp());
        assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
    }

    /// A grating that turns collimated light by 60° lets half of the power go on: ∫|U|² cos θ behind it.
    #[test]
    fn an_element_that_turns_light_narrows_it() {
        let (k, a) = (1e4, 0.2);
        let gradient = [0.75f64.sqrt() * k, 0.0];
        let grating = element(
            Layer::Phase(Profile::Linear { gradient }),
            Aperture::disc(a),
        );
        let screen = screen(on_axis(0.0), ScreenKind::Doe(grating));
        let found = power_behind(&plane_wave([0.0, 0.0]), &screen, k).unwrap();
        let exact = 0.5 * std::f64::consts::PI * a * a;
        assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
    }

    /// The carrier of a point's light on a tilted sphere is the change of its phase from place to place.
    #[test]
    fn the_carrier_on_a_curved_screen_follows_the_phase_of_the_field() {
        let screen = Screen {
            shape: conic(0.1, -0.4),
            index: 1.3,
            ..open_screen(Frame::GLOBAL.tilted([0.2, -0.1, 0.3]))
        };
        let source = Source::point([1.0, -2.0, -30.0], Vec3::new(0.0, 0.0, 0.0));
        let (at, k, h) = ([1.5, -0.7], 1.0, 1e-3);
        let carrier = source_carrier(&source, &screen, at);
        let phase = |u: f64, v: f64| {
            let there = source_field(&source, &screen, [at[0] + u, at[1] + v], k);
            let here = source_field(&source, &screen, at, k);
            (there / here).arg()
        };
        let slope = [
            phase(h, 0.0) - phase(-h, 0.0),
            phase(0.0, h) - phase(0.0, -h),
        ];
        for (a, slope) in slope.into_iter().enumerate() {
            assert!((slope / (2.0 * h) - carrier.p[a]).abs() < 1e-6);
        }
        let bends = [
            (phase(h, 0.0) + phase(-h, 0.0)) / (h * h),
            (phase(h, h) - phase(h, -h) - phase(-h, h) + phase(-h, -h)) / (4.0 * h * h),
            (phase(0.0, h) + phase(0.0, -h)) / (h * h),
        ];
        for (bend, q) in bends.into_iter().zip(carrier.q) {
            assert!((bend - q).abs() < 1e-5, "{bend} {q}");
        }
    }
}
