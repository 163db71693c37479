//! How the rays of a hop change with the parameters of a system.
//!
//! A parameter is known by two perturbed systems, a little below and a little above. Frames, indices
//! and heights of surfaces change between them in proportion, so their derivatives are differences of the
//! prescription, good to the square of a step that may be tiny; the rays themselves carry exact tangents from
//! there on: where they land, their directions, their optical paths, the amplitudes and curvatures of their
//! beamlets. Any shape, pose, index or rule between parameters is covered without knowing what it is.

use num_complex::Complex64;

use crate::engine::trace::launch_plane::LaunchPlane;
use crate::engine::trace::ray_trace::{
    BeamletStart, Carried, Landing, LocatedScreen, carry_beamlet, emit, land, trace_train,
};
use crate::engine::trace::surface_trace::carry_along;
use crate::math::complex::{Complex, Symmetric};
use crate::math::real::{Dual, Real};
use crate::math::vec3::Vec3;
use crate::optics::frame::{Axes, Frame};
use crate::optics::ray::Loss;
use crate::optics::screen::Screen;
use crate::optics::shape::{Bending, Height, Shape};
use crate::optics::surface::{Face, Surface};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::beamlet_kernel::Moments;

/// A parameter of a system: the same system with the parameter a little smaller and a little larger.
#[derive(Clone, Debug)]
pub struct Variation {
    /// The system with the smaller value.
    pub below: System,
    /// The system with the larger value.
    pub above: System,
    /// The difference of the two values.
    pub distance: f64,
}

impl Variation {
    /// The variation of a system in one of its parameters: `system` makes it from all of them, and the parameter at
    /// `index` is a `step` smaller and larger.
    ///
    /// # Errors
    /// Those of `system`.
    pub(crate) fn new<E>(
        parameters: &[f64],
        index: usize,
        step: f64,
        system: impl Fn(&[f64]) -> Result<System, E>,
    ) -> Result<Self, E> {
        let moved = |by: f64| {
            let mut moved = parameters.to_vec();
            moved[index] += by;
            system(&moved)
        };
        Ok(Self {
            below: moved(-step)?,
            above: moved(step)?,
            distance: 2.0 * step,
        })
    }

    /// Whether the light of the source on the first screen changes, because one of them does.
    pub(crate) fn moves_light(&self) -> bool {
        let ([below, ..], [above, ..]) =
            (self.below.screens.as_slice(), self.above.screens.as_slice())
        else {
            return false;
        };
        self.below.source != self.above.source
            || below.frame != above.frame
            || below.index != above.index
            || below.behind != above.behind
            || below.shape != above.shape
    }

    /// One of its hops.
    pub(crate) fn hop(&self, number: usize) -> Option<PerturbedHops<'_>> {
        Some(PerturbedHops {
            below: self.below.hops().nth(number)?,
            above: self.above.hops().nth(number)?,
            distance: self.distance,
        })
    }
}

/// One hop of a variation.
#[derive(Clone, Copy)]
pub(crate) struct PerturbedHops<'a> {
    /// The hop with the smaller value of the parameter.
    pub below: Hop<'a>,
    /// The hop with the larger value.
    pub above: Hop<'a>,
    /// The difference of the two values.
    pub distance: f64,
}

/// One hop of those variations in which its rays run otherwise, with their numbers.
pub(crate) fn perturbed_hops<'v>(
    variations: &'v [Variation],
    number: usize,
    hop: &Hop,
) -> (Vec<usize>, Vec<PerturbedHops<'v>>) {
    let all = variations.iter().enumerate();
    let all = all.filter_map(|(i, variation)| variation.hop(number).map(|n| (i, n)));
    all.filter(|(_, n)| !(n.below.is_same(hop) && n.above.is_same(hop)))
        .unzip()
}

/// Parameters whose tangents travel together.
pub(crate) const BLOCK: usize = 4;

/// A number with its derivatives with respect to a block of parameters.
pub(crate) type Number = Dual<BLOCK>;

/// A frame that moves.
pub(crate) struct VariedFrame {
    origin: Vec3<Number>,
    axes: [Vec3<Number>; 3],
}

