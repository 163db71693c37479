//! The error of the edge wave of a rim on a curved surface.
//!
//! A rim that is a screen cuts the field in its own plane. The surface there stands at an angle α to that plane, and
//! Kirchhoff's approximation does not say along which of both the field is cut. By the integral of Rayleigh and
//! Sommerfeld an edge sends into the angle θ off the light's own direction the amplitude (n·s)/((s − s₀)·t), with the
//! normal n of the cut, its tangent t across the edge and the directions s₀ and s of the light and of the edge wave:
//! cos(θ − α)/(sin(θ − α) − sin(θ₀ − α)). Cuts along the surface and in the plane differ by sin α/(2 cos θm cos(θm − α)), with
//! θm = (θ + θ₀)/2, wherever the edge wave goes. The energy of the edge wave
//! is λ/(4π²q²) dq for each unit of light a length of edge (`edge_diffraction`), with q = n(sin θ − sin θ₀). So the energy of the
//! difference is λα²/(16π²n² cos⁶ θ₀) dq: even over all directions q.
//!
//! Light that meets the surface aslant errs by more than this law says. What it adds is measured: it grows with the slope of
//! the surface, with the sine of the light, and with the root of the share of it that ends at the rim.

use std::f64::consts::PI;

use crate::engine::rims::onward::Onward;
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::surface_edge::{EdgeLight, SurfaceEdge};
use crate::math::erfc::erfc;
use crate::optics::system::Hop;

/// Light that grazes the plane of an edge counts as light of this cosine.
const LEAST_COSINE: f64 = 0.3;

/// Error of light of sine one that ends at the rim, divided by the slope of the surface there and by the root of its share.
/// Measured on 21 lenses of 40 λ to 220 λ behind or before random pixels, gratings and stops.
const ASLANT: f64 = 0.075;

/// Rays followed at most.
const RAYS: usize = 3000;

/// Parts of the directions that land on the target, of which each goes on to the sensor in its own share.
const PARTS: usize = 7;

/// The energy, on its way through the target to the sensor, of the difference between a cut along the surface and one in the
/// plane of its edge.
pub(crate) fn edge_difference(
    open: &Hop,
    onward: &Onward,
    rim: &SurfaceEdge,
    leaving: &[SourceRay],
) -> EdgeLight {
    let stride = leaving.len().div_ceil(RAYS).max(1);
    let index = rim.surface.index[1];
    let law = open.wavelength / (4.0 * PI * index).powi(2);
    let one = |source_ray: &SourceRay| {
        let depth = rim.depth_near(open, source_ray)?;
        let fan = Fan::at(open, rim, source_ray)?;
        let width = fan.width_towards(open, onward)?;
        let light = rim.per_depth(open, source_ray) * stride as f64;
        let share = law * fan.slope.powi(2) / fan.cosine(index).powi(6);
        Some((depth, light * share * width))
    };
    let some = leaving.iter().step_by(stride).filter_map(one);
    EdgeLight::of(some, rim.blur(open))
}

/// The relative error that light aslant adds, of light that passes the edges `before`.
pub(crate) fn aslant_error<'a>(
    open: &Hop,
    before: impl Iterator<Item = &'a SurfaceEdge<'a>> + Clone,
    rim: &SurfaceEdge,
    leaving: &[SourceRay],
) -> f64 {
    let heights = rim.surface.aperture.rim().into_iter();
    let slopes = heights.filter_map(|[x, y]| {
        let [sx, sy] = rim.surface.shape.height(x, y)?.slope;
        Some(sx.hypot(sy))
    });
    let slope = slopes.fold(0.0, f64::max);
    if slope == 0.0 {
        return 0.0;
    }
    let blur = rim.blur(open);
    let stride = leaving.len().div_ceil(RAYS).max(1);
    let (mut all, mut aslant) = (0.0, 0.0);
    for ray in leaving.iter().step_by(stride) {
        let passes = |edge: &SurfaceEdge| edge.depth_of(open, ray).is_some_and(|depth| depth > 0.0);
        let Some(met) = rim.meet(open, |hop| hop.trace(ray.at, ray.p, &mut ()).ok()) else {
            continue;
        };
        let [x, y] = met.at;
        if x.abs().max(y.abs()) <= rim.radius && before.clone().all(passes) {
            let ended = 0.5 * erfc(rim.surface.aperture.depth(x, y) / blur);
            let [px, py] = met.cosines;
            all += ray.energy;
            aslant += ray.energy * ended * (px * px + py * py);
        }
    }
    let share = if all > 0.0 { aslant / all } else { 0.0 };
    ASLANT * slope * share.sqrt() / rim.surface.index[0]
}

/// The edge wave that starts where a ray meets a rim: directions across the edge, q off the ray's own.
struct Fan {
    /// The angle between the surface and the plane of its edge, across the edge.
    slope: f64,
    /// The optical cosines there that the ray has across the edge, and along it.
    start: f64,
    along: f64,
    /// Where the ray lands on the target, and how much farther the edge wave does for each unit of q.
    at: [f64; 2],
    place_rate: [f64; 2],
    /// The optical cosines with which it lands, likewise.
    p: [f64; 2],
    cosine_rate: [f64; 2],
}

