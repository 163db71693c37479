//! One window about any point of a screen, and the plane waves of what lies under it.
//!
//! A transmission t under a window g about x₀, lit by a ray with optical direction cosines p₀ and wavefront
//! curvature K, is expanded in plane waves that leave from x₀ into the medium behind the screen,
//! g t e^{ik[p₀·u + q₀h + ½wᵀKw]} = Σₘ cₘ e^{ik[pₘ·u + qₘh]}, with h the height of the true surface over the
//! plane that touches it at x₀. The rates f = p + q∇s along the screen's local plane lie on a lattice of
//! spacing λ/P about the ray's own, so over the local plane only the curvature is left to transform; the
//! heights, small as they are, are separated from the modes by few levels.

use std::ops::Range;

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;
use raylet_matrix::product_of_three;

use crate::math::part::part;
use crate::math::vec3::Vec3;
use crate::optics::bundle::Hit;
use crate::optics::screen::Screen;
use crate::wave::grid::field::{Axis, Grid};
use crate::wave::grid::heights::{Heights, Stack};
use crate::wave::patches::patch::Band;

/// What a patch is cut out with, over the screen's local plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// exp(−u²/2σ²).
    Gaussian {
        /// σ in mm.
        sigma: f64,
    },
    /// One inside a square, nothing outside.
    Square {
        /// Its side in mm.
        side: f64,
    },
}

/// Gaussians are cut at this many σ, or at half the period.
const REACH: f64 = 4.5;

impl Window {
    /// The nodes of an axis under the window about a point, and its value at each; both axes multiply.
    pub(crate) fn on(&self, axis: &Axis, centre: f64, period: f64) -> (Range<usize>, Vec<f64>) {
        let half = match self {
            Window::Gaussian { sigma } => (0.5 * period).min(REACH * sigma),
            Window::Square { side } => 0.5 * side,
        };
        let range = axis.below(centre - half)..axis.below(centre + half);
        let value = |i: usize| match self {
            Window::Gaussian { sigma } => (-0.5 * ((axis.node(i) - centre) / sigma).powi(2)).exp(),
            Window::Square { .. } => 1.0,
        };
        let values = range.clone().map(value).collect();
        (range, values)
    }
}

/// What all local spectra of a screen share.
pub(crate) struct Emitter<'a> {
    /// The screen.
    pub screen: &'a Screen,
    /// The nodes on which its transmission is known.
    pub grid: &'a Grid,
    /// Its heights there; nothing on a plane.
    pub heights: Option<&'a Heights>,
    /// Whether a node is open: on a curved screen closed ones are left out.
    pub open: &'a Array2<bool>,
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// What patches are cut out with.
    pub window: Window,
    /// Period P of a patch in mm.
    pub period: f64,
    /// Directions to follow, as optical cosines on the screen's axes `[x_low, x_high, y_low, y_high]`.
    pub towards: [f64; 4],
}

/// A plane wave that leaves the light about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mode {
    /// Unit direction on the screen's axes.
    pub direction: Vec3,
    /// Cosine against the surface's normal, positive.
    pub cosine: f64,
}

/// One term of the sum of products that separates nodes from modes.
struct Separated {
    /// Factor of each node; nothing when it is one.
    nodes: Option<Array2<Complex64>>,
    /// Factor of each mode; nothing when it is one.
    modes: Option<Array2<Complex64>>,
}

/// The linear map from transmission to plane waves about one point.
pub(crate) struct LocalSpectrum {
    /// Its modes, indexed [m_y, m_x]; nothing where one does not propagate or is not to be followed.
    pub modes: Array2<Option<Mode>>,
    /// Height of the surface there, in mm.
    pub height: f64,
    /// The window exp(−½uᵀWu) on the axes of the touching plane: W = AᵀA, A = ∂(x, y)/∂u, for σ = 1.
    pub stretch: [f64; 3],
    nodes: [Range<usize>; 2],
    /// Along x and y: a row per mode, a column per node.
    lines: [Array2<Complex64>; 2],
    separated: Vec<Separated>,
}

/// The surface about a point: its height, slope and the axes of the plane that touches it.
struct Touch {
    at: [f64; 2],
    z: f64,
    slope: [f64; 2],
    axes: [Vec3; 3],
}

