//! Patches of a field on a curved screen and their plane waves.
//!
//! Over a patch the field is expanded in plane waves of space, taken on the true surface:
//! ĝⱼ U(X) = Σₘ cₘ e^{ik dₘ·(X−Xⱼ)}, d = (p, ±q) on the screen's axes, p on the lattice of the local plane.
//! A plane wave meets a surface of slope ∇s with the tangential rate p ± q∇s, so a lattice cell of
//! directions weighs N·d/q with N = (−∇s, 1): the factor of Rayleigh–Sommerfeld's first integral. N is
//! taken at the centre of the patch: its change over the patch is odd and cancels between neighbours. The
//! factor e^{∓ikq(s−sⱼ)} depends on direction and place; few levels of s separate the two.

use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::math::part::part;
use crate::optics::screen::Screen;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::{Heights, Stack, normal_cosines};
use crate::wave::patches::patch::{Band, PatchPlace, Patches, Spectrum};

/// What turns a field on a curved screen into patch spectra.
pub(crate) struct CurvedPatches<'a> {
    /// The plan of the local plane's transforms.
    pub patches: &'a Patches,
    /// The screen.
    pub screen: &'a Screen,
    /// Its heights at the field's nodes.
    pub heights: &'a Heights,
    /// Where the origin of the field's grid stands on the screen, in mm.
    pub origin: [f64; 2],
    /// Directions along x and y.
    pub bands: [&'a Band; 2],
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
}

/// The surface at the centre of a patch.
struct Centre {
    z: f64,
    slope: [f64; 2],
}

