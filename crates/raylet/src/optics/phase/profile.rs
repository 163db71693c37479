//! Analytic phase profiles of diffractive elements.
//!
//! A profile φ multiplies the field by exp(+iφ) and bends a ray by ∇φ/k in optical direction cosines.

use crate::math::jet::Jet;
use crate::math::real::{Dual, Real};
use crate::optics::phase::phase_grid::PhaseGrid;
use crate::optics::phase::placement::Placement;
use crate::optics::phase::radial_table::RadialTable;
use crate::optics::phase::two_point::TwoPoint;
use crate::optics::surface_coordinates::SurfaceCoordinates;
use crate::optics::zernike::ZernikeSum;

/// A smooth phase φ(x, y) in radians over the element's own plane, x and y in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// φ = gx·x + gy·y: a blazed grating of one order.
    Linear {
        /// Phase gradient in rad/mm.
        gradient: [f64; 2],
    },
    /// The ideal diffractive lens, φ = −k(√(r² + f²) − |f|)·sign f: equal optical path to its focus.
    Lens {
        /// Focal length in mm in the medium around the element; negative diverges.
        focal_length: f64,
        /// Wavenumber k = 2πn/λ it is made for, in rad/mm.
        wavenumber: f64,
    },
    /// φ = slope·r.
    Axicon {
        /// Radial phase gradient in rad/mm; negative bends towards the axis.
        slope: f64,
    },
    /// φ = charge·θ.
    Vortex {
        /// Topological charge.
        charge: i32,
    },
    /// φ = Σ aᵢ (r/ρ)^{2i+2}.
    Radial {
        /// Normalising radius ρ in mm.
        radius: f64,
        /// Coefficients in rad of (r/ρ)², (r/ρ)⁴, …
        coefficients: Vec<f64>,
    },
    /// A phase of the radius by samples.
    RadialTable(RadialTable),
    /// A phase by samples on a grid.
    Grid(PhaseGrid),
    /// φ = Σ aⱼ Zⱼ(x/ρ, y/ρ), coefficients in rad.
    Zernike(ZernikeSum),
    /// φ = Σ a (x/ρ)ⁱ (y/ρ)ʲ.
    Polynomial {
        /// Normalising radius ρ in mm.
        radius: f64,
        /// Exponents i and j with the coefficient a in rad.
        terms: Vec<([u32; 2], f64)>,
    },
    /// A hologram of two points.
    TwoPoint(TwoPoint),
    /// A phase whose own axes are off centre or turned.
    Placed(Placement, Box<Profile>),
    /// A phase on the own coordinates of a curved surface; zero where the surface does not exist.
    AlongSurface(Box<SurfaceCoordinates>, Box<Profile>),
}

impl Profile {
    /// The phase times a whole number: that of a diffraction order.
    pub fn times(&self, order: i32) -> Self {
        let m = f64::from(order);
        match self.clone() {
            Profile::Linear { gradient } => Profile::Linear {
                gradient: gradient.map(|g| m * g),
            },
            Profile::Lens {
                focal_length,
                wavenumber,
            } => Profile::Lens {
                focal_length,
                wavenumber: m * wavenumber,
            },
            Profile::Axicon { slope } => Profile::Axicon { slope: m * slope },
            Profile::Vortex { charge } => Profile::Vortex {
                charge: order.saturating_mul(charge),
            },
            Profile::Radial {
                radius,
                coefficients,
            } => Profile::Radial {
                radius,
                coefficients: coefficients.iter().map(|a| m * a).collect(),
            },
            Profile::RadialTable(table) => Profile::RadialTable(table.times(m)),
            Profile::Grid(grid) => Profile::Grid(grid.times(m)),
            Profile::Zernike(sum) => Profile::Zernike(sum.times(m)),
            Profile::Polynomial { radius, terms } => Profile::Polynomial {
                radius,
                terms: terms.iter().map(|(powers, a)| (*powers, m * a)).collect(),
            },
            Profile::TwoPoint(hologram) => Profile::TwoPoint(TwoPoint {
                order: m * hologram.order,
                ..hologram
            }),
            Profile::Placed(placement, own) => {
                Profile::Placed(placement, Box::new(own.times(order)))
            }
            Profile::AlongSurface(along, own) => {
                Profile::AlongSurface(along, Box::new(own.times(order)))
            }
        }
    }