impl Touch {
    fn new(screen: &Screen, at: [f64; 2]) -> Option<Self> {
        let here = screen.height(at)?;
        let [sx, sy] = here.slope;
        let x = Vec3::new(1.0, 0.0, sx).unit();
        let z = Vec3::new(-sx, -sy, 1.0).unit();
        Some(Self {
            at,
            z: here.z,
            slope: here.slope,
            axes: [x, z.cross(x), z],
        })
    }

    /// The mode with total rates f on the local plane; nothing when it does not propagate.
    fn mode(&self, screen: &Screen, f: [f64; 2]) -> Option<Mode> {
        let [x, y, z] = self.axes;
        let n = screen.index_behind();
        let p = [x, y].map(|axis| axis.x * f[0] + axis.y * f[1]);
        let under = n * n - p[0] * p[0] - p[1] * p[1];
        (under > 0.0).then(|| {
            let q = under.sqrt() * screen.leaves();
            Mode {
                direction: (x * p[0] + y * p[1] + z * q) * (1.0 / n),
                cosine: under.sqrt() / n,
            }
        })
    }

    /// Height of a point of the surface over the touching plane, along the screen's z axis.
    fn over(&self, [dx, dy]: [f64; 2], z: f64) -> f64 {
        z - self.z - self.slope[0] * dx - self.slope[1] * dy
    }

    /// Where a ray of this direction through a point of the surface meets the touching plane, on its axes.
    fn project(&self, [dx, dy]: [f64; 2], z: f64, direction: Vec3) -> [f64; 2] {
        let v = Vec3::new(dx, dy, z - self.z);
        let [x, y, normal] = self.axes;
        let v = v + direction * -(normal.dot(v) / normal.dot(direction));
        [x.dot(v), y.dot(v)]
    }
}

impl LocalSpectrum {
    /// The local spectrum about a hit, whose light has the second derivatives `curvature` (xx, xy, yy) of its optical
    /// path along the axes of the touching plane, in 1/mm. Nothing where the surface does not exist.
    pub(crate) fn new(emitter: &Emitter, hit: &Hit, curvature: Option<[f64; 3]>) -> Option<Self> {
        let screen = emitter.screen;
        let touch = Touch::new(screen, hit.at)?;
        let [n, behind] = [screen.index, screen.index_behind()];
        let lift = n * hit.along;
        let carrier = [0, 1].map(|a| hit.cosines[a] + lift * touch.slope[a]);
        let bands = [0, 1].map(|a| {
            // Rates p + q∇s of the directions to follow, whatever their q.
            let tip = screen.leaves() * behind * touch.slope[a];
            let low = emitter.towards[2 * a] + tip.min(0.0) - carrier[a];
            let high = emitter.towards[2 * a + 1] + tip.max(0.0) - carrier[a];
            let spacing = std::f64::consts::TAU / (emitter.k * emitter.period);
            Band::between(0.0, spacing, low, high)
        });
        let modes = Array2::from_shape_fn((bands[1].count, bands[0].count), |(my, mx)| {
            let f = [bands[0].at(mx) + carrier[0], bands[1].at(my) + carrier[1]];
            let followed = |mode: &Mode| {
                let [x0, x1, y0, y1] = emitter.towards;
                let p = [mode.direction.x * behind, mode.direction.y * behind];
                (x0..=x1).contains(&p[0]) && (y0..=y1).contains(&p[1])
            };
            touch.mode(screen, f).filter(followed)
        });
        let [ax, ay, _] = touch.axes;
        let axis = |a: usize| [&emitter.grid.x, &emitter.grid.y][a];
        let [(nodes_x, line_x), (nodes_y, line_y)] =
            [0, 1].map(|a| line(emitter, axis(a), hit.at[a], &bands[a]));
        let mut spectrum = Self {
            modes,
            height: touch.z,
            stretch: [
                ax.x * ax.x + ax.y * ax.y,
                ax.x * ay.x + ax.y * ay.y,
                ay.x * ay.x + ay.y * ay.y,
            ],
            nodes: [nodes_x, nodes_y],
            lines: [line_x, line_y],
            separated: Vec::new(),
        };
        spectrum.separated = spectrum.separated(emitter, &touch, hit, curvature);
        Some(spectrum)
    }

