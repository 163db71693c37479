//! Beamlets that the rays of a block carry.
//!
//! A beamlet is a pair of complex rays beside its ray: moved by the unit vectors e_j of the screen, and turned by its
//! curvature, Q e_j (Arnaud, Appl. Opt. 24, 538, 1985). Their derivatives are those of real rays. With m_j their places and
//! d the direction of the ray, the amplitude falls in a flight as 1/√(D₁/D₀), D = d·(m₁ × m₂); where they land at
//! places M with cosines N, the curvature is N M⁻¹.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdFrom, f64x8};

use crate::engine::ray_block::bend::Bend;
use crate::engine::ray_block::block::{Column, PACKETS, load, store};
use crate::engine::ray_block::block_step::{LaneCompanion, LaneEncounter};
use crate::engine::ray_block::lane_complex::{LaneComplex, triple};
use crate::engine::ray_block::lane_shape::LaneBending;
use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::math::complex::{Complex, Symmetric};
use crate::math::lanes::LANES;
use crate::optics::refraction::Coating;

/// Complex vectors of a block: real and imaginary parts.
type ComplexColumns = [[Column; 3]; 2];

/// Beamlets of a block that all start with one curvature.
pub(crate) struct LaneBeamlets {
    /// Their curvature on the axes of the plane screen from which they start, in 1/mm.
    start: Symmetric<f64>,
    /// Places of both rays.
    moved: [ComplexColumns; 2],
    /// Changes of their directions.
    turned: [ComplexColumns; 2],
    /// D behind the last part: real and imaginary parts.
    area: [Column; 2],
    /// Amplitudes without the phases of optical paths.
    amplitude: [Column; 2],
}

const ZERO: Column = [[0.0; LANES]; PACKETS];

#[inline(always)]
fn number<S: Simd>(simd: S, columns: &[Column; 2], at: usize) -> LaneComplex<S> {
    LaneComplex::new(
        f64x8::simd_from(simd, columns[0][at]),
        f64x8::simd_from(simd, columns[1][at]),
    )
}

#[inline(always)]
fn put<S: Simd>(columns: &mut [Column; 2], at: usize, number: LaneComplex<S>) {
    columns[0][at] = *number.re.as_array();
    columns[1][at] = *number.im.as_array();
}

impl LaneBeamlets {
    /// Beamlets that start with this curvature.
    pub(crate) fn new(start: Symmetric<f64>) -> Self {
        Self {
            start,
            moved: [[[ZERO; 3]; 2]; 2],
            turned: [[[ZERO; 3]; 2]; 2],
            area: [ZERO; 2],
            amplitude: [ZERO; 2],
        }
    }

    /// Amplitude of beamlet `i`, and its curvature along the axes of a plane screen in a medium of index `n`.
    pub(crate) fn landed(&self, i: usize, n: f64) -> (Complex<f64>, Symmetric<f64>) {
        let (at, lane) = (i / LANES, i % LANES);
        let number = |columns: &ComplexColumns, axis: usize| {
            Complex::new(columns[0][axis][at][lane], columns[1][axis][at][lane])
        };
        let [a, b] = [0, 1].map(|ray| [0, 1].map(|axis| number(&self.moved[ray], axis)));
        let [c, d] = [0, 1].map(|ray| [0, 1].map(|axis| number(&self.turned[ray], axis)));
        let scale = (a[0] * b[1] - a[1] * b[0]).inverse().scale(n);
        let curvature = Symmetric {
            xx: (c[0] * b[1] - d[0] * a[1]) * scale,
            xy: (c[1] * b[1] - d[1] * a[1]) * scale,
            yy: (d[1] * a[0] - c[1] * b[0]) * scale,
        };
        let amplitude = Complex::new(self.amplitude[0][at][lane], self.amplitude[1][at][lane]);
        (amplitude, curvature)
    }
}