    /// The phase on own axes that stand on the element as given.
    pub fn placed(self, placement: Placement) -> Self {
        match placement.is_none() {
            true => self,
            false => Self::Placed(placement, Box::new(self)),
        }
    }

    /// Where the phase is not smooth, if there is such a point.
    pub(crate) fn singular_point(&self) -> Option<[f64; 2]> {
        match self {
            Profile::Vortex { .. } | Profile::Axicon { .. } => Some([0.0; 2]),
            Profile::Placed(placement, own) => {
                let at = placement.vector_outwards(own.singular_point()?);
                Some([0, 1].map(|a| placement.centre[a] + at[a]))
            }
            Profile::AlongSurface(along, own) => along.point_at(own.singular_point()?),
            _ => None,
        }
    }

    /// The phase in radians.
    pub fn phase(&self, x: f64, y: f64) -> f64 {
        match self {
            Profile::Placed(placement, own) => {
                let [u, v] = placement.inwards(x, y);
                own.phase(u, v)
            }
            Profile::AlongSurface(along, own) => {
                along.at([x, y]).map_or(0.0, |[u, v]| own.phase(u, v))
            }
            Profile::Vortex { charge } => f64::from(*charge) * y.atan2(x),
            _ => self.smooth(x, y),
        }
    }

    /// The phase gradient in rad/mm; zero at the singular centre of a vortex or axicon.
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        match self {
            Profile::Placed(placement, own) => {
                let [u, v] = placement.inwards(x, y);
                placement.vector_outwards(own.gradient(u, v))
            }
            Profile::AlongSurface(along, own) => {
                gradient_along(along, own, [x, y]).unwrap_or([0.0; 2])
            }
            Profile::Vortex { charge } => {
                let square = x * x + y * y;
                let rate = if square > 0.0 {
                    f64::from(*charge) / square
                } else {
                    0.0
                };
                [-y * rate, x * rate]
            }
            Profile::Axicon { .. } if x == 0.0 && y == 0.0 => [0.0, 0.0],
            _ => {
                let phase = self.smooth(Dual::<2>::variable(x, 0), Dual::variable(y, 1));
                phase.tangent
            }
        }
    }

    /// The gradient at a point, or at the end of the way from the singular point through it that is this long if it is closer.
    pub(crate) fn gradient_beside(&self, [x, y]: [f64; 2], closest: f64) -> [f64; 2] {
        let Some([u, v]) = self.singular_point() else {
            return self.gradient(x, y);
        };
        let away = (x - u).hypot(y - v);
        let stretch = match away > 0.0 {
            true => (closest / away).max(1.0),
            false => 1.0,
        };
        self.gradient(u + stretch * (x - u), v + stretch * (y - v))
    }

    /// The charge of a vortex, if the phase is one.
    pub(crate) fn vortex_charge(&self) -> Option<i32> {
        match self {
            Profile::Vortex { charge } => Some(*charge),
            Profile::Placed(_, own) | Profile::AlongSurface(_, own) => own.vortex_charge(),
            _ => None,
        }
    }

    /// The second derivatives (xx, xy, yy) of the phase in rad/mm²; zero at the singular centre of a
    /// vortex or axicon.
    pub(crate) fn hessian(&self, x: f64, y: f64) -> [f64; 3] {
        let square = x * x + y * y;
        match self {
            Profile::Placed(placement, own) => {
                let [u, v] = placement.inwards(x, y);
                placement.matrix_outwards(own.hessian(u, v))
            }
            Profile::AlongSurface(along, own) => {
                hessian_along(along, own, [x, y]).unwrap_or([0.0; 3])
            }
            Profile::Vortex { .. } | Profile::Axicon { .. } if square == 0.0 => [0.0; 3],
            Profile::Vortex { charge } => {
                let rate = f64::from(*charge) / (square * square);
                [
                    2.0 * x * y * rate,
                    (y * y - x * x) * rate,
                    -2.0 * x * y * rate,
                ]
            }
            _ => {
                self.smooth(Jet::variable(x, 0), Jet::variable(y, 1))
                    .hessian
            }
        }
    }

    /// Every profile but the vortex, whose phase is no algebraic function, and those along a surface, which are integrals. Placed
    /// ones are no part of others.
    fn smooth<T: Real>(&self, x: T, y: T) -> T {
        match self {
            Profile::Linear { gradient: [gx, gy] } => x * *gx + y * *gy,
            Profile::Lens {
                focal_length: f,
                wavenumber,
            } => {
                // √(r²+f²) − |f| without cancellation.
                let square = x * x + y * y;
                let path = square / ((square + f * f).sqrt() + f.abs());
                path * (-wavenumber * f.signum())
            }
            Profile::Axicon { slope } => (x * x + y * y).sqrt() * *slope,
            Profile::Vortex { .. } | Profile::AlongSurface(..) => T::constant(0.0),
            Profile::Radial {
                radius,
                coefficients,
            } => {
                let u = (x * x + y * y) * (1.0 / (radius * radius));
                let horner = |sum: T, a: &f64| sum * u + *a;
                coefficients.iter().rev().fold(T::constant(0.0), horner) * u
            }
            Profile::RadialTable(table) => table.phase(x, y),
            Profile::Grid(grid) => grid.phase(x, y),
            Profile::Zernike(sum) => sum.at(x, y),
            Profile::Polynomial { radius, terms } => {
                let (x, y) = (x * (1.0 / radius), y * (1.0 / radius));
                let power = |base: T, i: u32| (0..i).fold(T::constant(1.0), |part, _| part * base);
                let add =
                    |sum: T, ([i, j], a): &([u32; 2], f64)| sum + power(x, *i) * power(y, *j) * *a;
                terms.iter().fold(T::constant(0.0), add)
            }
            Profile::TwoPoint(hologram) => hologram.phase(x, y),
            Profile::Placed(placement, own) => {
                let [u, v] = placement.inwards(x, y);
                own.smooth(u, v)
            }
        }
    }
}

