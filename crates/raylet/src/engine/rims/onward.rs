//! Whether light that arrives on a screen goes on to the sensor, by rays.
//!
//! Light that a rim sends aside arrives in other directions than the rest. Behind a smooth element it lands elsewhere, mostly
//! beside the sensor. Behind pixels it goes everywhere.
//!
//! The last screen before the sensor diffracts what passes it. Of the light of an outline with perimeter P and area A the share
//! λP/(2π²Aq) differs by more than q from its direction (`edge_diffraction`). So the light of a ray is spread like
//! c/(2π(q² + c²)^{3/2}) with c = λP/(2π²A), whose integral over a rectangle is a closed form.

use std::f64::consts::PI;

use crate::engine::rims::pixel_envelope::PixelEnvelope;
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::source_rays::{is_open, ray_behind};
use crate::optics::screen::ScreenKind;
use crate::optics::system::{Hop, System};

/// How far beside the sensor light counts, in diffraction widths λ/D of the aperture before it.
const WIDTHS: f64 = 4.0;

/// What is farther than so many widths of the spread has next to no light, and a spread in mm that is no spread.
const FAR: f64 = 1e6;
const LEAST: f64 = 1e-12;

/// Points along each side of a box whose rays are followed.
const SIDE: usize = 7;

/// The hops behind a screen up to the sensor.
pub(crate) struct Onward<'a> {
    hops: Vec<Hop<'a>>,
    /// The pixels behind which nothing is known.
    envelope: Option<PixelEnvelope>,
}

impl<'a> Onward<'a> {
    /// What follows a hop of a system; nothing behind the last one, and behind pixels.
    pub(crate) fn behind(system: &'a System, number: usize) -> Self {
        let hops: Vec<Hop> = system.hops().skip(number + 1).collect();
        let smooth = |hop: &Hop| match &hop.from.kind {
            ScreenKind::Stop(_) => true,
            ScreenKind::Doe(doe) => doe.phase_gradient(0.0, 0.0).is_some(),
            ScreenKind::Sensor(_) => false,
        };
        match hops.iter().all(smooth) {
            true => Self {
                hops,
                envelope: None,
            },
            false => Self {
                hops: Vec::new(),
                envelope: PixelEnvelope::behind(system, number),
            },
        }
    }

    /// Of light of which nothing more is known.
    #[cfg(test)]
    pub(crate) fn nowhere() -> Self {
        Self {
            hops: Vec::new(),
            envelope: None,
        }
    }

    /// Whether anything is known of the hops behind.
    pub(crate) fn is_known(&self) -> bool {
        !self.hops.is_empty()
    }

    /// How strongly pixels turn light of these rays to the sensor; nothing where no pixels follow, or others do.
    pub(crate) fn turned(&self, ray: impl Fn([f64; 2]) -> SourceRay) -> Option<f64> {
        self.envelope.as_ref().map(|own| own.strength(ray))
    }

    /// The mean over points of a box of what their rays have.
    pub(crate) fn mean_reach(
        &self,
        [x0, x1, y0, y1]: [f64; 4],
        ray: impl Fn([f64; 2]) -> SourceRay,
    ) -> Reach {
        if !self.is_known() {
            return Reach::WHOLE;
        }
        let place =
            |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / SIDE as f64;
        let points = (0..SIDE * SIDE).map(|n| [place(x0, x1, n % SIDE), place(y0, y1, n / SIDE)]);
        let reaches = points.map(|point| self.reach(ray(point)));
        let sum = reaches.fold([0.0; 2], |[near, share], reach| {
            [near + reach.near, share + reach.share]
        });
        let [near, share] = sum.map(|sum| sum / (SIDE * SIDE) as f64);
        Reach { near, share }
    }

    /// What of the light along a ray on the first of their screens gets to the sensor; all where nothing is known.
    pub(crate) fn reach(&self, mut ray: SourceRay) -> Reach {
        for (number, hop) in self.hops.iter().enumerate() {
            if !is_open(hop.from, ray.at) {
                return Reach::NOTHING;
            }
            let bent = ray_behind(hop, &ray);
            let Ok((landing, j)) = hop.jacobian(bent.at, bent.p) else {
                return Reach::NOTHING;
            };
            if number + 1 == self.hops.len() {
                return Reach::of(hop, landing.at, &j);
            }
            ray.at = landing.at;
            ray.p = landing.cosines;
        }
        Reach::WHOLE
    }
}

/// What of the light along a ray gets to the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// One where the ray lands in the box of the sensor, or no farther away than the box is wide, or than light of the last
    /// aperture is spread by diffraction; else zero.
    pub(crate) near: f64,
    /// The share of its light that lands in the box, if the last aperture diffracts it.
    pub(crate) share: f64,
}

impl Reach {
    /// Of light that all gets there, as far as is known.
    const WHOLE: Self = Self {
        near: 1.0,
        share: 1.0,
    };

