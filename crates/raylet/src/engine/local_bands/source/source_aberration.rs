//! What the sum of a smooth source's beamlets departs by from its wave.
//!
//! Each window has one beamlet, whose Gaussians add up to one if rays map linearly. The beamlet of a neighbour at u adds
//! exp(a + d) times its weight where the beamlet in the middle lands: a is what its amplitude differs by, of orders u and u²;
//! d is what its exponent departs by from that of the linear map, of orders u³ and u⁴: its imaginary part is the aberration,
//! and its real part the decay of beamlets that do not land evenly. The mean of exp(a + d) over the weight, to the second
//! order in odd terms, is what the sum is too strong by.
//!
//! The weight is a Gaussian of the complex covariance σ²(1 + iβ), as beamlets spread on their way: β = (A + BQ)⁻¹B/kσ² for a
//! carrier of curvature Q and rays that land at Ax + Bp. All terms are polynomials in u, known on a circle of real rays. So
//! their means are those over a circle in the complex plane of u, by ⟨r²⟩ = 2σ², ⟨r⁴⟩ = 8σ⁴ and ⟨r⁶⟩ = 48σ⁶.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::engine::beamlet::beamlet_aberration::{Aberration, AberrationError, CORRECTABLE};
use crate::engine::local_bands::chirped_beamlet::{ChirpedStart, NEARER};
use crate::engine::local_bands::source::source_light::{source_carrier, source_field};
use crate::engine::ray_block::hop_rays::RayStart;
use crate::engine::trace::ray_trace::Carried;
use crate::optics::ray::Loss;
use crate::optics::source::Source;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;

/// Directions on half a circle, evenly, with whose opposites polynomials of the fourth degree are known.
const DIRECTIONS: usize = 5;

/// ⟨r²⟩/σ², ⟨r⁴⟩/σ⁴ and ⟨r⁶⟩/σ⁶ over the weight.
const MOMENTS: [f64; 3] = [2.0, 8.0, 48.0];

/// What the correction leaves of η, over η²: 2.6 to 4.5 behind a triplet, an ellipsoid and a strong lens, for η from 3e-3 to 9e-3.
const LEFT: f64 = 4.0;

/// The aberration inside the beamlet of a window of a source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SourceAberration {
    /// That of the phases alone.
    pub phases: Aberration,
    /// What the sum is too strong by, in parts of the field; nothing where some neighbours are lost.
    excess: Option<Complex64>,
}

impl SourceAberration {
    /// What it does to the field.
    pub(crate) fn error(&self) -> AberrationError {
        let Some(excess) = self.excess else {
            return self.phases.error();
        };
        let plain = excess.norm().min(1.0);
        let left = match plain > CORRECTABLE {
            true => plain,
            false => (LEFT * plain * plain).min(plain),
        };
        AberrationError {
            plain,
            left,
            cubic: self.phases.cubic,
            lattice: self.phases.lattice,
            orders: 1.0,
        }
    }

    /// The factor for the beamlet's amplitude; one where the expansion does not hold.
    pub(crate) fn correction(&self) -> Complex64 {
        match self.excess {
            None => self.phases.correction(),
            Some(excess) if excess.norm() > CORRECTABLE => Complex64::ONE,
            Some(excess) => (-excess).exp(),
        }
    }
}

/// The aberration inside the beamlet of a window of a source; nothing when its ray or most of its neighbours are lost.
pub(crate) fn source_aberration(
    start: &ChirpedStart,
    hop: &Hop,
    source: &Source,
) -> Option<SourceAberration> {
    let middle = Middle::of(start, hop, source)?;
    NEARER.iter().find_map(|part| middle.aberration(*part))
}

/// The beamlet in the middle.
struct Middle<'a> {
    start: &'a ChirpedStart,
    hop: &'a Hop<'a>,
    source: &'a Source,
    /// Where it lands.
    own: Neighbour,
    /// iβ.
    spread: [[Complex64; 2]; 2],
}

/// A beamlet where it lands, of a window that the source lights.
struct Neighbour {
    arrival: Arrival,
    /// Its amplitude without the phase of its path.
    amplitude: Complex64,
}

/// Even and odd parts of what two opposite neighbours differ by.
#[derive(Clone, Copy)]
struct Pair {
    /// Of the amplitude's logarithm: [even, odd].
    amplitude: [Complex64; 2],
    /// Of the exponent, beyond the linear map: [even, odd].
    exponent: [Complex64; 2],
}

