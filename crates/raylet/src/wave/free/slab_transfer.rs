//! What plane waves meet on their way through plane-parallel slabs: phase, interfaces, and the taper that removes the
//! directions whose periodic copies would reach the target. Eight waves are computed at once.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, dispatch, f64x8};
use ndarray::ArrayViewMut1;
use num_complex::Complex64;

use crate::math::lanes::{LANES, Lanes, cis_turns};
use crate::math::simd_level::level;
use crate::optics::refraction::{Coating, transmission};
use crate::wave::free::free_plan::{FreePlan, Slab};

/// The transfer of a free hop by direction.
pub(in crate::wave) struct SlabTransfer<'a> {
    slabs: &'a [Slab],
    wavelength: f64,
    depth: f64,
    /// Along x and y.
    tapers: [Taper; 2],
}

/// Eight plane waves on their way: their optical paths through the slabs, and the factors by which interfaces and taper
/// weaken them. The factor of an evanescent wave is zero.
pub(in crate::wave) struct Crossings {
    /// In mm.
    pub path: Lanes,
    /// From 0 to 1.
    pub size: Lanes,
}

/// The weight of a plane wave by its landing offset L: one up to a little beyond W, zero from P − W,
/// where its first periodic copy reaches the target, a C³ step between. The step is even in the cosine
/// D/√(D² + L²) rather than in L, which would crowd the grazing directions.
#[derive(Clone, Copy)]
struct Taper {
    /// The cosine up to which it is one, and the inverse of the distance to the one where it is zero.
    full: f64,
    steepness: f64,
}

impl<'a> SlabTransfer<'a> {
    /// Of the slabs of a hop, by its plan.
    pub(in crate::wave) fn new(slabs: &'a [Slab], plan: &FreePlan) -> Self {
        Self {
            slabs,
            wavelength: plan.wavelength,
            depth: plan.depth,
            tapers: [0, 1].map(|axis| Taper::new(plan, axis)),
        }
    }

    /// Multiplies waves by their transfer; `p` gives the direction of each.
    pub(in crate::wave) fn apply(
        &self,
        waves: ArrayViewMut1<Complex64>,
        p: impl Fn(usize) -> [f64; 2],
    ) {
        dispatch!(level(), simd => self.turn(simd, waves, &p, 1.0));
    }

    /// The conjugate transpose of [`SlabTransfer::apply`].
    pub(in crate::wave) fn apply_adjoint(
        &self,
        waves_bar: ArrayViewMut1<Complex64>,
        p: impl Fn(usize) -> [f64; 2],
    ) {
        dispatch!(level(), simd => self.turn(simd, waves_bar, &p, -1.0));
    }

    /// What the waves from this one on meet.
    pub(in crate::wave) fn crossings(
        &self,
        first: usize,
        p: impl Fn(usize) -> [f64; 2],
    ) -> Crossings {
        dispatch!(level(), simd => {
            let [path, size] = self.cross(simd, directions(simd, first, &p));
            Crossings { path: path.into(), size: size.into() }
        })
    }

    /// Multiplies waves by their transfer, or by its conjugate with a sign of −1.
    #[inline(always)]
    fn turn<S: Simd>(
        &self,
        simd: S,
        mut waves: ArrayViewMut1<Complex64>,
        p: &impl Fn(usize) -> [f64; 2],
        sign: f64,
    ) {
        let turns = f64x8::splat(simd, sign / self.wavelength);
        let count = waves.len();
        let mut waves = waves.iter_mut();
        for first in (0..count).step_by(LANES) {
            let [path, size] = self.cross(simd, directions(simd, first, p));
            let (cos, sin) = cis_turns(path * turns);
            let (re, im): (Lanes, Lanes) = ((cos * size).into(), (sin * size).into());
            for ((re, im), wave) in re.into_iter().zip(im).zip(waves.by_ref()) {
                *wave *= Complex64::new(re, im);
            }
        }
    }

    /// Path and size of eight waves.
    #[inline(always)]
    fn cross<S: Simd>(&self, simd: S, [px, py]: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
        let splat = |v: f64| f64x8::splat(simd, v);
        let square = px * px + py * py;
        let [mut path, mut size, mut reach] = [0.0, 1.0, 0.0].map(splat);
        let mut before: Option<(&Slab, f64x8<S>)> = None;
        for slab in self.slabs {
            // Evanescent waves go on as if they were not, with nothing left of them.
            let under = splat(slab.index * slab.index) - square;
            let travels = under.simd_gt(splat(0.0));
            let normal = travels.select(under, splat(1.0)).sqrt();
            size = travels.select(size, splat(0.0));
            if let Some((last, cosine)) = before
                && let Some(coating) = last.exit
            {
                let ratio = last.index / slab.index;
                size *= transmitted(simd, coating, [cosine, normal], ratio);
            }
            path += splat(slab.thickness.abs()) * normal;
            reach += splat(slab.thickness.abs()) / normal;
            before = Some((slab, normal));
        }
        let [x, y] = &self.tapers;
        let kept = x.weight(reach * px, self.depth) * y.weight(reach * py, self.depth);
        [path, size * kept]
    }
}

/// The cosines of eight waves from this one on.
#[inline(always)]
fn directions<S: Simd>(simd: S, first: usize, p: &impl Fn(usize) -> [f64; 2]) -> [f64x8<S>; 2] {
    let mut lanes = [[0.0; LANES]; 2];
    let [x, y] = &mut lanes;
    for (n, (x, y)) in x.iter_mut().zip(y).enumerate() {
        [*x, *y] = p(first + n);
    }
    lanes.map(|lanes| f64x8::from_slice(simd, &lanes))
}

