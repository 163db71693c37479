//! Diffractive optical elements: a complex transmission over a plane.

use std::borrow::Cow;

use num_complex::Complex64;

use crate::optics::aperture::Aperture;
use crate::optics::phase::profile::Profile;
use crate::optics::pixels::pixel_grid::{Lattice, Pixels};
use crate::optics::surface_coordinates::SurfaceCoordinates;

/// A thin element that multiplies the field by a complex transmission (or reflection).
#[derive(Clone, Debug, PartialEq)]
pub struct Doe {
    /// Its layers; their transmissions multiply, so phases add.
    pub layers: Vec<Layer>,
    /// Its aperture; nothing passes outside.
    pub aperture: Aperture,
    /// Whether light goes on by reflection.
    pub reflect: bool,
}

/// One factor of a transmission.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// A grid of pixels.
    Pixels(Pixels),
    /// An analytic phase.
    Phase(Profile),
    /// A weighted sum of transmissions, each a product of layers.
    Sum(Vec<Term>),
    /// A product of layers given on the surface's own coordinates instead of its local x and y; dark where
    /// the surface does not exist.
    OnSurface(Box<SurfaceCoordinates>, Vec<Layer>),
}

/// Orders of the spectrum of pixels on surface coordinates that their sampling resolves: their edges lie anywhere
/// between the samples.
const PIXEL_ORDERS: f64 = 8.0;

impl Doe {
    /// The transmission at (x, y) without the aperture.
    pub fn transmission(&self, x: f64, y: f64) -> Complex64 {
        product(&self.layers, x, y)
    }

    /// The transmission of a small cell about (x, y), given as its spans: that of the point, with the mean over
    /// the cell of pixels on surface coordinates, whose edges lie anywhere in it.
    pub(crate) fn transmission_over(&self, [x, y]: [f64; 2], spans: [[f64; 2]; 2]) -> Complex64 {
        let cell = Cell { at: [x, y], spans };
        let factors = self.layers.iter().map(|layer| over(layer, cell));
        factors.product()
    }

    /// The phases among its layers that have a singular point, each with that point. Those inside sums are none of them.
    pub(crate) fn singular_phases(&self) -> Vec<(&Profile, [f64; 2])> {
        let phases = self.layers.iter().filter_map(|layer| match layer {
            Layer::Phase(profile) => Some(profile),
            Layer::Pixels(_) | Layer::Sum(_) | Layer::OnSurface(..) => None,
        });
        phases
            .filter_map(|profile| Some((profile, profile.singular_point()?)))
            .collect()
    }

    /// The pixel grid over x and y that sets this element's sampling, if it has one: the first of its layers.
    pub fn pixels(&self) -> Option<&Pixels> {
        first_pixels(&self.layers)
    }

    /// Whether a layer has pixels on the surface's own coordinates.
    pub(crate) fn has_surface_pixels(&self) -> bool {
        let on_surface = |layer: &Layer| match layer {
            Layer::OnSurface(_, layers) => first_pixels(layers).is_some(),
            Layer::Phase(_) | Layer::Pixels(_) | Layer::Sum(_) => false,
        };
        self.layers.iter().any(on_surface)
    }

    /// The pixels that a design may change: those of the first layer that is a pixel grid, over x and y or on
    /// the surface's own coordinates. Pixels inside sums are none of them.
    pub fn free_pixels(&self) -> Option<&Pixels> {
        self.layers.iter().find_map(own_pixels)
    }

    /// Mutable access to the pixels of [`Doe::free_pixels`].
    pub fn free_pixels_mut(&mut self) -> Option<&mut Pixels> {
        let own = |layer: &&mut Layer| own_pixels(layer).is_some();
        match self.layers.iter_mut().find(own)? {
            Layer::Pixels(pixels) => Some(pixels),
            Layer::OnSurface(_, layers) => layers.iter_mut().find_map(|layer| match layer {
                Layer::Pixels(pixels) => Some(pixels),
                _ => None,
            }),
            Layer::Phase(_) | Layer::Sum(_) => None,
        }
    }

