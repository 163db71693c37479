//! A ray with its ray tube through a whole system of smooth elements: the generalised law of refraction.
//!
//! At an element of smooth phase φ a ray goes on as p_out = p_in + ∇φ/k along the element's plane (the
//! grating equation, conical incidence included), and φ/k adds to its optical path. The tube's width and
//! the line foci it passes come from the ray's exact derivatives.

use crate::engine::trace::ray_trace::Landing;
use crate::math::real::{Dual, Real};
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::deflection::transmitted;
use crate::optics::frame::Axes;
use crate::optics::ray::Loss;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::{Companion, Encounter};

/// Tangents along the start (x, y) and along a change of the starting direction (p_x, p_y).
type Number = Dual<4>;

/// A ray at the sensor, with its tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayTube {
    /// Position in the sensor's plane, in mm.
    pub at: [f64; 2],
    /// Optical direction cosines along the sensor's axes.
    pub cosines: [f64; 2],
    /// Optical path from the first screen in mm, the elements' φ/k included.
    pub path: f64,
    /// Modulus of the field here over that of the incident field at the start.
    pub amplitude: f64,
    /// Line foci passed; flights backwards count theirs negative.
    pub foci: i32,
    /// ∂s/∂x: the tube's width here over its width at the start, rows s.
    pub spread: [[f64; 2]; 2],
    /// ∂s/∂p, p the direction behind the first screen, in mm.
    pub throw: [[f64; 2]; 2],
    /// ∂p′/∂x: how directions spread here, in 1/mm.
    pub turn: [[f64; 2]; 2],
    /// ∂p′/∂p.
    pub swing: [[f64; 2]; 2],
}

impl RayTube {
    /// Half width `half` of the pupil in Fresnel zones of this ray, N = a²/(λ|M⁻¹B|): geometrical optics
    /// holds for N ≫ 1 and fails where N falls to one, at caustics and foci.
    pub(crate) fn fresnel_number(&self, half: f64, wavelength: f64) -> f64 {
        let Some(inverse) = inverse(self.spread) else {
            return 0.0;
        };
        let zone = product(inverse, self.throw);
        let (low, high) = eigenvalues(zone);
        half * half / (wavelength * low.abs().max(high.abs()))
    }
}

/// The aperture of a screen.
pub(crate) fn aperture_of(screen: &Screen) -> Aperture {
    match &screen.kind {
        ScreenKind::Stop(aperture) => aperture.clone(),
        ScreenKind::Doe(doe) => doe.aperture.clone(),
        ScreenKind::Sensor(_) => Aperture::OPEN,
    }
}

/// The ray tube that starts at (x, y) on the first screen.
///
/// # Errors
/// How the ray was lost. Elements without a smooth phase lose it as evanescent; refuse them beforehand.
pub fn trace_tube(system: &System, start: [f64; 2]) -> Result<RayTube, Loss> {
    let (first, k) = (&system.screens[0], system.wavenumber());
    let mut at = [Number::variable(start[0], 0), Dual::variable(start[1], 1)];
    let zero = Number::constant(0.0);

    // The incident direction, as a function of the place.
    let point = first.frame.to_global(Vec3::new(at[0], at[1], zero));
    let incident = first
        .frame
        .direction_to_local(system.source.direction(point));
    let mut p = [incident.x * first.index, incident.y * first.index];

    let (mut path, mut flux) = (0.0, 1.0);
    let mut tube_rays = TubeRays::default();
    for (number, hop) in system.hops().enumerate() {
        // The element bends the ray and lengthens its path.
        let [here, arriving] = [at, p].map(|pair| pair.map(|v| v.value));
        if !aperture_of(hop.from).contains(here[0], here[1]) {
            return Err(Loss::Clipped);
        }
        flux *= transmitted(hop.from, &hop.from.shape, here, arriving)?.powi(2);
        path += deflect(hop.from, at, &mut p, k)?;
        if number == 0 {
            p = std::array::from_fn(|a| p[a] + Number::variable(0.0, 2 + a));
        }

        // The train; |U|² n cos dA is the same at both ends but for what the surfaces take.
        tube_rays.last = None;
        let landing = hop.trace(at, p, &mut tube_rays)?;
        flux *= normal(&hop, p.map(|p| p.value)) / normal_at(&hop, &landing);
        path += landing.path.value;
        (at, p) = (landing.at, landing.cosines);
    }
    let spread = at.map(|s| [s.tangent[0], s.tangent[1]]);
    let power = flux * tube_rays.transmission.powi(2);
    Ok(RayTube {
        at: at.map(|s| s.value),
        cosines: p.map(|p| p.value),
        path,
        amplitude: (power / determinant(spread).abs()).sqrt(),
        foci: tube_rays.foci,
        spread,
        throw: at.map(|s| [s.tangent[2], s.tangent[3]]),
        turn: p.map(|p| [p.tangent[0], p.tangent[1]]),
        swing: p.map(|p| [p.tangent[2], p.tangent[3]]),
    })
}

