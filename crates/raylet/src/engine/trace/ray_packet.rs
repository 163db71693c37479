//! Many rays from one place, eight at a time.
//!
//! Eight are traced together where its surfaces are planes and conics, met without a search. Where one
//! of eight is lost, each goes alone; every ray has the bits that it has alone.

use fearless_simd::{Level, Simd, dispatch};

use crate::engine::trace::ray_trace::Landing;
use crate::math::real::Real;
use crate::math::simd_packet::{PACKET, SimdPacket};
use crate::optics::ray::Loss;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;

/// The rays from (x, y) along each of these optical direction cosines, where they land or how they were lost.
pub(crate) fn trace_packets(
    hop: &Hop,
    at: [f64; 2],
    directions: &[[f64; 2]],
) -> Vec<Result<Landing, Loss>> {
    let level = Level::new();
    let together = is_closed(hop);
    let mut landings = Vec::with_capacity(directions.len());
    for group in directions.chunks(PACKET) {
        let packed = match <&[[f64; 2]; PACKET]>::try_from(group) {
            Ok(group) if together => dispatch!(level, simd => eight(simd, hop, at, group)),
            _ => None,
        };
        match packed {
            Some(eight) => landings.extend((0..PACKET).map(|i| Ok(alone(&eight, i)))),
            None => landings.extend(group.iter().map(|p| hop.trace(at, *p, &mut ()))),
        }
    }
    landings
}

/// Whether every surface of a hop is met by a formula.
fn is_closed(hop: &Hop) -> bool {
    let closed = |shape: &Shape| matches!(shape, Shape::Plane | Shape::Conic(_));
    hop.from.is_plane() && closed(&hop.to.shape) && hop.train.iter().all(|s| closed(&s.shape))
}

/// Eight rays together; nothing when one of them is lost.
#[inline(always)]
fn eight<S: Simd>(
    _: S,
    hop: &Hop,
    at: [f64; 2],
    directions: &[[f64; 2]; PACKET],
) -> Option<Landing<SimdPacket>> {
    let p = [0, 1].map(|a| SimdPacket(std::array::from_fn(|i| directions[i][a])));
    hop.trace(at.map(SimdPacket::constant), p, &mut ()).ok()
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
    use ndarray::Array2;

    use crate::design::examples::problems::lens_hologram;
    use crate::engine::trace::ray_packet::trace_packets;
    use crate::math::random::pair;
    use crate::optics::doe::PixelForm;
    use crate::optics::ray::Loss;

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
        let together = trace_packets(&hop, at, &directions);
        assert_eq!(together.len(), directions.len());
        let mut lost = 0;
        for (together, p) in together.iter().zip(&directions) {
            let alone = hop.trace(at, *p, &mut ());
            lost += u32::from(alone.is_err());
            assert_eq!(*together, alone);
        }
        assert!(together.contains(&Err(Loss::Clipped)));
        assert!(together.contains(&Err(Loss::Evanescent)));
        assert!((100..2003).contains(&lost), "{lost}");
    }
}