impl Fan {
    fn at(open: &Hop, rim: &SurfaceEdge, source_ray: &SourceRay) -> Option<Self> {
        let SourceRay { at, p, .. } = *source_ray;
        let (met, before) = rim.meet(open, |hop| hop.jacobian(at, p).ok())?;
        let (landing, whole) = open.jacobian(at, p).ok()?;
        let across = across(rim, met.at)?;
        let height = rim.surface.shape.height(met.at[0], met.at[1])?;
        let dot = |a: [f64; 2]| a[0] * across[0] + a[1] * across[1];

        // From directions at the rim to the target: the whole way times the inverse of its first part, which is symplectic.
        let rate = |row: usize| {
            let term = |b: usize| -> f64 {
                let at_rim =
                    |c: usize| whole[row][2 + c] * before[b][c] - whole[row][c] * before[b][2 + c];
                across[b] * (at_rim(0) + at_rim(1))
            };
            term(0) + term(1)
        };
        Some(Self {
            slope: dot(height.slope),
            start: dot(met.cosines),
            along: met.cosines[0] * across[1] - met.cosines[1] * across[0],
            at: landing.at,
            place_rate: [rate(0), rate(1)],
            p: landing.cosines,
            cosine_rate: [rate(2), rate(3)],
        })
    }

    /// The cosine of the light behind the edge to the normal of its plane, across the edge.
    fn cosine(&self, index: f64) -> f64 {
        let radius = (index * index - self.along.powi(2)).max(0.0);
        let square = 1.0 - self.start.powi(2) / radius;
        square.max(LEAST_COSINE * LEAST_COSINE).sqrt()
    }

    /// The width in q of the directions that land on the target, each counted by the share of its light that goes on to the
    /// sensor.
    fn width_towards(&self, open: &Hop, onward: &Onward) -> Option<f64> {
        let to = open.to.bounds()?;
        let index = open.to.index;
        let (mut low, mut high) = (-index - self.start, index - self.start);
        for a in 0..2 {
            let ends =
                [to[2 * a], to[2 * a + 1]].map(|end| (end - self.at[a]) / self.place_rate[a]);
            if ends.iter().any(|end| end.is_nan()) {
                continue;
            }
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        let width = (high - low).max(0.0);
        let share = |part: usize| {
            let q = low + width * (part as f64 + 0.5) / PARTS as f64;
            let ray = SourceRay {
                at: [0, 1].map(|a| self.at[a] + q * self.place_rate[a]),
                p: [0, 1].map(|a| self.p[a] + q * self.cosine_rate[a]),
                energy: 1.0,
                spread: [0.0; 2],
            };
            onward.reach(ray).share
        };
        let on: f64 = (0..PARTS).map(share).sum();
        Some(width * on / PARTS as f64)
    }
}

/// The direction across an edge, inward, nearest to a place of its plane.
fn across(rim: &SurfaceEdge, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let step = 1e-4 * rim.radius;
    let depth = |x: f64, y: f64| rim.surface.aperture.depth(x, y);
    let toward = [
        depth(x + step, y) - depth(x - step, y),
        depth(x, y + step) - depth(x, y - step),
    ];
    let length = toward[0].hypot(toward[1]);
    (length > 0.0).then(|| toward.map(|part| part / length))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::engine::rims::curved_edge::{Fan, edge_difference};
    use crate::engine::rims::onward::Onward;
    use crate::engine::rims::source_rays::source_rays;
    use crate::engine::rims::surface_edge::SurfaceEdge;
    use crate::fixtures::parts::{conic, face, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;
    use crate::optics::surface::without_edges;
    use crate::optics::system::Hop;

    /// In n = 1.5, light at 30° across the edge has the cosine √0.75, and light of 0.9 along the edge the same if it is at 30° in
    /// the plane across it.
    #[test]
    fn the_cosine_across_an_edge_leaves_out_what_goes_along_it() {
        for along in [0.0f64, 0.9] {
            let fan = Fan {
                slope: 0.1,
                start: 0.5 * (1.5f64 * 1.5 - along * along).sqrt(),
                along,
                at: [0.0; 2],
                place_rate: [0.0; 2],
                p: [0.0; 2],
                cosine_rate: [0.0; 2],
            };
            assert!((fan.cosine(1.5) - 0.75f64.sqrt()).abs() < 1e-12);
        }
    }

    /// Even light of density e on a disc of radius R whose edge slants by α has 2πR e of light a length of depth. Of it
    /// λα²/(16π²) lands for each unit of the directions that a square far behind it spans. A plane differs by nothing.
    #[test]
    fn the_difference_of_a_disc_is_that_of_its_edge() {
        let (radius, far, side) = (50.0, 4000.0, 200.0);
        let found = |curvature: f64| {
            let mut surface = face(on_axis(10.0), conic(curvature, 0.0), [1.0, 1.0]);
            surface.aperture = Aperture::disc(radius);
            let stop = ScreenKind::Stop(Aperture::disc(80.0));
            let last = screen(on_axis(far), sensor(200, side / 200.0));
            let first = screen(Frame::GLOBAL, stop);
            let mut system = lit(vec![first, last], vec![vec![surface]]);
            system.wavelength = 0.1;
            let light = source_rays(&system);
            let hop = system.hops().next().unwrap();
            let train = without_edges(hop.train);
            let open = Hop {
                train: &train,
                ..hop
            };
            let rim = SurfaceEdge::of(0, &hop.train[0]).unwrap();
            let all: f64 = light.iter().map(|ray| ray.energy).sum();
            let density = all / (PI * 80.0 * 80.0);
            edge_difference(&open, &Onward::nowhere(), &rim, &light).fainter() / density
        };
        let curvature = 1.0 / 400.0;
        let slope: f64 = curvature * radius / (1.0 - (curvature * radius).powi(2)).sqrt();

        // A chord through the middle of a square, averaged over its angle, is (4/π) ln(1 + √2) of its side.
        let chord = side / far * 4.0 / PI * (1.0 + 2f64.sqrt()).ln();
        let law = 0.1 * (slope / (4.0 * PI)).powi(2);
        let expected = 2.0 * PI * radius * law * chord;
        let ratio = found(curvature) / expected;
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
        assert!(found(0.0) < 1e-9 * expected);
    }
}