/// Turns p by ∇φ/k and returns φ/k.
fn deflect(screen: &Screen, at: [Number; 2], p: &mut [Number; 2], k: f64) -> Result<f64, Loss> {
    let ScreenKind::Doe(doe) = &screen.kind else {
        return Ok(0.0);
    };
    let [x, y] = at.map(|v| v.value);
    let mut phase = 0.0;
    for profile in doe.profiles().ok_or(Loss::Evanescent)? {
        phase += profile.phase(x, y);
        let ([gx, gy], [xx, xy, yy]) = (profile.gradient(x, y), profile.hessian(x, y));
        let along = |value: f64, a: f64, b: f64| Dual {
            value: value / k,
            tangent: std::array::from_fn(|i| (a * at[0].tangent[i] + b * at[1].tangent[i]) / k),
        };
        *p = [p[0] + along(gx, xx, xy), p[1] + along(gy, xy, yy)];
    }
    Ok(phase / k)
}

/// n·(normal optical cosine) behind the first screen of a hop.
fn normal(hop: &Hop, [px, py]: [f64; 2]) -> f64 {
    (hop.from.index_behind().powi(2) - px * px - py * py).sqrt()
}

/// The same where the ray lands, before the screen.
fn normal_at(hop: &Hop, landing: &Landing<Number>) -> f64 {
    let [px, py] = landing.cosines.map(|p| p.value);
    (hop.to.index.powi(2) - px * px - py * py).sqrt()
}

/// What the neighbouring rays do: line foci between them, and what surfaces transmit beside an ideal
/// coating.
struct TubeRays {
    foci: i32,
    transmission: f64,
    last: Option<Vec3<Number>>,
    forwards: bool,
}

impl Default for TubeRays {
    fn default() -> Self {
        Self {
            foci: 0,
            transmission: 1.0,
            last: None,
            forwards: true,
        }
    }
}

impl Companion<Number> for TubeRays {
    fn fly(&mut self, length: Number, _index: Number) {
        self.forwards = length.value >= 0.0;
    }

    fn refract<A: Axes<Number>>(&mut self, encounter: &Encounter<Number, A>) {
        let refracted = encounter.refracted;
        let [before, after] = encounter.index.map(|n| n.value);
        let ideal = before * refracted.cosine_in.value / (after * refracted.cosine_out.value.abs());
        self.transmission *= refracted.transmission.value / ideal.sqrt();
    }

    fn visit(&mut self, point: Vec3<Number>) {
        if let Some(last) = self.last {
            let count = foci_between(last, point);
            self.foci += if self.forwards { count } else { -count };
        }
        self.last = Some(point);
    }
}

/// Line foci of a ray's neighbours on a straight flight: the zeros of det(M₀ + t(M₁ − M₀)), 0 < t < 1,
/// with M the tube's width across the ray.
fn foci_between(from: Vec3<Number>, to: Vec3<Number>) -> i32 {
    let flight = to.value() - from.value();
    if flight.norm() == 0.0 {
        return 0;
    }
    let along = flight.unit();
    let helper = if along.x.abs() < 0.5 {
        Vec3::new(1.0, 0.0, 0.0)
    } else {
        Vec3::new(0.0, 1.0, 0.0)
    };
    let across = along.cross(helper).unit();
    let axes = [across, along.cross(across)];
    let width = |point: Vec3<Number>| {
        axes.map(|axis| {
            [0, 1].map(|i| {
                let (x, y, z) = (point.x.tangent[i], point.y.tangent[i], point.z.tangent[i]);
                axis.dot(Vec3::new(x, y, z))
            })
        })
    };
    // Eigenvalues 1 + μ of M₀⁻¹M₁ that are negative have passed through zero.
    let (start, end) = (width(from), width(to));
    let Some(inverse) = inverse(start) else {
        return 0;
    };
    let (low, high) = eigenvalues(product(inverse, end));
    i32::from(low < 0.0) + i32::from(high < 0.0)
}

pub(crate) type Matrix = [[f64; 2]; 2];

