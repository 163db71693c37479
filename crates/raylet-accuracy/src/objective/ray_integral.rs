//! The field on the sensor of an objective with an element at its stop, by one integral over the stop.
//!
//! The collimated light on the stop is the geometrical field: the path of the one ray to each point, and an amplitude
//! by the area of its ray tube. Behind the element it is multiplied by the ray Green's function (Van Vleck) of the rear
//! group, (k/2πi)·√(q/q′)·|det ∂s/∂p|^{−1/2}·e^{ikL}. There is no caustic between the stop and the sensor. Rays to each
//! pixel are interpolated between 3 × 3 points of the sensor. Where the stop is the first screen, the light on it is
//! that of the source.
//!
//! Where the stop is a curved surface, or an interface, q is the optical direction against the normal of the surface
//! that belongs to unit area below it, q − p·∇s, on either side; det ∂s/∂p is taken with the slopes p + q∇s of the
//! waves along the surface. The interface keeps the power of the light that it refracts.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Doe;
use raylet::optics::screen::{ScreenKind, Sensor};
use raylet::optics::surface::Surface;
use raylet::optics::system::{Hop, System};

use crate::numerics::quadrature::gauss_legendre;

/// Nodes that are summed together.
const CHUNK: usize = 256;

/// Parts of a cell that an edge cuts, along each side.
const PARTS: usize = 8;

/// Newton steps of a ray that is to land at a point.
const STEPS: usize = 12;

/// Largest distance of a landing from its point, in mm.
const CLOSE: f64 = 1e-12;

/// A point of the stop with the transmission there times the area that it represents, in mm².
#[derive(Clone, Copy, Debug)]
pub struct StopNode {
    /// Place on the stop, (x, y) in mm.
    pub at: [f64; 2],
    /// Transmission times area.
    pub weight: Complex64,
    /// Side of the square about it over which the transmission is constant, in mm; zero for a point.
    pub width: f64,
}

/// Gauss nodes along the radius of a disc, equal ones around, with the element's transmission.
pub fn polar_nodes(doe: &Doe, radius: f64, [rings, spokes]: [usize; 2]) -> Vec<StopNode> {
    let turn = std::f64::consts::TAU;
    let mut nodes = Vec::with_capacity(rings * spokes);
    for (t, w) in gauss_legendre(rings) {
        let r = 0.5 * radius * (t + 1.0);
        let area = 0.5 * radius * w * r * turn / spokes as f64;
        for n in 0..spokes {
            let (s, c) = (turn * (n as f64 + 0.5) / spokes as f64).sin_cos();
            let at = [r * c, r * s];
            let weight = doe.transmission(at[0], at[1]) * area;
            let width = 0.0;
            nodes.push(StopNode { at, weight, width });
        }
    }
    nodes
}

/// The centres of square cells of a pitch in mm over the bounds of the aperture; none without an edge. Cells that the edge cuts
/// have parts, which count with the share of each that the aperture leaves: a whole cell would send this share from its middle,
/// which is wrong in directions in which light gains a phase across the cell.
pub fn cell_nodes(doe: &Doe, pitch: f64) -> Vec<StopNode> {
    let Some([x0, x1, y0, y1]) = doe.aperture.bounds() else {
        return Vec::new();
    };
    let places = |low: f64, high: f64| {
        let count = ((high - low) / pitch).round() as usize;
        let middle = 0.5 * (low + high);
        (0..count).map(move |i| middle + (i as f64 + 0.5 - 0.5 * count as f64) * pitch)
    };
    let cell = |[x, y]: [f64; 2], width: f64| {
        let half = 0.5 * width;
        let open = (doe.aperture).coverage(x - half, x + half, y - half, y + half);
        let weight = doe.transmission(x, y) * (open * width * width);
        let at = [x, y];
        (open, StopNode { at, weight, width })
    };
    let mut nodes = Vec::new();
    for y in places(y0, y1) {
        for x in places(x0, x1) {
            let (open, whole) = cell([x, y], pitch);
            match open {
                0.0 => {}
                1.0 => nodes.push(whole),
                _ => nodes.extend(parts(whole).map(|at| cell(at, pitch / PARTS as f64).1)),
            }
        }
    }
    nodes.retain(|node| node.weight != Complex64::ZERO);
    nodes
}

