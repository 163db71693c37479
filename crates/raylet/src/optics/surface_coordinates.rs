//! A curved surface's own coordinates: lengths along it instead of their projections.
//!
//! On a surface of revolution the radius r becomes the length s(r) of the meridian from the vertex, and the
//! azimuth stays; on a cylinder the coordinate along the curve becomes the length of the curve from the
//! vertex line, and the other stays. Other surfaces have no such natural coordinates.

use std::num::NonZero;

use crate::optics::shape::Shape;

/// The way from a surface's local (x, y) to its own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceCoordinates {
    shape: Shape,
    along: MeasuredAlong,
    /// Nodes on [−1, 1] and weights of Gauss's rule.
    rule: Vec<[f64; 2]>,
}

/// Along what lengths are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MeasuredAlong {
    /// Meridians.
    Radius,
    /// The curve over x.
    X,
    /// The curve over y.
    Y,
}

/// Gauss nodes of a panel of the integral over the curve, and panels.
const NODES: NonZero<usize> = NonZero::<usize>::MIN.saturating_add(15);
const PANELS: usize = 2;

/// Steps from own coordinates to a point.
const NEWTON_STEPS: usize = 8;

impl SurfaceCoordinates {
    /// The own coordinates of a surface of revolution or a cylinder; nothing for others.
    pub fn of(shape: &Shape) -> Option<Self> {
        let along = match shape {
            Shape::Biconic(biconic) if biconic.y.curvature == 0.0 => MeasuredAlong::X,
            Shape::Biconic(biconic) if biconic.x.curvature == 0.0 => MeasuredAlong::Y,
            Shape::Toroid(toroid) if toroid.rotation == 0.0 => MeasuredAlong::Y,
            Shape::Toroid(toroid)
                if toroid.curve.curvature == 0.0
                    && toroid.coefficients.iter().all(|a| *a == 0.0) =>
            {
                MeasuredAlong::X
            }
            round if round.is_round() => MeasuredAlong::Radius,
            _ => return None,
        };
        let rule = gauss_quad::GaussLegendre::new(NODES);
        Some(Self {
            shape: shape.clone(),
            along,
            rule: rule.into_iter().map(|(t, w)| [t, w]).collect(),
        })
    }

