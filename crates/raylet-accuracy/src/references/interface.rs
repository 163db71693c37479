//! Diffraction from a plane to a curved surface and from a curved surface onwards.
//!
//! The field on the surface z = s(x, y) is U_S = Σ A(p) e^{ik(p·x + q s)}; from a field given on it
//! the plane waves behind are, by the first Rayleigh–Sommerfeld (Weyl) form,
//!   A(p) = (1/P²) Σ_S w U_S e^{−ik(p·x + q s)} [(−∇s, 1)·(p, q)]/q ΔxΔy.
//! The first is exact. The second is exact on planes, tilted ones too; on a surface of radius of
//! curvature it is the Kirchhoff approximation, which adds a relative
//! (i/2kn)(κ₁/cos³χ + κ₂/cos χ) (from the double layer's eigenvalues on a sphere; κ₁ the normal
//! curvature in the plane of incidence, χ the angle to the normal). Its value at χ = 0, i/kn times
//! the mean curvature, is subtracted; the remaining error is of order χ²/(k n R) in phase. A field continuous across the interface (unit transmission
//! for every direction) joins two media.
//!
//! Both sums run over FFTs at Chebyshev nodes in z. With the mean q₀ of the modes taken out, a
//! mode's phase over the sag range Δz is at most a = k·Δq·Δz/4 from the middle, and
//! a + `extra`·(1 + a)^⅓ nodes interpolate it.

use ndarray::Array2;
use num_complex::Complex64;

use crate::numerics::fourier::CentredTransform;
use crate::numerics::phase::cis_turns;
use crate::references::spectrum::{Lattice, Spectrum};
use crate::references::surface::SurfaceSamples;

/// The heights at which a field is transformed, and how a surface's samples mix them.
struct Layers {
    /// Mean normal cosine q₀, taken out of the interpolation.
    carrier: f64,
    /// Chebyshev nodes.
    heights: Vec<f64>,
    /// Lagrange weight of each node at each sample [node][sample].
    shares: Vec<Vec<f64>>,
}

impl Layers {
    /// Layers for modes with normal cosines from `least` to `most`.
    fn new(surface: &SurfaceSamples, wavelength: f64, [least, most]: [f64; 2], extra: f64) -> Self {
        let (low, high) = surface.heights();
        let (middle, reach) = (0.5 * (low + high), 0.5 * (high - low));
        let k = std::f64::consts::TAU / wavelength;
        let phase = 0.5 * k * (most - least) * reach;
        let count = (phase + extra * (1.0 + phase).cbrt()).ceil().max(1.0) as usize;
        let count = if reach > 0.0 { count } else { 1 };

        // Chebyshev nodes of the first kind.
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / count as f64;
        let cosines: Vec<f64> = (0..count).map(|node| angle(node).cos()).collect();
        let mut shares = vec![Vec::with_capacity(surface.points.len()); count];
        for point in &surface.points {
            let at = if reach > 0.0 {
                (point[2] - middle) / reach
            } else {
                cosines[0]
            };
            for (node, share) in lagrange(&cosines, at).into_iter().enumerate() {
                shares[node].push(share);
            }
        }
        Self {
            carrier: 0.5 * (least + most),
            heights: cosines
                .iter()
                .map(|cosine| middle + reach * cosine)
                .collect(),
            shares,
        }
    }
}

/// Lagrange weights at `at` of the Chebyshev nodes of the first kind, by the barycentric formula.
fn lagrange(nodes: &[f64], at: f64) -> Vec<f64> {
    if let Some(hit) = nodes.iter().position(|node| (node - at).abs() < 1e-14) {
        return (0..nodes.len())
            .map(|node| if node == hit { 1.0 } else { 0.0 })
            .collect();
    }
    let terms: Vec<f64> = nodes
        .iter()
        .enumerate()
        .map(|(index, node)| {
            let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
            sign * (1.0 - node * node).sqrt() / (at - node)
        })
        .collect();
    let sum: f64 = terms.iter().sum();
    terms.into_iter().map(|term| term / sum).collect()
}

/// Smallest and largest normal cosine among the modes that carry light.
fn cosine_range(spectrum: &Spectrum) -> [f64; 2] {
    let normal = spectrum.normal();
    let lit = spectrum
        .modes
        .iter()
        .zip(&normal)
        .filter(|(mode, _)| mode.norm_sqr() > 0.0);
    let range = lit.fold([spectrum.index, 0.0_f64], |[least, most], (_, q)| {
        [least.min(*q), most.max(*q)]
    });
    if range[0] <= range[1] {
        range
    } else {
        [spectrum.index; 2]
    }
}

