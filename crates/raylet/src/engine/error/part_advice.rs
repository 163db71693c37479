//! Warnings about the parts of a hop, whatever method carries it: orders that do not propagate, light beside pixels, a
//! sensor in glass.

use crate::optics::screen::ScreenKind;
use crate::optics::system::Hop;

/// Indices of media differ from here on.
const OTHER_INDEX: f64 = 1e-3;

/// Light of one order of an element, where it leaves and along which cosines, and how much of it there is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaving {
    /// Where it leaves, in mm.
    pub at: [f64; 2],
    /// Its optical direction cosines.
    pub cosines: [f64; 2],
    /// Its share of the light at that place.
    pub share: f64,
}

/// The least share of light that does not propagate which a warning reports, in per cent.
const GONE: f64 = 0.1;

/// Light that a smooth element turns beyond 90°, of what leaves it at some places.
pub(crate) fn evanescent(hop: &Hop, leaving: &[Leaving]) -> Option<String> {
    let index = hop.from.index_behind();
    let lost = |one: &&Leaving| one.cosines[0].hypot(one.cosines[1]) >= index;
    let [gone, all] = [
        leaving.iter().filter(lost).collect(),
        leaving.iter().collect(),
    ]
    .map(|rays: Vec<&Leaving>| rays.iter().map(|one| one.share).sum::<f64>());
    let share = 100.0 * gone / all;
    let brightest = leaving.iter().filter(lost);
    let brightest = brightest.max_by(|a, b| a.share.total_cmp(&b.share))?;
    let ([x, y], p) = (brightest.at, brightest.cosines);
    (share >= GONE).then(|| {
        format!(
            "{} % of the light behind '{}' does not propagate: its direction cosines would be ({:.3}, {:.3}) at \
             ({x:.4}, {y:.4}) mm, where the index is {index:.3}",
            percent(share),
            hop.from.name,
            p[0],
            p[1],
        )
    })
}

/// A percentage, with a decimal where it is small.
fn percent(share: f64) -> String {
    match share < 9.95 {
        true => format!("{share:.1}"),
        false => format!("{share:.0}"),
    }
}

/// The least share of light beside the pixels of an element that a note reports, in per cent.
const BESIDE: f64 = 0.5;

/// Light that comes through the aperture of an element beside its pixels, of places with the intensity there.
pub(crate) fn beside_pixels(hop: &Hop, lit: &[([f64; 2], f64)]) -> Option<String> {
    let ScreenKind::Doe(doe) = &hop.from.kind else {
        return None;
    };
    let [x0, x1, y0, y1] = doe.pixels()?.bounds();
    let open = lit
        .iter()
        .filter(|([x, y], _)| doe.aperture.contains(*x, *y));
    let (mut inside, mut all) = (0.0, 0.0);
    for ([x, y], intensity) in open {
        all += intensity;
        if (x0..=x1).contains(x) && (y0..=y1).contains(y) {
            inside += intensity;
        }
    }
    let share = 100.0 * (1.0 - inside / all);
    (share > BESIDE).then(|| {
        format!(
            "{share:.1} % of the light in the aperture of '{}' falls beside its pixels, where it is dark",
            hop.from.name
        )
    })
}

/// A sensor in a medium other than air or vacuum: a last surface is missing, perhaps.
pub(crate) fn in_glass(hop: &Hop, ambient: f64) -> Option<String> {
    let sensor = matches!(hop.to.kind, ScreenKind::Sensor(_));
    let inside = sensor && (hop.to.index - ambient).abs() > OTHER_INDEX;
    inside.then(|| {
        format!(
            "'{}' stands in a medium of index {:.4}, not in the ambient medium: no surface leads out of it",
            hop.to.name, hop.to.index
        )
    })
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::error::part_advice::{Leaving, beside_pixels, evanescent, in_glass};
    use crate::fixtures::parts::{self, conic, face, on_axis, open_screen, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::placement::Placement;
    use crate::optics::pixels::active_area::ActiveArea;
    use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
    use crate::optics::screen::{Screen, ScreenKind};
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;

    /// A biconvex lens of radii of 5 mm and this thickness, 2 mm in radius, between two screens.
    fn told<T>(thickness: f64, say: impl Fn(&Hop) -> T) -> T {
        let surface = |z: f64, curvature: f64, index: [f64; 2]| Surface {
            aperture: Aperture::disc(2.0),
            ..face(on_axis(z), conic(curvature, 0.0), index)
        };
        let train = [
            surface(1.0, 0.2, [1.0, 1.5]),
            surface(1.0 + thickness, -0.2, [1.5, 1.0]),
        ];
        let (from, to) = (
            open_screen(Frame::GLOBAL),
            screen(on_axis(9.0), sensor(8, 0.01)),
        );
        say(&Hop {
            wavelength: 0.5e-3,
            from: &from,
            train: &train,
            to: &to,
        })
    }

    #[test]
    fn light_that_cannot_leave_an_element_is_told_with_its_place() {
        let one = |at, cosines, share| Leaving { at, cosines, share };
        let leaving = [
            one([0.1, 0.2], [0.3, 0.0], 1.0),
            one([0.3, 0.4], [1.375, 0.0], 0.9),
            one([0.3, 0.4], [0.2, 0.0], 0.1),
        ];
        let text = told(0.9, |hop| evanescent(hop, &leaving)).unwrap();
        assert!(
            text.contains("45 %") && text.contains("(1.375, 0.000)"),
            "{text}"
        );
        assert_eq!(told(0.9, |hop| evanescent(hop, &leaving[..1])), None);
    }

    /// A disc about a square of pixels: 1 − 2/π of the light is beside them if they reach its rim with their corners.
    #[test]
    fn light_beside_the_pixels_is_told_with_its_share() {
        let side = 2f64.sqrt();
        let element = |radius: f64| {
            let pixels = Layer::Pixels(Pixels {
                pitch: [side / 20.0; 2],
                values: Array2::from_elem((20, 20), Complex64::ONE),
                form: PixelForm::Box,
                active: ActiveArea::WHOLE,
                placement: Placement::NONE,
            });
            ScreenKind::Doe(parts::element(pixels, Aperture::disc(radius)))
        };
        let lattice = (0..401).flat_map(|i| (0..401).map(move |j| [i, j]));
        let lit: Vec<_> = lattice
            .map(|at| (at.map(|i| f64::from(i) * 0.005 - 1.0), 1.0))
            .collect();
        let said = |radius: f64| {
            let (from, to) = (
                screen(Frame::GLOBAL, element(radius)),
                screen(on_axis(9.0), sensor(8, 0.01)),
            );
            let hop = Hop {
                wavelength: 0.5e-3,
                from: &from,
                train: &[],
                to: &to,
            };
            beside_pixels(&hop, &lit)
        };
        assert_eq!(said(0.5 * side), None);
        let text = said(1.0).unwrap();
        let share: f64 = text.split(' ').next().unwrap().parse().unwrap();
        let expected = 100.0 * (1.0 - 2.0 / std::f64::consts::PI);
        assert!((share - expected).abs() < 0.3, "{text}: {expected:.1} %");
    }

    #[test]
    fn a_sensor_in_glass_is_told() {
        assert_eq!(told(0.9, |hop| in_glass(hop, 1.0)), None);
        let inside = |hop: &Hop| {
            let to = Screen {
                index: 1.52,
                ..hop.to.clone()
            };
            in_glass(&Hop { to: &to, ..*hop }, 1.0)
        };
        assert!(told(0.9, inside).unwrap().contains("1.5200"));
    }
}
