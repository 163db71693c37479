//! The plane that touches a screen at a patch, and the plane waves that leave it.
//!
//! A patch is cut over the screen's local (x, y), where its modes have rates f: e^{ik f·Δ}. The wave in
//! space that has them on the touching plane has p + q∇s = f there, with (p, q) on the screen's axes;
//! p_t = Aᵀf are its cosines on the plane's own axes, A = ∂(x, y)/∂u.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::vec3::Vec3;
use crate::optics::screen::Screen;
use crate::optics::system::Hop;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::{Heights, Stack};
use crate::wave::patches::patch::Band;
use crate::wave::patches::tile::{CutScratch, TileCutter};

/// A place on a screen where a patch stands.
pub(crate) struct TangentPatch {
    /// The touching plane; nothing on a plane screen.
    plane: Option<Screen>,
    /// The place, in mm on the screen's local plane.
    at: [f64; 2],
    /// Height and slope of the screen there.
    z: f64,
    slope: [f64; 2],
    /// The touching plane's axes x, y, z along the screen's own.
    axes: [Vec3<f64>; 3],
    index: f64,
    leaves: f64,
    /// Rates of the modes that the middle of the lattice represents, beyond those on the local plane.
    carrier: [f64; 2],
}

impl TangentPatch {
    /// The tangent patch at (x, y); `along` is the normal cosine of the incident light, with its sign. Nothing
    /// where a curved screen does not exist.
    pub(crate) fn new(screen: &Screen, at: [f64; 2], along: f64) -> Option<Self> {
        let mut tangent_patch = Self {
            plane: None,
            at,
            z: 0.0,
            slope: [0.0; 2],
            axes: [
                Vec3::new(1.0, 0.0, 0.0),
                Vec3::new(0.0, 1.0, 0.0),
                Vec3::new(0.0, 0.0, 1.0),
            ],
            index: screen.index_behind(),
            leaves: screen.leaves(),
            carrier: [0.0; 2],
        };
        if screen.is_plane() {
            return Some(tangent_patch);
        }
        let here = screen.height(at)?;
        let plane = screen.tangent(at)?;
        tangent_patch.axes = [plane.frame.x, plane.frame.y, plane.frame.z]
            .map(|a| screen.frame.direction_to_local(a));
        (tangent_patch.z, tangent_patch.slope) = (here.z, here.slope);
        tangent_patch.carrier = here.slope.map(|s| s * along);
        tangent_patch.plane = Some(plane);
        Some(tangent_patch)
    }

