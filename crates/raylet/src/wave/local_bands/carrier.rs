//! The local carrier of a piece of light: the plane wave with curvature that runs along with it.
//!
//! What is left of the light beside its carrier changes slowly, so few samples hold it. A carrier is found from the
//! beamlets that arrive: their directions are a linear function of where they land. The curvature of a single beamlet
//! is not that of the light.

use num_complex::Complex64;

use crate::wave::beamlet::wavelet::Arrival;

/// The wave exp(ik[p·u + ½uᵀQu]), u = x − at, of a plane screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Carrier {
    /// The point about which it is written, in mm.
    pub at: [f64; 2],
    /// Its optical direction cosines there.
    pub p: [f64; 2],
    /// Its curvature Q in 1/mm: xx, xy, yy.
    pub q: [f64; 3],
}

/// How often a fit looks at beamlets farther away, and how much farther each time.
const WIDENINGS: usize = 6;
const WIDENING: f64 = 1.5;

/// Beamlets that a fit of a curvature needs at least, counted by their weights.
const FEWEST: f64 = 5.0;

/// The beamlets lie on a line when the determinant of their spread is below this share of its squared trace.
const SINGULAR: f64 = 1e-4;

impl Carrier {
    /// Its direction cosines p + Q(x − at) at another point.
    pub(crate) fn cosines(&self, x: [f64; 2]) -> [f64; 2] {
        let [u, v] = [x[0] - self.at[0], x[1] - self.at[1]];
        let [xx, xy, yy] = self.q;
        [self.p[0] + xx * u + xy * v, self.p[1] + xy * u + yy * v]
    }

    /// Its optical path p·u + ½uᵀQu at another point, in mm.
    pub(crate) fn path(&self, x: [f64; 2]) -> f64 {
        let [u, v] = [x[0] - self.at[0], x[1] - self.at[1]];
        let [xx, xy, yy] = self.q;
        self.p[0] * u + self.p[1] * v + 0.5 * (xx * u * u + yy * v * v) + xy * u * v
    }

    /// The same wave, but for its phase, written about another point.
    pub(crate) fn about(&self, at: [f64; 2]) -> Self {
        let p = self.cosines(at);
        Self { at, p, q: self.q }
    }

    /// This wave times another one about the same point.
    pub(crate) fn times(&self, p: [f64; 2], q: [f64; 3]) -> Self {
        Self {
            at: self.at,
            p: [self.p[0] + p[0], self.p[1] + p[1]],
            q: [self.q[0] + q[0], self.q[1] + q[1], self.q[2] + q[2]],
        }
    }

    /// How far its curvature differs from another one's, in 1/mm.
    pub(crate) fn curvature_change(&self, other: &Self) -> f64 {
        let [xx, xy, yy] = [0, 1, 2].map(|i| self.q[i] - other.q[i]);
        (xx * xx + 2.0 * xy * xy + yy * yy).sqrt()
    }

    /// Whether it is one everywhere.
    pub(crate) fn is_flat(&self) -> bool {
        self.p == [0.0; 2] && self.q == [0.0; 3]
    }

    /// The phase factor by which light at a point is divided by the carrier.
    pub(crate) fn removed(&self, x: [f64; 2], k: f64) -> Complex64 {
        Complex64::cis(-k * self.path(x))
    }

    /// A beamlet's direction beside the carrier's where it lands.
    pub(crate) fn departure(&self, arrival: &Arrival) -> [f64; 2] {
        let [p, q] = self.cosines(arrival.at);
        [arrival.cosines[0] - p, arrival.cosines[1] - q]
    }

    /// A beamlet divided by the carrier: a beamlet again, with directions and curvature beside those of the carrier.
    pub(crate) fn beside(&self, arrival: &Arrival, k: f64) -> Arrival {
        let [xx, xy, yy] = arrival.curvature;
        Arrival {
            at: arrival.at,
            cosines: self.departure(arrival),
            amplitude: arrival.amplitude * self.removed(arrival.at, k),
            curvature: [xx - self.q[0], xy - self.q[1], yy - self.q[2]],
        }
    }

    /// The carrier about a point of the light that beamlets bring, from those within some `radius` of it: linear
    /// regression of their directions on their places, weighted by energy. Where they are too few it looks farther
    /// away; where they lie on a line the carrier is plane. Nothing without light.
    pub(crate) fn fit(arrivals: &[Arrival], at: [f64; 2], radius: f64) -> Option<Self> {
        let mut radius = radius;
        let mut plane = None;
        for _ in 0..WIDENINGS {
            let sums = Regression::of(arrivals, at, radius);
            if let Some(found) = sums.carrier(at) {
                return Some(found);
            }
            plane = sums.plane(at).or(plane);
            radius *= WIDENING;
        }
        plane
    }
}

/// Weighted sums over beamlets: of one, their places and directions, and products of these.
#[derive(Default)]
struct Regression {
    weight: f64,
    squares: f64,
    place: [f64; 2],
    direction: [f64; 2],
    /// Of places with places: xx, xy, yy.
    spread: [f64; 3],
    /// Of places with directions, rows by place.
    slope: [[f64; 2]; 2],
}

