//! Screens: where a field lives, and what acts on it there.

use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::doe::Doe;
use crate::optics::frame::Frame;
use crate::optics::refraction::Coating;
use crate::optics::shape::{Height, Shape};

/// A surface on which the complex field is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Screen {
    /// Name shown to users.
    pub name: String,
    /// Origin (in mm) and axes of the screen, global; the field is a function of its local x and y.
    pub frame: Frame,
    /// Its height over the local plane, z = s(x, y).
    pub shape: Shape,
    /// Action on the light: an aperture, a diffractive element or a sensor.
    pub kind: ScreenKind,
    /// Refractive index around it; where another medium stands behind it, the index before it.
    pub index: f64,
    /// The medium behind an element that stands on an interface; nothing where light goes on in the same medium.
    pub behind: Option<MediumBehind>,
    /// +1 when light arrives towards the local +z, −1 when it arrives towards −z.
    pub arrives: f64,
}

/// The medium behind a screen that stands on an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumBehind {
    /// Its refractive index.
    pub index: f64,
    /// How much of the field the interface transmits.
    pub coating: Coating,
}

/// The action of a screen on light.
#[derive(Clone, Debug, PartialEq)]
pub enum ScreenKind {
    /// An aperture: what is outside is blocked.
    Stop(Aperture),
    /// A diffractive element.
    Doe(Doe),
    /// The end: a grid of sample points at the pixel centres.
    Sensor(Sensor),
}

/// The sample points of a sensor: `pixels` [nx, ny] of `pitch` mm, centred on the screen's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Number of pixels along x and y.
    pub pixels: [usize; 2],
    /// Distance of neighbouring pixels along x and y, in mm.
    pub pitch: [f64; 2],
}

/// How far a screen departs from its local plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Relief {
    /// Lowest z, in mm.
    pub low: f64,
    /// Highest z, in mm.
    pub high: f64,
    /// Largest |∂z/∂x| and |∂z/∂y|.
    pub slope: [f64; 2],
}

impl Relief {
    /// A plane's.
    pub(crate) const FLAT: Relief = Relief {
        low: 0.0,
        high: 0.0,
        slope: [0.0; 2],
    };
}

/// Intervals along each axis in which a relief is looked at.
const RELIEF: usize = 64;

impl Screen {
    /// +1 when light leaves towards the local +z, −1 when it leaves towards −z.
    pub(crate) fn leaves(&self) -> f64 {
        match &self.kind {
            ScreenKind::Doe(doe) if doe.reflect => -self.arrives,
            _ => self.arrives,
        }
    }

    /// Refractive index of the medium into which light leaves.
    pub fn index_behind(&self) -> f64 {
        self.behind.map_or(self.index, |behind| behind.index)
    }

    /// Whether the part that matters ends at the edges of [`Screen::bounds`].
    pub(crate) fn is_rectangular(&self) -> bool {
        let outline = match &self.kind {
            ScreenKind::Stop(aperture) => &aperture.outline,
            ScreenKind::Doe(doe) => &doe.aperture.outline,
            ScreenKind::Sensor(_) => return true,
        };
        matches!(outline, Outline::Rectangle { .. })
    }

    /// Whether the screen is a plane.
    pub(crate) fn is_plane(&self) -> bool {
        self.shape == Shape::Plane
    }

    /// Height and slope over the local plane; nothing where the surface does not exist.
    pub fn height(&self, [x, y]: [f64; 2]) -> Option<Height> {
        self.shape.height(x, y)
    }

    /// The plane that touches the screen above (x, y), as an open screen that light crosses: its z axis is
    /// the normal, its x axis lies above the local x axis.
    pub fn tangent(&self, at: [f64; 2]) -> Option<Screen> {
        let height = self.height(at)?;
        let [sx, sy] = height.slope;
        let x = Vec3::new(1.0, 0.0, sx).unit();
        let z = Vec3::new(-sx, -sy, 1.0).unit();
        let frame = Frame {
            origin: self.frame.to_global(Vec3::new(at[0], at[1], height.z)),
            x: self.frame.direction_to_global(x),
            y: self.frame.direction_to_global(z.cross(x)),
            z: self.frame.direction_to_global(z),
        };
        Some(Screen {
            name: String::new(),
            frame,
            shape: Shape::Plane,
            kind: ScreenKind::Stop(Aperture::OPEN),
            index: self.index_behind(),
            behind: None,
            arrives: self.leaves(),
        })
    }

    /// Lowest and highest z over the part that matters, and the largest |slope| along x and y; from a
    /// grid of points, widened by what may lie between them.
    pub(crate) fn relief(&self) -> Option<Relief> {
        let [x0, x1, y0, y1] = self.bounds()?;
        let mut relief = Relief::FLAT;
        if self.is_plane() {
            return Some(relief);
        }
        (relief.low, relief.high) = (f64::INFINITY, f64::NEG_INFINITY);
        let place = |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / RELIEF as f64;
        let mut steepest = 0.0f64;
        for j in 0..=RELIEF {
            for i in 0..=RELIEF {
                let Some(here) = self.height([place(x0, x1, i), place(y0, y1, j)]) else {
                    continue;
                };
                relief.low = relief.low.min(here.z);
                relief.high = relief.high.max(here.z);
                let second = here.hessian.iter().fold(0.0f64, |a, b| a.max(b.abs()));
                steepest = steepest.max(second);
                for a in 0..2 {
                    relief.slope[a] = relief.slope[a].max(here.slope[a].abs());
                }
            }
        }
        if relief.low > relief.high {
            return None;
        }
        let between = 0.5 * (x1 - x0).max(y1 - y0) / RELIEF as f64;
        relief.low -= steepest * between * between;
        relief.high += steepest * between * between;
        relief.slope = relief.slope.map(|s| s + steepest * between);
        Some(relief)
    }

    /// The smallest radius of curvature over the part that matters, in mm, from a grid of points; nothing
    /// for a plane.
    pub fn smallest_radius(&self) -> Option<f64> {
        let [x0, x1, y0, y1] = self.bounds()?;
        let place = |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / RELIEF as f64;
        let mut sharpest = 0.0f64;
        for n in 0..(RELIEF + 1) * (RELIEF + 1) {
            let [i, j] = [n % (RELIEF + 1), n / (RELIEF + 1)];
            if let Some(here) = self.height([place(x0, x1, i), place(y0, y1, j)]) {
                sharpest = sharpest.max(here.sharpest());
            }
        }
        (sharpest > 0.0).then(|| 1.0 / sharpest)
    }

    /// The part of the screen that matters, `[x_min, x_max, y_min, y_max]` in mm: the aperture of a stop
    /// or element, the outline of a sensor; nothing when it has no edge.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        match &self.kind {
            ScreenKind::Stop(aperture) => aperture.bounds(),
            ScreenKind::Doe(doe) => doe.bounds(),
            ScreenKind::Sensor(sensor) => {
                let half = |i: usize| 0.5 * sensor.pixels[i] as f64 * sensor.pitch[i];
                Some([-half(0), half(0), -half(1), half(1)])
            }
        }
    }
}