    /// Visits, for a small cell about (x, y), each pixel of [`Doe::free_pixels`] that takes part in
    /// [`Doe::transmission_over`] there, with its derivative with respect to that pixel's value.
    pub(crate) fn visit_pixels(
        &self,
        at: [f64; 2],
        spans: [[f64; 2]; 2],
        visit: &mut impl FnMut([usize; 2], Complex64),
    ) {
        let own = |layer: &Layer| own_pixels(layer).is_some();
        let Some(place) = self.layers.iter().position(own) else {
            return;
        };
        let cell = Cell { at, spans };
        let others = |layer: &(usize, &Layer)| layer.0 != place;
        let rest = self.layers.iter().enumerate().filter(others);
        let factor: Complex64 = rest.map(|(_, layer)| over(layer, cell)).product();
        match &self.layers[place] {
            Layer::Pixels(pixels) => {
                for (pixel, share) in pixels.shares(at[0], at[1]) {
                    visit(pixel, factor * share);
                }
            }
            Layer::OnSurface(own, layers) => {
                visit_on_surface(own, layers, factor, cell, visit);
            }
            Layer::Phase(_) | Layer::Sum(_) => {}
        }
    }

    /// The gradient of the phase in rad/mm where it is smooth, from the analytic layers; nothing when
    /// pixels or sums take part, whose phase has no gradient of this kind.
    pub fn phase_gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        gradient(&self.layers, x, y, |_| None)
    }

    /// The gradient of the phase in rad/mm by which a ray is turned: as [`Doe::phase_gradient`], with the strongest term of
    /// a sum in its place, if that has more than half of the energy.
    pub(crate) fn ray_gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        gradient(&self.layers, x, y, strongest)
    }

    /// The phase in rad that a ray gains, from the analytic layers, not wrapped; nothing where [`Doe::ray_gradient`] has
    /// nothing.
    pub(crate) fn ray_phase(&self, x: f64, y: f64) -> Option<f64> {
        ray_phase(&self.layers, x, y)
    }

    /// The analytic phases over x and y whose sum is this element's phase; nothing when other layers take
    /// part.
    pub(crate) fn profiles(&self) -> Option<Vec<&Profile>> {
        let mut profiles = Vec::new();
        for layer in &self.layers {
            match layer {
                Layer::Phase(profile) => profiles.push(profile),
                Layer::Pixels(_) | Layer::Sum(_) | Layer::OnSurface(..) => return None,
            }
        }
        Some(profiles)
    }

    /// The largest gradient of the analytic phases along x and y over a box, in rad/mm, by sampling; no nearer to a singular
    /// point than from sample to sample.
    pub fn steepest(&self, bounds: [f64; 4]) -> [f64; 2] {
        let mut steepest = [0.0f64; 2];
        let step = [0, 1].map(|a| (bounds[2 * a + 1] - bounds[2 * a]) / 32.0);
        let closest = step[0].min(step[1]);
        for j in 0..=32 {
            for i in 0..=32 {
                let x = bounds[0] + step[0] * f64::from(i);
                let y = bounds[2] + step[1] * f64::from(j);
                let here = slopes(&self.layers, [x, y], closest);
                steepest = [steepest[0].max(here[0]), steepest[1].max(here[1])];
            }
        }
        steepest
    }

    /// Whether all pixel grids of the element have the same pitch, size and form: one sampling holds for all.
    pub(crate) fn shares_lattice(&self) -> bool {
        let lattices = lattices(&self.layers);
        let agree = |a: &Lattice| lattices.iter().all(|b| a.agrees_with(b));
        lattices.iter().all(agree)
    }

    /// The sides over the pitch of the active area of its pixels over x and y; one where they have no gaps.
    pub(crate) fn active_sides(&self) -> [f64; 2] {
        let gapped = |layer: &Lattice| layer.sides != [1.0; 2];
        let own = lattices(&self.layers).into_iter().find(gapped);
        own.map_or([1.0; 2], |lattice| lattice.sides)
    }

    /// The element with the mean of each pixel over its active area and its gap.
    pub(crate) fn without_gaps(&self) -> Cow<'_, Self> {
        match self.active_sides() == [1.0; 2] {
            true => Cow::Borrowed(self),
            false => Cow::Owned(Self {
                layers: without_gaps(&self.layers),
                aperture: self.aperture.clone(),
                reflect: self.reflect,
            }),
        }
    }

    /// The part of the plane where the element transmits, `[x_min, x_max, y_min, y_max]`: its aperture
    /// and its pixel grid; nothing when neither limits it.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let grid = self.pixels().map(Pixels::bounds);
        match (grid, self.aperture.bounds()) {
            (Some(a), Some(b)) => Some([
                a[0].max(b[0]),
                a[1].min(b[1]),
                a[2].max(b[2]),
                a[3].min(b[3]),
            ]),
            (a, b) => a.or(b),
        }
    }
}