/// The gradient over (x, y) of a phase on own coordinates; nothing where the surface does not exist.
fn gradient_along(along: &SurfaceCoordinates, own: &Profile, at: [f64; 2]) -> Option<[f64; 2]> {
    let [u, v] = along.at(at)?;
    let [[ux, uy], [vx, vy]] = along.derivative(at)?;
    let [gu, gv] = own.gradient(u, v);
    Some([gu * ux + gv * vx, gu * uy + gv * vy])
}

/// Its second derivatives (xx, xy, yy): those on the own coordinates, and the bend of these.
fn hessian_along(along: &SurfaceCoordinates, own: &Profile, at: [f64; 2]) -> Option<[f64; 3]> {
    let [u, v] = along.at(at)?;
    let rows = along.derivative(at)?;
    let [bend_u, bend_v] = along.second_derivative(at)?;
    let [gu, gv] = own.gradient(u, v);
    let [uu, uv, vv] = own.hessian(u, v);
    let column = |a: usize| [rows[0][a], rows[1][a]];
    let turned =
        |[a, b]: [f64; 2], [c, d]: [f64; 2]| uu * a * c + uv * (a * d + b * c) + vv * b * d;
    let plain = [
        turned(column(0), column(0)),
        turned(column(0), column(1)),
        turned(column(1), column(1)),
    ];
    Some([0, 1, 2].map(|i| plain[i] + gu * bend_u[i] + gv * bend_v[i]))
}

#[cfg(test)]
mod tests {
    use crate::fixtures::noise::noise;
    use crate::optics::conic::Conic;
    use crate::optics::phase::phase_grid::PhaseGrid;
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::phase::radial_table::RadialTable;
    use crate::optics::phase::two_point::{RecordedWave, TwoPoint};
    use crate::optics::shape::Shape;
    use crate::optics::surface_coordinates::SurfaceCoordinates;
    use crate::optics::toric::Biconic;
    use crate::optics::zernike::ZernikeSum;