impl Regression {
    fn of(arrivals: &[Arrival], at: [f64; 2], radius: f64) -> Self {
        let mut sums = Self::default();
        for arrival in arrivals {
            let d = [arrival.at[0] - at[0], arrival.at[1] - at[1]];
            let near = (-(d[0] * d[0] + d[1] * d[1]) / (radius * radius)).exp();
            let [xx, xy, yy] = arrival.curvature.map(|g| g.im);
            let weight = arrival.amplitude.norm_sqr() * near / (xx * yy - xy * xy).sqrt();
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            sums.weight += weight;
            sums.squares += weight * weight;
            for (a, d) in d.iter().enumerate() {
                sums.place[a] += weight * d;
                sums.direction[a] += weight * arrival.cosines[a];
                let slopes = sums.slope[a].iter_mut().zip(arrival.cosines);
                slopes.for_each(|(sum, p)| *sum += weight * d * p);
            }
            for (sum, (a, b)) in sums.spread.iter_mut().zip([(0, 0), (0, 1), (1, 1)]) {
                *sum += weight * d[a] * d[b];
            }
        }
        sums
    }

    /// The mean direction; nothing without light.
    fn plane(&self, at: [f64; 2]) -> Option<Carrier> {
        let p = self.direction.map(|sum| sum / self.weight);
        p.iter()
            .all(|p| p.is_finite())
            .then_some(Carrier { at, p, q: [0.0; 3] })
    }

    /// The linear fit; nothing where too few beamlets, or a line of them, leave it open.
    fn carrier(&self, at: [f64; 2]) -> Option<Carrier> {
        let plane = self.plane(at)?;
        let place = self.place.map(|sum| sum / self.weight);
        let about = |sum: f64, a: f64, b: f64| sum / self.weight - a * b;
        let xx = about(self.spread[0], place[0], place[0]);
        let xy = about(self.spread[1], place[0], place[1]);
        let yy = about(self.spread[2], place[1], place[1]);
        let determinant = xx * yy - xy * xy;
        let count = self.weight * self.weight / self.squares;
        if count < FEWEST || determinant <= SINGULAR * (xx + yy) * (xx + yy) {
            return None;
        }
        let row = |a: usize| {
            let [cx, cy] = [0, 1].map(|b| about(self.slope[b][a], place[b], plane.p[a]));
            [
                (yy * cx - xy * cy) / determinant,
                (xx * cy - xy * cx) / determinant,
            ]
        };
        let ([qxx, qxy], [qyx, qyy]) = (row(0), row(1));
        let q = [qxx, 0.5 * (qxy + qyx), qyy];
        let centred = Carrier { q, ..plane };
        let p = centred.cosines([at[0] - place[0], at[1] - place[1]]);
        Some(Carrier { p, ..centred })
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::local_bands::carrier::Carrier;

    fn beamlet(at: [f64; 2], cosines: [f64; 2]) -> Arrival {
        Arrival {
            at,
            cosines,
            amplitude: Complex64::new(0.7, -0.4),
            curvature: [
                Complex64::new(0.2, 0.03),
                Complex64::new(0.01, 0.0),
                Complex64::new(-0.1, 0.02),
            ],
        }
    }

    #[test]
    fn a_linear_field_of_directions_is_found_again() {
        let wave = Carrier {
            at: [0.3, -0.2],
            p: [0.11, -0.07],
            q: [-0.02, 0.005, 0.03],
        };
        let place = |i: usize| [0.1 * (i % 6) as f64, 0.13 * (i / 6) as f64 - 0.4];
        let all: Vec<Arrival> = (0..36)
            .map(|i| beamlet(place(i), wave.cosines(place(i))))
            .collect();
        let found = Carrier::fit(&all, wave.at, 0.2).unwrap();
        for (a, b) in found.p.iter().zip(wave.p) {
            assert!((a - b).abs() < 1e-14);
        }
        for (a, b) in found.q.iter().zip(wave.q) {
            assert!((a - b).abs() < 1e-12);
        }
        // A line of beamlets has no curvature across it.
        assert_eq!(Carrier::fit(&all[..6], wave.at, 0.2).unwrap().q, [0.0; 3]);
        assert_eq!(Carrier::fit(&[], wave.at, 0.2), None);
    }

    #[test]
    fn a_beamlet_beside_its_carrier_is_the_quotient() {
        let k = 900.0;
        let carrier = Carrier {
            at: [0.3, -0.2],
            p: [0.11, -0.07],
            q: [-0.02, 0.005, 0.03],
        };
        let arrival = beamlet([0.25, 0.1], [0.12, -0.05]);
        let value = |a: &Arrival, x: [f64; 2]| {
            let [u, v] = [x[0] - a.at[0], x[1] - a.at[1]];
            let [xx, xy, yy] = a.curvature;
            let bent = xx * (0.5 * u * u) + xy * (u * v) + yy * (0.5 * v * v);
            let phase = bent + a.cosines[0] * u + a.cosines[1] * v;
            a.amplitude * (Complex64::i() * k * phase).exp()
        };
        let beside = carrier.beside(&arrival, k);
        for x in [[0.2, 0.0], [0.5, 0.3]] {
            let quotient = value(&arrival, x) * carrier.removed(x, k);
            assert!((value(&beside, x) - quotient).norm() < 1e-11);
        }
    }
}