    /// The products that separate nodes from modes.
    fn separated(
        &self,
        emitter: &Emitter,
        touch: &Touch,
        hit: &Hit,
        curvature: Option<[f64; 3]>,
    ) -> Vec<Separated> {
        let [n, behind] = [emitter.screen.index, emitter.screen.index_behind()];
        if emitter.heights.is_none() && curvature.is_none() {
            return vec![Separated {
                nodes: None,
                modes: None,
            }];
        }

        // Height over the touching plane, and what the incident light has there beside its carrier.
        let direction = Vec3::new(hit.cosines[0] / n, hit.cosines[1] / n, hit.along);
        let [xx, xy, yy] = curvature.unwrap_or([0.0; 3]);
        let light = |place: [f64; 2], z: f64| {
            let [u, v] = touch.project(place, z, direction);
            let bent = 0.5 * (xx * u * u + yy * v * v) + xy * u * v;
            Complex64::cis(emitter.k * (bent + n * hit.along * touch.over(place, z)))
        };
        let Some(heights) = emitter.heights else {
            let nodes = self.map_nodes(emitter, touch, |place, _| light(place, touch.z));
            return vec![Separated {
                nodes: Some(nodes),
                modes: None,
            }];
        };
        let z = |node: [usize; 2]| heights.z[node];
        let over = self.map_nodes(emitter, touch, |place, node| touch.over(place, z(node)));
        let light = self.map_nodes(emitter, touch, |place, node| {
            if emitter.open[node] {
                light(place, z(node))
            } else {
                Complex64::ZERO
            }
        });
        let lifts = self
            .modes
            .map(|mode| mode.map_or(0.0, |mode| behind * mode.direction.z));
        let lit = over.iter().zip(&light).filter(|(_, u)| u.norm_sqr() > 0.0);
        let stack = Stack::new(
            ends(lit.map(|(over, _)| *over)),
            ends(lifts.iter().copied().filter(|q| *q != 0.0)),
            emitter.k,
        );
        let product = |number: usize| Separated {
            nodes: Some(
                Zip::from(&light)
                    .and(&over)
                    .map_collect(|u, over| stack.part(*u, *over, number)),
            ),
            modes: Some(lifts.map(|q| Complex64::cis(-emitter.k * q * stack.levels.at[number]))),
        };
        (0..stack.len()).map(product).collect()
    }

    /// A value for each node under the window, from its place relative to the point and its index [y, x].
    fn map_nodes<T>(
        &self,
        emitter: &Emitter,
        touch: &Touch,
        value: impl Fn([f64; 2], [usize; 2]) -> T,
    ) -> Array2<T> {
        let [x, y] = &self.nodes;
        Array2::from_shape_fn((y.len(), x.len()), |(j, i)| {
            let node = [y.start + j, x.start + i];
            let dx = emitter.grid.x.node(node[1]) - touch.at[0];
            let dy = emitter.grid.y.node(node[0]) - touch.at[1];
            value([dx, dy], node)
        })
    }

