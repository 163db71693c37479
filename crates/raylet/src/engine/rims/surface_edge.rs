//! The edge of a surface of a train, and where rays meet the plane in which it lies.

use crate::engine::rims::source_ray::SourceRay;
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::Hop;

/// How near an edge light is to meet the surface to count as light at the edge, in radii.
pub(crate) const NEAR_RIM: f64 = 0.15;

/// Step of the difference that gives the normal of an edge, in radii.
const OF_RADIUS: f64 = 1e-4;

/// The edge of a surface of a train.
pub(crate) struct SurfaceEdge<'a> {
    pub(crate) number: usize,
    pub(crate) surface: &'a Surface,
    /// The height of the surface at its edge, in mm.
    depth: f64,
    /// How far the edge reaches from the vertex, in mm.
    pub(crate) radius: f64,
}

impl<'a> SurfaceEdge<'a> {
    /// Of surface `number` of a train; nothing where it has none.
    pub(crate) fn of(number: usize, surface: &'a Surface) -> Option<Self> {
        if surface.aperture.outline == Outline::Open {
            return None;
        }
        let sag = |[x, y]: [f64; 2]| surface.shape.height(x, y).map(|here| here.z);
        let edge = surface.aperture.rim();
        Some(Self {
            number,
            surface,
            depth: edge.first().copied().and_then(sag).unwrap_or(0.0),
            radius: edge.iter().map(|[x, y]| x.hypot(*y)).reduce(f64::max)?,
        })
    }

    /// The width over which diffraction on the way there blurs light at the edge.
    pub(crate) fn blur(&self, open: &Hop) -> f64 {
        let travelled = (self.surface.frame.origin - open.from.frame.origin).norm();
        (open.wavelength * travelled)
            .sqrt()
            .min(NEAR_RIM * self.radius)
    }

    /// The energy of a ray near the edge for each mm of depth about it.
    pub(crate) fn per_depth(&self, open: &Hop, source_ray: &SourceRay) -> f64 {
        source_ray.energy / (NEAR_RIM * self.radius + self.blur(open))
    }

    /// How far inside the edge a ray meets it.
    pub(crate) fn depth_of(&self, open: &Hop, source_ray: &SourceRay) -> Option<f64> {
        let [x, y] = self.met_by(open, source_ray)?;
        Some(self.surface.aperture.depth(x, y))
    }

    /// The same; nothing where it does not come near.
    pub(crate) fn depth_near(&self, open: &Hop, source_ray: &SourceRay) -> Option<f64> {
        let depth = self.depth_of(open, source_ray)?;
        (depth.abs() <= NEAR_RIM * self.radius).then_some(depth)
    }

    /// The normal of the edge next to where a ray meets its plane, along the local x and y, of any length.
    pub(crate) fn normal_by(&self, open: &Hop, source_ray: &SourceRay) -> Option<[f64; 2]> {
        let [x, y] = self.met_by(open, source_ray)?;
        let depth = |x: f64, y: f64| self.surface.aperture.depth(x, y);
        let h = OF_RADIUS * self.radius;
        Some([
            depth(x + h, y) - depth(x - h, y),
            depth(x, y + h) - depth(x, y - h),
        ])
    }

    /// Where a ray meets the plane of the edge.
    fn met_by(&self, open: &Hop, source_ray: &SourceRay) -> Option<[f64; 2]> {
        let landing = self.meet(open, |hop| {
            hop.trace(source_ray.at, source_ray.p, &mut ()).ok()
        })?;
        Some(landing.at)
    }

    /// What `follow` finds on the way to the plane of the edge, before the surface.
    pub(crate) fn meet<T>(&self, open: &Hop, follow: impl Fn(&Hop) -> Option<T>) -> Option<T> {
        let cross = |arrives: f64| {
            let plane = Screen {
                name: String::new(),
                frame: self.surface.frame.moved(Vec3::new(0.0, 0.0, self.depth)),
                kind: ScreenKind::Stop(Aperture::OPEN),
                index: self.surface.index[0],
                behind: None,
                shape: Shape::Plane,
                arrives,
            };
            follow(&Hop {
                train: &open.train[..self.number],
                to: &plane,
                ..*open
            })
        };
        // Behind mirrors light may come from either side.
        cross(1.0).or_else(|| cross(-1.0))
    }
}

/// Energy on both sides of an edge. What is nearer to the edge than light is blurred by diffraction counts on both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EdgeLight {
    inside: f64,
    outside: f64,
}

impl EdgeLight {
    /// Of light that meets the edge at these depths inside it.
    pub(crate) fn of(light: impl Iterator<Item = (f64, f64)>, blur: f64) -> Self {
        let mut sides = Self::default();
        for (depth, energy) in light {
            sides.inside += if depth > -blur { energy } else { 0.0 };
            sides.outside += if depth < blur { energy } else { 0.0 };
        }
        sides
    }

    /// The energy that an edge diffracts: light that ends before the edge does not reach it.
    pub(crate) fn fainter(self) -> f64 {
        self.inside.min(self.outside)
    }

    /// The energy that the edge of an entrance diffracts: its light ends at the edge.
    pub(crate) fn inside(self) -> f64 {
        self.inside
    }

    /// Both as shares of a whole.
    pub(crate) fn over(self, whole: f64) -> Self {
        Self {
            inside: self.inside / whole,
            outside: self.outside / whole,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::rims::surface_edge::EdgeLight;

    /// Even light of density 1 that reaches from the depth 1 inside an edge to this one.
    fn even_light(end: f64) -> impl Iterator<Item = (f64, f64)> {
        let depths = (0..1000).map(|n| 1.0 - 0.002 * (f64::from(n) + 0.5));
        depths
            .filter(move |depth| *depth > end)
            .map(|depth| (depth, 0.002))
    }

    /// Light across an edge counts by its density. Light that ends before the edge does not count, unless diffraction blurs
    /// it that far.
    #[test]
    fn light_that_ends_inside_an_edge_does_not_reach_it() {
        let fainter = |end: f64, blur: f64| EdgeLight::of(even_light(end), blur).fainter();
        assert!((fainter(-1.0, 0.0) - 1.0).abs() < 1e-9);
        assert_eq!(fainter(0.1, 0.0), 0.0);
        assert!((fainter(0.1, 0.2) - 0.1).abs() < 3e-3);
    }
}