/// The field at the samples of `surface`, whose vertex lies in the spectrum's plane; in the
/// medium of the spectrum, before any interface. `extra` Chebyshev nodes beyond the phase range.
/// Periods must agree, and the grid must be as fine as the lattice.
pub fn plane_to_surface(
    spectrum: &Spectrum,
    surface: &SurfaceSamples,
    extra: f64,
) -> Vec<Complex64> {
    let wavelength = spectrum.lattice.wavelength;
    let layers = Layers::new(surface, wavelength, cosine_range(spectrum), extra);
    let transform = CentredTransform::new(surface.samples);
    let normal = spectrum.normal();
    let mut field = vec![Complex64::ZERO; surface.points.len()];
    for (height, shares) in layers.heights.iter().zip(&layers.shares) {
        // The field in the plane at this height, without the carrier.
        let mut modes = spectrum.modes.clone();
        modes.zip_mut_with(&normal, |mode, q| {
            let (c, s) = cis_turns((q - layers.carrier) * height / wavelength);
            *mode *= Complex64::new(c, s);
        });
        let plane = transform.synthesise(&modes, surface.half);
        for (sample, value) in field.iter_mut().enumerate() {
            *value += plane[surface.cells[sample]] * shares[sample];
        }
    }
    for (value, point) in field.iter_mut().zip(&surface.points) {
        let (c, s) = cis_turns(layers.carrier * point[2] / wavelength);
        *value *= Complex64::new(c, s);
    }
    field
}

/// The plane waves in the medium of index `index` behind `surface`, from the `field` at its
/// samples, opaque outside its aperture; phases at the vertex plane. Only |p| < `index`.
pub fn surface_to_plane(
    field: &[Complex64],
    surface: &SurfaceSamples,
    lattice: Lattice,
    index: f64,
    extra: f64,
) -> Spectrum {
    let side = 2 * lattice.half + 1;
    let mut spectrum = Spectrum {
        lattice,
        index,
        modes: Array2::zeros((side, side)),
    };
    let normal = spectrum.normal();
    let least = normal
        .iter()
        .copied()
        .filter(|q| *q > 0.0)
        .fold(index, f64::min);
    let layers = Layers::new(surface, lattice.wavelength, [least, index], extra);
    let transform = CentredTransform::new(surface.samples);
    let p = lattice.directions();
    let sources = radiating(field, surface, layers.carrier, lattice.wavelength, index);
    let normalise = 1.0 / (surface.samples * surface.samples) as f64;

    for (height, shares) in layers.heights.iter().zip(&layers.shares) {
        // What this height gathers, alone and times each slope.
        let grids = layer_grids(&sources, surface, shares);
        let [plain, along_x, along_y] = grids.map(|grid| transform.analyse(&grid, lattice.half));
        for ((row, column), mode) in spectrum.modes.indexed_iter_mut() {
            let q = normal[[row, column]];
            if q > 0.0 {
                let (c, s) = cis_turns(-(q - layers.carrier) * height / lattice.wavelength);
                let at = [row, column];
                let tilt = along_x[at] * (p[column] / q) + along_y[at] * (p[row] / q);
                *mode += (plain[at] - tilt) * Complex64::new(c, s) * normalise;
            }
        }
    }
    spectrum
}

/// What each sample radiates: the field times its weight, the curvature's correction and, taken
/// out, the carrier's phase.
fn radiating(
    field: &[Complex64],
    surface: &SurfaceSamples,
    carrier: f64,
    wavelength: f64,
    index: f64,
) -> Vec<Complex64> {
    let reduced = wavelength / (std::f64::consts::TAU * index);
    (0..field.len())
        .map(|sample| {
            let (c, s) = cis_turns(-carrier * surface.points[sample][2] / wavelength);
            let correction = Complex64::new(1.0, -surface.curvatures[sample] * reduced);
            field[sample] * surface.weights[sample] * correction * Complex64::new(c, s)
        })
        .collect()
}