/// A shape that bends.
struct VariedShape<'a> {
    shape: &'a Shape,
    /// Which tangent, the shapes below and above, and one over their distance.
    changes: Vec<(usize, &'a Shape, &'a Shape, f64)>,
}

/// A surface that moves and bends.
pub(crate) struct VariedSurface<'a> {
    surface: &'a Surface,
    shape: VariedShape<'a>,
    frame: VariedFrame,
    index: [Number; 2],
}

/// A screen that moves and bends.
struct VariedScreen<'a> {
    screen: &'a Screen,
    shape: VariedShape<'a>,
    frame: VariedFrame,
    /// Refractive index on the side where the ray is.
    index: Number,
}

/// A hop whose parts move.
pub(crate) struct VariedHop<'a> {
    hop: Hop<'a>,
    from: VariedScreen<'a>,
    faces: Vec<VariedSurface<'a>>,
    to: VariedScreen<'a>,
}

/// A number from its value and the perturbed ones.
fn number(value: f64, perturbed: impl Iterator<Item = (f64, f64, f64)>) -> Number {
    let mut number = Number::constant(value);
    for (slot, (below, above, distance)) in perturbed.enumerate() {
        number.tangent[slot] = (above - below) / distance;
    }
    number
}

impl VariedFrame {
    fn new<'a>(
        frame: &Frame,
        perturbed: impl Iterator<Item = (&'a Frame, &'a Frame, f64)> + Clone,
    ) -> Self {
        let vector = |of: &dyn Fn(&Frame) -> Vec3| {
            let component = |along: &dyn Fn(Vec3) -> f64| {
                let pairs = perturbed.clone();
                let pairs = pairs.map(|(below, above, d)| (along(of(below)), along(of(above)), d));
                number(along(of(frame)), pairs)
            };
            Vec3::new(
                component(&|v| v.x),
                component(&|v| v.y),
                component(&|v| v.z),
            )
        };
        Self {
            origin: vector(&|frame| frame.origin),
            axes: [
                vector(&|frame| frame.x),
                vector(&|frame| frame.y),
                vector(&|frame| frame.z),
            ],
        }
    }

    /// A frame that stands still in this one.
    fn carrying(&self, own: &Frame) -> Self {
        let turned = |v: Vec3| self.direction_to_global(Vec3::constant(v));
        Self {
            origin: self.to_global(Vec3::constant(own.origin)),
            axes: [own.x, own.y, own.z].map(turned),
        }
    }
}

impl Axes<Number> for VariedFrame {
    fn across(&self) -> [Vec3<Number>; 2] {
        [self.axes[0], self.axes[1]]
    }
    fn direction_to_local(&self, v: Vec3<Number>) -> Vec3<Number> {
        let [x, y, z] = self.axes.map(|axis| v.dot(axis));
        Vec3::new(x, y, z)
    }
    fn direction_to_global(&self, v: Vec3<Number>) -> Vec3<Number> {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
    fn to_local(&self, point: Vec3<Number>) -> Vec3<Number> {
        self.direction_to_local(point - self.origin)
    }
    fn to_global(&self, point: Vec3<Number>) -> Vec3<Number> {
        self.direction_to_global(point) + self.origin
    }
}

impl Face<Number> for VariedSurface<'_> {
    type Axes = VariedFrame;
    fn surface(&self) -> &Surface {
        self.surface
    }
    fn axes(&self) -> &VariedFrame {
        &self.frame
    }
    fn index(&self) -> [Number; 2] {
        self.index
    }

    fn height(&self, x: Number, y: Number) -> Option<Height<Number>> {
        self.shape.height(x, y)
    }
    fn meet(&self, position: Vec3<Number>, direction: Vec3<Number>) -> Result<Number, Loss> {
        self.shape.meet(position, direction)
    }
}

impl<'a> VariedShape<'a> {
    /// A shape, with those below and above of each parameter and the distance of its values.
    fn new(shape: &'a Shape, perturbed: impl Iterator<Item = (&'a Shape, &'a Shape, f64)>) -> Self {
        let changing = perturbed.enumerate().filter(|(_, (a, b, _))| a != b);
        Self {
            shape,
            changes: changing
                .map(|(slot, (a, b, distance))| (slot, a, b, 1.0 / distance))
                .collect(),
        }
    }
}