    /// The part of an array over the grid that lies under the window.
    pub(crate) fn view<'a, T>(&self, values: &'a Array2<T>) -> ArrayView2<'a, T> {
        let [x, y] = self.nodes.clone();
        part(values.view(), y, x)
    }

    /// Adds values under the window to an array over the grid.
    pub(crate) fn add_to(&self, added: &Array2<Complex64>, values: &mut Array2<Complex64>) {
        let [x, y] = self.nodes.clone();
        let mut under = part(values.view_mut(), y, x);
        under += added;
    }

    /// The coefficients cₘ of a transmission over the grid, indexed [m_y, m_x]; zero for what is no mode.
    pub(crate) fn cut(&self, transmission: &Array2<Complex64>) -> Array2<Complex64> {
        let view = self.view(transmission);
        let [lx, ly] = &self.lines;
        let mut total = Array2::zeros(self.modes.dim());
        for product in &self.separated {
            // c = modes ∘ (Ly · (nodes ∘ t) · Lxᵀ)
            let mut waves = match &product.nodes {
                Some(nodes) => product_of_three(ly.view(), (nodes * &view).view(), lx.view()),
                None => product_of_three(ly.view(), view, lx.view()),
            };
            if let Some(modes) = &product.modes {
                waves *= modes;
            }
            total += &waves;
        }
        Zip::from(&mut total).and(&self.modes).for_each(|c, mode| {
            if mode.is_none() {
                *c = Complex64::ZERO;
            }
        });
        total
    }

    /// The conjugate transpose of [`LocalSpectrum::cut`]: cotangents of the nodes under the window, given those of
    /// the coefficients.
    pub(crate) fn cut_adjoint(&self, bar: &Array2<Complex64>) -> Array2<Complex64> {
        // c = 0 for what is no mode
        let bar = Zip::from(bar).and(&self.modes).map_collect(|c, mode| {
            if mode.is_some() {
                c.conj()
            } else {
                Complex64::ZERO
            }
        });
        let [lx, ly] = &self.lines;
        let [x, y] = &self.nodes;
        let mut total = Array2::zeros((y.len(), x.len()));
        for product in &self.separated {
            // c += modes ∘ (Ly · (nodes ∘ t) · Lxᵀ), conjugated as a whole at the end
            let waves = match &product.modes {
                Some(modes) => &bar * modes,
                None => bar.clone(),
            };
            let mut nodes = product_of_three(ly.t(), waves.view(), lx.t());
            if let Some(factors) = &product.nodes {
                nodes *= factors;
            }
            total += &nodes;
        }
        total.mapv_inplace(|v| v.conj());
        total
    }
}

/// The nodes of an axis under the window about a point, and the transform of each to each rate of a band:
/// window times length over period, with the phase.
fn line(
    emitter: &Emitter,
    axis: &Axis,
    centre: f64,
    band: &Band,
) -> (Range<usize>, Array2<Complex64>) {
    let (range, window) = emitter.window.on(axis, centre, emitter.period);
    let first = range.start;
    let matrix = Array2::from_shape_fn((band.count, range.len()), |(m, i)| {
        let phase = -emitter.k * band.at(m) * (axis.node(first + i) - centre);
        Complex64::from_polar(window[i] * axis.weight(first + i) / emitter.period, phase)
    });
    (range, matrix)
}