/// The lattice of every pixel grid among layers.
pub(crate) fn lattices(layers: &[Layer]) -> Vec<Lattice> {
    let own = |layer: &Layer| match layer {
        Layer::Pixels(pixels) => vec![pixels.lattice()],
        Layer::Phase(_) => Vec::new(),
        Layer::Sum(terms) => terms.iter().flat_map(|term| lattices(&term.1)).collect(),
        Layer::OnSurface(_, layers) => lattices(layers),
    };
    layers.iter().flat_map(own).collect()
}

/// Layers with pixels without gaps: [`Doe::without_gaps`].
fn without_gaps(layers: &[Layer]) -> Vec<Layer> {
    let own = |layer: &Layer| match layer {
        Layer::Pixels(pixels) => Layer::Pixels(pixels.without_gaps()),
        Layer::Phase(profile) => Layer::Phase(profile.clone()),
        Layer::Sum(terms) => {
            let terms = terms.iter();
            Layer::Sum(
                terms
                    .map(|(w, layers)| (*w, without_gaps(layers)))
                    .collect(),
            )
        }
        Layer::OnSurface(own, layers) => Layer::OnSurface(own.clone(), without_gaps(layers)),
    };
    layers.iter().map(own).collect()
}

/// A small cell of a screen, over which the field is one sample.
#[derive(Clone, Copy)]
struct Cell {
    /// Where the sample stands, in mm.
    at: [f64; 2],
    /// From where to where the cell extends along x and y, in mm.
    spans: [[f64; 2]; 2],
}

/// Points along each axis of a cell over which pixels on surface coordinates are averaged.
const PARTS: u32 = 8;

/// The product of layers on a surface's own coordinates, at a point over x and y.
fn on_surface<'a, L>(own: &SurfaceCoordinates, layers: L, at: [f64; 2]) -> Complex64
where
    L: IntoIterator<Item = &'a Layer>,
{
    let dark = Complex64::ZERO;
    own.at(at).map_or(dark, |[u, v]| product(layers, u, v))
}

/// Its mean over a cell; one without layers.
fn mean(own: &SurfaceCoordinates, layers: &[&Layer], spans: [[f64; 2]; 2]) -> Complex64 {
    if layers.is_empty() {
        return Complex64::ONE;
    }
    let value = |at| on_surface(own, layers.iter().copied(), at);
    parts(spans).map(value).sum::<Complex64>() / f64::from(PARTS * PARTS)
}

/// Points spread over a cell.
fn parts([[x0, x1], [y0, y1]]: [[f64; 2]; 2]) -> impl Iterator<Item = [f64; 2]> {
    let place = move |low: f64, high: f64, i: u32| {
        low + (high - low) * (f64::from(i) + 0.5) / f64::from(PARTS)
    };
    (0..PARTS).flat_map(move |j| (0..PARTS).map(move |i| [place(x0, x1, i), place(y0, y1, j)]))
}

/// The transmission of one layer in a small cell: see [`Doe::transmission_over`].
fn over(layer: &Layer, Cell { at, spans }: Cell) -> Complex64 {
    match layer {
        Layer::OnSurface(own, layers) => {
            let (edged, smooth): (Vec<&Layer>, Vec<&Layer>) = layers.iter().partition(is_edged);
            on_surface(own, smooth, at) * mean(own, &edged, spans)
        }
        layer => product([layer], at[0], at[1]),
    }
}

/// Whether a layer has pixels.
fn is_edged(layer: &&Layer) -> bool {
    first_pixels(std::slice::from_ref(*layer)).is_some()
}

/// The pixels of a layer that are not inside a sum.
fn own_pixels(layer: &Layer) -> Option<&Pixels> {
    match layer {
        Layer::Pixels(pixels) => Some(pixels),
        Layer::OnSurface(_, layers) => layers.iter().find_map(|layer| match layer {
            Layer::Pixels(pixels) => Some(pixels),
            _ => None,
        }),
        Layer::Phase(_) | Layer::Sum(_) => None,
    }
}