pub(crate) fn determinant(m: Matrix) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

pub(crate) fn inverse(m: Matrix) -> Option<Matrix> {
    let d = determinant(m);
    let inverse = [[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]];
    inverse
        .iter()
        .flatten()
        .all(|v| v.is_finite())
        .then_some(inverse)
}

/// Positive less negative eigenvalues of −aᵀb, real for the matrices of ray tubes.
pub(crate) fn signature(a: Matrix, b: Matrix) -> i32 {
    let transposed = [[a[0][0], a[1][0]], [a[0][1], a[1][1]]];
    let (low, high) = eigenvalues(product(transposed, b));
    -(low.signum() + high.signum()) as i32
}

pub(crate) fn product(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// The eigenvalues, real for the matrices of ray tubes; rounding that would split a double one into a
/// complex pair is cut off.
fn eigenvalues(m: Matrix) -> (f64, f64) {
    let mean = 0.5 * (m[0][0] + m[1][1]);
    let half = 0.5 * (m[0][0] - m[1][1]);
    let gap = (half * half + m[0][1] * m[1][0]).max(0.0).sqrt();
    (mean - gap, mean + gap)
}

#[cfg(test)]
mod tests {
    use crate::engine::geometrical::ray_tube::trace_tube;
    use crate::fixtures::parts::{element, on_axis, plane_wave, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::source::Source;
    use crate::optics::surface::Surface;
    use crate::optics::system::System;

    const WAVELENGTH: f64 = 0.7e-3;
    const K: f64 = std::f64::consts::TAU / WAVELENGTH;

    /// Elements at these places, then a sensor.
    fn system(source: Source, elements: Vec<(f64, Profile)>, end: f64) -> System {
        let mut screens: Vec<Screen> = elements
            .into_iter()
            .map(|(z, profile)| {
                let doe = element(Layer::Phase(profile), Aperture::disc(12.7));
                screen(on_axis(z), ScreenKind::Doe(doe))
            })
            .collect();
        screens.push(screen(on_axis(end), sensor(1, 1.0)));
        System {
            wavelength: WAVELENGTH,
            source,
            trains: vec![vec![]; screens.len() - 1],
            screens,
        }
    }

    fn lens(focal_length: f64) -> Profile {
        Profile::Lens {
            focal_length,
            wavenumber: K,
        }
    }

    #[test]
    fn diffractive_lens_has_one_path_to_its_focus() {
        let system = system(plane_wave([0.0, 0.0]), vec![(0.0, lens(30.0))], 30.0);
        for (x, y) in [(0.0, 0.0), (1.0, -3.0), (-8.0, 9.0), (12.0, 0.5)] {
            let tube = trace_tube(&system, [x, y]).unwrap();
            assert!(tube.at[0].hypot(tube.at[1]) < 1e-12, "{tube:?}");
            assert!((tube.path - 30.0).abs() < 1e-12, "{tube:?}");
        }
    }

    #[test]
    fn grating_equation_is_exact_and_conical() {
        // Light from out of the grating's plane of dispersion, through two crossed gratings.
        let (a, b) = ([900.0, 0.0], [-300.0, 1500.0]);
        let gratings = vec![
            (0.0, Profile::Linear { gradient: a }),
            (4.0, Profile::Linear { gradient: b }),
        ];
        let system = system(plane_wave([-0.2, 0.35]), gratings, 9.0);
        let tube = trace_tube(&system, [0.3, -0.2]).unwrap();
        let p = [-0.2 + (a[0] + b[0]) / K, 0.35 + (a[1] + b[1]) / K];
        assert!((tube.cosines[0] - p[0]).abs() < 1e-15);
        assert!((tube.cosines[1] - p[1]).abs() < 1e-15);
        let middle = [-0.2 + a[0] / K, 0.35];
        let flight = |p: [f64; 2], z: f64| z / (1.0 - p[0] * p[0] - p[1] * p[1]).sqrt();
        for i in 0..2 {
            let start = [0.3, -0.2][i];
            let s = start + middle[i] * flight(middle, 4.0) + p[i] * flight(p, 5.0);
            assert!((tube.at[i] - s).abs() < 1e-14);
        }
        // A bundle of parallel rays keeps its width in the plane; only its obliquity changes.
        assert_eq!(tube.foci, 0);
        let obliquity = flight(p, 1.0) / flight([-0.2, 0.35], 1.0);
        let first = flight(middle, 1.0) / flight([-0.2, 0.35], 1.0);
        assert!(obliquity > first);
        assert!((tube.amplitude - 1.0).abs() < 1e-14);
    }

    #[test]
    fn tube_narrows_as_a_spherical_wave_does() {
        // Behind a diffractive lens the wave is spherical: amplitude ∝ cos/r at fixed start, with the
        // power of each tube kept, and two line foci are passed in its centre.
        for (z, foci) in [(10.0, 0), (29.0, 0), (31.0, 2), (75.0, 2)] {
            let system = system(plane_wave([0.0, 0.0]), vec![(0.0, lens(30.0))], z);
            let (x, y) = (4.0, -3.0);
            let tube = trace_tube(&system, [x, y]).unwrap();
            // Radii 30/cos before and |z − 30|/cos behind: |U| scales with their ratio.
            let expected = 30.0 / (z - 30.0).abs();
            assert!((tube.amplitude / expected - 1.0).abs() < 1e-12, "{tube:?}");
            assert_eq!(tube.foci, foci);
        }
    }

    #[test]
    fn spread_and_throw_are_the_derivatives_of_the_landing() {
        let radial = Profile::Radial {
            radius: 5.0,
            coefficients: vec![-300.0, 40.0, 7.0],
        };
        let source = Source::Point {
            position: Vec3::new(3.0, -1.0, -60.0),
            reference: Vec3::new(0.0, 0.0, 0.0),
        };
        let mut system = system(source, vec![(0.0, radial), (20.0, lens(45.0))], 60.0);
        system.trains[0].push(Surface {
            shape: Shape::Conic(Conic {
                curvature: 0.02,
                conic: -0.4,
            }),
            frame: Frame::GLOBAL
                .moved(Vec3::new(0.0, 0.0, 8.0))
                .tilted([0.1, 0.2, 0.0]),
            aperture: Aperture::OPEN,
            interface: Interface::Refract,
            coating: Coating::Fresnel,
            index: [1.0, 1.5],
        });
        for screen in &mut system.screens[1..] {
            screen.index = 1.5;
        }
        let h = 1e-5;
        let (start, tube) = ([1.0, 2.0], trace_tube(&system, [1.0, 2.0]).unwrap());
        for axis in 0..2 {
            let moved = |sign: f64| {
                let mut at = start;
                at[axis] += sign * h;
                trace_tube(&system, at).unwrap()
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            for row in 0..2 {
                let slope = (plus.at[row] - minus.at[row]) / (2.0 * h);
                assert!((tube.spread[row][axis] - slope).abs() < 1e-8);
            }
            // Malus and Dupin: the path grows by p′·ds less the incident wave's own p·dx.
            let incident = system.source.direction(Vec3::new(start[0], start[1], 0.0));
            let along = [incident.x, incident.y][axis];
            let path = (plus.path - minus.path) / (2.0 * h) + along;
            let work: f64 = (0..2).map(|i| tube.cosines[i] * tube.spread[i][axis]).sum();
            assert!((path - work).abs() < 1e-8, "{path} {work}");
        }
    }

    /// The grating and LA1131-A of the source paper's first problem: its spot, 2 mm inside the paraxial
    /// focus, was published at 160.30 µm.
    #[test]
    fn grating_and_lens_land_where_published() {
        let grating = Profile::Linear {
            gradient: [30.0, 0.0],
        };
        let source = Source::Point {
            position: Vec3::new(0.0, 0.0, -1e5),
            reference: Vec3::new(0.0, 0.0, 0.0),
        };
        let mut system = system(source, vec![(0.0, grating)], 53.0);
        let surface = |z: f64, curvature: f64, index: [f64; 2]| Surface {
            shape: Shape::Conic(Conic {
                curvature,
                conic: 0.0,
            }),
            frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
            aperture: Aperture::disc(12.7),
            interface: Interface::Refract,
            coating: Coating::Ideal,
            index,
        };
        system.trains[0] = vec![
            surface(3.0, 1.0 / 25.8, [1.0, 1.5131]),
            surface(8.3, 0.0, [1.5131, 1.0]),
        ];
        // Spherical aberration spreads the rays over ±160 µm; the peak is made by the zone whose sagittal
        // rays meet there. Its height on the pupil by bisection.
        let landing = |height: f64| trace_tube(&system, [0.0, height]).unwrap().at;
        let (mut low, mut high) = (6.0, 12.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if landing(middle)[1] > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let [x, y] = landing(low);
        assert!(
            y.abs() < 1e-12 && (x - 160.30e-3).abs() < 0.35e-3,
            "{low} {x}"
        );
    }
}