    fn conic(curvature: f64, conic: f64) -> Conic {
        Conic { curvature, conic }
    }

    #[test]
    fn gradients_match_differences() {
        let placement = Placement {
            centre: [0.3, 0.7],
            rotation: 0.4,
        };
        let cubic = Profile::Polynomial {
            radius: 1.5,
            terms: vec![([3, 0], 20.0), ([1, 2], -7.0)],
        };
        let point = |at: [f64; 3]| RecordedWave::Point {
            at,
            converges: at[2] > 0.0,
        };
        let along = |shape: &Shape, own: Profile| {
            let coordinates = SurfaceCoordinates::of(shape).unwrap();
            Profile::AlongSurface(Box::new(coordinates), Box::new(own))
        };
        let cylinder = Shape::Biconic(Biconic {
            x: conic(0.3, -1.0),
            y: conic(0.0, 0.0),
        });
        let profiles = [
            cubic.clone(),
            Profile::Grid(PhaseGrid::new(&noise((8, 9), 1).mapv(|v| v.re), [0.3, 0.4]).unwrap()),
            Profile::RadialTable(
                RadialTable::new(&[0.0, 0.2, 0.5, 0.9, 1.3], &[0.0, 1.0, 4.0, 2.0, -3.0]).unwrap(),
            ),
            cubic.clone().placed(placement),
            along(&Shape::sphere(3.0), cubic.clone().placed(placement)),
            along(&cylinder, cubic),
            along(&Shape::sphere(-3.0), Profile::Vortex { charge: 2 }),
            Profile::Vortex { charge: 2 }.placed(placement),
            Profile::TwoPoint(TwoPoint {
                object: point([2.0, -1.0, 15.0]),
                reference: point([-5.0, 1.0, -30.0]),
                wavenumbers: [900.0, 700.0],
                order: 1.0,
                surface: (Shape::sphere(8.0), placement),
            }),
            Profile::Linear {
                gradient: [3.0, -2.0],
            },
            Profile::Lens {
                focal_length: -7.0,
                wavenumber: 900.0,
            },
            Profile::Axicon { slope: -4.0 },
            Profile::Vortex { charge: 3 },
            Profile::Radial {
                radius: 2.0,
                coefficients: vec![1.0, -0.5, 0.2],
            },
            Profile::Zernike(ZernikeSum::new(
                1.5,
                (1..=15).map(|j| 1.0 / f64::from(j)).collect(),
            )),
        ];
        let (x, y, h) = (0.4, -0.9, 1e-5);
        for profile in profiles {
            let [gx, gy] = profile.gradient(x, y);
            let dx = (profile.phase(x + h, y) - profile.phase(x - h, y)) / (2.0 * h);
            let dy = (profile.phase(x, y + h) - profile.phase(x, y - h)) / (2.0 * h);
            let scale = 1.0 + gx.hypot(gy);
            assert!((gx - dx).abs() < 1e-7 * scale, "{profile:?}");
            assert!((gy - dy).abs() < 1e-7 * scale, "{profile:?}");

            // An order has as many times the phase.
            let third = profile.times(-3).phase(x, y);
            assert!((third + 3.0 * profile.phase(x, y)).abs() < 1e-9);

            // Second derivatives against differences of the first.
            let along_x = (profile.gradient(x + h, y), profile.gradient(x - h, y));
            let along_y = (profile.gradient(x, y + h), profile.gradient(x, y - h));
            let expected = [
                (along_x.0[0] - along_x.1[0]) / (2.0 * h),
                (along_x.0[1] - along_x.1[1]) / (2.0 * h),
                (along_y.0[1] - along_y.1[1]) / (2.0 * h),
            ];
            for (ours, theirs) in profile.hessian(x, y).iter().zip(expected) {
                assert!((ours - theirs).abs() < 1e-7 * scale, "{profile:?}");
            }
        }
    }
}