/// [`Doe::visit_pixels`] for pixels on a surface's own coordinates, beside a factor.
fn visit_on_surface(
    own: &SurfaceCoordinates,
    layers: &[Layer],
    factor: Complex64,
    Cell { at, spans }: Cell,
    visit: &mut impl FnMut([usize; 2], Complex64),
) {
    let (edged, smooth): (Vec<&Layer>, Vec<&Layer>) = layers.iter().partition(is_edged);
    let place = edged.iter().position(|layer| own_pixels(layer).is_some());
    let (Some(place), factor) = (place, factor * on_surface(own, smooth, at)) else {
        return;
    };
    let others: Vec<&Layer> = (edged.iter().enumerate())
        .filter(|(i, _)| *i != place)
        .map(|(_, layer)| *layer)
        .collect();
    let Layer::Pixels(pixels) = edged[place] else {
        return;
    };
    for part in parts(spans) {
        let Some([u, v]) = own.at(part) else { continue };
        let beside = factor * product(others.iter().copied(), u, v) / f64::from(PARTS * PARTS);
        for (pixel, share) in pixels.shares(u, v) {
            visit(pixel, beside * share);
        }
    }
}

fn product<'a, L>(layers: L, x: f64, y: f64) -> Complex64
where
    L: IntoIterator<Item = &'a Layer>,
{
    let mut total = Complex64::ONE;
    for layer in layers {
        total *= match layer {
            Layer::Pixels(pixels) => pixels.at(x, y),
            Layer::Phase(profile) => Complex64::cis(profile.phase(x, y)),
            Layer::Sum(terms) => terms
                .iter()
                .map(|(weight, layers)| weight * product(layers, x, y))
                .sum(),
            Layer::OnSurface(own, layers) => on_surface(own, layers, [x, y]),
        };
    }
    total
}

fn first_pixels(layers: &[Layer]) -> Option<&Pixels> {
    layers.iter().find_map(|layer| match layer {
        Layer::Pixels(pixels) => Some(pixels),
        Layer::Phase(_) | Layer::OnSurface(..) => None,
        Layer::Sum(terms) => terms.iter().find_map(|(_, layers)| first_pixels(layers)),
    })
}

/// One term of a sum: its weight, and the layers whose product it is.
pub type Term = (Complex64, Vec<Layer>);

/// The term of a sum that has more than half of the energy of all.
fn strongest(terms: &[Term]) -> Option<&[Layer]> {
    let all: f64 = terms.iter().map(|(weight, _)| weight.norm_sqr()).sum();
    let main = terms
        .iter()
        .find(|(weight, _)| weight.norm_sqr() > 0.5 * all);
    main.map(|(_, layers)| layers.as_slice())
}

/// The phase of analytic layers, of sums that of the strongest term; nothing when pixels take part.
fn ray_phase(layers: &[Layer], x: f64, y: f64) -> Option<f64> {
    let phase = |layer: &Layer| match layer {
        Layer::Phase(profile) => Some(profile.phase(x, y)),
        Layer::OnSurface(own, layers) => {
            let [u, v] = own.at([x, y])?;
            ray_phase(layers, u, v)
        }
        Layer::Sum(terms) => ray_phase(strongest(terms)?, x, y),
        Layer::Pixels(_) => None,
    };
    layers.iter().map(phase).sum()
}

/// The gradient of the phase of analytic layers; of sums that of the term that `choose` gives. Nothing when pixels take part,
/// or sums without such a term.
fn gradient(
    layers: &[Layer],
    x: f64,
    y: f64,
    choose: fn(&[Term]) -> Option<&[Layer]>,
) -> Option<[f64; 2]> {
    let mut sum = [0.0; 2];
    for layer in layers {
        let here = match layer {
            Layer::Phase(profile) => profile.gradient(x, y),
            Layer::OnSurface(own, layers) => {
                let [u, v] = own.at([x, y])?;
                let [gu, gv] = gradient(layers, u, v, choose)?;
                let [[ux, uy], [vx, vy]] = own.derivative([x, y])?;
                [gu * ux + gv * vx, gu * uy + gv * vy]
            }
            Layer::Sum(terms) => gradient(choose(terms)?, x, y, choose)?,
            Layer::Pixels(_) => return None,
        };
        sum = [sum[0] + here[0], sum[1] + here[1]];
    }
    Some(sum)
}