/// Smallest and largest of some values; zeros when there are none.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    });
    if low <= high { [low, high] } else { [0.0; 2] }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::open_screen;

    use crate::optics::bundle::Hit;
    use crate::optics::frame::Frame;
    use crate::optics::screen::Screen;
    use crate::optics::shape::{Conic, Shape};
    use crate::wave::grid::field::{Axis, Grid};
    use crate::wave::grid::heights::Heights;
    use crate::wave::patches::local_spectrum::{Emitter, LocalSpectrum, Window};

    const K: f64 = std::f64::consts::TAU;

    fn screen(shape: Shape) -> Screen {
        Screen {
            shape,
            ..open_screen(Frame::GLOBAL)
        }
    }

    fn hit(at: [f64; 2], cosines: [f64; 2]) -> Hit {
        Hit {
            at,
            cosines,
            along: (1.0 - cosines[0].powi(2) - cosines[1].powi(2)).sqrt(),
        }
    }

    /// Runs a test on a point of a plane and of a sphere.
    fn with_hits(test: impl Fn(&Emitter, &Hit, [f64; 3])) {
        let sphere = Shape::Conic(Conic {
            curvature: 0.01,
            conic: 0.0,
        });
        let grid = Grid {
            x: Axis::gauss(60, 0.5, 0.0, 2),
            y: Axis::gauss(50, 0.6, 0.0, 3),
        };
        let open = Array2::from_elem(grid.shape(), true);
        let curvature = [0.02, -0.005, 0.01];
        for shape in [Shape::Plane, sphere] {
            let screen = screen(shape);
            let heights = (!screen.is_plane()).then(|| Heights::on(&screen, &grid));
            for window in [
                Window::Gaussian { sigma: 2.0 },
                Window::Square { side: 7.0 },
            ] {
                let emitter = Emitter {
                    screen: &screen,
                    grid: &grid,
                    heights: heights.as_ref(),
                    open: &open,
                    k: K,
                    window,
                    period: 12.0,
                    towards: [-0.8, 0.7, -1.0, 1.0],
                };
                test(&emitter, &hit([6.3, -4.1], [0.2, -0.1]), curvature);
            }
        }
    }

    /// The coefficients as the integral is written, in three dimensions.
    #[test]
    fn coefficients_match_the_direct_sum() {
        with_hits(|emitter, hit, curvature| {
            let t = noise((150, 120), 1);
            let spectrum = LocalSpectrum::new(emitter, hit, Some(curvature)).unwrap();
            let found = spectrum.cut(&t);
            let here = emitter.screen.height(hit.at).unwrap();
            let [sx, sy] = here.slope;
            let d = [hit.cosines[0], hit.cosines[1], hit.along];
            // Axes of the touching plane, written out anew.
            let norm = (1.0 + sx * sx + sy * sy).sqrt();
            let normal = [-sx / norm, -sy / norm, 1.0 / norm];
            let e1 = [1.0, 0.0, sx].map(|v| v / (1.0 + sx * sx).sqrt());
            let e2 = [
                normal[1] * e1[2] - normal[2] * e1[1],
                normal[2] * e1[0] - normal[0] * e1[2],
                normal[0] * e1[1] - normal[1] * e1[0],
            ];
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let (mut error, mut size) = (0.0, 0.0);
            for (mode, leaving) in spectrum.modes.indexed_iter() {
                let (m, Some(leaving)) = (mode, leaving) else {
                    continue;
                };
                if m.0 % 5 != 0 || m.1 % 4 != 0 {
                    continue;
                }
                let mut exact = Complex64::ZERO;
                for ((j, i), t) in t.indexed_iter() {
                    let (x, y) = (emitter.grid.x.node(i), emitter.grid.y.node(j));
                    let z = emitter.screen.height([x, y]).unwrap().z;
                    let v = [x - hit.at[0], y - hit.at[1], z - here.z];
                    let g = match emitter.window {
                        Window::Gaussian { sigma } if v[0].abs().max(v[1].abs()) < 6.0 => {
                            (-0.5 * (v[0] * v[0] + v[1] * v[1]) / (sigma * sigma)).exp()
                        }
                        Window::Square { side } if v[0].abs().max(v[1].abs()) < 0.5 * side => 1.0,
                        _ => continue,
                    };
                    let along = dot(normal, v) / dot(normal, d);
                    let w = [0, 1, 2].map(|c| v[c] - along * d[c]);
                    let (a, b) = (dot(e1, w), dot(e2, w));
                    let [xx, xy, yy] = curvature;
                    let path = dot(d, v) + 0.5 * (xx * a * a + yy * b * b) + xy * a * b;
                    let leaving = [
                        leaving.direction.x,
                        leaving.direction.y,
                        leaving.direction.z,
                    ];
                    let area = emitter.grid.x.weight(i) * emitter.grid.y.weight(j) / 144.0;
                    exact += t * g * area * Complex64::cis(K * (path - dot(leaving, v)));
                }
                error += (found[m] - exact).norm_sqr();
                size += exact.norm_sqr();
            }
            let error = (error / size).sqrt();
            let limit = if emitter.heights.is_some() {
                3e-5
            } else {
                1e-12
            };
            assert!(error < limit, "{:?}: {error:e}", emitter.window);
        });
    }

    #[test]
    fn cut_dot_product() {
        with_hits(|emitter, hit, curvature| {
            for curvature in [None, Some(curvature)] {
                let spectrum = LocalSpectrum::new(emitter, hit, curvature).unwrap();
                let t = noise((150, 120), 2);
                let cut = spectrum.cut(&t);
                let bar = noise(cut.dim(), 3);
                let mut back = Array2::zeros((150, 120));
                spectrum.add_to(&spectrum.cut_adjoint(&bar), &mut back);
                let dot = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
                    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
                };
                let size = (dot(&bar, &bar) * dot(&cut, &cut)).norm().sqrt();
                let off = (dot(&bar, &cut) - dot(&back, &t)).norm() / size;
                assert!(off < 1e-14, "{off:e}");
            }
        });
    }
}