    /// Of light that does not.
    const NOTHING: Self = Self {
        near: 0.0,
        share: 0.0,
    };

    /// Of a ray that lands at a place of the last screen of a hop, with this Jacobian.
    fn of(hop: &Hop, at: [f64; 2], j: &[[f64; 4]; 4]) -> Self {
        let (Some(from), Some(to)) = (hop.from.bounds(), hop.to.bounds()) else {
            return Self::WHOLE;
        };
        let sides = [from[1] - from[0], from[3] - from[2]];
        let near = (0..2).all(|a| {
            let [low, high] = [to[2 * a], to[2 * a + 1]];
            let widths = [0, 1].map(|b| WIDTHS * hop.wavelength / sides[b] * j[a][2 + b].abs());
            let margin = (high - low).max(widths[0]).max(widths[1]);
            (low - margin..=high + margin).contains(&at[a])
        });

        // The ends of the box in directions off that of the ray, in units of the width of the spread.
        let spread = hop.wavelength * (sides[0] + sides[1]) / (PI * PI * sides[0] * sides[1]);
        let end = |a: usize, end: usize| {
            let width = spread * j[a][2].hypot(j[a][3]);
            ((to[2 * a + end] - at[a]) / width.max(LEAST)).clamp(-FAR, FAR)
        };
        let corner = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
        let along_y = |x: f64| corner(x, end(1, 1)) - corner(x, end(1, 0));
        Self {
            near: f64::from(u8::from(near)),
            share: (along_y(end(0, 1)) - along_y(end(0, 0))) / (2.0 * PI),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::rims::onward::Onward;
    use crate::engine::rims::source_ray::SourceRay;
    use crate::fixtures::parts::{box_pixels, element, lit, on_axis, screen, sensor};
    use crate::math::bessel::bessel_j;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;

    /// A lens of 20 mm focal length and a sensor of 0.1 mm at its focus: what arrives along the axis goes on.
    #[test]
    fn directions_decide_behind_a_lens_and_pixels_send_everywhere() {
        let lens = Profile::Lens {
            focal_length: 20.0,
            wavenumber: std::f64::consts::TAU / 0.5e-3,
        };
        let smooth = ScreenKind::Doe(element(Layer::Phase(lens), Aperture::disc(1.0)));
        let pixels = box_pixels(Array2::from_elem((10, 10), Complex64::ONE), 0.2);
        for (kind, aside) in [(smooth, false), (pixels, true)] {
            let aperture = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.0)));
            let middle = screen(on_axis(5.0), kind);
            let last = screen(on_axis(25.0), sensor(10, 0.01));
            let mut system = lit(vec![aperture, middle, last], vec![vec![], vec![]]);
            system.wavelength = 0.5e-3;
            let onward = Onward::behind(&system, 0);
            let ray = |sine: f64| SourceRay {
                at: [0.5, 0.2],
                p: [sine, 0.0],
                energy: 1.0,
                spread: [0.0; 2],
            };
            assert_eq!(onward.reach(ray(0.0)).near, 1.0);
            assert_eq!(onward.reach(ray(0.1)).near == 1.0, aside);
        }
    }

    /// What a disc sends beyond a square about its light: Airy's pattern, integrated in polar coordinates. Squares whose sides
    /// are 0.06 to 0.6 off the light in direction, behind a disc of 20 λ.
    #[test]
    fn the_share_beyond_a_square_is_that_of_airy() {
        let (radius, far) = (20.0, 1e6);
        let disc = ScreenKind::Stop(Aperture::disc(radius));
        for sine in [0.06, 0.2, 0.6] {
            let side = 2.0 * far * f64::tan(f64::asin(sine));
            let open = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.0)));
            let middle = screen(on_axis(5.0), disc.clone());
            let last = screen(on_axis(5.0 + far), sensor(1, side));
            let system = lit(vec![open, middle, last], vec![vec![], vec![]]);
            let ray = SourceRay {
                at: [0.0; 2],
                p: [0.0; 2],
                energy: 1.0,
                spread: [0.0; 2],
            };
            let beyond = 1.0 - Onward::behind(&system, 0).reach(ray).share;

            // At the angle φ from x the square ends at q = sine/cos φ, beyond which J₀² + J₁² of 2πaq/λ remains.
            let outside = |n: i32| {
                let angle = PI / 4.0 * (f64::from(n) + 0.5) / 2000.0;
                let x = 2.0 * PI * radius * sine / angle.cos();
                bessel_j(0, x).powi(2) + bessel_j(1, x).powi(2)
            };
            let exact = (0..2000).map(outside).sum::<f64>() / 2000.0;
            let ratio = beyond / exact;
            assert!((0.7..1.3).contains(&ratio), "{sine}: {ratio}");
        }
    }
}