impl CurvedPatches<'_> {
    /// The spectrum of the patch with this index (x fastest); nothing when the field is dark there, or
    /// the screen does not exist at its centre.
    pub(crate) fn cut(&self, field: &Field, index: usize) -> Option<Spectrum> {
        self.cut_within(field, index, &self.patches.modes())
    }

    /// The same, of some directions only, given by their indices along x and y.
    pub(crate) fn cut_within(
        &self,
        field: &Field,
        index: usize,
        modes: &[Range<usize>; 2],
    ) -> Option<Spectrum> {
        let place = self.patches.place(index);
        let view = part(field.values.view(), place.y.clone(), place.x.clone());
        let energy = self.patches.energy_of(view, index);
        let [x, y] = place.centre;
        let here = self
            .screen
            .height([x + self.origin[0], y + self.origin[1]])?;
        if energy == 0.0 {
            return None;
        }
        let centre = Centre {
            z: here.z,
            slope: here.slope,
        };
        let z = self.above(&centre, &place);
        let stack = self.stack(&z, view, modes);
        let mut coefficients = Array2::zeros((modes[1].len(), modes[0].len()));
        for (number, part) in self.parts(&stack, view, &z).iter().enumerate() {
            let level = stack.levels.at[number];
            let waves = self.patches.transform(part.view(), index, modes);
            ndarray::Zip::indexed(&mut coefficients)
                .and(&waves)
                .for_each(|(my, mx), c: &mut Complex64, wave| {
                    let p = self.direction(modes, [mx, my]);
                    *c += wave * Complex64::cis(-self.k * self.normal(p) * level);
                });
        }
        self.finish(&mut coefficients, &centre, modes);
        Some(Spectrum {
            centre: place.centre,
            first: [modes[0].start, modes[1].start],
            coefficients,
            energy,
        })
    }

    /// The conjugate transpose of [`CurvedPatches::cut_within`]: from the coefficients to the nodes of the
    /// patch, [y, x]. `field` is the one that was expanded. Its lit nodes give the levels, and its dark nodes stay
    /// dark.
    pub(crate) fn cut_adjoint(
        &self,
        field: &Field,
        index: usize,
        modes: &[Range<usize>; 2],
        coefficients_bar: &Array2<Complex64>,
    ) -> Option<Array2<Complex64>> {
        let place = self.patches.place(index);
        let view = part(field.values.view(), place.y.clone(), place.x.clone());
        let [x, y] = place.centre;
        let here = self
            .screen
            .height([x + self.origin[0], y + self.origin[1]])?;
        let centre = Centre {
            z: here.z,
            slope: here.slope,
        };
        let z = self.above(&centre, &place);
        let stack = self.stack(&z, view, modes);

        // c *= N·d/q
        let mut bar = coefficients_bar.clone();
        self.finish(&mut bar, &centre, modes);
        let mut values_bar: Array2<Complex64> = Array2::zeros(view.dim());
        for (number, level) in stack.levels.at.iter().enumerate() {
            // c += wave·e^{−ikq·level}
            let mut waves_bar = bar.clone();
            for ((my, mx), wave) in waves_bar.indexed_iter_mut() {
                let p = self.direction(modes, [mx, my]);
                *wave *= Complex64::cis(self.k * self.normal(p) * level);
            }
            // wave = transform of part, part = share of value
            let part_bar = self
                .patches
                .transform_adjoint(waves_bar.view(), index, modes);
            ndarray::Zip::from(&mut values_bar)
                .and(&part_bar)
                .and(&z)
                .and(view)
                .for_each(|bar, part_bar, z, value| {
                    if *value != Complex64::ZERO {
                        *bar += stack.part_adjoint(*part_bar, *z, number);
                    }
                });
        }
        Some(values_bar)
    }

    /// Heights of the nodes of a patch above its centre.
    fn above(&self, centre: &Centre, place: &PatchPlace) -> Array2<f64> {
        let z = part(self.heights.z.view(), place.y.clone(), place.x.clone());
        z.mapv(|z| z - centre.z)
    }

    /// The direction cosines of a mode, counted from the first of `modes`.
    fn direction(&self, modes: &[Range<usize>; 2], mode: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|a| self.bands[a].at(modes[a].start + mode[a]))
    }

    /// The first and last direction cosines along both axes, `[x, x, y, y]`.
    fn ends(&self, modes: &[Range<usize>; 2]) -> [f64; 4] {
        let last = [0, 1].map(|a| modes[a].len().max(1) - 1);
        let ([x0, y0], [x1, y1]) = (self.direction(modes, [0; 2]), self.direction(modes, last));
        [x0, x1, y0, y1]
    }

    /// The cosine along the local z axis of a direction, with its sign; zero when evanescent.
    fn normal(&self, p: [f64; 2]) -> f64 {
        let n = self.screen.index;
        self.screen.leaves() * (n * n - p[0] * p[0] - p[1] * p[1]).max(0.0).sqrt()
    }

    /// Levels between the lit heights of a patch, for all its directions.
    fn stack(
        &self,
        z: &Array2<f64>,
        view: ArrayView2<Complex64>,
        modes: &[Range<usize>; 2],
    ) -> Stack {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for (z, value) in z.iter().zip(&view) {
            if value.norm_sqr() > 0.0 {
                range = [range[0].min(*z), range[1].max(*z)];
            }
        }
        let cosines = normal_cosines(self.ends(modes), self.screen.index);
        let leaves = self.screen.leaves();
        let mut signed = cosines.map(|q| leaves * q);
        signed.sort_by(f64::total_cmp);
        Stack::new(range, signed, self.k)
    }

    /// What each level holds of the field.
    fn parts(
        &self,
        stack: &Stack,
        field: ArrayView2<Complex64>,
        z: &Array2<f64>,
    ) -> Vec<Array2<Complex64>> {
        let mut parts = vec![Array2::zeros(field.dim()); stack.len()];
        let (mut shares, mut values) = (vec![0.0; stack.len()], vec![Complex64::ZERO; stack.len()]);
        for (node, value) in field.indexed_iter() {
            if *value == Complex64::ZERO {
                continue;
            }
            stack.split(*value, z[node], &mut shares, &mut values);
            for (part, value) in parts.iter_mut().zip(&values) {
                part[node] = *value;
            }
        }
        parts
    }

    /// The weight N·d/q of each direction; zero for those that leave on the wrong side.
    fn finish(
        &self,
        coefficients: &mut Array2<Complex64>,
        centre: &Centre,
        modes: &[Range<usize>; 2],
    ) {
        let [sx, sy] = centre.slope;
        for ((my, mx), c) in coefficients.indexed_iter_mut() {
            let p = self.direction(modes, [mx, my]);
            let q = self.normal(p);
            let lift = q - sx * p[0] - sy * p[1];
            let leaving = q != 0.0 && lift / q > 0.0;
            *c *= if leaving { lift / q } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{conic, open_screen};
    use crate::math::part::part;
    use crate::optics::frame::Frame;
    use crate::optics::screen::Screen;
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;
    use crate::wave::patches::curved::CurvedPatches;
    use crate::wave::patches::patch::{Band, Patches};
    use crate::wave::patches::window::Positions;

    /// With dark nodes, which change what heights count, and for light that leaves either way.
    #[test]
    fn cut_dot_product() {
        let axis = Axis::gauss(24, 0.8, 0.0, 2);
        let grid = Grid {
            x: axis.clone(),
            y: axis.clone(),
        };
        let k = std::f64::consts::TAU;
        let positions = Positions::covering(axis.edges(), 3.0, 4.0, 9.0);
        let band = Band::between(0.1, 1.0 / 18.0, -0.5, 0.6);
        let patches = Patches::new([&axis; 2], [&positions; 2], [&band; 2], k, 18.0);
        for arrives in [1.0, -1.0] {
            let screen = Screen {
                shape: conic(0.02, -0.3),
                index: 1.3,
                arrives,
                ..open_screen(Frame::GLOBAL)
            };
            let heights = Heights::on(&screen, &grid);
            let curved = CurvedPatches {
                patches: &patches,
                screen: &screen,
                heights: &heights,
                origin: [0.4, -0.2],
                bands: [&band; 2],
                k,
            };
            let mut values = noise(grid.shape(), 2);
            values.row_mut(20).fill(0.0.into());
            let field = Field {
                grid: grid.clone(),
                values,
            };
            let modes = [1..9, 3..17];
            for index in [patches.count() / 3, patches.count() / 2] {
                let place = patches.place(index);
                let under = part(field.values.view(), place.y, place.x).to_owned();
                let bar = noise((modes[1].len(), modes[0].len()), 3);
                let there = curved.cut_within(&field, index, &modes).unwrap();
                let back = curved.cut_adjoint(&field, index, &modes, &bar).unwrap();
                assert_transposed(&[(&bar, &there.coefficients)], &[(&back, &under)]);
            }
        }
    }
}