/// The centres of the parts of a cell.
fn parts(cell: StopNode) -> impl Iterator<Item = [f64; 2]> {
    let place = move |i: usize| ((i as f64 + 0.5) / PARTS as f64 - 0.5) * cell.width;
    let [x, y] = cell.at;
    (0..PARTS * PARTS).map(move |n| [x + place(n % PARTS), y + place(n / PARTS)])
}

/// The light at a point of the stop as it goes on to the sensor: optical path, amplitude, and rates of the path with
/// the place on the stop along x and y; at 3 × 3 points of the sensor, [y, x].
struct Spray {
    path: [[f64; 3]; 3],
    size: [[f64; 3]; 3],
    slope: [[[f64; 3]; 3]; 2],
}

/// A hop, and the same without the edges of its surfaces: no ray is lost on the way to its landing.
#[derive(Clone, Copy)]
struct HopPair<'a> {
    whole: Hop<'a>,
    open: Hop<'a>,
}

/// A point of the stop's surface, on one side of it.
#[derive(Clone, Copy)]
struct LocalSurface {
    slope: [f64; 2],
    /// The index on this side.
    index: f64,
    /// Whether light runs towards its +z or its −z.
    sense: f64,
}

impl LocalSurface {
    /// The cosine along z.
    fn along(&self, [px, py]: [f64; 2]) -> f64 {
        (self.index * self.index - px * px - py * py).sqrt() * self.sense
    }

    /// What a wave of unit amplitude carries through unit area below the surface: q − p·∇s.
    fn flux(&self, p: [f64; 2]) -> f64 {
        (self.along(p) - p[0] * self.slope[0] - p[1] * self.slope[1]).abs()
    }

    /// The same over det ∂(p + q∇s)/∂p = (q − p·∇s)/q.
    fn flux_over_slopes(&self, p: [f64; 2]) -> f64 {
        self.flux(p).powi(2) / self.along(p).abs()
    }
}

/// The hops to the stop, if there is one, and from it to the sensor.
struct Integral<'a> {
    system: &'a System,
    before: Option<HopPair<'a>>,
    after: HopPair<'a>,
}

/// The field at the pixels of a sensor behind an element at the stop, [y, x]; nothing where a ray is lost.
pub fn field(system: &System, nodes: &[StopNode]) -> Option<Array2<Complex64>> {
    let trains = opened(system);
    let integral = Integral::new(system, &trains)?;
    let sensor = integral.sensor()?;
    let parts: Option<Vec<Array2<Complex64>>> = nodes
        .par_chunks(CHUNK)
        .map(|nodes| integral.part(nodes, sensor))
        .collect();
    let dark = Array2::zeros((sensor.pixels[1], sensor.pixels[0]));
    Some(parts?.iter().fold(dark, |sum, part| sum + part))
}

/// Where on the sensor the ray lands that crosses the middle of the stop, where its optical direction cosines change by
/// a `kick`, whether or not an edge stops it on the way; nothing where it is lost otherwise.
pub fn chief_landing(system: &System, kick: [f64; 2]) -> Option<[f64; 2]> {
    let trains = opened(system);
    let integral = Integral::new(system, &trains)?;
    let (_, _, cosines) = integral.arriving([0.0; 2])?;
    let leaving = [cosines[0] + kick[0], cosines[1] + kick[1]];
    let landing = integral.after.open.trace([0.0; 2], leaving, &mut ());
    Some(landing.ok()?.at)
}

/// The trains of a system without the edges of their surfaces.
fn opened(system: &System) -> Vec<Vec<Surface>> {
    let open = |surface: &Surface| Surface {
        aperture: Aperture::OPEN,
        ..surface.clone()
    };
    let train = |train: &Vec<Surface>| train.iter().map(open).collect();
    system.trains.iter().map(train).collect()
}