/// [`slopes`] of layers on surface coordinates, converted to slopes over x and y. Pixels among the layers are not
/// sampled one by one, so their orders count.
fn slopes_on_surface(
    own: &SurfaceCoordinates,
    layers: &[Layer],
    [x, y]: [f64; 2],
    closest: f64,
) -> [f64; 2] {
    let (Some([u, v]), Some(d)) = (own.at([x, y]), own.derivative([x, y])) else {
        return [0.0; 2];
    };
    let mut along = slopes(layers, [u, v], closest);
    if let Some(pixels) = first_pixels(layers) {
        for (slope, pitch) in along.iter_mut().zip(pixels.pitch) {
            *slope += PIXEL_ORDERS * std::f64::consts::TAU / pitch;
        }
    }
    [0, 1].map(|a| along[0] * d[0][a].abs() + along[1] * d[1][a].abs())
}

/// Bounds on |∂φ/∂x| and |∂φ/∂y|, of singular phases at this distance at least: gradients of multiplied layers add, of summed
/// terms the largest counts.
fn slopes(layers: &[Layer], at: [f64; 2], closest: f64) -> [f64; 2] {
    let mut total = [0.0, 0.0];
    for layer in layers {
        let here = match layer {
            Layer::Pixels(_) => [0.0, 0.0],
            Layer::Phase(profile) => profile.gradient_beside(at, closest).map(f64::abs),
            Layer::Sum(terms) => terms.iter().fold([0.0f64; 2], |most, (_, layers)| {
                let term = slopes(layers, at, closest);
                [most[0].max(term[0]), most[1].max(term[1])]
            }),
            Layer::OnSurface(own, layers) => slopes_on_surface(own, layers, at, closest),
        };
        total = [total[0] + here[0], total[1] + here[1]];
    }
    total
}

#[cfg(test)]
mod tests {
    use crate::fixtures::noise::noise;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::phase::profile::Profile;
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::surface_coordinates::SurfaceCoordinates;
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::optics::phase::placement::Placement;
    use crate::optics::pixels::active_area::ActiveArea;
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};

    /// The derivatives by the pixels, times their values, are the transmission: it is linear in them.
    #[test]
    fn visit_pixels_dot_product() {
        let round = Shape::Conic(Conic {
            curvature: 0.3,
            conic: 0.0,
        });
        let cone = || Layer::Phase(Profile::Axicon { slope: 0.7 });
        let faint = Layer::Sum(vec![(Complex64::new(0.3, 0.4), vec![cone()])]);
        for form in [PixelForm::Box, PixelForm::Point, PixelForm::Bilinear] {
            let pixels = Pixels {
                pitch: [0.4, 0.3],
                values: noise((9, 7), 0),
                form,
                active: ActiveArea::WHOLE,
                placement: Placement::NONE,
            };
            let own = Box::new(SurfaceCoordinates::of(&round).unwrap());
            let curved = Layer::OnSurface(own, vec![cone(), Layer::Pixels(pixels.clone())]);
            for layer in [Layer::Pixels(pixels.clone()), curved] {
                let doe = Doe {
                    layers: vec![cone(), layer, faint.clone()],
                    aperture: Aperture::OPEN,
                    reflect: false,
                };
                for place in 0..40 {
                    let at = [0.09, 0.07].map(|step| step * f64::from(place % 20) - 0.8);
                    let spans = at.map(|v| [v - 0.06, v + 0.06]);
                    let mut derivatives: Array2<Complex64> = Array2::zeros((9, 7));
                    doe.visit_pixels(at, spans, &mut |pixel, by| derivatives[pixel] += by);
                    let sum: Complex64 = derivatives
                        .iter()
                        .zip(&pixels.values)
                        .map(|(a, b)| a * b)
                        .sum();
                    let whole = doe.transmission_over(at, spans);
                    assert!(
                        (sum - whole).norm() < 1e-14,
                        "{form:?} {at:?}: {sum} {whole}"
                    );
                }
            }
        }
    }
}