    /// The hop as it begins here, and the point on its first plane.
    pub(crate) fn start<'a>(&'a self, hop: &Hop<'a>) -> (Hop<'a>, [f64; 2]) {
        match &self.plane {
            None => (*hop, self.at),
            Some(plane) => (
                Hop {
                    from: plane,
                    ..*hop
                },
                [0.0; 2],
            ),
        }
    }

    /// Cosines on the touching plane of the mode with these rates on the lattice; nothing when it does
    /// not propagate.
    #[inline]
    pub(crate) fn cosines(&self, rates: [f64; 2]) -> Option<[f64; 2]> {
        let p = self.on_plane(rates);
        (p[0].hypot(p[1]) < self.index).then_some(p)
    }

    /// The same, whether it propagates or not.
    #[inline]
    pub(crate) fn on_plane(&self, rates: [f64; 2]) -> [f64; 2] {
        let f = [rates[0] + self.carrier[0], rates[1] + self.carrier[1]];
        let [x, y, _] = &self.axes;
        [x.x * f[0] + x.y * f[1], y.x * f[0] + y.y * f[1]]
    }

    /// Cosine of a mode along the screen's own z axis, with its sign.
    fn lift(&self, p: [f64; 2]) -> f64 {
        let q = (self.index * self.index - p[0] * p[0] - p[1] * p[1])
            .max(0.0)
            .sqrt();
        p[0] * self.axes[0].z + p[1] * self.axes[1].z + q * self.leaves * self.axes[2].z
    }

    /// The modes of the patch here on a plane screen.
    pub(crate) fn cut_plane(&self, cutter: &TileCutter, field: &Field, cut: &mut CutScratch) {
        cutter.cut(field, self.at, cut);
    }

    /// The modes of the patch as if it were the touching plane: light of normal cosine `along` has the
    /// phase there that it would have, and leaves from there.
    pub(crate) fn cut_tangent(
        &self,
        cutter: &TileCutter,
        (field, heights): (&Field, &Heights),
        [along, k]: [f64; 2],
        cut: &mut CutScratch,
    ) {
        let value = |node| {
            let over = self.over(field, heights, node);
            field.values[node] * Complex64::cis(-k * along * over)
        };
        cutter.cut_nodes(self.at, self.carrier, value, cut);
    }

    /// The modes of the patch as if its light left the touching plane, with the field of the true surface.
    pub(crate) fn cut_incident(&self, cutter: &TileCutter, field: &Field, cut: &mut CutScratch) {
        cutter.cut_nodes(self.at, self.carrier, |node| field.values[node], cut);
    }

    /// The height of a node over the touching plane, along the screen's z axis.
    #[inline]
    fn over(&self, field: &Field, heights: &Heights, [j, i]: [usize; 2]) -> f64 {
        let dx = field.grid.x.node(i) - self.at[0];
        let dy = field.grid.y.node(j) - self.at[1];
        heights.z[[j, i]] - self.z - self.slope[0] * dx - self.slope[1] * dy
    }

    /// The modes with the field on the true surface, Σ U e^{−ik(f·Δ + q h)} with the height h over the
    /// touching plane: few levels of h separate place and mode.
    pub(crate) fn cut_true(
        &self,
        cutter: &TileCutter,
        (field, heights): (&Field, &Heights),
        (bands, k): (&[Band; 2], f64),
        cut: &mut CutScratch,
    ) {
        let nodes = cutter.nodes(self.at);
        let over = |node| self.over(field, heights, node);
        let lifts = self.lifts(bands);
        let stack = Stack::new(range(field, &nodes, over), ends(&lifts), k);
        let mut modes = vec![Complex64::ZERO; lifts.len()];
        for (number, level) in stack.levels.at.iter().enumerate() {
            let value = |node| stack.part(field.values[node], over(node), number);
            cutter.cut_nodes(self.at, self.carrier, value, cut);
            for ((mode, part), lift) in modes.iter_mut().zip(&cut.modes).zip(&lifts) {
                *mode += part * Complex64::cis(-k * lift * level);
            }
        }
        cut.modes = modes;
    }

    /// The cosine along z of every mode, zero where it does not propagate.
    fn lifts(&self, bands: &[Band; 2]) -> Array2<f64> {
        Array2::from_shape_fn((bands[1].count, bands[0].count), |(my, mx)| {
            self.cosines([bands[0].at(mx), bands[1].at(my)])
                .map_or(0.0, |p| self.lift(p))
        })
    }
}

/// Lowest and highest of what is lit.
fn range(field: &Field, nodes: &[Range<usize>; 2], of: impl Fn([usize; 2]) -> f64) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for j in nodes[1].clone() {
        for i in nodes[0].clone() {
            if field.values[[j, i]] != Complex64::ZERO {
                let height = of([j, i]);
                range = [range[0].min(height), range[1].max(height)];
            }
        }
    }
    if range[0] <= range[1] {
        range
    } else {
        [0.0; 2]
    }
}

/// Smallest and largest value but zero.
fn ends(lifts: &Array2<f64>) -> [f64; 2] {
    let lit = lifts.iter().filter(|lift| **lift != 0.0);
    let ends = lit.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], lift| {
        [low.min(*lift), high.max(*lift)]
    });
    if ends[0] <= ends[1] { ends } else { [0.0; 2] }
}