impl<'a> Integral<'a> {
    /// Of a system of one or two hops.
    fn new(system: &'a System, trains: &'a [Vec<Surface>]) -> Option<Self> {
        let pairs = system.hops().zip(trains);
        let mut joined: Vec<HopPair> = pairs
            .map(|(whole, train)| HopPair {
                whole,
                open: Hop { train, ..whole },
            })
            .collect();
        let after = joined.pop()?;
        let before = joined.pop();
        joined.is_empty().then_some(Self {
            system,
            before,
            after,
        })
    }

    fn sensor(&self) -> Option<Sensor> {
        match self.after.whole.to.kind {
            ScreenKind::Sensor(sensor) => Some(sensor),
            ScreenKind::Stop(_) | ScreenKind::Doe(_) => None,
        }
    }

    /// What some nodes bring.
    fn part(&self, nodes: &[StopNode], sensor: Sensor) -> Option<Array2<Complex64>> {
        let k = self.system.wavenumber();
        let [nx, ny] = sensor.pixels;
        let mut total = Array2::zeros((ny, nx));
        for node in nodes {
            let spray = self.spray(node.at, sensor)?;
            for ((j, i), value) in total.indexed_iter_mut() {
                let place = |i: usize, n: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
                let (u, v) = (place(i, nx), place(j, ny));
                let mut size = between(&spray.size, u, v);
                if node.width > 0.0 {
                    for slope in &spray.slope {
                        size *= sinc(0.5 * k * node.width * between(slope, u, v));
                    }
                }
                *value += node.weight * Complex64::from_polar(size, k * between(&spray.path, u, v));
            }
        }
        Some(total * Complex64::new(0.0, -k / std::f64::consts::TAU))
    }

    /// The light from a point of the stop at points of the sensor.
    fn spray(&self, at: [f64; 2], sensor: Sensor) -> Option<Spray> {
        let (path, size, cosines) = self.arriving(at)?;
        let mut spray = Spray {
            path: [[0.0; 3]; 3],
            size: [[0.0; 3]; 3],
            slope: [[[0.0; 3]; 3]; 2],
        };
        let half = [0, 1].map(|a| 0.5 * sensor.pixels[a] as f64 * sensor.pitch[a]);
        let mut p = cosines;
        for j in 0..3 {
            for i in 0..3 {
                let to = [(i as f64 - 1.0) * half[0], (j as f64 - 1.0) * half[1]];
                let aimed = self.towards(at, p, to)?;
                p = aimed.leaving;
                let [leaves, lands] = [self.behind(at)?, self.at_sensor()];
                let ratio = leaves.flux_over_slopes(p) / lands.flux(aimed.landing);
                spray.path[j][i] = path + aimed.path;
                for (a, slope) in spray.slope.iter_mut().enumerate() {
                    slope[j][i] = cosines[a] - p[a];
                }
                spray.size[j][i] = size * (ratio / determinant(aimed.shift).abs()).sqrt();
            }
        }
        Some(spray)
    }

    /// The side of the stop at which light arrives.
    fn before(&self, at: [f64; 2]) -> Option<LocalSurface> {
        let stop = self.after.whole.from;
        Some(LocalSurface {
            slope: stop.height(at)?.slope,
            index: stop.index,
            sense: stop.arrives,
        })
    }

    /// The side of the stop from which light leaves.
    fn behind(&self, at: [f64; 2]) -> Option<LocalSurface> {
        let before = self.before(at)?;
        let index = self.after.whole.from.index_behind();
        Some(LocalSurface { index, ..before })
    }

    fn at_sensor(&self) -> LocalSurface {
        let sensor = self.after.whole.to;
        LocalSurface {
            slope: [0.0; 2],
            index: sensor.index,
            sense: sensor.arrives,
        }
    }