impl Bending<Number> for VariedShape<'_> {
    fn is_plane(&self) -> bool {
        self.changes.is_empty() && *self.shape == Shape::Plane
    }

    fn height(&self, x: Number, y: Number) -> Option<Height<Number>> {
        let mut height = self.shape.height(x, y)?;
        for (slot, below, above, rate) in &self.changes {
            let low = below.height(x.value, y.value)?;
            let high = above.height(x.value, y.value)?;
            let add = |number: &mut Number, low: f64, high: f64| {
                number.tangent[*slot] += (high - low) * rate;
            };
            add(&mut height.z, low.z, high.z);
            for (i, slope) in height.slope.iter_mut().enumerate() {
                add(slope, low.slope[i], high.slope[i]);
            }
            for (i, second) in height.hessian.iter_mut().enumerate() {
                add(second, low.hessian[i], high.hessian[i]);
            }
        }
        Some(height)
    }

    /// In plain numbers, then one Newton step with tangents: at a root that step is the derivative of the
    /// implicit function and adds nothing else.
    fn meet(&self, position: Vec3<Number>, direction: Vec3<Number>) -> Result<Number, Loss> {
        let length = Number::constant(self.shape.meet(position.value(), direction.value())?);
        let at = position + direction * length;
        let h = self.height(at.x, at.y).ok_or(Loss::Missed)?;
        let slope = direction.z - h.slope[0] * direction.x - h.slope[1] * direction.y;
        Ok(length - (at.z - h.z) / slope)
    }
}

impl<'a> VariedScreen<'a> {
    /// As a ray meets it.
    fn located(&self) -> LocatedScreen<'_, Number, VariedFrame, VariedShape<'a>> {
        LocatedScreen {
            screen: self.screen,
            shape: &self.shape,
            axes: &self.frame,
            index: self.index,
        }
    }
}

