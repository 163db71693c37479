//! Rays in SIMD packets, eight at a time.
//!
//! Eight are traced together where no surface is a freeform. Where one of eight is lost, or has to search for a surface,
//! each goes alone; every ray has the bits that it has alone.

use fearless_simd::{Level, Simd, dispatch};

use crate::engine::trace::ray_trace::Landing;
use crate::math::simd_packet::{PACKET, SimdPacket};
use crate::optics::ray::Loss;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;

/// Where a ray starts: (x, y) in mm on the first screen, and its optical direction cosines there.
pub(crate) type RayStart = [f64; 4];

/// Where a ray lands, or how it is lost.
pub(crate) type Traced = Result<Landing, Loss>;

/// A hop through which rays go in packets.
pub(crate) struct PacketTracer<'a> {
    hop: &'a Hop<'a>,
    level: Level,
    /// Whether eight rays may go together.
    together: bool,
}

impl<'a> PacketTracer<'a> {
    /// Through this hop.
    pub(crate) fn new(hop: &'a Hop<'a>) -> Self {
        let regular = |shape: &Shape| !matches!(shape, Shape::Freeform { .. });
        let train = hop.train.iter().all(|s| regular(&s.shape));
        Self {
            hop,
            level: Level::new(),
            together: hop.from.is_plane() && regular(&hop.to.shape) && train,
        }
    }

    /// Eight rays.
    pub(crate) fn trace_eight(&self, starts: &[RayStart; PACKET]) -> [Traced; PACKET] {
        let packed = match self.together {
            true => dispatch!(self.level, simd => eight(simd, self.hop, starts)),
            false => None,
        };
        match packed {
            Some(eight) => std::array::from_fn(|i| Ok(alone(&eight, i))),
            None => starts.map(|start| self.trace(start)),
        }
    }

    /// Any number of rays from (x, y), along each of these optical direction cosines.
    pub(crate) fn trace_from(&self, [x, y]: [f64; 2], directions: &[[f64; 2]]) -> Vec<Traced> {
        let start = |[p, q]: [f64; 2]| [x, y, p, q];
        let mut landings = Vec::with_capacity(directions.len());
        for group in directions.chunks(PACKET) {
            match <[[f64; 2]; PACKET]>::try_from(group) {
                Ok(group) => landings.extend(self.trace_eight(&group.map(start))),
                Err(_) => landings.extend(group.iter().map(|p| self.trace(start(*p)))),
            }
        }
        landings
    }

    fn trace(&self, [x, y, p, q]: RayStart) -> Traced {
        self.hop.trace([x, y], [p, q], &mut ())
    }
}

/// Eight rays together; nothing when one of them is lost.
#[inline(always)]
fn eight<S: Simd>(_: S, hop: &Hop, starts: &[RayStart; PACKET]) -> Option<Landing<SimdPacket>> {
    let packet = |a: usize| SimdPacket(std::array::from_fn(|i| starts[i][a]));
    let (at, p) = ([packet(0), packet(1)], [packet(2), packet(3)]);
    hop.trace(at, p, &mut ()).ok()
}

/// One of eight.
#[inline(always)]
fn alone(eight: &Landing<SimdPacket>, i: usize) -> Landing {
    Landing {
        at: eight.at.map(|v| v.0[i]),
        cosines: eight.cosines.map(|v| v.0[i]),
        path: eight.path.0[i],
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use ndarray::Array2;

    use crate::engine::trace::ray_packet::{PacketTracer, eight};
    use crate::fixtures::paper_systems::lens_hologram;
    use crate::fixtures::parts::{on_axis, open_screen};
    use crate::math::random::pair;
    use crate::optics::aperture::Aperture;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::ray::Loss;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;
    use crate::optics::toric::{Biconic, Toroid};

    /// Through an asphere, a biconic and a toroid to a curved screen: bit for bit, steep rays that pass by them among those.
    #[test]
    fn rays_through_aspheres_and_toroids_are_rays_alone() {
        let conic = |curvature: f64, conic: f64| Conic { curvature, conic };
        let surface = |z: f64, shape: Shape, index: [f64; 2]| Surface {
            frame: on_axis(z),
            shape,
            aperture: Aperture::disc(6.0),
            interface: Interface::Refract,
            coating: Coating::Unit,
            index,
        };
        let train = [
            surface(
                4.0,
                Shape::Asphere {
                    base: conic(0.05, -0.7),
                    coefficients: vec![1e-4, -2e-6],
                },
                [1.0, 1.5],
            ),
            surface(
                7.0,
                Shape::Biconic(Biconic {
                    x: conic(-0.04, 0.3),
                    y: conic(0.02, -1.2),
                }),
                [1.5, 1.0],
            ),
            surface(
                9.0,
                Shape::Toroid(Toroid {
                    rotation: 0.03,
                    curve: conic(-0.05, 0.0),
                    coefficients: vec![3e-5],
                }),
                [1.0, 1.6],
            ),
        ];
        let from = open_screen(on_axis(0.0));
        let mut to = open_screen(on_axis(20.0));
        (to.index, to.shape) = (1.6, Shape::sphere(-40.0));
        let hop = Hop {
            wavelength: 0.5e-3,
            from: &from,
            train: &train,
            to: &to,
        };
        let tracer = PacketTracer::new(&hop);
        let (mut together, mut lost) = (0, 0);
        for i in 0..2000 {
            let reach = if i < 1000 { 0.5 } else { 1.9 };
            let starts = std::array::from_fn(|k| {
                let [x, y] = pair(5, [i, k as u32, 0, 0]).map(|u| 4.0 * (u - 0.5));
                let [p, q] = pair(6, [i, k as u32, 0, 0]).map(|u| reach * (u - 0.5));
                [x, y, p, q]
            });
            together +=
                u32::from(dispatch!(Level::new(), simd => eight(simd, &hop, &starts)).is_some());
            for (packed, [x, y, p, q]) in tracer.trace_eight(&starts).iter().zip(starts) {
                let alone = hop.trace([x, y], [p, q], &mut ());
                lost += u32::from(alone.is_err());
                assert_eq!(*packed, alone);
            }
        }
        assert!(together > 700 && lost > 2000, "{together} {lost}");
    }

    /// Bit for bit, rays that miss, are clipped or do not propagate among them.
    #[test]
    fn rays_together_are_rays_alone() {
        let system = lens_hologram(&Array2::zeros((20, 20)), PixelForm::Point);
        let hop = system.hops().next().unwrap();
        let directions: Vec<[f64; 2]> = (0..4003)
            .map(|i| {
                let reach = if i < 2000 { 0.1 } else { 2.2 };
                pair(2, [i, 0, 0, 0]).map(|u| reach * (u - 0.5))
            })
            .collect();
        let at = [11.0, -0.2];
        let together = PacketTracer::new(&hop).trace_from(at, &directions);
        assert_eq!(together.len(), directions.len());
        let mut lost = 0;
        for (together, p) in together.iter().zip(&directions) {
            let alone = hop.trace(at, *p, &mut ());
            lost += u32::from(alone.is_err());
            assert_eq!(*together, alone);
        }
        for loss in [Loss::Missed, Loss::Clipped, Loss::Evanescent] {
            assert!(together.contains(&Err(loss)), "{loss:?}");
        }
        assert!((100..2003).contains(&lost), "{lost}");
    }
}