impl<'a> Middle<'a> {
    /// The beamlet of a start; nothing where its ray is lost.
    fn of(start: &'a ChirpedStart, hop: &'a Hop<'a>, source: &'a Source) -> Option<Self> {
        let carrier = &start.carrier;
        let (_, jacobian) = hop.jacobian_along(carrier.at, carrier.p).ok()?;
        Some(Self {
            start,
            hop,
            source,
            own: Neighbour::all(&[*start], hop, source).pop()??,
            spread: spread(start, &jacobian, hop.wavenumber())?,
        })
    }

    /// The means over neighbours on a circle of this part of σ; nothing where most of them are lost.
    fn aberration(&self, part: f64) -> Option<SourceAberration> {
        let places = std::array::from_fn(|number| direction(number).map(|e| part * e));
        let traced: Vec<Pair> = self.pairs(places).into_iter().flatten().collect();
        if 2 * traced.len() <= DIRECTIONS {
            return None;
        }

        // The phases alone, from the rays that arrive.
        let mean = |term: &dyn Fn(&Pair) -> f64| {
            traced.iter().map(term).sum::<f64>() / traced.len() as f64
        };
        let [_, fourth, sixth] = moments(part);
        let phases = Aberration {
            cubic: sixth * mean(&|pair| pair.exponent[1].im.powi(2)),
            quartic: fourth * mean(&|pair| pair.exponent[0].im) / 3.0,
            lattice: 0.0,
        };
        let all = <&[Pair; DIRECTIONS]>::try_from(&traced[..]).ok();
        Some(SourceAberration {
            phases,
            excess: all.map(|all| self.excess(all, part)),
        })
    }

    /// What the sum is too strong by, phases included, from all pairs.
    fn excess(&self, pairs: &[Pair; DIRECTIONS], part: f64) -> Complex64 {
        let known = |term: fn(&Pair) -> Complex64| pairs.each_ref().map(term);
        let amplitudes = [
            known(|pair| pair.amplitude[1]),
            known(|pair| pair.amplitude[0]),
        ];
        let exponents = [
            known(|pair| pair.exponent[1]),
            known(|pair| pair.exponent[0]),
        ];
        let [second, fourth, sixth] = moments(part);
        let at = |number: usize| {
            let u = self.weighted(direction(number));
            let [a1, a2] = [0, 1].map(|i| polynomial(&amplitudes[i], i + 1, u));
            let [d3, d4] = [0, 1].map(|i| polynomial(&exponents[i], i + 3, u));
            second * (a2 + 0.5 * a1 * a1) + fourth * (d4 + a1 * d3) + sixth * 0.5 * d3 * d3
        };
        (0..DIRECTIONS).map(at).sum::<Complex64>() / DIRECTIONS as f64
    }

    /// A direction times the root of 1 + iβ.
    fn weighted(&self, [x, y]: [f64; 2]) -> [Complex64; 2] {
        let [[xx, xy], [_, yy]] = self.spread;
        let first = (1.0 + xx).sqrt();
        let aside = xy / first;
        let second = (1.0 + yy - aside * aside).sqrt();
        [first * x, aside * x + second * y]
    }

    /// The neighbours at ±u, in σ, for these places u; nothing where one of them is lost.
    fn pairs(&self, places: [[f64; 2]; DIRECTIONS]) -> [Option<Pair>; DIRECTIONS] {
        let starts = places.map(|u| {
            [1.0, -1.0].map(|sign| {
                let at = [0, 1].map(|a| self.start.carrier.at[a] + sign * self.start.sigma * u[a]);
                ChirpedStart {
                    carrier: source_carrier(self.source, self.hop.from, at),
                    sigma: self.start.sigma,
                }
            })
        });
        let all = Neighbour::all(starts.as_flattened(), self.hop, self.source);
        std::array::from_fn(|number| {
            let linear = self.linear(places[number]);
            let [Some(plus), Some(minus)] = &all.as_chunks::<2>().0[number] else {
                return None;
            };
            let [plus, minus] = [plus, minus].map(|one| {
                let amplitude = (one.amplitude / self.own.amplitude).ln();
                (amplitude, self.quotient(one).ln() - amplitude - linear)
            });
            let parts = |a: Complex64, b: Complex64| [0.5 * (a + b), 0.5 * (a - b)];
            Some(Pair {
                amplitude: parts(plus.0, minus.0),
                exponent: parts(plus.1, minus.1),
            })
        })
    }