/// What a coating lets through at normal optical cosines before and behind it.
#[inline(always)]
fn transmitted<S: Simd>(simd: S, coating: Coating, cosines: [f64x8<S>; 2], ratio: f64) -> f64x8<S> {
    let [before, behind]: [Lanes; 2] = cosines.map(Into::into);
    let mut through = [0.0; LANES];
    for ((through, before), behind) in through.iter_mut().zip(before).zip(behind) {
        *through = transmission(coating, before, behind, ratio);
    }
    f64x8::from_slice(simd, &through)
}

impl Taper {
    /// Along an axis of a plan.
    fn new(plan: &FreePlan, axis: usize) -> Self {
        let depth = plan.depth;
        let [full, none] = (plan.taper(axis)).map(|landing| depth / depth.hypot(landing));
        Self {
            full,
            steepness: 1.0 / (full - none),
        }
    }

    /// The weights at eight landing offsets.
    #[inline(always)]
    fn weight<S: Simd>(&self, landing: f64x8<S>, depth: f64) -> f64x8<S> {
        let splat = |v: f64| f64x8::splat(landing.simd, v);
        let [zero, one] = [0.0, 1.0].map(splat);
        // Over no distance nothing moves, and no copy arrives.
        if depth == 0.0 {
            return one;
        }
        let far = (splat(depth * depth) + landing * landing).sqrt();
        let t = (splat(self.full) - splat(depth) / far) * splat(self.steepness);
        let t = t.max(zero).min(one);
        let [a, b, c, d] = [35.0, 84.0, 70.0, 20.0].map(splat);
        let square = t * t;
        one - square * square * (a - t * (b - t * (c - d * t)))
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::optics::refraction::Coating;
    use crate::wave::free::free_plan::{FreePlan, Slab};
    use crate::wave::free::slab_transfer::SlabTransfer;
    use crate::wave::patches::patch::Band;

    /// The wavenumber in rad/mm.
    const K: f64 = std::f64::consts::TAU / 6e-4;

    /// A plate of glass 1 mm in front of a target as wide as the screen, 0.2 mm.
    fn plate() -> ([Slab; 2], FreePlan) {
        let slab = |index: f64, thickness: f64| Slab {
            index,
            thickness,
            exit: Some(Coating::Fresnel),
        };
        let plan = FreePlan {
            period: [1.0; 2],
            span: [0.2; 2],
            bands: [Band::between(0.0, 6e-4, -0.5, 0.5); 2],
            reach: [0.5; 2],
            depth: 0.8 / 1.5 + 1.0,
            wavelength: 6e-4,
        };
        ([slab(1.5, 0.8), slab(1.0, 1.0)], plan)
    }

    /// Directions from the axis to beyond the plane waves that travel, as many as fill no whole number of lanes.
    fn direction(i: usize) -> [f64; 2] {
        [0.09 * i as f64, 0.001]
    }

    /// Near the axis the phase and the interface alone count; steeper waves fade, and evanescent ones are gone.
    #[test]
    fn waves_have_phase_interface_and_taper() {
        let (slabs, plan) = plate();
        let mut waves = Array2::from_elem((1, 13), Complex64::ONE);
        SlabTransfer::new(&slabs, &plan).apply(waves.row_mut(0), direction);
        let [x, y] = direction(0);
        let [glass, air] = [1.5f64, 1.0].map(|n| (n * n - x * x - y * y).sqrt());
        let expected = Complex64::from_polar(2.0 * 1.5 / 2.5, K * (0.8 * glass + air));
        assert!((waves[[0, 0]] - expected).norm() < 1e-6, "{waves}");
        let sizes = waves.mapv(|wave| wave.norm());
        assert!(
            sizes[[0, 1]] > sizes[[0, 6]] && sizes[[0, 12]] == 0.0,
            "{sizes}"
        );
    }

    /// Waves that are steep along y fade as those that are steep along x.
    #[test]
    fn both_axes_fade_alike() {
        let (slabs, plan) = plate();
        let transfer = SlabTransfer::new(&slabs, &plan);
        let mut waves = Array2::from_elem((2, 13), Complex64::ONE);
        transfer.apply(waves.row_mut(0), direction);
        transfer.apply(waves.row_mut(1), |i| [direction(i)[1], direction(i)[0]]);
        for (x, y) in waves.row(0).iter().zip(waves.row(1)) {
            assert!((x - y).norm() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn apply_dot_product() {
        let (slabs, plan) = plate();
        let transfer = SlabTransfer::new(&slabs, &plan);
        let [waves, bars] = [1, 2].map(|purpose| noise([1, 13], purpose));
        let (mut forward, mut back) = (waves.clone(), bars.clone());
        transfer.apply(forward.row_mut(0), direction);
        transfer.apply_adjoint(back.row_mut(0), direction);
        assert_transposed(&[(&bars, &forward)], &[(&back, &waves)]);
    }

    /// Whichever eight waves are taken together.
    #[test]
    fn crossings_are_those_of_the_transfer() {
        let (slabs, plan) = plate();
        let transfer = SlabTransfer::new(&slabs, &plan);
        let mut waves = Array2::from_elem((1, 21), Complex64::ONE);
        transfer.apply(waves.row_mut(0), direction);
        for first in [0, 3, 6, 13] {
            let met = transfer.crossings(first, direction);
            for (lane, (size, path)) in met.size.into_iter().zip(met.path).enumerate() {
                let off = Complex64::from_polar(size, K * path) - waves[[0, first + lane]];
                assert!(off.norm() < 1e-9, "{first} {lane}: {off}");
            }
        }
    }
}