    /// Path, amplitude and cosines of the collimated light behind the stop's surface, without the element.
    fn arriving(&self, to: [f64; 2]) -> Option<(f64, f64, [f64; 2])> {
        let (path, size, p) = self.incident(to)?;
        let (before, behind) = (self.before(to)?, self.behind(to)?);
        if before.index == behind.index {
            return Some((path, size, p));
        }

        // Snell's law: the flux changes along the normal, by the difference of the squares of the indices.
        let [sx, sy] = before.slope;
        let steep = 1.0 + sx * sx + sy * sy;
        let flux = before.flux(p);
        let step = behind.index * behind.index - before.index * before.index;
        let refracted = (flux * flux + steep * step).sqrt();
        let change = before.sense * (refracted - flux) / steep;
        let p = [p[0] - sx * change, p[1] - sy * change];
        Some((path, size * (flux / refracted).sqrt(), p))
    }

    /// Path, amplitude and cosines of the collimated light where it meets a point of the stop.
    fn incident(&self, to: [f64; 2]) -> Option<(f64, f64, [f64; 2])> {
        let source = &self.system.source;
        let direction = source.direction(Vec3::new(0.0, 0.0, 0.0));
        let p = [direction.x, direction.y];
        let path = |hop: &Hop, [x, y]: [f64; 2]| {
            let z = hop.from.height([x, y]).map_or(0.0, |here| here.z);
            source.path(hop.from.frame.to_global(Vec3::new(x, y, z)), 1.0)
        };
        let Some(before) = &self.before else {
            return Some((path(&self.after.whole, to), 1.0, p));
        };
        let mut at = [0.0; 2];
        for _ in 0..STEPS {
            let (landing, j) = before.open.jacobian(at, p).ok()?;
            let slope = [[j[0][0], j[0][1]], [j[1][0], j[1][1]]];
            let gap = [to[0] - landing.at[0], to[1] - landing.at[1]];
            if gap[0].hypot(gap[1]) < CLOSE {
                before.whole.trace(at, p, &mut ()).ok()?;
                let ratio = cosine(p) / self.before(to)?.flux(landing.cosines);
                let size = (ratio / determinant(slope).abs()).sqrt();
                return Some((
                    path(&before.whole, at) + landing.path,
                    size,
                    landing.cosines,
                ));
            }
            at = moved(at, solved(slope, gap));
        }
        None
    }

    /// The ray from a point of the stop to one of the sensor, sought from a direction on.
    fn towards(&self, at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> Option<Aimed> {
        let mut p = from;
        for _ in 0..STEPS {
            let (landing, j) = self.after.open.jacobian(at, p).ok()?;
            let slope = [[j[0][2], j[0][3]], [j[1][2], j[1][3]]];
            let gap = [to[0] - landing.at[0], to[1] - landing.at[1]];
            if gap[0].hypot(gap[1]) < CLOSE {
                self.after.whole.trace(at, p, &mut ()).ok()?;
                return Some(Aimed {
                    leaving: p,
                    path: landing.path,
                    landing: landing.cosines,
                    shift: slope,
                });
            }
            p = moved(p, solved(slope, gap));
        }
        None
    }
}

/// A ray from a point of the stop that lands on a given point of the sensor.
struct Aimed {
    /// Its optical direction cosines at the stop.
    leaving: [f64; 2],
    /// Its optical path in mm.
    path: f64,
    /// Its optical direction cosines on the sensor.
    landing: [f64; 2],
    /// ∂s/∂p: how its landing moves with its direction at the stop, in mm.
    shift: [[f64; 2]; 2],
}

/// The parabolas through values at −1, 0, 1, along x and y.
fn between(values: &[[f64; 3]; 3], u: f64, v: f64) -> f64 {
    let line = |[low, middle, high]: [f64; 3], t: f64| {
        middle + 0.5 * t * (high - low) + 0.5 * t * t * (high + low - 2.0 * middle)
    };
    line(values.map(|row| line(row, u)), v)
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

fn cosine([p, q]: [f64; 2]) -> f64 {
    (1.0 - p * p - q * q).sqrt()
}

fn determinant([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    a * d - b * c
}

fn solved(m: [[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let [[a, b], [c, d]] = m;
    let scale = 1.0 / determinant(m);
    [(d * x - b * y) * scale, (a * y - c * x) * scale]
}

fn moved([x, y]: [f64; 2], [dx, dy]: [f64; 2]) -> [f64; 2] {
    [x + dx, y + dy]
}
