//! Which pixels along an axis take part in a value between their centres, and with what shares.

use crate::math::band_limit::{TAPS, taps};

/// Neighbouring pixels with their shares.
#[derive(Clone, Copy)]
pub(crate) struct PixelShares {
    first: usize,
    count: usize,
    shares: [f64; TAPS],
}

impl PixelShares {
    /// One pixel alone.
    pub(crate) fn one(pixel: usize) -> Self {
        let mut shares = [0.0; TAPS];
        shares[0] = 1.0;
        Self {
            first: pixel,
            count: 1,
            shares,
        }
    }

    /// Linear interpolation at a place in steps of the centres, held constant beyond the outer ones.
    pub(crate) fn linear(place: f64, pixels: usize) -> Self {
        let last = pixels.saturating_sub(1);
        let place = place.clamp(0.0, last as f64);
        let low = (place as usize).min(last.saturating_sub(1));
        let above = place - low as f64;
        let mut shares = [0.0; TAPS];
        (shares[0], shares[1]) = (1.0 - above, above);
        Self {
            first: low,
            count: 2.min(pixels),
            shares,
        }
    }

    /// Interpolation of a limited band, of pixels that are zero beyond the outer ones.
    pub(crate) fn band_limited(place: f64, pixels: usize) -> Self {
        let (first, weights) = taps(place);
        let skipped = (-first).clamp(0, TAPS as i64) as usize;
        let first = first.max(0) as usize;
        let mut shares = [0.0; TAPS];
        let kept = weights.iter().skip(skipped);
        shares
            .iter_mut()
            .zip(kept)
            .for_each(|(share, weight)| *share = *weight);
        Self {
            first,
            count: (TAPS - skipped).min(pixels.saturating_sub(first)),
            shares,
        }
    }

    /// The pixels, each with its share.
    pub(crate) fn pixels(self) -> impl Iterator<Item = (usize, f64)> {
        let shares = self.shares.into_iter().take(self.count).enumerate();
        shares.map(move |(n, share)| (self.first + n, share))
    }
}