impl<'a> VariedHop<'a> {
    /// A hop that changes with up to [`BLOCK`] parameters.
    pub(crate) fn new(hop: Hop<'a>, perturbed: &[PerturbedHops<'a>]) -> Self {
        let screen = |of: &dyn Fn(&Hop<'a>) -> &'a Screen, index: fn(&Screen) -> f64| {
            let pairs = perturbed
                .iter()
                .map(|n| (of(&n.below), of(&n.above), n.distance));
            let frames = pairs.clone().map(|(a, b, d)| (&a.frame, &b.frame, d));
            let shapes = pairs.clone().map(|(a, b, d)| (&a.shape, &b.shape, d));
            let indices = pairs.map(|(a, b, d)| (index(a), index(b), d));
            let here = of(&hop);
            VariedScreen {
                screen: here,
                shape: VariedShape::new(&here.shape, shapes),
                frame: VariedFrame::new(&here.frame, frames),
                index: number(index(here), indices),
            }
        };
        let face = |(i, surface): (usize, &'a Surface)| {
            let pairs = perturbed
                .iter()
                .map(move |n| (&n.below.train[i], &n.above.train[i], n.distance));
            let frames = pairs.clone().map(|(a, b, d)| (&a.frame, &b.frame, d));
            let index = |side: usize| {
                let pairs = pairs.clone();
                let pairs = pairs.map(|(a, b, d)| (a.index[side], b.index[side], d));
                number(surface.index[side], pairs)
            };
            let shapes = pairs.clone().map(|(a, b, d)| (&a.shape, &b.shape, d));
            VariedSurface {
                surface,
                shape: VariedShape::new(&surface.shape, shapes),
                frame: VariedFrame::new(&surface.frame, frames),
                index: [index(0), index(1)],
            }
        };
        Self {
            from: screen(&|hop| hop.from, Screen::index_behind),
            faces: hop.train.iter().enumerate().map(face).collect(),
            to: screen(&|hop| hop.to, |screen| screen.index),
            hop,
        }
    }

    /// The ray that leaves (x, y) on the first screen along p, where it lands.
    ///
    /// # Errors
    /// How it was lost, if it was.
    pub(crate) fn trace(&self, at: [Number; 2], p: [Number; 2]) -> Result<Landing<Number>, Loss> {
        let ray = emit(&self.from.located(), at, p)?;
        let ray = trace_train(&self.faces, ray, &mut ())?;
        land(&self.to.located(), ray, &mut ())
    }

    /// A beamlet that leaves the first screen, where it lands, with slopes and curvature of the wave along both
    /// surfaces.
    ///
    /// # Errors
    /// How its ray was lost, if it was.
    pub(crate) fn carry_from(&self, start: BeamletStart<Number>) -> Result<Carried<Number>, Loss> {
        let (from, to) = (self.from.located(), self.to.located());
        carry_along(&from, &self.faces, &to, start)
    }

    /// The beamlet of width σ that leaves a launch plane along p, cosines along the screen's axes, where it lands.
    ///
    /// # Errors
    /// How its ray was lost, if it was.
    pub(crate) fn carry(
        &self,
        launch_plane: &LaunchPlane,
        p: [f64; 2],
        sigma: f64,
    ) -> Result<Carried<Number>, Loss> {
        let hop = launch_plane.hop(&self.hop);
        let frame = &self.from.frame;
        let tangent = launch_plane
            .frame_on(self.hop.from)
            .map(|own| frame.carrying(&own));
        let from = LocatedScreen {
            screen: hop.from,
            shape: &hop.from.shape,
            axes: tangent.as_ref().unwrap_or(frame),
            index: self.from.index,
        };
        let constant = |v: [f64; 2]| v.map(Number::constant);
        let window = launch_plane.window(sigma, hop.wavenumber());
        let number = |z: Complex| Complex::new(Number::constant(z.re), Number::constant(z.im));
        let start = BeamletStart {
            at: constant(launch_plane.at()),
            p: constant(launch_plane.cosines(p)?),
            q: Symmetric {
                xx: number(window.xx),
                xy: number(window.xy),
                yy: number(window.yy),
            },
        };
        carry_beamlet(&from, &self.faces, &self.to.located(), start)
    }
}