    /// The exponent of the weight at u, in σ: −½uᵀ(1 + iβ)⁻¹u.
    fn linear(&self, [x, y]: [f64; 2]) -> Complex64 {
        let [[xx, xy], [_, yy]] = self.spread;
        let (xx, yy) = (1.0 + xx, 1.0 + yy);
        -0.5 * (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy)
    }

    /// The value of a neighbour over that of the beamlet in the middle, where the latter lands.
    fn quotient(&self, one: &Neighbour) -> Complex64 {
        let k = self.hop.wavenumber();
        let [x, y] = [0, 1].map(|a| self.own.arrival.at[a] - one.arrival.at[a]);
        let ([p, q], [xx, xy, yy]) = (one.arrival.cosines, one.arrival.curvature);
        let phase = p * x + q * y + 0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y);
        one.arrival.amplitude * (Complex64::I * k * phase).exp() / self.own.arrival.amplitude
    }
}

impl Neighbour {
    /// The beamlets of some starts; nothing where a ray is lost or there is no light. Those of one curvature go together.
    fn all(starts: &[ChirpedStart], hop: &Hop, source: &Source) -> Vec<Option<Self>> {
        let k = hop.wavenumber();
        let ray = |start: &ChirpedStart| {
            let ([x, y], [p, q]) = (start.carrier.at, start.carrier.p);
            [x, y, p, q]
        };
        let alike = |a: &ChirpedStart, b: &ChirpedStart| a.carrier.q == b.carrier.q;
        let groups = starts.chunk_by(alike).flat_map(|group| {
            let rays: Vec<RayStart> = group.iter().map(ray).collect();
            hop.carry_all_along(group[0].curvature(k), &rays)
        });
        let lit = |(start, carried): (&ChirpedStart, Result<Carried, Loss>)| {
            let carried = carried.ok()?;
            let field = source_field(source, hop.from, start.carrier.at, k);
            let mut arrival = carried.arrival(k);
            arrival.amplitude *= field;
            (field.norm_sqr() > 0.0).then_some(Self {
                arrival,
                amplitude: carried.amplitude.value() * field.norm(),
            })
        };
        starts.iter().zip(groups).map(lit).collect()
    }
}

/// A direction of the circle.
fn direction(number: usize) -> [f64; 2] {
    let angle = PI * number as f64 / DIRECTIONS as f64;
    [angle.cos(), angle.sin()]
}

/// The moments of the weight for terms that are known at this part of σ.
fn moments(part: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| MOMENTS[i] / part.powi(2 * (i as i32 + 1)))
}

/// A polynomial of one order, from its values along the directions, at a complex place: rⁿe^{ihφ} is a product of powers of
/// x + iy and x − iy.
fn polynomial(values: &[Complex64; DIRECTIONS], order: usize, [x, y]: [Complex64; 2]) -> Complex64 {
    let (left, right) = (x + Complex64::I * y, x - Complex64::I * y);
    let term = |power: usize| {
        let h = 2.0 * power as f64 - order as f64;
        let turned = values.iter().enumerate().map(|(number, value)| {
            value * Complex64::cis(-h * PI * number as f64 / DIRECTIONS as f64)
        });
        turned.sum::<Complex64>() / DIRECTIONS as f64
            * left.powu(power as u32)
            * right.powu((order - power) as u32)
    };
    (0..=order).map(term).sum()
}