    /// The own coordinates (X, Y) in mm of the point above (x, y); nothing where the surface does not exist.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        match self.along {
            MeasuredAlong::X => Some([self.length(x)?, y]),
            MeasuredAlong::Y => Some([x, self.length(y)?]),
            MeasuredAlong::Radius => {
                let r = x.hypot(y);
                if r == 0.0 {
                    return Some([0.0; 2]);
                }
                let stretch = self.length(r)? / r;
                Some([x * stretch, y * stretch])
            }
        }
    }

    /// ∂(X, Y)/∂(x, y) by rows; nothing where the surface does not exist.
    pub(crate) fn derivative(&self, [x, y]: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        match self.along {
            MeasuredAlong::X => Some([[self.rate(x)?, 0.0], [0.0, 1.0]]),
            MeasuredAlong::Y => Some([[1.0, 0.0], [0.0, self.rate(y)?]]),
            MeasuredAlong::Radius => {
                let r = x.hypot(y);
                if r == 0.0 {
                    return Some([[1.0, 0.0], [0.0, 1.0]]);
                }
                let across = self.length(r)? / r;
                let excess = (self.rate(r)? - across) / (r * r);
                Some([
                    [across + excess * x * x, excess * x * y],
                    [excess * x * y, across + excess * y * y],
                ])
            }
        }
    }

    /// The second derivatives (xx, xy, yy) of X and of Y; nothing where the surface does not exist.
    pub(crate) fn second_derivative(&self, [x, y]: [f64; 2]) -> Option<[[f64; 3]; 2]> {
        let none = [0.0; 3];
        match self.along {
            MeasuredAlong::X => Some([[self.bend(x)?, 0.0, 0.0], none]),
            MeasuredAlong::Y => Some([none, [0.0, 0.0, self.bend(y)?]]),
            MeasuredAlong::Radius => {
                let r = x.hypot(y);
                if r == 0.0 {
                    return Some([none; 2]);
                }
                // X = x g with g = s/r; h = g′/r and e = h′/r.
                let h = (self.rate(r)? - self.length(r)? / r) / (r * r);
                let e = (self.bend(r)? / r - 3.0 * h) / (r * r);
                let own = |a: f64, b: f64| {
                    [
                        3.0 * a * h + a.powi(3) * e,
                        b * h + a * a * b * e,
                        a * h + a * b * b * e,
                    ]
                };
                let [yy, yx, xx] = own(y, x);
                Some([own(x, y), [xx, yx, yy]])
            }
        }
    }

    /// The point (x, y) in mm with these own coordinates, by Newton's method; nothing where there is none.
    pub(crate) fn point_at(&self, own: [f64; 2]) -> Option<[f64; 2]> {
        let mut at = own;
        for _ in 0..NEWTON_STEPS {
            let ([u, v], [[ux, uy], [vx, vy]]) = (self.at(at)?, self.derivative(at)?);
            let (du, dv) = (own[0] - u, own[1] - v);
            let determinant = ux * vy - uy * vx;
            at[0] += (vy * du - uy * dv) / determinant;
            at[1] += (ux * dv - vx * du) / determinant;
        }
        Some(at)
    }

    /// d²s/dt² of the curve.
    fn bend(&self, t: f64) -> Option<f64> {
        let (slope, curvature) = match self.along {
            MeasuredAlong::Y => {
                let height = self.shape.height(0.0, t)?;
                (height.slope[1], height.hessian[2])
            }
            MeasuredAlong::X | MeasuredAlong::Radius => {
                let height = self.shape.height(t, 0.0)?;
                (height.slope[0], height.hessian[0])
            }
        };
        Some(slope * curvature / 1.0f64.hypot(slope))
    }

    /// ds/dt = √(1 + z′²) of the curve.
    fn rate(&self, t: f64) -> Option<f64> {
        let slope = match self.along {
            MeasuredAlong::Y => self.shape.height(0.0, t)?.slope[1],
            MeasuredAlong::X | MeasuredAlong::Radius => self.shape.height(t, 0.0)?.slope[0],
        };
        Some(1.0f64.hypot(slope))
    }

    /// Length of the curve from the vertex, with the sign of t.
    fn length(&self, t: f64) -> Option<f64> {
        // A circle's is known, up to its rim.
        if let Some(c) = self.circle() {
            return ((c * t).abs() < 1.0).then(|| if c == 0.0 { t } else { (c * t).asin() / c });
        }
        let half = 0.5 * t / PANELS as f64;
        let mut sum = 0.0;
        for panel in 0..PANELS {
            let middle = (2 * panel + 1) as f64 * half;
            for [node, weight] in &self.rule {
                sum += weight * self.rate(middle + half * node)?;
            }
        }
        Some(sum * half)
    }

    /// The curvature of the curve where it is a circle or a line.
    fn circle(&self) -> Option<f64> {
        let conic = match (&self.shape, self.along) {
            (Shape::Plane, _) => return Some(0.0),
            (Shape::Conic(conic), _) => conic,
            (Shape::Biconic(biconic), MeasuredAlong::X) => &biconic.x,
            (Shape::Biconic(biconic), MeasuredAlong::Y) => &biconic.y,
            (Shape::Toroid(toroid), MeasuredAlong::X) => return Some(toroid.rotation),
            _ => return None,
        };
        (conic.conic == 0.0 || conic.curvature == 0.0).then_some(conic.curvature)
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::conic::Conic;
    use crate::optics::freeform::Term;
    use crate::optics::shape::Shape;
    use crate::optics::surface_coordinates::SurfaceCoordinates;
    use crate::optics::toric::{Biconic, Toroid};

    fn conic(curvature: f64, conic: f64) -> Conic {
        Conic { curvature, conic }
    }

    fn shapes() -> [Shape; 5] {
        [
            Shape::Conic(conic(0.02, 0.0)),
            Shape::Asphere {
                base: conic(-0.03, -0.6),
                coefficients: vec![1e-6, -2e-9],
            },
            Shape::Biconic(Biconic {
                x: conic(0.03, 0.0),
                y: conic(0.0, 0.0),
            }),
            Shape::Toroid(Toroid {
                rotation: 0.0,
                curve: conic(0.03, -1.2),
                coefficients: vec![2e-6],
            }),
            Shape::Plane,
        ]
    }

    /// A sphere's meridian is an angle times its radius; a parabola's length has a closed form.
    #[test]
    fn lengths_have_their_closed_forms() {
        let sphere = SurfaceCoordinates::of(&Shape::Conic(conic(-1.0 / 50.0, 0.0))).unwrap();
        let [x, y] = sphere.at([18.0, -24.0]).unwrap();
        let arc = 50.0 * (30.0f64 / 50.0).asin();
        assert!((x - 0.6 * arc).abs() < 1e-13 && (y + 0.8 * arc).abs() < 1e-13);
        assert!(sphere.at([40.0, 31.0]).is_none());

        let parabola = SurfaceCoordinates::of(&Shape::Conic(conic(1.0 / 20.0, -1.0))).unwrap();
        let t = 9.0 / 20.0f64;
        let length = 0.5 * 20.0 * (t * (1.0 + t * t).sqrt() + t.asinh());
        let [x, y] = parabola.at([0.0, 9.0]).unwrap();
        assert!(x == 0.0 && (y - length).abs() < 1e-12, "{y} {length}");
    }

    /// Walking along the surface in short steps, straight up the slope or around.
    #[test]
    fn derivatives_match_differences_and_lengths() {
        let h = 1e-5;
        for shape in shapes() {
            let coordinates = SurfaceCoordinates::of(&shape).unwrap();
            for [x, y] in [[3.0, -4.0], [0.0, 7.0], [-6.0, 0.5]] {
                let d = coordinates.derivative([x, y]).unwrap();
                let by = |dx: f64, dy: f64| {
                    let [a, b] =
                        [1.0, -1.0].map(|s| coordinates.at([x + s * dx, y + s * dy]).unwrap());
                    [0, 1].map(|c| (a[c] - b[c]) / (2.0 * h))
                };
                let (along_x, along_y) = (by(h, 0.0), by(0.0, h));
                for c in 0..2 {
                    assert!((d[c][0] - along_x[c]).abs() < 1e-8, "{shape:?}");
                    assert!((d[c][1] - along_y[c]).abs() < 1e-8, "{shape:?}");
                }
                let bend = coordinates.second_derivative([x, y]).unwrap();
                let rows = |dx: f64, dy: f64| coordinates.derivative([x + dx, y + dy]).unwrap();
                let (after, before, above, below) =
                    (rows(h, 0.0), rows(-h, 0.0), rows(0.0, h), rows(0.0, -h));
                for c in 0..2 {
                    let found = [
                        after[c][0] - before[c][0],
                        above[c][0] - below[c][0],
                        above[c][1] - below[c][1],
                    ];
                    for (ours, twice) in bend[c].iter().zip(found) {
                        assert!((ours - twice / (2.0 * h)).abs() < 1e-8, "{shape:?}");
                    }
                }
                let back = coordinates
                    .point_at(coordinates.at([x, y]).unwrap())
                    .unwrap();
                assert!((back[0] - x).hypot(back[1] - y) < 1e-12, "{shape:?}");
                // Along the steepest slope lengths are those on the surface itself.
                let [sx, sy] = shape.height(x, y).unwrap().slope;
                let steep = sx.hypot(sy);
                if steep > 0.0 {
                    let step = [sx / steep, sy / steep];
                    let own = [0, 1].map(|c| d[c][0] * step[0] + d[c][1] * step[1]);
                    assert!((own[0].hypot(own[1]) - 1.0f64.hypot(steep)).abs() < 1e-9);
                }
            }
        }
    }

    /// Surfaces that bend along both axes and are not round.
    #[test]
    fn other_surfaces_are_refused() {
        let base = conic(0.02, 0.0);
        let freeform = |term| Shape::Freeform {
            base,
            terms: vec![term],
        };
        let others = [
            Shape::Biconic(Biconic {
                x: base,
                y: conic(-0.02, 0.0),
            }),
            Shape::Toroid(Toroid {
                rotation: 0.03,
                curve: base,
                coefficients: vec![],
            }),
            freeform(Term::Polynomial {
                radius: 1.0,
                terms: vec![([2, 0], 1e-3)],
            }),
            freeform(Term::Gaussian {
                height: 0.1,
                centre: [1.0, 0.0],
                sigma: 2.0,
            }),
        ];
        for other in others {
            assert_eq!(SurfaceCoordinates::of(&other), None, "{other:?}");
        }
        // The same base under powers of the radius is round.
        let round = freeform(Term::Powers(vec![0.0, 1e-3]));
        assert!(SurfaceCoordinates::of(&round).is_some());
    }
}
