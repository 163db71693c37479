//! The transmission of a diffractive element at the nodes of a grid, and the adjoint for its phase and its pixels.

use ndarray::{Array2, Zip};
use num_complex::Complex64;

use crate::optics::doe::{Doe, Layer};
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::sampling::{apply_screen, singular_nodes};

/// There is no pixel grid to which cotangents could go.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the element on screen '{0}' is not one grid of box or point pixels (times analytic phases), expected \
     one for gradients by pixel"
)]
pub struct NoPixels(pub String);

/// What a screen lets through at the nodes of a grid, times the weight its aperture gives each, indexed [y, x].
pub(crate) fn screen_transmission(screen: &Screen, grid: &Grid) -> Array2<Complex64> {
    let mut field = Field::zeros(grid.clone());
    field.values.fill(Complex64::ONE);
    apply_screen(screen, &mut field);
    field.values
}

/// Cotangents of an element's phase at the nodes in 1/rad, given those of its transmission t: Im(t̄ t*).
pub fn phase_bar(
    transmission_bar: &Array2<Complex64>,
    transmission: &Array2<Complex64>,
) -> Array2<f64> {
    Zip::from(transmission_bar)
        .and(transmission)
        .map_collect(|bar, t| (bar * t.conj()).im)
}

/// Cotangents of the complex pixels of an element on a screen, indexed [y, x], given those of what it lets
/// through at the nodes of a grid. With v the pixels' values, Im(v̄ v*) is the gradient by their phases.
///
/// # Errors
/// When the element is not one grid of box or point pixels, alone or times analytic phases.
pub(crate) fn pixels_bar(
    screen: &Screen,
    doe: &Doe,
    grid: &Grid,
    transmission_bar: &Array2<Complex64>,
) -> Result<Array2<Complex64>, NoPixels> {
    let fault = || NoPixels(screen.name.clone());
    let known = |layer: &Layer| match layer {
        Layer::Phase(_) => true,
        Layer::Pixels(own) => own.form.is_even(),
        Layer::Sum(_) | Layer::OnSurface(..) => false,
    };
    let grids = { doe.layers.iter() }.filter(|layer| matches!(layer, Layer::Pixels(_)));
    if grids.count() != 1 || !doe.layers.iter().all(known) {
        return Err(fault());
    }
    let pixels = doe.free_pixels().ok_or_else(fault)?;

    // What multiplies each pixel: what is open, with the analytic phases. Gaps hold no pixel's value.
    let open = Screen {
        kind: ScreenKind::Stop(doe.aperture.clone()),
        ..screen.clone()
    };
    let mut open = screen_transmission(&open, grid);
    singular_nodes(doe, grid).apply(&mut open);
    let mut bar = Array2::zeros(pixels.values.dim());
    for ((j, i), t) in transmission_bar.indexed_iter() {
        let weight = t * open[[j, i]].conj();
        let [x, y] = [&grid.x, &grid.y];
        let (at, spans) = ([x.node(i), y.node(j)], [x.span(i), y.span(j)]);
        doe.visit_pixels(at, spans, &mut |pixel, by| bar[pixel] += weight * by.conj());
    }
    Ok(bar)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::frame::Frame;
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::active_area::ActiveArea;
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
    use crate::optics::screen::{Screen, ScreenKind};

    use crate::wave::grid::field::{Axis, Grid};
    use crate::wave::grid::transmission::{phase_bar, pixels_bar, screen_transmission};

    fn doe(values: Array2<Complex64>) -> Doe {
        let pixels = Pixels {
            pitch: [0.5, 0.4],
            values,
            form: PixelForm::Box,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        };
        let tilt = Profile::Linear {
            gradient: [1.0, -2.0],
        };
        Doe {
            layers: vec![Layer::Phase(tilt), Layer::Pixels(pixels)],
            aperture: Aperture::disc(1.6),
            reflect: false,
        }
    }

    fn screen(doe: &Doe) -> Screen {
        parts::screen(Frame::GLOBAL, ScreenKind::Doe(doe.clone()))
    }

    #[test]
    fn pixels_dot_product() {
        let doe = doe(noise((8, 7), 1));
        let screen = screen(&doe);
        let grid = Grid {
            x: Axis::gauss(7, 0.5, 0.0, 3),
            y: Axis::gauss(8, 0.4, 0.0, 2),
        };
        let through = screen_transmission(&screen, &grid);
        let bar = noise(through.dim(), 2);
        let back = pixels_bar(&screen, &doe, &grid, &bar).unwrap();
        let dot = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let (a, b) = (dot(&bar, &through), dot(&back, &noise((8, 7), 1)));
        assert!((a - b).norm() < 1e-13 * a.norm(), "{a} {b}");

        // A common phase of all pixels is the same as one of all nodes.
        let nodes: f64 = phase_bar(&bar, &through).iter().sum();
        let pixels: f64 = phase_bar(&back, &noise((8, 7), 1)).iter().sum();
        assert!((nodes - pixels).abs() < 1e-12 * nodes.abs());
    }

    #[test]
    fn other_elements_are_refused() {
        let mut doe = doe(noise((8, 7), 1));
        doe.layers.pop();
        let grid = Grid {
            x: Axis::uniform(3, 0.5, 0.0),
            y: Axis::uniform(3, 0.5, 0.0),
        };
        let found = pixels_bar(&screen(&doe), &doe, &grid, &noise((3, 3), 1)).unwrap_err();
        assert!(found.to_string().contains("screen 'element'"));
    }
}