/// iβ of beamlets about a carrier, from the Jacobian of rays; nothing at a focus.
fn spread(start: &ChirpedStart, j: &[[f64; 4]; 4], k: f64) -> Option<[[Complex64; 2]; 2]> {
    let [xx, xy, yy] = start.carrier.q;
    let q = [[xx, xy], [xy, yy]];
    let place = |a: usize, b: usize| j[a][b] + j[a][2] * q[0][b] + j[a][3] * q[1][b];
    let determinant = place(0, 0) * place(1, 1) - place(0, 1) * place(1, 0);
    let scale = 1.0 / (k * start.sigma * start.sigma * determinant);
    let row = |a: usize, b: usize| match a {
        0 => scale * (place(1, 1) * j[0][2 + b] - place(0, 1) * j[1][2 + b]),
        _ => scale * (place(0, 0) * j[1][2 + b] - place(1, 0) * j[0][2 + b]),
    };
    let spread = [0, 1].map(|a| [0, 1].map(|b| Complex64::new(0.0, row(a, b))));
    (spread.as_flattened().iter().all(|b| b.is_finite())).then_some(spread)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::local_bands::carry::carry;
    use crate::engine::local_bands::settings::LocalBandSettings;
    use crate::fixtures::parts::{conic, face, on_axis, plane_wave, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;
    use crate::optics::source::Source;
    use crate::optics::system::System;

    const INDEX: f64 = 1.5;
    const RADIUS: f64 = 10.0;
    const DEPTH: f64 = 12.0;

    /// Collimated light that an ellipsoid gathers in one point, inside the glass: the field on the axis before that point
    /// with windows of a width, over its closed form. A face passes all power, |U|² times the index.
    fn on_the_axis(sigma: f64, corrected: bool) -> Complex64 {
        let ellipsoid = conic(1.0 / RADIUS, -1.0 / INDEX.powi(2));
        let mut last = screen(on_axis(1.0 + DEPTH), sensor(1, 1e-3));
        last.index = INDEX;
        let system = System {
            wavelength: 0.5e-3,
            source: plane_wave([0.0; 2]),
            screens: vec![
                screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(3.0))),
                last,
            ],
            trains: vec![vec![face(on_axis(1.0), ellipsoid, [1.0, INDEX])]],
        };
        let settings = LocalBandSettings {
            corrected,
            threshold: 1e-6,
            ..LocalBandSettings::new(vec![sigma])
        };
        let focus = RADIUS * INDEX / (INDEX - 1.0);
        let path = 1.0 + INDEX * DEPTH;
        let strength = focus / (focus - DEPTH) / INDEX.sqrt();
        let exact = Complex64::cis(system.wavenumber() * path) * strength;
        carry(&system, &settings).unwrap().field.values[[0, 0]] / exact
    }

    /// Light of a point 6 mm before the first screen, on a tilted sensor 4 mm behind it: the relative error against its closed
    /// form.
    fn on_a_slope(sigma: f64, corrected: bool) -> f64 {
        let system = System {
            wavelength: 0.5e-3,
            source: Source::point([0.0, 0.0, -6.0], Vec3::new(0.0, 0.0, 0.0)),
            screens: vec![
                screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.0))),
                screen(on_axis(4.0).tilted([0.0, 0.6, 0.0]), sensor(16, 0.02)),
            ],
            trains: vec![Vec::new()],
        };
        let settings = LocalBandSettings {
            corrected,
            threshold: 1e-6,
            ..LocalBandSettings::new(vec![sigma])
        };
        let field = carry(&system, &settings).unwrap().field;
        let [mut off, mut all] = [0.0; 2];
        for ((j, i), value) in field.values.indexed_iter() {
            let [x, y] = [i, j].map(|n| (n as f64 - 7.5) * 0.02);
            let point = system.screens[1].frame.to_global(Vec3::new(x, y, 0.0));
            let exact = system.source.field(point, system.wavenumber());
            off += (value - exact).norm_sqr();
            all += exact.norm_sqr();
        }
        (off / all).sqrt()
    }

    #[test]
    fn gathered_light_has_the_right_strength_at_any_width() {
        for sigma in [0.1, 0.2] {
            let [plain, corrected] = [false, true].map(|corrected| {
                let change = on_the_axis(sigma, corrected) - 1.0;
                change.re.abs()
            });
            assert!(plain > 0.015 * sigma * sigma, "{sigma}: {plain:e}");
            assert!(corrected < 1.5e-5, "{sigma}: {corrected:e}");
        }
    }

    #[test]
    fn a_points_light_is_right_on_a_sloping_sensor() {
        for sigma in [0.02, 0.03, 0.04] {
            let [plain, corrected] = [false, true].map(|on| on_a_slope(sigma, on));
            assert!(plain > 1e-4, "{sigma}: {plain:e}");
            assert!(corrected < 5e-5, "{sigma}: {corrected:e}");
        }
    }
}
