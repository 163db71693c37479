//! How a part of a system changes with a parameter, and what that does to eight rays which come to it as before.
//!
//! `gradients_are_dot_products_with_derivatives` holds the adjoint.

use fearless_simd::{Simd, SimdBase, SimdFrom, f64x8};

use crate::engine::ray_block::bend::Bend;
use crate::engine::ray_block::block::Packet;
use crate::engine::ray_block::block_step::LaneEncounter;
use crate::engine::ray_block::lane_shape::LaneBending;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::engine::ray_block::passage::Passage;
use crate::engine::ray_block::prepared_part::PreparedPart;
use crate::engine::ray_block::tangents::PartDerivatives;
use crate::math::lanes::{LANES, Lanes};
use crate::optics::conic::Conic;
use crate::optics::shape::Shape;

/// The derivatives of a part by a parameter.
pub(crate) struct PartChange<'a> {
    /// Which parameter.
    pub parameter: usize,
    /// The ways to the part below and above the value of the parameter, where they differ.
    passages: Option<[Passage; 2]>,
    shape: ShapeChange<'a>,
    /// Derivatives of the ratio of the indices on both sides, and of the index before.
    ratio: f64,
    index: f64,
    /// One over the difference of the values below and above.
    rate: f64,
}

/// How a shape changes.
enum ShapeChange<'a> {
    /// It stays.
    None,
    /// A conic with the derivatives of its curvature and conic constant.
    Conic(Conic, [f64; 2]),
    /// Any other, by its heights below and above.
    Heights([&'a Shape; 2]),
}

/// What begins at a part: changes of places, directions and paths behind it.
pub(crate) struct Beginning<S: Simd> {
    pub moved: LaneVec3<S>,
    pub turned: LaneVec3<S>,
    pub longer: f64x8<S>,
}

impl<'a> PartChange<'a> {
    /// Between a part below and above, which does the same as `part` in between but for the parameter; nothing where it is the
    /// same.
    ///
    /// # Errors
    /// Where the part becomes one of another kind.
    pub(crate) fn between(
        parameter: usize,
        part: &PreparedPart,
        [below, above]: [PreparedPart<'a>; 2],
        distance: f64,
    ) -> Result<Option<Self>, OtherKind> {
        let rate = 1.0 / distance;
        let ratio = match (part.bend, below.bend, above.bend) {
            (Bend::Refract(_), Bend::Refract(below), Bend::Refract(above)) => {
                (above - below) * rate
            }
            (Bend::Refract(_), _, _) => return Err(OtherKind),
            (bend, below, above) if bend == below && bend == above => 0.0,
            _ => return Err(OtherKind),
        };
        let shape = match (part.shape, below.shape, above.shape) {
            (_, below, above) if below == above => ShapeChange::None,
            (Shape::Conic(here), Shape::Conic(below), Shape::Conic(above)) => {
                let curvature = (above.curvature - below.curvature) * rate;
                ShapeChange::Conic(*here, [curvature, (above.conic - below.conic) * rate])
            }
            (Shape::Conic(_), _, _) => return Err(OtherKind),
            (_, below, above) => ShapeChange::Heights([below, above]),
        };
        let index = (above.index - below.index) * rate;
        let stays = below.passage == above.passage;
        let same = stays && matches!(shape, ShapeChange::None) && ratio == 0.0 && index == 0.0;
        Ok((!same).then(|| Self {
            parameter,
            passages: (!stays).then_some([below.passage, above.passage]),
            shape,
            ratio,
            index,
            rate,
        }))
    }

    /// What begins for eight rays at the part; `shorter` is −1/(N·d).
    #[inline(always)]
    pub(crate) fn begin<S: Simd, C: LaneBending<S>>(
        &self,
        encounter: &LaneEncounter<S, C>,
        shorter: f64x8<S>,
    ) -> Beginning<S> {
        let LaneEncounter {
            bend,
            direction,
            meeting,
            bent,
            index,
            ..
        } = *encounter;
        // How they come to it.
        let [place, turned] = self.arriving(encounter.before);

        // Where they meet it: N·δp + δF = 0 on the shape F = 0, whose gradient is N.
        let (raised, tilted) = self.shape.change(meeting.hit, self.rate);
        let beside = place.plus(turned.times(meeting.length));
        let longer = (meeting.normal.dot(beside) + raised) * shorter;
        let moved = beside.plus(direction.times(longer));

        // How they go on.
        let normal = meeting.bending.normal_change(moved).plus(tilted);
        let behind = bend.change(direction, meeting, bent, [normal, turned]);
        let by_ratio = bend.change_by_ratio(direction, meeting, bent);
        Beginning {
            moved,
            turned: behind.plus(by_ratio.scaled(self.ratio)),
            longer: longer * index + meeting.length * self.index,
        }
    }

    /// The derivatives by the parameter, from those by what happens to eight rays at the part and by their paths.
    #[inline(always)]
    pub(crate) fn begin_adjoint<S: Simd, C: LaneBending<S>>(
        &self,
        encounter: &LaneEncounter<S, C>,
        by: &PartDerivatives<S>,
        by_path: f64x8<S>,
    ) -> f64x8<S> {
        let LaneEncounter {
            bend,
            direction,
            meeting,
            bent,
            ..
        } = *encounter;
        let (raised, tilted) = self.shape.change(meeting.hit, self.rate);
        let mut sum = raised * by.raised + tilted.dot(by.normal);
        if self.passages.is_some() {
            let [place, turned] = self.arriving(encounter.before);
            sum = sum + place.dot(by.place) + turned.dot(by.turned);
        }
        if self.ratio != 0.0 {
            let by_ratio = bend.change_by_ratio(direction, meeting, bent);
            sum += by_ratio.dot(by.behind) * self.ratio;
        }
        sum + meeting.length * by_path * self.index
    }

    /// How places and directions of eight rays change on the axes of the part.
    #[inline(always)]
    fn arriving<S: Simd>(&self, ray: &Packet<S>) -> [LaneVec3<S>; 2] {
        let (p, d) = (ray.position, ray.direction);
        match &self.passages {
            Some([below, above]) => [
                between(below.points(p), above.points(p)).scaled(self.rate),
                between(below.directions(d), above.directions(d)).scaled(self.rate),
            ],
            None => [p.scaled(0.0), p.scaled(0.0)],
        }
    }
}

/// From one point or direction to another.
#[inline(always)]
fn between<S: Simd>(one: LaneVec3<S>, other: LaneVec3<S>) -> LaneVec3<S> {
    other.plus(one.scaled(-1.0))
}

/// A part becomes one of another kind.
#[derive(Debug)]
pub(crate) struct OtherKind;

impl ShapeChange<'_> {
    /// The changes of F and of its gradient at eight points of the shape F(x, y, z) = 0.
    #[inline(always)]
    fn change<S: Simd>(&self, at: LaneVec3<S>, rate: f64) -> (f64x8<S>, LaneVec3<S>) {
        match self {
            Self::None => (at.x * 0.0, at.scaled(0.0)),
            // F = z − ½c(x² + y² + (1+κ)z²)
            Self::Conic(Conic { curvature, conic }, [by_curvature, by_conic]) => {
                let (c, k) = (*by_curvature, 1.0 + *conic);
                let squares = at.x * at.x + at.y * at.y + at.z * at.z * k;
                let steeper = curvature * by_conic;
                let raised = squares * (-0.5 * c) - at.z * at.z * (0.5 * steeper);
                let normal = at.scaled(-c).with_z(at.z * (-(c * k + steeper)));
                (raised, normal)
            }
            // F = z − h(x, y)
            Self::Heights(shapes) => {
                let [raised, sx, sy] = heights(shapes, [*at.x.as_array(), *at.y.as_array()], rate);
                let simd = at.x.simd;
                let normal = LaneVec3::new(
                    -f64x8::simd_from(simd, sx),
                    -f64x8::simd_from(simd, sy),
                    at.x * 0.0,
                );
                (-f64x8::simd_from(simd, raised), normal)
            }
        }
    }
}

/// The changes of heights and slopes at eight points; NaN where a shape has none.
#[inline(never)]
fn heights([below, above]: &[&Shape; 2], [x, y]: [Lanes; 2], rate: f64) -> [Lanes; 3] {
    let mut found = [[f64::NAN; LANES]; 3];
    for i in 0..LANES {
        if let (Some(low), Some(high)) = (below.height(x[i], y[i]), above.height(x[i], y[i])) {
            let changes = [
                high.z - low.z,
                high.slope[0] - low.slope[0],
                high.slope[1] - low.slope[1],
            ];
            for (column, change) in found.iter_mut().zip(changes) {
                column[i] = change * rate;
            }
        }
    }
    found
}
