//! Beamlets that are kept from one run to the next: nothing of them depends on the field.

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::Grid;
use crate::wave::grid::raster::Raster;

/// The beamlets of one patch that reach the target, in the order of their modes.
#[derive(Clone, Debug)]
pub(crate) struct PatchBeamlets {
    /// The patch.
    pub index: usize,
    /// The directions that were tried, as indices in the bands along x and y.
    pub modes: [Range<usize>; 2],
    /// Each beamlet's place among the modes, [my, mx].
    pub places: Vec<[usize; 2]>,
    /// The beamlets, of coefficient one.
    pub arrivals: Vec<Arrival>,
}

impl PatchBeamlets {
    /// Bytes that a beamlet takes.
    pub(crate) const BYTES: usize = size_of::<Arrival>() + size_of::<[usize; 2]>();

    /// Those at the given places.
    pub(crate) fn only(&self, kept: impl Fn([usize; 2]) -> bool) -> Self {
        let pairs = self.places.iter().zip(&self.arrivals);
        let (places, arrivals) = pairs.filter(|(place, _)| kept(**place)).unzip();
        Self {
            places,
            arrivals,
            modes: self.modes.clone(),
            ..*self
        }
    }
}

/// The beamlets of all patches from one grid to one raster; patches that the target does not see have none.
struct Cached {
    from: Grid,
    to: Raster,
    beamlets: Vec<Option<PatchBeamlets>>,
}

/// Where the beamlets of one hop may be kept. They are written once; copies share them.
#[derive(Clone, Default)]
pub(crate) struct BeamletCache(Arc<OnceLock<Option<Cached>>>);

impl BeamletCache {
    /// Whether nothing has been decided about it yet.
    pub(crate) fn is_new(&self) -> bool {
        self.0.get().is_none()
    }

    /// Keeps the beamlets of all patches, or nothing for good, if it is new.
    pub(crate) fn fill(
        &self,
        from: &Grid,
        to: &Raster,
        beamlets: Option<Vec<Option<PatchBeamlets>>>,
    ) {
        let cached = beamlets.map(|beamlets| Cached {
            from: from.clone(),
            to: *to,
            beamlets,
        });
        // Somebody else may have been faster, with the same.
        let _ = self.0.set(cached);
    }

    /// What is kept, if it is of this grid and this raster.
    pub(crate) fn of(&self, from: &Grid, to: &Raster) -> Option<&[Option<PatchBeamlets>]> {
        let cached = self.0.get()?.as_ref()?;
        (cached.from == *from && cached.to == *to).then_some(cached.beamlets.as_slice())
    }
}

impl fmt::Debug for BeamletCache {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let cached = self.0.get().and_then(Option::as_ref);
        let patches = cached.map_or(0, |cached| cached.beamlets.len());
        write!(out, "BeamletCache({patches} patches)")
    }
}