impl LaneCompanion for LaneBeamlets {
    #[inline(always)]
    fn launch<S: Simd>(&mut self, at: usize, d: LaneVec3<S>, _: [f64x8<S>; 2], n: f64) {
        let simd = d.x.simd;
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        // How the direction changes with the optical cosines along x and y.
        let step = one / n;
        let by_x = LaneVec3::new(step, zero, -d.x / d.z * step);
        let by_y = LaneVec3::new(zero, step, -d.y / d.z * step);
        let Symmetric { xx, xy, yy } = self.start;
        let [first, second] = &mut self.turned;
        store(
            &mut first[0],
            at,
            by_x.scaled(xx.re).plus(by_y.scaled(xy.re)),
        );
        store(
            &mut first[1],
            at,
            by_x.scaled(xx.im).plus(by_y.scaled(xy.im)),
        );
        store(
            &mut second[0],
            at,
            by_x.scaled(xy.re).plus(by_y.scaled(yy.re)),
        );
        store(
            &mut second[1],
            at,
            by_x.scaled(xy.im).plus(by_y.scaled(yy.im)),
        );
        let nothing = LaneVec3::new(zero, zero, zero);
        let [first, second] = &mut self.moved;
        store(&mut first[0], at, LaneVec3::new(one, zero, zero));
        store(&mut first[1], at, nothing);
        store(&mut second[0], at, LaneVec3::new(zero, one, zero));
        store(&mut second[1], at, nothing);
        put(&mut self.area, at, LaneComplex::new(d.z, zero));
        put(&mut self.amplitude, at, LaneComplex::new(one, zero));
    }

    #[inline(always)]
    fn follow<S: Simd, C: LaneBending<S>>(&mut self, at: usize, encounter: &LaneEncounter<S, C>) {
        let LaneEncounter {
            passage,
            direction,
            meeting,
            ..
        } = *encounter;
        let simd = direction.x.simd;

        // Where both rays start, and where the flight ends.
        let nothing = [direction.scaled(0.0); 2];
        let (mut starts, mut ends, mut turned) = ([nothing; 2], [nothing; 2], [nothing; 2]);
        for ray in 0..2 {
            for part in 0..2 {
                let start = passage.directions(load(simd, &self.moved[ray][part], at));
                let turn = passage.directions(load(simd, &self.turned[ray][part], at));
                starts[ray][part] = start;
                turned[ray][part] = turn;
                ends[ray][part] = start.plus(turn.times(meeting.length));
            }
        }

        // With λ₁ and λ₂ the eigenvalues of the flight, s = √λ₁√λ₂ is the root of D₁/D₀. Both √λ lie in the first quadrant,
        // in the last for a flight backwards: where s is nearly real, t = λ₁ + λ₂ has Re(t* s) > 0, elsewhere the
        // imaginary part of s has the sign of the length.
        let fallen = number(simd, &self.area, at).inverse();
        let end = triple(direction, ends[0], ends[1]);
        let both =
            triple(direction, starts[0], ends[1]).plus(triple(direction, ends[0], starts[1]));
        let root = end.times(fallen).sqrt();
        let trace = both.times(fallen);
        let real = root.re.abs().simd_gt(root.im.abs());
        let sign = real.select(
            trace.re * root.re + trace.im * root.im,
            root.im * meeting.length,
        );
        let root = root.scaled(f64x8::splat(simd, 1.0).copysign(sign));
        let amplitude = number(simd, &self.amplitude, at).times(root.inverse());

        // The part takes both rays on.
        let [factor, shrunk] = passed(encounter);
        put(&mut self.amplitude, at, amplitude.scaled(factor));
        put(&mut self.area, at, end.scaled(shrunk));
        let shorter = -1.0 / meeting.along;
        for ray in 0..2 {
            for part in 0..2 {
                let beside = ends[ray][part];
                let longer = meeting.normal.dot(beside) * shorter;
                let along = beside.plus(direction.times(longer));
                let normal = meeting.bending.normal_change(along);
                let changes = [normal, turned[ray][part]];
                let behind = encounter
                    .bend
                    .change(direction, meeting, encounter.bent, changes);
                store(&mut self.moved[ray][part], at, along);
                store(&mut self.turned[ray][part], at, behind);
            }
        }
    }
}

/// The factor of the field that a part transmits, and that of D.
#[inline(always)]
fn passed<S: Simd, C>(encounter: &LaneEncounter<S, C>) -> [f64x8<S>; 2] {
    let one = f64x8::splat(encounter.direction.x.simd, 1.0);
    let Bend::Refract(ratio) = encounter.bend else {
        return match encounter.bend {
            Bend::Reflect => [one, -one],
            _ => [one, one],
        };
    };
    // n cos χ before and behind, over the index behind and the length of the normal.
    let before = encounter.meeting.along.abs() * ratio;
    let after = encounter.bent.root.abs();
    let factor = match encounter.coating {
        Coating::Unit => one,
        Coating::Ideal => (before / after).sqrt(),
        Coating::Fresnel => {
            let s = before * 2.0 / (before + after);
            let p = before * 2.0 / (before / ratio + after * ratio);
            ((s * s + p * p) * 0.5).sqrt()
        }
    };
    [factor, encounter.bent.root / encounter.meeting.along]
}