/// The share of one layer on the grid square: alone, times ∂s/∂x, and times ∂s/∂y.
fn layer_grids(
    sources: &[Complex64],
    surface: &SurfaceSamples,
    shares: &[f64],
) -> [Array2<Complex64>; 3] {
    let side = 2 * surface.half + 1;
    let mut grids = [(); 3].map(|()| Array2::zeros((side, side)));
    for (sample, value) in sources.iter().enumerate() {
        let value = value * shares[sample];
        let [slope_x, slope_y] = surface.slopes[sample];
        for (grid, factor) in grids.iter_mut().zip([1.0, slope_x, slope_y]) {
            grid[surface.cells[sample]] = value * factor;
        }
    }
    grids
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::numerics::pixels::Pixels;
    use crate::references::interface::{plane_to_surface, surface_to_plane};
    use crate::references::spectrum::{Lattice, Slab, Spectrum};
    use crate::references::surface::{Sag, SurfaceSamples};

    /// Relative L2 distance of `a` from `b`.
    fn distance<'a>(
        a: impl IntoIterator<Item = &'a Complex64>,
        b: impl IntoIterator<Item = &'a Complex64>,
    ) -> f64 {
        let (mut off, mut norm) = (0.0, 0.0);
        for (a, b) in a.into_iter().zip(b) {
            off += (a - b).norm_sqr();
            norm += b.norm_sqr();
        }
        (off / norm).sqrt()
    }

    /// Plane waves from scrambled pixels of 1.1λ on the period 96λ, 25λ before a vertex plane.
    fn scrambled() -> Spectrum {
        let transmission = Array2::from_shape_fn((22, 22), |(i, j)| {
            Complex64::cis((5 * i * i + 3 * j * i) as f64)
        });
        let pixels = Pixels {
            pitch: 1.1,
            transmission,
        };
        let spectrum =
            Spectrum::from_pixels(Lattice::new(1.0, 96.0, 1.0), 1.0, &pixels, [0.1, 0.0]);
        spectrum
            .through(
                &[Slab {
                    index: 1.0,
                    thickness: 25.0,
                }],
                32.0,
            )
            .unwrap()
    }

    /// A smooth beam of waist `waist` with direction p_x = 0.2.
    fn beam(waist: f64) -> Spectrum {
        let lattice = Lattice::new(1.0, 96.0, 1.0);
        let p = lattice.directions();
        let modes = Array2::from_shape_fn((p.len(), p.len()), |(i, j)| {
            let square = (p[j] - 0.2).powi(2) + p[i].powi(2);
            let inside = p[j].hypot(p[i]) < 1.0;
            if inside {
                Complex64::from((-square * (std::f64::consts::PI * waist).powi(2)).exp())
            } else {
                Complex64::ZERO
            }
        });
        Spectrum {
            lattice,
            index: 1.0,
            modes,
        }
    }

    #[test]
    fn field_on_a_sphere_equals_the_sum_of_plane_waves_slow() {
        let spectrum = scrambled();
        for radius in [45.0, 22.0, -200.0] {
            let surface = SurfaceSamples::new(96.0, 288, 20.0, 6, Sag::Sphere(radius));
            let picked: Vec<usize> = (0..surface.points.len()).step_by(97).collect();
            let points: Vec<_> = picked
                .iter()
                .map(|&sample| surface.points[sample])
                .collect();
            let exact = spectrum.at_points(&points, 0.0);
            for (extra, bound) in [(3.0, 5e-4), (4.0, 3e-5), (5.0, 1e-6), (6.0, 3e-8)] {
                let field = plane_to_surface(&spectrum, &surface, extra);
                let error = distance(picked.iter().map(|&sample| &field[sample]), &exact);
                assert!(error < bound, "{extra}: {error:e}");
            }
        }
    }

    /// Without an interface the plane waves come back: exactly from planes, however tilted, and
    /// to O(1/kR) from curved surfaces.
    #[test]
    fn a_surface_without_an_interface_changes_nothing_slow() {
        let tilted = |x: f64, _y: f64| [0.25 * x, 0.25, 0.0];
        for (name, sag, bound) in [
            ("flat", Sag::Flat, 2e-11),
            ("tilted", Sag::General(&tilted), 3e-8),
            ("sphere 60", Sag::Sphere(60.0), 1.8e-4),
            ("sphere 120", Sag::Sphere(120.0), 7e-5),
            ("sphere 240", Sag::Sphere(240.0), 3.1e-5),
            ("sphere -240", Sag::Sphere(-240.0), 3.1e-5),
        ] {
            let spectrum = beam(8.0);
            let surface = SurfaceSamples::new(96.0, 288, 40.0, 6, sag);
            let field = plane_to_surface(&spectrum, &surface, 6.0);
            let back = surface_to_plane(&field, &surface, spectrum.lattice, 1.0, 6.0);
            let error = distance(&back.modes, &spectrum.modes);
            assert!(error < bound, "{name}: {error:e}");
        }
    }

    /// Light that converges in air on the point R + nR behind a sphere's vertex converges in glass
    /// on F = R + R/n without aberration, where the surface integral can be done: for the field
    /// e^{−iknρ}/ρ on it, (1/2π)∫(1/ρ − ikn)dΩ over the solid angle Ω of the rim seen from F, less
    /// the curvature's correction.
    #[test]
    fn aplanatic_focus_has_its_phase_and_amplitude() {
        let (radius, index, rim): (f64, f64, f64) = (200.0, 1.5, 40.0);
        let (tau, period) = (std::f64::consts::TAU, 240.0);
        let focus = radius + radius / index;
        let surface = SurfaceSamples::new(period, 600, rim, 6, Sag::Sphere(radius));
        // The distances to the two foci are as n to 1, so the light in air is known on the sphere.
        let incident = |[x, y, z]: &[f64; 3]| {
            let reach = x.hypot(*y).hypot(radius * (1.0 + index) - z);
            Complex64::cis(-tau * reach) / reach
        };
        let field: Vec<_> = surface.points.iter().map(incident).collect();
        let lattice = Lattice::new(1.0, period, 0.7);
        let behind = surface_to_plane(&field, &surface, lattice, index, 6.0);
        let behind = behind
            .through(
                &[Slab {
                    index,
                    thickness: focus,
                }],
                rim,
            )
            .unwrap();
        let found = behind.at_points(&[[0.0; 3]], 0.0)[0];

        let depth = focus - Sag::Sphere(radius).at(rim, 0.0)[0];
        let solid_angle = tau * (1.0 - depth / depth.hypot(rim));
        let k = tau * index;
        let bend = 1.0 / depth.hypot(rim) - 1.0 / radius;
        let expected = Complex64::new(bend, -k) * (solid_angle / (tau * index));
        assert!(
            (found / expected - 1.0).norm() < 2e-6,
            "{}",
            found / expected
        );
    }
}