/// The derivatives of a loss with respect to a block of parameters that one beamlet brings, from its total
/// `amplitude` and from the moments that the cotangent of the sum has under it.
///
/// The beamlet a·exp(ik[p·u + ½uᵀGu]), u = x − s, with a ∝ A·exp(ik·path), changes by
/// dA/A + ik[dpath − p·ds + (dp − G ds)·u + ½uᵀdG u] of itself.
pub(crate) fn pull(
    carried: &Carried<Number>,
    amplitude: Complex64,
    moments: &Moments,
    k: f64,
) -> [f64; BLOCK] {
    let [one, x, y, xx, xy, yy] = moments.map(|m| amplitude * m.conj());
    let (landing, g) = (&carried.landing, &carried.curvature);
    let value = carried.amplitude.value();
    let (gxx, gxy, gyy) = (g.xx.value(), g.xy.value(), g.yy.value());
    let ik = Complex64::new(0.0, k);
    std::array::from_fn(|i| {
        let complex = |z: &Complex<Number>| Complex64::new(z.re.tangent[i], z.im.tangent[i]);
        let [sx, sy] = landing.at.map(|s| s.tangent[i]);
        let [px, py] = landing.cosines.map(|p| p.tangent[i]);
        let [p, q] = landing.cosines.map(|p| p.value);
        let here =
            complex(&carried.amplitude) / value + ik * (landing.path.tangent[i] - p * sx - q * sy);
        let along_x = px - gxx * sx - gxy * sy;
        let along_y = py - gxy * sx - gyy * sy;
        let bend = (complex(&g.xx) * xx + complex(&g.yy) * yy) * 0.5 + complex(&g.xy) * xy;
        (here * one + ik * (along_x * x + along_y * y + bend)).re
    })
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::beamlet::beamlet_launch::launch_beamlet_from;
    use crate::engine::trace::launch_plane::LaunchPlane;
    use crate::engine::trace::ray_sensitivity::{PerturbedHops, VariedHop, pull};
    use crate::fixtures::noise::noise;
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;
    use crate::wave::beamlet::beamlet_sum::Canvas;
    use crate::wave::grid::raster::Raster;

    const K: f64 = std::f64::consts::TAU;

    /// A curved face between two screens, changed by so much in curvature, index, place and tilt of the last.
    struct Parts([Screen; 2], Vec<Surface>);

    impl Parts {
        fn new([curvature, index, place, tilt]: [f64; 4]) -> Self {
            let at = |z: f64| Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z));
            let index = [1.0, 1.5 + index];
            let screen = |frame: Frame, index: f64| Screen {
                name: String::new(),
                frame,
                shape: Shape::Plane,
                kind: ScreenKind::Stop(Aperture::OPEN),
                index,
                behind: None,
                arrives: 1.0,
            };
            let face = Surface {
                shape: Shape::Conic(Conic {
                    curvature: 0.02 + curvature,
                    conic: 0.0,
                }),
                frame: at(30.0),
                aperture: Aperture::disc(30.0),
                interface: Interface::Refract,
                coating: Coating::Fresnel,
                index,
            };
            let last = at(60.0 + place).tilted([tilt, 0.0, 0.0]);
            Self([screen(at(0.0), 1.0), screen(last, index[1])], vec![face])
        }

        fn hop(&self) -> Hop<'_> {
            Hop {
                wavelength: 1.0,
                from: &self.0[0],
                train: &self.1,
                to: &self.0[1],
            }
        }
    }

    /// One beamlet summed under a cotangent changes as its moments say.
    #[test]
    fn pull_matches_differences() {
        let raster = Raster {
            start: [-25.0, -25.0],
            pitch: [0.4, 0.4],
            size: [126, 126],
        };
        let (at, p, sigma, edge) = ([3.0, -2.0], [0.12, 0.05], 4.0, 1e-13);
        let bar = noise((126, 126), 0);
        let land = |hop: &Hop| {
            let launch_plane = LaunchPlane::new(hop.from, at).unwrap();
            launch_beamlet_from(&launch_plane, hop, p, sigma).unwrap()
        };
        let value = |change: [f64; 4]| {
            let parts = Parts::new(change);
            let mut canvas = Canvas::new(raster);
            canvas.add(&[land(&parts.hop())], K, edge);
            let sum = canvas.finish();
            let terms = bar.iter().zip(&sum);
            terms.map(|(a, b)| (a.conj() * b).re).sum::<f64>()
        };
        let along = |i: usize, by: f64| {
            let mut change = [0.0; 4];
            change[i] = by;
            change
        };
        let steps = [2e-5, 5e-6, 2e-4, 5e-5];
        let parts = Parts::new([0.0; 4]);
        let moved = |i: usize| [-1.0, 1.0].map(|sign| Parts::new(along(i, sign * 0.01 * steps[i])));
        let pairs: Vec<[Parts; 2]> = (0..4).map(moved).collect();
        let perturbed: Vec<PerturbedHops> = (pairs.iter().zip(steps))
            .map(|([below, above], step)| PerturbedHops {
                below: below.hop(),
                above: above.hop(),
                distance: 0.02 * step,
            })
            .collect();
        let hop = parts.hop();
        let arrival = land(&hop);
        let moments = Canvas::holding(raster, &bar).add_adjoint(&[arrival], K, edge);
        let launch_plane = LaunchPlane::new(hop.from, at).unwrap();
        let carried = VariedHop::new(hop, &perturbed).carry(&launch_plane, p, sigma);
        let amplitude: Complex64 = arrival.amplitude;
        let found = pull(&carried.unwrap(), amplitude, &moments[0], K);
        for (i, (found, step)) in found.into_iter().zip(steps).enumerate() {
            let slope = (value(along(i, step)) - value(along(i, -step))) / (2.0 * step);
            let error = (found - slope).abs() / slope.abs();
            assert!(
                error < 1e-5,
                "parameter {i}: {found:e} against {slope:e}: {error:e}"
            );
        }
    }
}
